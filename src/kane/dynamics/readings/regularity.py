# SPDX-License-Identifier: BSD-3-Clause
"""Checks for singular states, at which values are meaningless: an error at one state, a warning and NaN among several.

Speeds must satisfy A u + b = 0: |A u + b| must be small beside the largest of its terms, or within the noise of terms that vanish at
the state. Divisors of W and of the solution for dependent speeds must not vanish up to rounding: cos q = 6e-17 at q = π/2 would give
a finite but meaningless value. Redundant constraints must follow from the others at the state too, which on another branch they may
not. A load along v/|v| has no value at rest.
"""

from collections.abc import Mapping, Sequence, Set
from typing import Any

import numpy as np

from kane.dynamics.constraints.partition import Watch, choose
from kane.dynamics.formulation.recursive import WAYS, keep_digits
from kane.dynamics.poles import AdmittedSpeeds, moving_pivots
from kane.dynamics.solved import Pivot, Reading, Solved
from kane.errors import SimulationError, SingularError, ValueMissingError, cut, warn
from kane.expr.evaluation import Walk, at, evaluate, free_symbols, of_one_shape, stacked
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV, GONE, SYMBOL, WHERE
from kane.expr.regular import factors, guarding, guards_below, unguarded
from kane.expr.symbols import Parameter, Speed
from kane.expr.visit import substituting
from kane.numeric.arrays import Array, First, Mask, first_index
from kane.numeric.rank import balance, balanced, null_direction, surely_regular
from kane.numeric.scale import SOLVE_RANK, STATE_RANK, SURELY_REGULAR, TAKES_PART


