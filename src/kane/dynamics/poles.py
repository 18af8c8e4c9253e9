# SPDX-License-Identifier: BSD-3-Clause
"""False poles: configurations at which W = Y⁻¹ does not exist, although the constraints and the speeds together give the rates.

The speeds and the constraints are u = Y q̇ + z and A_q q̇ + b_q = 0. Where Y is singular, but the columns of [Y; A_q] are independent,
the motion is regular, and so is q̇ as a function of the independent speeds: q̇ follows from [Y_I; A_q]. Only what is written through W
has a pole there. With N the rates that the constraints admit, A_q N = 0, the speeds are those with B u = const., B (Y N) = 0: what
is dependent there is chosen from B.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.constraints.closure import Closure, residual_function, usual_sizes
from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.constraints.steady import follow_everywhere
from kane.dynamics.derived import Derived
from kane.expr.build import div
from kane.expr.diff import jacobian
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.matrix import dot
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Coordinate
from kane.expr.visit import substitute
from kane.model.completed import constraint_rate
from kane.numeric.arrays import Array
from kane.numeric.newton import close
from kane.numeric.rank import DERIVE_RANK, balanced, level, singular
from kane.numeric.sample import sample, values_of

_SEED = 20411
_DRAWN, _SPREAD, _STARTS = 256, 2.0, 3
"""Configurations drawn, how far apart, about, and from how many of them a zero of a pivot is sought."""
_STEPS = 12
"""Steps of Newton's method from each: there p is small already."""
_SMALL = 0.1
"""Share of its usual size that a pivot must fall below at one of them, if it vanishes anywhere."""
_REGULAR = 1e-6
"""Reciprocal condition number above which the speeds count as determined at a pole."""
_ZERO = 1e-9
"""Residual, a pivot's being its share of its usual size, at which it counts as zero where Newton's method ended."""


def without_poles(derived: Derived, partition: Partition | None) -> Partition | None:
    """Dependent speeds with which the motion is regular at false poles; None where none is found.

    Those of `partition`, or, if the user named none and these do not follow alike everywhere else, others that are determined no worse
    at configurations elsewhere.
    """
    pivots = [p for p in derived.kinematical.pivots if any(isinstance(s, Coordinate) for s in free_symbols([p]))]
    if partition is None or not partition.dependent or not pivots:
        return None
    places, f = _Places(derived), derived.conditions.f
    place = {u: i for i, u in enumerate(derived.speeds)}
    named = [place[u] for u in derived.system.dependent_speeds]
    dependent = partition.dependent
    everywhere = follow_everywhere(derived.compared, derived.constraints.a, dependent)
    own = f[len(derived.system.holonomic) :]  # the unit lengths of Euler parameters
    # off the constraints first: there most poles are seen to be true ones, for little
    for conditions in dict.fromkeys((own, f)):
        poles = [b for p in pivots for b in places.admissible(conditions, p) if len(b) == len(dependent)]
        if not poles:
            return None
        usual = [b for b in places.admissible(conditions) if len(b) == len(dependent)]
        sizes = np.max([np.abs(b).max(axis=0) for b in usual], axis=0, initial=0)
        sizes = np.where(sizes > 0, sizes, 1.0)
        reach = np.broadcast_to(sizes, usual[0].shape) if usual else sizes
        others = [] if everywhere else [choose(b, named, reach=reach).dependent for b in usual]
        choices = dict.fromkeys((dependent, *(tuple(sorted(d)) for d in others if len(d) == len(dependent))))
        best = max(choices, key=lambda d: min((_determined(b, d, sizes) for b in usual), default=0.0))
        if not any(_determined(b, best, sizes) > _REGULAR for b in poles):
            return None
    return Partition(partition.rows, best, partition.redundant)


def _determined(b: Array, dependent: Sequence[int], sizes: Array) -> float:
    """How well B u = const. gives the dependent speeds: the least singular value over the largest size, columns divided by `sizes`."""
    values = singular(level(b / sizes)[:, list(dependent)]).values
    return float(values[-1]) if len(values) == len(b) else 0.0


