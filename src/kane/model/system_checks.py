# SPDX-License-Identifier: BSD-3-Clause
"""Local checks of a system's declarations: errors before derivation, and warnings of probable mistakes.

Warnings concern models that can be computed: gravity that rotates with a body, contacts of another frame or on the wrong side.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from kane import expect
from kane.errors import ModelError, ReactionError, cut, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    declared,
    input_of,
)
from kane.model.bodies import Body, Part, Particle, RigidBody
from kane.model.constraints import Constraint, constraint_of, cut_of
from kane.model.declarations import Declarations, EulerParameters, geometry
from kane.model.loads import Gravity, Load
from kane.numeric.sampling import SEEDS, sample, value_of
from kane.numeric.scale import DECLARED
from kane.show import Listing
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, Vector, angular_velocity


def listed(what: str, given: Any, kind: type = object, made_by: str = "", named: bool = False) -> tuple[Any, ...]:
    """The items of a list, all of one kind, with different names if they are `named`; raises ModelError."""
    items = expect.items(given, f"{what}= to be a list", f"Write {what}=[…] around it.")
    expect.instances(items, kind, f"{what}= made by {made_by}")
    if named:
        cure = "Leave one out, or say name=… for each."
        expect.different((item.name for item in items), f"{what} of different names", cure)
    return Listing(items)


def check_inertial(frame: Any) -> None:
    """Raise ModelError unless the argument is a root frame."""
    cure = 'Make one with kn.Frame("N") and give it first.'
    expect.that(isinstance(frame, Frame) and frame.parent is None, "a root frame as the inertial frame", frame, cure)


def check_matter(bodies: tuple[Body, ...], loads: Iterable[Any]) -> None:
    """Raise ModelError unless there is a body, names of bodies are different, and loads are loads or gravity, each listed once."""
    expected = "loads from kn.Force, kn.Torque, kn.gravity, kn.linear_spring, …"
    cure = "Give its point or frame: kn.Force(point, vector), kn.Torque(frame, vector)."
    expect.instances(loads, (Load, Gravity), expected, cure)
    cure = "List it once; a second load of the same kind is another call."
    expect.different(loads, "each load once in loads=", cure)
    expect.that(bodies, "at least one body", came="none: nothing has mass")
    for b in bodies:
        cure = "A point or frame has no mass: make a body of it."
        right = isinstance(b, RigidBody | Particle | Body)
        expect.that(right, "bodies from kn.RigidBody or kn.Particle", b, cure)
    twice = sorted(name for name, count in Counter(b.name for b in bodies).items() if count > 1)
    cure = "Results are read by name: rename one, or list it once."
    expect.none(twice, "bodies of different names", "{} more than once", cure)


def check_names(symbols: Iterable[Symbol]) -> None:
    """Raise ModelError if two symbols have the same name."""
    first: dict[str, Symbol] = {}
    for s in symbols:
        if isinstance(s, Rate):
            continue
        other = first.setdefault(s.name, s)
        if other is not s:
            raise ModelError(
                f"Expected one symbol of the name {s.name!r}, got two with different declarations: {declared(other)} and "
                f"{declared(s)}. Declare it once and use it in both places, or rename one."
            )


def check_geometry(symbols: Iterable[Symbol]) -> None:
    """Raise ModelError unless positions and orientations are functions of coordinates, parameters, inputs and time."""
    kinds = Speed | AuxiliarySpeed | Reaction | Rate | QuasiRate
    wrong = [f"{s} ({type(s).__name__})" for s in symbols if isinstance(s, kinds) and input_of(s) is None]
    expected = "positions and orientations in coordinates, parameters, inputs and kn.time"
    came = "{}: a motion is described by coordinates, whose rates the speeds= define"
    expect.none(wrong[:1], expected, came, "Declare a kn.coordinate for it.")


def check_no_accelerations(symbols: Iterable[Symbol]) -> None:
    """Raise ModelError if loads depend on accelerations."""
    rates = (s for s in symbols if isinstance(s, Rate) and not isinstance(s.place, Coordinate | StateVariable))
    wrong = [s for s in rates if input_of(s) is None]
    expected = "loads in coordinates, rates, speeds, parameters, inputs and time"
    came = "{}, which is not known before the equations are solved"
    cure = "Model a load that depends on an acceleration as mass or inertia."
    expect.none(wrong[:1], expected, came, cure)


def check_strays(
    symbols: Iterable[Symbol],
    coordinates: tuple[Coordinate, ...],
    speeds: Mapping[Speed, Expr],
    euler: tuple[EulerParameters, ...],
) -> None:
    """Raise ModelError if loads or events contain coordinates or speeds that are not the system's."""
    own: set[Symbol] = {*coordinates, *speeds, *(w for s in euler for w in s.quasi)}

    def strays(origin: Any) -> bool:
        while isinstance(origin, Rate):
            origin = origin.place
        return isinstance(origin, Coordinate | Speed | QuasiRate) and origin not in own

    came = "{}: no frame or point depends on it and it is not among the keys of speeds="
    cure = "Use the system's own symbol, or a kn.parameter or kn.input for what is given."
    expect.none([*filter(strays, symbols)][:1], "loads, masses and events in symbols of the system", came, cure)


