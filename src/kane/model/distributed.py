# SPDX-License-Identifier: BSD-3-Clause
"""Distributed forces over a line, a rectangle or a disk, as forces at the points of a quadrature.

Resultant and moment are exact where the density is a polynomial of the `degree`: n points of Gauss and Legendre are exact to the
degree 2 n − 1, and a moment has one degree more than the force. The points belong to a body, `frame`, and move with it.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import cos, sin
from kane.expr.node import ZERO, Expr, as_expr, constant
from kane.model.directions import check_unit
from kane.model.joints.gears import length_along
from kane.model.loads import Load
from kane.numeric.legendre import gauss
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

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
    """Force per length along the line from `start` by `along`, both fixed in `frame`.

    Parameters
    ----------
    frame : of the body that carries the line
    start, along : the line
    density : force per length, N/m; a function of the share s of the line, from 0 to 1, where it changes along it
    degree : of the density in s
    """
    _check(frame, start, along)
    length = length_along(along)
    forces = [
        (start.fixed_in(frame, f"{name or start.name}.{k}", along * s), _density(density, s) * (length * w))
        for k, (s, w) in enumerate(_gauss(degree), 1)
    ]
    return Load(name or f"line load from {start.name}", tuple(forces))


def pressure_on_rectangle(
    frame: Frame,
    corner: Point,
    a: Vector,
    b: Vector,
    pressure: Any,
    *,
    degree: int = 1,
    name: str = "",
) -> Load:
    """Pressure p on a rectangle with edges a, b from a corner: −p n dA with n along a × b.

    Parameters
    ----------
    frame : of the body that carries the rectangle
    corner, a, b : the rectangle, a across b; the pressure acts on the side that a × b points away from
    pressure : N/m², or a function of the shares s, t along a and b
    degree : of the pressure in s and in t
    """
    for edge in (a, b):
        _check(frame, corner, edge)
    normal = a.cross(b)
    forces = []
    for i, (s, w) in enumerate(_gauss(degree), 1):
        for k, (t, h) in enumerate(_gauss(degree), 1):
            p = as_expr(pressure(s, t) if callable(pressure) else pressure)
            place = corner.fixed_in(frame, f"{name or corner.name}.{i}.{k}", a * s + b * t)
            forces.append((place, normal * (-p * (w * h))))
    return Load(name or f"pressure at {corner.name}", tuple(forces))


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
    """Pressure p on a disk: −p n dA.

    Parameters
    ----------
    frame : of the body that carries the disk
    center, normal, radius : the disk; the pressure acts against the unit vector `normal`
    pressure : N/m², or a function of the measure numbers x along `across` and y along normal × across
    degree : of the pressure in x and y
    across : unit vector in the disk; by default an axis of the frame
    """
    _check(frame, center, normal)
    check_unit(normal, "normal of the disk")
    x = across if across is not None else _across(frame, normal)
    check_unit(x, "direction across the normal")
    y, r = normal.cross(x), as_expr(radius)
    rule, turns = (
        list(_radial(degree)),
        degree + 2,
    )  # equidistant angles are exact for trigonometric polynomials of lower degree
    forces = []
    for i, (share, weight) in enumerate(rule, 1):
        for k in range(turns):
            angle = 2 * math.pi * (k + 0.5) / turns
            u, v = (r * share * f(constant(angle)) for f in (cos, sin))
            p = as_expr(pressure(u, v) if callable(pressure) else pressure)
            place = center.fixed_in(frame, f"{name or center.name}.{i}.{k + 1}", x * u + y * v)
            forces.append((place, normal * (-p * r * r * (weight * constant(2 * math.pi / turns)))))
    return Load(name or f"pressure at {center.name}", tuple(forces))


def _gauss(degree: int) -> Rule:
    """Shares and weights on 0…1; one point is exact."""
    count = _points(degree)
    if count == 1:
        return [(constant(1) / 2, constant(1))]
    return [(constant(x), constant(w)) for x, w in zip(*gauss(count), strict=True)]


def _radial(degree: int) -> Iterator[tuple[Expr, Expr]]:
    """Shares ρ of the radius and weights of ∫ f ρ dρ on 0…1."""
    for share, w in zip(*gauss(_points(degree) + 1), strict=True):
        yield constant(share), constant(w * share)


def _points(degree: Any) -> int:
    """How many points are exact for a density of this degree and its moment."""
    if isinstance(degree, bool) or not isinstance(degree, int) or not 0 <= degree <= 60:
        raise ModelError(f"Expected degree= of the density as a whole number from 0 to 60, got {cut(repr(degree))}.")
    return (degree + 1) // 2 + 1


def _density(density: Any, s: Expr) -> Vector:
    found = density(s) if callable(density) else density
    if not isinstance(found, Vector):
        raise ModelError(
            f"Expected a force per length as a Vector, or a function of such values, got {cut(repr(found))}. Write w*N.y."
        )
    return found


def _across(frame: Frame, normal: Vector) -> Vector:
    """An axis of the frame across the normal."""
    found = next((a for a in (frame.x, frame.y, frame.z) if normal.dot(a) is ZERO), None)
    if found is None:
        raise ModelError(
            f"Expected across=unit vector across the normal {normal}, got none, and no axis of {frame.name} is one."
        )
    return found


def _check(frame: Any, point: Any, vector: Any) -> None:
    if not isinstance(frame, Frame):
        raise ModelError(f"Expected the Frame of the body that carries the load, got {cut(repr(frame))}.")
    if not isinstance(point, Point):
        raise ModelError(f"Expected a Point of the body {frame.name}, got {cut(repr(point))}.")
    if not isinstance(vector, Vector):
        raise ModelError(
            f"Expected a Vector in the body {frame.name}, got {cut(repr(vector))}. Give it a direction: a*{frame.name}.x."
        )
