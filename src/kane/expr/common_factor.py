# SPDX-License-Identifier: BSD-3-Clause
"""The content of expressions: the product of parameters, and numbers, that all terms of a sum hold.

The content of m R² u₁ u₂/2 − m R² u₁ u₃ tan q₂/4 is m R²: an equation of which each term holds it is divided by it, and reads as one
writes it. Nothing is expanded: a sum has what its terms have in common, a product what its factors have together.
"""

from collections.abc import Callable, Iterable, Mapping

from kane.expr.build import add, div, mul, neg, sub
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import ADD, CONST, DIV, MUL, NEG, SUB
from kane.expr.symbols import Parameter
from kane.expr.visit import fold

Powers = Mapping[Expr, int]
"""Parameters with their powers, above zero."""
Contents = dict[Expr, Powers | None]
"""Contents by expression; None for zero, which is divided by anything."""

_NOTHING: Powers = {}


def content(exprs: Iterable[Expr], memo: Contents) -> Powers:
    """The parameters that all of the expressions hold, to the powers that all of them do; none where all are zero."""
    common: Powers | None = None
    for e in exprs:
        common = _both(common, fold(e, memo, lambda node: _of(node, memo)))
        if common is not None and not common:
            break
    return common or _NOTHING


def _of(node: Expr, memo: Contents) -> Powers | None:
    op, args = node.op, node.args
    if op is MUL or op is DIV:
        a, b = memo[args[0]], memo[args[1]]
        if a is None or b is None:
            return None
        sign = 1 if op is MUL else -1
        total = {p: a.get(p, 0) + sign * b.get(p, 0) for p in (*a, *b)}
        return {p: k for p, k in total.items() if k > 0}
    if op is ADD or op is SUB:
        return _both(memo[args[0]], memo[args[1]])
    if op is NEG:
        return memo[args[0]]
    if isinstance(node, Parameter):
        return {node: 1}
    return None if node is ZERO else _NOTHING


def _both(a: Powers | None, b: Powers | None) -> Powers | None:
    if a is None or b is None:
        return b if a is None else a
    return {p: min(k, b[p]) for p, k in a.items() if p in b}


def divider(memo: Contents) -> Callable[[Expr, Powers], Expr]:
    """Divides expressions by powers that are in their content; what they share is divided once."""
    done: dict[tuple[Expr, frozenset[tuple[Expr, int]]], Expr] = {}

    def divided(e: Expr, by: Powers) -> Expr:
        if not by or e is ZERO:
            return e
        key = e, frozenset(by.items())
        if key not in done:
            done[key] = _divided(e, by)
        return done[key]

    def _divided(e: Expr, by: Powers) -> Expr:
        op, args = e.op, e.args
        if op is ADD or op is SUB:
            return (add if op is ADD else sub)(divided(args[0], by), divided(args[1], by))
        if op is NEG:
            return neg(divided(args[0], by))
        if op is MUL:
            own = memo.get(args[0]) or _NOTHING
            first = {p: min(k, own[p]) for p, k in by.items() if p in own}
            rest = {p: k - first.get(p, 0) for p, k in by.items() if k > first.get(p, 0)}
            return mul(divided(args[0], first), divided(args[1], rest))
        if op is DIV and all((memo.get(args[0]) or _NOTHING).get(p, 0) >= k for p, k in by.items()):
            return div(divided(args[0], by), args[1])
        return ONE if by == {e: 1} else div(e, product_of(by))

    return divided


def product_of(powers: Powers) -> Expr:
    """The product of parameters with their powers."""
    total: Expr = ONE
    for p, k in powers.items():
        for _ in range(k):
            total = mul(total, p)
    return total


def over_number(e: Expr, divisor: Expr) -> Expr:
    """e over a number, which goes into the terms of a sum where each has a number as a factor, so that none is added."""
    if e.op is NEG:
        return neg(over_number(e.args[0], divisor))
    if not _absorbs(e):
        return div(e, divisor)
    if e.op is ADD or e.op is SUB:
        return (add if e.op is ADD else sub)(*(over_number(a, divisor) for a in e.args))
    if e.op is MUL:
        first, second = e.args
        inner = _absorbs(first)
        return mul(over_number(first, divisor) if inner else first, second if inner else over_number(second, divisor))
    return div(e, divisor)


def _absorbs(e: Expr) -> bool:
    """Whether e, each term of it if it is a sum, has a number as a factor."""
    if e.op is MUL:
        return any(a.op is not NEG and _absorbs(a) for a in e.args)
    if e.op is ADD or e.op is SUB or e.op is NEG:
        return all(map(_absorbs, e.args))
    return e.op is CONST or (e.op is DIV and (e.args[1].op is CONST or e.args[0].op is CONST))
