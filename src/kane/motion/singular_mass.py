# SPDX-License-Identifier: BSD-3-Clause
"""Where the accelerations are not determined by the equations: the mass matrix is singular at a state but for rounding.

What its pivots divide by is then zero or what rounding left of it, and the rates are finite by chance.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.numeric.rank import null_direction
from kane.numeric.scale import SOLVE_RANK, TAKES_PART

_POSITIVE = {"recursive", "composite"}
"""Routes that do not divide by pivots of M; theirs are positive (`dynamics/routes/recursive.py`)."""


def check_mass_matrix(eom: Equations, values: Mapping[Expr, Any], t: float) -> None:
    """M of a system without constraints must determine u̇ at the start; the error names the accelerations that it leaves open."""
    solved = eom.solved
    if solved.embedding is not None or solved.route in _POSITIVE:
        return
    m = np.asarray(evaluate(eom.mass_matrix, values), dtype=float)
    direction = null_direction(m, SOLVE_RANK)
    if direction is None:
        return
    names = [f"{u}'" for u, c in zip(eom.speeds, direction, strict=True) if abs(c) > TAKES_PART]
    raise SimulationError(
        f"Expected finite rates at the start, got none for {', '.join(names)} at t = {t:g}: the equations are singular at this state, "
        "where the mass matrix does not determine them. Start elsewhere, or choose coordinates and speeds that are regular here."
    )
