# SPDX-License-Identifier: BSD-3-Clause
"""Central inertia dyadics of plates, arcs, and solids of fewer symmetries (Kane & Levinson 1985, sec. 3.7, appendix).

Where the mass centre is no obvious place, `inertia.shape.centroid` leads to it from the place that the function names.
"""

from collections.abc import Sequence
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.build import add, cos, div, mul, sin, sub
from kane.expr.node import ONE, ZERO, Expr, as_expr, pi
from kane.model.directions import check_unit, is_unit
from kane.model.inertia import Inertia, Shape, axial, check_frame, inertia, parallel_axis
from kane.space.frame import Frame
from kane.space.vector import Dyadic, Vector, axes


def ellipsoid(frame: Frame, mass: Any, a: Any, b: Any, c: Any) -> Inertia:
    """Uniform ellipsoid with semi-axes a, b, c along x, y, z: m (b² + c²)/5, …."""
    m, sizes = as_expr(mass) / 5, {k: as_expr(x) for k, x in zip("abc", (a, b, c), strict=True)}
    a2, b2, c2 = (x * x for x in sizes.values())
    dyadic = inertia(frame, m * (b2 + c2), m * (c2 + a2), m * (a2 + b2))
    return Inertia(dyadic, Shape("ellipsoid", sizes, None, frame))


def torus(frame: Frame, mass: Any, radius: Any, tube: Any, axis: Vector) -> Inertia:
    """Solid torus with the radius R of its centre line and r of its tube: m (R² + 3 r²/4) about its axis, m (R²/2 + 5 r²/8) across."""
    m, big, small = as_expr(mass), as_expr(radius), as_expr(tube)
    about = m * (big * big + 3 * small * small / 4)
    across = m * (big * big / 2 + 5 * small * small / 8)
    dyadic = axial(frame, about, across, axis)
    return Inertia(dyadic, Shape("torus", {"radius": big, "tube": small}, axis, frame))


def frustum(frame: Frame, mass: Any, base: Any, top: Any, height: Any, axis: Vector) -> Inertia:
    """Uniform frustum of a cone, with the radii of its base and of its top, which `axis` points to.

    With D = R² + R r + r²: 3 m (R⁴ + R³ r + R² r² + R r³ + r⁴)/(10 D) about its axis; the mass centre is
    h (R² + 2 R r + 3 r²)/(4 D) above the base.
    """
    m, big, small, h = (as_expr(x) for x in (mass, base, top, height))
    d = big * big + big * small + small * small
    fourth = big**4 + big**3 * small + big**2 * small**2 + big * small**3 + small**4
    rise = h * (big * big + 2 * big * small + 3 * small * small) / (4 * d)
    about = 3 * m * fourth / (10 * d)
    squared = h * h * (big * big + 3 * big * small + 6 * small * small) / (10 * d)
    across = about / 2 + m * (squared - rise * rise)
    dyadic = axial(frame, about, across, axis)
    return Inertia(dyadic, Shape("frustum", {"base": big, "top": small, "height": h}, axis, frame, axis * rise))


def half_cylinder(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector, towards: Vector) -> Inertia:
    """Uniform half cylinder, the round side `towards`, a unit vector across the axis.

    The mass centre is 4 R/(3 π) from the middle of the flat side.
    """
    m, r, h = as_expr(mass), as_expr(radius), as_expr(height)
    shift = 4 * r / (3 * pi)
    plain = m * (3 * r * r + h * h) / 12
    off = m * shift * shift
    moments = (m * r * r / 2 - off, plain, plain - off)
    dyadic = _along(frame, _crossed(frame, axis, towards), moments)
    return Inertia(dyadic, Shape("half cylinder", {"radius": r, "height": h}, axis, frame, towards * shift))


