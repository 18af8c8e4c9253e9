# SPDX-License-Identifier: BSD-3-Clause
"""Recursions among the routes: tried of trees from a few bodies on, and from one more on alone.

There they are shorter and sooner found, and M and f are assembled when they are read. Of trees that constraints close they are tried
from a few bodies more on, and alone where there are many freedoms for each constraint.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.candidates import Candidate, Poles, all_speeds, divisors, with_reactions
from kane.dynamics.formulation.recursive import BENT, by_recursion, carrying, recursions
from kane.dynamics.formulation.shorten import with_half_speeds
from kane.dynamics.solved import Solved
from kane.errors import ModelError
from kane.expr.node import Expr
from kane.kinematics.freedoms import Unsuited
from kane.model.bodies import deforming

_TREE, _GROWN = 5, 6
"""Bodies from which on recursions are tried, and from which on nothing else is."""
_LOOP, _WIDE, _FEW = 6, 12, 3
"""The same under constraints, the latter with so many speeds for each row."""


def recursive(derived: Derived, partition: Partition | None) -> list[Solved]:
    """The solutions by recursion, of trees large enough or flexible, that divide by nothing of W by which velocities do not."""
    if len(derived.inertias) < (_TREE if partition is None else _LOOP) and not deforming(derived.system.bodies):
        return []
    return [_finished(derived, s) for s in recursions(derived, partition) if has_no_poles(derived, s)]


def _finished(derived: Derived, s: Solved) -> Solved:
    """With the reactions, and guards or short q̇."""
    whole = tree_with_reactions(derived, s)
    return with_half_speeds(whole) if s.embedding is None else whole.guarded()


def has_no_poles(derived: Derived, s: Solved) -> bool:
    """Whether it divides by nothing of W by which velocities do not."""
    return Poles(lambda: _of_velocities(derived)).fewer(derived, s.accelerations)


def _of_velocities(derived: Derived) -> set[Expr]:
    """What partial velocities of bodies divide by, and with them every route."""
    motions = [m for b in derived.bodies for m in (b.center, b.rotation and b.rotation.motion) if m]
    return divisors([x for m in motions for v in m.partials.values() for x in v.scalars()])


def is_grown(derived: Derived, partition: Partition | None) -> bool:
    """Whether a tree has so many bodies that recursion is shorter than any M of theirs."""
    if deforming(derived.system.bodies):
        return partition is None and len(derived.speeds) >= BENT
    if partition is None:
        return len(derived.inertias) >= _GROWN
    return len(derived.inertias) >= _WIDE and len(derived.speeds) >= _FEW * len(partition.rows)


def tree_with_reactions(derived: Derived, s: Solved) -> Solved:
    """A solution of a tree with the reactions."""
    if len(s.reactions) == len(derived.reactions):
        return s
    motions = all_speeds(derived) if derived.reactions else None
    return with_reactions(Candidate(s, motions), s.accelerations, derived, s.embedding)


def compared(found: Sequence[Solved]) -> Solved:
    """The solution with the fewest operations, the first of several, with the operations of all of them by route.

    Those of one alone are counted when they are read.
    """
    if len(found) == 1:
        return found[0]
    costs = [s.price for s in found]
    by_route: dict[str, int] = {}
    for s, cost in zip(found, costs, strict=True):
        by_route[s.route] = min(cost, by_route.get(s.route, cost))
    return replace(found[costs.index(min(costs))], routes=by_route)


def forced(route: str) -> Callable[[Derived, Partition | None], Solved]:
    """u̇ by one of the recursions, and the reactions; a ModelError where the system is no tree of joint speeds."""

    def solve(derived: Derived, partition: Partition | None) -> Solved:
        try:
            found = by_recursion(derived, carrying(derived, flexible=True, shared=True), route, partition)
            if not has_no_poles(derived, found):
                raise Unsuited("speeds whose W has poles that velocities in these speeds have not")
            return compared([_finished(derived, found)])
        except Unsuited as why:
            raise ModelError(
                f"Expected a tree of joint speeds for route={route!r}, got {why}. Leave out route=, or take "
                "route='classical'."
            ) from None

    return solve
