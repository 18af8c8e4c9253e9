# SPDX-License-Identifier: BSD-3-Clause
"""The same tree as a Pinocchio model: each step is a joint; all but a body's last carry no mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from tests.oracles.tree import Array, Tree


@dataclass(frozen=True, slots=True)
class Motion:
    """Accelerations by a dense solve of M qddot = f, and the wrench of each body's joint."""

    qddot: Array  # (degrees of freedom,)
    force: Array  # (bodies, 3) force of the joint on the body, inertial components
    torque: Array  # (bodies, 3) its torque about the body's origin
    mass_matrix: Array
    condition: float  # of the mass matrix


def model_of(tree: Tree) -> tuple[pin.Model, dict[int, int], list[int]]:
    """The model, the joint that carries each body, and the model's number of each of the tree's coordinates.

    Pinocchio's algorithms take a subtree's columns as contiguous, so joints are added depth first.
    """
    model = pin.Model()
    model.gravity = pin.Motion(np.array(tree.gravity), np.zeros(3))
    kinds = {"slide": pin.JointModelPrismaticUnaligned, "turn": pin.JointModelRevoluteUnaligned}
    joints: dict[int, int] = {-1: 0}
    numbers: dict[tuple[int, int], int] = {}

    def add(i: int) -> None:
        body = tree.bodies[i]
        joint = joints[body.parent]
        placement = pin.SE3(np.array(body.tilt), np.array(body.offset))
        for k, step in enumerate(body.steps):
            joint = model.addJoint(joint, kinds[step.kind](np.array(step.axis)), placement, f"{i}.{k}")
            placement = pin.SE3.Identity()
            numbers[i, k] = model.joints[joint].idx_v
        inertia = pin.Inertia(body.mass, np.array(body.center), np.array(body.inertia))
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        joints[i] = joint
        below(i)

    def below(parent: int) -> None:
        for i, body in enumerate(tree.bodies):
            if body.parent == parent:
                add(i)

    below(-1)
    return model, joints, [numbers[key] for key in sorted(numbers)]


def solve(tree: Tree, q: Array, qdot: Array) -> Motion:
    """Accelerations, mass matrix and reactions of the tree at one state."""
    model, carriers, order = model_of(tree)
    joints = [carriers[i] for i in range(len(tree.bodies))]
    place = np.empty(tree.size)
    speed = np.empty(tree.size)
    place[order], speed[order] = q, qdot
    data = model.createData()
    pin.forwardKinematics(model, data, place)
    turns = [data.oMi[j].rotation.copy() for j in joints]
    outer = [pin.Force.Zero() for _ in range(model.njoints)]
    for body, j, turn in zip(tree.bodies, joints, turns, strict=True):
        force = turn.T @ (np.zeros(3) if body.force is None else body.force)
        torque = turn.T @ (np.zeros(3) if body.torque is None else body.torque)
        outer[j] = pin.Force(force, torque + np.cross(body.load_point, force))
    upper = np.triu(pin.crba(model, data, place))
    mass_matrix = upper + np.triu(upper, 1).T
    qddot = np.linalg.solve(mass_matrix, -pin.rnea(model, data, place, speed, np.zeros(tree.size), outer))
    pin.rnea(model, data, place, speed, qddot, outer)
    return Motion(
        qddot=qddot[order],
        force=np.array([turn @ data.f[j].linear for j, turn in zip(joints, turns, strict=True)]),
        torque=np.array([turn @ data.f[j].angular for j, turn in zip(joints, turns, strict=True)]),
        mass_matrix=mass_matrix[np.ix_(order, order)],
        condition=float(np.linalg.cond(mass_matrix)),
    )
