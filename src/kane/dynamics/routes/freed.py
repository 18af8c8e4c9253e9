# SPDX-License-Identifier: BSD-3-Clause
"""A tree as forces of constraints press on it: its accelerations without them, the shares these have of its pivots, and what passes.

By articulated inertias here, by composite ones in `composed`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from kane.dynamics.routes.articulated import Inward, Passed, Wrenches, outward
from kane.dynamics.routes.pressed import Number, Pressed, loaded, pressed
from kane.expr.node import Expr
from kane.kinematics.travel import Travel
from kane.space.rotation import Triple


class Freed(Protocol):
    """A tree whose joint accelerations are known, and change as forces press on it."""

    @property
    def on(self) -> Travel:
        """The motion of its segments."""

    @property
    def free(self) -> Passed:
        """What passes without further forces."""

    @property
    def divisors(self) -> Mapping[Number, Expr]:
        """D of each pivot."""

    def press(self, forces: Mapping[int, Expr], loads: Wrenches) -> Pressed:
        """What `loads` on segments press with, and generalized forces on freedoms by the number of their row among those passed."""

    def passed(self, forces: Sequence[Pressed], amounts: Sequence[Expr]) -> Passed:
        """What passes with such forces besides, in these amounts."""


@dataclass(frozen=True, eq=False)
class Articulated:
    """A tree by articulated inertias; what is transmitted to the segments `asked` for is told."""

    found: Inward
    ground: Triple
    asked: Collection[int] = ()

    @property
    def on(self) -> Travel:
        """The motion of its segments."""
        return self.found.on

    @cached_property
    def free(self) -> Passed:
        """What passes without further forces."""
        return outward(self.found, self.ground)

    @cached_property
    def divisors(self) -> dict[Number, Expr]:
        """D of each pivot, in the order in which joint speeds are passed."""
        own = self.found.pivots
        found: dict[Number, Expr] = {(i, k): of[k].d for i, of in enumerate(own) for k in reversed(range(len(of)))}
        for _, modes in sorted(self.found.modes.items()):
            found |= {mode.rate: mode.d for mode in reversed(modes)}
        return found

    def press(self, forces: Mapping[int, Expr], loads: Wrenches) -> Pressed:
        """The way to the base."""
        numbers = list(self.divisors)
        return pressed(self.found, {numbers[k]: x for k, x in forces.items()}, loads)

    def passed(self, forces: Sequence[Pressed], amounts: Sequence[Expr]) -> Passed:
        """The way back."""
        return outward(loaded(self.found, forces, amounts), self.ground, self.asked)
