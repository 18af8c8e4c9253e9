# SPDX-License-Identifier: BSD-3-Clause
"""Contact of wheels and points with a plane, and of spheres: the point of contact, the particles there, constraints, friction.

A wheel is a ring of radius R about an axis w, thickened to a torus by a crown of radius r: a disk's edge has r = 0, a sphere
R = 0. With the plane's unit normal n and d the direction in the wheel's plane that points down,

    d = −(n − (n·w) w) / |n − (n·w) w|,        contact = centre + R d − r n,

which is smooth unless the wheel lies flat (n ∥ w). The rate of the height h = (contact − Q)·n over a point Q of the plane is the
relative velocity along n of the particles in contact: the multiplier of h = 0 is the normal force on the wheel's particle.

With s from the centre of another body, or the nearest point of its axis, to a sphere's centre, and n = s/|s|,

    gap = |s| − (r + r_other)            outside
    gap = r_other − r − |s|, n = −s/|s|  within, as in a bowl or a pipe

and the particles in contact are at centre − r n on both bodies, so that the gap's rate is their relative velocity along n.
Directions of slip rotate with n. If n stays perpendicular to an axis of the inertial frame, as in planar motion, they are that axis
and n × axis. Otherwise a pole p and the axes e perpendicular to it are rotated by the shortest rotation of p to n:
e − (e·n)(p + n)/(1 + p·n), which is smooth except at n = −p.

Sliding friction is a load with its slip, a threshold of the slip speed, and the reactions that must be compressive. It has no
direction at rest: a motion ends where the slip speed falls below the threshold, or, with `smooth`, the contact creeps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sqrt, sub
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Reaction
from kane.model.constraints import Constraint, check_unit, cut_of, home_of, no_slip, rolling, touching
from kane.model.joints.joint import Joint, check_attachment, fixed
from kane.model.loads import Force, Load, Slip, action_reaction, torque_pair
from kane.numeric.sampling import SEEDS, finite_number, not_negative, positive, sample
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
    radius = positive(ring[0], f"a radius of {name!r}") if ring is not None else ZERO
    rounding = positive(crown, f"a {'crown ' if ring else ''}radius of {name!r}") if crown is not None else ZERO
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
    expect.name(name, "a text as the name of a contact")
    for p in (point, plane):
        expect.instance(p, Point, f"a particle and a point of the plane for {name!r}")
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


# Spheres on spheres and cylinders, bodies with several points -------------------------------------------------------------


class _RoundBody(NamedTuple):
    """A body in contact: its frame, a point of it, and the radius of its surface."""

    frame: Frame
    point: Point
    radius: Expr


def sphere_on_sphere(
    name: str,
    wheel: Frame,
    center: Point,
    other: Frame,
    other_center: Point,
    *,
    radius: Any,
    other_radius: Any,
    inside: bool = False,
    pole: Vector | None = None,
) -> Contact:
    """Contact of a sphere with another one, or with a bowl; in planar motion, of disks. Gap |s| − (r + r_other), s between centres.

    Parameters
    ----------
    name : of the contact; its constraints are "name normal", "name 1" and "name 2"
    wheel, center : frame and centre of the first sphere; the inertial frame if it does not turn
    other, other_center : those of the other sphere; the inertial frame and a point fixed in it if it is at rest
    radius, other_radius : m, ≥ 0: a particle has the radius 0
    inside : whether the other sphere is hollow, with the first one inside: gap r_other − r − |s|
    pole : an axis of a frame, from which directions of slip are constructed: the normal must never be opposite to it. By default z
        of the inertial frame, unless the normal stays perpendicular to one of its axes

    Raises
    ------
    ModelError
        if a radius is below zero, both are, or the pole is not an axis of a frame
    """
    check_attachment(name, center, wheel)
    check_attachment(name, other_center, other)
    sides = _sides(name, (wheel, center, radius), (other, other_center, other_radius), inside)
    home = center.root().frame if pole is None else home_of(pole, f"pole of {name!r}")
    return _rounded(name, sides, center.position(other_center).express(home), Vector(), inside, pole)


def sphere_on_cylinder(
    name: str,
    wheel: Frame,
    center: Point,
    cylinder: Frame,
    axis_point: Point,
    *,
    axis: Vector,
    radius: Any,
    cylinder_radius: Any,
    inside: bool = False,
) -> Contact:
    """Contact of a sphere with a long cylinder, or a pipe: gap |s| − (r + r_cylinder), s from its axis to the sphere's centre.

    Parameters
    ----------
    name : of the contact; its constraints are "name normal", "name 1", along the axis, and "name 2", across
    wheel, center : the sphere's frame and centre; the inertial frame if it does not turn
    cylinder, axis_point : the cylinder's frame and a point of its axis; the inertial frame if it is at rest
    axis : unit vector of the axis, fixed in the cylinder
    radius, cylinder_radius : m, ≥ 0
    inside : whether the cylinder is a pipe with the sphere inside

    Raises
    ------
    ModelError
        if a radius is below zero, both are, or the axis is not fixed in the cylinder
    """
    check_attachment(name, center, wheel)
    check_attachment(name, axis_point, cylinder)
    w = fixed(axis, cylinder, f"axis of {name!r}")
    sides = _sides(name, (wheel, center, radius), (cylinder, axis_point, cylinder_radius), inside)
    apart = center.position(axis_point).express(cylinder)
    along = w * apart.dot(w)
    return _rounded(name, sides, apart - along, along, inside, w)


def capsule_on_plane(
    name: str,
    capsule: Frame,
    ends: Sequence[Point],
    plane: Point,
    *,
    radius: Any,
    normal: Vector,
    along: Vector | None = None,
    surface: Vector | None = None,
) -> tuple[Contact, ...]:
    """Contacts "name 1" and "name 2" of a capsule's end spheres with a plane; `ends` are their centres, else as `sphere_on_plane`."""
    centers = _several(name, ends, "centres of the ends", 2)
    return tuple(
        sphere_on_plane(f"{name} {k}", capsule, c, plane, radius=radius, normal=normal, along=along, surface=surface)
        for k, c in enumerate(centers, 1)
    )


