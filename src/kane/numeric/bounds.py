# SPDX-License-Identifier: BSD-3-Clause
"""By how much expressions can change where every symbol changes by a share of its value, rounding included: one pass with floats.

|Δ(a b)| ≤ |a| |Δb| + |b| |Δa| + |Δa| |Δb| and so on, each result and 2⁻⁵¹ of it (Higham 2002, Accuracy and Stability of Numerical
Algorithms, sec. 3.1). The bounds are of the first order of what happens, not sharp: terms that depend on each other are taken for
independent ones.
"""

import math
from collections.abc import Mapping

from kane.expr.evaluate import Walk
from kane.expr.node import Expr
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, SIN, SUB

_ROUNDING = 2.0**-51


def changes(walk: Walk, values: Mapping[Expr, float], share: float) -> list[tuple[float, float]] | None:
    """Value and largest change of each root; None where an operation is none of + − × ÷ sin cos, or a divisor may vanish."""
    found: dict[Expr, tuple[float, float]] = {}
    for node in walk.order:
        args, op = node.args, node.op
        if not args:
            number = walk.leaves[node]
            x = values[node] if number is None else number
            found[node] = x, abs(x) * share if number is None else abs(x) * _ROUNDING
            continue
        a, s = found[args[0]]
        if op is NEG:
            found[node] = -a, s
            continue
        if op is SIN or op is COS:
            if not math.isfinite(a):
                return None
            found[node] = (math.sin if op is SIN else math.cos)(a), s + _ROUNDING
            continue
        if len(args) != 2:
            return None
        b, t = found[args[1]]
        if op is MUL:
            x, change = a * b, abs(a) * t + abs(b) * s + s * t
        elif op is ADD or op is SUB:
            x, change = a + b if op is ADD else a - b, s + t
        elif op is DIV and abs(b) > t:
            x = a / b
            change = (s + abs(x) * t) / (abs(b) - t)
        else:
            return None
        found[node] = x, change + abs(x) * _ROUNDING
    return [found[r] for r in walk.roots]
