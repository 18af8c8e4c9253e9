# SPDX-License-Identifier: BSD-3-Clause
"""Nodes and weights of Gauss and Radau collocation on (0, 1], and the transformation of Radau stages for Newton's method.

L_j is the Lagrange polynomial that is 1 at node j and 0 at the others. With Legendre polynomials P_k and the weights b, L_j(θ) =
b_j Σ_k (2k+1) P_k(2c_j − 1) P_k(2θ − 1), whose integrals are differences of neighbouring P_k: Hairer & Wanner, *Solving Ordinary
Differential Equations II*, 2nd ed. 1996, sec. IV.5. Nodes are computed with 50 digits.

z_i is the state at node i minus y. With A⁻¹ = V Λ V⁻¹ the linearized equations Σ_j A⁻¹_ij z_j / h − f(y + z_i) = 0 decouple into
(λ/h − J) x = … for one real eigenvalue λ and for complex conjugate pairs: ibid., sec. IV.8. They are computed in plain Python, with
the same results on every machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import localcontext
from functools import cache
from math import comb, cos, factorial, pi, prod

from kane.numeric.polynomials import DIGITS, D, gauss_nodes, legendre, root

Vector = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Nodes:
    """Nodes `c`, weights `b`, and integrals of the Lagrange polynomials L_j; row j of the other fields belongs to node j.

    `a` contains ∫ L_j from 0 to each node, `a2` the square of this matrix, `b2` the double integrals to 1; `top` contains the
    leading coefficients of the L_j, their barycentric weights. Row k of `legendre` contains P_k(2c − 1).
    """

    c: Vector
    b: Vector
    a: tuple[Vector, ...]
    a2: tuple[Vector, ...]
    b2: Vector
    top: Vector
    legendre: tuple[Vector, ...]


@cache
def gauss(stages: int) -> Nodes:
    """The Gauss nodes, in ascending order."""
    with localcontext() as context:
        context.prec = DIGITS
        x, w = gauss_nodes(stages)
        return _of(x, [legendre(stages + 2, v) for v in x], [v / 2 for v in w])


@cache
def radau(stages: int) -> Nodes:
    """The Radau nodes, in ascending order, the last of which is 1: the roots of P_s(2c − 1) − P_s−1(2c − 1)."""
    with localcontext() as context:
        context.prec = DIGITS
        x = [root(stages, cos(2 * pi * (stages - k) / (2 * stages - 1)), of=-1) for k in range(1, stages)]
        x = [*sorted(x), D(1)]
        p = [legendre(stages + 2, v) for v in x]
        return _of(x, p, [(1 + v) / 2 / (stages * row[stages - 1]) ** 2 for v, row in zip(x, p, strict=True)])


def _of(x: list[D], p: list[list[D]], b: list[D]) -> Nodes:
    """The nodes (x + 1)/2 with weights b; row j of p contains P_0, P_1, … at x_j."""
    stages = len(x)
    c = [(v + 1) / 2 for v in x]
    once = [once_integrated(row, (v + 1) / 2) for row, v in zip(p, x, strict=True)]
    r = range(stages)
    a = [[b[j] * sum((D(2 * k + 1) * p[j][k] * once[i][k] for k in r), D(0)) for i in r] for j in r]
    a2 = [[sum((a[k][i] * a[j][k] for k in r), D(0)) for i in r] for j in r]
    top = []
    for j in r:
        product = D(1)
        for k in r:
            product *= c[j] - c[k] if k != j else 1
        top.append(1 / product)
    legendre = [[p[j][k] for j in r] for k in range(stages + 2)]
    return Nodes(
        _floats(c),
        _floats(b),
        _all(a),
        _all(a2),
        _floats([w * (1 - v) for w, v in zip(b, c, strict=True)]),
        _floats(top),
        _all(legendre),
    )


def _floats(row: Sequence[D]) -> Vector:
    return tuple(map(float, row))


def _all(rows: Sequence[Sequence[D]]) -> tuple[Vector, ...]:
    return tuple(map(_floats, rows))


def once_integrated(p: Sequence[D], theta: D) -> list[D]:
    """∫ P_k(2s − 1) ds from 0 to θ for all k but the last, from the values p of P_k(2θ − 1)."""
    return [theta] + [(p[k + 1] - p[k - 1]) / (2 * (2 * k + 1)) for k in range(1, len(p) - 1)]


_ROUNDS = 200
_BESIDE = 1e-9
Rows = Sequence[Sequence[complex]]


@dataclass(frozen=True, slots=True)
class RadauStages:
    """Nodes `c`, rows of A⁻¹, and its eigenvalues λ: the real one first, then those with a positive imaginary part.

    `split` transforms stages to the real unknowns: x of the real λ, then real and imaginary parts of the others; `joined` transforms
    back. `estimate` contains the e_j for which f(y) + Σ_j e_j z_j/h is f(y) minus the value at 0 of the polynomial through the rates
    of the stages. `lagrange` contains the weights of ∏_j (θ − c_j) θ/(θ − c_i) in the interpolant through y and all stages.
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
    """The nodes and transformations for an odd number of stages."""
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
    """The eigenvalues of A⁻¹: roots of det(1 − z A) = Σ_j C(s, j) (2s − 1 − j)!/(2s − 1)! (−z)^j, by the Weierstrass iteration."""
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
    """The eigenvector, by inverse iteration with a slightly shifted eigenvalue."""
    beside = value * (1 + _BESIDE)
    shifted = [[x - beside * (i == j) for j, x in enumerate(row)] for i, row in enumerate(matrix)]
    result: list[complex] = [1.0] * len(matrix)
    for _ in range(3):
        result = _solved(shifted, result)
        result = [x / result[-1] for x in result]
    return result


def _solved(matrix: Rows, right: Sequence[complex]) -> list[complex]:
    """The solution of a small linear system, by Gauss–Jordan elimination with pivoting."""
    rows = [[*map(complex, row), complex(r)] for row, r in zip(matrix, right, strict=True)]
    for k in range(len(rows)):
        best = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(len(rows)):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]