def check_reactions(
    symbols: Iterable[Symbol], reactions: tuple[Reaction, ...], auxiliary: tuple[AuxiliarySpeed, ...]
) -> None:
    """Raise ReactionError unless each reaction in a load is listed, and explicit auxiliary speeds match reactions without a place."""
    if len(set(reactions)) < len(reactions):
        raise ReactionError("Expected each reaction once in reactions=, got one twice.")
    for s in symbols:
        if isinstance(s, Reaction) and s not in set(reactions):
            raise ReactionError(f"The reaction {s} is used in a load but not listed: add it to System(reactions=[…]).")
    bare = [r for r in reactions if cut_of(r) is None and constraint_of(r) is None]
    expected = "as many explicit auxiliary speeds as reactions without a point or frame"
    came = f"{len(auxiliary)} and {len(bare)} ({', '.join(map(str, bare)) or 'none'})"
    cure = "Give the reaction a point or frame: kn.reaction(name, at=point, along=direction)."
    expect.that(len(bare) == len(auxiliary), expected, came=came, cure=cure, error=ReactionError)


def check_constraints(constraints: tuple[Constraint, ...], reactions: tuple[Reaction, ...]) -> None:
    """Raise ModelError for constraints of the same name, ReactionError for a reaction of a constraint that is not in the system."""
    names = [c.name for c in constraints]
    expect.different(names, "constraints of different names", "Say name=… for each.")
    for r in reactions:
        c = constraint_of(r)
        if c is not None and c not in constraints:
            expected = f"the constraint of the reaction {r} among the system's ({', '.join(names) or 'none'})"
            cure = "List it in holonomic= or nonholonomic=."
            raise expect.refusal(ReactionError, expected, cut(repr(c.name)), cure)


def check_dependent(
    what: str, dependent: tuple[Any, ...], known: Iterable[Any], constraints: Iterable[Constraint], *kinds: str
) -> None:
    """Raise ModelError unless dependent coordinates or speeds are the system's, each once, and at most as many as constraints."""
    names, most = ", ".join(map(str, dependent)), sum(c.kind in kinds for c in constraints)
    symbols = all(isinstance(s, Symbol) for s in dependent)
    if not symbols or not set(dependent) <= set(known) or len(set(dependent)) < len(dependent):
        raise ModelError(f"Expected dependent_{what}= to list {what} of the system, each once, got {names}.")
    came, cure = f"{len(dependent)} in dependent_{what}=: {names}", "Leave it out to have them chosen."
    expect.that(len(dependent) <= most, f"at most {most} dependent {what}, one a constraint", came=came, cure=cure)


def state_rates(states: Any) -> dict[StateVariable, Expr]:
    """The rates of the further states; raises ModelError if one contains quantities known only after the solution of the equations."""
    expect.instance(states, Mapping, "states= to be a dict {a: rate, …}", "Give each state its rate: {a: (e - a)/tau}.")
    rates: dict[StateVariable, Expr] = {}
    for a, given in states.items():
        came, cure = f"{cut(repr(a))} ({type(a).__name__})", 'Declare one: a = kn.state("a").'
        expect.that(isinstance(a, StateVariable), "states from kn.state as keys of states=", came=came, cure=cure)
        scalar = not isinstance(given, Vector | Dyadic)
        expect.that(scalar, f"a scalar as the rate of the state {a}", given, "Use .dot(unit vector).")
        rates[a] = as_expr(given)
        for s in free_symbols([rates[a]]):
            _check_known(a, s)
    return rates


