# SPDX-License-Identifier: BSD-3-Clause
"""Results in a store are those in memory, bit for bit, also after any number of kills; what does not fit a store is refused."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import warnings
from functools import partial

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar, pendulums
from tests.motion.many import runs
from tests.peer import require

xarray = require("xarray")
require("zarr")

TWO = runs.EOM
KILLS = 20 if os.environ.get("KANE_FULL") else 2


@pytest.fixture(scope="module")
def undisturbed():
    return runs.run()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A store of all motions, to be copied."""
    path = tmp_path_factory.mktemp("runs") / "runs.zarr"
    runs.run(path)
    return path


@pytest.fixture
def store(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "runs.zarr")


def test_same_as_in_memory(undisturbed, whole):
    assert {*undisturbed.status.values.tolist()} == {"finished", "failed"}
    assert undisturbed["force"].dims == ("instance", "t", "axis")
    runs.same(runs.run(whole), undisturbed)
    assert not [*whole.parent.glob(".kane*")]


def test_any_reader(whole, undisturbed):
    """A store is a Dataset without this library."""
    found = xarray.open_zarr(whole, consolidated=False)
    assert {"q1(0)", "m1", "t"} <= set(found.coords)
    assert found["energy"].attrs["units"] == "J"
    assert np.array_equal(found["force"].values, undisturbed["force"].values, equal_nan=True)


def test_closed_loops(tmp_path):
    """Motions on constraints that are run one by one, and instances of which the last chunk has one."""
    eom = kn.derive(four_bar.system())
    first, *others = eom.coordinates
    given = {"q": {first: np.linspace(1.1, 1.3, 5), **{c: kn.guess(0.3) for c in others}}, "samples": 5}
    given |= {"u": {eom.independent_speeds[0]: 0.5}}
    runs.same(
        kn.simulate_many(eom, (0, 1), store=tmp_path / "runs", chunk=2, **given),
        kn.simulate_many(eom, (0, 1), **given),
    )


def test_only_what_is_missing_is_run(store, undisturbed):
    """A chunk without its record, and one whose record was cut off, are run; numbers of others are left as they are."""
    for k in (3, 5, 30):
        (store / "q1" / "c" / str(k) / "0").write_bytes((store / "q1" / "c" / "0" / "0").read_bytes())
    (store / "status" / "c" / "3").unlink()
    record = store / "status" / "c" / "30"
    record.write_bytes(record.read_bytes()[:-5])
    part = store / "q1" / "c" / "3" / "0.0123.partial"
    part.write_bytes(b"what a killed writer left")
    found = runs.run(store)
    wrong = (found["q1"].values != undisturbed["q1"].values) & np.isfinite(undisturbed["q1"].values)
    places = np.unique(found["instance"].values[wrong.any(axis=1)] // runs.CHUNK)
    assert places.tolist() == [5]
    assert not part.exists()


@pytest.mark.slow
@pytest.mark.grows
@pytest.mark.skipif(sys.platform == "win32", reason="no kill -9")
def test_killed_at_any_moment(tmp_path, undisturbed, rng):
    path, cut_off = tmp_path / "runs.zarr", 0
    for _ in range(KILLS):
        cut_off += runs.killed(runs.started(path), path, rng.uniform(0, 3 / KILLS))
        if path.exists() and rng.random() < 0.2:  # the next one begins anew, so that templates are killed, too
            shutil.rmtree(path)
    assert cut_off
    runs.same(runs.run(path), undisturbed)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="no limit of a file's size")
def test_no_room(tmp_path, undisturbed):
    """Where the system refuses to write a file, an error says so, and what there is goes on."""
    path = tmp_path / "runs.zarr"

    code = f"""
import resource, signal
import kane as kn
from tests.motion.many import runs
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (9_000, resource.RLIM_INFINITY))
try:
    runs.run({str(path)!r})
except kn.SolutionFileError as error:
    print(error)
"""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=runs.environment(), capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"Expected to write the store {path}, got File too large."), done
    assert "call again with the same store" in done.stdout
    runs.same(runs.run(path), undisturbed)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"rtol": 1e-7}, "rtol: None in the store, 1e-07 here"),
        ({"samples": 21}, "samples: 20 numbers"),
        ({"u": [0, 0.1]}, "u2 (u): 0.0 in the store, 0.1 here"),
        ({"parameters": {"m1": np.linspace(1, 2, runs.COUNT)}}, "m1 (parameters): 2000 numbers"),
        ({"lanes": False}, "lanes: None in the store, False here"),
        ({"settings": kn.Settings(contract=False)}, "settings: Settings(contract=True"),
        ({"reduce": {"energy": "min"}}, "reduce energy: max in the store, min here"),
        ({"reduce": {"energy": lambda v: v[0]}}, "reduce energy: max in the store"),
        ({"outputs": {"q1": "q2", "energy": TWO.energy, "force": TWO.speeds[0] * TWO.system.inertial.x}}, "the output q1"),
        ({"chunk": 100}, "64 instances each, got chunk=100. Leave it out."),
    ],
    ids=lambda x: "" if isinstance(x, str) else "-".join(x),
)  # fmt: skip
def test_other_motions(whole, more, told):
    with pytest.raises(kn.SolutionFileError) as raised:
        runs.run(whole, **more)
    assert told in str(raised.value)
    assert str(whole) in str(raised.value)


