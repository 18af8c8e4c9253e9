# SPDX-License-Identifier: BSD-3-Clause
"""`mode_shapes`: the functions of ξ = x/L that a deformation of a beam is a sum of, by family, as functions or by a table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.polynomial import Chebyshev

from kane.errors import ModelError, alike, cut
from kane.expr.immutable import Immutable
from kane.model.beams.functions import FAMILIES, Evaluate
from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import ROUNDED, SIX_DIGITS

_DEGREES = (16, 32, 64, 128)
"""Degrees at which a function is interpolated, until its last coefficients are rounding."""
_GRID = np.linspace(0, 1, 101)


@dataclass(frozen=True, slots=True, eq=False)
class ModeShapes(Immutable):
    """`count` functions of ξ = x/L from 0, the root, to 1, the tip; `evaluate(ξ (m), order)` gives derivatives by ξ (m × count).

    `breaks` are the places at which they are less smooth; `label` says what they are.
    """

    label: str
    count: int
    evaluate: Evaluate
    breaks: tuple[float, ...] = (0.0, 1.0)

    def __repr__(self) -> str:
        return f"ModeShapes({self.label}, {self.count})"

    def __reduce__(self) -> tuple[Callable[..., "ModeShapes"], tuple[Any, ...]]:
        if self.label in FAMILIES:
            return mode_shapes, (self.label, self.count)
        return ModeShapes, (self.label, self.count, self.evaluate, self.breaks)

    def at(self, xi: float, order: int = 0) -> Array:
        """The values, or derivatives by ξ, at a place (count); zero where they vanish but for rounding: a pinned tip does not move."""
        values: Array = self.evaluate(np.array([float(xi)]), order)[0]
        size = np.abs(self.evaluate(_GRID, order)).max(axis=0)
        return np.where(np.abs(values) > ROUNDED * size, values, 0.0)


def mode_shapes(kind: Any = None, count: int | None = None, *, table: Any = None) -> ModeShapes:
    """Functions of ξ = x/L for a beam: a family by name, functions of one's own, or the tabulated modes of another program.

    Parameters
    ----------
    kind : "clamped-free", "pinned" or "free-free" (eigenfunctions of bending of a uniform beam), "rod" (of stretch and torsion);
        "legendre" or "legendre rod" (ξ² or ξ times Legendre polynomials), "polynomials" or "rod polynomials" (orthonormal ones of the
        same span, by which the mass matrix of a uniform beam is diagonal); or a list of functions of ξ, called with an array
    count : how many of a family
    table : (ξ, values) or (ξ, values, slopes) of a finite element model: places from 0 to 1 (m), values and dφ/dξ (m × n)

    Raises
    ------
    ModelError
        for another name, no functions, functions that are no numbers, or a table of wrong shape
    """
    if table is not None:
        return _tabulated(table)
    if isinstance(kind, str):
        if kind not in FAMILIES:
            raise ModelError(
                f"Expected mode shapes by name, one of {', '.join(map(repr, FAMILIES))}, got {kind!r}.{alike(kind, FAMILIES)}"
            )
        return ModeShapes(kind, _count(count), FAMILIES[kind].make(_count(count)))
    functions = [kind] if callable(kind) else list(kind) if isinstance(kind, Sequence) else []
    if not functions or not all(callable(f) for f in functions):
        raise ModelError(
            "Expected mode shapes as a name and a count, as a list of functions of ξ = x/L, or as table=(ξ, values), got "
            f'{cut(repr(kind))}. For example kn.mode_shapes("clamped-free", 3).'
        )
    series = [_interpolated(f, k) for k, f in enumerate(functions, 1)]
    return ModeShapes("own functions", len(series), _of_series(series))


def _count(count: Any) -> int:
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise ModelError(f"Expected a number of modes of at least 1, got {cut(repr(count))}.")
    return int(count)


def _interpolated(f: Callable[[Array], Any], k: int) -> Chebyshev:
    """A function as the shortest Chebyshev series that has it to rounding, so that it can be differentiated."""

    def numbers(x: Array) -> Array:
        try:
            values = np.asarray(f(x), dtype=float)
        except Exception as error:
            raise ModelError(
                f"Expected function {k} of the mode shapes to take an array of ξ and give a number for each, got "
                f"{type(error).__name__} from it: {error}. Write it with NumPy: lambda x: 1 - np.cos(np.pi*x)."
            ) from error
        if values.shape not in (x.shape, ()) or not np.isfinite(values).all():
            raise ModelError(
                f"Expected function {k} of the mode shapes to give a finite number for each ξ from 0 to 1, got the shape "
                f"{values.shape} for {x.shape}, or numbers that are not finite. Write it with NumPy: lambda x: 1 - np.cos(np.pi*x)."
            )
        return np.broadcast_to(values, x.shape)

    for degree in _DEGREES:
        series: Chebyshev = Chebyshev.interpolate(numbers, degree, domain=[0, 1])
        size = np.abs(series.coef).max()
        if np.abs(series.coef[-4:]).max() <= ROUNDED * size:
            kept = np.nonzero(np.abs(series.coef) > ROUNDED * size)[0]
            return Chebyshev(series.coef[: kept[-1] + 1] if len(kept) else [0.0], domain=[0, 1])
    raise ModelError(
        f"Expected smooth functions as mode shapes, got function {k}, which a polynomial of degree {_DEGREES[-1]} does not follow. "
        "Give what has kinks as table=(ξ, values)."
    )


def _of_series(series: Sequence[Chebyshev]) -> Evaluate:
    derivatives = [[p.deriv(k) if k else p for p in series] for k in range(3)]

    return partial(_summed, derivatives)


def _summed(derivatives: list[list[Chebyshev]], x: Array, order: int) -> Array:
    return np.array([p(x) for p in derivatives[order]]).T


def _tabulated(table: Any) -> ModeShapes:
    """Cubic splines through a table: with slopes Hermite's, as the elements of a beam have them."""
    from scipy.interpolate import CubicHermiteSpline, CubicSpline

    parts = _numbers(table) if isinstance(table, Sequence) and len(table) in (2, 3) else []
    if not parts:
        raise ModelError(
            f"Expected table=(ξ, values) or (ξ, values, slopes), arrays of real numbers, got {cut(repr(table))}. Places "
            "are m numbers, values and slopes m × modes."
        )
    x, values = parts[0], parts[1]
    if x.ndim != 1 or len(x) < 3 or x[0] != 0 or x[-1] != 1 or not (np.diff(x) > 0).all():
        raise ModelError(
            f"Expected places ξ = x/L that rise from 0 to 1, three at least, in table=, got {cut(x)}. Divide them by the length."
        )
    for what, v in zip(("values", "slopes"), parts[1:], strict=False):
        if v.ndim != 2 or v.shape[0] != len(x) or v.shape[1] < 1 or v.shape != values.shape:
            raise ModelError(
                f"Expected {what} of the tabulated modes as an array of {len(x)} places × modes, got the shape {v.shape}. One column "
                "is one mode; transpose it if modes are rows."
            )
        if not np.isfinite(v).all():
            raise ModelError(f"Expected finite {what} of the tabulated modes, got {cut(v[~np.isfinite(v)][0])}.")
    spline = CubicHermiteSpline(x, values, parts[2]) if len(parts) == 3 else CubicSpline(x, values)
    return ModeShapes("table", values.shape[1], spline, tuple(map(float, x)))


