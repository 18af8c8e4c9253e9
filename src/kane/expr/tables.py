# SPDX-License-Identifier: BSD-3-Clause
"""Tables: functions through points, of any expression."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from kane.errors import Attributes, ExpressionError, cut, none_of
from kane.expr.node import Expr
from kane.expr.piecewise import Data, Numbers, Piecewise, applied, derivative
from kane.expr.piecewise_sides import with_corners

Kind = Literal["linear", "cubic", "periodic", "steps"]
_LEAST = {"linear": 2, "cubic": 3, "periodic": 4, "steps": 1}
"""How many points each kind needs."""


@dataclass(frozen=True, slots=True, eq=False)
class Table(Attributes):
    """A function through points: of an expression it is an expression, of numbers their values."""

    op: Piecewise
    points: tuple[Numbers, Numbers]
    kind: str

    def __call__(self, x: Any) -> Any:
        """The value at x."""
        return applied(self.op, x) if isinstance(x, Expr) else self.op.data.at(x)

    def derivative(self, order: int = 1) -> Callable[[Any], Any]:
        """The nth derivative, a table too."""
        op = self.op
        for _ in range(order):
            op = derivative(op)
        return Table(op, self.points, self.kind)

    def __repr__(self) -> str:
        x = self.points[0]
        return f"Table({self.op.label}: {len(x)} points, {x[0]:g} … {x[-1]:g}, {self.kind})"


def table(
    x: Sequence[float], y: Sequence[float], kind: Kind = "linear", *, name: str = "table", unit: str = "", of: str = ""
) -> Table:
    """A function through the points (x, y), to be called with an expression: `pressure = kn.table(x, y, "periodic"); pressure(q1)`.

    It is part of the equations like any function: its derivatives are exact, and it runs in compiled and emitted code.

    Parameters
    ----------
    x, y : increasing places, and the values there
    kind : "linear": straight from point to point, with corners at which linearizations ask for a side; "cubic": the spline that is
        twice continuously differentiable; "periodic": the same, going round, so that the last value is the first one; "steps": the
        value of the last point passed. Before the first and beyond the last point a table keeps its value there.
    name : what it is called in print
    unit, of : the units of values and of the argument, which are then checked

    Raises
    ------
    ExpressionError
        if points are missing, not finite or not in order, or values of a periodic table do not go round
    """
    places, values = _points(x, y, kind)
    told: dict[str, Any] = {"name": name, "unit": unit, "of": of}
    for what, text in told.items():
        if not isinstance(text, str) or (what == "name" and not text.isidentifier()):
            raise ExpressionError(f"Expected {what} of a table as a text such as 'p', got {cut(repr(text))}.")
    return Table(with_corners(_KINDS[kind](places, values), name, unit, of), (places, values), kind)


def _points(x: Any, y: Any, kind: Any) -> tuple[Numbers, Numbers]:
    if not isinstance(kind, str) or kind not in _LEAST:
        raise ExpressionError(f"Expected the kind of a table as one of {none_of(_LEAST, kind)}")
    try:
        places, values = np.array(x, dtype=float), np.array(y, dtype=float)
    except (TypeError, ValueError) as error:
        raise ExpressionError(
            f"Expected numbers as the points of a table, got {cut(repr(x))} and {cut(repr(y))}."
        ) from error
    if places.ndim != 1 or places.shape != values.shape or len(places) < _LEAST[kind]:
        raise ExpressionError(
            f"Expected at least {_LEAST[kind]} points (x, y) for a table of kind {kind!r}, got shapes {places.shape} and "
            f"{values.shape}. Give more, or take another kind."
        )
    if not (np.isfinite(places).all() and np.isfinite(values).all()):
        raise ExpressionError("Expected finite points of a table, got NaN or infinity. Leave those points out.")
    if (np.diff(places) <= 0).any():
        k = int(np.argmax(np.diff(places) <= 0))
        raise ExpressionError(
            f"Expected increasing places of a table, got {places[k + 1]:g} after {places[k]:g}. Sort the points; where the value "
            "jumps, take kind='steps', or join the two values over a short stretch."
        )
    if kind == "periodic" and values[0] != values[-1]:
        raise ExpressionError(
            f"Expected a periodic table to end at the value that it begins with, {values[0]:g}, got {values[-1]:g}. Close it "
            "by a last point one period after the first."
        )
    return places, values


def _linear(x: Numbers, y: Numbers) -> Data:
    rows = np.column_stack([y[:-1], np.diff(y) / np.diff(x)])
    return _held(x, y, x[:-1], rows)


def _cubic(x: Numbers, y: Numbers) -> Data:
    from scipy.interpolate import CubicSpline

    return _held(x, y, x[:-1], CubicSpline(x, y).c[::-1].T)


def _held(x: Numbers, y: Numbers, centers: Numbers, rows: Numbers) -> Data:
    """Pieces between the points, and what is kept before and beyond them."""
    ends = np.zeros((2, rows.shape[1]))
    ends[:, 0] = y[[0, -1]]
    return Data(x, np.concatenate([x[:1], centers, x[-1:]]), np.vstack([ends[:1], rows, ends[1:]]))


def _periodic(x: Numbers, y: Numbers) -> Data:
    """The period begins in the middle of the first piece, so that every point is between two."""
    from scipy.interpolate import CubicSpline

    rows = CubicSpline(x, y, bc_type="periodic").c[::-1].T
    period = float(x[-1] - x[0])
    start = float((x[0] + x[1]) / 2)
    return Data(x[1:], x, np.vstack([rows, rows[:1]]), (start, period))


def _steps(x: Numbers, y: Numbers) -> Data:
    return Data(x, np.concatenate([x[:1], x]), np.concatenate([y[:1], y])[:, None])


_KINDS: dict[str, Callable[[Numbers, Numbers], Data]] = {
    "linear": _linear,
    "cubic": _cubic,
    "periodic": _periodic,
    "steps": _steps,
}
