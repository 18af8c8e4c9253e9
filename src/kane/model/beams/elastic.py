# SPDX-License-Identifier: BSD-3-Clause
"""What the elasticity and the damping of a beam exert: forces −(K q)_j and −(C q̇)_j on gauges.

A gauge of q_j is a point at q_j n from a point fixed in the inertial frame, n fixed there: its only partial velocity is n, for q̇_j, so
that a force along n contributes to this speed's equation and to no other, and to no reaction.
"""

from collections.abc import Sequence

import numpy as np

from kane.expr.build import add, div, mul
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Coordinate, rate
from kane.model.beams.deformation import Field, combined, quadratic
from kane.model.beams.integrals import Share, fine
from kane.model.beams.shapes import ModeShapes
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.point import Point


class Gauges:
    """The gauges of a beam's coordinates; those that are angles turn an arm of the beam's length."""

    def __init__(self, name: str, root: Point, length: Expr, fields: Sequence[Field]) -> None:
        origin = root.root()
        n = origin.frame.x
        self.direction = n
        self.points: dict[Coordinate, Point] = {}
        self.arms: dict[Coordinate, Expr] = {}
        for f in fields:
            for q in f.coordinates:
                arm = length if f.stem == "t" else ONE
                self.arms[q] = arm
                self.points[q] = origin.at(f"{name} gauge of {q.name}", n * mul(arm, q))

    def load(self, name: str, forces: Sequence[tuple[Coordinate, Expr]], potential: Expr | None) -> Load:
        """A load of generalized forces on these coordinates."""
        on = tuple((self.points[q], self.direction * div(-f, self.arms[q])) for q, f in forces)
        return Load(name, on, potential=potential)


def stiffness(f: Field) -> Array:
    """∫ e φ''_i φ''_j dξ of bending, ∫ e φ'_i φ'_j dξ of stretch and twist (n × n)."""
    return strain(f.shapes, f.stiffness.share, 2 if f.bends else 1)


def strain(shapes: ModeShapes, share: Share, order: int) -> Array:
    """∫ e of the products of the derivatives of an order (n × n)."""
    rule = fine([shapes])
    values = shapes.evaluate(rule.places, order)
    k = rule.gram(values, values, share(rule.places))
    size = np.sqrt(np.diag(k))
    # what orthogonality makes zero is zero, so that modes stay apart
    k[np.abs(k) < ROUNDED_CHAIN * np.multiply.outer(size, size)] = 0.0
    whole: Array = (k + k.T) / 2
    return whole


def stiffness_value(f: Field, length: Expr) -> Expr:
    """EI/L³, EA/L or GJ/L."""
    return div(f.stiffness.value, length**3 if f.bends else length)


def elasticity(name: str, gauges: Gauges, length: Expr, fields: Sequence[Field]) -> Load:
    """The load with the strain energy ½ qᵀ K q as its potential."""
    forces: list[tuple[Coordinate, Expr]] = []
    energy = ZERO
    for f in fields:
        k, value = stiffness(f), stiffness_value(f, length)
        energy = add(energy, mul(value, quadratic(k / 2, f.coordinates)))
        forces += [(q, mul(value, combined(row, f.coordinates))) for q, row in zip(f.coordinates, k, strict=True)]
    return gauges.load(f"elasticity of {name}", forces, energy)


def damper(name: str, gauges: Gauges, matrices: Sequence[tuple[Field, Sequence[tuple[Expr, Array]]]]) -> Load:
    """The load −C q̇, with C a sum of values times matrices of numbers for each field."""
    forces: list[tuple[Coordinate, Expr]] = []
    for f, terms in matrices:
        rates = [rate(q) for q in f.coordinates]
        for i, q in enumerate(f.coordinates):
            total = ZERO
            for value, c in terms:
                total = add(total, mul(value, combined(c[i], rates)))
            forces.append((q, total))
    return gauges.load(f"damping of {name}", forces, None)
