# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Euler's equations of an axisymmetric disk that slides on a horizontal plane.

Unknown: acceleration a of the mass centre, angular acceleration alpha, normal force N; all vectors have
inertial components, z up. With unit vectors b1 level in the disk's plane, b2 in that plane from the lowest
point to the centre, and d along the axis,

    m a = N (z + f) - m g z                 f = -mu slip / |slip|
    I alpha + w x I w = -R b2 x N (z + f)
    z . a = second derivative of the height h = R sqrt(1 - s^2), s = d . z

where d' = w x d gives s' = z . (w x d) and s'' = z . (alpha x d + w x (w x d)), and with c^2 = 1 - s^2

    h'' = -R (s s''/c + s'^2/c^3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracles.tree import Array, rotation, skew

Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Disk:
    """Mass, radius, gravity, friction, and moments of inertia about the axis and about a diameter."""

    m: float
    R: float
    g: float
    mu: float
    axial: float
    diametral: float


@dataclass(frozen=True, slots=True)
class Motion:
    """What follows at one state."""

    a: Array  # (3,) acceleration of the mass centre
    alpha: Array  # (3,) angular acceleration
    normal: float
    qddot: Array  # (5,)
    speeds: Array  # (5,) w.b1, w.b2, w.b3, q4', q5'
    accelerations: Array  # (5,) derivatives of the speeds
    slip: Array  # (3,) velocity of the contact particle
    energy: float
    friction_power: float
    condition: float


def solve(disk: Disk, q: Array, qdot: Array) -> Motion:
    """Accelerations and normal force at yaw q1, lean q2, spin q3, trace (q4, q5)."""
    yaw, lean, spin = q[:3]
    m, R = disk.m, disk.R
    turn = rotation(Z, yaw) @ rotation((1.0, 0.0, 0.0), np.pi / 2.0 - lean) @ rotation(Z, spin)
    b1 = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    d = turn @ Z
    b2 = np.cross(d, b1)
    frame_omega = qdot[0] * Z - qdot[1] * b1
    omega = frame_omega + qdot[2] * d
    velocity = np.array([qdot[3], qdot[4], 0.0]) + R * np.cross(frame_omega, b2)
    slip = velocity - R * np.cross(omega, b2)
    friction = -disk.mu * slip / np.linalg.norm(slip)

    inertia = turn @ np.diag([disk.diametral, disk.diametral, disk.axial]) @ turn.T
    s, c = d @ Z, np.sqrt(1.0 - (d @ Z) ** 2)
    s_rate = Z @ np.cross(omega, d)
    s_bias = Z @ np.cross(omega, np.cross(omega, d))

    table, right = np.zeros((7, 7)), np.zeros(7)
    table[:3, :3] = m * np.eye(3)
    table[:3, 6] = -(Z + friction)
    right[:3] = -m * disk.g * Z
    table[3:6, 3:6] = inertia
    table[3:6, 6] = np.cross(R * b2, Z + friction)
    right[3:6] = -np.cross(omega, inertia @ omega)
    table[6, :3] = Z
    table[6, 3:6] = R * s / c * np.cross(d, Z)  # z . (alpha x d) = alpha . (d x z)
    right[6] = -R * (s * s_bias / c + s_rate**2 / c**3)
    x = np.linalg.solve(table, right)
    a, alpha, normal = np.asarray(x[:3], dtype=np.float64), np.asarray(x[3:6], dtype=np.float64), float(x[6])

    # w = q1' z - q2' b1 + q3' d, with b1' = q1' z x b1 and d' = frame_omega x d.
    b1_rate = qdot[0] * np.cross(Z, b1)
    d_rate = np.cross(frame_omega, d)
    b2_rate = np.cross(frame_omega, b2)
    angles = np.linalg.solve(np.column_stack([Z, -b1, d]), alpha + qdot[1] * b1_rate - qdot[2] * d_rate)
    frame_alpha = angles[0] * Z - angles[1] * b1 - qdot[1] * b1_rate
    trace = a - R * (skew(frame_alpha) @ b2 + np.cross(frame_omega, b2_rate))

    return Motion(
        a=a,
        alpha=alpha,
        normal=normal,
        qddot=np.array([*angles, trace[0], trace[1]]),
        speeds=np.array([omega @ b1, omega @ b2, omega @ d, qdot[3], qdot[4]]),
        accelerations=np.array(
            [
                alpha @ b1 + omega @ b1_rate,
                alpha @ b2 + omega @ b2_rate,
                alpha @ d + omega @ d_rate,
                trace[0],
                trace[1],
            ]
        ),
        slip=slip,
        energy=float(m * velocity @ velocity / 2.0 + omega @ inertia @ omega / 2.0 + m * disk.g * R * c),
        friction_power=float(normal * friction @ slip),
        condition=float(np.linalg.cond(table)),
    )


def random_disk(rng: np.random.Generator, thin: bool) -> Disk:
    """A disk of generic numbers: thin, or of inertia anywhere between that of a needle and that of a ring."""
    m, R = rng.uniform(0.5, 2.0), rng.uniform(0.2, 1.0)
    axial = 0.5 if thin else rng.uniform(0.2, 1.0)
    diametral = 0.25 if thin else rng.uniform(axial / 2.0, 1.0)
    return Disk(m, R, rng.uniform(5.0, 15.0), rng.uniform(0.05, 0.5), axial * m * R**2, diametral * m * R**2)


def random_states(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Coordinates and rates, each of shape (5, count), short of lying flat."""
    q = rng.uniform(-3.0, 3.0, (5, count))
    q[1] = rng.uniform(-1.2, 1.2, count)
    return q, rng.uniform(-3.0, 3.0, (5, count))
