# SPDX-License-Identifier: BSD-3-Clause
"""Joint speeds: what a joint turns and slides by, in the generalized speeds, and these from the joint speeds' derivatives."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from kane.expr.build import sub
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.motion import Kinematics
from kane.kinematics.speeds import ScalarForm
from kane.space.rotation import NOTHING, UNITS, Basis, Triple
from kane.space.vector import Vector


class Unsuited(Exception):
    """What no recursion of this kind expresses, as its text says; another route does."""


_SPEEDS = "speeds that are no constant combinations of those of the joints"


class Freedom(NamedTuple):
    """A joint speed: what it adds to ω or to ṙ, and its row in the generalized speeds."""

    axis: Triple
    row: Mapping[Expr, Expr]


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A slide or a turn: freedoms, and what ṙ or ω is in speeds, with its drift."""

    freedoms: tuple[Freedom, ...] = ()
    total: Triple = NOTHING
    drift: Triple = NOTHING


def is_still(rates: Iterable[Expr]) -> bool:
    """Whether nothing moves."""
    return all(x is ZERO for x in rates)


class Forms(NamedTuple):
    """The forms in speeds of what a stage makes of rates."""

    forms: tuple[ScalarForm, ScalarForm, ScalarForm]


class Stages:
    """Forms of what moves, and the freedoms that they have once all of them are known."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.users: dict[Expr, int] = {}

    def raw(self, rates: Triple) -> Forms | None:
        """The forms of what changes with these rates, None of nothing."""
        if is_still(rates):
            return None
        x, y, z = self.kinematics.speeds.forms(rates)
        return Forms((x, y, z))

    def taken(self, raw: Forms | None) -> Forms | None:
        """The same, kept."""
        for s in {u for form in raw.forms for u in form.coefficients} if raw else ():
            self.users[s] = self.users.get(s, 0) + 1
        return raw

    def stage(self, raw: Forms | None) -> Stage:
        """The freedoms of forms: one an axis, or one a speed that nothing else moves by."""
        if raw is None:
            return Stage()
        rows = [(k, form.coefficients) for k, form in enumerate(raw.forms) if form.coefficients]
        speeds = dict.fromkeys(s for _, row in rows for s in row)
        if len(rows) <= 1 or is_single(raw):
            freedoms = tuple(Freedom(UNITS[k], row) for k, row in rows)
        elif all(self.users[s] == 1 for s in speeds):
            columns = {s: [form.coefficients.get(s, ZERO) for form in raw.forms] for s in speeds}
            freedoms = tuple(Freedom((c[0], c[1], c[2]), {s: ONE}) for s, c in columns.items())
        else:
            raise Unsuited(_SPEEDS)
        if not all(is_constant_in_time(f.row.values()) for f in freedoms):
            raise Unsuited(_SPEEDS)
        a, b, c = (form.total() for form in raw.forms)
        drift = self.kinematics.drift
        return Stage(freedoms, (a, b, c), (drift(a), drift(b), drift(c)))


def is_single(raw: Forms) -> bool:
    """Whether each form is of one speed, and no two of the same."""
    rows = [form.coefficients for form in raw.forms if form.coefficients]
    return all(len(row) == 1 for row in rows) and len({s for row in rows for s in row}) == len(rows)


def measured(v: Vector, basis: Basis) -> Iterator[Triple]:
    """The measure numbers in the two ways in which a speed's definition may have come to them."""
    yield v.components(basis)
    x, y, z = (v.dot(Vector(((basis, unit),))) for unit in UNITS)
    yield x, y, z


def solved_rows(rows: Iterable[tuple[Mapping[Expr, Expr], Expr]], speeds: Sequence[Expr]) -> dict[Expr, Expr] | None:
    """u̇ of Σ c u̇ = λ, one after the other from rows that hold one more; None where they do not give all."""
    found: dict[Expr, Expr] = {}
    waiting = list(rows)
    if len(waiting) != len(speeds):
        return None
    while waiting:
        left = []
        for row, value in waiting:
            new = [s for s in row if s not in found]
            if len(new) > 1:
                left.append((row, value))
                continue
            if not new:
                return None
            for s, c in row.items():
                if s in found:
                    value = sub(value, _times(c, found[s]))
            found[new[0]] = _over(value, row[new[0]])
        if len(left) == len(waiting):
            return None
        waiting = left
    return found


def _times(c: Expr, x: Expr) -> Expr:
    return x if c is ONE else c * x


def _over(x: Expr, c: Expr) -> Expr:
    return x if c is ONE else x / c
