# SPDX-License-Identifier: BSD-3-Clause
"""Aligned bases: each axis of rotation is the z axis of a basis, as in Denavit & Hartenberg 1955. Equations are written along them.

A rotation by θ about a unit vector n fixed in a frame has nine direction cosines that depend on θ. If D z = n it is

    cos θ 1 + (1 − cos θ) n nᵀ + sin θ [n×] = D R_z(θ) Dᵀ,        D = R_z(γ) R_x(α),

where Dᵀ is constant beyond the joint and is absorbed by offsets, inertias and the n of the next joint. γ of the next joint is added
to θ, so that only R_x(α) is between two joints: six operations for a vector, as for R_z(θ). Results are reported in declared frames.

If parameters direct an axis relative to the one before, γ and α are expressions of the parameters, unless the axes are parallel at
the parameters' defaults, where γ has no derivatives. The measure numbers of n in its declared frame must be numbers; an axis given
by parameters keeps its direction cosines.

`placed_frames` finds the aligned node and the constant direction cosines of each declared frame; `aligned_bases` makes the bases.
Direction cosines (3, 3) and angles are arrays of floats, or arrays of expressions if they depend on parameters. Expressions of
parameters are evaluated once per set of parameters and cost little. If axes become parallel at other values of the parameters, γ is
arbitrary there, and the rest of the rotation, `phase`, is computed with the same γ.
"""

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
"""The sine of the angle between two axes, at the parameters' defaults, above which γ is an expression of parameters."""


def are_numbers(cosines: Array) -> bool:
    """Whether the entries are floats, not expressions."""
    return cosines.dtype != object


def numbers(exprs: Iterable[Expr]) -> list[float] | None:
    """The values of constant expressions; None if one of them has symbols."""
    values = []
    for e in exprs:
        value = constant_value(e)
        if value is None and free_symbols([e]):
            return None
        values.append(float(evaluate(e, {}) if value is None else value))
    return values


def given(rows: Cosines) -> Array:
    """Direction cosines as an array (3, 3), of floats if all entries are constants, else of expressions."""
    known = numbers(x for row in rows for x in row)
    return _array(rows) if known is None else np.reshape(np.array(known), (3, 3))


def _array(rows: Sequence[Sequence[Expr]]) -> Array:
    entries = np.empty((3, 3), dtype=object)
    for i, j in np.ndindex(3, 3):
        entries[i, j] = rows[i][j]
    return entries


def times(a: Array, b: Array) -> Array:
    """The matrix product A B, of floats or expressions."""
    if are_numbers(a) and are_numbers(b):
        return rounded_product(a, b)
    left, right = exact(a), exact(b)
    columns = tuple(zip(*right, strict=True))
    return _array([[dot(row, column) for column in columns] for row in left])


def exact(cosines: Array) -> Cosines:
    """The direction cosines with expressions as entries."""
    a, b, c = (triple(map(as_expr, row)) for row in cosines.tolist())
    return a, b, c


def turn_about(axis: int, angle: Angle) -> Array:
    """The rotation matrix (3, 3) about basis vector `axis` by an angle."""
    if not isinstance(angle, Expr):
        return arrays.about(axis, angle)
    return turned_by(axis, cos(angle), sin(angle))


