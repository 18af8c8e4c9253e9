# SPDX-License-Identifier: BSD-3-Clause
"""Where expressions hold what is known by a name, the name stands: with v = R s cos q, (w cos q) (R s) is w v."""

from collections.abc import Collection, Mapping, Sequence

from kane.expr.build import div, mul, neg
from kane.expr.node import ONE, Expr, postorder
from kane.expr.ops import DIV, MUL, NEG
from kane.expr.visit import substituted


def named(roots: Sequence[Expr], given: Mapping[Expr, Expr], kept: Collection[Expr] = ()) -> tuple[Expr, ...]:
    """`roots` with names in the places of what is known.

    Parameters
    ----------
    roots : what is computed
    given : names by what they stand for, which is found as it is, or as factors of products
    kept : expressions in the roots that stay as they are
    """
    same = {e: e for e in kept}
    known = [(_factors(e), e, name) for e, name in given.items() if e.args]
    replaced: dict[Expr, Expr] = {}
    for node in postorder(roots):
        for factors, e, name in known:
            if node is e or (e.op is NEG and node is e.args[0]):
                replaced[node] = name if node is e else neg(name)
            elif (node.op is MUL or node.op is DIV) and len(factors) > 1:
                rest = _without(node, factors, same)
                if rest is not None:
                    replaced[node] = mul(rest, neg(name) if e.op is NEG else name)
    memo: dict[Expr, Expr] = {}
    whole = replaced | same
    return tuple(substituted(r, whole, memo) for r in roots) if replaced else tuple(roots)


def _factors(e: Expr) -> list[Expr]:
    """What a product without divisors is the product of, its sign apart; the whole where it is none."""
    found, waiting = [], [e.args[0] if e.op is NEG else e]
    while waiting:
        x = waiting.pop()
        if x.op is MUL:
            waiting += x.args
        else:
            found.append(x)
    return found


def _without(e: Expr, factors: Sequence[Expr], kept: Mapping[Expr, Expr]) -> Expr | None:
    """What is left of a product, in its order, without some factors; None where it has not all of them."""
    left = list(factors)

    def rest(x: Expr) -> Expr:
        place = next((k for k, f in enumerate(left) if f is x), None)
        if place is not None:
            del left[place]
            return ONE
        if x in kept:
            return x
        if x.op is MUL:
            return mul(*map(rest, x.args))
        return div(rest(x.args[0]), x.args[1]) if x.op is DIV else x

    found = rest(e)
    return None if left else found
