# SPDX-License-Identifier: BSD-3-Clause
"""The routes by name, and the equations solved by one of them."""

from collections.abc import Callable

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.derivation_checks import check_reactions_independent
from kane.dynamics.formulation.equations import classical
from kane.dynamics.formulation.held_forces import without_held_forces
from kane.dynamics.formulation.recursive import WAYS
from kane.dynamics.formulation.shortest import shortest
from kane.dynamics.formulation.speeds import constraint_speeds
from kane.dynamics.formulation.trees import forced
from kane.dynamics.solved import Solved
from kane.errors import ReactionError, SingularError

Route = Callable[[Derived, Partition | None], Solved]
"""From what is derived, and a choice of dependent speeds where there are constraints, to u̇ and the reactions."""

ROUTES: dict[str, Route] = {
    "classical": classical,
    "constraint speeds": constraint_speeds,
    "shortest": without_held_forces(shortest),
    **{name: forced(name) for name in WAYS},
}
ASKED = ("classical", *WAYS)
"""Those that one may ask for."""


def solved(derived: Derived, partition: Partition | None, route: str = "shortest") -> Solved:
    """u̇ and the reactions, which must be such that they can be told apart; with constraints also u_D by u_I."""
    try:
        solution = ROUTES[route](derived, partition)
    except SingularError as error:
        raise ReactionError(f"Expected reactions that can be told apart: {error}") from error
    check_reactions_independent(derived.system, derived.reactions, solution.reaction_matrix)
    return solution
