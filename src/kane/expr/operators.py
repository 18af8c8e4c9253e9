# SPDX-License-Identifier: BSD-3-Clause
"""Operators and functions of expressions: `a + b`, `2 * a`, `a.sin()`, `np.sin(a)`, `a.dt`, attached to Expr once."""

from collections.abc import Callable
from fractions import Fraction
from numbers import Integral
from typing import Any

import numpy as np

from kane.errors import ExpressionError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, power, sub
from kane.expr.node import BUILDERS, Expr, as_expr, constant
from kane.expr.ops import OPS
from kane.expr.symbols import Coordinate, Input, Speed, StateVariable, rate


def _accepting_numbers(name: str) -> Callable[..., Expr]:
    build, arity = NODE_BUILDERS[name], OPS[name].arity

    def public(*args: Any) -> Expr:
        if len(args) != arity:
            raise ExpressionError(f"{name} takes {arity} argument(s), got {len(args)}.")
        return build(*[as_expr(a) for a in args])

    public.__name__ = public.__qualname__ = name
    public.__doc__ = f"`{name}` of expressions or numbers."
    return public


for _name in NODE_BUILDERS:
    BUILDERS[_name] = _accepting_numbers(_name)


def _operator(build: Callable[[Expr, Expr], Expr], swapped: bool = False) -> Callable[[Expr, Any], Any]:
    if swapped:

        def reflected(self: Expr, other: Any) -> Any:
            return build(as_expr(other), self) if isinstance(other, _SCALARS) else NotImplemented

        return reflected

    def forward(self: Expr, other: Any) -> Any:
        if isinstance(other, Expr):
            return build(self, other)
        return build(self, as_expr(other)) if isinstance(other, _SCALARS) else NotImplemented

    return forward


_SCALARS = (Expr, int, float, Fraction, np.number)


for _dunder, _build in (("add", add), ("sub", sub), ("mul", mul), ("truediv", div), ("pow", power)):
    setattr(Expr, f"__{_dunder}__", _operator(_build))
    setattr(Expr, f"__r{_dunder}__", _operator(_build, swapped=True))
setattr(Expr, "__neg__", neg)  # noqa: B010
setattr(Expr, "__pos__", lambda self: self)  # noqa: B010
setattr(Expr, "__abs__", BUILDERS["abs"])  # noqa: B010
for _name in NODE_BUILDERS:
    if _name not in ("add", "sub", "mul", "div", "neg", "pow"):
        setattr(Expr, _name, lambda self, *rest, _build=BUILDERS[_name]: _build(self, *rest))
for _alias, _name in (("arcsin", "asin"), ("arccos", "acos"), ("arctan", "atan"), ("arctan2", "atan2")):
    setattr(Expr, _alias, getattr(Expr, _name))


def Rational(numerator: int, denominator: int = 1) -> Expr:
    """The exact constant numerator/denominator."""
    if not all(isinstance(n, Integral | Fraction) for n in (numerator, denominator)):
        raise ExpressionError(
            f"Expected integers, got Rational({cut(repr(numerator))}, {cut(repr(denominator))}). Quotients of expressions are a/b."
        )
    if denominator == 0:
        raise ExpressionError(f"Expected a denominator other than 0, got Rational({numerator}, 0).")
    return constant(Fraction(numerator, denominator))


def _dt(self: Expr) -> Expr:
    from kane.expr.differentiation import time_derivative

    return rate(self) if isinstance(self, Coordinate | Speed | StateVariable | Input) else time_derivative(self)


setattr(Expr, "dt", property(_dt, doc="Total time derivative; of a coordinate, speed or state, its rate leaf."))  # noqa: B010


sqrt, sin, cos, tan = (BUILDERS[k] for k in ("sqrt", "sin", "cos", "tan"))
asin, acos, atan, atan2 = (BUILDERS[k] for k in ("asin", "acos", "atan", "atan2"))
sinh, cosh, tanh = (BUILDERS[k] for k in ("sinh", "cosh", "tanh"))
exp, log, sign, where, less = (BUILDERS[k] for k in ("exp", "log", "sign", "where", "less"))
abs, min, max = (BUILDERS[k] for k in ("abs", "min", "max"))
