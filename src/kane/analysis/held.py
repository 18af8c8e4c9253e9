# SPDX-License-Identifier: BSD-3-Clause
"""The constraints on the motion at a configuration, in speeds or in rates, also where what is written through W has a pole.

Constraints A_q q̇ + b_q = 0 and speeds u = Y q̇ + z are divided by nothing. Where A may have false poles, or is not finite, the
speeds that are possible are those of the rates that are: with A_q N = 0 and A_q q̇₀ + b_q = 0 those with

    B u = B (Y q̇₀ + z),    B (Y N) = 0
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.state import misses
from kane.analysis.tangents import turning
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.evaluation import evaluate
from kane.expr.matrix import dot
from kane.expr.node import Expr
from kane.expr.symbols import rate
from kane.expr.visit import substituted
from kane.model.completed import constraint_rate
from kane.numeric.arrays import Array
from kane.numeric.projection import least_squares
from kane.numeric.rank import balance, singular
from kane.numeric.scale import DERIVE_RANK, GIVEN

_TOLD = 6


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Constraints `rows` x + `rest` = 0 on x, speeds or rates, with their `names`; the speeds are `to_speeds` x + `added`."""

    names: tuple[str, ...]
    rows: Array
    rest: Array
    to_speeds: Array
    added: Array


def held_at(eom: Equations, at: Mapping[Expr, Any], by_rates: bool) -> Held:
    """The constraints at a configuration, on the speeds or, with `by_rates`, on the rates of the coordinates.

    A SimulationError names constraints or speeds that are not finite there even in rates.
    """
    constraints, n = eom.derived.constraints, len(eom.speeds)
    m = len(constraints.b)
    a = np.asarray(evaluate(constraints.a, at), dtype=float).reshape(m, n)
    b = np.array(evaluate(list(constraints.b), at), dtype=float) if m else np.zeros(0)
    names = tuple(c.name for c in constraints.constraints)
    if _plain(eom, a, b):
        if not by_rates:
            return Held(names, a, b, np.eye(n), np.zeros(n))
        y = np.asarray(evaluate(eom.Y, at), dtype=float)[:n]
        z = np.array(evaluate(list(eom.z), at), dtype=float)[:n]
        return Held(names, a @ y, a @ z + b, y, z)
    y, z, c, rest = _in_basic_rates(eom, at)
    names = tuple(k.name for k in eom.system.constraints)
    if by_rates:
        spread = _basic(eom, at)
        return Held(names, c @ spread, rest, y @ spread, z)
    return _possible(names, y, z, c, rest)


def _plain(eom: Equations, a: Array, b: Array) -> bool:
    """Whether A u + b = 0 says what is held as it stands."""
    return eom.solved.twin is None and bool(np.isfinite(a).all() and np.isfinite(b).all())


def _in_basic_rates(eom: Equations, at: Mapping[Expr, Any]) -> tuple[Array, Array, Array, Array]:
    """Y, z, A_q, b_q in the basic rates, those of coordinates and the quasi-rates of Euler parameters."""
    speeds, system = eom.derived.kinematical, eom.system
    rows = [dot(list(row.values()), list(row)) + z for row, z in zip(speeds.rows, speeds.z, strict=True)]
    held = [substituted(constraint_rate(c), speeds.euler_rates) for c in system.constraints]
    count = len(speeds.rates)
    unit = dict(zip(speeds.rates, np.eye(count, count + 1), strict=True))
    with np.errstate(all="ignore"):
        wide = [np.broadcast_to(x, count + 1) for x in evaluate([*rows, *held], {**at, **unit})]
    numbers = np.array(wide, dtype=float)
    labels = [*(f"the speed {u}" for u in eom.speeds), *(repr(c.name) for c in system.constraints)]
    lost = [x for x, row in zip(labels, numbers, strict=True) if not np.isfinite(row).all()]
    if lost:
        place = [f"{q} = {float(at[q]):.6g}" for q in eom.coordinates if at[q]]
        where = ", ".join(place[:_TOLD]) or "zero of all coordinates"
        raise SimulationError(
            f"Expected constraints and speeds that are finite at this configuration, got infinity or NaN of {', '.join(lost)} at "
            f"{where}. The coordinates are singular there: take a configuration beside it, or other coordinates (another sequence "
            "of angles)."
        )
    rest = numbers[:, -1]
    linear, n = numbers[:, :-1] - rest[:, None], len(eom.speeds)
    return linear[:n], rest[:n], linear[n:], rest[n:]


def _basic(eom: Equations, at: Mapping[Expr, Any]) -> Array:
    """The basic rates by those of the coordinates: ω = 2 E(e)ᵀ ė of Euler parameters."""
    rates = {r: k for k, r in enumerate(eom.derived.kinematical.rates)}
    place = {q: k for k, q in enumerate(eom.coordinates)}
    spread = np.zeros((len(rates), len(place)))
    for q, k in place.items():
        if rate(q) in rates:
            spread[rates[rate(q)], k] = 1.0
    for s in eom.system.euler_parameters:
        e = np.array([float(at[q]) for q in s.coordinates])
        spread[np.ix_([rates[w] for w in s.quasi], [place[q] for q in s.coordinates])] = 4 * turning(e).T
    return spread


def _possible(names: tuple[str, ...], y: Array, z: Array, c: Array, rest: Array) -> Held:
    """B u = B (Y q̇₀ + z)."""
    scaled = balance(c)
    wanted = -rest / scaled.rows[:, 0]
    first = least_squares(scaled.matrix, wanted)
    bad = misses(names, scaled.matrix @ first - wanted, limit=GIVEN * np.abs(wanted).max(initial=0))
    if bad:
        raise SimulationError(
            f"Expected constraints that some rates satisfy together at this configuration, got {bad} at best. It is a singular "
            "configuration: take one beside it."
        )
    open_ = singular(scaled.matrix).kernel(DERIVE_RANK) / scaled.columns
    moved = balance(y @ open_.T)
    b = singular(moved.matrix).cokernel(DERIVE_RANK) / moved.rows[:, 0]
    together = f"{', '.join(names)}{' together' if len(names) > 1 else ''}"
    return Held((together,) * len(b), b, -b @ (y @ (first / scaled.columns[0]) + z), np.eye(len(y)), np.zeros(len(y)))
