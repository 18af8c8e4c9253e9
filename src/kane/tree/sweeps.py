# SPDX-License-Identifier: BSD-3-Clause
"""A kinematic tree of segments, and the two recursions along it (Featherstone 2008, ch. 5), which do all changes of basis and origin.

`outward` carries values from the ground to the tips, `inward` from the tips to the ground. An algorithm is a subclass of `Drive`
(outward) or `Carry` (inward), whose methods state what happens to a value at bodies, joints and offsets (arms).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

from kane.expr.build import add
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3
from kane.tree.triples import along, centripetal, is_zero, summed, times, turned_down
from kane.tree.values import (
    NO_MASS,
    NO_WRENCH,
    Accelerations,
    Change,
    Dof,
    Rigid,
    SpatialForce,
    SpatialInertia,
    opposite,
)


class Stage(NamedTuple):
    """The joint motion along one basis: joint speeds, their sums ω = `spin` and ṙ = `slide`, and the λ-free parts of their rates."""

    dofs: tuple[Dof, ...] = ()
    spin: Triple = NOTHING
    slide: Triple = NOTHING
    spin_drift: Triple = NOTHING
    slide_drift: Triple = NOTHING


STILL = Stage()


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A rigid or flexible body, or a massless link, moved by a joint relative to its parent segment.

    The constant rotations `lead` take the working basis of the parent to a basis A, along which are the position `arm` of the origin
    and the `outer` joint motion. The rotation `turn` takes A to B, the working basis, along which are the `inner` joint motion, `body`
    and `load`; without a turn the working basis is A. `shared` are the motion subspaces, along A, of elastic coordinates, which move
    other segments too; `modes` are the rates of those for which this is the nearest segment that carries everything they move.
    `elastic` maps ω and ω·ω to the spatial inertia of flexible parts. `absolute`, if not None, is one speed that equals the rate of
    rotation relative to the segment at which a chain of rotations about parallel axes begins.
    """

    parent: int
    lead: tuple[Change, ...] = ()
    arm: Triple = NOTHING
    outer: Stage = STILL
    turn: Change | None = None
    inner: Stage = STILL
    body: Rigid = NO_MASS
    load: SpatialForce = NO_WRENCH
    shared: tuple[Dof, ...] = ()
    modes: tuple[Expr, ...] = ()
    elastic: Callable[[Triple, Expr], SpatialInertia] | None = None
    absolute: Expr | None = None

    @property
    def axis(self) -> int | None:
        """The basis axis of all rotations of the joint, the same along A and B; None if they have no common one."""
        drift, spin = self.inner.spin_drift, self.inner.spin
        k = [i for i in range(3) if spin[i] is not ZERO or drift[i] is not ZERO]
        if self.turn is None:
            return k[0] if len(k) == 1 else None
        own = self.turn.axis
        return own if own is not None and all(i == own for i in k) else None

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """The joint speeds, those along A first."""
        return (*self.outer.dofs, *self.inner.dofs)

    def net_wrench(self, w: Triple, square: Expr, at: Accelerations) -> SpatialForce:
        """The inertia wrench of the body about its origin, with its bias, less the applied load."""
        return self.body.bias(w, square).plus(self.body.at(*at)).plus(opposite(self.load))


Tree = Sequence[Segment]
V = TypeVar("V", bound="Inward")
W = TypeVar("W", bound="Outward")


class Inward(Protocol):
    """A value that an inward sweep carries to the ground."""

    def turned(self: V, turn: Change, /) -> V:
        """Along the basis before a turn."""

    def moved(self: V, r: Triple, /) -> V:
        """About the point from which the origin lies at r."""

    def plus(self: V, other: V, /) -> V:
        """Both together."""


class Outward(Protocol):
    """A value that an outward sweep carries to the tips."""

    def turned(self: W, turn: Change, /) -> W:
        """Along the basis after a turn."""


