# SPDX-License-Identifier: BSD-3-Clause
"""Short equations as one writes them in the end: what is known has its name, what is alike is made once, lengths go by parameters.

    Ṙ s₁ + R s s₁  →  … u₅ where the constraints give u₅ = R s s₁;   g sin q + R w,  R x  →  R ((g/R) sin q + w),  R x

Where q̇, u̇ and the reactions together take fewer operations so. Long equations stay as they are: in them the ways differ by little.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import add
from kane.expr.collect import collected
from kane.expr.count import exceeds, price
from kane.expr.known import named
from kane.expr.linear_forms import combined
from kane.expr.node import Expr
from kane.expr.products import shared
from kane.expr.scales import scaled

LONG = 200
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
        shorter_rates=s.shorter_rates if _same(own, rates) else own,
    )


def short_forms(exprs: Sequence[Expr], derived: Derived, e: Embedding | None) -> tuple[Expr, ...]:
    """Expressions that are computed together in fewer operations; themselves where they are long."""
    best = tuple(exprs)
    if exceeds(best, LONG):
        return best
    least = price(best)
    given = _given(derived, e)
    kept = frozenset(e.guards_in_use) if e else frozenset()
    for rewritten in (lambda x, same: named(x, given, same), combined, shared, scaled, shared):
        found = rewritten(best, kept)
        cost = price(found)
        if cost < least:
            best, least = found, cost
    return best


def _given(derived: Derived, e: Embedding | None) -> dict[Expr, Expr]:
    """Dependent speeds by what the constraints give them as."""
    if e is None:
        return {}
    own = [derived.speeds[i] for i in e.independent]
    given = map(add, e.a_n @ own, e.b_n)
    return {collected(x): derived.speeds[d] for x, d in zip(given, e.partition.dependent, strict=True) if x.args}


def _same(a: Iterable[Expr], b: Iterable[Expr]) -> bool:
    return all(x is y for x, y in zip(a, b, strict=True))
