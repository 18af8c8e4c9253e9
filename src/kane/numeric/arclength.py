# SPDX-License-Identifier: BSD-3-Clause
"""Pseudo-arclength continuation (Keller 1977) of a curve F(y) = 0, where y has one entry more than F; the last entry is μ.

F(y) = 0 is solved together with τ·Δy = Δs, with the tangent τ, so that the equations are regular at turning points of μ too.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from kane.numeric.arrays import Array
from kane.numeric.newton import Residual, close
from kane.numeric.rank import level, singular
from kane.numeric.scale import SAME_TIME, SIX_DIGITS, SOLVED
from kane.progress import far

_FIRST, _LARGEST, _SMALLEST = 0.02, 0.08, 1e-7
"""Steps along the curve, where the whole range of μ counts 1."""
_STRAIGHT = 0.9
"""Least cosine of the angles of a step and of the tangent at its end to the tangent at its beginning, except at corners."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Points of a curve in order, with all steps; `marked` are the points asked for, and `turning` indices of turning points in it."""

    points: tuple[Array, ...]
    marked: tuple[int, ...]
    turning: tuple[int, ...]
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class ImplicitCurve:
    """A curve by its `function` y → F (n), ∂F/∂y (n × n + 1)."""

    function: Residual

    def tangent(self, y: Array, along: Array) -> Array:
        """The unit tangent (n + 1) at y, with a positive component along `along`."""
        direction = singular(level(self.function(y)[1])).right[-1]
        return np.asarray(direction if direction @ along >= 0 else -direction)

    def corrected(self, y: Array, across: Array) -> Array | None:
        """The point of the curve in the plane through y normal to `across`; None if Newton's method fails."""

        def bordered(trial: Array) -> tuple[Array, Array]:
            f, j = self.function(trial)
            return np.append(f, across @ (trial - y)), np.vstack([j, across])

        nearest = close(bordered, y, range(len(y)))
        return nearest.x if nearest.size <= SOLVED else None

    def middle(self, a: Array, b: Array) -> Array | None:
        """The point of the curve in the plane that halves the chord of two points; None if Newton's method fails."""
        chord = b - a
        return self.corrected((a + b) / 2, chord / np.linalg.norm(chord))

    def between(self, a: Array, b: Array, marks: Array) -> list[Array]:
        """The points of the curve at the values `marks` of μ between two points."""
        change = b[-1] - a[-1]
        across = np.eye(len(a))[-1]
        rows = []
        for m in marks if change * (marks[-1] - marks[0]) > 0 else marks[::-1]:
            share = (m - a[-1]) / change
            if SAME_TIME < share <= 1:
                point = self.corrected(np.append((a + share * (b - a))[:-1], m), across)
                rows += [] if point is None else [point]
        return rows

    def fold(self, y: Array, tau: Array, step: float) -> Array:
        """The turning point, at which the tangent has no component along μ, by bisection of a step along τ."""
        low, high, at = 0.0, step, y
        while high - low >= SAME_TIME:
            middle = (low + high) / 2
            point = self.corrected(y + middle * tau, tau)
            if point is None:
                break
            at = point
            if self.tangent(point, tau)[-1] * tau[-1] > 0:
                low = middle
            else:
                high = middle
        return at

    def follow(self, y: Array, marks: Array, max_points: int, where: Callable[[Array], str]) -> Path:
        """The curve from y on, with marked points at the values `marks` of μ and at turning points.

        It ends where μ leaves the range of `marks`. `where` gives the words for a point in the message.
        """
        tau = self.tangent(y, np.sign(marks[-1] - marks[0]) * np.eye(len(y))[-1])
        low, high = sorted((marks[0], marks[-1]))
        points, marked, turning, step = [y], [0], list[int](), _FIRST

        def path(message: str) -> Path:
            return Path(tuple(points[: marked[-1] + 1]), tuple(marked), tuple(turning), message)

        for _ in range(max_points):
            far(partial(where, y))
            new = self.corrected(y + step * tau, tau)
            length = np.inf if new is None else float(np.linalg.norm(new - y))
            if new is None or length > 3 * step:
                step /= 2
                if step < _SMALLEST:
                    return path(f"the branch could not be followed beyond {where(y)}")
                continue
            ahead = self.tangent(new, tau)
            # a chord off the tangent may pass over two turning points, with alike tangents at both ends
            if min(float(ahead @ tau), step / length) < _STRAIGHT and step > 100 * _SMALLEST:
                step /= 2
                continue
            turns = tau[-1] * ahead[-1] < 0
            ends = [y, *([self.fold(y, tau, step)] if turns else []), new]
            for k, (a, b) in enumerate(pairwise(ends)):
                between = self.between(a, b, marks)
                marked += range(len(points), len(points) + len(between))
                points += between
                met = bool(between) and float(np.linalg.norm(between[-1] - b)) < SIX_DIGITS
                if k == 0 and turns:
                    turning.append(len(marked) - met)
                    marked += [] if met else [len(points)]
                points += [] if met else [b]
            y, tau, step = new, ahead, min(1.5 * step, _LARGEST)
            if not low <= y[-1] <= high:
                back = (y[-1] < low) == (marks[0] == low)
                return path("the first value was reached again" if back else "the last value was reached")
        return path(f"{max_points} steps were taken")
