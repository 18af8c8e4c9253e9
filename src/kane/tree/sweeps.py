# SPDX-License-Identifier: BSD-3-Clause
"""A tree of segments, and the two sweeps along it that own all changes of basis and origin.

An algorithm is a `Carry`, or a `Drive`: what it does to a value at bodies, joints and arms. `outward` carries values from the ground
to the tips, `inward` from the tips to the ground.
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
    """What a segment turns and slides by along one basis: joint speeds, the sums ω and ṙ, and what their rates are beside λ."""

    dofs: tuple[Dof, ...] = ()
    spin: Triple = NOTHING
    slide: Triple = NOTHING
    spin_drift: Triple = NOTHING
    slide_drift: Triple = NOTHING


STILL = Stage()


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """What moves as one, in the segment before.

    From the basis of work of the parent `lead` turns by constants to A, where the origin lies at `arm`; `outer` joint speeds are along
    A. `turn` leads to B, the basis of work, along which are the `inner` ones, `body` and `load`; where there is none the segment works
    along A. `shared` moves it along A by coordinates that move other segments, too; all that moves by the rates `modes` hangs on it.
    `elastic` is what is felt of flexible parts, at ω and ω·ω. Where `absolute` is not None it is the rate of turn in what the
    turns about parallel axes begin from, as one speed.
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
        """The basis axis that it turns about by all it turns by: the same along A and B."""
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

    def pressing(self, w: Triple, square: Expr, at: Accelerations) -> SpatialForce:
        """What the body presses on the origin with as it moves, less the load."""
        return self.body.bias(w, square).plus(self.body.at(*at)).plus(opposite(self.load))


Tree = Sequence[Segment]
V = TypeVar("V", bound="Inward")
W = TypeVar("W", bound="Outward")


class Inward(Protocol):
    """A value that is carried to the ground."""

    def turned(self: V, turn: Change, /) -> V:
        """Along the basis before a turn."""

    def moved(self: V, r: Triple, /) -> V:
        """About the point from which the origin lies at r."""

    def plus(self: V, other: V, /) -> V:
        """Both together."""


class Outward(Protocol):
    """A value that is carried to the tips."""

    def turned(self: W, turn: Change, /) -> W:
        """Along the basis after a turn."""


class Carry(Generic[V]):
    """What an inward sweep does to values at bodies, joints and arms; nothing but to add and to move, unless told otherwise."""

    ground = False
    """Whether values are carried to the ground."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree

    def local(self, i: int) -> V | None:
        """The value of a segment alone, along its basis of work."""
        raise NotImplementedError

    def whole(self, i: int, v: V | None) -> V | None:
        """That of a segment with all that hangs on it."""
        return v

    def inner(self, i: int, v: V) -> V:
        """The value before the joint along the basis of work."""
        return v

    def outer(self, i: int, v: V) -> V:
        """The value before the joint along A."""
        return v

    def arm(self, i: int, v: V) -> V:
        """The value at the parent's origin."""
        return v.moved(self.tree[i].arm)


def inward(tree: Tree, carry: Carry[V]) -> V | None:
    """The values of all segments from the tips to the ground, where that is asked for."""
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
    """What an outward sweep does to values at arms and joints."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree

    def arm(self, i: int, v: W) -> W:
        """The value at the origin of a segment, along A."""
        return v

    def outer(self, i: int, v: W) -> W:
        """The value after the joint along A."""
        return v

    def inner(self, i: int, v: W) -> W:
        """The value after the joint along the basis of work."""
        return v


def outward(tree: Tree, drive: Drive[W], ground: W) -> list[W]:
    """The values of all segments, along the basis of work, from that of the ground."""
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
    """ω of what a segment moves in, along A, and of the segment, along the basis of work, each with ω·ω; bias accelerations.

    `shift` is that of the origin along A, `coriolis` what of it a slide along A adds; `sliding` and `spin` are those that the inner
    joint adds to a and to α: α = α_p + Σ s ẇ + ω × ω_rel + …, a = a_p + α_p × r + ω_p × (ω_p × r) + 2 ω_p × ṙ + Σ s ẇ + …
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
    """Velocities of the segments' origins, along the basis of work."""
    result: list[Triple] = [NOTHING]
    for i, s in enumerate(tree):
        if i == 0:
            continue
        v = turned_down(s.lead, result[s.parent])
        v = summed(summed(v, cross3(moving[i].before, s.arm)), s.outer.slide)
        result.append(summed(v if s.turn is None else s.turn.down(v), s.inner.slide))
    return result


class Driven(Drive[Accelerations]):
    """Accelerations at λ of the joint speeds and shared coordinates by number; at none where λ is not given."""

    def __init__(self, tree: Tree, moving: Sequence[Rates], lambdas: Sequence[Expr] = ()) -> None:
        super().__init__(tree)
        self.moving, self.lambdas = moving, lambdas
        self.origins = [Accelerations()]
        """The accelerations of what a segment moves in, at its origin as that slides, along A."""

    def arm(self, i: int, v: Accelerations) -> Accelerations:
        """The accelerations at the origin."""
        v = v.moved(self.tree[i].arm, self.moving[i].shift)
        self.origins.append(v)
        return v

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        """With those of the joint along A."""
        return self.driven((*self.tree[i].shared, *self.tree[i].outer.dofs), v)

    def inner(self, i: int, v: Accelerations) -> Accelerations:
        """With those of the joint along the basis of work."""
        return self.driven(self.tree[i].inner.dofs, v.plus(self.moving[i].spin, self.moving[i].sliding))

    def driven(self, dofs: Sequence[Dof], v: Accelerations) -> Accelerations:
        """The accelerations with those of joint speeds."""
        for dof in dofs if self.lambdas else ():
            x = self.lambdas[dof.number]
            v = v.plus(times(x, dof.spin), times(x, dof.slide))
        return v


class Forces(Carry[SpatialForce]):
    """Generalized forces by number of wrenches on segments, which press on the origins on the way to the ground."""

    def __init__(self, tree: Tree, wrenches: Sequence[SpatialForce | None], count: int) -> None:
        super().__init__(tree)
        self.wrenches, self.found = wrenches, [ZERO] * count

    def local(self, i: int) -> SpatialForce | None:
        """The wrench on a segment."""
        return self.wrenches[i]

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        """What joint speeds along the basis of work feel."""
        self.felt(self.tree[i].inner.dofs, v)
        return v

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        """What joint speeds along A feel."""
        self.felt((*self.tree[i].outer.dofs, *self.tree[i].shared), v)
        return v

    def felt(self, dofs: Sequence[Dof], w: SpatialForce) -> None:
        """What a wrench does to joint speeds."""
        for dof in dofs:
            self.found[dof.number] = add(self.found[dof.number], w.on(dof))


def forces(tree: Tree, wrenches: Sequence[SpatialForce | None], count: int) -> list[Expr]:
    """Generalized forces by number."""
    carry = Forces(tree, wrenches, count)
    inward(tree, carry)
    return carry.found
