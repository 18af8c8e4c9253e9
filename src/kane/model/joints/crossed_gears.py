# SPDX-License-Identifier: BSD-3-Clause
"""Gears whose axes are not parallel: bevel gears, whose axes meet, and worm gears, whose axes cross at right angles.

Teeth do not slip at the pitch point, along the common tangent of bevel gears, along the normal of a worm's thread. Between gears on
pins of one carrier, with pitch radii r_a : r_b = z_a : z_b, s = ±1 and the thread's rise p = r z_worm/z_wheel per rad,

    r_a θ_a + r_b θ_b = r_a φ  (bevel)        s r θ_wheel ± p θ_worm = ± p φ  (worm)

is a configuration constraint, otherwise a motion constraint. The multiplier is the tooth force on the first gear along that direction.
"""

from dataclasses import replace
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import add, div, mul, sub
from kane.expr.node import Expr, as_expr
from kane.model.constraints import Constraint, no_slip
from kane.model.directions import check_unit, is_pair
from kane.model.joints.gears import Gear, gear_side, length_along
from kane.model.joints.joint import Joint, check_named, numbers
from kane.numeric.scale import DECLARED
from kane.space.point import Point
from kane.space.vector import Vector


def bevel_pair(
    name: str,
    a: Gear,
    b: Gear,
    *,
    teeth: tuple[Any, Any],
    radius: Any,
    apex: Point | None = None,
    axes: tuple[Vector, Vector] | None = None,
    phase: Any = 0,
) -> Constraint:
    """Bevel gears `a` and `b` mesh; their axes meet at the apex.

    Parameters
    ----------
    name : of the constraint
    a, b : pin joints, or (frame, centre) of gears on any carriers
    teeth : numbers of teeth, or pitch radii: only their ratio counts
    radius : pitch radius of `a`, m
    apex : where the axes meet; by default the place of the pin `a`
    axes : unit vectors of the axes, from the apex into the gears; those of the pins. Where both point away from the apex, or both to
        it, the gears turn about them in opposite senses
    phase : the angle φ of `a` at θ_b = 0, for pins of one carrier: list the constraint in holonomic=

    Returns
    -------
    Constraint
        a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=
    """
    check_named("bevel gears", name)
    (frame_a, at_a), (frame_b, at_b) = (_of_pin(name, g) for g in (a, b))
    n_a, n_b = _axes(name, a, b, axes)
    z_a, z_b = _teeth(name, teeth)
    across = n_a.cross(n_b).gathered()
    if across.is_zero or abs(numbers([across.dot(across)])[0]) < DECLARED:
        raise ModelError(
            f"Expected axes of the bevel gears {name!r} that meet at an angle, got {n_a} and {n_b}. kn.gear_pair takes parallel ones."
        )
    meet = at_a if apex is None else apex
    _check_meets(name, meet, ((at_a, n_a), (at_b, n_b)))
    sine, r_a = length_along(across), as_expr(radius)
    line = (n_a * z_b + n_b * z_a) * div(r_a, mul(z_a, sine))  # along both pitch cones, z_a : z_b from the axes
    p = at_a.fixed_in(frame_a, f"{name} {frame_a.name}", (meet.position(at_a) + line).gathered())
    q = at_b.fixed_in(frame_b, f"{name} {frame_b.name}", (meet.position(at_b) + line).gathered())
    (slip,) = no_slip(p, q, along=across / sine, name=name)
    if not _of_one_carrier(a, b):
        return slip
    turn_a, turn_b = _turn(a, n_a), _turn(b, n_b)
    way = add(mul(r_a, sub(turn_a, as_expr(phase))), mul(div(mul(r_a, z_b), z_a), turn_b))
    return replace(slip, kind="configuration", expr=way)


