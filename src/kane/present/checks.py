# SPDX-License-Identifier: BSD-3-Clause
"""A check with its figure, as the demo prints it and a report shows it."""

from __future__ import annotations

from dataclasses import dataclass


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
