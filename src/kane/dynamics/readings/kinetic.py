# SPDX-License-Identifier: BSD-3-Clause
"""What the kinetic energy is made of, and the generalized inertia forces by it; power load by load.

    K = K₂ + K₁ + K₀, of degree 2, 1 and 0 in the speeds: with v = v̂ + v_t, v̂ = Σ v_r u_r, and ω likewise

        K₂ = ½ Σ m v̂·v̂ + ω̂·I·ω̂,    K₁ = Σ m v̂·v_t + ω̂·I·ω_t,    K₀ = ½ Σ m v_t·v_t + ω_t·I·ω_t

    G = ½ Σ m a·a + α·I·α + 2 α·(ω × I·ω),    F*_r = −∂G/∂u̇_r

    F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr

(Kane & Levinson 1985, sec. 5.5 and 5.6; Gibbs 1879.)
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from kane.dynamics.bodies import Moving
from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.lazy import LazyMapping
from kane.dynamics.readings.rate_forces import quasi_rates
from kane.dynamics.readings.values import without_rates
from kane.dynamics.terms import sum_of
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import gradient, time_derivative
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import rate
from kane.expr.visit import substituted
from kane.kinematics.motion import Motion, acceleration_form
from kane.model.bodies import parts_of
from kane.model.loads import Load
from kane.space.vector import Vector


class KineticParts(NamedTuple):
    """K = K₂ + K₁ + K₀, of degree 2, 1 and 0 in the speeds."""

    K2: Expr
    K1: Expr
    K0: Expr


def kinetic_energy_parts(bodies: Sequence[Moving], speeds: Sequence[Expr]) -> KineticParts:
    """K₂, K₁ and K₀."""
    twice, once, none = ZERO, ZERO, ZERO
    for b in bodies:
        own, rest, rotation = _by_speeds(b.center, speeds), b.center.rest, b.rotation
        for motion, mass in b.momenta:
            v = own if motion is b.center else _by_speeds(motion, speeds)
            twice = add(twice, mul(mass, own.dot(v)))
            once = add(once, mul(mass, rest.dot(v)))
            none = add(none, mul(mass, rest.dot(motion.rest)))
        if rotation is not None:
            turn, drift, times = _by_speeds(rotation.motion, speeds), rotation.motion.rest, rotation.inertia.times
            twice = add(twice, turn.dot(times(turn)))
            once = add(once, turn.dot(times(drift)))
            none = add(none, drift.dot(times(drift)))
    return KineticParts(twice / 2, once, none / 2)


def _by_speeds(motion: Motion, speeds: Sequence[Expr]) -> Vector:
    return sum((motion.partials[u] * u for u in speeds if u in motion.partials), start=Vector()).gathered()


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


def energy_in_rates(derived: Derived) -> Expr:
    """K in coordinates and their rates, straight from where bodies are declared to be; Euler parameters by theirs."""
    system, twice = derived.system, ZERO
    for part in parts_of(system.bodies):
        v = part.mass_center.velocity(system.inertial)
        for point, mass in part.momenta or ((part.mass_center, part.mass),):
            twice = add(twice, mul(mass, v.dot(point.velocity(system.inertial))))
        if part.frame is not None and part.inertia is not None:
            w = part.frame.angular_velocity(system.inertial)
            twice = add(twice, w.dot(part.inertia.dot(w)))
    return substituted(twice / 2, quasi_rates(derived))


def lagrange_terms(derived: Derived) -> Exprs:
    """d/dt ∂K/∂q̇_s − ∂K/∂q_s by coordinate, in q̇ and q̈."""
    k, q = energy_in_rates(derived), derived.system.coordinates
    momenta, slopes = gradient(k, tuple(map(rate, q))), gradient(k, q)
    return tuple(sub(time_derivative(p), s) for p, s in zip(momenta, slopes, strict=True))


def inertia_forces_by_energy(derived: Derived) -> Exprs:
    """F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr, in speeds and u̇."""
    terms = [without_rates(derived, e) for e in lagrange_terms(derived)]
    columns = zip(*(row[: len(derived.speeds)] for row in derived.W.rows), strict=True)
    return tuple(neg(dot(terms, column)) for column in columns)


def load_powers(derived: Derived, stands_for: Mapping[object, Load]) -> Mapping[Load, Expr]:
    """Σ F·v + Σ T·ω of each load."""
    return LazyMapping(
        derived.loads,
        lambda load: sum_of(motion.total.dot(vector) for _, vector, motion in derived.active_terms[load]),
        stands_for,
    )
