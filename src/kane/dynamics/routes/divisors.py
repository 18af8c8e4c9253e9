# SPDX-License-Identifier: BSD-3-Clause
"""What solutions divide by: no way to u̇ may divide by anything of W by which the usual one does not."""

from collections.abc import Callable, Sequence
from functools import cached_property

from kane.dynamics.derived import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import NODE_BUILDERS
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import Expr, nodes
from kane.expr.ops import DIV, OPS
from kane.expr.regular import factors

_TAN = OPS["tan"]


def divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    below = nodes(exprs)
    found = {f for node in below if node.op is DIV for f in factors(node.args[1])}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in below if node.op is _TAN}


class Poles:
    """What the usual solution divides by: that is asked for only where what goes into it, `parts`, divides by less than is found.

    Neither is made where what is found divides by nothing of W.
    """

    def __init__(self, parts: Callable[[], Sequence[Expr]], usual: Callable[[], Solved]) -> None:
        self._parts, self._usual = parts, usual

    @cached_property
    def _sure(self) -> set[Expr]:
        return divisors(self._parts())

    @cached_property
    def _allowed(self) -> set[Expr]:
        usual = self._usual()
        return divisors((*usual.accelerations, *usual.reactions))

    def fewer(self, derived: Derived, found: Sequence[Expr]) -> bool:
        """Whether what was found divides by nothing of W that the usual solution does not divide by."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        met = moving & divisors(found) if moving else moving
        return not met or met <= self._sure or met - self._sure <= self._allowed
