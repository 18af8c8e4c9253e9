# SPDX-License-Identifier: BSD-3-Clause
"""A motion between its samples: closed forms, constraints, phases, inputs of Python."""

import pickle

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar
from tests.motion.steppers.runs import spring

N = kn.Frame("N")
x, v, f = kn.coordinate("x"), kn.speed("v"), kn.input("f")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
TIMES = np.sort(np.random.default_rng(3).uniform(0, 20, 300))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "vern9", "tsitpap8", "dop853", "tsit5", "radau9", "DOP853", "Radau"])
def test_between_samples_a_motion_is_as_exact_as_at_them(method):
    """q = cos t at 300 times of a motion with two samples, and what follows from it; at the samples it is the same to the last bit."""
    sol = kn.simulate(spring(), (0, 20), q=[1], u=[0], samples=2, method=method, rtol=1e-10, atol=1e-10)
    found = sol.at(TIMES)
    off = 1e-6 if method in ("Radau", "DOP853") else 1e-8
    assert found.q[:, 0] == pytest.approx(np.cos(TIMES), abs=off)
    assert found.energy == pytest.approx(np.sin(TIMES) ** 2 / 2, abs=off)
    assert (found.t == TIMES).all()
    assert (found.method, found.steps) == (sol.method, sol.steps)
    assert np.array_equal(sol.at([0, 20]).states, sol.states)
    assert np.array_equal(sol.at(20).states, sol.states[1:])
    more = kn.simulate(spring(), (0, 20), q=[1], u=[0], samples=TIMES, method=method, rtol=1e-10, atol=1e-10)
    assert np.array_equal(found.states, more.states[1:-1])


@pytest.mark.slow
def test_constraints_are_kept_between_samples_too():
    eom = kn.derive(four_bar.system())
    sol = kn.simulate(eom, (0, 5), **four_bar.START, samples=2)
    found = sol.at(np.linspace(0.1, 4.9, 200))
    assert max(np.abs(r).max() for r in found.constraint_residuals.values()) < 1e-12
    assert found.energy == pytest.approx(np.full(200, sol.energy[0]), abs=1e-7)


def test_phases_go_on_as_they_were():
    """A ball that bounces at half of its speed: parabola after parabola; at the instant itself what is after."""
    up = kn.Event("floor", x, direction=-1, then={v: -v / 2})
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("b", P, 1)], speeds={v: x.dt}, loads=[kn.gravity(-10 * N.x)], events=[up])
    )
    sol = kn.simulate(eom, (0, 2), q=[5], u=[0], samples=2)
    found = sol.at([0.5, 1.25, 1.75])
    assert found["x"] == pytest.approx([5 - 1.25, 1.25 - 0.3125, 3.75 - 2.8125], abs=1e-9)
    assert found["v"] == pytest.approx([-5, 2.5, -2.5], abs=1e-9)
    assert found.phase.tolist() == [0, 1, 1]
    assert sol.at(sol.jumps[0].t)["v"] == pytest.approx([5], abs=1e-9)


def test_functions_of_python_are_asked_again():
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, f * N.x)]))
    for law in (lambda t: -np.cos(t), lambda t, s: -s[0]):
        sol = kn.simulate(eom, (0, 20), q=[1], u=[0], inputs={f: law}, samples=2)
        found = sol.at(TIMES)
        assert found["x"] == pytest.approx(np.cos(TIMES), abs=1e-6)
        assert found["f"] == pytest.approx(-np.cos(TIMES), abs=1e-6)
    held = kn.simulate(eom, (0, 3), q=[1], u=[0], inputs={f: kn.sampled(lambda t, s: -s[0], 0.5)}, samples=2)
    own = kn.simulate(eom, (0, 3), q=[1], u=[0], inputs={f: kn.sampled(lambda t, s: -s[0], 0.5)}, samples=61)
    assert held.at(own.t[1:-1]).states == pytest.approx(own.states[1:-1], abs=1e-13)


