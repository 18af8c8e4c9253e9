# SPDX-License-Identifier: BSD-3-Clause
"""Vectors and dyadics: sums of measure numbers along the axes of one or more frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import reduce
from itertools import takewhile
from types import MappingProxyType
from typing import Any, NoReturn

from kane import expect, show
from kane.errors import SpaceError, cut
from kane.expr.build import add, div, mul, neg, sqrt, sub
from kane.expr.differentiation import doubt_partial, tangent, time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Symbol, rate
from kane.expr.visit import remembered
from kane.space.rotation import (
    NOTHING,
    UNITS,
    Basis,
    Triple,
    between,
    common_base,
    connected,
    cost,
    cross3,
    deepest,
    express,
    express_sum,
    path,
    single,
)
from kane.space.rotation import Basis as Frame  # public signatures say Frame: a vector needs no more of one
from kane.write.arrange import TEXT, layout

Parts = tuple[tuple[Frame, Triple], ...]
_MANY = 12
"""Parts of a vector beyond which they are added up from frame to frame, and not each turned by itself."""


class Vector(Immutable):
    """A vector: the sum over frames of x a₁ + y a₂ + z a₃; immutable.

    `parts` holds a pair (frame, three measure numbers) for each frame. Vectors are not re-expressed unless an operation needs it.
    """

    _other_names = MappingProxyType(
        {
            "magnitude": "norm length",
            "normalized": "normalize unit",
            "components": "to_matrix args",
            "express": "express_in",
        }
    )

    __slots__ = ("parts",)
    parts: Parts

    def __init__(self, parts: Iterable[tuple[Frame, Triple]] = ()) -> None:
        kept = []
        for part in parts:
            x, y, z = part[1]
            if x is not ZERO or y is not ZERO or z is not ZERO:
                kept.append(part)
        _set_parts(self, tuple(kept))

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"A Vector is frozen: {name!r} cannot be set.")

    def __reduce__(self) -> tuple[Callable[..., Vector], tuple[Any, ...]]:
        return Vector, (self.parts,)

    __hash__ = object.__hash__

    def __eq__(self, other: object) -> NoReturn:
        raise SpaceError(
            "Expected a comparison that has a truth value: vectors are not compared by `==`. Compare numbers from "
            "kn.evaluate(v.components(frame), …)."
        )

    @property
    def is_zero(self) -> bool:
        """Whether all measure numbers are zero, identically."""
        return not self.parts

    def __add__(self, other: Vector | int) -> Vector:
        if isinstance(other, int) and other == 0:  # sum() starts with the integer 0
            return self
        if not isinstance(other, Vector):
            self._refuse_scalar("add to", other)
            return NotImplemented
        return self._joined(other, add) if self.parts else other

    __radd__ = __add__

    def __sub__(self, other: Vector | int) -> Vector:
        if not isinstance(other, Vector):
            self._refuse_scalar("subtract from", other)
            return NotImplemented
        return self._joined(other, sub)

    def __rsub__(self, other: object) -> Vector:
        self._refuse_scalar("subtract it from,", other)
        return NotImplemented

    def _refuse_scalar(self, verb: str, other: object) -> None:
        if isinstance(other, Expr | int | float):
            along = self.parts[0][0].name if self.parts else "N"
            raise SpaceError(
                f"Expected a vector to {verb} {cut(self)}, got the scalar {cut(other)}. Give it a direction, such as "
                f"{cut(other, 20)}*{along}.x."
            )

    def _joined(self, other: Vector, join: Callable[[Expr, Expr], Expr]) -> Vector:
        if not other.parts:
            return self
        merged = dict(self.parts)
        for frame, (x, y, z) in other.parts:
            a, b, c = merged.get(frame, NOTHING)
            merged[frame] = (join(a, x), join(b, y), join(c, z))
        return Vector(merged.items())

    def __neg__(self) -> Vector:
        return Vector([(f, (neg(x), neg(y), neg(z))) for f, (x, y, z) in self.parts])

    def __mul__(self, factor: Any) -> Vector:
        if isinstance(factor, Vector | Dyadic):
            raise SpaceError("Expected a scalar factor, got a vector: write a.dot(b), a.cross(b) or a.outer(b).")
        k = as_expr(factor)
        return Vector([(f, (mul(k, x), mul(k, y), mul(k, z))) for f, (x, y, z) in self.parts])

    __rmul__ = __mul__
    __array_ufunc__ = None

    def __truediv__(self, divisor: Any) -> Vector:
        if isinstance(divisor, Vector | Dyadic):
            raise divided_by(divisor)
        d = as_expr(divisor)
        return Vector([(f, (div(x, d), div(y, d), div(z, d))) for f, (x, y, z) in self.parts])

    def __rtruediv__(self, other: object) -> NoReturn:
        raise divided_by(self)

    def __pow__(self, other: object) -> NoReturn:
        raise raised(self)

    __rpow__ = __pow__

    def __and__(self, other: object) -> NoReturn:
        raise SpaceError("Expected a product by its name, got an operator: write a.dot(b), a.cross(b) or a.outer(b).")

    __rand__ = __or__ = __ror__ = __xor__ = __rxor__ = __matmul__ = __rmatmul__ = __and__

    def dot(self, other: Vector) -> Expr:
        """Scalar product self · other."""
        if type(other) is not Vector:
            raise not_a_vector("a.dot(b)", other)
        return _dot(self.parts, other.parts)

    def cross(self, other: Vector) -> Vector:
        """Vector product self × other."""
        if type(other) is not Vector:
            raise not_a_vector("a.cross(b)", other)
        return _cross(self.parts, other.parts)

    def outer(self, other: Vector) -> Dyadic:
        """The dyad a b of this vector a and the `other` b."""
        if type(other) is not Vector:
            raise not_a_vector("a.outer(b)", other)
        return Dyadic(((self, other),))

    def components(self, frame: Frame) -> Triple:
        """Measure numbers along the axes of `frame`."""
        parts = self.parts
        return parts[0][1] if len(parts) == 1 and parts[0][0] is frame else _components(parts, frame)

    def express(self, frame: Frame) -> Vector:
        """The same vector, written along the axes of `frame` alone."""
        if len(self.parts) == 1 and self.parts[0][0] is frame:
            return self
        return Vector(((frame, self.components(frame)),))

    def gathered(self) -> Vector:
        """The same vector written along one frame, chosen for the fewest operations.

        Candidates are the frames of its parts, their common ancestor and the frames between. Of equally short ones, that with the most
        measure numbers equal to zero is taken; long sums are written along the frame farthest from the root.
        """
        return self if len(self.parts) < 2 else _gathered(self.parts)

    def dt(self, frame: Frame) -> Vector:
        """Time derivative in `frame`: Σ (ẋ a₁ + …) + ω × (x a₁ + …), written in rates of coordinates."""
        total = Vector()
        for f, (x, y, z) in self.parts:
            check_connected(f, frame)
            total = total + Vector(((f, (time_derivative(x), time_derivative(y), time_derivative(z))),))
            if f is not frame:
                total = total + angular_velocity(f, frame).cross(Vector(((f, (x, y, z)),)))
        return total

    def diff(self, by: Expr, frame: Frame) -> Vector:
        """Partial derivative in `frame` with respect to a symbol s: Σ ∂x/∂s a₁ + x ∂a₁/∂s + … (Kane & Levinson 1985, sec. 1.4)."""
        if not isinstance(by, Symbol):
            raise SpaceError(
                f"Expected a symbol to differentiate {cut(self)} by, got {cut(repr(by))}. Along time it is v.dt(frame)."
            )
        doubt_partial(self, lambda: self.express(frame).scalars(), by)
        total = Vector()
        for f, triple in self.parts:
            check_connected(f, frame)
            turn = _turn_by(f, frame, by)
            f, triple = (f, triple) if turn is not None else (frame, express(triple, f, frame))
            x, y, z = (tangent(x, {by: ONE}) for x in triple)
            total = total + Vector(((f, (x, y, z)),))
            if turn is not None:
                total = total + turn.cross(Vector(((f, triple),)))
        return total

    def magnitude(self) -> Expr:
        """|self|, from measure numbers along one frame."""
        v = self.gathered()
        return sqrt(v.dot(v))

    def normalized(self) -> Vector:
        """self / |self|."""
        if self.is_zero:
            raise SpaceError("Expected a vector with a direction, got the zero vector.")
        return self.gathered() / self.magnitude()

    def project(self, direction: Vector) -> Vector:
        """The component of this vector along `direction`, a vector of any length."""
        return direction * (self.dot(direction) / direction.dot(direction))

    def reject(self, direction: Vector) -> Vector:
        """The component of this vector perpendicular to `direction`, a vector of any length."""
        return self - self.project(direction)

    def map(self, f: Callable[[Expr], Expr]) -> Vector:
        """The vector whose measure numbers are `f` of those of this one, frame by frame."""
        return Vector([(frame, (f(x), f(y), f(z))) for frame, (x, y, z) in self.parts])

    def scalars(self) -> tuple[Expr, ...]:
        """All measure numbers, frame by frame."""
        return tuple(x for _, t in self.parts for x in t)

    def __str__(self) -> str:
        """One line, after "where" what the measure numbers share."""
        present = [(x, f, axis) for f, t in self.parts for x, axis in zip(t, "xyz", strict=True) if x is not ZERO]
        shown = layout([x for x, _, _ in present])
        line = TEXT.along(shown.trees, [TEXT.unit_vector(f.name, axis) for _, f, axis in present])
        return TEXT.defined(line, shown.intermediates)

    __repr__ = __str__

    _repr_latex_ = show.latex


_set_parts = Vector.__dict__["parts"].__set__


@remembered
def _components(parts: Parts, frame: Frame) -> Triple:
    for f, _ in parts:
        check_connected(f, frame)
    if len(parts) > _MANY:
        return express_sum(parts, frame)
    total = NOTHING
    for f, v in parts:
        x, y, z = express(v, f, frame)
        total = (add(total[0], x), add(total[1], y), add(total[2], z))
    return total


@remembered
def _dot(many: Parts, few: Parts) -> Expr:
    if len(many) > _MANY or len(few) > _MANY:  # each put together along one frame first
        short = min(many, few, key=len)
        target = short[0][0] if len(short) == 1 else deepest(f for f, _ in (*many, *few))
        return dot(_components(many, target), _components(few, target))
    total = ZERO
    for f, v in many:
        for g, w in few:
            total = add(total, dot_parts(f, v, g, w))
    return total


@remembered
def _cross(these: Parts, others: Parts) -> Vector:
    if len(these) == 1 == len(others):
        frame, a, b = _together(*these[0], *others[0])
        return Vector(((frame, cross3(a, b)),))
    if len(these) > _MANY or len(others) > _MANY:
        return _cross(_gathered(these).parts, _gathered(others).parts)
    total = Vector()
    for f, v in these:
        for g, w in others:
            frame, a, b = _together(f, v, g, w)
            total = total + Vector(((frame, cross3(a, b)),))
    return total


@remembered
def _gathered(parts: Parts) -> Vector:
    whole, own = Vector(parts), [f for f, _ in parts]
    if len(own) > _MANY:
        return whole.express(deepest(own))
    base = reduce(common_base, own)
    between = [g for f in own for g in takewhile(lambda g: g is not base, f.lineage[1:]) if g not in own]
    candidates = (base, *between, *own)
    prices = [sum([cost(v, f, target) for f, v in parts]) for target in candidates]
    best = min(prices)
    cheap = [whole.express(f) for f, p in zip(candidates, prices, strict=True) if p == best]
    return max(reversed(cheap), key=_vanishing)


def axes(frame: Frame) -> tuple[Vector, Vector, Vector]:
    """The three unit vectors."""
    x, y, z = (Vector(((frame, unit),)) for unit in UNITS)
    return x, y, z


def angular_velocity(frame: Frame, base: Frame) -> Vector:
    """Angular velocity of `frame` in `base`, in rates."""
    spins = frame._spins
    spin: Vector | None = spins.get(base)
    if spin is None:
        up, down = path(base, frame)
        spin = Vector()
        for step in down:
            assert step.orientation is not None
            spin = spin + Vector(((step, step.orientation.rates),))
        for step in up:
            assert step.orientation is not None
            spin = spin - Vector(((step, step.orientation.rates),))
        spins[base] = spin
    return spin


def _turn_by(frame: Frame, base: Frame, by: Symbol) -> Vector | None:
    """How `frame` turns in `base` per unit of a symbol; None where it must be seen from the measure numbers.

    Of a coordinate that angles hold it is what its rate is multiplied by in the angular velocity.
    """
    steps = [
        o
        for way in path(base, frame)
        for b in way
        if (o := b.orientation) is not None and by in set(free_symbols(o.scalars()))
    ]
    if not steps:
        return Vector()
    if not isinstance(by, Coordinate) or any(o.parameters for o in steps):
        return None
    return angular_velocity(frame, base).map(lambda x: tangent(x, {rate(by): ONE}))


def _together(f: Frame, v: Triple, g: Frame, w: Triple) -> tuple[Frame, Triple, Triple]:
    """Both triples along one frame, theirs or one between that costs nothing; ties go to the deeper frame's axes."""
    if f is g:
        return f, v, w
    check_connected(f, g)
    there, here = cost(v, f, g), cost(w, g, f)
    if there and here and single(v) is not None and single(w) is not None:
        for h in between(f, g):
            if not cost(v, f, h) and not cost(w, g, h):
                return h, express(v, f, h), express(w, g, h)
    if here < there:
        return f, v, express(w, g, f)
    return g, express(v, f, g), w