def turned_by(axis: int, c: Expr, s: Expr) -> Array:
    """The rotation matrix (3, 3) about basis vector `axis`, from cosine and sine."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rows = [[ONE if a == b else ZERO for b in range(3)] for a in range(3)]
    rows[j][j] = rows[k][k] = c
    rows[k][j], rows[j][k] = s, neg(s)
    return _array(rows)


def is_apart(direction: Triple) -> bool:
    """Whether the sine of a direction's angle with z exceeds `_APART` at the parameters' defaults."""
    symbols = free_symbols(direction)
    x, y, z = (float(v) for v in evaluate(list(direction), {s: value_of(s, SEED) for s in symbols}))
    return math.hypot(x, y) > _APART * math.hypot(x, y, z)


class Leaning(NamedTuple):
    """The rotation R_z(γ) R_x(α): its direction cosines, γ, and α by cosine and sine."""

    cosines: Array
    gamma: Expr
    alpha: "Alpha"


class Alpha(NamedTuple):
    """An angle, represented by its cosine and sine."""

    c: Expr
    s: Expr


def leaning(direction: Triple) -> Leaning:
    """γ and α such that R_z(γ) R_x(α) z is `direction`, a unit vector."""
    x, y, z = direction
    across, gamma = sqrt(add(mul(x, x), mul(y, y))), BUILDERS["atan2"](x, neg(y))
    return Leaning(times(turn_about(2, gamma), turned_by(0, z, across)), gamma, Alpha(z, across))


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """The plan of an aligned basis for a declared frame.

    With a seat, the basis is rotated by `angle` + `phase` about the z axis of the seat, which is the frame's axis times `sense`.
    Without a seat, it has the declared orientation relative to a basis whose direction cosines in `base` are `lead`. Without a base
    it is the declared frame.
    """

    declared: Frame
    base: "Node | None" = None
    lead: Array = field(default_factory=lambda: np.eye(3))
    seat: "RotationAxis | None" = None
    angle: Expr = ZERO
    sense: int = 1
    phase: Expr = ZERO


class RotationAxis(NamedTuple):
    """The seat of an axis: a basis fixed in node `on`, at R_z(γ) R_x(α), whose z is the axis. γ is relative to the unshifted node."""

    on: Node
    gamma: Angle
    alpha: float | Alpha


class PlacedFrame(NamedTuple):
    """A frame fixed in a node: measure numbers along the unshifted node are `cosines` times those along the frame."""

    node: Node
    cosines: Array


def placed_frames(frames: Iterable[Frame]) -> dict[Basis, PlacedFrame]:
    """The nodes of frames, listed parents first; empty if all rotations are about basis vectors.

    A limb is a frame fixed in the root with its descendants; it keeps the declared frames if none of them `_is_general`.
    """
    listed = tuple(frames)
    limbs = {f.lineage[-2] for f in listed if _is_general(f)}
    places: dict[Basis, PlacedFrame] = {}
    for f in listed if limbs else ():
        aside = len(f.lineage) == 1 or f.lineage[-2] not in limbs
        places[f] = PlacedFrame(Node(f), np.eye(3)) if aside else _placed(f, *places[f.lineage[1]])
    return places


def _placed(f: Frame, base: Node, cosines: Array) -> PlacedFrame:
    """The node of a frame, from that of its base and the direction cosines in it."""
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
    if alpha in (0, math.pi):  # parallel to the axis before, or opposite to it
        sense = 1 if alpha == 0 else -1
        angle = o.angle if alpha == 0 else neg(o.angle)
        if base.seat is not None:
            return PlacedFrame(
                Node(f, base, seat=base.seat, angle=add(base.angle, angle), sense=sense, phase=base.phase), cosines
            )
        return PlacedFrame(Node(f, base, seat=RotationAxis(base, 0.0, 0.0), angle=angle, sense=sense), cosines)
    if abs(gamma) > math.pi / 2:  # (γ ∓ π, −α) is the same direction
        gamma, alpha = gamma - math.copysign(math.pi, gamma), -alpha
    node = Node(f, base, seat=RotationAxis(base, gamma, alpha), angle=o.angle)
    return PlacedFrame(node, rounded_product(rounded_product(about(2, gamma), about(0, alpha)).T, cosines))


def _by_parameters(f: Frame, base: Node, cosines: Array, axis: Array, angle: Expr) -> PlacedFrame:
    """The node of a frame whose axis is directed by parameters.

    If the axis is parallel to z at the defaults, the node keeps the declared rotation, since γ has no derivatives by parameters there.
    """
    gamma, alpha = zx(axis)
    own = rounded_product(about(2, gamma), about(0, alpha)).T  # takes the axis to z
    before = times(cosines, own.T)
    direction = triple(row[2] for row in exact(before))
    if not is_apart(direction):
        return PlacedFrame(Node(f, base, cosines), np.eye(3))
    lean = leaning(direction)
    (c, _, _), (s, _, _), _ = exact(times(lean.cosines.T, before))  # a rotation about z
    seat = RotationAxis(base, lean.gamma, lean.alpha)
    return PlacedFrame(Node(f, base, seat=seat, angle=angle, phase=BUILDERS["atan2"](s, c)), own)


def shifts(nodes: Iterable[Node]) -> dict[Node, Angle]:
    """The shift added to the angle of each node that rotates: γ of the seat on it that carries most descendants."""
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


# Orientations given by numbers --------------------------------------------------------------------------------------------------


def _is_general(f: Frame) -> bool:
    """Whether the frame has a constant orientation, or a rotation about a constant axis, and neither is about a basis vector."""
    o = f.orientation
    return o is not None and o.cosines is not None and (_axis(o) is not None or _tilt(o) is not None)


def _tilt(o: Orientation) -> Array | None:
    """The direction cosines (3, 3) of an orientation constant in time; None of others, and about a basis vector by parameters."""
    if o.axis is not None:
        turn = numbers([o.c, o.s])
        return None if turn is None else turned(o.axis, *turn)
    assert o.cosines is not None
    return given(o.cosines) if is_constant_in_time(x for row in o.cosines for x in row) else None


def _axis(o: Orientation) -> Array | None:
    """The unit axis (3,) of a rotation that varies in time, if its measure numbers are numbers, else None."""
    if o.angle is None or is_constant_in_time([o.angle]):
        return None
    if o.axis is not None:
        axis: Array = np.eye(3)[o.axis]
        return axis
    n = None if o.direction is None else numbers(o.direction)
    return None if n is None else np.array(n) / math.hypot(*n)


class AlignedFrame(NamedTuple):
    """A declared frame in its aligned basis: constant direction cosines, and ω of the frame in its parent, along the basis."""

    basis: Basis
    cosines: Array
    rates: Triple


@dataclass(frozen=True, slots=True, eq=False)
class Aligned:
    """The aligned bases of declared frames (`places`), and for each aligned basis a declared frame fixed in it (`owners`)."""

    places: Mapping[Basis, AlignedFrame]
    owners: Mapping[Basis, Basis]

    def rates(self, frame: Basis) -> tuple[Basis, Triple]:
        """The aligned basis of a frame, and the frame's angular velocity in its parent along that basis."""
        place = self.places.get(frame)
        if place is not None:
            return place.basis, place.rates
        o = frame.orientation
        return frame, NOTHING if o is None else o.rates

    def triple(self, frame: Basis, v: Triple) -> tuple[Basis, Triple]:
        """The aligned basis of a frame, and in it the vector with measure numbers v along the frame."""
        place = self.places.get(frame)
        return (frame, v) if place is None else (place.basis, product(exact(place.cosines), v))

    def vector(self, v: Vector) -> Vector:
        """The same vector, written along aligned bases."""
        return sum((Vector((self.triple(f, t),)) for f, t in v.parts), start=Vector()) if self.places else v

    def symmetric(self, frame: Basis, rows: Cosines) -> tuple[Basis, Cosines]:
        """The aligned basis of a frame, and in it C I Cᵀ of the symmetric dyadic with rows I along the frame."""
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
    """The aligned bases of frames listed parents first; `AS_DECLARED` if none is needed."""
    placed = placed_frames(frames)
    if not placed:
        return AS_DECLARED
    bases = _Bases(shifts(dict.fromkeys(p.node for p in placed.values())))
    places = {f: bases.place(f, p) for f, p in placed.items() if bases.node(p.node) is not f}
    return Aligned(MappingProxyType(places), MappingProxyType(bases.owners))


