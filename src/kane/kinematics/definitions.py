# SPDX-License-Identifier: BSD-3-Clause
"""Generalized speeds from their definitions u = Y q̇ + z (Kane & Levinson 1985, sec. 2.12): Y and z are read, checked and inverted.

Three rows of Y that are direction cosines C need no elimination, whose divisors would be 1: C⁻¹ = Cᵀ. They belong to speeds that are
measure numbers of an angular velocity, in the quasi-rates of Euler parameters, or of a velocity along perpendicular axes. If the
angular velocity is measured along the axes of the frame that rotates, ė follows without C (Kane, Likins & Levinson 1983, sec. 1.13):

    ė0 = −½ e·Ω,   ė = ½ (e0 Ω + Ω × e)

If the speeds of each link in a chain are the measure numbers of its angular velocity in the inertial frame, rows of Y contain those
of the preceding links. With ω of a link along axes fixed in the base, in the link or in the preceding link, three rows are

    u_i = D_i b_i + T u_j + q̇ …

where b_i are the rates of the link's own joint, D_i their direction cosines, and T rotates the measure numbers of the preceding link.
Then b_i = D_i⁻¹ (u_i − T u_j), and W has two blocks per link. Elimination of Y as a whole would fill W below its diagonal with terms
that cancel only because axes are perpendicular, which algebraic rewriting does not detect.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kane.errors import SingularError, SpeedsError, cut
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Walk, evaluate, free_symbols
from kane.expr.matrix import Matrix, blocks, dot, invert, matched_columns, structural_rank
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.symbols import Coordinate, QuasiRate, Rate, Speed, Symbols, input_of, rate
from kane.expr.visit import substituted
from kane.kinematics.speeds import Row, Speeds, is_rate
from kane.model.declarations import EulerParameters, basic_rates, rates_by_quasi
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.rank import null_direction
from kane.numeric.sampling import SEED, SEEDS, draw, unit, values_of
from kane.numeric.scale import ROUNDED_CHAIN, SPEEDS_RANK, TAKES_PART
from kane.space.attitude_formulas import cosines_of


def generalized_speeds(system: System) -> Speeds:
    """Y, z, W and X of a system's speeds. SpeedsError unless definitions are as many as the rates and independent."""
    sets = system.euler_parameters
    rates = basic_rates(system.coordinates, sets)
    euler_rates = rates_by_quasi(sets)
    speeds = tuple(system.speeds)
    rows, z = _definitions(system, rates, euler_rates)
    _check_cover(system, speeds, rows, rates)
    trivial = all(map(is_rate, rows))
    dense = [] if trivial else [[row.get(b, ZERO) for b in rates] for row in rows]
    if not trivial:
        _check_rank(system, speeds, dense, rates)
    w, pivots, along = _inverted(system, speeds, rows, z, dense, rates)
    x: dict[Expr, Expr] = {}
    for b in rates:
        rest = ZERO
        for i, u in enumerate(speeds):
            if u in w[b] and z[i] is not ZERO:
                rest = sub(rest, mul(w[b][u], z[i]))
        x[b] = rest
    by_row: dict[frozenset[tuple[Expr, Expr]], dict[int, Expr]] = {}
    for i, row in enumerate(rows):
        by_row[frozenset(row.items())] = {i: ONE}
        by_row[frozenset((b, neg(c)) for b, c in row.items())] = {i: neg(ONE)}
    return Speeds(
        system, Symbols(speeds), tuple(rates), tuple(rows), tuple(z), w, x, pivots, euler_rates, along, _groups(rates, rows),
        by_row, not trivial,
    )  # fmt: skip


