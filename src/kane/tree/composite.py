# SPDX-License-Identifier: BSD-3-Clause
"""The composite-rigid-body algorithm (Featherstone 2008, ch. 6): the joint-space inertia M, its sparse L D Lᵀ, and bias forces.

At unit rate of one joint speed its subtree accelerates as one composite body: the wrench is I s, and M_rs = s·(I s_r) for each joint
speed on the path to the ground. M is factored from the tips, without fill-in. Takes fewer operations than the articulated-body
algorithm along short branches.

The bias forces are made of composite bodies as well. At ẇ = 0 beyond a segment, the motion of its subtree is that of a body rigidly
attached to the parent, with ω, α and a of the segment's origin, and the relative motion of the joints in the subtree. With the
moments m, h and E of the composite body the first part has the wrench

    n = J α + (E ω) × ω + h × a,        f = m a + α × h + ω × (ω × h)

and each joint of the subtree with relative angular velocity ω_r, with the composite body beyond it, adds

    n = (E (2 ω + ω_r)) × ω_r,        f = (2 ω + ω_r) × (ω_r × h)

and, if it slides, h × a_r and m a_r of its Coriolis acceleration a_r = 2 ω × ṙ + …. Only the second part is propagated to the ground;
ω × J ω of single bodies is never formed.

M (ẇ − ẇ°) = −b(ẇ°) holds at any trial ẇ°. If J is diagonal and the mass centre lies on the joint's axis, the forces are shorter body
by body, at the trial accelerations that have no component along motion subspaces which are unit vectors.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

from kane.expr.build import add, mul, neg, sub, sum_of
from kane.expr.matrix import LDL, dot, ldl, sparse_order
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.tree.articulated import Passed, PropagatedForce, Wrenches
from kane.tree.sweeps import Carry, Driven, Forces, Rates, Tree, forces, inward, outward, rates
from kane.tree.triples import centripetal, is_zero, put, summed, times, triple
from kane.tree.values import (
    HALF,
    NO_WRENCH,
    Accelerations,
    Change,
    Dof,
    Moments,
    Rigid,
    Row,
    SpatialForce,
    SpatialInertia,
    moments,
    opposite,
    to_rigid,
)

Body = TypeVar("Body", Rigid, Moments)


class Composites(Carry[Body]):
    """The composite body of each segment, its subtree as one body about its origin: in the working basis (`work`) and along A."""

    def __init__(self, tree: Tree, bodies: Sequence[Body]) -> None:
        super().__init__(tree)
        self.bodies: Sequence[Body] = bodies
        self.work: list[Body] = list(bodies)
        self.along_a: list[Body] = list(bodies)
        inward(tree, self)

    def local(self, i: int) -> Body:
        """The body of segment i."""
        return self.bodies[i]

    def inner(self, i: int, v: Body) -> Body:
        """Records the composite body in the working basis."""
        self.work[i] = v
        return v

    def outer(self, i: int, v: Body) -> Body:
        """Records the composite body along A."""
        self.along_a[i] = v
        return v


class _Columns(tuple[tuple[int, SpatialForce], ...]):
    """Pairs (number, wrench I s at unit rate) of joint speeds."""

    __slots__ = ()

    def turned(self, turn: Change) -> "_Columns":
        """The wrenches in the basis before the rotation `turn`."""
        return _Columns((k, w.turned(turn)) for k, w in self)

    def moved(self, r: Triple) -> "_Columns":
        """The wrenches about the point from which the present origin lies at r."""
        return _Columns((k, w.moved(r)) for k, w in self)

    def plus(self, other: "_Columns") -> "_Columns":
        """The pairs of both."""
        return _Columns((*self, *other))


class _Mass(Carry[_Columns]):
    """The inward sweep that fills M, the joint-space inertia."""

    def __init__(
        self, tree: Tree, composite: Composites[Rigid] | Composites[Moments], elastic: Mapping[int, SpatialInertia]
    ) -> None:
        super().__init__(tree)
        self.composite, self.elastic, self.modes = composite, elastic, mode_numbers(tree)
        count = dof_count(tree)
        self.rows = [[ZERO] * count for _ in range(count)]
        for inertia in elastic.values():
            for b, column in inertia.columns.items():
                for other, x in column.row.items():
                    r, k = self.modes[b], self.modes[other]
                    self.rows[r][k] = add(self.rows[r][k], x)
        inward(tree, self)

    def local(self, i: int) -> _Columns:
        """The wrenches of the flexible parts of segment i."""
        columns = self.elastic[i].columns if i in self.elastic else {}
        return _Columns((self.modes[b], column.w) for b, column in columns.items())

    def inner(self, i: int, v: _Columns) -> _Columns:
        """Adds the inner joint speeds."""
        return self.fill(self.tree[i].inner.dofs, self.composite.work[i], v)

    def outer(self, i: int, v: _Columns) -> _Columns:
        """Adds the outer joint speeds and the elastic coordinates."""
        return self.fill((*self.tree[i].outer.dofs, *self.tree[i].shared), self.composite.along_a[i], v)

    def fill(self, dofs: Sequence[Dof], body: Rigid | Moments, v: _Columns) -> _Columns:
        """Fills the rows of some joint speeds that move `body`; v with their wrenches."""
        for dof in dofs:
            s = dof.number
            for r, w in v:
                x = w.on(dof)
                self.rows[r][s] = self.rows[s][r] = add(self.rows[r][s], mul(TWO, x) if r == s else x)
            own = body.at(dof.spin, dof.slide)
            self.rows[s][s] = add(self.rows[s][s], own.on(dof))
            if dof.reflected is not None:
                self.rows[s][s] = add(self.rows[s][s], dof.reflected.inertia)
            v = _Columns((*v, (s, own)))
        return v


def mass_rows(
    tree: Tree, whole: Composites[Rigid] | Composites[Moments], elastic: Mapping[int, SpatialInertia]
) -> list[list[Expr]]:
    """The joint-space inertia M (n × n) of joint speeds and elastic coordinates, by number."""
    return _Mass(tree, whole, elastic).rows


def mode_numbers(tree: Tree) -> dict[Expr, int]:
    """The numbers of elastic coordinates by their rates; they follow those of joint speeds."""
    count = sum(len(s.dofs) for s in tree)
    return {b: count + k for k, b in enumerate(b for s in tree for b in s.modes)}


def dof_count(tree: Tree) -> int:
    """The number n of joint speeds and elastic coordinates."""
    return sum(len(s.dofs) + len(s.modes) for s in tree)


def rows_of(tree: Tree) -> list[Row]:
    """The rows of joint speeds and elastic coordinates in generalized speeds or in rates, by number."""
    own = sorted((dof for s in tree for dof in s.dofs), key=lambda dof: dof.number)
    return [*(dof.row for dof in own), *({b: ONE} for b in mode_numbers(tree))]


def add_reflected(tree: Tree, on: list[Expr], lambdas: Sequence[Expr]) -> None:
    """Adds the reflected inertias' forces at rates `lambdas` to the generalized forces `on`, both by number."""
    for dof in (dof for s in tree for dof in s.dofs):
        if dof.reflected is not None:
            whole = add(dof.reflected.force, mul(dof.reflected.inertia, lambdas[dof.number]))
            on[dof.number] = add(on[dof.number], whole)


