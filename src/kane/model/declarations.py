# SPDX-License-Identifier: BSD-3-Clause
"""The declarations of a system: its fields, its events, and all frames, points and scalars that they contain.

Variables are the coordinates in order, sets of Euler parameters, and the definitions of the generalized speeds. If only the
independent speeds u_1 … u_p are defined (Kane & Levinson 1985, sec. 2.13), rates of constraints complete them, as the equations
need as many speeds as rates: w = A_q q̇ + b_q vanishes, and shortens q̇ = W u + X if it occurs there.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np

from kane import expect
from kane.errors import ModelError, NotAffineError, SpeedsError, cut
from kane.expr.differentiation import Affine, affine_forms, euler_parameter_rates, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import LESS, Immutable
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Input,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Symbols,
    input_of,
    names,
    rate,
    word,
)
from kane.expr.visit import substituted
from kane.model.bodies import Body, parts_of
from kane.model.constraints import Constraint, cut_of
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load
from kane.numeric.arrays import Array
from kane.numeric.rank import balanced, singular
from kane.numeric.sampling import SEEDS, values_of
from kane.numeric.scale import SPEEDS_RANK
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class EulerParameters(Immutable):
    """A set of Euler parameters and its quasi-rates."""

    coordinates: tuple[Coordinate, ...]
    quasi: tuple[QuasiRate, ...]


def euler_sets(frames: tuple[Frame, ...]) -> tuple[EulerParameters, ...]:
    """The sets of Euler parameters that orient frames."""
    by_coordinates: dict[tuple[int, ...], EulerParameters] = {}
    for f in frames:
        o = f.orientation
        if o is not None and o.parameters:
            by_coordinates[tuple(id(x) for x in o.parameters)] = EulerParameters(o.parameters, o.quasi)
    sets = tuple(by_coordinates.values())
    used = [x for s in sets for x in s.coordinates]
    if len(set(used)) < len(used):
        raise ModelError("Expected different coordinates in different sets of Euler parameters, got one in two sets.")
    return sets


def ordered_coordinates(
    symbols: tuple[Symbol, ...], order: Sequence[Coordinate | str] | None, first: Iterable[Coordinate] = ()
) -> Symbols[Coordinate]:
    """The coordinates in the given order, or those of joints, `first`, then the others as they appear.

    Among the others, those of positions precede those of orientations, and q1, q2, … stay together.
    """
    seen = dict.fromkeys(s for s in symbols if isinstance(s, Coordinate))
    if order is None:
        early = dict.fromkeys(q for q in first if q in seen)
        groups: dict[str, list[Coordinate]] = {}
        for q in (q for q in seen if q not in early):
            groups.setdefault(q.name.rstrip("0123456789"), []).append(q)
        rest = (sorted(group, key=lambda q: int(q.name[len(stem) :] or -1)) for stem, group in groups.items())
        return Symbols((*early, *(q for group in rest for q in group)))
    listed: Symbols[Coordinate] = by_name(order, seen)
    right = all(isinstance(q, Coordinate) for q in listed)
    expect.that(right, "coordinates= to be a list of coordinates, such as (q1, q2)", listed)
    unused = (q for q in listed if q not in seen)
    cure = "Leave it out, or write it into a position or orientation; is a body missing from bodies=?"
    expect.none(
        unused,
        lambda: f"coordinates= to list those that frames and points depend on ({_names(seen)})",
        "{}, which nothing uses",
        cure,
    )
    absent = [q for q in seen if q not in set(listed)]
    if absent or len(listed) != len(seen):
        cure = f"Add {_names(absent)}" if absent else "List each only once"
        raise ModelError(f"Expected coordinates= to list each of {_names(seen)} once, got {_names(listed)}. {cure}.")
    return listed


def moved(speeds: Mapping[Speed, Any] | str, constraints: Iterable[Constraint]) -> list[Expr]:
    """The coordinates of constraints that have a speed, even if no position depends on them, as for a counter."""
    held = [*free_symbols(c.expr for c in constraints)]
    held += [s.place for s in held if isinstance(s, Rate) and isinstance(s.place, Coordinate)]
    if not isinstance(speeds, Mapping):
        return [s for s in held if isinstance(s, Coordinate)]
    defined = {s.place for s in free_symbols(x for x in speeds.values() if isinstance(x, Expr)) if isinstance(s, Rate)}
    return [s for s in held if s in defined]


def by_name(items: Any, own: Iterable[Symbol]) -> Symbols[Any]:
    """Symbols given as such, by name, or by several names in one text; items that are not names in `own` are returned unchanged."""
    known = {s.name: s for s in own}
    items = names(items) if isinstance(items, str) else [items] if isinstance(items, Symbol) else items
    if not expect.is_list(items):
        raise ModelError(f"Expected a list of {', '.join(known)} by symbol or name, got {cut(repr(items))}.")
    return Symbols(known.get(x, x) if isinstance(x, str) else x for x in items)


def _names(symbols: Iterable[Any]) -> str:
    return ", ".join(map(str, symbols))


def speed_definitions(
    speeds: Mapping[Speed, Any] | str, coordinates: tuple[Coordinate, ...], euler: tuple[EulerParameters, ...]
) -> dict[Speed, Expr]:
    """The definition of each generalized speed; "rates" means u = q̇ throughout."""
    if isinstance(speeds, str):
        if speeds != "rates":
            raise SpeedsError(f'Expected speeds={{u1: definition, …}} or "rates", got {speeds!r}.')
        return _rates_as_speeds(coordinates, euler)
    expected = 'speeds= to be a dict {u1: definition, …} or "rates"'
    cure = "Each definition needs its speed: {u1: q1.dt, u2: q2.dt}."
    expect.instance(speeds, Mapping, expected, cure, error=SpeedsError)
    definitions: dict[Speed, Expr] = {}
    for u, definition in speeds.items():
        if not isinstance(u, Speed):
            raise SpeedsError(
                f"Expected generalized speeds as keys of speeds=, got {u!r} ({type(u).__name__}). "
                "Declare a kn.speed for it, as in {u1: q1.dt}."
            )
        if isinstance(definition, Vector):
            came = f"the vector {definition}"
            raise expect.refusal(SpeedsError, f"a scalar definition of {u}", came, "Use .dot(unit vector).")
        definitions[u] = as_expr(definition)
    known: dict[Expr, Affine] = {}
    rates = [s for s in free_symbols(definitions.values()) if isinstance(s, Rate | QuasiRate) and input_of(s) is None]
    for u, e in definitions.items():
        _check_definition(u, e, rates, known)
    return definitions


def basic_rates(coordinates: Iterable[Coordinate], euler: Sequence[EulerParameters]) -> list[Expr]:
    """The rates of the coordinates in their order, with quasi-rates for those of Euler parameters."""
    set_of = {q: s for s in euler for q in s.coordinates}
    result: list[Expr] = []
    for q in coordinates:
        if q not in set_of:
            result.append(rate(q))
        elif q is set_of[q].coordinates[0]:
            result.extend(set_of[q].quasi)
    return result


def rates_by_quasi(euler: Sequence[EulerParameters]) -> dict[Expr, Expr]:
    """The rates of Euler parameters as functions of their quasi-rates."""
    result: dict[Expr, Expr] = {}
    for s in euler:
        result.update(zip(map(rate, s.coordinates), euler_parameter_rates(s.coordinates, s.quasi), strict=True))
    return result


def inputs_with_rates(
    symbols: Iterable[Symbol], shape: Iterable[Expr], constraints: Iterable[Constraint]
) -> tuple[Input | Rate, ...]:
    """The inputs among `symbols`, each with the derivatives that the equations need.

    These are two for an input in positions or orientations, one in a motion constraint, and those that loads contain.
    """
    orders: dict[Input, int] = {}

    def need(used: Iterable[Symbol], more: int) -> None:
        for s in used:
            r, order, at = input_of(s), 0, s
            while isinstance(at, Rate):
                order, at = order + 1, cast(Symbol, at.place)
            if r is not None:
                orders[r] = max(orders.get(r, 0), order + more)

    need(symbols, 0)
    if not orders:
        return ()
    held = {kind: [c.expr for c in constraints if c.kind == kind] for kind in ("configuration", "motion")}
    need(free_symbols([*shape, *held["configuration"]]), 2)
    need(free_symbols(held["motion"]), 1)
    listed: list[Input | Rate] = []
    for r, order in orders.items():
        listed.append(r)
        at: Symbol = r
        for _ in range(order):
            at = rate(at)
            listed.append(at)
    return tuple(listed)


def _check_definition(u: Speed, definition: Expr, rates: Iterable[Expr], known: dict[Expr, Affine]) -> None:
    """Raise SpeedsError unless a definition is affine in rates, contains a rate, and contains no speed."""
    symbols = free_symbols([definition])
    for s in symbols:
        if isinstance(s, Speed):
            raise SpeedsError(
                f"Expected the definition of {u} in rates such as q', got the speed {s} in {cut(definition, 120)}. Write what {s} "
                "stands for, in rates such as q.dt."
            )
    try:
        ((row, _),) = affine_forms([definition], rates, known)
    except NotAffineError as error:
        culprit, whole = str(error).rpartition("got ")[2].rstrip("."), f"{cut(definition, 120)}"
        said = whole if culprit == whole else f"{culprit} in {whole}"
        raise SpeedsError(
            f"Expected the definition of {u} to be linear in the rates (u = Y q' + z), got {said}. Take a rate such as q.dt, or a "
            "component of a velocity or angular velocity, v.dot(N.x)."
        ) from error
    if not row:
        q = next((s for s in symbols if isinstance(s, Coordinate)), None)
        cure = f"Write {q}.dt for the rate of {q}" if q is not None else "Define it by a rate, such as q.dt"
        raise SpeedsError(f"Expected the definition of {u} to contain a rate, got {cut(definition, 120)}. {cure}.")


def _rates_as_speeds(coordinates: tuple[Coordinate, ...], euler: tuple[EulerParameters, ...]) -> dict[Speed, Expr]:
    """u = q̇; for Euler parameters the three measure numbers of the angular velocity."""
    made: dict[Speed, Expr] = {}
    sets = {x: s for s in euler for x in s.coordinates}
    for q in coordinates:
        s = sets.get(q)
        if s is None:
            numbered = q.name[0] == "q" and q.name[1:].isdigit()
            made[Speed.declare(f"u{q.name[1:]}" if numbered else f"u_{q.name}")] = q.dt
        elif q is s.coordinates[0]:
            for k, w in enumerate(s.quasi, 1):
                made[Speed.declare(f"w{k}_{q.name}")] = w
    return made


def completed(
    definitions: Mapping[Speed, Expr],
    coordinates: Sequence[Coordinate],
    euler: Sequence[EulerParameters],
    constraints: Sequence[Constraint],
) -> dict[Speed, Expr]:
    """Rates of constraints as speeds, if exactly the independent speeds are defined; none otherwise.

    All independent constraints are used: if fewer speeds are missing than there are of these, a speed was forgotten.
    """
    rates, by_quasi = basic_rates(coordinates, euler), rates_by_quasi(euler)
    missing = len(rates) - len(definitions)
    if not definitions or not 0 < missing <= len(constraints):
        return {}
    offered = [substituted(constraint_rate(c), by_quasi) for c in constraints]
    told = [substituted(e, by_quasi) for e in definitions.values()]
    forms = [row for row, _ in affine_forms([*told, *offered], rates)]
    entries = [row.get(b, ZERO) for row in forms for b in rates]
    chosen: set[tuple[int, ...]] = set()
    for seed in SEEDS:
        with np.errstate(all="ignore"):
            numbers = np.array(evaluate(entries, values_of(free_symbols(entries), seed)), dtype=float)
        places = _independent(numbers.reshape(len(forms), len(rates)), len(told), missing)
        if places is None:
            return {}
        chosen.add(places)
    if len(chosen) != 1:
        return {}
    taken = {u.name for u in definitions}
    result: dict[Speed, Expr] = {}
    for k, place in enumerate(next(iter(chosen))):
        c = constraints[place]
        name = next(
            n for n in (f"w{k + 1}", f"w{k + 1}_{c.name}", *(f"w_{i}" for i in range(len(rates)))) if n not in taken
        )
        taken.add(name)
        result[Speed.declare(word(name), None, "", f"rate of the constraint {c.name}, which vanishes")] = offered[place]
    return result


def constraint_rate(constraint: Constraint) -> Expr:
    """The rate ḟ of a configuration constraint, or f of a motion constraint: A_q q̇ + b_q."""
    return time_derivative(constraint.expr) if constraint.kind == "configuration" else constraint.expr


def _independent(rows: Array, first: int, missing: int) -> tuple[int, ...] | None:
    """`missing` rows beyond the `first` ones that are independent of these; None if that is not the rank of the rows."""
    if not np.isfinite(rows).all():
        return None
    scaled, kept, found = balanced(rows), list(range(first)), list[int]()
    if singular(scaled[first:]).rank(SPEEDS_RANK) != missing:
        return None
    for k in range(first, len(rows)):
        if len(found) == missing:
            break
        if singular(scaled[[*kept, k]]).rank(SPEEDS_RANK) == len(kept) + 1:
            kept.append(k)
            found.append(k - first)
    return tuple(found) if len(found) == missing and singular(scaled[kept]).rank(SPEEDS_RANK) == rows.shape[1] else None


@dataclass(frozen=True, slots=True, eq=False)
class Event(Immutable):
    """An event in a simulation: `quantity` falls below (direction −1), rises above (+1) or crosses (0) `threshold`.

    A terminal event ends the motion; `sol.event` names it. Without an action, `then=`, events are terminal by default; with one
    they are not. An action such as `then={v: -e*v}` gives new values of coordinates, speeds, states or parameters, all computed
    from those before the event, or new inputs, in any form that `inputs=` of `kn.simulate` takes. It may be a function that
    returns such a mapping, called with the keywords t, q, u and parameters. Under constraints, dependent speeds that are not set
    follow from the others.
    """

    name: str
    quantity: Expr
    threshold: float = 0.0
    direction: int = 0
    terminal: bool | None = None
    message: str = ""
    then: Any = None
    _ends: ClassVar[str] = "simulation"

    def __post_init__(self) -> None:
        who = f"the event {cut(repr(self.name), 40)}"
        for what, (right, expected) in _EVENT.items():
            given = getattr(self, what)
            expect.that(right(given), f"{what} of {who} to be {expected}", given, "See kn.Event.")
        object.__setattr__(self, "threshold", float(self.threshold))
        if self.quantity.op is LESS and not 0 < self.threshold < 1:
            came = f"the condition {self.quantity}, which is 0 or 1, across {self.threshold:g}"
            cure = "Take the quantity itself with its threshold and direction=, or threshold=0.5."
            raise expect.refusal(ModelError, f"a quantity that crosses the threshold of {who}", came, cure)
        object.__setattr__(self, "then", as_action(who, self.then))
        object.__setattr__(self, "terminal", self.then is None if self.terminal is None else bool(self.terminal))

    @property
    def breaks(self) -> bool:
        """Whether the event ends the motion or has an action."""
        return bool(self.terminal) or self.then is not None

    @property
    def consequence(self) -> str:
        """The action, and whether the event ends the motion, as text."""
        done = "; ".join(f"{s} := {x}" for s, x in self.then.items()) if isinstance(self.then, Mapping) else ""
        done = done or (f"calls {getattr(self.then, '__name__', 'a function')}" if self.then is not None else "")
        return ", ".join(x for x in (done, f"ends the {self._ends}" if self.terminal else "") if x)

    def __repr__(self) -> str:
        passes = {-1: "falls below", 0: "crosses", 1: "rises above"}[self.direction]
        done = f": {cut(self.consequence)}" if self.consequence else ""
        return f"Event({self.name!r}, {cut(self.quantity)} {passes} {self.threshold:g}{done})"


class EndOfMode(Event):
    """An event that ends a mode of a contact; its quantity is not checked for units, as gaps may contain numbers."""

    __slots__ = ()
    _ends = "mode"


_EVENT: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (lambda x: isinstance(x, str) and bool(x), "a text that is not empty"),
    "quantity": (lambda x: isinstance(x, Expr), "a scalar expression of the system, such as q1 or v.dot(N.x)"),
    "threshold": (expect.is_number, "a finite number, in the unit of the quantity"),
    "direction": (lambda x: expect.is_number(x) and x in (-1, 0, 1), "-1 (falls), 1 (rises) or 0 (either)"),
    "terminal": (lambda x: x is None or isinstance(x, bool | np.bool_), "True or False"),
    "message": (lambda x: isinstance(x, str), "a text"),
}
"""The condition on each field of an event, with its text."""


SETTABLE = (Coordinate, Speed, StateVariable, Parameter, Input)
_FORM = "Write then={symbol: expression}, as {u1: -e*u1}."


def as_action(who: str, then: Any) -> Any:
    """A mapping of symbols, or their names, to expressions, or a function that returns one; None without an action.

    Inputs may have any value that `inputs=` takes.
    """
    if then is None or (callable(then) and not isinstance(then, Expr | Mapping)):
        return then
    expect.that(isinstance(then, Mapping) and then, f"then= of {who} to give new values", then, _FORM)
    made: dict[Any, Any] = {}
    for key, value in then.items():
        expected = f"then= of {who} to set coordinates, speeds, states, parameters or inputs"
        if isinstance(key, Rate):
            raise ModelError(f"Expected {expected}, got the rate {key}. Set the speed instead.")
        expect.instance(key, (str, *SETTABLE), expected, _FORM)
        number = isinstance(value, Expr | int | float) and not isinstance(value, bool)
        right = number or isinstance(key, Input | str)
        expect.that(right, f"an expression or a number for {key} in then= of {who}", value, _FORM)
        made[key] = as_expr(value) if number else value
    return made


def expressions(events: Iterable[Any]) -> Iterator[Expr]:
    """The quantities of events, and the expressions that their actions assign."""
    for event in events:
        yield event.quantity
        if isinstance(event.then, Mapping):
            yield from (x for x in event.then.values() if isinstance(x, Expr))


def settable(system: Any) -> tuple[Symbol, ...]:
    """The symbols that actions may set."""
    inputs = (s for s in system.inputs if isinstance(s, Input))
    return (*system.coordinates, *system.speeds, *system.states, *system.parameters, *inputs)


def target(system: Any, event: Any, key: Any) -> Symbol:
    """The symbol of the system that an event sets; raises ModelError if there is none."""
    for s in settable(system):
        if s is key or (isinstance(key, str) and s.name == key):
            return s
    expected = f"then= of the event {event.name!r} to set one of {', '.join(s.name for s in settable(system))}"
    cure = "Take one of these, symbols of the system, or its name."
    raise expect.refusal(ModelError, expected, cut(repr(key)), cure)


def check_actions(system: Any) -> None:
    """Raise ModelError unless events set symbols of the system, each once, and their quantities change along a motion."""
    for event in system.events:
        moving = [s for s in free_symbols([event.quantity]) if not isinstance(s, Parameter)]
        expected = f"the quantity of the event {event.name!r} to change along a motion"
        if not moving:
            came = f"{cut(event.quantity)}, which is constant: it crosses no threshold"
            raise expect.refusal(
                ModelError, expected, came, "Give an expression of coordinates, speeds, reactions or time."
            )
        if not isinstance(event.then, Mapping):
            continue
        once = len({target(system, event, key) for key in event.then}) == len(event.then)
        expected, came = f"one value for each symbol in then= of the event {event.name!r}", "two, by symbol and by name"
        expect.that(once, expected, came=came, cure="Leave one out.")


@dataclass(frozen=True, slots=True, eq=False)
class Declarations(Immutable):
    """All that is declared, or contained in declarations, parents first; `System` makes and checks it."""

    inertial: Frame
    bodies: tuple[Body, ...]
    speeds: Mapping[Speed, Expr]
    states: Mapping[StateVariable, Expr]
    loads: tuple[Load, ...]
    gravities: tuple[Gravity, ...]
    reactions: tuple[Reaction, ...]
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    events: tuple[Event, ...]
    coordinates: Symbols[Coordinate]
    constraints: tuple[Constraint, ...]
    dependent_coordinates: tuple[Coordinate, ...]
    dependent_speeds: tuple[Speed, ...]
    joints: tuple[Joint, ...]
    euler_parameters: tuple[EulerParameters, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Input | Rate, ...]
    frames: tuple[Frame, ...]
    points: tuple[Point, ...]
    contacts: tuple[Any, ...] = ()
    modes: tuple[Any, ...] = ()

    @property
    def modes_change(self) -> bool:
        """Whether contacts change modes along a motion, unless the system is that of one combination of modes."""
        return bool(self.contacts) and not self.modes


def frames_and_points(
    inertial: Frame,
    bodies: tuple[Body, ...],
    loads: tuple[Load, ...],
    symbols: Iterable[Symbol],
    constraints: tuple[Constraint, ...] = (),
) -> tuple[tuple[Frame, ...], tuple[Point, ...]]:
    """All frames and points that bodies, loads and reactions depend on, parents first."""
    needed: dict[Frame | Point, None] = {}
    for place in _needed(bodies, (*loads, *constraints), symbols):
        _enter(place, inertial, needed)
    points = tuple(x for x in needed if isinstance(x, Point))
    roots = sorted(p.name for p in points if p.parent is None)
    cure = "Place one from the other with at(…)."
    expect.that(len(roots) <= 1, "points that are placed from one fixed point", came=", ".join(roots), cure=cure)
    return tuple(x for x in needed if isinstance(x, Frame)), points


def _needed(
    bodies: Iterable[Body], acting: Iterable[Load | Constraint], symbols: Iterable[Symbol]
) -> Iterator[Frame | Point]:
    """Points and frames of bodies, loads, constraints and reactions, and the frames of their vectors."""
    for part in parts_of(bodies):
        if part.frame is not None:
            yield part.frame
        yield part.mass_center
    pairs: list[tuple[Frame | Point, Vector]] = []
    for load in acting:
        pairs += [*load.forces, *load.torques]
    pairs += [(cut.at, cut.along) for cut in map(cut_of, symbols) if cut is not None]
    for place, v in pairs:
        yield place
        yield from frames_of(v)


def _enter(place: Frame | Point, inertial: Frame, needed: dict[Frame | Point, None]) -> None:
    """Add a frame or point to `needed` after its parents."""
    line: list[Any] = []
    x: Any = place
    while x is not None and x not in needed:
        line.append(x)
        x = x.parent
    root = line[-1] if x is None else None
    if isinstance(place, Frame):
        if root is not None and root is not inertial:
            raise ModelError(
                f"Expected frames that descend from {inertial.name}, got {place.name}, whose root is {root.name}. Make every "
                f"frame of this system from {inertial.name} with rotate(…)."
            )
        needed.update(dict.fromkeys(reversed(line)))
        return
    if root is not None and root.frame is not inertial:
        raise ModelError(
            f"Expected points that are placed from one fixed in {inertial.name}, got {place.name}, whose root {root.name} is fixed in "
            f"{root.frame.name}, the root of another system. Use a point of this one, made with at(…) or fixed_in(…)."
        )
    for p in reversed(line):
        for frame in (*frames_of(p.offset), *([p.body] if p.body is not None else [])):
            _enter(frame, inertial, needed)
        needed[p] = None


def geometry(frames: tuple[Frame, ...], points: tuple[Point, ...]) -> Iterator[Expr]:
    """The scalars in positions, then in orientations."""
    for p in points:
        yield from p.offset.scalars()
    for f in frames:
        yield from f.orientation.scalars() if f.orientation is not None else ()


def contents(bodies: tuple[Body, ...], loads: tuple[Load, ...], gravities: tuple[Gravity, ...]) -> Iterator[Expr]:
    """The scalars in masses, inertias and loads."""
    for part in parts_of(bodies):
        yield part.mass
        for dyad in part.inertia.dyads if part.inertia is not None else ():
            yield from (x for v in dyad for x in v.scalars())
    for load in loads:
        for _, v in (*load.forces, *load.torques):
            yield from v.scalars()
        if load.potential is not None:
            yield load.potential
    for g in gravities:
        yield from g.acceleration.scalars()
