# SPDX-License-Identifier: BSD-3-Clause
"""Explicit embedded Runge–Kutta methods as tables of coefficients, whose sums are checked.

A step of length h from y computes k_s = f(t + c_s h, y + h Σ a_sj k_j), y' = y + h Σ b_j k_j, and k_S = f(t + h, y'), the first k of
the next step. Dense output may take more stages; it is y + h Σ_k φ_k(θ) Σ_j d_kj k_j with φ = θ, θ(1−θ), θ²(1−θ), θ²(1−θ)², …; all
but the first are zero at both ends.
"""

import math
from dataclasses import dataclass

from kane.errors import SimulationError
from kane.numeric.scale import ROUNDED

Row = tuple[float, ...]


def numbers(text: str) -> tuple[Row, ...]:
    """The rows of a table given as text."""
    lines = text.strip().splitlines()
    return tuple(tuple(map(float, line.split())) for line in lines)


def hermite(b: Row, stages: int = 0) -> tuple[Row, ...]:
    """Dense output by the cubic Hermite interpolant: weights of y' − y, h k_0 − (y' − y), and 2 (y' − y) − h (k_0 + k_S).

    They are padded with zeros to a larger number of `stages`.
    """
    change = (*b, *[0.0] * max(1, stages - len(b)))
    first, last = ([float(j == at) for j in range(len(change))] for at in (0, len(b)))
    return (
        change,
        tuple(e - c for e, c in zip(first, change, strict=True)),
        tuple(2 * c - e - f for c, e, f in zip(change, first, last, strict=True)),
    )


@dataclass(frozen=True, slots=True)
class Tableau:
    """A method of an `order`, with fixed steps if it has no `errors`.

    `a` has a row for each stage but the first; `errors` has the weights of one or two error estimates, including that of k_S.

    `exponent` is the power of the error in the step size control: a sum of halves, quarters, …, which takes square roots alone. A row
    of `later`, the stages for dense output, is c and the row of a.
    """

    name: str
    order: int
    c: Row
    a: tuple[Row, ...]
    b: Row
    errors: tuple[Row, ...]
    exponent: float
    later: tuple[tuple[float, Row], ...]
    dense: tuple[Row, ...]

    def __post_init__(self) -> None:
        rows = [(f"row {s}", row, c) for s, (row, c) in enumerate(zip(self.a, self.c[1:], strict=True), 1)]
        rows += [(f"row {s}", row, c) for s, (c, row) in enumerate(self.later, len(self.b) + 1)]
        rows += [("b", self.b, 1.0)] + [("an error", row, 0.0) for row in self.errors]
        # at θ = 1 the slope of the interpolant is k_S, at θ = 0 it is k_0
        last, begin = len(self.b), self.dense[:2]
        rows += [("the slope at the start", tuple(map(math.fsum, zip(*begin, strict=True))), 1.0)]
        rows += [
            (f"b^{p}", tuple(w * x**p for w, x in zip(self.b, self.c, strict=True)), 1 / (p + 1))
            for p in range(self.order)
        ]
        for what, row, expected in rows:
            size = max(1.0, *map(abs, row))
            if abs(math.fsum(row) - expected) > ROUNDED * size:
                raise SimulationError(
                    f"Expected {what} of {self.name} to add up to {expected}, got {math.fsum(row)}: a number is mistyped."
                )
        if self.dense[0][:last] != self.b:
            raise SimulationError(f"Expected dense output of {self.name} that ends at y', got other weights than b.")

    @property
    def stages(self) -> int:
        """The number of evaluations per step, which includes k_S but not k_0."""
        return len(self.b)
