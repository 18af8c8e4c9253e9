# SPDX-License-Identifier: BSD-3-Clause
"""Breakpoints in time that depend on parameters: rates jump where c(t, p) reaches a level, and δτ = −(∂c/∂p δp)/(∂c/∂t).

There the sensitivity changes by δx⁺ = δx⁻ + (f⁻ − f⁺) δτ, as at an event without a reset, and ∫ L dt by (L⁻ − L⁺) δτ. Where several
breakpoints coincide, a derivative exists if all at which something jumps have the same δτ.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane.equations.equations import Equations
from kane.expr.differentiation import weighted
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, Expr, constant
from kane.expr.piecewise import Piecewise, on_sides, switches
from kane.expr.symbols import Parameter, time
from kane.expr.visit import substituted
from kane.motion.derivatives.parameter_slopes import evaluated
from kane.motion.derivatives.pulling import Laws
from kane.motion.inputs.breakpoints import Clock, Span, clock
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, timed
from kane.motion.solution.phases import Phase
from kane.numeric.arrays import Array


class MovedBreakpoint(NamedTuple):
    """The time t at which a quantity reaches its level, δτ/δp (k) of that time, and the quantity."""

    t: float
    slopes: Array
    quantity: Expr


def clocks(eom: Equations, phase: Phase, more: Iterable[Expr] = ()) -> list[tuple[Clock, dict[Expr, Any]]]:
    """The clocks of a phase (switching surfaces in time alone) of rates, inputs and `more`, each with the parameter values."""
    drives = [f for f in phase.inputs.values() if isinstance(f, Formula)]
    known = dict[Expr, Any](phase.parameters)
    for f in drives:
        known |= f.values
    numeric = eom.numeric()
    laws = [numeric.value(_clock, e) for e in (*(f.expr for f in drives), *more)]
    return [(found, known) for found in (numeric.value(timed), *laws)]


def _clock(_: Equations, e: Expr) -> Clock:
    return clock([e])


def moves_breakpoints(eom: Equations, laws: Iterable[Expr], by: Sequence[Expr]) -> bool:
    """Whether breakpoints of the rates or of the laws of inputs depend on any of `by`."""
    own = set(by)
    every = (eom.numeric().value(timed), *(clock([e]) for e in laws))
    return any(not own.isdisjoint(free_symbols([one.quantity])) for found in every for one in found.turning)


def moved_breakpoints(
    eom: Equations, phase: Phase, span: Span, by: Sequence[Parameter], more: Iterable[Expr] = ()
) -> list[MovedBreakpoint]:
    """The breakpoints of a phase within a span; the slopes of those that do not depend on parameters are zero."""
    own, result = set(by), list[MovedBreakpoint]()
    for one, known in ((one, known) for found, known in clocks(eom, phase, more) for one in found.turning):
        symbols = free_symbols([one.quantity])
        values: dict[Expr, Any] = {s: known[s] for s in symbols if s in known}
        times = np.array(one.times(values, span))
        slopes = np.zeros((len(times), len(by)))
        if len(times) and not own.isdisjoint(symbols):
            found = evaluate(weighted([one.quantity], [ONE], (time, *by)), {**values, time: times})
            by_time, *by_p = (np.broadcast_to(e, times.shape) for e in found)
            with np.errstate(divide="ignore", invalid="ignore"):
                slopes = -np.array(by_p).T / np.array(by_time)[:, None]
        result += [MovedBreakpoint(t, row, one.quantity) for t, row in zip(times.tolist(), slopes, strict=True)]
    return result


def _on_sides(eom: Equations, quantity: Expr, laws: Laws, more: tuple[Expr, ...]) -> list[Expr]:
    """Rates and `more` with a quantity below its level, then with it above."""
    roots = laws.read(eom, [*eom.right_hand_side, *more])
    side = Parameter.declare("side")
    own = {s.quantity: side for s in switches(roots) if _turning(s.quantity) is quantity}
    memo: dict[Expr, Expr] = {}
    sided = [on_sides(e, own, memo) for e in roots]
    return [substituted(e, {side: constant(sign)}) for sign in (-1, 1) for e in sided]


def _turning(quantity: Expr) -> Expr:
    """The quantity whose level is crossed: for a piecewise function (table), its argument."""
    return quantity.args[0] if isinstance(quantity.op, Piecewise) else quantity


def own_jump(now: Routines, quantity: Expr, more: Iterable[Expr], at: tuple[Array, Array]) -> Array:
    """|difference| of rates and `more` (n + … × m) between both sides of a quantity's level, at times (m) and states (m × n)."""
    laws = Laws(dict(zip(now.eom.inputs, now.drives, strict=True)))
    roots = now.eom.numeric(now.settings).value(_on_sides, quantity, laws, tuple(more))
    below, above = np.split(evaluated(roots, now, *at), 2)
    return np.abs(above - below)
