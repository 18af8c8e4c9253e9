# SPDX-License-Identifier: BSD-3-Clause
"""Generalized active and inertia forces one by one, for reading: by speed and load, by speed and body.

The equations that are solved are assembled in `assemble`, shorter; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Sequence

from kane.dynamics.routes.classical import Moving
from kane.expr.build import add
from kane.expr.node import ZERO, Expr
from kane.kinematics.motion import Kinematics, Motion, acceleration_form
from kane.model.bodies import RigidBody
from kane.model.loads import Load
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def sum_of(terms: Sequence[Expr]) -> Expr:
    """Σ terms."""
    total = ZERO
    for x in terms:
        total = add(total, x)
    return total


Term = tuple[Point | Frame, Vector, Vector]
"""A place, the force on it or torque on it, and the partial velocity or partial angular velocity that it meets."""


def active_terms(kinematics: Kinematics, speed: Expr, load: Load) -> list[Term]:
    """What of one load meets a partial velocity."""
    places: tuple[tuple[Point | Frame, Vector, Motion], ...] = (
        *((p, f, kinematics.point(p)) for p, f in load.forces),
        *((f, t, kinematics.frame(f)) for f, t in load.torques),
    )
    return [(place, x, motion.partials[speed]) for place, x, motion in places if speed in motion.partials]


def inertia_terms(moving: Moving, speed: Expr) -> list[Term]:
    """−m a at the mass centre and −(I·α + ω × I·ω) on the frame of one body, where they meet a partial velocity."""
    body, found = moving.body, list[Term]()
    v = moving.center.partials.get(speed)
    if v is not None:
        found.append((body.mass_center, acceleration_form(moving.center) * -body.mass, v))
    if moving.rotation is not None and isinstance(body, RigidBody):
        w = moving.rotation.partials.get(speed)
        if w is not None:
            found.append((body.frame, -moving.inertia_torque(), w))
    return found


def active(kinematics: Kinematics, speed: Expr, load: Load) -> Expr:
    """F_r of one load: Σ v_r·F + Σ ω_r·T (Kane & Levinson 1985, sec. 4.4)."""
    return sum_of([partial.dot(x) for _, x, partial in active_terms(kinematics, speed, load)])


def inertia(moving: Moving, speed: Expr) -> Expr:
    """F*_r of one body: v_r·(−m a) + ω_r·(−I·α − ω × I·ω) (Kane & Levinson 1985, sec. 4.11)."""
    return sum_of([partial.dot(x) for _, x, partial in inertia_terms(moving, speed)])
