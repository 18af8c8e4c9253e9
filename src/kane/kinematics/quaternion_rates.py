# SPDX-License-Identifier: BSD-3-Clause
"""Speeds that measure an angular velocity along perpendicular axes, of a frame that Euler parameters orient.

Their rows of Y, in the quasi-rates w along the frame's own axes, are direction cosines C(e): W has C⁻¹ = Cᵀ, without a divisor. Where
they are along the axes that the frame turns in, Ω = C w, the rates follow without C (Kane, Likins & Levinson 1983, sec. 1.13):

    ė0 = −½ e·Ω,   ė = ½ (e0 Ω + Ω × e)

So is W of speeds that measure a velocity along perpendicular axes: its inverse by a determinant would be divided by what is 1.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kane.expr.build import add, mul, neg
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, constant
from kane.expr.symbols import Coordinate
from kane.model.variables import EulerParameters
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEEDS, draw, unit
from kane.numeric.scale import ROUNDED_CHAIN

_AXES = 3
"""Measure numbers of a vector."""


class Turned(NamedTuple):
    """Three rows of Y that are direction cosines of a set of Euler parameters, by their places, and their entries.

    `along` are the places of those along the axes of the frame that the set turns in, in their order; None where they are others.
    """

    places: tuple[int, ...]
    cosines: Matrix
    along: tuple[int, ...] | None


def turned(group: EulerParameters, rows: Sequence[Mapping[Expr, Expr]]) -> Turned | None:
    """The rows of a set; None where they are not direction cosines, or other rows hold its quasi-rates too."""
    own = set(group.quasi)
    places = tuple(i for i, row in enumerate(rows) if not own.isdisjoint(row))
    if len(places) != len(group.quasi) or not all(own.issuperset(rows[i]) for i in places):
        return None
    cosines = Matrix([[rows[i].get(w, ZERO) for w in group.quasi] for i in places])
    if not set(free_symbols(cosines.entries)) <= set(group.coordinates):
        return None
    pairs = [_sample(group, cosines, seed) for seed in SEEDS]
    if any(np.abs(c @ c.T - np.eye(3)).max() > ROUNDED_CHAIN for c, _ in pairs):
        return None
    return Turned(places, cosines, _along(places, pairs))


def _sample(group: EulerParameters, cosines: Matrix, seed: int) -> tuple[Array, Array]:
    """The rows, and the direction cosines of the set, at unit Euler parameters."""
    drawn = np.array([draw(seed, s, -1.0, 1.0) for s in group.coordinates])
    e = drawn / np.linalg.norm(drawn)
    e0, v = e[0], e[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    numbers = evaluate(cosines, dict(zip(group.coordinates, e.tolist(), strict=True)))
    return np.asarray(numbers, dtype=float), (e0**2 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * e0 * cross


def _along(places: tuple[int, ...], pairs: Sequence[tuple[Array, Array]]) -> tuple[int, ...] | None:
    found = [
        place
        for axis in range(3)
        for k, place in enumerate(places)
        if all(np.abs(c[k] - whole[axis]).max() <= ROUNDED_CHAIN for c, whole in pairs)
    ]
    return tuple(found) if len(found) == len(places) else None


class Block(NamedTuple):
    """Three rows of Y that are direction cosines between rates of lengths, by their places, the rates, and the entries."""

    places: tuple[int, ...]
    rates: tuple[Expr, ...]
    cosines: Matrix


def blocks(rows: Sequence[Mapping[Expr, Expr]], sets: Sequence[EulerParameters]) -> list[Block]:
    """The rows of speeds that measure a velocity along perpendicular axes which turn: v along a body, by ẋ, ẏ, ż."""
    found = []
    for support in {frozenset(row): tuple(row) for row in rows if len(row) == _AXES}.values():
        own = set(support)
        places = tuple(i for i, row in enumerate(rows) if not own.isdisjoint(row))
        if len(places) != len(support) or not all(own.issuperset(rows[i]) for i in places):
            continue
        cosines = Matrix([[rows[i].get(b, ZERO) for b in support] for i in places])
        if _perpendicular(cosines, sets):
            found.append(Block(places, support, cosines))
    return found


def _perpendicular(cosines: Matrix, sets: Sequence[EulerParameters]) -> bool:
    """Whether C Cᵀ = 1 at all samples, at which sets of Euler parameters are unit ones."""
    symbols = free_symbols(cosines.entries)
    if not symbols or not all(isinstance(s, Coordinate) for s in symbols):
        return False
    for seed in SEEDS:
        values = {s: draw(seed, s, -1.0, 1.0) for s in (*symbols, *(e for group in sets for e in group.coordinates))}
        c = np.asarray(evaluate(cosines, unit(values, (s.coordinates for s in sets))), dtype=float)
        if np.abs(c @ c.T - np.eye(len(c))).max() > ROUNDED_CHAIN:
            return False
    return True


def rates_along(group: EulerParameters, w: Sequence[Expr]) -> tuple[Expr, ...]:
    """ė from the angular velocity along the axes that the frame turns in."""
    e0, *e = group.coordinates
    half = constant(0.5)
    first = neg(mul(half, add(add(mul(e[0], w[0]), mul(e[1], w[1])), mul(e[2], w[2]))))
    rest = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        cross = add(mul(w[i], e[j]), neg(mul(w[j], e[i])))
        rest.append(mul(half, add(mul(e0, w[k]), cross)))
    return (first, *rest)
