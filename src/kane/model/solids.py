# SPDX-License-Identifier: BSD-3-Clause
"""Central inertia dyadics of uniform solids, plates and wires, and the parallel axis theorem (Kane & Levinson 1985, ch. 3, appendix).

The moments of each solid are a row of a table. For solids without an obvious mass centre, `inertia.shape.centroid` is its position.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from kane import expect
from kane.errors import ModelError
from kane.expr.build import add, cos, div, mul, sin, sub
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant, constant_value, pi
from kane.model.constraints import check_unit, is_unit, length
from kane.numeric.sampling import SIGN, not_negative, positive
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.frame import Frame
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, Vector, axes


def check_frame(frame: object) -> None:
    """Raise ModelError unless the argument is a frame."""
    expect.instance(frame, Frame, "the Frame of the body, along whose axes its inertia is written")


def inertia(frame: Frame, Ixx: Any, Iyy: Any, Izz: Any, Ixy: Any = 0, Iyz: Any = 0, Izx: Any = 0) -> Dyadic:
    """Inertia dyadic Σ I_ij a_i a_j along the axes of `frame`; Ixy = −∫ x y dm is the measure number, not the product."""
    check_frame(frame)
    return Dyadic.of(frame, ((Ixx, Ixy, Izx), (Ixy, Iyy, Iyz), (Izx, Iyz, Izz)))


def unit_dyadic(frame: Basis) -> Dyadic:
    """The unit dyadic, along the axes of a frame."""
    return Dyadic.of(frame, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def axial(frame: Frame, about: Any, across: Any, axis: Vector | None) -> Dyadic:
    """Inertia of a body of revolution, with moments `about` and `across` its axis, which must be an axis of the frame."""
    check_frame(frame)
    axis = expect.instance(axis, Vector, "an axis of the body as a unit vector, such as B.x")
    direction = axis.components(frame)
    for i in range(3):
        if all(x is (ONE if k == i else ZERO) for k, x in enumerate(direction)):
            return inertia(frame, *(about if k == i else across for k in range(3)))
    square = axis.dot(axis)
    number = constant_value(square)
    if number is not None and abs(float(number) - 1) > ROUNDED_CHAIN:
        raise ModelError(f"Expected a unit vector as axis, such as {frame.name}.z, got {axis}. Use axis.normalized().")
    outer = axis.outer(axis) * ((as_expr(about) - as_expr(across)) / square)
    return unit_dyadic(frame) * as_expr(across) + outer


class Shape(NamedTuple):
    """The shape of a solid: a kind, its dimensions (m), the axis of a body of revolution, and the frame in which it is fixed.

    `centroid` is the position of the mass centre from the reference point of the solid: a corner, the middle of a base.
    """

    kind: str
    sizes: Mapping[str, Expr]
    axis: Vector | None
    frame: Frame
    centroid: Vector = Vector()


class Inertia(Dyadic):
    """The inertia of a solid together with its shape; sums and products are plain dyadics."""

    __slots__ = ("shape",)
    shape: Shape

    def __init__(self, dyadic: Dyadic, shape: Shape) -> None:
        super().__init__(dyadic.dyads)
        object.__setattr__(self, "shape", shape)

    def __reduce__(self) -> "tuple[Callable[..., Inertia], tuple[Any, ...]]":
        return Inertia, (Dyadic(self.dyads), self.shape)


def central_inertia(about: Dyadic, mass: Any, offset: Vector) -> Dyadic:
    """Central inertia from that about another point: I − m (r² 1 − r r), `offset` r from that point to the mass centre, or back.

    Kane & Levinson 1985, sec. 3.6.
    """
    return parallel_axis(about, -as_expr(mass), offset)


def parallel_axis(central: Dyadic, mass: Any, offset: Vector) -> Dyadic:
    """Inertia about another point: I + m (r² 1 − r r), `offset` r from that point to the mass centre, or back.

    Written along the frame of `offset`; `central_inertia` is the way back. Kane & Levinson 1985, sec. 3.6.
    """
    expect.instance(offset, Vector, "the offset of the mass centre as a Vector", "Give it a direction: x*B.x.")
    frames = [f for f, _ in offset.parts]
    if not frames:
        return central
    m = as_expr(mass)
    return central + unit_dyadic(frames[0]) * (m * offset.dot(offset)) - offset.outer(offset) * m


class Limit(NamedTuple):
    """A quantity of a solid, named `what`, that is not negative, or above zero."""

    value: Expr
    above: bool
    what: str
    cure: str = SIGN


def limits(kind: str, sizes: Mapping[str, Expr]) -> Iterator[Limit]:
    """What the dimensions of a solid must satisfy; those of zero make its flat, thin or point limit, where moments have one."""
    for name, x in sizes.items():
        what = f"dimension {name}" if len(name) == 1 else name.replace("_", " ")
        yield Limit(x, name == "half_angle", f"the {what} of the {kind}")
    if kind == "frustum":
        yield Limit(
            add(sizes["base"], sizes["top"]), True, "the sum of the radii of the frustum", "A thin one is a rod."
        )
    if kind == "torus":
        rest = sub(sizes["radius"], sizes["tube"])
        yield Limit(rest, False, "the radius of the torus less that of its tube", "Its tube would overlap itself.")
    if "half_angle" in sizes:
        yield Limit(sub(pi, sizes["half_angle"]), False, f"π less the half angle of the {kind}", "Give it in rad.")


def _sizes(kind: str, mass: Any, **sizes: Any) -> tuple[Expr, dict[str, Expr]]:
    """The mass of a solid and its dimensions; raises ModelError for those that no solid has, at default parameters."""
    m = not_negative(mass, f"a mass of the {kind}", "For a hole, use kn.solids.composite(…, without=[…]).")
    lengths = {name: as_expr(x) for name, x in sizes.items()}
    for value, above, what, cure in limits(kind, lengths):
        (positive if above else not_negative)(value, what, cure)
    return m, lengths


# Bodies of revolution -----------------------------------------------------------------------------------------------


def _frustum(m: Expr, big: Expr, small: Expr, h: Expr) -> tuple[Expr, Expr, Expr]:
    d = big * big + big * small + small * small
    fourth = big**4 + big**3 * small + big**2 * small**2 + big * small**3 + small**4
    rise = h * (big * big + 2 * big * small + 3 * small * small) / (4 * d)
    about = 3 * m * fourth / (10 * d)
    squared = h * h * (big * big + 3 * big * small + 6 * small * small) / (10 * d)
    return about, about / 2 + m * (squared - rise * rise), rise


_REVOLVED: dict[str, Callable[..., tuple[Any, ...]]] = {
    "thin disk": lambda m, r: (m * r * r / 2, m * r * r / 4),
    "ring": lambda m, r: (m * r * r, m * r * r / 2),
    "rod": lambda m, l: (0, m * l * l / 12),
    "solid sphere": lambda m, r: (constant(2) / 5 * m * r * r,) * 2,
    "spherical shell": lambda m, r: (constant(2) / 3 * m * r * r,) * 2,
    "solid cylinder": lambda m, r, h: (m * r * r / 2, m * (3 * r * r + h * h) / 12),
    "cylindrical shell": lambda m, r, h: (m * r * r, m * (6 * r * r + h * h) / 12),
    "solid cone": lambda m, r, h: (constant(3) / 10 * m * r * r, constant(3) / 80 * m * (4 * r * r + h * h), h / 4),
    "torus": lambda m, R, r: (m * (R * R + 3 * r * r / 4), m * (R * R / 2 + 5 * r * r / 8)),
    "frustum": _frustum,
    "hemisphere": lambda m, r: (2 * (m * r * r) / 5, 83 * (m * r * r) / 320, 3 * r / 8),
}
"""Moments about and across the axis, and the position of the mass centre along it, from the mass and the dimensions."""


def _revolved(kind: str, frame: Frame, mass: Any, axis: Vector | None, **sizes: Any) -> Inertia:
    """The inertia of a body of revolution; a sphere has no axis."""
    m, dimensions = _sizes(kind, mass, **sizes)
    about, across, *rise = _REVOLVED[kind](m, *dimensions.values())
    if axis is None and about is across:
        return Inertia(inertia(frame, about, about, about), Shape(kind, dimensions, None, frame))
    dyadic = axial(frame, about, across, axis)
    return Inertia(dyadic, Shape(kind, dimensions, axis, frame, axis * rise[0] if rise else Vector()))


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
    return _revolved("solid cone", frame, mass, axis, radius=radius, height=height)


def torus(frame: Frame, mass: Any, radius: Any, tube: Any, axis: Vector) -> Inertia:
    """Solid torus with the radius R of its centre line and r of its tube: m (R² + 3 r²/4) about its axis, m (R²/2 + 5 r²/8) across."""
    return _revolved("torus", frame, mass, axis, radius=radius, tube=tube)


def frustum(frame: Frame, mass: Any, base: Any, top: Any, height: Any, axis: Vector) -> Inertia:
    """Uniform frustum of a cone, with the radii of its base and of its top, which `axis` points to.

    With D = R² + R r + r²: 3 m (R⁴ + R³ r + R² r² + R r³ + r⁴)/(10 D) about its axis; the mass centre is
    h (R² + 2 R r + 3 r²)/(4 D) above the base.
    """
    return _revolved("frustum", frame, mass, axis, base=base, top=top, height=height)


def hemisphere(frame: Frame, mass: Any, radius: Any, axis: Vector) -> Inertia:
    """Uniform half of a sphere, the round side towards `axis`: 2 m R²/5 about it, 83 m R²/320 across.

    The mass centre is 3 R/8 from the middle of the flat side.
    """
    return _revolved("hemisphere", frame, mass, axis, radius=radius)


# Along the axes of the frame -----------------------------------------------------------------------------------------


def _cuboid(kind: str, frame: Frame, mass: Any, divisor: int, **sizes: Any) -> Inertia:
    """Inertia with moments m (b² + c²)/d, …, where `divisor` is d."""
    m, lengths = _sizes(kind, mass, **sizes)
    share = m / divisor
    a2, b2, c2 = (x * x for x in lengths.values())
    dyadic = inertia(frame, share * (b2 + c2), share * (c2 + a2), share * (a2 + b2))
    return Inertia(dyadic, Shape(kind, lengths, None, frame))


def box(frame: Frame, mass: Any, a: Any, b: Any, c: Any) -> Dyadic:
    """Uniform box with edges a, b, c along x, y, z: m (b² + c²)/12, …."""
    return _cuboid("box", frame, mass, 12, a=a, b=b, c=c)


def ellipsoid(frame: Frame, mass: Any, a: Any, b: Any, c: Any) -> Inertia:
    """Uniform ellipsoid with semi-axes a, b, c along x, y, z: m (b² + c²)/5, …."""
    return _cuboid("ellipsoid", frame, mass, 5, a=a, b=b, c=c)


def rectangular_plate(frame: Frame, mass: Any, a: Any, b: Any) -> Inertia:
    """Thin uniform plate with edges a, b along x, y: m b²/12, m a²/12, m (a² + b²)/12."""
    m, edges = _sizes("rectangular plate", mass, a=a, b=b)
    m, a, b = m / 12, *edges.values()
    dyadic = inertia(frame, m * b * b, m * a * a, m * (a * a + b * b))
    return Inertia(dyadic, Shape("rectangular plate", edges, None, frame))


def right_triangle(frame: Frame, mass: Any, a: Any, b: Any) -> Inertia:
    """Thin uniform right triangle with legs a, b from the right angle along x, y: m b²/18, m a²/18, Ixy = m a b/36.

    The mass centre is a/3, b/3 from the right angle.
    """
    m, legs = _sizes("right triangle", mass, a=a, b=b)
    a, b = legs.values()
    x, y, _ = axes(frame)
    dyadic = inertia(frame, m * b * b / 18, m * a * a / 18, m * (a * a + b * b) / 18, Ixy=m * a * b / 36)
    return Inertia(dyadic, Shape("right triangle", legs, None, frame, x * (a / 3) + y * (b / 3)))


def triangular_plate(frame: Frame, mass: Any, p: Vector, q: Vector) -> Inertia:
    """Thin uniform triangle with the vectors p and q from one corner to the others.

    The mass centre is (p + q)/3 from that corner; the inertia is that of m/12 at each corner, seen from there.
    """
    check_frame(frame)
    for v in (p, q):
        cure = "Give them directions: a*B.x, b*B.y."
        expect.instance(v, Vector, "the other corners of a triangle as two Vectors from the first", cure)
    third = _sizes("triangular plate", mass)[0] / 12
    corner = length(p.cross(q)) > ROUNDED_CHAIN * length(p) * length(q)
    expect.that(corner, "two edges of a triangle in different directions", came=f"{p} and {q}")
    center = (p + q) / 3
    corners = (parallel_axis(Dyadic(), third, (v - center).express(frame)) for v in (Vector(), p, q))
    total = sum(corners, start=Dyadic())
    return Inertia(total.express(frame), Shape("triangular plate", {}, None, frame, center))


# Half cylinders, sectors and arcs ------------------------------------------------------------------------------------


def half_cylinder(frame: Frame, mass: Any, radius: Any, height: Any, axis: Vector, towards: Vector) -> Inertia:
    """Uniform half cylinder, the round side `towards`, a unit vector across the axis.

    The mass centre is 4 R/(3 π) from the middle of the flat side.
    """
    m, sizes = _sizes("half cylinder", mass, radius=radius, height=height)
    r, h = sizes.values()
    shift = 4 * r / (3 * pi)
    plain, off = m * (3 * r * r + h * h) / 12, m * shift * shift
    dyadic = _along(frame, axis, towards, (m * r * r / 2 - off, plain, plain - off))
    return Inertia(dyadic, Shape("half cylinder", sizes, axis, frame, towards * shift))


def circular_sector(frame: Frame, mass: Any, radius: Any, half_angle: Any, normal: Vector, towards: Vector) -> Inertia:
    """Thin uniform sector of a disk, `half_angle` α to either side of `towards`, a unit vector across the normal.

    The mass centre is 2 R sin α/(3 α) from the tip; α = π/2 makes half a disk.
    """
    return _round("circular sector", frame, mass, radius, half_angle, normal, towards)


def circular_arc(frame: Frame, mass: Any, radius: Any, half_angle: Any, normal: Vector, towards: Vector) -> Inertia:
    """Thin uniform arc, `half_angle` α to either side of `towards`, a unit vector across the normal.

    The mass centre is R sin α/α from the centre of the circle.
    """
    return _round("circular arc", frame, mass, radius, half_angle, normal, towards)


def _round(kind: str, frame: Frame, mass: Any, radius: Any, half: Any, normal: Vector, towards: Vector) -> Inertia:
    """Sector or arc: ∫ x² and ∫ y² about the centre are ½ ∫ r² (1 ± sin 2α/(2α))."""
    m, sizes = _sizes(kind, mass, radius=radius, half_angle=half)
    r, alpha = sizes.values()
    polar, shift = m * r * r, div(mul(r, sin(alpha)), alpha)
    if kind == "circular sector":
        polar, shift = polar / 2, 2 * shift / 3
    lean = div(mul(sin(alpha), cos(alpha)), alpha)
    along, across = polar / 2 * add(ONE, lean), polar / 2 * sub(ONE, lean)
    off = m * shift * shift
    dyadic = _along(frame, normal, towards, (polar - off, across, along - off))
    return Inertia(dyadic, Shape(kind, sizes, normal, frame, towards * shift))


def _along(frame: Frame, axis: Vector, towards: Vector, moments: Sequence[Expr]) -> Dyadic:
    """Σ I_k n_k n_k along the axes of `frame`, with n_k the axis, `towards` and the unit vector across both."""
    check_frame(frame)
    check_unit(axis, "axis of the solid")
    check_unit(towards, "direction of its round side")
    third = axis.cross(towards)
    expected = f"the round side of the solid across its axis {axis}"
    expect.that(is_unit(third), expected, towards, "Take a unit vector across it.")
    entries = [[ZERO] * 3 for _ in range(3)]
    for moment, n in zip(moments, (v.components(frame) for v in (axis, towards, third)), strict=True):
        for i in range(3):
            for j in range(3):
                entries[i][j] = add(entries[i][j], mul(moment, mul(n[i], n[j])))
    return Dyadic.of(frame, entries)
