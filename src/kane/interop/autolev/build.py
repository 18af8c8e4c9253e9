# SPDX-License-Identifier: BSD-3-Clause
"""From a sheet to a system: auxiliary speeds, kinematical equations, bodies, loads, speeds, constraints and default values."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from kane.equations.equations import derive
from kane.equations.state import State
from kane.errors import KaneError, ModelError
from kane.expr.differentiation import affine_forms, diff
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import solve_linear
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Input, Reaction, Speed, StateVariable, Symbol, rate
from kane.interop.autolev.model import LastForm, agree, no_accelerations, replacing, speeds_in, undefined
from kane.interop.autolev.sheet import Sheet
from kane.interop.autolev.space import RateRow, Space
from kane.interop.autolev.values import Vec
from kane.interop.driven import independent_rows
from kane.interop.imported import Imported, size_of
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint, auxiliary_speed, motion_constraint, reaction
from kane.model.loads import Force, Gravity, Load, Torque, gravity
from kane.model.system import System
from kane.numeric.sampling import SEEDS, sample
from kane.space.vector import Dyadic, Vector


@dataclass(frozen=True, slots=True, eq=False)
class TurnedRates:
    """Definitions of speeds; speeds that vanish, as constraints; and the rates of coordinates that are further states instead."""

    speeds: dict[Speed, Expr]
    vanishing: dict[Speed, Expr]
    states: dict[Coordinate, Expr]


def kinematics(space: Space, names: LastForm, speeds: Sequence[Speed], moving: Iterable[Expr]) -> TurnedRates:
    """The inverse of the kinematical equations; `moving` are the expressions in positions and orientations of the model.

    Of the rows rate = W u + X a maximal set that is independent at random states is solved for the speeds, short rows first. The
    others become motion constraints, unless they are identities. A speed that no row determines gets an additional coordinate, its
    integral.
    """
    held = set(free_symbols(moving))
    grouped = {e for group in space.groups for e in group}
    named = [q for q in names.coordinates() if q not in grouped and rate(q) in names.kinematic]
    own = [_row(q, names, speeds) for q in named]
    placed = [(q, r) for q, r in zip(named, own, strict=True) if q in held]
    loose = [(q, r) for q, r in zip(named, own, strict=True) if q not in held]
    for q, row in placed:
        if row is None:
            raise ModelError(
                f"Expected the rate of {q} as an affine function of speeds, got {names.kinematic[rate(q)]}."
            )
    rows = [*(r for _, r in placed if r is not None), *space.rows]
    chosen = _independent(rows, speeds, space)
    states: dict[Coordinate, Expr] = {}
    for q, row in loose:
        more = None if row is None or len(chosen) == len(speeds) else _independent([*rows, row], speeds, space)
        if row is not None and more is not None and len(more) > len(chosen):
            rows, chosen = [*rows, row], more
        else:
            states[q] = names.kinematic[rate(q)]
    for u in speeds:
        if len(chosen) == len(speeds):
            break
        q = Coordinate.declare(f"{u.name}_integral", None, "", "")
        more = _independent([*rows, RateRow(rate(q), u)], speeds, space)
        if len(more) > len(chosen):
            rows, chosen = [*rows, RateRow(rate(q), u)], more
            space.sheet.remarks.say("inferred", f"{u.name} is the rate of no coordinate of the file: one is added")
    return _turned(
        [rows[k] for k in chosen], [r for k, r in enumerate(rows) if k not in set(chosen)], speeds, states, space
    )


def _row(q: Coordinate, names: LastForm, speeds: Sequence[Speed]) -> RateRow | None:
    """The kinematical equation of a coordinate, or None if it is not affine in the speeds."""
    value = names.final(names.kinematic[rate(q)])
    try:
        affine_forms([value], speeds)
    except KaneError:
        return None
    return RateRow(rate(q), value)


def _independent(rows: Sequence[RateRow], speeds: Sequence[Speed], space: Space) -> list[int]:
    """The indices of a maximal set of independent rows, with a preference for few and constant coefficients."""
    if not rows or not speeds:
        return []
    forms = [form for form, _ in affine_forms([r.value for r in rows], speeds)]
    weight = [sum(1 if constant_value(c) is not None else 10 for c in form.values()) for form in forms]
    flat = [form.get(u, ZERO) for form in forms for u in speeds]
    matrix = np.array(sample(map(undefined, flat), SEEDS[0], space.groups), dtype=float).reshape(
        len(rows), len(speeds), 1
    )
    order = sorted(range(len(rows)), key=weight.__getitem__)
    return sorted(order[k] for k in independent_rows(matrix[order]))


def _turned(
    rows: Sequence[RateRow],
    rest: Sequence[RateRow],
    speeds: Sequence[Speed],
    states: dict[Coordinate, Expr],
    space: Space,
) -> TurnedRates:
    forms = affine_forms([r.value for r in rows], speeds)
    matrix = [[form.get(u, ZERO) for u in speeds] for form, _ in forms]
    right = [r.rates - x for r, (_, x) in zip(rows, forms, strict=True)]
    definitions = dict(zip(speeds, solve_linear(matrix, right), strict=True))
    replace = replacing(definitions)
    left = {Speed.declare(f"slip_{k}", None, "", ""): r.rates - replace(r.value) for k, r in enumerate(rest, 1)}
    return TurnedRates(definitions, left, states)


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Auxiliary speeds, unknown forces, and the replacement of the file's names of these forces by reactions."""

    speeds: tuple[AuxiliarySpeed, ...] = ()
    reactions: tuple[Reaction, ...] = ()
    change: Callable[[Expr], Expr] | None = None

    def load(self, v: Vector) -> Vector:
        """A load in which reactions replace the names of unknown forces."""
        return v.map(self.change) if self.change else v


