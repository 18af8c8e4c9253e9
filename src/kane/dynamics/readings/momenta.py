# SPDX-License-Identifier: BSD-3-Clause
"""Generalized momenta and impulses, momenta of the rates, central angular momentum, cyclic coordinates.

p_r = Σ m v_r·v + ω_r·I·ω,    I_r = Σ v_r·∫F dt + ω_r·∫T dt        (Kane & Levinson 1985, sec. 6.8)

p_s = ∂K/∂q̇_s, constant where neither K nor a force depends on q_s or acts along it        (sec. 7.4)
"""

from collections.abc import Sequence
from typing import Any

from kane.dynamics.bodies import Moving
from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.readings.energy import linear_momentum
from kane.dynamics.readings.kinetic import energy_in_rates
from kane.dynamics.readings.rate_forces import by_rates, differs, places, rows_in_rates
from kane.dynamics.readings.values import without_rates
from kane.errors import ArgumentError, cut
from kane.expr.build import add
from kane.expr.differentiation import diff, gradient
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, rate
from kane.model.system import total_mass
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Impulse = tuple[Point | Frame, Vector]


def generalized_momenta(bodies: Sequence[Moving], speeds: Sequence[Expr]) -> Exprs:
    """p_r = Σ m v_r·v + ω_r·I·ω, one a speed."""
    found: dict[Expr, Expr] = dict.fromkeys(speeds, ZERO)
    for b in bodies:
        momentum = sum((motion.total * mass for motion, mass in b.momenta), start=Vector())
        for u, v in b.center.partials.items():
            if u in found:
                found[u] = add(found[u], v.dot(momentum))
        rotation = b.rotation
        if rotation is None:
            continue
        h = rotation.inertia.times(rotation.motion.total)
        for u, w in rotation.motion.partials.items():
            if u in found:
                found[u] = add(found[u], w.dot(h))
    return tuple(found.values())


def generalized_impulses(derived: Derived, impulses: Sequence[Any], speeds: Sequence[Expr]) -> Exprs:
    """I_r = Σ v_r·J over points with impulses J, and Σ ω_r·L over frames with impulses of torques L."""
    found: dict[Expr, Expr] = dict.fromkeys(speeds, ZERO)
    given: object = impulses
    for item in given if isinstance(given, Sequence) else (given,):
        if not (isinstance(item, tuple) and len(item) == 2 and isinstance(item[1], Vector)):
            raise ArgumentError(f"Expected (point, impulse) or (frame, impulse of a torque), got {cut(repr(item))}.")
        place, vector = item
        kinematics = derived.kinematics
        motion = kinematics.point(place) if isinstance(place, Point) else kinematics.frame(place)
        for u, v in motion.partials.items():
            if u in found:
                found[u] = add(found[u], v.dot(vector))
    return tuple(found.values())


def conjugate_momenta(derived: Derived) -> Exprs:
    """p_s = ∂K/∂q̇_s, one a coordinate, in speeds."""
    q_dot = tuple(map(rate, derived.system.coordinates))
    return tuple(without_rates(derived, p) for p in gradient(energy_in_rates(derived), q_dot))


def central_angular_momentum(bodies: Sequence[Moving]) -> Vector:
    """Σ I·ω + r × m v about the mass centre, r from there."""
    total, origin = Vector(), bodies[0].part.mass_center
    moment = sum((b.part.mass_center.position(origin) * b.part.mass for b in bodies), start=Vector())
    center, drift = moment / total_mass(b.part for b in bodies), linear_momentum(bodies)
    for b in bodies:
        if b.rotation is not None:
            total = total + b.rotation.inertia.times(b.rotation.motion.total)
        for motion, mass in b.momenta:
            total = total + b.part.mass_center.position(origin).cross(motion.total * mass)
    return total - center.cross(drift)


def cyclic_coordinates(derived: Derived) -> tuple[Coordinate, ...]:
    """Coordinates on which neither K depends nor forces and constraints, and along which no force acts and no constraint holds."""
    q = derived.system.coordinates
    turned = {e for s in derived.system.euler_parameters for e in s.coordinates}
    k = energy_in_rates(derived)
    forces = by_rates(derived, derived.system.all_loads())
    rows = rows_in_rates(derived)
    found = []
    for i, s in enumerate(q):
        held = [forces[i], *(row[i] for row in rows)]
        at = places([k, *held])
        if s not in turned and not differs([[e] for e in (diff(k, s), *held)], at)[1].any():
            found.append(s)
    return tuple(found)