def test_what_is_not_known_between_samples():
    sol = kn.simulate(spring(), (0, 2), q=[1], u=[0], samples=2)
    with pytest.raises(kn.SimulationError, match=r"from t = 0 to 2, got 0\.5 to 2\.5"):
        sol.at([0.5, 2.5])
    with pytest.raises(kn.SimulationError, match=r"increasing times, of the motion, got \[1, 0\.5\]"):
        sol.at([1, 0.5])
    with pytest.raises(kn.SimulationError, match="increasing times"):
        sol.at([])
    with pytest.raises(kn.SimulationError, match="from t = 0 to 2"):
        sol.at(np.nan)
    with pytest.raises(kn.SimulationError, match="a time or times of the motion, got 'now'"):
        sol.at("now")
    with pytest.raises(kn.SimulationError, match="read from a file or a pickle"):
        pickle.loads(pickle.dumps(sol)).at(1)
    calls = []
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, f * N.x)]))

    def moody(t, s):
        calls.append(t)
        return 0.0 if len(calls) < 60 else np.nan

    with pytest.raises(kn.SimulationError):
        kn.simulate(eom, (0, 2), q=[1], u=[0], inputs={f: moody}, samples=2).at(1)


def test_a_joined_motion_is_that_of_its_parts():
    """cos t up to 1, from there at another weight, and to and fro by events: each part at its own times, what jumps on both sides."""
    turn = kn.Event("turn", x, direction=-1, then={v: -v})
    m = kn.parameter("m", 1.0)
    body = kn.Particle("p", P, m)
    eom = kn.derive(kn.System(N, bodies=[body], speeds={v: x.dt}, loads=[kn.Force(P, -x * N.x)], events=[turn]))
    first = kn.simulate(eom, (0, 2), q=[1], u=[0], samples=2)
    whole = first + kn.simulate(eom, 4, start=first, parameters={m: 4}, samples=2)
    found = whole.at([0.5, 1.8, 2.0, 3.0, 4.0])
    assert found.t.tolist() == [0.5, 1.8, 2.0, 3.0, 4.0]
    assert found["x"][:2] == pytest.approx([np.cos(0.5), -np.cos(1.8)], abs=1e-8)
    a, b = -np.cos(2.0), np.sin(2.0)
    later = np.array([0.0, 1.0, 2.0]) / 2
    assert found["x"][2:] == pytest.approx(a * np.cos(later) + 2 * b * np.sin(later), abs=1e-8)
    assert found["m"].tolist() == [1, 1, 4, 4, 4]
    assert np.array_equal(whole.at(whole.t[-1]).states, whole.states[-1:])
    assert (whole + kn.simulate(eom, 5, start=whole, samples=2)).at([4.5])["m"].tolist() == [4]
    with pytest.raises(kn.SimulationError, match="got one that was joined"):
        whole.accuracy()


@pytest.mark.slow
@pytest.mark.parametrize("method", ["auto", "DOP853"])
def test_a_file_of_numbers_is_taken_once_more(tmp_path, method):
    """With a number for its input and an event that acts; energy and work too."""
    turn = kn.Event("turn", x, direction=-1, then={v: -v / 2})
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, (f - x) * N.x)], events=[turn])
    )  # fmt: skip
    sol = kn.simulate(eom, (0, 5), q=[1], u=[0], inputs={f: 0.5}, samples=11, method=method)
    sol.save(tmp_path / "run.npz")
    again = kn.load_solution(tmp_path / "run.npz", eom)
    here, there = (s.at([0.3, 1.1, 2.7, 4.9]) for s in (sol, again))
    assert np.array_equal(here.states, there.states)
    assert here.work == pytest.approx(there.work, abs=1e-14)
    assert again.accuracy().relative == pytest.approx(sol.accuracy().relative, rel=1e-6)
    more = kn.simulate(eom, 7, start=again, samples=3)
    assert (again + more).at([1.1, 6.5])["x"][0] == here["x"][1]


