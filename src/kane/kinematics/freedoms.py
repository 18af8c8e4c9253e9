# SPDX-License-Identifier: BSD-3-Clause
"""Joint speeds and motion subspaces (Featherstone 2008, ch. 3), and u̇ from the rates λ of joint speeds.

A joint speed is a linear form, its row, in generalized speeds (Σ c u̇ = λ) or in rates of coordinates (Σ c q̈ = λ). The rows are
solved by substitution: a row with one unknown left, whose coefficient is constant in time, gives that unknown. Speeds that are in no
row follow from their definitions without division, u̇ = Y q̈ + Ẏ q̇ + ż, and rates that are in none from q̈ = W u̇ + Ẇ u + Ẋ.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from kane.expr.build import add, div, mul, neg, sub, sum_of
from kane.expr.differentiation import Affine
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.speeds import Row, ScalarForm, Speeds
from kane.kinematics.velocities import Kinematics
from kane.space.rotation import NOTHING, UNITS, Triple
from kane.tree.triples import is_zero, triple


class Unsuited(Exception):
    """Raised if recursions along a tree of this kind cannot express the system; the text says why. Another formulation is used."""


_SPEEDS = "speeds that are no constant combinations of those of the joints"


class Freedom(NamedTuple):
    """A joint speed: its `axis` in ω or in ṙ, and its row in generalized speeds or in rates of coordinates.

    Its rate λ, the coefficient of the axis in α or in the acceleration, is Σ c u̇ or Σ c q̈. A screw also adds `slide` to ṙ, along A.
    """

    axis: Triple
    row: Row
    slide: Triple = NOTHING


@dataclass(frozen=True, slots=True, eq=False)
class Shift:
    """A slide or a rotation of a joint: joint speeds, ṙ or ω (`total`) with its `forms` in speeds, and the λ-free part of its rate.

    `shared` are the rates that move other segments too, each with its axis.
    """

    freedoms: tuple[Freedom, ...] = ()
    total: Triple = NOTHING
    drift: Triple = NOTHING
    forms: tuple[ScalarForm, ...] = ()
    shared: tuple[tuple[Expr, Triple], ...] = ()


class Forms(NamedTuple):
    """The three measure numbers of a slide or a rotation, as forms in speeds and in rates.

    `is_new` if each form has its own speed, with a constant coefficient, that moves no preceding segment. `shared` are the parts of
    the rows in rates that move other segments too; empty if there are none.
    """

    forms: tuple[ScalarForm, ...]
    rates: Sequence[Affine]
    is_new: bool
    shared: tuple[Row, ...] = ()

    @property
    def by_speeds(self) -> list[tuple[int, Row]]:
        """The nonzero rows in speeds, with the number of the axis."""
        return [(k, form.coefficients) for k, form in enumerate(self.forms) if form.coefficients]

    @property
    def by_rates(self) -> list[tuple[int, Row]]:
        """The nonzero rows in rates, with the number of the axis, without shared rates."""
        rows = [row for row, _ in self.rates]
        for k, shared in enumerate(self.shared):
            rows[k] = {s: c for s, c in rows[k].items() if s not in shared}
        return [(k, row) for k, row in enumerate(rows) if row]


class Stages:
    """Makes the forms of all slides and rotations, then their joint speeds; rates in `shared` may move several segments."""

    def __init__(self, kinematics: Kinematics, shared: Collection[Expr] = ()) -> None:
        self.kinematics, self.shared = kinematics, frozenset(shared)
        self.users: dict[Expr, int] = {}

    def raw(self, rates: Triple) -> Forms | None:
        """The forms of a motion with these measure numbers; None if they are zero."""
        if is_zero(rates):
            return None
        speeds = self.kinematics.speeds
        affine = speeds.in_rates(rates)
        forms = tuple(speeds.form(*x) for x in affine)
        rows = [form.coefficients for form in forms if form.coefficients]
        new = [[(u, c) for u, c in row.items() if u not in self.users] for row in rows]
        firsts = {own[0][0] for own in new if len(own) == 1 and is_constant_in_time([own[0][1]])}
        own = tuple({s: k for s, k in row.items() if s in self.shared} for row, _ in affine) if self.shared else ()
        return Forms(forms, affine, len(firsts) == len(new), own if any(own) else ())

    def take(self, *raw: Forms | None) -> None:
        """Counts the speeds and rates that move a segment."""
        rows = [row for r in raw if r is not None for _, row in (*r.by_speeds, *r.by_rates)]
        for s in dict.fromkeys(s for row in rows for s in row):
            self.users[s] = self.users.get(s, 0) + 1

    def stage(self, raw: Forms | None, by_rates: bool) -> Shift:
        """The joint speeds of forms: one per axis, or one per speed or rate that moves nothing else. Unsuited if there are none.

        Their rows are in rates of coordinates if `by_rates`.
        """
        if raw is None:
            return Shift()
        total = triple(form.total() for form in raw.forms)
        freedoms = None if by_rates or raw.shared else self._by_speeds(raw)
        if freedoms is not None:
            return Shift(freedoms, total, triple(map(self.kinematics.drift, total)), raw.forms)
        freedoms = self._by_rates(raw)
        if freedoms is None:
            raise Unsuited(_SPEEDS)
        return Shift(freedoms, total, triple(map(self._swing, raw.rates)), raw.forms, _shared(raw))

    def coupled(self, spin: Forms, slide: Forms) -> tuple[Shift, Shift]:
        """A rotation and a slide by the same rates, as of a screw; the joint speeds belong to the rotation."""
        turns, slides = (self._columns(raw.by_rates) for raw in (spin, slide))
        if turns is None or slides is None:
            raise Unsuited(_SPEEDS)
        along = {b: f.axis for f in slides for b in f.row}
        both = [f._replace(slide=along.pop(b, NOTHING)) for f in turns for b in f.row]
        both += [Freedom(NOTHING, {b: ONE}, v) for b, v in along.items()]
        x, y = (replace(self.stage(raw, True), freedoms=()) for raw in (spin, slide))
        return replace(x, freedoms=tuple(both)), y

    def _by_speeds(self, raw: Forms) -> tuple[Freedom, ...] | None:
        rows = raw.by_speeds
        if raw.is_new or (_is_constant(rows) and (len(rows) <= 1 or _is_single(rows))):
            return _units(rows)
        return None if self._by_rates(raw) else self._columns(rows)

    def _by_rates(self, raw: Forms) -> tuple[Freedom, ...] | None:
        rows = raw.by_rates
        if _is_constant(rows) and (len(rows) <= 1 or _is_single(rows)):
            return _units(rows)
        return self._columns(rows)

    def _columns(self, rows: Sequence[tuple[int, Row]]) -> tuple[Freedom, ...] | None:
        """One joint speed per speed or rate; None if one of these moves something else too."""
        columns: dict[Expr, list[Expr]] = {}
        for k, row in rows:
            for s, c in row.items():
                columns.setdefault(s, [ZERO, ZERO, ZERO])[k] = c
        if any(self.users[s] > 1 for s in columns):
            return None
        return tuple(Freedom((c[0], c[1], c[2]), {s: ONE}) for s, c in columns.items())

    def _swing(self, form: Affine) -> Expr:
        """The derivative of Σ c q̇ + rest at constant q̇."""
        row, rest = form
        drift, form_of = self.kinematics.drift, self.kinematics.speeds.form
        return sum_of([drift(rest), *(mul(drift(c), form_of({b: ONE}).total()) for b, c in row.items())])


def _shared(raw: Forms) -> tuple[tuple[Expr, Triple], ...]:
    """Each shared rate with its axis."""
    rates = dict.fromkeys(s for row in raw.shared for s in row)
    return tuple((s, (a, b, c)) for s in rates for a, b, c in [[row.get(s, ZERO) for row in raw.shared]])


def _is_constant(rows: Iterable[tuple[int, Row]]) -> bool:
    return all(is_constant_in_time(row.values()) for _, row in rows)


def _units(rows: Iterable[tuple[int, Row]]) -> tuple[Freedom, ...]:
    return tuple(Freedom(UNITS[k], row) for k, row in rows)


def _is_single(rows: Sequence[tuple[int, Row]]) -> bool:
    return all(len(row) == 1 for _, row in rows) and len({s for _, row in rows for s in row}) == len(rows)


def are_coupled(a: Forms | None, b: Forms | None) -> bool:
    """Whether two motions have a rate in common."""
    if a is None or b is None:
        return False
    return not {s for _, row in a.by_rates for s in row}.isdisjoint(s for _, row in b.by_rates for s in row)


def is_single(raw: Forms) -> bool:
    """Whether each form has one speed, different from those of the others, and no rate is shared."""
    return not raw.shared and _is_single(raw.by_speeds)


_NOT_ALL = "speeds that are no constant combinations of those of the joints, or coordinates that several joints share"

Stagewise = Callable[[int, bool], Sequence[Freedom]]
"""The joint speeds of a slide or rotation by its number; their rows are in rates if the flag is true."""


def by_rates(stages: int, freedoms: Stagewise, speeds: Speeds) -> set[int]:
    """The stages whose joint speeds must have rows in rates of coordinates, so that all u̇ follow. Unsuited if they never do."""
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
    """u̇ by speed, from pairs (row, λ) with Σ c u̇ = λ or Σ c q̈ = λ."""
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
    """The coefficients of λ in Σ a u̇, by the number of the row of λ; also, forces `row` on u as forces on the joint speeds."""
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
    result: dict[int, Expr] = {}
    for number, s in reversed(order):
        whole = taken.get(s, ZERO)
        if whole is ZERO:
            continue
        result[number] = div(whole, rows[number][s])
        for other, c in rows[number].items():
            if other is not s:
                take(other, neg(mul(result[number], c)))
    return result


def _defined(row: Row, z: Expr, found: Mapping[Expr, Expr], kinematics: Kinematics) -> Expr:
    """u̇ = Y q̈ + Ẏ q̇ + ż of a speed with this row of Y and this z."""
    drift, form = kinematics.drift, kinematics.speeds.form
    value = drift(z)
    for b, c in row.items():
        value = add(value, add(mul(c, changed(b, found, kinematics)), mul(drift(c), form({b: ONE}).total())))
    return value


def changed(s: Expr, u_dot: Mapping[Expr, Expr], kinematics: Kinematics) -> Expr:
    """The derivative of a speed or rate: its value in `u_dot`, else, of a rate, q̈ = d/dt (W u + X)."""
    if s in u_dot:
        return u_dot[s]
    form = kinematics.speeds.form({s: ONE})
    return sum_of([kinematics.drift(form.total()), *(mul(w, u_dot[u]) for u, w in form.coefficients.items())])


def _order(rows: Sequence[Row]) -> list[tuple[int, Expr]]:
    """Pairs (row number, unknown solved from it), in an order such that the row's other unknowns are known."""
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
            if len(left[k]) != 1:  # another row has given its unknown
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
    """The speeds whose u̇ does not follow from the rows, with the speeds and rates in their definitions and in unused rows."""
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
