# SPDX-License-Identifier: BSD-3-Clause
"""Gears on any carriers: spur gears, external or internal, rack and pinion, bevel gears and worm gears.

There is no slip at the pitch point, along the common tangent, or along the normal of a worm's thread. The multiplier is the tooth
force on the first gear along that direction, so that bearing reactions include it. Between joints of one carrier it is a
configuration constraint, with pitch radii proportional to numbers of teeth, s = ±1 and the thread's rise p = r z_worm/z_wheel per rad

    r_a θ_a + r_b θ_b = r_a φ  (external, bevel)      r_a θ_a − r_b θ_b = r_a φ  (internal, b the ring)
    r (θ − φ) − s = 0  (rack on a slider)             s r θ_wheel ± p θ_worm = ± p φ  (worm),

otherwise a motion constraint. The pitch radii of spur gears divide the distance of the centres in the ratio of the numbers of teeth.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from kane import expect
from kane.errors import ModelError
from kane.expr.build import add, div, mul, split, sqrt, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import NEG
from kane.model.constraints import Constraint, check_unit, no_slip
from kane.model.joints.joint import Joint, numbers
from kane.numeric.sampling import positive
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Gear = Joint | tuple[Frame, Point]


class _GearSide(NamedTuple):
    """A gear or a rack: its frame, a point of it, and its joint if it was given as one."""

    frame: Frame
    center: Point
    joint: Joint | None

    def is_along(self, axis: Vector) -> bool:
        """Whether the axis of the joint has the direction of a unit vector, or the opposite one; raises ModelError otherwise."""
        assert self.joint is not None
        off = self.joint.axis.cross(axis)
        across, along = numbers([off.dot(off), self.joint.axis.dot(axis)])
        expected = f"a {self.joint.kind} joint {self.joint.name!r} whose axis is along {axis}, or against it"
        came, cure = f"one along {self.joint.axis}", "Exchange either."
        expect.that(across <= (DECLARED * along) ** 2, expected, came=came, cure=cure)
        return along > 0

    def moved(self, axis: Vector) -> Expr:
        """The coordinate of the joint about, or along, a unit vector."""
        assert self.joint is not None
        q = self.joint.coordinates[0]
        return q if self.is_along(axis) else -q


def _side(name: str, part: Any, kind: str, joint: str, pair: str) -> _GearSide:
    if isinstance(part, Joint):
        if part.kind != kind:
            raise ModelError(f"Expected {joint} for {name!r}, got {part.name!r}, a {part.kind} joint.")
        return _GearSide(part.frame, part.point, part)
    right = isinstance(part, tuple) and len(part) == 2 and isinstance(part[0], Frame) and isinstance(part[1], Point)
    expect.that(right, f"{pair} for {name!r}", part)
    return _GearSide(part[0], part[1], None)


def _of_pin(name: str, gear: Any) -> _GearSide:
    return _side(name, gear, "pin", "gears on pins", "a gear as a pin joint or (frame, centre)")


def _meshing(
    name: str, a: _GearSide, b: _GearSide, arms: tuple[Vector, Vector], along: Vector, expr: Callable[[], Expr]
) -> Constraint:
    """No slip between the particles at the ends of both arms; for joints of one carrier the configuration constraint `expr` = 0."""
    p, q = (x.center.fixed_in(x.frame, f"{name} {x.frame.name}", arm) for x, arm in zip((a, b), arms, strict=True))
    (slip,) = no_slip(p, q, along=along, name=name)
    if a.joint is None or b.joint is None or a.joint.parent is not b.joint.parent:
        return slip
    return replace(slip, kind="configuration", expr=expr())


def _teeth(name: str, teeth: Any, internal: bool = False) -> list[Expr]:
    result = [as_expr(z) for z in expect.pair(teeth, f"teeth=(z_a, z_b) for the gears {name!r}")]
    a, b = numbers(result)
    more = ", more on the ring" if internal else ""
    right, expected = a > 0 and b > (a if internal else 0), f"positive numbers of teeth{more} for {name!r}"
    expect.that(right, expected, came=f"{a:g} and {b:g}")
    return result


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
    """The constraint of two meshing spur gears, or of a gear and an internal gear.

    It is a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=.

    Parameters
    ----------
    name : of the constraint
    a, b : pin joints, or (frame, centre) of gears on any carriers with a constant distance of the centres
    teeth : numbers of teeth of `a` and `b`, or their pitch radii, in any unit
    internal : whether `b` is an internal (ring) gear
    axis : unit vector of the gears' axes; by default that of the pin `a`
    phase : the angle φ (rad) of `a` at θ_b = 0, if both are pins of one carrier
    """
    expect.name(name, "a name for the gears")
    first, second = _of_pin(name, a), _of_pin(name, b)
    n = axis if axis is not None else a.axis if isinstance(a, Joint) else None
    if n is None:
        raise ModelError(f"Expected axis=unit vector for the gears {name!r}, which are not given by pin joints.")
    z_a, z_b = _teeth(name, teeth, internal)
    line = second.center.position(first.center)
    size = length_along(line)
    _check_centers(name, line, n, size)
    whole = sub(z_b, z_a) if internal else add(z_a, z_b)
    e = -line / size if internal else line / size
    r_a, r_b = _pitch_radius(size, z_a, whole), _pitch_radius(size, z_b, whole)
    arms = (e * r_a).gathered(), (e * (r_b if internal else -r_b)).gathered()

    def angles() -> Expr:
        assert first.joint is not None
        assert second.joint is not None
        forward = first.is_along(n)
        alike = forward == second.is_along(n)
        turn = second.joint.coordinates[0] if alike != internal else -second.joint.coordinates[0]
        f = add(mul(r_a, sub(first.joint.coordinates[0], as_expr(phase))), mul(r_b, turn))
        return f if forward else -f

    return _meshing(name, first, second, arms, n.cross(e).gathered(), angles)


def length_along(v: Vector) -> Expr:
    """|v|; for v = s (a, b, c) with numbers a, b, c it is s √(a² + b² + c²) if s > 0 at default parameters.

    The sign of s is kept as parameters change, so that radii and tangent reverse with the line of centres.
    """
    # the square root of a square would lose the sign of s
    terms = [split(x.args[0] if x.op is NEG else x) for x in v.gathered().scalars() if x is not ZERO]
    factors = {s for _, s in terms}
    if len(factors) != 1:
        return v.magnitude()
    (s,) = factors
    size = mul(sqrt(sum((k**2 for k, _ in terms), start=ZERO)), s)
    return -size if numbers([size])[0] < 0 else size


def _pitch_radius(size: Expr, teeth: Expr, whole: Expr) -> Expr:
    """size · teeth / whole, or the radius itself if radii are given that add up to the distance."""
    return teeth if size is whole else mul(size, div(teeth, whole))


def _check_centers(name: str, line: Vector, n: Vector, size: Expr) -> None:
    lift, square = numbers([line.dot(n), line.dot(line)])
    level, expected = abs(lift) <= DECLARED * abs(square) ** 0.5 and not line.is_zero, f"centres of the gears {name!r}"
    expect.that(level, f"{expected} in one plane across the axis", came=f"them {lift:.3g} m apart along {n}")
    expect.that(is_constant_in_time([size]), f"{expected} at a constant distance", size, "Place both in one frame.")


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
    """The constraint of a pinion that meshes with a rack.

    It is a configuration constraint for a pin and a slider of one carrier, else a motion constraint, for nonholonomic=.

    Parameters
    ----------
    name : of the constraint
    pinion : its pin joint, or (frame, centre)
    rack : its slider, or (frame, any point fixed in it)
    radius : of the pinion's pitch circle, m
    axis : unit vector of the pinion's axis; by default that of its pin
    along : unit vector along the rack, fixed in a carrier of the pinion; by default the slider's axis. The teeth are on the side
        along × axis of the pinion, so that turning about +axis moves the rack along +along; for the other side reverse `along`
    phase : the angle φ (rad) of the pinion at s = 0, if both are joints of one carrier
    """
    expect.name(name, "a name for the rack and pinion")
    n = axis if axis is not None else pinion.axis if isinstance(pinion, Joint) else None
    d = along if along is not None else rack.axis if isinstance(rack, Joint) else None
    if n is None or d is None:
        raise ModelError(f"Expected axis= and along= for {name!r}, which is not given by a pin and a slider.")
    pairs = ((pinion, "pin"), (rack, "slider"))
    wheel, bar = (_side(name, x, kind, f"a {kind} joint", f"a {kind} joint or (frame, point)") for x, kind in pairs)
    r = positive(radius, f"the radius of the pinion of {name!r}", "For the other side, turn along= round.")
    check_unit(n, f"axis of the pinion of {name!r}")
    if abs(numbers([n.dot(d)])[0]) > DECLARED:
        raise ModelError(f"Expected the rack {name!r} across the pinion's axis, got {d} and {n}.")
    arm = d.cross(n) * r

    def advance() -> Expr:
        assert wheel.joint is not None
        turn = sub(wheel.joint.coordinates[0], as_expr(phase))
        return sub(mul(r, turn if wheel.is_along(n) else -turn), bar.moved(d))

    return _meshing(name, wheel, bar, (arm, wheel.center.position(bar.center) + arm), d, advance)


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
    """The constraint of two meshing bevel gears, whose axes meet at the apex.

    It is a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=.

    Parameters
    ----------
    name : of the constraint
    a, b : pin joints, or (frame, centre) of gears on any carriers
    teeth : numbers of teeth of `a` and `b`, or their pitch radii, in any unit
    radius : pitch radius of `a`, m
    apex : the point where the axes meet; by default that of the pin `a`
    axes : unit vectors of the axes, from the apex towards the gears; by default those of the pins. If both point away from the
        apex, or both towards it, the gears turn about them in opposite senses
    phase : the angle φ (rad) of `a` at θ_b = 0, if both are pins of one carrier
    """
    expect.name(name, "a name for the bevel gears")
    first, second = _of_pin(name, a), _of_pin(name, b)
    n_a, n_b = _axes(name, first, second, axes)
    z_a, z_b = _teeth(name, teeth)
    across = n_a.cross(n_b).gathered()
    inclined = not across.is_zero and abs(numbers([across.dot(across)])[0]) >= DECLARED
    expected, cure = f"axes of the bevel gears {name!r} that meet at an angle", "Use kn.gear_pair for parallel axes."
    expect.that(inclined, expected, came=f"{n_a} and {n_b}", cure=cure)
    meet = first.center if apex is None else apex
    _check_meets(name, meet, ((first.center, n_a), (second.center, n_b)))
    sine, r_a = length_along(across), positive(radius, f"the radius of {name!r}")
    line = (n_a * z_b + n_b * z_a) * div(r_a, mul(z_a, sine))  # the common line of the pitch cones
    arm_a, arm_b = ((meet.position(x.center) + line).gathered() for x in (first, second))

    def angles() -> Expr:
        turn_a = mul(r_a, sub(first.moved(n_a), as_expr(phase)))
        return add(turn_a, mul(div(mul(r_a, z_b), z_a), second.moved(n_b)))

    return _meshing(name, first, second, (arm_a, arm_b), across / sine, angles)


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
    """The constraint of a worm and a worm wheel, whose axes are perpendicular.

    It is a configuration constraint for two pins of one carrier, else a motion constraint, for nonholonomic=.

    Parameters
    ----------
    name : of the constraint
    wheel, worm : pin joints, or (frame, centre); the worm's centre lies in the plane through the wheel's centre perpendicular
        to the wheel's axis
    teeth : number of teeth of the wheel, and of threads of the worm
    radius : pitch radius of the wheel, m; that of the worm is the distance of the axes less `radius`
    hand : "right" or "left", of the thread
    axes : unit vectors of the axes of wheel and worm; by default those of the pins
    phase : the angle φ (rad) of the worm at θ = 0 of the wheel, if both are pins of one carrier
    """
    expect.name(name, "a name for the worm gear")
    expect.that(hand in ("right", "left"), f'hand="right" or "left" of the worm {name!r}', hand)
    first, second = _of_pin(name, wheel), _of_pin(name, worm)
    n_g, n_w = _axes(name, first, second, axes)
    z, threads = _teeth(name, teeth)
    outward = n_w.cross(n_g)
    between = second.center.position(first.center)
    square, lift, gap = numbers([n_w.dot(n_g), between.dot(n_g), between.dot(outward)])
    if abs(square) > DECLARED or abs(lift) > DECLARED * abs(gap) or not gap:
        raise ModelError(
            f"Expected axes of the worm gear {name!r} that cross at right angles, the wheel's centre across from the worm, got {n_g} "
            f"and {n_w} with the centres {between} apart. Place the wheel's centre in the plane across its axis that holds the worm's."
        )
    side, r = (1 if gap > 0 else -1), positive(radius, f"the radius of the wheel of {name!r}")
    rise = div(mul(r, threads), z) * (1 if hand == "right" else -1)
    arm = sub(mul(as_expr(side), between.dot(outward)), r)
    expect.that(numbers([arm])[0] > 0, f"a pitch radius of the wheel below the distance of the axes of {name!r}", r)
    contact = outward * (side * r)
    normal = n_w - n_g * div(rise * side, arm)
    size = length_along(normal)

    def angles() -> Expr:
        turn = sub(second.moved(n_w), as_expr(phase))
        return div(add(mul(side * r, first.moved(n_g)), mul(rise, turn)), size)

    arms = contact.gathered(), (contact - between).gathered()
    return _meshing(name, first, second, arms, (normal / size).gathered(), angles)


def _axes(name: str, a: _GearSide, b: _GearSide, axes: Any) -> tuple[Vector, Vector]:
    if axes is None and a.joint is not None and b.joint is not None:
        axes = (a.joint.axis, b.joint.axis)
    first, second = expect.pair(axes, f"axes=(unit vector, unit vector) for the gears {name!r}", "Pins have their own.")
    for n in (first, second):
        check_unit(n, f"axis of a gear of {name!r}")
    return first, second


def _check_meets(name: str, apex: Any, lines: tuple[tuple[Point, Vector], ...]) -> None:
    """Raise ModelError unless the apex is on the axes of both gears."""
    expect.instance(apex, Point, f"a Point as the apex of {name!r}, where the axes meet")
    for at, n in lines:
        r = apex.position(at)
        off = r.cross(n)
        away, far = numbers([off.dot(off), r.dot(r)])
        on = abs(away) <= DECLARED**2 * max(abs(far), 0) or not far
        came = f"{apex.name}, off the line through {at.name} along {n}"
        cure = "Give apex=the point where the axes meet."
        expect.that(on, f"the apex of {name!r} on the axes of both gears", came=came, cure=cure)
