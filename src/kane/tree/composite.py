# SPDX-License-Identifier: BSD-3-Clause
"""Joint accelerations by composite bodies: M of the joint speeds, factored along the branches, and forces at no ẇ or at trial ones.

What hangs on a segment moves as one body at the acceleration of one joint speed: J s of the composite body is its wrench, and
M_rs = s·(I s_r) along the way to the ground (Featherstone 2008, ch. 6). M is eliminated from the tips, without fill. Shorter than
articulated inertias along short branches.

The bias forces are those of composite bodies, too. All that hangs on a segment moves, at no ẇ beyond it, as what carries the segment
would move there, with ω, α and a of its origin, and by what the joints below turn and slide besides. With the moments m, h and E of
the composite body the first presses with

    n = J α + (E ω) × ω + h × a,        f = m a + α × h + ω × (ω × h)

and each joint below that turns by ω_r, with its own composite body, with

    n = (E (2 ω + ω_r)) × ω_r,        f = (2 ω + ω_r) × (ω_r × h)

besides, and with h × a_r, m a_r of the Coriolis acceleration 2 ω × ṙ + … of what slides. Only the second goes from segment to segment
to the ground; a body's own ω × J ω is never formed.

M (ẇ − ẇ°) = −b(ẇ°) holds at any trial ẇ°. Body by body, at those accelerations that have no component along joint speeds with unit
vectors, the forces are shorter where J is diagonal and the mass centre on the joint's axis.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

from kane.expr.build import add, mul, neg, sub, sum_of
from kane.expr.matrix import LDL, dot, ldl, sparse_order
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.tree.articulated import Passed, Pressed, Wrenches
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
    """All that hangs on a segment as one body about its origin, along the basis of work and along A."""

    def __init__(self, tree: Tree, bodies: Sequence[Body]) -> None:
        super().__init__(tree)
        self.bodies: Sequence[Body] = bodies
        self.work: list[Body] = list(bodies)
        self.along_a: list[Body] = list(bodies)
        inward(tree, self)

    def local(self, i: int) -> Body:
        """The body of a segment."""
        return self.bodies[i]

    def inner(self, i: int, v: Body) -> Body:
        """All that hangs on a segment, along the basis of work."""
        self.work[i] = v
        return v

    def outer(self, i: int, v: Body) -> Body:
        """The same along A."""
        self.along_a[i] = v
        return v


class _Columns(tuple[tuple[int, SpatialForce], ...]):
    """Wrenches at the acceleration 1 of joint speeds, with the numbers of these."""

    __slots__ = ()

    def turned(self, turn: Change) -> "_Columns":
        """Along the basis before a turn."""
        return _Columns((k, w.turned(turn)) for k, w in self)

    def moved(self, r: Triple) -> "_Columns":
        """About the point from which the origin lies at r."""
        return _Columns((k, w.moved(r)) for k, w in self)

    def plus(self, other: "_Columns") -> "_Columns":
        """Both together."""
        return _Columns((*self, *other))


class _Mass(Carry[_Columns]):
    """M of the joint speeds."""

    def __init__(
        self, tree: Tree, composite: Composites[Rigid] | Composites[Moments], elastic: Mapping[int, SpatialInertia]
    ) -> None:
        super().__init__(tree)
        self.composite, self.elastic, self.modes = composite, elastic, mode_numbers(tree)
        count = dof_count(tree)
        self.rows = [[ZERO] * count for _ in range(count)]
        for felt in elastic.values():
            for b, column in felt.columns.items():
                for other, x in column.row.items():
                    r, k = self.modes[b], self.modes[other]
                    self.rows[r][k] = add(self.rows[r][k], x)
        inward(tree, self)

    def local(self, i: int) -> _Columns:
        """The wrenches of elastic parts."""
        columns = self.elastic[i].columns if i in self.elastic else {}
        return _Columns((self.modes[b], column.w) for b, column in columns.items())

    def inner(self, i: int, v: _Columns) -> _Columns:
        """With those of the joint along the basis of work."""
        return self.felt(self.tree[i].inner.dofs, self.composite.work[i], v)

    def outer(self, i: int, v: _Columns) -> _Columns:
        """With those of the joint along A."""
        return self.felt((*self.tree[i].outer.dofs, *self.tree[i].shared), self.composite.along_a[i], v)

    def felt(self, dofs: Sequence[Dof], body: Rigid | Moments, v: _Columns) -> _Columns:
        """With those of joint speeds."""
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
    """M of the joint speeds and of the rates that move several segments, by number."""
    return _Mass(tree, whole, elastic).rows


def mode_numbers(tree: Tree) -> dict[Expr, int]:
    """The numbers of the rates that move several segments: after those of the joint speeds."""
    count = sum(len(s.dofs) for s in tree)
    return {b: count + k for k, b in enumerate(b for s in tree for b in s.modes)}


def dof_count(tree: Tree) -> int:
    """How many joint speeds and rates that move several segments there are."""
    return sum(len(s.dofs) + len(s.modes) for s in tree)


def rows_of(tree: Tree) -> list[Row]:
    """Their rows in speeds or in rates, by number."""
    own = sorted((dof for s in tree for dof in s.dofs), key=lambda dof: dof.number)
    return [*(dof.row for dof in own), *({b: ONE} for b in mode_numbers(tree))]


def add_reflected(tree: Tree, on: list[Expr], lambdas: Sequence[Expr]) -> None:
    """Adds to generalized forces what is reflected to the joint speeds at these λ, both by number."""
    for dof in (dof for s in tree for dof in s.dofs):
        if dof.reflected is not None:
            whole = add(dof.reflected.force, mul(dof.reflected.inertia, lambdas[dof.number]))
            on[dof.number] = add(on[dof.number], whole)


def elastic_parts(tree: Tree, moving: Sequence[Rates]) -> dict[int, SpatialInertia]:
    """What is felt of flexible parts alone, by segment."""
    return {i: s.elastic(at.w, at.square) for i, (s, at) in enumerate(zip(tree, moving, strict=True)) if s.elastic}


def with_more(bodies: Sequence[Body], more: Mapping[int, Body]) -> list[Body]:
    """The bodies with what some of them carry besides."""
    return [body.plus(more[i]) if i in more else body for i, body in enumerate(bodies)]


class _Bias(Forces):
    """The generalized forces on joint speeds at no ẇ, of composite bodies without their elastic parts."""

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
        """The composite body of a segment at the motion of what carries it, along A or `turned` to the basis of work."""
        s, at, motion, square = self.tree[i], self.moving[i], self.at.origins[i], self.moving[i].before_square
        beyond = at.w, s.inner.spin, s.inner.spin_drift
        if turned and s.turn is not None:
            return _Joint(self.composite.work[i], s.turn.down(at.before), motion.turned(s.turn), square, *beyond)
        k = self.axis(i)
        about = ZERO if k is None else self.composite.work[i].about(k)
        return _Joint(self.composite.along_a[i], at.before, motion, square, *beyond, k, about)

    def axis(self, i: int) -> int | None:
        """The axis about which a segment turns, if that is all that it does along its basis of work."""
        return self.tree[i].axis if is_zero(self.tree[i].inner.slide) else None

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        if self.tree[i].turn is not None and self.axis(i) is not None:
            return v  # met along A, as the moment about the axis is the same there
        return self.joined(i, self.joint(i, turned=True), v)

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        s = self.tree[i]
        if s.turn is not None and self.axis(i) is not None:
            v = self.joined(i, self.joint(i, turned=False), v)
        carried = _Joint(
            self.composite.along_a[i], self.moving[i].before, self.at.origins[i], self.moving[i].before_square
        )
        for dof in (*s.outer.dofs, *s.shared):
            self.found[dof.number] = add(self.found[dof.number], carried.felt(dof, v))
        return v

    def arm(self, i: int, v: SpatialForce) -> SpatialForce:
        return v.plus(_sliding(self.composite.along_a[i], self.moving[i].coriolis)).moved(self.tree[i].arm)

    def joined(self, i: int, joint: "_Joint", v: SpatialForce) -> SpatialForce:
        """The wrench with what the inner joint adds, which its joint speeds feel."""
        v = v.plus(joint.turning()).plus(_sliding(joint.body, self.moving[i].sliding))
        for dof in self.tree[i].inner.dofs:
            self.found[dof.number] = joint.felt(dof, v)
        return v


@dataclass(frozen=True, eq=False)
class _Joint:
    """A composite body where a segment is carried: ω, and α and a, of what carries it, with ω·ω.

    `whole` is ω of the segment, `turned` and `drift` are ω and its derivative at no ẇ of the turn; `axis` is the axis that it turns
    about, about which its moment of inertia is `about`.
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

    def felt(self, dof: Dof, w: SpatialForce) -> Expr:
        """The generalized force of a joint speed, with the wrench `w` beside."""
        turns = sum_of(mul(s, add(w.n[k], self.moment(k))) for k, s in enumerate(dof.spin) if s is not ZERO)
        return turns if is_zero(dof.slide) else add(turns, dot(dof.slide, summed(w.f, self.force)))

    def moment(self, k: int) -> Expr:
        """That of the motion of what carries it, about a basis axis."""
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
        """That of the motion of what carries it."""
        h, (alpha, a) = self.body.h, self.at
        return summed(summed(times(self.body.m, a), cross3(alpha, h)), centripetal(self.w, h, self.square))

    def turning(self) -> SpatialForce:
        """What the turn of the joint adds."""
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
        """The same about a basis axis."""
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
    """What a body presses with at an acceleration of its origin."""
    return NO_WRENCH if is_zero(a) else SpatialForce(cross3(body.h, a), times(body.m, a))


