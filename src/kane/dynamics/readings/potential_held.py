# SPDX-License-Identifier: BSD-3-Clause
"""Forces that constraints C q̇ + c = 0 let be changed: Q + Cᵀλ does what Q does, and may have a potential energy where Q has none.

(Kane & Levinson 1985, sec. 5.1.) Along motions that the constraints allow dQ + Σ λ_k dC_k must vanish. Where no λ does that, at some
configuration, there is no potential energy. Else λ is such that some coordinates have no force, or solved for from that condition.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, islice

import numpy as np

from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.readings.rate_forces import Place, measured, places
from kane.dynamics.terms import sum_of
from kane.errors import KaneError, PotentialError
from kane.expr.build import mul, neg, sub
from kane.expr.differentiation import diff
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.solve import invert
from kane.expr.symbols import Coordinate
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_ROOT, STATE_RANK

Rows = list[list[Expr]]
Held = tuple[tuple[Coordinate, ...], Exprs]

_SETS, _FEW = 24, 4
"""Sets of coordinates that are tried as those that V does without, and as those that the others give."""
_SEEN = 8
"""Configurations at which constraints are looked at."""


def check_allowed(derived: Derived, forces: Exprs, rows: Rows, names: str) -> None:
    """Raise where no λ makes dQ + Σ λ_k dC_k vanish along the motions that the constraints allow, at some configuration.

    Where λ = 0 is the only one, at all of them, Q itself would have to do, and does not.
    """
    q = derived.system.coordinates
    n, whole = len(q), [*forces, *(x for row in rows for x in row), *q]
    own = places(whole, unit=[s.coordinates for s in derived.system.euler_parameters])
    if derived.constraints.constraints:
        at = derived.compared.at
        own = places(whole, [at.at(k) for k in range(min(at.count, _SEEN))])
    c = measured([x for row in rows for x in row], own).reshape(len(own), len(rows), n)
    tables = [measured([diff(f[i], x) for i in range(n) for x in q], own) for f in (forces, *rows)]
    alone: list[int] = []
    for k in range(len(own)):
        turns = [t[k].reshape(n, n) - t[k].reshape(n, n).T for t in tables]
        if not np.isfinite(turns).all() or not np.isfinite(c[k]).all():
            continue
        free = _null(c[k])
        inside = np.triu_indices(free.shape[1], 1)
        within = [(free.T @ t @ free)[inside] for t in turns]
        bound = ROUNDED_ROOT * np.linalg.norm(
            (np.abs(free).T @ (2 * np.abs(tables[0][k].reshape(n, n))) @ np.abs(free))[inside]
        )
        others = np.array(within[1:]).reshape(len(rows), -1).T
        weights, _, rank, _ = np.linalg.lstsq(others, within[0], rcond=None)
        if np.linalg.norm(within[0] - others @ weights) > bound:
            raise PotentialError(_not_allowed(names, q, own[k]))
        alone.append(k if rank == len(rows) and np.linalg.norm(others @ weights) <= bound else -1)
    if alone and min(alone) >= 0:
        raise PotentialError(_not_allowed(names, q, own[0]))


def _not_allowed(names: str, q: Sequence[Coordinate], at: Place) -> str:
    where = ", ".join(f"{s} = {at[s]:.4g}" for s in q)
    return (
        f"Expected forces with a potential energy, got {names}, which have none along the motions that the constraints allow: "
        f"about {where} their work depends on the way, whatever forces of constraints are added. Name the other loads, "
        "eom.find_potential([…]); what these do is power."
    )


def _null(c: Array) -> Array:
    _, s, v = np.linalg.svd(c)
    rank = int((s > STATE_RANK * s.max(initial=0)).sum())
    return np.asarray(v[rank:].T)


def held(forces: Exprs, rows: Rows, q: Sequence[Coordinate], at: Place) -> Iterator[Held]:
    """Forces Q + Cᵀλ that may have a potential energy, and the coordinates of which they are."""
    for way in (_without_some, _by_multipliers):
        yield from way(forces, rows, q, at)


def _inverses(rows: Rows, n: int) -> Iterator[tuple[tuple[int, ...], list[int], list[list[Expr]]]]:
    """Sets of coordinates that the others give, the others, and the inverse of their columns of C, transposed."""
    for gone in islice(combinations(reversed(range(n)), len(rows)), _SETS):
        try:
            inverse = invert([[row[i] for row in rows] for i in gone]).rows
        except KaneError:
            continue
        yield gone, [i for i in range(n) if i not in gone], inverse


def _without_some(forces: Exprs, rows: Rows, q: Sequence[Coordinate], at: Place) -> Iterator[Held]:
    """With λ such that some coordinates have no force, and the other coordinates with theirs."""
    for gone, kept, inverse in _inverses(rows, len(q)):
        weights = [sum_of(mul(x, forces[i]) for x, i in zip(line, gone, strict=True)) for line in inverse]
        yield tuple(q[i] for i in kept), _added(forces, rows, weights, kept)


def _by_multipliers(forces: Exprs, rows: Rows, q: Sequence[Coordinate], at: Place) -> Iterator[Held]:
    """With the λ that dQ + Σ λ_k dC_k = 0 gives along as many pairs of allowed directions as there are λ."""
    n = len(q)
    for gone, kept, inverse in islice(_inverses(rows, n), _FEW):
        allowed = [_direction(i, gone, inverse, rows, n) for i in kept]
        pairs = list(combinations(allowed, 2))
        table = [[_turn(row, x, y, q) for row in rows] for x, y in pairs]
        numbers = measured([x for line in table for x in line], [at]).reshape(len(pairs), len(rows))
        chosen = _independent(numbers, len(rows))
        if chosen is None:
            continue
        try:
            solved = invert([table[k] for k in chosen]).rows
        except KaneError:
            continue
        right = [_turn(forces, *pairs[k], q) for k in chosen]
        weights = [sum_of(mul(x, r) for x, r in zip(line, right, strict=True)) for line in solved]
        yield tuple(q), _added(forces, rows, weights, range(n))


def _added(forces: Exprs, rows: Rows, weights: Sequence[Expr], kept: Sequence[int]) -> Exprs:
    """Q − Cᵀ w of some coordinates."""
    return tuple(sub(forces[i], sum_of(mul(row[i], w) for row, w in zip(rows, weights, strict=True))) for i in kept)


def _direction(i: int, gone: Sequence[int], inverse: Rows, rows: Rows, n: int) -> list[Expr]:
    """The rates of all coordinates, where that of one is 1 and the others that are not given are 0."""
    found = [ONE if k == i else ZERO for k in range(n)]
    for j, g in enumerate(gone):
        found[g] = neg(sum_of(mul(line[j], row[i]) for line, row in zip(inverse, rows, strict=True)))
    return found


def _turn(form: Sequence[Expr], x: Sequence[Expr], y: Sequence[Expr], q: Sequence[Coordinate]) -> Expr:
    """Σ (∂w_t/∂q_s − ∂w_s/∂q_t) x_s y_t."""
    return sum_of(
        mul(sub(diff(form[t], q[s]), diff(form[s], q[t])), sub(mul(x[s], y[t]), mul(x[t], y[s])))
        for s, t in combinations(range(len(q)), 2)
        if not (x[s] is y[t] is x[t] is y[s] is ZERO)
    )


def _independent(table: Array, count: int) -> list[int] | None:
    """As many independent rows as there are columns, the largest first."""
    left, chosen = table.copy(), list[int]()
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=1) if len(left) else np.zeros(0)
        k = int(np.argmax(sizes)) if len(sizes) else -1
        if k < 0 or not sizes[k] > ROUNDED_ROOT * np.abs(table).max():
            return None
        chosen.append(k)
        along = left[k] / sizes[k]
        left = left - np.outer(left @ along, along)
    return chosen
