# SPDX-License-Identifier: BSD-3-Clause
"""Bases turned so that each axis of rotation is their z. Equations are written along them; what is read keeps the declared frames.

A rotation by θ about a unit vector n fixed in a frame takes nine direction cosines that change with θ. With D of D z = n it is

    cos θ 1 + (1 − cos θ) n nᵀ + sin θ [n×] = D R_z(θ) Dᵀ,        D = R_z(γ) R_x(α),

where Dᵀ is constant beyond the joint: offsets, inertias and the next joint's n absorb it. γ of the next joint is added to θ, so that
only R_x(α) stands between two joints: six operations for a vector, as for R_z(θ) (Denavit & Hartenberg 1955).

Where parameters give the seat of an axis, γ and α are computed of them, unless the axes are parallel at their defaults: there γ has no
derivatives. The measure numbers of n itself must be numbers; an axis with parameters keeps its direction cosines.

Where declared frames lie in bases that turn about their z; `aligned` says why and makes the bases.

Direction cosines (3, 3) and angles are numbers, or expressions of parameters where those are not known: arrays of floats, or of
objects. What is computed of parameters alone is computed once for given ones, so that it counts little; where axes are parallel at
some parameters, γ is any angle, and what is left of the rotation is taken with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kane.expr.build import add, cos, div, mul, neg, sin, sqrt, sub
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time
from kane.expr.matrix import dot
from kane.expr.node import BUILDERS, ONE, ZERO, Expr, as_expr, constant, constant_value, pi
from kane.numeric import arrays
from kane.numeric.arrays import Array, about, rounded, turned, zx, zxz
from kane.numeric.arrays import product as rounded_product
from kane.numeric.sampling import SEED, value_of
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
from kane.tree.triples import mirrored, similar, triple

Angle = float | Expr
_APART = 1e-3
"""The least sine of the angle between axes, at the parameters' defaults, beyond which γ may be taken of parameters."""


def are_numbers(cosines: Array) -> bool:
    """Whether they are known."""
    return cosines.dtype != object


def numbers(exprs: Iterable[Expr]) -> list[float] | None:
    """The values of expressions; None where one has symbols."""
    values = []
    for e in exprs:
        value = constant_value(e)
        if value is None and free_symbols([e]):
            return None
        values.append(float(evaluate(e, {}) if value is None else value))
    return values


def given(rows: Cosines) -> Array:
    """Direction cosines as an array, of floats where all are numbers."""
    known = numbers(x for row in rows for x in row)
    return _array(rows) if known is None else np.reshape(np.array(known), (3, 3))


def _array(rows: Sequence[Sequence[Expr]]) -> Array:
    entries = np.empty((3, 3), dtype=object)
    for i, j in np.ndindex(3, 3):
        entries[i, j] = rows[i][j]
    return entries


def times(a: Array, b: Array) -> Array:
    """A B."""
    if are_numbers(a) and are_numbers(b):
        return rounded_product(a, b)
    left, right = exact(a), exact(b)
    columns = tuple(zip(*right, strict=True))
    return _array([[dot(row, column) for column in columns] for row in left])


def exact(cosines: Array) -> Cosines:
    """The entries as expressions."""
    a, b, c = (triple(map(as_expr, row)) for row in cosines.tolist())
    return a, b, c


def turn_about(axis: int, angle: Angle) -> Array:
    """Of a rotation about a basis vector."""
    if not isinstance(angle, Expr):
        return arrays.about(axis, angle)
    return turned_by(axis, cos(angle), sin(angle))


def turned_by(axis: int, c: Expr, s: Expr) -> Array:
    """Of a rotation about a basis vector, by cosine and sine."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rows = [[ONE if a == b else ZERO for b in range(3)] for a in range(3)]
    rows[j][j] = rows[k][k] = c
    rows[k][j], rows[j][k] = s, neg(s)
    return _array(rows)


def is_apart(direction: Triple) -> bool:
    """Whether a direction lies well aside of z at the parameters' defaults."""
    symbols = free_symbols(direction)
    x, y, z = (float(v) for v in evaluate(list(direction), {s: value_of(s, SEED) for s in symbols}))
    return math.hypot(x, y) > _APART * math.hypot(x, y, z)


def about_z(cosines: Array) -> Expr:
    """The angle of a rotation about z."""
    (c, _, _), (s, _, _), _ = exact(cosines)
    return BUILDERS["atan2"](s, c)


class Leaning(NamedTuple):
    """R_z(γ) R_x(α) as a rotation, γ, and α, which stands for its cosine and sine."""

    cosines: Array
    gamma: Expr
    alpha: Alpha


class Alpha(NamedTuple):
    """An angle by its cosine and sine."""

    c: Expr
    s: Expr

    def about_x(self, base: Basis) -> Orientation:
        """The orientation of what is turned by it about x."""
        return Orientation(base, NOTHING, axis=0, c=self.c, s=self.s, angle=BUILDERS["atan2"](self.s, self.c))