class Carry(Generic[V]):
    """The steps of an inward sweep at bodies, joints and arms. By default values are added and referred to the parent's origin."""

    ground = False
    """Whether the sweep includes segment 0, the ground."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree

    def local(self, i: int) -> V | None:
        """The value of segment i alone, in its working basis; None if it has none."""
        raise NotImplementedError

    def whole(self, i: int, v: V | None) -> V | None:
        """The value of segment i with all its descendants, from the sum v."""
        return v

    def inner(self, i: int, v: V) -> V:
        """The value before the inner joint motion."""
        return v

    def outer(self, i: int, v: V) -> V:
        """The value before the outer joint motion."""
        return v

    def arm(self, i: int, v: V) -> V:
        """The value about the parent's origin."""
        return v.moved(self.tree[i].arm)


def inward(tree: Tree, carry: Carry[V]) -> V | None:
    """Runs the sweep from the tips to the ground; the value of segment 0 if `carry.ground`, else None or its local value."""
    hung = [carry.local(i) for i in range(len(tree))]
    for i in reversed(range(0 if carry.ground else 1, len(tree))):
        segment, v = tree[i], carry.whole(i, hung[i])
        if i == 0 or v is None:
            hung[i] = v
            continue
        v = carry.inner(i, v)
        if segment.turn is not None:
            v = v.turned(segment.turn)
        v = carry.outer(i, v)
        if segment.parent or carry.ground:
            v = carry.arm(i, v)
            for turn in reversed(segment.lead):
                v = v.turned(turn)
            before = hung[segment.parent]
            hung[segment.parent] = v if before is None else before.plus(v)
    return hung[0]


class Drive(Generic[W]):
    """The steps of an outward sweep at arms and joints. By default values only change their basis."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree

    def arm(self, i: int, v: W) -> W:
        """The value at the origin of segment i, along A."""
        return v

    def outer(self, i: int, v: W) -> W:
        """The value after the outer joint motion, along A."""
        return v

    def inner(self, i: int, v: W) -> W:
        """The value after the inner joint motion, in the working basis."""
        return v


def outward(tree: Tree, drive: Drive[W], ground: W) -> list[W]:
    """The value of each segment, in its working basis, from the value `ground` of segment 0."""
    result = [ground]
    for i, segment in enumerate(tree):
        if i:
            v = result[segment.parent]
            for turn in segment.lead:
                v = v.turned(turn)
            v = drive.outer(i, drive.arm(i, v))
            result.append(drive.inner(i, v if segment.turn is None else v.turned(segment.turn)))
    return result


class Rates(NamedTuple):
    """Angular velocities of a segment's parent, along A, and of the segment, in its working basis, with ω·ω; bias accelerations.

    `shift` is the bias acceleration of the origin, along A, and `coriolis` its part due to the outer slide; `sliding` and `spin` are
    the parts of a and α due to the inner joint: α = α_p + Σ s ẇ + ω × ω_rel + …,
    a = a_p + α_p × r + ω_p × (ω_p × r) + 2 ω_p × ṙ + Σ s ẇ + …, where p is the parent and w are joint speeds.
    """

    before: Triple = NOTHING
    before_square: Expr = ZERO
    w: Triple = NOTHING
    square: Expr = ZERO
    shift: Triple = NOTHING
    coriolis: Triple = NOTHING
    sliding: Triple = NOTHING
    spin: Triple = NOTHING


def rates(tree: Tree) -> list[Rates]:
    """The angular velocities and bias accelerations of all segments."""
    result, base = [Rates()], [NOTHING]
    for i, s in enumerate(tree):
        if i == 0:
            continue
        parent, before = result[s.parent], turned_down(s.lead, result[s.parent].w)
        coaxial = not s.lead and s.turn is None and tree[s.parent].turn is None
        base.append(base[s.parent] if coaxial else before)
        entered = before if s.turn is None else s.turn.down(before)
        w, square = entered, parent.square
        if not is_zero(s.inner.spin):
            w = summed(entered, s.inner.spin)
            if s.absolute is not None and s.axis is not None:
                w = summed(base[i], along(s.axis, s.absolute))
            square = dot(w, w)
        doubled = times(TWO, cross3(before, s.outer.slide))
        shift = summed(summed(centripetal(before, s.arm, parent.square), doubled), s.outer.slide_drift)
        twice = summed(times(TWO, entered), s.inner.spin)
        sliding = summed(s.inner.slide_drift, cross3(twice, s.inner.slide))
        spin = summed(s.inner.spin_drift, cross3(entered, s.inner.spin))
        coriolis = summed(doubled, s.outer.slide_drift)
        result.append(Rates(before, parent.square, w, square, shift, coriolis, sliding, spin))
    return result


def velocities(tree: Tree, moving: Sequence[Rates]) -> list[Triple]:
    """The velocity of each segment's origin, in its working basis."""
    result: list[Triple] = [NOTHING]
    for i, s in enumerate(tree):
        if i == 0:
            continue
        v = turned_down(s.lead, result[s.parent])
        v = summed(summed(v, cross3(moving[i].before, s.arm)), s.outer.slide)
        result.append(summed(v if s.turn is None else s.turn.down(v), s.inner.slide))
    return result


