# SPDX-License-Identifier: BSD-3-Clause
"""Lengths |v| = √(v·v) that are zero at a state: they have no derivative there, |v| v has.

Derivatives take that of a length at zero as zero, the mean of all sides. Whether that is right is seen beside the state, along each of
the states and inputs and along all of them together.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.corners import different_slopes
from kane.analysis.flow import Flow, flow_at, output_slopes
from kane.analysis.local import unknowns
from kane.analysis.outputs import Outputs
from kane.analysis.sides import Piece, beside
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.equations import Equations
from kane.equations.routines import ports
from kane.errors import CornerError, SingularError, cut
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import GONE, SQRT
from kane.expr.size import Sizes, size
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle


class Lengths(NamedTuple):
    """s of each √s, and the sizes of their terms."""

    squares: Array
    sizes: Array


def lengths(eom: Equations, *outputs: Expr) -> tuple[Expr, ...]:
    """The roots √s of the unsolved equations and of outputs."""
    u = unsolved(eom.derived)
    order = postorder((*u.places, *u.residual, *outputs))
    return tuple(n for n in order if n.op is SQRT and not is_constant_in_time(n.args))


def _measured(eom: Equations, *outputs: Expr) -> Any:
    z, memo = unknowns(eom), Sizes()
    squares = [n.args[0] for n in lengths(eom, *outputs)]
    groups = {"squares": squares, "sizes": [size(s, memo) for s in squares]}
    bundle = Bundle("lengths", (*ports(eom.derived), z), Lengths, groups)
    return bundle.reference([s for port in bundle.ports for s in port.symbols])


def check_cones(flow: Flow, outputs: Outputs) -> None:
    """A CornerError names a length that is zero at the flow's state, where slopes beside it depend on the direction."""
    numeric, state = flow.numeric, flow.state
    table = numeric.value(lengths, *outputs.roots)
    if not table:
        return
    own: Lengths = numeric.value(_measured, *outputs.roots)([state.t, *state.x, *state.p, *state.r, *flow.z])
    standing = [n for n, s, size in zip(table, own.squares, own.sizes, strict=True) if s <= (2 * GONE) ** 2 * size]
    if not standing:
        return
    here = Piece(flow, (), *output_slopes(flow, outputs), np.zeros((0, 0)), np.zeros(0))
    width = flow.moves.shape[1]
    mixed = np.sqrt(1.0 + np.arange(width))
    for d in (*np.eye(width), *-np.eye(width), mixed, -mixed, mixed * (-1.0) ** np.arange(width)):
        there = _tends(flow, outputs, d)
        if there is None or different_slopes((here, there)).any():
            what = ", ".join(f"{cut(str(n), 80)} = 0" for n in standing[:3])
            raise CornerError(
                f"Expected a state at which the equations have one derivative, got one at which {what}: slopes beside it depend on "
                "the direction in which it is left. Take a state beside it, or give the length a small eps, sqrt(v.dot(v) + eps^2)."
            )


def _tends(flow: Flow, outputs: Outputs, d: Array) -> Piece | None:
    """What slopes and values beside the state tend to along d; None where they tend to nothing finite."""

    def at(x: Array, r: Array) -> Piece | None:
        try:
            there = flow_at(flow.numeric, replace(flow.state, x=x, r=r), flow.choice, flow.numbers)
        except SingularError:
            return None
        return Piece(there, (), *output_slopes(there, outputs), np.zeros((0, 0)), d)

    with np.errstate(invalid="ignore", divide="ignore"):
        return beside(flow, d, at)
