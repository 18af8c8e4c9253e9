# SPDX-License-Identifier: BSD-3-Clause
"""Ctrl-C: what there is of a motion is returned, whoever steps it and whatever is asked of Python."""

import _thread
import math
import signal
import threading

import numpy as np
import pytest

import kane as kn
from kane import progress
from kane.gallery.contacts import mass_on_belt

N = kn.Frame("N")
x, v, F = kn.coordinate("x"), kn.speed("v"), kn.input("F")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
LINE = kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, (F - x) * N.x)])
EOM = kn.derive(LINE)
START = {"q": [1], "u": [0]}


@pytest.fixture(autouse=True)
def handler():
    """Python's own one, which processes of tests need not have; every test begins long after the last signal."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    progress._here.last = -10.0
    yield
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    signal.signal(signal.SIGINT, before)


def later(seconds):
    timer = threading.Timer(seconds, _thread.interrupt_main)
    timer.start()
    return timer


def check(sol, begin, end):
    """The beginning of cos t, with all its samples, and the state it was stopped at."""
    assert sol.status == "stopped"
    assert sol.message == f"interrupted by Ctrl-C at t = {sol.t[-1]:.6g}"
    assert begin <= sol.t[-1] < end
    assert sol.states.shape == (len(sol.t), 2)
    assert sol["x"] == pytest.approx(np.cos(sol.t), abs=1e-5)


METHODS = ["dop853", "tsit5", "radau9", "rk4", "DOP853", "Radau"]


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("of", ["state", "time"])
def test_while_a_function_is_asked(method, of):
    """The signal comes in the function; it is not asked again, and no state is made of its answer."""
    asked, before = [], [math.inf]

    def law(t, *_):
        asked.append(t)
        if t > 2 and len(asked) > before[0]:
            signal.raise_signal(signal.SIGINT)
        return 0.0

    function = law if of == "state" else lambda t: law(t)
    given = {"inputs": {F: function}, "method": method, "max_step": 0.01, "samples": 901} | START
    kn.simulate(EOM, (0, 9), max_steps=1, **given)
    before[0] = len(asked)  # before the second step, as jumps of functions of time are looked for
    asked.clear()
    sol = kn.simulate(EOM, (0, 9), **given)
    check(sol, 1.9, 2.1)
    assert len(sol) >= 190
    assert sum(t > 2 for t in asked[before[0] :]) == 1


@pytest.mark.parametrize("method", ["auto", "DOP853", "BDF"])
def test_while_machine_code_runs(method):
    given = {"inputs": {F: 0.0}, "method": method, "max_steps": 10**9, "samples": 11} | START
    kn.simulate(EOM, (0, 1), **given)  # what is compiled
    timer = later(0.3)
    sol = kn.simulate(EOM, (0, 1e7), **given)
    timer.join()
    assert sol.message.startswith("interrupted by Ctrl-C at t = ")
    assert 0 < sol.t[-1] < 1e7


def test_a_motion_of_many_phases_and_controllers():
    """A ball that bounces for ever, and a sampled controller in whose function the signal comes."""
    turn = kn.Event("turn", x, then={v: -v}, direction=-1)
    eom = kn.derive(LINE.replace(events=[turn]))

    def control(t, state):
        if t > 4.05:
            signal.raise_signal(signal.SIGINT)
        return 0.0

    sol = kn.simulate(eom, (0, 9), inputs={F: kn.sampled(control, period=0.1)}, **START)
    assert sol.message.startswith("interrupted by Ctrl-C at t = 4.")
    assert len(sol.jumps) == 1
    assert sol["x"] == pytest.approx(np.abs(np.cos(sol.t)), abs=1e-7)
    more = kn.simulate(eom, 9, start=sol, inputs={F: 0.0})  # and goes on
    assert (more.t[0], more.status) == (sol.t[-1], "finished")


def test_another_one_soon_after_interrupts_the_program():
    def law(t, state):
        if t > 2:
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
        return 0.0

    def once(t, state):
        if t > 2:
            signal.raise_signal(signal.SIGINT)
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        kn.simulate(EOM, (0, 9), inputs={F: law}, **START)
    progress._here.last = -10.0
    assert kn.simulate(EOM, (0, 9), inputs={F: once}, **START).status == "stopped"
    with pytest.raises(KeyboardInterrupt):  # as in a loop over many motions
        kn.simulate(EOM, (0, 9), inputs={F: once}, **START)


def test_a_part_is_no_answer_to_another_question():
    """What takes the motion once more, for its errors or its values between samples, is interrupted as a whole."""
    armed = []

    def law(t, state):
        if armed and t > 2:
            signal.raise_signal(signal.SIGINT)
        return 0.0

    sol = kn.simulate(EOM, (0, 3), inputs={F: law}, samples=4, **START)
    armed.append(True)
    for question in (sol.accuracy, lambda: sol.at([0.5, 2.5])):
        progress._here.last = -10.0
        with pytest.raises(KeyboardInterrupt):
            question()


def test_a_handler_of_the_programs_own_is_left():
    seen = []
    signal.signal(signal.SIGINT, lambda *_: seen.append(1))

    def law(t, state):
        if t > 2 and not seen:
            signal.raise_signal(signal.SIGINT)
        return 0.0

    sol = kn.simulate(EOM, (0, 3), inputs={F: law}, **START)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    assert (sol.status, seen) == ("finished", [1])


def test_other_threads_run_on():
    found = []
    thread = threading.Thread(target=lambda: found.append(kn.simulate(EOM, (0, 30), inputs={F: 0.0}, **START)))
    thread.start()
    thread.join()
    assert found[0].status == "finished"


@pytest.mark.slow
def test_contacts_that_change_their_modes_without_end():
    """A mass on a belt for a year: what there is of the motion is returned."""
    eom = kn.derive(mass_on_belt.system())
    kn.simulate(eom, (0, 10), **mass_on_belt.START)  # compiled
    later(0.3)
    sol = kn.simulate(eom, (0, 3e7), samples=2, **mass_on_belt.START)
    assert sol.status == "stopped"
    assert sol.message.startswith("interrupted by Ctrl-C at t = ")
    assert 100 < sol.t[-1] < 3e7
    assert len(sol.mode_history) > 100
