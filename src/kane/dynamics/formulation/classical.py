# SPDX-License-Identifier: BSD-3-Clause
"""Kane's dynamical equations in given speeds (Kane & Levinson 1985, sec. 4.4, 6.1), with M factored as L D Lᵀ: four forms.

Assembled (classical): M, f and G of all speeds are reduced by B = [1; A_n]. Embedded: u_D = A_n u_I + b_n and u̇_D = A_n u̇_I + c_D
are substituted along the tree, so that every body has the nonholonomic partial velocities ṽ_r = v_r + Σ_D v_D A_n[D, r] (sec. 2.14),
one per degree of freedom, and the equations are those of a system without constraints:

    M̃_rs = Σ m ṽ_r·ṽ_s + ω̃_r·I·ω̃_s,   f̃_r = Σ (m ṽ_r)·(g − ã_b) + ṽ_r·F + ω̃_r·T − (I·ω̃_r)·α̃_b − ω̃_r·(ω × I·ω)

For a body with a point O at rest the terms may be written about O: with ṽ_r = ω̃_r × r, r from O,

    m ṽ_r·a + ω̃_r·(I·α + ω × I·ω) = ω̃_r·(I_O·α + ω × I_O·ω),   I_O = I + m (r² 1 − r r)

(sec. 3.3), where I_O depends on parameters alone. Power: with one degree of freedom and velocities homogeneous in the speeds,
u = B u_I, the power of the forces is the rate of the kinetic energy K = ½ uᵀ M u,

    Bᵀ M B u̇_I = Bᵀ F − (M B)ᵀ c − ½ Bᵀ Ṁ u,

with the active forces F: accelerations of bodies are not needed, and only entries of M that vary are differentiated. As B_r u_s is
B_s u_r, each pair of entries of Ṁ is needed once. Squares: K is written as a sum of squares, as by hand:

    K = ½ Σ W x²,   x = X u_I,   ẋ = X u̇_I + d:       (Σ W X²) u̇_I = F̃ − Σ W X d

The x are measure numbers of angular velocities and of velocities of mass centres, each along a frame in which they are short. Terms
that vanish by a constraint are left out, and multiples of the same form are joined: moments of inertia are then about the points
guided by constraints. Loads that depend on reactions need the assembled form.

The equations are solved for u̇ and the reactions as straight-line code:

    M u̇ = f + G R                 n equations
    M_a u̇ = f_a + G_a R           one for each auxiliary speed

M is factored as L D Lᵀ. With y = L⁻¹ f, Z = L⁻¹ G and X = L⁻¹ M_aᵀ the reactions solve

    (G_a − Xᵀ D⁻¹ Z) R = Xᵀ D⁻¹ y − f_a,

a small block, and u̇ = L⁻ᵀ D⁻¹ (y + Z R). If no load depends on a reaction, Z = 0 and R follows from u̇. M is eliminated in an order
with little fill-in.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from kane.dynamics import forcing
from kane.dynamics.constraints.partition import Embedding, Partition, embedding
from kane.dynamics.derivation import Derived, check_mass, free_fall
from kane.dynamics.forcing import Blocks, Moving, PartRotation, blocks, mass_rows, moving_parts, primitive
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg, sub, sum_of
from kane.expr.evaluation import Prices, free_symbols, is_constant_in_time, price
from kane.expr.forms.collect import collected
from kane.expr.matrix import Matrix, dot, ldl, solve_lu, sparse_order
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.symbols import AuxiliarySpeed, Reaction, Speed
from kane.expr.visit import remembered
from kane.kinematics.speeds import ScalarForm
from kane.kinematics.velocities import ContactPoint, Kinematics, Motion
from kane.model.bodies import Part
from kane.space.frame import Point
from kane.space.rotation import Basis, Cosines, Triple
from kane.space.vector import Vector
from kane.tree.triples import as_rows


class BlockSolution(NamedTuple):
    """u̇ and R, the pivots of M, the matrix G_a − Xᵀ D⁻¹ Z, and the same without loads that depend on reactions.

    If some reaction occurs in loads alone, the latter matrix is G_a with these loads.
    """

    accelerations: tuple[Expr, ...]
    reactions: tuple[Expr, ...]
    pivots: tuple[Expr, ...]
    reaction_matrix: Matrix
    bare_reaction_matrix: Matrix


def block_solution(blocks: Blocks) -> BlockSolution:
    """Solves the equations for u̇ and R. SingularError if a pivot of M, or of the equations for R, is identically zero.

    Coupled equations are divided by parameters and numbers common to all of their terms, and the result is collected if that is
    shorter.
    """
    usual, shorter = _solution(blocks), primitive(blocks)
    if shorter is blocks:
        return usual
    every = [usual, _solution(shorter)]
    forcing = tuple(map(collected, shorter.forcing))
    if any(x is not y for x, y in zip(forcing, shorter.forcing, strict=True)):
        every.append(_solution(shorter._replace(forcing=forcing)))
    return min(every, key=lambda s: price((*s.accelerations, *s.reactions)))


def _solution(blocks: Blocks) -> BlockSolution:
    factors = ldl(blocks.mass.rows, sparse_order(blocks.mass.rows))
    y, z = factors.forward(blocks.forcing), list(map(factors.forward, blocks.coupling.T))
    coupled = any(x is not ZERO for column in z for x in column)
    matrix = blocks.coupling_a
    if not coupled:
        u_dot = factors.finish(y)
        right = [sub(dot(m, u_dot), f) for m, f in zip(blocks.mass_a, blocks.forcing_a, strict=True)]
    else:
        x = [factors.over(factors.forward(row)) for row in blocks.mass_a]
        matrix = Matrix(
            [[sub(g, dot(r, c)) for g, c in zip(row, z, strict=True)] for row, r in zip(matrix, x, strict=True)]
        )
        right = [sub(dot(r, y), f) for r, f in zip(x, blocks.forcing_a, strict=True)]
    reactions = solved_reactions(matrix, right)
    if coupled:
        for reaction, column in zip(reactions, z, strict=True):
            y = [v if c is ZERO else add(v, mul(c, reaction)) for v, c in zip(y, column, strict=True)]
        u_dot = factors.finish(y)
    known = all(any(x is not ZERO for x in row) for row in blocks.evident.rows)
    pivots = dict(zip(factors.order, factors.pivots, strict=True))
    return BlockSolution(
        tuple(u_dot),
        tuple(reactions),
        tuple(pivots[i] for i in range(len(pivots))),
        matrix,
        blocks.evident if known else blocks.coupling_a,
    )


def solved_reactions(matrix: Matrix, right: Sequence[Expr]) -> list[Expr]:
    """R from `matrix` R = `right`."""
    diagonal = [row[i] for i, row in enumerate(matrix)]
    if any(x is not ZERO for i, row in enumerate(matrix) for j, x in enumerate(row) if i != j):
        return solve_lu(matrix.rows, [right])[0]
    if any(x is ZERO for x in diagonal):
        raise SingularError("Expected each reaction to enter its own equation, got a zero on the diagonal.")
    return [div(b, x) for b, x in zip(right, diagonal, strict=True)]


def classical(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions from M u̇ = f + G R. ModelError if a speed, or a combination of speeds, moves no mass."""
    return unguarded_classical(derived, partition).guarded()