def _inverted(
    system: System,
    speeds: tuple[Speed, ...],
    rows: list[dict[Expr, Expr]],
    z: list[Expr],
    dense: list[list[Expr]],
    rates: list[Expr],
) -> tuple[dict[Expr, dict[Expr, Expr]], tuple[Expr, ...], dict[Expr, Expr]]:
    """W_b by basic rate and speed, the pivots of the elimination, and ė of Euler parameters that follow from speeds without W.

    Rows that are direction cosines are inverted by transposition and replaced by unit rows in the elimination of the rest of Y.
    """
    if not dense:
        return {b: {u: ONE} for u, row in zip(speeds, rows, strict=True) for b in row}, (), {}
    apart = chained(rows, rates, system.euler_parameters)
    for i, row in enumerate(apart.rows):
        if apart.shares[i]:
            dense[i] = [row.get(b, ZERO) for b in rates]
    rows = apart.rows
    perpendicular = {s: found for s in system.euler_parameters if (found := turned(s, rows)) is not None}
    turning = [*cosine_blocks(rows, system.euler_parameters), *perpendicular.values()]
    for block in turning:
        for i, own in zip(block.places, block.rates, strict=True):
            dense[i] = [ONE if b is own else ZERO for b in rates]
    try:
        inverse, pivots = invert(dense)
    except SingularError as error:
        raise SpeedsError(f"Expected independent generalized speeds: {error}") from error
    w: dict[Expr, dict[Expr, Expr]] = {
        b: {u: c for u, c in zip(speeds, row, strict=True) if c is not ZERO}
        for b, row in zip(rates, inverse, strict=True)
    }
    for block in turning:
        for b, column in zip(block.rates, block.cosines.T, strict=True):
            w[b] = {speeds[i]: c for i, c in zip(block.places, column, strict=True) if c is not ZERO}
    along: dict[Expr, Expr] = {}
    for s, found in perpendicular.items():
        places = _along(s, found)
        if places is not None:
            values = rates_along(s, [apart.beyond(i, speeds, z) for i in places])
            along.update(zip(map(rate, s.coordinates), values, strict=True))
    return apart.whole(w, speeds), tuple(pivots), along


def _definitions(
    system: System, rates: list[Expr], euler_rates: dict[Expr, Expr]
) -> tuple[list[dict[Expr, Expr]], list[Expr]]:
    basic = set(rates)
    exprs: list[Expr] = []
    for u, definition in system.speeds.items():
        e = substituted(definition, euler_rates) if euler_rates else definition
        for s in free_symbols([e]):
            if isinstance(s, Rate | QuasiRate) and s not in basic and input_of(s) is None:
                raise SpeedsError(
                    f"Expected the definition of {u} in rates of the system's coordinates, got {s}, but no frame or point of the "
                    "system depends on that coordinate. Is a body missing from bodies=? Only what bodies and loads need is part of a "
                    "System."
                )
        exprs.append(e)
    forms = affine_forms(exprs, rates)  # `System` has checked that they are affine
    return [row for row, _ in forms], [rest for _, rest in forms]


def _check_cover(system: System, speeds: tuple[Speed, ...], rows: list[dict[Expr, Expr]], rates: list[Expr]) -> None:
    covered = {b for row in rows for b in row}
    missing = [b for b in rates if b not in covered]
    if missing:
        raise SpeedsError(
            f"Expected every rate in some speed's definition, got none with {', '.join(map(str, missing))}. Define a speed "
            'for each, for instance u = q.dt, or pass speeds="rates" to take u = q\' throughout.'
        )
    if len(speeds) != len(rates):
        extra = "" if not system.euler_parameters else " (each set of Euler parameters needs three)"
        short = len(rates) - len(speeds)
        some = ", or only those that constraints leave independent" if system.constraints else ""
        cure = f"Define {short} more{some}" if short > 0 else f"Leave {-short} of them out: they follow from the others"
        raise SpeedsError(
            f"Expected as many generalized speeds as independent rates, {len(rates)}{extra}: {', '.join(map(str, rates))}; "
            f"got {len(speeds)}: {', '.join(map(str, speeds))}. {cure}."
        )


def _check_rank(system: System, speeds: tuple[Speed, ...], dense: list[list[Expr]], rates: list[Expr]) -> None:
    structural = structural_rank(dense, len(rates))
    if structural < len(rates):
        raise SpeedsError(
            f"Expected independent definitions of {', '.join(map(str, speeds))}, got structural rank {structural} of "
            f"{len(rates)}: some of them share too few rates. Define one of them differently."
        )
    symbols = free_symbols(x for row in dense for x in row)
    numbers = values_of(symbols, SEED, {s: draw(SEED, s) for s in symbols if s.default == 0})
    numbers = unit(numbers, (s.coordinates for s in system.euler_parameters))
    y = np.asarray(evaluate(Matrix(dense), numbers), dtype=float)
    vanishing = null_direction(y.T, SPEEDS_RANK)
    if vanishing is not None:
        culprits = [u for u, c in zip(speeds, vanishing, strict=True) if abs(c) > TAKES_PART]
        said = ", ".join(f"{u} = {cut(system.speeds[u], 80)}" for u in culprits)
        raise SpeedsError(
            f"Expected independent definitions of the generalized speeds, got a combination of {', '.join(map(str, culprits))} that "
            f"vanishes at every configuration, so that W does not exist: {said}. Define one of them differently."
        )


def _groups(rates: list[Expr], rows: list[dict[Expr, Expr]]) -> dict[Expr, int]:
    """The number of each rate's group: rates in one row belong to one group."""
    group = {b: i for i, b in enumerate(rates)}
    for row in rows:
        joined = {group[b] for b in row}
        target = min(joined)
        if len(joined) > 1:
            group = {b: target if g in joined else g for b, g in group.items()}
    return group


