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
