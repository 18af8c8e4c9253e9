# SPDX-License-Identifier: BSD-3-Clause
"""Contacts with friction as numbers: which open, stick and slip, and what impacts do."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "problem": "ContactProblem Mode contact_problem",
        "cones": "Block least_forces projected",
        "equations": "ModeSolution",
        "enumeration": "enumerated",
        "iteration": "iterated",
        "choice": "Choice Count choose jamming",
        "routh": "Impact Law Phase impact",
        "several": "Hit Impacts Rule impacts",
    },
)