# Rows that are direction cosines ------------------------------------------------------------------------------------

_AXES = 3
"""The number of measure numbers of a vector."""


class CosineRows(NamedTuple):
    """Three rows of Y that are direction cosines: their indices (`places`), the rates of their columns, and the entries (3, 3)."""

    places: tuple[int, ...]
    rates: tuple[Expr, ...]
    cosines: Matrix


def _cosine_rows(rows: Sequence[Row], rates: Sequence[Expr], sets: Sequence[EulerParameters]) -> CosineRows | None:
    """The rows with any of `rates`; None if they are not as many, contain other rates, or C Cᵀ ≠ 1 at sampled values."""
    own = set(rates)
    places = tuple(i for i, row in enumerate(rows) if not own.isdisjoint(row))
    if len(places) != len(rates) or not all(own.issuperset(rows[i]) for i in places):
        return None
    cosines = Matrix([[rows[i].get(b, ZERO) for b in rates] for i in places])
    if not all(isinstance(s, Coordinate) for s in free_symbols(cosines.entries)):
        return None
    if _off_unit(_values(cosines.rows, sets)) > ROUNDED_CHAIN:
        return None
    return CosineRows(places, tuple(rates), cosines)


def turned(group: EulerParameters, rows: Sequence[Row]) -> CosineRows | None:
    """The rows of the quasi-rates of a set of Euler parameters, if they are direction cosines of these parameters alone, else None."""
    found = _cosine_rows(rows, group.quasi, [group])
    return found if found and set(free_symbols(found.cosines.entries)) <= set(group.coordinates) else None


def cosine_blocks(rows: Sequence[Row], sets: Sequence[EulerParameters]) -> list[CosineRows]:
    """The rows of speeds that are measure numbers of a velocity along rotating perpendicular axes, as v along a body by ẋ, ẏ, ż."""
    supports = {frozenset(row): tuple(row) for row in rows if len(row) == _AXES}
    found = [_cosine_rows(rows, support, sets) for support in supports.values()]
    return [block for block in found if block and free_symbols(block.cosines.entries)]


def _along(group: EulerParameters, found: CosineRows) -> tuple[int, ...] | None:
    """The indices of the rows along the x, y, z axes of the frame relative to which a set rotates; None if they are along others."""
    whole = Matrix(cosines_of(np.array(group.coordinates, dtype=object), unit=True))
    numbers = _values([*found.cosines.rows, *whole.rows], [group])
    axes = [
        place
        for axis in numbers[_AXES:]
        for place, row in zip(found.places, numbers, strict=False)
        if np.abs(row - axis).max() <= ROUNDED_CHAIN
    ]
    return tuple(axes) if len(axes) == _AXES else None


def rates_along(group: EulerParameters, w: Sequence[Expr]) -> tuple[Expr, ...]:
    """ė from the angular velocity w along the axes of the frame relative to which the set rotates."""
    e0, *e = group.coordinates
    half = constant(0.5)
    first = neg(mul(half, add(add(mul(e[0], w[0]), mul(e[1], w[1])), mul(e[2], w[2]))))
    rest = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        cross = add(mul(w[i], e[j]), neg(mul(w[j], e[i])))
        rest.append(mul(half, add(mul(e0, w[k]), cross)))
    return (first, *rest)


class Chained(NamedTuple):
    """The rows D_i of Y without the parts T u_j of preceding links, and the entries of T by the index j of the speed."""

    rows: list[dict[Expr, Expr]]
    shares: list[dict[int, Expr]]

    def beyond(self, i: int, speeds: Sequence[Expr], z: Sequence[Expr]) -> Expr:
        """D b of row i: u_i − z_i − Σ T_ij (u_j − z_j)."""
        total = sub(speeds[i], z[i])
        for j, c in self.shares[i].items():
            total = sub(total, mul(c, sub(speeds[j], z[j])))
        return total

    def whole(self, inverse: Mapping[Expr, Row], speeds: Sequence[Expr]) -> dict[Expr, dict[Expr, Expr]]:
        """W by rate and speed, from the inverse of the separated rows."""
        shares = {speeds[i]: {speeds[j]: c for j, c in own.items()} for i, own in enumerate(self.shares) if own}
        if not shares:
            return {b: dict(row) for b, row in inverse.items()}
        result: dict[Expr, dict[Expr, Expr]] = {}
        for b, row in inverse.items():
            total = dict(row)
            for u, w in row.items():
                for v, c in shares.get(u, {}).items():
                    total[v] = sub(total.get(v, ZERO), mul(w, c))
            result[b] = {u: w for u, w in total.items() if w is not ZERO}
        return result


