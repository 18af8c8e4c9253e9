# SPDX-License-Identifier: BSD-3-Clause
"""∂f/∂p along a motion: by parameters of the equations, and by those of inputs that are expressions, f(x, t, p, r(x, t, p))."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.dynamics.slopes import slopes
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Symbol, time
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, only
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Shaped

Slopes = Callable[[Array, Array], Array] | None
"""A derivative of f (m × n × k) at times (m) and states (m × n); None where it is zero.

It is written out and compiled when it is first asked for: the way back along a motion hardly ever needs it.
"""


def symbol_slopes(eom: Equations, *by: Symbol) -> Bundle[Array]:
    """∂(q̇, u̇, ȧ)/∂symbols, parameters or inputs."""
    return Bundle(
        "by_parameters",
        ports(eom.derived),
        only,
        {"x": Shaped((len(eom.state), len(by)), slopes(eom.solved, by).entries)},
    )


def input_slopes(now: Routines, by: Sequence[Symbol]) -> Slopes:
    """∂f/∂r ∂r/∂symbols (m × n × k) of inputs that are expressions, at times (m) and states (m × n); None where it is zero."""
    eom = now.eom
    laws = {s: f for s, f in zip(eom.inputs, now.drives, strict=True) if isinstance(f, Formula)}
    turned = {s: [tangent(f.whole, {p: ONE}) for p in by] for s, f in laws.items()}
    turned = {s: row for s, row in turned.items() if any(e is not ZERO for e in row)}
    if not turned:
        return None

    def along(t: Array, x: Array) -> Array:
        of_inputs = now.routine(symbol_slopes, *turned)(t, x, now.p, now.inputs_all(t, x))
        slopes = np.empty((len(t), len(turned), len(by)))
        for i, (s, row) in enumerate(turned.items()):
            at: dict[Expr, Any] = {
                **laws[s].values,
                **laws[s].gains,
                **dict(zip(eom.state, x.T, strict=False)),
                time: t,
            }
            for k, value in enumerate(evaluate(row, at)):
                slopes[:, i, k] = value
        return np.asarray(of_inputs @ slopes)

    return along


def forcing(now: Routines, by: Sequence[Symbol]) -> Slopes:
    """∂f/∂p (m × n × k) at times (m) and states (m × n); None where there are no parameters."""
    if not by:
        return None
    own = set(now.eom.parameters)
    place = [k for k, s in enumerate(by) if s in own]
    through = input_slopes(now, by)

    def along(t: Array, x: Array) -> Array:
        found = np.zeros((len(t), x.shape[1], len(by)))
        if place:
            found[:, :, place] = now.routine(symbol_slopes, *(by[k] for k in place))(t, x, now.p, now.inputs_all(t, x))
        return found if through is None else found + through(t, x)

    return along
