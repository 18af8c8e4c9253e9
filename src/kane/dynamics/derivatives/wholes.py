# SPDX-License-Identifier: BSD-3-Clause
"""What hangs on a segment of a tree, as one: how its moment and force about the segment's origin O change with the segment's motion.

With ω, α of the segment and a of O changed, and all that moves in the segment moving in it as before, particles at ρ with velocities v
from O change their accelerations by δα′ × ρ + 2 δω × v + δa, where δα′ = δα − δω × ω. With ρ × (δω × v) = (ρ·v) δω − v (ρ·δω)

    δn = J δα′ + (tr P 1 − P) δω + h × δa,      δf = δα′ × h + δω × 2 h° + m δa,

J = ∫ (ρ·ρ 1 − ρ ρᵀ) dm, h = ∫ ρ dm, h° = ∫ v dm and P = 2 ∫ v ρᵀ dm, which is no tensor of inertia: two of its rows and columns would
be, and P has fewer numbers than J° and ∫ ρ × v dm, which it stands for. δα′ is the same all along a tree, δω too, and an origin at r
with the velocity v from O has δa + δα′ × r + 2 δω × v. (Singh, Russo & Wensing 2022, in Kane's terms.)
"""

from typing import NamedTuple

from kane.expr.build import add, div, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import TWO, Expr
from kane.space.rotation import Cosines, Triple, cross3, product, transposed
from kane.space.spatial import Rigid, Turn, Turns, as_rows, summed, summed_rows, times, triple


class Change(NamedTuple):
    """δω, δα′ and δa."""

    spin: Triple
    alpha: Triple
    a: Triple

    def plus(self, other: "Change") -> "Change":
        """Both together."""
        return Change(*map(summed, self, other))


class Row(NamedTuple):
    """What is multiplied by δω, δα′ and δa."""

    spin: Triple
    alpha: Triple
    a: Triple

    def times(self, change: Change) -> Expr:
        """The sum of the products."""
        return add(add(dot(self.spin, change.spin), dot(self.alpha, change.alpha)), dot(self.a, change.a))

    def turned(self, turn: Turn | Turns) -> "Row":
        """Along the basis before a turn."""
        return Row(*map(turn.up, self))

    def moved(self, r: Triple, v: Triple) -> "Row":
        """By the changes of the point from which the origin lies at r, with the velocity v."""
        spin = summed(self.spin, cross3(times(TWO, v), self.a))
        return Row(spin, summed(self.alpha, cross3(r, self.a)), self.a)


class Whole(NamedTuple):
    """m, h, J of what hangs on a segment, 2 h° and P."""

    body: Rigid
    shift: Triple
    spread: Cosines

    def plus(self, other: "Whole") -> "Whole":
        """Both together."""
        shift, spread = summed(self.shift, other.shift), summed_rows(self.spread, other.spread)
        return Whole(self.body.plus(other.body), shift, spread)

    def turned(self, turn: Turn | Turns) -> "Whole":
        """Along the basis before a turn."""
        return Whole(self.body.before(turn), turn.up(self.shift), turn.up_general(self.spread))

    def moved(self, r: Triple, v: Triple) -> "Whole":
        """About the point from which the origin lies at r, with the velocity v: P + 2 h° rᵀ + 2 v (h + m r)ᵀ."""
        body, twice = self.body.moved(r), times(TWO, v)
        rows = [
            summed(row, summed(times(x, r), times(y, body.h)))
            for row, x, y in zip(self.spread, self.shift, twice, strict=True)
        ]
        return Whole(body, summed(self.shift, times(body.m, twice)), (rows[0], rows[1], rows[2]))

    def turning(self) -> Cosines:
        """tr P 1 − P."""
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.spread
        return (
            (add(yy, zz), neg(xy), neg(xz)),
            (neg(yx), add(xx, zz), neg(yz)),
            (neg(zx), neg(zy), add(xx, yy)),
        )

    def pressed(self, by: Change) -> tuple[Triple, Triple]:
        """δn and δf."""
        m, h, j = self.body
        n = summed(product(self.turning(), by.spin), summed(product(j, by.alpha), cross3(h, by.a)))
        f = summed(cross3(by.spin, self.shift), cross3(by.alpha, h))
        return n, summed(f, times(m, by.a))

    def row(self, spin: Triple, slide: Triple) -> Row:
        """s·δn + t·δf of a freedom that adds s to ω and t to ṙ."""
        m, h, j = self.body
        turned = Row(product(transposed(self.turning()), spin), product(j, spin), cross3(spin, h))
        slid = Row(cross3(self.shift, slide), cross3(h, slide), times(m, slide))
        return Row(*map(summed, turned, slid))


def alone(body: Rigid, w: Triple) -> Whole:
    """A body that turns at ω: 2 ω × ∫ ρ ρᵀ dm, of which J is the trace without it."""
    half = div(add(add(body.j[0][0], body.j[1][1]), body.j[2][2]), TWO)
    spread = as_rows([[sub(half, x) if a == b else neg(x) for b, x in enumerate(row)] for a, row in enumerate(body.j)])
    twice = times(TWO, w)
    x, y, z = (cross3(twice, column) for column in spread)  # ∫ ρ ρᵀ dm is symmetric
    return Whole(body, cross3(twice, body.h), transposed((x, y, z)))


def primed(w: Triple, spin: Triple, alpha: Triple, a: Triple) -> Change:
    """The change of a motion at ω."""
    return Change(spin, triple(map(sub, alpha, cross3(spin, w))), a)
