# SPDX-License-Identifier: BSD-3-Clause
"""The system: one frozen record of everything declared, checked locally."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from inspect import signature
from types import MappingProxyType
from typing import Any, Literal

from kane import show
from kane.errors import ModelError, none_of
from kane.expr.build import add, mul, sub
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Parameter, Reaction, Speed, StateVariable, Symbols
from kane.model import checks
from kane.model.actions import check_actions, expressions
from kane.model.bodies import Body, Part, RigidBody, brought_loads, deforming, extended, parts_of, rigid
from kane.model.checks import listed
from kane.model.completed import completed
from kane.model.constraints import Constraint, as_constraints
from kane.model.declarations import Declarations, Event
from kane.model.doubtful import warn_of_doubts
from kane.model.joints.joint import Joint, with_joints
from kane.model.loads import Gravity, Load
from kane.model.plausible import check_turning
from kane.model.scalar_loads import with_forces
from kane.model.states import check_states, state_rates
from kane.model.survey import contents, geometry, places
from kane.model.units import check_units
from kane.model.variables import (
    by_name,
    euler_sets,
    inputs_with_rates,
    moved,
    ordered_coordinates,
    speed_definitions,
)
from kane.space.frame import Frame
from kane.space.point import Point


@dataclass(frozen=True, slots=True, eq=False, init=False)
class System(Declarations):
    """A mechanical system: bodies, loads, speeds, constraints, reactions, in the inertial frame `inertial`.

    Parameters
    ----------
    inertial : Frame
        the root frame, in which Newton's laws hold
    bodies : sequence of RigidBody and Particle
    speeds : mapping of Speed to its definition, affine in the rates, or "rates" for u = q̇ throughout; left out, the joints' own.
        Under constraints the independent ones alone will do: rates of constraints, w1, w2, …, complete them, and vanish
    loads : sequence of loads and gravity
    reactions : reactions to bring into evidence
    auxiliary_speeds : explicit auxiliary speeds
    events : quantities to watch in simulations
    coordinates : their order, if not that of the joints, then that of their first appearance
    holonomic : configuration constraints f(q, t) = 0: from `kn.coincident`, `kn.distance`, …, or scalars that must vanish
    nonholonomic : motion constraints, affine in the rates: from `kn.rolling`, `kn.no_slip`, or scalars that must vanish
    dependent_coordinates : which coordinates the configuration constraints give, chosen by rank if left out
    dependent_speeds : which speeds the constraints give, in the order in which they are to stand; chosen by rank if left out
    joints : joints to be known by name; their coordinates and speeds come first, in this order. Where `speeds` defines the rates of
        one otherwise, these definitions take their place
    states : further states with their rates, {a: (e - a)/tau}: an activation, a current, the integral of a controller. Loads and
        events may depend on them; rates may hold coordinates, their rates, speeds, states, parameters, inputs and time
    """

    def __init__(
        self,
        inertial: Any,
        *,
        bodies: Sequence[Body],
        speeds: Mapping[Speed, Any] | Literal["rates"] | None = None,
        loads: Sequence[Load | Gravity] = (),
        reactions: Sequence[Reaction] = (),
        auxiliary_speeds: Sequence[AuxiliarySpeed] = (),
        events: Sequence[Event] = (),
        coordinates: Sequence[Coordinate | str] | None = None,
        holonomic: Any = (),
        nonholonomic: Any = (),
        dependent_coordinates: Sequence[Coordinate | str] = (),
        dependent_speeds: Sequence[Speed | str] = (),
        joints: Sequence[Joint] = (),
        states: Mapping[StateVariable, Any] = MappingProxyType({}),
    ) -> None:
        checks.check_inertial(inertial)
        bodies, loads = listed("bodies", bodies), listed("loads", loads)
        checks.check_bodies(bodies)
        checks.check_loads(loads)
        events, joints = listed("events", events), listed("joints", joints)
        checks.check_joints(joints)
        movers = (*joints, *deforming(bodies))
        told, first = with_joints(speeds, movers), (q for mover in movers for q in mover.coordinates)
        own = with_forces((x for x in (*loads, *brought_loads(bodies)) if isinstance(x, Load)), inertial, bodies, told)
        gravities = tuple(x for x in loads if isinstance(x, Gravity))
        reactions, auxiliary = listed("reactions", reactions), listed("auxiliary_speeds", auxiliary_speeds)
        checks.check_listed("reactions", reactions, Reaction, "kn.reaction")
        checks.check_listed("auxiliary_speeds", auxiliary, AuxiliarySpeed, "kn.auxiliary_speed")
        checks.check_events(events)
        constraints = (*as_constraints(holonomic, "configuration"), *as_constraints(nonholonomic, "motion"))
        checks.check_constraints(constraints, reactions)
        frames, points = places(inertial, bodies, own, (*reactions, *auxiliary), constraints)
        euler, shape = euler_sets(frames), list(geometry(frames, points))
        ordered = ordered_coordinates(free_symbols([*shape, *moved(told, constraints)]), coordinates, first)
        vanishing = completed(definitions := speed_definitions(told, ordered, euler), ordered, euler, constraints)
        definitions |= vanishing
        matter, further = list(contents(bodies, own, gravities)), state_rates(states)
        watched = [*matter, *expressions(events), *(c.expr for c in constraints), *further, *further.values()]
        symbols = free_symbols([*shape, *definitions.values(), *watched])
        checks.check_geometry(free_symbols(shape))
        checks.check_no_accelerations(free_symbols(matter))
        checks.check_strays(free_symbols(watched), ordered, definitions, euler)
        checks.check_names((*symbols, *definitions, *reactions, *auxiliary))
        checks.check_reactions(symbols, reactions, auxiliary)
        dependent_q = by_name(dependent_coordinates, ordered)
        dependent_u = Symbols((*by_name(dependent_speeds, definitions), *vanishing))
        checks.check_all_dependent(dependent_q, ordered, dependent_u, definitions, constraints)
        parameters = Symbols(s for s in symbols if isinstance(s, Parameter))
        inputs = Symbols(inputs_with_rates(symbols, shape + list(definitions.values()), constraints))
        Declarations.__init__(
            self, inertial, bodies, definitions, further, own, gravities, Symbols(reactions), Symbols(auxiliary), tuple(events),
            ordered, constraints, dependent_q, dependent_u, joints, euler, parameters, inputs, frames, points,
        )  # fmt: skip
        _check(self, symbols)
        warn_of_doubts(inertial, tuple(parts_of(bodies)), gravities, constraints)
        check_turning(inertial, extended(rigid(bodies)))

    @property
    def rigid_bodies(self) -> tuple[RigidBody, ...]:
        """The bodies with inertia."""
        return tuple(b for b in self.bodies if isinstance(b, RigidBody))

    @property
    def holonomic(self) -> tuple[Constraint, ...]:
        """The configuration constraints."""
        return tuple(c for c in self.constraints if c.kind == "configuration")

    @property
    def nonholonomic(self) -> tuple[Constraint, ...]:
        """The motion constraints."""
        return tuple(c for c in self.constraints if c.kind == "motion")

    def replace(self, **changes: Any) -> System:
        """The same system with some arguments of `System(…)` changed: `system.replace(speeds="rates")`."""
        values = {name: getattr(self, name) for name in _ARGUMENTS} | {"loads": self._given_loads()}
        unknown = changes.keys() - values.keys()
        if unknown:
            raise ModelError(f"Expected some of {', '.join(values)} to replace, got {', '.join(sorted(unknown))}.")
        return System(self.inertial, **(values | changes))

    def __reduce__(self) -> tuple[Callable[..., System], tuple[Any, ...]]:
        arguments = {name: getattr(self, name) for name in _ARGUMENTS} | {"loads": self._given_loads()}
        return _restored, (self.frames, self.points, self.inertial, arguments)

    def _given_loads(self) -> tuple[Load | Gravity, ...]:
        """The loads but for those that bodies bring with them."""
        brought = brought_loads(self.bodies)
        return (*self.gravities, *(x for x in self.loads if all(x is not y for y in brought)))

    def redefined(self, speeds: Mapping[Speed, Expr]) -> System:
        """The same system by other generalized speeds, made of its own and not checked; none is dependent."""
        values = {f.name: getattr(self, f.name) for f in fields(Declarations)}
        other = object.__new__(System)
        Declarations.__init__(other, **(values | {"speeds": speeds, "dependent_speeds": ()}))
        return other

    def with_loads(self, loads: Sequence[Load]) -> System:
        """The same system with other loads beside gravity, made of its own and not checked."""
        values = {f.name: getattr(self, f.name) for f in fields(Declarations)}
        other = object.__new__(System)
        Declarations.__init__(other, **(values | {"loads": tuple(loads)}))
        return other

    def __getitem__(self, name: str) -> Joint | Body | Frame | Point | Load | Constraint:
        """The joint, body, frame, point, load or constraint of that name, looked up in this order."""
        first: list[Joint | Body | Frame | Point] = [*self.joints, *self.bodies, *self.frames, *self.points]
        known = [x.name for x in first]
        if name in known:
            return first[known.index(name)]
        others: list[Load | Constraint] = [*self.all_loads(), *self.constraints]
        for item in others:
            if item.name == name:
                return item
        raise ModelError(f"Expected the name of a joint, body, frame, point or load, one of {none_of(known, name)}")

    def all_loads(self) -> tuple[Load, ...]:
        """The loads with gravity written out: one force a body, and its potential −Σ m g·r."""
        return (*(gravity_load(g, self.bodies) for g in self.gravities), *self.loads)

    _repr_html_ = show.html

    def __repr__(self) -> str:
        bodies = ", ".join(b.name for b in self.bodies)
        return f"System({bodies}; {len(self.coordinates)} coordinates, {len(self.speeds)} speeds)"


def _check(system: System, symbols: Sequence[Any]) -> None:
    """States, events and units, of a system that is declared as a whole."""
    check_states(system, symbols)
    check_actions(system)
    check_units(system, symbols)


_ARGUMENTS = tuple(name for name in signature(System).parameters if name != "inertial")


def _restored(frames: object, points: object, inertial: Frame, arguments: Mapping[str, Any]) -> System:
    """A system that was pickled, after its frames and points, parents first."""
    return System(inertial, **arguments)


def gravity_load(gravity: Gravity, bodies: Iterable[Body]) -> Load:
    """Gravity as forces on the mass centres; without a potential where it is not constant in the inertial frame."""
    forces, potential = [], ZERO
    steady = is_constant_in_time(gravity.acceleration.scalars())
    for part in parts_of(bodies):
        forces.append((part.mass_center, gravity.acceleration * part.mass))
        root = part.mass_center.root()
        steady = steady and is_constant_in_time(gravity.acceleration.components(root.frame))
        height = gravity.acceleration.dot(part.mass_center.position(root))
        potential = sub(potential, mul(part.mass, height))
    return Load(gravity.name, forces=tuple(forces), potential=potential if steady else None)


def total_mass(parts: Iterable[Part]) -> Expr:
    """Σ m."""
    mass = ZERO
    for part in parts:
        mass = add(mass, part.mass)
    return mass
