# SPDX-License-Identifier: BSD-3-Clause
"""Contact of a wheel with a plane: the point of contact, the particles there, the constraints of contact and of rolling; friction.

A wheel is a ring of radius R about an axis w, thickened to a torus by a crown of radius r: a disk's edge has r = 0, a sphere
R = 0. With the plane's unit normal n and d the direction in the wheel's plane that points down,

    d = −(n − (n·w) w) / |n − (n·w) w|,        contact = centre + R d − r n,

which is smooth unless the wheel lies flat (n ∥ w). The rate of the height h = (contact − Q)·n over a point Q of the plane is the
relative velocity along n of the particles in contact: the multiplier of h = 0 is the normal force on the wheel's particle.

Sliding friction is a load with its slip, a threshold of the slip speed, and the reactions that must be compressive. It has no
direction at rest: a motion ends where the slip speed falls below the threshold, or, with `smooth`, the contact creeps.
"""

from dataclasses import dataclass, replace
from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sqrt
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Reaction
from kane.model.constraints import Constraint, check_unit, cut_of, home_of, rolling, touching
from kane.model.joints.joint import Joint, check_attachment, fixed
from kane.model.loads import Force, Load, Slip, action_reaction, torque_pair
from kane.numeric.sampling import SEEDS, default_of, finite_number, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point
from kane.space.rotation import single
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class Contact(Immutable):
    """The geometry of a contact between two bodies, such as a wheel and a plane; for `kn.contact`, or for its constraints.

    `point` is the geometric point of contact, `particle` the first body's particle there, and `ground` the other's (None if that
    is at rest). `height` is the configuration constraint that keeps the contact closed, `rolling` the two motion constraints of
    rolling. If the choice of coordinates keeps the contact closed, list `rolling` alone.
    """

    name: str
    point: Point
    particle: Point
    ground: Point | None
    normal: Vector
    height: Constraint
    rolling: tuple[Constraint, ...]

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraint `height` and the two constraints `rolling`."""
        return (self.height, *self.rolling)

    def __repr__(self) -> str:
        return f"Contact({self.name!r}: {self.particle.name} on {self.height.name})"


def _contact(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    normal: Vector,
    ring: tuple[Any, Vector] | None,
    crown: Any | None,
    along: Vector | None,
    down: Vector | None,
    surface: Vector | None = None,
) -> Contact:
    """The contact of a ring (radius, axis) with the radius of its crown on the plane through `plane` normal to `normal`."""
    radius = _positive(ring[0], f"radius of {name!r}") if ring is not None else ZERO
    rounding = _positive(crown, f"{'crown ' if ring else ''}radius of {name!r}") if crown is not None else ZERO
    check_attachment(name, center, wheel)
    check_attachment(name, plane, wheel)
    base = home_of(normal, f"normal of {name!r}")
    reach = normal * -rounding
    if ring is not None:
        axis = _despun(fixed(ring[1], wheel, f"axis of {name!r}"), wheel)
        reach = reach + _down(name, axis, normal, down) * radius
    point = center.at(f"{name} point", reach)
    particle = center.fixed_in(wheel, f"{name} particle", reach)
    ground = None if _at_rest(plane, base) else _particle(name, plane, base, point, Vector())
    return _placed(name, (point, particle, ground), plane, normal, along, surface)


def _at_rest(plane: Point, base: Frame) -> bool:
    """Whether the plane is at rest; it may also move without rotation."""
    return base.parent is None and plane.velocity(base).is_zero


def _particle(name: str, plane: Point, base: Frame, point: Point, below: Vector) -> Point:
    """The plane's particle below a point."""
    born = plane if plane.body is None or plane.parent is None else plane.parent
    return born.fixed_in(base, f"{name} ground", point.position(born) + below)


def _placed(
    name: str,
    points: tuple[Point, Point, Point | None],
    plane: Point,
    normal: Vector,
    along: Vector | None,
    surface: Vector | None,
) -> Contact:
    """The contact of a particle with a plane, whose surface may have a velocity relative to the plane's frame."""
    point, particle, ground = points
    height = touching(particle, plane, normal=normal, name=f"{name} normal")
    slip = rolling(particle, ground, normal=normal, along=along, name=name)
    if surface is not None:
        expect.instance(surface, Vector, f"a velocity as the surface= of {name!r}")
        slip = tuple(_less(c, surface) for c in slip)
    return Contact(name, point, particle, ground, normal, height, slip)


def _less(c: Constraint, surface: Vector) -> Constraint:
    """The constraint of no slip on a surface with a velocity relative to its frame."""
    running = neg(surface.dot(c.forces[0][1]))
    return replace(c, expr=add(c.expr, running), own=add(c.own, running))


