# SPDX-License-Identifier: BSD-3-Clause
"""Generalized active and inertia forces one by one, for reading: by speed and load, by speed and body.

The equations that are solved are assembled in `assemble`, shorter; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Sequence

from kane.dynamics.assemble import Moving
from kane.expr.build import add
from kane.expr.node import ZERO, Expr
from kane.kinematics.motion import Kinematics, acceleration_form
from kane.model.loads import Load


def sum_of(terms: Sequence[Expr]) -> Expr:
    """Σ terms."""
    total = ZERO
    for x in terms:
        total = add(total, x)
    return total


def active(kinematics: Kinematics, speed: Expr, load: Load) -> Expr:
    """F_r of one load: Σ v_r·F + Σ ω_r·T (Kane & Levinson 1985, sec. 4.4)."""
    total = ZERO
    for point, f in load.forces:
        v = kinematics.point(point).partials.get(speed)
        if v is not None:
            total = add(total, v.dot(f))
    for frame, t in load.torques:
        w = kinematics.frame(frame).partials.get(speed)
        if w is not None:
            total = add(total, w.dot(t))
    return total


def inertia(moving: Moving, speed: Expr) -> Expr:
    """F*_r of one body: v_r·(−m a) + ω_r·(−I·α − ω × I·ω) (Kane & Levinson 1985, sec. 4.11)."""
    total = ZERO
    v = moving.center.partials.get(speed)
    if v is not None:
        total = add(total, v.dot(acceleration_form(moving.center) * -moving.body.mass))
    if moving.rotation is not None and moving.inertia is not None:
        w = moving.rotation.partials.get(speed)
        if w is not None:
            spin = moving.rotation.total.express(moving.inertia.frame)
            torque = moving.inertia.times(acceleration_form(moving.rotation)) + spin.cross(moving.inertia.times(spin))
            total = add(total, w.dot(-torque))
    return total
