# SPDX-License-Identifier: BSD-3-Clause
"""Operations that are data: polynomials in pieces, f(x) = Σ_j a_ij (x − c_i)^j on piece i.

Each is an operation of one argument with a derivative of its own kind, made once of equal data. In expressions and what is printed
it is one function; where code is made it is written in comparisons and choices (`lowered`), which every language has.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.expr.build import NODE_BUILDERS, add, div, mul, sub
from kane.expr.evaluation import know
from kane.expr.node import Expr, as_expr, constant, constant_value, intern_node, postorder
from kane.expr.ops import Op
from kane.expr.visit import fold, rebuilt

Numbers = npt.NDArray[np.float64]
_less, _where, _floor = (NODE_BUILDERS[name] for name in ("less", "where", "floor"))


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """Pieces between `ends` (m − 1), each with its center c (m) and coefficients a (m × degree + 1), lowest first.

    `period` is (x₀, P): then x stands for x − P ⌊(x − x₀)/P⌋, else the outer pieces go on for ever. `corners` are where sides differ.
    """

    ends: Numbers
    centers: Numbers
    coefficients: Numbers
    period: tuple[float, float] | None = None
    corners: tuple[float, ...] = ()

    def digest(self) -> str:
        """What is the same of equal data, in every process."""
        found = hashlib.sha256(repr((self.period, self.corners, self.coefficients.shape)).encode())
        for array in (self.ends, self.centers, self.coefficients):
            found.update(array.astype("<f8").tobytes())
        return found.hexdigest()

    def within(self, x: Any) -> Any:
        """x in the first period."""
        if self.period is None:
            return x
        start, period = self.period
        return x - period * np.floor((x - start) / period)

    def at(self, x: Any) -> Any:
        """Values at numbers or arrays."""
        with np.errstate(invalid="ignore"):
            x = self.within(np.asarray(x, dtype=float))
            piece = np.searchsorted(self.ends, x, side="right")
            d = x - self.centers[piece]
            value = self.coefficients[piece, -1]
            for column in self.coefficients.T[-2::-1]:
                value = value * d + column[piece]
        return np.where(np.isnan(x), np.nan, value)[()]

    def slope(self) -> Data:
        """The derivative."""
        degrees = np.arange(1, self.coefficients.shape[1])
        own = self.coefficients[:, 1:] * degrees
        return replace(self, coefficients=own if own.size else np.zeros((len(self.centers), 1)))


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Piecewise(Op):
    """The operation of some data; `unit` is that of its values and `of` that of its argument, "" where they are not told."""

    data: Data = Data(np.zeros(0), np.zeros(1), np.zeros((1, 1)))
    unit: str = ""
    of: str = ""
    order: int = 0
    sides: tuple[Piecewise, Piecewise, Piecewise] | None = None
    """Of one with corners: a quantity that changes its sign there, and what the operation is on either side of it."""

    def __repr__(self) -> str:
        return f"Piecewise({self.label!r})"

    def __reduce__(self) -> tuple[Callable[..., Piecewise], tuple[Any, ...]]:
        sides = None if self.sides is None else tuple(self.sides)
        return piecewise, (self.data, self.label, self.unit, self.of, self.order, sides)


_known: dict[tuple[Any, ...], Piecewise] = {}


def piecewise(
    data: Data,
    label: str,
    unit: str = "",
    of: str = "",
    order: int = 0,
    sides: tuple[Piecewise, Piecewise, Piecewise] | None = None,
) -> Piecewise:
    """The one operation of this data under this label."""
    digest = data.digest()
    own = (digest, label, unit, of, order, None if sides is None else tuple(s.name for s in sides))
    op = _known.get(own)
    if op is None:
        # the name, and the number that expressions are ordered by, say all that it is
        text = hashlib.sha256(repr(own).encode()).hexdigest()
        code = 1000 + int(text[:12], 16)
        op = Piecewise(
            f"table {text}",
            1,
            data.at,
            _slope_of,
            1,
            label=label,
            code=code,
            data=data,
            unit=unit,
            of=of,
            order=order,
            sides=sides,
        )
        op = _known.setdefault(own, op)
        NODE_BUILDERS[op.name] = _builder(op)
        know(op)
    return op


def _slope_of(node: Expr, x: Expr) -> tuple[Any]:
    op: Any = node.op
    if not op.data.coefficients[:, 1:].any():
        return (0,)
    return (NODE_BUILDERS[derivative(op).name](x),)


def derivative(op: Piecewise) -> Piecewise:
    """The operation of the derivative."""
    sides = None
    if op.sides is not None:
        turning, *others = op.sides
        sides = (turning, *map(derivative, others))
    return piecewise(op.data.slope(), f"{op.label}'", op.unit, op.of, op.order + 1, sides)  # type: ignore[arg-type]


def _builder(op: Piecewise) -> Callable[[Expr], Expr]:
    def build(a: Expr) -> Expr:
        value = constant_value(a)
        return intern_node(op, a) if value is None else constant(float(op.data.at(float(value))))

    return build


def lowered(roots: Iterable[Expr], memo: dict[Expr, Expr] | None = None) -> list[Expr]:
    """The expressions with what is data written in comparisons and choices; without any of it they are as they were."""
    wanted = list(roots)
    if not any(isinstance(node.op, Piecewise) for node in postorder(wanted)):
        return wanted
    images: dict[Expr, Expr] = {} if memo is None else memo

    def image(node: Expr) -> Expr:
        args = [images[a] for a in node.args]
        return written(node.op.data, args[0]) if isinstance(node.op, Piecewise) else rebuilt(node, args)

    return [fold(root, images, image) for root in wanted]


def written(data: Data, x: Expr) -> Expr:
    """The value at x, as `Data.at` computes it."""
    if data.period is not None:
        start, period = map(constant, data.period)
        x = sub(x, mul(period, _floor(div(sub(x, start), period))))
    before = [_less(x, constant(float(end))) for end in data.ends]

    def pick(numbers: Numbers) -> Expr:
        return _picked([constant(float(v)) for v in numbers], before)

    d = sub(x, pick(data.centers))
    value = pick(data.coefficients[:, -1])
    for column in data.coefficients.T[-2::-1]:
        value = add(mul(value, d), pick(column))
    return value


def _picked(values: list[Expr], before: list[Expr]) -> Expr:
    """The value of the piece that x is in: `before[i]` says that x comes before the end of piece i; by halves."""
    if len(values) == 1:
        return values[0]
    half = len(values) // 2
    return _where(before[half - 1], _picked(values[:half], before), _picked(values[half:], before[half:]))


def applied(op: Piecewise, x: Any) -> Expr:
    """The expression op(x)."""
    return NODE_BUILDERS[op.name](as_expr(x))
