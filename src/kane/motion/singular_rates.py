# SPDX-License-Identifier: BSD-3-Clause
"""Where the rates are not determined by the speeds: W of q̇ = W u + X divides by what vanishes at a state.

The pivots of W are compared with their size at a random configuration: cos q2 = 6e-17 at q2 = π/2 is zero.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.poles import AdmittedSpeeds
from kane.equations.derive import repartition
from kane.equations.equations import Equations
from kane.errors import SimulationError, cut
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate
from kane.numeric.arrays import Array
from kane.numeric.rank import balance, singular
from kane.numeric.sampling import sample
from kane.numeric.scale import MOTION_RANK, SOLVE_RANK, TAKES_PART, UNRELATED

_SEED = 20049


class Vanishing(NamedTuple):
    """A pivot of W, its value at a state, and its size there relative to that at a random configuration."""

    pivot: Expr
    value: float
    relative: float

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates that it holds."""
        return tuple(s for s in free_symbols([self.pivot]) if isinstance(s, Coordinate))

    def __str__(self) -> str:
        return f"{cut(self.pivot, 80)} = {self.value:.3g}"


def pivots(eom: Equations, values: Mapping[Expr, Any]) -> list[Vanishing]:
    """The pivots of W that change with the configuration, the smallest first."""
    moving = [p for p in dict.fromkeys(eom.solved.regular.kinematical.pivots) if not is_constant_in_time([p])]
    if not moving:
        return []
    usual = [abs(x) for x in sample(moving, _SEED)]
    rows = [
        Vanishing(p, float(v), abs(float(v)) / (scale or 1.0))
        for p, v, scale in zip(moving, evaluate(moving, values), usual, strict=True)
    ]
    return sorted(rows, key=lambda r: r.relative)


def check_regular(eom: Equations, values: Mapping[Expr, Any], t: float) -> None:
    """Y must be invertible at the start; the error names the pivot of W that vanishes, and the rates that are left open."""
    small = pivots(eom, values)
    if not small:
        return
    speeds = eom.solved.regular.kinematical
    rates = speeds.rates
    free = _free_direction([[r.get(b, ZERO) for b in rates] for r in speeds.rows], values)
    if free is None:
        return
    named = [r for r in small if r.relative <= UNRELATED] or small[:1]
    open_ = ", ".join(str(b) for b, c in zip(rates, free, strict=True) if abs(c) > TAKES_PART)
    where = ", ".join(f"{q} = {float(values[q]):.6g}" for q in dict.fromkeys(q for r in named for q in r.coordinates))
    raise SimulationError(
        f"Expected finite rates at the start, got none for {open_} at t = {t:g}: the kinematics are singular at {where}, where W of "
        f"q' = W u + X divides by {', '.join(map(str, named))}. Start elsewhere, or choose coordinates that are regular here (another "
        "sequence of angles, Euler parameters)."
    )


def regular_otherwise(
    eom: Equations, values: Mapping[Expr, Any], admitted: AdmittedSpeeds, made: Callable[..., Equations]
) -> Equations | None:
    """Equations with other dependent speeds that follow at a state where those of `eom` do not, and whose W has no pole there.

    `made` keeps what is derived anew: made(repartition, partition).
    """
    assert eom.embedding is not None
    others = admitted.others(values, eom.embedding.partition.dependent)
    if others is None:
        return None
    found = made(repartition, admitted.partition(values, eom.embedding.partition, others))
    least, now = (min((p.relative for p in pivots(e, values)), default=1.0) for e in (found, eom))
    return found if least > now else None


def _free_direction(rows: list[list[Expr]], values: Mapping[Expr, Any]) -> Array | None:
    """x with Y x = 0, the rows and columns of Y measured by their size at a random configuration; None where Y is regular.

    A row that vanishes at this configuration alone must count as zero, whatever is left of it by rounding.
    """
    y = np.asarray(evaluate(Matrix(rows), values), dtype=float)
    usual = np.abs(np.array(sample([x for row in rows for x in row], _SEED)).reshape(y.shape))
    if not (np.all(np.isfinite(y)) and np.all(np.isfinite(usual))):
        return None
    size = balance(usual, order=(1, 0), rounding=0.0)
    scaled = singular(y / size.rows / size.columns)
    return None if scaled.regular(SOLVE_RANK) else scaled.right[-1]


def nearly_singular(eom: Equations, values: Mapping[Expr, Any]) -> str:
    """What to add to the message of a motion that broke off near a singularity of W, if it did."""
    near = [r for r in pivots(eom, values) if r.relative < MOTION_RANK]
    return f"; W of q' = W u + X divides by {', '.join(map(str, near))} there" if near else ""
