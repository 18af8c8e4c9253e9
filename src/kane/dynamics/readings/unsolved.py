# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion before they are solved, and conditions of rest and of steady motion.

    M u̇ − Aᵀ λ − G R       = f                n rows
    A u̇                    = −(Ȧ u + ḃ)       one for each constraint
    M_a u̇ − A_aᵀ λ − G_a R = f_a              one for each reaction

K z = k with z = (u̇, λ, R). Nothing is divided by, so that its derivatives are short, and hold wherever K is regular:

    K δz = −∂(K z − k)/∂x δx,   z held while differentiating.

At rest F̃_r = 0 at u = z (q̇ = 0), in steady motion F̃_r + F̃*_r = 0 at u̇ = 0 (Kane & Levinson 1985, sec. 6.5 and 6.6).

Terms for control: inverse dynamics, M and f, centroidal momentum, the operational inertia at a point.

Of trees that recursions solve, by recursion.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from kane.dynamics import inverse_dynamics as trees
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.classical import solved_reactions
from kane.dynamics.formulation.recursive import BENT, WAYS
from kane.dynamics.readings.energy import angular_momentum, linear_momentum, mass_center
from kane.dynamics.solved import Solved
from kane.errors import ArgumentError, ExpressionError, ModelError, SingularError, ValueMissingError, alike, cut
from kane.expr.build import add, neg, sub
from kane.expr.differentiation import tangent, weighted
from kane.expr.evaluation import free_symbols, price
from kane.expr.forms.collect import collected
from kane.expr.matrix import Matrix, dot, ldl, solve_lu, sparse_order
from kane.expr.node import ONE, ZERO, Expr, Exprs, as_expr
from kane.expr.symbols import Reaction, Symbol, Time, input_of, rate
from kane.expr.visit import substituted, substituting
from kane.kinematics.freedoms import Unsuited
from kane.model.bodies import deforming
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class Unsolved:
    """z = (u̇, λ, R) as `unknowns`, K, k, and what a state must satisfy.

    `configuration` is f(q, t), `motion` A u + b, `rates` q̇ in speeds, `spins` the angular velocity's measure numbers of each set of
    Euler parameters, `states` ȧ of the further states.
    """

    unknowns: tuple[Symbol, ...]
    matrix: tuple[tuple[Expr, ...], ...]
    right: tuple[Expr, ...]
    configuration: tuple[Expr, ...]
    motion: tuple[Expr, ...]
    rates: tuple[Expr, ...]
    spins: tuple[Expr, ...]
    states: tuple[Expr, ...]

    @property
    def residual(self) -> tuple[Expr, ...]:
        """K z − k."""
        return tuple(sub(dot(row, self.unknowns), k) for row, k in zip(self.matrix, self.right, strict=True))

    @property
    def places(self) -> tuple[Expr, ...]:
        """f, A u + b, q̇, spins and ȧ: what is differentiated together with the residual."""
        return (*self.configuration, *self.motion, *self.rates, *self.spins, *self.states)


def unsolved(derived: Derived) -> Unsolved:
    """The unsolved equations of motion."""
    blocks, rows = derived.blocks, derived.constraints
    m, s = len(rows.constraints), len(derived.reactions)
    columns = (*blocks.mass, *blocks.mass_a), (*rows.a.T, *rows.a_auxiliary.T), (*blocks.coupling, *blocks.coupling_a)
    dynamical = [(*mass, *map(neg, a), *map(neg, g)) for mass, a, g in zip(*columns, strict=True)]
    held = [(*row, *[ZERO] * (m + s)) for row in rows.a]
    kinematical, n = derived.kinematical, len(derived.speeds)
    return Unsolved(
        (*map(rate, derived.speeds), *(Reaction.declare(f"λ{k + 1}") for k in range(m)), *derived.reactions),
        (*dynamical[:n], *held, *dynamical[n:]),
        (*blocks.forcing, *map(neg, rows.drift), *blocks.forcing_a),
        tuple(c.expr for c in derived.system.holonomic),
        derived.constraint_rates,
        derived.rates,
        tuple(
            add(dot(list(kinematical.inverse[w].values()), list(kinematical.inverse[w])), kinematical.x[w])
            for e in derived.system.euler_parameters
            for w in e.quasi
        ),
        derived.state_rates,
    )


def partials(roots: Sequence[Expr], symbols: Sequence[Expr]) -> Matrix:
    """∂roots/∂symbols, a row for each root; those of lengths |v| at v = 0 are zero."""
    columns = []
    for s in symbols:
        memo: dict[Expr, Expr] = {}
        columns.append([tangent(r, {s: ONE}, memo, at_rest=True) for r in roots])
    return Matrix(zip(*columns, strict=True), (len(roots), len(symbols)))


def equilibrium_conditions(solved: Solved) -> Exprs:
    """F̃_r at rest, one for each independent speed: what vanishes in equilibrium.

    Raises
    ------
    ModelError
        if motion is prescribed, so that nothing can be at rest, or a load has no value there
    """
    d = solved.derived
    given = [s for s in free_symbols([*d.z, *d.constraints.b]) if isinstance(s, Time) or input_of(s) is not None]
    if given:
        raise ModelError(
            f"Expected a system that can be at rest, got one whose motion is prescribed by {given[0]}. Use the "
            "conditions for a steady motion, eom.steady_conditions({…})."
        )
    at: dict[Expr, Expr] = dict(zip(d.speeds, d.z, strict=False))  # z ends with a zero for each set of Euler parameters
    try:
        return _written(solved.Fr_nh[: len(solved.independent_speeds)], at)
    except ExpressionError as error:
        raise ModelError(
            "Expected loads that are defined at rest, got one that is divided by a speed, as sliding friction is: at rest it can have "
            "any value within a range. Leave it out, eom.system.replace(loads=[…])."
        ) from error


