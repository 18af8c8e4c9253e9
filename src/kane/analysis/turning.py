# SPDX-License-Identifier: BSD-3-Clause
"""The quantities at which equations and outputs switch, how large their terms are, and their derivatives."""

from typing import NamedTuple

from kane.analysis.local import unknowns
from kane.dynamics.readings.unsolved import partials, unsolved
from kane.equations.equations import Equations
from kane.equations.routines import ports
from kane.expr.node import Expr
from kane.expr.size import Sizes, size
from kane.expr.switching import Switch, switches
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle


class Turning(NamedTuple):
    """c, the sizes of its terms, and ∂c/∂(q, u, a, r, z), a row for each switch."""

    quantities: Array
    sizes: Array
    slopes: Array


def all_switches(eom: Equations, *outputs: Expr) -> tuple[Switch, ...]:
    """Those of the unsolved equations and of outputs."""
    u = unsolved(eom.derived)
    return switches((*u.places, *u.residual, *outputs))


def turning(eom: Equations, *outputs: Expr) -> Bundle[Turning]:
    """The quantities of `all_switches`, in their order; z is an argument."""
    z, memo = unknowns(eom), Sizes()
    quantities = [s.quantity for s in all_switches(eom, *outputs)]
    slopes = partials(quantities, (*eom.state, *eom.inputs, *z.symbols))
    groups = {"quantities": quantities, "sizes": [size(c, memo) for c in quantities], "slopes": slopes}
    return Bundle("turning", (*ports(eom.derived), z), Turning, groups)