def corners_on_plane(
    name: str,
    corners: Sequence[Point],
    plane: Point,
    *,
    normal: Vector,
    along: Vector | None = None,
    surface: Vector | None = None,
) -> tuple[Contact, ...]:
    """Contacts of a convex polygon or polyhedron with a plane, "name 1", "name 2", …: one for each corner.

    `corners` are particles of the body, made with `fixed_in`; other arguments as for `point_on_plane`.
    """
    return tuple(
        point_on_plane(f"{name} {k}", p, plane, normal=normal, along=along, surface=surface)
        for k, p in enumerate(_several(name, corners, "corners", 1), 1)
    )


def _several(name: str, points: Sequence[Point], what: str, least: int) -> tuple[Point, ...]:
    expect.name(name, "a text as the name of contacts")
    given = expect.items(points, f"{what} of {name!r}", "Write [P, Q].")
    expect.instances(given, Point, f"{what} of {name!r}")
    expect.that(len(given) >= least, f"{least} or more {what} of {name!r}", came=str(len(given)))
    return given


def _sides(
    name: str, own: tuple[Frame, Point, Any], other: tuple[Frame, Point, Any], inside: bool
) -> tuple[_RoundBody, _RoundBody]:
    """Both bodies, the sphere first; raises ModelError for negative radii, or a sphere too large for a hollow body."""
    expect.flag(inside, f"inside= of {name!r} to be True or False")
    a, b = (
        _RoundBody(frame, point, not_negative(radius, f"radii of {name!r}")) for frame, point, radius in (own, other)
    )
    r, s = sample([a.radius, b.radius], SEEDS[0])
    room = s > r if inside else r + s > 0
    cure = "Give the hollow body as the other one." if inside else "Give one of them a radius above zero."
    what = (
        f"the radius of the hollow body of {name!r} above that of the sphere"
        if inside
        else f"radii of {name!r} that are not both zero"
    )
    expect.that(room, what, came=f"{a.radius} = {r:.6g} and {b.radius} = {s:.6g}", cure=cure)
    return a, b


def _rounded(
    name: str, sides: tuple[_RoundBody, _RoundBody], apart: Vector, along: Vector, inside: bool, pole: Vector | None
) -> Contact:
    """The contact of a sphere with a surface whose centre is at −`apart` from its centre, and at `along` from the other's point."""
    own, other = sides
    if apart.is_zero:
        raise ModelError(
            f"Expected the centre of the sphere of {name!r} apart from that of the other body, got both at the same point."
        )
    distance = apart.magnitude()
    normal = apart / distance * (-1 if inside else 1)
    gap = sub(sub(other.radius, own.radius), distance) if inside else sub(distance, add(own.radius, other.radius))
    reach = normal * neg(own.radius)
    point = own.point.at(f"{name} point", reach)
    particle = own.point.fixed_in(own.frame, f"{name} particle", reach)
    out = neg(other.radius) if inside else other.radius
    ground = other.point.fixed_in(other.frame, f"{name} ground", along + normal * out)
    height = Constraint(f"{name} normal", "configuration", gap, ((particle, normal), (ground, -normal)), (), "N")
    slips = no_slip(particle, ground, along=_tangents(name, normal, along, pole, own.point.root().frame), name=name)
    return Contact(name, point, particle, ground, normal, height, slips)


def _tangents(name: str, normal: Vector, along: Vector, pole: Vector | None, inertial: Frame) -> tuple[Vector, Vector]:
    """Two unit vectors perpendicular to the normal and to each other, smooth as it rotates."""
    axes = (inertial.x, inertial.y, inertial.z)
    across = pole if not along.is_zero else next((e for e in axes if pole is None and e.dot(normal) is ZERO), None)
    if across is not None:
        return across, normal.cross(across)
    pole = inertial.z if pole is None else pole
    home = home_of(pole, f"pole of {name!r}")
    others = [e for e in (home.x, home.y, home.z) if e.dot(pole) is ZERO]
    expect.that(len(others) == 2 and pole.dot(pole) is ONE, f"an axis of a frame as the pole of {name!r}", pole)
    halfway = (pole + normal).gathered()
    share = add(ONE, pole.dot(normal))
    first, second = (e - halfway * div(e.dot(normal), share) for e in others)
    return first, second


# Friction loads ---------------------------------------------------------------------------------------------------------


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
    name = expect.label(name) or f"friction on {point.name}"
    load = Force(point, force, name) if against is None else action_reaction(point, against, force, name)
    rolls = any(p.body is not None and not p.offset.dt(p.body).is_zero for p in (point, against) if p is not None)
    return _declared(load, Slip(slip.magnitude(), rolls=rolls, size=share), normal, threshold, smooth)


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
    load, name = joint.axis * (-most * sense), expect.label(name) or f"dry friction in {joint.name}"
    pair = (
        torque_pair(joint.frame, joint.parent, load, name)
        if kind == "pin"
        else action_reaction(joint.point, joint.at, load, name)
    )
    return _declared(pair, Slip(NODE_BUILDERS["abs"](rate), size=most), most, threshold, smooth)


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
