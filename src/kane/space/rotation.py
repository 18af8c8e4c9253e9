# SPDX-License-Identifier: BSD-3-Clause
"""Orientations of bases, and changes of basis along the tree of frames, in few operations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from kane.errors import warn
from kane.expr.build import add, cos, mul, neg, sin, sub
from kane.expr.differentiation import time_derivative
from kane.expr.matrix import dot
from kane.expr.node import ONE, TWO, ZERO, Expr, as_expr, constant_value
from kane.expr.ops import NEG, SUB, Immutable
from kane.expr.symbols import Coordinate, QuasiRate
from kane.expr.visit import remembered

Triple = tuple[Expr, Expr, Expr]
Cosines = tuple[Triple, Triple, Triple]

NOTHING: Triple = (ZERO, ZERO, ZERO)
UNITS: Cosines = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


@dataclass(frozen=True, slots=True, eq=False)
class Orientation:
    """How a frame B lies in its base A.

    `axis` is 0, 1, 2 where B turns about a basis axis by the angle with cosine `c` and sine `s`; else `cosines` holds
    the direction cosines ᴬCᴮ, and `direction` the axis of a rotation by `angle`. `rates` are the measure numbers of ᴬω^B along
    B's axes, in rates. With Euler parameters, `parameters` holds the four coordinates.
    """

    base: Basis
    rates: Triple
    axis: int | None = None
    c: Expr = ONE
    s: Expr = ZERO
    angle: Expr | None = None
    cosines: Cosines | None = None
    direction: Triple | None = None
    parameters: tuple[Coordinate, ...] = ()
    quasi: tuple[QuasiRate, ...] = ()

    def scalars(self) -> tuple[Expr, ...]:
        """The expressions of the orientation: Euler parameters, or the angle with a general axis, else the direction cosines."""
        if self.angle is not None:
            return (*self.parameters, self.angle, *(self.direction or ()))
        return (*self.parameters, *(x for row in self.cosines or () for x in row))


def about_axis(base: Basis, axis: int, angle: Expr) -> Orientation:
    """The orientation of a basis rotated about basis axis `axis` of `base`."""
    rates = [ZERO, ZERO, ZERO]
    rates[axis] = time_derivative(angle)
    return Orientation(base, (rates[0], rates[1], rates[2]), axis=axis, c=cos(angle), s=sin(angle), angle=angle)


def in_degrees(what: str, angle: float) -> str:
    """Words for the warning that an angle beyond a whole turn may be in degrees."""
    turns = abs(angle) / (2 * math.pi)
    return f"{what}, {turns:.3g} turns: angles are in radians. If degrees are meant, write math.radians({angle:g})."


def doubt_degrees(name: str, angles: Iterable[Any]) -> None:
    """Warns of an angle beyond a whole turn that is a number of few digits, as degrees are; sums of radians have many digits."""
    for angle in angles:
        exact = constant_value(as_expr(angle))
        if isinstance(exact, int | Fraction) and abs(value := float(exact)) > 2 * math.pi:
            warn(in_degrees(f"{name} is turned by {value:g} rad", value))


class Basis(Immutable):
    """Three right-handed orthonormal vectors in a tree of bases; a frame as far as measure numbers and changes of basis need it.

    `lineage` is this basis, the base of its orientation, the base's base, … up to the root.
    """

    __slots__ = ("__weakref__", "_spins", "lineage", "name", "orientation", "parent")

    name: str
    parent: Basis | None
    orientation: Orientation | None
    lineage: tuple[Basis, ...]
    _copies: Mapping[Basis, Basis] = MappingProxyType({})
    _spins: dict[Basis, Any]


class AlignedBasis(Basis):
    """A basis of the aligned tree: `copies` gives, for each declared frame, the basis of this tree with the same axes."""

    __slots__ = ("_copies",)

    def __init__(self, name: str, orientation: Orientation, copies: Mapping[Basis, Basis]) -> None:
        self.name, self.parent, self.orientation = name, orientation.base, orientation
        self.lineage, self._copies, self._spins = (self, *orientation.base.lineage), copies, {}


def common_base(a: Basis, b: Basis) -> Basis:
    """The deepest frame that both descend from (or are)."""
    up, _ = path(a, b)
    if not up:
        return a
    last = up[-1].orientation
    assert last is not None
    return last.base


def path(source: Basis, target: Basis) -> tuple[tuple[Basis, ...], tuple[Basis, ...]]:
    """The bases to leave on the path up from `source`, and to enter on the path down to `target`.

    Between aligned bases and declared frames the path leads through the copy of the declared frame.
    """
    if source._copies is not target._copies:
        source, target = target._copies.get(source, source), source._copies.get(target, target)
    if source is target:
        return (), ()
    up, down = source.lineage, target.lineage
    i, j = max(0, len(up) - len(down)), max(0, len(down) - len(up))
    while i < len(up) and up[i] is not down[j]:  # where two lineages meet they go on as one
        i, j = i + 1, j + 1
    return up[:i], down[:j][::-1]


def between(a: Basis, b: Basis) -> tuple[Basis, ...]:
    """The frames on the path from one to the other."""
    up, down = path(a, b)
    top = (common_base(a, b),) if up and down else ()
    return (*up[1:], *top, *down[:-1])


def connected(a: Basis, b: Basis) -> bool:
    """Whether both frames have the same root."""
    return a.lineage[-1] is b.lineage[-1]


def _turn(o: Orientation, v: Triple, s: Expr) -> Triple:
    """The components rotated about the basis axis of `o` with cosine o.c and sine s."""
    assert o.axis is not None
    i, j, k = o.axis, (o.axis + 1) % 3, (o.axis + 2) % 3
    x, y = v[j], v[k]
    if x is ZERO and y is ZERO:
        return v
    c = o.c
    out: list[Expr] = [ZERO, ZERO, ZERO]
    out[i] = v[i]
    if y is ZERO:
        out[j], out[k] = mul(c, x), mul(s, x)
    elif x is ZERO:
        out[j], out[k] = neg(mul(s, y)), mul(c, y)
    else:
        out[j], out[k] = sub(mul(c, x), mul(s, y)), add(mul(s, x), mul(c, y))
    return (out[0], out[1], out[2])


def product(rows: Cosines, v: Triple) -> Triple:
    """The product C v."""
    a, b, c = rows
    return (dot(a, v), dot(b, v), dot(c, v))


def cross3(a: Triple, b: Triple) -> Triple:
    """Measure numbers of a × b in one right-handed basis."""
    (a1, a2, a3), (b1, b2, b3) = a, b
    k = single(a)
    if k is not None:  # an arm along an axis: the other products are zero
        if k == 0:
            return ZERO, neg(mul(a1, b3)), mul(a1, b2)
        return (mul(a2, b3), ZERO, neg(mul(a2, b1))) if k == 1 else (neg(mul(a3, b2)), mul(a3, b1), ZERO)
    return (sub(mul(a2, b3), mul(a3, b2)), sub(mul(a3, b1), mul(a1, b3)), sub(mul(a1, b2), mul(a2, b1)))


def transposed(rows: Cosines) -> Cosines:
    """The transpose."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (a, d, g), (b, e, h), (c, f, i)