class Driven(Drive[Accelerations]):
    """Accelerations of the segments at the rates `lambdas` of joint speeds and elastic coordinates, by number; bias ones without."""

    def __init__(self, tree: Tree, moving: Sequence[Rates], lambdas: Sequence[Expr] = ()) -> None:
        super().__init__(tree)
        self.moving, self.lambdas = moving, lambdas
        self.origins = [Accelerations()]
        """The parent's acceleration at each segment's origin, with `shift`, along A."""

    def arm(self, i: int, v: Accelerations) -> Accelerations:
        """The acceleration at the origin, with its bias."""
        v = v.moved(self.tree[i].arm, self.moving[i].shift)
        self.origins.append(v)
        return v

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        """The sum with the accelerations of the outer joint speeds and the elastic coordinates."""
        return self.driven((*self.tree[i].shared, *self.tree[i].outer.dofs), v)

    def inner(self, i: int, v: Accelerations) -> Accelerations:
        """The sum with the bias and the accelerations of the inner joint speeds."""
        return self.driven(self.tree[i].inner.dofs, v.plus(self.moving[i].spin, self.moving[i].sliding))

    def driven(self, dofs: Sequence[Dof], v: Accelerations) -> Accelerations:
        """The sum of v and λ times each motion subspace."""
        for dof in dofs if self.lambdas else ():
            x = self.lambdas[dof.number]
            v = v.plus(times(x, dof.spin), times(x, dof.slide))
        return v


class Forces(Carry[SpatialForce]):
    """Generalized forces, by number, of wrenches on segments: each wrench is propagated to the ground and projected on the joints."""

    def __init__(self, tree: Tree, wrenches: Sequence[SpatialForce | None], count: int) -> None:
        super().__init__(tree)
        self.wrenches, self.found = wrenches, [ZERO] * count

    def local(self, i: int) -> SpatialForce | None:
        """The wrench on segment i."""
        return self.wrenches[i]

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        """Adds the generalized forces of the inner joint speeds."""
        self.project(self.tree[i].inner.dofs, v)
        return v

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        """Adds the generalized forces of the outer joint speeds and the elastic coordinates."""
        self.project((*self.tree[i].outer.dofs, *self.tree[i].shared), v)
        return v

    def project(self, dofs: Sequence[Dof], w: SpatialForce) -> None:
        """Adds the projection of a wrench on motion subspaces."""
        for dof in dofs:
            self.found[dof.number] = add(self.found[dof.number], w.on(dof))


def forces(tree: Tree, wrenches: Sequence[SpatialForce | None], count: int) -> list[Expr]:
    """The `count` generalized forces of wrenches on segments, by number."""
    carry = Forces(tree, wrenches, count)
    inward(tree, carry)
    return carry.found
