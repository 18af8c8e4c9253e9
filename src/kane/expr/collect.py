# SPDX-License-Identifier: BSD-3-Clause
"""Sums of products, collected: like terms joined, and the factor that most terms have taken out, as one writes a short equation.

    R u₂ u₃ + R u₂ u₃/2 − R u₂² tan q₂/4 + g sin q₂  →  g sin q₂ + R u₂ (3 u₃/2 − u₂ tan q₂/4)

Sums within products are left as they are. What that costs is for the caller to compare.
"""

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from functools import cmp_to_key

from kane.expr.build import add, mul, neg
from kane.expr.node import ONE, ZERO, Expr, Number, constant, constant_value, precedes
from kane.expr.ops import ADD, CONST, DIV, MUL, NEG, SUB

_MOST = 12
"""Terms, and factors of a term, up to which a sum is collected."""


def _first(a: Expr, b: Expr) -> int:
    return -1 if precedes(a, b) else 1


_ORDER = cmp_to_key(_first)

Term = tuple[Number, tuple[Expr, ...]]
"""A number, and factors in their order."""


def collected(e: Expr) -> Expr:
    """The sum e collected; e itself where it is none, or a long one."""
    if e.op is NEG:
        return neg(collected(e.args[0]))
    if e.op is not ADD and e.op is not SUB:
        return e
    terms = _terms(e)
    return e if terms is None else _factored(terms)


def _terms(e: Expr) -> list[Term] | None:
    found: dict[tuple[Expr, ...], Number] = {}
    waiting: list[tuple[Expr, int]] = [(e, 1)]
    count = 0
    while waiting:
        x, sign = waiting.pop()
        if x.op is ADD or x.op is SUB:
            waiting += [(x.args[1], sign if x.op is ADD else -sign), (x.args[0], sign)]
        elif x.op is NEG:
            waiting.append((x.args[0], -sign))
        else:
            count += 1
            number, factors = _product(x)
            if count > _MOST or len(factors) > _MOST:
                return None
            found[factors] = found.get(factors, 0) + sign * number
    return [(n, f) for f, n in found.items() if n != 0]


def _product(e: Expr) -> Term:
    """The number and the factors that e is the product of."""
    number: Number = 1
    factors: list[Expr] = []
    waiting = [e]
    while waiting:
        x = waiting.pop()
        value = constant_value(x)
        if value is not None:
            number = number * value
        elif x.op is MUL:
            waiting += x.args
        elif x.op is NEG:
            number = -number
            waiting.append(x.args[0])
        elif x.op is DIV and x.args[1].op is CONST:
            below = constant_value(x.args[1])
            assert below is not None
            number = number * (Fraction(1, below) if isinstance(below, int) else 1 / below)
            waiting.append(x.args[0])
        else:
            factors.append(x)
    return number, tuple(sorted(factors, key=_ORDER))


def _factored(terms: Sequence[Term]) -> Expr:
    """The factor that most terms have, times what is left of them, plus the other terms likewise."""
    if not terms:
        return ZERO
    if len(terms) == 1:
        ((number, factors),) = terms
        return _times(number, factors)
    counts = Counter(f for _, factors in terms for f in dict.fromkeys(factors))
    common = max(counts, key=lambda f: counts[f])
    if counts[common] < 2:
        total = ZERO
        for number, factors in terms:
            total = add(total, _times(number, factors))
        return total
    own = [(n, _without(f, common)) for n, f in terms if common in dict.fromkeys(f)]
    others = [(n, f) for n, f in terms if common not in dict.fromkeys(f)]
    return add(_factored(others), mul(common, _factored(own)))


def _without(factors: tuple[Expr, ...], one: Expr) -> tuple[Expr, ...]:
    place = next(i for i, f in enumerate(factors) if f is one)
    return (*factors[:place], *factors[place + 1 :])


def _times(number: Number, factors: Sequence[Expr]) -> Expr:
    total = ONE
    for f in factors:
        total = mul(total, f)
    return mul(constant(number), total)
