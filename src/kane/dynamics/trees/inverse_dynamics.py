# SPDX-License-Identifier: BSD-3-Clause
"""M u̇ − f, f and M of trees, in a number of operations that grows as the tree, or as M has entries.

g of each joint speed w is what its equation leaves: the moment and force that are transmitted to its segment, along its axis. Kane's
equations of the generalized speeds are Σ_w g_w ∂w/∂u_r, and M_rs = Σ ∂w/∂u_r M_ww′ ∂w′/∂u_s.
"""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.assembly import sum_of
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.articulated import parts
from kane.dynamics.routes.composite import freedom_mass
from kane.dynamics.routes.places import Place, composites, working
from kane.dynamics.trees.bent_line import bent_line, by_speeds
from kane.dynamics.trees.line import Line, Vectors, line_at, motions, passed_on, pressing
from kane.expr.build import neg
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import rate
from kane.kinematics.constraints import constraint_rows
from kane.model.bodies import deforming
from kane.space.spatial import summed

Exprs = tuple[Expr, ...]


def residual(derived: Derived) -> Exprs:
    """M u̇ − f in u̇, of a tree of joint speeds; Unsuited, with what is in the way, of another system."""
    u_dot = [rate(u) for u in derived.speeds]
    if deforming(derived.system.bodies):
        return bent_line(derived, u_dot).left(derived)
    line = line_at(derived, u_dot)
    return joint_rows(line, derived).T @ joint_forces(line)


def forcing(derived: Derived) -> Exprs:
    """f of a tree; Unsuited, with what is in the way, of another system."""
    still = [ZERO] * len(derived.speeds)
    if deforming(derived.system.bodies):
        return tuple(map(neg, bent_line(derived, still).left(derived)))
    line = line_at(derived, still)
    return tuple(map(neg, joint_rows(line, derived).T @ joint_forces(line)))


def mass_matrix(derived: Derived) -> Matrix:
    """M of a tree, which constraints do not change; Unsuited, with what is in the way, of another system."""
    if derived.constraints.constraints:
        derived = replace(derived, constraints=constraint_rows((), derived.kinematics, derived.auxiliary_speeds))
    still = [ZERO] * len(derived.speeds)
    if deforming(derived.system.bodies):
        return bent_line(derived, still).mass(derived)
    line = line_at(derived, still)
    own, mass = [p.freedom.row for p in line.places], joint_mass(line)
    if all(len(row) == 1 and next(iter(row.values())) is ONE for row in own):
        number = {s: k for k, row in enumerate(own) for s in row}
        if all(u in number for u in derived.speeds):
            order = [number[u] for u in derived.speeds]
            return mass.take(order, order)
    rows = joint_rows(line, derived)
    return rows.T @ mass @ rows


def joint_mass(line: Line) -> Matrix:
    """M of the joint speeds, by number."""
    bodies = [working(line.way.on, i, body) for i, body in enumerate(line.bodies)]
    whole = composites(line.way, bodies)
    return Matrix(freedom_mass(line.way, whole, len(line.places)))


def joint_rows(line: Line, derived: Derived) -> Matrix:
    """∂w/∂u, a row for each joint speed."""
    return by_speeds([p.freedom.row for p in line.places], derived)


def joint_forces(line: Line) -> list[Expr]:
    """g of every joint speed, by number."""
    moving, on = motions(line), line.way.on
    forces: list[Vectors | None] = [None] * len(moving)
    g: list[Expr] = [ZERO] * len(line.places)

    def felt(places: Sequence[Place], force: Vectors) -> None:
        for p in places:
            g[p.number] = sum_of(map(dot, parts(p.freedom, p.turning), force))

    for i in reversed(range(1, len(moving))):
        force = _both(pressing(line, i)(*moving[i].work, on.rates[i].square), forces[i])
        felt(line.way.inner[i], force)
        for k, make in enumerate(passed_on(line, i)):
            force = make(*force)
            if k == 0:
                felt(line.way.outer[i], force)
        if line.parent(i):
            forces[line.parent(i)] = _both(force, forces[line.parent(i)])
    return g


def _both(a: Vectors, b: Vectors | None) -> Vectors:
    return a if b is None else tuple(map(summed, a, b))
