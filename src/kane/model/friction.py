# SPDX-License-Identifier: BSD-3-Clause
"""Sliding friction, declared: loads that say what slips, from which speed on it no longer does, and what must press.

Its direction is that of the slip, which none is left of at rest: a motion ends where the slip falls below the threshold, or,
with `smooth`, the force falls with the slip and the contact creeps.
"""

from dataclasses import replace
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, sqrt
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Reaction
from kane.model.joints.joint import Joint
from kane.model.loads import Force, Load, Slip, action_reaction, torque_pair
from kane.model.reactions import cut_of
from kane.numeric.named import finite_number
from kane.space.point import Point
from kane.space.vector import Vector

_JOINTS = ("pin", "slider")


def friction(
    point: Point,
    normal: Reaction,
    mu: Any,
    *,
    along: Vector | None = None,
    against: Point | None = None,
    threshold: float | None = None,
    smooth: float | None = None,
    name: str = "",
) -> Load:
    """Coulomb's friction −μ N v/|v| at a particle that slides under the normal force N.

    The slip v is the particle's velocity across the normal's direction. A motion ends where |v| falls below the threshold (the
    contact sticks, or rolls where the particle in contact changes), and where N falls to zero (the contact opens).

    Parameters
    ----------
    point : the particle in contact, made with `fixed_in`
    normal : the normal reaction, which must press where it is positive
    mu : coefficient of friction
    along : the direction of the normal, where the reaction does not say it
    against : the particle of the other body that it slides on; it feels the opposite force. Without it the ground
    threshold : slip speed, in the units of the model, below which the contact is taken not to slide any more; a ten-thousandth of the
        largest that it has had in the motion, unless told
    smooth : a speed ε: the force is −μ N v/√(v² + ε²), which has no threshold and can start at rest
    name : of the load

    Raises
    ------
    ModelError
        if the point is no Point, the normal no Reaction with a direction, or the threshold or ε not above zero
    """
    if not isinstance(point, Point):
        raise ModelError(
            f"Expected friction at a Point, got {cut(repr(point))}. Make the particle in contact with fixed_in(…)."
        )
    if not isinstance(normal, Reaction):
        raise ModelError(
            f"Expected the normal force as a reaction, got {cut(repr(normal))}. Bring it into evidence: kn.reaction(name, "
            "at=…, along=…)."
        )
    if along is None:
        place = cut_of(normal)
        if place is None:
            raise ModelError(
                f"Expected along=unit vector, the normal's direction, as the reaction {normal} does not say it."
            )
        along = place.along
    root = point.root().frame
    v = point.velocity(root) if against is None else point.velocity(root) - against.velocity(root)
    slip = v.reject(along)
    force = _direction(slip, slip.dot(slip), _speed("smooth", smooth)) * (-as_expr(mu) * normal)
    name = name or f"friction on {point.name}"
    load = Force(point, force, name) if against is None else action_reaction(point, against, force, name)
    rolls = any(p.body is not None and not p.offset.dt(p.body).is_zero for p in (point, against) if p is not None)
    return _declared(load, Slip(slip.magnitude(), rolls=rolls), normal, threshold, smooth)


def dry_friction(
    joint: Joint, size: Any, *, threshold: float | None = None, smooth: float | None = None, name: str = ""
) -> Load:
    """Dry friction in a pin or a slider: a torque or force of a given size against the joint's rate.

    A motion ends where the rate falls below the threshold (the joint sticks).

    Parameters
    ----------
    joint : a pin or a slider
    size : of the torque (pin) or force (slider), not below zero
    threshold : rate, in the units of the model, below which the joint is taken to stick; a ten-thousandth of the largest that it has
        had in the motion, unless told
    smooth : a rate ε: the load is −size tanh(rate/ε), which has no threshold and can start at rest
    name : of the load

    Raises
    ------
    ModelError
        if the joint is neither a pin nor a slider, or the threshold or ε is not above zero
    """
    kind = getattr(joint, "kind", None)
    if kind not in _JOINTS:
        what = f"a {kind} joint" if isinstance(kind, str) else f"{cut(repr(joint))}"
        raise ModelError(
            f"Expected dry friction in a pin or slider joint, got {what}. Write the load with kn.torque_pair."
        )
    turns = joint.kind == "pin"
    axis = joint.axis
    rate = (joint.angular_velocity if turns else joint.velocity).dot(axis)
    eps = _speed("smooth", smooth)
    sense = NODE_BUILDERS["sign"](rate) if eps is None else NODE_BUILDERS["tanh"](div(rate, as_expr(eps)))
    load = axis * (-as_expr(size) * sense)
    name = name or f"dry friction in {joint.name}"
    pair = (
        torque_pair(joint.frame, joint.parent, load, name)
        if turns
        else action_reaction(joint.point, joint.at, load, name)
    )
    return _declared(pair, Slip(NODE_BUILDERS["abs"](rate)), as_expr(size), threshold, smooth)


def _direction(v: Vector, square: Expr, eps: float | None) -> Vector:
    """v over its length, or over √(v² + ε²)."""
    return v.normalized() if eps is None else v / sqrt(add(square, mul(as_expr(eps), as_expr(eps))))


def _declared(load: Load, slip: Slip, size: Expr, threshold: float | None, smooth: float | None) -> Load:
    presses = tuple(s for s in free_symbols([size]) if isinstance(s, Reaction))
    speed = slip.speed if smooth is None else None
    return replace(load, slip=replace(slip, speed=speed, threshold=_speed("threshold", threshold), presses=presses))


def _speed(name: str, value: Any) -> float | None:
    return None if value is None else _above_zero(name, value)


def _above_zero(name: str, value: Any) -> float:
    number = finite_number("speed", name, value)
    if not number > 0:
        raise ModelError(f"Expected {name} > 0, a speed in the units of the model, got {value!r}.")
    return number
