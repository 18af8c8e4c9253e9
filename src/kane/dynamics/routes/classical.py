# SPDX-License-Identifier: BSD-3-Clause
"""The classical route: M, f and G assembled, constraints embedded, M factored as L D Lᵀ."""

from kane.dynamics.checks import check_mass
from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.solved import Solved


def classical(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions from M u̇ = f + G R; a speed, or a combination of speeds, that moves no mass is a ModelError."""
    return unguarded_classical(derived, partition).guarded()


def unguarded_classical(derived: Derived, partition: Partition | None, e: Embedding | None = None) -> Solved:
    """The same, where what is divided by is not watched yet, with the embedding `e` of the partition, if there is one already."""
    system, speeds, blocks = derived.system, derived.speeds, derived.blocks
    if partition is None:
        check_mass(system, speeds, blocks.mass)
        return Solved("classical", derived, None, *block_solution(blocks))
    e = e or embedding(derived.constraints, partition)
    inner = e.reduced(blocks)
    check_mass(system, [speeds[i] for i in e.independent], inner.mass)
    solution = block_solution(inner)
    every = solution._replace(accelerations=e.every(solution.accelerations))
    return Solved("classical", derived, e, *every)