@dataclass(frozen=True, slots=True, eq=False)
class _Bases:
    """The bases made for nodes and seats, each once; `copies` are the fixed bases that stand for declared frames."""

    shifts: Mapping[Node, Angle]
    copies: dict[Basis, Basis] = field(default_factory=dict)
    owners: dict[Basis, Basis] = field(default_factory=dict)
    nodes: dict[Node, Basis] = field(default_factory=dict)
    seats: dict[RotationAxis, Basis] = field(default_factory=dict)

    def place(self, frame: Basis, placed: PlacedFrame) -> AlignedFrame:
        """The aligned basis of a frame; records the basis that stands for the frame itself."""
        node, o, rates = placed.node, frame.orientation, NOTHING
        if node.declared is frame and o is not None:
            rates = o.rates
            if node.seat is not None and o.angle is not None:
                rates = (ZERO, ZERO, mul(constant(node.sense), time_derivative(o.angle)))
        cosines = self.cosines(node, placed.cosines)
        self.copies[frame] = self.fixed(node, cosines)
        return AlignedFrame(self.node(node), cosines, rates)

    def node(self, node: Node) -> Basis:
        """The basis of a node, made at the first call."""
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
        """The basis of a seat, made at the first call."""
        if seat not in self.seats:
            basis = self.node(seat.on)
            gamma = _less(seat.gamma, self.shifts.get(seat.on, 0.0))
            if isinstance(gamma, Expr) or abs(gamma) > LAST_DIGIT:
                basis = self.child(seat.on, about_axis(basis, 2, _angle(gamma)))
            if isinstance(seat.alpha, Alpha):
                c, s = seat.alpha
                tilt = Orientation(basis, NOTHING, axis=0, c=c, s=s, angle=BUILDERS["atan2"](s, c))
                basis = self.child(seat.on, tilt)
            elif abs(seat.alpha) > LAST_DIGIT:
                basis = self.child(seat.on, about_axis(basis, 0, _angle(seat.alpha)))
            self.seats[seat] = basis
        return self.seats[seat]

    def cosines(self, node: Node, cosines: Array) -> Array:
        """Direction cosines (3, 3) in the basis of a node, from those in the unshifted node.

        In a node without shift they include the phase, which its angle then does not have.
        """
        turn = _less(0.0, self.shifts[node]) if node in self.shifts else 0.0 if node.phase is ZERO else node.phase
        found = times(turn_about(2, turn), cosines)
        return rounded(found) if are_numbers(found) else found

    def fixed(self, node: Node, cosines: Array) -> Basis:
        """A basis with constant direction cosines in the basis of a node."""
        base = self.node(node)
        if are_numbers(cosines) and np.array_equal(cosines, np.eye(3)):
            return base
        return self.child(node, Orientation(base, NOTHING, cosines=exact(cosines)))

    def child(self, owner: Node, orientation: Orientation) -> Basis:
        """A new aligned basis in which the declared frame of `owner` is fixed."""
        basis = AlignedBasis(f"{owner.declared.name}^", orientation, self.copies)
        self.owners[basis] = owner.declared
        return basis


def _less(a: Angle, b: Angle) -> Angle:
    """a − b, a float if both are floats or the difference is zero."""
    if isinstance(a, float) and isinstance(b, float):
        return a - b
    left = sub(_angle(a), _angle(b))
    return 0.0 if left is ZERO else left


def _angle(value: Angle) -> Expr:
    """An angle as an expression; multiples of π/2, up to rounding, are written with π."""
    if isinstance(value, Expr):
        return value
    quarters = round(value / (math.pi / 2))
    near = abs(value - quarters * math.pi / 2) <= LAST_DIGIT
    return div(mul(constant(quarters), pi), constant(2)) if near else constant(value)
