# SPDX-License-Identifier: BSD-3-Clause
"""What a kernel of collocation is given beside what all are, and the polynomials that it leaves."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from kane.dynamics.events import SLIPS, KinematicsEnd, SlipEnd
from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.motion.bounds import DEGREE as PARTS
from kane.motion.compiled_equations import Routines
from kane.motion.steppers.collocation import gauss
from kane.motion.steppers.gauss import STAGES
from kane.numeric.arrays import Array
from kane.program.native.entry import aligned, entry, hoisted, wide_entry

Given = dict[str, Any]
"""Arrays, integers and routines by the names of a kernel's arguments."""


def by_kind(eom: Equations) -> dict[str, Array | int]:
    """`pairs`: the (i, j) of coordinates i whose rate is the speed at place j of the state; `free`: the places of the others."""
    place: dict[Expr, int] = {u: len(eom.coordinates) + k for k, u in enumerate(eom.speeds)}
    roots = without_unknowns(eom.solved, eom.right_hand_side)
    pairs = [(i, place[root]) for i, root in enumerate(roots[: len(eom.coordinates)]) if root in place]
    paired = {i for i, _ in pairs}
    free = [i for i in range(len(roots)) if i not in paired]
    # one more, so that no array is empty
    arrays = {"pairs": np.array([*pairs, (0, 0)], dtype=float).reshape(-1), "free": np.array([*free, 0], dtype=float)}
    return {**arrays, "pair_count": len(pairs), "free_count": len(free)}


def watching(now: Routines, t: float, y: Array, switches: int = 0, wide: bool = True) -> Given:
    """What tells of events, and of so many switches behind them: their routine, their quantities at the start, their thresholds."""
    events, none = now.eom.events, [0.0] * switches
    room = {"values": aligned((len(events) + switches) * (PARTS + 1) + 3 * PARTS)}
    code = wide_entry(now.events or now.rates, PARTS) if wide else entry(now.events or now.rates)
    if now.events is None:
        empty = ("hw", "seen", "largest", "least", "shares", "pivots")
        return {"watch": code, "events": 0, **{name: np.zeros(1) for name in empty}, **room}
    seen = now.watch(t, y)
    shared = np.array([isinstance(e, SlipEnd) and e.by_share for e in events])
    return {
        "watch": code,
        "events": len(events) + switches,
        "hw": hoisted(now.events, t, y[: now.width], now.parameters(now.events), now.inputs(t, y)),
        "seen": seen,
        "largest": np.nan_to_num(np.abs(seen)),
        "least": np.array([*np.where(shared, 0.0, [e.threshold for e in events]), *none]),
        "shares": np.array([*np.where(shared, SLIPS, 0.0), *none]),
        "pivots": np.array([*(float(isinstance(e, KinematicsEnd)) for e in events), *none]),
        **room,
    }


def after_stages(n: int) -> int:
    """Where in `work` the end of a step stands, for n components."""
    return 4 * STAGES * n + STAGES + n


def polynomial(given: Given, h: float, start: float) -> Callable[[Array], Array]:
    """The state along the step of length h from `start` that a collocation kernel has found, as a function of times (k): k × n."""
    y, lag, work, pairs, free = (given[name] for name in ("y", "lag", "work", "pairs", "free"))
    n = len(y)
    begin, rates = (y + lag).copy(), work[3 * STAGES * n : 4 * STAGES * n].reshape(n, STAGES).copy()
    of, by = pairs.reshape(-1, 2)[: given["pair_count"]].astype(int).T
    others = [*free[: given["free_count"]].astype(int), n - 1]

    def state(times: Array) -> Array:
        theta = (times - start) / h
        once, twice = along(theta)
        rows = np.empty((len(times), n))
        rows[:, others] = begin[others] + h * once @ rates[others].T
        rows[:, of] = begin[of] + h * theta[:, None] * begin[by] + h * h * twice @ rates[by].T
        return rows

    return state


def along(theta: Array) -> tuple[Array, Array]:
    """∫ L_j and ∫∫ L_j (k × 8) from 0 to shares of a step (k)."""
    nodes = gauss(STAGES)
    p = legvander(2 * theta - 1, STAGES + 1)
    double = 2.0 * np.arange(1, STAGES + 1) + 1
    once = np.column_stack([theta, (p[:, 2:] - p[:, :-2]) / (2 * double)])
    twice = np.column_stack([theta**2 / 2, (once[:, 2:] - once[:, :-2]) / (2 * double[: STAGES - 1])])
    rows = (2.0 * np.arange(STAGES) + 1)[:, None] * np.array(nodes.legendre[:STAGES]) * nodes.b
    return once[:, :STAGES] @ rows, twice @ rows
