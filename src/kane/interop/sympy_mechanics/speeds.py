# SPDX-License-Identifier: BSD-3-Clause
"""Definitions of speeds from kinematical equations k_q q̇ + k_u u + f = 0, whose number may differ from that of the speeds.

As many equations as k_u has independent rows are solved for speeds. Further equations are motion constraints; a speed that no equation
determines is the rate of an additional coordinate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kane.errors import ModelError
from kane.expr.build import add, mul, neg, sum_of
from kane.expr.matrix import solve_linear
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, QuasiRate, Speed, rate
from kane.expr.visit import substituted
from kane.interop.driven import GivenRates, independent_rows
from kane.interop.imported import Remarks
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.states import Kinematical, States
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_SUM


@dataclass(slots=True)
class Definitions:
    """The speeds in terms of rates, expressions that vanish as additional speeds, and additional coordinates."""

    speeds: dict[Speed, Expr] = field(default_factory=dict)
    vanishing: dict[Speed, Expr] = field(default_factory=dict)
    coordinates: list[Coordinate] = field(default_factory=list)

    def in_rates(self, e: Expr) -> Expr:
        """`e` with speeds replaced by their definitions."""
        return substituted(e, dict[Expr, Expr](self.speeds.items()))


def define(
    known: Translation, kinematical: Kinematical,
    sets: dict[tuple[Coordinate, ...], tuple[QuasiRate, ...]], states: States, remarks: Remarks,
) -> Definitions:  # fmt: skip
    """The definitions of SymPy's speeds."""
    (basic, rows), speeds = _equations(known, kinematical, sets, states), known.speeds
    numbers = states.of([x for row in rows for x in row]).reshape(len(rows), len(speeds), -1)
    chosen = independent_rows(numbers)
    columns = independent_rows(numbers[chosen].transpose(1, 0, 2))
    result = Definitions()
    for k, u in enumerate(speeds):
        if k not in columns:
            q = Coordinate.declare(known.names.free(f"integral_{u.name}"), None, "", f"∫ {u.name} dt")
            result.speeds[u] = rate(q)
            result.coordinates.append(q)
            states.enter(q, u)
            remarks.say("inferred", f"a coordinate {q.name} for the speed {u.name}, which is the rate of no coordinate")
    free = [k for k in range(len(speeds)) if k not in columns]
    left = [_less(basic[i], rows[i], speeds, result.speeds, free) for i in chosen]
    solved = solve_linear([[rows[i][k] for k in columns] for i in chosen], left) if chosen else ()
    result.speeds |= {speeds[k]: e for k, e in zip(columns, solved, strict=True)}
    result.speeds = {u: result.speeds[u] for u in speeds}
    for i in (i for i in range(len(rows)) if i not in chosen):
        row = _less(basic[i], rows[i], speeds, result.speeds, range(len(speeds)))
        result.vanishing[_held(known, f"kinematical equation {i + 1}")] = row
        remarks.say("changed", f"the kinematical equation {i + 1}, which defines no speed, to a motion constraint")
    return result


def _held(known: Translation, of: str) -> Speed:
    return Speed.declare(known.names.free("w"), None, "", f"vanishes: {of}")


def follow(found: Definitions, further: Sequence[GivenRates], known: Translation) -> None:
    """Adds coordinates that SymPy's model lacks, with their equations as vanishing speeds."""
    for more in further:
        found.coordinates += more.coordinates
        for left, right in more.rates:
            own = next(iter(more.coordinates)).name
            found.vanishing[_held(known, f"{own} follows from its velocity")] = found.in_rates(left - right)


def _less(
    basic: Expr, row: Sequence[Expr], speeds: Sequence[Speed], by: dict[Speed, Expr], over: Sequence[int]
) -> Expr:
    """`basic` − Σ row u over some of the speeds."""
    for k in over:
        if row[k] is not ZERO:
            basic = add(basic, neg(mul(row[k], by[speeds[k]])))
    return basic