def unguarded_classical(derived: Derived, partition: Partition | None, e: Embedding | None = None) -> Solved:
    """The same without guards of divisors, with the embedding `e` of the partition if it exists already."""
    system, speeds, blocks = derived.system, derived.speeds, derived.blocks
    if partition is None:
        check_mass(system, speeds, blocks.mass)
        return Solved("classical", derived, None, *block_solution(blocks))
    e = e or embedding(derived.constraints, partition)
    inner = e.reduced(blocks)
    check_mass(system, [speeds[i] for i in e.independent], inner.mass)
    solution = block_solution(inner)
    every = solution._replace(accelerations=e.every(solution.accelerations))
    return Solved("classical", derived, e, *every)


@dataclass(frozen=True, eq=False)
class BodyMotions:
    """The motions of the bodies in `speeds`."""

    speeds: tuple[Speed, ...]
    kinematics: Kinematics
    bodies: tuple[Moving, ...]


def embedded_motions(derived: Derived, e: Embedding, contacts: Mapping[Point, ContactPoint]) -> BodyMotions:
    """The motions of all bodies in the independent speeds."""
    speeds = derived.speeds
    own = tuple(speeds[i] for i in e.independent)
    following = e.following(speeds)
    vanishing = {u for u, by in following.items() if not by.row and by.rest is ZERO and by.bias is ZERO}
    kinematics = derived.kinematics.with_following(following, contacts, frozenset(vanishing))
    bodies = moving_parts(derived.inertias, kinematics)
    return BodyMotions(own, kinematics, bodies)


