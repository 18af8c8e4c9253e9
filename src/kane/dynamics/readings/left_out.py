# SPDX-License-Identifier: BSD-3-Clause
"""Whether constraints that were left out as redundant follow from the others at a state: on another branch they may not.

Numbers there are an error, or NaN with a warning; what is compiled is NaN too, and its message names the constraint.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.constraints.left_out import Watch
from kane.dynamics.solved import Solved
from kane.errors import KaneWarning, SingularError, ValueMissingError
from kane.expr.evaluation import Walk, at, of_one_shape
from kane.expr.node import Expr, postorder
from kane.numeric.arrays import Mask
from kane.numeric.places import first_place

_CURE = (
    "It is on another branch of the mechanism than those that were compared: derive with kn.derive(system, near=…) of this "
    "configuration."
)


def concerned(solved: Solved, roots: Sequence[Expr]) -> tuple[int, ...]:
    """The places of expressions that hold something that the constraints were solved for, where rows were left out."""
    if not solved.redundant:
        return ()
    return tuple(k for k, root in enumerate(roots) if not solved.by_constraints.isdisjoint(postorder([root])))


def guarded(solved: Solved, roots: Sequence[Expr]) -> Sequence[Expr]:
    """`roots` to be compiled: NaN where rows that were left out hold more; where none are, they as they are."""
    return nan_where_more(solved, roots, roots)


def nan_where_more(solved: Solved, roots: Sequence[Expr], found: Sequence[Expr]) -> Sequence[Expr]:
    """What was `found` of `roots`, one of each: NaN where the root is."""
    places = concerned(solved, roots)
    if not places or solved.left_out is None:
        return found
    guard, _ = solved.left_out.guarding()
    return [guard(x) if k in places else x for k, x in enumerate(found)]


def notes(solved: Solved) -> dict[Expr, str]:
    """What to say of each guard that `guarded` puts in."""
    if solved.left_out is None:
        return {}
    _, guards = solved.left_out.guarding()
    why = (
        "which was left out as redundant and holds more at this state: it is on another branch of the mechanism than those that were "
        "compared (derive with kn.derive(system, near=…) of it)"
    )
    return {guard: f"{c.name!r}, {why}" for guard, c in guards.items()}


def check_left_out(
    solved: Solved, places: Sequence[int], values: Mapping[Expr, Any], numbers: Sequence[Any]
) -> list[Any]:
    """`numbers` at `values`: those at `places`, solved with too few constraints, are a SingularError, of arrays NaN and a warning."""
    kept, watch = list(numbers), solved.left_out
    if not places or watch is None:
        return kept
    rows = _more(solved, watch, values)
    wrong = rows.any(axis=-1)
    if not wrong.any():
        return kept
    first = first_place(wrong)
    names = ", ".join(repr(c.name) for c, x in zip(solved.redundant, rows[first.place], strict=True) if x)
    told = f"got {names}, which were left out as redundant and hold more"
    if not wrong.ndim:
        raise SingularError(
            f"Expected constraints that follow from the others at this state as where they were compared, {told}. {_CURE}"
        )
    warnings.warn(
        f"Expected constraints that follow from the others at every state, {told} at {first}: the values there are NaN. "
        f"{_CURE}",
        KaneWarning,
        stacklevel=4,
    )
    for k in places:
        kept[k] = np.where(wrong, np.nan, kept[k])
    return kept


def _more(solved: Solved, watch: Watch, values: Mapping[Expr, Any]) -> Mask:
    """Which rows hold more than the others (… × rows)."""
    roots = (watch.open, *(x for r in watch.rows for x in (r.beyond, r.limit)))
    try:
        found = of_one_shape(at(solved.walks.get(roots, lambda: Walk(roots)), values))
    except ValueMissingError:  # what was asked for holds less than the constraints do
        return np.zeros(len(watch.rows), dtype=bool)
    with np.errstate(invalid="ignore"):
        rows = [(found[0] < 1) & (beyond > limit) for beyond, limit in zip(found[1::2], found[2::2], strict=True)]
    return np.stack(rows, axis=-1)
