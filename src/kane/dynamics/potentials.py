# SPDX-License-Identifier: BSD-3-Clause
"""A load's potential against its forces: at random states, Σ F·∂v/∂q̇ + Σ T·∂ω/∂q̇ = −∂V/∂q.

Where there are constraints, at configurations that satisfy them; what differs may be along a constraint's force alone.
"""

import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from kane.dynamics.derived import Derived
from kane.errors import KaneWarning
from kane.expr.diff import time_derivative
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Speed, Symbol
from kane.kinematics.sample import Sample
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.sample import draw
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

_SEED, _STATES = 20091, 6
_WIDE = 1.2
_DIFFERS = 1e-6
"""Share of its terms by which a generalized force may differ from the potential's: rounding leaves less, another formula more."""


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
    (slope,) = sample.numbers([time_derivative(load.potential)])
    width = len(sample.speeds.rates) + 1
    steep = np.broadcast_to(slope, (width,))
    held = steep[:-1] - steep[-1]
    pushed, size = np.zeros(width - 1), np.abs(held)
    acting: list[tuple[Point | Frame, Vector]] = [*load.forces, *load.torques]
    for place, force in acting:
        motion = sample.in_root(_motion(place, inertial))
        pull, partial = _at_rates(sample, force), motion[:, :-1] - motion[:, -1:]
        pushed, size = pushed + pull @ partial, size + np.abs(pull) @ np.abs(partial)
    gap = pushed + held
    if not (np.isfinite(gap).all() and np.isfinite(size).all()):
        return None
    if a is None or not len(a):
        return bool((np.abs(gap) > _DIFFERS * size).any())
    w = sample.inverse
    own, whole = gap @ w, np.abs(size) @ np.abs(w)
    left = own - np.linalg.lstsq(a.T, own, rcond=None)[0] @ a
    return bool((np.abs(left) > _DIFFERS * whole.max(initial=0)).any())


def _motion(place: Point | Frame, inertial: Frame) -> Vector:
    return place.velocity(inertial) if isinstance(place, Point) else place.angular_velocity(inertial)


def _at_rates(sample: Sample, v: Vector) -> Array:
    """Measure numbers of a force along the root's axes, with a number for every rate."""
    total = np.zeros(3)
    for frame, triple in v.parts:
        values = {s: _number(sample, s) for s in free_symbols(triple)}
        total = total + sample.turn(frame) @ np.array(evaluate(list(triple), values), dtype=float)
    return total


def _number(sample: Sample, s: Symbol) -> float:
    if isinstance(s, Coordinate | Speed):
        return float(sample.values[s])
    (value,) = sample.numbers([s])
    return float(value) if np.ndim(value) == 0 else draw(sample.seed, s)
