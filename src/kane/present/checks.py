# SPDX-License-Identifier: BSD-3-Clause
"""A check with its figure, as the demo prints it and a report shows it."""

from __future__ import annotations

from dataclasses import dataclass

from kane.motion.solution import Solution

ENERGY_LIMIT = 1e-6


@dataclass(frozen=True, slots=True)
class Check:
    """What was compared, the figure found and the most that passes; NaN fails.

    `detail` says what the figure is: which two routes, at how many states.
    """

    name: str
    figure: float
    limit: float
    detail: str = ""

    @property
    def passed(self) -> bool:
        """Whether the figure is within its limit."""
        return self.figure <= self.limit

    def __str__(self) -> str:
        return f"{'pass' if self.passed else 'FAIL'}  {self.name}: {self.figure:.1e} (limit {self.limit:.0e})"


def energy_check(solution: Solution, *, of: str = "the loads", limit: float = ENERGY_LIMIT) -> Check:
    """Whether the energy changed by the work done, and by nothing else."""
    energy = solution.energy_check
    return Check(f"energy less the work of {of}, along the motion", energy.relative, limit, str(energy))