def embedded(
    derived: Derived,
    e: Embedding,
    moving: BodyMotions,
    bodies: tuple[Sequence[Moving], Sequence[Moving]] | None = None,
    *,
    carried: bool = False,
) -> Solved:
    """u̇ by the embedded form, without reactions and without guards of divisors.

    `bodies` are the bodies for M̃ and for f̃, if others than those of `moving`. If `carried`, f̃ contains (m ṽ_r)·a instead of
    ṽ_r·(m a), with the momenta m ṽ_r and I·ω̃_r of M̃.
    """
    own = moving.speeds
    inertial, forced = bodies or (moving.bodies, moving.bodies)
    left = derived.left_by(moving.kinematics, () if carried else forced)
    right = [forcing.generalized_by_motion(left, s) for s in own]
    if carried:
        right = [add(x, _by_momenta(derived, forced, s)) for x, s in zip(right, own, strict=True)]
    mass = mass_rows(inertial, own, ())
    check_mass(derived.system, own, Matrix(mass, (len(own), len(own))))
    return _without_reactions("embedded", derived, e, mass, right)


def _without_reactions(
    route: str, derived: Derived, e: Embedding, mass: list[list[Expr]], right: Sequence[Expr]
) -> Solved:
    """u̇ from M̃ and f̃ of the independent speeds, without guards of divisors."""
    inner, matrix = block_solution(blocks(mass, right, (), (), {})), evident(derived)
    return Solved(route, derived, e, e.every(inner.accelerations), (), inner.pivots, matrix, matrix)


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
    """G_a without loads that depend on reactions."""
    rows, columns = derived.auxiliary_speeds, derived.reactions
    return Matrix([[derived.pairs.get((s, r), ZERO) for r in columns] for s in rows], (len(rows), len(columns)))


def holds_reactions(derived: Derived) -> bool:
    """Whether a load depends on a reaction."""
    scalars = (x for _, v in forcing.acting(derived.declared_loads) for x in v.scalars())
    return any(isinstance(s, Reaction) for s in free_symbols(scalars))


Bodies = tuple[Moving, ...]


def about_points_at_rest(bodies: Sequence[Moving], kinematics: Kinematics) -> tuple[Bodies, Bodies] | None:
    """The bodies for M and for f, with inertias about points at rest; None if no body has such a point."""
    inertial, forced, some = [], [], False
    for m in bodies:
        turning = _about_point(m, kinematics)
        if turning is not None:
            some = True
            inertial.append(m._replace(center=replace(m.center, partials={}), rotation=turning))
            forced.append(m._replace(center=m.center.with_bias(Vector()), rotation=turning))
        else:
            inertial.append(m)
            forced.append(m)
    return (tuple(inertial), tuple(forced)) if some else None


@remembered
def _about_point(m: Moving, kinematics: Kinematics) -> PartRotation | None:
    """The rotation of a body with the inertia about a point of it at rest; None if there is no such point."""
    turning, arm = m.rotation, _arm(m.part, kinematics)
    if turning is None or arm is None or kinematics.point(m.part.mass_center).is_still:
        return None
    inertia = turning.inertia
    r = arm.components(inertia.frame)
    if not is_constant_in_time(r):
        return None
    whole = replace(inertia, rows=_inertia_about(inertia.rows, m.part.mass, r))
    return replace(turning, inertia=whole, made=lambda: whole.torque(turning.motion, turning.motion.bias))


def _inertia_about(rows: Cosines, mass: Expr, r: Triple) -> Cosines:
    """I + m (r² 1 − r r)."""
    square = dot(r, r)
    own = [[add(square if i == j else ZERO, neg(mul(r[i], r[j]))) for j in range(3)] for i in range(3)]
    return as_rows(
        [[collected(add(x, mul(mass, y))) for x, y in zip(*both, strict=True)] for both in zip(rows, own, strict=True)]
    )


