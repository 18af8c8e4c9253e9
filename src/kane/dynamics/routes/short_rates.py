# SPDX-License-Identifier: BSD-3-Clause
"""q̇ collected: ẋ = R (u₂ tan q₂ − u₃) cos q₁ for R u₂ cos q₁ tan q₂ − R u₃ cos q₁, where that takes fewer operations."""

from collections.abc import Iterator
from dataclasses import replace

from kane.dynamics.solved import Solved
from kane.expr.build import mul, neg
from kane.expr.collect import collected
from kane.expr.count import Prices
from kane.expr.node import ONE, Expr
from kane.expr.ops import ADD, COS, MUL, NEG, SIN, SUB

_SUMS = {ADD, SUB, MUL, NEG}


def with_short_rates(s: Solved) -> Solved:
    """The same with each q̇ in the form that takes the fewest operations beside u̇, the reactions and the other q̇."""
    rates, price = list(s.rates), None
    sums = [i for i, x in enumerate(rates) if x.op in _SUMS and any(a.args for a in x.args)]
    for rewritten in (collected, _amounts_first):
        for i in sums:
            found = rewritten(rates[i])
            if found is not rates[i]:
                price = price or Prices((*s.accelerations, *s.reactions))
                tried = [*rates[:i], found, *rates[i + 1 :]]
                rates = tried if price(tried) < price(rates) else rates
    changed = any(x is not y for x, y in zip(rates, s.rates, strict=True))
    return replace(s, shorter_rates=tuple(rates)) if changed else s


def _amounts_first(e: Expr) -> Expr:
    """A product with its sines and cosines last: the components of one vector then share its size."""
    if e.op is NEG:
        return neg(_amounts_first(e.args[0]))
    factors = sorted(_factors(e), key=lambda f: f.op in (SIN, COS))
    product = ONE
    for f in factors:
        product = mul(product, f)
    return product


def _factors(e: Expr) -> Iterator[Expr]:
    if e.op is MUL:
        yield from _factors(e.args[0])
        yield from _factors(e.args[1])
    else:
        yield e
