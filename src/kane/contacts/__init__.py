# SPDX-License-Identifier: BSD-3-Clause
"""Contacts with Coulomb friction at one instant, numerically: modes, contact forces and accelerations, and impacts."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "problem": "ContactProblem ContactStatus contact_problem",
        "cones": "Block least_forces projected",
        "mode_solution": "ModeSolution",
        "iteration": "iterated",
        "choice": "ModeChoice SolutionCount choose enumerated jamming",
        "routh": "ContactImpact Law ImpactPhase impact",
        "several": "Hit Impacts Rule impacts",
    },
)
