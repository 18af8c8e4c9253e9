# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion as they are stepped: compiled functions of (t, y), the constraints kept, the dependent speeds changed.

What changes while stepping is only which speeds are dependent. Where the rank of the constraints drops at a configuration, the
accelerations are those of least size in the mass metric that the constraints leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.analysis.routines import once, routine
from kane.dynamics.constraints.closure import OFF, closure, residual_function
from kane.dynamics.constraints.partition import POOR, choose, quality
from kane.dynamics.readings.values import without_unknowns
from kane.equations.derive import repartition
from kane.equations.equations import Equations
from kane.equations.handle import Handle
from kane.equations.routines import rate_names
from kane.errors import ReactionError, SimulationError
from kane.expr.evaluate import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import input_of, time
from kane.model.events import Event
from kane.motion.projection import Manifold, Numbers, manifold
from kane.numeric.arrays import Array
from kane.numeric.newton import close
from kane.numeric.projection import least_constraint, mobility, sizes
from kane.numeric.rank import MOTION_RANK, balanced, combinations

_BETTER = 4.0
"""By how much the quality of other dependent speeds must be better for a change."""
_SHORT_OF_RANK = 0.02
"""Least singular value of A over the largest below which a motion that broke off may have come to a lock."""
_SHORT = 1e-3
"""Reciprocal condition below which a sample between two steps is read off with other dependent speeds than it was stepped with."""


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


def _loose(eom: Equations) -> Handle:
    """What the accelerations of least size are made of: q̇, f, Ȧ u + ḃ."""
    roots = [*eom.rates, *eom.forcing, *eom.constraints.drift]
    return _routine(eom, "loose", roots)


