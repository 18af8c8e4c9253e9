# SPDX-License-Identifier: BSD-3-Clause
"""A tree by composite bodies as forces press on it: M is factored already, so that e = L⁻¹ τ and ẇ = L⁻ᵀ D⁻¹ (L⁻¹ f + Σ e λ).

τ of a wrench on a segment is its power with each freedom on the way to the ground.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from kane.dynamics.routes.articulated import Passed, Wrenches
from kane.dynamics.routes.composite import Factored
from kane.dynamics.routes.moving import moving
from kane.dynamics.routes.places import Wrench
from kane.dynamics.routes.pressed import Number, Pressed
from kane.expr.build import add, mul
from kane.expr.node import ZERO, Expr
from kane.expr.solve import forward
from kane.kinematics.travel import Travel
from kane.space.rotation import Triple


@dataclass(frozen=True, eq=False)
class Composed:
    """The tree; what its joints transmit is not found on this way."""

    found: Factored
    ground: Triple

    @property
    def on(self) -> Travel:
        """The motion of its segments."""
        return self.found.way.on

    @cached_property
    def free(self) -> Passed:
        """What passes without further forces."""
        return self.passed((), ())

    @cached_property
    def divisors(self) -> dict[Number, Expr]:
        """D of each pivot, in the order of elimination."""
        return dict(enumerate(self.found.factors.pivots))

    def press(self, forces: Mapping[int, Expr], loads: Wrenches) -> Pressed:
        """L⁻¹ τ."""
        found, on = self.found, self.on
        tau = [forces.get(k, ZERO) for k in range(len(found.order))]
        for i, (n, f) in loads.items():
            turn = on.steps[i].turn
            wrench = Wrench(n, f) if turn is None or not on.base[i] else Wrench(turn.up(n), turn.up(f))
            for place, x in found.way.up(i, wrench):
                tau[place.number] = add(tau[place.number], x)
        return Pressed(dict(enumerate(forward(found.factors.lower, [tau[k] for k in found.order]))), {})

    def passed(self, forces: Sequence[Pressed], amounts: Sequence[Expr]) -> Passed:
        """What passes with such forces besides, in these amounts."""
        found, whole = self.found, list(self.found.eliminated)
        for each, x in zip(forces, amounts, strict=True):
            whole = [add(y, mul(each.shares[k], x)) for k, y in enumerate(whole)]
        values = found.values(whole)
        return Passed(found.rows(values), list(found.factors.pivots), {}, moving(found.way, self.ground, values).own)
