# SPDX-License-Identifier: BSD-3-Clause
"""Loads that push away or feed the motion at a state: what energy says of signs that no unit and no name gives away.

With velocities v of the places of a load's forces F (and ω of its torques), odd parts in the speeds u written F⁻ = (F(u) − F(−u))/2:

    a damper takes energy,    Σ F⁻·v⁻ ≤ 0,
    a spring pushes back,     Σ (δF·n)(δr·n) ≤ 0,    n = F/|F| at u = 0,

for small motions δr of the places that the constraints permit. What F gains by turning with a frame is across n and does not
count, so that a spring that is pressed is none that pushes away. Friction that holds a reaction is not judged, nor is the push of a
load that depends on speeds where prescribed motion carries it.
"""

from collections.abc import Iterator, Mapping
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
    """A load, and whether it "feeds" or "pushes"; `most` is the largest power (W) found, or change of force by place (N/m, N·m)."""

    load: Load
    does: str
    most: float


def doubtful_loads(eom: Equations, numbers: Numbers) -> Iterator[Doubt]:
    """Loads whose sign energy doubts at a state; `numbers` are the time, parameters, inputs, coordinates and speeds there."""
    u = _directions(eom, numbers)
    still: dict[Expr, Expr] = {}
    still.update((s, ZERO) for s in eom.speeds)
    still.update(
        (s, as_expr(float(x))) for s, x in numbers.items() if not isinstance(s, Coordinate | Speed | Parameter)
    )
    for load, terms in eom.derived.active_terms.items():
        scalars = [x for term in terms for x in term.vector.scalars()]
        symbols = free_symbols(scalars)
        if load.slip is not None or any(isinstance(s, Reaction | StateVariable) for s in symbols) or not len(u):
            continue
        moves = any(isinstance(s, Speed) for s in symbols)
        if moves:
            most = _power(eom, terms, numbers, u)
            if most is not None:
                yield Doubt(load, "feeds", most)
        carried = moves and not all(term.motion.rest.is_zero for term in terms)  # a damper works at u = 0, too
        if not carried:
            most = _stiffness(eom, terms, numbers, still, u)
            if most is not None:
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


def _power(eom: Equations, terms: tuple[LoadTerm, ...], numbers: Numbers, u: Array) -> float | None:
    """The largest power of what is odd in the speeds, where it is positive for all of them."""
    total, size = np.zeros(len(u)), np.zeros(len(u))
    for term in terms:
        exprs = list(term.vector.components(eom.system.inertial))
        force = (_at(eom, exprs, numbers, u) - _at(eom, exprs, numbers, -u)) / 2
        v = _velocity(eom, term, numbers, u)
        total, size = total + (force * v).sum(axis=0), size + np.abs(force * v).sum(axis=0)
    return _largest(total, size)


def _stiffness(
    eom: Equations, terms: tuple[LoadTerm, ...], numbers: Numbers, still: Mapping[Expr, Expr], u: Array
) -> float | None:
    """The largest growth of the force along itself over the motion of its place, where it is positive in all directions."""
    total, size, moved = (np.zeros(len(u)) for _ in range(3))
    for term in terms:
        try:
            held = [substituted(x, still) for x in term.vector.components(eom.system.inertial)]
        except ExpressionError:  # it is not defined at rest
            return None
        rates = [time_derivative(eom.derived, x) for x in held]
        change = (_at(eom, rates, numbers, u) - _at(eom, rates, numbers, -u)) / 2
        v = _velocity(eom, term, numbers, u)
        force = _at(eom, held, numbers, u)[:, 0]
        along = np.linalg.norm(force)
        if along > 0:
            n = force / along
            total, moved = total + (n @ change) * (n @ v), moved + (n @ v) ** 2
        else:
            total, moved = total + (change * v).sum(axis=0), moved + (v * v).sum(axis=0)
        size = size + np.linalg.norm(change, axis=0) * np.linalg.norm(v, axis=0)
    found = _largest(total, size)
    return None if found is None else float((total / np.where(moved > 0, moved, 1.0)).max())


def _at(eom: Equations, exprs: list[Expr], numbers: Numbers, u: Array) -> Array:
    """Values (expressions × directions)."""
    values: dict[Expr, Any] = dict(numbers)
    values.update(zip(eom.speeds, u.T, strict=True))
    with np.errstate(all="ignore"):
        return np.array([np.broadcast_to(x, (len(u),)) for x in evaluate(exprs, values)], dtype=float)


def _velocity(eom: Equations, term: LoadTerm, numbers: Numbers, u: Array) -> Array:
    """What the speeds give of the velocity of a term's place (3 × directions)."""
    total = np.zeros((3, len(u)))
    for k, s in enumerate(eom.speeds):
        if s in term.motion.partials:
            partial = _at(eom, list(term.motion.partials[s].components(eom.system.inertial)), numbers, u)
            total = total + partial * u[:, k]
    return total


def _largest(total: Array, size: Array) -> float | None:
    """The largest of numbers that are all positive, beyond rounding."""
    positive = np.isfinite(total) & (total > UNRELATED * size) & (size > 0)
    return float(total.max()) if positive.all() else None
