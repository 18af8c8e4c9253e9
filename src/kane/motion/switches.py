# SPDX-License-Identifier: BSD-3-Clause
"""Where loads switch: signs, comparisons and directions that they hold."""

from typing import NamedTuple

from kane.equations.equations import Equations
from kane.errors import cut
from kane.expr.build import sub
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import DIV, OPS, SQRT

_JUMPS = {OPS["sign"], OPS["less"]}


class Switch(NamedTuple):
    """A load's expression that `jumps` where `quantity` passes zero, or is a direction that it then has not; `smooth` cures it."""

    text: str
    quantity: Expr
    load: str
    smooth: str
    jumps: bool


def switches(eom: Equations) -> tuple[Switch, ...]:
    """Signs, comparisons and directions v/|v| that the loads hold, each once."""
    found: dict[Expr, Switch] = {}
    for load in eom.solved.regular.declared_loads:
        for node in postorder(x for _, v in (*load.forces, *load.torques) for x in v.scalars()):
            if node.op in _JUMPS:
                quantity = sub(*node.args) if len(node.args) == 2 else node.args[0]
            elif node.op is DIV and node.args[1].op is SQRT:  # a direction v/|v|
                quantity = node.args[1]
            else:
                continue
            if is_constant_in_time([quantity]):
                continue
            if quantity.op is SQRT:
                smooth = f"divide by sqrt({cut(quantity.args[0])} + eps^2)"
            else:
                smooth = f"write tanh(({cut(quantity)})/eps)"
            found.setdefault(quantity, Switch(str(node), quantity, load.name, smooth, node.op in _JUMPS))
    return tuple(found.values())