def _equations(
    known: Translation, kinematical: Kinematical,
    sets: dict[tuple[Coordinate, ...], tuple[QuasiRate, ...]], states: States,
) -> tuple[list[Expr], list[list[Expr]]]:  # fmt: skip
    """`basic` and `rows` of the equations `basic` = `rows` u, `basic` in rates; those of Euler parameters in the angular velocity."""
    k_q, k_u, f = kinematical
    n, turning = len(k_q), {q: k for k, group in enumerate(sets) for q in group}
    own = [
        {turning[q] for q, x in zip(known.coordinates, row, strict=True) if x is not ZERO and q in turning}
        for row in k_q
    ]
    basic, rows = [], []
    for i in range(n):
        if own[i]:
            continue
        basic.append(sum_of([f[i], *(mul(x, rate(q)) for q, x in zip(known.coordinates, k_q[i], strict=True))]))
        rows.append([neg(x) for x in k_u[i]])
    for group, quasi in sets.items():
        basic += quasi
        rows += _spin(known, kinematical, group, states)
    return basic, rows


def _spin(
    known: Translation, kinematical: Kinematical, group: Sequence[Coordinate], states: States
) -> list[list[Expr]]:
    """w in terms of the speeds: constant coefficients if they are equal at all states, e.g. if the speeds are measure numbers of w."""
    e, by_u = states.of(group), rates_by_speeds(known, kinematical, states)[[_place(known, q) for q in group]]
    w = 2 * (e[0] * by_u[1:] - by_u[0] * e[1:, None] - np.cross(e[1:, None], by_u[1:], axis=0))
    if np.abs(w - w[..., :1]).max() > ROUNDED_SUM * 100:
        return _spin_in_symbols(known, kinematical, group)
    tidy = np.round(w[..., 0] * 2**20) / 2**20
    tidy = np.where(np.abs(tidy - w[..., 0]) < ROUNDED_SUM * 100, tidy, w[..., 0])
    return [[as_expr(int(x) if x == int(x) else float(x)) for x in row] for row in tidy]


def rates_by_speeds(known: Translation, kinematical: Kinematical, states: States) -> Array:
    """∂q̇/∂u at the states (coordinates × speeds × states)."""
    k_q, k_u, _ = kinematical
    n, m, count = len(k_q), len(known.speeds), states.of([ONE]).shape[1]
    a = states.of([x for row in k_q for x in row]).reshape(n, n, count)
    b = states.of([x for row in k_u for x in row]).reshape(n, m, count)
    return np.stack([-np.linalg.solve(a[:, :, s], b[:, :, s]) for s in range(count)], axis=-1)


def keeps_length(known: Translation, kinematical: Kinematical, states: States, group: Sequence[Coordinate]) -> bool:
    """Whether the length of Euler parameters is constant for all values of the speeds."""
    by_u = rates_by_speeds(known, kinematical, states)[[_place(known, q) for q in group]]
    return bool(np.abs(np.einsum("is,ims->ms", states.of(group), by_u)).max() <= ROUNDED_SUM * 100)


def _place(known: Translation, q: Coordinate) -> int:
    return next(k for k, x in enumerate(known.coordinates) if x is q)


def _spin_in_symbols(known: Translation, kinematical: Kinematical, group: Sequence[Coordinate]) -> list[list[Expr]]:
    """w = 2 (e0 ė − ė0 e − e × ė) with ė in terms of the speeds, if each equation contains the rate of one parameter only."""
    k_q, k_u, _ = kinematical
    by_u: list[list[Expr]] = []
    for q in group:
        j = _place(known, q)
        i = next((i for i, row in enumerate(k_q) if row[j] is not ZERO), None)
        if i is None or sum(x is not ZERO for x in k_q[i]) != 1:
            raise ModelError(
                f"Expected one kinematical equation for each rate of the Euler parameters "
                f"{', '.join(q.name for q in group)}, got coupled ones."
            )
        by_u.append([neg(x) / k_q[i][j] for x in k_u[i]])
    e = list(group)
    result = []
    for k in range(3):
        a, b = (k + 1) % 3 + 1, (k + 2) % 3 + 1
        result.append([
            2 * (e[0] * by_u[k + 1][m] - e[k + 1] * by_u[0][m] - (e[a] * by_u[b][m] - e[b] * by_u[a][m]))
            for m in range(len(known.speeds))
        ])  # fmt: skip
    return result