def evidence(sheet: Sheet, names: LastForm, space: Space) -> Evidence:
    """Auxiliary speeds and reactions (Kane & Levinson 1985, sec. 4.9); ModelError unless they are as many."""
    if not sheet.auxiliary:
        return Evidence()
    unknown = _unknown(sheet, names)
    if len(unknown) != len(sheet.auxiliary):
        raise ModelError(
            f"Expected as many unknown forces in loads as auxiliary speeds, {len(sheet.auxiliary)}, got "
            f"{', '.join(s.name for s in unknown) or 'none'}. Name them in Kane(…)."
        )
    reactions = {s: reaction(s.name) for s in unknown}
    speeds = tuple(_cut(u, sheet, names, space) for u in sheet.auxiliary)
    return Evidence(speeds, tuple(reactions.values()), replacing(reactions))


def _unknown(sheet: Sheet, names: LastForm) -> list[Input]:
    """Variables without a value in loads: those named in Kane(…), or all if none is named there."""
    loads = [x for _, v, _ in (*sheet.forces, *sheet.torques) for x in names.vector(v).parts.values()]
    free = [s for s in free_symbols(loads) if isinstance(s, Input) and s.name.lower() not in sheet.given]
    told = [s for s in free if s.name.lower() in sheet.unknown]
    return told or free


def _cut(u: Speed, sheet: Sheet, names: LastForm, space: Space) -> AuxiliarySpeed:
    """An auxiliary speed, at the point or frame nearest to the inertial frame whose velocity contains it."""
    n = sheet.inertial
    for name in filter(space.turning.__contains__, space.frames):  # in the order from the inertial one outwards
        part = _partial(u, sheet.spin(name, n), names)
        if part.parts:
            return auxiliary_speed(u.name, frame=space.turning[name], along=_unit(u, part, space))
    partials = {p: _partial(u, v, names) for (p, f), v in sheet.velocities.items() if f == n and p in space.points}
    moved = [p for p, v in partials.items() if v.parts]
    if not moved:
        raise ModelError(f"Expected velocities that hold the auxiliary speed {u.name}, got none that the model needs.")
    first = min(moved, key=lambda p: len(space.points[p].ancestry()))
    _check(u, first, partials, space)
    return auxiliary_speed(u.name, at=space.points[first], along=_unit(u, partials[first], space))


