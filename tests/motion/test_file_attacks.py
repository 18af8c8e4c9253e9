# SPDX-License-Identifier: BSD-3-Clause
"""Attacks on files of motions: nothing else than a solution is replaced, and nothing else than what was written is read."""

import json
import os
import shutil
import socket
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.motion import Contents, read, write
from tests.examples import examples
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
X, Y = kn.coordinates("x y")
V, W = kn.speeds("v w")
F = kn.input("F")
NUMBERS = (1.0, 2.0, 0.5, 3.0, 9.81, 0.1, 0.7, 5.0, 200.0, 6.0, 0.2, 1.5, 4.0)


def system(numbers=NUMBERS):
    """Two particles whose every number, those of what does not act along the motion too, is one of `numbers`."""
    m1, m2, stretch, length, g, damping, soft, far, beyond, deep, top, threshold, k = numbers
    P = O.at("P", X * N.x)
    B = N.rotate("B", Y / 2, N.z)
    Q = P.at("Q", length * B.x)
    bump = kn.where(kn.less(X, far), soft * V, deep * V)
    table = kn.table([0, 50, 100, 150], [0, top, 0, 1])(X)
    beyond_reach = kn.where(kn.less(X, beyond), 0, kn.sqrt(X - beyond))
    return kn.System(
        N,
        bodies=[kn.Particle("P", P, m1), kn.Particle("Q", Q, m2)],
        speeds={V: X.dt, W: stretch * Y.dt},
        loads=[
            kn.gravity(-g * N.y),
            kn.Force(P, (F - damping * V - bump) * N.x, name="drag"),
            kn.Force(Q, (table + beyond_reach - kn.parameter("k", k) * X) * N.x, name="spring"),
        ],
        events=[kn.Event("up", Y, threshold=threshold, terminal=False)],
    )


EOM = kn.derive(system())
SOL = kn.simulate(EOM, (0, 0.2), q=[0, 0], u=[0, 0], inputs={F: 0}, samples=5)


@pytest.fixture(params=["npz", "zarr"])
def path(request, tmp_path):
    if request.param == "zarr":
        require("zarr")
    return tmp_path / f"run.{request.param}"


def everything(folder):
    """All that is in a folder: kind, rights, links and bytes of each thing."""
    found = {}
    for p in sorted(folder.rglob("*")):
        status = p.lstat()
        content = os.readlink(p) if p.is_symlink() else p.read_bytes() if p.is_file() else None
        found[str(p.relative_to(folder))] = (status.st_mode, status.st_nlink, content)
    return found


def _folder(path):
    path.mkdir()
    (path / "thesis.txt").write_text("all of it")


def _old_store(path):
    path.mkdir()
    (path / "zarr.json").write_text(json.dumps({"attributes": {"header": json.dumps({"format": "kane solution"})}}))


def _link(path):
    SOL.save(path.with_name(f"other{path.suffix}"))
    path.symlink_to(path.with_name(f"other{path.suffix}"))


def _linked_folder(path):
    _folder(path.with_name("data"))
    path.symlink_to(path.with_name("data"))


def _socket(path):
    short = os.open(path.parent, os.O_RDONLY)  # names of sockets are short
    with socket.socket(socket.AF_UNIX) as s:
        s.bind(f"/proc/self/fd/{short}/{path.name}")
    os.close(short)


def _of_arrays(path):
    with path.open("wb") as file:
        np.savez(file, t=np.arange(3.0), header=np.frombuffer(b'{"format": "mine"}', dtype=np.uint8))


def _zip(path):
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.txt", "no arrays")


