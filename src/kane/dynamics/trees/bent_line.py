# SPDX-License-Identifier: BSD-3-Clause
"""Segments of a tree with flexible bodies at given u̇: what is left of its equations, and M.

With λ of the joint speeds and of the rates that move several segments, a segment whose parts move by these presses with

    n + Σ n_k λ_k,   f + Σ f_k λ_k,   and on each of them with   Q_k = n_k·α + f_k·a + Σ m_kl λ_l + e_k

beside what segments press with that move by them, s_k·(n, f), on the way to the ground.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kane.dynamics.derivation import Derived
from kane.dynamics.routes.articulated import Wrenches
from kane.dynamics.routes.carried import falling, regrouped
from kane.dynamics.routes.composite import bending_along, freedom_mass, with_more
from kane.dynamics.routes.equations import holds_reactions
from kane.dynamics.routes.moving import moving
from kane.dynamics.routes.places import Way, Wrench, composites, way_along, working
from kane.dynamics.routes.recursive import carrying
from kane.dynamics.routes.trial import wrenches
from kane.dynamics.trees.line import change_of
from kane.expr.build import add, mul
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.speeds import Row
from kane.kinematics.travel import travel
from kane.space.rotation import Triple
from kane.space.spatial import Inertia, Rigid, summed, times, to_rigid


@dataclass(frozen=True, eq=False)
class BentLine:
    """The segments, what they carry and feel of flexible parts along the basis of work, and λ by number with the rows they are of."""

    way: Way
    bodies: Sequence[Rigid]
    bending: Mapping[int, Inertia]
    loads: Wrenches
    ground: Triple
    rows: Sequence[Row]
    lambdas: Sequence[Expr]

    def left(self, derived: Derived) -> tuple[Expr, ...]:
        """M u̇ − f."""
        return by_speeds(self.rows, derived).T @ self.forces()

    def mass(self, derived: Derived) -> Matrix:
        """M."""
        felt = {i: to_rigid(own) for i, own in self.bending.items()}
        whole = composites(self.way, with_more(self.bodies, felt))
        rows = by_speeds(self.rows, derived)
        return rows.T @ Matrix(freedom_mass(self.way, whole, len(self.rows), self.bending)) @ rows

    def forces(self) -> list[Expr]:
        """What the equation of each freedom leaves, by number."""
        way, g = self.way, [ZERO] * len(self.rows)
        motion = moving(way, self.ground, self.lambdas).work
        pressing = list(wrenches(way, self.bodies, self.loads, motion))
        for i, felt in self.bending.items():
            pressing[i] = pressing[i].plus(self._bent(felt, motion[i], g))
        for i in reversed(range(1, len(way.on.steps))):
            w = pressing[i]
            for place in way.inner[i]:
                g[place.number] = add(g[place.number], w.along(place.freedom, place.turning))
            w = way.entered(i, w)
            for place, x in way.along_a(i, w):
                g[place.number] = add(g[place.number], x)
            parent = way.on.steps[i].parent
            if parent:
                pressing[parent] = pressing[parent].plus(way.left(i, w))
        return g

    def _bent(self, felt: Inertia, at: tuple[Triple, Triple], g: list[Expr]) -> Wrench:
        """What the flexible parts of a segment press with, and on the rates that they move by."""
        known, number = felt.at(*at), self.way.modes
        n, f = known.n, known.f
        for b, column in known.columns.items():
            value = self.lambdas[number[b]]
            n, f = summed(n, times(value, column.n)), summed(f, times(value, column.f))
            total = column.force
            for other, x in column.row.items():
                total = add(total, mul(x, self.lambdas[number[other]]))
            g[number[b]] = add(g[number[b]], total)
        return Wrench(n, f)


def bent_line(derived: Derived, u_dot: Sequence[Expr]) -> BentLine:
    """The segments at given u̇, as if nothing closed the tree; Unsuited, with what is in the way, where it is none."""
    if holds_reactions(derived):
        raise Unsuited("loads that hold reactions")
    carried = carrying(derived, flexible=True, shared=True)
    steps = carried.segments.steps
    on = travel(steps)
    way = way_along(on)
    bodies = [working(on, i, body) for i, body in enumerate(regrouped(carried.bodies, steps, balanced=False))]
    rows: list[Row] = [*(p.freedom.row for p in way.places), *({b: ONE} for b in way.modes)]
    if len(rows) != len(derived.speeds):
        raise Unsuited("speeds that are not those of the joints")
    value: dict[Expr, Expr] = dict(zip(derived.speeds, u_dot, strict=True))
    lambdas = [change_of(row, value, derived) for row in rows]
    return BentLine(way, bodies, bending_along(on, carried.bent), carried.loads, falling(derived), rows, lambdas)


def by_speeds(rows: Sequence[Row], derived: Derived) -> Matrix:
    """∂w/∂u of joint speeds, by their rows in speeds and rates."""
    found = [_by_speeds(row, derived) for row in rows]
    return Matrix([[row.get(u, ZERO) for u in derived.speeds] for row in found], (len(rows), len(derived.speeds)))


def _by_speeds(own: Row, derived: Derived) -> dict[Expr, Expr]:
    speeds, found = set(derived.speeds), dict[Expr, Expr]()
    for s, c in own.items():
        by = {s: ONE} if s in speeds else derived.kinematical.form({s: ONE}).coefficients
        for u, w in by.items():
            found[u] = add(found.get(u, ZERO), mul(c, w))
    return found
