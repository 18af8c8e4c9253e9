# SPDX-License-Identifier: BSD-3-Clause
"""What sweeps carry along a tree: accelerations outward; wrenches, rigid bodies and articulated inertias inward.

Each value knows `turned` (outward: to the basis after a turn; inward: to the one before it) and `moved` (outward: to the point at r;
inward: to the point from which the origin lies at r), those carried inward also `plus`. Zeros are structural: they make no node.

An inertia maps the accelerations (α, a) of a basis and of its origin to a moment about that point and a force,

    n = J α + H a,   f = Hᵀ α + M a.

For a rigid body J is the inertia about the origin, H = [h×] with h = m r* and M = m 1 (Featherstone 2008, ch. 7).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg, sub, sum_of
from kane.expr.matrix import dot
from kane.expr.node import ONE, TWO, ZERO, Expr, constant
from kane.space.rotation import NOTHING, Cosines, Triple, cross3, product, transposed
from kane.tree.triples import (
    NO_ROWS,
    Turn,
    Turns,
    as_rows,
    centripetal,
    is_zero,
    lowered,
    negative,
    over,
    put,
    skew,
    summed,
    summed_rows,
    summed_symmetric,
    times,
    triple,
)

HALF = constant(0.5)
Row = Mapping[Expr, Expr]
Change = Turn | Turns


class Reflected(NamedTuple):
    """What turns or slides in the ground at the rate of a joint speed adds to the equation of that: a to M, −Q to f.

    So the rotor of a motor does whose stator stands still, and a counterweight.
    """

    inertia: Expr
    force: Expr


class Dof(NamedTuple):
    """A joint speed: what it adds to ω and to ṙ, its row in the generalized speeds or in the rates of coordinates, its number.

    λ, what spin and slide are taken with in α and in the acceleration, is Σ c u̇ of a row in speeds, Σ c q̈ of one in rates.
    """

    spin: Triple
    slide: Triple
    row: Row
    number: int
    reflected: Reflected | None = None

    @property
    def unit(self) -> tuple[int, bool] | None:
        """The axis, where the joint turns or slides along a basis axis at the rate of the speed, and whether it turns."""
        k = _unit(self.spin) if is_zero(self.slide) else _unit(self.slide) if is_zero(self.spin) else None
        return None if k is None else (k, is_zero(self.slide))

    @property
    def free(self) -> tuple[int, bool] | None:
        """The same where the joint transmits nothing along the axis, as nothing is reflected to it."""
        return self.unit if self.reflected is None else None


def _unit(v: Triple) -> int | None:
    k = [i for i, x in enumerate(v) if x is not ZERO]
    return k[0] if len(k) == 1 and v[k[0]] is ONE else None


class Accelerations(NamedTuple):
    """α of a basis and a of its origin."""

    alpha: Triple = NOTHING
    a: Triple = NOTHING

    def turned(self, turn: Change) -> "Accelerations":
        """Along the basis after a turn."""
        return Accelerations(turn.down(self.alpha), turn.down(self.a))

    def moved(self, r: Triple, bias: Triple = NOTHING) -> "Accelerations":
        """At the point at r, with the bias acceleration of that."""
        return Accelerations(self.alpha, summed(self.a, summed(cross3(self.alpha, r), bias)))

    def plus(self, alpha: Triple, a: Triple) -> "Accelerations":
        """With more of both."""
        return Accelerations(summed(self.alpha, alpha), summed(self.a, a))


class SpatialForce(NamedTuple):
    """A moment about the origin, and a force."""

    n: Triple = NOTHING
    f: Triple = NOTHING

    def turned(self, turn: Change) -> "SpatialForce":
        """Along the basis before a turn."""
        return SpatialForce(turn.up(self.n), turn.up(self.f))

    def moved(self, r: Triple) -> "SpatialForce":
        """About the point from which this origin lies at r."""
        return SpatialForce(summed(self.n, cross3(r, self.f)), self.f)

    def plus(self, other: "SpatialForce") -> "SpatialForce":
        """Both together."""
        return SpatialForce(summed(self.n, other.n), summed(self.f, other.f))

    def times(self, k: Expr) -> "SpatialForce":
        """k times the wrench."""
        return SpatialForce(times(k, self.n), times(k, self.f))

    def along(self, spin: Triple, slide: Triple) -> Expr:
        """spin·n + slide·f."""
        return add(dot(spin, self.n), dot(slide, self.f))

    def on(self, dof: Dof) -> Expr:
        """The generalized force on a joint speed."""
        return self.along(dof.spin, dof.slide)


NO_WRENCH = SpatialForce()


def opposite(w: SpatialForce) -> SpatialForce:
    """The wrench of the reaction."""
    return SpatialForce(negative(w.n), negative(w.f))


class Rigid(NamedTuple):
    """Mass, h = m r* and the inertia about the origin of what is rigid."""

    m: Expr
    h: Triple
    j: Cosines

    def plus(self, other: "Rigid") -> "Rigid":
        """Both together."""
        return Rigid(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.j, other.j))

    def turned(self, turn: Change) -> "Rigid":
        """Along the basis before a turn."""
        return Rigid(self.m, turn.up(self.h), turn.up_symmetric(self.j))

    def moved(self, r: Triple) -> "Rigid":
        """About the point from which this origin lies at r."""
        m, h = self.m, self.h
        whole = add(mul(TWO, dot(h, r)), mul(m, dot(r, r)))
        rows = [list(row) for row in self.j]
        for a in range(3):
            for b in range(a, 3):
                x = rows[a][b]
                if r[a] is not ZERO or r[b] is not ZERO:
                    x = sub(x, add(mul(h[a], r[b]), mul(r[a], h[b])))
                    x = sub(x, mul(m, mul(r[a], r[b])))
                rows[a][b] = rows[b][a] = add(x, whole) if a == b else x
        return Rigid(m, summed(h, times(m, r)), as_rows(rows))

    def bias(self, w: Triple, square: Expr) -> SpatialForce:
        """ω × J ω and ω × (ω × h), with ω · ω; what J has of the unit dyadic adds nothing."""
        (a, b, c), (d, e, f), (g, h, common) = self.j
        j = (sub(a, common), b, c), (d, sub(e, common), f), (g, h, ZERO)
        return SpatialForce(cross3(w, product(j, w)), centripetal(w, self.h, square))

    def about(self, k: int) -> Expr:
        """The moment of inertia about a basis axis."""
        return self.j[k][k]

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return product(self.j, v)

    def at(self, alpha: Triple, a: Triple) -> SpatialForce:
        """The inertia wrench at the accelerations α and a, less the bias."""
        return _at(self, alpha, a)

    @property
    def is_nothing(self) -> bool:
        """Whether there is none."""
        return self.m is ZERO and all(x is ZERO for row in (self.h, *self.j) for x in row)


NO_MASS = Rigid(ZERO, NOTHING, NO_ROWS)


class Moments(NamedTuple):
    """m, h = m r* and E = Σ m r r of what is rigid, and J where that is known.

    The inertia is J = (tr E) 1 − E. E is shorter to move than J (E + h p + p h + m p p, without a trace), and bias wrenches are
    shorter in it: with r × (a × (b × r)) = (r·(b × r)) a − (r·a) b × r, whose first term is zero,

        Σ m r × (a × (b × r)) = (E a) × b,        ω × J ω = (E ω) × ω
    """

    m: Expr
    h: Triple
    e: Cosines
    j: Cosines | None = None

    def plus(self, other: "Moments") -> "Moments":
        """Both together."""
        if self is NO_MOMENTS or other is NO_MOMENTS:
            return other if self is NO_MOMENTS else self
        return Moments(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.e, other.e))

    def turned(self, turn: Change) -> "Moments":
        """Along the basis before a turn."""
        return self if self is NO_MOMENTS else Moments(self.m, turn.up(self.h), turn.up_symmetric(self.e))

    def moved(self, r: Triple) -> "Moments":
        """About the point from which this origin lies at r."""
        if self is NO_MOMENTS or is_zero(r):
            return self
        h = summed(self.h, times(self.m, r))
        rows = [list(row) for row in self.e]
        for a in range(3):
            rows[a][a] = add(rows[a][a], mul(r[a], add(self.h[a], h[a])))
            for b in range(a + 1, 3):
                rows[a][b] = rows[b][a] = add(rows[a][b], add(mul(self.h[a], r[b]), mul(r[a], h[b])))
        return Moments(self.m, h, as_rows(rows))

    def about(self, k: int) -> Expr:
        """The moment of inertia about a basis axis."""
        if self.j is not None:
            return self.j[k][k]
        return add(self.e[(k + 1) % 3][(k + 1) % 3], self.e[(k + 2) % 3][(k + 2) % 3])

    def entry(self, a: int, b: int) -> Expr:
        """J_ab."""
        return self.about(a) if a == b else neg(self.e[a][b])

    def along(self, k: int, v: Triple) -> Expr:
        """The measure number of J v along a basis axis."""
        return sum_of(mul(self.entry(k, b), x) for b, x in enumerate(v) if x is not ZERO)

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return NOTHING if v is NOTHING else triple(self.along(k, v) for k in range(3))

    def at(self, alpha: Triple, a: Triple) -> SpatialForce:
        """The inertia wrench at the accelerations α and a, less the bias."""
        return _at(self, alpha, a)


NO_MOMENTS = Moments(ZERO, NOTHING, NO_ROWS)


def moments(body: Rigid) -> Moments:
    """Those of a body with this inertia: E = ½ (tr J) 1 − J."""
    if body.is_nothing:
        return NO_MOMENTS
    rows = [[neg(x) for x in row] for row in body.j]
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        rows[k][k] = mul(HALF, sub(add(body.j[a][a], body.j[b][b]), body.j[k][k]))
    return Moments(body.m, body.h, as_rows(rows), body.j)


def _at(body: Rigid | Moments, alpha: Triple, a: Triple) -> SpatialForce:
    """J α + h × a, α × h + m a."""
    n = summed(body.turned_by(alpha), cross3(body.h, a))
    return SpatialForce(n, summed(cross3(alpha, body.h), times(body.m, a)))


class Column(NamedTuple):
    """What a coordinate that moves several segments adds to an inertia: wrench, row of M, force at no acceleration.

    At the accelerations (α, a) of an origin and λ_k of such coordinates

        n = J α + H a + Σ n_k λ_k + …,   f = Hᵀ α + M a + Σ f_k λ_k + …,   Q_k = n_k·α + f_k·a + Σ m_kl λ_l + e_k.
    """

    w: SpatialForce = NO_WRENCH
    row: Row = MappingProxyType({})
    force: Expr = ZERO

    def plus(self, other: "Column") -> "Column":
        """Both together."""
        return Column(self.w.plus(other.w), with_entries(self.row, other.row), add(self.force, other.force))


Columns = Mapping[Expr, Column]
"""Columns by the rate that a coordinate has λ of."""
NO_COLUMNS: Columns = MappingProxyType({})


def joined(a: Columns, b: Columns) -> Columns:
    """Both together."""
    if not a or not b:
        return a or b
    return {k: a[k].plus(b[k]) if k in a and k in b else a.get(k) or b[k] for k in {**a, **b}}


def with_entries(row: Row, more: Row) -> dict[Expr, Expr]:
    """A row with more entries added to it."""
    whole = dict(row)
    for k, x in more.items():
        whole[k] = add(whole.get(k, ZERO), x)
    return whole


class Elimination(NamedTuple):
    """A joint speed, or the rate of a coordinate that moves several segments, eliminated from an inertia.

    λ = rest − t·(α, a) − …; t is U/D, `beside` is n_k·s/D of the columns that it was eliminated from.
    """

    of: Dof | Expr
    t: SpatialForce
    rest: Expr
    d: Expr
    beside: Row

    def known(self, values: Row) -> Expr:
        """The rest with λ of the columns."""
        rest = self.rest
        for b, x in self.beside.items():
            if x is not ZERO:
                rest = sub(rest, mul(x, values[b]))
        return rest

    def value(self, at: Accelerations, values: Row) -> Expr:
        """λ at the accelerations of the origin."""
        return sub(self.known(values), self.t.along(at.alpha, at.a))

    def after(self, at: Accelerations, values: Row) -> tuple[Expr, Accelerations]:
        """λ of a joint speed, and the accelerations with it."""
        assert isinstance(self.of, Dof)
        unit = self.of.free
        if unit is None:
            x = self.value(at, values)
            return x, at.plus(times(x, self.of.spin), times(x, self.of.slide))
        k, turns = unit  # the whole component first, as U/D is 1 there
        before = at.alpha if turns else at.a
        rest = at._replace(alpha=put(before, k, ZERO)) if turns else at._replace(a=put(before, k, ZERO))
        whole = self.value(rest, values)
        after = put(before, k, whole)
        return sub(whole, before[k]), at._replace(alpha=after) if turns else at._replace(a=after)


class SpatialInertia(NamedTuple):
    """J, H and M, the wrench that is there at no acceleration, and columns of coordinates that move several segments."""

    j: Cosines
    h: Cosines
    m: Cosines
    p: SpatialForce
    columns: Columns = NO_COLUMNS

    def plus(self, other: "SpatialInertia") -> "SpatialInertia":
        """Both together."""
        return SpatialInertia(
            summed_symmetric(self.j, other.j),
            summed_rows(self.h, other.h),
            summed_symmetric(self.m, other.m),
            self.p.plus(other.p),
            joined(self.columns, other.columns),
        )

    def turned(self, turn: Change) -> "SpatialInertia":
        """Along the basis before a turn."""
        return SpatialInertia(
            turn.up_symmetric(self.j, several=True),
            turn.up_general(self.h),
            turn.up_symmetric(self.m, several=True),
            self.p.turned(turn),
            {b: c._replace(w=c.w.turned(turn)) for b, c in self.columns.items()},
        )

    def moved(self, r: Triple) -> "SpatialInertia":
        """About the point from which this origin lies at r."""
        if is_zero(r):
            return self
        (m_0, m_1, m_2), (h_0, h_1, h_2) = self.m, self.h
        g = summed_rows(self.h, transposed((cross3(r, m_0), cross3(r, m_1), cross3(r, m_2))))  # H + [r×] M
        left = cross3(r, h_0), cross3(r, h_1), cross3(r, h_2)  # the columns of [r×] Hᵀ
        right = cross3(g[0], r), cross3(g[1], r), cross3(g[2], r)  # the rows of G [r×]
        rows = [list(row) for row in self.j]
        for a in range(3):
            for b in range(a, 3):
                rows[a][b] = rows[b][a] = sub(add(rows[a][b], left[b][a]), right[a][b])
        columns = {b: c._replace(w=c.w.moved(r)) for b, c in self.columns.items()}
        return SpatialInertia(as_rows(rows), g, self.m, self.p.moved(r), columns)

    def at(self, alpha: Triple, a: Triple) -> "SpatialInertia":
        """The same with what known parts of the acceleration add to the wrench and to the forces on columns."""
        if is_zero(alpha) and is_zero(a):
            return self
        columns = {b: c._replace(force=add(c.force, c.w.along(alpha, a))) for b, c in self.columns.items()}
        n = summed(summed(self.p.n, product(self.j, alpha)), product(self.h, a))
        f = summed(summed(self.p.f, product(transposed(self.h), alpha)), product(self.m, a))
        return self._replace(p=SpatialForce(n, f), columns=columns)

    def of(self, dof: Dof) -> SpatialForce:
        """The wrench at the acceleration 1 of a joint speed: one of the entries is all that a product with a unit vector has."""
        if dof.unit is not None:
            k, turns = dof.unit
            return SpatialForce(transposed(self.j if turns else self.h)[k], (self.h if turns else self.m)[k])
        n = summed(product(self.j, dof.spin), product(self.h, dof.slide))
        return SpatialForce(n, summed(product(transposed(self.h), dof.spin), product(self.m, dof.slide)))

    def without(self, dof: Dof) -> tuple["SpatialInertia", Elimination]:
        """What is felt before a joint speed, which is free.

        U = I s,   D = s·U,   λ = (−s·p − U·a)/D,      I − U Uᵀ/D,   p − U (s·p)/D
        """
        u = self.of(dof)
        d, force = u.on(dof), self.p.on(dof)
        if dof.reflected is not None:
            d, force = add(d, dof.reflected.inertia), add(force, dof.reflected.force)
        left, pivot = self._eliminated(dof, u, d, force, {b: c.w.on(dof) for b, c in self.columns.items()})
        if dof.free is None:
            return left, pivot
        k, turns = dof.free  # rows and columns that cancel
        if turns:
            p = left.p._replace(n=put(left.p.n, k, ZERO))
            return left._replace(j=_without(left.j, k), h=put(left.h, k, NOTHING), p=p), pivot
        h = transposed(put(transposed(left.h), k, NOTHING))
        return left._replace(h=h, m=_without(left.m, k), p=left.p._replace(f=put(left.p.f, k, ZERO))), pivot

    def without_mode(self, b: Expr) -> tuple["SpatialInertia", Elimination]:
        """What is felt where all that moves by a rate hangs here."""
        columns = dict(self.columns)
        own = columns.pop(b, Column())
        less = {k: c._replace(row={o: x for o, x in c.row.items() if o is not b}) for k, c in columns.items()}
        beside = {k: own.row[k] for k in own.row if k is not b}
        return self._replace(columns=less)._eliminated(b, own.w, own.row.get(b, ZERO), own.force, beside)

    def _eliminated(
        self, of: Dof | Expr, u: SpatialForce, d: Expr, force: Expr, g: Row
    ) -> tuple["SpatialInertia", Elimination]:
        """Without what has the wrench U, the pivot D, this force at no acceleration, and g of columns."""
        if d is ZERO:
            raise SingularError("Expected every joint speed to move some mass.")
        t, rest = SpatialForce(over(u.n, d), over(u.f, d)), neg(div(force, d))
        beside = {b: div(x, d) for b, x in g.items() if x is not ZERO}
        columns = dict(self.columns)
        for b in [b for b in beside if b in columns]:
            less, row = g[b], {k: neg(mul(g[b], y)) for k, y in beside.items()}
            columns[b] = columns[b].plus(Column(t.times(neg(less)), row, mul(less, rest)))
        left = SpatialInertia(
            lowered(self.j, t.n, u.n, symmetric=True),
            lowered(self.h, t.n, u.f, symmetric=False),
            lowered(self.m, t.f, u.f, symmetric=True),
            self.p.plus(u.times(rest)),
            columns,
        )
        return left, Elimination(of, t, rest, d, beside)

    def sharing(self, dof: Dof, b: Expr) -> "SpatialInertia":
        """What is felt before a segment that moves by the rate b as others do, too: with a column for it."""
        columns, u = dict(self.columns), self.of(dof)
        row: dict[Expr, Expr] = {}
        for other, c in self.columns.items():
            more = c.w.on(dof)
            if more is not ZERO:
                row[other] = mul(TWO, more) if other is b else more
                if other is not b:
                    columns[other] = c._replace(row=with_entries(c.row, {b: more}))
        row = with_entries(row, {b: u.on(dof)})
        columns[b] = columns.get(b, Column()).plus(Column(u, row, self.p.on(dof)))
        return self._replace(columns=columns)

    def wrench(self, at: Accelerations, values: Row) -> SpatialForce:
        """That at given accelerations and λ of the columns."""
        w = self.at(at.alpha, at.a).p
        for b, c in self.columns.items():
            w = w.plus(c.w.times(values[b]))
        return w


def _without(rows: Cosines, k: int) -> Cosines:
    """Symmetric rows with zeros in row and column k."""
    return as_rows([[ZERO if k in (a, b) else x for b, x in enumerate(row)] for a, row in enumerate(rows)])


NO_INERTIA = SpatialInertia(NO_ROWS, NO_ROWS, NO_ROWS, NO_WRENCH)


def of_rigid(body: Rigid, p: SpatialForce) -> SpatialInertia:
    """The inertia of a rigid body, with the wrench that is there at no acceleration."""
    m = body.m
    return SpatialInertia(body.j, skew(body.h), ((m, ZERO, ZERO), (ZERO, m, ZERO), (ZERO, ZERO, m)), p)


def to_rigid(felt: SpatialInertia) -> Rigid:
    """The rigid body with this inertia, which is that of one."""
    return Rigid(felt.m[0][0], (felt.h[2][1], felt.h[0][2], felt.h[1][0]), felt.j)
