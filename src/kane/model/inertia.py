# SPDX-License-Identifier: BSD-3-Clause
"""Central inertia dyadics of the usual solids, and the parallel axis theorem (Kane & Levinson 1985, sec. 3.6, appendix)."""

from __future__ import annotations

from typing import Any

from kane.errors import ModelError
from kane.expr.node import ONE, ZERO, as_expr, constant, constant_value
from kane.space.frame import Frame
from kane.space.vector import Dyadic, Vector

_SLACK = 1e-12


def inertia(frame: Frame, Ixx: Any, Iyy: Any, Izz: Any, Ixy: Any = 0, Iyz: Any = 0, Izx: Any = 0) -> Dyadic:
    """Inertia dyadic Σ I_ij a_i a_j along the axes of `frame`; Ixy = −∫ x y dm is the measure number, not the product."""
    return Dyadic.of(frame, ((Ixx, Ixy, Izx), (Ixy, Iyy, Iyz), (Izx, Iyz, Izz)))


def _axial(frame: Frame, about: Any, across: Any, axis: Vector) -> Dyadic:
    """Inertia of a body of revolution: `about` its axis, `across` it."""
    direction = axis.components(frame)
    for i in range(3):
        if all(x is (ONE if k == i else ZERO) for k, x in enumerate(direction)):
            diagonal = [across, across, across]
            diagonal[i] = about
            return inertia(frame, *diagonal)
    square = axis.dot(axis)
    number = constant_value(square)
    if number is not None and abs(float(number) - 1) > _SLACK:
        raise ModelError(f"Expected a unit vector as axis, such as {frame.name}.z, got {axis}. Use axis.normalized().")
    unit = Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return unit * as_expr(across) + axis.outer(axis) * ((as_expr(about) - as_expr(across)) / square)


def _ratio(top: int, bottom: int) -> Any:
    return constant(top) / constant(bottom)


def thin_disk(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Dyadic:
    """Thin uniform disk: m R²/2 about its axis, m R²/4 across."""
    square = as_expr(mass) * radius * radius
    return _axial(frame, square / 2, square / 4, axis)


def ring(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Dyadic:
    """Thin uniform ring: m R² about its axis, m R²/2 across."""
    square = as_expr(mass) * radius * radius
    return _axial(frame, square, square / 2, axis)


def rod(frame: Frame, mass: Any, length: Any, axis: Vector) -> Dyadic:
    """Thin uniform rod: 0 about its axis, m L²/12 across."""
    return _axial(frame, 0, as_expr(mass) * length * length / 12, axis)


def solid_sphere(frame: Frame, mass: Any, radius: Any) -> Dyadic:
    """Uniform sphere: 2 m R²/5."""
    value = _ratio(2, 5) * as_expr(mass) * radius * radius
    return inertia(frame, value, value, value)


def spherical_shell(frame: Frame, mass: Any, radius: Any) -> Dyadic:
    """Thin uniform spherical shell: 2 m R²/3."""
    value = _ratio(2, 3) * as_expr(mass) * radius * radius
    return inertia(frame, value, value, value)


def solid_cylinder(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Uniform cylinder: m R²/2 about its axis, m (3 R² + h²)/12 across."""
    m, r, h = as_expr(mass), as_expr(radius), as_expr(height)
    return _axial(frame, m * r * r / 2, m * (3 * r * r + h * h) / 12, axis)


def cylindrical_shell(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Thin open cylinder: m R² about its axis, m (6 R² + h²)/12 across."""
    m, r, h = as_expr(mass), as_expr(radius), as_expr(height)
    return _axial(frame, m * r * r, m * (6 * r * r + h * h) / 12, axis)


def solid_cone(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Uniform cone about its mass centre (h/4 above the base): 3 m R²/10 about its axis, 3 m (4 R² + h²)/80 across."""
    m, r, h = as_expr(mass), as_expr(radius), as_expr(height)
    return _axial(frame, _ratio(3, 10) * m * r * r, _ratio(3, 80) * m * (4 * r * r + h * h), axis)


def box(frame: Frame, mass: Any, a: Any, b: Any, c: Any) -> Dyadic:
    """Uniform box with edges a, b, c along x, y, z: m (b² + c²)/12, …."""
    m = as_expr(mass) / 12
    a2, b2, c2 = (as_expr(x) * x for x in (a, b, c))
    return inertia(frame, m * (b2 + c2), m * (c2 + a2), m * (a2 + b2))


def parallel_axis(central: Dyadic, mass: Any, offset: Vector) -> Dyadic:
    """Inertia about another point: I + m (r² 1 − r r), `offset` r from that point to the mass centre, or back.

    Written along the frame of `offset`.
    """
    frames = [f for f, _ in offset.parts]
    if not frames:
        return central
    m, frame = as_expr(mass), frames[0]
    unit = Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return central + unit * (m * offset.dot(offset)) - offset.outer(offset) * m
