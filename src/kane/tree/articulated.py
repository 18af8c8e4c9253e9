# SPDX-License-Identifier: BSD-3-Clause
"""The articulated-body algorithm (Featherstone 2008, ch. 7): joint accelerations in O(n) operations for n joint speeds.

A subtree transmits to the segment that carries it n = J α + H a + …, f = Hᵀ α + M a + …. The inward sweep eliminates each joint speed
by its equation, in which the transmitted wrench has no component along the motion subspace s beside the joint force; the outward
sweep substitutes back. Accelerations are those of points, not spatial ones, so that only angular velocities are needed; gravity
is an acceleration of the ground. An elastic coordinate, which moves several segments, is a column of the inertias up to their
nearest common ancestor, and is eliminated there.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import NamedTuple

from kane.expr.build import add, div, mul, sub, sum_of
from kane.expr.node import ONE, ZERO, Expr
from kane.space.rotation import NOTHING, Triple
from kane.tree.sweeps import Carry, Drive, Rates, Tree, inward, outward, rates
from kane.tree.triples import put, times
from kane.tree.values import (
    NO_INERTIA,
    NO_WRENCH,
    Accelerations,
    Dof,
    Elimination,
    Row,
    SpatialForce,
    SpatialInertia,
    of_rigid,
    opposite,
)

Wrenches = Mapping[int, SpatialForce]


class Passed(NamedTuple):
    """The result of forward dynamics: (row, ẇ) of each joint speed, pivots D, and wrenches transmitted to the segments asked for.

    The wrenches are about the origins of the segments, along A.
    """

    rows: list[tuple[Row, Expr]]
    pivots: list[Expr]
    transmitted: Wrenches


class PropagatedForce(NamedTuple):
    """The effect of a force on the elimination: right-hand sides e, in the order of the divisors; propagated wrenches, along A."""

    shares: Sequence[Expr]
    wrenches: Wrenches


class _Inward(Carry[SpatialInertia]):
    """The inward sweep: articulated inertias before the outer joint, along A, and the eliminations of each segment, in their order."""

    def __init__(self, tree: Tree, moving: Sequence[Rates]) -> None:
        super().__init__(tree)
        self.moving = moving
        self.ground = bool(tree[0].modes)
        self.inertias: dict[int, SpatialInertia] = {}
        self.outer_pivots: dict[int, list[Elimination]] = {}
        self.inner_pivots: dict[int, list[Elimination]] = {}
        self.modes: dict[int, list[Elimination]] = {}

    def local(self, i: int) -> None:
        """None: `whole` adds the inertia of the segment to the sum of its descendants."""

    def whole(self, i: int, v: SpatialInertia | None) -> SpatialInertia | None:
        """The sum with the inertia of segment i, after elimination of the elastic coordinates `modes` of the segment."""
        s, at = self.tree[i], self.moving[i]
        parts = [] if v is None else [v]
        if s.elastic is not None:
            parts.append(s.elastic(at.w, at.square))
        if not (s.body.is_nothing and s.load is NO_WRENCH):
            parts.append(of_rigid(s.body, opposite(s.load).plus(s.body.bias(at.w, at.square))))
        v = reduce(SpatialInertia.plus, parts) if parts else None
        for b in reversed(s.modes):
            v, pivot = (NO_INERTIA if v is None else v).without_mode(b)
            self.modes.setdefault(i, []).append(pivot)
        return v

    def inner(self, i: int, v: SpatialInertia) -> SpatialInertia:
        v = _without(v, self.tree[i].inner.dofs, self.inner_pivots.setdefault(i, []))
        return v.at(self.moving[i].spin, self.moving[i].sliding)

    def outer(self, i: int, v: SpatialInertia) -> SpatialInertia:
        v = self.inertias[i] = _without(v, self.tree[i].outer.dofs, self.outer_pivots.setdefault(i, []))
        return v

    def arm(self, i: int, v: SpatialInertia) -> SpatialInertia:
        v = v.at(NOTHING, self.moving[i].shift)
        for dof in self.tree[i].shared:
            (b,) = dof.row
            v = v.sharing(dof, b)
        return v.moved(self.tree[i].arm)


def _without(v: SpatialInertia, dofs: Sequence[Dof], pivots: list[Elimination]) -> SpatialInertia:
    for dof in reversed(dofs):
        v, pivot = v.without(dof)
        pivots.append(pivot)
    return v


class _Outward(Drive[Accelerations]):
    """The outward sweep: accelerations by back substitution, with right-hand sides `more` added to those of the pivots, by number."""

    def __init__(self, found: "Articulated", more: Sequence[Expr]) -> None:
        super().__init__(found.tree)
        self.found, self.more = found, more
        self.rows: list[tuple[Row, Expr]] = []
        self.values: dict[Expr, Expr] = {}
        self.origins: dict[int, Accelerations] = {}
        self.known(0, Accelerations(NOTHING, found.ground))

    def arm(self, i: int, v: Accelerations) -> Accelerations:
        v = v.moved(self.tree[i].arm, self.found.moving[i].shift)
        for dof in self.tree[i].shared:
            (b,) = dof.row
            v = v.plus(times(self.values[b], dof.spin), times(self.values[b], dof.slide))
        self.origins[i] = v
        return v

    def outer(self, i: int, v: Accelerations) -> Accelerations:
        return self.taken(self.found.inward.outer_pivots.get(i, ()), v)

    def inner(self, i: int, v: Accelerations) -> Accelerations:
        v = v.plus(self.found.moving[i].spin, self.found.moving[i].sliding)
        v = self.taken(self.found.inward.inner_pivots.get(i, ()), v)
        self.known(i, v)
        return v

    def taken(self, pivots: Sequence[Elimination], v: Accelerations) -> Accelerations:
        """The acceleration beyond some joint speeds; records their ẇ."""
        for pivot in reversed(pivots):
            assert isinstance(pivot.of, Dof)
            x, v = self.loaded(pivot).after(v, self.values)
            self.rows.append((pivot.of.row, x))
        return v

    def known(self, i: int, v: Accelerations) -> None:
        """Records the rates λ of the elastic coordinates eliminated at segment i."""
        for pivot in reversed(self.found.inward.modes.get(i, ())):
            assert isinstance(pivot.of, Expr)
            self.values[pivot.of] = self.loaded(pivot).value(v, self.values)

    def loaded(self, pivot: Elimination) -> Elimination:
        """The elimination with its right-hand side increased by `more`."""
        if not self.more:
            return pivot
        return pivot._replace(rest=add(pivot.rest, div(self.more[self.found.number(pivot)], pivot.d)))


class _PropagatedForces(Carry[SpatialForce]):
    """The inward sweep of the ABA for added wrenches on segments and added generalized forces τ, without inertia forces.

    At a joint speed the right-hand side is e = τ − s·p and the wrench passed on p + U e/D; for an elastic coordinate e = τ − Q, and
    the Q of another one k becomes Q + (n_k·s) e/D. Then eᵀ D⁻¹ e′ = τᵀ M⁻¹ τ′ for two forces, as with M = L D Lᵀ.
    """

    def __init__(self, found: "Articulated", forces: Mapping[int, Expr], loads: Wrenches) -> None:
        super().__init__(found.tree)
        self.found, self.forces, self.loads = found, forces, loads
        self.ground = found.inward.ground
        self.q: dict[Expr, Expr] = {}
        self.shares = [ZERO] * len(found.divisors)
        self.wrenches: dict[int, SpatialForce] = {}

    def local(self, i: int) -> SpatialForce | None:
        if i in self.loads:
            return opposite(self.loads[i])
        return NO_WRENCH if any(dof.number in self.forces for dof in self.tree[i].dofs) else None

    def whole(self, i: int, v: SpatialForce | None) -> SpatialForce | None:
        for pivot in self.found.inward.modes.get(i, ()):
            assert isinstance(pivot.of, Expr)
            e = sub(self.forces.get(self.found.number(pivot), ZERO), self.q.get(pivot.of, ZERO))
            if e is not ZERO:
                v = (NO_WRENCH if v is None else v).plus(self.shared(pivot, e))
        return v

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        return self.taking(self.found.inward.inner_pivots.get(i, ()), v)

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        self.wrenches[i] = self.taking(self.found.inward.outer_pivots.get(i, ()), v)
        return self.wrenches[i]

    def arm(self, i: int, v: SpatialForce) -> SpatialForce:
        for dof in self.tree[i].shared:
            (b,) = dof.row
            self.add(b, v.on(dof))
        return v.moved(self.tree[i].arm)

    def taking(self, pivots: Sequence[Elimination], v: SpatialForce) -> SpatialForce:
        """The wrench before some joint speeds, with the forces on these."""
        for pivot in pivots:
            assert isinstance(pivot.of, Dof)
            force = self.forces.get(pivot.of.number, ZERO)
            v = v.plus(self.shared(pivot, sub(force, v.on(pivot.of))))
            if pivot.of.free is not None:  # the component along the axis equals the joint force
                k, turns = pivot.of.free
                v = v._replace(n=put(v.n, k, force)) if turns else v._replace(f=put(v.f, k, force))
        return v

    def shared(self, pivot: Elimination, e: Expr) -> SpatialForce:
        """Records the right-hand side e of a pivot; the wrench U e/D that it adds."""
        self.shares[self.found.number(pivot)] = e
        for b, x in pivot.beside.items():
            self.add(b, mul(x, e))
        return pivot.t.times(e)

    def add(self, b: Expr, x: Expr) -> None:
        """Adds x to Q of the elastic coordinate with rate b."""
        if x is not ZERO:
            self.q[b] = add(self.q.get(b, ZERO), x)


@dataclass(frozen=True, eq=False)
class Articulated:
    """The articulated-body algorithm on `tree`, whose ground has the acceleration `ground`; results are made when first read.

    `asked` are the segments whose transmitted wrenches are returned. SingularError if a pivot is identically zero.
    """

    tree: Tree
    ground: Triple
    asked: Collection[int] = ()

    @cached_property
    def moving(self) -> list[Rates]:
        """The angular velocities and bias accelerations of the segments."""
        return rates(self.tree)

    @cached_property
    def inward(self) -> _Inward:
        """The completed inward sweep."""
        result = _Inward(self.tree, self.moving)
        inward(self.tree, result)
        return result

    @cached_property
    def _free(self) -> tuple[Passed, list[Accelerations]]:
        return self._outward((), ())

    @property
    def free(self) -> Passed:
        """The accelerations under the loads of the segments alone."""
        return self._free[0]

    @property
    def motion(self) -> list[Accelerations]:
        """α and a of each segment under the loads of the segments alone, in its working basis."""
        return self._free[1]

    @cached_property
    def pivots(self) -> list[Elimination]:
        """The eliminations of joint speeds, from the ground to the tips, then those of elastic coordinates."""
        found, n = self.inward, range(len(self.tree))
        own = [p for i in n for of in (found.outer_pivots, found.inner_pivots) for p in reversed(of.get(i, ()))]
        return own + [p for i in n for p in reversed(found.modes.get(i, ()))]

    @cached_property
    def divisors(self) -> list[Expr]:
        """The pivot D of each elimination."""
        return [p.d for p in self.pivots]

    @cached_property
    def _numbers(self) -> dict[Expr, int]:
        return {p.of: k for k, p in enumerate(self.pivots) if isinstance(p.of, Expr)}

    def number(self, pivot: Elimination) -> int:
        """The number of the joint speed or elastic coordinate that is eliminated."""
        return pivot.of.number if isinstance(pivot.of, Dof) else self._numbers[pivot.of]

    def propagate(self, forces: Mapping[int, Expr], loads: Wrenches) -> PropagatedForce:
        """The effect of wrenches on segments, in their working bases, and of generalized forces by number."""
        found = _PropagatedForces(self, forces, loads)
        inward(self.tree, found)
        return PropagatedForce(found.shares, found.wrenches)

    def passed(self, forces: Sequence[PropagatedForce], amounts: Sequence[Expr]) -> Passed:
        """The accelerations with added forces, each the product of an amount and a force whose effect `propagate` returned."""
        return self._outward(forces, amounts)[0]

    def _outward(
        self, forces: Sequence[PropagatedForce], amounts: Sequence[Expr]
    ) -> tuple[Passed, list[Accelerations]]:
        each = range(len(self.divisors)) if forces else ()
        more = [sum_of(mul(f.shares[k], x) for f, x in zip(forces, amounts, strict=True)) for k in each]
        drive = _Outward(self, more)
        moving = outward(self.tree, drive, Accelerations(NOTHING, self.ground))
        transmitted = {}
        for i in self.asked:
            inertia = self.inward.inertias.get(i, NO_INERTIA)
            for f, x in zip(forces, amounts, strict=True):
                inertia = inertia._replace(p=inertia.p.plus(f.wrenches[i].times(x))) if i in f.wrenches else inertia
            transmitted[i] = inertia.wrench(drive.origins[i], drive.values)
        rows = [*drive.rows, *(({b: ONE}, x) for b, x in drive.values.items())]
        return Passed(rows, self.divisors, transmitted), moving
