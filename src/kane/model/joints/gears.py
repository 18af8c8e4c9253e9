# SPDX-License-Identifier: BSD-3-Clause
"""Gears, external or internal, on any carriers, and rack and pinion: teeth do not slip at the pitch point.

The particles of both gears at the pitch point have one velocity along the common tangent. The multiplier is the tangential tooth
force on the first gear, so that bearings feel the teeth too. With both gears on pins of one carrier it is a configuration constraint,

    r_a θ_a + r_b θ_b = r_a φ  (external)        r_a θ_a − r_b θ_b = r_a φ  (internal, b the ring),

otherwise a motion constraint. The pitch radii divide the distance of the centres as the numbers of teeth do.

With the pinion on a pin and the rack on a slider of one carrier, their constraint is r (θ − φ) − s = 0; its multiplier is the
tangential tooth force on the pinion along the rack.


Gears whose axes are not parallel: bevel gears, whose axes meet, and worm gears, whose axes cross at right angles.

Teeth do not slip at the pitch point, along the common tangent of bevel gears, along the normal of a worm's thread. Between gears on
pins of one carrier, with pitch radii r_a : r_b = z_a : z_b, s = ±1 and the thread's rise p = r z_worm/z_wheel per rad,

    r_a θ_a + r_b θ_b = r_a φ  (bevel)        s r θ_wheel ± p θ_worm = ± p φ  (worm)

is a configuration constraint, otherwise a motion constraint. The multiplier is the tooth force on the first gear along that direction.
"""

from dataclasses import replace
from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.build import add, div, mul, sqrt, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import NEG
from kane.expr.patterns import split
from kane.model.constraints import Constraint, no_slip
from kane.model.directions import check_unit, is_pair
from kane.model.joints.joint import Joint, check_named, fixed, is_along, numbers
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Gear = Joint | tuple[Frame, Point]


def gear_pair(
    name: str,
    a: Gear,
    b: Gear,
    *,
    teeth: tuple[Any, Any],
    internal: bool = False,
    axis: Vector | None = None,
    phase: Any = 0,
) -> Constraint:
    """Gears `a` and `b` mesh.

    Parameters
    ----------
    name : of the constraint
    a, b : pin joints, or (frame, centre) of gears on any carriers whose centres keep their distance
    teeth : numbers of teeth, or pitch radii: only their ratio counts
    internal : whether `b` is a ring with teeth inside
    axis : common unit vector of the gears' axes; that of `a` where it is a pin
    phase : the angle φ of `a` at θ_b = 0, for gears on pins of one carrier: list the constraint in holonomic=

    Returns
    -------
    Constraint
        a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=
    """
    check_named("gears", name)
    (frame_a, at_a), (frame_b, at_b) = (
        gear_side(name, part, "pin", "gears on pins", "a gear as a pin joint or (frame, centre)") for part in (a, b)
    )
    n = axis if axis is not None else a.axis if isinstance(a, Joint) else None
    if n is None:
        raise ModelError(f"Expected axis=unit vector for the gears {name!r}, which are not given by pin joints.")
    if not is_pair(teeth):
        raise ModelError(f"Expected teeth=(z_a, z_b) for the gears {name!r}, got {cut(repr(teeth))}.")
    z_a, z_b = (as_expr(z) for z in teeth)
    line = at_b.position(at_a)
    size = length_along(line)
    _check_layout(name, line, n, size, z_a, z_b, internal)
    whole = sub(z_b, z_a) if internal else add(z_a, z_b)
    e = -line / size if internal else line / size
    r_a, r_b = _pitch_radius(size, z_a, whole), _pitch_radius(size, z_b, whole)
    tangent = n.cross(e).gathered()
    p = at_a.fixed_in(frame_a, f"{name} {frame_a.name}", (e * r_a).gathered())
    q = at_b.fixed_in(frame_b, f"{name} {frame_b.name}", (e * (r_b if internal else -r_b)).gathered())
    (slip,) = no_slip(p, q, along=tangent, name=name)
    if not (isinstance(a, Joint) and isinstance(b, Joint) and a.parent is b.parent):
        return slip
    other = fixed(b.axis, a.parent, f"axis of {b.name!r}")
    forward, alike = is_along(a.axis, n), is_along(a.axis, n) == is_along(other, n)
    turn_b = b.coordinates[0] if alike != internal else -b.coordinates[0]
    way = add(mul(r_a, sub(a.coordinates[0], as_expr(phase))), mul(r_b, turn_b))
    return replace(slip, kind="configuration", expr=way if forward else -way)


