# SPDX-License-Identifier: BSD-3-Clause
"""Shape functions of ξ = x/L for the deformation of a beam: named families, functions defined by the user, or tables.

A row of `FAMILIES` gives the functions of one family as a function of ξ (m) and the order of the derivative, (m × n).
Eigenfunctions of bending have ∫ φ² dξ = 1; their eigenvalues β solve the transcendental equations of Blevins (1979), table 8-1.
Differences of terms that grow as cosh β are rewritten with bounded exponentials.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.polynomial.legendre import Legendre

from kane import expect
from kane.errors import ModelError, alike, cut
from kane.expr.ops import Immutable
from kane.numeric.arrays import Array, Mask, product
from kane.numeric.polynomials import gauss
from kane.numeric.scale import ROUNDED, SIX_DIGITS
from kane.program.emit.sincos import sine_cosine

Evaluate = Callable[[Array, int], Array]

_LN2 = float.fromhex("0x1.62e42fefa39efp-1")
_LN2_HIGH, _LN2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")
"""ln 2 as a sum of two numbers; multiples of the first are exact."""
_TERMS = 14
_QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""cos and sin of 0, 1, 2 and 3 quarter turns."""


class ShapeFamily(NamedTuple):
    """A family: `make` returns n functions; `root` and `tip` list what vanishes there for each: value (0) and slope (1)."""

    make: Callable[[int], Evaluate]
    root: tuple[int, ...] = ()
    tip: tuple[int, ...] = ()


def _roots(sign: int, guesses: Any) -> Array:
    """Solutions of cos β = `sign`/cosh β near guesses, by Newton's method."""
    beta: Array = np.array(guesses, dtype=float)
    for _ in range(12):  # quadratic convergence from guesses with one digit
        (sine, cosine), (sinh, cosh) = sine_cosine(beta), _hyperbolic(beta)
        beta = beta + (cosine - sign / cosh) / (sine - sign * sinh / (cosh * cosh))
    return beta


def _exp(x: Array) -> Array:
    """e^x = 2^k e^r with |r| ≤ ln 2/2, by its series, with the same bits on every machine, unlike NumPy's."""
    k = np.rint(x / _LN2)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    series = np.ones_like(r)
    for n in range(_TERMS, 0, -1):
        series = 1 + r * series / n
    return np.asarray(np.ldexp(series, k.astype(int)))


def _hyperbolic(x: Array) -> tuple[Array, Array]:
    """sinh x and cosh x for x not near zero."""
    rising, falling = _exp(x) / 2, _exp(-x) / 2
    return rising - falling, rising + falling


def _clamped_free(n: int) -> Evaluate:
    """cos β cosh β = −1: cosh βξ − cos βξ − σ (sinh βξ − sin βξ), σ = (sinh β − sin β)/(cosh β + cos β)."""
    beta = _roots(-1, (np.arange(n) + 0.5) * np.pi)
    (sine, cosine), (_, cosh) = sine_cosine(beta), _hyperbolic(beta)
    return _of_exponentials(beta, sine + cosine + _exp(-beta), 1 / (cosh + cosine), -1)


def _free_free(n: int) -> Evaluate:
    """cos β cosh β = 1: cosh βξ + cos βξ − σ (sinh βξ + sin βξ), σ = (cosh β − cos β)/(sinh β − sin β)."""
    beta = _roots(1, (np.arange(n) + 1.5) * np.pi)
    (sine, cosine), (sinh, _) = sine_cosine(beta), _hyperbolic(beta)
    return _of_exponentials(beta, cosine - sine - _exp(-beta), 1 / (sinh - sine), 1)


def _of_exponentials(beta: Array, rest: Array, scale: Array, sign: int) -> Evaluate:
    """½ (1 + σ) e^(−βξ) + ½ (1 − σ) e^(βξ) + sign (cos βξ − σ sin βξ), with the small 1 − σ = `rest` · `scale`."""
    less = rest * scale
    sigma = 1 - less

    def evaluate(x: Array, order: int) -> Array:
        z = np.multiply.outer(x, beta)
        # e^(βξ) (1 − σ)/2 = e^(β(ξ−1)) · [rest · e^β · scale]/2, which stays of order 1
        rising = _exp(z - beta) * (rest * _exp(beta) * scale) / 2
        falling = _exp(-z) * (1 + sigma) / 2 * (-1) ** order
        sine, cosine = _quarters_further(z, order)
        waves = cosine - sigma * sine
        whole: Array = (rising + falling + sign * waves) * _power(beta, order)
        return whole

    return evaluate