def _arm(part: Part, kinematics: Kinematics) -> Vector | None:
    """The position of the mass centre from a point of the body at rest; None if there is no such point."""
    point, arm = part.mass_center, Vector()
    while point.parent is not None and point.body is None and _is_fixed(point, part):
        arm, point = arm + kinematics.aligned.vector(point.offset), point.parent
        if kinematics.point(point).is_still:
            return arm
        held = kinematics.contacts.get(point)
        if held is not None and held.body is part.frame and held.other is None and not held.directions:
            return arm - kinematics.aligned.vector(held.particle.offset) if _is_fixed(held.particle, part) else None
    return None


def _is_fixed(point: Point, part: Part) -> bool:
    """Whether the position of a point from its parent is fixed in the body."""
    offset = point.offset
    return all(f is part.frame for f, _ in offset.parts) and is_constant_in_time(offset.scalars())


_HALF = constant(0.5)


def homogeneous(derived: Derived, e: Embedding) -> bool:
    """Whether there is one u_I, velocities are u_I times a function of configuration and time, and momenta are m v."""
    if any(m.shared for m in derived.bodies):
        return False
    moving = [m.center for m in derived.bodies] + [m.rotation.motion for m in derived.bodies if m.rotation]
    return len(e.independent) == 1 and all(m.rest.is_zero for m in moving) and all(x is ZERO for x in e.b_n)


def _of_one_speed(derived: Derived, e: Embedding) -> tuple[list[Expr], list[Expr]]:
    """B and the active forces of all speeds, for one independent speed."""
    by: dict[int, Expr] = {i: x for i, (x,) in zip(e.partition.dependent, e.a_n.rows, strict=True)}
    left = derived.left_by(derived.kinematics, [still(m) for m in derived.bodies])
    active = [forcing.generalized_by_motion(left, s) for s in derived.speeds]
    return [by.get(i, ONE) for i in range(len(derived.speeds))], active


def power(derived: Derived, e: Embedding) -> Solved:
    """u̇ by the power form, without reactions and without guards of divisors."""
    every, active = _of_one_speed(derived, e)
    spread = derived.mass_matrix @ every
    held = [spread[d] for d in e.partition.dependent]
    right = sub(sub(dot(every, active), dot(held, e.c)), _gained(derived, e, every))
    return _without_reactions("power", derived, e, [[dot(every, spread)]], [right])


def still(m: Moving) -> Moving:
    """The body with zero bias acceleration."""
    turning = m.rotation and replace(m.rotation, made=Vector)
    shared = tuple((motion.with_bias(Vector()), mass) for motion, mass in m.shared)
    return m._replace(center=m.center.with_bias(Vector()), rotation=turning, shared=shared)


def _gained(derived: Derived, e: Embedding, every: Sequence[Expr]) -> Expr:
    """½ Bᵀ Ṁ u, with the terms of the independent speed, whose B is 1, first."""
    total, m = ZERO, derived.mass_matrix
    order = (*e.independent, *sorted(e.partition.dependent))
    for k, s in enumerate(order):
        own = mul(every[s], mul(_HALF, derived.kinematics.drift(m[s, s])))
        column = sum_of([own, *(mul(every[r], derived.kinematics.drift(m[r, s])) for r in order[:k])])
        total = add(total, mul(derived.speeds[s], column))
    return total


Form = dict[Expr, Expr]
"""Coefficients by speed."""

_TERM = 4
"""Operations that a term of a measure number brings: in it, in its derivative, and in products with both."""


class Square(NamedTuple):
    """A term W x y of 2 K; x and y are the same form except for products of inertia."""

    weight: Expr
    x: Form
    y: Form


