# SPDX-License-Identifier: BSD-3-Clause
"""Analytical derivatives of inverse dynamics by any symbols, at constant accelerations (Singh, Russo & Wensing 2022).

A symbol x changes the motion of some segments relative to their parents. For each such segment the change of its subtree's wrench is
propagated to the ground and projected on the joints on that path; each joint of the subtree has a row, propagated inward to the
segment, whose product with the change of motion is the derivative of its force. If ω, α of a segment and a of its origin O change and
the motion of the subtree relative to it does not, particles at ρ with velocities v from O change their accelerations by
δα′ × ρ + 2 δω × v + δa, where δα′ = δα − δω × ω. With ρ × (δω × v) = (ρ·v) δω − v (ρ·δω)

    δn = J δα′ + (tr P 1 − P) δω + h × δa,      δf = δα′ × h + δω × 2 h° + m δa,

J = ∫ (ρ·ρ 1 − ρ ρᵀ) dm, h = ∫ ρ dm, h° = ∫ v dm and P = 2 ∫ v ρᵀ dm, a dyadic that is not symmetric and replaces J° and ∫ ρ × v dm.
δω and δα′ are the same for all segments of the subtree, and an origin at r with velocity v from O changes its acceleration by
δa + δα′ × r + 2 δω × v.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from kane.expr.build import add, div, mul, neg, sub, sum_of
from kane.expr.differentiation import tangent
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import dot
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import substituted
from kane.space.rotation import NOTHING, Cosines, Triple, cross3, product, transposed
from kane.tree.sweeps import Carry, Driven, Rates, Segment, Tree, inward, outward, rates
from kane.tree.triples import as_rows, is_zero, summed, summed_rows, times, triple, turned_down
from kane.tree.values import NO_WRENCH, Accelerations, Change, Dof, Rigid, SpatialForce

Vectors = tuple[Triple, ...]


class TracedFunction:
    """A function `make` of vectors or scalars, traced once with symbols for its arguments, whose values are `at`.

    `symbols` are the free symbols of its result other than its arguments.
    """

    def __init__(self, make: Callable[..., Sequence[Any]], at: Sequence[Any]) -> None:
        names = (Parameter.declare(f"held{k}", description="what is held") for k, _ in enumerate(_flat(at)))
        held = _like(at, names)
        self.values: dict[Expr, Expr] = dict(zip(_flat(held), _flat(at), strict=True))
        self.made = make(*held)
        self.symbols = frozenset(free_symbols(_flat(self.made))).difference(self.values)

    def slope(self, x: Expr) -> Any:
        """The partial derivative by a symbol at constant arguments; None if it is zero."""
        return self._derivative({x: ONE}) if x in self.symbols else None

    def along(self, change: Sequence[Any]) -> Any:
        """The directional derivative for a change of the arguments; None if it is zero."""
        return self._derivative(dict(zip(self.values, _flat(change), strict=True)))

    def _derivative(self, seeds: dict[Expr, Expr]) -> Any:
        memo: dict[Expr, Expr] = {}
        images: dict[Expr, Expr] = {}
        found = [substituted(tangent(e, seeds, memo, at_rest=True), self.values, images) for e in _flat(self.made)]
        return None if all(x is ZERO for x in found) else _like(self.made, iter(found))


def total(parts: Sequence[Any]) -> Any:
    """The sum of nested tuples of equal structure; None counts as zero."""
    result: Any = None
    for part in parts:
        if result is None:
            result = part
        elif part is not None:
            result = _like(result, map(add, _flat(result), _flat(part)))
    return result


def _flat(vectors: Sequence[Any]) -> list[Expr]:
    return [x for v in vectors for x in (v if isinstance(v, tuple) else (v,))]


def _like(vectors: Sequence[Any], values: Iterator[Expr]) -> tuple[Any, ...]:
    return tuple(tuple(next(values) for _ in v) if isinstance(v, tuple) else next(values) for v in vectors)


class _Row(NamedTuple):
    """The coefficients of δω, δα′ and δa in the change of a joint force."""

    spin: Triple
    alpha: Triple
    a: Triple

    def times(self, change: Vectors) -> Expr:
        """The change of the joint force for the change (δω, δα′, δa) of motion."""
        spin, alpha, a = change
        return add(add(dot(self.spin, spin), dot(self.alpha, alpha)), dot(self.a, a))

    def turned(self, turn: Change) -> "_Row":
        """The row in the basis before the rotation `turn`."""
        return _Row(*map(turn.up, self))

    def swept(self, r: Triple, v: Triple) -> "_Row":
        """The row for changes at the point from which the present origin lies at r and has the velocity v."""
        spin = summed(self.spin, cross3(times(TWO, v), self.a))
        return _Row(spin, summed(self.alpha, cross3(r, self.a)), self.a)


class SubtreeMoments(NamedTuple):
    """The moments of a subtree: m, h, J in `body`, 2 h° in `shift` and P in `spread`."""

    body: Rigid
    shift: Triple
    spread: Cosines

    def plus(self, other: "SubtreeMoments") -> "SubtreeMoments":
        """The sum."""
        shift, spread = summed(self.shift, other.shift), summed_rows(self.spread, other.spread)
        return SubtreeMoments(self.body.plus(other.body), shift, spread)

    def turned(self, turn: Change) -> "SubtreeMoments":
        """The same quantity in the basis before the rotation `turn`."""
        return SubtreeMoments(self.body.turned(turn), turn.up(self.shift), turn.up_general(self.spread))

    def swept(self, r: Triple, v: Triple) -> "SubtreeMoments":
        """The moments about the point from which the present origin lies at r with velocity v: P + 2 h° rᵀ + 2 v (h + m r)ᵀ."""
        body, twice = self.body.moved(r), times(TWO, v)
        a, b, c = (
            summed(row, summed(times(x, r), times(y, body.h)))
            for row, x, y in zip(self.spread, self.shift, twice, strict=True)
        )
        return SubtreeMoments(body, summed(self.shift, times(body.m, twice)), (a, b, c))

    def turning(self) -> Cosines:
        """tr P 1 − P."""
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.spread
        return ((add(yy, zz), neg(xy), neg(xz)), (neg(yx), add(xx, zz), neg(yz)), (neg(zx), neg(zy), add(xx, yy)))

    def change(self, spin: Triple, alpha: Triple, a: Triple) -> SpatialForce:
        """The change δn, δf of the wrench for the change δω, δα′, δa of motion."""
        m, h, j = self.body
        n = summed(product(self.turning(), spin), summed(product(j, alpha), cross3(h, a)))
        f = summed(cross3(spin, self.shift), cross3(alpha, h))
        return SpatialForce(n, summed(f, times(m, a)))

    def row(self, dof: Dof) -> _Row:
        """The row of s·δn + t·δf for a joint speed with spin s and slide t."""
        m, h, j = self.body
        spin, slide = dof.spin, dof.slide
        turned = _Row(product(transposed(self.turning()), spin), product(j, spin), cross3(spin, h))
        slid = _Row(cross3(self.shift, slide), cross3(h, slide), times(m, slide))
        return _Row(*map(summed, turned, slid))


def alone(body: Rigid, w: Triple) -> SubtreeMoments:
    """The moments of one body with angular velocity ω: P = 2 ω × E, where E = ∫ ρ ρᵀ dm = ½ (tr J) 1 − J."""
    half = div(add(add(body.j[0][0], body.j[1][1]), body.j[2][2]), TWO)
    spread = as_rows([[sub(half, x) if a == b else neg(x) for b, x in enumerate(row)] for a, row in enumerate(body.j)])
    twice = times(TWO, w)
    x, y, z = (cross3(twice, column) for column in spread)  # ∫ ρ ρᵀ dm is symmetric
    return SubtreeMoments(body, cross3(twice, body.h), transposed((x, y, z)))


@dataclass(frozen=True, eq=False)
class _Value:
    """A subtree: its moments, its wrench, the derivatives of that by symbol, and the rows of its joint speeds, by number."""

    symbols: Sequence[Symbol]
    moving: SubtreeMoments
    force: SpatialForce
    columns: dict[Symbol, SpatialForce]
    rows: dict[int, _Row]

    def plus(self, other: "_Value") -> "_Value":
        """The sum."""
        columns = dict(self.columns)
        for x, w in other.columns.items():
            _join(columns, x, w)
        moving = self.moving.plus(other.moving)
        return _Value(self.symbols, moving, self.force.plus(other.force), columns, {**self.rows, **other.rows})

    def turned(self, turn: Change) -> "_Value":
        """The same quantity in the basis before the rotation `turn`."""
        force, columns = self.passed(lambda n, f: SpatialForce(n, f).turned(turn))
        rows = {k: row.turned(turn) for k, row in self.rows.items()}
        return _Value(self.symbols, self.moving.turned(turn), force, columns, rows)

    def moved(self, r: Triple) -> "_Value":
        """The value about the point from which the present origin lies at r, without relative velocity."""
        return self.swept(r, NOTHING)

    def swept(self, r: Triple, v: Triple) -> "_Value":
        """The value about the point from which the present origin lies at r with velocity v."""
        force, columns = self.passed(lambda n, f: SpatialForce(n, f).moved(r))
        rows = {k: row.swept(r, v) for k, row in self.rows.items()}
        return _Value(self.symbols, self.moving.swept(r, v), force, columns, rows)

    def passed(self, make: Callable[[Triple, Triple], SpatialForce]) -> tuple[SpatialForce, dict[Symbol, SpatialForce]]:
        """The wrench changed by `make`, and its derivatives, which include those of `make` itself."""
        columns, held = {x: make(*w) for x, w in self.columns.items()}, TracedFunction(make, self.force)
        for x in self.symbols:
            _join(columns, x, held.slope(x))
        return make(*self.force), columns


def _join(columns: dict[Symbol, SpatialForce], x: Symbol, w: Sequence[Triple] | None) -> None:
    if w is not None:
        own = SpatialForce(*w)
        columns[x] = columns[x].plus(own) if x in columns else own


class _Traced(Driven):
    """The outward sweep of accelerations that records them along A before the arm (`entered`) and after the outer joint (`placed`)."""

    def __init__(self, tree: Tree, moving: Sequence[Rates], lambdas: Sequence[Expr]) -> None:
        super().__init__(tree, moving, lambdas)
        self.entered, self.placed = [Accelerations()], [Accelerations()]

    def arm(self, i: int, v: Accelerations) -> Accelerations:
        self.entered.append(v)
        return super().arm(i, v)

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        self.placed.append(super().outer(i, v))
        return self.placed[-1]


class _Changes(Carry[_Value]):
    """The inward sweep that computes ∂g/∂x by number and x, where g is the generalized force of each joint speed."""

    def __init__(self, tree: Tree, ground: Triple, lambdas: Sequence[Expr], symbols: Sequence[Symbol]) -> None:
        super().__init__(tree)
        self.symbols, self.wanted, self.lambdas = symbols, frozenset(symbols), lambdas
        self.rates = rates(tree)
        drive = _Traced(tree, self.rates, lambdas)
        self.work = outward(tree, drive, Accelerations(NOTHING, ground))
        falls = {x: triple(tangent(e, {x: ONE}) for e in ground) for x in symbols}
        self.changed: list[dict[Symbol, Vectors]] = [
            {x: (NOTHING, NOTHING, v) for x, v in falls.items() if not is_zero(v)}
        ]
        for i in range(1, len(tree)):
            self.changed.append(self.changes(i, drive))
        self.ground = bool(self.changed[0])
        self.found: dict[tuple[int, Symbol], Expr] = {}

    def changes(self, i: int, drive: _Traced) -> dict[Symbol, Vectors]:
        """The derivatives δω, δα′ and δa of a segment's motion by symbol, at a given motion of its parent."""
        s, at, result = self.tree[i], self.rates[i], dict[Symbol, Vectors]()
        parent = self.rates[s.parent].w, *self.work[s.parent]
        stages = [
            TracedFunction(lambda *v: tuple(turned_down(s.lead, x) for x in v), parent),
            TracedFunction(lambda w, alpha, a: _placed(s, w, alpha, a), (at.before, *drive.entered[i])),
            TracedFunction(lambda w, alpha, a: _turned(s, w, alpha, a), (at.before, *drive.placed[i])),
        ]
        for x in self.symbols:
            change: Vectors | None = None
            for stage, dofs in zip(stages, ((), s.outer.dofs, s.inner.dofs), strict=True):
                own = self.driven(dofs, x)
                change = total([None if change is None else stage.along(change), stage.slope(x), own])
            if change is not None:
                spin, alpha, a = change
                result[x] = spin, triple(map(sub, alpha, cross3(spin, at.w))), a
        return result

    def driven(self, dofs: Sequence[Dof], x: Symbol) -> Vectors | None:
        """The derivatives of α and a by x due to motion subspaces that depend on x; None if they are zero."""
        alpha = a = NOTHING
        for dof in dofs:
            spin, slide = (triple(tangent(e, {x: ONE}) for e in v) for v in (dof.spin, dof.slide))
            alpha = summed(alpha, times(self.lambdas[dof.number], spin))
            a = summed(a, times(self.lambdas[dof.number], slide))
        return None if is_zero((*alpha, *a)) else (NOTHING, alpha, a)

    def local(self, i: int) -> _Value:
        s, at, work = self.tree[i], self.rates[i], self.work[i]

        def net_wrench(w: Triple, alpha: Triple, a: Triple) -> SpatialForce:
            return s.net_wrench(w, dot(w, w), Accelerations(alpha, a))

        columns, held = dict[Symbol, SpatialForce](), TracedFunction(net_wrench, (at.w, *work))
        for x in self.symbols if i else ():
            _join(columns, x, held.slope(x))
        force = s.net_wrench(at.w, at.square, work) if i else NO_WRENCH
        return _Value(self.symbols, alone(s.body, at.w), force, columns, {})

    def whole(self, i: int, v: _Value | None) -> _Value | None:
        assert v is not None
        columns = dict(v.columns)
        for x, change in self.changed[i].items():
            for number, row in v.rows.items():
                self.add(number, x, row.times(change))
            if i:
                _join(columns, x, v.moving.change(*change))
        return _Value(self.symbols, v.moving, v.force, columns, v.rows)

    def inner(self, i: int, v: _Value) -> _Value:
        return self.project(self.tree[i].inner.dofs, v)

    def outer(self, i: int, v: _Value) -> _Value:
        return self.project(self.tree[i].outer.dofs, v)

    def arm(self, i: int, v: _Value) -> _Value:
        s, at = self.tree[i], self.rates[i]
        late = s.inner.slide if s.turn is None else s.turn.up(s.inner.slide)
        return v.swept(s.arm, summed(cross3(at.before, s.arm), summed(s.outer.slide, late)))

    def project(self, dofs: Sequence[Dof], v: _Value) -> _Value:
        """Adds ∂(s·w)/∂x for the wrench w and motion subspaces s, and derivatives of reflected inertias; the value with their rows."""
        rows = dict(v.rows)
        for dof in dofs:
            for x, w in v.columns.items():
                self.add(dof.number, x, sum_of(map(dot, (dof.spin, dof.slide), w)))
            for x in free_symbols([*dof.spin, *dof.slide]):
                if x in self.wanted:
                    axes = [[tangent(e, {x: ONE}) for e in axis] for axis in (dof.spin, dof.slide)]
                    self.add(dof.number, x, sum_of(map(dot, axes, v.force)))
            if dof.reflected is not None:
                inertia, force = dof.reflected
                for x in self.wanted & {*free_symbols([inertia, force])}:
                    changed = mul(tangent(inertia, {x: ONE}), self.lambdas[dof.number])
                    self.add(dof.number, x, add(changed, tangent(force, {x: ONE})))
            rows[dof.number] = v.moving.row(dof)
        return _Value(self.symbols, v.moving, v.force, v.columns, rows)

    def add(self, number: int, x: Symbol, value: Expr) -> None:
        """Adds to ∂g/∂x."""
        self.found[number, x] = add(self.found.get((number, x), ZERO), value)


