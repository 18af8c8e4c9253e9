# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that turn about a point at rest, with their inertia about it.

With ṽ_r = ω̃_r × r from a point O of the body that is at rest, or that constraints hold there,

    m ṽ_r·a + ω̃_r·(I·α + ω × I·ω) = ω̃_r·(I_O·α + ω × I_O·ω),   I_O = I + m (r² 1 − r r)

(Kane & Levinson 1985, sec. 3.3): the mass centre brings its weight alone, and I_O is a matter of parameters.
"""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.bodies import Moving, Turning
from kane.expr.build import add, mul, neg
from kane.expr.collect import collected
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed
from kane.kinematics.motion import Kinematics
from kane.model.bodies import Part
from kane.space.point import Point
from kane.space.rotation import Cosines, Triple
from kane.space.vector import Vector

Bodies = tuple[Moving, ...]


def about_points_at_rest(bodies: Sequence[Moving], kinematics: Kinematics) -> tuple[Bodies, Bodies] | None:
    """The bodies as M has them, and as f has them; None where none turns about a point at rest."""
    inertial, forced, some = [], [], False
    for m in bodies:
        turning = _turning(m, kinematics)
        if turning is not None:
            some = True
            inertial.append(m._replace(center=replace(m.center, partials={}), rotation=turning))
            forced.append(m._replace(center=replace(m.center, bias=Vector()), rotation=turning))
        else:
            inertial.append(m)
            forced.append(m)
    return (tuple(inertial), tuple(forced)) if some else None


def _turning(m: Moving, kinematics: Kinematics) -> Turning | None:
    """The rotation with the inertia about a point of the body at rest."""
    turning, arm = m.rotation, _arm(m.part, kinematics)
    if turning is None or arm is None or _rests(m.part.mass_center, kinematics):
        return None
    inertia = turning.inertia
    r = arm.components(inertia.frame)
    if not is_constant_in_time(r):
        return None
    whole = replace(inertia, rows=_shifted(inertia.rows, m.part.mass, r))
    return turning._replace(inertia=whole, bias=whole.torque(turning.motion, turning.motion.bias))


def _shifted(rows: Cosines, mass: Expr, r: Triple) -> Cosines:
    """I + m (r² 1 − r r)."""
    square = dot(r, r)
    a, b, c = (
        tuple(
            collected(add(x, mul(mass, add(square if i == j else ZERO, neg(mul(r[i], r[j]))))))
            for j, x in enumerate(row)
        )
        for i, row in enumerate(rows)
    )
    return (a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])


def _arm(part: Part, kinematics: Kinematics) -> Vector | None:
    """From a point of the body at rest to its mass centre."""
    point, arm = part.mass_center, Vector()
    while point.parent is not None and point.body is None and _is_fixed(point, part):
        arm, point = arm + kinematics.aligned.vector(point.offset), point.parent
        if _rests(point, kinematics):
            return arm
        held = kinematics.contacts.get(point)
        if held is not None and held.body is part.frame and held.other is None and not held.directions:
            return arm - kinematics.aligned.vector(held.particle.offset) if _is_fixed(held.particle, part) else None
    return None


def _is_fixed(point: Point, part: Part) -> bool:
    """Whether a point lies fixed in the body beside the one before it."""
    offset = point.offset
    return all(f is part.frame for f, _ in offset.parts) and is_constant_in_time(offset.scalars())


def _rests(point: Point, kinematics: Kinematics) -> bool:
    motion = kinematics.point(point)
    still = motion.rest.is_zero and motion.bias.is_zero
    return still and all(isinstance(s, AuxiliarySpeed) for s in motion.partials)
