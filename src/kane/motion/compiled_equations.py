# SPDX-License-Identifier: BSD-3-Clause
"""The equations of a motion as compiled functions of (t, y), parameters and inputs being given; y = (q, u, a, ∫P dt)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.equations.routines import ports, rate_names
from kane.expr.node import Expr
from kane.expr.symbols import time
from kane.motion.drives import law_and
from kane.motion.feedback import value
from kane.motion.formulas import turning_laws
from kane.motion.laws import law_ports
from kane.motion.switches import switches
from kane.motion.time_breaks import Clock, clock
from kane.numeric.arrays import Array
from kane.numeric.projection import least_constraint
from kane.numeric.rank import Mixed
from kane.program.bundle import Bundle
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.machine import Settings


def rates(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """(q̇, u̇, ȧ, P)."""
    roots = without_unknowns(eom.solved, [*eom.right_hand_side, eom.power])
    return Bundle("motion", ports(eom.derived), _parts, {"rates": roots}, [*rate_names(eom.derived), "P"])


def timed(eom: Equations) -> Clock:
    """What of the rates turns at times, or may be a pulse."""
    return clock(rates(eom).task.roots)


def watched(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """The events' quantities."""
    roots = without_unknowns(eom.solved, [e.quantity for e in eom.events])
    return Bundle("events", ports(eom.derived), _parts, {"events": roots}, [e.name for e in eom.events])


def switched(eom: Equations, *more: Expr) -> Bundle[tuple[Array, ...]]:
    """The quantities of the loads' switches, and `more` of the laws of inputs."""
    roots = [*without_unknowns(eom.solved, jumping(eom)), *more]
    return Bundle("switches", law_ports(eom, more), _parts, {"switches": roots}, list(map(str, range(len(roots)))))


def jumping(eom: Equations, laws: Sequence[Expr] = ()) -> list[Expr]:
    """The quantities at which loads jump, then those at which laws of inputs do."""
    found = [*switches(eom), *switches(eom, laws)] if laws else switches(eom)
    return list(dict.fromkeys(s.quantity for s in found if s.jumps))


def _parts(*parts: Array) -> tuple[Array, ...]:
    return parts


class Unembedded(NamedTuple):
    """q̇, f and Ȧ u + ḃ: what the accelerations of least size are made of."""

    rates: Array
    forcing: Array
    drift: Array


def unembedded(eom: Equations) -> Bundle[Unembedded]:
    """q̇, f and Ȧ u + ḃ as functions of the state."""
    groups = {"rates": eom.rates, "forcing": eom.forcing, "drift": eom.constraints.drift}
    plain = {name: without_unknowns(eom.solved, roots) for name, roots in groups.items()}
    return Bundle("unembedded", ports(eom.derived), Unembedded, plain)


@dataclass(frozen=True, slots=True, eq=False)
class Routines:
    """Equations with values `p` of their parameters and `drives`, the inputs as functions of time; `width` counts (q, u, a).

    `numbers` are those of the inputs that are expressions, and of the quantities at which they switch.
    """

    eom: Equations
    p: Array
    drives: tuple[Callable[[Any], Any], ...]
    settings: Settings | None
    width: int
    rates: CompiledRoutine
    events: CompiledRoutine | None
    switches: CompiledRoutine | None = None
    numbers: tuple[float, ...] = ()

    @property
    def laws(self) -> tuple[Expr, ...]:
        """The inputs that are expressions of the state with switches in them."""
        return turning_laws(self.drives)

    def inputs(self, t: float, y: Array) -> Array:
        """Values of the inputs."""
        return np.array([value(f, t, y[: self.width]) for f in self.drives])

    def inputs_all(self, t: Array, y: Array) -> Array:
        """Values of the inputs (k × inputs) at times (k) and states (k × n)."""
        return np.array([self.inputs(s, row) for s, row in zip(t, y, strict=True)])

    def rate(self, t: float, y: Array) -> Array:
        """(q̇, u̇, P)."""
        return self.rates(t, y[: self.width], self.p, self.inputs(t, y) if self.drives else None)

    def least_rate(self, t: float, y: Array, m: Array, a: Array, reach: Array, mix: Mixed | None = None) -> Array:
        """(q̇, u̇, P) with the u̇ nearest to M⁻¹ f in the mass metric for which A u̇ = −(Ȧ u + ḃ)."""
        routine = self.eom.numeric(self.settings).routine(unembedded)
        q_dot, f, drift = routine(t, y[: self.width], self.p, self.inputs(t, y))
        rest = self.rate(t, y)[len(q_dot) + len(f) :]
        return np.concatenate([q_dot, least_constraint(m, a, f, -drift, reach, mix), rest])

    def watch(self, t: float, y: Array) -> Array:
        """The events' quantities."""
        return np.zeros(0) if self.events is None else self._at(self.events, t, y)

    def watch_all(self, t: Array, y: Array) -> Array:
        """The events' quantities (k × events) at times (k) and states (k × n)."""
        return np.zeros((len(t), 0)) if self.events is None else self._at_all(self.events, t, y)

    def switch(self, t: float, y: Array) -> Array:
        """The quantities of the loads' switches, of which there are some."""
        assert self.switches is not None
        return self._at(self.switches, t, y)

    def switch_all(self, t: Array, y: Array) -> Array:
        """The quantities of the loads' switches (k × switches) at times (k) and states (k × n)."""
        assert self.switches is not None
        return self._at_all(self.switches, t, y)

    def _at(self, routine: CompiledRoutine, t: float, y: Array) -> Array:
        return routine(t, y[: self.width], self.parameters(routine), self.inputs(t, y) if self.drives else None)

    def parameters(self, routine: CompiledRoutine) -> Array:
        """What a routine takes as p: the parameters of the equations, and as many of the numbers of the inputs as it asks for."""
        wanted = sum(len(port.symbols) for port in routine.program.ports if port.name == "p")
        return self.p if wanted == len(self.p) else np.append(self.p, self.numbers)[:wanted]

    def _at_all(self, routine: CompiledRoutine, t: Array, y: Array) -> Array:
        return routine(t, y[:, : self.width], self.parameters(routine), self.inputs_all(t, y))

    def values(self, t: float, y: Array) -> dict[Expr, Any]:
        """A number for every symbol of the equations."""
        eom = self.eom
        symbols = (time, *eom.state, *eom.parameters, *eom.inputs)
        return dict(zip(symbols, [t, *y[: self.width], *self.p, *self.inputs(t, y)], strict=True))

    def explain(self, t: float, y: Array) -> str:
        """What is not finite first."""
        return self.rates.explain(t, y[: self.width], self.p, self.inputs(t, y))


def routines(
    eom: Equations,
    p: Array,
    drives: Sequence[Callable[[Any], Any]],
    settings: Settings | None,
    *others: Callable[[Equations], Bundle[Any]],
) -> Routines:
    """The equations compiled, and the bundles of `others` with them in one module."""
    numeric, width = eom.numeric(settings), len(eom.state)
    events = [watched] if eom.events else []
    own, jumps = jumping(eom), jumping(eom, turning_laws(drives))
    numeric.compile(rates, *events, *([switched] if own and len(jumps) == len(own) else []), *others)
    law = law_and(drives, eom.inputs, jumps[len(own) :])
    quantities = numeric.routine(watched).flat if events else None
    sides = numeric.routine(switched, *law.values[len(eom.inputs) :]).flat if jumps else None
    own_rates = numeric.routine(rates).flat
    return Routines(eom, p, tuple(drives), settings, width, own_rates, quantities, sides, law.numbers)
