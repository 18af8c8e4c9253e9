# SPDX-License-Identifier: BSD-3-Clause
"""Whether constraints that were left out as redundant follow from the others at a state: on another branch they may not.

With A_R the rows left out and u_D = A_n u_I the speeds that the others leave, they follow where A_R,I + A_R,D A_n vanishes. That is
compared with the sizes of its terms and with what the row holds elsewhere, at states on the constraints: off them nothing is known.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.constraints.closure import OFF
from kane.dynamics.derived import Derived
from kane.dynamics.solved import Solved
from kane.errors import KaneWarning, SingularError, ValueMissingError
from kane.expr.evaluate import Walk, at, of_one_shape
from kane.expr.node import Expr, postorder
from kane.expr.ops import CONST, SYMBOL
from kane.numeric.arrays import Array

_HOLDS = 1e-2
"""Share above which a row holds more: beside a place where branches meet it is the root of what a closed state may leave open."""


def check_left_out(
    solved: Solved, roots: Sequence[Expr], values: Mapping[Expr, Any], numbers: Sequence[Any]
) -> list[Any]:
    """`numbers` of `roots` at `values`: what was solved with too few constraints is a SingularError, of arrays NaN and a warning."""
    kept = list(numbers)
    concerned = [k for k, root in enumerate(roots) if _solved_below(solved, root)] if solved.redundant else []
    if not concerned:
        return kept
    share, closed = _shares(solved, values)
    with np.errstate(invalid="ignore"):
        rows = (share > _HOLDS) & closed[..., None]
    wrong = rows.any(axis=-1)
    if not wrong.any():
        return kept
    first = tuple(int(i) for i in np.argwhere(wrong)[0])
    names = ", ".join(repr(c.name) for c, x in zip(solved.redundant, rows[first], strict=True) if x)
    told = f"got {names}, which were left out as redundant and hold more"
    cure = (
        "It is on another branch of the mechanism than those that were compared: derive with "
        "kn.derive(system, near=…) of this configuration."
    )
    if not wrong.ndim:
        raise SingularError(
            f"Expected constraints that follow from the others at this state as where they were compared, {told}. {cure}"
        )
    index = first[0] if len(first) == 1 else first
    warnings.warn(
        f"Expected constraints that follow from the others at every state, {told} at index {index}"
        f"{f' and {int(wrong.sum()) - 1} more' if wrong.sum() > 1 else ''}: the values there are NaN. {cure}",
        KaneWarning,
        stacklevel=4,
    )
    for k in concerned:
        kept[k] = np.where(wrong, np.nan, kept[k])
    return kept


def _solved_below(solved: Solved, root: Expr) -> bool:
    """Whether an expression holds something that the constraints were solved for."""
    e = solved.embedding
    assert e is not None
    found = (*solved.accelerations, *solved.reactions, *e.a_n.entries, *e.b_n)
    return not {x for x in found if x.op is not CONST and x.op is not SYMBOL}.isdisjoint(postorder([root]))


def _shares(solved: Solved, values: Mapping[Expr, Any]) -> tuple[Array, Any]:
    """What each row left out holds beyond the others, over the size of its terms (… × rows), and whether the state is closed (…)."""
    e, derived = solved.embedding, solved.derived
    assert e is not None
    rows, conditions = derived.A.take(e.partition.redundant), derived.conditions
    groups = (rows.take(columns=e.independent), rows.take(columns=e.partition.dependent), e.a_n)
    roots = (*(x for m in groups for x in m.entries), *conditions.f)
    try:
        found = of_one_shape(at(solved.walks.get(roots, lambda: Walk(roots)), values))
    except ValueMissingError:  # what was asked for holds less than the constraints do
        return np.zeros(len(rows)), np.zeros((), dtype=bool)
    stacked = np.stack(found, axis=-1)
    *starts, end = np.cumsum([0, *(m.shape[0] * m.shape[1] for m in groups)])
    pieces = zip(np.split(stacked[..., :end], starts[1:], axis=-1), groups, strict=True)
    own, dependent, a_n = (x.reshape(*x.shape[:-1], *m.shape) for x, m in pieces)
    with np.errstate(invalid="ignore", divide="ignore"):
        beyond = np.abs(own + dependent @ a_n).max(axis=-1, initial=0)
        terms = (np.abs(own) + np.abs(dependent) @ np.abs(a_n)).max(axis=-1, initial=0)
        closed = (np.abs(stacked[..., end:]) <= OFF * _reach(derived)).all(axis=-1)
        usual = np.abs(derived.compared.a[:, list(e.partition.redundant)]).max(axis=(0, 2), initial=0)
        return beyond / np.maximum(terms, usual), closed


def _reach(derived: Derived) -> Array:
    """The usual size of the terms of each configuration constraint: of their derivatives times turns of 1 rad, or lengths."""
    at = derived.compared.at
    q = np.array([np.broadcast_to(at.values[c], at.count) for c in derived.system.coordinates]).T
    gradient = np.abs(at.matrices(derived.conditions.gradient))
    return np.asarray((gradient @ np.abs(q)[:, :, None])[:, :, 0].max(axis=0, initial=0))