def length_along(v: Vector) -> Expr:
    """|v|; of s (a, b, c) with numbers a, b, c it is s √(a² + b² + c²), where s > 0 at the parameters' defaults.

    The sign of s is left to it where a parameter changes: a line of centres that turns round turns radii and tangent with it.
    """
    # a square has lost the sign that a number times s may have in front
    terms = [split(x.args[0] if x.op is NEG else x) for x in v.gathered().scalars() if x is not ZERO]
    factors = {s for _, s in terms}
    if len(factors) != 1:
        return v.magnitude()
    (s,) = factors
    size = mul(sqrt(sum((k**2 for k, _ in terms), start=ZERO)), s)
    return -size if numbers([size])[0] < 0 else size


def _pitch_radius(size: Expr, teeth: Expr, whole: Expr) -> Expr:
    """size · teeth / whole; the radius itself where radii are given that add up to the distance."""
    return teeth if size is whole else mul(size, div(teeth, whole))


def gear_side(name: str, part: Any, kind: str, joint: str, pair: str) -> tuple[Frame, Point]:
    """Frame and centre of a gear that is given by its joint, or by these."""
    if isinstance(part, Joint):
        if part.kind != kind:
            raise ModelError(f"Expected {joint} for {name!r}, got {part.name!r}, a {part.kind} joint.")
        return part.frame, part.point
    if isinstance(part, tuple) and len(part) == 2 and isinstance(part[0], Frame) and isinstance(part[1], Point):
        return part
    raise ModelError(f"Expected {pair} for {name!r}, got {cut(repr(part))}.")


def _check_layout(name: str, line: Vector, n: Vector, size: Expr, z_a: Expr, z_b: Expr, internal: bool) -> None:
    lift, square, ta, tb = numbers([line.dot(n), line.dot(line), z_a, z_b])
    if abs(lift) > DECLARED * abs(square) ** 0.5 or line.is_zero:
        raise ModelError(
            f"Expected centres of the gears {name!r} in one plane across the axis, got them {lift:.3g} m apart along {n}."
        )
    if not is_constant_in_time([size]):
        raise ModelError(
            f"Expected centres of the gears {name!r} at a constant distance, got {cut(size)}. Carry both by one frame."
        )
    if not (ta > 0 and tb > (ta if internal else 0)):
        raise ModelError(
            f"Expected positive numbers of teeth{', more on the ring' if internal else ''} for {name!r}, got {ta:g} and {tb:g}."
        )


def rack_and_pinion(
    name: str,
    pinion: Gear,
    rack: Gear,
    *,
    radius: Any,
    axis: Vector | None = None,
    along: Vector | None = None,
    phase: Any = 0,
) -> Constraint:
    """A pinion meshes with a rack.

    Parameters
    ----------
    name : of the constraint
    pinion : its pin joint, or (frame, centre)
    rack : its slider, or (frame, any point fixed in it)
    radius : of the pinion's pitch circle, m
    axis : unit vector of the pinion's axis; that of its pin
    along : unit vector along the rack, fixed in a carrier of the pinion; the slider's axis. The teeth are on the side
        along × axis of the pinion, so that turning about +axis moves the rack along +along; for the other side reverse `along`
    phase : the angle φ of the pinion at s = 0, for joints of one carrier: list the constraint in holonomic=

    Returns
    -------
    Constraint
        a configuration constraint for a pin and a slider of one carrier, else a motion constraint, for nonholonomic=
    """
    check_named("rack and pinion", name)
    n = axis if axis is not None else pinion.axis if isinstance(pinion, Joint) else None
    d = along if along is not None else rack.axis if isinstance(rack, Joint) else None
    if n is None or d is None:
        raise ModelError(f"Expected axis= and along= for {name!r}, which is not given by a pin and a slider.")
    (wheel, center), (bar, foot) = (
        gear_side(name, part, kind, f"a {kind} joint", f"a {kind} joint or (frame, point)")
        for part, kind in ((pinion, "pin"), (rack, "slider"))
    )
    r = as_expr(radius)
    if abs(numbers([n.dot(d)])[0]) > DECLARED:
        raise ModelError(f"Expected the rack {name!r} across the pinion's axis, got {d} and {n}.")
    arm = d.cross(n) * r
    p = center.fixed_in(wheel, f"{name} {wheel.name}", arm)
    q = foot.fixed_in(bar, f"{name} {bar.name}", center.position(foot) + arm)
    (slip,) = no_slip(p, q, along=d, name=name)
    if not (isinstance(pinion, Joint) and isinstance(rack, Joint) and pinion.parent is rack.parent):
        return slip
    s, turn = rack.coordinates[0], sub(pinion.coordinates[0], as_expr(phase))
    along_rack = is_along(fixed(rack.axis, rack.parent, "axis"), d)
    way = sub(mul(r, turn if is_along(pinion.axis, n) else -turn), s if along_rack else -s)
    return replace(slip, kind="configuration", expr=way)


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
    expect.instance(apex, Point, f"a Point as the apex of {name!r}, where the axes meet")
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
