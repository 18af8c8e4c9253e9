# SPDX-License-Identifier: BSD-3-Clause
"""Whether coordinates satisfy the constraints, on the branch that closures mean."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.analysis.state import misses, open_shares
from kane.dynamics.constraints.manifold import manifold, turned_closures
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.node import Expr
from kane.numeric.arrays import Array
from kane.numeric.places import first_place


def check_configuration(
    eom: Equations, residual: Array, terms: Array, values: Mapping[Expr, Any], what: str, cure: str
) -> None:
    """The configuration constraints hold: `residual` (… × m) is what is left of them; `terms` and `values` as for `open_shares`."""
    count = residual.shape[-1]
    if not count:
        return
    shares = open_shares(eom, residual, terms, values).reshape(-1, count)
    worst = np.abs(residual).reshape(-1, count).max(axis=0, initial=0)
    bad = misses([c.name for c in eom.system.holonomic], worst, shares.max(axis=0, initial=0))
    if bad:
        raise SimulationError(f"Expected {what} on the constraints, got coordinates that miss {bad}. {cure}")


def check_branch(eom: Equations, q: Array, rest: Mapping[Expr, Any], what: str, cure: str) -> None:
    """No closure is turned away from the branch that it means, at any of the coordinates q (… × n); `rest` holds all other values."""
    conditions = manifold(eom.system)
    angles = conditions.at(rest).turned(q)
    away = angles.any(axis=-1)
    if away.any():
        first = first_place(away)
        where = f" at index {first.written}" if first.place else ""
        turned = turned_closures(conditions.branches, angles[first.place])
        raise SimulationError(
            f"Expected {what} on the branch that the closures mean, got {turned}{where}. kn.assemble finds one on it "
            f"from guesses{cure}."
        )
