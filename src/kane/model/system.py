# SPDX-License-Identifier: BSD-3-Clause
"""The system: one frozen record of all declarations, checked locally.

`scaffold` makes systems without bodies, of frames and points with speeds and constraints, for kinematics alone.

Loads given by a function V(q, t) or R(q, q̇, t), F_r = −Σ_s ∂V/∂q_s W_sr or F_r = −∂R/∂u_r (Kane & Levinson 1985, sec. 5.1, 5.3),
are replaced by forces and torques. The force Q_s of the rate of one coordinate, v·F = Q_s q̇_s, becomes a pair of torques if a frame
of a body is rotated by the coordinate alone; otherwise a force on a point displaced by it along the first axis of the inertial frame,
or a torque on a frame rotated by it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import reduce
from inspect import signature
from types import MappingProxyType
from typing import Any, Literal, cast

from kane import expect, show
from kane.errors import KaneWarning, ModelError, none_of
from kane.expr.build import add, mul, sub
from kane.expr.differentiation import diff
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Symbols,
    input_of,
    rate,
)
from kane.expr.visit import substituted
from kane.model import system_checks
from kane.model.bodies import Body, Deforming, Part, RigidBody, brought_loads, check_turning, deforming, parts_of
from kane.model.constraints import Constraint, as_constraints
from kane.model.contact_modes import additions
from kane.model.contacts import ContactLaw, ContactMode, contact_rows, given_modes, laws_of
from kane.model.declarations import (
    Declarations,
    Event,
    by_name,
    check_actions,
    completed,
    contents,
    euler_sets,
    expressions,
    frames_and_points,
    geometry,
    inputs_with_rates,
    moved,
    ordered_coordinates,
    speed_definitions,
)
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load
from kane.model.system_checks import check_states, listed, state_rates, warn_of_doubts
from kane.model.unit_checks import check_units
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Vector, axes
from kane.units.rules import parse


@dataclass(frozen=True, slots=True, eq=False, init=False)
class System(Declarations):
    """A mechanical system: bodies, loads, generalized speeds, constraints and reactions, declared for `kn.derive`.

    Parameters
    ----------
    inertial : Frame
        the root frame, in which Newton's laws hold
    bodies : sequence of RigidBody and Particle
    speeds : mapping of each Speed to its definition, affine in the rates q̇, or "rates" for u = q̇; by default the speeds of
        `joints`. Under constraints the independent speeds suffice: further ones w1, w2, …, rates of constraints and therefore
        zero, complete them
    loads : loads and gravity, from `kn.Force`, `kn.linear_spring`, `kn.gravity`, …
    reactions : noncontributing forces and torques to bring into evidence, from `kn.reaction`
    auxiliary_speeds : explicit auxiliary speeds, from `kn.auxiliary_speed`
    events : events of simulations, from `kn.Event`
    coordinates : order of the coordinates; by default those of the joints, then the others as they first appear
    holonomic : configuration constraints f(q, t) = 0, from `kn.coincident`, `kn.distance`, …, or expressions f
    nonholonomic : motion constraints, affine in the rates, from `kn.rolling`, `kn.no_slip`, …, or expressions f
    dependent_coordinates : the coordinates to solve the configuration constraints for; by default chosen by rank
    dependent_speeds : the speeds to solve the constraints for, in their order; by default chosen by rank
    joints : joints whose names `eom.reaction` and others take; their coordinates and speeds come first, in this order. If `speeds`
        defines other speeds for the rates of a joint, these replace the joint's
    states : further states with their rates, {a: (e - a)/tau}: an activation, a current, the integral of a controller. Loads and
        events may depend on them; rates may contain coordinates, their rates, speeds, states, parameters, inputs and time
    contacts : contacts with friction and impacts, from `kn.contact`, `kn.joints.stop`, …. In the system itself all are separated,
        or without effect; `system.in_modes(…)` is the system in other modes
    """

    _other_names = MappingProxyType(
        {"bodies": "bodylist", "loads": "forces forcelist loadlist", "coordinates": "q", "speeds": "u", "inputs": "r"}
    )

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
        contacts: Sequence[ContactLaw] = (),
    ) -> None:
        system_checks.check_inertial(inertial)
        bodies, loads = listed("bodies", bodies), listed("loads", loads)
        system_checks.check_matter(bodies, loads)
        joints = listed("joints", joints, Joint, "kn.pin, kn.slider, …", named=True)
        movers = (*joints, *deforming(bodies))
        told, first = _with_joints(speeds, movers), (q for mover in movers for q in mover.coordinates)
        own = with_forces((x for x in (*loads, *brought_loads(bodies)) if isinstance(x, Load)), inertial, bodies, told)
        gravities = tuple(x for x in loads if isinstance(x, Gravity))
        along = placed(frame for g in gravities for frame in frames_of(g.acceleration))
        reactions = listed("reactions", reactions, Reaction, "kn.reaction")
        auxiliary = listed("auxiliary_speeds", auxiliary_speeds, AuxiliarySpeed, "kn.auxiliary_speed")
        events = listed("events", events, Event, "kn.Event(name, quantity)", named=True)
        constraints = as_constraints(holonomic, "configuration") + as_constraints(nonholonomic, "motion")
        contacts = listed("contacts", contacts, ContactLaw, "kn.contact(place, mu), kn.joints.stop, …", named=True)
        rows, laws = [*constraints, *contact_rows(contacts)], laws_of(contacts)
        system_checks.check_constraints(constraints, reactions)
        frames, points = frames_and_points(inertial, bodies, (*own, along), (*reactions, *auxiliary), tuple(rows))
        euler, shape = euler_sets(frames), list(geometry(frames, points))
        ordered = ordered_coordinates(free_symbols([*shape, *moved(told, constraints)]), coordinates, first)
        vanishing = completed(definitions := speed_definitions(told, ordered, euler), ordered, euler, constraints)
        definitions |= vanishing
        matter, further = list(contents(bodies, own, gravities)), state_rates(states)
        watched = [*matter, *expressions(events), *(c.expr for c in rows), *laws, *further, *further.values()]
        symbols = free_symbols([*shape, *definitions.values(), *watched])
        system_checks.check_geometry(free_symbols(shape))
        system_checks.check_no_accelerations(free_symbols(matter))
        system_checks.check_strays(free_symbols(watched), ordered, definitions, euler)
        system_checks.check_names((*symbols, *definitions, *reactions, *auxiliary))
        system_checks.check_reactions(symbols, reactions, auxiliary)
        dependent_q = by_name(dependent_coordinates, ordered)
        dependent_u = Symbols((*by_name(dependent_speeds, definitions), *vanishing))
        system_checks.check_dependent("coordinates", dependent_q, ordered, constraints, "configuration")
        system_checks.check_dependent("speeds", dependent_u, definitions, constraints, "configuration", "motion")
        parameters = Symbols(s for s in symbols if isinstance(s, Parameter))
        inputs = Symbols(inputs_with_rates(symbols, shape + list(definitions.values()), rows))
        Declarations.__init__(
            self, inertial, bodies, definitions, further, _counted(own, inputs), gravities, Symbols(reactions), Symbols(auxiliary),
            events, ordered, show.Listing(constraints), dependent_q, dependent_u, joints, euler, parameters, inputs,
            show.Listing(frames), show.Listing(points), contacts,
        )  # fmt: skip
        _check_whole(self, symbols)

    @property
    def rigid_bodies(self) -> tuple[RigidBody, ...]:
        """The rigid bodies, without particles and beams."""
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
        """A copy of the system with some arguments of `System(…)` changed: `system.replace(speeds="rates")`."""
        values = self._given()
        expect.none(sorted(changes.keys() - values.keys()), f"some of {', '.join(values)} to replace")
        return System(self.inertial, **(values | changes))

    def in_modes(self, modes: Mapping[ContactLaw | str, ContactMode | str] | Sequence[ContactMode]) -> System:
        """The system with contacts in given modes, {contact: "stick"}; those left out are separated, or stick if they have no gap.

        Closed gaps and sticking slips become constraints with their forces as reactions, friction of slipping contacts becomes
        loads, and events mark the end of the mode.
        """
        every, values = given_modes(self.contacts, modes), self._given()
        added = additions(self.contacts, every)
        own = self.quietly(**{name: tuple(dict.fromkeys((*values[name], *more))) for name, more in added.items()})
        return own._remade(contacts=self.contacts, modes=every)

    def quietly(self, **changes: Any) -> System:
        """A copy of the system without its contacts and with other arguments changed; it repeats no warnings."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KaneWarning)
            return self.replace(contacts=(), **changes)

    def __reduce__(self) -> tuple[Callable[..., System], tuple[Any, ...]]:
        return _restored, (self.frames, self.points, self.inertial, self._given())

    def _given(self) -> dict[str, Any]:
        """The arguments of the system, without the loads that belong to bodies."""
        brought = brought_loads(self.bodies)
        loads = (*self.gravities, *(x for x in self.loads if all(x is not y for y in brought)))
        return {name: getattr(self, name) for name in _ARGUMENTS} | {"loads": loads}

    def redefined(self, speeds: Mapping[Speed, Expr]) -> System:
        """A copy of the system with other generalized speeds, all independent; the definitions are not checked."""
        return self._remade(speeds=speeds, dependent_speeds=())

    def with_loads(self, loads: Sequence[Load]) -> System:
        """A copy of the system with other loads, gravity apart; they must use its symbols, frames and points, which is not checked."""
        return self._remade(loads=tuple(loads))

    def _remade(self, **changes: Any) -> System:
        values = {f.name: getattr(self, f.name) for f in fields(Declarations)}
        other = object.__new__(System)
        Declarations.__init__(other, **(values | changes))
        return other

    def __getitem__(self, name: str) -> Joint | Body | Frame | Point | Load | Constraint:
        """The joint, body, frame, point, load or constraint of that name, looked up in this order."""
        first: list[Joint | Body | Frame | Point] = [*self.joints, *self.bodies, *self.frames, *self.points]
        for item in (*first, *self.all_loads(), *self.constraints):
            if item.name == name:
                return item
        known = none_of([x.name for x in first], name)
        raise ModelError(f"Expected the name of a joint, body, frame, point or load, one of {known}")

    def all_loads(self) -> tuple[Load, ...]:
        """All loads, gravity as one force for each body with the potential −Σ m g·r."""
        return (*(gravity_load(g, self.bodies) for g in self.gravities), *self.loads)

    _repr_html_ = show.html

    def __repr__(self) -> str:
        bodies = ", ".join(b.name for b in self.bodies)
        return f"System({bodies}; {show.counts(coordinates=len(self.coordinates), speeds=len(self.speeds))})"


