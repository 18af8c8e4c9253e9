# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles with their multipliers, branches of them as a parameter changes, and Poincaré sections."""

from kane.motion.cycles.branch import CycleBranch, CycleChange
from kane.motion.cycles.limit_cycle import LimitCycle, limit_cycle
from kane.motion.cycles.section import SectionPoints, poincare

__all__ = ["CycleBranch", "CycleChange", "LimitCycle", "SectionPoints", "limit_cycle", "poincare"]
