# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Euler's equations of a tree in redundant coordinates, as one square linear system.

Unknown for each body: acceleration a of its mass centre, angular acceleration alpha, and the force f and
torque t (about the body's origin) that its joint exerts on it; and for each step its coordinate's second
derivative. Everything is in the inertial frame. Equations: Newton's and Euler's for each body; each body's
accelerations from its parent's through the steps of the joint; and no force or torque of the joint along its
free directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracles.tree import Array, Tree, rotation, skew


@dataclass(frozen=True, slots=True)
class Motion:
    """What the system of equations yields at one state."""

    qddot: Array  # (degrees of freedom,)
    a: Array  # (bodies, 3) acceleration of mass centres
    alpha: Array  # (bodies, 3) angular accelerations
    force: Array  # (bodies, 3) force of the joint on the body
    torque: Array  # (bodies, 3) torque of the joint on the body, about the body's origin
    mass_matrix: Array  # (degrees of freedom, degrees of freedom), speeds are the rates
    condition: float  # of the redundant system
    kinetic: float
    potential: float  # of gravity, from the inertial origin
    power: float  # of the external forces and torques


def solve(tree: Tree, q: Array, qdot: Array) -> Motion:
    """Accelerations and joint reactions of the tree at one state."""
    n, size = len(tree.bodies), tree.size
    total = 12 * n + size

    def column(start: int) -> Array:
        """Three unknowns as rows over [all unknowns, 1]."""
        rows = np.zeros((3, total + 1))
        rows[:, start : start + 3] = np.eye(3)
        return rows

    a = [column(6 * i) for i in range(n)]
    alpha = [column(6 * i + 3) for i in range(n)]
    force = [column(6 * n + size + 6 * i) for i in range(n)]
    torque = [column(6 * n + size + 6 * i + 3) for i in range(n)]
    gravity = np.array(tree.gravity)

    kinematic: list[Array] = []
    free: list[Array] = []
    turns: list[Array] = []
    origins: list[Array] = []
    centers: list[Array] = []
    omegas: list[Array] = []
    k = 0
    for i, body in enumerate(tree.bodies):
        if body.parent < 0:
            turn, origin, center, omega = np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3)
            accel, angular = np.zeros((3, total + 1)), np.zeros((3, total + 1))
        else:
            p = body.parent
            turn, origin, center, omega = turns[p], origins[p], centers[p], omegas[p]
            accel, angular = a[p].copy(), alpha[p].copy()
        point = origin + turn @ body.offset
        arm = point - center
        accel -= skew(arm) @ angular
        accel[:, -1] += np.cross(omega, np.cross(omega, arm))
        turn = turn @ np.array(body.tilt)
        axes: list[tuple[str, Array, Array]] = []
        for step in body.steps:
            axis = turn @ step.axis
            rate, second = qdot[k], 6 * n + k
            axes.append((step.kind, axis, point))
            if step.kind == "slide":
                shift = q[k] * axis
                accel -= skew(shift) @ angular
                accel[:, -1] += np.cross(omega, np.cross(omega, shift)) + 2.0 * rate * np.cross(omega, axis)
                accel[:, second] += axis
                point = point + shift
            else:
                angular[:, -1] += rate * np.cross(omega, axis)
                angular[:, second] += axis
                omega = omega + rate * axis
                turn = turn @ rotation(step.axis, q[k])
            k += 1
        arm = turn @ body.center
        accel -= skew(arm) @ angular
        accel[:, -1] += np.cross(omega, np.cross(omega, arm))
        kinematic += [a[i] - accel, alpha[i] - angular]
        for kind, axis, passes in axes:
            moment = torque[i] + skew(point - passes) @ force[i]
            free.append((axis @ (force[i] if kind == "slide" else moment))[None])
        turns.append(turn)
        origins.append(point)
        centers.append(point + arm)
        omegas.append(omega)

    newton, euler, inertias, forces, torques = [], [], [], [], []
    for i, body in enumerate(tree.bodies):
        inertia = turns[i] @ np.array(body.inertia) @ turns[i].T
        inertias.append(inertia)
        outer_force = np.zeros(3) if body.force is None else np.array(body.force)
        outer_torque = np.zeros(3) if body.torque is None else np.array(body.torque)
        outer_torque += np.cross(origins[i] + turns[i] @ body.load_point - centers[i], outer_force)
        forces.append(outer_force)
        torques.append(outer_torque)
        linear = body.mass * a[i] - force[i]
        angular = inertia @ alpha[i] - torque[i] - skew(origins[i] - centers[i]) @ force[i]
        for j, child in enumerate(tree.bodies):
            if child.parent == i:
                linear += force[j]
                angular += torque[j] + skew(origins[j] - centers[i]) @ force[j]
        linear[:, -1] -= outer_force + body.mass * gravity
        angular[:, -1] += np.cross(omegas[i], inertia @ omegas[i]) - outer_torque
        newton.append(linear)
        euler.append(angular)

    table = np.concatenate(kinematic + free + newton + euler)
    x = np.linalg.solve(table[:, :-1], -table[:, -1])

    rows = np.concatenate(kinematic)
    jacobian = np.linalg.solve(rows[:, : 6 * n], -rows[:, 6 * n : 6 * n + size])
    mass_matrix = np.zeros((size, size))
    power, potential = 0.0, 0.0
    for i, body in enumerate(tree.bodies):
        v, w = jacobian[6 * i : 6 * i + 3], jacobian[6 * i + 3 : 6 * i + 6]
        mass_matrix += body.mass * v.T @ v + w.T @ inertias[i] @ w
        power += float(forces[i] @ v @ qdot + torques[i] @ omegas[i])
        potential -= float(body.mass * gravity @ centers[i])

    motions = x[: 6 * n].reshape(n, 2, 3)
    reactions = x[6 * n + size :].reshape(n, 2, 3)
    return Motion(
        qddot=x[6 * n : 6 * n + size],
        a=motions[:, 0],
        alpha=motions[:, 1],
        force=reactions[:, 0],
        torque=reactions[:, 1],
        mass_matrix=mass_matrix,
        condition=float(np.linalg.cond(table[:, :-1])),
        kinetic=float(qdot @ mass_matrix @ qdot / 2.0),
        potential=potential,
        power=power,
    )
