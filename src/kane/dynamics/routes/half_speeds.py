# SPDX-License-Identifier: BSD-3-Clause
"""ė = ½ Gᵀ ω with ω/2 instead: three halves in the place of four, for each set of Euler parameters."""

from dataclasses import replace

from kane.dynamics.assembly import sum_of
from kane.dynamics.solved import Solved
from kane.expr.build import div, mul
from kane.expr.count import price
from kane.expr.linear_parts import affine_forms
from kane.expr.node import TWO, ZERO, Expr


def with_half_speeds(s: Solved) -> Solved:
    """The same, where q̇ then takes fewer operations beside u̇."""
    if not s.derived.system.euler_parameters:
        return s
    place: dict[Expr, int] = {q: i for i, q in enumerate(s.derived.system.coordinates)}
    rates = list(s.rates)
    for group in s.derived.system.euler_parameters:
        own = [place[e] for e in group.coordinates]
        forms = affine_forms([mul(TWO, rates[i]) for i in own], s.derived.speeds)
        if any(rest is not ZERO for _, rest in forms):
            continue
        for i, (form, _) in zip(own, forms, strict=True):
            rates[i] = sum_of(mul(c, div(u, TWO)) for u, c in form.items())
    beside = (*s.accelerations, *s.reactions)
    return replace(s, shorter_rates=tuple(rates)) if price((*rates, *beside)) < price((*s.rates, *beside)) else s
