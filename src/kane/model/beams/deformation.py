# SPDX-License-Identifier: BSD-3-Clause
"""The deformation of a beam in hybrid variables: the stretch s along the deformed axis, deflections v and w, twist θ.

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
from kane.model.beams.shapes import ModeShapes
from kane.numeric.arrays import Array
from kane.space.vector import Vector


class Field(NamedTuple):
    """One of s, v, w, θ: `along` a unit vector (of a twist about it), its shapes, its coordinates, and EA, EI or GJ.

    Of bending `turn` is the axis about which a positive slope turns the section.
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
        """The deflections."""
        return tuple(f for f in self.fields if f.bends)

    def place(self, xi: float) -> Vector:
        """r(ξ) from the root."""
        whole = self.axis * mul(constant(xi), self.length)
        for f in self.shifting:
            whole = whole + f.along * combined(f.shapes.at(xi), f.coordinates)
        if self.stiffening:
            whole = whole + self.axis * self.shortening([foreshortening(f.shapes, xi) for f in self.bending])
        return whole

    def shortening(self, matrices: Sequence[Array]) -> Expr:
        """−Σ qᵀ H q/(2 L) over the deflections."""
        total = ZERO
        for f, h in zip(self.bending, matrices, strict=True):
            total = add(total, quadratic(rounded(-h / 2), f.coordinates))
        return div(total, self.length)

    def slope(self, f: Field, xi: float) -> Expr:
        """dv/dx, or the twist."""
        if not f.bends:
            return combined(f.shapes.at(xi), f.coordinates)
        return div(combined(f.shapes.at(xi, 1), f.coordinates), self.length)


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