def hemisphere(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Inertia:
    """Uniform half of a sphere, the round side towards `axis`: 2 m R²/5 about it, 83 m R²/320 across.

    The mass centre is 3 R/8 from the middle of the flat side.
    """
    m, r = as_expr(mass), as_expr(radius)
    square = m * r * r
    across = 83 * square / 320
    dyadic = axial(frame, 2 * square / 5, across, axis)
    return Inertia(dyadic, Shape("hemisphere", {"radius": r}, axis, frame, axis * (3 * r / 8)))


def rectangular_plate(frame: Frame, mass: Any, a: Any, b: Any) -> Inertia:
    """Thin uniform plate with edges a, b along x, y: m b²/12, m a²/12, m (a² + b²)/12."""
    m, a, b = as_expr(mass) / 12, as_expr(a), as_expr(b)
    dyadic = inertia(frame, m * b * b, m * a * a, m * (a * a + b * b))
    return Inertia(dyadic, Shape("rectangular plate", {"a": a, "b": b}, None, frame))


def right_triangle(frame: Frame, mass: Any, a: Any, b: Any) -> Inertia:
    """Thin uniform right triangle with legs a, b from the right angle along x, y: m b²/18, m a²/18, Ixy = m a b/36.

    The mass centre is a/3, b/3 from the right angle.
    """
    m, a, b = as_expr(mass), as_expr(a), as_expr(b)
    x, y, _ = axes(frame)
    dyadic = inertia(frame, m * b * b / 18, m * a * a / 18, m * (a * a + b * b) / 18, Ixy=m * a * b / 36)
    return Inertia(dyadic, Shape("right triangle", {"a": a, "b": b}, None, frame, x * (a / 3) + y * (b / 3)))


def triangular_plate(frame: Frame, mass: Any, p: Vector, q: Vector) -> Inertia:
    """Thin uniform triangle with the vectors p and q from one corner to the others.

    The mass centre is (p + q)/3 from that corner; the inertia is that of m/12 at each corner, seen from there.
    """
    check_frame(frame)
    if not all(isinstance(v, Vector) for v in (p, q)):
        raise ModelError(
            f"Expected the other corners of a triangle as two Vectors from the first, got {cut(repr(p))}, {cut(repr(q))}. Give "
            "them directions: a*B.x, b*B.y."
        )
    third = as_expr(mass) / 12
    center = (p + q) / 3
    total = Dyadic()
    for corner in (Vector(), p, q):
        total = total + parallel_axis(Dyadic(), third, (corner - center).express(frame))
    return Inertia(total.express(frame), Shape("triangular plate", {}, None, frame, center))


def circular_sector(frame: Frame, mass: Any, radius: Any, half_angle: Any, normal: Vector, towards: Vector) -> Inertia:
    """Thin uniform sector of a disk, `half_angle` α to either side of `towards`, a unit vector across the normal.

    The mass centre is 2 R sin α/(3 α) from the tip; α = π/2 makes half a disk.
    """
    return _round(frame, "circular sector", mass, radius, half_angle, (normal, towards), solid=True)


def circular_arc(frame: Frame, mass: Any, radius: Any, half_angle: Any, normal: Vector, towards: Vector) -> Inertia:
    """Thin uniform arc, `half_angle` α to either side of `towards`, a unit vector across the normal.

    The mass centre is R sin α/α from the centre of the circle.
    """
    return _round(frame, "circular arc", mass, radius, half_angle, (normal, towards), solid=False)


def _round(
    frame: Frame, kind: str, mass: Any, radius: Any, half_angle: Any, directions: tuple[Vector, Vector], solid: bool
) -> Inertia:
    """Sector or arc: ∫ x² and ∫ y² about the centre are ½ ∫ r² (1 ± sin 2α/(2α))."""
    m, r, alpha = as_expr(mass), as_expr(radius), as_expr(half_angle)
    normal, towards = directions
    polar = m * r * r / 2 if solid else m * r * r
    shift = div(mul(r, sin(alpha)), alpha)
    if solid:
        shift = 2 * shift / 3
    lean = div(mul(sin(alpha), cos(alpha)), alpha)
    along, across = polar / 2 * add(ONE, lean), polar / 2 * sub(ONE, lean)
    off = m * shift * shift
    dyadic = _along(frame, _crossed(frame, normal, towards), (polar - off, across, along - off))
    return Inertia(dyadic, Shape(kind, {"radius": r, "half_angle": alpha}, normal, frame, towards * shift))


def _crossed(frame: Frame, axis: Vector, towards: Vector) -> tuple[Vector, Vector, Vector]:
    """Axis, `towards` and the unit vector across both."""
    check_frame(frame)
    check_unit(axis, "axis of the solid")
    check_unit(towards, "direction of its round side")
    third = axis.cross(towards)
    if not is_unit(third):
        raise ModelError(
            f"Expected the round side of the solid across its axis {axis}, got {towards}. Take a unit vector across it."
        )
    return axis, towards, third


def _along(frame: Frame, directions: Sequence[Vector], moments: tuple[Expr, Expr, Expr]) -> Dyadic:
    """Σ I_k n_k n_k along the axes of `frame`."""
    entries = [[ZERO] * 3 for _ in range(3)]
    for moment, n in zip(moments, (v.components(frame) for v in directions), strict=True):
        for i in range(3):
            for j in range(3):
                entries[i][j] = add(entries[i][j], mul(moment, mul(n[i], n[j])))
    return Dyadic.of(frame, entries)