def chained(rows: Sequence[Row], rates: Sequence[Expr], sets: Sequence[EulerParameters]) -> Chained:
    """The rows of Y separated by link; rows without the form D_i b_i + T u_j + q̇ … are unchanged."""
    result = Chained([dict(row) for row in rows], [{} for _ in rows])
    if not any(len(row) > _AXES for row in rows):
        return result
    dense = [[row.get(b, ZERO) for b in rates] for row in rows]
    match = matched_columns(dense)
    if min(match, default=0) < 0:
        return result
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
        shares = _equal(left, rows, irreducible[before]) or _turned_before(
            left, rows, irreducible[before], own[before], sets
        )
        for i, share in zip(block, shares or (), strict=shares is not None):
            result.shares[i].update(share | {plain[b]: rows[i][b] for b in beside if b in rows[i]})
            result.rows[i] = {b: c for b, c in rows[i].items() if b in own[k]}
    return result


def _by_set(irreducible: Sequence[list[int]], own: Sequence[Expr], sets: Sequence[EulerParameters]) -> list[list[int]]:
    """The blocks, with those of one set of Euler parameters merged; `own` is the rate matched to each row."""
    whole: dict[Expr, int] = {w: k for k, group in enumerate(sets) for w in group.quasi}
    found: dict[object, list[int]] = {}
    for number, block in enumerate(irreducible):
        owners = {whole.get(own[i]) for i in block}
        found.setdefault(owners.pop() if len(owners) == 1 and None not in owners else (number,), []).extend(block)
    return list(found.values())


def _equal(left: Sequence[Row], rows: Sequence[Row], block: Sequence[int]) -> list[dict[int, Expr]] | None:
    """T if the remainder of each row equals another row, else None."""
    places = {frozenset(rows[i].items()): i for i in block}
    found = [places.get(frozenset(row.items())) for row in left]
    return None if None in found else [{i: ONE} for i in found if i is not None]


def _turned_before(
    left: Sequence[Row], rows: Sequence[Row], block: Sequence[int], own: Iterable[Expr], sets: Sequence[EulerParameters]
) -> list[dict[int, Expr]] | None:
    """T = P Dᵀ, where P and D are the columns of rates `own` in the remainders and in the rows of the preceding link.

    None unless, at sampled values, D Dᵀ = 1 and T times those rows is the whole remainder.
    """
    columns = sorted({b for i in block for b in rows[i]} | {b for row in left for b in row}, key=lambda b: b.key)
    y = [[rows[i].get(b, ZERO) for b in columns] for i in block]
    p = [[row.get(b, ZERO) for b in columns] for row in left]
    numbers = _values([*y, *p], sets)
    before, after = numbers[: len(y)], numbers[len(y) :]
    place = {b: k for k, b in enumerate(columns)}
    inner = [place[b] for b in own]
    d = before[:, inner]
    turn = np.einsum("ik...,jk...->ij...", after[:, inner], d)
    sizes = np.abs(after) + np.einsum("ij...,jk...->ik...", np.abs(turn), np.abs(before))
    off = np.abs(after - np.einsum("ij...,jk...->ik...", turn, before))
    if not (_off_unit(d) <= ROUNDED_CHAIN and np.all(off <= ROUNDED_CHAIN * sizes)):
        return None
    return [
        {
            j: x
            for j, line in zip(block, y, strict=True)
            if (x := dot([row[k] for k in inner], [line[k] for k in inner])) is not ZERO
        }
        for row in p
    ]


def _values(rows: Sequence[Sequence[Expr]], sets: Sequence[EulerParameters]) -> Array:
    """Sampled values (rows × columns × samples); Euler parameters have unit length."""
    walk = Walk([x for row in rows for x in row])
    groups = [group.coordinates for group in sets]
    drawn = dict.fromkeys((*walk.symbols, *(e for group in groups for e in group)))
    values = unit({s: np.array([draw(seed, s, -1.0, 1.0) for seed in SEEDS]) for s in drawn}, groups)
    found = np.array([np.broadcast_to(x, len(SEEDS)) for x in walk(values)], dtype=float)
    return found.reshape(len(rows), -1, len(SEEDS))


def _off_unit(d: Array) -> float:
    """The largest entry of |D Dᵀ − 1| over the samples of D (3 × n × samples)."""
    gram = np.einsum("ik...,jk...->ij...", d, d)
    return float(np.abs(gram - np.eye(len(d))[..., None]).max())
