# SPDX-License-Identifier: BSD-3-Clause
"""Reactions from the accelerations, as one writes them by hand once u̇ is known.

    G_a R = ρ_a + A_naᵀ ρ_D,   ρ_s = Σ v_s·(m a − F) + Σ ω_s·(I·α + ω × I·ω − T)

with a and α of each body put together first: the products with partial velocities are then as many as there are reactions, not as
many as entries of M_a. Where no load holds a reaction.

Loads along what constraints hold contribute nothing: u̇ is solved without them, so that none of them is left there to cancel.

A force X e on a particle whose velocity along e is given, or X e and −X e on two that have it in common, is part of what holds them
(Kane & Levinson 1985, sec. 4.5). Without it λ + X takes the place of the multiplier λ, and nothing else changes.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from kane.dynamics.body_motions import Moving, moving_parts
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import LoadTerm, generalized_by_motion
from kane.dynamics.formulation.equations import Motions, about_points_at_rest, holds_reactions, solved_reactions
from kane.dynamics.solved import Solved
from kane.expr.build import mul, neg, sub, sum_of
from kane.expr.differentiation import Affine
from kane.expr.evaluation import Prices, exceeds, price
from kane.expr.forms.collect import collected
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.visit import remembered
from kane.kinematics.velocities import Following, Kinematics, Motion
from kane.model.constraints import Constraint, constraint_of
from kane.model.loads import Load
from kane.space.frame import Point
from kane.space.rotation import UNITS, Basis, single
from kane.space.vector import Vector

LARGE = 800
"""Operations of u̇ above which fewer ways are tried: they differ by little there, and each takes its time."""
_FEW = 6
"""Bodies up to which the accelerations of each are looked for."""


def reactions(
    derived: Derived,
    e: Embedding | None,
    moving: Motions,
    u_dot: Mapping[Expr, Expr],
    matrix: Matrix,
    held: Callable[[Expr], Expr],
    differentiated: bool,
) -> Iterator[tuple[Expr, ...]]:
    """R with products along the frames of the partial velocities; where they are `differentiated`, in a few ways.

    Accelerations are those of the bodies of `moving` with `u_dot`, or velocities `differentiated`, partial velocities those of
    `derived`, which has all speeds. `held` leaves out the speeds that vanish.
    """

    def whole(bodies: Sequence[Moving]) -> list[LoadTerm]:
        return [
            term._replace(motion=derived.kinematics.of(term.place), vector=term.vector.map(held))
            for term in derived.left_by(moving.kinematics, bodies, u_dot)
            if not term.vector.is_zero
        ]

    def solved(
        terms: Sequence[LoadTerm],
        about: Sequence[LoadTerm] | None = None,
        product: Callable[[Vector, Vector], Expr] = _dot_along,
    ) -> tuple[Expr, ...]:
        return tuple(map(held, solved_reactions(matrix, _remainders(derived, e, terms, about or terms, product))))

    def about_rest(bodies: Sequence[Moving]) -> tuple[Expr, ...]:
        pivoted = about_points_at_rest(bodies, derived.kinematics)
        still = Motion({}, Vector(), Vector())  # the mass centre of a body about a point at rest brings no acceleration
        resting = pivoted and whole([f if m is f else f._replace(center=still) for m, f in zip(*pivoted, strict=True)])
        return solved(whole(bodies), resting, Vector.dot)

    if not differentiated:
        yield solved(whole(moving.bodies))
    elif not exceeds(u_dot.values(), LARGE):  # of long systems the ways differ by little
        known = moving.kinematics.with_following(_given(derived, u_dot), {})
        for frame in dict.fromkeys(f for b in moving.bodies if b.rotation for f in b.rotation.frame.lineage):
            yield solved(whole([_along(b, frame, known) for b in moving.bodies]))
        if len(moving.bodies) <= _FEW:
            yield _along_inertial(derived, moving, u_dot, about_rest)


def _given(derived: Derived, u_dot: Mapping[Expr, Expr]) -> dict[Expr, Following]:
    return {u: Following({}, ZERO, u_dot.get(u, ZERO)) for u in derived.speeds}


def _along_inertial(
    derived: Derived,
    moving: Motions,
    u_dot: Mapping[Expr, Expr],
    reactions_of: Callable[[Sequence[Moving]], tuple[Expr, ...]],
) -> tuple[Expr, ...]:
    """The accelerations of some mass centres by u̇ of all speeds along the inertial frame, each where that is shorter."""
    cost = Prices((*derived.rates, *u_dot.values()))
    known = derived.kinematics.with_following(_given(derived, u_dot), moving.kinematics.contacts)
    bodies, best = list(moving.bodies), reactions_of(moving.bodies)
    least = cost(best)
    for k, b in enumerate(moving_parts(derived.inertias, known)):
        other = b._replace(center=replace(b.center, bias=b.center.bias.express(derived.system.inertial)))
        tried = [*bodies[:k], other, *bodies[k + 1 :]]
        found = reactions_of(tried)
        if (price_of := cost(found)) < least:
            bodies, best, least = tried, found, price_of
    return best


def _along(b: Moving, frame: Basis, known: Kinematics) -> Moving:
    """The body with the acceleration of its centre as the derivative of the measure numbers of v along a frame."""
    if b.rotation is None or frame not in b.rotation.frame.lineage:
        return b
    a = known.turning(b.center.total.express(frame))
    return b._replace(center=Motion({}, Vector(), a))


def _remainders(
    derived: Derived,
    e: Embedding | None,
    whole: Sequence[LoadTerm],
    about: Sequence[LoadTerm],
    product: Callable[[Vector, Vector], Expr],
) -> tuple[Expr, ...]:
    """ρ_a + A_naᵀ ρ_D, one for each auxiliary speed; ρ_D of the terms `about` points at rest."""

    def rho(s: Expr, terms: Sequence[LoadTerm] = about) -> Expr:
        return neg(generalized_by_motion(terms, s, product))

    own = [rho(a, whole) for a in derived.auxiliary_speeds]
    if e is None or not e.partition.dependent:
        return tuple(own)
    held = [
        rho(derived.speeds[d]) if any(x is not ZERO for x in e.a_na.rows[k]) else ZERO
        for k, d in enumerate(e.partition.dependent)
    ]
    return (Matrix.column(own) + _carried(e, tuple(held))).entries


@remembered
def _carried(e: Embedding, held: tuple[Expr, ...]) -> Matrix:
    """A_naᵀ ρ_D, by −A_aᵀ λ with A_Dᵀ λ = ρ_D where that divides by nothing else."""
    if {d.value for d in e.transposed.divisors} <= {d.value for d in e.divisors}:
        multipliers = e.transposed.solve(held)
        return -(e.rows.a_auxiliary.take(e.partition.rows).T @ Matrix.column(multipliers))
    return e.a_na.T @ Matrix.column(held)


def _dot_along(partial: Vector, v: Vector) -> Expr:
    """Their product, v along the frame of the partial velocity first, as other reactions need it."""
    return partial.dot(v.express(partial.parts[0][0]) if len(partial.parts) == 1 else v)


# Loads along what constraints hold -----------------------------------------------------------------------------------


Route = Callable[[Derived, Partition | None], Solved]
Forces = dict[Point, Vector]


def without_held_forces(route: Route) -> Route:
    """The route taken with what is left of the loads."""

    def solved(derived: Derived, partition: Partition | None) -> Solved:
        held, loads = _held(derived, partition) if partition is not None else ({}, ())
        if not held:
            return route(derived, partition)
        light = replace(derived, system=derived.system.with_loads(loads))
        found = route(light, partition)
        if found.twin is not None or found.derived is not light:
            return route(derived, partition)
        memo: dict[Expr, Affine] = {}
        reactions, constraints = list(found.reactions), derived.constraints.constraints
        for i, r in enumerate(derived.reactions):
            c = constraint_of(r)
            if c is not None and c in held:
                reactions[i] = sub(reactions[i], derived.kinematical.in_speeds(held[c], memo))
        of_rows = found.of_rows and {
            r: sub(x, derived.kinematical.in_speeds(held[c], memo)) if (c := constraints[r]) in held else x
            for r, x in found.of_rows.items()
        }
        return replace(found, derived=derived, lightened=light, reactions=tuple(reactions), of_rows=of_rows)

    return solved


def _held(derived: Derived, partition: Partition) -> tuple[Mapping[Constraint, Expr], Sequence[Load]]:
    """The loads' measure numbers along constraints that do not follow from others, and the loads without them."""
    constraints = [derived.constraints.constraints[r] for r in sorted(partition.rows)]
    loaded = _plain(derived.system.loads, {p for c in constraints for p, _ in c.forces})
    left = dict(loaded)
    held: dict[Constraint, Expr] = {}
    waiting = [
        c for c in constraints if not c.torques and len(c.forces) in (1, 2) and all(p in left for p, _ in c.forces)
    ]
    while waiting:  # the plainest force first: what is left is plainer for the others
        found = [(c, *_components(c, left)) for c in waiting]
        c, x, after = min(found, key=lambda each: (each[1] is ZERO, price([each[1]])))
        if x is ZERO:
            break
        held[c] = x
        left |= after
        waiting.remove(c)
    if not held or holds_reactions(derived):
        return {}, ()
    changed = {p: v for p, v in left.items() if v is not loaded[p]}
    kept = [_elsewhere(load, changed) for load in derived.system.loads]
    rests = [Load(f"rest at {p.name}", ((p, v),)) for p, v in changed.items() if not v.is_zero]
    return held, [*(load for load in kept if load.forces or load.torques), *rests]


