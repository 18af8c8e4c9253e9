# SPDX-License-Identifier: BSD-3-Clause
"""Times at which a motion's rates jump or bend, so that steps end there: read off switches and tables of time and parameters alone."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.expr.diff import tangent
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, postorder
from kane.expr.piecewise import Data, Piecewise
from kane.expr.switches import switches
from kane.expr.symbols import Parameter, Time, time
from kane.motion.bounds import SHARES, passages
from kane.motion.bumps import bumps
from kane.numeric.arrays import Array

_PARTS = 64
"""In so many parts of the span the passages of what is no line are looked for."""
_MOST = 100_000
"""More corners of a table that goes round are left to the steps."""
MANY = 2000
"""More pieces than these, where they join smoothly, are left to the steps."""
_ULPS = 4
"""So many numbers beside a breakpoint steps end and begin: the switch surely stands on its side there."""

_COARSE = 1e-9
"""Share of a span from which on the distance of two times may be what is in the way of a step."""

Span = tuple[float, float]


def up_to(t: float) -> float:
    """The end of a step that leads up to a breakpoint."""
    return t - _ULPS * math.ulp(t)


def on_from(t: float) -> float:
    """The beginning of the step that leads on from there, beyond the breakpoint: below a power of two numbers are twice as close."""
    return t + 4 * _ULPS * math.ulp(t)


def told_apart(t: float, span: Span) -> str:
    """That numbers of that size are too far apart for the times of a span, in words; "" where they are not."""
    apart = math.ulp(t)
    if apart < _COARSE * (span[1] - span[0]):
        return ""
    return f"times there are {apart:.2g} s apart, and steps no shorter than ten times that. Count time from a nearer beginning"


def next_end(breakpoints: Sequence[float], t: float, end: float) -> float:
    """Where steps from t on end: just before the next of the breakpoints, which are in order, else at the `end`."""
    k = bisect_right(breakpoints, t)
    return up_to(breakpoints[k]) if k < len(breakpoints) and breakpoints[k] < end else end


def in_loads(eom: Equations, parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
    """The breakpoints of the loads."""
    loads = eom.solved.regular.declared_loads
    roots = [x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars()]
    return breakpoints(roots, parameters, span)


def breakpoints(roots: Iterable[Expr], parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
    """The times within the span at which a switch of time and parameters alone turns, or a pulse comes and goes, in order."""
    roots = tuple(roots)
    found = bumps(roots, parameters, span)
    for switch in switches(roots):
        symbols = free_symbols([switch.quantity])
        if all(isinstance(s, Time | Parameter) for s in symbols):
            found.update(_zeros(switch.quantity, {s: parameters[s] for s in symbols if s in parameters}, span))
    for node in postorder(roots):
        if isinstance(node.op, Piecewise) and all(isinstance(s, Time | Parameter) for s in free_symbols([node])):
            knots = _knots(node, parameters, span)
            found.update(knots if len(knots) <= MANY else ())
    return tuple(sorted(t for t in found if span[0] < t < span[1]))


def _knots(node: Expr, parameters: Mapping[Expr, Any], span: Span) -> list[float]:
    """Where the pieces of a table end: smooth as it may be, some derivative jumps, which a step's estimate would have to see."""
    line = _line(node.args[0], {s: parameters[s] for s in free_symbols([node]) if s in parameters}, span)
    return [] if line is None else _met(node.op.data, *line, span)  # type: ignore[attr-defined]


def _zeros(quantity: Expr, values: Mapping[Expr, Any], span: Span) -> list[float]:
    """Where a quantity passes zero."""
    op = quantity.op
    if isinstance(op, Piecewise):
        line = _line(quantity.args[0], values, span)
        return [] if line is None else _met(op.data, *line, span)
    line = _line(quantity, values, span)
    if line is not None:
        at, slope = line
        return [span[0] - at / slope] if slope else []
    return _passed(quantity, values, span)


def _line(e: Expr, values: Mapping[Expr, Any], span: Span) -> tuple[float, float] | None:
    """The value at the beginning and the slope of what is affine in time; None of what is not."""
    slope = tangent(e, lambda leaf: ONE if isinstance(leaf, Time) else ZERO)
    if time in free_symbols([slope]):
        return None
    return float(evaluate(e, {**values, time: span[0]})), float(evaluate(slope, values))


def _met(data: Data, at: float, slope: float, span: Span) -> list[float]:
    """The times at which at + slope (t − t₀) comes to the ends of pieces that the quantity has its zeros at."""
    if not slope:
        return []
    reached = np.array([at, at + slope * (span[1] - span[0])])
    corners = data.ends
    if data.period is not None:
        start, period = data.period
        first, last = np.floor((np.sort(reached) - start) / period)
        if (last - first + 1) * len(corners) > _MOST:
            return []
        corners = (corners + period * np.arange(first, last + 1)[:, None]).ravel()
    return [float(t) for t in span[0] + (corners - at) / slope]


def _passed(quantity: Expr, values: Mapping[Expr, Any], span: Span) -> list[float]:
    """The times at which a quantity changes its sign, by bounds along parts of the span."""
    from scipy.optimize import brentq

    def of(t: Array) -> Array:
        return np.broadcast_to(np.asarray(evaluate(quantity, {**values, time: t}), dtype=float), t.shape)

    found = []
    edges = np.linspace(*span, _PARTS + 1)
    for a, b in pairwise(edges.tolist()):
        times = a + (b - a) * np.array(SHARES)
        for s, e, p, q in passages(of, times, of(times)):
            inside = p * q < 0
            found.append(
                float(brentq(lambda t: float(of(np.array([t]))[0]), s, e, xtol=4 * math.ulp(e))) if inside else e
            )
    return found
