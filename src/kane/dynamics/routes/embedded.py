# SPDX-License-Identifier: BSD-3-Clause
"""The route by nonholonomic partial velocities: motions in the independent speeds from the start, as one writes them by hand.

With u_D = A_n u_I + b_n and u̇_D = A_n u̇_I + c_D put in along the tree, every body has one partial velocity for each degree of freedom,
ṽ_r = v_r + Σ_D v_D A_n[D, r] (Kane & Levinson 1985, sec. 2.14), and the equations are those of a system without constraints:

    M̃_rs = Σ m ṽ_r·ṽ_s + ω̃_r·I·ω̃_s,   f̃_r = Σ ṽ_r·(F − m ã_b) + ω̃_r·(T − I·α̃_b − ω × I·ω)

M and f of all speeds are not assembled. Loads that hold reactions are left to the classical route.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kane.dynamics import assembly
from kane.dynamics.assembly import blocks, mass_rows
from kane.dynamics.bodies import Moving, moving_parts
from kane.dynamics.checks import check_mass
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived, free_fall
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.solved import Solved
from kane.expr.build import add, sub
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Reaction, Speed
from kane.kinematics.motion import Contact, Kinematics
from kane.space.point import Point


@dataclass(frozen=True, eq=False)
class Motions:
    """The motions of the bodies by `speeds`."""

    speeds: tuple[Speed, ...]
    kinematics: Kinematics
    bodies: tuple[Moving, ...]


def embedded_motions(derived: Derived, e: Embedding, contacts: Mapping[Point, Contact]) -> Motions:
    """The motions of all bodies where the speeds that the constraints give are written by the others."""
    speeds = derived.speeds
    own = tuple(speeds[i] for i in e.independent)
    following = e.following(speeds)
    vanishing = {u for u, by in following.items() if not by.row and by.rest is ZERO and by.bias is ZERO}
    kinematics = derived.kinematics.with_following(following, contacts, frozenset(vanishing))
    bodies = moving_parts(derived.inertias, kinematics)
    return Motions(own, kinematics, bodies)


def embedded(
    derived: Derived,
    e: Embedding,
    moving: Motions,
    bodies: tuple[Sequence[Moving], Sequence[Moving]] | None = None,
    *,
    carried: bool = False,
) -> Solved:
    """u̇ from the motions in the independent speeds, without the reactions; what is divided by is not watched yet.

    `bodies` are those that M̃ and f̃ are made of, where these are others than the motions have. Where they are `carried`, f̃ is made of
    the m ṽ_r and I·ω̃_r that M̃ has, (m ṽ_r)·a in the place of ṽ_r·(m a).
    """
    own = moving.speeds
    inertial, forced = bodies or (moving.bodies, moving.bodies)
    left = derived.left_by(moving.kinematics, () if carried else forced)
    right = [assembly.generalized_by_motion(left, s) for s in own]
    if carried:
        right = [add(x, _by_momenta(derived, forced, s)) for x, s in zip(right, own, strict=True)]
    equations = blocks(mass_rows(inertial, own, ()), right, (), (), {})
    check_mass(derived.system, own, equations.mass)
    inner = block_solution(equations)
    matrix = evident(derived)
    u_dot = e.every(inner.accelerations)
    return Solved("embedded", derived, e, u_dot, (), inner.pivots, matrix, matrix)


def _by_momenta(derived: Derived, bodies: Sequence[Moving], speed: Expr) -> Expr:
    """Σ (m ṽ_r)·(g − a_b) − (I·ω̃_r)·α_b − ω̃_r·(ω × I·ω)."""
    total = ZERO
    fall = free_fall(derived.system)
    for b in bodies:
        center, rotation = b.center, b.rotation
        for motion, mass in b.momenta if speed in center.partials else ():
            total = add(total, (center.partials[speed] * mass).dot((fall - motion.bias).gathered()))
        if rotation is not None and speed in rotation.motion.partials:
            w, turned = rotation.motion.partials[speed], rotation.motion
            spin = turned.total.express(rotation.inertia.frame)
            total = sub(total, rotation.inertia.times(w).dot(turned.bias))
            total = sub(total, w.dot(spin.cross(rotation.inertia.times(spin))))
    return total


def evident(derived: Derived) -> Matrix:
    """G_a where no load holds a reaction: what the reactions bring into the auxiliary equations."""
    rows, columns = derived.auxiliary_speeds, derived.reactions
    return Matrix([[derived.pairs.get((s, r), ZERO) for r in columns] for s in rows], (len(rows), len(columns)))


def holds_reactions(derived: Derived) -> bool:
    """Whether a load depends on a reaction."""
    vectors = (v for load in derived.declared_loads for _, v in (*load.forces, *load.torques))
    return any(isinstance(s, Reaction) for s in free_symbols(x for v in vectors for x in v.scalars()))
