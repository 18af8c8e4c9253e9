# SPDX-License-Identifier: BSD-3-Clause
"""The unsolved equations at a state, as numbers: K z = k solved, and the exact derivatives of everything in q, u and inputs.

The routines are compiled once for each set of equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kane.analysis.routines import once, routine
from kane.analysis.state import State
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import partial_columns, unsolved
from kane.equations.equations import Equations
from kane.equations.handle import Handle
from kane.errors import SingularError
from kane.expr.node import Expr
from kane.numeric.arrays import Array
from kane.numeric.rank import SOLVE_RANK, SURE_RANK, balanced, singular


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """K, k, f, A u + b, q̇ and spins at a state (or at many: leading axes)."""

    matrix: Array
    right: Array
    configuration: Array
    motion: Array
    rates: Array
    spins: Array

    def constraints(self, n: int) -> Array:
        """A."""
        m = self.motion.shape[-1]
        return self.matrix[..., n : n + m, :n]


def values_at(eom: Equations, state: State) -> Values:
    """K and k, and what the state must satisfy."""
    handle = once(eom, ("values",), lambda: _values(eom))
    flat = handle(state.t, state.x, state.p, state.r)
    n, m = len(eom.speeds), len(eom.b)
    size = n + m + len(eom.reactions)
    c, nq = len(eom.system.holonomic), len(eom.coordinates)
    at = np.cumsum([size * size, size, c, m, nq])
    parts = np.split(flat, at, axis=-1)
    return Values(parts[0].reshape(*flat.shape[:-1], size, size), *parts[1:])


def _values(eom: Equations) -> Handle:
    made = unsolved(eom.derived)
    return routine(eom, "values", [*(x for row in made.matrix for x in row), *made.right, *made.places])


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """Derivatives in some variables, a column each: of f, A u + b, q̇, spins, and of K z − k at fixed z."""

    configuration: Array
    motion: Array
    rates: Array
    spins: Array
    residual: Array


def slopes_at(eom: Equations, state: State, z: Array, by: tuple[Expr, ...] | None = None) -> Slopes:
    """Derivatives in q, u and the inputs, or in the symbols `by`."""
    handle = once(eom, ("slopes", *(by or ())), lambda: _slopes(eom, by))
    width = len(eom.coordinates) + len(eom.speeds) + len(eom.inputs) if by is None else len(by)
    flat = handle(state.t, np.append(state.x, z), state.p, state.r).reshape(width, -1).T
    spins = 3 * len(eom.system.euler_parameters)
    at = np.cumsum([len(eom.system.holonomic), len(eom.b), len(eom.coordinates), spins])
    return Slopes(*np.split(flat, at))


def _slopes(eom: Equations, by: tuple[Expr, ...] | None) -> Handle:
    made = unsolved(eom.derived)
    symbols = (*eom.coordinates, *eom.speeds, *eom.inputs) if by is None else by
    columns = partial_columns((*made.places, *made.residual), symbols)
    return routine(eom, "slopes", [x for column in columns for x in column], made.unknowns)


def independent_rows(eom: Equations, a: Array) -> tuple[int, ...]:
    """Constraints that are independent of each other at the numbers `a`; the others follow from them.

    Raises
    ------
    SingularError
        if they hold fewer speeds here than elsewhere
    """
    if eom.embedding is None:
        return ()
    rows = eom.embedding.partition.rows
    if singular(balanced(a[list(rows)])).regular(SURE_RANK):
        return rows
    found = choose(a)
    if len(found.rows) < len(rows):
        names = ", ".join(eom.constraints.constraints[i].name for i in found.redundant)
        raise SingularError(
            f"Expected constraints of constant rank {len(rows)}, got rank {len(found.rows)} at this state: it is a singular "
            f"configuration, where the motion may branch and has no derivative. {names} follow from the others here only. Take a "
            "state beside it."
        )
    return found.rows


@dataclass(frozen=True, slots=True, eq=False)
class Solver:
    """K with one row and one column for each independent constraint, ready to be solved with."""

    matrix: Array
    keep: npt.NDArray[np.intp]

    def __call__(self, right: Array) -> Array:
        """z of K z = right, multipliers of the constraints that follow from the others zero."""
        z = np.zeros(right.shape)
        z[self.keep] = np.linalg.solve(self.matrix, right[self.keep])
        return z


def solver(eom: Equations, values: Values) -> Solver:
    """K to be solved with.

    Raises
    ------
    SingularError
        if K is singular at this state
    """
    n, m, s = len(eom.speeds), len(eom.b), len(eom.reactions)
    rows = independent_rows(eom, values.constraints(n))
    keep = np.array([*range(n), *(n + i for i in rows), *range(n + m, n + m + s)], dtype=np.intp)
    matrix = values.matrix[np.ix_(keep, keep)]
    if not np.all(np.isfinite(matrix)) or not np.all(np.isfinite(values.right)):
        raise SingularError(
            "Expected equations of motion that are finite at this state, got infinity or NaN: coordinates, speeds or parameters are "
            "singular here."
        )
    if matrix.size and not singular(balanced(matrix)).regular(SOLVE_RANK):
        raise SingularError(
            "Expected equations of motion that determine u' and the reactions, got a singular matrix at this state: a speed moves "
            "no mass here, or reactions cannot be told apart."
        )
    return Solver(matrix, keep)
