# SPDX-License-Identifier: BSD-3-Clause
"""Contact of spheres with spheres and cylinders, and of bodies that touch a plane at several points.

With s from the centre of the other body, or the nearest point of its axis, to the sphere's centre, and n = s/|s|,

    gap = |s| − (r + r_other)            outside
    gap = r_other − r − |s|, n = −s/|s|  within, as in a bowl or a pipe

and the particles in contact are at centre − r n on both bodies, so that the gap's rate is their relative velocity along n.

Directions of slip rotate with n. If n stays perpendicular to an axis of the inertial frame, as in planar motion, they are that axis
and n × axis. Otherwise a pole p and the axes e perpendicular to it are rotated by the shortest rotation of p to n:
e − (e·n)(p + n)/(1 + p·n), which is smooth except at n = −p.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from kane import expect
from kane.errors import ModelError
from kane.expr.build import add, div, neg, sub
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.model.constraints import Constraint, home_of, no_slip
from kane.model.joints.contact import Contact, point_on_plane, sphere_on_plane
from kane.model.joints.joint import check_attachment, fixed
from kane.numeric.sampling import SEEDS, sample
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


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
    given = expect.items(points, f"{what} of {name!r}", "Write [P, Q].")
    expect.instances(given, Point, f"{what} of {name!r}")
    expect.that(len(given) >= least, f"{least} or more {what} of {name!r}", came=str(len(given)))
    return given


def _sides(
    name: str, own: tuple[Frame, Point, Any], other: tuple[Frame, Point, Any], inside: bool
) -> tuple[_RoundBody, _RoundBody]:
    """Both bodies, the sphere first; raises ModelError for negative radii, or a sphere too large for a hollow body."""
    a, b = (_RoundBody(frame, point, as_expr(radius)) for frame, point, radius in (own, other))
    r, s = sample([a.radius, b.radius], SEEDS[0])
    for side, value in ((a, r), (b, s)):
        expect.that(value >= 0, f"radii of {name!r} at or above zero", came=f"{side.radius} = {value:.6g}")
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
