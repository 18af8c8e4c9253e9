# SPDX-License-Identifier: BSD-3-Clause
"""`kane sweep` writes what `kn.simulate_many` gives, goes on where it was left, and says what became of the instances."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, four_bar
from tests.cli.command import HEAD, from_json, kane, line, written
from tests.peer import require

xarray = require("xarray")
require("zarr")


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def opened(path="runs.zarr"):
    return xarray.open_zarr(path, consolidated=False)


WORDS = ("--span", 0, 2, "--samples", 5, "--store", "runs.zarr")


def test_bounds(tmp_path):
    words = (
        "sweep",
        "double_pendulum",
        *WORDS,
        "--design",
        "q1=-1:1",
        "--design",
        "u2=0:2",
        "--count",
        100,
        "--chunk",
        64,
    )
    assert kane(*words, "--q", "q2=0.3").stdout == "100 instances: 100 finished.\nStore: runs.zarr\n"
    given = {"q": {"q2": 0.3}, "u": {"u1": 0}, "design": {"q1": (-1, 1), "u2": (0, 2)}, "sampler": "sobol"}
    own = kn.simulate_many(kn.derive(double_pendulum.system()), (0, 2), count=100, samples=5, **given)
    for name in ("q1", "u2", "q1(0)", "u2(0)", "end_state"):
        assert np.array_equal(opened()[name].values, own[name].values), name
    (tmp_path / "runs.zarr" / "status" / "c" / "1").unlink()
    (tmp_path / "runs.zarr" / "q2" / "c" / "1" / "0").unlink()
    whole = (tmp_path / "runs.zarr" / "q2" / "c" / "0" / "0").stat().st_mtime_ns
    found = from_json(*words, "--q", "q2=0.3")
    assert (found["statuses"], found["causes"], found["instances"]) == ({"finished": 100}, [], 100)
    assert np.array_equal(opened()["q2"].values, own["q2"].values)
    assert (tmp_path / "runs.zarr" / "q2" / "c" / "0" / "0").stat().st_mtime_ns == whole
    assert "rtol" not in kane(*words, code=1).stderr  # q2 of START
    assert "q2 (q): 0.3 in the store" in line(kane(*words, code=1).stderr)


SPRUNG = HEAD + (
    "    return kn.System(N, bodies=[kn.Particle('bob', P, m)], speeds='rates', loads=[kn.linear_spring(P, O, k)])\n\n"
    "plain = system\nSTART = {'q': {'x': 1, 'y': 0}, 'u': {'u_x': 0, 'u_y': 0}}\nSPAN = (0, 1)\n"
)


def test_levels_and_those_that_fail(tmp_path):
    file = written(tmp_path, SPRUNG)
    words = ("--sampler", "product", "--design", "m=1,0,2", "--design", "k=3,4", "--store", "runs.zarr", "--samples", 3)
    said = kane("sweep", f"{file}:plain", *words).stdout
    assert said.startswith("6 instances: 4 finished, 2 failed.\n\nCauses\n  2  failed  Expected ")
    assert opened()["m"].values.tolist() == [1, 1, 0, 0, 2, 2]
    found = from_json("sweep", file, *words)
    (cause,) = found["causes"]
    assert (cause["status"], cause["count"]) == ("failed", 2)
    none = kane(
        "sweep", file, "--sampler", "product", "--design", "m=0", "--parameter", "k=1", "--store", "none", code=1
    )
    assert none.stdout.startswith("1 instances: 1 failed.")
    assert "add --parameter k=…" in line(
        kane("sweep", file, "--sampler", "product", "--design", "m=1", "--store", "x", code=2).stderr
    )


def test_closed_loop(tmp_path):
    """START of a mechanism guesses, and each instance is assembled."""
    text = (
        "from kane.gallery.four_bar import system\nimport kane as kn\n"
        "eom = kn.derive(system())\nfirst, *others = (s.name for s in eom.coordinates)\n"
        "START = {'q': {first: 1.2} | {c: kn.guess(0.3) for c in others}, 'u': {eom.independent_speeds[0].name: 0.5}}\n"
    )
    file, eom = written(tmp_path, text), kn.derive(four_bar.system())
    first, *others = eom.coordinates
    kane("sweep", file, *WORDS, "--design", f"{first}=1.1:1.3", "--count", 3)
    given = {"q": {c: kn.guess(0.3) for c in others}, "u": {eom.independent_speeds[0]: 0.5}, "samples": 5}
    own = kn.simulate_many(eom, (0, 2), design={first: (1.1, 1.3)}, sampler="sobol", count=3, **given)
    for c in eom.coordinates:
        assert np.array_equal(opened()[c.name].values, own[c.name].values)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--design", "q9=0:1"), "got 'q9'. Did you mean q2 or q1?"),
        (("--design", "q1=0,1"), "Expected --design NAME=LOW:HIGH with numbers for the sampler sobol, got 'q1=0,1'."),
        (("--design", "q1=0:1", "--design", "q1=0:2"), "got q1 twice"),
        (("--design", "q1=0:1", "--q", "q7=1"), "got 'q7'"),
    ],
)
def test_misuse(words, told):
    assert told in line(kane("sweep", "double_pendulum", *WORDS, "--count", 2, *words, code=2).stderr)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--design", "q1=1:0"), "Expected two bounds (low, high) for q1"),
        (("--design", "q1=0:1", "--sampler", "sobl"), "Did you mean sobol?"),
    ],
)
def test_bad_designs(words, told):
    assert told in line(kane("sweep", "double_pendulum", *WORDS, "--count", 2, *words, code=1).stderr)


def test_functions_of_a_file(tmp_path):
    file = written(tmp_path, SPRUNG)
    assert "Expected a function plan() in model.py, got only system(), plain(). Rename plain to plan" in line(
        kane("check", f"{file}:plan", code=1).stderr
    )
    assert kane("check", f"{file}:plain", "--json").stdout