class _Trial(Driven):
    """Accelerations without their components along joint speeds with unit vectors, which the trial takes off."""

    def __init__(self, tree: Tree, moving: Sequence[Rates]) -> None:
        super().__init__(tree, moving)
        self.trial = [ZERO] * dof_count(tree)

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        return self.driven(self.tree[i].outer.dofs, v)  # coordinates that several segments share are left as they are

    def driven(self, dofs: Sequence[Dof], v: Accelerations) -> Accelerations:
        for dof in dofs:
            if dof.unit is not None:
                k, turns = dof.unit
                self.trial[dof.number] = neg((v.alpha if turns else v.a)[k])
                v = v._replace(alpha=put(v.alpha, k, ZERO)) if turns else v._replace(a=put(v.a, k, ZERO))
        return v


def are_slender(bodies: Sequence[Rigid]) -> bool:
    """Whether most bodies that are carried have diagonal J and no m r*, as rods along their axes and rotors."""
    carried = [body for body in bodies if not body.is_nothing]
    slender = [b for b in carried if all(x is ZERO for x in (*b.h, b.j[0][1], b.j[0][2], b.j[1][2]))]
    return 2 * len(slender) > len(carried)


class _Factored(NamedTuple):
    """L D Lᵀ of M, trial accelerations by number, and the forces left there eliminated, L⁻¹ f."""

    factors: LDL
    trial: Sequence[Expr]
    eliminated: Sequence[Expr]

    def values(self, eliminated: Sequence[Expr]) -> list[Expr]:
        """ẇ by number."""
        return list(map(add, self.trial, self.factors.finish(eliminated)))


