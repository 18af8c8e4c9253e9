# SPDX-License-Identifier: BSD-3-Clause
"""A parameter's powers where they cost least: lengths of a disk are counted in its radii.

    (g sin q + R u₂ w)/(5 R/4),  m (g − R x)  →  4 ((g/R) sin q + u₂ w)/5,  m R (g/R − x)

Every expression e is p^k e′, with the power k that its factors bring. It costs nothing to carry k along through products, and through
sums whose terms have the same k. Elsewhere a term is multiplied by p, or the parameters in it are: g is R (g/R), once for all.
"""

from collections.abc import Collection, Sequence

from kane.expr.build import NODE_BUILDERS, div, mul, neg
from kane.expr.count import price
from kane.expr.node import ONE, Expr, postorder
from kane.expr.ops import ADD, DIV, MUL, NEG, SUB
from kane.expr.powers import WHOLE, chosen
from kane.expr.symbols import Parameter

_Image = tuple[Expr, int]
"""e′ and k of p^k e′."""


def scaled(roots: Sequence[Expr], kept: Collection[Expr] = ()) -> tuple[Expr, ...]:
    """`roots` with parameters' powers where all of them together take fewer operations; by no other parameter than before is divided.

    Parameters
    ----------
    roots : what is computed together
    kept : expressions in them that stay as they are
    """
    best, least, held = tuple(roots), price(roots), frozenset(kept)
    for p in _frequent(best):
        found = _rewritten(best, p, held, chosen(best, p, held))
        cost = price(found)
        if cost < least:
            best, least = found, cost
    return best


def _frequent(roots: Sequence[Expr]) -> list[Parameter]:
    """Parameters that are factors more than once, the most frequent first."""
    uses: dict[Parameter, int] = {}
    for node in postorder(roots):
        if node.op is MUL or node.op is DIV:
            for a in node.args:
                if isinstance(a, Parameter):
                    uses[a] = uses.get(a, 0) + 1
    return sorted((p for p, n in uses.items() if n > 1), key=lambda p: -uses[p])


def _rewritten(
    roots: tuple[Expr, ...], p: Parameter, kept: frozenset[Expr], choices: dict[Expr, int]
) -> tuple[Expr, ...]:
    images: dict[Expr, _Image] = {}
    for node in postorder(roots):
        if node is p:
            images[node] = ONE, 1
        elif isinstance(node, Parameter):
            k = choices.get(node, 0)
            images[node] = _times(node, p, -k), k
        elif not node.args or node in kept:
            images[node] = node, 0
        else:
            images[node] = _image(node, p, [images[a] for a in node.args], choices)
    return tuple(_times(e, p, k) for e, k in (images[r] for r in roots))


def _image(node: Expr, p: Parameter, args: list[_Image], choices: dict[Expr, int]) -> _Image:
    op, choice = node.op, choices.get(node)
    if op is NEG:
        return neg(args[0][0]), args[0][1]
    if op in (MUL, DIV):
        (x, k), (y, n) = args
        e, power = (mul(x, y), k + n) if op is MUL else (div(x, y), k - n)
    else:
        sum_ = op is ADD or op is SUB
        power = (min(k for _, k in args) if choice is None or choice == WHOLE else choice) if sum_ else 0
        e = NODE_BUILDERS[op.name](*[_times(x, p, k - power) for x, k in args])
    return (_times(e, p, power), 0) if choice == WHOLE else (e, power)


def _times(e: Expr, p: Parameter, k: int) -> Expr:
    """p^k e."""
    factor = ONE
    for _ in range(abs(k)):
        factor = mul(factor, p)
    return mul(e, factor) if k >= 0 else div(e, factor)
