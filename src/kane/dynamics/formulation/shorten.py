# SPDX-License-Identifier: BSD-3-Clause
"""Short equations as one writes them in the end, where q̇, u̇ and the reactions together take fewer operations so.

What is known has its name, what is alike is made once, lengths go by parameters; long equations stay, for in them the ways differ by
little:

    Ṙ s₁ + R s s₁  →  … u₅ where the constraints give u₅ = R s s₁;   g sin q + R w,  R x  →  R ((g/R) sin q + w),  R x
    q̇ collected: ẋ = R (u₂ tan q₂ − u₃) cos q₁ for R u₂ cos q₁ tan q₂ − R u₃ cos q₁
    short quotients: I Ω u/(m R² + I) for I Ω u/(R² (m + I/R²))
    ė = ½ Gᵀ ω with ω/2: three halves in the place of four, for each set of Euler parameters
"""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import add, div, mul, sum_of
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Prices, exceeds, price
from kane.expr.forms.collect import collected, combined
from kane.expr.forms.scales import scaled
from kane.expr.forms.shorter import named, shared
from kane.expr.forms.shorter import with_short_quotients as shortened
from kane.expr.node import TWO, ZERO, Expr
from kane.expr.ops import ADD, MUL, NEG, SUB
from kane.expr.regular import extended

SHORT = 200
"""Operations above which equations stay as they are."""


def with_short_forms(s: Solved) -> Solved:
    """The same with shorter u̇, reactions and q̇; before it is guarded."""
    n, rates = len(s.accelerations), s.rates
    found = short_forms((*s.accelerations, *s.reactions, *rates), s.derived, s.embedding)
    own = found[len(found) - len(rates) :]
    return replace(
        s,
        accelerations=found[:n],
        reactions=found[n : len(found) - len(rates)],
        shorter_rates=s.shorter_rates if all(x is y for x, y in zip(own, rates, strict=True)) else own,
    )


def short_forms(exprs: Sequence[Expr], derived: Derived, e: Embedding | None) -> tuple[Expr, ...]:
    """Expressions that are computed together in fewer operations; themselves where they are long."""
    best = tuple(exprs)
    if exceeds(best, SHORT):
        return best
    least = price(best)
    given = _given(derived, e)
    kept = frozenset(e.guards_in_use) if e else frozenset()
    final: dict[str, tuple[Expr, ...]] = {}
    for rewritten in (lambda x, same: named(x, given, same), shared, combined, scaled, shared):
        if final.get(rewritten.__name__) is best:  # nothing has changed since
            continue
        found = rewritten(best, kept)
        cost = price(found)
        if cost < least:
            best, least = found, cost
        final[rewritten.__name__] = best
    return best


def _given(derived: Derived, e: Embedding | None) -> dict[Expr, Expr]:
    """Dependent speeds by what the constraints give them as."""
    if e is None:
        return {}
    own = [derived.speeds[i] for i in e.independent]
    given = map(add, e.a_n @ own, e.b_n)
    return {collected(x): derived.speeds[d] for x, d in zip(given, e.partition.dependent, strict=True) if x.args}


_SUMS = {ADD, SUB, MUL, NEG}


def with_short_rates(s: Solved) -> Solved:
    """The same with each q̇ in the form that takes the fewest operations beside u̇, the reactions and the other q̇."""
    rates, price = list(s.rates), None
    sums = [i for i, x in enumerate(rates) if x.op in _SUMS and any(a.args for a in x.args)]
    for i in sums:
        found = collected(rates[i])
        if found is not rates[i]:
            price = price or Prices((*s.accelerations, *s.reactions))
            tried = [*rates[:i], found, *rates[i + 1 :]]
            rates = tried if price(tried) < price(rates) else rates
    changed = any(x is not y for x, y in zip(rates, s.rates, strict=True))
    return replace(s, shorter_rates=tuple(rates)) if changed else s


def with_short_quotients(s: Solved) -> Solved:
    """The same, where u̇, reactions and q̇ then take fewer operations, or as many and each of them fewer; before it is guarded."""
    solved = (*s.accelerations, *s.reactions)
    found = shortened(solved, s.shorter_rates or s.derived.rates)
    if all(x is y for x, y in zip(solved, found, strict=True)):
        return s
    n, e = len(s.accelerations), s.embedding
    if e is not None:
        e = e.watching(extended(e.guards_in_use, found))
    return replace(s, accelerations=found[:n], reactions=found[n:], embedding=e)


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
