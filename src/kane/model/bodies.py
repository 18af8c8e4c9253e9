# SPDX-License-Identifier: BSD-3-Clause
"""Bodies: what has mass, as parts that each have a mass centre and, where they are extended, a frame and an inertia."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeGuard, runtime_checkable

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.immutable import Immutable
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Coordinate, Parameter, Speed, Symbol
from kane.model.inertia import central_inertia
from kane.model.plausible import check_inertia, check_mass
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Dyadic


class Part(NamedTuple):
    """What moves as one in the body `name`: a mass at a mass centre, and the frame of a central inertia dyadic, if it has any.

    A point of a flexible body whose momentum is not m v has `momenta`: Σ μ v of these points, itself among them, where μ of P for Q is
    that of Q for P, and the mass is Σ μ. The kinetic energy is then ½ Σ μ v^P·v^Q over all pairs.
    """

    name: str
    mass: Expr
    mass_center: Point
    frame: Frame | None = None
    inertia: Dyadic | None = None
    momenta: tuple[tuple[Point, Expr], ...] = ()


@runtime_checkable
class Body(Protocol):
    """What has mass: a name, and parts."""

    @property
    def name(self) -> str:
        """By which results are read."""

    def parts(self) -> tuple[Part, ...]:
        """What has mass, motion and inertia."""


@runtime_checkable
class Deforming(Body, Protocol):
    """A body with coordinates of its own, the rates of these as speeds, and loads that belong to it."""

    coordinates: tuple[Coordinate, ...]
    speeds: Mapping[Speed, Expr]
    named: frozenset[Symbol]
    """Its symbols that got units without being asked."""

    @property
    def own_loads(self) -> tuple[Any, ...]:
        """The loads that its deformation exerts."""

    def defined_by(self, definitions: Mapping[Speed, Expr]) -> bool:
        """Whether some of the definitions hold a rate of it."""


def parts_of(bodies: Iterable[Body]) -> Iterator[Part]:
    """The parts of all bodies."""
    return (part for body in bodies for part in body.parts())


def extended(bodies: Iterable[Body]) -> list[tuple[str, Frame, Dyadic]]:
    """Name, frame and inertia of the parts that have both."""
    return [(x.name, x.frame, x.inertia) for x in parts_of(bodies) if x.frame and x.inertia]


def deforming(bodies: Iterable[Body]) -> tuple[Deforming, ...]:
    """The bodies with coordinates of their own."""
    return tuple([body for body in bodies if _deforms(body)])


def _deforms(body: Body) -> TypeGuard[Deforming]:
    """Whether it is one of those; a look at all that a protocol asks for takes long, and most lack the first."""
    return hasattr(body, "own_loads") and isinstance(body, Deforming)


def rigid(bodies: Iterable[Body]) -> tuple[Body, ...]:
    """The others."""
    return tuple([body for body in bodies if not _deforms(body)])


def brought_loads(bodies: Iterable[Body]) -> tuple[Any, ...]:
    """The loads that bodies bring with them."""
    return tuple(load for body in deforming(bodies) for load in body.own_loads)


def _check_center(name: str, point: Any) -> None:
    if not isinstance(point, Point):
        raise ModelError(f"Expected a Point as the place of {name}, got {cut(repr(point))}.")
    if point.body is not None:
        raise ModelError(
            f"Expected a geometric point for {name}, got {point.name}, the particle of {point.body.name} that is there now. Make the "
            "point with at(...)."
        )


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Particle(Immutable):
    """A particle: a mass at a point."""

    name: str
    point: Point
    mass: Expr

    def __init__(self, name: str, point: Point, mass: Any) -> None:
        m = as_expr(mass)
        check_mass(name, m)
        _check_center(name, point)
        for slot, value in (("name", name), ("point", point), ("mass", m)):
            object.__setattr__(self, slot, value)

    @property
    def mass_center(self) -> Point:
        """The particle's own place."""
        return self.point

    def __reduce__(self) -> tuple[Callable[..., "Particle"], tuple[Any, ...]]:
        return Particle, (self.name, self.point, self.mass)

    def parts(self) -> tuple[Part, ...]:
        """The particle itself."""
        return (Part(self.name, self.mass, self.point),)

    def __repr__(self) -> str:
        return f"Particle({self.name!r}, at {self.point.name})"


@dataclass(frozen=True, slots=True, eq=False, init=False)
class RigidBody(Immutable):
    """A rigid body: frame, mass centre, mass and central inertia dyadic.

    `inertia=(dyadic, point)` takes the inertia about another point of the body; the body keeps the central one.
    """

    name: str
    frame: Frame
    mass_center: Point
    mass: Expr
    inertia: Dyadic

    def __init__(
        self, name: str, *, frame: Frame, mass_center: Point, mass: Any, inertia: Dyadic | tuple[Dyadic, Point]
    ) -> None:
        m = as_expr(mass)
        check_mass(name, m)
        _check_center(name, mass_center)
        if not isinstance(frame, Frame):
            raise ModelError(f"Expected a Frame for the body {name}, got {cut(repr(frame))}.")
        if isinstance(inertia, tuple):
            inertia = _central(name, frame, mass_center, m, inertia)
        if not isinstance(inertia, Dyadic):
            raise ModelError(
                f"Expected an inertia dyadic for {name}, such as kn.inertia({frame.name}, Ixx, Iyy, Izz), got "
                f"{type(inertia).__name__} ({cut(inertia)}). kn.rod, kn.thin_disk, kn.box, … make those of solids."
            )
        check_inertia(name, inertia)
        mass_center.frame._check(frame)
        values = (("name", name), ("frame", frame), ("mass_center", mass_center), ("mass", m), ("inertia", inertia))
        for slot, value in values:
            object.__setattr__(self, slot, value)

    def __reduce__(self) -> tuple[Callable[..., "RigidBody"], tuple[Any, ...]]:
        return _restored, (self.name, self.frame, self.mass_center, self.mass, self.inertia)

    def parts(self) -> tuple[Part, ...]:
        """The body itself."""
        return (Part(self.name, self.mass, self.mass_center, self.frame, self.inertia),)

    def __repr__(self) -> str:
        return f"RigidBody({self.name!r}, frame {self.frame.name}, mass centre {self.mass_center.name})"


def _central(name: str, frame: Frame, center: Point, mass: Expr, about: tuple[Any, ...]) -> Dyadic:
    """The central inertia of a body whose inertia is given about another point of it."""
    if len(about) != 2 or not isinstance(about[0], Dyadic) or not isinstance(about[1], Point):
        raise ModelError(
            f"Expected inertia=dyadic, about the mass centre, or inertia=(dyadic, point) for {name}, got {cut(repr(about))}."
        )
    dyadic, point = about
    frame._check(point.frame)
    offset = center.position(point).express(frame)
    moving = [str(s) for s in free_symbols(offset.scalars()) if not isinstance(s, Parameter)]
    if moving:
        raise ModelError(
            f"Expected the inertia of {name} about a point fixed in {frame.name}, got one about {point.name}, whose place depends "
            f"on {', '.join(moving)}. Give it about a point that moves with the body, or about the mass centre {center.name}."
        )
    return central_inertia(dyadic, mass, offset)


def _restored(name: str, frame: Frame, mass_center: Point, mass: Expr, inertia: Dyadic) -> RigidBody:
    """A body that was pickled."""
    return RigidBody(name, frame=frame, mass_center=mass_center, mass=mass, inertia=inertia)