def _quarters_further(z: Array, order: int) -> tuple[Array, Array]:
    """sin and cos of z + order π/2: the derivatives of sin z, and of cos z up to a quarter turn."""
    sine, cosine = sine_cosine(z)
    c, s = _QUARTERS[order % 4]
    return c * sine + s * cosine, c * cosine - s * sine


def _power(beta: Array, order: int) -> Array:
    """β^order by products."""
    power = np.ones_like(beta)
    for _ in range(order):
        power = power * beta
    return power


def _sines(beta: Any) -> Evaluate:
    """√2 sin βξ."""

    def evaluate(x: Array, order: int) -> Array:
        values: Array = np.sqrt(2) * _quarters_further(np.multiply.outer(x, beta), order)[0] * _power(beta, order)
        return values

    return evaluate


def _polynomials(power: int, n: int) -> Evaluate:
    """ξ^power P_k(2ξ − 1) with the Legendre polynomials P_k, k = 0, 1, …; derivatives by the Leibniz rule."""
    series = [Legendre.basis(k, domain=(0, 1)) for k in range(n)]

    def evaluate(x: Array, order: int) -> Array:
        total = np.zeros((*np.shape(x), n))
        factor = Polynomial([0] * power + [1])
        for k in range(order + 1):
            own = factor.deriv(k)(x) if k else factor(x)
            rest = np.array([(p.deriv(order - k) if order > k else p)(x) for p in series])
            total = total + math.comb(order, k) * (own * rest).T
        return total

    return evaluate


def _orthonormal(power: int, n: int) -> Evaluate:
    """Functions that span the same space, with ∫ φ_i φ_j dξ = δ_ij and increasing degree: ξ^power times Jacobi polynomials."""
    raw = _polynomials(power, n)
    rule = gauss(n + power + 1)
    values, turned = raw(rule.places, 0), np.eye(n)
    for k in range(n):  # Gram–Schmidt, twice to remove rounding errors
        for _ in range(2):
            v = product(values, turned[:, : k + 1])
            parts = (rule.weights[:, None] * v[:, :k] * v[:, k:]).sum(axis=0)
            turned[:, k] -= product(turned[:, :k], parts[:, None])[:, 0]
        length = (rule.weights * product(values, turned[:, k : k + 1])[:, 0] ** 2).sum()
        turned[:, k] /= np.sqrt(length)

    def evaluate(x: Array, order: int) -> Array:
        return product(raw(x, order), turned)

    return evaluate


FAMILIES: dict[str, ShapeFamily] = {
    "clamped-free": ShapeFamily(_clamped_free, root=(0, 1)),
    "pinned": ShapeFamily(lambda n: _sines(np.arange(1, n + 1) * np.pi), root=(0,), tip=(0,)),
    "free-free": ShapeFamily(_free_free),
    "rod": ShapeFamily(lambda n: _sines((np.arange(n) + 0.5) * np.pi), root=(0,)),  # free at the tip
    "polynomials": ShapeFamily(partial(_orthonormal, 2), root=(0, 1)),
    "rod polynomials": ShapeFamily(partial(_orthonormal, 1), root=(0,)),
    "legendre": ShapeFamily(partial(_polynomials, 2), root=(0, 1)),
    "legendre rod": ShapeFamily(partial(_polynomials, 1), root=(0,)),
}
"""Families by name."""


_DEGREES = (16, 32, 64, 128)
"""Degrees of interpolation, increased until the last coefficients are within rounding."""
GRID = np.linspace(0, 1, 101)
_UNIT_BITS = 4


