# SPDX-License-Identifier: BSD-3-Clause
"""What solutions divide by: no way to u̇ may divide by anything of W by which the usual one does not."""

from collections.abc import Callable, Sequence
from functools import cached_property

from kane.dynamics.derived import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import NODE_BUILDERS
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import OPS
from kane.expr.regular import denominators, factors


def divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    tangents = (node for node in postorder(exprs) if node.op is OPS["tan"])
    found = {f for d in denominators(exprs) for f in factors(d)}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in tangents}


class Poles:
    """What the usual solution divides by: that is asked for only where what goes into it, `parts`, divides by less than is found."""

    def __init__(self, parts: Sequence[Expr], usual: Callable[[], Solved]) -> None:
        self._parts, self._usual = parts, usual

    @cached_property
    def _sure(self) -> set[Expr]:
        return divisors(self._parts)

    @cached_property
    def _allowed(self) -> set[Expr]:
        usual = self._usual()
        return divisors((*usual.accelerations, *usual.reactions))

    def fewer(self, derived: Derived, found: Sequence[Expr]) -> bool:
        """Whether what was found divides by nothing of W that the usual solution does not divide by."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        if not moving or moving <= self._sure:
            return True
        more = (moving & divisors(found)) - self._sure
        return not more or more <= self._allowed