@dataclass(frozen=True, eq=False)
class Composite:
    """A tree by composite bodies, whose ground accelerates; what its joints transmit is not found on this way.

    Forces are found `body_by_body` at trial accelerations where the bodies are slender, or as one asks for it. As further forces press
    on the tree M is factored already: e = L⁻¹ τ, and ẇ = L⁻ᵀ D⁻¹ (L⁻¹ f + Σ e λ). A SingularError where a pivot is zero whatever the
    state.
    """

    tree: Tree
    ground: Triple
    asked: Collection[int] = ()
    body_by_body: bool | None = None

    @cached_property
    def moving(self) -> list[Rates]:
        """The angular velocities and bias accelerations."""
        return rates(self.tree)

    @cached_property
    def factored(self) -> _Factored:
        """M, eliminated, and the forces."""
        tree, bodies = self.tree, [s.body for s in self.tree]
        elastic = elastic_parts(tree, self.moving)
        rigid = {i: to_rigid(felt) for i, felt in elastic.items()}
        by_body = are_slender(bodies) if self.body_by_body is None else self.body_by_body
        drive = _Trial(tree, self.moving) if by_body else Driven(tree, self.moving)
        at = outward(tree, drive, Accelerations(NOTHING, self.ground))
        wrenches: list[SpatialForce | None] = []
        on = [ZERO] * dof_count(tree)
        for i, (s, moving) in enumerate(zip(tree, self.moving, strict=True)):
            w = s.pressing(moving.w, moving.square, at[i]) if by_body else opposite(s.load)
            if i in elastic:
                felt = elastic[i].at(*at[i])
                w = w.plus(felt.p)
                for b, column in felt.columns.items():
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
        """The accelerations without further forces."""
        return self.passed((), ())

    @cached_property
    def motion(self) -> list[Accelerations]:
        """α and a of each segment without further forces, along the basis of work."""
        values = [x for _, x in self.free.rows]
        return outward(self.tree, Driven(self.tree, self.moving, values), Accelerations(NOTHING, self.ground))

    @property
    def divisors(self) -> Sequence[Expr]:
        """D of each pivot, in the order of elimination."""
        return self.factored.factors.pivots

    def press(self, on: Mapping[int, Expr], loads: Wrenches) -> Pressed:
        """L⁻¹ τ of wrenches on segments, along the basis of work, and of generalized forces by number."""
        found, wrenches = self.factored, [loads.get(i) for i in range(len(self.tree))]
        tau = [add(on.get(k, ZERO), x) for k, x in enumerate(forces(self.tree, wrenches, len(found.trial)))]
        return Pressed(found.factors.forward(tau), {})

    def passed(self, pressed: Sequence[Pressed], amounts: Sequence[Expr]) -> Passed:
        """The accelerations with such forces besides, in these amounts."""
        found, whole = self.factored, list(self.factored.eliminated)
        for each, x in zip(pressed, amounts, strict=True):
            whole = [add(y, mul(share, x)) for y, share in zip(whole, each.shares, strict=True)]
        return Passed(list(zip(rows_of(self.tree), found.values(whole), strict=True)), list(self.divisors), {})
