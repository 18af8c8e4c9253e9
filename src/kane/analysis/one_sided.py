# SPDX-License-Identifier: BSD-3-Clause
"""The bundles of equations with every switch that stands at zero replaced by what it is on one side."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from kane.analysis.local import Slopes, Values, slopes, values
from kane.analysis.outputs import Answers, Outputs, answers
from kane.analysis.state import State
from kane.analysis.turning import Turning, turning
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.expr.node import Expr
from kane.expr.switching import on_sides
from kane.expr.symbols import Parameter, Symbol
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle, Shaped

R = TypeVar("R")
Signs = tuple[float, ...]


class Table:
    """The bundles of equations with the sides of some switches as symbols, on the reference evaluator."""

    def __init__(self, numeric: Numeric[Equations], quantities: Sequence[Expr]) -> None:
        self.numeric = numeric
        self.sides: dict[Expr, Symbol] = {
            c: Parameter.declare(f"side{k}", description="of a switch") for k, c in enumerate(quantities)
        }
        self._memo: dict[Expr, Expr] = {}
        self._runs: dict[Any, Callable[[Sequence[Any]], Any]] = {}

    def __call__(self, make: Callable[..., Bundle[R]], signs: Signs, given: Sequence[Any], *arguments: Any) -> R:
        """The record of the bundle make(equations, *arguments) at numbers for its ports, on one side."""
        key = (make, *arguments)
        if key not in self._runs:
            bundle = self.numeric.value(make, *arguments)
            groups = {name: Shaped(g.shape, tuple(map(self._on_sides, g.roots))) for name, g in bundle.groups.items()}
            leaves = [s for port in bundle.ports for s in port.symbols]
            own = Bundle(bundle.name, bundle.ports, bundle.record, groups)
            self._runs[key] = own.reference([*leaves, *self.sides.values()])
        found: R = self._runs[key]([*np.concatenate([np.atleast_1d(v) for v in given]), *signs])
        return found

    def _on_sides(self, root: Expr) -> Expr:
        return on_sides(root, self.sides, self._memo)


@dataclass(frozen=True, slots=True, eq=False)
class OneSided:
    """`Numbers` on one side of the switches of a table."""

    table: Table
    signs: Signs

    def values(self, state: State) -> Values:
        """See `Numbers`."""
        return self.table(values, self.signs, (state.t, state.x, state.p, state.r))

    def slopes(self, state: State, z: Array) -> Slopes:
        """See `Numbers`."""
        return self.table(slopes, self.signs, (state.t, state.x, state.p, state.r, z))

    def answers(self, state: State, z: Array, outputs: Outputs) -> Answers:
        """See `Numbers`."""
        return self.table(answers, self.signs, (state.t, state.x, state.p, state.r, z), *outputs.roots)

    def turning(self, state: State, z: Array, outputs: Outputs) -> Turning:
        """The quantities of all switches."""
        return self.table(turning, self.signs, (state.t, state.x, state.p, state.r, z), *outputs.roots)