def point_on_plane(
    name: str, point: Point, plane: Point, *, normal: Vector, along: Vector | None = None, surface: Vector | None = None
) -> Contact:
    """Contact of a particle, or of a corner of a body, with a plane.

    Parameters
    ----------
    name : of the contact; its constraints are "name normal", "name 1" and "name 2"
    point : the particle: a point made with `fixed_in`, or the point of a `kn.Particle`
    plane : a point of the plane, fixed in the frame that `normal` is written in
    normal : unit vector perpendicular to the plane, on the side of the particle
    along : unit vector in the plane, the first direction of slip; by default an axis of the normal's frame
    surface : velocity of the surface relative to the plane's frame, for a belt
    """
    check_unit(normal, f"normal of {name!r}")
    base = home_of(normal, f"normal of {name!r}")
    ground = None
    if not _at_rest(plane, base):
        height = point.position(plane).dot(normal)
        ground = _particle(name, plane, base, point, -normal * height)
    return _placed(name, (point, point, ground), plane, normal, along, surface)


def _despun(axis: Vector, wheel: Frame) -> Vector:
    """The axis written in the frame in which the wheel spins, if it spins about one of its own axes: shorter without the spin."""
    o = wheel.orientation
    if o is None or o.axis is None or single(axis.components(wheel)) != o.axis:
        return axis
    return Vector(((o.base, axis.components(wheel)),))


def _down(name: str, axis: Vector, normal: Vector, down: Vector | None) -> Vector:
    if down is None:
        steepest = normal - axis * normal.dot(axis)
        if steepest.is_zero:
            raise ModelError(f"Expected the wheel {name!r} not to lie flat, got its axis along the normal {normal}.")
        return -steepest.gathered().normalized()
    check_unit(down, f"down direction of {name!r}")
    checks = [down.dot(axis), down.cross(axis).dot(normal), normal.dot(down)]
    for seed in SEEDS:
        level, sideways, sense = sample(checks, seed)
        if abs(level) > DECLARED or abs(sideways) > DECLARED or sense > 0:
            raise ModelError(
                f"Expected down= in the plane of the wheel {name!r}, across its axis and pointing to the ground, got {down}: its "
                f"products with the axis, the horizontal and the normal are {level:.3g}, {sideways:.3g}, {sense:.3g} at a random "
                "configuration (0, 0 and negative). Leave it out to have it found."
            )
    return down


def _positive(length: Any, what: str) -> Expr:
    """The length; raises ModelError if it is not positive at default parameters."""
    e = as_expr(length)
    value = sample([e], SEEDS[0])[0]
    if not value > 0:
        raise ModelError(f"Expected a positive {what}, got {e} = {value:.6g}.")
    return e


def disk_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    axis: Vector,
    radius: Any,
    normal: Vector,
    along: Vector | None = None,
    down: Vector | None = None,
    surface: Vector | None = None,
) -> Contact:
    """The edge of a disk on a plane: contact at centre + R d, d the steepest direction down the disk's plane, which must not lie flat.

    Parameters
    ----------
    name : of the contact; its constraints are "name normal", "name 1" and "name 2"
    wheel, center : the disk's frame and centre
    plane : a point of the plane, fixed in the frame that `normal` is written in
    axis : unit vector along the disk's axis, fixed in the disk
    radius : of its edge, m
    normal : unit vector perpendicular to the plane, on the side of the disk
    along : unit vector in the plane, direction of the first constraint of rolling; by default an axis of the normal's frame
    down : the unit vector d, if an axis of a frame of the model is d: it makes the equations shorter
    surface : velocity of the surface relative to the plane's frame, for a belt
    """
    return _contact(name, wheel, center, plane, normal, (radius, axis), None, along, down, surface)


def sphere_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    radius: Any,
    normal: Vector,
    along: Vector | None = None,
    surface: Vector | None = None,
) -> Contact:
    """Contact of a sphere with a plane, at centre − r n. Arguments as for `disk_on_plane`."""
    return _contact(name, wheel, center, plane, normal, None, radius, along, None, surface)


