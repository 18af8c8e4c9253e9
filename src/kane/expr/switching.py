# SPDX-License-Identifier: BSD-3-Clause
"""Switches: operations that turn where a quantity c passes zero, and what they are on one side of it.

|c|,   sign c,   a < b and where(a < b, …) with c = b − a,   min and max of a, b with c = b − a,   tables, at whose corners c turns
"""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from kane.expr.build import NODE_BUILDERS, neg, sub, where
from kane.expr.node import ONE, ZERO, Expr, constant, postorder
from kane.expr.ops import LESS, NEG, OPS, Op
from kane.expr.piecewise import Piecewise, applied
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import fold, rebuilt

ABS, SIGN, MIN, MAX = (OPS[name] for name in ("abs", "sign", "min", "max"))
_OF_TWO = frozenset((LESS, MIN, MAX))


class Switch(NamedTuple):
    """A quantity, and the nodes that turn where it passes zero."""

    quantity: Expr
    nodes: tuple[Expr, ...]


def turning_on(node: Expr) -> tuple[Expr, bool] | None:
    """The quantity of a switch, and whether it counts as declared or with the other sign; None of what is no switch.

    Of a quantity and its negative there is one, so that x < 0 and 0 < x turn on the same.
    """
    if node.op is ABS or node.op is SIGN:
        c = node.args[0]
    elif isinstance(node.op, Piecewise) and node.op.sides is not None:
        return applied(node.op.sides[0], node.args[0]), True
    elif node.op in _OF_TWO:
        c = sub(node.args[1], node.args[0])
    else:
        return None
    return (c.args[0], False) if c.op is NEG else (c, True)


def switches(roots: Iterable[Expr]) -> tuple[Switch, ...]:
    """The switches below `roots` by their quantities, but those whose quantity changes in jumps alone, or with parameters."""
    order = postorder(roots)
    varies: dict[Expr, bool] = {}
    found: dict[Expr, list[Expr]] = {}
    for node in order:
        own = turning_on(node)
        if own is not None and any(varies[a] for a in node.args):
            found.setdefault(own[0], []).append(node)
        varies[node] = _varies(node, varies)
    return tuple(Switch(c, tuple(nodes)) for c, nodes in found.items())


def _varies(node: Expr, varies: Mapping[Expr, bool]) -> bool:
    if isinstance(node, Symbol):
        return not isinstance(node, Parameter)
    return node.op is not LESS and node.op is not SIGN and any(varies[a] for a in node.args)


_Choose = Callable[[Expr, Expr], Expr]
_ON_SIDE: dict[Op, Callable[[tuple[Expr, ...], _Choose], Expr]] = {
    ABS: lambda a, choose: choose(a[0], neg(a[0])),
    SIGN: lambda a, choose: choose(ONE, constant(-1)),
    MAX: lambda a, choose: choose(a[1], a[0]),
    MIN: lambda a, choose: choose(a[0], a[1]),
}
_LESS = NODE_BUILDERS["less"]


def on_sides(root: Expr, sides: Mapping[Expr, Symbol], memo: dict[Expr, Expr]) -> Expr:
    """`root` with every switch of a quantity in `sides` replaced by what it is where that symbol is positive, or negative."""

    def replaced(node: Expr) -> Expr:
        args = tuple(memo[a] for a in node.args)
        own = turning_on(node)
        side = sides.get(own[0]) if own is not None else None
        if own is None or side is None:
            return rebuilt(node, args)
        holds = _LESS(ZERO, side) if own[1] else _LESS(side, ZERO)
        if isinstance(node.op, Piecewise) and node.op.sides is not None:
            return where(holds, *(applied(op, args[0]) for op in node.op.sides[1:]))
        return holds if node.op is LESS else _ON_SIDE[node.op](args, lambda x, y: where(holds, x, y))

    return fold(root, memo, replaced)