def elastic_parts(tree: Tree, moving: Sequence[Rates]) -> dict[int, SpatialInertia]:
    """The spatial inertias of flexible parts, by segment."""
    return {i: s.elastic(at.w, at.square) for i, (s, at) in enumerate(zip(tree, moving, strict=True)) if s.elastic}


def with_more(bodies: Sequence[Body], more: Mapping[int, Body]) -> list[Body]:
    """The bodies, with those of `more` added by index."""
    return [body.plus(more[i]) if i in more else body for i, body in enumerate(bodies)]


class _Bias(Forces):
    """The inward sweep for the bias forces, at ẇ = 0, of composite bodies without flexible parts."""

    def __init__(
        self,
        tree: Tree,
        moving: Sequence[Rates],
        whole: Composites[Moments],
        at: Driven,
        wrenches: Sequence[SpatialForce | None],
    ) -> None:
        super().__init__(tree, wrenches, dof_count(tree))
        self.moving, self.composite, self.at = moving, whole, at

    def joint(self, i: int, *, turned: bool) -> "_Joint":
        """The composite body of segment i with the parent's motion, along A or, if `turned`, in the working basis."""
        s, at, motion, square = self.tree[i], self.moving[i], self.at.origins[i], self.moving[i].before_square
        beyond = at.w, s.inner.spin, s.inner.spin_drift
        if turned and s.turn is not None:
            return _Joint(self.composite.work[i], s.turn.down(at.before), motion.turned(s.turn), square, *beyond)
        k = self.axis(i)
        about = ZERO if k is None else self.composite.work[i].about(k)
        return _Joint(self.composite.along_a[i], at.before, motion, square, *beyond, k, about)

    def axis(self, i: int) -> int | None:
        """The axis of the inner joint if it is a rotation about one basis axis without slide, else None."""
        return self.tree[i].axis if is_zero(self.tree[i].inner.slide) else None

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        if self.tree[i].turn is not None and self.axis(i) is not None:
            return v  # done by `outer` along A, where the moment about the axis is the same
        return self.joined(i, self.joint(i, turned=True), v)

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        s = self.tree[i]
        if s.turn is not None and self.axis(i) is not None:
            v = self.joined(i, self.joint(i, turned=False), v)
        carried = _Joint(
            self.composite.along_a[i], self.moving[i].before, self.at.origins[i], self.moving[i].before_square
        )
        for dof in (*s.outer.dofs, *s.shared):
            self.found[dof.number] = add(self.found[dof.number], carried.bias(dof, v))
        return v

    def arm(self, i: int, v: SpatialForce) -> SpatialForce:
        return v.plus(_sliding(self.composite.along_a[i], self.moving[i].coriolis)).moved(self.tree[i].arm)

    def joined(self, i: int, joint: "_Joint", v: SpatialForce) -> SpatialForce:
        """The wrench with the inner joint's part added; records the bias forces of its joint speeds."""
        v = v.plus(joint.turning()).plus(_sliding(joint.body, self.moving[i].sliding))
        for dof in self.tree[i].inner.dofs:
            self.found[dof.number] = joint.bias(dof, v)
        return v


