# SPDX-License-Identifier: BSD-3-Clause
"""Gravitation of bodies, gravity moment, buoyancy, drag, and distributed forces, as loads.

Two bodies whose mass centres are at R = R a from the first to the second attract each other, to second order in their dimensions, by
(MacCullagh; Kane, Likins & Levinson 1983, Spacecraft Dynamics, sec. 2.3 to 2.6)

    V = −G [m₁ m₂/R + m₁ (tr I₂ − 3 a·I₂·a)/(2 R³) + m₂ (tr I₁ − 3 a·I₁·a)/(2 R³)],
    F = −(G m₁ m₂/R²) a − (3 G m₁/(2 R⁴)) ((tr I₂ − 5 a·I₂·a) a + 2 I₂·a) − …,   T₂ = (3 G m₁/R³) a × I₂·a.

Distributed forces over a line, a rectangle or a disk are forces at quadrature points, which belong to a body with the frame `frame`.
Resultant and moment are exact if the density is a polynomial of the given `degree`: n Gauss–Legendre points are exact for degree
2 n − 1, and a moment has one degree more than the force.
"""

import math
from collections.abc import Callable
from functools import reduce
from typing import Any

from kane import expect
from kane.errors import ModelError
from kane.expr.build import add, cos, div, mul, sin, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr, constant
from kane.model.bodies import Body, Part
from kane.model.constraints import check_unit, is_unit
from kane.model.joints.gears import length_along
from kane.model.loads import Load
from kane.model.mass import parts_listed
from kane.numeric.polynomials import gauss
from kane.numeric.sampling import not_negative, positive
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


def gravitation(one: Body, other: Body, constant: Any, name: str = "") -> Load:
    """Gravitational attraction of two bodies, to second order in their dimensions over their distance (sec. 4.8).

    Parameters
    ----------
    one, other : particles or rigid bodies, far apart compared with their dimensions
    constant : G, 6.674e-11 m³/(kg s²)
    name : of the load

    Returns
    -------
    Load
        opposite forces at the mass centres and a torque on each rigid body, with their potential energy
    """
    (a,), (b,) = (_single(x) for x in (one, other))
    g, r = not_negative(constant, "a constant of gravitation"), b.mass_center.position(a.mass_center).gathered()
    if r.is_zero:
        raise ModelError(f"Expected two bodies apart from each other, got {a.name} and {b.name} at the same point.")
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
    label = expect.label(name) or f"gravitation of {a.name} and {b.name}"
    return Load(label, pulls, tuple(torques), potential if is_constant_in_time([g]) else None)


def gravity_moment(body: Body, direction: Vector, strength: Any, name: str = "") -> Load:
    """Moment of a distant particle's gravitation about a body's mass centre, 3 k a × I·a (sec. 4.8; Spacecraft Dynamics, sec. 2.6).

    Parameters
    ----------
    body : a rigid body
    direction : unit vector a from the particle to the body, or opposite
    strength : k = G m/R³, 1/s²: the square of the angular rate of a circular orbit
    """
    check_unit(direction, "direction of a gravity moment")
    (part,) = _single(body)
    if part.inertia is None or part.frame is None:
        raise ModelError(f"Expected an extended body for a gravity moment, got {part.name}, a particle: it has none.")
    torque = direction.cross(part.inertia.dot(direction)) * (
        3 * not_negative(strength, "a strength k = G m/R³ of the gravity moment")
    )
    return Load(expect.label(name) or f"gravity moment on {part.name}", torques=((part.frame, torque),))


def buoyancy(point: Point, density: Any, volume: Any, acceleration: Vector, name: str = "") -> Load:
    """Buoyancy −ρ V g at the centre of buoyancy, with its potential ρ V g·r.

    Parameters
    ----------
    point : the centre of buoyancy
    density, volume : of the displaced fluid, kg/m³ and m³
    acceleration : g of free fall, a vector fixed in the inertial frame: -g*N.z
    """
    _check_point(point, "centre of buoyancy")
    expect.instance(acceleration, Vector, "the acceleration of free fall as a Vector", "Give it a direction: -g*N.z.")
    lift = acceleration * (
        -(not_negative(density, "a density of the fluid") * not_negative(volume, "a volume displaced"))
    )
    root = point.root()
    steady = is_constant_in_time(lift.components(root.frame))
    potential = -lift.dot(point.position(root)) if steady else None
    return Load(expect.label(name) or f"buoyancy at {point.name}", ((point, lift),), potential=potential)


def linear_drag(point: Point, coefficient: Any, medium: Vector | None = None, name: str = "") -> Load:
    """Linear drag −c v on a point; v is its velocity relative to a medium at rest, or with the velocity `medium`."""
    return _drag(point, medium, name, lambda v: v * -not_negative(coefficient, "a coefficient of drag"))


def quadratic_drag(point: Point, coefficient: Any, medium: Vector | None = None, name: str = "") -> Load:
    """Quadratic drag −c |v| v on a point, c = ρ c_d A/2; v is relative to a medium at rest, or with the velocity `medium`."""
    return _drag(
        point, medium, name, lambda v: v * (-not_negative(coefficient, "a coefficient of drag") * v.magnitude())
    )


def _drag(point: Point, medium: Vector | None, name: str, law: Any) -> Load:
    _check_point(point, "point of drag")
    v = point.velocity(point.root().frame)
    if medium is not None:
        v = v - expect.instance(medium, Vector, "the velocity of the medium as a Vector", "Give it a direction: w*N.x.")
    return Load(expect.label(name) or f"drag at {point.name}", ((point, law(v)),))


def _single(body: Any) -> list[Part]:
    parts = parts_listed(body)
    cure = "kn.composite makes one of several that move as one."
    expect.that(len(parts) == 1, "one body", came=f"{len(parts)} parts", cure=cure)
    return parts


