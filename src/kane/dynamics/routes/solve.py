# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion solved: for the tree as it stands, or with its constraints embedded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kane.dynamics.checks import check_mass, check_reactions_independent
from kane.dynamics.constraints.closure import matrix_at, sampled, table_at
from kane.dynamics.constraints.embed import Embedding, embedding, reduced, solve_embedded
from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.constraints.redundancy import check_determinate
from kane.dynamics.routes.reduce import Blocks, Solved, solve_motion
from kane.errors import ModelError, ReactionError, SingularError
from kane.expr.node import Expr, constant_value
from kane.kinematics.constraints import ConstraintRows
from kane.model.system import System


def solve(
    system: System, speeds: Sequence[Expr], blocks: Blocks, rows: ConstraintRows, partition: Partition | None
) -> tuple[Embedding | None, Solved]:
    """u̇ and the reactions; with constraints also how the dependent speeds follow from the independent ones."""
    e = None
    try:
        if partition is None:
            check_mass(system, speeds, blocks.mass)
            solved = solve_motion(blocks)
        else:
            e = embedding(rows, partition, len(speeds), len(blocks.mass_a))
            inner = reduced(e, blocks)
            check_mass(system, [speeds[i] for i in e.independent], inner.mass)
            solved = solve_embedded(e, inner, len(speeds))
    except SingularError as error:
        raise ReactionError(f"Expected reactions that can be told apart: {error}") from error
    check_reactions_independent(system.reactions, solved.reaction_matrix)
    return e, solved


def first_partition(system: System, speeds: Sequence[Expr], rows: ConstraintRows) -> Partition | None:
    """The partition at a configuration that satisfies the constraints, parameters at their defaults; None without constraints.

    What the user made dependent is taken first.
    """
    if not rows.constraints:
        return None
    sample = sampled(system, [x for row in (*rows.a, *rows.a_auxiliary) for x in row])
    values = sample.values
    a = matrix_at(rows, values)
    if not np.all(np.isfinite(a)):
        raise ModelError(
            "Expected constraints that are finite where their configuration constraints hold, got infinity or NaN: coordinates or "
            "parameters' defaults are singular there."
        )
    place = {u: i for i, u in enumerate(speeds)}
    easy = np.array([[constant_value(x) is not None for x in row] for row in rows.a]).reshape(a.shape)
    found = choose(a, [place[u] for u in system.dependent_speeds], easy=easy)
    strangers = [str(u) for u in system.dependent_speeds if place[u] not in found.dependent]
    if strangers:
        raise ModelError(
            f"Expected dependent_speeds= that the constraints give, got {', '.join(strangers)}, which they do not determine together "
            "with the others listed. Choose others, or leave them out to have them chosen."
        )
    check_determinate(system, rows, a, table_at(rows.a_auxiliary, values), sample)
    return found
