# SPDX-License-Identifier: BSD-3-Clause
"""The dependent speeds that a derivation begins with."""

from __future__ import annotations

import numpy as np

from kane.dynamics.constraints.closure import matrix_at, sampled
from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.constraints.redundancy import check_determinate
from kane.errors import ModelError
from kane.expr.node import constant_value
from kane.kinematics.constraints import ConstraintRows
from kane.model.system import System


def first_partition(system: System, rows: ConstraintRows) -> Partition | None:
    """The partition at a configuration that satisfies the constraints, parameters at their defaults; None without constraints.

    What the user made dependent is taken first.

    Raises
    ------
    ModelError
        if A is not finite there, `dependent_speeds` are not given by the constraints, or these contradict each other
    ReactionError
        if a reaction is not determined
    """
    if not rows.constraints:
        return None
    sample = sampled(system, [*rows.a.entries, *rows.a_auxiliary.entries])
    a = matrix_at(rows.a, sample.values)
    if not np.all(np.isfinite(a)):
        raise ModelError(
            "Expected constraints that are finite where their configuration constraints hold, got infinity or NaN: coordinates or "
            "parameters' defaults are singular there."
        )
    place = {u: i for i, u in enumerate(system.speeds)}
    easy = np.array([constant_value(x) is not None for x in rows.a.entries]).reshape(a.shape)
    partition = choose(a, [place[u] for u in system.dependent_speeds], easy=easy)
    strangers = [str(u) for u in system.dependent_speeds if place[u] not in partition.dependent]
    if strangers:
        raise ModelError(
            f"Expected dependent_speeds= that the constraints give, got {', '.join(strangers)}, which they do not determine together "
            "with the others listed. Choose others, or leave them out to have them chosen."
        )
    check_determinate(system, rows, a, matrix_at(rows.a_auxiliary, sample.values), sample)
    return partition
