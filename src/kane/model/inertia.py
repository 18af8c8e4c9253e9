# SPDX-License-Identifier: BSD-3-Clause
"""Central inertia dyadics of the usual solids, and the parallel axis theorem (Kane & Levinson 1985, sec. 3.6, appendix)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from kane.errors import ModelError, cut
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant, constant_value
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.frame import Frame
from kane.space.vector import Dyadic, Vector


def check_frame(frame: object) -> None:
    """A ModelError unless it is a frame, along whose axes an inertia is written."""
    if not isinstance(frame, Frame):
        raise ModelError(
            f"Expected the Frame of the body, along whose axes its inertia is written, got {cut(repr(frame))}."
        )


def inertia(frame: Frame, Ixx: Any, Iyy: Any, Izz: Any, Ixy: Any = 0, Iyz: Any = 0, Izx: Any = 0) -> Dyadic:
    """Inertia dyadic Σ I_ij a_i a_j along the axes of `frame`; Ixy = −∫ x y dm is the measure number, not the product."""
    check_frame(frame)
    return Dyadic.of(frame, ((Ixx, Ixy, Izx), (Ixy, Iyy, Iyz), (Izx, Iyz, Izz)))


def axial(frame: Frame, about: Any, across: Any, axis: Vector) -> Dyadic:
    """Inertia of a body of revolution: `about` its axis, `across` it."""
    check_frame(frame)
    if not isinstance(axis, Vector):
        raise ModelError(f"Expected an axis of the body as a unit vector, such as B.x, got {cut(repr(axis))}.")
    direction = axis.components(frame)
    for i in range(3):
        if all(x is (ONE if k == i else ZERO) for k, x in enumerate(direction)):
            diagonal = [across, across, across]
            diagonal[i] = about
            return inertia(frame, *diagonal)
    square = axis.dot(axis)
    number = constant_value(square)
    if number is not None and abs(float(number) - 1) > ROUNDED_CHAIN:
        raise ModelError(f"Expected a unit vector as axis, such as {frame.name}.z, got {axis}. Use axis.normalized().")
    unit = Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return unit * as_expr(across) + axis.outer(axis) * ((as_expr(about) - as_expr(across)) / square)


class Shape(NamedTuple):
    """What a solid looks like: a kind, its dimensions (m), the axis of a body of revolution, and the frame that it is fixed in.

    `centroid` leads from the place that the solid's function names (a corner, the middle of a base) to the mass centre.
    """

    kind: str
    sizes: Mapping[str, Expr]
    axis: Vector | None
    frame: Frame
    centroid: Vector = Vector()


class Inertia(Dyadic):
    """The inertia of a solid, which remembers its shape; sums and products of it are plain dyadics."""

    __slots__ = ("shape",)
    shape: Shape

    def __init__(self, dyadic: Dyadic, shape: Shape) -> None:
        super().__init__(dyadic.dyads)
        object.__setattr__(self, "shape", shape)

    def __reduce__(self) -> tuple[Callable[..., Inertia], tuple[Any, ...]]:
        return Inertia, (Dyadic(self.dyads), self.shape)


def _ratio(top: int, bottom: int) -> Expr:
    return constant(top) / constant(bottom)


_REVOLVED: dict[str, Callable[..., tuple[Any, Any]]] = {
    "thin disk": lambda m, r: (m * r * r / 2, m * r * r / 4),
    "ring": lambda m, r: (m * r * r, m * r * r / 2),
    "rod": lambda m, l: (0, m * l * l / 12),
    "solid sphere": lambda m, r: (_ratio(2, 5) * m * r * r,) * 2,
    "spherical shell": lambda m, r: (_ratio(2, 3) * m * r * r,) * 2,
    "solid cylinder": lambda m, r, h: (m * r * r / 2, m * (3 * r * r + h * h) / 12),
    "cylindrical shell": lambda m, r, h: (m * r * r, m * (6 * r * r + h * h) / 12),
    "solid cone": lambda m, r, h: (_ratio(3, 10) * m * r * r, _ratio(3, 80) * m * (4 * r * r + h * h)),
}
"""Moments about and across the axis of bodies of revolution, from the mass and the dimensions."""


def _revolved(kind: str, frame: Frame, mass: Any, axis: Vector | None, **sizes: Any) -> Inertia:
    """A body of revolution; a sphere has no axis."""
    dimensions = {name: as_expr(size) for name, size in sizes.items()}
    about, across = _REVOLVED[kind](as_expr(mass), *dimensions.values())
    dyadic = inertia(frame, about, about, about) if axis is None else axial(frame, about, across, axis)
    return Inertia(dyadic, Shape(kind, dimensions, axis, frame))


def thin_disk(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Dyadic:
    """Thin uniform disk: m R²/2 about its axis, m R²/4 across."""
    return _revolved("thin disk", frame, mass, axis, radius=radius)


def ring(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Dyadic:
    """Thin uniform ring: m R² about its axis, m R²/2 across."""
    return _revolved("ring", frame, mass, axis, radius=radius)


def rod(frame: Frame, mass: Any, length: Any, axis: Vector) -> Dyadic:
    """Thin uniform rod: 0 about its axis, m L²/12 across."""
    return _revolved("rod", frame, mass, axis, length=length)


def solid_sphere(frame: Frame, mass: Any, radius: Any) -> Dyadic:
    """Uniform sphere: 2 m R²/5."""
    return _revolved("solid sphere", frame, mass, None, radius=radius)


def spherical_shell(frame: Frame, mass: Any, radius: Any) -> Dyadic:
    """Thin uniform spherical shell: 2 m R²/3."""
    return _revolved("spherical shell", frame, mass, None, radius=radius)


def solid_cylinder(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Uniform cylinder: m R²/2 about its axis, m (3 R² + h²)/12 across."""
    return _revolved("solid cylinder", frame, mass, axis, radius=radius, height=height)


