# SPDX-License-Identifier: BSD-3-Clause
"""The check that prescribed motions are smooth: functions of time must not jump, and given derivatives must be theirs.

The change of a function is compared with the integral of its derivative by Simpson's rule, in all parts of the span at once. What the
rounding error of an expression explains is no jump: over a short span a ramp is a difference of terms that cancel.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError, cut
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.piecewise import Piecewise
from kane.expr.symbols import Time, time
from kane.model.declarations import geometry
from kane.motion.inputs.breakpoints import by_time, known_beforehand, on_from, up_to
from kane.motion.inputs.expressions import Formula, along
from kane.numeric.arrays import Array
from kane.numeric.scale import EPS, LEAPS
from kane.program.from_expressions import Task, build_program
from kane.program.passes.optimize import rounding
from kane.program.program import Port

_PIECEWISE = ("where", "sign", "abs", "min", "max")
_PARTS = 128
_BISECTIONS = 40
_OWN = 0.01
"""Share of its range by which a function may differ from the integral of its derivative over the span."""
_SAFE = 4.0
"""Factor of the bound on the rounding error, which is of first order."""


def at(f: Any, times: Array) -> Array:
    """The values (m) of an input that does not depend on the state at times (m)."""
    return along(f, times, np.zeros((len(times), 0)))


def rounding_of(f: Any) -> Callable[[float], float]:
    """A bound on the rounding error of an input's value, as a function of time; zero if it is a function of the user."""
    if not isinstance(f, Formula) or f.of_state:
        return lambda t: 0.0
    own = [s for s in free_symbols([f.expr]) if not isinstance(s, Time)]
    code = build_program("function", [Port("t", (time, *own))], [Task("f", [f.expr], (1,), ["f"])])
    numbers = [float(f.values[s]) for s in own]

    def bound(t: float) -> float:
        ((_, error),) = rounding(code, (t, *numbers))
        return error * EPS / 2 if np.isfinite(error) else 0.0

    return bound


def check_smooth(what: str, f: Any, slope: Any, span: tuple[float, float]) -> None:
    """Check that `f` has no jump over the span and `slope` is its derivative; raises a SimulationError otherwise."""
    places = grid(span)
    derived = isinstance(f, Formula) and isinstance(slope, Formula) and f.smooth and f.derivative().expr is slope.expr
    _check(lambda: what, (f, at(f, places[::2])), (slope, at(slope, places)), places, derived)


def grid(span: tuple[float, float]) -> Array:
    """The ends and midpoints of the parts of a span, just inside it, so that a switch at its end counts by its inner side."""
    return np.linspace(on_from(span[0]), up_to(span[1]), 2 * _PARTS + 1)


def _check(
    what: Callable[[], str], f: tuple[Any, Array], slope: tuple[Any, Array], places: Array, derived: bool = False
) -> None:
    """`check_smooth` of inputs with their values: of f at the ends of parts, of the slope also at the midpoints.

    A slope that is `derived` from a smooth expression is right even if it oscillates too fast for the integrals.
    """
    (below, values), (above, slopes) = f, slope
    times, length = places[::2], float(places[-1] - places[0])
    finite = np.isfinite(values) & np.isfinite(slopes[::2])
    if not finite.all():
        raise SimulationError(
            f"Expected the {what()} finite over the time span, got NaN or infinity at t = {times[~finite][0]:.6g}."
        )
    size = float(np.ptp(values) + np.ptp(slopes[::2]) * length + np.abs(values).max() * 1e-9)
    gaps = _gaps(values, slopes, np.diff(times))
    if not gaps.max() > LEAPS * size:
        return
    noise = _noise(below, above)
    gaps = gaps - np.array([noise(a, b) for a, b in pairwise(times.tolist())])
    k = int(np.argmax(gaps))
    if not gaps[k] > LEAPS * size:
        return
    a, b = _closer(below, above, float(times[k]), float(times[k + 1]))
    if _gap(below, above, a, b) > LEAPS * size + noise(a, b):
        jump = abs(float(np.diff(at(below, np.array([a, b])))[0]))
        raise SimulationError(
            f"Expected the {what()} without jumps, as it prescribes a motion, got one of {jump:.3g} at "
            f"t = {b:.6g}: it would need an infinite force. Join the two values over a short time."
        )
    if not derived and np.maximum(gaps, 0).sum() > _OWN * size:
        raise SimulationError(
            f"Expected the given derivative of the {what()} to match it, got one whose integral differs from its change by "
            f"{gaps[k]:.3g} between t = {times[k]:.6g} and {times[k + 1]:.6g}."
        )


