# SPDX-License-Identifier: BSD-3-Clause
"""The shortest of a few ways to write an expression: as it was built, collected, or multiplied out with common factors taken out."""

from collections.abc import Iterable, Sequence

from kane.expr.collect import collected, factored
from kane.expr.count import price
from kane.expr.expand import expanded
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV, NEG
from kane.expr.visit import substituted

_LONG = 300
"""Nodes above which expressions that are read are left as they were built."""
_QUOTIENT = 24
"""Nodes up to which a quotient that is computed is looked at."""


def shortened(*ways: Sequence[Expr]) -> tuple[Expr, ...]:
    """Of each expression, given in one or more ways, the shortest; all as they come first where that is shorter together."""
    first = tuple(ways[0])
    if len(postorder(x for way in ways for x in way)) > _LONG:
        return min(map(tuple, ways), key=price)
    best = tuple(min(_forms(same), key=lambda e: price([e])) for same in zip(*ways, strict=True))
    return min((first, best), key=price)


def _forms(same: Iterable[Expr]) -> list[Expr]:
    found: list[Expr] = []
    for e in same:
        terms = expanded(e)
        found += [e, collected(e)] if terms is None else [e, collected(e), factored(terms)]
    return found


def with_short_quotients(exprs: Sequence[Expr], beside: Sequence[Expr]) -> tuple[Expr, ...]:
    """`exprs` with short quotients in their shortest form, where all, and what stands `beside` them, then take fewer operations.

    I Ω u/(R² (m + I/R²)) is I Ω u/(m R² + I).
    """
    unsigned = (e.args[0] if e.op is NEG else e for e in exprs)
    short = {e: min(_forms([e]), key=lambda form: price([form])) for e in unsigned if _is_short_quotient(e)}
    short = {e: form for e, form in short.items() if form is not e}
    if not short:
        return tuple(exprs)
    best = tuple(exprs)
    least = _length(best, beside)
    inner = {e: form for e, form in short.items() if not any(x is not e and x in short for x in postorder([e]))}
    for replaced in (inner, *({e: form} for e, form in short.items())):  # what they share decides: together, then each
        memo: dict[Expr, Expr] = {}
        trial = tuple(substituted(e, replaced, memo) for e in best)
        if (length := _length(trial, beside)) < least:
            best, least = trial, length
    return best


def _length(exprs: Sequence[Expr], beside: Sequence[Expr]) -> tuple[int, int]:
    """Operations of all together, and of each by itself, as it reads."""
    return price((*beside, *exprs)), sum(price([e]) for e in exprs)


def _is_short_quotient(e: Expr) -> bool:
    seen: set[Expr] = set()
    waiting = [e]
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            if len(seen) > _QUOTIENT:
                return False
            waiting += node.args
    return any(node.op is DIV for node in seen)
