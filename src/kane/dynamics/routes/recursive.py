# SPDX-License-Identifier: BSD-3-Clause
"""The recursive route: u̇ of trees by articulated inertias.

It takes systems without constraints whose joint speeds are constant combinations of the generalized speeds, one after the other:
rates, sums and differences of rates, measure numbers of ω and v of a body in the one before. Of others `recursive` is None.
"""

from kane.dynamics.derived import Derived
from kane.dynamics.routes.articulated import accelerations
from kane.dynamics.routes.carried import falling, load_wrenches, regrouped, rigid_bodies
from kane.dynamics.routes.embedded import evident, holds_reactions
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.evaluate import is_constant_in_time
from kane.kinematics.segments import Unsuited, segments, solved_rows
from kane.kinematics.tree import tree_of


def recursive(derived: Derived) -> Solved | None:
    """u̇ without the reactions; None where the tree is not one of those."""
    if not suits(derived):
        return None
    points = [p for load in derived.declared_loads for p, _ in load.forces]
    tree = tree_of(derived.system, derived.kinematics.aligned, points)
    try:
        found = segments(tree, derived.kinematics)
        bodies = regrouped(rigid_bodies(derived, found, tree.links), found.steps)
        loads = load_wrenches(derived, found, tree.links)
        passed = accelerations(found.steps, bodies, loads, falling(derived))
    except (Unsuited, SingularError):
        return None
    values = solved_rows(passed.rows, derived.speeds)
    if values is None:
        return None
    matrix = evident(derived)
    u_dot = tuple(values[u] for u in derived.speeds)
    return Solved("recursive", derived, None, u_dot, (), tuple(passed.pivots), matrix, matrix)


def suits(derived: Derived) -> bool:
    """Whether there are no constraints, no loads that hold reactions, and W divides by parameters and numbers alone."""
    return not derived.constraints.constraints and not holds_reactions(derived)
