# SPDX-License-Identifier: BSD-3-Clause
"""Whole angular velocities as speeds, link after link: W has two blocks a link, without a divisor, and recursion takes it."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.kinematics import generalized_speeds


def balls(n, axes, pins=False, offset=0):
    """A chain of bodies on ball joints; the speeds are components of ω along N, along the body, or along the one before."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, frame, bodies, speeds = kn.Point("O", fixed_in=N), N, [], {}
    for i in range(1, n + 1):
        before = frame
        if pins and i > 1:
            before = frame.rotate(f"A{i}", kn.coordinate(f"q{i}"), frame.x)
            bodies.append(kn.Particle(f"p{i}", at.at(f"R{i}", 0.3 * before.z), 0.5))
            at = at.at(f"Q{i}", 0.2 * before.y)
            speeds[kn.speed(f"v{i}")] = kn.coordinate(f"q{i}").dt
        B = before.rotate_euler_parameters(f"B{i}", kn.coordinates(f"e{i}_0:4"))
        along = {"N": N, "own": B, "before": before}[axes]
        w = B.angular_velocity(N)
        names = kn.speeds(f"u{i}_1:4")
        speeds |= {u: w.dot(x) + offset for u, x in zip(names, (along.x, along.y, along.z), strict=True)}
        center = at.at(f"C{i}", 0.1 * B.x - 0.5 * B.z)
        inertia = kn.inertia(B, 0.1, 0.2, 0.15, 0.01)
        bodies.append(kn.RigidBody(f"b{i}", frame=B, mass_center=center, mass=1.0, inertia=inertia))
        at, frame = at.at(f"P{i}", -1 * B.z), B
    return kn.System(N, bodies=bodies, speeds=speeds, loads=[kn.gravity(-g * N.z)])


def state(eom, rng):
    """Coordinates with unit Euler parameters, and speeds."""
    q = dict(zip(eom.coordinates, rng.normal(size=len(eom.coordinates)), strict=True))
    for group in eom.system.euler_parameters:
        length = np.linalg.norm([q[e] for e in group.coordinates])
        q |= {e: q[e] / length for e in group.coordinates}
    return {"q": list(q.values()), "u": rng.normal(size=len(eom.speeds))}


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["N", "own", "before"])
@pytest.mark.parametrize("pins", [False, True])
def test_rates_give_back_the_speeds_and_routes_agree(axes, pins, rng):
    system = balls(3, axes, pins, offset=0.3)
    usual, own = (kn.derive(system, route=route) for route in ("classical", "recursive"))
    at = state(usual, rng)
    rates = np.array(usual.evaluate(list(usual.rates), **at), dtype=float)
    y, z = (np.array(usual.evaluate(x, **at), dtype=float) for x in (usual.Y, list(usual.z)))
    assert y @ rates + z == pytest.approx([*at["u"], 0, 0, 0], abs=1e-12)
    a, b = (np.array(e.evaluate(list(e.accelerations), **at), dtype=float) for e in (usual, own))
    np.testing.assert_allclose(b, a, rtol=1e-11, atol=1e-12 * np.abs(a).max())


@pytest.mark.parametrize("axes", ["N", "own", "before"])
def test_w_holds_the_speeds_of_two_links_and_divides_by_nothing(axes):
    speeds = generalized_speeds(balls(6, axes))
    assert speeds.pivots == ()
    assert max(len(row) for row in speeds.inverse.values()) <= 6


@pytest.mark.parametrize(("axes", "most"), [("N", 640), ("own", 480)])
def test_recursion_grows_by_the_same_for_every_link(axes, most):
    """Six links by components along N had poles of W, by those along the bodies they took 6,546 operations."""
    few, more, many = (kn.derive(balls(n, axes), route="recursive").operations.total for n in (4, 5, 6))
    assert many - more <= most
    assert many - more <= 1.02 * (more - few)


def test_what_is_no_angular_velocity_stays_as_it_is():
    """A factor of 2 on what is measured along N: the rows are no direction cosines."""
    system = balls(3, "N")
    speeds = generalized_speeds(system.redefined({u: 2 * x for u, x in system.speeds.items()}))
    assert speeds.pivots != ()


@pytest.mark.slow
def test_many_turns_one_after_the_other_move_mass():
    """Euler parameters that are not of unit length scale what they turn, by as many factors as there are links."""
    assert kn.derive(balls(16, "N"), route="recursive").route == "recursive"


@pytest.mark.slow
def test_many_turns_one_after_the_other_move_mass_on_the_classical_route():
    assert kn.derive(balls(16, "N"), route="classical").route == "classical"
