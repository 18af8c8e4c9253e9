# SPDX-License-Identifier: BSD-3-Clause
"""Gears, external or internal, on any carriers, and rack and pinion: teeth do not slip at the pitch point.

The particles of both gears at the pitch point have one velocity along the common tangent. The multiplier is the tangential tooth
force on the first gear, so that bearings feel the teeth too. With both gears on pins of one carrier it is a configuration constraint,

    r_a θ_a + r_b θ_b = r_a φ  (external)        r_a θ_a − r_b θ_b = r_a φ  (internal, b the ring),

otherwise a motion constraint. The pitch radii divide the distance of the centres as the numbers of teeth do.

With the pinion on a pin and the rack on a slider of one carrier, their constraint is r (θ − φ) − s = 0; its multiplier is the
tangential tooth force on the pinion along the rack.
"""

from dataclasses import replace
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import add, div, mul, sqrt, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import NEG
from kane.expr.patterns import split
from kane.model.constraints import Constraint, no_slip
from kane.model.directions import is_pair
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
