# SPDX-License-Identifier: BSD-3-Clause
"""A load's potential against its forces: at random states, Σ F·∂v/∂q̇ + Σ T·∂ω/∂q̇ = −∂V/∂q.

Where there are constraints, at configurations that satisfy them; what differs may be along a constraint's force alone.
"""

import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived
from kane.errors import KaneWarning
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Speed, Symbol
from kane.kinematics.sample import Sample
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.bounds import ROUNDING, bounded
from kane.numeric.sampling import draw
from kane.numeric.scale import SIX_DIGITS
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

_SEED, _STATES = 20091, 6
_WIDE = 1.2


def check_potentials(derived: Derived) -> None:
    """Warn of each load whose potential is not that of its forces: its work would be wrong, and so the energy."""
    loads = [load for load in derived.system.loads if load.potential is not None]
    samples = list(_samples(derived)) if loads else []
    for load in loads:
        found = [at for sample, a in samples if (at := _differs(load, sample, a, derived.system.inertial)) is not None]
        if any(found):
            warnings.warn(
                f"Expected the potential of {load.name!r} to be that of its forces, F·v + T·ω = −dV/dt, got another one: they differ "
                "at random states. The motion is right, its energy and work are not. Correct the potential's sign or factor, or leave "
                "it out: the work of the forces then counts as power.",
                KaneWarning,
                stacklevel=3,
            )


def _samples(derived: Derived) -> Iterable[tuple[Sample, Array | None]]:
    """States at which loads are looked at, with A there, None without constraints."""
    if derived.constraints.constraints:
        places = derived.compared.at
        for k in range(min(places.count, _STATES)):
            yield Sample(derived.kinematical, _SEED + k, _drawn(derived, k, places.at(k))), derived.compared.a[k]
        return
    for k in range(_STATES):
        yield Sample(derived.kinematical, _SEED + k, _drawn(derived, k, {})), None


def _drawn(derived: Derived, k: int, known: Mapping[Symbol, float]) -> dict[Expr, Any]:
    """Coordinates and speeds on both sides of zero in every other state: what is switched there is seen in both positions."""
    low = -_WIDE if k % 2 else 0.3
    moving: dict[Expr, Any] = {
        s: draw(_SEED + k, s, low, _WIDE) for s in (*derived.system.coordinates, *derived.speeds)
    }
    defaults: dict[Expr, Any] = {p: p.default for p in derived.system.parameters if p.default is not None}
    return {**moving, **defaults, **dict(known.items())}


def _differs(load: Load, sample: Sample, a: Array | None, inertial: Frame) -> bool | None:
    """Whether the potential's generalized forces are others than the load's; None where a number is not finite."""
    assert load.potential is not None
    slope = time_derivative(load.potential)
    width = len(sample.speeds.rates) + 1
    steep, error = (np.broadcast_to(x, (width,)) for x in bounded([slope], _numbers(sample, [slope]))[0])
    held = steep[:-1] - steep[-1]
    pushed, size, left = np.zeros(width - 1), np.abs(held), error[:-1] + error[-1]
    acting: list[tuple[Point | Frame, Vector]] = [*load.forces, *load.torques]
    for place, force in acting:
        velocity = _motion(place, inertial)
        motion, moved = _in_root(sample, velocity, _numbers(sample, velocity.scalars()), width)
        pull, off = _in_root(sample, force, {s: _number(sample, s) for s in free_symbols(force.scalars())})
        partial = motion[:, :-1] - motion[:, -1:]
        pushed, size = pushed + pull[:, 0] @ partial, size + np.abs(pull[:, 0]) @ np.abs(partial)
        left = left + np.abs(pull).sum() * (moved[:-1] + moved[-1]) + off[0] * np.abs(partial).sum(axis=0)
    gap, left = pushed + held, np.nan_to_num(left, posinf=0.0)
    if not (np.isfinite(gap).all() and np.isfinite(size).all()):
        return None
    if a is None or not len(a):
        return bool((np.abs(gap) > SIX_DIGITS * size + left).any())
    w = sample.inverse
    own, whole = gap @ w, (size + left / SIX_DIGITS) @ np.abs(w)
    left = own - np.linalg.lstsq(a.T, own, rcond=None)[0] @ a
    return bool((np.abs(left) > SIX_DIGITS * whole.max(initial=0)).any())


def _motion(place: Point | Frame, inertial: Frame) -> Vector:
    return place.velocity(inertial) if isinstance(place, Point) else place.angular_velocity(inertial)


def _numbers(sample: Sample, exprs: Iterable[Expr]) -> dict[Symbol, Any]:
    """Values of the symbols, those of rates with an entry a rate and one for all at rest."""
    symbols = free_symbols(exprs)
    return dict(zip(symbols, sample.numbers(symbols), strict=True))


def _in_root(sample: Sample, v: Vector, values: Mapping[Symbol, Any], width: int = 1) -> tuple[Array, Array]:
    """Measure numbers along the root's axes (3 × width), and how far rounding may carry any of them (width)."""
    total, error = np.zeros((3, width)), np.zeros(width)
    for frame, triple in v.parts:
        parts = [[np.broadcast_to(x, (width,)) for x in pair] for pair in bounded(triple, values)]
        numbers, bounds = np.swapaxes(np.array(parts), 0, 1)
        total = total + sample.turn(frame) @ numbers
        error = error + (bounds + len(frame.lineage) * ROUNDING * np.abs(numbers)).sum(axis=0)
    return total, error


def _number(sample: Sample, s: Symbol) -> float:
    if isinstance(s, Coordinate | Speed):
        return float(sample.values[s])
    (value,) = sample.numbers([s])
    return float(value) if np.ndim(value) == 0 else draw(sample.seed, s)
