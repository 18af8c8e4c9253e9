# SPDX-License-Identifier: BSD-3-Clause
"""The system: one frozen record of everything declared, checked locally."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from kane.errors import ModelError, ReactionError, SpeedsError
from kane.expr.build import add, mul, sub
from kane.expr.evaluate import free_symbols
from kane.expr.kinds import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Input,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    Symbol,
)
from kane.model.bodies import Body, Particle, RigidBody
from kane.model.events import Event
from kane.model.loads import Gravity, Load
from kane.model.reactions import cut_of
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class EulerParameters:
    """One set of Euler parameters in use and its quasi-rates."""

    coordinates: tuple[Coordinate, ...]
    quasi: tuple[QuasiRate, ...]


@dataclass(frozen=True, slots=True, eq=False, init=False)
class System:
    """A mechanical system: bodies, loads, speeds, reactions, in the inertial frame `inertial`.

    Parameters
    ----------
    inertial : Frame
        the root frame, in which Newton's laws hold
    bodies : sequence of RigidBody and Particle
    speeds : mapping of Speed to its definition, affine in the rates, or "rates" for u = q̇ throughout
    loads : sequence of loads and gravity
    reactions : reactions to bring into evidence
    auxiliary_speeds : explicit auxiliary speeds
    events : quantities to watch in simulations
    coordinates : their order, if not that of their first appearance
    """

    inertial: Frame
    bodies: tuple[Body, ...]
    speeds: Mapping[Speed, Expr]
    loads: tuple[Load, ...]
    gravities: tuple[Gravity, ...]
    reactions: tuple[Reaction, ...]
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    events: tuple[Event, ...]
    coordinates: tuple[Coordinate, ...]
    euler_parameters: tuple[EulerParameters, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Input, ...]
    frames: tuple[Frame, ...]
    points: tuple[Point, ...]

    def __init__(
        self,
        inertial: Any,
        *,
        bodies: Sequence[Body],
        speeds: Mapping[Speed, Any] | Literal["rates"],
        loads: Sequence[Load | Gravity] = (),
        reactions: Sequence[Reaction] = (),
        auxiliary_speeds: Sequence[AuxiliarySpeed] = (),
        events: Sequence[Event] = (),
        coordinates: Sequence[Coordinate] | None = None,
    ) -> None:
        if not isinstance(inertial, Frame) or inertial.parent is not None:
            raise ModelError(f"Expected a root frame as the inertial frame, got {inertial!r:.60}.")
        bodies, loads = tuple(bodies), tuple(loads)
        _check_bodies(bodies)
        own = tuple(x for x in loads if isinstance(x, Load))
        gravities = tuple(x for x in loads if isinstance(x, Gravity))
        if len(own) + len(gravities) != len(loads):
            raise ModelError(
                "Expected loads from kn.Force, kn.Torque, kn.gravity, kn.linear_spring, …: got something else."
            )
        reactions, auxiliary = tuple(reactions), tuple(auxiliary_speeds)
        frames, points = _places(inertial, bodies, own, (*reactions, *auxiliary))
        euler = _euler_sets(frames)
        geometry = list(_geometry(frames, points))
        found = free_symbols(geometry)
        ordered = _coordinates(found, euler, coordinates)
        definitions = _speeds(speeds, ordered, euler)
        contents = list(_contents(bodies, own, gravities))
        watched = [e.quantity for e in events]
        roots = [*geometry, *definitions.values(), *contents, *watched]
        symbols = free_symbols(roots)
        _check_inputs((*found, *free_symbols(definitions.values())))
        _check_no_accelerations(free_symbols(contents))
        _check_strays(free_symbols([*contents, *watched]), ordered, definitions, euler)
        _check_names((*symbols, *definitions, *reactions, *auxiliary))
        _check_reactions(symbols, reactions, auxiliary)
        values = {
            "inertial": inertial,
            "bodies": bodies,
            "speeds": definitions,
            "loads": own,
            "gravities": gravities,
            "reactions": reactions,
            "auxiliary_speeds": auxiliary,
            "events": tuple(events),
            "coordinates": ordered,
            "euler_parameters": euler,
            "parameters": tuple(s for s in symbols if isinstance(s, Parameter)),
            "inputs": tuple(s for s in symbols if isinstance(s, Input)),
            "frames": frames,
            "points": points,
        }
        for slot, value in values.items():
            object.__setattr__(self, slot, value)

    @property
    def rigid_bodies(self) -> tuple[RigidBody, ...]:
        """The bodies with inertia."""
        return tuple(b for b in self.bodies if isinstance(b, RigidBody))

    def all_loads(self) -> tuple[Load, ...]:
        """The loads with gravity written out: one force a body, and its potential −Σ m g·r."""
        return (*(gravity_load(g, self.bodies) for g in self.gravities), *self.loads)

    def __repr__(self) -> str:
        bodies = ", ".join(b.name for b in self.bodies)
        return f"System({bodies}; {len(self.coordinates)} coordinates, {len(self.speeds)} speeds)"


def gravity_load(gravity: Gravity, bodies: Iterable[Body]) -> Load:
    """Gravity as forces on the mass centres; without a potential where it is not constant in the inertial frame."""
    forces, potential = [], ZERO
    steady = is_constant_in_time(gravity.acceleration.scalars())
    for b in bodies:
        forces.append((b.mass_center, gravity.acceleration * b.mass))
        root = b.mass_center.root()
        steady = steady and is_constant_in_time(gravity.acceleration.components(root.frame))
        height = gravity.acceleration.dot(b.mass_center.position(root))
        potential = sub(potential, mul(b.mass, height))
    return Load(gravity.name, forces=tuple(forces), potential=potential if steady else None)


def _check_bodies(bodies: tuple[Body, ...]) -> None:
    if not bodies:
        raise ModelError("Expected at least one body, got none: nothing has mass.")
    for b in bodies:
        if not isinstance(b, Particle | RigidBody):
            raise ModelError(f"Expected a RigidBody or Particle, got {b!r:.60}.")
    if len({b.name for b in bodies}) < len(bodies):
        names = [b.name for b in bodies]
        twice = sorted({n for n in names if names.count(n) > 1})
        raise ModelError(f"Expected bodies of different names, got {', '.join(twice)} more than once.")


def _places(
    inertial: Frame, bodies: tuple[Body, ...], loads: tuple[Load, ...], symbols: Iterable[Symbol]
) -> tuple[tuple[Frame, ...], tuple[Point, ...]]:
    """Every frame and point that a body, load or reaction needs, parents first."""
    frames: dict[Frame, None] = {}
    points: dict[Point, None] = {}

    def meet_frame(frame: Frame) -> None:
        line: list[Frame] = []
        at: Frame | None = frame
        while at is not None:
            line.append(at)
            at = at.parent
        if line[-1] is not inertial:
            raise ModelError(
                f"Expected frames that descend from {inertial.name}, got {frame.name}, whose root is {line[-1].name}."
            )
        frames.update(dict.fromkeys(reversed(line)))

    def meet_point(point: Point) -> None:
        line = point.ancestry()
        if line[-1].frame is not inertial:
            raise ModelError(
                f"Expected points reached from one fixed in {inertial.name}, got {point.name}, whose root "
                f"{line[-1].name} is fixed in {line[-1].frame.name}."
            )
        for p in reversed(line):
            for frame, _ in p.offset.parts:
                meet_frame(frame)
            if p.body is not None:
                meet_frame(p.body)
            points[p] = None

    def meet_parts(v: Vector) -> None:
        for f, _ in v.parts:
            meet_frame(f)

    for b in bodies:
        if isinstance(b, RigidBody):
            meet_frame(b.frame)
        meet_point(b.mass_center)
    for load in loads:
        for point, v in load.forces:
            meet_point(point)
            meet_parts(v)
        for frame, v in load.torques:
            meet_frame(frame)
            meet_parts(v)
    for s in symbols:
        cut = cut_of(s)
        if cut is not None:
            place = cut.at
            if isinstance(place, Frame):
                meet_frame(place)
            else:
                meet_point(place)
            meet_parts(cut.along)
    if len({p.root() for p in points}) > 1:
        roots = sorted({p.root().name for p in points})
        raise ModelError(
            f"Expected points reached from one fixed point, got {', '.join(roots)}. Reach one from the other."
        )
    return tuple(frames), tuple(points)


def _geometry(frames: tuple[Frame, ...], points: tuple[Point, ...]) -> Iterator[Expr]:
    for f in frames:
        o = f.orientation
        if o is None:
            continue
        yield from o.parameters
        if o.angle is not None:
            yield o.angle
        elif o.cosines is not None:
            yield from (x for row in o.cosines for x in row)
    for p in points:
        yield from p.offset.scalars()


def _contents(bodies: tuple[Body, ...], loads: tuple[Load, ...], gravities: tuple[Gravity, ...]) -> Iterator[Expr]:
    for b in bodies:
        yield b.mass
        if isinstance(b, RigidBody):
            for left, right in b.inertia.dyads:
                yield from left.scalars()
                yield from right.scalars()
    for load in loads:
        for _, v in (*load.forces, *load.torques):
            yield from v.scalars()
        if load.potential is not None:
            yield load.potential
    for g in gravities:
        yield from g.acceleration.scalars()


def _euler_sets(frames: tuple[Frame, ...]) -> tuple[EulerParameters, ...]:
    found: dict[tuple[int, ...], EulerParameters] = {}
    for f in frames:
        o = f.orientation
        if o is not None and o.parameters:
            found[tuple(id(x) for x in o.parameters)] = EulerParameters(o.parameters, o.quasi)
    sets = tuple(found.values())
    used = [x for s in sets for x in s.coordinates]
    if len(set(used)) < len(used):
        raise ModelError("Expected different coordinates in different sets of Euler parameters, got one in two sets.")
    return sets


def _coordinates(
    found: tuple[Symbol, ...], euler: tuple[EulerParameters, ...], order: Sequence[Coordinate] | None
) -> tuple[Coordinate, ...]:
    seen = dict.fromkeys(s for s in found if isinstance(s, Coordinate))
    if order is None:
        return tuple(seen)
    if set(order) != set(seen) or len(order) != len(seen):
        raise ModelError(
            f"Expected coordinates= to list each of {', '.join(map(str, seen))} once, got {', '.join(map(str, order))}."
        )
    return tuple(order)


def _speeds(
    speeds: Mapping[Speed, Any] | str, coordinates: tuple[Coordinate, ...], euler: tuple[EulerParameters, ...]
) -> dict[Speed, Expr]:
    if isinstance(speeds, str):
        if speeds != "rates":
            raise SpeedsError(f'Expected speeds={{u1: definition, …}} or "rates", got {speeds!r}.')
        return _rates_as_speeds(coordinates, euler)
    made: dict[Speed, Expr] = {}
    for u, definition in speeds.items():
        if not isinstance(u, Speed):
            raise SpeedsError(f"Expected generalized speeds as keys of speeds=, got {u!r} ({type(u).__name__}).")
        if isinstance(definition, Vector):
            raise SpeedsError(
                f"Expected a scalar definition of {u}, got the vector {definition}. Use .dot(unit vector)."
            )
        made[u] = as_expr(definition)
    return made


def _rates_as_speeds(coordinates: tuple[Coordinate, ...], euler: tuple[EulerParameters, ...]) -> dict[Speed, Expr]:
    """u = q̇; for Euler parameters the three measure numbers of the angular velocity instead."""
    made: dict[Speed, Expr] = {}
    sets = {x: s for s in euler for x in s.coordinates}
    for q in coordinates:
        s = sets.get(q)
        if s is None:
            made[Speed.declare(_speed_name(q.name))] = q.dt
        elif q is s.coordinates[0]:
            for k, w in enumerate(s.quasi, 1):
                made[Speed.declare(f"w{k}_{q.name}")] = w
    return made


def _speed_name(name: str) -> str:
    return "u" + name[1:] if name[0] == "q" and name[1:].isdigit() else f"u_{name}"


def _check_names(symbols: Iterable[Symbol]) -> None:
    first: dict[str, Symbol] = {}
    for s in symbols:
        if isinstance(s, Rate):
            continue
        other = first.setdefault(s.name, s)
        if other is not s:
            raise ModelError(
                f"Expected one symbol of the name {s.name!r}, got two with different declarations: "
                f"{type(other).__name__}{other.declaration()[:4]} and {type(s).__name__}{s.declaration()[:4]}. Declare it once and "
                "use it in both places, or rename one."
            )


def _check_inputs(symbols: Iterable[Symbol]) -> None:
    for s in symbols:
        if isinstance(s, Input) or (isinstance(s, Rate) and isinstance(s.place, Input)):
            raise ModelError(
                f"Expected inputs in loads only, got {s} in a position, an orientation or the definition of a speed, whose "
                "acceleration needs its derivatives. Write prescribed motion as an expression of kn.time."
            )


def _check_no_accelerations(symbols: Iterable[Symbol]) -> None:
    for s in symbols:
        if isinstance(s, Rate) and not isinstance(s.place, Coordinate):
            raise ModelError(
                f"Expected loads in coordinates, rates, speeds, parameters, inputs and time, got {s}, which is not known before the "
                "equations are solved. Model a load that depends on an acceleration as mass or inertia."
            )


def _check_strays(
    symbols: Iterable[Symbol],
    coordinates: tuple[Coordinate, ...],
    speeds: Mapping[Speed, Expr],
    euler: tuple[EulerParameters, ...],
) -> None:
    known: set[Symbol] = {*coordinates, *speeds, *(w for s in euler for w in s.quasi)}
    for s in symbols:
        origin: Any = s
        while isinstance(origin, Rate):
            origin = origin.place
        if isinstance(origin, Coordinate | Speed | QuasiRate) and origin not in known:
            raise ModelError(
                f"Expected loads, masses and events in symbols of the system, got {s}: no frame or point depends on it and it is not "
                "among the keys of speeds=."
            )


def _check_reactions(
    symbols: Iterable[Symbol], reactions: tuple[Reaction, ...], auxiliary: tuple[AuxiliarySpeed, ...]
) -> None:
    listed = dict.fromkeys(reactions)
    if len(listed) < len(reactions):
        raise ReactionError("Expected each reaction once in reactions=, got one twice.")
    for s in symbols:
        if isinstance(s, Reaction) and s not in listed:
            raise ReactionError(f"The reaction {s} is used in a load but not listed: add it to System(reactions=[…]).")
    bare = [r for r in reactions if cut_of(r) is None]
    if len(bare) != len(auxiliary):
        raise ReactionError(
            f"Expected as many explicit auxiliary speeds as reactions without a place, got {len(auxiliary)} and {len(bare)} "
            f"({', '.join(map(str, bare)) or 'none'}). Give the reaction a place: kn.reaction(name, at=point, along=direction)."
        )


def total_mass(bodies: Iterable[Body]) -> Expr:
    """Σ m."""
    mass = ZERO
    for b in bodies:
        mass = add(mass, b.mass)
    return mass
