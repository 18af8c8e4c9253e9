# SPDX-License-Identifier: BSD-3-Clause
"""What writes files for the user: whole ones, over its own alone."""

import os

import numpy as np
import pytest
from matplotlib.figure import Figure

import kane as kn
from kane.gallery import pendulum
from tests.cli.command import kane, line

EOM = kn.derive(pendulum.system())
SOL = kn.simulate(EOM, (0, 1), q=[0.5], u=[0], samples=5)
WRITERS = {
    "report.html": lambda path: kn.report(EOM, path),
    **{f"motion.{end}": lambda path: kn.plot(SOL, "theta", path=path) for end in ("png", "svg", "pdf")},
}
COMMANDS = (
    ("report", "pendulum", "--out"),
    ("simulate", "pendulum", "--csv"),
    ("simulate", "pendulum", "--plot"),
    ("emit", "pendulum", "--target", "c", "--out"),
    ("new",),
)


def _link(path):
    path.with_name("mine").write_text("mine")
    path.symlink_to("mine")


THINGS = {
    "folder": lambda path: path.mkdir(),
    "link": _link,
    "pipe": os.mkfifo,
    "device": lambda path: os.mknod(path, 0o020666, os.makedev(1, 3)),
}


def _made(thing, path):
    try:
        THINGS[thing](path)
    except PermissionError:  # devices are made by root alone
        path.mkdir()
        return "folder"
    return thing


@pytest.mark.parametrize("thing", THINGS)
@pytest.mark.parametrize("name", WRITERS)
def test_nothing_but_files_is_replaced(tmp_path, name, thing):
    path = tmp_path / name
    thing = _made(thing, path)
    before = path.lstat().st_ino, sorted(os.listdir(tmp_path))
    with pytest.raises(
        kn.ArgumentError, match=rf"Expected a file to write, got the {thing} .*{name}, which is not replaced"
    ):
        WRITERS[name](path)
    assert (path.lstat().st_ino, sorted(os.listdir(tmp_path))) == before


@pytest.mark.parametrize("name", WRITERS)
def test_only_what_was_written_here_is_replaced(tmp_path, name):
    path = tmp_path / "new" / name
    for _ in range(2):
        WRITERS[name](path)
    assert os.listdir(path.parent) == [name]
    if name != "report.html":
        Figure().savefig(path)
    else:
        path.write_text("<!doctype html><title>My thesis</title>")
    mine = path.read_bytes()
    with pytest.raises(kn.ArgumentError, match=r"a file of this kind written by kane, got .* with other contents"):
        WRITERS[name](path)
    assert path.read_bytes() == mine
    assert os.listdir(path.parent) == [name]


def test_what_fails_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / "motion.svg"
    kn.plot(SOL, "theta", path=path)
    before = path.read_bytes()

    def full(_, place, **__):
        place.write_text("half")
        raise OSError("no space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(OSError, match="no space left"):
        kn.plot(SOL, "theta", path=path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("given", [3, None, b"report.html"])
def test_what_is_no_path(given):
    with pytest.raises(
        kn.ArgumentError, match=r"Expected the path of a file, a text or a Path, got .*\. Write kn\.report\("
    ):
        kn.report(EOM, given)


@pytest.mark.parametrize("thing", ["link", "pipe"])
@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_commands_leave_what_is_no_file(tmp_path, words, thing):
    place = tmp_path / ("x.html" if words[0] == "report" else "x.svg" if words[-1] == "--plot" else "x.py")
    _made(thing, place)
    before = place.lstat().st_ino
    for force in ((), ("--force",)):
        told = kane(*words, place, *force, code=2)
        assert f"Expected a file to write, got the {thing}" in line(told.stderr)
    assert place.lstat().st_ino == before
    assert thing != "link" or place.read_text() == "mine"


def test_a_table_is_whole(tmp_path):
    path = tmp_path / "motion.csv"
    kane("simulate", "pendulum", "--t1", 1, "--csv", path)
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    assert table[-1, 0] == 1
    assert os.listdir(tmp_path) == [path.name]
