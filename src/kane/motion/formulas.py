# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that are given as expressions of time and parameters: data, which machine code evaluates and differentiates itself."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kane.equations.equations import Equations
from kane.equations.routines import ports
from kane.errors import SimulationError, cut
from kane.expr.diff import tangent
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, postorder
from kane.expr.ops import OPS
from kane.expr.piecewise import Piecewise
from kane.expr.symbols import Time, time
from kane.motion.breakpoints import breakpoints
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle

CORNERS = frozenset(OPS[name] for name in ("abs", "sign", "min", "max", "less", "where"))
"""Operations that have corners or jumps."""


@dataclass(frozen=True, slots=True, eq=False)
class Formula:
    """An expression of time and of parameters, which have `values`: called with a time it gives its value."""

    expr: Expr
    values: Mapping[Expr, Any]

    def __call__(self, t: Any) -> float:
        """The value at time t."""
        return float(evaluate([self.expr], {**self.values, time: t})[0])

    def derivative(self, order: int = 1) -> "Formula":
        """The nth derivative by time."""
        expr = self.expr
        for _ in range(order):
            expr = tangent(expr, lambda leaf: ONE if isinstance(leaf, Time) else ZERO)
        return Formula(expr, self.values)

    def breakpoints(self, span: tuple[float, float]) -> tuple[float, ...]:
        """The times within the span at which it jumps or bends."""
        return breakpoints([self.expr], self.values, span)

    @property
    def smooth(self) -> bool:
        """Whether it has no corners."""
        return not any(node.op in CORNERS or isinstance(node.op, Piecewise) for node in postorder([self.expr]))


def formula(name: str, expr: Expr, parameters: Mapping[Expr, Any]) -> Formula:
    """The value of the input `name`.

    Raises
    ------
    SimulationError
        if it holds something else than time and parameters of the model
    """
    symbols = [s for s in free_symbols([expr]) if not isinstance(s, Time)]
    wrong = [f"{s} ({type(s).__name__})" for s in symbols if s not in parameters]
    if wrong:
        raise SimulationError(
            f"Expected the input {name} as a number, a function of time or an expression of time and of parameters of the model, got "
            f"the expression {cut(expr)} with {', '.join(wrong)}. What depends on the state: write it into the model in the place of "
            f"{name}."
        )
    return Formula(expr, {s: parameters[s] for s in symbols})


def driving(eom: Equations, *values: Expr) -> Bundle[tuple[Array, ...]]:
    """The inputs as functions of time and parameters."""
    names = [s.name for s in eom.inputs]
    return Bundle("driving", ports(eom.derived), _parts, {"inputs": list(values)}, names)


def _parts(*parts: Array) -> tuple[Array, ...]:
    return parts
