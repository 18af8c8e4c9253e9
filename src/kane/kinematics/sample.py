# SPDX-License-Identifier: BSD-3-Clause
"""Numbers at one configuration drawn at random: they show, before any symbolic work, where matching cannot succeed.

A measure number can only be a sum of whole rows of Y if its coefficients in the speeds are 0, 1 and −1 there.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.kinematics.speeds import Speeds
from kane.numeric.arrays import Array
from kane.numeric.sample import draw
from kane.space.rotation import Basis
from kane.space.vector import Vector, axes

_SLACK = 1e-6


@dataclass(frozen=True, eq=False)
class Sample:
    """Random values of a system's symbols, made when first needed; rates run through their unit vectors and zero."""

    speeds: Speeds
    seed: int = 20046
    values: dict[Expr, Any] = field(default_factory=dict)
    turns: dict[Basis, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values.update(
            zip(self.speeds.rates, np.eye(len(self.speeds.rates), len(self.speeds.rates) + 1), strict=True)
        )
        for group in self.speeds.system.euler_parameters:
            e = np.array([draw(self.seed, s, -1.0, 1.0) for s in group.coordinates])
            self.values.update(zip(group.coordinates, e / np.linalg.norm(e), strict=True))

    def numbers(self, exprs: Iterable[Expr]) -> list[Any]:
        """Values of expressions, each with one entry a basic rate and one for all rates at rest, or a scalar."""
        wanted = list(exprs)
        numbers: list[Any] = evaluate(wanted, {s: self._value(s) for s in free_symbols(wanted)})
        return numbers

    def _value(self, s: Symbol) -> Any:
        if s not in self.values:
            e = self.speeds.euler_rates.get(s)
            self.values[s] = draw(self.seed, s) if e is None else self.numbers([e])[0]
        return self.values[s]

    def turn(self, frame: Basis) -> Array:
        """Direction cosines of the frame in the root."""
        if frame not in self.turns:
            o = frame.orientation
            if o is None:
                self.turns[frame] = np.eye(3)
            else:
                columns = [self.numbers(axis.components(o.base)) for axis in axes(frame)]
                self.turns[frame] = self.turn(o.base) @ np.array(columns, dtype=float).T
        return self.turns[frame]

    @cached_property
    def inverse(self) -> Array:
        """W: the rates (rates × speeds) of one speed at a time."""
        rates = self.speeds.rates
        numbers = [dict(zip(row, self.numbers(row.values()), strict=True)) for row in self.speeds.rows]
        y = np.array([[row.get(b, 0.0) for b in rates] for row in numbers], dtype=float).reshape(-1, len(rates))
        return np.asarray(np.linalg.pinv(y) if np.isfinite(y).all() else np.full(y.T.shape, np.nan))

    def coefficients(self, v: Vector) -> Array:
        """What multiplies each speed in the three measure numbers of `v` along the root's axes."""
        total = self.in_root(v)
        return np.asarray((total[:, :-1] - total[:, -1:]) @ self.inverse)

    def in_root(self, v: Vector) -> Array:
        """The three measure numbers of `v` along the root's axes, for each basic rate and for all at rest."""
        width = len(self.speeds.rates) + 1
        total = np.zeros((3, width))
        for frame, triple in v.parts:
            parts = [np.broadcast_to(x, (width,)) for x in self.numbers(triple)]
            total = total + self.turn(frame) @ np.array(parts)
        return total

    def whole(self, coefficients: Array, frame: Basis) -> tuple[int, bool]:
        """How many measure numbers along `frame` may be sums of whole rows, and whether all that are not absent may.

        Where the numbers are not finite nothing is ruled out.
        """
        along = self.turn(frame).T @ coefficients
        if not np.isfinite(along).all():
            return 3, True
        near = np.abs(along - np.clip(np.round(along), -1, 1)).max(axis=1, initial=0) < _SLACK
        present = np.abs(along).max(axis=1, initial=0) > _SLACK
        return int((near & present).sum()), bool(near.all() and present.any())
