# SPDX-License-Identifier: BSD-3-Clause
"""Constructors of nodes, which apply local rewriting rules in O(1) time.

Rules fold constants, 0 and 1, move signs outwards, and simplify x − x, like terms, x·y/y, sin² + cos², multiples of π/2 and the parity
of functions. Nothing is expanded, and no rule is global. Each pattern reads a fixed number of nodes and creates none.
"""

import math
from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import reduce
from typing import Any

import numpy as np

from kane.errors import ExpressionError, cut
from kane.expr.node import (
    ONE,
    TWO,
    ZERO,
    Expr,
    Number,
    as_expr,
    constant,
    constant_value,
    intern_node,
    intern_pair,
    intern_single,
    number_of,
    opposite,
    pi,
    precedes,
    product,
    quotient,
    total,
    turned,
)
from kane.expr.numbers import Surd, root, sine_of_turns, value_of_numbers
from kane.expr.ops import ADD, CONST, COS, DIV, LESS, MUL, NEG, OPS, POW, SIN, SQRT, SUB, WHERE, Op

_CIRCULAR = (SIN, COS)


def split(a: Expr) -> tuple[Expr, Expr]:
    """The numerical coefficient of a product and the rest: a = coefficient · rest."""
    if a.op is MUL and a.args[0].op is CONST:
        return a.args[0], a.args[1]
    return ONE, a


def one_product(a: Expr, b: Expr, sign: int, both: bool) -> Expr | None:
    """a + sign·b as a product, if a pattern applies: c x ± d x, c x y ± d x y, x (y z) ± y (x z), k sin² x + k cos² x; else None.

    At least one is a product, `both` or not.
    """
    if not both:
        (ca, ra), (cb, rb) = split(a), split(b)
        return mul(total(ca, cb, sign), ra) if ra is rb else None
    (p, q), (r, s) = a.args, b.args
    po, qo, ro, so = p.op, q.op, r.op, s.op
    inner, other = po is MUL or qo is MUL, ro is MUL or so is MUL  # whether a factor is a product
    if po is CONST or ro is CONST or (inner and _has_number(p, q, po, qo)) or (other and _has_number(r, s, ro, so)):
        alike = _like_products(a, b, sign)
        if alike is not None:
            return alike
    if inner and other and same_product(a, b):
        return mul(TWO, a) if sign > 0 else ZERO
    if sign > 0 and (inner or p is q) and (other or r is s):
        return sin2_cos2(a, b)
    return None


def _like_products(a: Expr, b: Expr, sign: int) -> Expr | None:
    """a + sign·b of two products, one with a numerical factor, as one product; None if they are not alike."""
    (ca, ra), (cb, rb) = split(a), split(b)
    if ra is rb:
        return mul(total(ca, cb, sign), ra)
    for c, x, y in _scaled_pairs(a):
        for d, v, w in _scaled_pairs(b):
            if (x is v and y is w) or (x is w and y is v):
                return mul(total(c, d, sign), mul(x, y))
    return None


def _has_number(x: Expr, y: Expr, xo: Op, yo: Op) -> bool:
    """Whether x or y, of the operations xo and yo, is a product with a numerical coefficient."""
    return (xo is MUL and x.args[0].op is CONST) or (yo is MUL and y.args[0].op is CONST)


def _scaled_pairs(a: Expr) -> list[tuple[Expr, Expr, Expr]]:
    """Ways to write the product a as c x y with a number c ≠ 1; and a itself as 1 x y."""
    x, y = a.args
    if x.op is CONST:
        return [(x, y.args[0], y.args[1])] if y.op is MUL else []
    pairs: list[tuple[Expr, Expr, Expr]] = [(ONE, x, y)]
    if y.op is MUL and y.args[0].op is CONST:
        pairs.append((y.args[0], x, y.args[1]))
    if x.op is MUL and x.args[0].op is CONST:
        pairs.append((x.args[0], y, x.args[1]))
    return pairs


def same_product(a: Expr, b: Expr) -> bool:
    """Whether a and b are products of the same three factors in different groupings, as x·(y·z) and y·(x·z)."""
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


def sin2_cos2(a: Expr, b: Expr) -> Expr | None:
    """k if a + b is k sin² x + k cos² x in any grouping of the factors, else None."""
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
    squares = []
    for t, rest in ((x, y), (y, x)):
        if rest.op is MUL:
            p, q = rest.args
            if t.op in _CIRCULAR and (p is t or q is t):
                squares.append((t, q if p is t else p))
            if p is q and p.op in _CIRCULAR:
                squares.append((p, t))
    return squares


