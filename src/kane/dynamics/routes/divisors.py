# SPDX-License-Identifier: BSD-3-Clause
"""What solutions divide by: no way to u̇ may divide by anything of W by which the usual one does not."""

from collections.abc import Callable, Sequence

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import NODE_BUILDERS
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import Expr, nodes
from kane.expr.ops import DIV, OPS, REGULAR
from kane.expr.regular import factors

_TAN = OPS["tan"]


def divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    below = nodes(exprs)
    found = {f for node in below if node.op is DIV for f in factors(node.args[1])}
    found |= {f for node in found if node.op is REGULAR for f in factors(node.args[0])}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in below if node.op is _TAN}


def of_embedding(e: Embedding) -> set[Expr]:
    """What A_n = −A_D⁻¹ A_I surely divides by: what A_I does and A_D does not, as A_D⁻¹ vanishes nowhere where A_D is finite."""
    a = e.rows.a.take(e.partition.rows)
    return divisors(a.take(columns=e.independent).entries) - divisors(a.take(columns=e.partition.dependent).entries)


def _of_solution(s: Solved) -> set[Expr]:
    return divisors((*s.accelerations, *s.reactions))


class Poles:
    """What the usual solution divides by, as far as that has to be known: first what is `told` soonest, last what it is made of.

    None of it is made where what is found divides by nothing of W.
    """

    def __init__(self, usual: Callable[[], Solved], *told: Callable[[], set[Expr]]) -> None:
        self._told: list[Callable[[], set[Expr]]] = [*told, lambda: _of_solution(usual())]
        self._known: set[Expr] = set()

    def fewer(self, derived: Derived, found: Sequence[Expr]) -> bool:
        """Whether what was found divides by nothing of W that the usual solution does not divide by."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        met = moving & divisors(found) if moving else moving
        while self._told and not met <= self._known:
            self._known |= self._told.pop(0)()
        return met <= self._known
