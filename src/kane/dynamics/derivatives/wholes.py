# SPDX-License-Identifier: BSD-3-Clause
"""What hangs on a segment of a tree, as one: how its moment and force about the segment's origin O change with the segment's motion.

With ω, α of the segment and a of O changed, and all that moves in the segment moving in it as before, particles at ρ with velocities v
from O change their accelerations by δα′ × ρ + 2 δω × v + δa, where δα′ = δα − δω × ω. So

    δn = J δα′ + J° δω + δω × L + h × δa,      δf = δα′ × h + 2 δω × h° + m δa,

with J = ∫ (ρ·ρ 1 − ρ ρᵀ) dm, h = ∫ ρ dm, L = ∫ ρ × v dm, and ° the derivatives in an inertial frame. δα′ is the same all along a tree,
δω too, and an origin at r with the velocity v from O has δa + δα′ × r + 2 δω × v. (Singh, Russo & Wensing 2022, in Kane's terms.)
"""

from typing import NamedTuple

from kane.expr.build import add, mul, sub
from kane.expr.matrix import dot
from kane.expr.node import TWO, Expr
from kane.space.rotation import Cosines, Triple, cross3, product
from kane.space.spatial import Rigid, Turn, Turns, as_rows, mirrored, summed, summed_symmetric, times, triple


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
    """m, h, J of what hangs on a segment, L, h° and J°."""

    body: Rigid
    momentum: Triple
    shift: Triple
    rows: Cosines

    def plus(self, other: "Whole") -> "Whole":
        """Both together."""
        return Whole(
            self.body.plus(other.body),
            summed(self.momentum, other.momentum),
            summed(self.shift, other.shift),
            summed_symmetric(self.rows, other.rows),
        )

    def turned(self, turn: Turn | Turns) -> "Whole":
        """Along the basis before a turn."""
        return Whole(self.body.before(turn), turn.up(self.momentum), turn.up(self.shift), turn.up_symmetric(self.rows))

    def moved(self, r: Triple, v: Triple) -> "Whole":
        """About the point from which the origin lies at r, with the velocity v."""
        body = self.body.moved(r)
        momentum = summed(self.momentum, summed(cross3(r, self.shift), cross3(body.h, v)))
        own = [add(mul(v[k], body.h[k]), mul(r[k], self.shift[k])) for k in range(3)]
        rows = [list(row) for row in self.rows]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            rows[i][i] = add(rows[i][i], mul(TWO, add(own[j], own[k])))
            rows[i][j] = rows[j][i] = sub(rows[i][j], add(_both(v, body.h, i, j), _both(r, self.shift, i, j)))
        return Whole(body, momentum, summed(self.shift, times(body.m, v)), as_rows(rows))

    def pressed(self, by: Change) -> tuple[Triple, Triple]:
        """δn and δf."""
        m, h, j = self.body
        n = summed(product(self.rows, by.spin), cross3(by.spin, self.momentum))
        n = summed(n, summed(product(j, by.alpha), cross3(h, by.a)))
        f = summed(cross3(times(TWO, by.spin), self.shift), cross3(by.alpha, h))
        return n, summed(f, times(m, by.a))

    def row(self, spin: Triple, slide: Triple) -> Row:
        """s·δn + t·δf of a freedom that adds s to ω and t to ṙ."""
        m, h, j = self.body
        turned = Row(summed(product(self.rows, spin), cross3(self.momentum, spin)), product(j, spin), cross3(spin, h))
        slid = Row(times(TWO, cross3(self.shift, slide)), cross3(h, slide), times(m, slide))
        return Row(*map(summed, turned, slid))


def alone(body: Rigid, w: Triple) -> Whole:
    """A body that turns at ω."""
    turned = as_rows([list(cross3(w, column)) for column in body.j])  # (ω × J)ᵀ, J symmetric
    rows = [[add(turned[a][b], turned[b][a]) for b in range(3)] for a in range(3)]
    return Whole(body, product(body.j, w), cross3(w, body.h), mirrored(as_rows(rows)))


def _both(a: Triple, b: Triple, i: int, k: int) -> Expr:
    """a bᵀ + b aᵀ."""
    x, y = dot([a[i]], [b[k]]), dot([b[i]], [a[k]])
    return add(x, y)


def primed(w: Triple, spin: Triple, alpha: Triple, a: Triple) -> Change:
    """The change of a motion at ω."""
    return Change(spin, triple(map(sub, alpha, cross3(spin, w))), a)
