# SPDX-License-Identifier: BSD-3-Clause
"""What control is made of: inverse dynamics, M and f, centroidal momentum, inertia as it is felt at a point.

Of trees that recursions solve, by recursion.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

from kane.dynamics import inverse_dynamics as trees
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.block_solution import solved_reactions
from kane.dynamics.formulation.recursive import BENT, WAYS
from kane.dynamics.readings.energy import linear_momentum, mass_center
from kane.dynamics.solved import Solved
from kane.errors import ArgumentError, SingularError
from kane.expr.build import div, sub
from kane.expr.differentiation import weighted
from kane.expr.forms.count import price
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.solve import forward, ldl, solve_lu, sparse_order
from kane.expr.symbols import rate
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited
from kane.model.bodies import deforming
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Exprs = tuple[Expr, ...]
V = TypeVar("V", Matrix, Exprs)


def inverse_dynamics(solved: Solved) -> Exprs:
    """M u̇ − f as functions of the state and of u̇: the generalized forces that are wanted besides the loads.

    Reactions that loads hold follow from their own equations at u̇; where constraints have a part in these, an ArgumentError.
    """
    return _by_tree(solved, trees.residual, _dense_inverse)


def _dense_inverse(d: Derived) -> Exprs:
    u_dot, blocks = [rate(u) for u in d.speeds], d.blocks
    found = tuple(sub(x, f) for x, f in zip(d.mass_matrix @ u_dot, d.forcing, strict=True))
    if all(x is ZERO for x in blocks.coupling.entries):
        return found
    if any(x is not ZERO for x in d.constraints.a_auxiliary.entries):
        raise ArgumentError(
            "Expected loads that hold no reactions, or reactions that no constraint changes, for inverse dynamics of all speeds. "
            "Solve for what is unknown with kn.inverse(eom, unknowns=…)."
        )
    right = [sub(x, f) for x, f in zip(blocks.mass_a @ u_dot, blocks.forcing_a, strict=True)]
    values: dict[Expr, Expr] = dict(zip(d.reactions, solved_reactions(blocks.coupling_a, right), strict=True))
    memo: dict[Expr, Expr] = {}
    return tuple(substituted(x, values, memo) for x in found)


def forcing(solved: Solved) -> Exprs:
    """f of M u̇ = f."""
    return _by_tree(solved, trees.forcing, lambda d: d.forcing)


def mass_matrix(solved: Solved) -> Matrix:
    """M."""
    return _by_tree(solved, trees.mass_matrix, lambda d: d.mass_matrix)


def _by_tree(solved: Solved, tree: Callable[[Derived], V], usual: Callable[[Derived], V]) -> V:
    """What is read along the segments of a tree that recursions solve; of few flexible bodies the shorter of both."""
    d = solved.derived
    if solved.route in WAYS:
        try:
            found = tree(d)
            few = deforming(d.system.bodies) and len(d.speeds) < BENT
            return min((found, usual(d)), key=_price) if few else found
        except Unsuited:
            pass
    return usual(d)


def _price(x: Matrix | Exprs) -> int:
    return price(x.entries if isinstance(x, Matrix) else x)


def centroidal_momentum_matrix(solved: Solved) -> Matrix:
    """A_G (6 × n): Σ m v, then the angular momentum about the mass centre, along the inertial frame, per unit of each speed."""
    d = solved.derived
    bodies, frame = d.bodies, d.system.inertial
    origin = bodies[0].part.mass_center
    p, center = linear_momentum(bodies), mass_center(bodies, origin)
    about = Vector()
    for b in bodies:
        arm = b.part.mass_center.position(origin) - center
        for motion, mass in b.momenta:
            about = about + arm.cross(motion.total * mass)
        if b.rotation is not None:
            about = about + b.rotation.inertia.times(b.rotation.motion.total)
    rows = [weighted([x], [ONE], d.speeds) for x in (*p.components(frame), *about.components(frame))]
    return Matrix(rows, (6, len(d.speeds)))


def operational_mobility(solved: Solved, place: Point | Frame, along: Sequence[Vector] | None) -> Matrix:
    """Λ⁻¹ = J M⁻¹ Jᵀ: the acceleration along each axis per unit of force, or torque, along each.

    Under constraints J and M are those of the independent speeds.
    """
    axes = _axes(solved, along)
    if isinstance(place, Point):
        partials = solved.partial_velocities_nh[place]
    elif isinstance(place, Frame):
        partials = solved.partial_angular_velocities_nh[place]
    else:
        raise ArgumentError(f"Expected a point or a frame to push at, got {place!r}.")
    mass = mass_matrix(solved) if solved.embedding is None else solved.mass_matrix_nh
    order = sparse_order(mass.rows)
    speeds = [solved.independent_speeds[i] for i in order]
    factors = ldl(mass.take(order, order).rows)
    columns = [forward(factors.lower, [partials[u].dot(axis) for u in speeds]) for axis in axes]
    scaled = [[ZERO if x is ZERO else div(x, d) for x, d in zip(c, factors.pivots, strict=True)] for c in columns]
    return Matrix([[dot(a, b) for b in scaled] for a in columns]).mirrored()


def operational_inertia(solved: Solved, place: Point | Frame, along: Sequence[Vector] | None) -> Matrix:
    """Λ = (J M⁻¹ Jᵀ)⁻¹: the force, or torque, along each axis per unit of acceleration along each."""
    mobility = operational_mobility(solved, place, along)
    n = mobility.shape[0]
    try:
        columns = solve_lu(mobility.rows, [[ONE if i == j else ZERO for i in range(n)] for j in range(n)])
    except SingularError as error:
        raise SingularError(
            f"Expected axes along each of which {place} can be accelerated by itself, got {n} that are not independent. Give fewer, "
            "along=(…), or take operational_mobility, its inverse, which exists."
        ) from error
    return Matrix(columns, (n, n))


def _axes(solved: Solved, along: Sequence[Vector] | None) -> tuple[Vector, ...]:
    if along is None:
        frame = solved.derived.system.inertial
        return frame.x, frame.y, frame.z
    given: object = along
    if not isinstance(given, Sequence) or not given or not all(isinstance(v, Vector) for v in given):
        raise ArgumentError(f"Expected along= as a list of unit vectors, got {along!r}.")
    return tuple(along)
