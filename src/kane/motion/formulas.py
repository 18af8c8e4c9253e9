# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that are given as expressions of time, parameters and state: data, which machine code evaluates and differentiates itself."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from kane.equations.equations import Equations
from kane.errors import SimulationError, cut
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, constant, postorder
from kane.expr.ops import OPS
from kane.expr.piecewise import Piecewise
from kane.expr.switching import switches
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.expr.visit import substituted
from kane.motion.time_breaks import breakpoints

CORNERS = frozenset(OPS[name] for name in ("abs", "sign", "min", "max", "less", "where"))
"""Operations that have corners or jumps."""


@dataclass(frozen=True, slots=True, eq=False)
class Formula:
    """An expression of time and of parameters, which have `values`: called with a time it gives its value.

    Where it holds symbols of the `state` too, it is called with a time and (q, u).
    """

    expr: Expr
    values: Mapping[Expr, Any]
    state: tuple[Symbol, ...] = ()

    def __call__(self, t: Any, x: Any = ()) -> float:
        """The value at time t, and state x."""
        at = dict(zip(self.state, x, strict=bool(self.state)))
        return float(evaluate([self.expr], {**self.values, **at, time: t})[0])

    @property
    def of_state(self) -> bool:
        """Whether it depends on the state."""
        return bool(self.state)

    def derivative(self, order: int = 1) -> "Formula":
        """The nth derivative by time."""
        expr = self.expr
        for _ in range(order):
            expr = tangent(expr, lambda leaf: ONE if isinstance(leaf, Time) else ZERO)
        return Formula(expr, self.values, self.state)

    def breakpoints(self, span: tuple[float, float]) -> tuple[float, ...]:
        """The times within the span at which it jumps or bends."""
        return breakpoints([self.expr], self.values, span)

    @property
    def smooth(self) -> bool:
        """Whether it has no corners."""
        return not any(node.op in CORNERS or isinstance(node.op, Piecewise) for node in postorder([self.expr]))


def turning_laws(drives: Iterable[Any]) -> tuple[Expr, ...]:
    """The inputs that are expressions of the state with switches in them."""
    laws = (f.expr for f in drives if isinstance(f, Formula) and f.of_state)
    return tuple(e for e in laws if switches([e]))


def formula(name: str, expr: Expr, parameters: Mapping[Expr, Any], state: tuple[Symbol, ...] = ()) -> Formula:
    """The value of the input `name`; symbols of the `state` (q, u) may be in it.

    Raises
    ------
    SimulationError
        if it holds something else than time, the state, and parameters of the model
    """
    own = set(state)
    symbols = [s for s in free_symbols([expr]) if not isinstance(s, Time)]
    wrong = [f"{s} ({type(s).__name__})" for s in symbols if s not in parameters and s not in own]
    if wrong:
        kinds, else_ = ("time, coordinates, speeds", "rates or reactions") if state else ("time", "the state")
        raise SimulationError(
            f"Expected the input {name} as a number, a function of time or an expression of {kinds} and of parameters of the model, "
            f"got the expression {cut(expr)} with {', '.join(wrong)}. What depends on {else_}: write it into the model in the place "
            f"of {name}."
        )
    given: dict[Expr, Any] = {s: parameters[s] for s in symbols if s not in own}
    return Formula(expr, given, state if own.intersection(symbols) else ())


def with_gains(eom: Equations, expr: Expr, parameters: Mapping[Expr, Any]) -> Expr:
    """The expression with numbers for parameters that the model does not hold."""
    own = set(eom.parameters)
    foreign = [s for s in free_symbols([expr]) if isinstance(s, Parameter) and s not in own]
    numbers = {s: parameters.get(s, s.default) for s in foreign}
    return substituted(expr, {s: constant(float(v)) for s, v in numbers.items() if v is not None})


def own_parameters(given: Any) -> dict[Expr, Any]:
    """The values given for parameters by symbol: those that stand in inputs alone are not the model's."""
    return {s: v for s, v in given.items() if isinstance(s, Parameter)} if isinstance(given, Mapping) else {}
