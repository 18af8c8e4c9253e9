# SPDX-License-Identifier: BSD-3-Clause
"""The rates by which flexible bodies deform, and the loads on these alone: forces on gauges, torques on frames of sections.

A point that moves along inertial axes by such rates has partial velocities for them alone: what acts on it is a generalized force, and
no segment of the tree.
"""

from collections.abc import Sequence

from kane.dynamics.derivation import Derived
from kane.expr.build import add
from kane.expr.differentiation import time_derivative
from kane.expr.linear_parts import affine_forms
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.model.bodies import deforming
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import Triple
from kane.space.spatial import triple
from kane.space.vector import Vector, angular_velocity


def shared_rates(derived: Derived) -> tuple[Expr, ...]:
    """The rates by which flexible bodies deform."""
    return tuple(rate for body in deforming(derived.system.bodies) for rate in body.speeds.values())


def bent_frames(derived: Derived) -> list[Frame]:
    """The frames of torques that turn by deformation alone in the frame before: links for them are between others."""
    rates = shared_rates(derived)
    frames = dict.fromkeys(f for load in derived.declared_loads for f, _ in load.torques) if rates else {}
    return [f for f in frames if f.parent is not None and _by_deformation(_turning(f, f.parent), rates)]


def _turning(frame: Frame, base: Frame) -> Triple:
    return triple(angular_velocity(frame, base).components(base))


def _by_deformation(moved: Sequence[Expr], rates: Sequence[Expr]) -> bool:
    forms = affine_forms(moved, rates)
    return any(row for row, _ in forms) and all(rest is ZERO for _, rest in forms)


def gauged(derived: Derived) -> tuple[list[tuple[Point, Vector]], dict[Expr, Expr]]:
    """The forces of the loads, without those on points that move by the deformation alone; these as generalized forces on rates."""
    forces = [x for load in derived.declared_loads for x in load.forces]
    rates, aligned = shared_rates(derived), derived.kinematics.aligned
    if not rates:
        return forces, {}
    kept, on = [], dict[Expr, Expr]()
    for point, force in forces:
        columns = _columns(derived, point, rates)
        if columns is None:
            kept.append((point, force))
            continue
        for b, v in columns.items():
            on[b] = add(on.get(b, ZERO), dot(aligned.vector(force).components(derived.system.inertial), v))
    return kept, on


def _columns(derived: Derived, point: Point, rates: Sequence[Expr]) -> dict[Expr, Triple] | None:
    """The partial velocities of a point that moves along inertial axes by rates of deformation alone; None for others."""
    parent, inertial = point.parent, derived.system.inertial
    if point.body is not None or parent is None or parent.parent is not None:
        return None
    if any(f is not inertial for f, _ in point.offset.parts):
        return None
    moved = [time_derivative(x) for _, v in point.offset.parts for x in v]
    if len(moved) != 3 or not _by_deformation(moved, rates):
        return None
    forms = affine_forms(moved, rates)
    return {b: triple(row.get(b, ZERO) for row, _ in forms) for b in {b: None for row, _ in forms for b in row}}