def leaning(direction: Triple) -> Leaning:
    """γ and α with R_z(γ) R_x(α) z = direction, a unit vector."""
    x, y, z = direction
    across, gamma = sqrt(add(mul(x, x), mul(y, y))), BUILDERS["atan2"](x, neg(y))
    return Leaning(times(turn_about(2, gamma), turned_by(0, z, across)), gamma, Alpha(z, across))


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A basis to be made for a declared frame.

    With a seat it is turned by `angle` + `phase` about the seat's z, which is the frame's axis times `sense`. Without one it lies
    in its base, turned by `lead`, as the frame does in its own. Without a base it is the frame itself.
    """

    declared: Frame
    base: Node | None = None
    lead: Array = field(default_factory=lambda: np.eye(3))
    seat: RotationAxis | None = None
    angle: Expr = ZERO
    sense: int = 1
    phase: Expr = ZERO


class RotationAxis(NamedTuple):
    """What turns about one axis sits on: R_z(γ) R_x(α) in the node, before that is shifted."""

    on: Node
    gamma: Angle
    alpha: float | Alpha


class PlacedFrame(NamedTuple):
    """A frame in a node that it is fixed in: v along the node, before that is shifted, is `cosines` · v along the frame."""

    node: Node
    cosines: Array


def placed_frames(frames: Iterable[Frame]) -> dict[Basis, PlacedFrame]:
    """The places of frames, which come parents first; none where all turn about basis vectors.

    A limb, all that hangs on one frame of the root, stays as declared if no frame of it has a general axis or is tilted by numbers.
    """
    listed = tuple(frames)
    limbs = {f.lineage[-2] for f in listed if _is_general(f)}
    places: dict[Basis, PlacedFrame] = {}
    for f in listed if limbs else ():
        aside = len(f.lineage) == 1 or f.lineage[-2] not in limbs
        places[f] = PlacedFrame(Node(f), np.eye(3)) if aside else _placed(f, *places[f.lineage[1]])
    return places


def _placed(f: Frame, base: Node, cosines: Array) -> PlacedFrame:
    """The place of a frame, from that of its base."""
    o = f.orientation
    assert o is not None
    tilt, axis = _tilt(o), _axis(o)
    if tilt is not None:
        return PlacedFrame(base, times(cosines, tilt))
    if axis is None or o.angle is None:
        return PlacedFrame(Node(f, base, cosines), np.eye(3))
    if not are_numbers(cosines):
        return _by_parameters(f, base, cosines, axis, o.angle)
    direction = rounded_product(cosines, axis[:, None])[:, 0]
    gamma, alpha = zx(direction)
    if alpha in (0, math.pi):  # the same axis once more, or against it
        sense = 1 if alpha == 0 else -1
        angle = o.angle if alpha == 0 else neg(o.angle)
        if base.seat is not None:
            return PlacedFrame(
                Node(f, base, seat=base.seat, angle=add(base.angle, angle), sense=sense, phase=base.phase), cosines
            )
        return PlacedFrame(Node(f, base, seat=RotationAxis(base, 0.0, 0.0), angle=angle, sense=sense), cosines)
    if abs(gamma) > math.pi / 2:  # half a turn less, and over the other way
        gamma, alpha = gamma - math.copysign(math.pi, gamma), -alpha
    node = Node(f, base, seat=RotationAxis(base, gamma, alpha), angle=o.angle)
    return PlacedFrame(node, rounded_product(rounded_product(about(2, gamma), about(0, alpha)).T, cosines))


def _by_parameters(f: Frame, base: Node, cosines: Array, axis: Array, angle: Expr) -> PlacedFrame:
    """The place of a frame that turns about an axis which parameters direct; where it may be parallel to z, that of a node of its own.

    γ has no derivatives by parameters there, and x no direction.
    """
    gamma, alpha = zx(axis)
    own = rounded_product(about(2, gamma), about(0, alpha)).T  # the axis along z
    before = times(cosines, own.T)
    direction = triple(row[2] for row in exact(before))
    if not is_apart(direction):
        return PlacedFrame(Node(f, base, cosines), np.eye(3))
    lean = leaning(direction)
    left = about_z(times(lean.cosines.T, before))
    return PlacedFrame(Node(f, base, seat=RotationAxis(base, lean.gamma, lean.alpha), angle=angle, phase=left), own)


def shifts(nodes: Iterable[Node]) -> dict[Node, Angle]:
    """What is added to a node's angle: γ of the seat on it beyond which most frames lie."""
    beyond: dict[Node | RotationAxis, int] = {}
    for node in reversed(list(nodes)):
        for carrier in (node.base, node.seat):
            if carrier is not None:
                beyond[carrier] = beyond.get(carrier, 0) + beyond.get(node, 0) + 1
    heaviest: dict[Node, RotationAxis] = {}
    for seat in beyond:
        if isinstance(seat, RotationAxis) and seat.on.seat is not None:
            before = heaviest.setdefault(seat.on, seat)
            heaviest[seat.on] = seat if beyond[seat] > beyond[before] else before
    return {node: seat.gamma for node, seat in heaviest.items()}


# What stands in numbers ---------------------------------------------------------------------------------------------------------


def _is_general(f: Frame) -> bool:
    """Whether the frame lies in its base by numbers, or turns about an axis in numbers, and not about a basis vector."""
    o = f.orientation
    return o is not None and o.cosines is not None and (_axis(o) is not None or _tilt(o) is not None)


def _tilt(o: Orientation) -> Array | None:
    """The direction cosines (3, 3) where they are numbers, or given by parameters one by one."""
    if o.axis is not None:
        turn = numbers([o.c, o.s])
        return None if turn is None else turned(o.axis, *turn)
    assert o.cosines is not None
    return given(o.cosines) if is_constant_in_time(x for row in o.cosines for x in row) else None


def _axis(o: Orientation) -> Array | None:
    """The axis (3,) of a rotation that goes on, where its measure numbers are numbers."""
    if o.angle is None or is_constant_in_time([o.angle]):
        return None
    if o.axis is not None:
        axis: Array = np.eye(3)[o.axis]
        return axis
    n = None if o.direction is None else numbers(o.direction)
    return None if n is None else np.array(n) / math.hypot(*n)


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
