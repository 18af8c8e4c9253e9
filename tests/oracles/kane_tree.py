# SPDX-License-Identifier: BSD-3-Clause
"""The same tree declared to kane, each coordinate's rate being its speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import kane as kn
from tests.oracles.tree import Array, Tree, Triple


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """The equations, with frames, origins and mass centres body by body."""

    eom: kn.Equations
    coordinates: tuple[kn.Coordinate, ...]
    inertial: kn.Frame
    frames: tuple[kn.Frame, ...]
    centers: tuple[kn.Point, ...]

    @property
    def order(self) -> list[int]:
        """The tree's number of each coordinate, in the order of the equations; speeds have the same order."""
        number = {q: k for k, q in enumerate(self.coordinates)}
        return [number[q] for q in self.eom.coordinates]

    def evaluate(self, exprs: Any, q: Array, qdot: Array) -> Array:
        """Values of shape (expressions, states) at q and qdot of shape (degrees of freedom, states)."""
        order = self.order
        values = self.eom.evaluate(
            list(exprs),
            q={symbol: q[k] for symbol, k in zip(self.eom.coordinates, order, strict=True)},
            u={symbol: qdot[k] for symbol, k in zip(self.eom.speeds, order, strict=True)},
        )
        return np.array([np.broadcast_to(value, q.shape[1:]) for value in values])

    def accelerations(self, q: Array, qdot: Array) -> Array:
        """Second derivatives of the coordinates in the tree's order, (degrees of freedom, states)."""
        found = np.empty_like(q)
        found[self.order] = self.evaluate(self.eom.accelerations, q, qdot)
        return found

    def mass_matrix(self, q: Array, qdot: Array) -> Array:
        """Mass matrices in the tree's order, of shape (states, degrees of freedom, degrees of freedom)."""
        n = len(self.coordinates)
        entries = [self.eom.mass_matrix[i, j] for i in range(n) for j in range(n)]
        table = np.moveaxis(self.evaluate(entries, q, qdot).reshape(n, n, -1), 2, 0)
        found = np.empty_like(table)
        found[np.ix_(range(len(table)), self.order, self.order)] = table
        return found


def vector(frame: kn.Frame, v: Triple) -> kn.Vector:
    """The vector with these components along the frame's axes."""
    return v[0] * frame.x + v[1] * frame.y + v[2] * frame.z


def derive(tree: Tree) -> Model:
    """Kane's equations of the tree."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    coordinates = kn.coordinates(f"q1:{tree.size + 1}")
    unused = iter(coordinates)
    frames: list[kn.Frame] = []
    origins: list[kn.Point] = []
    bodies: list[kn.RigidBody] = []
    loads: list[Any] = [kn.gravity(vector(N, tree.gravity))] if any(tree.gravity) else []
    for i, body in enumerate(tree.bodies):
        frame, origin = (N, O) if body.parent < 0 else (frames[body.parent], origins[body.parent])
        origin = origin.at(f"J{i}", vector(frame, body.offset))
        frame = frame.rotate_matrix(f"J{i}", body.tilt)
        for k, step in enumerate(body.steps):
            axis, coordinate = vector(frame, step.axis), next(unused)
            if step.kind == "slide":
                origin = origin.at(f"P{i}{k}", coordinate * axis)
            else:
                frame = frame.rotate(f"B{i}{k}", coordinate, axis)
        (xx, xy, zx), (_, yy, yz), (_, _, zz) = body.inertia
        bodies.append(
            kn.RigidBody(
                f"B{i}",
                frame=frame,
                mass_center=origin.at(f"B{i}*", vector(frame, body.center)),
                mass=kn.parameter(f"m{i}", body.mass, "kg"),
                inertia=kn.inertia(frame, xx, yy, zz, xy, yz, zx),
            )
        )
        if body.force is not None:
            loads.append(kn.Force(origin.at(f"F{i}", vector(frame, body.load_point)), vector(N, body.force)))
        if body.torque is not None:
            loads.append(kn.Torque(frame, vector(N, body.torque)))
        frames.append(frame)
        origins.append(origin)
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads))
    return Model(eom, coordinates, N, tuple(frames), tuple(body.mass_center for body in bodies))
