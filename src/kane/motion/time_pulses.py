# SPDX-License-Identifier: BSD-3-Clause
"""Smooth pulses of time: what is at rest for most of a span, and comes and goes between, which a long step would lead across.

Neither a step's estimate nor the energy sees what no stage has asked for. So steps end where a pulse begins, at its top, and where
it ends.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, postorder
from kane.expr.ops import ADD, SUB, WHERE
from kane.expr.switching import turning_on
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.numeric.arrays import Array
from kane.numeric.scale import LEAPS

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
