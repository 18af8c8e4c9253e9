# SPDX-License-Identifier: BSD-3-Clause
"""The parts with mass that represent a beam: particles at stations (nonlinear form), points with shared momentum (linearized form).

Nonlinear: K = ½ Σ m_g v_g·v_g over Gauss points, as few as integrate the products of all functions, foreshortening included.
Linearized: with r = Σ f_k(ξ) d_k, f = (1, ξ, φ_1, …), and D_k = dd_k/dt, the kinetic energy to second order in the deformation is

    K = ½ Σ μ_kl D_k·D_l,   μ_kl = ∫ ρA f_k f_l dx,

where only the products of the foreshortening with 1 and ξ are kept: −qᵀ(∫ r H)q/2L moves with the root, −qᵀ(∫ r ξ H)q/2L with ξ e₁.
All D_k are differences of velocities of points P_k at d_k from the root, so that K = ½ Σ μ'_kl v_k·v_l: the momentum of P_k is
Σ_l μ'_kl v_l.

Elasticity and damping of a beam are forces −(K q)_j and −(C q̇)_j on gauges. A gauge of q_j is a point at q_j n from a point fixed in
the inertial frame, with n fixed there: its only partial velocity is n, for q̇_j, so that a force along n contributes to the equation
of this speed alone, and to no reaction.

Damping is C = α M + β K (Rayleigh), or a ratio ζ for each mode of the beam with its root fixed. With
M = ρA L m and K = k EI/L³ in numbers m, k and their modes Φ: ΦᵀmΦ = 1, ΦᵀkΦ = λ², the ratio ζ has
C = 2 ζ √(ρA L EI/L³) · mΦ diag(λ) Φᵀm.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from kane import expect
from kane.errors import ModelError, none_of
from kane.expr.build import add, div, mul, sqrt
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.symbols import Coordinate, rate
from kane.model.beams import deformation
from kane.model.beams.shape_functions import ModeShapes, slopes
from kane.model.bodies import Part
from kane.model.joints.joint import mirrored
from kane.model.loads import Load
from kane.numeric.arrays import Array, product
from kane.numeric.sampling import not_negative
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


class Matter(NamedTuple):
    """Mass per length, and moments of inertia per length, where used: about the axis, and about the axis of each bending."""

    mass: deformation.Tapered
    polar: deformation.Tapered | None
    rotary: tuple[deformation.Tapered, ...] = ()


def particles(name: str, root: Point, whole: deformation.Fields, matter: Matter) -> list[Part]:
    """Particles at the stations of the nonlinear form."""
    shapes = [f.shapes for f in whole.shifting]
    bending = [f.shapes for f in whole.sagging] if whole.stiffening else []
    rule = deformation.stations(shapes, bending, matter.mass.share)
    shares = rule.weights * matter.mass.share(rule.places)
    total = mul(matter.mass.value, whole.length)
    return [
        Part(f"{name} station {k}", mul(constant(float(m)), total), root.at(f"{name} station {k}", whole.place(x)))
        for k, (x, m) in enumerate(zip(rule.places, shares, strict=True), 1)
    ]


def sharing(name: str, root: Point, whole: deformation.Fields, matter: Matter) -> list[Part]:
    """Points with shared momentum, of the linearized form."""
    places: list[tuple[str, Vector]] = [("axis", whole.axis * whole.length)]
    for f in whole.shifting:
        places += [
            (q.name, f.along * mul(constant(float(c)), q)) for c, q in zip(f.shapes.units, f.coordinates, strict=True)
        ]
    mu = _mu(whole, matter)
    if whole.stiffening and whole.bending:
        moments, unit = _shortening_moments(whole, matter), matter.mass.share.root**2
        places += [("shortening", whole.axis * whole.shortening(moments[0]))]
        places += [("shortening moment", whole.axis * whole.shortening(moments[1]))]
        mu = np.pad(mu, (0, 2))
        mu[0, -2] = mu[-2, 0] = mu[1, -1] = mu[-1, 1] = unit
    points = [root, *(root.at(f"{name} {what}", d) for what, d in places)]
    differences = np.eye(len(mu))  # μ is for the velocities v_0 and v_k − v_0, the rows are for v_0 and v_k
    differences[1:, 0] = -1.0
    rows = product(product(differences.T, mu), differences)
    total = mul(matter.mass.value, whole.length)

    def times(x: float) -> Expr:
        return mul(constant(float(x)), total) if x else ZERO

    parts = []
    for k, (point, row) in enumerate(zip(points, rows, strict=True)):
        momenta = tuple((p, times(x)) for p, x in zip(points, row, strict=True) if x)
        parts.append(Part(point.name if k else f"{name} root", times(row.sum()), point, momenta=momenta))
    return parts


def _mu(whole: deformation.Fields, matter: Matter) -> Array:
    """μ of 1, ξ and the functions of all deformations, each divided by its unit, in units of ρA L."""
    rule = deformation.fine([f.shapes for f in whole.shifting], matter.mass.share)
    x = rule.places
    values = np.hstack(
        [np.ones((len(x), 1)), x[:, None], *(f.shapes.evaluate(x, 0) / f.shapes.units for f in whole.shifting)]
    )
    mu = deformation.cleaned(rule.gram(values, values, matter.mass.share(x)), ROUNDED)
    return deformation.rounded((mu + mu.T) / 2, matter.mass.share.root)


def _shortening_moments(whole: deformation.Fields, matter: Matter) -> tuple[list[Array], list[Array]]:
    """∫ r H dξ and ∫ r ξ H dξ of each deflection, divided by the units of its functions."""
    result: tuple[list[Array], list[Array]] = [], []
    for f in whole.sagging:
        rule = deformation.fine([f.shapes], matter.mass.share)
        slopes = f.shapes.evaluate(rule.places, 1)
        for each, m in zip(result, deformation.moments_beyond(matter.mass.share, rule.places), strict=True):
            each.append(rule.gram(slopes, slopes, m / matter.mass.share.root**2))
    return result


def slices(name: str, root: Point, frame: Frame, whole: deformation.Fields, matter: Matter) -> list[Part]:
    """Sections at stations, with inertia about the axis for the twist, and about the axes of bending if `matter` has it."""
    twist = [f.shapes for f in whole.fields if f.stem == "t"]
    bending = whole.bending if matter.rotary else ()
    about = [(whole.axis, matter.polar)] if matter.polar is not None else []
    about += [(f.turn, inertia) for f, inertia in zip(bending, matter.rotary, strict=True) if f.turn is not None]
    shapes = [*twist, *(slopes(f.shapes) for f in bending)]
    breaks = tuple(sorted({b for _, inertia in about for b in inertia.share.breaks}))
    rules = [deformation.stations(shapes, [], inertia.share._replace(breaks=breaks)) for _, inertia in about]
    rule = max(rules, key=lambda r: len(r.places), default=None)
    if rule is None:
        return []
    seen = whole if matter.rotary else whole._replace(fields=tuple(f for f in whole.fields if f.stem == "t"))
    parts = []
    for k, (x, w) in enumerate(zip(rule.places, rule.weights, strict=True), 1):
        section = deformation.section_frame(f"{name} section {k}", frame, seen, x)
        dyads = []
        for axis, inertia in about:
            e = mirrored(axis, frame, section)
            share = float(w * inertia.share(np.array([x]))[0])
            dyads.append((e * mul(constant(share), mul(inertia.value, whole.length)), e))
        parts.append(Part(section.name, ZERO, root, section, Dyadic(tuple(dyads))))
    return parts


Matrices = Sequence[tuple[deformation.Field, Sequence[tuple[Expr, Array]]]]
"""C, for each field a sum of values times matrices of numbers."""


class Gauges:
    """The gauges of a beam's coordinates; for a coordinate that is an angle, its product with the beam's length."""

    def __init__(self, name: str, root: Point, length: Expr, fields: Sequence[deformation.Field]) -> None:
        origin = root.root()
        n = origin.frame.x
        self.direction = n
        self.points: dict[Coordinate, Point] = {}
        self.arms: dict[Coordinate, Expr] = {}
        for f in fields:
            for q in f.coordinates:
                arm = length if f.stem == "t" else ONE
                self.arms[q] = arm
                self.points[q] = origin.at(f"{name} gauge of {q.name}", n * mul(arm, q))

    def load(self, name: str, matrices: Matrices, of: Callable[[Coordinate], Expr], potential: Expr | None) -> Load:
        """The load −C x on the gauges, with x given for each coordinate by `of`."""
        on = []
        for f, terms in matrices:
            x = [of(q) for q in f.coordinates]
            for i, q in enumerate(f.coordinates):
                force = reduce(add, (mul(value, deformation.combined(c[i], x)) for value, c in terms), ZERO)
                on.append((self.points[q], self.direction * div(-force, self.arms[q])))
        return Load(name, tuple(on), potential=potential)


def stiffness(f: deformation.Field) -> Array:
    """Stiffness matrix (n × n) without units: ∫ e φ''_i φ''_j dξ of bending, ∫ e φ'_i φ'_j dξ of stretch and twist."""
    return strain(f.shapes, f.stiffness.share, 2 if f.bends else 1)


def strain(shapes: ModeShapes, share: deformation.Share, order: int) -> Array:
    """∫ e φ_i φ_j dξ (n × n) with the derivatives φ of the given order."""
    rule = deformation.fine([shapes], share)
    values = shapes.evaluate(rule.places, order)
    k = deformation.cleaned(rule.gram(values, values, share(rule.places)), ROUNDED_CHAIN)
    return np.asarray((k + k.T) / 2)


def stiffness_value(f: deformation.Field, length: Expr) -> Expr:
    """The factor of the stiffness matrix: EI/L³, EA/L or GJ/L."""
    return div(f.stiffness.value, length**3 if f.bends else length)


def elasticity(name: str, gauges: Gauges, length: Expr, fields: Sequence[deformation.Field]) -> Load:
    """The elastic load, with the strain energy ½ qᵀ K q as its potential."""
    k = [(f, stiffness_value(f, length), stiffness(f)) for f in fields]
    energy = reduce(add, (mul(value, deformation.quadratic(c / 2, f.coordinates)) for f, value, c in k), ZERO)
    return gauges.load(f"elasticity of {name}", [(f, [(value, c)]) for f, value, c in k], lambda q: q, energy)


_DIGITS = 30
_DAMPING = ("mass", "stiffness", "ratio")


def damping_of(
    name: str, gauges: Gauges, whole: deformation.Fields, matter: Matter, damping: Mapping[str, Any] | None
) -> tuple[Load, ...]:
    """The damping load; none without damping."""
    if damping is None:
        return ()
    given: object = damping
    expected = f'damping= of {name} as {{"mass": α, "stiffness": β}} or {{"ratio": ζ}}'
    expect.that(isinstance(given, Mapping) and given, expected, damping)
    for kind in damping:
        if kind not in _DAMPING:
            raise ModelError(f"Expected damping= of {name} by some of {none_of(_DAMPING, kind)}")
    if any(f.stem in deformation.SHEAR.values() for f in whole.fields):
        expected, given = f'damping= of {name}, which shears, as {{"stiffness": β}}', ", ".join(map(repr, damping))
        came = f"{given}: its modes are those of bending and shear together"
        expect.that(set(damping) == {"stiffness"}, expected, came=came)
    values = {kind: _parameter(name, kind, x) for kind, x in damping.items()}
    matrices = [(f, _terms(f, whole, matter, values)) for f in whole.fields]
    return (gauges.load(f"damping of {name}", matrices, rate, None),)


def _parameter(name: str, kind: str, given: Any) -> Expr:
    """A nonnegative value, in parameters; raises ModelError."""
    return deformation.in_parameters(name, kind, not_negative(given, f"damping {kind!r} of {name}"), meaning="damping")


def _terms(
    f: deformation.Field, whole: deformation.Fields, matter: Matter, damping: Mapping[str, Expr]
) -> list[tuple[Expr, Array]]:
    inert = matter.polar if f.stem == "t" else matter.mass
    assert inert is not None
    rule = deformation.fine([f.shapes], inert.share)
    values = f.shapes.evaluate(rule.places, 0)
    m, k = deformation.cleaned(rule.gram(values, values, inert.share(rule.places)), ROUNDED), stiffness(f)
    mass, stiff = mul(inert.value, whole.length), stiffness_value(f, whole.length)
    terms = []
    if "mass" in damping:
        terms.append((mul(damping["mass"], mass), m))
    if "stiffness" in damping:
        terms.append((mul(damping["stiffness"], stiff), k))
    if "ratio" in damping:
        terms.append((mul(2 * damping["ratio"], sqrt(mul(mass, stiff))), _critical(m, k)))
    return terms


def _critical(m: Array, k: Array) -> Array:
    """mΦ diag(λ) Φᵀm, computed with extra digits, as the last digits of LAPACK's results depend on the machine."""
    import mpmath

    with mpmath.workdps(_DIGITS):
        lower = mpmath.cholesky(mpmath.matrix(m.tolist()))
        inverse = lower**-1
        squares, modes = mpmath.eigsy(inverse * mpmath.matrix(k.tolist()) * inverse.T)
        half = lower * modes
        c = half * mpmath.diag([mpmath.sqrt(max(x, 0)) for x in squares]) * half.T
        return deformation.cleaned(np.array(c.tolist(), dtype=float), ROUNDED_CHAIN)
