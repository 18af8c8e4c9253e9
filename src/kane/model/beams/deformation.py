# SPDX-License-Identifier: BSD-3-Clause
"""The deformation of a beam in hybrid variables: the stretch s along the deformed axis, deflections v and w, twist θ.

Where sections shear, a deflection is that of bending and that of shear together, v = v_b + v_s: sections turn by v_b', the angle of
shear is v_s', each a sum of functions of its own, so that nothing locks as the stiffness GA grows.

    r(ξ) = (L ξ + s − ∫₀^ξ (v'² + w'²) dη/(2L)) e₁ + v e₂ + w e₃        ' = d/dξ

(Yoo, Ryan & Scott 1995): the axial displacement is no variable, so that its foreshortening stands in the partial velocities before
anything is linearized. Each of s, v, w, θ is Σ φ_j(ξ) q_j.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from kane.expr.build import add, div, mul
from kane.expr.node import ZERO, Expr, constant
from kane.expr.symbols import Coordinate
from kane.model.beams.integrals import foreshortening, rounded
from kane.model.beams.section import Tapered
from kane.model.beams.shapes import ModeShapes, together
from kane.numeric.arrays import Array
from kane.space.frame import Frame
from kane.space.vector import Vector

SHEAR = {"v": "g", "w": "h"}
"""The deflection by shear beside each by bending."""


class Field(NamedTuple):
    """One of s, v, w, θ, or of the deflections by shear g and h: `along` a unit vector (of a twist about it), shapes, coordinates.

    `stiffness` is EA, EI, GJ or k_s G A. Of bending `turn` is the axis about which a positive slope turns the section.
    """

    stem: str
    along: Vector
    turn: Vector | None
    shapes: ModeShapes
    coordinates: tuple[Coordinate, ...]
    stiffness: Tapered

    @property
    def bends(self) -> bool:
        """Whether it is a deflection."""
        return self.turn is not None


class Fields(NamedTuple):
    """The deformation of a beam of a length, along the axis e₁."""

    length: Expr
    axis: Vector
    fields: tuple[Field, ...]
    stiffening: bool

    @property
    def shifting(self) -> tuple[Field, ...]:
        """What moves the axis: all but a twist."""
        return tuple(f for f in self.fields if f.stem != "t")

    @property
    def bending(self) -> tuple[Field, ...]:
        """The deflections by bending."""
        return tuple(f for f in self.fields if f.bends)

    @property
    def sagging(self) -> tuple[Field, ...]:
        """The deflections, each with that by shear along the same direction."""
        shear = {id(f.along): f for f in self.fields if f.stem in SHEAR.values()}
        return tuple(_with(f, shear[id(f.along)]) if id(f.along) in shear else f for f in self.bending)

    def place(self, xi: float) -> Vector:
        """r(ξ) from the root."""
        whole = self.axis * mul(constant(xi), self.length)
        for f in self.shifting:
            whole = whole + f.along * combined(f.shapes.at(xi), f.coordinates)
        if self.stiffening:
            whole = whole + self.axis * self.shortening([foreshortening(f.shapes, xi) for f in self.sagging])
        return whole

    def shortening(self, matrices: Sequence[Array]) -> Expr:
        """−Σ qᵀ H q/(2 L) over the deflections."""
        total = ZERO
        for f, h in zip(self.sagging, matrices, strict=True):
            total = add(total, quadratic(rounded(-h / 2), f.coordinates))
        return div(total, self.length)

    def slope(self, f: Field, xi: float) -> Expr:
        """dv/dx, or the twist."""
        if not f.bends:
            return combined(f.shapes.at(xi), f.coordinates)
        return div(combined(f.shapes.at(xi, 1), f.coordinates), self.length)


def _with(f: Field, shear: Field) -> Field:
    return f._replace(shapes=together(f.shapes, shear.shapes), coordinates=(*f.coordinates, *shear.coordinates))


def section_frame(name: str, frame: Frame, whole: Fields, xi: float) -> Frame:
    """The frame of the section at ξ: turned by the slopes of bending, and by the twist."""
    turned = frame
    for f in whole.bending:
        axis = _within(f.turn.components(frame), turned)  # type: ignore[union-attr]
        turned = turned.rotate(f"{name} {f.stem}" if f is not whole.fields[-1] else name, whole.slope(f, xi), axis)
    for f in whole.fields:
        if f.stem == "t":
            turned = turned.rotate(name, whole.slope(f, xi), _within(f.along.components(frame), turned))
    return turned


def _within(components: Iterable[Expr], frame: Frame) -> Vector:
    """The vector with these measure numbers along a frame."""
    a, b, c = components
    return frame.x * a + frame.y * b + frame.z * c


def combined(numbers: Iterable[float], symbols: Sequence[Expr]) -> Expr:
    """Σ number · symbol."""
    total = ZERO
    for c, q in zip(numbers, symbols, strict=True):
        if c:
            total = add(total, mul(constant(float(c)), q))
    return total


def quadratic(matrix: Array, symbols: Sequence[Expr]) -> Expr:
    """qᵀ A q of a symmetric matrix of numbers."""
    total = ZERO
    for i, q in enumerate(symbols):
        row = [*(2 * matrix[i, :i]), matrix[i, i]]
        total = add(total, mul(q, combined(row, symbols[: i + 1])))
    return total