def test_another_system(tmp_path):
    given = {"q": [0.1, 0.2], "u": [0, 0], "samples": 3, "store": tmp_path / "runs.zarr"}
    kn.simulate_many(TWO, (0, 1), **given)
    other = kn.derive(pendulums.system(3))
    with pytest.raises(kn.SolutionFileError, match=r"which differs in .*, which only .* has"):
        kn.simulate_many(other, (0, 1), **given | {"q": [0.1, 0.2, 0.3], "u": [0, 0, 0]})


def gains(c):
    """A law that closes over a number."""
    return lambda t: c * t


class Gain:
    """A law that has a number."""

    def __init__(self, c):
        self.c = c

    def law(self, t):
        return self.c * t


def keyword(c):
    def law(t, *, c=c):
        return c * t

    return law


READ = 1.0


def reading(c):
    """A law that reads a number of its module."""
    global READ
    READ = c
    return lambda t: READ * t


def within(c):
    """Laws with another function within, of one name."""
    laws = (lambda t: sum(1.0 * s for s in (t,)), lambda t: sum(1.5 * s for s in (t,)))
    return laws[c > 1]


@pytest.mark.parametrize(
    ("law", "again", "other"),
    [
        (lambda: gains(1.0), lambda: gains(1), lambda: gains(1.5)),
        (lambda: kn.signal([0, 1, 2, 3], [0, 1, 0, 1]), None, lambda: kn.signal([0, 1, 2, 3], [0, 1, 0, 2])),
        (lambda: kn.parameter("k", 2.0) * kn.time, None, lambda: kn.parameter("k", 2.0) * kn.time**2),
        (lambda: [0.0, 1.0], lambda: [0, 1], lambda: [0.0, 1.5]),
        (lambda: 1, lambda: 1.0, lambda: 1.5),
        (lambda: Gain(1.0).law, None, lambda: Gain(1.5).law),
        (lambda: keyword(1.0), None, lambda: keyword(1.5)),
        (lambda: reading(1.0), None, lambda: reading(1.5)),
        (lambda: within(1.0), None, lambda: within(1.5)),
        (lambda: partial(float.__mul__, 1.0), None, lambda: partial(float.__mul__, 1.5)),
    ],
    ids=["function", "signal", "expression", "numbers", "number", "method", "keyword", "module", "within", "partial"],
)
def test_laws(tmp_path, law, again, other):
    """A store knows the inputs again, whatever they are, and others."""
    x, v, k, F, N = kn.coordinate("x"), kn.speed("v"), kn.parameter("k", 2.0), kn.input("F"), kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("b", P, k)], speeds={v: x.dt}, loads=[kn.Force(P, F * N.x)]))
    given = {"q": {x: [0.0, 0.1]}, "u": {v: 0}, "samples": 3, "store": tmp_path / "runs.zarr"}

    def run(f):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kn.KaneWarning)  # functions run one after the other
            return kn.simulate_many(eom, (0, 1), inputs={F: f()}, **given).load()

    first = run(law)
    xarray.testing.assert_identical(run(again or law), first)
    with pytest.raises(kn.SolutionFileError, match=r"differs in .*F"):
        run(other)


def test_paths(tmp_path):
    given = {"q": [0.1, 0.2], "u": [0, 0], "samples": 3}
    file, other = tmp_path / "file", tmp_path / "other"
    file.write_text("of somebody")
    other.mkdir()
    (other / "file").write_text("of somebody")
    for path, told in (
        (file, "got the file"),
        (other, "with something else in it"),
        (tmp_path / "none" / "runs", "Expected a writable folder"),
        (file / "runs", "Expected a writable folder"),
    ):
        with pytest.raises(kn.SolutionFileError, match=told):
            kn.simulate_many(TWO, (0, 1), store=path, **given)
    with pytest.raises(kn.ArgumentError, match="Expected the path"):
        kn.simulate_many(TWO, (0, 1), store=3, **given)
    with pytest.raises(kn.SolutionFileError, match="names of outputs that a store can have, got 'a/b'"):
        kn.simulate_many(TWO, (0, 1), store=tmp_path / "runs", outputs={"a/b": "q1"}, **given)
    with pytest.raises(kn.SimulationError, match="accepts any numbers"):
        kn.simulate_many(TWO, (0, 1), store=tmp_path / "runs", reduce=lambda v: [][0], **given)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "other"]
    assert file.read_text() == "of somebody"


def test_too_large_for_memory():
    q1 = np.zeros(1_000_000)
    with pytest.raises(
        kn.SimulationError, match=r'got 15\.2 GiB of 1000000 instances at 501 times\. .* store="runs\.zarr"'
    ):
        kn.simulate_many(TWO, (0, 1), q={"q1": q1, "q2": 0}, u=[0, 0])


@pytest.mark.parametrize("chunk", [0, 1.5, "x"])
def test_chunks(chunk):
    with pytest.raises(kn.SimulationError, match="chunk="):
        kn.simulate_many(TWO, (0, 1), q=[0, 0], u=[0, 0], chunk=chunk)