def _cut(path):
    SOL.save(path)
    os.truncate(path, path.stat().st_size // 2)


def _protected(path):
    SOL.save(path)
    path.chmod(0o444)


ATTACKS = {
    "a folder": _folder,
    "an empty folder": lambda p: p.mkdir(),
    "a store in a folder": _old_store,
    "a link to a solution": _link,
    "a link to nothing": lambda p: p.symlink_to("nothing"),
    "a link to itself": lambda p: p.symlink_to(p),
    "a link to a folder": _linked_folder,
    "a pipe": os.mkfifo,
    "a socket": _socket,
    "a device": lambda p: p.symlink_to("/dev/zero"),
    "a text": lambda p: p.write_text("my notes"),
    "other arrays": _of_arrays,
    "another zip": _zip,
    "a solution cut off": _cut,
    "a write-protected solution": _protected,
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_nothing_but_a_solution_is_replaced(path, attack):
    ATTACKS[attack](path)
    before = everything(path.parent)
    with pytest.raises(
        kn.SolutionFileError, match=r"Expected .* got .*run\.\w+.* Choose another name, or remove it first\."
    ):
        SOL.save(path)
    assert everything(path.parent) == before
    if attack not in ("a link to a solution", "a write-protected solution"):
        with pytest.raises(kn.SolutionFileError, match="Expected a file with a solution, got"):
            kn.load_solution(path, EOM)
    else:
        assert np.array_equal(kn.load_solution(path, EOM).states, SOL.states)


def test_solutions_and_empty_files_are_replaced(path):
    path.touch(mode=0o600)
    SOL.save(path)
    second = path.with_name("second")
    os.link(path, second)
    kn.simulate(EOM, (0, 1), q=[0, 0], u=[1, 0], inputs={F: 0}, samples=3).save(path)
    assert kn.load_solution(path, EOM).t[-1] == 1
    assert path.stat().st_mode & 0o777 == 0o600
    second.rename(second.with_suffix(path.suffix))
    assert kn.load_solution(second.with_suffix(path.suffix), EOM).t[-1] == 0.2
    assert len(os.listdir(path.parent)) == 2


@pytest.mark.parametrize(
    "key", ["status", "message", "method", "steps", "evaluations", "kane", "events", "declared", "numbers"]
)
def test_a_header_that_was_changed_is_refused(tmp_path, key):
    path = tmp_path / "run.npz"
    SOL.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    header = json.loads(arrays["header"].tobytes())
    arrays["header"] = np.frombuffer(json.dumps({**header, key: [[9]]}).encode(), dtype=np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(kn.SolutionFileError, match=r"as it was written, got .*, which was changed"):
        kn.load_solution(path, EOM)


def sealed(path, **changed):
    """Load a file with other parts, as if it had been written so."""
    SOL.save(path)
    header, arrays = read(path)
    parts = {k: v for k, v in changed.items() if k in arrays}
    write(path, Contents({**header, **{k: v for k, v in changed.items() if k not in parts}}, {**arrays, **parts}))
    return kn.load_solution(path, EOM)


def _parts():
    yield from {
        "status": "fine",
        "steps": "1",
        "events": None,
        "phases": [],
        "partitions": [],
        "numbers": [[None, 1]],
    }.items()
    yield from {"numbers": [["x"]], "events": [["up", None]], "event": "down", "partitions": [[[9], [9], []]]}.items()
    yield "t", np.array([0.0, 0.1, 0.05, 0.15, 0.2])
    yield "t", np.array([0.0, 0.1, 0.1, 0.15, 0.2])
    yield "states", SOL.states.T
    yield "states", SOL.states.astype(str)
    yield "states", SOL.states.astype(complex)
    yield "phase", np.array([0, 0, 0, 0, 1])
    yield "phase", np.array([0, 0, -1, 0, 0])
    yield "segment_starts", np.array([0.0])
    yield "segments", np.array([3])
    yield "segments", np.array([-1])
    names = (
        "t",
        "states",
        "work",
        "parameters",
        "inputs",
        "tolerances",
        "phase_parameters",
        "declared",
    )
    for name in names:
        yield name, None
        yield name, np.nan


@pytest.mark.parametrize(("name", "value"), list(_parts()))
def test_parts_that_do_not_fit_are_named(tmp_path, name, value):
    path = tmp_path / "run.npz"
    if value is None or isinstance(value, float):
        SOL.save(path)
        own = read(path).arrays.get(name)
        if own is not None:
            value = np.concatenate([own, own[:1]]) if value is None else np.full(own.shape, value)
    with pytest.raises(
        kn.SolutionFileError,
        match=r"do not fit together \(\w+: .*\)\. Simulate again|differs in|belong to another system",
    ):
        sealed(path, **{name: value})


@given(at=st.integers(min_value=0), bit=st.integers(0, 7), end=st.sampled_from(["npz", "zarr"]))
def test_any_bit(tmp_path_factory, at, bit, end):
    """With one bit changed a file is refused, or means the same: what changed was a date, or another thing that zip files keep."""
    if end == "zarr":
        require("zarr")
    path = tmp_path_factory.mktemp("bits") / f"run.{end}"
    SOL.save(path)
    whole = bytearray(path.read_bytes())
    whole[at % len(whole)] ^= 1 << bit
    path.write_bytes(whole)
    try:
        again = kn.load_solution(path, EOM)
    except kn.SolutionFileError:
        return
    finally:
        shutil.rmtree(path.parent)
    assert np.array_equal(again.states, SOL.states)
    assert (again.status, again.message, again.steps, again.method) == (SOL.status, SOL.message, SOL.steps, SOL.method)


def test_masses_of_one_and_of_five(tmp_path):
    """They fall alike, so that no rate tells one from the other."""

    def falling(mass):
        P = O.at("P", X * N.x)
        return kn.System(N, bodies=[kn.Particle("P", P, mass)], speeds={V: X.dt}, loads=[kn.gravity(-9.81 * N.x)])

    for one, five, told in (
        (1, 5, r"the mass of P: 1 in the file, 5 here"),
        (kn.parameter("m", 1, "kg"), kn.parameter("m", 5, "kg"), "the parameter m: 1 in the file, 5 here"),
        (kn.parameter("m", 1, "kg"), kn.parameter("m", 1, "g"), "the parameter m"),
    ):
        kn.simulate(kn.derive(falling(one)), (0, 1), q=[0], u=[0], samples=3).save(tmp_path / "run.npz")
        kn.load_solution(tmp_path / "run.npz", falling(one))
        with pytest.raises(
            kn.SolutionFileError, match=rf"differs in {told}\. Load it with the system that was simulated"
        ):
            kn.load_solution(tmp_path / "run.npz", falling(five))


@examples(0.2, 10)
@given(place=st.integers(0, len(NUMBERS) - 1), share=st.floats(1e-6, 1) | st.floats(-0.9, -1e-6))
def test_a_system_with_one_other_number_is_refused(tmp_path_factory, place, share):
    """Wherever it stands: in what does not act, in a branch not taken, in a piece of a table not reached."""
    path = tmp_path_factory.mktemp("one") / "run.npz"
    SOL.save(path)
    assert np.array_equal(kn.load_solution(path, system()).states, SOL.states)
    numbers = [x * (1 + share) if k == place else x for k, x in enumerate(NUMBERS)]
    with pytest.raises(kn.SolutionFileError, match="whose system differs in "):
        kn.load_solution(path, system(numbers))
    shutil.rmtree(path.parent)


_KILLED = """
import os, random, signal, sys, time
from pathlib import Path
import numpy as np
from kane.motion import Contents, read, write

folder, path = Path(sys.argv[1]), Path(sys.argv[1]) / sys.argv[2]
if path.suffix == ".zarr":
    import zarr.storage

def forked(act):
    pid = os.fork()
    if not pid:
        act()
        os._exit(0)
    return pid

def numbered(k):
    return Contents({"k": k}, {"a": np.full(200_000, float(k)), "b": np.random.default_rng(k).random(20_000)})

def save():
    k = 0
    while True:
        k += 1
        write(path, numbered(k))

def check():
    header, arrays = read(path)
    expected = numbered(header["k"]).arrays
    os._exit(0 if all(np.array_equal(arrays[name], a) for name, a in expected.items()) else 1)

assert os.waitpid(forked(lambda: write(path, numbered(0))), 0)[1] == 0
chance = random.Random(path.name)
for n in range(int(sys.argv[3])):
    pid = forked(save)
    time.sleep(chance.uniform(0, 0.15))
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    assert os.waitpid(forked(check), 0)[1] == 0, n
    others = {p.name for p in folder.iterdir()} - {path.name}
    assert all(p.startswith(".kane-") and p.endswith(".part" + path.suffix) for p in others), others
"""


@pytest.mark.slow
def test_a_process_that_is_killed_while_saving(path):
    """At each of a hundred moments the name stands for one whole file."""
    (path.parent / ".notes").mkdir()
    subprocess.run(
        [sys.executable, "-c", _KILLED, str(path.parent / ".notes"), path.name, "100"], check=True, timeout=300
    )
