# SPDX-License-Identifier: BSD-3-Clause
"""Times at which a motion's rates jump, bend or come and go, so that steps end there: read off what of the rates is of time alone.

`clock` lists what that is, for values of parameters to come: `simulate` asks it for the times of its span, and a program in C does the
same. A smooth pulse is at rest for most of a span; neither a step's estimate nor the energy sees what no stage has asked for, so steps
end where it begins, at its top, and where it ends.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, postorder
from kane.expr.ops import ADD, SUB, WHERE
from kane.expr.piecewise import Data, Piecewise, switches, turning_on
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.numeric.arrays import Array
from kane.numeric.polynomials import SHARES, left, passages, zero_of
from kane.numeric.scale import LEAPS, NEAR_TIME

PLACES = 2049
"""At so many times of a span an expression is looked at: a pulse shorter than between two of them is not seen."""
SHARE, MOST = 0.5, 64
"""Share of the span that pulses take at most, and how many there are at most; else it is no pulse, and steps see it."""

Span = tuple[float, float]


def bumps(terms: Sequence[Expr], parameters: Mapping[Expr, Any], span: Span) -> set[float]:
    """The beginnings, tops and ends of the pulses in terms of time and parameters."""
    values = {s: parameters[s] for s in free_symbols(terms) if s in parameters}

    times = np.linspace(*span, PLACES)
    each = evaluate(terms, {**values, time: times}) if terms else []
    return set[float]().union(*(_in_values(times, np.broadcast_to(x, times.shape)) for x in each))


def bumps_of(function: Callable[[Array], Array], span: Span, places: int = PLACES) -> set[float]:
    """The beginnings, tops and ends of the pulses of a function, which is asked at so many places at once."""
    times = np.linspace(*span, places)
    with np.errstate(all="ignore"):
        return _in_values(times, function(times))


def _in_values(times: Array, values: Array) -> set[float]:
    places = len(times)
    if not np.isfinite(values).all():
        return set()
    height = np.abs(values - np.median(values))
    there = height > LEAPS * height.max()
    edges = np.flatnonzero(np.diff(there.astype(int), prepend=0, append=0))
    runs = edges.reshape(-1, 2).tolist()
    if there.mean() > SHARE or len(runs) > MOST:
        return set()
    found = {float(times[k]) for first, end in runs for k in (max(first - 1, 0), min(end, places - 1))}
    return found | {float(times[first + int(np.argmax(height[first:end]))]) for first, end in runs}


def pulses(roots: Iterable[Expr]) -> tuple[Expr, ...]:
    """The largest expressions of time and parameters alone, term by term, without what has corners: those are looked into."""
    roots = tuple(roots)
    known: dict[Expr, bool] = {}
    of_time: dict[Expr, bool] = {}
    largest: dict[Expr, None] = {}
    for node in postorder(roots):
        moves = isinstance(node, Time)
        symbol = isinstance(node, Symbol)
        cornered = node.op is WHERE or turning_on(node) is not None
        known[node] = (
            moves or isinstance(node, Parameter) if symbol else not cornered and all(map(known.get, node.args))
        )
        of_time[node] = moves or (known[node] and any(map(of_time.get, node.args)))
        for part in node.args if not of_time[node] or node.op in (ADD, SUB) else ():
            if of_time[part] and part.op not in (ADD, SUB):
                largest[part] = None
    roots_alone = [r for r in roots if of_time.get(r) and r.op not in (ADD, SUB)]
    return tuple(e for e in dict.fromkeys((*largest, *roots_alone)) if e is not time)


_PARTS = 64
"""In so many parts of the span the passages of what is no line are looked for."""
_MOST = 100_000
"""More corners of a table are left to the steps."""
MANY = 2000
"""More pieces than these, where they join smoothly, are left to the steps."""
ULPS = 4
"""So many numbers beside a breakpoint steps end and begin: the switch surely stands on its side there."""


def up_to(t: float) -> float:
    """The end of a step that leads up to a breakpoint."""
    return t - ULPS * math.ulp(t)


def on_from(t: float) -> float:
    """The beginning of the step that leads on from there, beyond the breakpoint: below a power of two numbers are twice as close."""
    return t + 4 * ULPS * math.ulp(t)


def indistinct_times(t: float, span: Span) -> str:
    """That numbers of that size are too far apart for the times of a span, in words; "" where they are not."""
    apart = math.ulp(t)
    if apart < NEAR_TIME * (span[1] - span[0]):
        return ""
    return f"times there are {apart:.2g} s apart, and steps no shorter than ten times that. Count time from a nearer beginning"


def next_end(breakpoints: Sequence[float], t: float, end: float) -> float:
    """Where steps from t on end: just before the next of the breakpoints, which are in order, else at the `end`."""
    k = bisect_right(breakpoints, t)
    return up_to(breakpoints[k]) if k < len(breakpoints) and breakpoints[k] < end else end


def stretch(breakpoints: Sequence[float], t: float, end: float) -> Span:
    """Where steps from t on begin and end, as `next_end`: beyond a breakpoint before which there is no room for one."""
    until = next_end(breakpoints, t, end)
    while until <= on_from(t) and on_from(until) < end:
        t = on_from(until)
        until = next_end(breakpoints, t, end)
    return t, max(t, until)


class Discontinuity(NamedTuple):
    """What jumps or bends where a `quantity` comes to a level, an end of the pieces of `data`: not at more than `most` of them.

    The quantity is of time and parameters, its `slope` of parameters; None stands for one that changes with time.
    """

    quantity: Expr
    slope: Expr | None
    data: Data
    most: int

    def levels(self, low: float, high: float) -> Array:
        """Those from `low` to `high`."""
        ends = self.data.ends
        if not math.isfinite(high - low):
            return ends[:0]
        if self.data.period is not None and len(ends):
            start, period = self.data.period
            first, last = math.floor((low - start) / period), math.floor((high - start) / period)
            if (last - first + 1) * len(ends) > self.most:
                return ends[:0]
            ends = (ends + period * np.arange(first, last + 1)[:, None]).ravel()
        within = ends[(ends >= low) & (ends <= high)]
        return within if len(within) <= self.most else ends[:0]

    def times(self, parameters: Mapping[Expr, Any], span: Span) -> list[float]:
        """The times of a span at which it comes to them."""
        values: dict[Expr, Any] = {s: parameters[s] for s in free_symbols([self.quantity]) if s in parameters}
        if self.slope is None:
            return self._passed(values, span)
        at, slope = (float(evaluate(e, {**values, time: span[0]})) for e in (self.quantity, self.slope))
        levels = self.levels(*sorted((at, at + slope * (span[1] - span[0]))))
        return [float(t) for t in span[0] + (levels - at) / slope] if slope else []

    def _passed(self, values: Mapping[Expr, Any], span: Span) -> list[float]:
        """The same by bounds along parts of the span."""

        def of(t: Array) -> Array:
            return np.broadcast_to(np.asarray(evaluate(self.quantity, {**values, time: t}), dtype=float), t.shape)

        result = []
        edges = np.linspace(*span, _PARTS + 1)
        for a, b in pairwise(edges.tolist()):
            times = a + (b - a) * np.array(SHARES)
            there = of(times)
            known = there[np.isfinite(there)]
            room = left(there) if known.size == len(there) else 0.0
            levels = self.levels(known.min() - room, known.max() + room) if known.size else known
            for level in levels.tolist():

                def above(t: Any, level: float = level) -> Any:
                    return of(np.asarray(t)) - level

                for s, e, p, q in passages(above, times, there - level):
                    result.append(zero_of(above, s, e, p, q, 4 * math.ulp(e)))
        return result


class Clock(NamedTuple):
    """What turns at times that parameters set, and terms of time in which there may be `pulses`."""

    turning: tuple[Discontinuity, ...] = ()
    pulses: tuple[Expr, ...] = ()

    def breakpoints(self, parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
        """The times within a span at which something turns, or a pulse comes and goes, in order."""
        found = bumps(self.pulses, parameters, span).union(*(one.times(parameters, span) for one in self.turning))
        return tuple(sorted(t for t in found if span[0] < t < span[1]))


def breakpoints(roots: Iterable[Expr], parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
    """The times within the span at which a switch of time and parameters alone turns, or a pulse comes and goes, in order."""
    return clock(roots).breakpoints(parameters, span)


def clock(roots: Iterable[Expr]) -> Clock:
    """What of expressions is of time and parameters alone and turns, or may be a pulse."""
    roots = tuple(roots)
    if time not in free_symbols(roots):
        return Clock()
    quantities = [switch.quantity for switch in switches(roots)]
    corners = [(q.args[0], q.op.data, _MOST) if isinstance(q.op, Piecewise) else (q, _ZERO, _MOST) for q in quantities]
    # smooth as a table may be, some derivative jumps, which a step's estimate would have to see
    joints = [(e.args[0], e.op.data, MANY) for e in postorder(roots) if isinstance(e.op, Piecewise)]
    turning: dict[Any, Discontinuity] = {}
    for quantity, data, most in (*corners, *joints):
        if is_timed(quantity):
            turning.setdefault((quantity, data.ends.tobytes(), data.period), _turning(quantity, data, most))
    return Clock(tuple(turning.values()), pulses(roots))


_ZERO = Data(np.zeros(1), np.zeros(2), np.zeros((2, 1)))
"""What turns at zero."""


def _turning(quantity: Expr, data: Data, most: int) -> Discontinuity:
    slope = tangent(quantity, lambda leaf: ONE if isinstance(leaf, Time) else ZERO)
    return Discontinuity(quantity, None if time in free_symbols([slope]) else slope, data, most)


def known_beforehand(roots: Iterable[Expr]) -> dict[Expr, bool]:
    """Whether expressions, and what they are made of, parts first, are of time and parameters alone."""
    known: dict[Expr, bool] = {}
    for e in postorder(roots):
        known[e] = isinstance(e, Time | Parameter) if isinstance(e, Symbol) else all(known[a] for a in e.args)
    return known


def is_timed(quantity: Expr) -> bool:
    """Whether it is of time and parameters alone, so that it turns at times that are known beforehand, at which steps end."""
    return all(isinstance(s, Time | Parameter) for s in free_symbols([quantity]))
