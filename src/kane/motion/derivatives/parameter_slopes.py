# SPDX-License-Identifier: BSD-3-Clause
"""∂f/∂p along a motion, for parameters of the equations and of inputs that are expressions: f(x, t, p, r(x, t, p))."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.dynamics.slopes import slopes
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Rate, Symbol, time
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, only
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Shaped

Slopes = Callable[[Array, Array], Array] | None
"""A derivative of f (m × n × k) at times (m) and states (m × n); None if it is identically zero.

Derived and compiled at the first call, because the backward integration rarely needs it.
"""


def symbol_slopes(eom: Equations, *by: Symbol) -> Bundle[Array]:
    """∂(q̇, u̇, ȧ)/∂symbols, with respect to parameters or inputs."""
    return Bundle(
        "by_parameters",
        ports(eom.derived),
        only,
        {"x": Shaped((len(eom.state), len(by)), slopes(eom.solved, by).entries)},
    )


def law_slopes(now: Routines, by: Sequence[Symbol]) -> dict[Symbol, list[Expr]]:
    """∂r/∂symbols: one row for each input whose expression depends on some of them."""
    laws = {s: f.expr for s, f in zip(now.eom.inputs, now.drives, strict=True) if isinstance(f, Formula)}
    turned = {s: [tangent(e, {p: ONE}) for p in by] for s, e in laws.items()}
    return {s: row for s, row in turned.items() if any(e is not ZERO for e in row)}


def evaluated(exprs: Sequence[Expr], now: Routines, t: Array, x: Array) -> Array:
    """Values (expressions × m) at times (m) and states (m × n); parameters of inputs are substituted."""
    values: dict[Expr, Any] = {s: v for f in now.drives if isinstance(f, Formula) for s, v in f.values.items()}
    values |= now.values(t, x)
    return np.array([np.broadcast_to(v, t.shape) for v in evaluate(exprs, values)]).reshape(len(exprs), len(t))


def input_slopes(now: Routines, by: Sequence[Symbol]) -> Slopes:
    """∂f/∂r ∂r/∂symbols (m × n × k) of inputs that are expressions, at times (m) and states (m × n); None if identically zero."""
    turned = law_slopes(now, by)
    if not turned:
        return None

    def along(t: Array, x: Array) -> Array:
        of_inputs = now.routine(symbol_slopes, *turned)(t, x, now.p, now.inputs(t, x))
        slopes = [evaluated(row, now, t, x) for row in turned.values()]
        return np.asarray(of_inputs @ np.array(slopes).transpose(2, 0, 1))

    return along


def input_changes(now: Routines, t: float, x: Array, by: Sequence[Symbol]) -> Array:
    """∂r/∂(t, symbols) (inputs × 1 + k) at a state; where the equations contain the rate of an input, ∂r/∂t is that rate."""
    place: dict[Any, int] = {s: k for k, s in enumerate(now.eom.inputs)}
    result = np.zeros((len(place), 1 + len(by)))
    for s, row in law_slopes(now, (time, *by)).items():
        result[place[s]] = evaluated(row, now, np.array([t]), x[None])[:, 0]
    for s, value in zip(now.eom.inputs, now.inputs(t, x), strict=True):
        if isinstance(s, Rate):
            result[place[s.place], 0] = value
    return result


def forcing(now: Routines, by: Sequence[Symbol]) -> Slopes:
    """∂f/∂p (m × n × k) at times (m) and states (m × n); None without parameters."""
    if not by:
        return None
    own = set(now.eom.parameters)
    place = [k for k, s in enumerate(by) if s in own]
    through = input_slopes(now, by)

    def along(t: Array, x: Array) -> Array:
        found = np.zeros((len(t), x.shape[1], len(by)))
        if place:
            found[:, :, place] = now.routine(symbol_slopes, *(by[k] for k in place))(t, x, now.p, now.inputs(t, x))
        return found if through is None else found + through(t, x)

    return along