def _partial(u: Speed, v: Vec, names: LastForm) -> Vec:
    return v.map(lambda x: names.final(diff(names.with_auxiliary(x), u)))


def _unit(u: Speed, v: Vec, space: Space) -> Vector:
    direction = space.vector(v)
    if not agree([direction.dot(direction)], [ONE], space.groups):
        raise ModelError(
            f"Expected a unit vector as the partial velocity for the auxiliary speed {u.name}, got {direction}."
        )
    return direction


def _check(u: Speed, first: str, partials: dict[str, Vec], space: Space) -> None:
    """Raises unless exactly the points placed from `first` have this partial velocity."""
    root = space.points[first]
    for p, v in partials.items():
        expected = partials[first] if root in space.points[p].ancestry() else Vec()
        mine, told = space.vector(expected), space.vector(v)
        if not agree(mine.components(space.root), told.components(space.root), space.groups):
            raise ModelError(
                f"Expected the auxiliary speed {u.name} in the velocities of {first} and of all points that are placed from it, got "
                f"another one in that of {p}. Place {p} from {first}, or from another point."
            )


Body = RigidBody | Particle


def build(sheet: Sheet) -> Imported:
    """The system of a sheet, with symbols, start values and remarks."""
    if not sheet.inertial:
        raise ModelError("Expected a Newtonian frame, got a text that declares none. Write Newtonian N.")
    if not sheet.masses:
        raise ModelError("Expected a body or particle with a mass, got none. Write Mass B = m.")
    names = LastForm(sheet)
    space = Space(sheet, names)
    shown = evidence(sheet, names, space)
    bodies = _bodies(sheet, names, space)
    loads = _loads(sheet, names, space, bodies, shown)
    laws = [names.final(e) for e, _ in sheet.constraints]
    _compare_accelerations(sheet, names, space)
    moving = [*_moving(space), *laws]
    speeds = _speeds(sheet, names, space, moving)
    kin = kinematics(space, names, speeds, moving)
    whole = partial(_system, sheet, names, space, kin, bodies, laws, shown)
    system = _relieved(sheet, whole, loads)
    for symbol in (s for s in (*system.inputs, *system.parameters) if s in sheet.outputs):
        why, line = sheet.outputs[symbol]
        raise line.refuse(f"an expression of the model for {symbol.name}", why)
    return _imported(sheet, names, system)


def _speeds(sheet: Sheet, names: LastForm, space: Space, moving: list[Expr]) -> list[Speed]:
    """The speeds of the model: those in kinematical equations, in the motion of bodies, and in constraints."""
    held = set(free_symbols(moving))
    rates = [
        names.final(names.kinematic[rate(q)]) for q in names.coordinates() if q in held and rate(q) in names.kinematic
    ]
    used = speeds_in([*(r.value for r in space.rows), *moving, *rates])
    order = [s for s in sheet.symbols.values() if isinstance(s, Speed)]
    found = set(used) - set(sheet.auxiliary)
    return [u for u in dict.fromkeys((*order, *used)) if u in found]