def _is_plain(load: Load) -> bool:
    return load.potential is None and load.slip is None


def _plain(loads: Iterable[Load], points: set[Point]) -> Forces:
    """The forces of plain loads at points, all of one point together."""
    total: Forces = {}
    for load in loads:
        for p, v in load.forces if _is_plain(load) else ():
            if p in points:
                total[p] = total[p] + v if p in total else v
    return total


def _elsewhere(load: Load, points: Mapping[Point, Vector]) -> Load:
    """The load without its forces at points that are told anew."""
    if not _is_plain(load) or not any(p in points for p, _ in load.forces):
        return load
    return Load(load.name, tuple((p, v) for p, v in load.forces if p not in points), load.torques)


def _components(c: Constraint, loaded: Forces) -> tuple[Expr, Forces]:
    """X of the forces X e, or X e and −X e, along the constraint, and what is left at its points, where that is less."""
    places: list[tuple[Point, Basis, int, Expr]] = []
    for p, e in c.forces:
        frame, axis = e.parts[0]
        i = single(axis)
        if len(e.parts) > 1 or i is None or not (axis[i] is ONE or neg(axis[i]) is ONE):
            return ZERO, {}
        places.append((p, frame, i, axis[i]))
    least = (*_scalars(loaded[p] for p, *_ in places), 0)
    best: tuple[Expr, Forces] = ZERO, {}
    for p, frame, i, sign in places:
        own = sum_of([v[i] for f, v in loaded[p].parts if f is frame])
        for number in (own, loaded[p].components(frame)[i]):
            x = mul(sign, number)
            left = {p: _less(loaded[p], frame, i, mul(sign, x)) for p, frame, i, sign in places}
            found = (*_scalars(left.values()), price([x]))
            if x is not ZERO and found < least:
                best, least = (x, left), found
    return best


def _less(v: Vector, frame: Basis, i: int, x: Expr) -> Vector:
    """v without x along an axis, over its own frames or along that of the axis."""
    rest = (v - Vector(((frame, UNITS[i]),)) * x).map(collected)
    return min((rest, rest.express(frame).map(collected)), key=lambda w: _scalars([w]))


def _scalars(vectors: Iterable[Vector]) -> tuple[int, int]:
    """Measure numbers that there are, and what they cost."""
    scalars = [x for v in vectors for x in v.scalars() if x is not ZERO]
    return len(scalars), price(scalars)