def dot_parts(f: Frame, v: Triple, g: Frame, w: Triple) -> Expr:
    """Scalar product of two parts; multiples of unit vectors meet in one direction cosine."""
    if f is g:
        return dot(v, w)
    i, j = single(v), single(w)
    if i is not None:
        check_connected(f, g)
        row = express(UNITS[i], f, g)
        return mul(mul(v[i], w[j]), row[j]) if j is not None else mul(v[i], dot(row, w))
    if j is not None:
        check_connected(f, g)
        return mul(w[j], dot(express(UNITS[j], g, f), v))
    _, a, b = _together(f, v, g, w)
    return dot(a, b)


class Dyadic(Immutable):
    """A dyadic: a sum of dyads a b; `I.dot(w)` is Σ a (b·w). Immutable."""

    __slots__ = ("__weakref__", "dyads")
    dyads: tuple[tuple[Vector, Vector], ...]

    def __init__(self, dyads: Iterable[tuple[Vector, Vector]] = ()) -> None:
        object.__setattr__(self, "dyads", tuple(d for d in dyads if not (d[0].is_zero or d[1].is_zero)))

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"A Dyadic is frozen: {name!r} cannot be set.")

    def __reduce__(self) -> tuple[Callable[..., Dyadic], tuple[Any, ...]]:
        return Dyadic, (self.dyads,)

    @classmethod
    def of(cls, frame: Frame, rows: Iterable[Iterable[Any]]) -> Dyadic:
        """The dyadic Σ I_ij a_i a_j, with `rows` the 3 × 3 measure numbers I_ij along the axes a_i of `frame`."""
        units, entries = axes(frame), [[as_expr(x) for x in row] for row in rows]
        return cls(
            (units[i] * entries[i][j], units[j]) for i in range(3) for j in range(3) if entries[i][j] is not ZERO
        )

    def __add__(self, other: object) -> Dyadic:
        if isinstance(other, int) and other == 0:  # sum() starts with the integer 0
            return self
        if not isinstance(other, Dyadic):
            raise not_a_dyadic(other)
        return Dyadic(self.dyads + other.dyads)

    __radd__ = __add__

    def __neg__(self) -> Dyadic:
        return Dyadic((-a, b) for a, b in self.dyads)

    def __sub__(self, other: object) -> Dyadic:
        return self + (-other if isinstance(other, Dyadic) else other)

    def __rsub__(self, other: object) -> NoReturn:
        raise not_a_dyadic(other)

    def __mul__(self, factor: Any) -> Dyadic:
        return Dyadic((a * factor, b) for a, b in self.dyads)

    __rmul__ = __mul__
    __array_ufunc__ = None

    def __truediv__(self, divisor: Any) -> Dyadic:
        if isinstance(divisor, Vector | Dyadic):
            raise divided_by(divisor)
        return Dyadic((a / divisor, b) for a, b in self.dyads)

    def dot(self, w: Vector) -> Vector:
        """I · w."""
        if type(w) is not Vector:
            raise not_a_vector("dyadic.dot(w)", w)
        return sum((a * b.dot(w) for a, b in self.dyads), start=Vector())

    def components(self, frame: Frame) -> Matrix:
        """The 3 × 3 matrix of measure numbers along the axes of `frame`."""
        rows = [[ZERO] * 3 for _ in range(3)]
        for a, b in self.dyads:
            left, right = a.components(frame), b.components(frame)
            for i in range(3):
                for j in range(3):
                    if left[i] is not ZERO and right[j] is not ZERO:
                        rows[i][j] = add(rows[i][j], mul(left[i], right[j]))
        return Matrix(rows)

    def express(self, frame: Frame) -> Dyadic:
        """The same dyadic along the axes of `frame` alone."""
        return Dyadic.of(frame, self.components(frame).rows)

    def frames(self) -> tuple[Frame, ...]:
        """The frames along whose axes the dyadic is written, without repetition."""
        return tuple(dict.fromkeys(f for d in self.dyads for v in d for f, _ in v.parts))

    def __str__(self) -> str:
        return " + ".join(f"({a})({b})" for a, b in self.dyads) or "0"

    __repr__ = __str__

    _repr_latex_ = show.latex


