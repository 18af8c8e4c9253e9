# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that are expressions of time, parameters and state: data, which machine code evaluates and differentiates itself.

Their routines take numbers at run time, so that laws which differ in numbers alone share what is compiled.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.errors import SimulationError, cut
from kane.expr.build import NODE_BUILDERS, add, neg
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, constant, postorder
from kane.expr.ops import CONST, OPS
from kane.expr.piecewise import Piecewise, switches
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.expr.visit import fold, substituted
from kane.motion.inputs.breakpoints import breakpoints
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle
from kane.program.program import Port

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

    def along(self, t: Array, states: Array) -> Array:
        """The values at times (n) and states (n × (q, u, a))."""
        at = dict(zip(self.state, states.T[: len(self.state)], strict=True))
        return np.broadcast_to(evaluate([self.expr], {**self.values, **at, time: t})[0], t.shape)

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


_ADD, _SUB, _MUL, _DIV, _NEG = (OPS[name] for name in ("add", "sub", "mul", "div", "neg"))
_KEPT = {OPS["pow"]: 1, OPS["regular"]: 1}
"""Operations of which one argument says what they are, where it is a number: an exponent."""

Signed = tuple[Expr, int]


class Number(Parameter):
    """The value of a number of a law; `place` counts them."""

    __slots__ = ()
    place: int


def _number(place: int) -> Number:
    return Number.declare(f"number{place}", place=place)


class SharedLaw(NamedTuple):
    """Inputs as expressions with a `Number` in the place of each number, and the values of these."""

    values: tuple[Expr, ...]
    numbers: tuple[float, ...]

    def parameters(self, p: Array) -> Array:
        """What its routines take as p: the parameters of the equations, then the numbers."""
        return np.append(p, self.numbers)


def law(values: Sequence[Expr]) -> SharedLaw:
    """Expressions without their numbers: the same ones whatever these are, and their signs; those of the first ones come first.

    Signs go into numbers, and numbers are counted in an order of the terms that does not depend on them, as the order of the arguments
    of sums and products does.
    """
    shapes: dict[Expr, tuple[int, bool]] = {}
    made: dict[Signed, Expr] = {}
    numbers: list[float] = []

    def argument(node: Expr, sign: int, kept: bool) -> Expr:
        if node.op is not CONST or kept:
            return made.get((node, sign), node)
        numbers.append(sign * float(node))
        return _number(len(numbers))

    def combined(node: Expr, sign: int) -> Expr:
        signs, left = _signs(node, sign, shapes)
        args = [argument(a, s, _KEPT.get(node.op) == k) for k, (a, s) in enumerate(zip(node.args, signs, strict=True))]
        if node.op is _NEG:
            return args[0]
        whole = add(*args) if node.op in (_ADD, _SUB) else NODE_BUILDERS[node.op.name](*args) if args else node
        return neg(whole) if left < 0 else whole

    found: list[Expr] = []
    for value in values:
        fold(value, shapes, lambda node: _shape(node, shapes))
        stack = [(value, 1)]
        while stack:
            node, sign = stack[-1]
            signs, _ = _signs(node, sign, shapes)
            waiting = [x for x in zip(node.args, signs, strict=True) if x[0].op is not CONST and x not in made]
            if waiting:
                stack += sorted(waiting, key=lambda x: shapes[x[0]][0], reverse=True)
            elif stack.pop() not in made and node.op is not CONST:
                made[node, sign] = combined(node, sign)
        found.append(argument(value, 1, False))
    return SharedLaw(tuple(found), tuple(numbers))


def _shape(node: Expr, shapes: dict[Expr, tuple[int, bool]]) -> tuple[int, bool]:
    """What a node is but for numbers and signs, as an integer, and whether some number of it can take over a sign."""
    args, op = [shapes[a] for a in node.args], node.op
    if op is CONST:
        return 0, True
    if not args:
        return node.key, False
    if op is _NEG:
        return args[0]
    codes = [code for code, _ in args]
    taking = [takes for _, takes in args]
    takes = {_ADD: all, _SUB: all, _MUL: any, _DIV: any}.get(op)
    code = _ADD.code if op is _SUB else op.code
    return hash((code, *(sorted(codes) if op.commutative or op is _SUB else codes))), takes is not None and takes(
        taking
    )


def _signs(node: Expr, sign: int, shapes: dict[Expr, tuple[int, bool]]) -> tuple[list[int], int]:
    """The signs that the arguments of a node take over from `sign`, and what is left of it for the whole."""
    op = node.op
    if op is _NEG:
        return [-sign], 1
    if op in (_ADD, _SUB):
        return [sign, -sign if op is _SUB else sign], 1
    signs = [1] * len(node.args)
    if sign < 0 and op in (_MUL, _DIV):
        taking = [k for k, a in enumerate(node.args) if shapes[a][1]]
        if taking:
            signs[min(taking, key=lambda k: shapes[node.args[k]][0])] = -1
            return signs, 1
    return signs, sign


def driving(eom: Equations, *values: Expr) -> Bundle[tuple[Array, ...]]:
    """The inputs as functions of time, the state, and parameters."""
    return Bundle("driving", law_ports(eom, values), _parts, {"inputs": list(values)}, [s.name for s in eom.inputs])


def law_ports(eom: Equations, values: Sequence[Expr]) -> tuple[Port, ...]:
    """t, x, p and r of routines that hold a law, with its numbers behind the parameters."""
    t, x, p, r = ports(eom.derived)
    last = max((s.place for s in free_symbols(values) if isinstance(s, Number)), default=0)
    numbers = [_number(place) for place in range(1, last + 1)]
    return t, x, replace(p, symbols=(*p.symbols, *numbers)), r


def _parts(*parts: Array) -> tuple[Array, ...]:
    return parts