def _trace(part: Part) -> Expr:
    """tr I, zero for a particle."""
    dyads = part.inertia.dyads if part.inertia is not None else ()
    return reduce(add, (a.dot(b) for a, b in dyads), ZERO)


def _check_point(point: Any, what: str) -> None:
    expect.instance(point, Point, f"a Point as the {what}", "Make one with at(…), or take a body's mass_center.")


Rule = list[tuple[Expr, Expr]]


def line_load(
    frame: Frame,
    start: Point,
    along: Vector,
    density: Vector | Callable[[Expr], Vector],
    *,
    degree: int = 1,
    name: str = "",
) -> Load:
    """A force distributed along a straight line of a body.

    Parameters
    ----------
    frame : of the body, in which the line is fixed
    start, along : the first point of the line, and the vector to the last
    density : force per length, N/m; or a function of s, from 0 at the first to 1 at the last point, that returns it
    degree : of the polynomial `density` in s
    """
    _check(frame, start, along)
    length, forces = length_along(along), []
    for k, (s, w) in enumerate(_gauss(degree), 1):
        expected = "a force per length as a Vector, or a function of such values"
        force = expect.instance(density(s) if callable(density) else density, Vector, expected, "Write w*N.y.")
        forces.append(
            (start.fixed_in(frame, f"{expect.label(name) or start.name}.{k}", along * s), force * (length * w))
        )
    return Load(expect.label(name) or f"line load from {start.name}", tuple(forces))


def pressure_on_rectangle(
    frame: Frame, corner: Point, a: Vector, b: Vector, pressure: Any, *, degree: int = 1, name: str = ""
) -> Load:
    """Pressure p on a rectangle with edges a, b from a corner: forces −p n dA with n along a × b.

    Parameters
    ----------
    frame : of the body, in which the rectangle is fixed
    corner, a, b : a corner and the perpendicular vectors to its neighbours
    pressure : N/m²; or a function p(s, t), with s and t from 0 to 1 along a and b
    degree : of the polynomial `pressure` in s and in t
    """
    for edge in (a, b):
        _check(frame, corner, edge)
    normal = a.cross(b)
    forces = []
    for i, (s, w) in enumerate(_gauss(degree), 1):
        for k, (t, h) in enumerate(_gauss(degree), 1):
            p = as_expr(pressure(s, t) if callable(pressure) else pressure)
            place = corner.fixed_in(frame, f"{expect.label(name) or corner.name}.{i}.{k}", a * s + b * t)
            forces.append((place, normal * (-p * (w * h))))
    return Load(expect.label(name) or f"pressure at {corner.name}", tuple(forces))


def pressure_on_disk(
    frame: Frame,
    center: Point,
    normal: Vector,
    radius: Any,
    pressure: Any,
    *,
    degree: int = 1,
    across: Vector | None = None,
    name: str = "",
) -> Load:
    """Pressure p on a disk: forces −p n dA.

    Parameters
    ----------
    frame : of the body, in which the disk is fixed
    center, normal, radius : the disk; the pressure acts against the unit vector `normal`
    pressure : N/m²; or a function p(x, y) of the measure numbers (m) from the centre along `across` and along normal × across
    degree : of the polynomial `pressure` in x and y
    across : unit vector in the plane of the disk; by default an axis of the frame
    """
    _check(frame, center, normal)
    check_unit(normal, "normal of the disk")
    x = across if across is not None else _across(frame, normal)
    check_unit(x, "direction across the normal")
    expect.that(is_unit(normal.cross(x)), f"across= in the disk across its normal {normal}", x)
    y, r = normal.cross(x), positive(radius, "the radius of the disk under pressure")
    # ∫ f ρ dρ over the radius; equidistant angles are exact for trigonometric polynomials of lower degree
    rule, turns = [(constant(x), constant(w * x)) for x, w in zip(*gauss(_points(degree) + 1), strict=True)], degree + 2
    forces = []
    for i, (share, weight) in enumerate(rule, 1):
        for k in range(turns):
            angle = 2 * math.pi * (k + 0.5) / turns
            u, v = (r * share * f(constant(angle)) for f in (cos, sin))
            p = as_expr(pressure(u, v) if callable(pressure) else pressure)
            place = center.fixed_in(frame, f"{expect.label(name) or center.name}.{i}.{k + 1}", x * u + y * v)
            forces.append((place, normal * (-p * r * r * (weight * constant(2 * math.pi / turns)))))
    return Load(expect.label(name) or f"pressure at {center.name}", tuple(forces))


def _gauss(degree: int) -> Rule:
    """Gauss points and weights on [0, 1] for a density of this degree."""
    return [(constant(x), constant(w)) for x, w in zip(*gauss(_points(degree)), strict=True)]


def _points(degree: Any) -> int:
    """Number of Gauss points that are exact for a density of this degree and its moment."""
    count = expect.whole(degree, "degree= of the density as a whole number from 0 to 60", least=0, most=60)
    return (count + 1) // 2 + 1


def _across(frame: Frame, normal: Vector) -> Vector:
    """An axis of the frame perpendicular to the normal."""
    result = next((a for a in (frame.x, frame.y, frame.z) if normal.dot(a) is ZERO), None)
    if result is None:
        raise ModelError(
            f"Expected across=unit vector across the normal {normal}, got none, and no axis of {frame.name} is one."
        )
    return result


def _check(frame: Any, point: Any, vector: Any) -> None:
    expect.instance(frame, Frame, "the Frame of the body that carries the load")
    expect.instance(point, Point, f"a Point of the body {frame.name}")
    expect.instance(vector, Vector, f"a Vector in the body {frame.name}", f"Give it a direction: a*{frame.name}.x.")