def _check_known(a: StateVariable, s: Symbol) -> None:
    if isinstance(s, Rate) and isinstance(s.place, StateVariable):
        what, cure = f"the rate {s}", f"Write out the rate of {s.place} as in states="
    elif isinstance(s, Reaction | AuxiliarySpeed):
        what, cure = (
            f"{s} ({type(s).__name__})",
            "Write the expression that gives the reaction, or a load instead of it",
        )
    elif isinstance(s, Rate) and input_of(s) is None and not isinstance(s.place, Coordinate):
        what = f"the acceleration {s}"
        cure = "Use a state whose rate contains the speed instead: a high-pass filter is the speed minus a low-pass filter of it"
    else:
        return
    raise ModelError(
        f"Expected the rate of the state {a} in coordinates, rates, speeds, states, parameters, inputs and time, got {what}, which is "
        f"not known before the equations are solved. {cure}."
    )


def check_states(system: Declarations, symbols: Iterable[Symbol]) -> None:
    """Raise ModelError if a state among `symbols` has no rate, or if the description of motions depends on a state."""
    origins = [(s, s.place if isinstance(s, Rate) else s) for s in symbols]
    states = [(s, origin) for s, origin in origins if isinstance(origin, StateVariable)]
    if not states:
        return
    for s, origin in states:
        kinds = "coordinates, speeds, states, parameters, inputs and time"
        cure = f"Declare it: System(states={{{origin}: …}}), an expression of {kinds}."
        expect.that(origin in system.states, f"a rate for the state {origin}", came="none", cure=cure)
        cure = f"Write out the rate of {origin} as in states=."
        expect.that(origin is s, "loads and events in states, not in their rates", came=f"the rate {s}", cure=cure)
    without: dict[str, Iterable[Expr]] = {
        "positions and orientations": geometry(system.frames, system.points),
        "definitions of speeds": system.speeds.values(),
        "constraints": [c.expr for c in system.constraints],
    }
    cure = "Let states act by loads: a servo turns a joint by a torque that depends on its state."
    for kind, exprs in without.items():
        inside = [s for s in free_symbols(exprs) if isinstance(s, StateVariable)]
        expect.none(inside[:1], f"{kind} without states", "{} in them", cure)


def warn_of_doubts(
    inertial: Frame, parts: Sequence[Part], gravities: Iterable[Gravity], constraints: Iterable[Constraint]
) -> None:
    """Warn of gravity and contacts that are probably mistakes, once each."""
    messages = [*_turning(inertial, gravities)]
    contacts = {c.forces[0][0]: c for c in constraints if c.normal is not None and c.forces}
    for p, c in contacts.items():
        messages += _contact(p, c, parts)
    particles = dict.fromkeys(p for c in constraints if c.kind == "motion" for p, _ in c.forces)
    messages += [text for p in particles for text in _carried(p, parts, inertial)]
    edges: dict[Point, list[Constraint]] = {}
    for c in constraints:
        if c.kind == "motion" and c.normal is None and c.forces:
            edges.setdefault(c.forces[0][0], []).append(c)
    for p, along in edges.items():
        messages += next(filter(None, ([*_edge(p, c, parts, inertial)] for c in along)), [])
    for message in messages:
        warn(message)


def _turning(inertial: Frame, gravities: Iterable[Gravity]) -> Iterator[str]:
    for g in gravities:
        components = list(g.acceleration.components(inertial))
        if _depends_on_coordinates(components):
            frames = ", ".join(f.name for f, _ in g.acceleration.parts)
            yield (
                f"Expected gravity {g.name!r} along a fixed direction, got {g.acceleration}, which rotates with coordinates of the "
                f"model. Write it along {inertial.name} instead of {frames}: -g*{inertial.name}.z where that points up."
            )


def _depends_on_coordinates(exprs: Sequence[Expr]) -> bool:
    symbols = free_symbols(exprs)
    if not any(isinstance(s, Coordinate) for s in symbols):
        return False

    def at(seed: int) -> list[float]:
        values = {s: value_of(s, seed if isinstance(s, Coordinate) else SEEDS[0]) for s in symbols}
        return [float(x) for x in evaluate(exprs, values)]

    first, *others = map(at, SEEDS)
    size = max(map(abs, first))
    return any(abs(a - b) > DECLARED * size for row in others for a, b in zip(first, row, strict=True))