def _vanishing(v: Vector) -> int:
    """How many measure numbers along the frame of a gathered vector are zero."""
    return sum(x is ZERO for _, triple in v.parts for x in triple) if v.parts else 3


# What is said of operands that go with no vector --------------------------------------------------------------------


def divided_by(vector: object) -> SpaceError:
    """A vector or dyadic as a divisor."""
    return SpaceError(
        f"Expected a scalar divisor, got {cut(vector)}. Divide by a magnitude, v.magnitude(), or a measure number, v.dot(N.x)."
    )


def raised(vector: object) -> SpaceError:
    """A power of a vector."""
    return SpaceError(f"Expected a scalar to raise to a power, got the vector {cut(vector)}. Its square is v.dot(v).")


def not_a_vector(product: str, came: object) -> SpaceError:
    """What came as the other vector of a product such as "a.dot(b)"."""
    if hasattr(came, "dyads"):
        cure = "Write dyadic.dot(vector)."
    elif isinstance(came, Basis):
        cure = f"Take one of its axes, such as {came.name}.x."
    else:
        cure = "A product with a scalar is a * b."
    return SpaceError(
        f"Expected a vector in {product}, got {came.name if isinstance(came, Basis) else cut(came)}. {cure}"
    )


def check_connected(
    f: Basis, g: Basis, expected: str = "a frame, along whose axes or in which a vector is asked for"
) -> None:
    """A SpaceError unless both are frames, of one tree."""
    expect.instance(g, Basis, expected, error=SpaceError)
    if not connected(f, g):
        raise SpaceError(
            f"Expected frames of one tree, got {f.name} and {g.name}, which have no common root. Make one from the other "
            "with rotate(...)."
        )


def not_a_dyadic(came: object) -> SpaceError:
    """What came in a sum of dyadics."""
    return SpaceError(
        f"Expected a dyadic in a sum of dyadics, got {cut(came)}. A moment of inertia about an axis is I * e.outer(e)."
    )
