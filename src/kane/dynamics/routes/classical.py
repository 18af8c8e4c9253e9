# SPDX-License-Identifier: BSD-3-Clause
"""The classical route: M, f and G assembled, constraints embedded, M factored as L D Lᵀ."""

from __future__ import annotations

from kane.dynamics.checks import check_mass
from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derived import Derived
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.routes.embedded import all_accelerations, reduced
from kane.dynamics.solved import Solved


def classical(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions from M u̇ = f + G R.

    Raises
    ------
    SingularError
        if the reactions cannot be solved for
    ModelError
        if a speed, or a combination of speeds, moves no mass
    """
    system, speeds, blocks = derived.system, derived.speeds, derived.blocks
    if partition is None:
        check_mass(system, speeds, blocks.mass)
        return Solved("classical", derived, None, *block_solution(blocks))
    e: Embedding = embedding(derived.constraints, partition)
    inner = reduced(e, blocks)
    check_mass(system, [speeds[i] for i in e.independent], inner.mass)
    found = block_solution(inner)
    return Solved("classical", derived, e, *found._replace(accelerations=all_accelerations(e, found.accelerations)))
