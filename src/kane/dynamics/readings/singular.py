# SPDX-License-Identifier: BSD-3-Clause
"""Where W of q̇ = W u + X does not exist: what it divides by vanishes at a state, but for rounding.

cos q = 6e-17 at q = π/2, and what is divided by it would be a number, finite and meaningless. It is NaN, as what constraints are
divided by is; numbers at one state are an error.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.poles import AdmittedSpeeds, moving_pivots
from kane.dynamics.solved import Solved
from kane.errors import KaneWarning, SingularError, ValueMissingError, cut
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.expr.ops import GONE
from kane.expr.regular import guarding, unguarded
from kane.numeric.places import first_place

_CURE = (
    "Take a state beside it, or choose coordinates that are regular here (another sequence of angles, Euler parameters) or speeds "
    "that need no such division."
)


def with_regular_rates(solved: Solved, roots: Sequence[Expr]) -> list[Expr]:
    """`roots` that are NaN where they divide by what W divides by, and it vanishes."""
    return list(map(guarding(solved.rate_guards), roots))


def of_rates(solved: Solved, guard: Expr) -> str:
    """What to say of a guard that stands for a divisor of W; "" of another one."""
    (divisor,) = unguarded(guard.args[:1])
    return (
        f"the rates, which W of q' = W u + X gives divided by {cut(divisor, 80)}"
        if divisor in solved.rate_guards
        else ""
    )


def _cure(solved: Solved, values: Mapping[Expr, Any]) -> str:
    """Other dependent speeds, where the rates follow with them at this state, else other coordinates or speeds."""
    embedding = solved.embedding
    if embedding is None or not moving_pivots(solved.derived):
        return _CURE
    try:
        others = AdmittedSpeeds(solved.derived, values).cure(values, embedding.partition)
    except ValueMissingError:  # what was asked for holds less than the rates do
        return _CURE
    if others is None:
        return _CURE
    names = ", ".join(solved.derived.speeds[k].name for k in others)
    return (
        f"Name other dependent speeds, here System(dependent_speeds=…) of {names}; kn.simulate changes them by itself."
    )


def check_rates(solved: Solved, values: Mapping[Expr, Any], numbers: Sequence[Any]) -> None:
    """Say where `numbers` at `values` are NaN for a divisor of W that vanishes: of one state a SingularError, of arrays a warning."""
    by = solved.rate_guards
    if not by or not any(np.isnan(x).any() for x in numbers):
        return
    lost = np.logical_or.reduce([np.isnan(x) for x in numbers])
    known = [d for d in by if all(s in values for s in solved.rate_symbols[d])]
    here = evaluate([*known, *(by[d] for d in known)], values)
    for divisor, value, size in zip(known, here, here[len(known) :], strict=False):
        with np.errstate(invalid="ignore"):
            gone = np.broadcast_to(np.abs(value) <= GONE * size, lost.shape) & lost
        if not gone.any():
            continue
        first = first_place(gone)
        what = f"W of q' = W u + X divided by {cut(divisor, 80)} = {float(np.broadcast_to(value, lost.shape)[first.place]) + 0.0:.3g}"
        state = {s: np.broadcast_to(v, lost.shape)[first.place] for s, v in values.items()}
        if not lost.ndim:
            raise SingularError(
                f"Expected speeds that give the rates at this state, got {what}. {_cure(solved, state)}"
            )
        warnings.warn(
            f"Expected speeds that give the rates at every state, got {what} at {first}: the values there are NaN. "
            f"{_cure(solved, state)}",
            KaneWarning,
            stacklevel=5,
        )
        return