def _placed(s: Segment, w: Triple, alpha: Triple, a: Triple) -> Vectors:
    """ω of the parent, α and a at the origin of a segment, along A, at zero rates of the joint speeds."""
    a = summed(a, summed(cross3(alpha, s.arm), cross3(w, cross3(w, s.arm))))
    a = summed(a, s.outer.slide_drift)
    return w, alpha, a if is_zero(s.outer.slide) else summed(a, times(TWO, cross3(w, s.outer.slide)))


def _turned(s: Segment, w: Triple, alpha: Triple, a: Triple) -> Vectors:
    """ω, α and a of a segment in its working basis, from those along A, at zero rates of the inner joint speeds."""
    if s.turn is not None:
        w, alpha, a = map(s.turn.down, (w, alpha, a))
    if not is_zero(s.inner.slide):
        doubled = summed(times(TWO, w), s.inner.spin)
        a = summed(summed(a, s.inner.slide_drift), cross3(doubled, s.inner.slide))
    alpha = summed(alpha, summed(s.inner.spin_drift, cross3(w, s.inner.spin)))
    return summed(w, s.inner.spin), alpha, a


def tangents(
    tree: Tree, ground: Triple, lambdas: Sequence[Expr], symbols: Sequence[Symbol]
) -> dict[tuple[int, Symbol], Expr]:
    """∂g/∂x at constant λ, by the number of the joint speed and symbol; g are the generalized forces of inverse dynamics."""
    carry = _Changes(tree, ground, lambdas, symbols)
    inward(tree, carry)
    return carry.found
