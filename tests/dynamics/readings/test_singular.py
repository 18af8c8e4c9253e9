# SPDX-License-Identifier: BSD-3-Clause
"""Numbers where W does not exist: none that are finite and meaningless, in any language; what does not use W stays."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2 = q = kn.coordinates("q1 q2")
u = kn.speeds("u1 u2")


def universal(first="x"):
    """A body on a universal joint, by components of its angular velocity: ω_x = q1' cos q2 has no q1' at q2 = π/2, ω_z none at 0."""
    B = N.rotate("A", q1, N.x).rotate("B", q2, N.rotate("A", q1, N.x).y)
    center = O.at("G", 0.3 * B.z + 0.1 * B.x)
    body = kn.RigidBody("b", frame=B, mass_center=center, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    w = B.angular_velocity(N)
    speeds = dict(zip(u, (w.dot(getattr(B, first)), w.dot(B.y)), strict=True))
    return kn.derive(kn.System(N, bodies=[body], speeds=speeds, loads=[kn.gravity(-9.81 * N.z)]))


@pytest.mark.parametrize(
    ("first", "at", "pivot"), [("x", np.pi / 2, "cos"), ("x", -np.pi / 2, "cos"), ("z", np.pi, "sin")]
)
@pytest.mark.parametrize("speed", [0.0, 0.4])
def test_a_universal_joint_where_a_component_says_nothing(first, at, pivot, speed):
    eom = universal(first)
    state = {"q": [0.3, at], "u": [speed, 0.5]}
    message = rf"Expected speeds that determine the rates at this state, got W of q' = W u \+ X divided by {pivot}\(q2\) = .*Euler"
    for what in (eom.accelerations, eom.rates, q1.dt):
        with pytest.raises(kn.SingularError, match=message):
            eom.evaluate(what, **state)
    np.testing.assert_allclose(eom.evaluate([eom.rates[1], kn.sin(q1)], **state), [0.5, np.sin(0.3)])


def test_of_arrays_the_values_are_nan_there_and_a_warning_names_the_first():
    eom = universal()
    with pytest.warns(
        kn.KaneWarning, match=r"at every state, got .*cos\(q2\) = 6\.12e-17 at index 1: the values there are NaN"
    ):
        found = eom.evaluate(eom.rates[0], q=[[0.3, 0.3, 0.3], [0.0, np.pi / 2, 1.0]], u=[0.4, 0.5])
    np.testing.assert_allclose(found, [0.4, np.nan, 0.4 / np.cos(1.0)])


def test_compiled_code_says_so():
    eom = universal()
    rhs = kn.compile(eom).rhs
    state = np.array([0.3, np.pi / 2, 0.4, 0.5])
    with pytest.warns(kn.KaneWarning, match=r"W of q' = W u \+ X gives divided by cos\(q2\)"):
        found = rhs(0.0, state, np.zeros(0))
    assert np.isnan(found[[0, 2]]).all()


@pytest.mark.parametrize("near", [1e-3, 1e-6, 1e-9])
def test_beside_it_the_numbers_are_those_of_angle_rates(near):
    """q1' and q2' as speeds know no such place: q̈ by both are the same, to the digits that 1/cos leaves."""
    eom = universal()
    rates = kn.derive(eom.system.replace(speeds="rates"))
    at = np.pi / 2 - near
    w = {"q": [0.3, at], "u": [0.7 * np.cos(at), 0.5]}
    second = eom.evaluate([q1.dt.dt, q2.dt.dt], **w)
    expected = rates.evaluate(rates.accelerations, q=[0.3, at], u=[0.7, 0.5])
    np.testing.assert_allclose(second, expected, rtol=1e-13 / near)


def test_accelerations_that_use_no_w_are_right_at_gimbal_lock():
    angles = kn.coordinates("a1:4")
    B = N.rotate_body("B", angles, "zyx")
    body = kn.RigidBody("b", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    w = B.angular_velocity(N)
    v = kn.speeds("v1:4")
    eom = kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(v, (w.dot(B.x), w.dot(B.y), w.dot(B.z)), strict=True))))
    found = eom.evaluate(eom.accelerations, q=[0.2, np.pi / 2, 0.4], u=[1, 2, 3])
    np.testing.assert_allclose(found, [-6.0, 3.0, -2 / 3])
