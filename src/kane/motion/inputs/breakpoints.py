# SPDX-License-Identifier: BSD-3-Clause
"""Breakpoints, at which integration steps end: times at which rates jump or bend, and at which pulses begin, peak and end.

They follow from the parts of the rates that depend on time alone. `clock` lists these for parameter values to come: `simulate`
evaluates them for its span, and so does a generated program in C. A smooth pulse is at rest for most of a span; neither the error
estimate nor the energy shows a pulse that no stage samples, so steps end where it begins, at its peak, and where it ends.
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
from kane.numeric.arrays import Array, Mask
from kane.numeric.polynomials import SHARES, left, passages, zero_of
from kane.numeric.scale import LEAPS, NEAR_TIME

PLACES = 2049
"""Number of times in a span at which an expression is evaluated: a pulse between two of them is not detected."""
SHARE, MOST = 0.5, 64
"""Largest share of the span that pulses take, and their largest number; otherwise steps resolve them without breakpoints."""

Span = tuple[float, float]


def bumps(terms: Sequence[Expr], parameters: Mapping[Expr, Any], span: Span) -> set[float]:
    """The times at which pulses in terms of time and parameters begin, peak and end."""
    if not terms:
        return set()
    values = {s: parameters[s] for s in free_symbols(terms) if s in parameters}
    times = np.linspace(*span, PLACES)
    each = evaluate(terms, {**values, time: times})
    return set[float]().union(*(_in_values(times, np.broadcast_to(x, times.shape)) for x in each))


def bumps_of(function: Callable[[Array], Array], span: Span, places: int = PLACES) -> set[float]:
    """The times at which pulses of a function begin, peak and end; it is called with `places` times at once."""
    times = np.linspace(*span, places)
    with np.errstate(all="ignore"):
        return _in_values(times, function(times))


def may_have_bumps(terms: Sequence[Expr], parameters: Mapping[Expr, Array], count: int, span: Span) -> Mask:
    """Whether there may be `bumps` for each of `count` sets of parameters, which are columns."""
    own, found = [s for s in free_symbols(terms) if s in parameters], np.zeros(count, dtype=bool)
    times = np.linspace(*span, PLACES)
    for begin in range(0, count, _ROWS) if terms else ():
        rows = slice(begin, begin + _ROWS)
        columns: dict[Expr, Any] = {s: np.broadcast_to(parameters[s], count)[rows, None] for s in own}
        for values in evaluate(terms, {**columns, time: times}):
            there = _raised(np.broadcast_to(values, (len(found[rows]), PLACES)))[1]
            found[rows] |= there.any(axis=1) & (there.mean(axis=1) <= SHARE)
    return found


_ROWS = 64
"""Number of sets of parameters that are examined at once."""


def _raised(values: Array) -> tuple[Array, Mask]:
    """The distances from the median (… × n), and whether they are substantial."""
    height = np.abs(values - np.median(values, axis=-1, keepdims=True))
    return height, height > LEAPS * height.max(axis=-1, keepdims=True)


def _in_values(times: Array, values: Array) -> set[float]:
    places = len(times)
    if not np.isfinite(values).all():
        return set()
    height, there = _raised(values)
    edges = np.flatnonzero(np.diff(there.astype(int), prepend=0, append=0))
    runs = edges.reshape(-1, 2).tolist()
    if there.mean() > SHARE or len(runs) > MOST:
        return set()
    found = {float(times[k]) for first, end in runs for k in (max(first - 1, 0), min(end, places - 1))}
    return found | {float(times[first + int(np.argmax(height[first:end]))]) for first, end in runs}


def pulses(roots: Iterable[Expr]) -> tuple[Expr, ...]:
    """The largest subexpressions of time and parameters alone, term by term; for those with corners, the ones in their arguments."""
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
"""Number of parts of the span in which crossings of a quantity that is not linear in time are located."""
_MOST = 100_000
"""Number of corners of a table beyond which they are no breakpoints."""
MANY = 2000
"""The same for pieces that join smoothly."""
ULPS = 4
"""Spacings of numbers from a breakpoint to the ends of the steps beside it, so that each step is on one side of the switch."""


def up_to(t: float) -> float:
    """The end of the step before a breakpoint."""
    return t - ULPS * math.ulp(t)


def on_from(t: float) -> float:
    """The beginning of the step after a breakpoint, farther off than the end before it: spacings change at powers of two."""
    return t + 4 * ULPS * math.ulp(t)


def indistinct_times(t: float, span: Span) -> str:
    """A message that the spacing of numbers near t is too coarse for the times of a span; "" if it is not."""
    apart = math.ulp(t)
    if apart < NEAR_TIME * (span[1] - span[0]):
        return ""
    return (
        f"adjacent times there are {apart:.2g} s apart, and steps at least ten times as long. Use an origin of time closer to "
        "the motion"
    )


def next_end(breakpoints: Sequence[float], t: float, end: float) -> float:
    """The end of steps from t on: just before the next of the sorted breakpoints, else the `end`."""
    k = bisect_right(breakpoints, t)
    return up_to(breakpoints[k]) if k < len(breakpoints) and breakpoints[k] < end else end


def stretch(breakpoints: Sequence[float], t: float, end: float) -> Span:
    """The beginning and end of steps from t on; skips breakpoints that leave no room for a step before them."""
    until = next_end(breakpoints, t, end)
    while until <= on_from(t) and on_from(until) < end:
        t = on_from(until)
        until = next_end(breakpoints, t, end)
    return t, max(t, until)


class Discontinuity(NamedTuple):
    """A jump or bend where a `quantity` reaches an end of a piece of `data`; none is reported if there are more than `most`.

    `quantity` depends on time and parameters; its time derivative `slope` on parameters, or is None if it changes with time.
    """

    quantity: Expr
    slope: Expr | None
    data: Data
    most: int

    def levels(self, low: float, high: float) -> Array:
        """The ends of pieces from `low` to `high`."""
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
        """The times in a span at which the quantity reaches an end of a piece."""
        values: dict[Expr, Any] = {s: parameters[s] for s in free_symbols([self.quantity]) if s in parameters}
        if self.slope is None:
            return self._passed(values, span)
        at, slope = (float(evaluate(e, {**values, time: span[0]})) for e in (self.quantity, self.slope))
        levels = self.levels(*sorted((at, at + slope * (span[1] - span[0]))))
        return [float(t) for t in span[0] + (levels - at) / slope] if slope else []

    def _passed(self, values: Mapping[Expr, Any], span: Span) -> list[float]:
        """The same for a quantity that is not linear in time, by bounds along parts of the span."""

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
    """The discontinuities at times that depend on parameters alone, and the terms of time that may contain `pulses`."""

    turning: tuple[Discontinuity, ...] = ()
    pulses: tuple[Expr, ...] = ()

    def breakpoints(self, parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
        """The times in a span of discontinuities and of beginnings, peaks and ends of pulses, sorted."""
        found = bumps(self.pulses, parameters, span).union(*(one.times(parameters, span) for one in self.turning))
        return tuple(sorted(t for t in found if span[0] < t < span[1]))


def breakpoints(roots: Iterable[Expr], parameters: Mapping[Expr, Any], span: Span) -> tuple[float, ...]:
    """The times in the span at which a switch of time and parameters alone changes, or a pulse begins, peaks or ends, sorted."""
    return clock(roots).breakpoints(parameters, span)


def clock(roots: Iterable[Expr]) -> Clock:
    """The discontinuities and possible pulses of those parts of expressions that depend on time and parameters alone."""
    roots = tuple(roots)
    if time not in free_symbols(roots):
        return Clock()
    quantities = [switch.quantity for switch in switches(roots)]
    corners = [(q.args[0], q.op.data, _MOST) if isinstance(q.op, Piecewise) else (q, _ZERO, _MOST) for q in quantities]
    # however smooth a table is, some derivative jumps, which the error estimate would have to detect
    joints = [(e.args[0], e.op.data, MANY) for e in postorder(roots) if isinstance(e.op, Piecewise)]
    turning: dict[Any, Discontinuity] = {}
    for quantity, data, most in (*corners, *joints):
        if is_timed(quantity):
            turning.setdefault((quantity, data.ends.tobytes(), data.period), _turning(quantity, data, most))
    return Clock(tuple(turning.values()), pulses(roots))


_ZERO = Data(np.zeros(1), np.zeros(2), np.zeros((2, 1)))
"""The data of a switch at zero."""


def by_time(leaf: Expr) -> Expr:
    """The derivative of a symbol with respect to time, on which no other symbol depends."""
    return ONE if isinstance(leaf, Time) else ZERO


def _turning(quantity: Expr, data: Data, most: int) -> Discontinuity:
    slope = tangent(quantity, by_time)
    return Discontinuity(quantity, None if time in free_symbols([slope]) else slope, data, most)


def known_beforehand(roots: Iterable[Expr]) -> dict[Expr, bool]:
    """For each node of expressions, arguments first, whether it depends on time and parameters alone."""
    known: dict[Expr, bool] = {}
    for e in postorder(roots):
        known[e] = isinstance(e, Time | Parameter) if isinstance(e, Symbol) else all(known[a] for a in e.args)
    return known


def is_timed(quantity: Expr) -> bool:
    """Whether a quantity depends on time and parameters alone, so that its switching times, where steps end, are known beforehand."""
    return all(isinstance(s, Time | Parameter) for s in free_symbols([quantity]))
