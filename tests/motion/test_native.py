# SPDX-License-Identifier: BSD-3-Clause
"""Motions in machine code are those of SciPy's solvers, and stop where these do."""

import pickle
import warnings

import numpy as np
import pytest

import kane as kn
from kane.errors import SimulationError
from kane.gallery import pendulums
from tests.motion.steppers.runs import spring

NATIVE = ["gauss16", "dop853"]


@pytest.fixture(scope="module")
def pendulum():
    return kn.derive(pendulums.system(2))


def simulated(eom, method, **more):
    return kn.simulate(eom, (0, 3), q=[1.0, 2.0], u=[0.5, 0.0], method=method, samples=31, **more)


@pytest.mark.parametrize("method", NATIVE)
def test_a_motion_is_scipys(method, pendulum):
    """At 1e-12 they differ by less than 1e-10; so they do where steps end at a breakpoint, and where the end is no sample."""
    reference = simulated(pendulum, "DOP853", rtol=1e-12, atol=1e-12)
    for more in ({}, {"breakpoints": [0.7, 1.0]}):
        sol = simulated(pendulum, method, rtol=1e-12, atol=1e-12, **more)
        assert sol.method == method
        assert sol.status == "finished"
        assert np.array_equal(sol.t, reference.t)
        assert sol.states == pytest.approx(reference.states, abs=1e-10)
        assert not sol.energy_check.exceeds(1e-12)
    few = kn.simulate(
        pendulum, (0, 3), q=[1.0, 2.0], u=[0.5, 0.0], method=method, rtol=1e-12, atol=1e-12, samples=[1.0]
    )
    assert few.t.tolist() == [0, 1, 3]
    assert few.states == pytest.approx(reference.states[[0, 10, 30]], abs=1e-10)


@pytest.mark.parametrize("method", NATIVE)
def test_work_and_constant_inputs_are_there(method):
    """A force F on a mass of 1 kg: x = F t²/2, and F x is the work."""
    N = kn.Frame("N")
    x, F = kn.coordinate("x"), kn.input("F")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, F * N.x)], speeds="rates"))
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: 3}, method=method)
    assert sol.q[:, 0] == pytest.approx(1.5 * sol.t**2, rel=1e-12)
    assert sol.work == pytest.approx(4.5 * sol.t**2, rel=1e-12)
    with pytest.raises(
        SimulationError, match=f'method="{method}", got one in which inputs are functions of time. Take method="auto"'
    ):
        kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: np.sin}, method=method)
    assert kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: np.sin}, method="auto").method == "DOP853"
    assert kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: 3}, method="auto").method in NATIVE


@pytest.mark.parametrize("method", NATIVE)
def test_limits_are_kept(method, pendulum):
    """So many steps and no more, though the kernel takes them by the thousand; so much time; none longer than asked for."""
    sol = simulated(pendulum, method, max_steps=7)
    assert (sol.status, sol.steps) == ("stopped", 7)
    assert "7 steps were not enough; at t = " in sol.message
    assert sol.t[-1] == pytest.approx(float(sol.message.split()[-1]), rel=1e-5)
    assert simulated(pendulum, method, max_step=1e-3).steps == 3000
    late = kn.simulate(
        pendulum, (0, 1e9), q=[1.0, 2.0], u=[0.5, 0.0], method=method, max_seconds=0.05, max_steps=10**9, samples=2
    )
    assert "max_seconds=0.05 have passed" in late.message
    slow = kn.simulate(pendulum, (0, 1e9), q=[1.0, 2.0], u=[0.5, 0.0], method=method, samples=2)
    assert "10000 steps led from t = 0 to" in slow.message


def singular(exponent):
    """x'' = 1/(2 − x)^exponent from rest at 0."""
    N = kn.Frame("N")
    x = kn.coordinate("x")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    load = kn.Force(p, (2 - x) ** exponent * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))


@pytest.mark.parametrize("method", NATIVE)
@pytest.mark.parametrize("exponent", [-2, 0.5])
def test_what_breaks_off_says_where_and_why(method, exponent):
    """A pole, and the root of what becomes negative: the solution ends before, as by SciPy's DOP853, and no number is NaN."""
    eom = singular(exponent)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        ends = {m: kn.simulate(eom, (0, 10), q=[0], u=[0.5], method=m) for m in (method, "DOP853")}
    own, other = ends[method], ends["DOP853"]
    assert own.status == other.status == "stopped"
    assert own.t[-1] == pytest.approx(other.t[-1], rel=1e-4)
    assert np.isfinite(own.states).all()
    told = "changes fastest" if exponent == -2 else "(2 - x) = nan|x - 2|not finite"
    assert f"singular or not finite near t = {own.t[-1]:.6g}" in own.message
    assert any(part in own.message for part in told.split("|")), own.message


@pytest.mark.parametrize("method", NATIVE)
def test_rounding_of_time_does_not_add_up(method):
    """A million steps of 1e-3 end at 1000 s exactly, and the spring's phase is right to what its own steps leave."""
    sol = kn.simulate(spring(), (0, 1000), q=[1], u=[0], method=method, max_step=1e-2, samples=2)
    assert sol.steps == 100_000
    assert sol.q[-1, 0] == pytest.approx(np.cos(1000), abs=1e-12)


def test_a_pickle_keeps_the_method(pendulum):
    sol = simulated(pendulum, "auto")
    assert pickle.loads(pickle.dumps(sol)).method == sol.method


def test_methods_that_are_none_are_named(pendulum):
    with pytest.raises(SimulationError, match=r"Expected method to be one of auto, .*dop853.*, got 'euler'"):
        simulated(pendulum, "euler")
    with pytest.raises(SimulationError, match=r"Expected method to be one of auto, .*, got \['dop853'\]"):
        simulated(pendulum, ["dop853"])