def _check_whole(system: System, symbols: Sequence[Symbol]) -> None:
    """Checks of the whole system: further states, actions and units, and warnings about bodies and contacts."""
    check_states(system, symbols)
    check_actions(system)
    check_units(system, symbols)
    warn_of_doubts(system.inertial, tuple(parts_of(system.bodies)), system.gravities, system.constraints)
    check_turning(system.inertial, system.bodies)


_ARGUMENTS = tuple(name for name in signature(System).parameters if name != "inertial")


def _restored(frames: object, points: object, inertial: Frame, arguments: Mapping[str, Any]) -> System:
    """Restore a pickled system; frames and points are arguments so that they are restored first, parents before children."""
    return System(inertial, **arguments)


def gravity_load(gravity: Gravity, bodies: Iterable[Body]) -> Load:
    """Gravity as forces on the mass centres, without a potential unless it is constant in the inertial frame."""
    forces, potential, steady = [], ZERO, is_constant_in_time(gravity.acceleration.scalars())
    for part in parts_of(bodies):
        forces.append((part.mass_center, gravity.acceleration * part.mass))
        root = part.mass_center.root()
        steady = steady and is_constant_in_time(gravity.acceleration.components(root.frame))
        height = gravity.acceleration.dot(part.mass_center.position(root))
        potential = sub(potential, mul(part.mass, height))
    return Load(gravity.name, forces=tuple(forces), potential=potential if steady else None)


