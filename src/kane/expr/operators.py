# SPDX-License-Identifier: BSD-3-Clause
"""Operators and functions of expressions: `a + b`, `2 * a`, `a.sin()`, `np.sin(a)`, `a.dt`, attached to Expr once."""

from fractions import Fraction
from numbers import Integral

from kane.errors import ExpressionError, cut
from kane.expr.build import NODE_BUILDERS, accepting_numbers, add, div, mul, neg, operator, power, sub
from kane.expr.node import BUILDERS, Expr, constant
from kane.expr.symbols import Coordinate, Input, Speed, StateVariable, rate

for _name in NODE_BUILDERS:
    BUILDERS[_name] = accepting_numbers(_name)

for _dunder, _build in (("add", add), ("sub", sub), ("mul", mul), ("truediv", div), ("pow", power)):
    setattr(Expr, f"__{_dunder}__", operator(_build))
    setattr(Expr, f"__r{_dunder}__", operator(_build, swapped=True))
setattr(Expr, "__neg__", neg)  # noqa: B010
setattr(Expr, "__pos__", lambda self: self)  # noqa: B010
setattr(Expr, "__abs__", BUILDERS["abs"])  # noqa: B010
for _name in NODE_BUILDERS:
    if _name not in ("add", "sub", "mul", "div", "neg", "pow"):
        setattr(Expr, _name, BUILDERS[_name])
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

    return time_derivative(self)


setattr(Expr, "dt", property(_dt, doc="Total time derivative."))  # noqa: B010
for _kind in (Coordinate, Speed, StateVariable, Input):
    setattr(_kind, "dt", property(rate, doc="The symbol for its time derivative."))  # noqa: B010


sqrt, sin, cos, tan = map(BUILDERS.__getitem__, ("sqrt", "sin", "cos", "tan"))
asin, acos, atan, atan2 = map(BUILDERS.__getitem__, ("asin", "acos", "atan", "atan2"))
sinh, cosh, tanh = map(BUILDERS.__getitem__, ("sinh", "cosh", "tanh"))
exp, log, sign, where, less = map(BUILDERS.__getitem__, ("exp", "log", "sign", "where", "less"))
abs, min, max = map(BUILDERS.__getitem__, ("abs", "min", "max"))
