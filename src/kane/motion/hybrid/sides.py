# SPDX-License-Identifier: BSD-3-Clause
"""Loads and inputs that switch, in machine code: the side of each switch is a number among the parameters, −1 or 1.

With every switch replaced by what it is on its side, rates are smooth across the place where it turns, so that a step sees it as an
event on its own polynomial (`steppers/watched.py`).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.expr.piecewise import Piecewise, leaps, on, on_sides, side_symbols
from kane.expr.piecewise import switches as switches_of
from kane.motion.hybrid.event_routines import glance
from kane.motion.inputs.expressions import Formula
from kane.motion.inputs.functions import law_and
from kane.motion.right_hand_side import Routines, has_jumps, quantities, rates, sided, watched


def unfit(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether they jump and there are switches with more than two sides, tables of steps, or with none: what chooses pivots."""
    if not has_jumps(eom, laws):
        return False
    loads = eom.solved.regular.declared_loads
    scalars = [x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars()]
    own = switches_of([*without_unknowns(eom.solved, scalars), *laws])
    tables = any(isinstance(node.op, Piecewise) and leaps(node.op) for s in own for node in s.nodes)
    return tables or not set(quantities(eom, laws)) <= {s.quantity for s in own}


def on_one_side(eom: Equations, laws: Sequence[Expr] = ()) -> list[Expr]:
    """(q̇, u̇, ȧ, P), and the laws of inputs, with every switch on one side: what they are made of between two switches."""
    every = quantities(eom, laws)
    return list(map(on(every, (1,) * len(every)), (*rates(eom).task.roots, *laws)))


def on_their_sides(now: Routines) -> Routines:
    """The equations as a kernel takes them that decides switches; as they are where nothing jumps."""
    eom = now.eom
    if not has_jumps(eom, now.laws):
        return now
    every = quantities(eom, now.laws)
    symbols, memo = side_symbols(every), dict[Expr, Expr]()

    def fixed(e: Expr) -> Expr:
        return on_sides(e, symbols, memo)

    written = tuple(replace(f, expr=fixed(f.expr)) if isinstance(f, Formula) else f for f in now.drives)
    own = quantities(eom)
    law = law_and(written, eom.inputs, list(map(fixed, every[len(own) :])))
    turning = (*own, *law.values[len(eom.inputs) :])
    makes = ((rates,), (watched, *turning), (glance, *turning))
    eom.numeric(now.settings).compile(*((sided, len(every), *make) for make in makes))
    p = np.append(now.p, np.ones(len(every)))
    on_them = replace(now, p=p, quantities=every, written=written, numbers=law.numbers, turning=turning, switches=None)
    return replace(on_them, rates=on_them.routine(rates).flat, events=on_them.routine(watched, *turning).flat)
