# SPDX-License-Identifier: BSD-3-Clause
"""Models of *Learn Multibody Dynamics* (Moore 2022) against second routes, to 1e-12: by hand in NumPy, or by other methods."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import car_with_trailer, chaplygin_sleigh, four_bar, snakeboard
from tests.laws.test_methods import numbers, states

CLOSE = 1e-12
g, l1, l2, m1, m2 = 9.81, 0.7, 1.1, 0.9, 0.4


def double_pendulum():
    """Two particles on strings, with the tensions in evidence."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1 q2")
    u1, u2 = kn.speeds("u1 u2")
    A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
    P = O.at("P", -l1 * A.y)
    Q = P.at("Q", -l2 * B.y)
    tensions = [kn.reaction("T1", at=P, along=A.y), kn.reaction("T2", at=Q, along=B.y)]
    return kn.System(
        N,
        bodies=[kn.Particle("P", P, m1), kn.Particle("Q", Q, m2)],
        speeds={u1: q1.dt, u2: q2.dt},
        loads=[kn.gravity(-g * N.y)],
        reactions=tensions,
        coordinates=(q1, q2),
    )


@pytest.mark.parametrize("seed", range(10))
def test_tensions_are_those_of_newton(seed):
    """m a = T e + m g of each particle, a by its string: four equations for θ̈₁, θ̈₂, T₁, T₂."""
    eom = kn.derive(double_pendulum())
    q, u = np.random.default_rng(seed).uniform(-1, 1, (2, 2))
    along = [np.array([-np.sin(x), np.cos(x)]) for x in q]  # up the string
    across = [np.array([np.cos(x), np.sin(x)]) for x in q]
    sides = np.zeros((4, 4))
    right = np.zeros(4)
    fall = np.array([0.0, -g])
    sides[:2, 0] = m1 * l1 * across[0]
    sides[:2, 2], sides[:2, 3] = -along[0], along[1]
    right[:2] = m1 * (fall - l1 * u[0] ** 2 * along[0])
    sides[2:, 0], sides[2:, 1] = m2 * l1 * across[0], m2 * l2 * across[1]
    sides[2:, 3] = -along[1]
    right[2:] = m2 * (fall - l1 * u[0] ** 2 * along[0] - l2 * u[1] ** 2 * along[1])
    expected = np.linalg.solve(sides, right)
    found = eom.evaluate([*eom.accelerations, *eom.reaction_values], q=q, u=u)
    assert np.ravel(found) == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


def jumper():
    """Foot on springy ground, lower and upper leg, a torso above the hip, a muscle's torque at the knee."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, q1, q2 = kn.coordinates("x y q1 q2")
    u = kn.speeds("u1:5")
    k, c, L, T = 1e3, 5.0, 0.4, kn.input("T")
    A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
    foot = O.at("foot", x * N.x + y * N.y)
    knee = foot.at("knee", L * A.y)
    hip = knee.at("hip", L * B.y)
    bodies = [
        kn.RigidBody(
            "lower", frame=A, mass_center=foot.at("A*", L / 2 * A.y), mass=3.0, inertia=kn.inertia(A, 0, 0, 0.05)
        ),
        kn.RigidBody(
            "upper", frame=B, mass_center=knee.at("B*", L / 2 * B.y), mass=7.0, inertia=kn.inertia(B, 0, 0, 0.1)
        ),
        kn.Particle("torso", hip, 40.0),
    ]
    ground = kn.Force(foot, -k * y * N.y - c * foot.velocity(N))
    muscle = (kn.Torque(B, T * N.z), kn.Torque(A, -T * N.z))
    return kn.System(
        N,
        bodies=bodies,
        speeds={u[0]: foot.velocity(N).dot(A.x), u[1]: foot.velocity(N).dot(A.y), u[2]: q1.dt, u[3]: q2.dt - q1.dt},
        loads=[kn.gravity(-g * N.y), ground, *muscle],
        coordinates=(x, y, q1, q2),
    )


def rolling_sphere():
    """A sphere that rolls on a plane under a force at its centre, by angles."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, *angles = kn.coordinates("x y a b c")
    u = kn.speeds("u1:6")
    r, m = 0.3, 2.0
    B = N.rotate_body("B", angles, "zyx")
    C = O.at("C", x * N.x + y * N.y + r * N.z)
    ball = kn.RigidBody("ball", frame=B, mass_center=C, mass=m, inertia=kn.solid_sphere(B, m, r))
    w = B.angular_velocity(N)
    return kn.System(
        N,
        bodies=[ball],
        speeds={u[0]: w.dot(N.x), u[1]: w.dot(N.y), u[2]: w.dot(N.z), u[3]: x.dt, u[4]: y.dt},
        loads=[kn.Force(C, kn.input("F_x") * N.x + kn.input("F_y") * N.y)],
        nonholonomic=kn.rolling(C.fixed_in(B, "C^", -r * N.z), normal=N.z)[:2],
        coordinates=(x, y, *angles),
    )


MODELS = {
    "rolling sphere": rolling_sphere,
    "vehicle": car_with_trailer.system,
    "sleigh": chaplygin_sleigh.system,
    "four-bar": four_bar.system,
    "snakeboard": snakeboard.system,
    "jumper": jumper,
}


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_models_by_newton_and_euler_and_by_lagrange(model):
    eom = kn.derive(MODELS[model]())
    at = states(eom, 20)
    wanted = numbers(eom.by("newton-euler").accelerations, at)
    size = np.maximum(1, np.abs(wanted).max(axis=0))
    for found in (eom.accelerations, eom.by("lagrange").accelerations):
        assert (np.abs(numbers(found, at) - wanted).max(axis=0) <= CLOSE * size).all()


def test_sphere_rolls_with_five_sevenths():
    """ẍ = 5 F/7 m, as a sphere's inertia carries two sevenths."""
    eom = kn.derive(rolling_sphere())
    at = states(eom, 5) | dict(zip(eom.inputs, (0.7, -0.2), strict=True))
    found = numbers(eom.accelerations, at)
    assert found[3:] == pytest.approx(np.array([[0.25], [-0.2 * 5 / 14]]) * np.ones(5), rel=CLOSE)
