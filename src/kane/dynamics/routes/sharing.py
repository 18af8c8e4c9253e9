# SPDX-License-Identifier: BSD-3-Clause
"""Freedoms that move several segments, on the way to the base and back: the coordinates of flexible bodies.

Below the segment that all of these hang on, what is felt keeps a column for each (`space.columns`): a segment that moves by s λ has

    n_k + J s + …,   m_kk + 2 s·(n_k, f_k) + s·I s,   m_kl + s·(n_l, f_l),   e_k + s·p

Where the last of them has come together they are eliminated one after the other, as joint speeds are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.kinematics.freedoms import Stage
from kane.kinematics.segments import Segment
from kane.space.columns import Column, Columns, with_entries
from kane.space.rotation import NOTHING, Cosines, Triple, product, transposed
from kane.space.spatial import Inertia, as_rows, summed, times


class Share(NamedTuple):
    """What a rate adds to ω and to ṙ of a segment, along A."""

    rate: Expr
    spin: Triple
    slide: Triple


def shares_of(step: Segment, slide: Stage) -> list[Share]:
    """What a segment moves by that others move by, too; the `slide` along A."""
    spins, slides = dict(step.spin.shared), dict(slide.shared)
    if step.turn is not None and step.turn.axis is None:
        spins = {b: step.turn.up(v) for b, v in spins.items()}
    return [Share(b, spins.get(b, NOTHING), slides.get(b, NOTHING)) for b in {**slides, **spins}]


def shared(felt: Inertia, shares: Sequence[Share]) -> Inertia:
    """What is felt before a segment that moves so."""
    columns = dict(felt.columns)
    for b, spin, slide in shares:
        u_n = summed(product(felt.j, spin), product(felt.h, slide))
        u_f = summed(product(transposed(felt.h), spin), product(felt.m, slide))
        before = columns.get(b, Column())
        row = dict(before.row)
        for other, c in columns.items():
            more = c.along(spin, slide)
            if more is ZERO:
                continue
            row = with_entries(row, {other: mul(TWO, more) if other is b else more})
            if other is not b:
                columns[other] = c._replace(row=with_entries(c.row, {b: more}))
        row = with_entries(row, {b: add(dot(spin, u_n), dot(slide, u_f))})
        force = add(before.force, add(dot(spin, felt.n), dot(slide, felt.f)))
        columns[b] = Column(summed(before.n, u_n), summed(before.f, u_f), row, force)
    return felt._replace(columns=columns)


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """λ of a rate that is solved for: (−e)/D less (n, f)/D·(α, a) less m/D of those that are left, `beside`; D."""

    rate: Expr
    t_n: Triple
    t_f: Triple
    beside: Mapping[Expr, Expr]
    rest: Expr
    d: Expr

    def value(self, alpha: Triple, a: Triple, known: Mapping[Expr, Expr]) -> Expr:
        """λ at the accelerations of the segment."""
        found = sub(self.rest, add(dot(self.t_n, alpha), dot(self.t_f, a)))
        for b, x in self.beside.items():
            found = sub(found, mul(x, known[b]))
        return found


def without_modes(felt: Inertia, rates: Sequence[Expr]) -> tuple[Inertia, list[Mode]]:
    """What is felt of a segment whose parts move by these rates, and how λ of each follows."""
    modes: list[Mode] = []
    for b in reversed(rates):
        felt = _without(felt, b, modes)
    return felt, modes


def _without(felt: Inertia, b: Expr, modes: list[Mode]) -> Inertia:
    columns = dict(felt.columns)
    own = columns.pop(b, Column())
    d = own.row.get(b, ZERO)
    if d is ZERO:
        raise SingularError("Expected every rate to move some mass.")
    t_n, t_f = over(own.n, d), over(own.f, d)
    beside = {other: div(x, d) for other, x in own.row.items() if other is not b and x is not ZERO}
    rest = neg(div(own.force, d))
    modes.append(Mode(b, t_n, t_f, beside, rest, d))
    for k, c in columns.items():
        x = own.row.get(k, ZERO)
        row = {other: y for other, y in c.row.items() if other is not b}
        if x is ZERO:
            columns[k] = c._replace(row=row)
            continue
        less = {other: neg(mul(x, y)) for other, y in beside.items()}
        n, f = (summed(v, times(neg(x), t)) for v, t in ((c.n, t_n), (c.f, t_f)))
        columns[k] = Column(n, f, with_entries(row, less), add(c.force, mul(x, rest)))
    n, f = summed(felt.n, times(rest, own.n)), summed(felt.f, times(rest, own.f))
    j, m = lowered(felt.j, t_n, own.n, True), lowered(felt.m, t_f, own.f, True)
    return Inertia(j, lowered(felt.h, t_n, own.f, False), m, n, f, columns)


def over(v: Triple, d: Expr) -> Triple:
    """v/D."""
    return div(v[0], d), div(v[1], d), div(v[2], d)


def lowered(rows: Cosines, t: Triple, u: Triple, symmetric: bool) -> Cosines:
    """A − t uᵀ."""
    out = [list(row) for row in rows]
    for a in range(3):
        for b in range(a if symmetric else 0, 3):
            x = rows[a][b] if t[a] is ZERO or u[b] is ZERO else sub(rows[a][b], mul(t[a], u[b]))
            out[a][b] = x
            if symmetric:
                out[b][a] = x
    return as_rows(out)


def columns_less(columns: Columns, g: Mapping[Expr, Expr], t: tuple[Triple, Triple], d: Expr, rest: Expr) -> Columns:
    """What columns keep where a joint speed is eliminated along which they have g, of U/D = t."""
    if not columns:
        return columns
    left = {}
    for b, c in columns.items():
        x = g[b]
        less = {other: neg(div(mul(x, y), d)) for other, y in g.items() if y is not ZERO and x is not ZERO}
        n, f = (summed(v, times(neg(x), each)) for v, each in zip((c.n, c.f), t, strict=True))
        left[b] = Column(n, f, with_entries(c.row, less), add(c.force, mul(x, rest)))
    return left


def found_modes(modes: Sequence[Mode], alpha: Triple, a: Triple, known: Mapping[Expr, Expr]) -> dict[Expr, Expr]:
    """λ of the modes of a segment, with what is known of others."""
    values = dict(known)
    for mode in reversed(modes):
        values[mode.rate] = mode.value(alpha, a, values)
    return values


def wrench_at(felt: Inertia, alpha: Triple, a: Triple, values: Mapping[Expr, Expr]) -> tuple[Triple, Triple]:
    """The moment and the force at given accelerations."""
    at = felt.at(alpha, a)
    n, f = at.n, at.f
    for b, c in felt.columns.items():
        n, f = summed(n, times(values[b], c.n)), summed(f, times(values[b], c.f))
    return n, f