def _gaps(values: Array, slopes: Array, lengths: Array) -> Array:
    """The absolute difference between the change of the function and the integral of its derivative in each part."""
    means = (slopes[:-1:2] + 4 * slopes[1::2] + slopes[2::2]) / 6
    whole: Array = np.abs(np.diff(values) - lengths * means)
    return whole


def _gap(f: Any, slope: Any, a: float, b: float) -> float:
    places = np.array([a, a + (b - a) / 2, b])
    return float(_gaps(at(f, places[::2]), at(slope, places), np.array([b - a]))[0])


def _noise(f: Any, slope: Any) -> Callable[[float, float], float]:
    """A bound on the rounding error of the difference in a part, from its ends."""
    own, of_slope = rounding_of(f), rounding_of(slope)
    return lambda a, b: _SAFE * sum(own(t) + (b - a) * of_slope(t) for t in (a, b))


def _closer(f: Any, slope: Any, a: float, b: float) -> tuple[float, float]:
    """The tiny interval in which the difference is largest, by bisection."""
    for _ in range(_BISECTIONS):
        middle = (a + b) / 2
        a, b = (a, middle) if _gap(f, slope, a, middle) >= _gap(f, slope, middle, b) else (middle, b)
    return a, b


def check_prescribed(eom: Equations, parameters: Mapping[Expr, Any], span: tuple[float, float]) -> None:
    """Check that piecewise functions of time in positions, orientations and configuration constraints are C¹."""
    roots = _prescribing(eom)
    for node, error in _torn(pieces_prescribed(eom), parameters, span):
        # the expression that contains it may be smooth
        if any(True for _ in _torn(_around(node, roots), parameters, span)):
            raise error


def pieces_prescribed(eom: Equations) -> list[Expr]:
    """The piecewise functions of time and parameters alone in positions, orientations and configuration constraints."""
    return _pieces(_prescribing(eom))


def _prescribing(eom: Equations) -> tuple[Expr, ...]:
    system = eom.system
    return (*geometry(system.frames, system.points), *(c.expr for c in system.holonomic))


def _torn(
    pieces: Sequence[Expr], parameters: Mapping[Expr, Any], span: tuple[float, float]
) -> Iterator[tuple[Expr, SimulationError]]:
    """The pieces that are not C¹, each with the error that says so."""
    if not pieces:
        return
    slope = partial(tangent, seeds=by_time, memo={})
    levels = [(node, slope(node), slope(slope(node))) for node in pieces]
    flat = [e for row in levels for e in row]
    known: dict[Expr, Any] = {s: parameters[s] for s in free_symbols(flat) if s in parameters}
    places = grid(span)
    values = iter(evaluate(flat, {**known, time: places}))  # together: common subexpressions are evaluated once
    for row in levels:
        curves = [(Formula(e, known), next(values)) for e in row]
        try:
            for what, (below, there), above in zip(
                ("prescribed", "velocity of the prescribed"), curves, curves[1:], strict=False
            ):
                _check(partial("{} {}".format, what, cut(row[0], 60)), (below, there[::2]), above, places)
        except SimulationError as error:
            yield row[0], error


def _pieces(roots: Iterable[Expr]) -> list[Expr]:
    """The piecewise functions of time and parameters alone."""
    known = known_beforehand(roots)
    moving: dict[Expr, bool] = {}
    for node in known:
        moving[node] = isinstance(node, Time) or any(moving[a] for a in node.args)
    bent = (e for e in known if e.op.name in _PIECEWISE or (isinstance(e.op, Piecewise) and e.op.sides is not None))
    return [node for node in bent if known[node] and moving[node]]


def _around(node: Expr, roots: Sequence[Expr]) -> list[Expr]:
    """The largest functions of time and parameters alone that contain a node: max(0, t)² is smooth, though max(0, t) bends."""
    known = known_beforehand(roots)
    holds: dict[Expr, bool] = {}
    largest: dict[Expr, None] = {}
    for e in known:
        holds[e] = e is node or any(holds[a] for a in e.args)
        largest.update(dict.fromkeys(a for a in e.args if holds[a] and known[a] and not known[e]))
    return list(largest | dict.fromkeys(root for root in roots if holds[root] and known[root]))