def powers_near(sizes: Any) -> Array:
    """Powers of 16 near `sizes`: 1 for those between 1/4 and 4, and for 0."""
    digits = np.log2(np.where(sizes > 0, sizes, 1.0)) / _UNIT_BITS
    powers: Array = np.ldexp(1.0, _UNIT_BITS * np.round(digits).astype(int))
    return powers


@dataclass(frozen=True, slots=True, eq=False)
class ModeShapes(Immutable):
    """Shape functions of ξ = x/L from 0 at the root to 1 at the tip, `count` of them, from `kn.beams.mode_shapes`.

    `evaluate(ξ, order)` gives their derivatives of an order with respect to ξ at an array ξ (m), as (m × count). `breaks` are the ξ
    between which they are smooth; `label` names the family.
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

    @property
    def units(self) -> Array:
        """Powers of 16 near the root mean square of each function (count); divided by these, functions are of order 1."""
        return powers_near(np.sqrt((self.evaluate(GRID, 0) ** 2).mean(axis=0)))

    def at(self, xi: float, order: int = 0) -> Array:
        """Values (count) at ξ = `xi`, or derivatives of an order with respect to ξ; values of the size of rounding are set to zero."""
        values: Array = self.evaluate(np.array([float(xi)]), order)[0]
        size = np.abs(self.evaluate(GRID, order)).max(axis=0)
        return np.where(np.abs(values) > ROUNDED * size, values, 0.0)


def mode_shapes(kind: Any = None, count: int | None = None, *, table: Any = None) -> ModeShapes:
    """Shape functions of ξ = x/L for a beam: a named family, functions in Python, or modes tabulated by another program.

    Parameters
    ----------
    kind : "clamped-free", "pinned" or "free-free" (eigenfunctions of bending of a uniform beam), "rod" (of stretch and torsion);
        "legendre" or "legendre rod" (ξ² or ξ times Legendre polynomials), "polynomials" or "rod polynomials" (orthonormal polynomials
        that span the same space and make the mass matrix of a uniform beam diagonal); or a list of functions of an array ξ
    count : number of functions of a family
    table : (ξ, values) or (ξ, values, slopes) of a finite element model: ξ from 0 to 1 (m), values φ and dφ/dξ (m × n)

    Raises
    ------
    ModelError
        if the name is unknown, there are no functions, their values are not finite numbers, or a table has the wrong shape
    """
    if table is not None:
        return _tabulated(table)
    if isinstance(kind, str):
        if kind not in FAMILIES:
            raise ModelError(
                f"Expected mode shapes by name, one of {', '.join(map(repr, FAMILIES))}, got {kind!r}.{alike(kind, FAMILIES)}"
            )
        n = expect.whole(count, "a number of modes from 1 to 1000", least=1, most=1000)
        return ModeShapes(kind, n, FAMILIES[kind].make(n))
    functions = [kind] if callable(kind) else list(kind) if isinstance(kind, Sequence) else []
    expected = "mode shapes as a name and a count, as a list of functions of ξ = x/L, or as table=(ξ, values)"
    cure = 'For example kn.mode_shapes("clamped-free", 3).'
    expect.that(functions and all(map(callable, functions)), expected, kind, cure)
    series = [_interpolated(f, k) for k, f in enumerate(functions, 1)]
    return ModeShapes(
        "own functions", len(series), partial(_summed, [[p.deriv(k) if k else p for p in series] for k in range(3)])
    )


def _interpolated(f: Callable[[Array], Any], k: int) -> Chebyshev:
    """The shortest Chebyshev series that equals a function within rounding, for its derivatives."""
    what, cure = f"function {k} of the mode shapes", "Write it with NumPy: lambda x: 1 - np.cos(np.pi*x)."

    def numbers(x: Array) -> Array:
        values = taken(f, x, what, cure)
        right = values.shape in (x.shape, ()) and np.isfinite(values).all()
        came = f"the shape {values.shape} for {x.shape}, or numbers that are not finite"
        expect.that(right, f"{what} to give a finite number for each ξ from 0 to 1", came=came, cure=cure)
        return np.broadcast_to(values, x.shape)

    for degree in _DEGREES:
        series: Chebyshev = Chebyshev.interpolate(numbers, degree, domain=[0, 1])
        size = np.abs(series.coef).max()
        if np.abs(series.coef[-4:]).max() <= ROUNDED * size:
            kept = np.nonzero(np.abs(series.coef) > ROUNDED * size)[0]
            return Chebyshev(series.coef[: kept[-1] + 1] if len(kept) else [0.0], domain=[0, 1])
    raise ModelError(
        f"Expected smooth functions as mode shapes, got function {k}, which a polynomial of degree {_DEGREES[-1]} does not "
        "approximate. Give functions with kinks as table=(ξ, values)."
    )


def taken(f: Callable[[Array], Any], x: Array, what: str, cure: str) -> Array:
    """The values of a user's function at an array of ξ; raises ModelError if it fails."""
    try:
        return np.asarray(f(x), dtype=float)
    except Exception as error:
        raise ModelError(
            f"Expected {what} to take an array of ξ and give a number for each, got {type(error).__name__} from it: {error}. {cure}"
        ) from error


