# SPDX-License-Identifier: BSD-3-Clause
"""`eom.jacobian(…)`: the derivatives of the right-hand side, as expressions and as numbers at a state.

On a switching surface the derivatives are those of both sides if they agree; otherwise there are none.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from kane.dynamics.derivation import Derived
from kane.dynamics.lazy import read
from kane.dynamics.readings.quantities import evaluate_along
from kane.dynamics.slopes import slopes
from kane.dynamics.solved import Solved
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, CornerError, cut
from kane.expr.evaluation import Operations, count_operations
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.ops import GONE, Immutable
from kane.expr.piecewise import SwitchedQuantity, on, switches
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol, rate, time
from kane.numeric.arrays import Array, first_index
from kane.numeric.sampling import symbols_named
from kane.numeric.scale import EQUAL


def at_state(solved: Solved, matrix: Matrix, state: State) -> Array:
    """The values of derivatives of the right-hand side. CornerError if those of two sides of a switch differ."""
    result = np.asarray(evaluate_along(solved, matrix, *state.in_order))
    for switch, here, sides in _standing(solved, matrix, state):
        one, other = (np.asarray(evaluate_along(solved, side, *state.in_order)) for side in sides)
        scale = np.abs(np.nan_to_num(one)).max(axis=(-2, -1), keepdims=True, initial=0)
        with np.errstate(invalid="ignore"):
            apart = (~(np.abs(one - other) <= EQUAL * scale) & ~(np.isnan(one) & np.isnan(other))).any(axis=(-2, -1))
        if (apart & here).any():
            place = f" at {first_index(apart & here)}" if apart.ndim else ""
            raise CornerError(
                f"Expected a state at which the equations are differentiable, got a corner{place}: "
                f"{cut(str(switch.nodes[0]), 80)} switches at {cut(str(switch.quantity))} = 0. Use a nearby state, or the "
                "derivative on one side, kn.linearize(eom, …, side=…)."
            )
    return result


def _standing(
    solved: Solved, matrix: Matrix, state: State
) -> Iterator[tuple[SwitchedQuantity, Any, tuple[Matrix, Matrix]]]:
    """Switches at zero, with the entries where they are and the derivatives on both sides, for both sides of the other switches."""
    every = switches(solved.right_hand_side)
    if not every:
        return
    memo: Sizes = {}
    found = evaluate_along(solved, [x for s in every for x in (s.quantity, size(s.quantity, memo))], *state.in_order)
    zero = [np.abs(c) <= GONE * bound for c, bound in zip(found[::2], found[1::2], strict=True)]
    at = [(s, here) for s, here in zip(every, zero, strict=True) if np.any(here)]
    for k, (switch, here) in enumerate(at):
        for others in (1, -1):
            signs = [[sign if j == k else others for j in range(len(at))] for sign in (1, -1)]
            one, other = (matrix.map(on([s.quantity for s, _ in at], own)) for own in signs)
            yield switch, here, (one, other)


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian(Immutable):
    """Exact derivatives of ẋ = (q̇, u̇, ȧ), as functions of the state, time, inputs and parameters, from `eom.jacobian`.

    `matrix` holds the expressions, `rows` the rates q̇, u̇ and ȧ, `columns` the symbols that they are differentiated with respect
    to. Under constraints, u̇ of all speeds are functions of the whole state, dependent coordinates and speeds included: for
    perturbations δx that satisfy the linearized constraints, J δx is the perturbation of ẋ.
    """

    rows: tuple[Symbol, ...]
    columns: tuple[Symbol, ...]
    matrix: Matrix
    solved: Solved

    @by_keyword
    def at(self, state: State | None = None, **values: Unpack[StateValues]) -> npt.NDArray[np.float64]:
        """Numerical values (…, rows, columns) at a state, given as for `Equations.evaluate`; the axes of arrays come first.

        Raises
        ------
        SingularError
            if the right-hand side is not defined at the state
        CornerError
            if a switch (|x|, max, where, …) is at its corner there, with different derivatives on its two sides
        """
        return at_state(self.solved, self.matrix, state_of(state, **values))

    @read
    def pattern(self) -> npt.NDArray[np.bool_]:
        """The sparsity pattern (rows × columns): True for entries that are not identically zero."""
        result = np.array([x is not ZERO for x in self.matrix.entries], dtype=bool).reshape(self.matrix.shape)
        result.flags.writeable = False
        return result

    @property
    def entries(self) -> Mapping[tuple[Symbol, Symbol], Expr]:
        """The entries that are not identically zero, by the symbols of row and column."""
        places = np.argwhere(self.pattern).tolist()
        return {(self.rows[i], self.columns[j]): self.matrix[i, j] for i, j in places}

    operations = read[Operations](
        lambda j: count_operations(j.matrix.entries), "Operations of one evaluation of all entries together."
    )

    def __reduce__(self) -> "tuple[Callable[..., Jacobian], tuple[Any, ...]]":
        return jacobian, (self.solved, self.columns)

    def __iter__(self) -> Iterator[tuple[Expr, ...]]:
        return iter(self.matrix)

    def __getitem__(self, place: tuple[int, int]) -> Expr:
        return self.matrix[place]

    def __repr__(self) -> str:
        n, m = self.matrix.shape
        return f"Jacobian({n} × {m}, {int(self.pattern.sum())} entries not zero, {self.operations.total} operations)"


Kinds = Mapping[str, Callable[[Derived], Sequence[Symbol]]]
KINDS: Kinds = {
    "state": lambda d: d.state,
    "inputs": lambda d: d.system.inputs,
    "parameters": lambda d: d.system.parameters,
    "time": lambda d: (time,),
}
"""What there is to differentiate by."""


def jacobian(solved: Solved, by: Any) -> Jacobian:
    """See Equations.jacobian."""
    derived = solved.derived
    columns = _columns(derived, by)
    return Jacobian(rate_symbols(derived), columns, slopes(solved, columns), solved)


def rate_symbols(derived: Derived) -> tuple[Symbol, ...]:
    """q̇, u̇ and ȧ."""
    return tuple(map(rate, derived.state))


def _columns(derived: Derived, by: Any) -> tuple[Symbol, ...]:
    if isinstance(by, str) and by in KINDS:
        return tuple(KINDS[by](derived))
    if isinstance(by, str | Symbol):
        by = [by]
    if not isinstance(by, list | tuple):
        kinds = ", ".join(map(repr, KINDS))
        raise ArgumentError(f"Expected by= one of {kinds}, or a list of symbols and names, got {cut(repr(by))}.")
    every = [s for symbols in KINDS.values() for s in symbols(derived)]
    return tuple(symbols_named("columns", every, by))