def worm_pair(
    name: str,
    wheel: Gear,
    worm: Gear,
    *,
    teeth: tuple[Any, Any],
    radius: Any,
    hand: str = "right",
    axes: tuple[Vector, Vector] | None = None,
    phase: Any = 0,
) -> Constraint:
    """A worm drives a wheel; their axes cross at right angles.

    Parameters
    ----------
    name : of the constraint
    wheel, worm : pin joints, or (frame, centre); the centre of the wheel is across from the axis of the worm
    teeth : of the wheel, and the threads of the worm
    radius : pitch radius of the wheel, m; that of the worm is what is left of the distance of the axes
    hand : "right" or "left", of the thread
    axes : unit vectors of wheel and worm; those of the pins
    phase : the angle φ of the worm at θ = 0 of the wheel, for pins of one carrier: list the constraint in holonomic=

    Returns
    -------
    Constraint
        a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=
    """
    check_named("worm gear", name)
    if hand not in ("right", "left"):
        raise ModelError(f'Expected hand="right" or "left" of the worm {name!r}, got {cut(repr(hand))}.')
    (frame_g, at_g), (frame_w, at_w) = (_of_pin(name, g) for g in (wheel, worm))
    n_g, n_w = _axes(name, wheel, worm, axes)
    z, threads = _teeth(name, teeth)
    outward = n_w.cross(n_g)
    between = at_w.position(at_g)
    square, lift, gap = numbers([n_w.dot(n_g), between.dot(n_g), between.dot(outward)])
    if abs(square) > DECLARED or abs(lift) > DECLARED * abs(gap) or not gap:
        raise ModelError(
            f"Expected axes of the worm gear {name!r} that cross at right angles, the wheel's centre across from the worm, got {n_g} "
            f"and {n_w} with the centres {between} apart. Place the wheel's centre in the plane across its axis that holds the worm's."
        )
    side = 1 if gap > 0 else -1
    r = as_expr(radius)
    rise = div(mul(r, threads), z) * (1 if hand == "right" else -1)
    arm = sub(mul(as_expr(side), between.dot(outward)), r)
    if numbers([arm])[0] <= 0:
        raise ModelError(
            f"Expected a pitch radius of the wheel below the distance of the axes of {name!r}, got {cut(r)}."
        )
    contact = outward * (side * r)
    p = at_g.fixed_in(frame_g, f"{name} {frame_g.name}", contact.gathered())
    q = at_w.fixed_in(frame_w, f"{name} {frame_w.name}", (contact - between).gathered())
    normal = n_w - n_g * div(rise * side, arm)
    size = length_along(normal)
    (slip,) = no_slip(p, q, along=(normal / size).gathered(), name=name)
    if not _of_one_carrier(wheel, worm):
        return slip
    way = add(mul(side * r, _turn(wheel, n_g)), mul(rise, sub(_turn(worm, n_w), as_expr(phase))))
    return replace(slip, kind="configuration", expr=div(way, size))


def _of_pin(name: str, gear: Any) -> Any:
    return gear_side(name, gear, "pin", "gears on pins", "a gear as a pin joint or (frame, centre)")


def _axes(name: str, a: Gear, b: Gear, axes: Any) -> tuple[Vector, Vector]:
    if axes is None and isinstance(a, Joint) and isinstance(b, Joint):
        axes = (a.axis, b.axis)
    if not is_pair(axes):
        raise ModelError(
            f"Expected axes=(unit vector, unit vector) for the gears {name!r}, got {cut(repr(axes))}. Pins have their own."
        )
    for n in axes:
        check_unit(n, f"axis of a gear of {name!r}")
    return axes[0], axes[1]


def _teeth(name: str, teeth: Any) -> tuple[Expr, Expr]:
    if not is_pair(teeth):
        raise ModelError(f"Expected teeth=(z_a, z_b) for the gears {name!r}, got {cut(repr(teeth))}.")
    pair = as_expr(teeth[0]), as_expr(teeth[1])
    sizes = numbers(pair)
    if not min(sizes) > 0:
        raise ModelError(f"Expected positive numbers of teeth for {name!r}, got {sizes[0]:g} and {sizes[1]:g}.")
    return pair


def _check_meets(name: str, apex: Any, lines: tuple[tuple[Point, Vector], ...]) -> None:
    """The apex lies on the axes of both gears."""
    if not isinstance(apex, Point):
        raise ModelError(f"Expected a Point as the apex of {name!r}, where the axes meet, got {cut(repr(apex))}.")
    for at, n in lines:
        r = apex.position(at)
        off = r.cross(n)
        away, far = numbers([off.dot(off), r.dot(r)])
        if abs(away) > DECLARED**2 * max(abs(far), 0) and far:
            raise ModelError(
                f"Expected the apex of {name!r} on the axes of both gears, got {apex.name}, off the line through {at.name} along {n}. "
                "Give apex=the point where the axes meet."
            )


def _of_one_carrier(a: Gear, b: Gear) -> bool:
    return isinstance(a, Joint) and isinstance(b, Joint) and a.parent is b.parent


def _turn(gear: Gear, axis: Vector) -> Expr:
    """The angle of a pin about an axis along it."""
    assert isinstance(gear, Joint)
    same = numbers([gear.axis.dot(axis)])[0] > 0
    return gear.coordinates[0] if same else -gear.coordinates[0]