def quarter_turns(a: Expr) -> tuple[int, Expr, bool]:
    """(turns, rest, negative) with a = turns·π/2 ± rest, turns in 0…3; turns is 0 if a contains no multiple of π/2."""
    turns = _pi_halves(a)
    if turns is not None:
        return turns % 4, ZERO, False
    if a.op is NEG:
        inner, rest, negative = quarter_turns(a.args[0])
        return -inner % 4, rest, not negative
    if a.op is ADD or a.op is SUB:
        sign = 1 if a.op is ADD else -1
        x, y = a.args
        turns = _pi_halves(x)
        if turns is not None:
            return turns % 4, y, sign < 0
        turns = _pi_halves(y)
        if turns is not None:
            return sign * turns % 4, x, False
    return 0, a, False


def turns_sine(a: Expr, quarters: int) -> Number | None:
    """sin(a + quarters · π/2) if a is a multiple of π whose sine is a fraction or a surd, else None."""
    ratio = constant_value(a.args[0]) if a.op is MUL and a.args[1] is pi else None
    if ratio is None or not isinstance(ratio, int | Fraction):  # the class of fractions takes long to tell
        return None
    result: Number | None = sine_of_turns(ratio + Fraction(quarters, 2))
    return result


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
        value = number_of(a)
        k = round(value / (math.pi / 2))
        return k if k and isinstance(value, float) and value == k * (math.pi / 2) else None
    if ratio is None or not isinstance(ratio, (int, Fraction)) or (2 * ratio) % 1 != 0:
        return None
    return int(2 * ratio)


_MAX_EXPANDED_POWER = 16


def add(a: Expr, b: Expr) -> Expr:
    """a + b."""
    if a is ZERO:
        return b
    if b is ZERO:
        return a
    ao, bo = a.op, b.op
    if ao is CONST and bo is CONST:
        return total(a, b)
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
        whole = one_product(a, b, 1, ao is bo)
        if whole is not None:
            return whole
    x, y = a.key, b.key
    if ao is CONST or (bo is not CONST and (x < y or (x == y and precedes(a, b)))):
        return intern_pair(ADD, a, b, x, y)
    return intern_pair(ADD, b, a, y, x)


def sub(a: Expr, b: Expr) -> Expr:
    """a − b; of a − b and b − a only one exists, the other is its negative."""
    if b is ZERO:
        return a
    if a is ZERO:
        return neg(b)
    if a is b:
        return ZERO
    ao, bo = a.op, b.op
    if ao is CONST and bo is CONST:
        return total(a, b, -1)
    if bo is NEG:
        return add(a, b.args[0])
    if ao is NEG:
        return neg(add(a.args[0], b))
    if ao is ADD or ao is SUB or bo is ADD or bo is SUB:
        rest = _rest_of_sums(a, b)
        if rest is not None:
            return rest
    if ao is MUL or bo is MUL:
        whole = one_product(a, b, -1, ao is bo)
        if whole is not None:
            return whole
    x, y = a.key, b.key
    if ao is CONST or (bo is not CONST and (x < y or (x == y and precedes(a, b)))):
        return intern_pair(SUB, a, b, x, y)
    return neg(intern_pair(SUB, b, a, y, x))


def sum_of(terms: Iterable[Expr]) -> Expr:
    """Σ terms, added in order."""
    return reduce(add, terms, ZERO)


def _rest_of_sums(a: Expr, b: Expr) -> Expr | None:
    """a − b if one of them is a term of the other, else None."""
    if a.op is ADD or a.op is SUB:
        x, y = a.args
        if x is b:
            return y if a.op is ADD else neg(y)
        if y is b and a.op is ADD:
            return x
    if b.op is ADD or b.op is SUB:
        x, y = b.args
        if x is a:
            return neg(y) if b.op is ADD else y
        if y is a and b.op is ADD:
            return neg(x)
    return None


def neg(a: Expr) -> Expr:
    """−a."""
    op = a.op
    if op is NEG:
        return a.args[0]
    if op is CONST:
        return opposite(a)
    return intern_single(NEG, a)


