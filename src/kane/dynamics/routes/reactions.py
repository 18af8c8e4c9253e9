# SPDX-License-Identifier: BSD-3-Clause
"""Reactions from the accelerations, as one writes them by hand once u̇ is known.

    G_a R = ρ_a + A_naᵀ ρ_D,   ρ_s = Σ v_s·(m a − F) + Σ ω_s·(I·α + ω × I·ω − T)

with a and α of each body put together first: the products with partial velocities are then as many as there are reactions, not as
many as entries of M_a. Where no load holds a reaction.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from kane.dynamics.bodies import Moving
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derived import Derived
from kane.dynamics.routes.block_solution import solved_reactions
from kane.dynamics.routes.embedded import Motions
from kane.dynamics.terms import Term, generalized_by_motion
from kane.expr.build import neg
from kane.expr.collect import collected
from kane.expr.count import price
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.kinematics.motion import Following, Kinematics, Motion
from kane.space.frame import Frame
from kane.space.rotation import Basis
from kane.space.vector import Vector

LARGE = 800
"""Operations of u̇ above which fewer ways are tried: they differ by little there, and each takes its time."""


def reactions(
    derived: Derived,
    e: Embedding | None,
    moving: Motions,
    u_dot: Mapping[Expr, Expr],
    matrix: Matrix,
    held: Callable[[Expr], Expr],
    differentiated: bool,
) -> Iterator[tuple[Expr, ...]]:
    """R in a few ways: vectors along the frames in which they are short, along those of the partial velocities, and these collected.

    Accelerations are those of the bodies of `moving` with `u_dot`, or velocities `differentiated`, partial velocities those of
    `derived`, which has all speeds. `held` leaves out the speeds that vanish.
    """
    for bodies in _differentiated(derived, moving, u_dot) if differentiated else (moving.bodies,):
        whole = [
            term._replace(motion=_motion(derived, term), vector=term.vector.map(held))
            for term in derived.left_by(moving.kinematics, bodies, u_dot)
            if not term.vector.is_zero
        ]
        short = [term._replace(vector=term.vector.map(collected)) for term in whole]
        for terms, turned in ((whole, False), (whole, True), (short, True)):
            yield tuple(map(held, solved_reactions(matrix, _remainders(derived, e, terms, turned))))


def _differentiated(derived: Derived, moving: Motions, u_dot: Mapping[Expr, Expr]) -> Iterator[tuple[Moving, ...]]:
    """The bodies with the accelerations of their centres as derivatives of the measure numbers of v along one frame, each in turn.

    Short systems only, for the ways of long ones differ by little.
    """
    if price(u_dot.values()) > LARGE:
        return
    frames = dict.fromkeys(f for b in moving.bodies if b.rotation for f in b.rotation.frame.lineage)
    known = moving.kinematics.with_following({u: Following({}, ZERO, u_dot.get(u, ZERO)) for u in derived.speeds}, {})
    for f in frames:
        yield tuple(_along(b, f, known) for b in moving.bodies)


def _along(b: Moving, frame: Basis, known: Kinematics) -> Moving:
    if b.rotation is None or frame not in b.rotation.frame.lineage:
        return b
    a = known.turning(b.center.total.express(frame))
    return b._replace(center=Motion({}, Vector(), a))


def _motion(derived: Derived, term: Term) -> Motion:
    place, kinematics = term.place, derived.kinematics
    return kinematics.frame(place) if isinstance(place, Frame) else kinematics.point(place)


def _remainders(derived: Derived, e: Embedding | None, whole: Sequence[Term], turned: bool) -> tuple[Expr, ...]:
    """ρ_a + A_naᵀ ρ_D, one for each auxiliary speed."""
    product = _dot_along if turned else Vector.dot

    def rho(s: Expr) -> Expr:
        return neg(generalized_by_motion(whole, s, product))

    own = [rho(a) for a in derived.auxiliary_speeds]
    if e is None or not e.partition.dependent:
        return tuple(own)
    held = [
        rho(derived.speeds[d]) if any(x is not ZERO for x in e.a_na.rows[k]) else ZERO
        for k, d in enumerate(e.partition.dependent)
    ]
    return (Matrix.column(own) + e.a_na.T @ Matrix.column(held)).entries


def _dot_along(partial: Vector, v: Vector) -> Expr:
    """Their product, v along the frame of the partial velocity first, as other reactions need it."""
    return partial.dot(v.express(partial.parts[0][0]) if len(partial.parts) == 1 else v)
