# SPDX-License-Identifier: BSD-3-Clause
"""Events that no model declares: loss of contact, singular kinematics."""

import numpy as np
import pytest

import kane as kn


def block(slope_of_pull: float = 1.0, along: float = 1.0):
    """A block on the ground with sliding friction, lifted by a pull that grows with time."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    R = kn.reaction("R", at=P, along=along * N.y)
    loads = [
        kn.gravity(-10 * N.y),
        kn.friction(P, R, 0.2, name="friction"),
        kn.Force(P, slope_of_pull * kn.time * N.y, name="pull"),
    ]
    return kn.derive(kn.System(N, bodies=[kn.Particle("block", P, 2)], speeds="rates", loads=loads, reactions=[R])), R


def test_contact_is_lost_where_the_normal_force_vanishes():
    """R = m g − pull t = 20 − 4 t vanishes at t = 5 s; the block still slides then."""
    eom, R = block(4.0)
    sol = kn.simulate(eom, (0, 10), q=[0], u=[30])
    assert sol.status == "event"
    assert sol.event is not None
    assert sol.event.name == "contact lost (R = 0)"
    np.testing.assert_allclose(sol.t[-1], 5.0, rtol=1e-9)
    np.testing.assert_allclose(sol[R], 20 - 4 * sol.t, atol=1e-9)


def test_a_reaction_that_presses_where_it_is_negative_is_told_to_turn_round():
    eom, _ = block(along=-1.0)
    with pytest.raises(kn.SimulationError, match="declare the reaction along the opposite direction"):
        kn.simulate(eom, (0, 1), q=[0], u=[1])


def test_a_pivot_of_W_through_zero_ends_the_motion():
    """Body-fixed zxz angles, turning about the middle axis at 1 rad/s from 0.5 rad: sin vanishes at t = 0.5 s."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a, b, c = kn.coordinates("a b c")
    u1, u2, u3 = kn.speeds("u1:4")
    B = N.rotate_body("B", (a, b, c), "zxz")
    w = B.angular_velocity(N)
    body = kn.RigidBody("b", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    eom = kn.derive(
        kn.System(N, bodies=[body], speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)}, coordinates=(a, b, c))
    )
    assert [str(e) for e in eom.accelerations] == ["-u2*u3", "u1*u3", "-u1*u2/3"]  # Euler's equations
    sol = kn.simulate(eom, (0, 10), q=[0, 0.5, 0], u=[-1, 0, 0])
    assert sol.status == "event"
    assert sol.event is not None
    assert "sin(b)" in sol.event.name
    np.testing.assert_allclose(sol.t[-1], 0.5, rtol=1e-9)
