# SPDX-License-Identifier: BSD-3-Clause
"""Gravitation of bodies, its moment, buoyancy and drag, as loads.

Two bodies at the vector R = R a from the mass centre of the one to that of the other attract each other, to second order in their
sizes, by (MacCullagh; Kane, Likins & Levinson 1983, Spacecraft Dynamics, sec. 2.3 to 2.6)

    V = −G [m₁ m₂/R + m₁ (tr I₂ − 3 a·I₂·a)/(2 R³) + m₂ (tr I₁ − 3 a·I₁·a)/(2 R³)],

    F = −(G m₁ m₂/R²) a − (3 G m₁/(2 R⁴)) ((tr I₂ − 5 a·I₂·a) a + 2 I₂·a) − …,   T₂ = (3 G m₁/R³) a × I₂·a.
"""

from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import add, div, mul, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.model.bodies import Body, Part
from kane.model.directions import check_unit
from kane.model.loads import Load
from kane.model.mass import parts_listed
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def gravitation(one: Body, other: Body, constant: Any, name: str = "") -> Load:
    """Gravitational attraction of two bodies, particles or extended, to second order in their sizes (sec. 4.8).

    Parameters
    ----------
    one, other : bodies of one part, far apart beside their sizes
    constant : G, 6.674e-11 m³/(kg s²)
    name : what the load is called

    Returns
    -------
    Load
        with its potential: force and opposite force at the mass centres, and on extended bodies a torque
    """
    (a,), (b,) = (_single(x) for x in (one, other))
    g, r = as_expr(constant), b.mass_center.position(a.mass_center).gathered()
    if r.is_zero:
        raise ModelError(f"Expected two bodies apart from each other, got {a.name} and {b.name} at one place.")
    square = r.dot(r)
    cube = square * r.magnitude()
    force = r * (-(g * a.mass * b.mass) / cube)
    potential = -(g * a.mass * b.mass) / r.magnitude()
    torques: list[tuple[Frame, Vector]] = []
    for part, mass in ((a, b.mass), (b, a.mass)):
        if part.inertia is None or part.frame is None:
            continue
        seen = part.inertia.dot(r)
        spread = sub(_trace(part), div(mul(as_expr(3), r.dot(seen)), square))
        strength = g * mass / cube
        potential = sub(potential, strength * spread / 2)
        far = sub(_trace(part), div(mul(as_expr(5), r.dot(seen)), square))
        force = force - (r * far + seen * 2) * (3 * strength / (2 * square))
        torques.append((part.frame, r.cross(seen) * (3 * strength / square)))
    pulls = ((b.mass_center, force), (a.mass_center, -force))
    label = name or f"gravitation of {a.name} and {b.name}"
    return Load(label, pulls, tuple(torques), potential if is_constant_in_time([g]) else None)


def gravity_moment(body: Body, direction: Vector, strength: Any, name: str = "") -> Load:
    """Moment of a distant particle's gravitation about the mass centre, 3 k a × I·a (sec. 4.8; Spacecraft Dynamics, sec. 2.6).

    Parameters
    ----------
    body : extended
    direction : unit vector a from the particle to the body, or back
    strength : k = G m/R³, the square of the rate of a circular orbit, 1/s²
    """
    check_unit(direction, "direction of a gravity moment")
    (part,) = _single(body)
    if part.inertia is None or part.frame is None:
        raise ModelError(f"Expected an extended body for a gravity moment, got {part.name}, a particle: it has none.")
    torque = direction.cross(part.inertia.dot(direction)) * (3 * as_expr(strength))
    return Load(name or f"gravity moment on {part.name}", torques=((part.frame, torque),))


def buoyancy(point: Point, density: Any, volume: Any, acceleration: Vector, name: str = "") -> Load:
    """Buoyancy −ρ V g at the centre of buoyancy of what is displaced, with its potential ρ V g·r.

    Parameters
    ----------
    point : the centre of buoyancy
    density, volume : of the displaced fluid
    acceleration : of free fall, a vector that does not move: -g*N.z
    """
    _check_point(point, "centre of buoyancy")
    if not isinstance(acceleration, Vector):
        raise ModelError(
            f"Expected the acceleration of free fall as a Vector, got {cut(repr(acceleration))}. Give it a direction: -g*N.z."
        )
    lift = acceleration * (-(as_expr(density) * as_expr(volume)))
    root = point.root()
    steady = is_constant_in_time(lift.components(root.frame))
    potential = -lift.dot(point.position(root)) if steady else None
    return Load(name or f"buoyancy at {point.name}", ((point, lift),), potential=potential)


def linear_drag(point: Point, coefficient: Any, medium: Vector | None = None, name: str = "") -> Load:
    """Drag −c v of a point in a medium that rests, or moves at the velocity `medium`."""
    return _drag(point, medium, name, lambda v: v * -as_expr(coefficient))


def quadratic_drag(point: Point, coefficient: Any, medium: Vector | None = None, name: str = "") -> Load:
    """Drag −c |v| v of a point in a medium that rests, or moves at the velocity `medium`; c is ρ c_d A/2."""
    return _drag(point, medium, name, lambda v: v * (-as_expr(coefficient) * v.magnitude()))


def _drag(point: Point, medium: Vector | None, name: str, law: Any) -> Load:
    _check_point(point, "place of drag")
    if medium is not None and not isinstance(medium, Vector):
        raise ModelError(
            f"Expected the velocity of the medium as a Vector, got {cut(repr(medium))}. Give it a direction: w*N.x."
        )
    v = point.velocity(point.root().frame)
    return Load(name or f"drag at {point.name}", ((point, law(v if medium is None else v - medium)),))


def _single(body: Any) -> list[Part]:
    parts = parts_listed(body)
    if len(parts) != 1:
        raise ModelError(
            f"Expected one body, got {len(parts)} parts. kn.composite makes one of several that move as one."
        )
    return parts


def _trace(part: Part) -> Expr:
    """tr I, the same along any axes."""
    total = ZERO
    for a, b in part.inertia.dyads if part.inertia is not None else ():
        total = add(total, a.dot(b))
    return total


def _check_point(point: Any, what: str) -> None:
    if not isinstance(point, Point):
        raise ModelError(
            f"Expected a Point as the {what}, got {cut(repr(point))}. Make one with at(…), or take a body's mass_center."
        )