def total_mass(parts: Iterable[Part]) -> Expr:
    """The total mass Σ m."""
    return reduce(add, (part.mass for part in parts), ZERO)


def scaffold(
    inertial: Frame,
    speeds: Mapping[Speed, Any] | str,
    of: Sequence[Frame | Point],
    holonomic: Any,
    nonholonomic: Any,
    dependent_speeds: Sequence[Speed | str],
    coordinates: Sequence[Coordinate | str] | None,
) -> System:
    """The system of frames and points; a coordinate whose rate defines a speed may be absent from all of them."""
    system_checks.check_inertial(inertial)
    constraints = (*as_constraints(holonomic, "configuration"), *as_constraints(nonholonomic, "motion"))
    frames, points = frames_and_points(inertial, (), (placed(system_checks.listed("of", of)),), (), constraints)
    euler = euler_sets(frames)
    shape = list(geometry(frames, points))
    ordered = ordered_coordinates(free_symbols([*shape, *moved(speeds, constraints), *_moving(speeds)]), coordinates)
    vanishing = completed(definitions := speed_definitions(speeds, ordered, euler), ordered, euler, constraints)
    definitions |= vanishing
    watched = [c.expr for c in constraints]
    symbols = free_symbols([*shape, *definitions.values(), *watched])
    system_checks.check_geometry(free_symbols(shape))
    system_checks.check_strays(free_symbols(watched), ordered, definitions, euler)
    system_checks.check_names((*symbols, *definitions))
    dependent = Symbols((*by_name(dependent_speeds, definitions), *vanishing))
    system_checks.check_dependent("speeds", dependent, definitions, constraints, "configuration", "motion")
    parameters = Symbols(s for s in symbols if isinstance(s, Parameter))
    inputs = Symbols(inputs_with_rates(symbols, shape + list(definitions.values()), constraints))
    system = object.__new__(System)
    Declarations.__init__(
        system, inertial, (), definitions, {}, (), (), Symbols(()), Symbols(()), (), ordered, constraints, Symbols(()), dependent,
        (), euler, parameters, inputs, frames, points,
    )  # fmt: skip
    check_units(system, symbols)
    return system