@dataclass(frozen=True, eq=False)
class _Joint:
    """The composite body beyond a joint, with the parent's motion: ω = `w`, (α, a) = `at` and ω·ω = `square`.

    `whole` is ω of the segment, `turned` the angular velocity of the joint and `drift` its derivative at ẇ = 0; `axis` is the basis
    axis of the rotation, if it has one, and `about` the moment of inertia about it.
    """

    body: Moments
    w: Triple
    at: Accelerations
    square: Expr
    whole: Triple = NOTHING
    turned: Triple = NOTHING
    drift: Triple = NOTHING
    axis: int | None = None
    about: Expr = ZERO

    @cached_property
    def ew(self) -> Triple:
        """E ω."""
        return product(self.body.e, self.w)

    def bias(self, dof: Dof, w: SpatialForce) -> Expr:
        """The bias force of a joint speed: of the parent's motion and of the wrench `w`."""
        turns = sum_of(mul(s, add(w.n[k], self.moment(k))) for k, s in enumerate(dof.spin) if s is not ZERO)
        return turns if is_zero(dof.slide) else add(turns, dot(dof.slide, summed(w.f, self.force)))

    def moment(self, k: int) -> Expr:
        """The component of n along basis axis k due to the parent's motion."""
        i, j = (k + 1) % 3, (k + 2) % 3
        h, (alpha, a) = self.body.h, self.at
        if k == self.axis:
            accelerated = sub(mul(self.about, alpha[k]), sum_of(mul(self.body.e[k][b], alpha[b]) for b in (i, j)))
        else:
            accelerated = self.body.along(k, alpha)
        swung = sub(mul(self.w[j], self.ew[i]), mul(self.w[i], self.ew[j]))
        return add(accelerated, add(swung, sub(mul(h[i], a[j]), mul(h[j], a[i]))))

    @cached_property
    def force(self) -> Triple:
        """f due to the parent's motion."""
        h, (alpha, a) = self.body.h, self.at
        return summed(summed(times(self.body.m, a), cross3(alpha, h)), centripetal(self.w, h, self.square))

    def turning(self) -> SpatialForce:
        """The wrench due to the relative rotation of the joint."""
        body, turned = self.body, self.turned
        if is_zero(turned):
            return NO_WRENCH
        if self.axis is not None:
            w = self.about_axis(self.axis)
        else:
            twice = summed(self.w, self.whole)
            w = SpatialForce(cross3(product(body.e, twice), turned), cross3(twice, cross3(turned, body.h)))
        return (
            w if is_zero(self.drift) else w.plus(SpatialForce(body.turned_by(self.drift), cross3(self.drift, body.h)))
        )

    def about_axis(self, k: int) -> SpatialForce:
        """The same for a rotation about basis axis k, in fewer operations."""
        i, j = (k + 1) % 3, (k + 2) % 3
        (h, e), w, u = (self.body.h, self.body.e), self.w, self.turned[k]
        n, f = [ZERO] * 3, [ZERO] * 3
        if w[i] is ZERO and w[j] is ZERO:
            both = sub(mul(self.whole[k], self.whole[k]), mul(w[k], w[k]))
            n[i], n[j] = mul(both, e[j][k]), neg(mul(both, e[i][k]))
        else:
            twice, half = mul(TWO, u), mul(HALF, u)
            both = mul(twice, add(w[k], half))
            n[i] = mul(twice, add(self.ew[j], mul(e[j][k], half)))
            n[j] = neg(mul(twice, add(self.ew[i], mul(e[i][k], half))))
            f[k] = mul(twice, add(mul(w[i], h[i]), mul(w[j], h[j])))
        f[i], f[j] = neg(mul(both, h[i])), neg(mul(both, h[j]))
        return SpatialForce(triple(n), triple(f))


