# SPDX-License-Identifier: BSD-3-Clause
"""Inverse dynamics of trees by the recursive Newton–Euler algorithm (Featherstone 2008, ch. 5): M u̇ − f, f, M and kinetic energy.

The force g of each joint speed w is the component, along its motion subspace, of the wrench transmitted to its segment. Then
(M u̇ − f)_r = Σ_w g_w ∂w/∂u_r, in O(n) operations, and M_rs = Σ ∂w/∂u_r M_ww′ ∂w′/∂u_s, in as many as M has nonzero entries.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.carried import falling
from kane.dynamics.formulation.classical import holds_reactions
from kane.dynamics.formulation.recursive import WAYS, carrying
from kane.expr.build import add, mul, neg, sum_of
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, TWO, ZERO, Expr, Exprs
from kane.expr.symbols import rate
from kane.kinematics.freedoms import Unsuited, changed
from kane.kinematics.segments import joint_tree
from kane.kinematics.speeds import Row
from kane.kinematics.velocity_constraints import constraint_rows
from kane.model.bodies import deforming
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.tree import composite
from kane.tree.sweeps import Driven, Tree, forces, outward, rates, velocities
from kane.tree.values import Accelerations, to_rigid


@dataclass(frozen=True, eq=False)
class TreeInverse:
    """A tree at given u̇: its segments, the acceleration of the ground, and the rows and rates λ of joint speeds, by number."""

    tree: Tree
    ground: Triple
    rows: Sequence[Row]
    lambdas: Sequence[Expr]

    def left(self, derived: Derived) -> Exprs:
        """M u̇ − f of the generalized speeds."""
        return self.by_speeds(derived).T @ self.forces()

    def by_speeds(self, derived: Derived) -> Matrix:
        """∂w/∂u (joint speeds × generalized speeds)."""
        found = [_by_speeds(row, derived) for row in self.rows]
        return Matrix([[row.get(u, ZERO) for u in derived.speeds] for row in found], (len(found), len(derived.speeds)))

    def forces(self) -> list[Expr]:
        """The force g of each joint speed, by number."""
        moving, numbers = rates(self.tree), composite.mode_numbers(self.tree)
        at = outward(self.tree, Driven(self.tree, moving, self.lambdas), Accelerations(NOTHING, self.ground))
        wrenches = [s.net_wrench(w.w, w.square, a) for s, w, a in zip(self.tree, moving, at, strict=True)]
        on = [ZERO] * len(self.rows)
        for i, inertia in composite.elastic_parts(self.tree, moving).items():
            known = inertia.at(*at[i])
            values = {b: self.lambdas[k] for b, k in numbers.items()}
            wrenches[i] = wrenches[i].plus(inertia.wrench(at[i], values))
            for b, column in known.columns.items():
                own = sum_of(mul(x, values[other]) for other, x in column.row.items())
                on[numbers[b]] = add(on[numbers[b]], add(column.force, own))
        composite.add_reflected(self.tree, on, self.lambdas)
        return list(map(add, forces(self.tree, [None, *wrenches[1:]], len(on)), on))

    def mass(self) -> Matrix:
        """M of the joint speeds, by number."""
        elastic = composite.elastic_parts(self.tree, rates(self.tree))
        bodies = composite.with_more(
            [s.body for s in self.tree], {i: to_rigid(inertia) for i, inertia in elastic.items()}
        )
        return Matrix(composite.mass_rows(self.tree, composite.Composites(self.tree, bodies), elastic))

    def mass_of_speeds(self, derived: Derived) -> Matrix:
        """M."""
        mass = self.mass()
        if all(len(row) == 1 and next(iter(row.values())) is ONE for row in self.rows):
            number = {s: k for k, row in enumerate(self.rows) for s in row}
            if all(u in number for u in derived.speeds):
                order = [number[u] for u in derived.speeds]
                return mass.take(order, order)
        rows = self.by_speeds(derived)
        return rows.T @ mass @ rows


def _by_speeds(own: Row, derived: Derived) -> dict[Expr, Expr]:
    speeds, result = set(derived.speeds), dict[Expr, Expr]()
    for s, c in own.items():
        by = {s: ONE} if s in speeds else derived.kinematical.form({s: ONE}).coefficients
        for u, w in by.items():
            result[u] = add(result.get(u, ZERO), mul(c, w))
    return result


def inverse_at(
    derived: Derived, u_dot: Sequence[Expr], *, balanced: bool = False, elastic: bool = False
) -> TreeInverse:
    """The tree at given u̇, without constraints. Unsuited, with the reason, if the system is not a tree of joint speeds."""
    if holds_reactions(derived):
        raise Unsuited("loads that contain reactions")
    carried = carrying(derived, shared=elastic)
    tree = carried.tree(balanced=balanced).segments
    if composite.dof_count(tree) != len(derived.speeds):
        raise Unsuited("speeds other than those of the joints")
    value: dict[Expr, Expr] = dict(zip(derived.speeds, u_dot, strict=True))
    rows = composite.rows_of(tree)
    lambdas = [sum_of(mul(c, changed(s, value, derived.kinematics)) for s, c in row.items()) for row in rows]
    return TreeInverse(tree, falling(derived), rows, lambdas)


def inverse_of(derived: Derived, u_dot: Sequence[Expr], route: str) -> TreeInverse:
    """The tree at the u̇ of recursion `route`, without elastic parts. Unsuited if the system is not such a tree.

    λ of rows in rates are those of the recursion; with composite bodies the bias forces are computed body by body, as g is.
    """
    if derived.constraints.constraints:
        raise Unsuited("constraints")
    inverse = inverse_at(derived, u_dot, balanced=route == "recursive")
    if route != "composite" and all(u in derived.speeds for row in inverse.rows for u in row):
        return inverse
    solver = WAYS[route](inverse.tree, inverse.ground)
    if isinstance(solver, composite.Composite):
        solver = replace(solver, body_by_body=True)
    found = {id(row): x for row, x in solver.free.rows}
    return replace(inverse, lambdas=[found[id(row)] for row in inverse.rows])


def residual(derived: Derived) -> Exprs:
    """M u̇ − f in u̇. Unsuited, with the reason, if the system is not a tree of joint speeds."""
    return _inverse(derived, [rate(u) for u in derived.speeds]).left(derived)


def forcing(derived: Derived) -> Exprs:
    """f. Unsuited, with the reason, if the system is not a tree of joint speeds."""
    return tuple(map(neg, _inverse(derived, [ZERO] * len(derived.speeds)).left(derived)))


def mass_matrix(derived: Derived) -> Matrix:
    """M, which constraints do not change. Unsuited, with the reason, if the system is not a tree of joint speeds."""
    if derived.constraints.constraints:
        derived = replace(derived, constraints=constraint_rows((), derived.kinematics, derived.auxiliary_speeds))
    return _inverse(derived, [ZERO] * len(derived.speeds)).mass_of_speeds(derived)


def _inverse(derived: Derived, u_dot: Sequence[Expr]) -> TreeInverse:
    return inverse_at(derived, u_dot, elastic=bool(deforming(derived.system.bodies)))


def kinetic_energy_along_tree(derived: Derived) -> Expr:
    """The kinetic energy ½ Σ m v·v + ω·I·ω, from the velocities of the segments. Unsuited if the system is not a tree of joint speeds.

    A body with ω, velocity v of its origin, mass m, h = m r* and inertia J about the origin has ½ (m v·v + 2 v·(ω × h) + ω·J·ω), a
    reflected inertia a has ½ a w².
    """
    carried = carrying(derived)
    tree = joint_tree(carried.segments.steps, carried.bodies, along_b=True, reflected=carried.reflected).segments
    moving, speeds, twice = rates(tree), derived.kinematics.speeds, ZERO
    for s, at, v in zip(tree, moving, velocities(tree, moving), strict=True):
        twice = add(twice, add(mul(s.body.m, dot(v, v)), dot(at.w, product(s.body.j, at.w))))
        twice = add(twice, mul(TWO, dot(v, cross3(at.w, s.body.h))))
        for dof in s.dofs:
            if dof.reflected is not None:
                w = sum_of(
                    mul(c, form.total()) for c, form in zip(dof.row.values(), speeds.forms(dof.row), strict=True)
                )
                twice = add(twice, mul(dof.reflected.inertia, mul(w, w)))
    return twice / 2