def turned_symmetric(rows: Cosines, axis: int, c: Expr, s: Expr, *, several: bool = False) -> Cosines:
    """R A Rᵀ of a symmetric A (3 × 3), R the rotation about a basis axis with cosine c and sine s, in 16 operations.

    With y = s (a₁₁ − a₂₂) + 2 c a₁₂ in the plane normal to the axis: a₁₁ − s y, a₂₂ + s y, c y − a₁₂. `several` matrices share 2 c.
    """
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    a, b, d = rows[j][j], rows[j][k], rows[k][k]
    both = mul(mul(TWO, c), b) if several else mul(c, mul(TWO, b))
    y = add(mul(s, sub(a, d)), both)
    out = [list(row) for row in rows]
    more = mul(s, y)
    out[j][j], out[k][k] = sub(a, more), add(d, more)
    out[j][k] = out[k][j] = sub(mul(c, y), b)
    x, z = rows[i][j], rows[i][k]
    if x is not ZERO or z is not ZERO:
        out[i][j] = out[j][i] = sub(mul(c, x), mul(s, z))
        out[i][k] = out[k][i] = add(mul(s, x), mul(c, z))
    first, second, third = out
    return (first[0], first[1], first[2]), (second[0], second[1], second[2]), (third[0], third[1], third[2])


def leave(frame: Basis, v: Triple) -> Triple:
    """The components along the base of `frame` of a vector with components v along `frame`."""
    o = frame.orientation
    assert o is not None
    return product(o.cosines, v) if o.cosines is not None else _turn(o, v, o.s)


def enter(frame: Basis, v: Triple) -> Triple:
    """The components along `frame` of a vector with components v along its base."""
    o = frame.orientation
    assert o is not None
    return product(transposed(o.cosines), v) if o.cosines is not None else _turn(o, v, neg(o.s))


