# SPDX-License-Identifier: BSD-3-Clause
"""Builders: every node is made here, after local rewriting that costs O(1).

What is rewritten: constants, 0 and 1, signs (outwards), x − x, like terms, x·y/y, sin² + cos², multiples of π/2 and the
parity of functions. Nothing is ever expanded, and nothing global is done.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from kane.errors import ExpressionError
from kane.expr.node import (
    BUILDERS,
    ONE,
    TWO,
    ZERO,
    Expr,
    Number,
    as_expr,
    constant,
    constant_value,
    intern_node,
    pi,
    precedes,
)
from kane.expr.ops import ADD, CONST, COS, DIV, LESS, MUL, NEG, OPS, POW, SIN, SQRT, SUB, WHERE, Op
from kane.expr.symbols import rate

_MINUS_ONE = constant(-1)
_MAX_EXPANDED_POWER = 16


def add(a: Expr, b: Expr) -> Expr:
    """a + b."""
    ao, bo = a.op, b.op
    if ao is CONST or bo is CONST:
        if a is ZERO:
            return b
        if b is ZERO:
            return a
        if ao is bo:
            return constant(_value(a) + _value(b))
    if bo is NEG:
        return sub(a, b.args[0])
    if ao is NEG:
        return sub(b, a.args[0])
    if a is b:
        return mul(TWO, a)
    if ao is SUB and a.args[1] is b:
        return a.args[0]
    if bo is SUB and b.args[1] is a:
        return b.args[0]
    if ao is MUL or bo is MUL:
        joined = _like_terms(a, b, 1)
        if joined is None and ao is bo:
            joined = _sin2_cos2(a, b)
        if joined is not None:
            return joined
    return intern_node(ADD, a, b) if precedes(a, b) else intern_node(ADD, b, a)


def sub(a: Expr, b: Expr) -> Expr:
    """a − b; of a − b and b − a only one exists, the other is its negative."""
    ao, bo = a.op, b.op
    if a is b:
        return ZERO
    if ao is CONST or bo is CONST:
        if b is ZERO:
            return a
        if a is ZERO:
            return neg(b)
        if ao is bo:
            return constant(_value(a) - _value(b))
    if bo is NEG:
        return add(a, b.args[0])
    if ao is NEG:
        return neg(add(a.args[0], b))
    if ao is ADD:
        if a.args[1] is b:
            return a.args[0]
        if a.args[0] is b:
            return a.args[1]
    if ao is SUB and a.args[0] is b:
        return neg(a.args[1])
    if bo is ADD:
        if b.args[1] is a:
            return neg(b.args[0])
        if b.args[0] is a:
            return neg(b.args[1])
    if bo is SUB and b.args[0] is a:
        return b.args[1]
    if ao is MUL or bo is MUL:
        joined = _like_terms(a, b, -1)
        if joined is not None:
            return joined
        if ao is bo and _same_product(a, b):
            return ZERO
    return intern_node(SUB, a, b) if precedes(a, b) else neg(intern_node(SUB, b, a))


def neg(a: Expr) -> Expr:
    """−a."""
    if a.op is CONST:
        return constant(-_value(a))
    return a.args[0] if a.op is NEG else intern_node(NEG, a)


def mul(a: Expr, b: Expr) -> Expr:
    """a b."""
    ao, bo = a.op, b.op
    if ao is CONST or bo is CONST:
        if a is ONE:
            return b
        if b is ONE:
            return a
        if a is ZERO or b is ZERO:
            return ZERO
        if ao is bo:
            return constant(_value(a) * _value(b))
        return _scaled(a, b) if ao is CONST else _scaled(b, a)
    if ao is NEG:
        return mul(a.args[0], b.args[0]) if bo is NEG else neg(mul(a.args[0], b))
    if bo is NEG:
        return neg(mul(a, b.args[0]))
    if ao is DIV:
        if a.args[1] is b:
            return a.args[0]
        if a.args[0] is ONE:
            return div(b, a.args[1])
    if bo is DIV:
        if b.args[1] is a:
            return b.args[0]
        if b.args[0] is ONE:
            return div(a, b.args[1])
    if a is b and ao is SQRT:
        return a.args[0]
    return intern_node(MUL, a, b) if precedes(a, b) else intern_node(MUL, b, a)


def _scaled(c: Expr, x: Expr) -> Expr:
    """c x for a constant c that is neither 0 nor 1: positive constants stay, the sign goes outwards."""
    value = _value(c)
    if value < 0:
        return neg(mul(constant(-value), x))
    if x.op is NEG:
        return neg(mul(c, x.args[0]))
    if x.op is MUL and x.args[0].op is CONST:
        return mul(constant(value * _value(x.args[0])), x.args[1])
    return intern_node(MUL, c, x)


def div(a: Expr, b: Expr) -> Expr:
    """a / b."""
    if b.op is CONST:
        value = _value(b)
        if value == 0:
            raise ExpressionError(f"Division of {a!s:.80} by the constant 0.")
        if isinstance(value, (int, Fraction)):
            return mul(constant(Fraction(1) / value), a)
        if a.op is CONST:
            return constant(_value(a) / value)
        if value < 0:
            return neg(div(a, constant(-value)))
    if a is ZERO:
        return ZERO
    if a is b:
        return ONE
    if a.op is NEG:
        return neg(div(a.args[0], b))
    if b.op is NEG:
        return neg(div(a, b.args[0]))
    if a.op is CONST and _value(a) < 0:
        return neg(div(constant(-_value(a)), b))
    if a.op is MUL:
        if a.args[1] is b:
            return a.args[0]
        if a.args[0] is b:
            return a.args[1]
    if b.op is DIV:
        return div(mul(a, b.args[1]), b.args[0])
    if b.op is MUL:
        if b.args[0] is a:
            return div(ONE, b.args[1])
        if b.args[1] is a:
            return div(ONE, b.args[0])
    return intern_node(DIV, a, b)


def power(a: Expr, p: Expr) -> Expr:
    """a**p; small integer powers become products."""
    exponent = constant_value(p)
    if exponent is None:
        return intern_node(POW, a, p)
    if isinstance(exponent, int) and abs(exponent) <= _MAX_EXPANDED_POWER:
        if exponent < 0:
            return div(ONE, power(a, constant(-exponent)))
        result, square = ONE, a
        while exponent:
            if exponent & 1:
                result = mul(result, square)
            exponent >>= 1
            if exponent:
                square = mul(square, square)
        return result
    if exponent == Fraction(1, 2):
        return sqrt(a)
    if exponent == Fraction(-1, 2):
        return div(ONE, sqrt(a))
    base = constant_value(a)
    if base == 0 and exponent > 0:
        return ZERO
    if base is not None and base > 0:
        with np.errstate(all="ignore"):
            return constant(np.power(float(base), float(exponent)))
    return intern_node(POW, a, p)


def sqrt(a: Expr) -> Expr:
    """Square root; exact for squares of rationals."""
    value = constant_value(a)
    if value is None:
        return intern_node(SQRT, a)
    if value < 0:
        raise ExpressionError(f"Square root of the negative constant {value}.")
    ratio = Fraction(value)
    top, bottom = math.isqrt(ratio.numerator), math.isqrt(ratio.denominator)
    exact = top * top == ratio.numerator and bottom * bottom == ratio.denominator
    return constant(Fraction(top, bottom)) if exact else constant(math.sqrt(value))


def sin(a: Expr) -> Expr:
    """Sine; angle offsets by multiples of π/2 and signs are taken out."""
    turns, rest = _quarter_turns(a)
    return _signed((_sine, _cosine)[turns & 1](rest), turns in (2, 3))


def cos(a: Expr) -> Expr:
    """Cosine; angle offsets by multiples of π/2 and signs are taken out."""
    turns, rest = _quarter_turns(a)
    return _signed((_cosine, _sine)[turns & 1](rest), turns in (1, 2))


def _sine(a: Expr) -> Expr:
    if a.op is NEG:
        return neg(_sine(a.args[0]))
    value = constant_value(a)
    if value is None:
        return intern_node(SIN, a)
    return constant(math.sin(value))


def _cosine(a: Expr) -> Expr:
    if a.op is NEG:
        a = a.args[0]
    value = constant_value(a)
    if value is None:
        return intern_node(COS, a)
    return constant(math.cos(value))


def _signed(a: Expr, negative: bool) -> Expr:
    return neg(a) if negative else a


def _quarter_turns(a: Expr) -> tuple[int, Expr]:
    """a = turns·π/2 + rest with turns in 0…3; turns is 0 where no multiple of π/2 is at hand."""
    turns = _pi_halves(a)
    if turns is not None:
        return turns % 4, ZERO
    if a.op is NEG:
        turns, rest = _quarter_turns(a.args[0])
        return -turns % 4, neg(rest)
    if a.op is ADD or a.op is SUB:
        sign = 1 if a.op is ADD else -1
        x, y = a.args
        turns = _pi_halves(x)
        if turns is not None:
            return turns % 4, _signed(y, sign < 0)
        turns = _pi_halves(y)
        if turns is not None:
            return sign * turns % 4, x
    return 0, a


def _pi_halves(a: Expr) -> int | None:
    """k if a is k π/2 with integer k ≠ 0, else None."""
    ratio: Number | None = None
    if a is pi:
        ratio = 1
    elif a.op is NEG:
        k = _pi_halves(a.args[0])
        return None if k is None else -k
    elif a.op is MUL and a.args[1] is pi:
        ratio = constant_value(a.args[0])
    elif a.op is CONST:
        value = _value(a)
        k = round(value / (math.pi / 2))
        return k if k and isinstance(value, float) and value == k * (math.pi / 2) else None
    if ratio is None or not isinstance(ratio, (int, Fraction)) or (2 * ratio) % 1 != 0:
        return None
    return int(2 * ratio)


def _value(a: Expr) -> Number:
    return a.value  # type: ignore[attr-defined, no-any-return]


def _split(a: Expr) -> tuple[Number, Expr]:
    """a = coefficient · rest."""
    if a.op is MUL and a.args[0].op is CONST:
        return _value(a.args[0]), a.args[1]
    return 1, a


def _like_terms(a: Expr, b: Expr, sign: int) -> Expr | None:
    """c x ± d x; c x y ± d x y however the three factors are grouped."""
    ca, ra = _split(a)
    cb, rb = _split(b)
    if ra is rb:
        return mul(constant(ca + sign * cb), ra)
    if a.op is MUL is b.op:
        for c, x, y in _scaled_pairs(a):
            for d, v, w in _scaled_pairs(b):
                if (x is v and y is w) or (x is w and y is v):
                    return mul(constant(c + sign * d), mul(x, y))
    return None


def _scaled_pairs(a: Expr) -> list[tuple[Number, Expr, Expr]]:
    """Ways to write the product a as c x y with a number c ≠ 1; and a itself as 1 x y."""
    x, y = a.args
    if x.op is CONST:
        return [(_value(x), y.args[0], y.args[1])] if y.op is MUL else []
    found: list[tuple[Number, Expr, Expr]] = [(1, x, y)]
    if y.op is MUL and y.args[0].op is CONST:
        found.append((_value(y.args[0]), x, y.args[1]))
    if x.op is MUL and x.args[0].op is CONST:
        found.append((_value(x.args[0]), y, x.args[1]))
    return found


def _same_product(a: Expr, b: Expr) -> bool:
    """Whether x·(y·z) and y·(x·z) are at hand: the same three factors, grouped otherwise."""
    p, q = a.args
    r, s = b.args
    for x, y in ((p, q), (q, p)):
        if y.op is not MUL:
            continue
        for t, v in (y.args, y.args[::-1]):
            other = s if t is r else r if t is s else None
            if other is not None and other.op is MUL:
                f, g = other.args
                if (f is x and g is v) or (g is x and f is v):
                    return True
    return False


def _sin2_cos2(a: Expr, b: Expr) -> Expr | None:
    """k sin² x + k cos² x = k, however the factors are grouped."""
    for s, k in _squares(a):
        for c, h in _squares(b):
            if k is h and s.args[0] is c.args[0] and s.op is not c.op:
                return k
    return None


def _squares(a: Expr) -> list[tuple[Expr, Expr]]:
    """Ways to write the product a as t² k with t a sine or cosine."""
    x, y = a.args
    if x is y:
        return [(x, ONE)] if x.op in _CIRCULAR else []
    found = []
    for t, rest in ((x, y), (y, x)):
        if rest.op is MUL:
            p, q = rest.args
            if t.op in _CIRCULAR and (p is t or q is t):
                found.append((t, q if p is t else p))
            if p is q and p.op in _CIRCULAR:
                found.append((p, t))
    return found


_CIRCULAR = (SIN, COS)
_ODD = {OPS[name] for name in ("tan", "asin", "atan", "sinh", "tanh", "sign")}
_EVEN = {OPS[name] for name in ("cosh", "abs")}


def _function(op: Op) -> Callable[[Expr], Expr]:
    def build(a: Expr) -> Expr:
        value = constant_value(a)
        if value is not None:
            assert op.numpy is not None
            if op.name == "log" and value <= 0:
                raise ExpressionError(f"Logarithm of the constant {value}, which is not positive.")
            if op.name in ("asin", "acos") and not -1 <= value <= 1:
                raise ExpressionError(f"{op.name} of the constant {value}, which is not within −1…1.")
            with np.errstate(all="ignore"):  # what overflows is refused by `constant`
                return constant(float(op.numpy(float(value))))
        if a.op is NEG and op in _ODD:
            return neg(intern_node(op, a.args[0]))
        if a.op is NEG and op in _EVEN:
            return intern_node(op, a.args[0])
        return intern_node(op, a)

    return build


def _binary(op: Op) -> Callable[[Expr, Expr], Expr]:
    def build(a: Expr, b: Expr) -> Expr:
        x, y = constant_value(a), constant_value(b)
        if op is not LESS and x is not None and y is not None:
            assert op.numpy is not None
            with np.errstate(all="ignore"):
                return constant(float(op.numpy(float(x), float(y))))
        if op.commutative:
            if a is b:
                return a
            if precedes(b, a):
                a, b = b, a
        return intern_node(op, a, b)

    return build


def where(condition: Expr, x: Expr, y: Expr) -> Expr:
    """x where the condition holds, else y; the condition comes from `less`."""
    if condition.op is not LESS:
        raise ExpressionError(f"Expected a condition kn.less(a, b) in where(...), got {condition!s:.80}.")
    a, b = (constant_value(c) for c in condition.args)
    if a is not None and b is not None:
        return x if a < b else y
    return x if x is y else intern_node(WHERE, condition, x, y)


_DIRECT: dict[str, Callable[..., Expr]] = {
    "add": add,
    "sub": sub,
    "mul": mul,
    "div": div,
    "neg": neg,
    "pow": power,
    "sqrt": sqrt,
    "sin": sin,
    "cos": cos,
    "where": where,
}
NODE_BUILDERS: dict[str, Callable[..., Expr]] = {
    name: _DIRECT.get(name) or (_function(op) if op.arity == 1 else _binary(op)) for name, op in OPS.items() if op.arity
}
"""Builders that take expressions only; the public ones below also take numbers."""


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


def _rational(numerator: int, denominator: int = 1) -> Expr:
    """The exact constant numerator/denominator."""
    return constant(Fraction(numerator, denominator))


rational = _rational


def _dt(self: Expr) -> Expr:
    from kane.expr.diff import time_derivative
    from kane.expr.symbols import Coordinate, Input, Speed

    return rate(self) if isinstance(self, Coordinate | Speed | Input) else time_derivative(self)


setattr(Expr, "dt", property(_dt, doc="Total time derivative; of a coordinate or speed, its rate leaf."))  # noqa: B010
