# SPDX-License-Identifier: BSD-3-Clause
"""Motions in files: what was written is read, and nothing else is."""

import io
import json
import os
import pickle
import sys
import zipfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, four_bar
from kane.motion import Contents, read, write
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y", "m")
v, w = kn.speeds("v w", "m/s")
m, c = kn.parameter("m", 2.0, "kg"), kn.parameter("c", 0.3, "N*s/m")
F = kn.input("F", "N")
P = O.at("P", x * N.x + y * N.y)


def system(extra=0, mass=m):
    return kn.System(
        N,
        bodies=[kn.Particle("P", P, mass)],
        speeds={v: x.dt, w: y.dt},
        loads=[kn.Force(P, ((1 + extra) * F - c * v) * N.x), kn.gravity(-9.81 * N.y)],
        events=[kn.Event("half way", y, threshold=0.5, terminal=False)],
    )


EOM = kn.derive(system())


def motion(eom=EOM, **more):
    return kn.simulate(
        eom, (0, 0.4), q=[0, 1], u=[1, 0], parameters={m: 3.0}, inputs={F: lambda t: np.sin(5 * t)}, samples=7, **more
    )


SOL = motion()


def same(one, two):
    for name in ("t", "states", "work", "q", "u", "energy"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for name in ("status", "message", "steps", "evaluations", "rtol", "atol", "method"):
        assert getattr(one, name) == getattr(two, name), name
    assert [(e.name, e.message, t) for e, t in one.events] == [(e.name, e.message, t) for e, t in two.events]
    assert (one.event and one.event.name) == (two.event and two.event.name)
    assert {p.name: v for p, v in one.parameters.items()} == {p.name: v for p, v in two.parameters.items()}
    assert one.energy_check == two.energy_check


def test_what_is_read_is_what_was_written(tmp_path):
    SOL.save(tmp_path / "run.npz")
    again = kn.load_solution(tmp_path / "run.npz", EOM)
    same(again, SOL)
    assert np.array_equal(again[F], SOL[F])
    assert again.events[0][0] is EOM.events[0]
    same(kn.load_solution(str(tmp_path / "run.npz"), system()), SOL)
    assert os.listdir(tmp_path) == ["run.npz"]
    same(pickle.loads(pickle.dumps(again)), SOL)


def test_a_system_written_otherwise_is_the_same(tmp_path):
    """What counts is what expressions mean, and neither how they are written nor in which order things are listed."""
    SOL.save(tmp_path / "run.npz")
    M = kn.Frame("N")
    A = kn.Point("O", fixed_in=M)
    Q = A.at("P", y * M.y + 2 * x * M.x / 2)
    force = Q, (F - c * v) * (M.x * 3 - 2 * M.x)
    eom = kn.derive(
        kn.System(
            M,
            bodies=[kn.Particle("P", Q, m + m - m)],
            speeds={v: x.dt, w: y.dt},
            loads=[kn.gravity(-9.81 * M.y), kn.Force(*force)],
            events=[kn.Event("half way", y, threshold=0.5, terminal=False)],
        )
    )
    again = kn.load_solution(tmp_path / "run.npz", eom)
    assert again.parameters[m] == 3.0
    assert np.array_equal(again.energy, SOL.energy)


@pytest.mark.slow
def test_a_mechanism_whose_dependent_speeds_changed(tmp_path):
    eom = kn.derive(four_bar.system())
    sol = kn.simulate(eom, (0, 2), **four_bar.START, samples=21)
    sol.save(tmp_path / "run.npz")
    again = kn.load_solution(tmp_path / "run.npz", kn.derive(four_bar.system()))
    assert [s.start for s in again.segments] == [s.start for s in sol.segments]
    kept = [
        (one.equations.dependent_speeds, two.equations.dependent_speeds)
        for one, two in zip(again.segments, sol.segments, strict=True)
    ]
    assert all([s.name for s in a] == [s.name for s in b] for a, b in kept)
    for a, b in zip(again.equations.accelerations, sol.equations.accelerations, strict=True):
        assert np.allclose(again[a], sol[b], rtol=1e-12, atol=0)


def test_files_of_other_systems_are_refused(tmp_path):
    path = tmp_path / "run.npz"
    SOL.save(path)
    with pytest.raises(
        kn.SolutionFileError, match=r"with the coordinates q1, q2, got .* with x, y\. It belongs to another"
    ):
        kn.load_solution(path, double_pendulum.system())
    with pytest.raises(kn.SolutionFileError, match=r"whose system differs in the load force on P\. Load it with"):
        kn.load_solution(path, kn.derive(system(extra=1e-3)))
    with pytest.raises(kn.SolutionFileError, match=r"differs in the mass of P\."):
        kn.load_solution(path, kn.derive(system(mass=2 * m)))
    with pytest.raises(kn.SolutionFileError, match=r"differs in the event half way, which only that of the file has"):
        kn.load_solution(path, system().replace(events=[]))
    with pytest.raises(kn.ArgumentError, match=r"Expected the Equations or the System .* got 'run'"):
        kn.load_solution(path, "run")
    with pytest.raises(
        kn.ArgumentError, match=r"Expected the path of a file.* got None\. Write kn\.load_solution\(\"run"
    ):
        kn.load_solution(None, EOM)
    for given in (3, None, b"run.npz", "run\0.npz"):
        with pytest.raises(
            kn.ArgumentError, match=r"Expected the path of a file.* got .*\. Write sol\.save\(\"run\.npz"
        ):
            SOL.save(given)


def test_no_part_of_a_file_is_read(tmp_path):
    """Cut off anywhere, a file is an error."""
    path = tmp_path / "run.npz"
    SOL.save(path)
    whole = path.read_bytes()
    for size in range(0, len(whole), max(1, len(whole) // 40)):
        path.write_bytes(whole[:size])
        with pytest.raises(kn.SolutionFileError, match="cannot be read"):
            kn.load_solution(path, EOM)


def test_numbers_that_were_changed_within_a_sound_file(tmp_path):
    path = tmp_path / "run.npz"
    SOL.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    arrays["states"] = arrays["states"] * 2
    np.savez(path, **arrays)
    with pytest.raises(kn.SolutionFileError, match="which was changed or is truncated"):
        kn.load_solution(path, EOM)


def test_other_versions_and_other_files(tmp_path):
    path = tmp_path / "run.npz"
    SOL.save(path)
    header, arrays = read(path)
    write(path, Contents({**header, "version": 99, "kane": "9.1"}, arrays))
    with pytest.raises(kn.SolutionFileError, match=r"of version 2, got version 99, written by kane 9\.1"):
        kn.load_solution(path, EOM)
    write(path, Contents({**header, "format": "else"}, arrays))
    with pytest.raises(kn.SolutionFileError, match="with something else in it"):
        kn.load_solution(path, EOM)
    del arrays["work"]
    path.unlink()
    write(path, Contents(header, arrays))
    with pytest.raises(kn.SolutionFileError, match=r"Expected a file with all parts of a solution, got .*'work'"):
        kn.load_solution(path, EOM)
    np.savez(path, t=np.zeros(3))
    with pytest.raises(kn.SolutionFileError, match="cannot be read"):
        kn.load_solution(path, EOM)
    np.savez(path, t=np.array([object()], dtype=object), header=np.frombuffer(json.dumps({}).encode(), dtype=np.uint8))
    with pytest.raises(kn.SolutionFileError, match="cannot be read"):  # pickles are not
        kn.load_solution(path, EOM)
    with pytest.raises(kn.SolutionFileError, match=r"got none at .*none\.npz\. Write one by sol\.save"):
        kn.load_solution(tmp_path / "none.npz", EOM)
    with pytest.raises(kn.SolutionFileError, match=r"ends in \.npz or \.zarr, got 'run\.csv'"):
        SOL.save(tmp_path / "run.csv")
    with pytest.raises(kn.SolutionFileError, match=r"Expected a folder that exists, got .*nowhere"):
        SOL.save(tmp_path / "nowhere" / "run.npz")


def test_a_failed_write_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    SOL.save(path)
    before = path.read_bytes()

    def full(*_, **__):
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="no space left"):
        SOL.save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["run.npz"]


def test_zarr(tmp_path):
    require("zarr")
    path = tmp_path / "run.zarr"
    SOL.save(path)
    SOL.save(path)
    same(kn.load_solution(path, EOM), SOL)
    assert os.listdir(tmp_path) == ["run.zarr"]
    with zipfile.ZipFile(path) as whole:
        members = {name: whole.read(name) for name in whole.namelist()}
    chunk = next(name for name in members if name.startswith("states/c"))
    for changed in ({**members, chunk: members[chunk][:-9]}, {k: d for k, d in members.items() if k != chunk}):
        with zipfile.ZipFile(path, "w") as part:
            for name, data in changed.items():
                part.writestr(name, data)
        with pytest.raises(kn.SolutionFileError):  # zarr takes what is not there for zeros
            kn.load_solution(path, EOM)


@pytest.mark.slow
def test_tables_of_pandas():
    require("pandas")
    frame = SOL.to_dataframe({"r": P.position(O), "K": EOM.kinetic_energy})
    assert list(frame.columns) == ["x", "y", "v", "w", "F", "r.x", "r.y", "r.z", "K"]
    assert frame.index.name == "t"
    assert np.array_equal(frame.index, SOL.t)
    assert np.array_equal(frame["v"], SOL[v])
    assert np.array_equal(frame["r.y"], SOL[y])
    units = frame.attrs["units"]
    assert [units[name] for name in ("t", "x", "w", "F", "K")] == ["s", "m", "m/s", "N", EOM.unit(EOM.kinetic_energy)]
    assert frame.attrs["parameter m"] == 3.0


@pytest.mark.slow
def test_datasets_of_xarray():
    require("xarray")
    data = SOL.to_xarray({"r": P.position(O)})
    assert data["r"].dims == ("t", "axis")
    assert np.array_equal(data["r"].sel(axis="y"), SOL[y])
    assert data["F"].attrs["units"] == "N"
    assert data["t"].attrs["units"] == "s"
    assert data.attrs["status"] == "finished"


@pytest.mark.parametrize(("package", "call"), [("pandas", "to_dataframe"), ("xarray", "to_xarray"), ("zarr", None)])
def test_a_package_that_is_missing_is_named(tmp_path, monkeypatch, package, call):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"Expected the package {package}.*'kane\[table\]'"):
        getattr(SOL, call)() if call else SOL.save(tmp_path / "run.zarr")


@pytest.mark.parametrize("call", ["to_dataframe", "to_xarray"])
def test_outputs_of_tables_have_names_of_their_own(call):
    require("pandas" if call == "to_dataframe" else "xarray")
    with pytest.raises(kn.ArgumentError, match=r"Expected a new name for an output, got 'x'"):
        getattr(SOL, call)({"x": v})
    with pytest.raises(kn.ArgumentError, match=r"Expected outputs as a dict of names and expressions, got \[v\]"):
        getattr(SOL, call)([v])


def _energy(sol):
    return sol.energy


@pytest.mark.slow
def test_motions_cross_a_pool_of_processes():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert np.array_equal(next(pool.map(_energy, [SOL])), SOL.energy)


def test_a_zip_of_something_else(tmp_path):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as file:
        file.writestr("a.txt", "no arrays")
    (tmp_path / "run.npz").write_bytes(data.getvalue())
    with pytest.raises(kn.SolutionFileError, match="cannot be read"):
        kn.load_solution(tmp_path / "run.npz", EOM)