def express(v: Triple, source: Basis, target: Basis) -> Triple:
    """The components along `target` of a vector with components v along `source`, step by step along the tree.

    A multiple of a basis vector is computed from the basis vector, so that multiples share direction cosines.
    """
    return v if source is target else _expressed(v, source, target)


@remembered
def _expressed(v: Triple, source: Basis, target: Basis) -> Triple:
    i = single(v)
    if i is None:
        return _walk(v, source, target) if any(x is not ZERO for x in v) else v
    a, b, c = _walk(UNITS[i], source, target)
    x = v[i]
    return (mul(x, a), mul(x, b), mul(x, c))


@remembered
def _walk(v: Triple, source: Basis, target: Basis) -> Triple:
    up, down = path(source, target)
    between = _between(up, down)
    if between is not None:
        up, down = up[:-1], down[1:]
    for frame in up:
        v = leave(frame, v)
    if between is not None:
        v = _turn(between, v, between.s)
    for frame in down:
        v = enter(frame, v)
    return v


def deepest(bases: Iterable[Basis]) -> Basis:
    """The basis with the longest path to the root; the first of several."""
    return max(bases, key=lambda b: len(b.lineage))


def express_sum(parts: Sequence[tuple[Basis, Triple]], target: Basis) -> Triple:
    """The components along `target` of a sum of vectors along bases of one tree, in O(length of the path) operations.

    Components along one basis are summed before they are rotated on, first towards the root and then towards `target`.
    """
    copies = next((b._copies for b in (target, *(f for f, _ in parts)) if b._copies), {})
    target = copies.get(target, target)
    onward = set(target.lineage)
    levels: dict[int, dict[Basis, Triple]] = {}

    def put(f: Basis, v: Triple) -> None:
        level = levels.setdefault(len(f.lineage), {})
        x, y, z = level.get(f, NOTHING)
        level[f] = (add(x, v[0]), add(y, v[1]), add(z, v[2]))

    for f, v in parts:
        put(copies.get(f, f), v)
    for depth in range(max(levels), 1, -1):
        for f, v in levels.get(depth, {}).items():
            if f not in onward:
                put(f.lineage[1], leave(f, v))
    total = NOTHING
    for f in reversed(target.lineage):
        x, y, z = enter(f, total) if f.orientation is not None else total
        a, b, c = levels.get(len(f.lineage), {}).get(f, NOTHING)
        total = add(x, a), add(y, b), add(z, c)
    return total


def _between(up: Sequence[Basis], down: Sequence[Basis]) -> Orientation | None:
    """The rotation from the last frame of `up` to the first of `down`, if both are about the same axis and its angle is simple.

    For frames rotated by θ and θ + δ it is δ: the direction cosines are cos δ, not cos θ cos(θ + δ) + sin θ sin(θ + δ).
    """
    if not up or not down:
        return None
    angle = turned_beyond(up[-1], down[0])
    if angle is None or (angle.args[0] if angle.op is NEG else angle).op is SUB:
        return None
    a = up[-1].orientation
    assert a is not None
    return Orientation(a.base, NOTHING, axis=a.axis, c=cos(angle), s=sin(angle), angle=angle)


def turned_beyond(b: Basis, a: Basis) -> Expr | None:
    """The angle from `a` to `b` if both are rotated about the same basis axis of the same base, else None."""
    o, p = b.orientation, a.orientation
    if o is None or p is None or o.axis is None or (o.base, o.axis) != (p.base, p.axis):
        return None
    return None if o.angle is None or p.angle is None else sub(o.angle, p.angle)


def single(v: Triple) -> int | None:
    """The index of the only nonzero component; None if there are none or several."""
    x, y, z = v
    if x is ZERO:
        if y is ZERO:
            return None if z is ZERO else 2
        return 1 if z is ZERO else None
    return 0 if y is ZERO and z is ZERO else None


@remembered
def cost(v: Triple, source: Basis, target: Basis) -> int:
    """An estimate of the operations of `express`."""
    if source is target:
        return 0
    present = [x is not ZERO for x in v]
    operations = 0
    up, down = path(source, target)
    for frame in (*up, *down):
        o = frame.orientation
        assert o is not None
        if o.axis is None:
            operations += 5 * sum(present)
            present = [any(present)] * 3
            continue
        j, k = (o.axis + 1) % 3, (o.axis + 2) % 3
        operations += (0, 2, 6)[present[j] + present[k]]
        present[j] = present[k] = present[j] or present[k]
    return operations
