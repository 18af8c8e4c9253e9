# SPDX-License-Identifier: BSD-3-Clause
"""Loads that push away from a position or feed energy into the motion at a state: doubtful signs, judged by power.

With v the velocities of the points of a load's forces F (and ω of its torques), and odd parts in the speeds F⁻ = (F(u) − F(−u))/2:

    a damper takes energy,    Σ F⁻·v⁻ ≤ 0,
    a spring pushes back,     Σ (δF·n)(δr·n) ≤ 0,    n = F/|F| at u = 0,

for small displacements δr that the constraints permit. The change of F by rotation with a frame is normal to n and does not count, so
that a compressed spring is not doubtful. Friction that depends on a reaction is not judged, nor the change with position of a load
that depends on speeds and acts on prescribed motion.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.forcing import LoadTerm
from kane.dynamics.readings.quantities import time_derivative
from kane.equations.equations import Equations
from kane.errors import ExpressionError
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Parameter, Reaction, Speed, StateVariable
from kane.expr.visit import substituted
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.rank import singular
from kane.numeric.sampling import SEED
from kane.numeric.scale import STATE_RANK, UNRELATED

DIRECTIONS = 8

Numbers = Mapping[Expr, Any]


class Doubt(NamedTuple):
    """A load that "feeds" energy, with the largest power (W), or "pushes", with the largest stiffness (N/m, N·m), in `most`."""

    load: Load
    does: str
    most: float


def doubtful_loads(eom: Equations, numbers: Numbers) -> Iterator[Doubt]:
    """Loads with a doubtful sign at a state; `numbers` are the time, parameters, inputs, coordinates and speeds."""
    trials = _Trials(eom, numbers, _directions(eom, numbers))
    given = {s: as_expr(float(x)) for s, x in numbers.items() if not isinstance(s, Coordinate | Speed | Parameter)}
    still: dict[Expr, Expr] = {**dict.fromkeys(eom.speeds, ZERO), **given}
    for load, terms in eom.derived.active_terms.items() if len(trials.u) else ():
        symbols = free_symbols([x for term in terms for x in term.vector.scalars()])
        if load.slip is not None or any(isinstance(s, Reaction | StateVariable) for s in symbols):
            continue
        moves = any(isinstance(s, Speed) for s in symbols)
        carried = moves and not all(term.motion.rest.is_zero for term in terms)  # a damper acts even at u = 0
        if moves and (most := _power(trials, terms)) is not None:
            yield Doubt(load, "feeds", most)
        if not carried and (most := _stiffness(trials, terms, still)) is not None:
            yield Doubt(load, "pushes", most)


def _directions(eom: Equations, numbers: Numbers) -> Array:
    """Random speeds (directions × speeds) with A u = 0."""
    n = len(eom.speeds)
    drawn = np.random.default_rng(SEED).normal(size=(DIRECTIONS, n))
    if not len(eom.b):
        return drawn
    a = np.asarray(evaluate(eom.A, numbers), dtype=float)
    if not np.isfinite(a).all():
        return np.zeros((0, n))
    kernel = singular(a).kernel(STATE_RANK)
    return np.asarray(drawn[:, : len(kernel)] @ kernel) if len(kernel) else np.zeros((0, n))


class _Trials(NamedTuple):
    """A state with several speeds u (directions × speeds) in place of its own."""

    eom: Equations
    numbers: Numbers
    u: Array

    def at(self, exprs: Iterable[Expr], sign: int = 1) -> Array:
        """Values of expressions (expressions × directions)."""
        values: dict[Expr, Any] = {**self.numbers, **dict(zip(self.eom.speeds, sign * self.u.T, strict=True))}
        with np.errstate(all="ignore"):
            return np.array([np.broadcast_to(x, (len(self.u),)) for x in evaluate(list(exprs), values)], dtype=float)

    def odd(self, exprs: Sequence[Expr]) -> Array:
        """Odd parts of expressions in the speeds (expressions × directions)."""
        return np.asarray((self.at(exprs) - self.at(exprs, -1)) / 2)

    def velocity(self, term: LoadTerm) -> Array:
        """The velocity of a term's point or frame due to the speeds (3 × directions)."""
        total = np.zeros((3, len(self.u)))
        for k, s in enumerate(self.eom.speeds):
            if s in term.motion.partials:
                partial = self.at(term.motion.partials[s].components(self.eom.system.inertial))
                total = total + partial * self.u[:, k]
        return total


def _power(trials: _Trials, terms: Sequence[LoadTerm]) -> float | None:
    """The largest power of the odd part of a load, if positive in all directions, else None."""
    inertial = trials.eom.system.inertial
    powers = [trials.odd(term.vector.components(inertial)) * trials.velocity(term) for term in terms]
    return _largest(np.sum(powers, axis=(0, 1)), np.abs(powers).sum(axis=(0, 1)))


def _stiffness(trials: _Trials, terms: Sequence[LoadTerm], still: Mapping[Expr, Expr]) -> float | None:
    """The largest growth of a force along itself per displacement of its point, if positive in all directions, else None."""
    total, size, moved = (np.zeros(len(trials.u)) for _ in range(3))
    for term in terms:
        try:
            held = [substituted(x, still) for x in term.vector.components(trials.eom.system.inertial)]
        except ExpressionError:  # the load is not defined at rest
            return None
        change = trials.odd([time_derivative(trials.eom.derived, x) for x in held])
        v, force = trials.velocity(term), trials.at(held)[:, 0]
        along = np.linalg.norm(force)
        size = size + np.linalg.norm(change, axis=0) * np.linalg.norm(v, axis=0)
        if along > 0:
            change, v = force / along @ change, force / along @ v
        total, moved = total + np.atleast_2d(change * v).sum(axis=0), moved + np.atleast_2d(v * v).sum(axis=0)
    found = _largest(total, size)
    return None if found is None else float((total / np.where(moved > 0, moved, 1.0)).max())


def _largest(total: Array, size: Array) -> float | None:
    """The largest of totals, if all are positive beyond rounding, else None."""
    positive = np.isfinite(total) & (total > UNRELATED * size) & (size > 0)
    return float(total.max()) if positive.all() else None