def mul(a: Expr, b: Expr) -> Expr:
    """a b."""
    if a is ZERO or b is ZERO:
        return ZERO
    if a is ONE:
        return b
    if b is ONE:
        return a
    ao, bo = a.op, b.op
    if ao is CONST or bo is CONST:
        if ao is bo:
            return product(a, b)
        return _scaled(a, b) if ao is CONST else _scaled(b, a)
    if ao is NEG:
        return mul(a.args[0], b.args[0]) if bo is NEG else neg(mul(a.args[0], b))
    if bo is NEG:
        return neg(mul(a, b.args[0]))
    if ao is DIV or bo is DIV:
        cancelled = _times_quotient(a, b)
        if cancelled is not None:
            return cancelled
    if a is b and ao is SQRT:
        return a.args[0]
    x, y = a.key, b.key
    if x < y or (x == y and precedes(a, b)):
        return intern_pair(MUL, a, b, x, y)
    return intern_pair(MUL, b, a, y, x)


def _times_quotient(a: Expr, b: Expr) -> Expr | None:
    """a b if a or b is a quotient that simplifies, (x/b) b = x or (1/y) b = b/y, else None."""
    if a.op is DIV:
        if a.args[1] is b:
            return a.args[0]
        if a.args[0] is ONE:
            return div(b, a.args[1])
    if b.op is DIV:
        if b.args[1] is a:
            return b.args[0]
        if b.args[0] is ONE:
            return div(a, b.args[1])
    return None


def _scaled(c: Expr, x: Expr) -> Expr:
    """c x for a constant c that is neither 0 nor 1: positive constants stay, the sign goes outwards."""
    value = number_of(c)
    if (value.numerator if type(value) is Fraction else value) < 0:
        return neg(mul(opposite(c), x))
    if x.op is NEG:
        return neg(mul(c, x.args[0]))
    if x.op is MUL and x.args[0].op is CONST:
        return mul(product(c, x.args[0]), x.args[1])
    return intern_pair(MUL, c, x, c.key, x.key)


def div(a: Expr, b: Expr) -> Expr:
    """a / b."""
    if a is ZERO and b is not ZERO:
        return ZERO
    if b.op is CONST:
        over = _over_number(a, b)
        if over is not None:
            return over
    if a is b:
        return ONE
    if a.op is NEG:
        return neg(div(a.args[0], b))
    if b.op is NEG:
        return neg(div(a, b.args[0]))
    if a.op is CONST and number_of(a) < 0:
        return neg(div(opposite(a), b))
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
    return intern_pair(DIV, a, b, a.key, b.key)


_SHARES = {n: constant(Fraction(1, n)) for n in range(2, 17)}
"""1/2, 1/3, …: to make a fraction takes longer than all else here."""


def _over_number(a: Expr, b: Expr) -> Expr | None:
    """a / b of a constant b as a product, a number or a negative; None if it stays a quotient."""
    value = number_of(b)
    if value == 0:
        raise ExpressionError(f"Division of {cut(a, 80)} by the constant 0.")
    if type(value) is int:
        return a if value == 1 else mul(_SHARES[value] if value in _SHARES else constant(Fraction(1, value)), a)
    if isinstance(value, Fraction):
        return mul(constant(1 / value), a)
    if isinstance(value, Surd):
        return mul(constant(value.reciprocal()), a)
    if a.op is CONST:
        return quotient(a, b)
    return neg(div(a, opposite(b))) if value < 0 else None


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
    """Square root; exact for rationals of ordinary size, as a surd where they are no squares."""
    value = constant_value(a)
    if value is None:
        return intern_node(SQRT, a)
    if value < 0:
        raise ExpressionError(f"Square root of the negative constant {value}.")
    return constant(root(value))


def sin(a: Expr) -> Expr:
    """Sine; angle offsets by multiples of π/2 and signs are taken out."""
    turns, rest, negative = quarter_turns(a)
    return _signed((_sine, _cosine)[turns & 1](_signed(rest, negative)), turns in (2, 3))


def cos(a: Expr) -> Expr:
    """Cosine; angle offsets by multiples of π/2 and signs are taken out."""
    turns, rest, negative = quarter_turns(a)
    return _signed((_cosine, _sine)[turns & 1](_signed(rest, negative)), turns in (1, 2))


def _sine(a: Expr) -> Expr:
    if a.op is NEG:
        return neg(_sine(a.args[0]))
    value = constant_value(a)
    if value is None:
        known = turns_sine(a, 0)
        return intern_node(SIN, a) if known is None else constant(known)
    return turned(a, 0)


def _cosine(a: Expr) -> Expr:
    if a.op is NEG:
        a = a.args[0]
    value = constant_value(a)
    if value is None:
        known = turns_sine(a, 1)
        return intern_node(COS, a) if known is None else constant(known)
    return turned(a, 1)


def _signed(a: Expr, negative: bool) -> Expr:
    return neg(a) if negative else a


