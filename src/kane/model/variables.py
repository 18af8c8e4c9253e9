# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates in order, sets of Euler parameters, and the definitions of the generalized speeds.

Where the independent speeds alone are defined, u_1 … u_p (Kane & Levinson 1985, sec. 2.13), rates of constraints are those that are
missing, as the equations need as many speeds as rates: w = A_q q̇ + b_q vanishes, and shortens q̇ = W u + X where it stands in it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from kane import expect
from kane.errors import ModelError, NotAffineError, SpeedsError, cut
from kane.expr.differentiation import Affine, affine_forms, euler_parameter_rates, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Input, QuasiRate, Rate, Speed, Symbol, Symbols, input_of, names, rate, word
from kane.expr.visit import substituted
from kane.model.constraints import Constraint
from kane.numeric.arrays import Array
from kane.numeric.rank import balanced, singular
from kane.numeric.sampling import SEEDS, values_of
from kane.numeric.scale import SPEEDS_RANK
from kane.space.frame import Frame
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class EulerParameters(Immutable):
    """One set of Euler parameters in use and its quasi-rates."""

    coordinates: tuple[Coordinate, ...]
    quasi: tuple[QuasiRate, ...]


def euler_sets(frames: tuple[Frame, ...]) -> tuple[EulerParameters, ...]:
    """The sets of Euler parameters that frames are oriented by."""
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
    """The coordinates in the order given, else those of joints, `first`, then the others as they appear.

    Of the others those of positions come before those of orientations, and q1, q2, … stay together.
    """
    seen = dict.fromkeys(s for s in symbols if isinstance(s, Coordinate))
    if order is None:
        early = dict.fromkeys(q for q in first if q in seen)
        groups: dict[str, list[Coordinate]] = {}
        for q in (q for q in seen if q not in early):
            groups.setdefault(q.name.rstrip("0123456789"), []).append(q)
        rest = (sorted(group, key=lambda q: int(q.name[len(stem) :] or -1)) for stem, group in groups.items())
        return Symbols((*early, *(q for group in rest for q in group)))
    listed = _coordinates(by_name(order, seen))
    unused = (q for q in listed if q not in seen)
    expected = f"coordinates= to list those that frames and points depend on ({_names(seen)})"
    cure = "Leave it out, or write it into a position or orientation; is a body missing from bodies=?"
    expect.none(unused, expected, "{}, which nothing uses", cure)
    absent = [q for q in seen if q not in set(listed)]
    if absent or len(listed) != len(seen):
        cure = f"Add {_names(absent)}" if absent else "List none twice"
        raise ModelError(f"Expected coordinates= to list each of {_names(seen)} once, got {_names(listed)}. {cure}.")
    return listed


def moved(speeds: Mapping[Speed, Any] | str, constraints: Iterable[Constraint]) -> list[Expr]:
    """The coordinates of constraints that have a speed: one that no place depends on, a counter, may be in them alone."""
    held = [*free_symbols(c.expr for c in constraints)]
    held += [s.place for s in held if isinstance(s, Rate) and isinstance(s.place, Coordinate)]
    if not isinstance(speeds, Mapping):
        return [s for s in held if isinstance(s, Coordinate)]
    defined = {s.place for s in free_symbols(x for x in speeds.values() if isinstance(x, Expr)) if isinstance(s, Rate)}
    return [s for s in held if s in defined]


def by_name(items: Any, own: Iterable[Symbol]) -> Symbols[Any]:
    """Symbols by themselves, by name, or several names in one text; what is no name of `own` is kept as it came."""
    known = {s.name: s for s in own}
    items = names(items) if isinstance(items, str) else [items] if isinstance(items, Symbol) else items
    if not isinstance(items, Iterable):
        raise ModelError(f"Expected a list of {', '.join(known)} by symbol or name, got {cut(repr(items))}.")
    return Symbols(known.get(x, x) if isinstance(x, str) else x for x in items)


def _coordinates(order: Any) -> Symbols[Coordinate]:
    """Coordinates; a single one, or something else, is refused."""
    several = not isinstance(order, Expr) and isinstance(order, Iterable)
    right = several and all(isinstance(q, Coordinate) for q in order)
    expect.that(right, "coordinates= to be a list of coordinates, such as (q1, q2)", order)
    return Symbols(order)


def _names(symbols: Iterable[Any]) -> str:
    return ", ".join(map(str, symbols))


def speed_definitions(
    speeds: Mapping[Speed, Any] | str, coordinates: tuple[Coordinate, ...], euler: tuple[EulerParameters, ...]
) -> dict[Speed, Expr]:
    """The definition of each generalized speed; "rates" takes u = q̇ throughout."""
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
                f"Expected generalized speeds as keys of speeds=, got {u!r} ({type(u).__name__}), which has that role already. "
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
    """The rates of the coordinates in their order, of each set of Euler parameters its quasi-rates in their place."""
    set_of = {q: s for s in euler for q in s.coordinates}
    found: list[Expr] = []
    for q in coordinates:
        if q not in set_of:
            found.append(rate(q))
        elif q is set_of[q].coordinates[0]:
            found.extend(set_of[q].quasi)
    return found


def rates_by_quasi(euler: Sequence[EulerParameters]) -> dict[Expr, Expr]:
    """The rates of Euler parameters by their quasi-rates."""
    found: dict[Expr, Expr] = {}
    for s in euler:
        found.update(zip(map(rate, s.coordinates), euler_parameter_rates(s.coordinates, s.quasi), strict=True))
    return found


def inputs_with_rates(
    symbols: Iterable[Symbol], shape: Iterable[Expr], constraints: Iterable[Constraint]
) -> tuple[Input | Rate, ...]:
    """The inputs, each with the derivatives that the equations need.

    Two where it places or turns something, one in a motion constraint, and those that loads name.
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
    """A definition is affine in rates, contains one, and no speed."""
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
    """u = q̇; for Euler parameters the three measure numbers of the angular velocity instead."""
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
    """Rates of constraints as speeds, where the definitions are exactly the independent speeds; none otherwise.

    All independent constraints take part: with fewer speeds left out than there are constraints, one was forgotten.
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
    found: dict[Speed, Expr] = {}
    for k, place in enumerate(next(iter(chosen))):
        c = constraints[place]
        name = next(
            n for n in (f"w{k + 1}", f"w{k + 1}_{c.name}", *(f"w_{i}" for i in range(len(rates)))) if n not in taken
        )
        taken.add(name)
        found[Speed.declare(word(name), None, "", f"rate of the constraint {c.name}, which vanishes")] = offered[place]
    return found


def constraint_rate(constraint: Constraint) -> Expr:
    """ḟ of a configuration constraint, a motion constraint itself: A_q q̇ + b_q."""
    return time_derivative(constraint.expr) if constraint.kind == "configuration" else constraint.expr


def _independent(rows: Array, first: int, missing: int) -> tuple[int, ...] | None:
    """The rows beyond the `first` ones that these do not give; None where they are not `missing`, all that are independent."""
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
