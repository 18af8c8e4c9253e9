# SPDX-License-Identifier: BSD-3-Clause
"""Forces by the rates of the coordinates: Q_s = Σ F·∂v/∂q̇_s + Σ T·∂ω/∂q̇_s, so that F_r = Σ_s Q_s W_sr for any speeds.

With them rows C of the constraints in the rates, C q̇ + c = 0, and the states at which both are looked at in numbers.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from kane.dynamics.derivation import Derived
from kane.expr.build import add, mul
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, Parameter, QuasiRate, Rate, Speed, Symbol, rate
from kane.expr.visit import substituted
from kane.model.loads import Load
from kane.numeric.arrays import Array, Mask
from kane.numeric.sampling import SEED, draw
from kane.numeric.scale import UNRELATED
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import Triple
from kane.space.vector import Vector

Exprs = tuple[Expr, ...]
Place = dict[Expr, float]

_PLACES, _WIDE = 8, 1.2
_ABOUT = (0.7, 1.3)
"""Multiples of their defaults between which parameters are drawn."""
_NEIGHBOURS, _STEP, _SPREAD = 4, 1e-11, 0.1
"""Places near by at which a number is computed again, how far they are, and by which share what is not of rounding changes at most."""


def by_rates(derived: Derived, loads: Iterable[Load]) -> Exprs:
    """Q, one a coordinate, Euler parameters too: of these what is along their length means nothing."""
    q_dot = tuple(map(rate, derived.system.coordinates))
    quasi = quasi_rates(derived)
    total: dict[Expr, Expr] = dict.fromkeys(q_dot, ZERO)
    for load in loads:
        acting: list[tuple[Point | Frame, Vector]] = [*load.forces, *load.torques]
        for place, vector in acting:
            for triple, rows in _powers(place, vector, derived.system.inertial, quasi):
                for x, (own, _) in zip(triple, affine_forms(rows, q_dot), strict=True):
                    total.update((s, add(total[s], mul(x, c))) for s, c in own.items())
    return tuple(total[r] for r in q_dot)


def _powers(
    place: Point | Frame, vector: Vector, inertial: Frame, quasi: Mapping[Expr, Expr]
) -> Iterable[tuple[Triple, list[Expr]]]:
    """Measure numbers of a force or torque, and those of the motion of its place, in rates.

    Where there are Euler parameters a point's velocity is the derivative of its place, whatever their length: so forces that have a
    potential energy have one off unit length too.
    """
    motion = place.velocity(inertial) if isinstance(place, Point) else place.angular_velocity(inertial)
    if isinstance(place, Point) and quasi and not _of_a_body(place):
        moved = [time_derivative(x) for x in place.position(place.root()).components(inertial)]
        yield vector.components(inertial), moved
        return
    memo: dict[Expr, Expr] = {}
    for frame, triple in vector.parts:
        yield triple, [substituted(x, quasi, memo) for x in motion.components(frame)]


def _of_a_body(point: Point) -> bool:
    """Whether a point, or one that it is reached from, is a particle of a body: its place says nothing of its velocity."""
    p: Point | None = point
    while p is not None and p.body is None:
        p = p.parent
    return p is not None


def quasi_rates(derived: Derived) -> dict[Expr, Expr]:
    """w of Euler parameters by ė: w = 2 (e₀ ė − ė₀ e − e × ė)."""
    found: dict[Expr, Expr] = {}
    for s in derived.system.euler_parameters:
        e0, e1, e2, e3 = s.coordinates
        d0, d1, d2, d3 = (rate(e) for e in s.coordinates)
        rows = (
            e0 * d1 - d0 * e1 - (e2 * d3 - e3 * d2),
            e0 * d2 - d0 * e2 - (e3 * d1 - e1 * d3),
            e0 * d3 - d0 * e3 - (e1 * d2 - e2 * d1),
        )
        found.update((w, 2 * row) for w, row in zip(s.quasi, rows, strict=True))
    return found


def rows_in_rates(derived: Derived) -> list[list[Expr]]:
    """C of the constraints C q̇ + c = 0, then eᵀė = 0 of each set of Euler parameters."""
    q_dot = tuple(map(rate, derived.system.coordinates))
    roots = [time_derivative(c.expr) if c.kind == "configuration" else c.expr for c in derived.constraints.constraints]
    quasi, memo = quasi_rates(derived), dict[Expr, Expr]()
    forms = [own for own, _ in affine_forms([substituted(x, quasi, memo) for x in roots], q_dot)]
    forms += [{rate(e): e for e in s.coordinates} for s in derived.system.euler_parameters]
    return [[own.get(r, ZERO) for r in q_dot] for own in forms]


def places(
    exprs: Iterable[Expr],
    known: Sequence[Mapping[Symbol, float]] = (),
    unit: Sequence[Sequence[Symbol]] = (),
    *,
    varied: bool = True,
) -> list[Place]:
    """Values of all symbols at a few places: those that are `known`, else drawn, on both sides of zero in every other place.

    Parameters are drawn too, about their defaults, unless they are not to be `varied`: what is said is said of all their values, and a
    damping that is zero by default is damping. Sets of Euler parameters have `unit` length.
    """
    symbols = free_symbols(exprs)
    starts: Sequence[Mapping[Symbol, float]] = known or [{}] * _PLACES
    found: list[Place] = [{s: _value(s, k, start, varied) for s in symbols} for k, start in enumerate(starts)]
    for place in found:
        for group in unit:
            length = np.linalg.norm([place.get(e, draw(SEED, e)) for e in group])
            place.update((e, place.get(e, draw(SEED, e)) / float(length)) for e in group)
    return found


def _value(s: Symbol, k: int, known: Mapping[Symbol, float], varied: bool) -> float:
    if s in known:
        return float(known[s])
    if isinstance(s, Parameter) and s.default:
        return float(s.default) * (draw(SEED + k, s, *_ABOUT) if varied else 1.0)
    k = k if varied or not isinstance(s, Parameter) else 0
    wide = isinstance(s, Coordinate | QuasiRate | Rate | Speed) and k % 2
    return draw(SEED + k, s, -_WIDE if wide else 0.3, _WIDE)


def measured(exprs: Sequence[Expr], at: Sequence[Place]) -> Array:
    """Values of some expressions, each place a row; NaN where they are not finite."""
    with np.errstate(all="ignore"):
        found = np.array([np.array(evaluate(list(exprs), dict(place)), dtype=float) for place in at])
    found = found.reshape(len(at), len(exprs))
    found[~np.isfinite(found)] = np.nan
    return found


def differs(groups: Sequence[Sequence[Expr]], at: Sequence[Place]) -> tuple[Array, Mask]:
    """Sums of groups of terms at some places (places × groups), and where they are more than rounding leaves.

    A sum is zero where it is a small share of its terms, or where it is another number as near by as rounding shows: what rounding
    leaves of zero has other digits wherever it is computed.
    """
    if not groups:
        return np.zeros((len(at), 0)), np.zeros((len(at), 0), dtype=bool)
    flat = [e for group in groups for e in group]
    ends = np.cumsum([len(group) for group in groups])[:-1]

    def sums(table: Array) -> Array:
        return np.array([part.sum(axis=1) for part in np.split(table, ends, axis=1)]).reshape(len(groups), -1).T

    values = measured(flat, at)
    total, terms = sums(values), sums(np.abs(values))
    spread = np.zeros(total.shape)
    for k in range(_NEIGHBOURS):
        spread = np.fmax(spread, np.abs(sums(measured(flat, [_near(place, k) for place in at])) - total))
    with np.errstate(invalid="ignore"):
        told = (np.abs(total) > UNRELATED * terms) & (spread <= _SPREAD * np.abs(total))
    return total, np.asarray(told)


def _near(place: Place, k: int) -> Place:
    return {s: x * (1 + _STEP * draw(SEED + k, s, -1.0, 1.0)) for s, x in place.items()}
