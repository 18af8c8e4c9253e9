# SPDX-License-Identifier: BSD-3-Clause
"""The routes of trees as one asks for them: with the reactions, and an error that says why where the system is no such tree."""

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derived import Derived
from kane.dynamics.routes.recursive import by_recursion
from kane.dynamics.routes.trees import compared, tree_with_reactions
from kane.dynamics.solved import Solved
from kane.errors import ModelError
from kane.kinematics.segments import Unsuited


def recursive(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ by articulated inertias, and the reactions; a ModelError where the system is no tree of joint speeds."""
    try:
        return compared([tree_with_reactions(derived, by_recursion(derived))])
    except Unsuited as why:
        raise ModelError(
            f"Expected a tree of joint speeds without constraints for route='recursive', got {why}. Leave out route=, or take "
            "route='classical'."
        ) from None
