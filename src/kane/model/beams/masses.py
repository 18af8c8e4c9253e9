# SPDX-License-Identifier: BSD-3-Clause
"""The parts that a beam's mass is: in the nonlinear form particles at stations, in the linearized form points that share momentum.

Nonlinear: K = ½ Σ m_g v_g·v_g over Gauss's points, as few as integrate the products of all functions, foreshortening included.

Linearized: with r = Σ f_k(ξ) d_k, f = (1, ξ, φ_1, …), and D_k = dd_k/dt, the kinetic energy to second order in the deformation is

    K = ½ Σ μ_kl D_k·D_l,   μ_kl = ∫ ρA f_k f_l dx,

where the foreshortening has μ with 1 and with ξ alone: −qᵀ(∫ r H)q/2L moves with the root, −qᵀ(∫ r ξ H)q/2L with ξ e₁. All D_k are
differences of velocities of points P_k at d_k from the root, so that K = ½ Σ μ'_kl v_k·v_l: the momentum of P_k is Σ_l μ'_kl v_l.
"""

from typing import NamedTuple

import numpy as np

from kane.expr.build import mul
from kane.expr.node import ZERO, Expr, constant
from kane.model.beams.deformation import Fields, Tapered, fine, moments_beyond, rounded, section_frame, stations
from kane.model.beams.shapes import slopes
from kane.model.bodies import Part
from kane.numeric.arrays import Array, product
from kane.numeric.scale import ROUNDED
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Dyadic, Vector


class Matter(NamedTuple):
    """Mass per length, and moments of inertia per length, where the sections' turning counts: about the axis, and of each bending."""

    mass: Tapered
    polar: Tapered | None
    rotary: tuple[Tapered, ...] = ()


def particles(name: str, root: Point, whole: Fields, matter: Matter) -> list[Part]:
    """Particles at the stations of the nonlinear form."""
    shapes = [f.shapes for f in whole.shifting]
    bending = [f.shapes for f in whole.sagging] if whole.stiffening else []
    rule = stations(shapes, bending, matter.mass.share)
    shares = rule.weights * matter.mass.share(rule.places)
    total = mul(matter.mass.value, whole.length)
    return [
        Part(f"{name} station {k}", mul(constant(float(m)), total), root.at(f"{name} station {k}", whole.place(x)))
        for k, (x, m) in enumerate(zip(rule.places, shares, strict=True), 1)
    ]


def sharing(name: str, root: Point, whole: Fields, matter: Matter) -> list[Part]:
    """Points that share their momentum, of the linearized form."""
    places: list[tuple[str, Vector]] = [("axis", whole.axis * whole.length)]
    places += [(q.name, f.along * q) for f in whole.shifting for q in f.coordinates]
    mu = _mu(whole, matter)
    if whole.stiffening and whole.bending:
        moments = _shortening_moments(whole, matter)
        places += [("shortening", whole.axis * whole.shortening(moments[0]))]
        places += [("shortening moment", whole.axis * whole.shortening(moments[1]))]
        mu = np.pad(mu, (0, 2))
        mu[0, -2] = mu[-2, 0] = mu[1, -1] = mu[-1, 1] = 1.0
    points = [root, *(root.at(f"{name} {what}", d) for what, d in places)]
    rows = _by_points(mu)
    total = mul(matter.mass.value, whole.length)

    def times(x: float) -> Expr:
        return mul(constant(float(x)), total) if x else ZERO

    return [
        Part(
            point.name if k else f"{name} root",
            times(row.sum()),
            point,
            momenta=tuple((p, times(x)) for p, x in zip(points, row, strict=True) if x),
        )
        for k, (point, row) in enumerate(zip(points, rows, strict=True))
    ]


def _mu(whole: Fields, matter: Matter) -> Array:
    """μ of 1, ξ and the functions of all deformations, in units of ρA L."""
    rule = fine([f.shapes for f in whole.shifting])
    x = rule.places
    values = np.hstack([np.ones((len(x), 1)), x[:, None], *(f.shapes.evaluate(x, 0) for f in whole.shifting)])
    mu = rule.gram(values, values, matter.mass.share(x))
    size = np.sqrt(np.diag(mu))
    mu[np.abs(mu) < ROUNDED * np.multiply.outer(size, size)] = 0.0
    return rounded((mu + mu.T) / 2)


def _shortening_moments(whole: Fields, matter: Matter) -> tuple[list[Array], list[Array]]:
    """∫ r H dξ and ∫ r ξ H dξ of each deflection."""
    found: tuple[list[Array], list[Array]] = [], []
    for f in whole.sagging:
        rule = fine([f.shapes])
        slopes = f.shapes.evaluate(rule.places, 1)
        for each, m in zip(found, moments_beyond(matter.mass.share, rule.places), strict=True):
            each.append(rule.gram(slopes, slopes, m))
    return found


def _by_points(mu: Array) -> Array:
    """μ' of velocities of points from μ of their differences from the root's: v_0, v_k − v_0."""
    differences = np.eye(len(mu))
    differences[1:, 0] = -1.0
    return product(product(differences.T, mu), differences)


def slices(name: str, root: Point, frame: Frame, whole: Fields, matter: Matter) -> list[Part]:
    """Sections that turn, at stations: about the axis with the twist, and as the beam bends where that counts."""
    twist = [f.shapes for f in whole.fields if f.stem == "t"]
    bending = whole.bending if matter.rotary else ()
    about = [(whole.axis, matter.polar)] if matter.polar is not None else []
    about += [(f.turn, inertia) for f, inertia in zip(bending, matter.rotary, strict=True) if f.turn is not None]
    shapes = [*twist, *(slopes(f.shapes) for f in bending)]
    rules = [stations(shapes, [], inertia.share) for _, inertia in about]
    rule = max(rules, key=lambda r: len(r.places), default=None)
    if rule is None:
        return []
    seen = whole if matter.rotary else whole._replace(fields=tuple(f for f in whole.fields if f.stem == "t"))
    parts = []
    for k, (x, w) in enumerate(zip(rule.places, rule.weights, strict=True), 1):
        section = section_frame(f"{name} section {k}", frame, seen, x)
        dyads = []
        for axis, inertia in about:
            e = Vector(((section, axis.components(frame)),))
            share = float(w * inertia.share(np.array([x]))[0])
            dyads.append((e * mul(constant(share), mul(inertia.value, whole.length)), e))
        parts.append(Part(section.name, ZERO, root, section, Dyadic(tuple(dyads))))
    return parts