def test_a_file_that_does_not_say_how_it_was_stepped(tmp_path):
    """Of a longest step, at a tolerance that asks for none, and of functions nothing is kept."""
    sol = kn.simulate(spring(), (0, 200), q=[1], u=[0], samples=3, method="tsit5", max_step=0.01, rtol=1e-2, atol=1e-9)
    sol.save(tmp_path / "run.npz")
    with pytest.raises(kn.SimulationError, match="max_step=, breakpoints= or settings= that a file does not contain"):
        kn.load_solution(tmp_path / "run.npz", spring()).at(1.0)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, f * N.x)]))
    kn.simulate(eom, (0, 1), q=[1], u=[0], inputs={f: lambda t: -np.cos(t)}).save(tmp_path / "law.npz")
    with pytest.raises(kn.SimulationError, match="read from a file or a pickle"):
        kn.load_solution(tmp_path / "law.npz", eom).at(0.5)


def damped():
    """ẍ = f − 4 x − 0.2 v, the spring's constant being a parameter."""
    k = kn.parameter("k", 4.0)
    loads = [kn.Force(P, (f - k * x - 0.2 * v) * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads)), k


@pytest.mark.parametrize("prepared", [False, True])
def test_values_that_are_changed_for_the_next_motion_are_not_those_of_the_last(prepared):
    eom, k = damped()
    parameters, inputs = {k: 4.0}, {f: 0.5}
    if prepared:
        run = kn.prepare(eom, (0, 5), inputs=inputs, samples=6)
        inputs[f] = -7.0
        sol = run([1], [0], parameters=parameters)
    else:
        sol = kn.simulate(eom, (0, 5), q=[1], u=[0], parameters=parameters, inputs=inputs, samples=6)
    parameters[k], inputs[f] = 16.0, 9.0
    assert np.array_equal(sol.at(2.0).states[0], sol.states[2])
    assert sol.accuracy().relative < 1e-9


def test_the_accuracy_of_some_times_is_that_of_the_motion_there():
    eom, _ = damped()
    sol = kn.simulate(eom, (0, 5), q=[1], u=[0], inputs={f: kn.sin(kn.time)}, samples=6, rtol=1e-6)
    exact = kn.simulate(
        eom, (0, 5), q=[1], u=[0], inputs={f: kn.sin(kn.time)}, samples=[0.3, 3.3], rtol=1e-13, atol=1e-13
    )
    part = sol.at([0.3, 3.3])
    off = np.abs(part.states - exact.states[1:-1])
    for method, close in (("repeated", 0.5), ("variational", 0.01)):
        found = part.accuracy(method=method)
        assert found.t.tolist() == [0.3, 3.3]
        assert found.errors == pytest.approx(off, rel=close, abs=1e-3 * off.max())
    more = kn.simulate(eom, 8, start=sol)
    with pytest.raises(kn.SimulationError, match="got one that was joined"):
        (sol + more).at([1, 6]).accuracy()


def test_a_controller_that_goes_on_is_asked_again_as_it_was():
    eom, _ = damped()
    integral = kn.sampled(lambda t, state, z: (-z, z + 0.1 * state[0]), period=0.1, state=0.0)
    first = kn.simulate(eom, (0, 1), q=[1], u=[0], inputs={f: integral}, samples=11)
    second = kn.simulate(eom, 2, start=first, samples=11)
    assert np.array_equal(second.at(second.t).states, second.states)
    assert (first + second).at(1.55).q[0, 0] == pytest.approx(second.at(1.55).q[0, 0], abs=1e-12)


def test_motions_of_more_steps_than_there_are_unless_told():
    sol = kn.simulate(spring(), (0, 1.1), q=[1], u=[0], samples=2, method=kn.integrators.Rk4(1e-6), max_steps=2_000_000)
    assert sol.steps > 1_000_000
    assert sol.at(1.05).q[0, 0] == pytest.approx(np.cos(1.05), abs=1e-12)


def test_a_motion_that_ends_where_it_begins():
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("b", P, 1)],
            speeds={v: x.dt},
            loads=[kn.Force(P, -x * N.x)],
            events=[kn.Event("falls", v, direction=-1)],
        )
    )
    sol = kn.simulate(eom, (0, 9), q=[1], u=[0])
    assert len(sol) == 1
    assert np.array_equal(sol.at(0.0).states, sol.states)
    assert sol.accuracy().relative == 0.0
    with pytest.raises(kn.SimulationError, match="Expected times of the motion"):
        sol.at(0.1)