def _numbers(table: Sequence[Any]) -> list[Array]:
    """The parts as arrays, none if some hold no real numbers."""
    try:
        parts = [np.asarray(x) for x in table]
        return [] if any(map(np.iscomplexobj, parts)) else [x.astype(float) for x in parts]
    except (TypeError, ValueError):
        return []


def vanish(shapes: ModeShapes, xi: float, order: int) -> Mask:
    """Which functions (count) vanish at a place, in value (order 0) or slope (1), but for the rounding of tables."""
    return np.asarray(np.abs(shapes.at(xi, order)) <= SIX_DIGITS * np.abs(shapes.evaluate(_GRID, order)).max(axis=0))


def unmet(shapes: ModeShapes, orders: Sequence[int]) -> list[str]:
    """Which functions do not vanish at the root, in value (order 0) or slope (1)."""
    wrong = []
    for order in orders:
        noun, end = "slope" if order else "value", np.abs(shapes.at(0, order))
        wrong += [f"mode {k + 1} has the {noun} {end[k]:.3g}" for k in np.nonzero(~vanish(shapes, 0, order))[0]]
    return wrong


def together(first: ModeShapes, other: ModeShapes) -> ModeShapes:
    """The functions of both, one after the other."""
    breaks = tuple(sorted({*first.breaks, *other.breaks}))
    evaluate = partial(_side_by_side, first.evaluate, other.evaluate)
    return ModeShapes(f"{first.label}, {other.label}", first.count + other.count, evaluate, breaks)


def _side_by_side(first: Evaluate, other: Evaluate, x: Array, order: int) -> Array:
    return np.hstack([first(x, order), other(x, order)])


def slopes(shapes: ModeShapes) -> ModeShapes:
    """The first derivatives of functions."""
    return ModeShapes(f"slopes of {shapes.label}", shapes.count, partial(_slope, shapes.evaluate), shapes.breaks)


def _slope(evaluate: Evaluate, x: Array, order: int) -> Array:
    return evaluate(x, order + 1)
