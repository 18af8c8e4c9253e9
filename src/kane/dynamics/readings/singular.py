# SPDX-License-Identifier: BSD-3-Clause
"""Where W of q̇ = W u + X does not exist: what it divides by vanishes at a state, but for rounding.

cos q = 6e-17 at q = π/2, and what is divided by it would be a number, finite and meaningless. It is NaN, as what constraints are
divided by is; numbers at one state are an error.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.solved import Solved
from kane.errors import KaneWarning, SingularError, cut
from kane.expr.evaluate import evaluate
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
        if not lost.ndim:
            raise SingularError(f"Expected speeds that give the rates at this state, got {what}. {_CURE}")
        warnings.warn(
            f"Expected speeds that give the rates at every state, got {what} at {first}: the values there are NaN. {_CURE}",
            KaneWarning,
            stacklevel=5,
        )
        return
