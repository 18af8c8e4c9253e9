# SPDX-License-Identifier: BSD-3-Clause
"""Contacts that just touch: an impact is neither missed nor counted twice, however flat the way to it, beside closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

TIGHT = {"rtol": 1e-12, "atol": 1e-12}
DEEP = [1e-2, 1e-6, 1e-10]


@pytest.fixture(scope="module")
def ball() -> kn.Equations:
    """On a spring at the height h, that swings down to a floor at zero: y = h + A cos t."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y", "m")
    m, k, h = kn.parameter("m", 1.0, "kg"), kn.parameter("k", 1.0, "N/m"), kn.parameter("h", 1.0, "m")
    P = O.at("P", y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), restitution=0.5)
    loads = [kn.Force(P, -k * (y - h) * N.y)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("ball", P, m)], speeds="rates", loads=loads, contacts=[floor]))


@pytest.mark.parametrize("deep", DEEP)
def test_a_ball_that_would_go_a_little_below_the_floor_hits_it_at_each_swing(ball: kn.Equations, deep: float) -> None:
    """It meets the floor at cos t = −1/A with v² = A² − 1, leaves it with v/2, and is back after 2π − 2 arctan(v/2)."""
    sol = kn.simulate(ball, (0, 20), q=[2 + deep], u=[0], **TIGHT)
    v, t = np.sqrt(deep * (2 + deep)), np.pi - np.arctan(np.sqrt(deep * (2 + deep)))
    expected = []
    while t < 20:
        expected.append((t, v))
        v /= 2
        t += 2 * np.pi - 2 * np.arctan(v)
    assert len(expected) == 3
    found = [(j.t, -j.changes[ball.speeds[0]][0]) for j in sol.jumps]
    # what tolerances leave of the depth turns times by as much over the speed
    np.testing.assert_allclose(found, expected, rtol=0, atol=4e-12 / np.sqrt(deep))
    assert sol["y"].min() > -1e-13


@pytest.mark.parametrize("high", [0.0, 1e-10, 1e-6])
def test_a_ball_that_comes_down_to_the_floor_and_no_further_swings_on(ball: kn.Equations, high: float) -> None:
    """At most an impact that takes nothing."""
    sol = kn.simulate(ball, (0, 20), q=[2 - high], u=[0], **TIGHT)
    assert sol.mode_history == ((0.0, {"floor": "separated"}),)
    assert len(sol.jumps) == 0 or high == 0.0
    np.testing.assert_allclose(sol["y"], 1 + (1 - high) * np.cos(sol.t), rtol=0, atol=1e-9)


def rod(mu: float = 0.0) -> kn.Equations:
    """Turns about its end, with its tip on a circle of 1 m that a wall at the height h cuts, or nearly does."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    theta = kn.coordinate("theta", "rad")
    m, h, L = kn.parameter("m", 1.0, "kg"), kn.parameter("h", 1.0, "m"), kn.parameter("L", 1.0, "m")
    A = N.rotate("A", theta, N.z)
    I = kn.parameter("I", 1 / 12, "kg*m^2")
    body = kn.RigidBody("rod", frame=A, mass_center=O.at("C", L / 2 * A.x), mass=m, inertia=kn.inertia(A, I, I, I))
    wall = kn.joints.point_on_plane("wall", O.at("tip", L * A.x), O.at("W", h * N.y), normal=-N.y)
    return kn.derive(kn.System(N, bodies=[body], speeds="rates", contacts=[kn.contact(wall, mu, restitution=0.5)]))


def test_a_rod_whose_tip_grazes_a_wall() -> None:
    """sin θ = h with cos θ = √(2 ε), ε = 1 − h: it turns back with half of its speed, from a wall beyond its reach not at all."""
    eom = rod()
    start = {"q": [0.2], "u": [1.0], **TIGHT}
    for deep in DEEP:
        sol = kn.simulate(eom, (0, 4), parameters={"h": 1 - deep}, **start)
        (jump,) = sol.jumps
        assert jump.t == pytest.approx(np.arcsin(1 - deep) - 0.2, abs=1e-15 / np.sqrt(deep) * 8)
        np.testing.assert_allclose(sol["u_theta"][-1], -0.5, rtol=1e-12)
        assert sol["theta"][-1] == pytest.approx(0.2 + jump.t - 0.5 * (4 - jump.t), abs=1e-10)
    for high in DEEP:
        sol = kn.simulate(eom, (0, 4), parameters={"h": 1 + high}, **start)
        assert not sol.events
        assert sol["theta"][-1] == pytest.approx(4.2, abs=1e-12)


def test_a_rod_that_friction_jams_is_named() -> None:
    """Its tip slips only where it opens: the impact stops it, and what it presses with then depends on what yields."""
    eom = rod(0.2)
    for k in range(20):  # whatever rounding leaves of the speed
        sol = kn.simulate(eom, (0, 4), parameters={"h": 1 - 1e-4}, q=[0.2], u=[1.0 + 0.01 * k])
        assert sol.status == "stopped"
        assert "cannot slip without opening" in sol.message
