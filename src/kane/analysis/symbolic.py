# SPDX-License-Identifier: BSD-3-Clause
"""`linearize_symbolic`: A and B of ẋ = A x + B r as expressions, for small systems.

    δq = T ξ,  G T ξ = 0  ⟹  ξ = N ξ_I,       A δu + ∂(A u + b)/∂q δq = 0  ⟹  δu = B δu_I + E ξ_I

T is the identity; for Euler parameters it turns three small angles along the axes of their frame into δe.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.state import GIVEN, misses
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import Perturbations, perturbations, unsolved
from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.build import add, mul, neg, sub
from kane.expr.diff import tangent
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.solve import solve_lu
from kane.expr.substitute import substitute
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array, Mask
from kane.numeric.named import named_values
from kane.numeric.sample import values_of

Column = list[Expr]

_ZERO = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicLinear:
    """ẋ = A x + B r with A and B as expressions; `states` names x, `coordinates` of them are perturbations of coordinates."""

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    coordinates: int
    A: Matrix
    B: Matrix

    def __repr__(self) -> str:
        return f"SymbolicLinear({', '.join(self.states)}; A {self.A.shape}, B {self.B.shape})"


def dependence(a: Array, count: int) -> Mask:
    """Which of the states the speeds depend on, through whatever chain; the first `count` are coordinates."""
    from scipy.linalg import matrix_balance

    scaled = np.abs(matrix_balance(a, permute=False)[0])
    linked = scaled > _ZERO * scaled.max(initial=0)
    matters = np.arange(len(a)) >= count
    while True:
        more = matters | linked[matters].any(axis=0)
        if np.array_equal(more, matters):
            return matters
        matters = more


def linearize_symbolic(eom: Equations, point: Mapping[Any, Any]) -> SymbolicLinear:
    """A and B about an equilibrium or a steady motion, exact, with parameters as symbols.

    Parameters
    ----------
    eom : Equations
    point : expressions of parameters for coordinates, speeds and inputs, by symbol or name; what is left out stays a symbol

    Raises
    ------
    SimulationError
        if the point is off the constraints, or neither at rest nor in steady motion, at a sample of what stays a symbol
    """
    known = perturbations(eom.derived)
    symbols: tuple[Symbol, ...] = (*eom.coordinates, *eom.speeds, *eom.inputs)
    at = {s: as_expr(e) for s, e in named_values("the point", symbols, point).items()}
    memo: dict[Expr, Expr] = {}

    def there(roots: Sequence[Expr]) -> Column:
        return [substitute(e, at, memo) for e in roots]

    made = unsolved(eom.derived)
    plain = [made.rates[i] for i in known.coordinates]
    flow = [*plain, *made.spins, *without_unknowns(eom.solved, [*eom.accelerations])]
    held = [*made.configuration, *made.motion]
    moved: tuple[Expr, ...] = (*eom.speeds, *eom.inputs)
    seeds = [*_spread(eom, known), *({s: ONE} for s in moved)]
    columns = []
    for seed in seeds:
        own: dict[Expr, Expr] = {}
        columns.append(there([tangent(e, seed, own) for e in (*flow, *held)]))
    values = there([*flow, *held])
    sample = _Sample(eom, [*values, *(x for column in columns for x in column)])
    _check_held(eom, sample(values[len(flow) :]))
    w, n, nr, c = len(known.names), len(eom.speeds), len(eom.inputs), len(made.configuration)
    _turn(columns, values, len(plain), w)
    f, m = len(flow), len(made.motion)
    g = [column[f : f + c] for column in columns]
    v = [column[f + c : f + c + m] for column in columns]
    wished = [k for k, q in enumerate(known.symbols) if q in set(eom.system.dependent_coordinates)]
    inputs = range(w + n, w + n + nr)
    free_q, n_q = _eliminated(g[:w], [g[k] for k in inputs], wished, sample)
    shift = [_combined(v[:w], column) for column in n_q]
    for k in range(nr):
        shift[len(free_q) + k] = list(map(add, shift[len(free_q) + k], v[w + n + k]))
    own_u = list(eom.embedding.partition.dependent) if eom.embedding else []
    free_u, n_u = _eliminated(v[w : w + n], shift, own_u, sample)
    wide = len(free_q) + len(free_u) + nr
    moves: list[Column] = []
    for k in range(wide):
        i, j = k - len(free_q), k - len(free_q) - len(free_u)
        if i < 0:
            moves.append([*n_q[k], *n_u[len(free_u) + k], *[ZERO] * nr])
        elif j < 0:
            moves.append([*[ZERO] * w, *n_u[i], *[ZERO] * nr])
        else:
            unit = [ONE if r == j else ZERO for r in range(nr)]
            moves.append([*n_q[len(free_q) + j], *n_u[len(free_u) + len(free_q) + j], *unit])
    rows = [*free_q, *(w + i for i in free_u)]
    flows = [column[:f] for column in columns]
    result = [[x[r] for r in rows] for x in (_combined(flows, move) for move in moves)]
    states = (*(known.names[i] for i in free_q), *(eom.speeds[i].name for i in free_u))
    a = Matrix(list(zip(*result[: len(rows)], strict=True)), (len(rows), len(rows)))
    b = Matrix(list(zip(*result[len(rows) :], strict=True)), (len(rows), nr))
    _check_steady(states, len(free_q), sample([values[r] for r in rows]), _numbers(a, sample))
    return SymbolicLinear(states, tuple(r.name for r in eom.inputs), len(free_q), a, b)


def _spread(eom: Equations, known: Perturbations) -> list[dict[Expr, Expr]]:
    """δq of each perturbation."""
    seeds: list[dict[Expr, Expr]] = [{eom.coordinates[i]: ONE} for i in known.coordinates]
    for places in known.sets:
        e0, e1, e2, e3 = (eom.coordinates[i] for i in places)
        half = as_expr(0.5)
        for column in ((-e1, e0, e3, -e2), (-e2, -e3, e0, e1), (-e3, e2, -e1, e0)):
            seeds.append({e: mul(half, x) for e, x in zip((e0, e1, e2, e3), column, strict=True)})
    return seeds


def _turn(columns: list[Column], values: Column, plain: int, width: int) -> None:
    """θ̇ = δω − ω × θ."""
    for first in range(plain, width, 3):
        x, y, z = values[first : first + 3]
        for k, crossed in enumerate(((ZERO, z, neg(y)), (neg(z), ZERO, x), (y, neg(x), ZERO))):
            for i, e in enumerate(crossed):
                columns[first + k][first + i] = sub(columns[first + k][first + i], e)


def _combined(columns: Sequence[Column], factors: Column) -> Column:
    height = len(columns[0]) if columns else 0
    return [dot([column[i] for column in columns], factors) for i in range(height)]


class _Sample:
    """Numbers at one set of values for all that stays a symbol."""

    def __init__(self, eom: Equations, roots: Sequence[Expr]) -> None:
        self.values = values_of((*free_symbols(roots), *eom.parameters), 20050)

    def __call__(self, roots: Sequence[Expr]) -> Array:
        return np.array(evaluate(list(roots), self.values), dtype=float) if roots else np.zeros(0)


def _numbers(a: Matrix, sample: _Sample) -> Array:
    return sample([x for row in a.rows for x in row]).reshape(a.shape)


def _eliminated(
    columns: Sequence[Column], rest: Sequence[Column], wished: Sequence[int], sample: _Sample
) -> tuple[tuple[int, ...], list[Column]]:
    """x of Σ columns x + Σ rest y = 0, a column for each free x and each y."""
    count, height = len(columns), len(columns[0]) if columns else 0
    if not height:
        return tuple(range(count)), [
            *([ONE if i == k else ZERO for i in range(count)] for k in range(count)),
            *([ZERO] * count for _ in rest),
        ]
    numbers = sample([x for column in columns for x in column]).reshape(count, height).T
    found = choose(numbers, wished)
    free = found.independent(count)
    square = [[columns[c][r] for c in found.dependent] for r in found.rows]
    right = [[neg(columns[k][r]) for r in found.rows] for k in free] + [[neg(y[r]) for r in found.rows] for y in rest]
    solved = solve_lu(square, right)
    made = []
    for k, x in enumerate(solved):
        column: Column = [ZERO] * count
        if k < len(free):
            column[free[k]] = ONE
        for c, value in zip(found.dependent, x, strict=True):
            column[c] = value
        made.append(column)
    return free, made


def _check_held(eom: Equations, left: Array) -> None:
    names = [*(c.name for c in eom.system.holonomic), *(c.name for c in eom.constraints.constraints)]
    bad = misses(names, left)
    if bad:
        raise SimulationError(
            f"Expected a point on the constraints, got one that misses {bad} with parameters at their defaults. Give "
            "expressions that satisfy them for all parameters."
        )


def _check_steady(states: Sequence[str], count: int, rest: Array, a: Array) -> None:
    matters = dependence(a, count)
    left = [f"{s}' = {x:.6g}" for s, x, m in zip(states, rest, matters, strict=True) if m and not abs(x) <= GIVEN]
    if left:
        raise SimulationError(
            f"Expected an equilibrium or a steady motion, got a point where there remains {', '.join(left)} with parameters at their "
            "defaults."
        )
