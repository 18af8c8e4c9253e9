# SPDX-License-Identifier: BSD-3-Clause
"""Where loads switch, and inputs that are expressions of the state: signs, comparisons and directions that they hold."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.dynamics.poles import SLIPS
from kane.equations.equations import Equations
from kane.errors import cut
from kane.expr.build import sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV, OPS, SQRT
from kane.expr.piecewise import Piecewise, applied, leaps
from kane.motion.inputs.breakpoints import is_timed
from kane.numeric.scale import CHANGES_SIDE, ROUNDED_CHAIN

_JUMPS = {OPS["sign"], OPS["less"]}


class Switch(NamedTuple):
    """What bends or `jumps` in a load or inputs where `quantity` passes zero, or a direction it has not then; `smooth` is a cure."""

    text: str
    quantity: Expr
    load: str
    smooth: str
    jumps: bool


def switches(eom: Equations, laws: Sequence[Expr] = ()) -> tuple[Switch, ...]:
    """Signs, comparisons and directions v/|v| that the loads, and the `laws` of inputs, hold, each once."""
    found: dict[Expr, Switch] = {}
    loads = {
        load.name: [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]
        for load in eom.solved.regular.declared_loads
    }
    for name, scalars in (*loads.items(), ("inputs", laws)):
        for node in postorder(scalars):
            if node.op in _JUMPS:
                quantity = sub(*node.args) if len(node.args) == 2 else node.args[0]
            elif isinstance(node.op, Piecewise) and node.op.sides is not None:
                quantity = applied(node.op.sides[0], node.args[0])
            elif node.op is DIV and node.args[1].op is SQRT:  # a direction v/|v|
                quantity = node.args[1]
            else:
                continue
            if is_constant_in_time([quantity]) or is_timed(quantity):
                continue
            if isinstance(node.op, Piecewise):
                smooth = "take a table of kind 'cubic'"
            elif quantity.op is SQRT:
                smooth = f"divide by sqrt({cut(quantity.args[0])} + eps^2) with a small eps"
            else:
                smooth = f"write tanh(({cut(quantity)})/eps) with a small eps"
            jumping = leaps(node.op) if isinstance(node.op, Piecewise) else node.op is not DIV
            known = found.setdefault(quantity, Switch(str(node), quantity, name, smooth, jumping))
            if jumping and not known.jumps:
                found[quantity] = known._replace(text=str(node), smooth=smooth, jumps=True)
    return tuple(found.values())


def has_jumps(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether loads, or the laws of inputs, jump."""
    return any(s.jumps for s in switches(eom, laws))


Sides = npt.NDArray[np.int8]


def sides(motion: Any) -> dict[str, Sides]:
    """See Solution.regimes."""
    eom: Equations = motion.equations
    turning = [s for s in switches(eom) if s.jumps]
    slips = [
        (load.name, load.slip)
        for load in eom.solved.regular.declared_loads
        if load.slip and load.slip.speed is not None
    ]
    values = motion[[*(s.quantity for s in turning), *(slip.speed for _, slip in slips)]] if turning or slips else []
    found = {s.text: _sign(v) for s, v in zip(turning, values, strict=False)}
    for (name, slip), speed in zip(slips, values[len(turning) :], strict=True):
        least = SLIPS * np.abs(speed).max(initial=0) if slip.threshold is None else slip.threshold
        found[name] = (speed > (1 + CHANGES_SIDE) * least).astype(np.int8)
    return found


def _sign(values: npt.NDArray[np.float64]) -> Sides:
    near = np.abs(values) <= ROUNDED_CHAIN * np.abs(values).max(initial=0)
    return np.where(near, 0, np.sign(values)).astype(np.int8)
