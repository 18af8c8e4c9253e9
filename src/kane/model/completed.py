# SPDX-License-Identifier: BSD-3-Clause
"""Independent speeds alone: those that are missing are rates of constraints, which vanish.

With as many motions as speeds the book writes u_1 … u_p only (Kane & Levinson 1985, sec. 2.13). The equations need as many speeds as
rates: w = A_q q̇ + b_q of constraints completes them, is zero, and shortens q̇ = W u + X where it stands in it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.linear_parts import affine_forms
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, Speed, word
from kane.expr.visit import substituted
from kane.model.constraints import Constraint
from kane.model.variables import EulerParameters, basic_rates, rates_by_quasi
from kane.numeric.arrays import Array
from kane.numeric.rank import balanced, singular
from kane.numeric.sampling import SEEDS, values_of
from kane.numeric.scale import SPEEDS_RANK


def completed(
    definitions: Mapping[Speed, Expr],
    coordinates: Sequence[Coordinate],
    euler: Sequence[EulerParameters],
    constraints: Sequence[Constraint],
) -> dict[Speed, Expr]:
    """Rates of constraints as speeds, where the definitions are exactly the independent speeds; none otherwise.

    All independent constraints take part: with fewer speeds left out than there are constraints, one was forgotten.
    """
    rates, by_quasi = basic_rates(coordinates, euler), rates_by_quasi(euler)
    missing = len(rates) - len(definitions)
    if not definitions or not 0 < missing <= len(constraints):
        return {}
    offered = [substituted(constraint_rate(c), by_quasi) for c in constraints]
    told = [substituted(e, by_quasi) for e in definitions.values()]
    forms = [row for row, _ in affine_forms([*told, *offered], rates)]
    entries = [row.get(b, ZERO) for row in forms for b in rates]
    chosen: set[tuple[int, ...]] = set()
    for seed in SEEDS:
        with np.errstate(all="ignore"):
            numbers = np.array(evaluate(entries, values_of(free_symbols(entries), seed)), dtype=float)
        places = _independent(numbers.reshape(len(forms), len(rates)), len(told), missing)
        if places is None:
            return {}
        chosen.add(places)
    if len(chosen) != 1:
        return {}
    taken = {u.name for u in definitions}
    found: dict[Speed, Expr] = {}
    for k, place in enumerate(next(iter(chosen))):
        c = constraints[place]
        name = next(
            n for n in (f"w{k + 1}", f"w{k + 1}_{c.name}", *(f"w_{i}" for i in range(len(rates)))) if n not in taken
        )
        taken.add(name)
        found[Speed.declare(word(name), None, "", f"rate of the constraint {c.name}, which vanishes")] = offered[place]
    return found


def constraint_rate(constraint: Constraint) -> Expr:
    """ḟ of a configuration constraint, a motion constraint itself: A_q q̇ + b_q."""
    return time_derivative(constraint.expr) if constraint.kind == "configuration" else constraint.expr


def _independent(rows: Array, first: int, missing: int) -> tuple[int, ...] | None:
    """The rows beyond the `first` ones that these do not give; None where they are not `missing`, all that are independent."""
    if not np.isfinite(rows).all():
        return None
    scaled, kept, found = balanced(rows), list(range(first)), list[int]()
    if singular(scaled[first:]).rank(SPEEDS_RANK) != missing:
        return None
    for k in range(first, len(rows)):
        if len(found) == missing:
            break
        if singular(scaled[[*kept, k]]).rank(SPEEDS_RANK) == len(kept) + 1:
            kept.append(k)
            found.append(k - first)
    return tuple(found) if len(found) == missing and singular(scaled[kept]).rank(SPEEDS_RANK) == rows.shape[1] else None
