# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles with their Floquet multipliers, branches of limit cycles, and Poincaré sections."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered
from kane.motion.cycles.branch import CycleBranch, CycleChange
from kane.motion.cycles.limit_cycle import LimitCycle, limit_cycle
from kane.motion.cycles.section import SectionPoints, poincare

__all__ = ["CycleBranch", "CycleChange", "LimitCycle", "SectionPoints", "limit_cycle", "poincare"]

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})
