# SPDX-License-Identifier: BSD-3-Clause
"""The equations at a corner, one smooth piece for each side of the switches that stand there.

A piece counts where a motion leads into it: some d with s_i ∇c_i·d > 0 for all switches c_i and their sides s_i = ±1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from kane.analysis.flow import Flow, flow_at, output_slopes
from kane.analysis.one_sided import OneSided, Signs, Table
from kane.analysis.outputs import Outputs
from kane.analysis.state import State
from kane.errors import SingularError
from kane.expr.node import Expr
from kane.expr.ops import GONE
from kane.numeric.arrays import Array
from kane.numeric.rank import balance
from kane.numeric.scale import ROUNDED, SIX_DIGITS, UNRELATED

_MOST = 6
"""Switches of which all sides are looked at together; of more, all on one side, and each of them on the other."""
_NEAR = (2.0**-16, 2.0**-24, 2.0**-32)
"""Distances at which a piece is looked at whose derivative has no value at the corner itself."""


@dataclass(frozen=True, eq=False)
class Piece:
    """One side `signs` of the switches at a corner: the flow, its outputs and their derivatives.

    `gradients` (switches × δ(ξ_I, u_I, r)) are those of the switches that can be left, zero of the others; `away` leads into it.
    `blur` is how far the slopes may be off, where they are limits.
    """

    flow: Flow
    signs: Signs
    outputs: Array
    output_slopes: Array
    gradients: Array
    away: Array
    blur: Array | float = 0.0

    @cached_property
    def level(self) -> Array:
        """ẋ and the outputs."""
        return np.append(self.flow.rest, self.outputs)

    @cached_property
    def slopes(self) -> Array:
        """[A B; C D]."""
        return np.vstack([np.hstack([self.flow.a, self.flow.b]), self.output_slopes])

    @property
    def finite(self) -> bool:
        """Whether all of it is."""
        return bool(np.isfinite(self.slopes).all() and np.isfinite(self.level).all())


@dataclass(frozen=True, slots=True, eq=False)
class Corner:
    """A flow at whose state some switches stand at zero: which of `turning` they are, and how far off they count as standing there."""

    flow: Flow
    outputs: Outputs
    at: tuple[int, ...]
    slack: Array


def pieces(corner: Corner, quantities: Sequence[Expr]) -> tuple[Piece, ...]:
    """The pieces that meet at the corner; `quantities` are those of its switches."""
    table = Table(corner.flow.numeric, quantities)
    found = (_piece(corner, OneSided(table, signs)) for signs in _patterns(len(corner.at)))
    return tuple(p for p in found if p is not None)


def _patterns(count: int) -> list[Signs]:
    if count <= _MOST:
        return list(product((1.0, -1.0), repeat=count))
    rows: list[Signs] = []
    for side in (1.0, -1.0):
        rows.append((side,) * count)
        rows += [tuple(-side if j == k else side for j in range(count)) for k in range(count)]
    return rows


def _piece(corner: Corner, numbers: OneSided) -> Piece | None:
    """The piece, None where no motion leads into it; what it tends to where it has no derivative at the corner itself."""
    state = corner.flow.state
    first = _built(corner, state, numbers)
    if first is None or first.finite:
        return first
    near = beside(corner.flow, first.away, lambda x, r: _built(corner, replace(state, x=x, r=r), numbers))
    return first if near is None else replace(near, signs=first.signs, gradients=first.gradients, away=first.away)


def beside(flow: Flow, d: Array, at: Callable[[Array, Array], Piece | None]) -> Piece | None:
    """What the pieces `at` places beside a state tend to along d; None where they tend to nothing finite."""
    n = len(flow.state.x)
    changes = [flow.moves @ (h * d) for h in _NEAR]
    near = [at(flow.state.x + c[:n], flow.state.r + c[n:]) for c in changes]
    found = [p for p in near if p is not None and p.finite]
    if len(found) < len(_NEAR):
        return None
    level, slopes = (_limit([getattr(p, what) for p in found]) for what in ("level", "slopes"))
    m = len(flow.rest)
    limit = replace(found[-1].flow, state=flow.state, rest=level[:m], a=slopes[:m, :m], b=slopes[:m, m:])
    blur = np.abs(found[-1].slopes - found[-2].slopes)
    return replace(found[-1], flow=limit, outputs=level[m:], output_slopes=slopes[m:], blur=blur)


def _limit(series: Sequence[Array]) -> Array:
    """What c + a hᵖ at three distances h in equal shares tends to (Aitken's Δ² process); the last where it tends to nothing."""
    first, second, last = series
    one, two = second - first, last - second
    with np.errstate(all="ignore"):
        limit = last - two**2 / (two - one)
    limit = np.where((np.abs(two) < np.abs(one)) & np.isfinite(limit), limit, last)
    return np.where(np.abs(limit) <= SIX_DIGITS * np.abs(first), 0.0, limit)


def _built(corner: Corner, state: State, numbers: OneSided) -> Piece | None:
    flow = corner.flow
    with np.errstate(invalid="ignore"):
        try:
            here = flow_at(flow.numeric, state, flow.choice, numbers)
        except SingularError:
            return None
        level, slopes = output_slopes(here, corner.outputs)
        own, pick = numbers.turning(state, here.z, corner.outputs), list(corner.at)
        gradients = _leaving(own.slopes[pick], np.vstack([here.moves, here.answers]))
    signs, c = np.array(numbers.signs), own.quantities[pick]
    off = np.abs(c) > np.maximum(GONE * own.sizes[pick], corner.slack)
    if (off & (signs * c < 0)).any():  # held on the other side by the sides of other switches
        return None
    gradients = np.where(off[:, None], 0.0, gradients)
    away = _direction(signs[:, None] * gradients)
    return None if away is None else Piece(here, numbers.signs, level, slopes, gradients, away)


def _leaving(rows: Array, moves: Array) -> Array:
    """∇c along the changes that are allowed, what rounding leaves of zero being zero; what c does not hold need not be finite."""
    terms = np.where(rows[:, :, None] == 0, 0.0, rows[:, :, None] * moves[None])
    found = terms.sum(axis=1)
    return np.asarray(np.where(np.abs(found) <= ROUNDED * np.abs(terms).sum(axis=1), 0.0, found))


def _direction(rows: Array) -> Array | None:
    """A direction d with row·d > 0 for every row that is not zero; None where there is none."""
    rows = rows[np.abs(rows).max(axis=1, initial=0) > 0]
    width = rows.shape[1]
    if not len(rows):
        return np.zeros(width)
    scaled = balance(rows, order=(0, 1))
    d = np.asarray(np.linalg.lstsq(scaled.matrix, np.ones(len(rows)))[0], dtype=np.float64)
    if not (scaled.matrix @ d > 0.5).all():
        from scipy.optimize import linprog

        above = np.hstack([-scaled.matrix, np.ones((len(rows), 1))])
        best = linprog([*[0.0] * width, -1.0], above, np.zeros(len(rows)), bounds=[(-1, 1)] * width + [(None, 1)])
        found = np.asarray(best.x if best.success else np.zeros(width + 1), dtype=np.float64)
        if not found[-1] > UNRELATED:
            return None
        d = found[:-1]
    d = d / scaled.columns[0]
    return np.asarray(d / np.abs(d).max())