def steady_conditions(solved: Solved, values: Mapping[Any, Any]) -> Exprs:
    """F̃_r + F̃*_r at u̇ = 0 with the `values` of some coordinates and speeds, one for each independent speed.

    Raises
    ------
    ValueMissingError
        if a value is given for something else
    """
    d, count = solved.derived, len(solved.independent_speeds)
    known: dict[str, Symbol] = {s.name: s for s in (*d.system.coordinates, *d.speeds)}
    at: dict[Expr, Expr] = {}
    given: object = values
    if not isinstance(given, Mapping):
        raise ValueMissingError(f"Expected values by symbol or name, {{u1: 2.0}}, got {cut(repr(given))}.")
    for key, value in values.items():
        name = key.name if isinstance(key, Symbol) else key
        if name not in known:
            raise ValueMissingError(
                f"Expected values of coordinates and speeds ({', '.join(known)}) in a steady motion, got one of {cut(repr(name))}."
                f"{alike(str(name), known)}"
            )
        at[known[name]] = as_expr(value)
    even: dict[Expr, Expr] = {rate(u): ZERO for u in d.speeds}
    sums = [add(f, g) for f, g in zip(solved.Fr_nh[:count], solved.Fr_star_nh[:count], strict=True)]
    return _written([substituted(e, even) for e in sums], at)


def _written(exprs: Sequence[Expr], at: Mapping[Expr, Expr]) -> Exprs:
    found = map(substituting(at), exprs)
    return tuple(min((e, collected(e)), key=lambda form: price([form])) for e in found)


V = TypeVar("V", Matrix, Exprs)


def inverse_dynamics(solved: Solved) -> Exprs:
    """M u̇ − f as functions of the state and of u̇: the generalized forces that are wanted besides the loads.

    Reactions that loads hold follow from their own equations at u̇; where constraints have a part in these, an ArgumentError.
    """
    return _by_tree(solved, trees.residual, _dense_inverse)


def _dense_inverse(d: Derived) -> Exprs:
    u_dot, blocks = [rate(u) for u in d.speeds], d.blocks
    result = tuple(sub(x, f) for x, f in zip(d.mass_matrix @ u_dot, d.forcing, strict=True))
    if all(x is ZERO for x in blocks.coupling.entries):
        return result
    if any(x is not ZERO for x in d.constraints.a_auxiliary.entries):
        raise ArgumentError(
            "Expected loads without reactions, or reactions independent of constraint forces, for inverse dynamics of all speeds. "
            "Solve for what is unknown with kn.inverse(eom, unknowns=…)."
        )
    right = [sub(x, f) for x, f in zip(blocks.mass_a @ u_dot, blocks.forcing_a, strict=True)]
    values: dict[Expr, Expr] = dict(zip(d.reactions, solved_reactions(blocks.coupling_a, right), strict=True))
    return tuple(map(substituting(values), result))


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
        with suppress(Unsuited):
            found = tree(d)
            few = deforming(d.system.bodies) and len(d.speeds) < BENT
            return min((found, usual(d)), key=_price) if few else found
    return usual(d)


def _price(x: Matrix | Exprs) -> int:
    return price(x.entries if isinstance(x, Matrix) else x)


def centroidal_momentum_matrix(solved: Solved) -> Matrix:
    """A_G (6 × n): Σ m v, then the angular momentum about the mass centre, along the inertial frame, per unit of each speed."""
    d = solved.derived
    bodies, frame = d.bodies, d.system.inertial
    origin = bodies[0].part.mass_center
    p, about = linear_momentum(bodies), angular_momentum(bodies, origin, mass_center(bodies, origin))
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
        raise ArgumentError(f"Expected a point or a frame for the operational inertia, got {place!r}.")
    mass = mass_matrix(solved) if solved.embedding is None else solved.mass_matrix_nh
    factors = ldl(mass.rows, sparse_order(mass.rows))
    columns = [factors.forward([partials[u].dot(axis) for u in solved.independent_speeds]) for axis in axes]
    scaled = list(map(factors.over, columns))
    return Matrix([[dot(a, b) for b in scaled] for a in columns]).mirrored()


def operational_inertia(solved: Solved, place: Point | Frame, along: Sequence[Vector] | None) -> Matrix:
    """Λ = (J M⁻¹ Jᵀ)⁻¹: the force, or torque, along each axis per unit of acceleration along each."""
    mobility = operational_mobility(solved, place, along)
    n = mobility.shape[0]
    try:
        columns = solve_lu(mobility.rows, [[ONE if i == j else ZERO for i in range(n)] for j in range(n)])
    except SingularError as error:
        raise SingularError(
            f"Expected axes along which {place} can be accelerated independently, got {n} that are not independent. Give fewer, "
            "along=(…), or use operational_mobility, the inverse, which exists."
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
