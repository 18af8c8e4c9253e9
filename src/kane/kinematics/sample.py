# SPDX-License-Identifier: BSD-3-Clause
"""Numbers at one configuration drawn at random: they show, before any symbolic work, where matching cannot succeed.

A measure number can only be a sum of whole rows of Y if its coefficients in the speeds are 0, 1 and −1 there.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kane.expr.node import Expr, constant_value
from kane.expr.ops import CONST, PI, SYMBOL
from kane.expr.visit import fold
from kane.kinematics.speeds import Speeds
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED, draw
from kane.numeric.scale import SIX_DIGITS
from kane.space.rotation import Basis
from kane.space.vector import Parts, Vector, axes


@dataclass(frozen=True, eq=False)
class Sample:
    """Random values of a system's symbols, made when first needed; rates run through their unit vectors and zero.

    `values` are those of every expression that was met, `turns` direction cosines, `rooted` measure numbers along the root's axes.
    """

    speeds: Speeds
    seed: int = SEED
    values: dict[Expr, Any] = field(default_factory=dict)
    turns: dict[Basis, Array] = field(default_factory=dict)
    rooted: dict[Parts, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values.update({s: np.float64(v) for s, v in self.values.items() if isinstance(v, float | int)})
        self.values.update(
            zip(self.speeds.rates, np.eye(len(self.speeds.rates), len(self.speeds.rates) + 1), strict=True)
        )
        for group in self.speeds.system.euler_parameters:
            e = np.array([draw(self.seed, s, -1.0, 1.0) for s in group.coordinates])
            self.values.update(zip(group.coordinates, e / np.linalg.norm(e), strict=True))

    def by(self, speeds: Speeds) -> "Sample":
        """The same numbers for other speeds of the same rates."""
        if speeds.rates not in {self.speeds.rates}:
            return Sample(speeds, self.seed)
        return Sample(speeds, self.seed, self.values, self.turns, self.rooted)

    def numbers(self, exprs: Iterable[Expr]) -> list[Any]:
        """Values of expressions, each with one entry a basic rate and one for all rates at rest, or a scalar."""
        with np.errstate(all="ignore"):
            return [fold(e, self.values, self._value) for e in exprs]

    def _value(self, node: Expr) -> Any:
        if node.op is SYMBOL:
            e = self.speeds.euler_rates.get(node)
            return np.float64(draw(self.seed, node)) if e is None else fold(e, self.values, self._value)
        if node.op is CONST:
            return np.float64(constant_value(node) or 0)
        if node.op is PI:
            return np.float64(math.pi)
        return node.op.numpy(*[self.values[a] for a in node.args])

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

    def at_speeds(self, e: Expr) -> float:
        """The value of an expression affine in the rates, these by speeds drawn at random: q̇ = W u + X."""
        known = self.speeds
        numbers = np.broadcast_to(self.numbers([e])[0], (len(known.rates) + 1,))
        u, x = self.numbers(known.speeds), self.numbers(known.x[b] for b in known.rates)
        q_dot = self.inverse @ np.array(u) + np.array(x)
        return float((numbers[:-1] - numbers[-1]) @ q_dot + numbers[-1])

    def coefficients(self, v: Vector) -> Array:
        """What multiplies each speed in the three measure numbers of `v` along the root's axes."""
        total = self.in_root(v)
        return np.asarray((total[:, :-1] - total[:, -1:]) @ self.inverse)

    def in_root(self, v: Vector) -> Array:
        """The three measure numbers of `v` along the root's axes, for each basic rate and for all at rest."""
        if v.parts not in self.rooted:
            width = len(self.speeds.rates) + 1
            total = np.zeros((3, width))
            for frame, triple in v.parts:
                parts = [np.broadcast_to(x, (width,)) for x in self.numbers(triple)]
                total = total + self.turn(frame) @ np.array(parts)
            self.rooted[v.parts] = total
        return self.rooted[v.parts]

    def whole(self, coefficients: Array, frames: Sequence[Basis]) -> list[tuple[int, bool]]:
        """How many measure numbers along each of `frames` may be sums of whole rows, and whether all that are not absent may.

        Where the numbers are not finite nothing is ruled out.
        """
        along = np.array([self.turn(f).T for f in frames]).reshape(-1, 3, 3) @ coefficients
        finite = np.asarray(np.isfinite(along).all(axis=(1, 2)))
        with np.errstate(invalid="ignore"):
            near = np.abs(along - np.clip(np.round(along), -1, 1)).max(axis=2, initial=0) < SIX_DIGITS
            present = np.abs(along).max(axis=2, initial=0) > SIX_DIGITS
        counts, full = (near & present).sum(axis=1), np.asarray(near.all(axis=1) & present.any(axis=1))
        told = zip(counts, full, finite, strict=True)
        return [(int(count), bool(every)) if known else (3, True) for count, every, known in told]