def undirected(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """Words for a load without a value at `values`, its divisor and the cure; "" if all loads have values.

    Symbols without a value, reactions, count as 1.
    """
    for load in solved.regular.declared_loads:
        scalars = [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]
        order = postorder(scalars)
        given = {s: values.get(s, 1.0) for s in free_symbols(order)}
        numbers = np.array(evaluate(order, given), dtype=float) if order else np.zeros(0)
        if np.isfinite(numbers).all():
            continue
        first = int(np.flatnonzero(~np.isfinite(numbers))[0])
        node = order[first]
        if node.op is SYMBOL:
            return f"{load.name} is undefined here, as {node} is {numbers[first]:g}. Correct the function that gives its value"
        by = (
            f"{cut(str(node), 80)} divides by {cut(str(node.args[1]))} = 0"
            if node.op is DIV
            else f"{cut(str(node), 80)}"
        )
        return (
            f"{load.name} is undefined here, {by}. A force along v/|v| has no direction at rest: declare friction, "
            "kn.friction(…, smooth=…) or kn.dry_friction(…, smooth=…), and write a drag as c*v.magnitude()*v, or as "
            "v/sqrt(v.dot(v) + eps^2) with a small eps"
        )
    return ""


_NONE_FREE = "The constraints determine all speeds: leave them out."


def reading(solved: Solved, walk: Walk, known: Set[Expr]) -> Reading:
    """The reading of expressions in q, u, t, parameters and inputs, with A_n u_I + b_n for dependent speeds that are not `known`.

    If dependent speeds are given and the expressions contain speeds, constraints whose symbols are all known are read too.
    """
    dependent, count = solved.dependent_speeds, len(walk.roots)
    if not dependent or not any(isinstance(s, Speed) for s in walk.symbols):
        return Reading(walk, count, ())
    filled: dict[Expr, Expr] = {
        u: value
        for u, value in zip(solved.derived.speeds, solved.speeds_by_independent, strict=True)
        if value is not u and u not in known
    }
    rows = _rows(solved, {*known, *filled}) if len(filled) < len(dependent) else ()
    every = [*walk.roots, *(rate for _, rate, _ in rows), *(limit for _, _, limit in rows)]
    every = list(map(substituting(filled), every)) if filled else every
    return Reading(Walk(every) if rows or filled else walk, count, tuple(name for name, _, _ in rows))


def _rows(solved: Solved, known: Set[Expr]) -> list[tuple[str, Expr, Expr]]:
    """The constraints whose symbols are all known: name, A u + b, and the limit due to rounding."""
    return [
        (constraint.name, rate, solved.speed_limits[k])
        for k, (constraint, rate) in enumerate(zip(solved.held.constraints, solved.speed_residuals, strict=True))
        if all(s in known or (isinstance(s, Parameter) and s.default is not None) for s in free_symbols([rate]))
    ]


def check_on_constraints(solved: Solved, names: Sequence[str], numbers: Sequence[Any]) -> None:
    """Checks that speeds satisfy the constraints: an error at one state, for arrays a warning that names the first entry.

    `numbers` are A u + b of the constraints `names`, then the limits; values that are not finite are not checked.
    """
    count, numbers = len(names), np.broadcast_arrays(*numbers)
    with np.errstate(invalid="ignore"):
        off = [np.abs(rate) > limit for rate, limit in zip(numbers[:count], numbers[count:], strict=True)]
    anywhere = np.any(off, axis=0)
    if not anywhere.any():
        return
    place, index, more = first_index(anywhere)
    miss = ", ".join(f"{n!r} by {r[place]:.3g}" for n, r, x in zip(names, numbers, off, strict=False) if x[place])
    own = ", ".join(u.name for u in solved.independent_speeds)
    cure = f"Give the independent speeds alone, u= of {own}: the others follow." if own else _NONE_FREE
    expected = "Expected speeds that satisfy the constraints A u + b = 0"
    if not place:
        raise SimulationError(f"{expected}, got some that miss {miss}. {cure}")
    warn(
        f"{expected} at every state, got some that miss {miss} at index {index}"
        f"{f', and at {more} more' if more else ''}: the values there do not belong to one motion. {cure}"
    )


_CURE = (
    "It is on another branch of the mechanism than the configurations that were compared: derive with kn.derive(system, near=…) of "
    "this configuration."
)


def concerned(solved: Solved, roots: Sequence[Expr]) -> tuple[int, ...]:
    """The indices of expressions that contain solved values, if there are redundant constraints or no constraints."""
    if solved.embedding is not None and not solved.redundant:
        return ()
    holding = set(solved.solved_for)
    for e in postorder(roots):
        if not holding.isdisjoint(e.args):
            holding.add(e)
    return tuple(k for k, root in enumerate(roots) if root in holding)


def nan_where_more(solved: Solved, roots: Sequence[Expr], found: Sequence[Expr]) -> Sequence[Expr]:
    """The expressions `found`, one per root, NaN where redundant rows do not follow and the root depends on solved values."""
    if solved.left_out is None:
        return found
    places, (guard, _) = concerned(solved, roots), solved.left_out.guarding()
    return [guard(x) if k in places else x for k, x in enumerate(found)]


def notes(solved: Solved) -> dict[Expr, str]:
    """Words for each guard of `nan_where_more`."""
    if solved.left_out is None:
        return {}
    _, guards = solved.left_out.guarding()
    why = (
        "which was left out as redundant and holds more at this state: it is on another branch of the mechanism than those that were "
        "compared (derive with kn.derive(system, near=…) of it)"
    )
    return {guard: f"{c.name!r}, {why}" for guard, c in guards.items()}


def check_left_out(
    solved: Solved, places: Sequence[int], values: Mapping[Expr, Any], numbers: Sequence[Any]
) -> list[Any]:
    """`numbers` at `values`: those at `places`, solved with too few constraints, are a SingularError, of arrays NaN and a warning."""
    kept, watch = list(numbers), solved.left_out
    if not places or watch is None:
        return kept
    rows = _more(solved, watch, values)
    wrong = rows.any(axis=-1)
    if not wrong.any():
        return kept
    first = first_index(wrong)
    names = ", ".join(repr(c.name) for c, x in zip(solved.redundant, rows[first.place], strict=True) if x)
    told, here = (
        f"{names}, which were left out as redundant and restrict the motion",
        "this state as where they were compared",
    )
    _refuse_or_warn("constraints that follow from the others", told, first, _CURE, here)
    for k in places:
        kept[k] = np.where(wrong, np.nan, kept[k])
    return kept


def _more(solved: Solved, watch: Watch, values: Mapping[Expr, Any]) -> Mask:
    """Which redundant rows do not follow from the others (… × rows)."""
    roots = (watch.open, *(x for r in watch.rows for x in (r.beyond, r.limit)))
    try:
        found = of_one_shape(at(solved.walks.get(roots, lambda: Walk(roots)), values))
    except ValueMissingError:  # the constraints contain symbols without values
        return np.zeros(len(watch.rows), dtype=bool)
    with np.errstate(invalid="ignore"):
        rows = [(found[0] < 1) & (beyond > limit) for beyond, limit in zip(found[1::2], found[2::2], strict=True)]
    return np.stack(rows, axis=-1)


def mass_matrix_in_doubt(solved: Solved, values: Mapping[Expr, Any], pivots: Sequence[Any] = ()) -> Array | None:
    """M (… × n × n) if it may not determine u̇; None under constraints, and if no pivot is small beside its size.

    `pivots` are the values of `free_pivots` and of their sizes; without them, at one state, those along a tree are evaluated, which
    may be small if they are the same a little beside it.
    """
    if solved.embedding is not None:
        return None
    if pivots or solved.route in WAYS:
        own = solved.free_pivots
        numbers = pivots or evaluate([*own, *own.values()], values)
        if all(np.all(np.abs(x) > SURELY_REGULAR * y) for x, y in zip(numbers, numbers[len(own) :], strict=False)):
            return None
        groups = [s.coordinates for s in solved.derived.system.euler_parameters]
        if not pivots and keep_digits(list(own), values, groups):
            return None
    m = solved.derived.mass_matrix
    return np.asarray(stacked(of_one_shape(evaluate(m.entries, values)), m.shape), dtype=float)


def open_speeds(m: Array) -> list[int]:
    """The indices of speeds whose accelerations M (n × n) does not determine."""
    direction = null_direction(m, SOLVE_RANK)
    return [] if direction is None else [k for k, c in enumerate(direction) if abs(c) > TAKES_PART]


def check_mass_matrix(
    solved: Solved, read: Reading, values: Mapping[Expr, Any], numbers: Sequence[Any], pivots: Sequence[Any]
) -> list[Any]:
    """`numbers` at `values`: those with u̇ that M leaves open are a SingularError, of arrays NaN and a warning.

    `pivots` are the numbers of `free_pivots` and of their sizes.
    """
    kept, roots = list(numbers), read.walk.roots
    m = mass_matrix_in_doubt(solved, values, pivots) if pivots else None
    if m is None:
        return kept
    several = balance(m.reshape(-1, *m.shape[-2:]), rounding=0.0).matrix
    doubtful = np.argwhere(~surely_regular(several, SOLVE_RANK).reshape(m.shape[:-2]))
    open_ = {tuple(map(int, place)): open_speeds(m[tuple(place)]) for place in doubtful}
    free = sorted({k for found in open_.values() for k in found})
    if not free:
        return kept
    given = {x for own in (solved.accelerations, solved.shown[0]) for k, x in enumerate(own) if k not in free}
    wrong = [k for k in read.concerned if not (solved.solved_for - given).isdisjoint(postorder([roots[k]]))]
    if wrong:
        where = np.zeros(m.shape[:-2], dtype=bool)
        for place, found in open_.items():
            where[place] = bool(found)
        names = ", ".join(f"{solved.derived.speeds[k]}'" for k in free)
        got = f"one that leaves {names} undetermined"
        _refuse_or_warn("a mass matrix that determines u'", got, first_index(where), _OTHER_COORDINATES)
        for k in wrong:
            kept[k] = np.where(where, np.nan, kept[k])
    return kept


_OTHER_COORDINATES = (
    "Use a nearby state, or choose coordinates that are regular here (another sequence of angles, Euler parameters) or speeds "
    "that need no such division."
)


def with_regular_rates(solved: Solved, roots: Sequence[Expr]) -> list[Expr]:
    """`roots`, NaN where a divisor that they share with W vanishes."""
    return list(map(guarding(solved.rate_guards), roots))


def of_rates(solved: Solved, guard: Expr) -> str:
    """Words for a guard of a divisor of W; "" for another guard."""
    (divisor,) = unguarded(guard.args[:1])
    return (
        f"the rates, which W of q' = W u + X gives divided by {cut(divisor, 80)}"
        if divisor in solved.rate_guards
        else ""
    )


def _cure_of_rates(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """Words for the cure: other dependent speeds, if they determine the rates at this state, else other coordinates or speeds."""
    embedding = solved.embedding
    if embedding is None or not moving_pivots(solved.derived):
        return _OTHER_COORDINATES
    try:
        others = AdmittedSpeeds(solved.derived, values).cure(values, embedding.partition)
    except ValueMissingError:  # the rates contain symbols without values
        return _OTHER_COORDINATES
    if others is None:
        return _OTHER_COORDINATES
    names = ", ".join(solved.derived.speeds[k].name for k in others)
    return f"Name other dependent speeds, here System(dependent_speeds=…) of {names}; kn.simulate changes them automatically."


def check_rates(solved: Solved, values: Mapping[Expr, Any], numbers: Sequence[Any]) -> None:
    """Reports NaN in `numbers` due to a vanishing divisor of W: a SingularError at one state, for arrays a warning."""
    by = solved.rate_guards
    if not by or not any(np.isnan(x).any() for x in numbers):
        return
    lost = np.logical_or.reduce([np.isnan(x) for x in numbers])
    known = [d for d in by if all(s in values for s in solved.rate_symbols[d])]
    here = evaluate([*known, *(by[d] for d in known)], values)
    for divisor, value, terms in zip(known, here, here[len(known) :], strict=False):
        with np.errstate(invalid="ignore"):
            gone = np.broadcast_to(np.abs(value) <= GONE * terms, lost.shape) & lost
        if not gone.any():
            continue
        first = first_index(gone)
        what = f"W of q' = W u + X divided by {cut(divisor, 80)} = {float(np.broadcast_to(value, lost.shape)[first.place]) + 0.0:.3g}"
        state = {s: np.broadcast_to(v, lost.shape)[first.place] for s, v in values.items()}
        _refuse_or_warn("speeds that determine the rates", what, first, _cure_of_rates(solved, state))
        return


def check_pivots(solved: Solved, roots: Sequence[Expr], values: Mapping[Expr, Any], numbers: Sequence[Any]) -> None:
    """Reports NaN in `numbers` of `roots` due to a vanishing divisor of the constraints.

    A SingularError at one state; for arrays a warning names the first entry.
    """
    if not any(np.isnan(x).any() for x in numbers):
        return
    below = [g for g in guards_below(roots) if not of_rates(solved, g)]
    lost = np.logical_or.reduce([np.isnan(x) for x in numbers])
    numbers, terms = (evaluate([g.args[k] for g in below], values) for k in (0, 1))
    for g, x, term in zip(below, numbers, terms, strict=True):
        with np.errstate(invalid="ignore"):
            where = np.asarray(np.abs(x) <= GONE * term) & lost
        if where.any():
            p, first = pivot_of(solved, g), first_index(where)
            here = {s: np.broadcast_to(v, where.shape)[first.place] for s, v in values.items()}
            got = f"{divided_by(p, 'they')} = {float(evaluate(p.value, here)) + 0.0:.3g}"
            _refuse_or_warn("dependent speeds that the constraints determine", got, first, _cure_of_pivot(solved, here))


def pivot_of(solved: Solved, guard: Expr) -> Pivot:
    """The pivot of a guard; solutions with A_Dᵀ have other expressions for the same pivots."""
    (divisor,) = unguarded(guard.args[:1])
    for p in solved.dependent_pivots:
        if any(divisor is f for f in factors(p.value)):
            return p
    return Pivot(solved.dependent_speeds, divisor, guard.args[1])


def divided_by(p: Pivot, who: str = "the constraints") -> str:
    """Words for the speeds of a pivot and their divisor, if it is short."""
    names = ", ".join(sorted(u.name for u in p.speeds))
    chosen = any(node.op is WHERE for node in postorder([p.value]))
    return f"{names}, which {who} give divided by {'a determinant' if chosen else f'{cut(p.value, 80)}'}"


def _refuse_or_warn(expected: str, got: str, first: First, cure: str, here: str = "this state") -> None:
    """Raises a SingularError at a single state; for arrays warns, naming the first entry."""
    if not first.place:
        raise SingularError(f"Expected {expected} at {here}, got {got}. {cure}")
    warn(f"Expected {expected} at every state, got {got} at {first}: the values there are NaN. {cure}")


def _cure_of_pivot(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """Words for the cure: the dependent speeds chosen numerically at this state, if they are as many."""
    assert solved.embedding is not None
    matrix = solved.embedding.rows.a
    try:
        a = np.asarray(evaluate(matrix, values), dtype=float)
    except ValueMissingError:  # A contains symbols without values
        a = np.full(matrix.shape, np.nan)
    rows = list(solved.embedding.partition.rows)
    if not np.isfinite(a).all():
        return "Name others, System(dependent_speeds=…)."
    other = choose(a[rows])
    block = balanced(a[rows])[np.ix_(other.rows, other.dependent)]
    if len(other.rows) < len(rows) or not np.linalg.cond(block) * STATE_RANK < 1:
        if len(choose(a).rows) < len(rows):
            return (
                "No other choice is possible: the constraints determine fewer speeds here than elsewhere, it is a singular "
                "configuration. Use a nearby state."
            )
        return "Here other constraints are redundant; kn.simulate changes them automatically, kn.linearize and kn.inverse need none."
    names = ", ".join(solved.derived.speeds[k].name for k in sorted(other.dependent))
    return (
        f"Name others, here System(dependent_speeds=…) of {names}; kn.simulate changes them automatically, kn.linearize and "
        "kn.inverse need none."
    )
