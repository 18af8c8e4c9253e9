# SPDX-License-Identifier: BSD-3-Clause
"""Explicit embedded Runge–Kutta methods as tables of numbers, which check their own sums.

A step of length h from y gives k_s = f(t + c_s h, y + h Σ a_sj k_j), y' = y + h Σ b_j k_j, and k_S = f(t + h, y'), which is the first
of the next step. Dense output may take more stages; it is y + h Σ_k φ_k(θ) Σ_j d_kj k_j with φ = θ, θ(1−θ), θ²(1−θ), θ²(1−θ)², …, of
which only the first is not zero at both ends.
"""

import math
from dataclasses import dataclass

from kane.errors import SimulationError

Row = tuple[float, ...]
_ROUNDING = 1e-13


def numbers(text: str) -> tuple[Row, ...]:
    """The rows of a table."""
    lines = text.strip().splitlines()
    return tuple(tuple(map(float, line.split())) for line in lines)


@dataclass(frozen=True, slots=True)
class Tableau:
    """A method of an `order`; `a` holds a row for each stage but the first, `errors` the weights of one or two estimates, k_S counted.

    `exponent` is that of the error in the next step's length, a sum of halves, quarters, …, which takes square roots alone. Of `later`
    stages, for dense output, each row begins with c.
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
            if abs(math.fsum(row) - expected) > _ROUNDING * size:
                raise SimulationError(
                    f"Expected {what} of {self.name} to add up to {expected}, got {math.fsum(row)}: a number is mistyped."
                )
        if self.dense[0][:last] != self.b:
            raise SimulationError(f"Expected dense output of {self.name} that ends at y', got other weights than b.")

    @property
    def stages(self) -> int:
        """Evaluations a step, k_S counted and k_0 not."""
        return len(self.b)
