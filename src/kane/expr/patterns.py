# SPDX-License-Identifier: BSD-3-Clause
"""Patterns that the builders look for: each looks at a fixed number of nodes and builds none."""

import math
from fractions import Fraction

from kane.expr.constants import number_of, total
from kane.expr.node import ONE, ZERO, Expr, Number, constant_value, pi
from kane.expr.ops import ADD, CONST, COS, MUL, NEG, SIN, SUB
from kane.expr.surd import sine_of_turns

_CIRCULAR = (SIN, COS)


def split(a: Expr) -> tuple[Expr, Expr]:
    """A constant and the rest: a = coefficient · rest."""
    if a.op is MUL and a.args[0].op is CONST:
        return a.args[0], a.args[1]
    return ONE, a


def like_terms(a: Expr, b: Expr, sign: int) -> tuple[Expr, Expr, Expr] | None:
    """The sum a + sign·b as constant · x · y, if it is one product: c x ± d x, or c x y ± d x y however they are grouped."""
    if a.op is not MUL or b.op is not MUL:
        ca, ra = split(a)
        cb, rb = split(b)
        return (total(ca, cb, sign), ra, ONE) if ra is rb else None
    if not (_has_number(a) or _has_number(b)):  # two products of two are alike only with a number in one of them
        return None
    ca, ra = split(a)
    cb, rb = split(b)
    if ra is rb:
        return total(ca, cb, sign), ra, ONE
    for c, x, y in _scaled_pairs(a):
        for d, v, w in _scaled_pairs(b):
            if (x is v and y is w) or (x is w and y is v):
                return total(c, d, sign), x, y
    return None


def _has_number(a: Expr) -> bool:
    """Whether a product of two factors has a number in front, or in front of a factor."""
    x, y = a.args
    return x.op is CONST or (x.op is MUL and x.args[0].op is CONST) or (y.op is MUL and y.args[0].op is CONST)


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


def sin2_cos2(a: Expr, b: Expr) -> Expr | None:
    """k where a + b is k sin² x + k cos² x, however the factors are grouped."""
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
    """a = turns·π/2 ± rest with turns in 0…3 and − where the flag is set; turns is 0 where no multiple of π/2 is at hand."""
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
    """sin(a + quarters · π/2) where a is a multiple of π whose sine is a fraction or a surd, else None."""
    ratio = constant_value(a.args[0]) if a.op is MUL and a.args[1] is pi else None
    if ratio is None or not isinstance(ratio, int | Fraction):  # the class of fractions takes long to tell
        return None
    found: Number | None = sine_of_turns(ratio + Fraction(quarters, 2))
    return found


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