_ODD = {OPS[name] for name in ("tan", "asin", "atan", "sinh", "tanh", "sign")}
_EVEN = {OPS[name] for name in ("cosh", "abs")}


def _function(op: Op) -> Callable[[Expr], Expr]:
    def build(a: Expr) -> Expr:
        value = constant_value(a)
        if value is not None:
            if op.name == "log" and value <= 0:
                raise ExpressionError(f"Logarithm of the constant {value}, which is not positive.")
            if op.name in ("asin", "acos") and not -1 <= value <= 1:
                raise ExpressionError(f"{op.name} of the constant {value}, which is not within −1…1.")
            return constant(value_of_numbers(op, float(value)))  # what overflows is refused by `constant`
        if a.op is NEG and op in _ODD:
            return neg(intern_node(op, a.args[0]))
        if a.op is NEG and op in _EVEN:
            return intern_node(op, a.args[0])
        return intern_node(op, a)

    return build


_tangent = _function(OPS["tan"])


def tan(a: Expr) -> Expr:
    """Tangent; exact where sine and cosine are."""
    if a.op is NEG:
        return neg(tan(a.args[0]))
    over, under = turns_sine(a, 0), turns_sine(a, 1)
    return _tangent(a) if over is None or not under else div(constant(over), constant(under))


def _binary(op: Op) -> Callable[[Expr, Expr], Expr]:
    def build(a: Expr, b: Expr) -> Expr:
        x, y = constant_value(a), constant_value(b)
        if op is not LESS and x is not None and y is not None:
            return constant(value_of_numbers(op, float(x), float(y)))
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
        raise ExpressionError(f"Expected a condition kn.less(a, b) in where(...), got {cut(condition, 80)}.")
    a, b = (constant_value(c) for c in condition.args)
    if a is not None and b is not None:
        return x if a < b else y
    return x if x is y else intern_node(WHERE, condition, x, y)


NODE_BUILDERS: dict[str, Callable[..., Expr]] = {
    name: _function(op) if op.arity == 1 else _binary(op) for name, op in OPS.items() if op.arity
}
"""Builders that take expressions only; the public ones of `operators` also take numbers."""
NODE_BUILDERS |= {build.__name__: build for build in (add, sub, mul, div, neg, sqrt, sin, cos, tan, where)} | {
    "pow": power
}


_ANGLE = "`{}` of an expression or a number, an angle in rad."
_TEXTS = {
    **{name: _ANGLE.format(name) for name in ("sin", "cos", "tan")},
    **{name: f"`{name}` of an expression or a number: an angle in rad." for name in ("asin", "acos", "atan")},
    "atan2": "`atan2(y, x)`: the angle in rad, from −π to π, of the direction (x, y).",
    "log": "Natural logarithm of an expression or a number.",
    "abs": "|x| of an expression or a number.",
    "sign": "`sign(x)`: 1 for x > 0, −1 for x < 0, 0 at 0.",
    "min": "`min(a, b)`: the smaller of two expressions or numbers.",
    "max": "`max(a, b)`: the larger of two expressions or numbers.",
    "less": "`less(a, b)`: the condition a < b, for `where`.",
    "where": "`where(less(a, b), x, y)`: x where a < b, else y.",
}
"""Docstrings of functions whose arguments or values need one."""


def accepting_numbers(name: str) -> Callable[..., Expr]:
    """The public form of a builder, which accepts numbers as well as expressions."""
    build, arity = NODE_BUILDERS[name], OPS[name].arity

    def public(*args: Any) -> Expr:
        if len(args) != arity:
            raise ExpressionError(f"{name} takes {arity} argument(s), got {len(args)}.")
        return build(*[as_expr(a) for a in args])

    public.__name__ = public.__qualname__ = name
    public.__doc__ = _TEXTS.get(name, f"`{name}` of an expression or a number.")
    return public


_SCALARS = (Expr, int, float, Fraction, np.number)


def operator(build: Callable[[Expr, Expr], Expr], swapped: bool = False) -> Callable[[Expr, Any], Any]:
    """The method of an operator, or with `swapped` the reflected method, which Python calls on the right operand."""
    if swapped:

        def reflected(self: Expr, other: Any) -> Any:
            return build(as_expr(other), self) if isinstance(other, _SCALARS) else NotImplemented

        return reflected

    def forward(self: Expr, other: Any) -> Any:
        if isinstance(other, Expr):
            return build(self, other)
        return build(self, as_expr(other)) if isinstance(other, _SCALARS) else NotImplemented

    return forward
