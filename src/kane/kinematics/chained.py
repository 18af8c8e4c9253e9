# SPDX-License-Identifier: BSD-3-Clause
"""Speeds that measure the whole angular velocity of one link after the other: their rows of Y hold those of the links before.

With ω of a link along axes fixed in the base, in the link or in the one before, three rows are

    u_i = D_i b_i + T u_j + q̇ …

where b_i are rates of the joint's own, D_i are direction cosines of these, and T turns the measure numbers of the link before. So
b_i = D_i⁻¹ (u_i − T u_j): W has two blocks a link. Eliminated as it stands Y fills W below its diagonal, with terms that cancel as
axes are perpendicular, which no rewriting sees.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kane.expr.build import mul, sub
from kane.expr.evaluation import Walk
from kane.expr.irreducible import blocks, matched_columns
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.speeds import is_rate
from kane.model.variables import EulerParameters
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEEDS, draw, unit
from kane.numeric.scale import ROUNDED_CHAIN

Row = Mapping[Expr, Expr]
_AXES = 3


class Chained(NamedTuple):
    """The rows of Y without what they hold of other speeds' rows, and T by the numbers of these."""

    rows: list[dict[Expr, Expr]]
    shares: list[dict[int, Expr]]

    def beyond(self, i: int, speeds: Sequence[Expr], z: Sequence[Expr]) -> Expr:
        """D b of a row, (u − z) less what it has of other speeds."""
        total = sub(speeds[i], z[i])
        for j, c in self.shares[i].items():
            total = sub(total, mul(c, sub(speeds[j], z[j])))
        return total

    def whole(self, inverse: Mapping[Expr, Row], speeds: Sequence[Expr]) -> dict[Expr, dict[Expr, Expr]]:
        """W by rate and speed, from that of the rows apart."""
        shares = {speeds[i]: {speeds[j]: c for j, c in own.items()} for i, own in enumerate(self.shares) if own}
        if not shares:
            return {b: dict(row) for b, row in inverse.items()}
        found: dict[Expr, dict[Expr, Expr]] = {}
        for b, row in inverse.items():
            total = dict(row)
            for u, w in row.items():
                for v, c in shares.get(u, {}).items():
                    total[v] = sub(total.get(v, ZERO), mul(w, c))
            found[b] = {u: w for u, w in total.items() if w is not ZERO}
        return found


def chained(rows: Sequence[Row], rates: Sequence[Expr], sets: Sequence[EulerParameters]) -> Chained:
    """The rows apart; those that are no such sums stay whole."""
    found = Chained([dict(row) for row in rows], [{} for _ in rows])
    if not any(len(row) > _AXES for row in rows):
        return found
    dense = [[row.get(b, ZERO) for b in rates] for row in rows]
    match = matched_columns(dense)
    if min(match, default=0) < 0:
        return found
    irreducible = _by_set(blocks(dense, match), [rates[k] for k in match], sets)
    own = [{rates[match[i]]: None for i in block} for block in irreducible]
    holder = {b: k for k, of in enumerate(own) for b in of}
    held = [{holder[b] for i in block for b in rows[i]} for block in irreducible]
    plain = {next(iter(row)): i for i, row in enumerate(rows) if is_rate(row)}
    for k, block in enumerate(irreducible):
        others = sorted(held[k] - {k})
        before = max(others, key=lambda j: len(held[j]), default=None)
        if before is None or len(block) != _AXES or len(irreducible[before]) != _AXES:
            continue
        beside = [b for j in others if j not in held[before] for b in own[j]]
        if not plain.keys() >= set(beside):
            continue
        inner = {*beside, *own[k]}
        left = [{b: c for b, c in rows[i].items() if b not in inner} for i in block]
        shares = _equal(left, rows, irreducible[before]) or _turned(left, rows, irreducible[before], own[before], sets)
        for i, share in zip(block, shares or (), strict=shares is not None):
            found.shares[i].update(share | {plain[b]: rows[i][b] for b in beside if b in rows[i]})
            found.rows[i] = {b: c for b, c in rows[i].items() if b in own[k]}
    return found


def _by_set(irreducible: Sequence[list[int]], own: Sequence[Expr], sets: Sequence[EulerParameters]) -> list[list[int]]:
    """The blocks, those of the quasi-rates of one set of Euler parameters together; `own` are the rates that rows give."""
    whole: dict[Expr, int] = {w: k for k, group in enumerate(sets) for w in group.quasi}
    found: dict[object, list[int]] = {}
    for number, block in enumerate(irreducible):
        owners = {whole.get(own[i]) for i in block}
        found.setdefault(owners.pop() if len(owners) == 1 and None not in owners else (number,), []).extend(block)
    return list(found.values())


def _equal(left: Sequence[Row], rows: Sequence[Row], block: Sequence[int]) -> list[dict[int, Expr]] | None:
    """T where what is left of each row is another row."""
    places = {frozenset(rows[i].items()): i for i in block}
    found = [places.get(frozenset(row.items())) for row in left]
    return None if None in found else [{i: ONE} for i in found if i is not None]


def _turned(
    left: Sequence[Row], rows: Sequence[Row], block: Sequence[int], own: Iterable[Expr], sets: Sequence[EulerParameters]
) -> list[dict[int, Expr]] | None:
    """T = P Dᵀ of what is left, P of the rates `own` of the rows before, where D Dᵀ = 1 and nothing else is left."""
    columns = sorted({b for i in block for b in rows[i]} | {b for row in left for b in row}, key=lambda b: b.key)
    y = [[rows[i].get(b, ZERO) for b in columns] for i in block]
    p = [[row.get(b, ZERO) for b in columns] for row in left]
    numbers = _numbers([*y, *p], sets)
    before, after = numbers[: len(y)], numbers[len(y) :]
    place = {b: k for k, b in enumerate(columns)}
    inner = [place[b] for b in own]
    d = before[:, inner]
    turn = np.einsum("ik...,jk...->ij...", after[:, inner], d)
    gram = np.einsum("ik...,jk...->ij...", d, d)
    sizes = np.abs(after) + np.einsum("ij...,jk...->ik...", np.abs(turn), np.abs(before))
    off = np.abs(after - np.einsum("ij...,jk...->ik...", turn, before))
    if not (
        np.all(np.abs(gram - np.eye(len(inner))[..., None]) <= ROUNDED_CHAIN) and np.all(off <= ROUNDED_CHAIN * sizes)
    ):
        return None
    return [
        {
            j: x
            for j, line in zip(block, y, strict=True)
            if (x := dot([row[k] for k in inner], [line[k] for k in inner])) is not ZERO
        }
        for row in p
    ]


def _numbers(rows: Sequence[Sequence[Expr]], sets: Sequence[EulerParameters]) -> Array:
    """Values (rows × columns × samples), Euler parameters being those of rotations."""
    walk = Walk([x for row in rows for x in row])
    values = {s: np.array([draw(seed, s, -1.0, 1.0) for seed in SEEDS]) for s in walk.symbols}
    values = unit(values, (group.coordinates for group in sets))
    found = np.array([np.broadcast_to(x, len(SEEDS)) for x in walk(values)], dtype=float)
    return found.reshape(len(rows), -1, len(SEEDS))
