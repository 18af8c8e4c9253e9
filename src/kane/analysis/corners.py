# SPDX-License-Identifier: BSD-3-Clause
"""Which switches stand at zero at a state, and whether it makes a difference on which side of them it is left.

Only what differs counts: x |x| and guarded quotients have one derivative on both sides, however they are written.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.flow import Flow
from kane.analysis.outputs import Outputs
from kane.analysis.sides import Corner, Piece, pieces
from kane.analysis.turning import all_switches, turning
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.expr.ops import GONE
from kane.expr.switching import Switch
from kane.numeric.arrays import Mask
from kane.numeric.rank import balance
from kane.numeric.scale import EQUAL, ROUNDED_SUM

_AS_ZERO = 1e-4
"""Share of a tolerance by which a steady state that was solved for is off."""


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """The pieces that meet at a corner, and its switches."""

    corner: Corner
    switches: tuple[Switch, ...]
    pieces: tuple[Piece, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """What can be changed: states and inputs."""
        flow = self.corner.flow
        return (*flow.states, *(r.name for r in flow.numeric.equations.inputs))


def sides_at(flow: Flow, outputs: Outputs, tolerance: float) -> Sides | None:
    """The sides of the switches that stand at zero at the flow's state, None where none do.

    Zero is what rounding leaves of the terms, and at a state that is steady up to a `tolerance`, what solving for it leaves.
    """
    numeric = flow.numeric
    table = numeric.value(all_switches, *outputs.roots)
    if not table:
        return None
    state, z = flow.state, flow.z
    run = numeric.value(_watch, *outputs.roots)
    own = run([state.t, *state.x, *state.p, *state.r, *z])
    c, zero = np.abs(own.quantities), GONE * own.sizes
    if tolerance > 0 and np.isfinite(flow.a).all():
        change = own.slopes @ np.vstack([flow.moves, flow.answers])[:, : len(flow.a)]
        zero = np.maximum(zero, _AS_ZERO * tolerance * np.abs(change @ np.linalg.pinv(flow.a)) @ flow.terms)
    at = tuple(np.flatnonzero(c <= zero).tolist())
    if not at:
        return None
    corner = Corner(flow, outputs, at, zero[list(at)])
    standing = tuple(table[k] for k in at)
    return Sides(corner, standing, pieces(corner, [s.quantity for s in standing]))


def _watch(eom: Equations, *outputs: Expr) -> Any:
    bundle = turning(eom, *outputs)
    return bundle.reference([s for port in bundle.ports for s in port.symbols])


# What differs ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Difference:
    """Which of the switches make a difference; and which of ẋ and the outputs jump there."""

    switches: tuple[int, ...]
    jumps: Mask

    def __bool__(self) -> bool:
        return bool(self.switches)


def difference(sides: Sides) -> Difference:
    """What differs between the pieces."""
    every = sides.pieces
    if not every:
        return Difference((), np.zeros(0, dtype=bool))
    slopes, level = different_slopes(every), _different_levels(sides)
    count = len(every)
    pairs = [(i, j) for i in range(count) for j in range(i) if slopes[i, j] or level[i, j].any()]
    turned = [
        [k for k, (a, b) in enumerate(zip(every[i].signs, every[j].signs, strict=True)) if a != b] for i, j in pairs
    ]
    least = min(map(len, turned), default=0)
    found = {k for some in turned if len(some) == least for k in some}
    return Difference(tuple(sorted(found)), np.asarray(level.any(axis=(0, 1))))


def different_slopes(every: Sequence[Piece]) -> Mask:
    """Which pairs of pieces have other slopes (pieces × pieces)."""
    alike = np.array([p.flow.states == every[0].flow.states for p in every])
    own = [p.slopes if ok else every[0].slopes for p, ok in zip(every, alike, strict=True)]
    table = np.array(own)
    finite = np.isfinite(table)
    scale = balance(np.where(finite, np.abs(table), 0.0).max(axis=0))
    scaled = table / (scale.rows * scale.columns)
    blur = np.array([np.broadcast_to(p.blur, table.shape[1:]) for p in every]) / (scale.rows * scale.columns)
    with np.errstate(invalid="ignore"):
        apart = ~(np.abs(scaled[:, None] - scaled[None]) <= ROUNDED_SUM + blur[:, None] + blur[None])
    both = ~finite[:, None] & ~finite[None]
    return np.asarray(
        (apart & ~both).any(axis=(2, 3)) | (alike[:, None] != alike[None]) | ~alike[:, None] & ~alike[None]
    )


def _different_levels(sides: Sides) -> Mask:
    """Which of ẋ and the outputs have other values in pairs of pieces (pieces × pieces × values).

    A quantity that is zero but for rounding changes them by no more than the change of slopes makes of that rounding.
    """
    every = sides.pieces
    level = np.array([p.level for p in every])
    shape = every[0].slopes.shape
    slopes = np.array([p.slopes if p.slopes.shape == shape else every[0].slopes for p in every])
    apart = np.abs(level[:, None] - level[None])
    noise = EQUAL * (np.abs(level[:, None]) + np.abs(level[None]))
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.array([np.abs(p.gradients) for p in every]).max(axis=0)
        step = np.where(reach > 0, sides.corner.slack[:, None] / reach, 0.0).max(axis=0, initial=0)
        noise = noise + 10 * np.nan_to_num(np.abs(slopes[:, None] - slopes[None]) @ step)
        return np.asarray(apart > noise)