def _sliding(body: Rigid | Moments, a: Triple) -> SpatialForce:
    """The wrench h × a, m a of a body whose origin has the acceleration a."""
    return NO_WRENCH if is_zero(a) else SpatialForce(cross3(body.h, a), times(body.m, a))


class _Trial(Driven):
    """Trial accelerations: the component along each motion subspace that is a unit vector is zero, by the choice of ẇ° in `trial`."""

    def __init__(self, tree: Tree, moving: Sequence[Rates]) -> None:
        super().__init__(tree, moving)
        self.trial = [ZERO] * dof_count(tree)

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        return self.driven(self.tree[i].outer.dofs, v)  # elastic coordinates keep a zero trial rate

    def driven(self, dofs: Sequence[Dof], v: Accelerations) -> Accelerations:
        for dof in dofs:
            if dof.unit is not None:
                k, turns = dof.unit
                self.trial[dof.number] = neg((v.alpha if turns else v.a)[k])
                v = v._replace(alpha=put(v.alpha, k, ZERO)) if turns else v._replace(a=put(v.a, k, ZERO))
        return v


def are_slender(bodies: Sequence[Rigid]) -> bool:
    """Whether more than half of the bodies with mass have diagonal J and h = 0 about their origins, as rotors have."""
    carried = [body for body in bodies if not body.is_nothing]
    slender = [b for b in carried if all(x is ZERO for x in (*b.h, b.j[0][1], b.j[0][2], b.j[1][2]))]
    return 2 * len(slender) > len(carried)


class _Factored(NamedTuple):
    """L D Lᵀ of M, the trial accelerations ẇ° by number, and L⁻¹ f of the residual forces f = −b(ẇ°)."""

    factors: LDL
    trial: Sequence[Expr]
    eliminated: Sequence[Expr]

    def values(self, eliminated: Sequence[Expr]) -> list[Expr]:
        """ẇ = ẇ° + L⁻ᵀ D⁻¹ e by number, for the right-hand side e after forward elimination."""
        return list(map(add, self.trial, self.factors.finish(eliminated)))


