# SPDX-License-Identifier: BSD-3-Clause
"""Where the dependent speeds of a partition do not follow from the independent ones: a determinant in A_D vanishes at a state.

u_D = A_n u_I + b_n with A_n = −A_D⁻¹ A_I divides by the determinants of the irreducible blocks of A_D. Each is compared with the size
of the terms that it is made of: what is left of zero by rounding, such as cos q = 6e-17 at q = π/2, is zero, and what is divided by
it is NaN. Other partitions are regular there.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.singular import of_rates
from kane.dynamics.solved import Pivot, Solved
from kane.errors import KaneWarning, SingularError, ValueMissingError, cut
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr, postorder
from kane.expr.ops import GONE, WHERE
from kane.expr.regular import factors, guards_below, unguarded
from kane.numeric.places import First, first_place
from kane.numeric.rank import balanced
from kane.numeric.scale import STATE_RANK


def check_pivots(solved: Solved, roots: Sequence[Expr], values: Mapping[Expr, Any], numbers: Sequence[Any]) -> None:
    """Say where `numbers` of `roots` at `values` are NaN for what they are divided by vanishes.

    At a single state that is a SingularError; of arrays a warning names the first place.
    """
    if not any(np.isnan(x).any() for x in numbers):
        return
    below = [g for g in guards_below(roots) if not of_rates(solved, g)]
    lost = np.logical_or.reduce([np.isnan(x) for x in numbers])
    for g, where in zip(below, _vanishing(below, values), strict=True):
        where = where & lost
        if where.any():
            _tell(solved, pivot_of(solved, g), values, where.shape, first_place(where))


def _vanishing(below: Sequence[Expr], values: Mapping[Expr, Any]) -> list[npt.NDArray[np.bool_]]:
    here, sizes = (evaluate([g.args[k] for g in below], values) for k in (0, 1))
    with np.errstate(invalid="ignore"):
        return [np.asarray(np.abs(x) <= GONE * size) for x, size in zip(here, sizes, strict=True)]


def pivot_of(solved: Solved, guard: Expr) -> Pivot:
    """The pivot that a guard belongs to; what is solved with A_Dᵀ has expressions of its own."""
    (divisor,) = unguarded(guard.args[:1])
    for p in solved.dependent_pivots:
        if any(divisor is f for f in factors(p.value)):
            return p
    return Pivot(solved.dependent_speeds, divisor, guard.args[1])


def divided_by(p: Pivot, who: str = "the constraints") -> str:
    """The speeds of a pivot and what they are divided by, as far as that can be read."""
    names = ", ".join(sorted(u.name for u in p.speeds))
    chosen = any(node.op is WHERE for node in postorder([p.value]))
    return f"{names}, which {who} give divided by {'a determinant' if chosen else f'{cut(p.value, 80)}'}"


def _tell(solved: Solved, p: Pivot, values: Mapping[Expr, Any], shape: tuple[int, ...], first: First) -> None:
    here = {s: np.broadcast_to(v, shape)[first.place] for s, v in values.items()}
    undetermined = f"{divided_by(p, 'they')} = {float(evaluate(p.value, here)) + 0.0:.3g}"
    if not first.place:
        raise SingularError(
            f"Expected dependent speeds that the constraints give at this state, got {undetermined}. {_cure(solved, here)}"
        )
    warnings.warn(
        f"Expected dependent speeds that the constraints give at every state, got {undetermined} at {first}: the values there "
        f"are NaN. {_cure(solved, here)}",
        KaneWarning,
        stacklevel=5,
    )


def _cure(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """The speeds that are dependent by choice of the numbers at this state, where there are as many."""
    assert solved.embedding is not None
    matrix = solved.embedding.rows.a
    try:
        a = np.asarray(evaluate(matrix, values), dtype=float)
    except ValueMissingError:  # what was asked for holds less than A does
        a = np.full(matrix.shape, np.nan)
    rows = list(solved.embedding.partition.rows)
    if not np.isfinite(a).all():
        return "Name others, System(dependent_speeds=…)."
    other = choose(a[rows])
    block = balanced(a[rows])[np.ix_(other.rows, other.dependent)]
    if len(other.rows) < len(rows) or not np.linalg.cond(block) * STATE_RANK < 1:
        if len(choose(a).rows) < len(rows):
            return (
                "No others will do: the constraints hold fewer speeds here than elsewhere, it is a singular configuration. Take a "
                "state beside it."
            )
        return "Here other constraints are redundant; kn.simulate changes them by itself, kn.linearize and kn.inverse do without."
    names = ", ".join(solved.derived.speeds[k].name for k in sorted(other.dependent))
    return (
        f"Name others, here System(dependent_speeds=…) of {names}; kn.simulate changes them by itself, kn.linearize and kn.inverse "
        "do without."
    )
