# SPDX-License-Identifier: BSD-3-Clause
"""Constraints with corners along a motion, such as a bead on y = |x| that arrives at the corner.

Beyond a switch in f or in A u + b the constraints may require positions or velocities that differ from those of the motion. That is an
impact, which constraints do not determine: the motion stops. Where positions and velocities stay continuous, it continues.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.analysis.one_sided import SidedBundles
from kane.analysis.state_checks import open_shares
from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations
from kane.errors import SimulationError, cut
from kane.expr.node import Expr, postorder
from kane.expr.ops import GONE
from kane.expr.piecewise import SwitchedQuantity, switches
from kane.expr.regular import Sizes, size
from kane.expr.symbols import time
from kane.motion.projection import Numbers, Tolerances, constraint_numbers
from kane.numeric.arrays import Array
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.polynomials import zero_of
from kane.numeric.scale import LAST_DIGIT, LEAPS, SOON
from kane.program.from_expressions import Bundle
from kane.program.native.compiled_routine import BundleRoutine

Dense = Callable[[float | Array], Array]
Given = Callable[[float], tuple[Array, Array]]
"""given(t) returns the values of parameters and inputs at time t."""

_SLACK = 10.0
"""Multiple of the tolerances of speeds within which a motion constraint counts as satisfied."""


def bends(eom: Equations) -> tuple[SwitchedQuantity, ...]:
    """The switches that occur in the constraints."""
    rows = eom.derived.constraints
    return switches((*(c.expr for c in eom.system.holonomic), *rows.a.entries, *rows.b))


class ConstraintSwitches(NamedTuple):
    """The quantities of the switches in the constraints, and the sizes of their terms (switches each)."""

    quantities: Array
    sizes: Array


def bending(eom: Equations) -> Bundle[ConstraintSwitches]:
    """The routine of `ConstraintSwitches` as functions of the state."""
    roots, memo = without_unknowns(eom.solved, [s.quantity for s in bends(eom)]), Sizes()
    groups = {"quantities": roots, "sizes": [size(c, memo) for c in roots]}
    return Bundle("bends", ports(eom.derived), ConstraintSwitches, groups)


@dataclass(frozen=True, slots=True, eq=False)
class Kink:
    """A corner that the motion cannot pass: its time on the interpolant, and the message if the motion ends there."""

    t: float
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class Kinks:
    """The switches `found` in the constraints; `bending` evaluates their quantities, `table` the constraints on given sides."""

    eom: Equations
    found: tuple[SwitchedQuantity, ...]
    bending: BundleRoutine[ConstraintSwitches]
    table: SidedBundles

    def ahead(self, dense: Dense, start: float, end: float, given: Given, tolerances: Tolerances) -> Kink | None:
        """The first corner in a step across which positions or velocities would have to jump; None if there is none."""
        width = len(self.eom.state)

        def at(t: float) -> Array:
            return self.bending(t, dense(t)[:width], *given(t)).quantities

        times = np.linspace(start, end, PARTS + 1)
        values = np.array([at(float(t)) for t in times])
        before = np.sign(values[0])
        turned: list[tuple[float, int]] = []
        for k in np.flatnonzero((np.sign(values) * before < 0).any(axis=0)):
            i = int(np.argmax(np.sign(values[:, k]) * before[k] < 0))
            a, b = float(times[i - 1]), float(times[i])

            def quantity(t: float, k: int = int(k)) -> float:
                return float(at(t)[k])

            place = zero_of(quantity, a, b, values[i - 1, k], values[i, k], LAST_DIGIT * max(abs(a), abs(b)))
            turned.append((place, int(k)))
        signs = np.where(before == 0, 1.0, before)
        for t, _ in sorted(turned):
            after = signs.copy()
            for other, j in turned:
                after[j] *= -1.0 if abs(other - t) <= SOON * (end - start) or other < t else 1.0
            told = self._leap(t, dense(t)[:width], given(t), signs, after, tolerances)
            if told:
                return Kink(t, told)
        return None

    def check_start(self, t: float, x: Array, given: tuple[Array, Array], rates: Array) -> None:
        """A SimulationError if a motion that is not at rest begins on a corner whose sides allow different velocities."""
        own = self.bending(t, x, *given)
        signs = np.where(own.quantities < 0, -1.0, 1.0)
        for k in np.flatnonzero(np.abs(own.quantities) <= GONE * own.sizes).tolist() if rates.any() else ():
            other = np.where(np.arange(len(signs)) == k, -signs, signs)
            one, two = (self._on(s, t, x, given) for s in (signs, other))
            apart = np.maximum(np.abs(two.a - one.a).max(axis=1, initial=0), np.abs(two.b - one.b))
            whole = np.maximum(np.abs(two.a).max(axis=1, initial=0), np.abs(two.b))
            if (apart > LEAPS * whole).any():
                name = self.eom.derived.constraints.constraints[int(np.argmax(apart))].name
                node, quantity = self._node(name, [self.found[k]])
                raise SimulationError(
                    f"Expected a start beside the corners of constraints, got one on a corner of {name!r}: "
                    f"{cut(str(node), 80)} switches at {cut(str(quantity))} = 0, and the constraint allows different "
                    "velocities on its two sides. Start on one side of it."
                )

    def _leap(
        self, t: float, x: Array, given: tuple[Array, Array], before: Array, after: Array, tolerances: Tolerances
    ) -> str:
        """The message on what would have to jump from the sides `before` to those `after`; "" if nothing would."""
        nq, n = len(self.eom.coordinates), len(self.eom.speeds)
        here, there = (self._on(signs, t, x, given) for signs in (before, after))
        names = [c.name for c in self.eom.derived.constraints.constraints]
        turned = [s for s, a, b in zip(self.found, before, after, strict=True) if a != b]
        symbols = (time, *self.eom.state, *self.eom.parameters, *self.eom.inputs)
        values: dict[Expr, float] = dict(
            zip(symbols, [t, *x.tolist(), *given[0].tolist(), *given[1].tolist()], strict=True)
        )
        apart = open_shares(self.eom, there.f - here.f, np.zeros(len(here.f)), values)
        if apart.max(initial=0) > LEAPS:
            return self._kink_message(t, "positions", names[int(np.argmax(apart))], turned)
        u = x[nq : nq + n]
        left = np.abs(there.a @ u + there.b) - np.abs(here.a @ u + here.b)
        terms = np.abs(there.a) @ np.abs(u) + np.abs(there.b)
        rtol, atol = tolerances
        limit = max(LEAPS, _SLACK * rtol) * terms + _SLACK * atol * np.abs(there.a).sum(axis=1)
        off = left / np.maximum(limit, np.finfo(float).tiny)
        return (
            self._kink_message(t, "velocities", names[int(np.argmax(off))], turned)
            if n and off.max(initial=0) > 1
            else ""
        )

    def _on(self, signs: Array, t: float, x: Array, given: tuple[Array, Array]) -> Numbers:
        return self.table.on(tuple(signs.tolist()))(constraint_numbers)(t, x, *given)

    def _kink_message(self, t: float, what: str, name: str, turned: Sequence[SwitchedQuantity]) -> str:
        node, quantity = self._node(name, turned)
        return (
            f"{what} would have to jump at t = {t:.6g}: the constraint {name!r} has a corner there, {cut(str(node), 80)} "
            f"switches at {cut(str(quantity))} = 0. A constraint does not describe the impact: end the motion earlier, smooth "
            "the corner with a small eps, sqrt(c^2 + eps^2) for abs(c), or replace the constraint by a stiff spring"
        )

    def _node(self, name: str, turned: Sequence[SwitchedQuantity]) -> tuple[Expr, Expr]:
        """The switch that occurs in the constraint of that name, else the first one, with its quantity."""
        own = [c.expr for c in self.eom.system.holonomic if c.name == name]
        nodes = set(postorder(own))
        pairs = [(node, s.quantity) for s in turned for node in s.nodes]
        return next((pair for pair in pairs if pair[0] in nodes), pairs[0])


def kinks(numeric: Numeric[Equations]) -> Kinks | None:
    """The switches in the constraints of the equations; None if there are none."""
    found = numeric.value(bends)
    if not found:
        return None
    table = SidedBundles(numeric, [s.quantity for s in found])
    return Kinks(numeric.equations, found, numeric.routine(bending), table)
