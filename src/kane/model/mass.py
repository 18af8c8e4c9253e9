# SPDX-License-Identifier: BSD-3-Clause
"""Mass centres and inertias of points, bodies and sets of them, about any point; nothing is derived for it.

    I_a = Σ m p × (n_a × p),   I_ab = I_a · n_b,   I^{S/O} = Σ I^{B/B*} + m (p² 1 − p p)

with p from the point O to the mass centres (Kane & Levinson 1985, ch. 3).
"""

from collections.abc import Iterable, Iterator
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import add
from kane.expr.collect import collected
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.operators import sqrt
from kane.expr.symbols import Parameter
from kane.model.bodies import Body, Part, RigidBody, parts_of
from kane.model.directions import check_unit
from kane.model.inertia import parallel_axis
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Dyadic, Vector


def mass_center(bodies: Any, origin: Point) -> Vector:
    """Position of the mass centre of bodies from `origin`: Σ m p / Σ m (Kane & Levinson 1985, sec. 3.1).

    Parameters
    ----------
    bodies : a body, or a list of bodies
    origin : the point from which it is seen

    Raises
    ------
    ModelError
        if these are no bodies, or their masses are zero altogether
    """
    parts = parts_listed(bodies)
    _check_point(origin, "seen from")
    mass = _mass(parts)
    moment = sum((p.mass_center.position(origin) * p.mass for p in parts), start=Vector())
    return (moment / mass).map(collected)


def inertia_about(bodies: Any, point: Point) -> Dyadic:
    """Inertia dyadic of bodies about a point, each body along its own frame (Kane & Levinson 1985, sec. 3.5, 3.6).

    Parameters
    ----------
    bodies : a body, or a list of bodies
    point : the point, which needs no body
    """
    parts = parts_listed(bodies)
    _check_point(point, "about which an inertia is asked for")
    return _along_one(sum((_about(part, point) for part in parts), start=Dyadic()))


def inertia_matrix(bodies: Any, point: Point, frame: Frame) -> Matrix:
    """Inertia matrix of bodies about a point: I_jk = n_j·I·n_k for the axes of `frame` (Kane & Levinson 1985, sec. 3.5)."""
    return inertia_about(bodies, point).components(frame)


def inertia_vector(bodies: Any, point: Point, direction: Vector) -> Vector:
    """Inertia vector I_a = Σ m p × (n_a × p) of bodies about a point for a unit vector n_a (Kane & Levinson 1985, sec. 3.3)."""
    check_unit(direction, "direction of an inertia vector")
    return inertia_about(bodies, point).dot(direction)


def moment_of_inertia(bodies: Any, point: Point, direction: Vector) -> Expr:
    """Moment of inertia n·I·n of bodies about the line through a point along a unit vector (Kane & Levinson 1985, sec. 3.3)."""
    return inertia_vector(bodies, point, direction).dot(direction)


def product_of_inertia(bodies: Any, point: Point, a: Vector, b: Vector) -> Expr:
    """Product of inertia n_a·I·n_b = Σ m (p × n_a)·(p × n_b), which is −Σ m x y for perpendicular unit vectors.

    Kane & Levinson 1985, sec. 3.3.
    """
    check_unit(b, "second direction of a product of inertia")
    return inertia_vector(bodies, point, a).dot(b)


def radius_of_gyration(bodies: Any, point: Point, direction: Vector) -> Expr:
    """Radius of gyration √(n·I·n / Σ m) about the line through a point along a unit vector (Kane & Levinson 1985, sec. 3.3)."""
    return sqrt(collected(moment_of_inertia(bodies, point, direction) / _mass(parts_listed(bodies))))


