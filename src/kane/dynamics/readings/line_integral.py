# SPDX-License-Identifier: BSD-3-Clause
"""V with ∂V/∂x_k = p_k, along a way of lines, one a symbol: V = Σ_k ∫ p_k(x₁, …, x_{k−1}, s, b, …, b) ds, from the base b to x_k.

Each part is an antiderivative where there is one in closed form, else Gauss's rule. That V is what it says is for the caller to see,
by differentiation: where ∂p_i/∂x_k = ∂p_k/∂x_i every way gives the same, elsewhere none does.
"""

from collections.abc import Sequence
from typing import NamedTuple

from kane.expr.build import add, mul, sub
from kane.expr.collect import factored
from kane.expr.count import price
from kane.expr.evaluation import free_symbols
from kane.expr.expand import expanded
from kane.expr.integration import antiderivative
from kane.expr.node import ZERO, Expr, constant
from kane.expr.symbols import Symbol
from kane.expr.visit import substituted
from kane.numeric.legendre import gauss

NODES = 20
"""Of Gauss's rule."""


class Integral(NamedTuple):
    """A potential, and the symbols along which Gauss's rule was taken."""

    value: Expr
    by_rule: tuple[Symbol, ...]


def line_integral(slopes: Sequence[Expr], symbols: Sequence[Symbol], base: Expr = ZERO) -> Integral:
    """V from its `slopes` in the `symbols`, zero where these are the base, but for a constant of the first part."""
    total, by_rule = ZERO, []
    for k, (p, x) in enumerate(zip(slopes, symbols, strict=True)):
        own = substituted(p, dict.fromkeys(symbols[k + 1 :], base))
        part = antiderivative(own, x)
        if part is None:
            part = _by_gauss(own, x, base)
            by_rule.append(x)
        elif any(s in set(symbols[:k]) for s in free_symbols([part])):
            part = sub(part, substituted(part, {x: base}))
        total = add(total, part)
    return Integral(_short(total), tuple(by_rule))


def _by_gauss(e: Expr, x: Symbol, base: Expr) -> Expr:
    """∫ e dx from the base by Gauss's rule."""
    reach, total = sub(x, base), ZERO
    for place, weight in zip(*gauss(NODES), strict=True):
        at = add(base, mul(constant(float(place)), reach))
        total = add(total, mul(constant(float(weight)), substituted(e, {x: at})))
    return mul(reach, total)


def _short(e: Expr) -> Expr:
    """What cancels between the parts left out, where that is shorter."""
    terms = expanded(e)
    if terms is None:
        return e
    forms = [e, factored(terms)]
    return min(forms, key=lambda form: price([form]))
