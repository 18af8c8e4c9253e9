# SPDX-License-Identifier: BSD-3-Clause
"""The definitions of the generalized speeds, read, checked and inverted."""

import numpy as np

from kane.errors import SingularError, SpeedsError, cut
from kane.expr.build import mul, neg, sub
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.irreducible import structural_rank
from kane.expr.linear_parts import affine_forms
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.solve import invert
from kane.expr.symbols import QuasiRate, Rate, Speed, Symbols, input_of, rate
from kane.expr.visit import substituted
from kane.kinematics.chained import chained
from kane.kinematics.quaternion_rates import blocks, rates_along, turned
from kane.kinematics.speeds import Speeds, is_rate
from kane.model.system import System
from kane.model.variables import basic_rates, rates_by_quasi
from kane.numeric.rank import null_direction
from kane.numeric.sampling import SEED, draw, unit, values_of
from kane.numeric.scale import SPEEDS_RANK, TAKES_PART


def generalized_speeds(system: System) -> Speeds:
    """The speeds' definitions read, checked (affine in the rates, as many as these, independent) and inverted."""
    sets = system.euler_parameters
    rates = basic_rates(system.coordinates, sets)
    euler_rates = rates_by_quasi(sets)
    speeds = tuple(system.speeds)
    rows, z = _definitions(system, rates, euler_rates)
    _check_cover(system, speeds, rows, rates)
    trivial = all(map(is_rate, rows))
    dense = [] if trivial else [[row.get(b, ZERO) for b in rates] for row in rows]
    if not trivial:
        _check_rank(system, speeds, rows, dense, rates)
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
    """W_b by basic rate and speed, what it is divided by, and the rates of Euler parameters that follow from speeds outright.

    Of rows that are direction cosines the inverse is known; what is left of Y sees units in their places. Bare rates need none.
    """
    if not dense:
        return {b: {u: ONE} for u, row in zip(speeds, rows, strict=True) for b in row}, (), {}
    apart = chained(rows, rates, system.euler_parameters)
    for i, row in enumerate(apart.rows):
        if apart.shares[i]:
            dense[i] = [row.get(b, ZERO) for b in rates]
    rows = apart.rows
    perpendicular = {s: found for s in system.euler_parameters if (found := turned(s, rows)) is not None}
    for s, found in perpendicular.items():
        for k, i in enumerate(found.places):
            dense[i] = [ONE if b is s.quasi[k] else ZERO for b in rates]
    turning = blocks(rows, system.euler_parameters)
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
        for k, quasi in enumerate(s.quasi):
            shares = ((speeds[i], found.cosines[row, k]) for row, i in enumerate(found.places))
            w[quasi] = {u: c for u, c in shares if c is not ZERO}
        if found.along is not None:
            values = rates_along(s, [apart.beyond(i, speeds, z) for i in found.along])
            along.update(zip(map(rate, s.coordinates), values, strict=True))
    return apart.whole(w, speeds), tuple(pivots), along


def _definitions(
    system: System, rates: list[Expr], euler_rates: dict[Expr, Expr]
) -> tuple[list[dict[Expr, Expr]], list[Expr]]:
    basic = set(rates)
    told: list[Expr] = []
    for u, definition in system.speeds.items():
        e = substituted(definition, euler_rates) if euler_rates else definition
        for s in free_symbols([e]):
            if isinstance(s, Rate | QuasiRate) and s not in basic and input_of(s) is None:
                raise SpeedsError(
                    f"Expected the definition of {u} in rates of the system's coordinates, got {s}, but no frame or point of the "
                    "system depends on that coordinate. Is a body missing from bodies=? Only what bodies and loads need is part of a "
                    "System."
                )
        told.append(e)
    forms = affine_forms(told, rates)  # the system has seen that they are affine
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
        cure = f"Define {short} more" if short > 0 else f"Leave {-short} of them out: they follow from the others"
        raise SpeedsError(
            f"Expected as many generalized speeds as independent rates, {len(rates)}{extra}: {', '.join(map(str, rates))}; "
            f"got {len(speeds)}: {', '.join(map(str, speeds))}. {cure}."
        )


def _check_rank(
    system: System, speeds: tuple[Speed, ...], rows: list[dict[Expr, Expr]], dense: list[list[Expr]], rates: list[Expr]
) -> None:
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
    """Rates that meet in a row belong to one group."""
    group = {b: i for i, b in enumerate(rates)}
    for row in rows:
        joined = {group[b] for b in row}
        target = min(joined)
        if len(joined) > 1:
            group = {b: target if g in joined else g for b, g in group.items()}
    return group
