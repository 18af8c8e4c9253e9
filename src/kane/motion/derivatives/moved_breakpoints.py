# SPDX-License-Identifier: BSD-3-Clause
"""Breakpoints that parameters move: where c(t, p) comes to a level, at which rates jump, δτ = −(∂c/∂p δp)/(∂c/∂t).

There the state changes by δx⁺ = δx⁻ + (f⁻ − f⁺) δτ, as at an event that sets nothing; ∫ L dt by (L⁻ − L⁺) δτ.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane.equations.equations import Equations
from kane.expr.differentiation import weighted
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, Expr
from kane.expr.symbols import Parameter, time
from kane.motion.inputs.breakpoints import Clock, clock
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import timed
from kane.motion.solution.phases import Phase
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array


class MovedBreakpoint(NamedTuple):
    """When something turns, and δτ/δp (k) of that time."""

    t: float
    slopes: Array


def clocks(eom: Equations, phase: Phase, more: Iterable[Expr] = ()) -> list[tuple[Clock, dict[Expr, Any]]]:
    """What turns at times in a phase, of the rates, its inputs and `more`, with the values of parameters there."""
    drives = [f for f in phase.inputs.values() if isinstance(f, Formula)]
    known = dict[Expr, Any](phase.parameters)
    for f in drives:
        known |= {**f.values, **f.gains}
    return [(eom.numeric().value(timed), known), *((clock([e]), known) for e in (*(f.whole for f in drives), *more))]


def moves_breakpoints(eom: Equations, laws: Iterable[Expr], by: Sequence[Expr]) -> bool:
    """Whether some of `by` move times at which rates or laws of inputs turn."""
    own = set(by)
    every = (eom.numeric().value(timed), *(clock([e]) for e in laws))
    return any(not own.isdisjoint(free_symbols([one.quantity])) for found in every for one in found.turning)


def moved_breakpoints(motion: Solution, by: Sequence[Parameter], more: Iterable[Expr] = ()) -> list[MovedBreakpoint]:
    """Those within a motion, none where parameters move none of them."""
    span, own = (float(motion.t[0]), float(motion.t[-1])), set(by)
    every = [(one, known) for found, known in clocks(motion.equations, motion.phases[0], more) for one in found.turning]
    if all(own.isdisjoint(free_symbols([one.quantity])) for one, _ in every):
        return []
    result = []
    for one, known in every:
        slopes = weighted([one.quantity], [ONE], (time, *by))
        values: dict[Expr, Any] = {s: known[s] for s in free_symbols([one.quantity]) if s in known}
        for t in one.times(values, span):
            by_time, *by_p = map(float, evaluate(slopes, {**values, time: t}))
            with np.errstate(divide="ignore", invalid="ignore"):
                result.append(MovedBreakpoint(t, -np.array(by_p) / by_time))
    return result