def placed(items: Iterable[Any]) -> Load:
    """A load of zero forces at points and frames, so that `frames_and_points` finds their parents."""
    expected = "frames and points of which motions are asked"
    kept = expect.instances(items, (Frame, Point), expected, "Give a body's frame, or its mass_center.")
    forces = tuple((x, Vector()) for x in kept if isinstance(x, Point))
    torques = tuple((x, Vector()) for x in kept if isinstance(x, Frame))
    return Load("", forces=forces, torques=torques)


def _moving(speeds: Mapping[Speed, Any] | str) -> list[Symbol]:
    """The coordinates whose rates are in the definitions of speeds."""
    held = free_symbols(x for x in speeds.values() if hasattr(x, "op")) if isinstance(speeds, Mapping) else ()
    places = [s.place if isinstance(s, QuasiRate) else (s.place,) for s in held if isinstance(s, Rate | QuasiRate)]
    return [q for place in places if isinstance(place, tuple) for q in place if isinstance(q, Coordinate)]


Pulls = list[tuple[Coordinate | QuasiRate, Expr]]
_LENGTH_EXPONENTS = parse("m").exponents


def with_forces(loads: Iterable[Load], inertial: Frame, bodies: Sequence[Body], speeds: Any) -> tuple[Load, ...]:
    """The loads, with forces and torques for those given by a function; `speeds` defines the speeds that these may contain."""
    placeless = ((x, x.scalar is not None and not x.forces and not x.torques) for x in loads)
    return show.Listing(_placed(x, _pulls(x, speeds), inertial, bodies) if bare else x for x, bare in placeless)


def _pulls(load: Load, speeds: Any) -> Pulls:
    """Q_s = −∂V/∂q_s, or −∂R/∂q̇_s, by coordinate, and −∂R/∂w by quasi-rate."""
    assert load.scalar is not None
    if load.potential is not None:
        return [(q, -diff(load.potential, q)) for q in free_symbols([load.potential]) if isinstance(q, Coordinate)]
    by_speed = speeds if isinstance(speeds, Mapping) else {}
    known: dict[Expr, Expr] = {
        u: as_expr(e) for u, e in by_speed.items() if isinstance(u, Speed) and not isinstance(e, Vector)
    }
    function = substituted(load.scalar, known)
    left = [s for s in free_symbols([function]) if isinstance(s, Speed)]
    names = ", ".join(u.name for u in known if isinstance(u, Speed)) or "none, as all are rates"
    expected = f"the dissipation function of {load.name!r} in rates or in speeds that the system defines ({names})"
    expect.none(left[:1], expected, "{} in it", "Write it by rates, q.dt.")
    moved_by = ((s, s if isinstance(s, QuasiRate) else getattr(s, "place", None)) for s in free_symbols([function]))
    return [(x, -diff(function, s)) for s, x in moved_by if isinstance(x, Coordinate | QuasiRate)]