def _summed(derivatives: list[list[Chebyshev]], x: Array, order: int) -> Array:
    return np.array([p(x) for p in derivatives[order]]).T


def _tabulated(table: Any) -> ModeShapes:
    """Cubic splines through a table; with slopes Hermite splines, the shape functions of beam elements."""
    from scipy.interpolate import CubicHermiteSpline, CubicSpline

    parts = _numbers(table) if isinstance(table, Sequence) and len(table) in (2, 3) else []
    cure = "Places are m numbers, values and slopes m × modes."
    expect.that(parts, "table=(ξ, values) or (ξ, values, slopes), arrays of real numbers", table, cure)
    x, values = parts[0], parts[1]
    right = x.ndim == 1 and len(x) > 2 and x[0] == 0 and x[-1] == 1 and (np.diff(x) > 0).all()
    expected, cure = (
        "positions ξ = x/L that increase from 0 to 1, at least three, in table=",
        "Divide them by the length.",
    )
    expect.that(right, expected, came=cut(x), cure=cure)
    for what, v in zip(("values", "slopes"), parts[1:], strict=False):
        right = v.ndim == 2 and v.shape[0] == len(x) and v.shape[1] > 0 and v.shape == values.shape
        expected, came = (
            f"{what} of the tabulated modes as an array of {len(x)} positions × modes",
            f"the shape {v.shape}",
        )
        expect.that(right, expected, came=came, cure="One column is one mode; transpose it if modes are rows.")
        if not np.isfinite(v).all():
            raise ModelError(f"Expected finite {what} of the tabulated modes, got {cut(v[~np.isfinite(v)][0])}.")
    spline = CubicHermiteSpline(x, values, parts[2]) if len(parts) == 3 else CubicSpline(x, values)
    return ModeShapes("table", values.shape[1], spline, tuple(map(float, x)))


def _numbers(table: Sequence[Any]) -> list[Array]:
    """The parts as arrays of floats; empty if some are not real numbers."""
    try:
        parts = [np.asarray(x) for x in table]
        return [] if any(map(np.iscomplexobj, parts)) else [x.astype(float) for x in parts]
    except (TypeError, ValueError):
        return []


def vanish(shapes: ModeShapes, xi: float, order: int) -> Mask:
    """Which functions (count) vanish at a place, in value (order 0) or slope (1), within the precision of tables."""
    return np.asarray(np.abs(shapes.at(xi, order)) <= SIX_DIGITS * np.abs(shapes.evaluate(GRID, order)).max(axis=0))


def unmet(shapes: ModeShapes, orders: Sequence[int]) -> list[str]:
    """Functions that do not vanish at the root, in value (order 0) or slope (1), in words."""
    wrong = []
    for order in orders:
        noun, end = "slope" if order else "value", np.abs(shapes.at(0, order))
        wrong += [f"mode {k + 1} has the {noun} {end[k]:.3g}" for k in np.nonzero(~vanish(shapes, 0, order))[0]]
    return wrong


def together(first: ModeShapes, other: ModeShapes) -> ModeShapes:
    """The functions of both, those of `first` first."""
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
