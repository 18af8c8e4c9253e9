# SPDX-License-Identifier: BSD-3-Clause
"""Constraints that bend along a motion: it stops at corners, and goes through where only the curvature jumps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
v, w = kn.speeds("v w")
P = O.at("P", x * N.x + y * N.y)
G = 9.81


def positive(c, a, b):
    return kn.where(kn.less(0, c), a, b)


def bead(profile, unit=1.0, place=(0.37, 0.37)):
    """A bead of 1 kg on y = profile(x), under gravity."""
    system = kn.System(
        N,
        bodies=[kn.Particle("p", P, 1.0)],
        speeds={v: x.dt, w: y.dt},
        loads=[kn.gravity(-G * unit * N.y)],
        holonomic=[y - profile],
    )
    return kn.derive(system, near={x: place[0] * unit, y: place[1] * unit})


@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
@pytest.mark.parametrize(
    "method", ["DOP853", *(pytest.param(m, marks=pytest.mark.slow) for m in ("RK23", "Radau", "BDF", "LSODA"))]
)
def test_a_bead_stops_at_a_corner_of_its_wire(method, unit):
    """From rest at 1 along y = |x| it comes to the corner with v² = g, after √(4/g)."""
    given = {"q": [-unit, unit], "u": [0, 0], "method": method, "atol": 1e-9 * unit, "samples": 5}
    sol = kn.simulate(bead(abs(x), unit), (0, 3), **given)
    assert sol.status == "stopped"
    for told in (
        "velocities would have to jump at t = 0.6385",
        "abs(x) switches at x = 0",
        "'holonomic 1'",
        "stiff spring",
    ):
        assert told in sol.message
    assert sol.t[-1] == pytest.approx(np.sqrt(4 / G), rel=1e-6)
    assert sol["v"][-1] == pytest.approx(np.sqrt(G) * unit, rel=1e-6)
    assert abs(sol["x"][-1]) < 1e-6 * unit
    assert sol.energy_check.relative < 1e-6


CORNERS = {
    "max": (kn.max(x, 0), "max(0, x)"),
    "where": (positive(x, x / 2, -x), "0 < x"),
    "two at once": (abs(x) + positive(2 * x, 0, x), "x"),
    "min": (kn.min(x, -x), "min("),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CORNERS)
def test_corners_are_told_however_they_are_written(name):
    profile, told = CORNERS[name]
    start = {"q": {x: -0.5, y: kn.guess(0.1)}, "u": {v: 4.0}}
    sol = kn.simulate(bead(profile), (0, 3), samples=2, **start)
    assert sol.status == "stopped"
    assert "velocities would have to jump" in sol.message
    assert told in sol.message
    assert abs(sol["x"][-1]) < 1e-9


def test_a_step_in_the_wire_is_told_as_a_jump_of_positions():
    sol = kn.simulate(bead(positive(x - 0.25, 0.1, 0)), (0, 3), q=[0, 0], u=[1, 0], samples=2)
    assert sol.status == "stopped"
    assert "positions would have to jump at t = 0.25" in sol.message
    assert "0 < x - 1/4" in sol.message


def test_a_motion_constraint_that_sets_in_stops_where_it_takes_velocities_away():
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds={v: x.dt, w: y.dt}, nonholonomic=[w - positive(x, v, 0)]),
        near={x: 0.4},
    )  # fmt: skip
    sol = kn.simulate(eom, (0, 3), q=[-1, 0], u=[1, 0], samples=2)
    assert sol.status == "stopped"
    assert "velocities would have to jump at t = 1" in sol.message
    assert kn.simulate(eom, (0, 3), q=[0.5, 0], u=[1, 1], samples=2).status == "finished"


def test_a_corner_that_is_not_reached_and_one_at_rest_do_no_harm():
    turns = kn.simulate(bead(abs(x)), (0, 0.6), q=[1, 1], u=[3, 3], samples=5)
    assert turns.status == "finished"
    np.testing.assert_allclose(turns["x"], 1 + 3 * turns.t - G / 4 * turns.t**2, atol=1e-8)
    rest = kn.simulate(bead(abs(x)), (0, 1), q=[0, 0], u=[0, 0], samples=5)
    assert rest.status == "finished"
    assert not rest["x"].any()


def test_a_start_on_a_corner_is_refused_unless_at_rest():
    with pytest.raises(kn.SimulationError, match=r"got one on a corner of 'holonomic 1': abs\(x\) switches at x = 0"):
        kn.simulate(bead(abs(x)), (0, 1), q=[0, 0], u=[1, 0])


@examples(0.03)
@given(
    st.tuples(*[st.floats(-1, 1)] * 4),
    st.floats(-0.4, 0.4),
    st.sampled_from((-1.0, 1.0)),
)
def test_random_wires_of_two_parabolas(c, corner, way):
    """Of one gradient where they meet: energy is kept through; of two: the motion ends there."""
    slope, left, right, kink = c
    d = x - corner
    for bent in (0.0, 0.2 + abs(kink)):
        wire = slope * d + positive(d, right * d**2 + bent * d, left * d**2)
        eom = bead(wire, place=(-way, float(kn.evaluate(wire, {x: -way}))))
        start = {"q": {x: -way, y: kn.guess(0)}, "u": {v: 9.0 * way}, "rtol": 1e-8, "atol": 1e-8}
        sol = kn.simulate(eom, (0, 0.5), samples=41, **start)
        if bent:
            assert sol.status == "stopped"
            assert sol["x"][-1] == pytest.approx(corner, abs=1e-6)
        else:
            assert sol.status == "finished"
            assert (sol["x"][-1] - corner) * way > 0
        assert sol.energy_check.relative < 1e-5
        far = sol["x"] - corner
        wires = slope * far + np.where(far > 0, right * far**2 + bent * far, left * far**2)
        np.testing.assert_allclose(sol["y"], wires, atol=1e-7)