class Motion:
    """One motion of `eom`: `rate(t, y)` with y = (q, u, ∫P dt), `watch(t, y)`, `keep(t, y)`.

    `segments` lists from which time on which equations, by their dependent speeds, were stepped; `changes` are the events of it.
    """

    def __init__(self, eom: Equations, fixed: Array, forces: Sequence[Callable[[Any], Any]]) -> None:
        self.fixed, self.forces = fixed, list(forces)
        self.width = len(eom.coordinates) + len(eom.speeds)
        self.manifold: Manifold | None = once(eom, "manifold", lambda: manifold(eom))
        self.first = eom
        self.segments: list[tuple[float, Equations]] = []
        self.changes: list[tuple[Event, float]] = []
        self.lost = False
        self.side = 0.0
        self.reach: Array = np.zeros((len(eom.b), len(eom.speeds)))
        self._take(eom)

    def _take(self, eom: Equations) -> None:
        self.eom = eom
        self.handle: Handle = once(eom, "rates", lambda: _rates(eom))
        self.events: Handle | None = once(eom, "events", lambda: _watched(eom))

    def inputs(self, t: float) -> Array:
        """Values of the inputs."""
        return np.array([float(f(t)) for f in self.forces])

    def rate(self, t: float, y: Array) -> Array:
        """(q̇, u̇, P)."""
        r = self.inputs(t) if self.forces else None
        found = self.handle(t, y[: self.width], self.fixed, r)
        return self._least(t, y, found) if self.lost else found

    def watch(self, t: float, y: Array) -> Array:
        """The events' quantities."""
        if self.events is None:
            return np.zeros(0)
        return self.events(t, y[: self.width], self.fixed, self.inputs(t) if self.forces else None)

    def values(self, t: float, y: Array) -> dict[Expr, Any]:
        """A number for every symbol of the equations."""
        eom = self.eom
        symbols = (time, *eom.coordinates, *eom.speeds, *eom.parameters, *eom.inputs)
        return dict(zip(symbols, [t, *y[: self.width], *self.fixed, *self.inputs(t)], strict=True))

    def explain(self, t: float, y: Array) -> str:
        """What is not finite first."""
        return self.handle.explain(t, y[: self.width], self.fixed, self.inputs(t))

    def held_up(self, t: float, y: Array, later: float) -> str:
        """Which constraint a drive cannot hold beyond t, as no configuration near y closes it at `later`; "" without that evidence."""
        driving = free_symbols(c.expr for c in self.eom.system.holonomic)
        if self.manifold is None or not any(s is time or input_of(s) is not None for s in driving):
            return ""
        kept, numbers = self.keep(t, y)
        if numbers is None or not all(np.all(np.isfinite(v)) for v in (numbers.a, numbers.f)):
            return ""
        values = combinations(numbers.a, self.reach).values
        least = float(values[len(self.eom.dependent_speeds) - 1] / values[0])
        known, moving = closure(self.eom.system), set(self.eom.coordinates)
        rest = {s: v for s, v in self.values(later, kept).items() if s not in moving}
        found = close(residual_function(self.eom.system, known, rest), kept[: len(moving)], range(len(moving)))
        if not (least < _SHORT_OF_RANK and OFF < found.size < np.inf):
            return ""
        worst = int(np.argmax(np.abs(found.residual)))
        return (
            f"{known.names[worst]!r} cannot be held beyond t = {t:.6g}, where the constraints lose rank (least singular value "
            f"{least:.1e} of the largest): at t = {later:.6g} {found.residual[worst]:.2g} is left of it in the nearest "
            "configuration. The drive carries the parts further than they reach: end before, drive them another way, or correct the "
            "lengths"
        )

    # Constraints ---------------------------------------------------------------------------------------------------------

    def keep(self, t: float, y: Array) -> tuple[Array, Numbers | None]:
        """y moved onto the constraints, and their numbers there."""
        if self.manifold is None:
            return y, None
        x, numbers = self.manifold.project(t, y[: self.width], self.fixed, self.inputs(t), self.reach)
        self.reach = np.maximum(self.reach, np.abs(numbers.a))
        return np.append(x, y[self.width :]), numbers

    def sample(self, t: float, y: Array) -> tuple[Array, Equations]:
        """y moved onto the constraints, and equations whose dependent speeds are determined there.

        A step may lead across a state at which those that are stepped are singular. Where rank is lost, dependent speeds are as many
        as are determined: the accelerations are then those of least size.
        """
        kept, numbers = self.keep(t, y)
        e = self.eom.embedding
        if e is None or numbers is None or not np.all(np.isfinite(numbers.a)):
            return kept, self.eom
        rank = combinations(numbers.a, self.reach).rank
        reach = np.maximum(self.reach, sizes(numbers.a, mobility(numbers.m, self.reach)))
        if rank >= len(e.partition.rows) and quality(numbers.a, e.partition, reach) >= _SHORT:
            return kept, self.eom
        found = choose(numbers.a, reach=reach).first(min(rank, len(e.partition.rows)))
        try:
            return kept, once(self.first, f"partition {found}", lambda: repartition(self.first, found))
        except ReactionError:
            return kept, self.eom

    def settle(self, t: float, numbers: Numbers | None) -> bool:
        """Choose other dependent speeds where the present ones are poorly determined; says whether anything changed."""
        e = self.eom.embedding
        if e is None or numbers is None or not np.all(np.isfinite(numbers.a)):
            return False
        before = (self.eom, self.lost)
        now = quality(numbers.a, e.partition, self.reach)
        if now < POOR:
            found = choose(numbers.a, reach=self.reach)
            more = len(found.rows) - len(e.partition.rows)
            if (more == 0 or (more > 0 and not self.segments)) and quality(
                numbers.a, found, self.reach
            ) > _BETTER * now:
                eom = once(self.first, f"partition {found}", lambda: repartition(self.first, found))
                self._take(eom)
                given = ", ".join(u.name for u in eom.dependent_speeds)
                self._note(t, f"dependent speeds {given}", "the dependent speeds were changed")
        lost = self._loses(numbers)
        if lost and not self.lost:
            self._check_loose(t)
            self._note(t, "rank of the constraints drops", "the accelerations of least size were taken")
        self.lost = lost
        self.side = 0.0 if lost else self._side(numbers)
        if before[0] is not self.eom or not self.segments:
            self.segments.append((t, self.eom))
        return before != (self.eom, self.lost)

    def jumped(self, numbers: Numbers | None) -> bool:
        """Whether the dependent block was singular since `settle` was last called: its determinant has changed sign.

        On the way its inverse was as large as chance would have it, and none of the solver's error estimates need have seen it.
        """
        if not self.side or numbers is None or not np.all(np.isfinite(numbers.a)):
            return False
        return self.side * self._side(numbers) < 0 and not self._loses(numbers)

    def _side(self, numbers: Numbers) -> float:
        assert self.eom.embedding is not None
        partition = self.eom.embedding.partition
        block = balanced(numbers.a, self.reach)[np.ix_(partition.rows, partition.dependent)]
        return float(np.linalg.slogdet(block)[0])

    def _loses(self, numbers: Numbers) -> bool:
        values = combinations(numbers.a, self.reach).values
        return bool(values[len(self.eom.dependent_speeds) - 1] < MOTION_RANK * values[0])

    def _note(self, t: float, name: str, message: str) -> None:
        self.changes.append((Event(name, ZERO, terminal=False, message=message), t))

    def _check_loose(self, t: float) -> None:
        if any(x is not ZERO for row in self.eom.blocks.coupling for x in row):
            raise SimulationError(
                f"Expected constraints of constant rank, got a drop at t = {t:.6g}, where loads that hold reactions leave the "
                "accelerations undetermined. Start elsewhere, or leave out the loads that depend on reactions."
            )

    def _least(self, t: float, y: Array, found: Array) -> Array:
        """The u̇ nearest to M⁻¹ f in the mass metric with A u̇ = −(Ȧ u + ḃ)."""
        assert self.manifold is not None
        eom, x, r = self.eom, y[: self.width], self.inputs(t)
        numbers = self.manifold.numbers(t, x, self.fixed, r)
        nq, n = len(eom.coordinates), len(eom.speeds)
        loose = once(eom, "loose", lambda: _loose(eom))(t, x, self.fixed, r)
        u_dot = least_constraint(numbers.m, numbers.a, loose[nq : nq + n], -loose[nq + n :], self.reach)
        return np.concatenate([loose[:nq], u_dot, found[-1:]])