def _turning(frames: Iterable[Frame]) -> Mapping[Symbol, tuple[Frame, Frame, Vector]]:
    """For each coordinate the frame rotated by it alone, the parent frame, and the axis; for quasi-rates likewise."""
    result: dict[Symbol, tuple[Frame, Frame, Vector]] = {}
    for frame in frames:
        o, parent = frame.orientation, frame.parent
        if o is None or parent is None:
            continue
        for w, along in zip(o.quasi, axes(frame), strict=False):
            result.setdefault(w, (frame, parent, along))
        if o.axis is None or o.angle is None:
            continue
        before = parent.orientation
        start = before.angle if before is not None and before.base is o.base and before.axis == o.axis else None
        for q in free_symbols([o.angle]):
            if isinstance(q, Coordinate) and o.angle is (q if start is None else add(start, q)):
                result.setdefault(q, (frame, parent, axes(parent)[o.axis]))
    return result


def _placed(load: Load, pulls: Pulls, inertial: Frame, bodies: Sequence[Body]) -> Load:
    frames, points = frames_and_points(inertial, tuple(bodies), (), ())
    root = points[0].root()
    turning, angles = _turning(frames), set(free_symbols(geometry(frames, ())))
    forces: list[tuple[Point, Vector]] = []
    torques: list[tuple[Frame, Vector]] = []
    for q, pull in pulls:
        name = f"{load.name} by {q.name}"
        if pull is ZERO:
            continue
        if q in turning:
            frame, base, axis = turning[q]
            torque = axis * pull
            torques += [(frame, torque), *([] if base is inertial else [(base, -torque)])]
        elif isinstance(q, QuasiRate):
            *e, k = cast(tuple[Any, ...], q.place)
            frame = inertial.rotate_euler_parameters(name, e)
            torques.append((frame, axes(frame)[k - 1] * pull))
        elif parse(q.unit).exponents == _LENGTH_EXPONENTS if q.unit else q not in angles:
            forces.append((root.at(name, inertial.x * q), inertial.x * pull))
        else:
            torques.append((inertial.rotate(name, q, inertial.x), inertial.x * pull))
    return replace(load, forces=tuple(forces), torques=tuple(torques))


def _counted(loads: tuple[Load, ...], inputs: Symbols[Any]) -> tuple[Load, ...]:
    """Loads without potentials whose rates contain rates of inputs that are not needed otherwise: their work counts as power."""
    held = ((x, () if x.potential is None or not inputs else free_symbols([x.potential])) for x in loads)
    pairs = ((x, any(input_of(s) is not None and rate(s) not in inputs for s in own)) for x, own in held)
    return show.Listing(replace(x, potential=None) if unknown else x for x, unknown in pairs)


def _with_joints(
    speeds: Mapping[Speed, Any] | str | None, joints: Sequence[Joint | Deforming]
) -> Mapping[Speed, Any] | str:
    """The definitions of the speeds: for each joint its own, or those of its rates in `speeds`, then the others."""
    if isinstance(speeds, str) or not (speeds is None or isinstance(speeds, Mapping)):
        return speeds  # other types are refused later, by `speed_definitions`
    if speeds is None and not joints:
        raise ModelError('Expected speeds={u: definition, …}, "rates", or joints= with speeds of their own, got none.')
    definitions = dict(speeds or {})
    scalars = {u: as_expr(e) for u, e in definitions.items() if not isinstance(e, Vector)}
    own: dict[Speed, Any] = {}
    for joint in joints:
        others = {u: definitions[u] for u, e in scalars.items() if joint.defined_by({u: e})}
        for u, e in (others or joint.speeds).items():
            own.setdefault(u, e)
    return own | definitions