def _contact(p: Point, c: Constraint, parts: Sequence[Part]) -> Iterator[str]:
    """Messages about the point at which a body rolls."""
    assert c.normal is not None
    near = [x for x in parts if x.frame is not None and _belongs(x.mass_center, p)]
    home = p.body or _home(p)
    label = c.name.rpartition(" ")[0] or c.name
    if near and not any(x.frame is not None and home is not None and _fixed(x.frame, home) for x in near):
        yield _of_another(p, near[-1], label)
        return
    corner = p.body is not None and p.offset.dt(p.body).is_zero
    for x in near:
        height = x.mass_center.position(p).dot(c.normal)
        if corner and any(isinstance(s, Coordinate) for s in free_symbols([height])):
            continue  # a corner is below the mass centre in some orientations only
        if all(sample([height], seed)[0] < 0 for seed in SEEDS):
            yield (
                f"Expected the contact of {x.name!r} in {label!r} on the side from which the normal {c.normal} points to it, got "
                f"{p.name} beyond its mass centre. Change the sign of the offset of {p.name}, or of the normal."
            )


def _edge(p: Point, c: Constraint, parts: Sequence[Part], inertial: Frame) -> Iterator[str]:
    """Messages about a wheel's contact point whose velocity along a constrained direction is not that of the wheel's particle there.

    An edge along a direction of its own frame may be that of a frame without mass.
    """
    on = [x for x in parts if x.frame is not None and p.parent in (x.mass_center, x.mass_center.parent)]
    wheels = [x for x in on if p.parent is x.mass_center]
    for q, e in c.forces if wheels else ():
        home = q.body or _home(q)
        own = [f for f, _ in e.parts]
        if home is not None and home is not inertial and all(f is not inertial and _fixed(home, f) for f in own):
            return
        if any(_moves_with(q, x, e, inertial) for x in on):
            return
    if wheels:
        yield _of_another(p, wheels[-1], c.name)


def _carried(p: Point, parts: Sequence[Part], inertial: Frame) -> Iterator[str]:
    """Messages about a particle made on a point that does not move with its body: v^X + ω × r is then the velocity of no particle."""
    bodies = [x for x in parts if x.frame is not None and x.frame is p.body]
    if not bodies or p.parent is None or any(x.mass_center is p.parent for x in bodies):
        return
    axes = (inertial.x, inertial.y, inertial.z)
    if not any(all(_moves_with(p, x, e, inertial) for e in axes) for x in bodies):
        body, frame = bodies[-1], p.body.name if p.body is not None else ""
        center = body.mass_center.name
        yield (
            f"Expected {p.name} placed from a point that moves with {body.name!r}, got {p.parent.name}, which does not: v + ω × r is "
            f"then the velocity of no particle of the body. Place it from one, such as {center}: {center}.fixed_in({frame}, …)."
        )


def _moves_with(p: Point, body: Part, e: Vector, inertial: Frame) -> bool:
    """Whether the velocity of the point along e equals that of the body's particle there, at random states."""
    assert body.frame is not None
    center = body.mass_center
    if p.body is body.frame and p.parent is center:  # by the definition of a particle
        return True
    turned = body.frame.angular_velocity(inertial).cross(p.position(center))
    numbers = [p.velocity(inertial).dot(e), center.velocity(inertial).dot(e), turned.dot(e)]
    rows = [sample(numbers, seed) for seed in SEEDS]
    return all(
        abs(own - moved - round_) <= DECLARED * (abs(own) + abs(moved) + abs(round_)) for own, moved, round_ in rows
    )


def _of_another(p: Point, body: Part, label: str) -> str:
    assert body.frame is not None
    kind = f"a particle of {p.body.name}" if p.body is not None else "a geometric point"
    return (
        f"Expected the particle of {body.name!r} that touches the ground in {label!r}, got {p.name}, {kind}, which does not turn "
        f"with it. Use {p.parent.name if p.parent else p.name}.fixed_in({body.frame.name}, …)."
    )


def _belongs(center: Point, p: Point) -> bool:
    """Whether the point is defined from the mass centre, or the mass centre from it or from its parent."""
    return p.parent is not None and (center is p.parent or center.parent in (p, p.parent))


def _home(p: Point) -> Frame | None:
    """The frame in which the offset of a geometric point is constant; None if there is none."""
    frames = [f for f, _ in p.offset.parts]
    stays = len(frames) == 1 and not any(isinstance(s, Coordinate) for s in free_symbols(p.offset.scalars()))
    return frames[0] if stays and isinstance(frames[0], Frame) else None


def _fixed(frame: Basis, other: Basis) -> bool:
    return frame is other or angular_velocity(frame, other).is_zero
