# SPDX-License-Identifier: BSD-3-Clause
"""Where a mode of contacts begins its forces must be those of its laws: a contact that sticks or slips presses, N ≥ 0, |F| ≤ μ_s N.

Its events wait for these to fall to zero, and would never come where they begin below.
"""

from __future__ import annotations

from collections.abc import Collection

from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.model.declarations import Event
from kane.motion.hybrid.events import quantity_along
from kane.motion.right_hand_side import Routines
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL

_TOLD = {
    "opens": "that presses, got N = {value:.6g}: it is pulled. Take the mode 'separated'",
    "slips": "whose friction suffices, got |F| > μ_s N, (Σ μ_s N)² − |F|² = {value:.6g}: it slips. Take a mode in which it does",
}
"""What is wrong with a contact in a mode, by the event that would have ended this before."""


def ends_force(eom: Equations) -> tuple[str, ...]:
    """By event, how it ends a mode where the forces of a contact leave their cone; "" of any other."""
    if not eom.system.modes:
        return ("",) * len(eom.events)
    names = {f"{c.name} {kind}": kind for c in eom.system.contacts for kind in _TOLD}
    return tuple(names.get(e.name, "") for e in eom.events)


def check_forces(now: Routines, t: float, state: Array, known: Collection[str]) -> None:
    """Refuse a mode whose forces are beyond their cone by more than rounding; events that are `known` are at their thresholds.

    Raises
    ------
    SimulationError
        if a contact is pulled, or sticks by more friction than it has
    """
    kinds = now.eom.numeric().value(ends_force)
    if not any(kinds):
        return
    for event, kind, value in zip(now.eom.events, kinds, now.watch(t, state), strict=True):
        if kind and event.name not in known and value < 0 and _beyond(event, now, t, state):
            name = event.name.removesuffix(f" {kind}")
            raise SimulationError(
                f"Expected a contact {name!r} {_TOLD[kind].format(value=value)}, or simulate the system itself, which chooses "
                f"its modes (t = {t:.6g})."
            )


def _beyond(event: Event, now: Routines, t: float, state: Array) -> bool:
    """Whether a quantity is below zero by more than rounding of its terms."""
    value, terms = quantity_along(event, now, t, state)
    return not value >= -EQUAL * terms
