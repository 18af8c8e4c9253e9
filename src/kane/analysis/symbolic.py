# SPDX-License-Identifier: BSD-3-Clause
"""`linearize_symbolic`: A and B of ẋ = A x + B r as expressions, for small systems.

    δq = T ξ,  G T ξ = 0  ⟹  ξ = N ξ_I + P δr,      A δu + ∂(A u + b)/∂q δq = 0  ⟹  δu = B δu_I + E ξ_I + Q δr

T is the identity; for Euler parameters it turns three small angles along the axes of their frame into δe.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.state import check_equations, misses
from kane.analysis.steady import dependence
from kane.analysis.tangents import FreePart, by_free_part, perturbations, spread, tangents, turning_rates
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import unsolved
from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.errors import Attributes, CornerError, SimulationError, cut
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.solve import solve_lu
from kane.expr.switching import on_sides, switches
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import substituted
from kane.numeric.arrays import Array, Entries
from kane.numeric.named import named_values
from kane.numeric.sampling import values_of
from kane.numeric.scale import GIVEN

_SEED = 20050


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicLinear(Attributes):
    """ẋ = A x + B r with A and B as expressions; `states` names x, `coordinates` of them are perturbations of coordinates."""

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    coordinates: int
    A: Matrix
    B: Matrix

    def __repr__(self) -> str:
        return f"SymbolicLinear({', '.join(self.states)}; A {self.A.shape}, B {self.B.shape})"


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
    CornerError
        if a switch (|x|, max, where, …) stands there whose sides have other derivatives
    """
    check_equations(eom)
    perturbed, equations = perturbations(eom), unsolved(eom.derived)
    plain = [equations.rates[i] for i in perturbed.coordinates]
    flow = [*plain, *equations.spins, *without_unknowns(eom.solved, [*eom.accelerations, *eom.state_rates])]
    turned = spread(perturbed, np.array(eom.coordinates, dtype=object)).T
    seeds: list[dict[Expr, Expr]] = [dict(zip(eom.coordinates, map(as_expr, row), strict=True)) for row in turned]
    seeds += [{s: ONE} for s in (*eom.speeds, *eom.states, *eom.inputs)]
    values, slopes = _of_either_side(eom, point, [*flow, *equations.configuration, *equations.motion], seeds)
    width, n, rates, c = len(perturbed.names), len(eom.speeds), len(flow), len(equations.configuration)
    slopes[:width, :width] = slopes[:width, :width] - turning_rates(values[:width], len(plain))
    point_values = values_of((*free_symbols([*values, *slopes.flat]), *eom.parameters), _SEED)

    def sample(exprs: Entries) -> Array:
        return np.array(evaluate(list(map(as_expr, exprs.flat)), point_values), dtype=float).reshape(exprs.shape)

    names = [*(c.name for c in eom.system.holonomic), *(c.name for c in eom.constraints.constraints)]
    bad = misses(names, sample(values[rates:]))
    if bad:
        raise SimulationError(
            f"Expected a point on the constraints, got one that misses {bad} with parameters at their defaults. Give "
            "expressions that satisfy them for all parameters."
        )
    wished = [k for k, q in enumerate(perturbed.symbols) if q in set(eom.system.dependent_coordinates)]
    own = eom.embedding.partition.dependent if eom.embedding else ()
    tangent = tangents(
        slopes[rates : rates + c],
        slopes[rates + c :],
        width,
        n,
        _in_symbols(sample, wished),
        _in_symbols(sample, own),
    )
    rows = [*tangent.free_q, *(width + i for i in (*tangent.free_u, *range(n, n + len(eom.states))))]
    result = slopes[rows] @ tangent.moves
    states = (*(perturbed.names[i] for i in tangent.free_q), *(eom.speeds[i].name for i in tangent.free_u))
    counts = len(tangent.free_q), len(states)
    states = (*states, *(s.name for s in eom.states))
    a, b = result[:, : len(rows)], result[:, len(rows) :]
    _check_steady(states, counts, sample(values[rows]), sample(a))
    inputs = tuple(r.name for r in eom.inputs)
    return SymbolicLinear(states, inputs, len(tangent.free_q), Matrix(a, a.shape), Matrix(b, b.shape))


def _of_either_side(
    eom: Equations, point: Mapping[Any, Any], roots: Sequence[Expr], seeds: Sequence[Mapping[Expr, Expr]]
) -> tuple[Entries, Entries]:
    """The roots and their derivatives as `_at_point` has them, which must be the same on all sides of what switches at the point."""
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs)
    at = {s: as_expr(e) for s, e in named_values("the point", symbols, point).items()}
    standing = [s for s in switches(roots) if substituted(s.quantity, at) is ZERO]
    sides = {s.quantity: Parameter.declare(f"side{k}", description="of a switch") for k, s in enumerate(standing)}
    memo: dict[Expr, Expr] = {}
    either = [on_sides(root, sides, memo) for root in roots]

    def on(signs: Sequence[int]) -> tuple[Entries, Entries]:
        return _at_point({**at, **dict(zip(sides.values(), map(as_expr, signs), strict=True))}, either, seeds)

    first = on([1] * len(standing))
    for k, s in enumerate(standing):
        for others in (1, -1):
            one, other = (on([sign if j == k else others for j in range(len(standing))]) for sign in (1, -1))
            if any(a is not b for x, y in zip(one, other, strict=True) for a, b in zip(x.flat, y.flat, strict=True)):
                raise CornerError(
                    f"Expected a point at which the equations have one derivative, got a corner: {cut(str(s.nodes[0]), 80)} turns at "
                    f"{cut(str(s.quantity))} = 0. kn.linearize(eom, …, side=…) takes the derivative of one side in numbers."
                )
    return first


def _at_point(
    at: Mapping[Expr, Expr], roots: Sequence[Expr], seeds: Sequence[Mapping[Expr, Expr]]
) -> tuple[Entries, Entries]:
    """The roots, and their derivatives along each of the seeds (roots × seeds), at the point."""
    memo: dict[Expr, Expr] = {}
    columns = [list(roots)]
    for seed in seeds:
        own: dict[Expr, Expr] = {}
        columns.append([tangent(e, seed, own) for e in roots])
    table = np.array([[substituted(e, at, memo) for e in column] for column in columns], dtype=object)
    return table[0], table[1:].T


def _in_symbols(sample: Callable[[Entries], Array], preferred: Sequence[int]) -> FreePart:
    """Solving in expressions, for what is well determined at a sample."""

    def solve(square: Entries, right: Entries) -> Entries:
        solutions = solve_lu(Matrix(square).rows, Matrix(right.T).rows)
        return np.array(solutions, dtype=object).reshape(right.T.shape).T

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(sample(a), preferred), solve)

    return solved


def _check_steady(states: Sequence[str], counts: tuple[int, int], rest: Array, a: Array) -> None:
    matters = dependence(a, *counts)
    left = [f"{s}' = {x:.6g}" for s, x, m in zip(states, rest, matters, strict=True) if m and not abs(x) <= GIVEN]
    if left:
        raise SimulationError(
            f"Expected an equilibrium or a steady motion, got a point where there remains {', '.join(left)} with parameters at their "
            "defaults."
        )
