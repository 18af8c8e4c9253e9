# SPDX-License-Identifier: BSD-3-Clause
"""The equations of a motion as compiled functions of (t, y), parameters and inputs being given; y = (q, u, ∫P dt)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.routines import once, routine
from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.equations.handle import Handle
from kane.equations.routines import rate_names
from kane.expr.node import Expr
from kane.expr.symbols import time
from kane.numeric.arrays import Array
from kane.numeric.projection import least_constraint


def _routine(eom: Equations, name: str, roots: Sequence[Expr], labels: Sequence[str] | None = None) -> Handle:
    return routine(eom, name, without_unknowns(eom.solved, roots), labels=labels)


def _rates(eom: Equations) -> Handle:
    """(q̇, u̇, P)."""
    return _routine(eom, "motion", [*eom.right_hand_side, eom.power], [*rate_names(eom.derived), "P"])


def _watched(eom: Equations) -> Handle | None:
    """The events' quantities."""
    return (
        _routine(eom, "events", [e.quantity for e in eom.events], [e.name for e in eom.events]) if eom.events else None
    )


def _unsolved(eom: Equations) -> Handle:
    """What the accelerations of least size are made of: q̇, f, Ȧ u + ḃ."""
    roots = [*eom.rates, *eom.forcing, *eom.constraints.drift]
    return _routine(eom, "loose", roots)


@dataclass(frozen=True, slots=True, eq=False)
class Routines:
    """Equations with values `p` of their parameters and `drives`, the inputs as functions of time; `width` counts (q, u)."""

    eom: Equations
    p: Array
    drives: tuple[Callable[[Any], Any], ...]
    width: int
    handle: Handle
    events: Handle | None

    def inputs(self, t: float) -> Array:
        """Values of the inputs."""
        return np.array([float(f(t)) for f in self.drives])

    def rate(self, t: float, y: Array) -> Array:
        """(q̇, u̇, P)."""
        return self.handle(t, y[: self.width], self.p, self.inputs(t) if self.drives else None)

    def least_rate(self, t: float, y: Array, m: Array, a: Array, reach: Array) -> Array:
        """(q̇, u̇, P) with the u̇ nearest to M⁻¹ f in the mass metric for which A u̇ = −(Ȧ u + ḃ)."""
        eom, nq, n = self.eom, len(self.eom.coordinates), len(self.eom.speeds)
        q_dot, f, drift = np.split(
            once(eom, "loose", lambda: _unsolved(eom))(t, y[: self.width], self.p, self.inputs(t)), [nq, nq + n]
        )
        return np.concatenate([q_dot, least_constraint(m, a, f, -drift, reach), self.rate(t, y)[-1:]])

    def watch(self, t: float, y: Array) -> Array:
        """The events' quantities."""
        if self.events is None:
            return np.zeros(0)
        return self.events(t, y[: self.width], self.p, self.inputs(t) if self.drives else None)

    def values(self, t: float, y: Array) -> dict[Expr, Any]:
        """A number for every symbol of the equations."""
        eom = self.eom
        symbols = (time, *eom.coordinates, *eom.speeds, *eom.parameters, *eom.inputs)
        return dict(zip(symbols, [t, *y[: self.width], *self.p, *self.inputs(t)], strict=True))

    def explain(self, t: float, y: Array) -> str:
        """What is not finite first."""
        return self.handle.explain(t, y[: self.width], self.p, self.inputs(t))


def routines(eom: Equations, p: Array, drives: Sequence[Callable[[Any], Any]]) -> Routines:
    """The equations compiled, once for each set of them."""
    width = len(eom.coordinates) + len(eom.speeds)
    rates, events = once(eom, "rates", lambda: _rates(eom)), once(eom, "events", lambda: _watched(eom))
    return Routines(eom, p, tuple(drives), width, rates, events)
