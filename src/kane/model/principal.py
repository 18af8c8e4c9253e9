# SPDX-License-Identifier: BSD-3-Clause
"""Principal moments, axes and planes of an inertia dyadic, its ellipsoid, and its greatest and least moments.

    I·n = I_n n,    I = Σ I_k n_k n_k

Kane & Levinson 1985, sec. 3.8, 3.9. Numbers are taken where the matrix is made of them; symbols where it falls into blocks of
two and one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from kane import show
from kane.errors import ModelError, cut
from kane.expr.build import add, cos, div, mul, sin, sqrt, sub
from kane.expr.evaluation import evaluate
from kane.expr.immutable import Immutable
from kane.expr.matrix import Matrix
from kane.expr.node import TWO, ZERO, Expr, as_expr, constant, constant_value, pi
from kane.expr.operators import atan2
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame
from kane.space.vector import Dyadic, Vector

Numbers = npt.NDArray[np.float64]
Pairs = list[tuple[Expr, Vector]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Principal(Immutable):
    """Principal moments of inertia and the unit vectors along their axes, right-handed.

    Moments that are numbers rise; of equal ones every line in the plane of their axes is a principal axis.
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
        """The greatest one, and its axis."""
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
        if any(x is ZERO for x in self.moments):
            raise ModelError(
                "Expected principal moments above zero for the inertia ellipsoid, got 0: along that axis it has no end."
            )
        return tuple(div(as_expr(scale), sqrt(x)) for x in self.moments)

    def radii_of_gyration(self, mass: Any) -> tuple[Expr, ...]:
        """√(I_k / m) for a mass."""
        return tuple(sqrt(div(x, as_expr(mass))) for x in self.moments)

    def __repr__(self) -> str:
        return "Principal(" + "; ".join(f"{i} about {n}" for i, n in zip(self.moments, self.axes, strict=True)) + ")"

    _repr_html_ = show.html


def principal(inertia: Dyadic, frame: Frame | None = None, *, values: Mapping[Any, Any] | None = None) -> Principal:
    """Principal moments, axes and planes of an inertia dyadic (Kane & Levinson 1985, sec. 3.8).

    Parameters
    ----------
    inertia : about any point: a body's, or that of kn.inertia_about
    frame : along which its matrix is looked at; the dyadic's own, if it is one
    values : numbers for symbols by symbol or name, others at their defaults; without it symbols stay, which needs an axis of the
        frame that is a principal one

    Raises
    ------
    ModelError
        if the matrix is not symmetric, or holds symbols and no axis of the frame is a principal one
    """
    if not isinstance(inertia, Dyadic):
        raise ModelError(
            f"Expected an inertia dyadic, got {cut(repr(inertia))}. Take body.inertia, or kn.inertia_about(bodies, point)."
        )
    home = _home(inertia, frame)
    matrix = inertia.components(home)
    if values is not None:
        matrix = Matrix(np.asarray(evaluate(matrix, values), dtype=float).tolist())
    numbers = _numbers(matrix)
    if numbers is not None:
        _check_symmetric(numbers)
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


def _home(inertia: Dyadic, frame: object) -> Frame:
    if isinstance(frame, Frame):
        return frame
    frames = [f for f in inertia.frames() if isinstance(f, Frame)]
    if frame is not None or len(frames) != 1:
        names = ", ".join(f.name for f in frames) or "none"
        raise ModelError(
            f"Expected one frame for the principal axes, got {cut(repr(frame))} with a dyadic along {names}. Name "
            "it: kn.principal(inertia, B)."
        )
    return frames[0]


def _numbers(matrix: Matrix) -> Numbers | None:
    values = [constant_value(x) for x in matrix.entries]
    if any(v is None for v in values):
        return None
    return np.array([float(v) for v in values if v is not None]).reshape(3, 3)


def _check_symmetric(n: Numbers) -> None:
    if np.abs(n - n.T).max() > DECLARED * np.abs(n).max():
        raise ModelError(
            f"Expected a symmetric inertia, got the matrix {n.tolist()}. kn.inertia(frame, Ixx, Iyy, Izz, Ixy, Iyz, Izx) makes one."
        )


def _apart(matrix: Matrix, i: int) -> bool:
    """Whether the i-th axis has no products with the others."""
    return all(matrix[i, j] is ZERO and matrix[j, i] is ZERO for j in range(3) if j != i)


def _of_blocks(matrix: Matrix, frame: Frame, i: int) -> Pairs:
    """Moments and axes where the i-th axis of the frame is a principal one: (a + d)/2 ∓ √(((a − d)/2)² + b²) across it."""
    units = (frame.x, frame.y, frame.z)
    j, k = (i + 1) % 3, (i + 2) % 3
    a, d, b = matrix[j, j], matrix[k, k], matrix[j, k]
    if b is ZERO:
        return [(matrix[n, n], units[n]) for n in range(3)]
    mean, half = div(add(a, d), TWO), div(sub(a, d), TWO)
    same = half is ZERO  # then the axes halve the right angle, whatever the product is
    reach = b if same else sqrt(add(mul(half, half), mul(b, b)))
    angle = div(pi, constant(4)) if same else div(atan2(mul(TWO, b), sub(a, d)), TWO)
    c, s = cos(angle), sin(angle)
    small, great = units[j] * s - units[k] * c, units[j] * c + units[k] * s
    return [(sub(mean, reach), small), (add(mean, reach), great), (matrix[i, i], units[i])]


def _of_numbers(n: Numbers, frame: Frame) -> Pairs:
    values, columns = np.linalg.eigh((n + n.T) / 2)
    first, second = (c if c[np.abs(c).argmax()] > 0 else -c for c in columns.T[:2])
    pairs: Pairs = []
    for value, column in zip(values, (first, second, np.cross(first, second)), strict=True):
        x, y, z = (float(v) for v in column)
        pairs.append((as_expr(float(value)), frame.x * x + frame.y * y + frame.z * z))
    return pairs


def _ordered(pairs: Pairs) -> Principal:
    """Right-handed pairs with the moments in rising order where they are numbers, and still right-handed."""
    values = [constant_value(m) for m, _ in pairs]
    order = [0, 1, 2]
    if all(v is not None for v in values):
        sizes = [float(v or 0) for v in values]
        order.sort(key=lambda i: (sizes[i], i))
        pairs = [
            (ZERO if abs(x) <= DECLARED * max(sizes) and x < 0 else m, n)
            for x, (m, n) in zip(sizes, pairs, strict=True)
        ]
    (p, x), (q, y), (r, z) = (pairs[i] for i in order)
    return Principal((p, q, r), (x, y, z if order in _CYCLIC else -z))


_CYCLIC = ([0, 1, 2], [1, 2, 0], [2, 0, 1])
