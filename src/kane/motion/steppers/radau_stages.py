# SPDX-License-Identifier: BSD-3-Clause
"""What Newton's method needs of Radau's collocation: A⁻¹, its eigenvalues and eigenvectors, and the estimate's weights.

z_i is the state at node i less y. With A⁻¹ = V Λ V⁻¹ the equations Σ_j A⁻¹_ij z_j / h − f(y + z_i) = 0, linearized, fall apart into
(λ/h − J) x = … of one real eigenvalue λ and of pairs of conjugate ones: Hairer & Wanner, *Solving Ordinary Differential Equations II*,
2nd ed. 1996, sec. IV.8. Plain Python computes them, so that they are the same numbers on every machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb, factorial, prod

from kane.motion.steppers.collocation import Vector, radau

_ROUNDS = 200
_BESIDE = 1e-9
Rows = Sequence[Sequence[complex]]


@dataclass(frozen=True, slots=True)
class RadauStages:
    """Nodes c; rows of A⁻¹; λ, the real one first, then those above the real axis.

    `split` are rows that take stages to the real unknowns: x of the real λ, then real and imaginary part of each other one; `joined`
    takes these back. `estimate` are the weights of z/h beside f(y): the rates at the beginning less their polynomial through the
    stages there. `lagrange` are those of ∏_j (θ − c_j) θ/(θ − c_i), of the interpolant through y and all stages.
    """

    c: Vector
    inverse: tuple[Vector, ...]
    eigenvalues: tuple[complex, ...]
    split: tuple[Vector, ...]
    joined: tuple[Vector, ...]
    estimate: Vector
    lagrange: Vector


@cache
def radau_stages(count: int) -> RadauStages:
    """Of an odd number of stages."""
    nodes, each = radau(count), range(count)
    c, a = nodes.c, [[nodes.a[j][i] for j in each] for i in each]
    columns = [_solved(a, [float(i == j) for i in each]) for j in each]
    inverse = [[columns[j][i].real for j in each] for i in each]
    values = _eigenvalues(count)
    split: list[Vector] = []
    joined: list[Vector] = []
    for k, value in enumerate(values):
        right, left = (_vector(m, value) for m in (inverse, [list(row) for row in zip(*inverse, strict=True)]))
        share = sum(x * y for x, y in zip(left, right, strict=True))
        left = [x / share for x in left]
        split.append(tuple(x.real for x in left))
        joined.append(tuple((x if k == 0 else 2 * x).real for x in right))
        if k:
            split.append(tuple(x.imag for x in left))
            joined.append(tuple(-2 * x.imag for x in right))
    at_start = [prod(c[j] / (c[j] - c[i]) for j in each if j != i) for i in each]
    return RadauStages(
        c,
        tuple(map(tuple, inverse)),
        tuple(values),
        tuple(split),
        tuple(zip(*joined, strict=True)),
        tuple(-sum(at_start[i] * inverse[i][j] for i in each) for j in each),
        tuple(x / y for x, y in zip(nodes.top, c, strict=True)),
    )


def _eigenvalues(count: int) -> list[complex]:
    """The roots of det(1 − z A) = Σ_j C(s, j) (2s − 1 − j)!/(2s − 1)! (−z)^j, by Weierstrass's iteration."""
    whole = factorial(2 * count - 1)
    parts = [(-1) ** j * comb(count, j) * factorial(2 * count - 1 - j) / whole for j in range(count + 1)]
    roots = [count * (0.4 + 0.9j) ** k for k in range(count)]
    for _ in range(_ROUNDS):
        for k, z in enumerate(roots):
            value = sum(p * z**j for j, p in enumerate(parts))
            roots[k] -= value / (parts[-1] * prod(z - other for i, other in enumerate(roots) if i != k))
    real = min(roots, key=lambda z: abs(z.imag)).real
    above = [z for z in roots if z.imag > _BESIDE * abs(z)]
    return [complex(real), *sorted(above, key=lambda z: z.imag)]


def _vector(matrix: Rows, value: complex) -> list[complex]:
    """The eigenvector, by inverse iteration from beside its value."""
    beside = value * (1 + _BESIDE)
    shifted = [[x - beside * (i == j) for j, x in enumerate(row)] for i, row in enumerate(matrix)]
    found: list[complex] = [1.0] * len(matrix)
    for _ in range(3):
        found = _solved(shifted, found)
        found = [x / found[-1] for x in found]
    return found


def _solved(matrix: Rows, right: Sequence[complex]) -> list[complex]:
    """The solution of a small system, by Gauss's elimination."""
    rows = [[*map(complex, row), complex(r)] for row, r in zip(matrix, right, strict=True)]
    for k in range(len(rows)):
        best = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(len(rows)):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]
