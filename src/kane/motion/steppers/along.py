# SPDX-License-Identifier: BSD-3-Clause
"""A step of collocation along its length: where events are looked at, where rates are compared, weights up to any place.

The stages see a jump of the rates where it lies between two nodes, as the polynomial through them is bent by it. Before the first node
and behind the last one, a fiftieth of the step at either end, it leaves no trace in them: the state is off by the jump times that
part of the step. So rates that may jump are evaluated at both ends too, and between the nodes, in one call. A smooth motion differs
there by the next divided difference of its rates alone, which is ω(1) = 1/12870 of the one that the step is judged by, times their
ratio.
"""

from dataclasses import dataclass
from functools import cache

from kane.motion.bounds import SHARES
from kane.motion.steppers.collocation import Nodes, Vector, integrals, lagrange
from kane.program.kernel.write import Term, Writer

_BETWEEN = (0.0, 0.06, 0.17, 0.32, 0.5, 0.68, 0.83, 1.0)
_REACH = 0.02
"""Share of a step that lies behind its last node."""
_TOLERANCES, _SMOOTH = 5.0, 1.5e-5
"""What is let pass: so many times rtol; and the share of the step's own estimate that is ten times what smooth rates leave there."""


@dataclass(frozen=True, slots=True)
class Along:
    """Eight `shares` of a step; row j of `once`, `twice` and `rates` says what the rates at node j count in ∫ k, ∫∫ k and k there.

    Where it is `ended`, the last state is the one that is gone on from, moved onto the constraints.
    """

    shares: Vector
    once: tuple[Vector, ...]
    twice: tuple[Vector, ...]
    rates: tuple[Vector, ...]
    ended: bool

    def larger(self, w: Writer, before: Term, gap: Term) -> Term:
        """The larger sizes, lane by lane; what is not finite stays so."""
        size = w.compute("abs", gap)
        return w.select(size > before, size, before) + size * w.lanes(*[0.0] * len(self.shares))

    def share(self, w: Writer, gaps: Term, rtol: Term, error: Term) -> Term:
        """What a jump may have made of the state, by the gaps times h over sizes, over what is let pass."""
        largest = w.compute("largest", gaps) + w.compute("sum", gaps) * 0.0
        return largest * _REACH / (rtol * _TOLERANCES + error * _SMOOTH)


@cache
def events(nodes: Nodes) -> Along:
    """The places at which events are looked at, but for the beginning of the step."""
    return _along(nodes, SHARES[1:], True)


@cache
def defects(nodes: Nodes) -> Along:
    """Both ends of the step, and places between."""
    return _along(nodes, _BETWEEN, False)


def _along(nodes: Nodes, shares: Vector, ended: bool) -> Along:
    once, twice = (tuple(zip(*rows, strict=True)) for rows in zip(*(integrals(nodes, s) for s in shares), strict=True))
    return Along(shares, once, twice, tuple(zip(*(lagrange(nodes, s) for s in shares), strict=True)), ended)


def weights(w: Writer, theta: Term, nodes: Nodes) -> tuple[Term, Term]:
    """What the rates of the nodes count in ∫ k and in ∫∫ k up to θ, lane by lane."""
    count = len(nodes.c)
    x = theta * 2.0 - 1.0
    p = [w.constant(1.0), x]
    for k in range(1, count + 1):
        p.append((x * p[k] * float(2 * k + 1) - p[k - 1] * float(k)) * (1 / (k + 1)))
    once = [theta] + [(p[k + 1] - p[k - 1]) * (0.5 / (2 * k + 1)) for k in range(1, count + 1)]
    twice = [theta * theta * 0.5] + [(once[k + 1] - once[k - 1]) * (0.5 / (2 * k + 1)) for k in range(1, count)]
    rows = [tuple((2 * k + 1) * b * v for b, v in zip(nodes.b, nodes.legendre[k], strict=True)) for k in range(count)]
    first, second = ([w.compute("splat8", v) * r for v, r in zip(i, rows, strict=False)] for i in (once, twice))
    return w.sum(first), w.sum(second)