def cylindrical_shell(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Thin open cylinder: m R² about its axis, m (6 R² + h²)/12 across."""
    return _revolved("cylindrical shell", frame, mass, axis, radius=radius, height=height)


def solid_cone(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector) -> Dyadic:
    """Uniform cone about its mass centre (h/4 above the base): 3 m R²/10 about its axis, 3 m (4 R² + h²)/80 across.

    `shape.centroid` leads from the middle of the base to the mass centre, with the apex along `axis`.
    """
    made = _revolved("solid cone", frame, mass, axis, radius=radius, height=height)
    return Inertia(made, made.shape._replace(centroid=axis * (as_expr(height) / 4)))


def box(frame: Frame, mass: Any, a: Any, b: Any, c: Any) -> Dyadic:
    """Uniform box with edges a, b, c along x, y, z: m (b² + c²)/12, …."""
    m, edges = as_expr(mass) / 12, {name: as_expr(x) for name, x in zip("abc", (a, b, c), strict=True)}
    a2, b2, c2 = (x * x for x in edges.values())
    return Inertia(inertia(frame, m * (b2 + c2), m * (c2 + a2), m * (a2 + b2)), Shape("box", edges, None, frame))


def central_inertia(about: Dyadic, mass: Any, offset: Vector) -> Dyadic:
    """Central inertia from that about another point: I − m (r² 1 − r r), `offset` r from that point to the mass centre, or back.

    Kane & Levinson 1985, sec. 3.6.
    """
    return parallel_axis(about, -as_expr(mass), offset)


def parallel_axis(central: Dyadic, mass: Any, offset: Vector) -> Dyadic:
    """Inertia about another point: I + m (r² 1 − r r), `offset` r from that point to the mass centre, or back.

    Written along the frame of `offset`; `central_inertia` is the way back. Kane & Levinson 1985, sec. 3.6.
    """
    if not isinstance(offset, Vector):
        raise ModelError(
            f"Expected the offset of the mass centre as a Vector, got {cut(repr(offset))}. Give it a direction: x*B.x."
        )
    frames = [f for f, _ in offset.parts]
    if not frames:
        return central
    m, frame = as_expr(mass), frames[0]
    unit = Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return central + unit * (m * offset.dot(offset)) - offset.outer(offset) * m
