# SPDX-License-Identifier: BSD-3-Clause
"""Explicit embedded Runge–Kutta methods as tables of coefficients, whose sums `tests/motion/steppers` checks.

A step of length h from y computes k_s = f(t + c_s h, y + h Σ a_sj k_j), y' = y + h Σ b_j k_j, and k_S = f(t + h, y'), the first k of
the next step. Dense output may take more stages; it is y + h Σ_k φ_k(θ) Σ_j d_kj k_j with φ = θ, θ(1−θ), θ²(1−θ), θ²(1−θ)², …; all
but the first are zero at both ends.
"""

from dataclasses import dataclass

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

    @property
    def stages(self) -> int:
        """The number of evaluations per step, which includes k_S but not k_0."""
        return len(self.b)
