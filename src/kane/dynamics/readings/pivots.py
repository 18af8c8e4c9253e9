# SPDX-License-Identifier: BSD-3-Clause
"""Where the dependent speeds of a partition do not follow from the independent ones: a pivot of A_D vanishes at a state.

u_D = A_n u_I + b_n with A_n = −A_D⁻¹ A_I divides by the pivots of A_D. They are compared with their size at coordinates drawn at
random: what is left of zero by rounding, such as cos q = 6e-17 at q = π/2, is zero. Other partitions are regular there.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.constraints.partition import choose
from kane.dynamics.solved import Pivot, Solved
from kane.errors import KaneWarning, SingularError, ValueMissingError
from kane.expr.evaluate import evaluate
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV
from kane.numeric.sample import draw

_SEED = 20066
_GONE = 1e-12
"""Share of its usual size at which a pivot is taken as zero: nothing that was divided by it has a digit left."""


def check_pivots(
    solved: Solved, roots: Sequence[Expr], values: Mapping[Expr, Any], numbers: Sequence[Any]
) -> list[Any]:
    """`numbers` of `roots` at `values`, checked: those that divide by a vanishing pivot are not finite, or rounding's alone.

    At a single state that is a SingularError; of arrays a warning names the first place, and such numbers are NaN.
    """
    kept = list(numbers)
    below = _denominators(roots)
    divided = [p for p in solved.dependent_pivots if below.intersection(p.divisors)] if below else []
    for p, where in zip(divided, _vanishing([p.value for p in divided], solved, values), strict=True):
        if not where.any():
            continue
        place = tuple(int(i) for i in np.argwhere(where)[0])
        _tell(solved, p, values, where.shape, place, int(where.sum()))
        for k, root in enumerate(roots):
            if _denominators([root]).intersection(p.divisors):
                kept[k] = np.where(where, np.nan, kept[k])
    return kept


def _denominators(roots: Sequence[Expr]) -> set[Expr]:
    return {node.args[1] for node in postorder(roots) if node.op is DIV}


def _vanishing(pivots: Sequence[Expr], solved: Solved, values: Mapping[Expr, Any]) -> list[npt.NDArray[np.bool_]]:
    if not pivots:
        return []
    drawn = {q: draw(_SEED, q) for q in solved.derived.system.coordinates}
    here, usual = evaluate(pivots, values), evaluate(pivots, {**values, **drawn})
    with np.errstate(invalid="ignore"):
        return [np.asarray(np.abs(x) <= _GONE * np.abs(y)) for x, y in zip(here, usual, strict=True)]


def _tell(
    solved: Solved, p: Pivot, values: Mapping[Expr, Any], shape: tuple[int, ...], place: tuple[int, ...], count: int
) -> None:
    here = {s: np.broadcast_to(v, shape)[place] for s, v in values.items()}
    undetermined = (
        f"{p.speed.name}, which they give divided by {p.value!s:.80} = {float(evaluate(p.value, here)) + 0.0:.3g}"
    )
    if not place:
        raise SingularError(
            f"Expected dependent speeds that the constraints give at this state, got {undetermined}. {_cure(solved, here)}"
        )
    index = place[0] if len(place) == 1 else place
    warnings.warn(
        f"Expected dependent speeds that the constraints give at every state, got {undetermined} at index {index}"
        f"{f' and {count - 1} more' if count > 1 else ''}: the values there are NaN. {_cure(solved, here)}",
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
    other = choose(a) if np.isfinite(a).all() else None
    if other is None:
        return "Name others, System(dependent_speeds=…)."
    if len(other.rows) < len(solved.embedding.partition.rows):
        return (
            "No others will do: the constraints hold fewer speeds here than elsewhere, it is a singular configuration. Take a state "
            "beside it."
        )
    names = ", ".join(solved.derived.speeds[k].name for k in sorted(other.dependent))
    return (
        f"Name others, here System(dependent_speeds=…) of {names}; kn.simulate changes them by itself, kn.linearize and kn.inverse "
        "do without."
    )
