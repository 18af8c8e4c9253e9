# SPDX-License-Identifier: BSD-3-Clause
"""The routes of trees as one asks for them: with the reactions, and an error that says why where the system is no such tree."""

from collections.abc import Callable

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.closed import closed
from kane.dynamics.routes.recursive import by_recursion, carrying
from kane.dynamics.routes.shorten import with_half_speeds
from kane.dynamics.routes.trees import compared, has_no_poles, tree_with_reactions
from kane.dynamics.solved import Solved
from kane.errors import ModelError
from kane.kinematics.freedoms import Unsuited


def _closed(derived: Derived, partition: Partition, route: str) -> Solved:
    found = closed(derived, partition, route, shared=True)
    _check_poles(derived, found)
    return tree_with_reactions(derived, found).guarded()


def _check_poles(derived: Derived, found: Solved) -> None:
    if not has_no_poles(derived, found):
        raise Unsuited("speeds whose W has poles that velocities in these speeds have not")


def forced(route: str) -> Callable[[Derived, Partition | None], Solved]:
    """u̇ by one of the recursions, and the reactions; a ModelError where the system is no tree of joint speeds."""

    def solve(derived: Derived, partition: Partition | None) -> Solved:
        try:
            if partition is not None:
                return compared([_closed(derived, partition, route)])
            found = by_recursion(derived, carrying(derived, flexible=True, shared=True), route)
            _check_poles(derived, found)
            return compared([with_half_speeds(tree_with_reactions(derived, found))])
        except Unsuited as why:
            raise ModelError(
                f"Expected a tree of joint speeds for route={route!r}, got {why}. Leave out route=, or take "
                "route='classical'."
            ) from None

    return solve
