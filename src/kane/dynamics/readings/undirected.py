# SPDX-License-Identifier: BSD-3-Clause
"""Loads that have no value at a state, such as those along v/|v| at rest."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.dynamics.solved import Solved
from kane.errors import cut
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV


def undirected(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """Which load has no value at `values`, what it divides by there, and the cure; "" where all have one.

    Symbols without a value, reactions, count as 1.
    """
    for load in solved.regular.declared_loads:
        scalars = [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]
        order = postorder(scalars)
        given = {s: values.get(s, 1.0) for s in free_symbols(order)}
        numbers = np.array(evaluate(order, given), dtype=float) if order else np.zeros(0)
        if np.isfinite(numbers).all():
            continue
        node = order[int(np.flatnonzero(~np.isfinite(numbers))[0])]
        by = (
            f"{cut(str(node), 80)} divides by {cut(str(node.args[1]))} = 0"
            if node.op is DIV
            else f"{cut(str(node), 80)}"
        )
        return (
            f"{load.name} has no value here, {by}. A force along v/|v| has no direction at rest: declare friction, "
            "kn.friction(…, smooth=…) or kn.dry_friction(…, smooth=…), and write a drag as c*v.magnitude()*v, or as "
            "v/sqrt(v.dot(v) + eps^2) with a small eps"
        )
    return ""
