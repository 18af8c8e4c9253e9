# SPDX-License-Identifier: BSD-3-Clause
"""Spatial quantities that sweeps carry along a tree: accelerations outward; wrenches, rigid-body and articulated inertias inward.

Each class has `turned`, which changes the basis (outward: to the child's, inward: to the parent's), and `moved`, which changes the
origin (outward: to the point at r; inward: to the point from which the present origin lies at r). Those carried inward also have
`plus`, the sum. Zeros are structural: sums and products with them create no expression node.

An inertia maps the acceleration (α, a) of a basis and of its origin to a moment about that origin and a force,

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
    """The reflected inertia `inertia`, added to M at a joint speed, and `force`, subtracted from f.

    They belong to a body that turns or slides in the ground at the rate of the joint speed: a geared rotor, a counterweight.
    """

    inertia: Expr
    force: Expr


class Dof(NamedTuple):
    """A joint speed: its motion subspace (`spin` in ω, `slide` in ṙ), its `row` as a linear form, and its number.

    Its rate λ, the coefficient of spin in α and of slide in a, is Σ c u̇ if the row is in generalized speeds, Σ c q̈ if it is in
    rates of coordinates, where c are the coefficients of the row.
    """

    spin: Triple
    slide: Triple
    row: Row
    number: int
    reflected: Reflected | None = None

    @property
    def unit(self) -> tuple[int, bool] | None:
        """(k, whether it is a rotation) if the motion subspace is the unit vector of basis axis k, else None."""
        k = _unit(self.spin) if is_zero(self.slide) else _unit(self.slide) if is_zero(self.spin) else None
        return None if k is None else (k, is_zero(self.slide))

    @property
    def free(self) -> tuple[int, bool] | None:
        """`unit` if no inertia is reflected to the joint, so that it transmits no moment or force along that axis, else None."""
        return self.unit if self.reflected is None else None


def _unit(v: Triple) -> int | None:
    k = [i for i, x in enumerate(v) if x is not ZERO]
    return k[0] if len(k) == 1 and v[k[0]] is ONE else None


class Accelerations(NamedTuple):
    """The angular acceleration α of a basis and the acceleration a of its origin."""

    alpha: Triple = NOTHING
    a: Triple = NOTHING

    def turned(self, turn: Change) -> "Accelerations":
        """The same vectors in the basis after the rotation `turn`."""
        return Accelerations(turn.down(self.alpha), turn.down(self.a))

    def moved(self, r: Triple, bias: Triple = NOTHING) -> "Accelerations":
        """The acceleration of the point at r, a + α × r + `bias`."""
        return Accelerations(self.alpha, summed(self.a, summed(cross3(self.alpha, r), bias)))

    def plus(self, alpha: Triple, a: Triple) -> "Accelerations":
        """The sum with another angular acceleration and acceleration."""
        return Accelerations(summed(self.alpha, alpha), summed(self.a, a))


class SpatialForce(NamedTuple):
    """A wrench: the moment n about the origin, and the force f."""

    n: Triple = NOTHING
    f: Triple = NOTHING

    def turned(self, turn: Change) -> "SpatialForce":
        """The same quantity in the basis before the rotation `turn`."""
        return SpatialForce(turn.up(self.n), turn.up(self.f))

    def moved(self, r: Triple) -> "SpatialForce":
        """The same quantity about the point from which the present origin lies at r."""
        return SpatialForce(summed(self.n, cross3(r, self.f)), self.f)

    def plus(self, other: "SpatialForce") -> "SpatialForce":
        """The sum."""
        return SpatialForce(summed(self.n, other.n), summed(self.f, other.f))

    def times(self, k: Expr) -> "SpatialForce":
        """The wrench multiplied by k."""
        return SpatialForce(times(k, self.n), times(k, self.f))

    def along(self, spin: Triple, slide: Triple) -> Expr:
        """spin·n + slide·f."""
        return add(dot(spin, self.n), dot(slide, self.f))

    def on(self, dof: Dof) -> Expr:
        """The generalized force of the wrench for a joint speed, spin·n + slide·f."""
        return self.along(dof.spin, dof.slide)


NO_WRENCH = SpatialForce()


def opposite(w: SpatialForce) -> SpatialForce:
    """−w."""
    return SpatialForce(negative(w.n), negative(w.f))


class Rigid(NamedTuple):
    """A rigid-body inertia: mass m, first moment h = m r*, and inertia dyadic J about the origin."""

    m: Expr
    h: Triple
    j: Cosines

    def plus(self, other: "Rigid") -> "Rigid":
        """The sum."""
        return Rigid(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.j, other.j))

    def turned(self, turn: Change) -> "Rigid":
        """The same quantity in the basis before the rotation `turn`."""
        return Rigid(self.m, turn.up(self.h), turn.up_symmetric(self.j))

    def moved(self, r: Triple) -> "Rigid":
        """The same quantity about the point from which the present origin lies at r."""
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
        """The bias wrench ω × J ω, ω × (ω × h); `square` is ω·ω. Multiples of the unit dyadic in J drop out, as ω × ω = 0."""
        (a, b, c), (d, e, f), (g, h, common) = self.j
        j = (sub(a, common), b, c), (d, sub(e, common), f), (g, h, ZERO)
        return SpatialForce(cross3(w, product(j, w)), centripetal(w, self.h, square))

    def about(self, k: int) -> Expr:
        """The moment of inertia about basis axis k."""
        return self.j[k][k]

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return product(self.j, v)

    def at(self, alpha: Triple, a: Triple) -> SpatialForce:
        """The wrench J α + h × a, α × h + m a at accelerations α and a; `bias` is not included."""
        return _at(self, alpha, a)

    @property
    def is_nothing(self) -> bool:
        """Whether all entries are structural zeros."""
        return self.m is ZERO and all(x is ZERO for row in (self.h, *self.j) for x in row)


NO_MASS = Rigid(ZERO, NOTHING, NO_ROWS)


class Moments(NamedTuple):
    """A rigid-body inertia by its moments: m, h = m r*, second moment E = Σ m r r, and the inertia dyadic J if it was given.

    J = (tr E) 1 − E. Moving E by p takes fewer operations than moving J (E + h p + p h + m p p, without a trace), and bias
    wrenches are shorter: since r × (a × (b × r)) = (r·(b × r)) a − (r·a) b × r, whose first term is zero,

        Σ m r × (a × (b × r)) = (E a) × b,        ω × J ω = (E ω) × ω
    """

    m: Expr
    h: Triple
    e: Cosines
    j: Cosines | None = None

    def plus(self, other: "Moments") -> "Moments":
        """The sum."""
        if self is NO_MOMENTS or other is NO_MOMENTS:
            return other if self is NO_MOMENTS else self
        return Moments(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.e, other.e))

    def turned(self, turn: Change) -> "Moments":
        """The same quantity in the basis before the rotation `turn`."""
        return self if self is NO_MOMENTS else Moments(self.m, turn.up(self.h), turn.up_symmetric(self.e))

    def moved(self, r: Triple) -> "Moments":
        """The same quantity about the point from which the present origin lies at r."""
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
        """The moment of inertia about basis axis k."""
        if self.j is not None:
            return self.j[k][k]
        return add(self.e[(k + 1) % 3][(k + 1) % 3], self.e[(k + 2) % 3][(k + 2) % 3])

    def entry(self, a: int, b: int) -> Expr:
        """The entry J_ab of the inertia dyadic."""
        return self.about(a) if a == b else neg(self.e[a][b])

    def along(self, k: int, v: Triple) -> Expr:
        """The measure number of J v along basis axis k."""
        return sum_of(mul(self.entry(k, b), x) for b, x in enumerate(v) if x is not ZERO)

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return NOTHING if v is NOTHING else triple(self.along(k, v) for k in range(3))

    def at(self, alpha: Triple, a: Triple) -> SpatialForce:
        """The wrench J α + h × a, α × h + m a at accelerations α and a; `bias` is not included."""
        return _at(self, alpha, a)


NO_MOMENTS = Moments(ZERO, NOTHING, NO_ROWS)


def moments(body: Rigid) -> Moments:
    """The moments of a rigid body, E = ½ (tr J) 1 − J."""
    if body.is_nothing:
        return NO_MOMENTS
    rows = [[neg(x) for x in row] for row in body.j]
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        rows[k][k] = mul(HALF, sub(add(body.j[a][a], body.j[b][b]), body.j[k][k]))
    return Moments(body.m, body.h, as_rows(rows), body.j)


def _at(body: Rigid | Moments, alpha: Triple, a: Triple) -> SpatialForce:
    """The wrench J α + h × a, α × h + m a."""
    n = summed(body.turned_by(alpha), cross3(body.h, a))
    return SpatialForce(n, summed(cross3(alpha, body.h), times(body.m, a)))


class Column(NamedTuple):
    """The column of elastic coordinate k in a spatial inertia: wrench (n_k, f_k), row m_kl of M, force e_k at zero acceleration.

    An elastic coordinate moves several segments. At the acceleration (α, a) of an origin and rates λ_k of such coordinates

        n = J α + H a + Σ n_k λ_k + …,   f = Hᵀ α + M a + Σ f_k λ_k + …,   Q_k = n_k·α + f_k·a + Σ m_kl λ_l + e_k.
    """

    w: SpatialForce = NO_WRENCH
    row: Row = MappingProxyType({})
    force: Expr = ZERO

    def plus(self, other: "Column") -> "Column":
        """The sum."""
        return Column(self.w.plus(other.w), with_entries(self.row, other.row), add(self.force, other.force))


Columns = Mapping[Expr, Column]
"""Columns of elastic coordinates, by the speed or rate that stands in the row of the coordinate."""
NO_COLUMNS: Columns = MappingProxyType({})


def joined(a: Columns, b: Columns) -> Columns:
    """The sums of columns of the same coordinate; columns in only one of the mappings are kept."""
    if not a or not b:
        return a or b
    return {k: a[k].plus(b[k]) if k in a and k in b else a.get(k) or b[k] for k in {**a, **b}}


def with_entries(row: Row, more: Row) -> dict[Expr, Expr]:
    """The sum of two sparse rows."""
    whole = dict(row)
    for k, x in more.items():
        whole[k] = add(whole.get(k, ZERO), x)
    return whole


class Elimination(NamedTuple):
    """One step of elimination in the ABA: of a joint speed, or of the rate of an elastic coordinate.

    λ = rest − t·(α, a) − Σ beside_k λ_k, where t = U/D, D is the pivot and beside_k = (n_k·s)/D for the elastic columns k present.
    """

    of: Dof | Expr
    t: SpatialForce
    rest: Expr
    d: Expr
    beside: Row

    def known(self, values: Row) -> Expr:
        """rest − Σ beside_k λ_k at the rates λ_k given in `values`."""
        rest = self.rest
        for b, x in self.beside.items():
            if x is not ZERO:
                rest = sub(rest, mul(x, values[b]))
        return rest

    def value(self, at: Accelerations, values: Row) -> Expr:
        """λ at the acceleration `at` of the origin and the rates of the elastic columns."""
        return sub(self.known(values), self.t.along(at.alpha, at.a))

    def after(self, at: Accelerations, values: Row) -> tuple[Expr, Accelerations]:
        """λ of a joint speed, and the acceleration beyond the joint."""
        assert isinstance(self.of, Dof)
        unit = self.of.free
        if unit is None:
            x = self.value(at, values)
            return x, at.plus(times(x, self.of.spin), times(x, self.of.slide))
        k, turns = unit  # U/D is 1 at component k, so solve for its sum with λ
        before = at.alpha if turns else at.a
        rest = at._replace(alpha=put(before, k, ZERO)) if turns else at._replace(a=put(before, k, ZERO))
        whole = self.value(rest, values)
        after = put(before, k, whole)
        return sub(whole, before[k]), at._replace(alpha=after) if turns else at._replace(a=after)


class SpatialInertia(NamedTuple):
    """A spatial inertia with blocks J, H and M, the wrench p at zero acceleration, and the columns of elastic coordinates."""

    j: Cosines
    h: Cosines
    m: Cosines
    p: SpatialForce
    columns: Columns = NO_COLUMNS

    def plus(self, other: "SpatialInertia") -> "SpatialInertia":
        """The sum."""
        return SpatialInertia(
            summed_symmetric(self.j, other.j),
            summed_rows(self.h, other.h),
            summed_symmetric(self.m, other.m),
            self.p.plus(other.p),
            joined(self.columns, other.columns),
        )

    def turned(self, turn: Change) -> "SpatialInertia":
        """The same quantity in the basis before the rotation `turn`."""
        return SpatialInertia(
            turn.up_symmetric(self.j, several=True),
            turn.up_general(self.h),
            turn.up_symmetric(self.m, several=True),
            self.p.turned(turn),
            {b: c._replace(w=c.w.turned(turn)) for b, c in self.columns.items()},
        )

    def moved(self, r: Triple) -> "SpatialInertia":
        """The same quantity about the point from which the present origin lies at r."""
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
        """The inertia with known parts α, a of the acceleration moved into the wrench p and into the columns' forces."""
        if is_zero(alpha) and is_zero(a):
            return self
        columns = {b: c._replace(force=add(c.force, c.w.along(alpha, a))) for b, c in self.columns.items()}
        n = summed(summed(self.p.n, product(self.j, alpha)), product(self.h, a))
        f = summed(summed(self.p.f, product(transposed(self.h), alpha)), product(self.m, a))
        return self._replace(p=SpatialForce(n, f), columns=columns)

    def of(self, dof: Dof) -> SpatialForce:
        """U = I s, the wrench at unit rate of a joint speed; one column of the inertia if s is the unit vector of a basis axis."""
        if dof.unit is not None:
            k, turns = dof.unit
            return SpatialForce(transposed(self.j if turns else self.h)[k], (self.h if turns else self.m)[k])
        n = summed(product(self.j, dof.spin), product(self.h, dof.slide))
        return SpatialForce(n, summed(product(transposed(self.h), dof.spin), product(self.m, dof.slide)))

    def without(self, dof: Dof) -> tuple["SpatialInertia", Elimination]:
        """The articulated inertia before a free joint speed, and its elimination (Featherstone 2008, sec. 7.2).

        U = I s,   D = s·U,   λ = (−s·p − U·a)/D,      I − U Uᵀ/D,   p − U (s·p)/D
        """
        u = self.of(dof)
        d, force = u.on(dof), self.p.on(dof)
        if dof.reflected is not None:
            d, force = add(d, dof.reflected.inertia), add(force, dof.reflected.force)
        left, pivot = self._eliminated(dof, u, d, force, {b: c.w.on(dof) for b, c in self.columns.items()})
        if dof.free is None:
            return left, pivot
        k, turns = dof.free  # row and column k of I − U Uᵀ/D cancel: make them structural zeros
        if turns:
            p = left.p._replace(n=put(left.p.n, k, ZERO))
            return left._replace(j=_without(left.j, k), h=put(left.h, k, NOTHING), p=p), pivot
        h = transposed(put(transposed(left.h), k, NOTHING))
        return left._replace(h=h, m=_without(left.m, k), p=left.p._replace(f=put(left.p.f, k, ZERO))), pivot

    def without_mode(self, b: Expr) -> tuple["SpatialInertia", Elimination]:
        """The inertia with the elastic coordinate of q̇ = b eliminated, at the segment that carries all segments it moves."""
        columns = dict(self.columns)
        own = columns.pop(b, Column())
        less = {k: c._replace(row={o: x for o, x in c.row.items() if o is not b}) for k, c in columns.items()}
        beside = {k: own.row[k] for k in own.row if k is not b}
        return self._replace(columns=less)._eliminated(b, own.w, own.row.get(b, ZERO), own.force, beside)

    def _eliminated(
        self, of: Dof | Expr, u: SpatialForce, d: Expr, force: Expr, g: Row
    ) -> tuple["SpatialInertia", Elimination]:
        """Eliminates an unknown with wrench U, pivot D, `force` at zero acceleration and couplings g; SingularError if D is zero."""
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
        """The inertia before a segment that the elastic coordinate with rate b moves by `dof`; the segment is added to its column."""
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
        """The wrench at the acceleration `at` and the rates `values` of the elastic columns."""
        w = self.at(at.alpha, at.a).p
        for b, c in self.columns.items():
            w = w.plus(c.w.times(values[b]))
        return w


def _without(rows: Cosines, k: int) -> Cosines:
    """Symmetric rows with zeros in row and column k."""
    return as_rows([[ZERO if k in (a, b) else x for b, x in enumerate(row)] for a, row in enumerate(rows)])


NO_INERTIA = SpatialInertia(NO_ROWS, NO_ROWS, NO_ROWS, NO_WRENCH)


def of_rigid(body: Rigid, p: SpatialForce) -> SpatialInertia:
    """The spatial inertia of a rigid body with wrench p at zero acceleration."""
    m = body.m
    return SpatialInertia(body.j, skew(body.h), ((m, ZERO, ZERO), (ZERO, m, ZERO), (ZERO, ZERO, m)), p)


def to_rigid(inertia: SpatialInertia) -> Rigid:
    """The rigid-body inertia equal to a spatial inertia that has the form of one."""
    return Rigid(inertia.m[0][0], (inertia.h[2][1], inertia.h[0][2], inertia.h[1][0]), inertia.j)
