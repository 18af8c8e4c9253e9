# SPDX-License-Identifier: BSD-3-Clause
"""Smooth pulses of time: what is at rest for most of a span, and comes and goes between, which a long step would lead across.

Neither a step's estimate nor the energy sees what no stage has asked for. So steps end where a pulse begins, at its top, and where
it ends.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr, postorder
from kane.expr.ops import ADD, SUB
from kane.expr.switches import switches
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.numeric.arrays import Array

_PLACES = 2049
"""At so many times of a span an expression is looked at: a pulse shorter than between two of them is not seen."""
_RISEN = 1e-6
"""Share of its height from which on a pulse is there."""
_SHARE, _MOST = 0.5, 64
"""Share of the span that pulses take at most, and how many there are at most; else it is no pulse, and steps see it."""

Span = tuple[float, float]


def bumps(roots: Iterable[Expr], parameters: Mapping[Expr, Any], span: Span) -> set[float]:
    """The beginnings, tops and ends of the pulses in expressions."""
    found = set[float]()
    for term in _terms(roots, parameters):
        values: Mapping[Expr, Any] = {s: parameters[s] for s in free_symbols([term]) if s in parameters}

        def of(t: Array, term: Expr = term, values: Mapping[Expr, Any] = values) -> Array:
            return np.asarray(np.broadcast_to(np.asarray(evaluate(term, {**values, time: t}), dtype=float), t.shape))

        found |= bumps_of(of, span)
    return found


def bumps_of(function: Callable[[Array], Array], span: Span, places: int = _PLACES) -> set[float]:
    """The beginnings, tops and ends of the pulses of a function, which is asked at so many places at once."""
    times = np.linspace(*span, places)
    with np.errstate(all="ignore"):
        values = function(times)
    if not np.isfinite(values).all():
        return set()
    height = np.abs(values - np.median(values))
    there = height > _RISEN * height.max()
    edges = np.flatnonzero(np.diff(there.astype(int), prepend=0, append=0))
    runs = edges.reshape(-1, 2).tolist()
    if there.mean() > _SHARE or len(runs) > _MOST:
        return set()
    found = {float(times[k]) for first, end in runs for k in (max(first - 1, 0), min(end, places - 1))}
    return found | {float(times[first + int(np.argmax(height[first:end]))]) for first, end in runs}


def _terms(roots: Iterable[Expr], parameters: Mapping[Expr, Any]) -> list[Expr]:
    """The largest expressions of time and parameters alone, term by term, that have no corners."""
    known: dict[Expr, bool] = {}
    of_time: dict[Expr, bool] = {}
    largest: dict[Expr, None] = {}
    for node in postorder(tuple(roots)):
        moves = isinstance(node, Time)
        symbol = isinstance(node, Symbol)
        known[node] = (
            moves or (isinstance(node, Parameter) and node in parameters) if symbol else all(map(known.get, node.args))
        )
        of_time[node] = moves or (known[node] and any(map(of_time.get, node.args)))
        for part in node.args if not of_time[node] or node.op in (ADD, SUB) else ():
            if of_time[part] and part.op not in (ADD, SUB):
                largest[part] = None
    roots_alone = [r for r in roots if of_time.get(r) and r.op not in (ADD, SUB)]
    return [e for e in (*largest, *roots_alone) if e is not time and not switches([e])]
