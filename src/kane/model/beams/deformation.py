# SPDX-License-Identifier: BSD-3-Clause
"""The deformation of a beam in hybrid variables: the stretch s along the deformed axis, deflections v and w, twist θ.

    r(ξ) = (L ξ + s − ∫₀^ξ (v'² + w'²) dη/(2L)) e₁ + v e₂ + w e₃        ' = d/dξ

(Yoo, Ryan & Scott 1995): the axial displacement is not a variable, so that partial velocities contain the foreshortening before any
linearization. Each of s, v, w, θ is Σ φ_j(ξ) q_j. With shear, v = v_b + v_s: sections rotate by v_b', the shear angle is v_s', and
each has its own functions, so that there is no locking as the stiffness GA grows.

Modal integrals are computed once by Gauss quadrature. With shares r of the mass per length and e of a stiffness:

    ∫ r f_k f_l dξ        ∫ e φ''_i φ''_j dξ        H_ij(ξ) = ∫₀^ξ φ'_i φ'_j dη

H is the foreshortening: a point of an inextensible axis moves by −qᵀ H q/(2L) along e₁. Its moments with the mass, ∫ r H dξ and
∫ r ξ H dξ, are ∫ m₀ φ'_i φ'_j dξ and ∫ m₁ φ'_i φ'_j dξ by Fubini's theorem, with m₀ = ∫_ξ¹ r dη and m₁ = ∫_ξ¹ r η dη.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from kane import expect
from kane.errors import ModelError, cut, warn
from kane.expr.build import add, div, mul, sum_of
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr, as_expr, constant, constant_value
from kane.expr.symbols import Coordinate, Parameter
from kane.model.beams.shape_functions import GRID, ModeShapes, powers_near, taken, together
from kane.model.joints.joint import mirrored
from kane.numeric.arrays import Array
from kane.numeric.polynomials import QuadratureRule, gauss
from kane.numeric.rank import singular
from kane.numeric.sampling import positive
from kane.numeric.scale import EQUAL, STATE_RANK, STEEP, TAKES_PART
from kane.space.frame import Frame
from kane.space.vector import Vector

_DEGREE = 64
"""Degree of the polynomial with which a taper is compared."""


class Share(NamedTuple):
    """A function of ξ = x/L (m) in units of its value at the root; it or its slope jumps at `breaks`."""

    function: Callable[[Array], Any]
    breaks: tuple[float, ...] = ()

    def __call__(self, x: Array) -> Array:
        """The values (m)."""
        cure = "Write it with NumPy: lambda xi: np.where(xi < 0.5, 1.0, 0.25), breaks=(0.5,)."
        values = taken(self.function, x, "the taper", cure)
        came = f"the shape {values.shape} for {np.shape(x)}"
        expect.that(values.shape in (np.shape(x), ()), "the taper to give a number for each ξ", came=came, cure=cure)
        return np.broadcast_to(values, np.shape(x))

    @property
    def root(self) -> float:
        """A power of 16 near the root of the mean value, 1 for ordinary ones."""
        return float(powers_near(np.sqrt(self(GRID).mean())))

    @property
    def ends(self) -> tuple[float, ...]:
        """The ends of the intervals in which the function is smooth."""
        return (0.0, *self.breaks, 1.0)


UNIFORM = Share(np.ones_like)


class Tapered(NamedTuple):
    """The property `value` · `share(ξ)`."""

    value: Expr
    share: Share


def tapered(value: Any, share: Callable[[Array], Any], breaks: Sequence[float] = ()) -> Tapered:
    """A mass per length, or a stiffness, that varies along a beam: `value` times a function of ξ = x/L.

    `kn.tapered(EI, lambda xi: (1 - 0.5 * xi) ** 3)` is EI at the root and EI/8 at the tip.

    Parameters
    ----------
    value : the value where `share` is 1, a parameter, an expression or a number
    share : a function of an array ξ, with positive values
    breaks : the ξ at which the function or its slope jumps, as for a stepped beam; integrals are split there

    Raises
    ------
    ModelError
        if the function does not accept an array ξ, is not positive, or `breaks` are not between 0 and 1
    """
    cure = "For example lambda xi: 1 - 0.5 * xi."
    expect.that(callable(share), "a function of ξ = x/L as the taper", share, cure)
    expected = "breaks= of the taper as positions ξ between 0 and 1"
    places = sorted({expect.number(x, expected) for x in expect.items(breaks, expected)})
    expect.that(all(0 < x < 1 for x in places), expected, breaks)
    shares = Share(partial(share), tuple(places))  # `partial` is hashable, NumPy polynomials are not
    along = shares(GRID)
    if not (along[:-1] > 0).all() or not np.isfinite(along).all() or along[-1] < 0:
        worst = GRID[int(np.argmin(np.where(np.isfinite(along), along, -np.inf)))]
        raise ModelError(
            f"Expected a taper above zero from the root to the tip, got {float(shares(np.array([worst]))[0]):g} at ξ = {worst:g}. The "
            "function gives the share of the value at the root."
        )
    for a, b in pairwise(shares.ends):
        series: Chebyshev = Chebyshev.interpolate(lambda x: shares(x), _DEGREE, domain=[a, b])
        size = np.abs(series.coef)
        if size[-4:].max() > STEEP * size.max():
            warn(
                f"Expected a taper that is smooth from ξ = {a:g} to {b:g}, or the positions of its steps, got one that jumps or is "
                "steep there: integrals along the beam are off by some thousandths. Give the positions of the steps: breaks=(0.5,)."
            )
    return Tapered(as_expr(value), shares)


def section(who: str, what: str, given: Any, which: str = "") -> Tapered:
    """A property of a beam, uniform unless tapered; raises ModelError if it is not positive, or varies in time."""
    whole = given if isinstance(given, Tapered) else Tapered(as_expr(given), UNIFORM)
    return whole._replace(value=measure(who, what, whole.value, which))


UNITS = {
    "length": ("L", "m"), "mass_per_length": ("rhoA", "kg/m"), "EI": ("EI", "N*m^2"), "EA": ("EA", "N"), "GJ": ("GJ", "N*m^2"),
    "polar": ("Ip", "kg*m"), "shear": ("kGA", "N"), "rotary": ("rhoI", "kg*m"),
    "mass": ("alpha", "1/s"), "stiffness": ("beta", "s"), "ratio": ("zeta", "1"),
}  # fmt: skip
"""Symbol and unit of the parameters made from numbers."""


def measure(who: str, what: str, given: Any, which: str = "") -> Expr:
    """A value in parameters; raises ModelError if it is not positive at their defaults."""
    value = as_expr(given)
    if not all(isinstance(s, Parameter) for s in free_symbols([value])):
        raise ModelError(f"Expected {what} of {who} in parameters and numbers, got {cut(value)}. Use a kn.parameter.")
    return in_parameters(who, what, positive(value, f"{what} of {who}"), which)


def in_parameters(who: str, what: str, value: Expr, which: str = "", meaning: str = "") -> Expr:
    """The value, as a parameter of the beam if it is a number: parameters have units and can be changed."""
    number = constant_value(value)
    if number is None:
        return value
    symbol, unit = UNITS[what]
    name = f"{symbol}{which}_{'_'.join(who.split())}"
    return Parameter.declare(name, float(number), unit, f"{meaning or what} of {who}")


_POINTS = 40
"""Quadrature points for an interval between breaks, beyond twice the number of functions."""
_BITS = 44
"""Numbers rounded to multiples of 2^-44 have exact sums, so that terms cancel exactly."""


def fine(shapes: Sequence[ModeShapes], share: Share = UNIFORM) -> QuadratureRule:
    """A quadrature rule for products of all these functions, times a share."""
    breaks = {b for s in shapes for b in s.breaks} | {0.0, 1.0}
    most = max((s.count for s in shapes), default=1)
    points = max(8, (_POINTS + 2 * most) // (1 if len(breaks) == 2 else 4))
    return gauss(points, sorted(breaks.union(share.breaks)))


def rounded(a: Array, units: Array | float = 1.0) -> Array:
    """A matrix rounded to few bits in units of its rows and columns, so that numbers cancel exactly."""
    scale = np.multiply.outer(units, units)
    whole: Array = np.ldexp(np.round(np.ldexp(a / scale, _BITS)), -_BITS) * scale
    return whole


def cleaned(a: Array, limit: float) -> Array:
    """A matrix with entries that are small beside its diagonal set to zero, for orthogonal functions."""
    size = np.sqrt(np.diag(a))
    return np.where(np.abs(a) < limit * np.multiply.outer(size, size), 0.0, a)


def check_independent(who: str, shapes: ModeShapes, rule: QuadratureRule) -> None:
    """Raise ModelError, with the rank and the dependent functions, unless the functions are linearly independent."""
    values = np.sqrt(rule.weights)[:, None] * shapes.evaluate(rule.places, 0)
    lengths = np.linalg.norm(values, axis=0)
    zero = [k + 1 for k in np.nonzero(lengths == 0)[0]]
    if zero:
        raise ModelError(f"Expected modes of {who} that bend it, got mode {zero[0]}, which is zero. Leave it out.")
    found = singular(values / lengths)
    rank = found.rank(STATE_RANK)
    if rank < shapes.count:
        parts = np.abs(found.kernel(STATE_RANK)).max(axis=0)
        blamed = ", ".join(str(k + 1) for k in np.nonzero(parts > TAKES_PART)[0])
        raise ModelError(
            f"Expected independent modes of {who}, got {shapes.count} of rank {rank}: modes {blamed} depend on each other. Leave out "
            f"{shapes.count - rank} of these."
        )


def foreshortening(shapes: ModeShapes, xi: float) -> Array:
    """The foreshortening matrix H(ξ) (n × n)."""
    breaks = [b for b in shapes.breaks if b < xi]
    if not breaks:
        return np.zeros((shapes.count, shapes.count))
    points = (_POINTS + 2 * shapes.count) // (1 if len(breaks) == 1 else 4)
    rule = gauss(max(points, 8), (*breaks, xi))
    slopes = shapes.evaluate(rule.places, 1)
    return rule.gram(slopes, slopes)


def moments_beyond(share: Share, places: Array) -> tuple[Array, Array]:
    """m₀ and m₁ at each place ξ."""
    inner, first, second = gauss(_POINTS), np.zeros_like(places), np.zeros_like(places)
    for a, b in pairwise(share.ends):
        start = np.clip(places, a, b)
        x = start[:, None] + np.multiply.outer(b - start, inner.places)
        weights = np.multiply.outer(b - start, inner.weights) * share(x)
        first, second = first + weights.sum(axis=1), second + (weights * x).sum(axis=1)
    return first, second


def stations(shapes: Sequence[ModeShapes], bending: Sequence[ModeShapes], share: Share) -> QuadratureRule:
    """The Gauss rule with the fewest points that integrates r f_k f_l for all functions and foreshortenings."""
    target, sizes = _products(fine(shapes, share), shapes, bending, share)

    def enough(points: int) -> bool:
        error = np.abs(_products(gauss(points, share.ends), shapes, bending, share)[0] - target)
        return bool((error <= EQUAL * np.multiply.outer(sizes, sizes)).all())

    few, most = 1, 4 * max((s.count for s in shapes), default=1) + 40
    while most - few > 1:
        middle = (few + most) // 2
        few, most = (few, middle) if enough(middle) else (middle, most)
    return gauss(most, share.ends)


def _products(
    rule: QuadratureRule, shapes: Sequence[ModeShapes], bending: Sequence[ModeShapes], share: Share
) -> tuple[Array, Array]:
    values = [np.ones((len(rule.places), 1)), rule.places[:, None]]
    values += [s.evaluate(rule.places, 0) for s in shapes]
    for s in bending:
        h = np.array([foreshortening(s, x) for x in rule.places])
        rows, columns = np.triu_indices(s.count)
        values.append(h[:, rows, columns])
    whole = np.hstack(values)
    squares = rule.gram(whole, whole, share(rule.places))
    return squares, np.sqrt(np.diag(squares))


SHEAR = {"v": "g", "w": "h"}
"""The deflection by shear for each deflection by bending."""


class Field(NamedTuple):
    """One of s, v, w, θ, or the deflections by shear g and h: direction `along` (for a twist its axis), shape functions, coordinates.

    `stiffness` is EA, EI, GJ or k_s G A. For bending, `turn` is the axis about which a positive slope rotates the section.
    """

    stem: str
    along: Vector
    turn: Vector | None
    shapes: ModeShapes
    coordinates: tuple[Coordinate, ...]
    stiffness: Tapered

    @property
    def bends(self) -> bool:
        """Whether the field is a deflection by bending."""
        return self.turn is not None


class Fields(NamedTuple):
    """The fields of deformation of a beam with a length and an axis e₁."""

    length: Expr
    axis: Vector
    fields: tuple[Field, ...]
    stiffening: bool

    @property
    def shifting(self) -> tuple[Field, ...]:
        """Fields that displace the axis: all except a twist."""
        return tuple(f for f in self.fields if f.stem != "t")

    @property
    def bending(self) -> tuple[Field, ...]:
        """The deflections by bending."""
        return tuple(f for f in self.fields if f.bends)

    @property
    def sagging(self) -> tuple[Field, ...]:
        """The deflections, each with that by shear in the same direction."""
        shear = {id(f.along): f for f in self.fields if f.stem in SHEAR.values()}
        pairs = ((f, shear.get(id(f.along))) for f in self.bending)
        return tuple(
            f._replace(shapes=together(f.shapes, g.shapes), coordinates=(*f.coordinates, *g.coordinates)) if g else f
            for f, g in pairs
        )

    def place(self, xi: float) -> Vector:
        """The position r(ξ) from the root."""
        whole = self.axis * mul(constant(xi), self.length)
        for f in self.shifting:
            whole = whole + f.along * combined(f.shapes.at(xi), f.coordinates)
        if self.stiffening:
            whole = whole + self.axis * self.shortening([foreshortening(f.shapes, xi) for f in self.sagging])
        return whole

    def shortening(self, matrices: Sequence[Array]) -> Expr:
        """The foreshortening −Σ qᵀ H q/(2 L) over the deflections."""
        pairs = zip(self.sagging, matrices, strict=True)
        return div(sum_of(quadratic(rounded(-h / 2, f.shapes.units), f.coordinates) for f, h in pairs), self.length)

    def slope(self, f: Field, xi: float) -> Expr:
        """The slope dv/dx, or the twist."""
        if not f.bends:
            return combined(f.shapes.at(xi), f.coordinates)
        return div(combined(f.shapes.at(xi, 1), f.coordinates), self.length)


def section_frame(name: str, frame: Frame, whole: Fields, xi: float) -> Frame:
    """The frame of the section at ξ, rotated by the slopes of bending and by the twist."""
    turned = frame
    for f in whole.bending:
        axis = mirrored(f.turn, frame, turned)  # type: ignore[arg-type]
        turned = turned.rotate(f"{name} {f.stem}" if f is not whole.fields[-1] else name, whole.slope(f, xi), axis)
    for f in whole.fields:
        if f.stem == "t":
            turned = turned.rotate(name, whole.slope(f, xi), mirrored(f.along, frame, turned))
    return turned


def combined(numbers: Iterable[float], symbols: Sequence[Expr]) -> Expr:
    """Σ number · symbol."""
    return sum_of(mul(constant(float(c)), q) for c, q in zip(numbers, symbols, strict=True) if c)


def quadratic(matrix: Array, symbols: Sequence[Expr]) -> Expr:
    """qᵀ A q for a symmetric matrix of numbers."""
    total = ZERO
    for i, q in enumerate(symbols):
        row = [*(2 * matrix[i, :i]), matrix[i, i]]
        total = add(total, mul(q, combined(row, symbols[: i + 1])))
    return total
