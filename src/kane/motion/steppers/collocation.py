# SPDX-License-Identifier: BSD-3-Clause
"""Gauss's and Radau's nodes on (0, 1] and what follows from them, computed in 50 digits.

L_j is Lagrange's polynomial that is 1 at node j and 0 at the others. By Legendre polynomials P_k and the weights b it is
L_j(θ) = b_j Σ_k (2k+1) P_k(2c_j − 1) P_k(2θ − 1), whose integrals are sums of neighbours: Hairer & Wanner, *Solving Ordinary
Differential Equations II*, 2nd ed. 1996, sec. IV.5.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import localcontext
from functools import cache
from math import cos, pi

from kane.numeric.legendre import DIGITS, D, gauss_nodes, legendre, root

Vector = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Nodes:
    """`c`, `b`: nodes and weights; rows j of the other fields belong to node j.

    `a` holds ∫ L_j from 0 to each node, `a2` is its square as a matrix, `b2` the double integral to 1; `top` is the leading
    coefficient of L_j and its barycentric weight. Row k of `legendre` holds P_k(2c − 1).
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
    """Gauss's nodes, in ascending order."""
    with localcontext() as context:
        context.prec = DIGITS
        x, w = gauss_nodes(stages)
        return _of(x, [legendre(stages + 2, v) for v in x], [v / 2 for v in w])


@cache
def radau(stages: int) -> Nodes:
    """Radau's nodes, in ascending order, of which 1 is the last: the roots of P_s(2c − 1) − P_s−1(2c − 1)."""
    with localcontext() as context:
        context.prec = DIGITS
        x = [root(stages, cos(2 * pi * (stages - k) / (2 * stages - 1)), of=-1) for k in range(1, stages)]
        x = [*sorted(x), D(1)]
        p = [legendre(stages + 2, v) for v in x]
        return _of(x, p, [(1 + v) / 2 / (stages * row[stages - 1]) ** 2 for v, row in zip(x, p, strict=True)])


def _of(x: list[D], p: list[list[D]], b: list[D]) -> Nodes:
    """Nodes at (x + 1)/2 with weights b, and P_0 … there."""
    stages = len(x)
    c = [(v + 1) / 2 for v in x]
    once = [_integrals(row, (v + 1) / 2) for row, v in zip(p, x, strict=True)]
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


def _integrals(p: Sequence[D], theta: D) -> list[D]:
    """∫ P_k(2s − 1) ds from 0 to θ, for all k but the last."""
    return [theta] + [(p[k + 1] - p[k - 1]) / (2 * (2 * k + 1)) for k in range(1, len(p) - 1)]


def integrals(nodes: Nodes, theta: float) -> tuple[Vector, Vector]:
    """∫ L_j and ∫∫ L_j from 0 to θ."""
    count, x = len(nodes.c), D(2 * theta - 1)
    p = legendre(count + 3, x)
    once = _integrals(p, D(theta))
    twice = [D(theta) ** 2 / 2] + [(once[k + 1] - once[k - 1]) / (2 * (2 * k + 1)) for k in range(1, count)]
    rows = [[(2 * k + 1) * b * v for k, v in enumerate(column)] for b, column in _columns(nodes)]
    first, second = ([sum(float(i) * r for i, r in zip(of, row, strict=False)) for row in rows] for of in (once, twice))
    return tuple(first), tuple(second)


def lagrange(nodes: Nodes, theta: float) -> Vector:
    """L_j at θ."""
    p = legendre(len(nodes.c), D(2 * theta - 1))
    return tuple(
        float(sum((2 * k + 1) * float(p[k]) * v for k, v in enumerate(column)) * b) for b, column in _columns(nodes)
    )


def _columns(nodes: Nodes) -> Iterator[tuple[float, Vector]]:
    """Of each node its weight, and P_0 … there."""
    return zip(nodes.b, zip(*nodes.legendre[: len(nodes.c)], strict=True), strict=True)
