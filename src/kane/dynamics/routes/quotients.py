# SPDX-License-Identifier: BSD-3-Clause
"""Short quotients of what was solved for in their shortest form: I Ω u/(m R² + I) for I Ω u/(R² (m + I/R²))."""

from dataclasses import replace

from kane.dynamics.solved import Solved
from kane.expr.regular import extended
from kane.expr.shorten import with_short_quotients as shortened


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