def _bodies(sheet: Sheet, names: LastForm, space: Space) -> list[Body]:
    made: list[Body] = []
    for name, mass in sheet.masses.items():
        shown, m = sheet.say(name), names.final(mass)
        if name in sheet.particles:
            made.append(Particle(shown, space.points[name], m))
            continue
        dyad, about, line = sheet.inertias.get(name, (None, sheet.bodies[name], None))
        inertia = Dyadic()
        if dyad is None:
            sheet.remarks.say("inferred", f"{shown} has no inertia: zero is assumed")
        else:
            inertia = space.inertia(dyad, name)
        center, frame = space.points[sheet.bodies[name]], space.turning[name]
        place = inertia if about == sheet.bodies[name] else (inertia, space.points[about])
        try:
            made.append(RigidBody(shown, frame=frame, mass_center=center, mass=m, inertia=place))
        except KaneError as error:
            raise (line.refuse("a body that kane can represent", str(error)) if line else error) from error
    for name in sheet.bodies.keys() - sheet.masses.keys():
        sheet.remarks.say("inferred", f"{sheet.say(name)} has no mass: it becomes a frame")
    return made


def _loads(sheet: Sheet, names: LastForm, space: Space, bodies: list[Body], shown: Evidence) -> list[Load | Gravity]:
    loads: list[Load | Gravity] = []
    total, everywhere = Vec(), False
    by_name = {b.name.lower(): b for b in bodies}
    for k, (vector, on) in enumerate(sheet.gravities):
        if not on or set(on) >= by_name.keys():
            total, everywhere = total + vector, True
            continue
        for name in on:
            if name in by_name:
                b = by_name[name]
                loads.append(Force(b.mass_center, space.vector(vector) * b.mass, f"gravity {k + 1} on {b.name}"))
    if everywhere:
        loads.insert(0, gravity(space.vector(total)))
    for name, vector, line in sheet.forces:
        value = shown.load(space.vector(vector))
        unknown = any(isinstance(x, Reaction) for x in free_symbols(value.scalars()))
        if not value.is_zero and (unknown or not space.points[name].velocity(space.root).is_zero):
            loads.append(Force(space.points[name], value, f"F{len(loads) + 1} on {sheet.say(name)} ({line.where})"))
    for name, vector, line in sheet.torques:
        value = shown.load(space.vector(vector))
        if name != sheet.inertial and not value.is_zero:
            frame = space.turning.get(name, space.frames[name])
            loads.append(Torque(frame, value, f"T{len(loads) + 1} on {sheet.say(name)} ({line.where})"))
    return loads


def _moving(space: Space) -> list[Expr]:
    """The expressions in the positions and orientations of the model."""
    frames = (*space.frames.values(), *space.turning.values())
    turned = [x for f in frames for v in (f.x, f.y, f.z) for x in v.components(space.root)]
    return [*turned, *(x for p in space.points.values() for x in p.position(space.origin).scalars())]


def _system(
    sheet: Sheet, names: LastForm, space: Space, kin: TurnedRates, bodies: list[Body], laws: list[Expr], shown: Evidence,
    loads: list[Load | Gravity],
) -> System:  # fmt: skip
    by_rates = replacing(kin.speeds)
    states = {q: StateVariable.declare(q.name, names.numbers.get(q.name.lower(), 0.0), "", "") for q in kin.states}
    change = replacing(states)
    held = _rated_states(kin, sheet)
    constraints: list[Constraint] = [motion_constraint(f"kinematics of {u.name}", e) for u, e in kin.vanishing.items()]
    for k, (law, (_, line)) in enumerate(zip(laws, sheet.constraints, strict=True), 1):
        if not no_accelerations(law):
            raise line.refuse("a constraint of speeds", "one of accelerations")
        constraints.append(motion_constraint(f"constraint {k} ({line.where})", by_rates(law)))
    dependent = [u for u in dict.fromkeys(sheet.dependent) if u in kin.speeds]
    return System(
        space.root,
        bodies=bodies,
        speeds={**kin.speeds, **kin.vanishing},
        loads=[_changed(x, change) for x in loads],
        nonholonomic=constraints,
        states={states[q]: change(e) for q, e in kin.states.items() if q in held},
        dependent_speeds=(*kin.vanishing, *dependent) if len(dependent) == len(laws) else (),
        auxiliary_speeds=shown.speeds,
        reactions=shown.reactions,
    )


