# SPDX-License-Identifier: BSD-3-Clause
"""Bases turned so that each axis of rotation is their z. Equations are written along them; what is read keeps the declared frames.

A rotation by θ about a unit vector n fixed in a frame takes nine direction cosines that change with θ. With D of D z = n it is

    cos θ 1 + (1 − cos θ) n nᵀ + sin θ [n×] = D R_z(θ) Dᵀ,        D = R_z(γ) R_x(α),

where Dᵀ is constant beyond the joint: offsets, inertias and the next joint's n absorb it. γ of the next joint is added to θ, so that
only R_x(α) stands between two joints: six operations for a vector, as for R_z(θ) (Denavit & Hartenberg 1955).

Where parameters give the seat of an axis, γ and α are computed of them, unless the axes are parallel at their defaults: there γ has no
derivatives. The measure numbers of n itself must be numbers; an axis with parameters keeps its direction cosines.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kane.expr.build import add, cos, div, mul, sin, sub
from kane.expr.differentiation import time_derivative
from kane.expr.node import ZERO, Expr, constant, pi
from kane.kinematics.placement import (
    Alpha,
    Angle,
    Node,
    PlacedFrame,
    RotationAxis,
    are_numbers,
    exact,
    placed_frames,
    shifts,
    times,
    turn_about,
)
from kane.numeric.arrays import Array, rounded, zxz
from kane.numeric.scale import LAST_DIGIT
from kane.space.frame import Frame
from kane.space.rotation import (
    NOTHING,
    AlignedBasis,
    Basis,
    Cosines,
    Orientation,
    Triple,
    about_axis,
    product,
    turned_symmetric,
)
from kane.space.vector import Vector
from kane.tree.triples import mirrored, similar


class AlignedFrame(NamedTuple):
    """A declared frame in its basis: v along that = `cosines` · v along the frame, and ω of the frame in its base, along the basis."""

    basis: Basis
    cosines: Array
    rates: Triple


@dataclass(frozen=True, slots=True, eq=False)
class Aligned:
    """The places of the frames that equations are not written along; for each aligned basis a declared frame that is fixed in it."""

    places: Mapping[Basis, AlignedFrame]
    owners: Mapping[Basis, Basis]

    def rates(self, frame: Basis) -> tuple[Basis, Triple]:
        """The basis that the frame is fixed in, and along it the angular velocity of the frame in its base."""
        place = self.places.get(frame)
        if place is not None:
            return place.basis, place.rates
        o = frame.orientation
        return frame, NOTHING if o is None else o.rates

    def triple(self, frame: Basis, v: Triple) -> tuple[Basis, Triple]:
        """Measure numbers along a declared frame as those along its basis."""
        place = self.places.get(frame)
        return (frame, v) if place is None else (place.basis, product(exact(place.cosines), v))

    def vector(self, v: Vector) -> Vector:
        """The vector along aligned bases."""
        return sum((Vector((self.triple(f, t),)) for f, t in v.parts), start=Vector()) if self.places else v

    def symmetric(self, frame: Basis, rows: Cosines) -> tuple[Basis, Cosines]:
        """Measure numbers of a symmetric dyadic along a declared frame as those along its basis: C I Cᵀ."""
        place = self.places.get(frame)
        if place is None:
            return frame, rows
        if not are_numbers(place.cosines):
            return place.basis, mirrored(similar(exact(place.cosines), rows))
        a, b, c = (_angle(x) for x in zxz(place.cosines))
        for axis, angle in ((2, c), (0, b), (2, a)):
            rows = turned_symmetric(rows, axis, cos(angle), sin(angle))
        return place.basis, rows


AS_DECLARED = Aligned({}, {})


def aligned_bases(frames: Iterable[Frame]) -> Aligned:
    """The aligned bases of frames, which come parents first."""
    placed = placed_frames(frames)
    if not placed:
        return AS_DECLARED
    bases = _Bases(shifts(dict.fromkeys(p.node for p in placed.values())))
    places = {f: bases.place(f, p) for f, p in placed.items() if bases.node(p.node) is not f}
    return Aligned(MappingProxyType(places), MappingProxyType(bases.owners))


@dataclass(frozen=True, slots=True, eq=False)
class _Bases:
    """The bases of nodes and seats as they are made, with the copies of declared frames that they share."""

    shifts: Mapping[Node, Angle]
    copies: dict[Basis, Basis] = field(default_factory=dict)
    owners: dict[Basis, Basis] = field(default_factory=dict)
    nodes: dict[Node, Basis] = field(default_factory=dict)
    seats: dict[RotationAxis, Basis] = field(default_factory=dict)

    def place(self, frame: Basis, placed: PlacedFrame) -> AlignedFrame:
        """Where a frame lies in the basis of its node, of which it gets a copy."""
        node, o, rates = placed.node, frame.orientation, NOTHING
        if node.declared is frame and o is not None:
            rates = o.rates
            if node.seat is not None and o.angle is not None:
                rates = (ZERO, ZERO, mul(constant(node.sense), time_derivative(o.angle)))
        cosines = self.cosines(node, placed.cosines)
        self.copies[frame] = self.fixed(node, cosines)
        return AlignedFrame(self.node(node), cosines, rates)

    def node(self, node: Node) -> Basis:
        """The basis of a node."""
        if node not in self.nodes:
            self.nodes[node] = self._made(node)
        return self.nodes[node]

    def _made(self, node: Node) -> Basis:
        o = node.declared.orientation
        if node.base is None or o is None:
            return node.declared
        if node.seat is not None:
            beyond = add(node.phase, _angle(self.shifts[node])) if node in self.shifts else ZERO
            angle = add(node.angle, beyond)
            return self.child(node, about_axis(self.seat(node.seat), 2, angle))
        base = self.fixed(node.base, self.cosines(node.base, node.lead))
        return node.declared if base is o.base else self.child(node, replace(o, base=base))

    def seat(self, seat: RotationAxis) -> Basis:
        """The basis about whose z frames turn."""
        if seat not in self.seats:
            basis = self.node(seat.on)
            gamma = _less(seat.gamma, self.shifts.get(seat.on, 0.0))
            if isinstance(gamma, Expr) or abs(gamma) > LAST_DIGIT:
                basis = self.child(seat.on, about_axis(basis, 2, _angle(gamma)))
            if isinstance(seat.alpha, Alpha):
                basis = self.child(seat.on, seat.alpha.about_x(basis))
            elif abs(seat.alpha) > LAST_DIGIT:
                basis = self.child(seat.on, about_axis(basis, 0, _angle(seat.alpha)))
            self.seats[seat] = basis
        return self.seats[seat]

    def cosines(self, node: Node, cosines: Array) -> Array:
        """Direction cosines (3, 3) in the basis of a node, from those in the node before it is shifted.

        A node that is not shifted does without its phase, which stands in them.
        """
        turn = _less(0.0, self.shifts[node]) if node in self.shifts else 0.0 if node.phase is ZERO else node.phase
        found = times(turn_about(2, turn), cosines)
        return rounded(found) if are_numbers(found) else found

    def fixed(self, node: Node, cosines: Array) -> Basis:
        """The basis with these direction cosines in that of a node."""
        base = self.node(node)
        if are_numbers(cosines) and np.array_equal(cosines, np.eye(3)):
            return base
        return self.child(node, Orientation(base, NOTHING, cosines=exact(cosines)))

    def child(self, owner: Node, orientation: Orientation) -> Basis:
        """A basis that the frame of `owner` is fixed in."""
        basis = AlignedBasis(f"{owner.declared.name}^", orientation, self.copies)
        self.owners[basis] = owner.declared
        return basis


def _less(a: Angle, b: Angle) -> Angle:
    """a − b, a number where it is known to be one."""
    if isinstance(a, float) and isinstance(b, float):
        return a - b
    left = sub(_angle(a), _angle(b))
    return 0.0 if left is ZERO else left


def _angle(value: Angle) -> Expr:
    """An angle as an expression; quarter turns, up to rounding, as those of π."""
    if isinstance(value, Expr):
        return value
    quarters = round(value / (math.pi / 2))
    near = abs(value - quarters * math.pi / 2) <= LAST_DIGIT
    return div(mul(constant(quarters), pi), constant(2)) if near else constant(value)
