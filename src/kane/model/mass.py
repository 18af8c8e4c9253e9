# SPDX-License-Identifier: BSD-3-Clause
"""Mass centres and inertias of points, bodies and sets of them, about any point; principal moments, axes and planes.

    I_a = Σ m p × (n_a × p),   I_ab = I_a · n_b,   I^{S/O} = Σ I^{B/B*} + m (p² 1 − p p)

with p from the point O to the mass centres (Kane & Levinson 1985, ch. 3). Principal moments and axes, I·n = I_n n and
I = Σ I_k n_k n_k, are numerical for a matrix of numbers, and symbolic if an axis of the frame is a principal axis.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from kane import expect, show
from kane.errors import ModelError, cut
from kane.expr.build import add, cos, div, mul, sin, sub
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.forms.collect import collected
from kane.expr.matrix import Matrix
from kane.expr.node import TWO, ZERO, Expr, as_expr, constant, constant_value, pi
from kane.expr.operators import atan2, sqrt
from kane.expr.ops import Immutable
from kane.expr.symbols import Parameter
from kane.model.bodies import Body, Part, RigidBody, parts_of
from kane.model.constraints import check_unit
from kane.model.solids import parallel_axis, unit_dyadic
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


def mass_center(bodies: Any, origin: Point) -> Vector:
    """Position of the mass centre of bodies from `origin`: Σ m p / Σ m (Kane & Levinson 1985, sec. 3.1).

    Parameters
    ----------
    bodies : a body, or a list of bodies
    origin : the point from which the position is measured

    Raises
    ------
    ModelError
        if `bodies` contains other objects than bodies, or the total mass is zero
    """
    parts = parts_listed(bodies)
    _check_point(origin, "seen from")
    mass = _mass(parts)
    moment = sum((p.mass_center.position(origin) * p.mass for p in parts), start=Vector())
    return (moment / mass).map(collected)


def inertia_about(bodies: Any, point: Point) -> Dyadic:
    """Inertia dyadic of bodies about a point, each term written in the body's frame (Kane & Levinson 1985, sec. 3.5, 3.6).

    Parameters
    ----------
    bodies : a body, or a list of bodies
    point : the point, which need not belong to a body
    """
    parts = parts_listed(bodies)
    _check_point(point, "about which an inertia is asked for")
    whole = sum((_about(part, point) for part in parts), start=Dyadic())
    frames = [f for f in whole.frames() if isinstance(f, Frame)]
    return _along(frames[0], whole) if len(frames) == 1 else whole


def inertia_matrix(bodies: Any, point: Point, frame: Frame) -> Matrix:
    """Inertia matrix of bodies about a point: I_jk = n_j·I·n_k for the axes of `frame` (Kane & Levinson 1985, sec. 3.5)."""
    return inertia_about(bodies, point).components(frame)


def inertia_vector(bodies: Any, point: Point, direction: Vector) -> Vector:
    """Inertia vector I_a = Σ m p × (n_a × p) of bodies about a point for a unit vector n_a (Kane & Levinson 1985, sec. 3.3)."""
    check_unit(direction, "direction of an inertia vector")
    return inertia_about(bodies, point).dot(direction)


def moment_of_inertia(bodies: Any, point: Point, direction: Vector) -> Expr:
    """Moment of inertia n·I·n of bodies about the line through a point along a unit vector (Kane & Levinson 1985, sec. 3.3)."""
    return inertia_vector(bodies, point, direction).dot(direction)


def product_of_inertia(bodies: Any, point: Point, a: Vector, b: Vector) -> Expr:
    """Product of inertia n_a·I·n_b = Σ m (p × n_a)·(p × n_b), which is −Σ m x y for perpendicular unit vectors.

    Kane & Levinson 1985, sec. 3.3.
    """
    check_unit(b, "second direction of a product of inertia")
    return inertia_vector(bodies, point, a).dot(b)


def radius_of_gyration(bodies: Any, point: Point, direction: Vector) -> Expr:
    """Radius of gyration √(n·I·n / Σ m) about the line through a point along a unit vector (Kane & Levinson 1985, sec. 3.3)."""
    return sqrt(collected(moment_of_inertia(bodies, point, direction) / _mass(parts_listed(bodies))))


def composite(name: str, bodies: Any, frame: Frame, *, without: Any = ()) -> RigidBody:
    """The rigid body composed of bodies that are fixed to each other (Kane & Levinson 1985, sec. 3.1, 3.6).

    Parameters
    ----------
    name : of the new body
    bodies : a body, or a list of bodies
    frame : the frame in which all of them are fixed
    without : bodies whose mass and inertia are subtracted: holes

    Raises
    ------
    ModelError
        if a body moves in `frame`, or the remaining mass is zero
    """
    kept = parts_listed(bodies)
    expected, came = f"rigid bodies and particles for the composite {name}", "a flexible body: it deforms"
    expect.that(not any(p.momenta for p in kept), expected, came=came)
    holes = [p._replace(mass=-p.mass, inertia=None if p.inertia is None else -p.inertia) for p in parts_listed(without)]
    parts = [*kept, *holes]
    mass, origin = _mass(parts), parts[0].mass_center
    moment = sum((p.mass_center.position(origin) * p.mass for p in parts), start=Vector())
    center = origin.at(f"{name}*", (moment / mass).express(frame).map(collected))
    total = Dyadic()
    for p in parts:
        own = Dyadic() if p.inertia is None else p.inertia
        total = total + parallel_axis(own, p.mass, p.mass_center.position(center).express(frame))
    whole = _along(frame, total)
    symbols = free_symbols([*center.offset.scalars(), *whole.components(frame).entries])
    moving = (s for s in symbols if not isinstance(s, Parameter))
    expected = f"bodies of the composite {name} that are fixed in {frame.name}"
    cure = "List what moves in it as separate bodies."
    expect.none(moving, expected, "positions or inertias in it that depend on {}", cure)
    return RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=whole)


def _along(frame: Frame, inertia: Dyadic) -> Dyadic:
    """The dyadic multiplied out, along the axes of one frame."""
    return Dyadic.of(frame, inertia.components(frame).map(collected).rows)


def _about(part: Part, point: Point) -> Dyadic:
    """I + m (p² 1 − p p); for a point of a flexible body with shared momentum, I + Σ μ (p·q 1 − p q)."""
    own = Dyadic() if part.inertia is None else part.inertia
    p = part.mass_center.position(point).gathered()
    if not part.momenta:
        return parallel_axis(own, part.mass, p)
    for other, mass in part.momenta:
        q = other.position(point).gathered()
        for frame, _ in q.parts[:1]:
            own = own + unit_dyadic(frame) * (mass * p.dot(q)) - p.outer(q) * mass
    return own


def parts_listed(bodies: Any) -> list[Part]:
    """The parts of a body, a system, or a nested list of bodies; raises ModelError for anything else."""
    return list(parts_of(_bodies(bodies)))


def _bodies(item: Any) -> Iterator[Body]:
    if isinstance(item, Body):
        yield item
    elif expect.is_list(item):
        for x in item:
            yield from _bodies(x)
    elif isinstance(getattr(item, "bodies", None), tuple):
        yield from _bodies(item.bodies)
    else:
        cure = "A point has no mass: make a body of it, kn.Particle(name, point, mass)."
        raise expect.refusal(ModelError, "bodies from kn.RigidBody or kn.Particle", cut(repr(item)), cure)


def _mass(parts: Iterable[Part]) -> Expr:
    mass = reduce(add, (part.mass for part in parts), ZERO)
    if mass is ZERO:
        raise ModelError("Expected bodies with mass, got none: a mass centre needs some. List the bodies that have it.")
    return mass


def _check_point(point: Any, what: str) -> None:
    expect.instance(point, Point, f"the Point {what}", "Make one with at(…), or take a body's mass_center.")


Pairs = list[tuple[Expr, Vector]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Principal(Immutable):
    """Principal moments of inertia, and the right-handed unit vectors along the principal axes.

    Numerical moments are in ascending order; if two are equal, every line in the plane of their axes is a principal axis.
    """

    moments: tuple[Expr, Expr, Expr]
    axes: tuple[Vector, Vector, Vector]

    @property
    def planes(self) -> tuple[tuple[Vector, Vector], ...]:
        """The principal planes, each by the two axes that span it; the k-th is perpendicular to the k-th axis."""
        x, y, z = self.axes
        return (y, z), (z, x), (x, y)

    @property
    def minimum(self) -> tuple[Expr, Vector]:
        """The least moment of inertia about any line through the point, and its axis (Kane & Levinson 1985, sec. 3.9)."""
        return self._extreme(0)

    @property
    def maximum(self) -> tuple[Expr, Vector]:
        """The greatest moment of inertia about any line through the point, and its axis."""
        return self._extreme(-1)

    def _extreme(self, place: int) -> tuple[Expr, Vector]:
        values = [constant_value(x) for x in self.moments]
        if any(v is None for v in values):
            raise ModelError(
                f"Expected principal moments that are numbers, got {', '.join(cut(x, 40) for x in self.moments)}: which is the "
                "greatest depends on symbols. Give their values: kn.principal(inertia, values={…}); {} takes the defaults."
            )
        k = sorted(range(3), key=lambda i: float(values[i] or 0))[place]
        return self.moments[k], self.axes[k]

    def ellipsoid(self, scale: Any = 1) -> tuple[Expr, ...]:
        """Semi-axes scale/√I_k of the inertia ellipsoid; along any line √I is `scale` over the distance to its surface."""
        expected, came = (
            "principal moments above zero for the inertia ellipsoid",
            "0: the ellipsoid is infinite along that axis",
        )
        expect.none((x for x in self.moments if x is ZERO), expected, came)
        return tuple(div(as_expr(scale), sqrt(x)) for x in self.moments)

    def radii_of_gyration(self, mass: Any) -> tuple[Expr, ...]:
        """Radii of gyration √(I_k/m) about the principal axes, for a mass m."""
        return tuple(sqrt(div(x, as_expr(mass))) for x in self.moments)

    def __repr__(self) -> str:
        return "Principal(" + "; ".join(f"{i} about {n}" for i, n in zip(self.moments, self.axes, strict=True)) + ")"

    _repr_html_ = show.html


def principal(inertia: Dyadic, frame: Frame | None = None, *, values: Mapping[Any, Any] | None = None) -> Principal:
    """Principal moments, axes and planes of an inertia dyadic (Kane & Levinson 1985, sec. 3.8).

    Parameters
    ----------
    inertia : an inertia dyadic about any point: of a body, or from `kn.solids.inertia_about`
    frame : the frame in which the matrix is formed; by default that in which the dyadic is written, if there is only one
    values : numbers by symbol or name, for a numerical result; parameters left out take their defaults. Without `values` the
        result is symbolic, and one axis of the frame must be a principal axis

    Raises
    ------
    ModelError
        if the matrix is not symmetric, or contains symbols while no axis of the frame is a principal axis
    """
    expect.instance(inertia, Dyadic, "an inertia dyadic", "Take body.inertia, or kn.inertia_about(bodies, point).")
    home = _frame_of(inertia, frame)
    matrix = inertia.components(home)
    if values is not None:
        matrix = Matrix(np.asarray(evaluate(matrix, values), dtype=float).tolist())
    numbers = _matrix_of_numbers(matrix)
    drawn = np.reshape(sample(matrix.entries, SEED), (3, 3)) if numbers is None else numbers
    odd = np.abs(drawn - drawn.T).max() > DECLARED * np.abs(drawn).max()
    came = f"the matrix {[[*row] for row in matrix.rows] if numbers is None else numbers.tolist()}"
    cure = "kn.inertia(frame, Ixx, Iyy, Izz, Ixy, Iyz, Izx) makes one."
    expect.that(not odd, "a symmetric inertia", came=came, cure=cure)
    lone = next((i for i in range(3) if _apart(matrix, i)), None)
    if lone is not None:
        pairs = _of_blocks(matrix, home, lone)
    elif numbers is not None:
        pairs = _of_numbers(numbers, home)
    else:
        raise ModelError(
            f"Expected an inertia whose matrix along {home.name} has two zero products with one axis, or values of its symbols, got "
            f"{cut(matrix.rows[0])}, …. Give them: kn.principal(inertia, values={{…}}); {{}} takes the defaults."
        )
    return _ordered(pairs)


def _frame_of(inertia: Dyadic, frame: object) -> Frame:
    if isinstance(frame, Frame):
        return frame
    frames = [f for f in inertia.frames() if isinstance(f, Frame)]
    if frame is not None or len(frames) != 1:
        came = f"{cut(repr(frame))} with a dyadic along {', '.join(f.name for f in frames) or 'none'}"
        raise expect.refusal(ModelError, "one frame for the principal axes", came, "Name it: kn.principal(inertia, B).")
    return frames[0]


def _matrix_of_numbers(matrix: Matrix) -> Array | None:
    values = [constant_value(x) for x in matrix.entries]
    if any(v is None for v in values):
        return None
    return np.array([float(v) for v in values if v is not None]).reshape(3, 3)


def _apart(matrix: Matrix, i: int) -> bool:
    """Whether the products of inertia of the i-th axis with the others are zero."""
    return all(matrix[i, j] is ZERO and matrix[j, i] is ZERO for j in range(3) if j != i)


def _of_blocks(matrix: Matrix, frame: Frame, i: int) -> Pairs:
    """Moments and axes if the i-th axis of the frame is principal: (a + d)/2 ∓ √(((a − d)/2)² + b²) perpendicular to it."""
    units = (frame.x, frame.y, frame.z)
    j, k = (i + 1) % 3, (i + 2) % 3
    a, d, b = matrix[j, j], matrix[k, k], matrix[j, k]
    if b is ZERO:
        return [(matrix[n, n], units[n]) for n in range(3)]
    mean, half = div(add(a, d), TWO), div(sub(a, d), TWO)
    same = half is ZERO  # equal moments: the principal axes are at 45° for any product b
    reach = b if same else sqrt(add(mul(half, half), mul(b, b)))
    angle = div(pi, constant(4)) if same else div(atan2(mul(TWO, b), sub(a, d)), TWO)
    c, s = cos(angle), sin(angle)
    small, great = units[j] * s - units[k] * c, units[j] * c + units[k] * s
    return [(sub(mean, reach), small), (add(mean, reach), great), (matrix[i, i], units[i])]


def _of_numbers(n: Array, frame: Frame) -> Pairs:
    values, columns = np.linalg.eigh((n + n.T) / 2)
    first, second = (c if c[np.abs(c).argmax()] > 0 else -c for c in columns.T[:2])
    pairs: Pairs = []
    for value, column in zip(values, (first, second, np.cross(first, second)), strict=True):
        x, y, z = (float(v) for v in column)
        pairs.append((as_expr(float(value)), frame.x * x + frame.y * y + frame.z * z))
    return pairs


def _ordered(pairs: Pairs) -> Principal:
    """Right-handed principal axes with their moments, in ascending order if these are numbers."""
    values = [constant_value(m) for m, _ in pairs]
    order = [0, 1, 2]
    if all(v is not None for v in values):
        sizes = [float(v or 0) for v in values]
        order.sort(key=lambda i: (sizes[i], i))
        rounded = [abs(x) <= DECLARED * max(sizes) and x < 0 for x in sizes]
        pairs = [(ZERO if zero else m, n) for zero, (m, n) in zip(rounded, pairs, strict=True)]
    (p, x), (q, y), (r, z) = (pairs[i] for i in order)
    return Principal((p, q, r), (x, y, z if order in _CYCLIC else -z))


_CYCLIC = ([0, 1, 2], [1, 2, 0], [2, 0, 1])