def squares(derived: Derived, e: Embedding) -> Solved:
    """u̇ by the form of squares, without reactions and without guards of divisors."""
    every, active = _of_one_speed(derived, e)
    by_speed: dict[Expr, Expr] = dict(zip(derived.speeds, every, strict=True))
    known = derived.kinematics.with_following(e.following(derived.speeds), {})
    right = dot(every, active)
    mass = ZERO
    for w, x, y in _merged(_squares(derived, e)):
        share, other = _value(x, by_speed), _value(y, by_speed)
        carried = mul(w, other)
        mass = add(mass, mul(share, carried))
        d = known.drift(ScalarForm(x, ZERO).total())
        right = sub(right, mul(carried, collected(d) if len(x) > 1 else d))
    return _without_reactions("squares", derived, e, [[mass]], [right])


def _value(x: Form, by: Mapping[Expr, Expr]) -> Expr:
    return sum_of(mul(c, by[u]) for u, c in x.items())


def _merged(found: Iterator[Square]) -> list[Square]:
    """The terms, with multiples of the same form by parameters joined."""
    weights: dict[tuple[tuple[tuple[Expr, Expr], ...], ...], Expr] = {}
    for w, x, y in found:
        (a, x_), (b, y_) = _normed(x), _normed(y)
        key = tuple(x_.items()), tuple(y_.items())
        weights[key] = add(weights.get(key, ZERO), mul(mul(w, a), b))
    return [Square(w, dict(x), dict(y)) for (x, y), w in weights.items()]


def _normed(x: Form) -> tuple[Expr, Form]:
    """A factor of parameters of a form, and the form divided by it."""
    if len(x) == 1:
        ((u, c),) = x.items()
        if is_constant_in_time([c]):
            return c, {u: ONE}
    return ONE, x


def _squares(derived: Derived, e: Embedding) -> Iterator[Square]:
    """The terms of each part, its velocity along the frame in which it adds the fewest operations to the preceding terms."""
    speeds: Sequence[Expr] = derived.speeds
    given = [derived.constraints.a.rows[r] for r in e.partition.rows]
    rows = [{u: a for u, a in zip(speeds, row, strict=True) if a is not ZERO} for row in given]
    parts = zip(e.partition.dependent, e.a_n.rows, e.c, strict=True)
    zero = {speeds[d] for d, (x,), c in parts if x is ZERO and c is ZERO}
    seen: list[Expr] = []
    for m in derived.bodies:
        best: list[Form] = []
        if m.center.partials:
            ways = [[_without_vanishing(x, rows, zero) for x in _forms(m.center, f)] for f in _frames(derived, m)]
            price = Prices(seen)
            best = min(ways, key=lambda xs: price([c for x in xs for c in x.values()]) + _TERM * sum(map(len, xs)))
        seen += [c for x in best for c in x.values()]
        yield from (Square(m.part.mass, x, x) for x in best if x)
        if m.rotation is None:
            continue
        inertia = m.rotation.inertia
        omega = [_without_vanishing(x, rows, zero) for x in _forms(m.rotation.motion, inertia.frame)]
        for row, x in zip(inertia.rows, omega, strict=True):
            yield from (Square(w, x, y) for w, y in zip(row, omega, strict=True) if w is not ZERO and x and y)


def _frames(derived: Derived, m: Moving) -> list[Basis]:
    """The frames of the partial velocities, and the body's frame."""
    found = [f for v in m.center.partials.values() for f, _ in v.parts]
    if m.part.frame is not None:
        found.append(derived.kinematics.aligned.rates(m.part.frame)[0])
    return list(dict.fromkeys(found))


def _forms(motion: Motion, frame: Basis) -> list[Form]:
    """The measure numbers of a velocity along a frame, as forms in speeds."""
    forms: list[Form] = [{}, {}, {}]
    for u, v in motion.partials.items():
        if isinstance(u, AuxiliarySpeed):
            continue
        for x, c in zip(forms, v.components(frame), strict=True):
            if c is not ZERO:
                x[u] = c
    return forms


def _without_vanishing(x: Form, rows: Sequence[Form], zero: set[Expr]) -> Form:
    """The form x without combinations that constraints make zero."""
    for row in rows:
        for join in (sub, add):
            less = {u: join(x.get(u, ZERO), row.get(u, ZERO)) for u in {**x, **row}}
            less = {u: c for u, c in less.items() if c is not ZERO}
            if len(less) < len(x):
                x = less
    return {u: c for u, c in x.items() if u not in zero}