def _relieved(sheet: Sheet, whole: Callable[[list[Load | Gravity]], System], loads: list[Load | Gravity]) -> System:
    """The system without the unknown forces for which a file solves, if they are those of its constraints."""
    system = whole(loads)
    sought = [x for x in system.inputs if x.name in sheet.sought]
    if not sought:
        return system
    change = replacing(dict.fromkeys(sought, ZERO))
    accelerations = derive(system).accelerations
    names, line = ", ".join(x.name for x in sought), sheet.sought[sought[0].name]
    if agree(accelerations, map(change, accelerations), [e.coordinates for e in system.euler_parameters]):
        text = f"{names} are constraint forces, which the multipliers represent: they are left out"
        sheet.remarks.say("changed", text, line.where)
        return whole([x for load in loads if (x := _changed(load, change)) is load or not _vanishes(x)])
    text = f"{names}, which the file solves for together with accelerations, do work on the constraints: they become inputs"
    sheet.remarks.say("changed", text, line.where)
    return system


def _vanishes(load: Load | Gravity) -> bool:
    return isinstance(load, Load) and all(v.is_zero for _, v in (*load.forces, *load.torques))


def _compare_accelerations(sheet: Sheet, names: LastForm, space: Space) -> None:
    """Remarks on accelerations in the file that are not derivatives of the velocities, which are used instead."""
    n = sheet.inertial
    for (p, frame), (told, line) in sheet.accelerations.items():
        if frame != n or (p, n) not in sheet.velocities:
            continue
        difference = sheet.dt(sheet.velocities[p, n].map(names.final), n).map(names.final) - names.vector(told)
        size = names.final(sheet.dot(difference, difference))
        if difference.parts and not agree([size + 1], [ONE], space.groups):
            text = f"the acceleration of {sheet.say(p)} is not the derivative of its velocity: the velocity is used"
            sheet.remarks.say("changed", text, line.where)


def _rated_states(kin: TurnedRates, sheet: Sheet) -> set[Coordinate]:
    """Further states whose rates the system determines."""
    known = {q for q, e in kin.states.items() if no_accelerations(e) and set(speeds_in([e])) <= kin.speeds.keys()}
    for q in kin.states:
        if q not in known:
            sheet.remarks.say("ignored", f"{q.name}: its rate contains accelerations, or speeds that move nothing")
    return known


def _changed(load: Load | Gravity, change: Callable[[Expr], Expr]) -> Load | Gravity:
    if isinstance(load, Gravity):
        return load
    forces = tuple((p, v.map(change)) for p, v in load.forces)
    torques = tuple((f, v.map(change)) for f, v in load.torques)
    return Load(load.name, forces, torques)


def _imported(sheet: Sheet, names: LastForm, system: System) -> Imported:
    symbols = (*system.coordinates, *system.speeds, *system.states, *system.parameters, *system.inputs)
    every: dict[str, Symbol] = {str(s.name): s for s in symbols}
    low = {name.lower(): s for name, s in every.items()}
    start: dict[type[Symbol], dict[Any, float]] = {Coordinate: {}, Speed: {}}
    for name, value in names.numbers.items():
        symbol = low.get(name, low.get(f"{name.rstrip(chr(39))}p"))
        if isinstance(symbol, Coordinate | Speed):
            start[type(symbol)][symbol] = value
    held = set(system.inputs)
    for name in sheet.prescribed:
        if sheet.symbols[name.lower()] in held:
            text = f"{name} is no generalized speed's coordinate and no equation defines it: it is an input"
            sheet.remarks.say("inferred", text)
    sheet.remarks.say("read", size_of(system))
    q, u = ({s.name: s for s in system.coordinates}, {s.name: s for s in system.speeds})
    parameters = {s.name: s for s in system.parameters}
    extras = {"start": State(q=start[Coordinate], u=start[Speed])}
    return Imported(system, every, q, u, parameters, sheet.remarks.all(), extras)