@dataclass(frozen=True, eq=False)
class Composite:
    """The composite-rigid-body algorithm on `tree`, whose ground has the acceleration `ground`; transmitted wrenches are not computed.

    Bias forces are computed body by body at trial accelerations if `body_by_body`, or if it is None and the bodies `are_slender`.
    Added forces τ reuse the factors: e = L⁻¹ τ, and ẇ = L⁻ᵀ D⁻¹ (L⁻¹ f + Σ e λ). SingularError if a pivot is identically zero.
    """

    tree: Tree
    ground: Triple
    asked: Collection[int] = ()
    body_by_body: bool | None = None

    @cached_property
    def moving(self) -> list[Rates]:
        """The angular velocities and bias accelerations of the segments."""
        return rates(self.tree)

    @cached_property
    def factored(self) -> _Factored:
        """The factored M, and the right-hand side."""
        tree, bodies = self.tree, [s.body for s in self.tree]
        elastic = elastic_parts(tree, self.moving)
        rigid = {i: to_rigid(inertia) for i, inertia in elastic.items()}
        by_body = are_slender(bodies) if self.body_by_body is None else self.body_by_body
        drive = _Trial(tree, self.moving) if by_body else Driven(tree, self.moving)
        at = outward(tree, drive, Accelerations(NOTHING, self.ground))
        wrenches: list[SpatialForce | None] = []
        on = [ZERO] * dof_count(tree)
        for i, (s, moving) in enumerate(zip(tree, self.moving, strict=True)):
            w = s.net_wrench(moving.w, moving.square, at[i]) if by_body else opposite(s.load)
            if i in elastic:
                inertia = elastic[i].at(*at[i])
                w = w.plus(inertia.p)
                for b, column in inertia.columns.items():
                    k = mode_numbers(tree)[b]
                    on[k] = add(on[k], column.force)
            wrenches.append(w)
        if isinstance(drive, _Trial):
            left, trial = forces(tree, wrenches, len(on)), drive.trial
            mass = mass_rows(tree, Composites(tree, with_more(bodies, rigid)), elastic)
        else:
            spread = [moments(body) for body in bodies]
            whole, trial = Composites(tree, spread), [ZERO] * len(on)
            bias = _Bias(tree, self.moving, whole, drive, wrenches)
            inward(tree, bias)
            left = bias.found
            if elastic:
                whole = Composites(tree, with_more(spread, {i: moments(body) for i, body in rigid.items()}))
            mass = mass_rows(tree, whole, elastic)
        add_reflected(tree, on, trial)
        right = [neg(add(x, y)) for x, y in zip(left, on, strict=True)]
        factors = ldl(mass, sparse_order(mass))
        return _Factored(factors, trial, factors.forward(right))

    @cached_property
    def free(self) -> Passed:
        """The accelerations under the loads of the segments alone."""
        return self.passed((), ())

    @cached_property
    def motion(self) -> list[Accelerations]:
        """α and a of each segment under the loads of the segments alone, in its working basis."""
        values = [x for _, x in self.free.rows]
        return outward(self.tree, Driven(self.tree, self.moving, values), Accelerations(NOTHING, self.ground))

    @property
    def divisors(self) -> Sequence[Expr]:
        """The pivots D, in the order of elimination."""
        return self.factored.factors.pivots

    def propagate(self, on: Mapping[int, Expr], loads: Wrenches) -> PropagatedForce:
        """L⁻¹ τ for wrenches on segments, in their working bases, and generalized forces by number."""
        found, wrenches = self.factored, [loads.get(i) for i in range(len(self.tree))]
        tau = [add(on.get(k, ZERO), x) for k, x in enumerate(forces(self.tree, wrenches, len(found.trial)))]
        return PropagatedForce(found.factors.forward(tau), {})

    def passed(self, added: Sequence[PropagatedForce], amounts: Sequence[Expr]) -> Passed:
        """The accelerations with added forces, each the product of an amount and a force whose effect `propagate` returned."""
        found, whole = self.factored, list(self.factored.eliminated)
        for each, x in zip(added, amounts, strict=True):
            whole = [add(y, mul(share, x)) for y, share in zip(whole, each.shares, strict=True)]
        return Passed(list(zip(rows_of(self.tree), found.values(whole), strict=True)), list(self.divisors), {})
