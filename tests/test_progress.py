# SPDX-License-Identifier: BSD-3-Clause
"""What is said of long work on a terminal, a pseudo-terminal here, and that nothing is said elsewhere."""

import io
import os
import threading
import time
from types import SimpleNamespace

import pytest

import kane as kn
from kane import progress
from kane.gallery import four_bar

pty = pytest.importorskip("pty")
CLEAR = "\r\x1b[K"


@pytest.fixture
def terminal(monkeypatch):
    """A function that gives what was written to stderr, a terminal."""
    master, slave = pty.openpty()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("KANE_PROGRESS", raising=False)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    file = os.fdopen(slave, "w")
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=file))

    def written():
        file.flush()
        os.set_blocking(master, False)
        text = b""
        while True:
            try:
                more = os.read(master, 1 << 16)
            except (BlockingIOError, OSError):
                return text.decode()
            text += more

    yield written
    file.close()
    os.close(master)


def test_only_what_takes_long_is_told_and_nothing_is_left_of_it(terminal, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.05)
    with progress.working("Deriving"):
        pass
    assert terminal() == ""
    with progress.working("Deriving"):
        time.sleep(0.3)
    text = terminal()
    assert text.startswith(f"{CLEAR}Deriving … (0 s)")
    assert text.endswith(CLEAR)

    def failing():
        with progress.working("Failing"):
            time.sleep(0.1)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing()
    assert terminal().endswith(CLEAR)


def test_work_within_work_has_one_line_with_how_far_it_is(terminal):
    with progress.working("Simulating"), progress.working("Simulating"):
        progress.far(lambda: "t = 3 of 5 s")
        with progress.working("Compiling"):
            time.sleep(0.3)
        time.sleep(0.3)
    text = terminal()
    assert "Simulating: t = 3 of 5 s, compiling (0 s)" in text
    assert "Simulating: t = 3 of 5 s (0 s)" in text


def test_the_line_belongs_to_one_thread(terminal):
    def other():
        with progress.working("Linearizing"):
            progress.far(lambda: "far")
            time.sleep(0.3)

    with progress.working("Deriving"):
        thread = threading.Thread(target=other)
        thread.start()
        thread.join()
    assert "inearizing" not in terminal()
    other()
    assert "Linearizing: far" in terminal()


@pytest.mark.parametrize("name", ["TERM", "KANE_PROGRESS", "no terminal"])
def test_nothing_is_told_where_it_is_not_wanted(terminal, monkeypatch, name):
    if name == "no terminal":
        monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=io.StringIO()))
    else:
        monkeypatch.setenv(name, "dumb" if name == "TERM" else "off")
    threads = threading.active_count()
    with progress.working("Deriving"):
        assert threading.active_count() == threads
        progress.far(lambda: pytest.fail("asked for how far it is"))
    assert terminal() == ""


@pytest.mark.slow
def test_everything_that_may_take_long_says_what_it_does(terminal, tmp_path, monkeypatch):
    """Each of them enters the line; a wait makes each long enough."""
    seen = []
    begin = progress._Line.watch

    def watch(self, done, patience):
        seen.append(self.doing[0])
        begin(self, done, patience)

    monkeypatch.setattr(progress._Line, "watch", watch)
    eom = kn.derive(four_bar.system())
    start = kn.assemble(eom, q={"q1": 1.0, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)})
    kn.simulate(eom, (0, 0.01), q=start.q, u=start.u, samples=2)
    kn.linearize(eom, q=start.q, u=start.u, steady=False)
    eom.compile(cache=False)
    kn.report(eom, tmp_path / "report.html")
    x, v = kn.coordinates("x")[0], kn.speeds("v")[0]
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    k = kn.parameter("k", 2.0)
    pulled = kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, (1 - k * x) * N.x)])
    spring = kn.derive(pulled)
    kn.equilibrium(spring)
    kn.continuation(spring, k, [1.0, 2.0])
    told = {"Deriving", "Assembling", "Simulating", "Linearizing", "Compiling", "Writing the report", "Trimming"}
    assert {*told, "Following the branch"} == set(seen)
    assert progress._line.owner is None