def torus_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    axis: Vector,
    radius: Any,
    crown: Any,
    normal: Vector,
    along: Vector | None = None,
    down: Vector | None = None,
    surface: Vector | None = None,
) -> Contact:
    """A wheel with a rounded (toroidal) rim on a plane: contact at centre + R d − r n; the wheel must not lie flat.

    `radius` R is that of the centre line of the torus, `crown` r that of its cross section: an upright wheel has its centre at the
    height R + r. Other arguments as for `disk_on_plane`.
    """
    return _contact(name, wheel, center, plane, normal, (radius, axis), crown, along, down, surface)


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
    """Coulomb friction −μ N v/|v| on a particle that slides under the normal force N; for stick and slip use `kn.contact`.

    The slip v is the component of the particle's velocity perpendicular to the normal. A motion ends where |v| falls below the
    threshold (the contact would stick, or roll), and where N falls to zero (the contact would open).

    Parameters
    ----------
    point : the particle in contact, made with `fixed_in`
    normal : the reaction N, positive in compression
    mu : coefficient of friction
    along : unit vector of the normal, if `normal` was declared without a direction
    against : the particle of the other body at the contact, on which the opposite force acts; by default the ground
    threshold : slip speed below which sliding ends, in the unit of speed of the model; by default 1e-4 of the largest slip speed so
        far in the motion
    smooth : a speed ε: the force is −μ N v/√(v² + ε²), which has no threshold, and motions may start at rest
    name : of the load

    Raises
    ------
    ModelError
        if `point` is not a Point, `normal` not a Reaction with a direction, or the threshold or ε is not positive
    """
    expect.instance(point, Point, "friction at a Point", "Make the particle in contact with fixed_in(…).")
    cure = "Bring it into evidence: kn.reaction(name, at=…, along=…)."
    expect.instance(normal, Reaction, "the normal force as a reaction", cure)
    share = not_negative(mu, f"a coefficient of friction at {point.name}")
    if along is None:
        place = cut_of(normal)
        if place is None:
            raise ModelError(
                f"Expected along=unit vector, the normal's direction, as the reaction {normal} does not define it."
            )
        along = place.along
    if against is not None:
        expect.instance(against, Point, "the particle that it slides on as a Point", "Make it with fixed_in(…).")
    root = point.root().frame
    v = point.velocity(root) if against is None else point.velocity(root) - against.velocity(root)
    slip = v.reject(along)
    eps = _above_zero("smooth", smooth)
    regular = None if eps is None else sqrt(add(slip.dot(slip), mul(as_expr(eps), as_expr(eps))))
    force = (slip.normalized() if regular is None else slip / regular) * (-share * normal)
    name = name or f"friction on {point.name}"
    load = Force(point, force, name) if against is None else action_reaction(point, against, force, name)
    rolls = any(p.body is not None and not p.offset.dt(p.body).is_zero for p in (point, against) if p is not None)
    return _declared(load, Slip(slip.magnitude(), rolls=rolls), normal, threshold, smooth)


def dry_friction(
    joint: Joint, size: Any, *, threshold: float | None = None, smooth: float | None = None, name: str = ""
) -> Load:
    """Dry friction in a pin or a slider: a torque or force of given magnitude that opposes the joint's rate.

    A motion ends where the rate falls below the threshold (the joint would stick); for stick and slip use `kn.joints.stiction`.

    Parameters
    ----------
    joint : a pin or a slider
    size : magnitude of the torque (pin) or force (slider), ≥ 0
    threshold : rate below which sliding ends, in the unit of the joint's rate; by default 1e-4 of the largest rate so far in the
        motion
    smooth : a rate ε: the load is −size tanh(rate/ε), which has no threshold, and motions may start at rest
    name : of the load

    Raises
    ------
    ModelError
        if the joint is neither a pin nor a slider, or the threshold or ε is not above zero
    """
    kind = getattr(joint, "kind", None)
    if kind not in ("pin", "slider"):
        what = f"a {kind} joint" if isinstance(kind, str) else cut(repr(joint))
        cure = "Write the load with kn.torque_pair."
        raise expect.refusal(ModelError, "dry friction in a pin or slider joint", what, cure)
    rate = (joint.angular_velocity if kind == "pin" else joint.velocity).dot(joint.axis)
    most, eps = not_negative(size, f"a size of dry friction in {joint.name!r}"), _above_zero("smooth", smooth)
    sense = NODE_BUILDERS["sign"](rate) if eps is None else NODE_BUILDERS["tanh"](div(rate, as_expr(eps)))
    load, name = joint.axis * (-most * sense), name or f"dry friction in {joint.name}"
    pair = (
        torque_pair(joint.frame, joint.parent, load, name)
        if kind == "pin"
        else action_reaction(joint.point, joint.at, load, name)
    )
    return _declared(pair, Slip(NODE_BUILDERS["abs"](rate)), most, threshold, smooth)


def not_negative(given: Any, expected: str) -> Expr:
    """An expression; raises ModelError if it is negative at default parameters."""
    e = as_expr(given)
    value = default_of(e)
    expect.that(value is None or value >= 0, f"{expected} at or above zero", came=f"{value}")
    return e


def _declared(load: Load, slip: Slip, size: Expr, threshold: float | None, smooth: float | None) -> Load:
    presses = tuple(s for s in free_symbols([size]) if isinstance(s, Reaction))
    speed, least = slip.speed if smooth is None else None, _above_zero("threshold", threshold)
    return replace(load, slip=replace(slip, speed=speed, threshold=least, presses=presses))


def _above_zero(name: str, value: Any) -> float | None:
    """A positive speed, or None."""
    number = None if value is None else finite_number("speed", name, value)
    if number is not None and not number > 0:
        raise ModelError(f"Expected {name} > 0, a speed in the units of the model, got {value!r}.")
    return number
