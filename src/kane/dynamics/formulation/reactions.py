# SPDX-License-Identifier: BSD-3-Clause
"""Reactions from the accelerations, as one writes them by hand once u̇ is known.

    G_a R = ρ_a + A_naᵀ ρ_D,   ρ_s = Σ v_s·(m a − F) + Σ ω_s·(I·α + ω × I·ω − T)

with a and α of each body put together first: the products with partial velocities are then as many as there are reactions, not as
many as entries of M_a. Where no load holds a reaction.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from kane.dynamics.body_motions import Moving, moving_parts
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import LoadTerm, generalized_by_motion
from kane.dynamics.formulation.block_solution import solved_reactions
from kane.dynamics.formulation.equations import Motions, about_points_at_rest
from kane.expr.build import neg
from kane.expr.forms.count import Prices, exceeds
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.visit import remembered
from kane.kinematics.velocities import Following, Kinematics, Motion
from kane.space.rotation import Basis
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
