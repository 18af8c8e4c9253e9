# SPDX-License-Identifier: BSD-3-Clause
"""Numbers at one configuration drawn at random: they show, before any symbolic work, where matching cannot succeed.

A measure number can only be a sum of whole rows of Y if its coefficients in the speeds are 0, 1 and −1 there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr
from kane.kinematics.speeds import Speeds
from kane.numeric.arrays import Array
from kane.numeric.sample import draw
from kane.space.rotation import Basis
from kane.space.vector import Vector, axes

_SLACK = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Random values of a system's symbols, made when first needed; rates run through their unit vectors and zero."""

    speeds: Speeds
    seed: int = 20046
    values: dict[Expr, Any] = field(default_factory=dict)
    turns: dict[Basis, Array] = field(default_factory=dict)
    inverse: list[Array] = field(default_factory=list)

    def numbers(self, exprs: Iterable[Expr]) -> list[Any]:
        """Values of expressions, each with one entry a basic rate and one for all rates at rest, or a scalar."""
        wanted = list(exprs)
        if not self.values:
            units = np.eye(len(self.speeds.rates), len(self.speeds.rates) + 1)
            self.values.update(zip(self.speeds.rates, units, strict=True))
            for group in self.speeds.system.euler_parameters:
                e = np.array([draw(self.seed, s, -1.0, 1.0) for s in group.coordinates])
                self.values.update(zip(group.coordinates, e / np.linalg.norm(e), strict=True))
        for s in free_symbols(wanted):
            if s in self.speeds.euler_rates:
                self.values[s] = self.numbers([self.speeds.euler_rates[s]])[0]
            elif s not in self.values:
                self.values[s] = draw(self.seed, s)
        numbers: list[Any] = evaluate(wanted, {s: self.values[s] for s in free_symbols(wanted)})
        return numbers

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

    def coefficients(self, v: Vector) -> Array:
        """What multiplies each speed in the three measure numbers of `v` along the root's axes."""
        width = len(self.speeds.rates) + 1
        if not self.inverse:
            rows = np.zeros((len(self.speeds.rows), width - 1))
            place = {b: k for k, b in enumerate(self.speeds.rates)}
            for i, row in enumerate(self.speeds.rows):
                for (b, _), x in zip(row.items(), self.numbers(row.values()), strict=True):
                    rows[i, place[b]] = x
            inverse = np.linalg.pinv(rows) if np.isfinite(rows).all() else np.full(rows.T.shape, np.nan)
            self.inverse.append(np.asarray(inverse, dtype=np.float64))
        total = np.zeros((3, width))
        for frame, triple in v.parts:
            parts = [np.broadcast_to(x, (width,)) for x in self.numbers(triple)]
            total = total + self.turn(frame) @ np.array(parts)
        return np.asarray((total[:, :-1] - total[:, -1:]) @ self.inverse[0])

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
