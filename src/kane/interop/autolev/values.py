# SPDX-License-Identifier: BSD-3-Clause
"""Vectors, dyadics and matrices of a file, in terms of names of frames, which may be oriented after vectors use them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from kane.expr.node import ONE, ZERO, Expr

Axis = tuple[str, int]
"""A unit vector: the frame's name, and 0, 1 or 2."""
Rows = tuple[tuple[Expr, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Vec:
    """A vector: measure numbers by unit vector."""

    parts: Mapping[Axis, Expr] = field(default_factory=dict)

    def __add__(self, other: "Vec") -> "Vec":
        return gathered([*self.parts.items(), *other.parts.items()])

    def __sub__(self, other: "Vec") -> "Vec":
        return self + other.times(-ONE)

    def times(self, factor: Expr) -> "Vec":
        """The vector times a scalar."""
        return gathered((axis, factor * x) for axis, x in self.parts.items())

    def map(self, f: Callable[[Expr], Expr]) -> "Vec":
        """The vector with a function applied to each measure number."""
        return gathered((axis, f(x)) for axis, x in self.parts.items())

    def within(self, frame: str) -> "Vec":
        """The components along the axes of one frame."""
        return Vec({axis: x for axis, x in self.parts.items() if axis[0] == frame})

    def components(self, frame: str) -> tuple[Expr, ...]:
        """The measure numbers along the axes of a frame, ignoring components along other frames."""
        return tuple(self.parts.get((frame, k), ZERO) for k in range(3))

    def frames(self) -> tuple[str, ...]:
        """The frames along whose axes it is written."""
        return tuple(dict.fromkeys(frame for frame, _ in self.parts))


def gathered(parts: Iterable[tuple[Axis, Expr]]) -> Vec:
    """The sum of terms: those along the same unit vector are added, zeros are omitted."""
    total: dict[Axis, Expr] = {}
    for axis, x in parts:
        total[axis] = total[axis] + x if axis in total else x
    return Vec({axis: x for axis, x in total.items() if x is not ZERO})


def along(frame: str, components: Iterable[Expr]) -> Vec:
    """The vector with these components along the axes of a frame."""
    return gathered(((frame, k), x) for k, x in enumerate(components))


@dataclass(frozen=True, slots=True, eq=False)
class Dyad:
    """A sum of dyads plus `unit` times the unit dyadic."""

    terms: tuple[tuple[Vec, Vec], ...] = ()
    unit: Expr = ZERO

    def __add__(self, other: "Dyad") -> "Dyad":
        return Dyad((*self.terms, *other.terms), self.unit + other.unit)

    def times(self, factor: Expr) -> "Dyad":
        """The dyadic times a scalar."""
        return Dyad(tuple((a.times(factor), b) for a, b in self.terms), self.unit * factor)


@dataclass(frozen=True, slots=True, eq=False)
class FileMatrix:
    """A matrix of scalars or vectors."""

    rows: tuple[tuple["Value", ...], ...]

    def flat(self) -> tuple["Value", ...]:
        """Its elements in row-major order."""
        return tuple(x for row in self.rows for x in row)

    def map(self, f: Callable[["Value"], "Value"]) -> "FileMatrix":
        """The matrix with a function applied to each element."""
        return FileMatrix(tuple(tuple(map(f, row)) for row in self.rows))


@dataclass(frozen=True, slots=True)
class Unread:
    """The value of an output that is not read; it may be named, and is refused if the model depends on it."""

    why: str


Value = Expr | Vec | Dyad | FileMatrix | Unread


def entries(value: Value) -> tuple[Value, ...]:
    """The elements of a matrix; another value as the only element."""
    return value.flat() if isinstance(value, FileMatrix) else (value,)


def product(a: Rows, b: Rows) -> Rows:
    """The product of matrices of scalars."""
    columns = tuple(zip(*b, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in a)


def transposed(a: Rows) -> Rows:
    """The transpose."""
    return tuple(zip(*a, strict=True))


def dot(a: Iterable[Expr], b: Iterable[Expr]) -> Expr:
    """Σ a_k b_k."""
    return sum((x * y for x, y in zip(a, b, strict=True)), start=ZERO)


UNIT: Rows = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))
