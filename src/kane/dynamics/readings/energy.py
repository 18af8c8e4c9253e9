# SPDX-License-Identifier: BSD-3-Clause
"""Energies, power, mass centre and momenta."""

from collections.abc import Iterable, Sequence

from kane.dynamics.bodies import Moving, Turning
from kane.dynamics.derivation import Derived
from kane.dynamics.inverse_dynamics import kinetic_energy_along_tree
from kane.dynamics.readings.values import time_derivative
from kane.dynamics.routes.recursive import WAYS
from kane.dynamics.solved import Solved
from kane.dynamics.terms import sum_of
from kane.expr.build import add, mul, neg, sub
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import State, Time, input_of
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.motion import acceleration_form, velocity_form
from kane.model.loads import Load
from kane.model.survey import geometry
from kane.model.system import total_mass
from kane.space.point import Point
from kane.space.vector import Vector

_LARGE = 16
"""Bodies from which on the kinetic energy is read along the tree."""


def kinetic_energy(bodies: Sequence[Moving]) -> Expr:
    """½ Σ m v·v + ω·I·ω."""
    twice = ZERO
    for b in bodies:
        for motion, mass in b.momenta:
            twice = add(twice, mul(mass, b.center.total.dot(motion.total)))
        if b.rotation is not None:
            w = _along_inertia(b.rotation, b.rotation.motion.total)
            twice = add(twice, w.dot(b.rotation.inertia.times(w)))
    return twice / 2


def whole_kinetic_energy(solved: Solved) -> Expr:
    """That of all bodies; of large trees that recursions solve from the velocities of their segments."""
    if solved.route in WAYS and solved.twin is None and len(solved.derived.inertias) >= _LARGE:
        try:
            return kinetic_energy_along_tree(solved.derived)
        except Unsuited:
            pass
    return solved.written([kinetic_energy(solved.regular.bodies)])[0]


def kinetic_energy_in_speeds(bodies: Sequence[Moving]) -> Expr:
    """½ Σ m v·v + ω·I·ω, with v = Σ v_r u_r + v_t and ω likewise."""
    twice = ZERO
    for b in bodies:
        v = velocity_form(b.center).gathered()
        for motion, mass in b.momenta:
            twice = add(twice, mul(mass, v.dot(v if motion is b.center else velocity_form(motion).gathered())))
        if b.rotation is not None:
            w = _along_inertia(b.rotation, velocity_form(b.rotation.motion))
            twice = add(twice, w.dot(b.rotation.inertia.times(w)))
    return twice / 2


def _along_inertia(rotation: Turning, w: Vector) -> Vector:
    return w.gathered() if rotation.inertia.uniform else w.express(rotation.inertia.frame)


def potential_energy(loads: Iterable[Load]) -> Expr:
    """The sum of the loads' potentials."""
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
            total = add(total, time_derivative(derived, load.potential))
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
    """Whether nothing moves where all speeds are zero: no motion is prescribed, and no speed counts from another."""
    system = derived.system
    own = free_symbols(geometry(system.frames, system.points))
    return all(z is ZERO for z in derived.kinematical.z) and not any(
        isinstance(s, Time) or input_of(s) is not None for s in own
    )


def depends_on_time(e: Expr) -> bool:
    """Whether the time, an input or a further state is in an expression."""
    return any(isinstance(s, Time | State) or input_of(s) is not None for s in free_symbols([e]))


def mass_center(bodies: Sequence[Moving], origin: Point) -> Vector:
    """Σ m r / Σ m from `origin`."""
    moment = sum((b.part.mass_center.position(origin) * b.part.mass for b in bodies), start=Vector())
    return moment / total_mass(b.part for b in bodies)


def linear_momentum(bodies: Sequence[Moving]) -> Vector:
    """Σ m v."""
    return sum((b.center.total * b.part.mass for b in bodies), start=Vector())


def angular_momentum(bodies: Sequence[Moving], about: Point) -> Vector:
    """Σ I·ω + r × m v about a point fixed in the inertial frame."""
    total = Vector()
    for b in bodies:
        for motion, mass in b.momenta:
            total = total + b.part.mass_center.position(about).cross(motion.total * mass)
        if b.rotation is not None:
            total = total + b.rotation.inertia.times(b.rotation.motion.total)
    return total