class _Places:
    """Configurations, and Y and A_q in the basic rates there."""

    def __init__(self, derived: Derived) -> None:
        self.system, rates = derived.system, derived.kinematical.rates
        rows = [dot(list(row.values()), list(row)) for row in derived.kinematical.rows]
        euler = derived.kinematical.euler_rates
        held = [constraint_rate(c) for c in self.system.constraints]
        held = [substitute(x, euler) for x in held] if euler else held
        self.linear = (*rows, *held)
        self.unit: dict[Any, Any] = dict(zip(rates, np.eye(len(rates), len(rates) + 1), strict=True))

    def admissible(self, f: tuple[Expr, ...], pivot: Expr | None = None) -> Iterator[Array]:
        """B (rank × n) with B u = const. at configurations with f = 0, and where `pivot` vanishes, if one is given.

        Left out are those at which Y and A_q together do not give the rates.
        """
        q = self.system.coordinates
        if pivot is not None:
            f = (*f, div(pivot, as_expr(sample([pivot], _SEED)[0])))
        values = values_of((*free_symbols([*f, *self.linear]), *q), _SEED, self.unit)
        moving = {*q, *self.unit}
        others = {s: v for s, v in values.items() if s not in moving}
        conditions = Closure((), f, jacobian(f, q))
        closed: list[Array] = list(self._starts(values, pivot))
        if f and closed:
            function, usual = (
                residual_function(self.system, conditions, others),
                usual_sizes(self.system, conditions, others),
            )
            ends = [close(function, x, range(len(q)), steps=_STEPS, sizes=(usual.f, usual.x)) for x in closed]
            closed = [last.x for last in ends if np.abs(last.residual / usual.f).max(initial=0) <= _ZERO]
        if not closed:
            return
        places = np.array(closed).reshape(-1, len(q), 1)
        for b in self._determining(values | {x: places[:, k] for k, x in enumerate(q)}, len(places)):
            if b is not None:
                yield b

    def _starts(self, values: Mapping[Expr, Any], pivot: Expr | None) -> Array:
        """Configurations drawn at random; those at which the pivot is smallest, none where it is nowhere small."""
        q = self.system.coordinates
        begin = np.array([values[x] for x in q])
        drawn = begin + _SPREAD * np.random.default_rng(_SEED).normal(size=(_DRAWN, len(q)))
        place = {x: k for k, x in enumerate(q)}
        for group in self.system.euler_parameters:
            own = [place[e] for e in group.coordinates]
            drawn[:, own] /= np.linalg.norm(drawn[:, own], axis=1, keepdims=True)
        if pivot is None:
            return drawn[:_STARTS]
        with np.errstate(all="ignore"):
            (x,) = evaluate([pivot], {**values, **{c: drawn[:, k] for k, c in enumerate(q)}})
        size = np.abs(np.broadcast_to(x, _DRAWN))
        nearest = np.argsort(size)[:_STARTS]
        return drawn[nearest] if size[nearest[0]] < _SMALL * np.median(size) else drawn[:0]

    def _determining(self, values: Mapping[Expr, Any], count: int) -> Iterator[Array | None]:
        """B (rank × n) with B (Y N) = 0 at each place, its rows orthonormal; None where [Y; A_q] does not give the rates."""
        n = len(self.unit)
        with np.errstate(all="ignore"):
            wide = [np.broadcast_to(x, (count, n + 1)) for x in evaluate(self.linear, values)]
        numbers = np.array(wide, dtype=float).swapaxes(0, 1)
        for both in numbers[..., :n] - numbers[..., n:]:
            if not np.isfinite(both).all() or singular(balanced(both)).rank(DERIVE_RANK) < n:
                yield None
                continue
            admitted = singular(balanced(both[n:])).kernel(DERIVE_RANK)
            yield singular(both[:n] @ admitted.T).cokernel(DERIVE_RANK)
