# SPDX-License-Identifier: BSD-3-Clause
"""Kinetic and potential energy, power, mass centre, momenta and impulses, inertia forces from the kinetic energy; integrals of motion.

    K = K₂ + K₁ + K₀, of degree 2, 1 and 0 in the speeds: with v = v̂ + v_t, v̂ = Σ v_r u_r, and ω likewise

        K₂ = ½ Σ m v̂·v̂ + ω̂·I·ω̂,    K₁ = Σ m v̂·v_t + ω̂·I·ω_t,    K₀ = ½ Σ m v_t·v_t + ω_t·I·ω_t

    G = ½ Σ m a·a + α·I·α + 2 α·(ω × I·ω),    F*_r = −∂G/∂u̇_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr

    p_r = Σ m v_r·v + ω_r·I·ω,    I_r = Σ v_r·∫F dt + ω_r·∫T dt

(Kane & Levinson 1985, sec. 5.5, 5.6 and 6.8; Gibbs 1879.) The conjugate momentum p_s = ∂K/∂q̇_s is constant if K and the forces do not
depend on q_s and no force acts along it (sec. 7.4).

Integrals are functions of q, u and t that every motion keeps (sec. 7.1, 7.2 and 7.4). Candidates are the energy, the Hamiltonian
K₂ − K₀ + V in the rates, momenta of cyclic coordinates, linear and angular momenta along the inertial axes, and single speeds. A
candidate is an integral if its rate vanishes beside its terms at several random states; one that is proportional to a preceding
integral is left out.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane import show
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import ConstantInertia, Moving
from kane.dynamics.formulation.recursive import WAYS
from kane.dynamics.in_rates import InRates
from kane.dynamics.inverse_dynamics import kinetic_energy_along_tree
from kane.dynamics.lazy import LazyMapping
from kane.dynamics.readings.contributions import by_rates, differs, measured, sample_points, states
from kane.dynamics.readings.potential import find_potential
from kane.dynamics.readings.quantities import time_derivative as derivative_along_motion
from kane.dynamics.readings.quantities import without_rates
from kane.dynamics.solved import Solved
from kane.errors import ArgumentError, PotentialError, cut
from kane.expr.build import add, mul, neg, sub, sum_of
from kane.expr.differentiation import diff, gradient
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr, Exprs
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, StateVariable, Time, input_of, rate
from kane.expr.visit import substituting
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.velocities import Motion, acceleration_form, velocity_form
from kane.model.declarations import frames_and_points, geometry
from kane.model.loads import Load
from kane.model.system import placed, total_mass
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL
from kane.show import html
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_LARGE = 16
"""Bodies from which on the kinetic energy is read along the tree."""


Reading = Callable[[Motion, ConstantInertia | None], Vector]
"""A vector read off the motion of a mass centre, or of a frame with an inertia."""


def _products(bodies: Iterable[Moving], left: Reading, right: Reading) -> Expr:
    """Σ m l·r + l·I·r over bodies, with the vectors l and r that `left` and `right` read from motions."""
    total = ZERO
    for b in bodies:
        own = left(b.center, None)
        for motion, mass in b.momenta:
            total = add(total, mul(mass, own.dot(right(motion, None))))
        if b.rotation is not None:
            turned, inertia = b.rotation.motion, b.rotation.inertia
            total = add(total, left(turned, inertia).dot(inertia.times(right(turned, inertia))))
    return total


def _along_inertia(inertia: ConstantInertia | None, v: Vector) -> Vector:
    return v.gathered() if inertia is None or inertia.uniform else v.express(inertia.frame)


def kinetic_energy(bodies: Sequence[Moving]) -> Expr:
    """½ Σ m v·v + ω·I·ω."""

    def total(motion: Motion, inertia: ConstantInertia | None) -> Vector:
        return motion.total if inertia is None else _along_inertia(inertia, motion.total)

    return _products(bodies, total, total) / 2


def whole_kinetic_energy(solved: Solved) -> Expr:
    """The kinetic energy of all bodies; of large trees from the velocities of their segments."""
    if solved.route in WAYS and solved.twin is None and len(solved.derived.inertias) >= _LARGE:
        try:
            return kinetic_energy_along_tree(solved.derived)
        except Unsuited:
            pass
    return solved.written([kinetic_energy(solved.regular.bodies)])[0]


def kinetic_energy_in_speeds(bodies: Sequence[Moving]) -> Expr:
    """½ Σ m v·v + ω·I·ω, with v = Σ v_r u_r + v_t and ω likewise."""

    def form(motion: Motion, inertia: ConstantInertia | None) -> Vector:
        return _along_inertia(inertia, velocity_form(motion))

    return _products(bodies, form, form) / 2


def potential_energy(loads: Iterable[Load]) -> Expr:
    """The sum of the potential energies of loads."""
    return sum_of(load.potential for load in loads if load.potential is not None)


def power(solved: Solved) -> Expr:
    """P with dE/dt = P.

    Loads with a potential are in E; where the potential depends on time, what it gains by that is added. Loads without one give
    Σ F·v + T·ω. Prescribed motions, through the parts v_t and ω_t of the velocities that no speed multiplies, give
    −Σ v_t·(F − m a) − Σ ω_t·(T − I·α − ω × I·ω) over all loads: what their reactions do. Constraints A u + b = 0 that move by
    themselves give −Σ λ b.
    """
    derived, total = solved.regular, ZERO
    still = _is_still(derived)
    for load in derived.loads:
        works = load.potential is None
        if load.potential is not None and depends_on_time(load.potential):
            works = True
            total = add(total, derivative_along_motion(derived, load.potential))
        for _, vector, motion in derived.active_terms[load] if works or not still else ():
            if works:
                total = add(total, motion.total.dot(vector))
            total = add(total, neg(motion.rest.dot(vector)))
    for b in () if still else derived.bodies:
        for motion, mass in b.momenta:
            total = add(total, b.center.rest.dot(acceleration_form(motion) * mass))
        if b.rotation is not None and not b.rotation.motion.rest.is_zero:
            torque = b.rotation.torque(acceleration_form(b.rotation.motion))
            total = add(total, b.rotation.motion.rest.dot(torque))
    rests = derived.constraints.b
    if any(b_k is not ZERO for b_k in rests):
        for b_k, force in zip(rests, solved.multipliers.values(), strict=True):
            total = sub(total, mul(force, b_k))
    return solved.written([total])[0]


def _is_still(derived: Derived) -> bool:
    """Whether nothing moves if all speeds are zero: there is no prescribed motion, and no u = Y q̇ + z with nonzero z."""
    system = derived.system
    own = free_symbols(geometry(system.frames, system.points))
    return all(z is ZERO for z in derived.kinematical.z) and not any(
        isinstance(s, Time) or input_of(s) is not None for s in own
    )


def depends_on_time(e: Expr) -> bool:
    """Whether an expression contains the time, an input or a further state."""
    return any(isinstance(s, Time | StateVariable) or input_of(s) is not None for s in free_symbols([e]))


def mass_center(bodies: Sequence[Moving], origin: Point) -> Vector:
    """Σ m r / Σ m from `origin`."""
    moment = sum((b.part.mass_center.position(origin) * b.part.mass for b in bodies), start=Vector())
    return moment / total_mass(b.part for b in bodies)


def linear_momentum(bodies: Sequence[Moving]) -> Vector:
    """Σ m v."""
    return sum((b.center.total * b.part.mass for b in bodies), start=Vector())


def angular_momentum(bodies: Sequence[Moving], about: Point, shift: Vector = Vector()) -> Vector:  # noqa: B008, vectors are frozen
    """Σ I·ω + r × m v about a point fixed in the inertial frame, or the place at a `shift` from it."""
    total = Vector()
    for b in bodies:
        arm = b.part.mass_center.position(about) - shift
        for motion, mass in b.momenta:
            total = total + arm.cross(motion.total * mass)
        if b.rotation is not None:
            total = total + b.rotation.inertia.times(b.rotation.motion.total)
    return total


class KineticParts(NamedTuple):
    """K = K₂ + K₁ + K₀, of degree 2, 1 and 0 in the speeds."""

    K2: Expr
    K1: Expr
    K0: Expr

    def _repr_html_(self) -> str | None:
        return html(self)


def kinetic_energy_parts(bodies: Sequence[Moving], speeds: Sequence[Expr]) -> KineticParts:
    """K₂, K₁ and K₀."""

    def own(motion: Motion, _: ConstantInertia | None) -> Vector:
        return sum((motion.partials[u] * u for u in speeds if u in motion.partials), start=Vector()).gathered()

    def rest(motion: Motion, _: ConstantInertia | None) -> Vector:
        return motion.rest

    return KineticParts(
        _products(bodies, own, own) / 2, _products(bodies, rest, own), _products(bodies, rest, rest) / 2
    )


def gibbs_function(bodies: Sequence[Moving]) -> Expr:
    """½ Σ m a·a + α·I·α + 2 α·(ω × I·ω), in u̇."""
    twice = ZERO
    for b in bodies:
        a, rotation = acceleration_form(b.center).gathered(), b.rotation
        for motion, mass in b.momenta:
            twice = add(twice, mul(mass, a.dot(a if motion is b.center else acceleration_form(motion).gathered())))
        if rotation is not None:
            alpha = acceleration_form(rotation.motion).gathered()
            torque = rotation.torque(alpha)
            twice = add(twice, alpha.dot(torque * 2 - rotation.inertia.times(alpha)))
    return twice / 2


def inertia_forces_by_energy(derived: Derived) -> Exprs:
    """F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr, in speeds and u̇."""
    s = InRates(derived)
    terms = without_rates(derived, s.lagrange_terms(s.declared_kinetic_energy))
    columns = zip(*(row[: len(derived.speeds)] for row in derived.W.rows), strict=True)
    return tuple(neg(dot(terms, column)) for column in columns)


def load_powers(derived: Derived, stands_for: Mapping[object, Load]) -> Mapping[Load, Expr]:
    """Σ F·v + Σ T·ω of each load."""
    return LazyMapping(
        derived.loads,
        lambda load: sum_of(motion.total.dot(vector) for _, vector, motion in derived.active_terms[load]),
        stands_for,
    )


Impulse = tuple[Point | Frame, Vector]


def generalized_momenta(bodies: Sequence[Moving], speeds: Sequence[Expr]) -> Exprs:
    """p_r = Σ m v_r·v + ω_r·I·ω, one a speed."""
    pairs: list[tuple[Motion, Vector]] = []
    for b in bodies:
        pairs.append((b.center, sum((motion.total * mass for motion, mass in b.momenta), start=Vector())))
        if b.rotation is not None:
            pairs.append((b.rotation.motion, b.rotation.inertia.times(b.rotation.motion.total)))
    return _projections(pairs, speeds)


def generalized_impulses(derived: Derived, impulses: Sequence[Any]) -> Exprs:
    """I_r = Σ v_r·J over points with impulses J, and Σ ω_r·L over frames with impulses of torques L."""
    given: object = impulses
    pairs: list[tuple[Motion, Vector]] = []
    for item in given if isinstance(given, Sequence) else (given,):
        place, vector = item if isinstance(item, tuple) and len(item) == 2 else (None, None)
        if not (isinstance(place, Point | Frame) and isinstance(vector, Vector)):
            raise ArgumentError(f"Expected (point, impulse) or (frame, impulse of a torque), got {cut(repr(item))}.")
        frames_and_points(derived.system.inertial, (), (placed([place]),), ())  # which refuses those of other trees
        pairs.append((derived.kinematics.of(place), vector))
    return _projections(pairs, derived.speeds)


def _projections(pairs: Iterable[tuple[Motion, Vector]], speeds: Sequence[Expr]) -> Exprs:
    """Σ v_r·F for each speed, over pairs of a motion with partial velocities v_r and a vector F."""
    found: dict[Expr, Expr] = dict.fromkeys(speeds, ZERO)
    for motion, vector in pairs:
        for u, v in motion.partials.items():
            if u in found:
                found[u] = add(found[u], v.dot(vector))
    return tuple(found.values())


def conjugate_momenta(derived: Derived) -> Exprs:
    """p_s = ∂K/∂q̇_s, one a coordinate, in speeds."""
    q_dot = tuple(map(rate, derived.system.coordinates))
    return tuple(without_rates(derived, gradient(InRates(derived).declared_kinetic_energy, q_dot)))


def central_angular_momentum(bodies: Sequence[Moving]) -> Vector:
    """Σ I·ω + r × m v about the mass centre, r from there."""
    origin = bodies[0].part.mass_center
    return angular_momentum(bodies, origin) - mass_center(bodies, origin).cross(linear_momentum(bodies))


def cyclic_coordinates(derived: Derived) -> tuple[Coordinate, ...]:
    """Coordinates on which K, forces and constraints do not depend, and along which no force or constraint force acts."""
    q = derived.system.coordinates
    turned = {e for s in derived.system.euler_parameters for e in s.coordinates}
    k, rows = InRates(derived).declared_kinetic_energy, InRates(derived).rows
    forces = by_rates(derived, derived.system.all_loads())
    found = []
    for i, s in enumerate(q):
        held = [forces[i], *(row[i] for row in rows)]
        at = sample_points([k, *held])
        if s not in turned and not differs([[e] for e in (diff(k, s), *held)], at)[1].any():
            found.append(s)
    return tuple(found)


_STATES, _LEAST = 8, 2


@dataclass(frozen=True, slots=True, eq=False)
class Integral(Immutable):
    """An integral of the equations of motion: a function of the state that is constant in every motion.

    Attributes
    ----------
    name : such as "energy", "momentum of q1", "angular momentum about O along N.z"
    value : the function, in coordinates, speeds and parameters
    why : the reason why it is constant, as text
    """

    name: str
    value: Expr
    why: str

    _repr_latex_ = show.latex

    def __repr__(self) -> str:
        return f"Integral({self.name!r}: {cut(self.value)})"


def integrals(solved: Solved) -> tuple[Integral, ...]:
    """See Equations.integrals."""
    found: list[Integral] = []
    kept: list[Array] = []
    for one in _proposed(solved):
        numbers = _values_if_constant(solved, one.value)
        if numbers is not None and not any(_same(numbers, other) for other in kept):
            found.append(one)
            kept.append(numbers)
    return tuple(found)


def _values_if_constant(solved: Solved, value: Expr) -> Array | None:
    """The values of a function at random states, with one set of parameters, if it is an integral; else None."""
    if is_constant_in_time([value]):
        return None
    derived = solved.derived
    (plain,) = without_rates(derived, [value])
    by: dict[Expr, Expr] = {
        u: x for u, x in zip(derived.speeds, solved.speeds_by_independent, strict=True) if u is not x
    }
    *terms, own = map(substituting(by), (*_rate_terms(solved, plain), plain))
    values, moved = differs([terms, [own]], states(derived, [*terms, own]))
    finite = np.isfinite(values).all(axis=1)
    if finite.sum() < _LEAST or moved[finite, 0].any() or not moved[finite, 1].any():
        return None
    return np.asarray(measured([own], states(derived, [own], varied=False))[:, 0])


def _rate_terms(solved: Solved, value: Expr) -> list[Expr]:
    """The terms of dc/dt: ∂c/∂q q̇, ∂c/∂u u̇, and those of the time and of inputs."""
    derived = solved.derived
    moves: dict[Expr, Expr] = dict(zip(derived.system.coordinates, solved.written(derived.rates), strict=True))
    moves.update(zip(derived.speeds, solved.accelerations, strict=True))
    moves.update(zip(derived.states, solved.state_rates, strict=True))
    result = [ZERO]
    for s in free_symbols([value]):
        if isinstance(s, Time):
            result.append(diff(value, s))
        elif s in moves:
            result.append(mul(diff(value, s), moves[s]))
        elif input_of(s) is not None:
            result.append(mul(diff(value, s), rate(s)))
    return result


def _same(a: Array, b: Array) -> bool:
    """Whether two functions are proportional at all states at which both are finite."""
    both = np.isfinite(a) & np.isfinite(b)
    x, y = a[both], b[both]
    scale = np.linalg.norm(x) * np.linalg.norm(y)
    return bool(abs(abs(x @ y) - scale) <= EQUAL * scale) and len(x) > 1


# Candidates of integrals -------------------------------------------------------------------------------------------------


def _proposed(solved: Solved) -> Iterator[Integral]:
    derived = solved.derived.as_declared
    yield from _energies(solved, derived)
    for q, p in zip(derived.system.coordinates, conjugate_momenta(derived), strict=True):
        yield Integral(f"momentum of {q}", p, f"{q} is cyclic: neither K nor a force depends on it or acts along it")
    yield from _momenta(derived)
    for u in derived.speeds:
        yield Integral(f"speed {u}", u, "its equation is u' = 0")


def _energies(solved: Solved, derived: Derived) -> Iterator[Integral]:
    v, found = potential_energy(derived.loads), []
    for load in derived.system.all_loads():
        if load.potential is None:
            try:
                v = add(v, find_potential(derived, [load]).value)
                found.append(load.name)
            except PotentialError:
                continue
    said = f", those of {', '.join(found)} found" if found else ""
    total = add(whole_kinetic_energy(solved), v)
    yield Integral(
        "energy", total, f"K + V: all loads that do work have a potential energy{said}, and no motion is prescribed"
    )
    k, q_dot = InRates(derived).declared_kinetic_energy, tuple(map(rate, derived.system.coordinates))
    twice = sum_of(mul(r, p) for r, p in zip(q_dot, gradient(k, q_dot), strict=True))
    hamiltonian = add(without_rates(derived, [sub(twice, k)])[0], v)
    yield Integral(
        "Hamiltonian",
        hamiltonian,
        f"K₂ − K₀ + V by the rates: all forces have a potential energy{said}, and L does not depend on time",
    )


def _momenta(derived: Derived) -> Iterator[Integral]:
    bodies, frame = derived.bodies, derived.system.inertial
    root = bodies[0].part.mass_center.root()
    vectors = (
        ("linear momentum", linear_momentum(bodies), "no external force acts along it"),
        (f"angular momentum about {root.name}", angular_momentum(bodies, root), "no external moment acts about it"),
        (
            "central angular momentum",
            central_angular_momentum(bodies),
            "no external moment about the mass centre acts about it",
        ),
    )
    for name, vector, why in vectors:
        for axis, x in zip("xyz", vector.components(frame), strict=True):
            yield Integral(f"{name} along {frame.name}.{axis}", x, why)
