# SPDX-License-Identifier: BSD-3-Clause
"""Motions that do not get on are stopped soon, and say at which switch of which load they stand, and what to do."""

from __future__ import annotations

import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
v = kn.speed("v")
P = O.at("P", x * N.x)


def line(force, spring=50.0, unit=1.0):
    """A particle of 1 kg on a line, on a spring, under a force."""
    loads = [kn.Force(P, unit * (force - spring * x / unit) * N.x, name="pull")]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads))


SLOW = pytest.mark.slow


@pytest.mark.slow
@pytest.mark.parametrize(
    "method", ["DOP853", *(pytest.param(m, marks=SLOW) for m in ("RK23", "RK45", "Radau", "BDF", "LSODA"))]
)
@pytest.mark.parametrize("force", [-3 * kn.sign(v), kn.where(kn.less(v, 0), 3.0, -3.0)], ids=["sign", "where"])
@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
def test_dry_friction_that_comes_to_rest(force, method, unit):
    eom = line(force, unit=unit)
    tolerances = {"rtol": 1e-9, "atol": 1e-9 * unit}
    sol = kn.simulate(eom, (0, 20), q=[0.5 * unit], u=[0.5 * unit], method=method, samples=3, **tolerances)
    assert sol.status == "stopped"
    assert sol.steps < 9000
    assert "in the pull switches back and forth, as v reaches zero again and again. Declare friction" in sol.message
    assert sol["v"][-1] == pytest.approx(0, abs=1e-4 * unit)


def test_a_table_that_jumps_at_rest():
    """Its cure is another table, and no eps."""
    friction = kn.table([-1, 0, 1], [3, 3, -3], "steps")(v)
    sol = kn.simulate(line(friction), (0, 20), q=[0.5], u=[0.5], samples=3)
    assert sol.status == "stopped"
    assert "or take a table of kind 'cubic' instead and choose" in sol.message


@pytest.mark.slow
def test_the_cure_cures():
    """tanh(v/eps) and Radau: at rest where the spring pulls less than the friction."""
    sol = kn.simulate(line(-3 * kn.tanh(v / 1e-4)), (0, 3), q=[0.5], u=[0.5], method="Radau", samples=3)
    assert sol.status == "finished"
    assert abs(sol["v"][-1]) < 1e-4
    assert abs(sol["x"][-1]) < 3 / 50


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_switches_that_are_crossed_are_none(seed):
    """A load that pulls back towards one place jumps twice a swing, and the motion goes on."""
    sol = kn.simulate(line(-(seed + 1.0) * kn.sign(x), 0.0), (0, 20), q=[0.5], u=[0.1], rtol=1e-6, atol=1e-6, samples=3)
    assert sol.status == "finished"


def test_steps_of_one_length_that_turn_back_at_once():
    """Pulled back to x = 0 by 1 N a particle of 1e-5 m/s swings within 5e-11 m: steps of 0.1 s are shortened, and counted."""
    eom = line(-kn.sign(x), 0.0)
    sol = kn.simulate(eom, (0, 1e-4), q=[0], u=[1e-5], method="rk4", max_step=0.1, samples=[3e-5, 5e-5])
    assert sol.q[:, 0] == pytest.approx([0, -5e-11, 5e-11, 0], abs=1e-16)
    told = kn.simulate(eom, (0, 1), q=[0], u=[1e-5], method="rk4", max_step=0.1, max_steps=20)
    assert told.message.startswith("20 steps were not enough")


@pytest.mark.slow
def test_a_motion_that_hardly_gets_on():
    """By an explicit method a rate of 1e9 /s takes steps of 1e-9 s; what was asked for is done all the same."""
    eom = line(-1e9 * v, 1e4)
    sol = kn.simulate(eom, (0, 1e4), q=[1], u=[0], method="RK23", rtol=1e-3, atol=1e-3, samples=3)
    assert (sol.status, sol.steps) == ("stopped", 10_000)
    assert 'Choose method="Radau" if the equations are stiff' in sol.message
    assert (
        kn.simulate(eom, (0, 1e4), q=[1], u=[0], method="Radau", rtol=1e-3, atol=1e-3, samples=3).status == "finished"
    )
    told = kn.simulate(eom, (0, 1e4), q=[1], u=[0], method="RK23", rtol=1e-3, atol=1e-3, samples=3, max_steps=10_100)
    assert told.message.startswith("10100 steps were not enough")


def test_a_motion_that_takes_long():
    sol = kn.simulate(line(0), (0, 1e6), q=[1], u=[0], max_seconds=0.05, samples=3)
    assert sol.status == "stopped"
    assert sol.message.startswith("max_seconds=0.05 have passed; at t = ")
    with pytest.raises(kn.SimulationError, match="Expected max_seconds > 0"):
        kn.simulate(line(0), (0, 1), q=[1], u=[0], max_seconds=0)
