# SPDX-License-Identifier: BSD-3-Clause
"""u̇ from joint accelerations, whose rows are in generalized speeds or in rates of coordinates.

Rows in which one unknown is left, with a constant beside it, give it, one after the other. Speeds u = Y q̇ + z that are in none of them
follow from their definitions, u̇ = Y q̈ + Ẏ q̇ + ż, which divide by nothing; of joints by speeds of their own q̈ = W u̇ + Ẇ u + Ẋ.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from kane.expr.build import add, div, mul, neg, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.freedoms import Freedom, Unsuited
from kane.kinematics.motion import Kinematics
from kane.kinematics.speeds import Row, Speeds

_NOT_ALL = "speeds that are no constant combinations of those of the joints, or coordinates that several joints share"

Stagewise = Callable[[int, bool], Sequence[Freedom]]
"""The freedoms of a stage, by rates or not."""


def by_rates(stages: int, freedoms: Stagewise, speeds: Speeds) -> set[int]:
    """The stages that move by rates of coordinates, as their freedoms in speeds do not give all u̇; Unsuited where none do."""
    chosen: set[int] = set()
    while True:
        own = [freedoms(k, k in chosen) for k in range(stages)]
        rows = [f.row for each in own for f in each]
        if len(rows) != len(speeds.speeds):
            raise Unsuited(_NOT_ALL)
        lost = _missing(rows, speeds)
        if not lost:
            return chosen
        more = {k for k, each in enumerate(own) if k not in chosen and any(not lost.isdisjoint(f.row) for f in each)}
        if not more:
            raise Unsuited(_NOT_ALL)
        chosen |= more


def resolved(rows: Iterable[tuple[Row, Expr]], kinematics: Kinematics) -> dict[Expr, Expr]:
    """u̇ by speed, of Σ c u̇ = λ and Σ c q̈ = λ."""
    known, speeds = list(rows), kinematics.speeds
    found: dict[Expr, Expr] = {}
    for number, s in _order([row for row, _ in known]):
        row, value = known[number]
        for other, c in row.items():
            if other is not s:
                value = sub(value, mul(c, found[other]))
        found[s] = div(value, row[s])
    return {
        u: found[u] if u in found else _defined(speeds.rows[i], speeds.z[i], found, kinematics)
        for i, u in enumerate(speeds.speeds)
    }


def transposed(row: Row, rows: Sequence[Row], speeds: Speeds) -> dict[int, Expr]:
    """Σ a u̇ of a row in λ: what of each λ it has, by the number of its row; the generalized forces of λ that those of u̇ are."""
    order = _order(rows)
    given, taken = {s for _, s in order}, dict[Expr, Expr]()

    def take(s: Expr, c: Expr) -> None:
        taken[s] = add(taken.get(s, ZERO), c)

    places: dict[Expr, int] = {u: i for i, u in enumerate(speeds.speeds)}
    for u, c in row.items():
        if u in given:
            take(u, c)
            continue
        for b, y in speeds.rows[places[u]].items():
            if b in given:
                take(b, mul(c, y))
            else:
                for v, w in speeds.form({b: ONE}).coefficients.items():
                    take(v, mul(mul(c, y), w))
    found: dict[int, Expr] = {}
    for number, s in reversed(order):
        whole = taken.get(s, ZERO)
        if whole is ZERO:
            continue
        found[number] = div(whole, rows[number][s])
        for other, c in rows[number].items():
            if other is not s:
                take(other, neg(mul(found[number], c)))
    return found


def _defined(row: Row, z: Expr, found: Mapping[Expr, Expr], kinematics: Kinematics) -> Expr:
    """Y q̈ + Ẏ q̇ + ż."""
    drift, form = kinematics.drift, kinematics.speeds.form
    value = drift(z)
    for b, c in row.items():
        now = form({b: ONE})
        if b in found:
            change = found[b]
        else:
            change = drift(now.total())
            for u, w in now.coefficients.items():
                change = add(change, mul(w, found[u]))
        value = add(value, add(mul(c, change), mul(drift(c), now.total())))
    return value


def _order(rows: Sequence[Row]) -> list[tuple[int, Expr]]:
    """Rows with what each of them gives, in an order in which the rest of each is known."""
    left = [dict.fromkeys(row) for row in rows]
    users: dict[Expr, list[int]] = {}
    for k, row in enumerate(rows):
        for s in row:
            users.setdefault(s, []).append(k)
    ready = [k for k, own in enumerate(left) if len(own) == 1]
    found: dict[Expr, None] = {}
    order: list[tuple[int, Expr]] = []
    while ready:
        after: list[int] = []
        for k in ready:
            if len(left[k]) != 1:  # another has given it
                continue
            (s,) = left[k]
            if not is_constant_in_time([rows[k][s]]):
                continue
            found[s] = None
            order.append((k, s))
            for other in users[s]:
                del left[other][s]
                if len(left[other]) == 1:
                    after.append(other)
        ready = after
    return order


def _missing(rows: Sequence[Row], speeds: Speeds) -> set[Expr]:
    """The speeds whose u̇ does not follow, with the others and the rates that their definitions and left rows hold."""
    order = _order(rows)
    found = {s for _, s in order}
    used = {k for k, _ in order}
    lost = {s for k, row in enumerate(rows) if k not in used for s in row}
    for i, u in enumerate(speeds.speeds):
        if u in found:
            continue
        for b in speeds.rows[i]:
            by = speeds.form({b: ONE}).coefficients
            if b not in found and not all(s in found for s in by):
                lost |= {u, b, *by}
    return lost