def composite(name: str, bodies: Any, frame: Frame, *, without: Any = ()) -> RigidBody:
    """One rigid body of bodies that move as one: mass, mass centre and central inertia (Kane & Levinson 1985, sec. 3.1, 3.6).

    Parameters
    ----------
    name : of the body
    bodies : a body, or a list of bodies
    frame : in which all of them are fixed
    without : bodies that are cut out of the others: holes

    Raises
    ------
    ModelError
        if something moves in `frame`, or nothing is left of the mass
    """
    kept = parts_listed(bodies)
    if any(p.momenta for p in kept):
        raise ModelError(
            f"Expected rigid bodies and particles for the composite {name}, got a flexible body: it deforms."
        )
    parts = [*kept, *(p._replace(mass=-p.mass, inertia=_negative(p.inertia)) for p in parts_listed(without))]
    origin, mass = kept[0].mass_center, _mass(parts)
    moment = sum((p.mass_center.position(origin) * p.mass for p in parts), start=Vector())
    center = origin.at(f"{name}*", (moment / mass).express(frame).map(collected))
    total = Dyadic()
    for p in parts:
        own = Dyadic() if p.inertia is None else p.inertia
        total = total + parallel_axis(own, p.mass, p.mass_center.position(center).express(frame))
    whole = _along(frame, total)
    symbols = free_symbols([*center.offset.scalars(), *whole.components(frame).entries])
    moving = [s for s in symbols if not isinstance(s, Parameter)]
    if moving:
        raise ModelError(
            f"Expected bodies of the composite {name} that are fixed in {frame.name}, got places or inertias there that depend on "
            f"{', '.join(map(str, moving))}. List what moves in it as bodies of their own."
        )
    return RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=whole)


def _negative(inertia: Dyadic | None) -> Dyadic | None:
    return None if inertia is None else -inertia


def _along_one(inertia: Dyadic) -> Dyadic:
    """The dyadic multiplied out, where it is written along one frame."""
    frames = [f for f in inertia.frames() if isinstance(f, Frame)]
    return _along(frames[0], inertia) if len(frames) == 1 else inertia


def _along(frame: Frame, inertia: Dyadic) -> Dyadic:
    return Dyadic.of(frame, inertia.components(frame).map(collected).rows)


def _about(part: Part, point: Point) -> Dyadic:
    """I + m (p² 1 − p p); of a point that shares momentum with others, of a flexible body, I + Σ μ (p·q 1 − p q)."""
    own = Dyadic() if part.inertia is None else part.inertia
    p = part.mass_center.position(point).gathered()
    if not part.momenta:
        return parallel_axis(own, part.mass, p)
    for other, mass in part.momenta:
        q = other.position(point).gathered()
        for frame, _ in q.parts[:1]:
            unit = Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
            own = own + unit * (mass * p.dot(q)) - p.outer(q) * mass
    return own


def parts_listed(bodies: Any) -> list[Part]:
    """The parts of a body, or of those in a list, a system or lists of lists; a ModelError for anything else."""
    return list(parts_of(_bodies(bodies)))


def _bodies(item: Any) -> Iterator[Body]:
    if isinstance(item, Body):
        yield item
    elif isinstance(item, Iterable) and not isinstance(item, str):
        for x in item:
            yield from _bodies(x)
    elif isinstance(getattr(item, "bodies", None), tuple):
        yield from _bodies(item.bodies)
    else:
        raise ModelError(
            f"Expected bodies from kn.RigidBody or kn.Particle, got {cut(repr(item))}. A point has no mass: make a body of it, "
            "kn.Particle(name, point, mass)."
        )


def _mass(parts: Iterable[Part]) -> Expr:
    mass = ZERO
    for part in parts:
        mass = add(mass, part.mass)
    if mass is ZERO:
        raise ModelError("Expected bodies with mass, got none: a mass centre needs some. List the bodies that have it.")
    return mass


def _check_point(point: Any, what: str) -> None:
    if not isinstance(point, Point):
        raise ModelError(
            f"Expected the Point {what}, got {cut(repr(point))}. Make one with at(…), or take a body's mass_center."
        )
