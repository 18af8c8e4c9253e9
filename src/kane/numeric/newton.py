# SPDX-License-Identifier: BSD-3-Clause
"""f(x) = 0 by damped Gauss–Newton steps of minimum norm: from one start within a trust region, or from many starts at once.

From many starts x and f are scaled by their natural sizes, so that units do not matter.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from kane.numeric.arrays import Array, Indices, Mask, medians
from kane.numeric.rank import singular
from kane.numeric.scale import CLOSED, CLOSED_FULLY, FIXED_SHARE, NEAR_SINGULAR, ROUNDED, ROUNDED_CHAIN, ROUNDED_TERMS

T = TypeVar("T")
Residual = Callable[[Array], tuple[Array, Array]]
"""f (m) and ∂f/∂x (m × n) at x (n)."""

_HALVINGS = 30
_STRAIGHT, _GROWTH = 0.1, 4.0
"""Where f differs from its tangent by no more than this share of a step's change, the trust region grows by this factor."""


@dataclass(frozen=True, slots=True)
class Closed:
    """The end of the iteration: `x` (n), the residual f (m), and the number of steps."""

    x: Array
    residual: Array
    steps: int

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.abs(self.residual).max(initial=0))


def close(
    function: Residual,
    x: Array,
    free: Sequence[int],
    limit: float = CLOSED_FULLY,
    steps: int = 60,
    sizes: tuple[Array | float, Array | float] = (1.0, 1.0),
) -> Closed:
    """Steps in the `free` entries of x until the residual is below `limit` or falls no more.

    f (m) and x (n) are scaled by `sizes`. The radius of the trust region is 1 at first and grows while f agrees with its
    linearization, so that linear equations are solved for any size of x.
    """
    columns, (rows, wide) = list(free), sizes
    scale = np.broadcast_to(wide, x.shape)[columns]
    f, g = function(x)
    length = np.linalg.norm(f / rows)
    best, radius = Closed(x, f, 0), 1.0
    for step in range(1, steps + 1):
        if not math.isfinite(length) or np.abs(best.residual / rows).max(initial=0) <= limit or not columns:
            break
        slopes = g[:, columns] * scale / np.reshape(rows, (-1, 1))
        change = _least_step(slopes, -f / rows)
        within = share = radius / max(radius, np.abs(change).max(initial=0))
        before = length
        for _ in range(_HALVINGS):
            x = best.x.copy()
            x[columns] += share * change * scale
            f, g = function(x)
            length = np.linalg.norm(f / rows)
            if length < before:
                break
            share /= 2
        else:
            break
        predicted = share * (slopes @ change)
        curved = np.linalg.norm((f - best.residual) / rows - predicted)
        if within < 1 and curved <= _STRAIGHT * np.linalg.norm(predicted):
            radius *= _GROWTH
        best = Closed(x, f, step)
        if length > (1 - 1e-3 * within) * before:
            break
    return best


def _least_step(slopes: Array, right: Array) -> Array:
    """The least x (n) of those nearest to A x = right (m), without components of `right` that are rounding in weak directions of A.

    Close to a configuration a row that follows from the others there seems to be independent, by as much as the rest is open.
    """
    change, _, _, values = np.linalg.lstsq(slopes, right, rcond=FIXED_SHARE)
    if np.any((values > FIXED_SHARE * values[:1]) & (values <= NEAR_SINGULAR * values[:1])):
        whole = singular(slopes)
        weak = slice(whole.rank(NEAR_SINGULAR), whole.rank(FIXED_SHARE))
        parts = whole.left[:, weak].T @ right
        parts[np.abs(parts) > ROUNDED_TERMS] = 0.0
        change = change - whole.right[weak].T @ (parts / whole.values[weak])
    return np.asarray(change)


def closest(
    function: Residual,
    starts: Iterable[Array],
    free: Sequence[int],
    enough: float = CLOSED,
    limit: float = CLOSED_FULLY,
    astray: Callable[[Array], Array] | None = None,
) -> Closed:
    """The end from the first start with a residual of at most `enough` that is not `astray`; else the end with the least residual."""
    best: Closed | None = None
    for x in starts:
        last = close(function, x, free, limit)
        if last.size <= enough and not (astray is not None and astray(last.x).any()):
            return last
        if best is None or last.size < best.size:
            best = last
    assert best is not None
    return best


def starts(x: Array, free: Sequence[int], seed: int, spreads: Iterable[float]) -> Iterator[Array]:
    """x, then x with its `free` entries displaced at random, by about each of `spreads` in turn."""
    yield x
    generator = np.random.default_rng(seed)
    for spread in spreads:
        other = x.copy()
        other[list(free)] += spread * generator.normal(size=len(free))
        yield other


def improved(at: T, size: Callable[[T], float], change: Callable[[T], T], limit: float, rounds: int) -> T:
    """`at` after repeated `change`, at most `rounds` times, while its size falls and is above `limit`."""
    for _ in range(rounds):
        if not size(at) > limit:
            break
        trial = change(at)
        if not size(trial) < size(at):
            break
        at = trial
    return at


Accepted = Callable[[Array, Indices], Mask]
"""Which of x (k × n), closed, are on a branch that is meant, of the starts numbered by the second argument (k)."""
Residuals = Callable[[Array, Indices], tuple[Array, Array]]
"""f (k × m) and ∂f/∂x (k × m × n) at x (k × n) of the starts numbered by the second argument (k)."""

Rounding = Callable[[Array, Indices], Any]
"""How far rounding may carry each f (k × m) there."""

_TURNS = 2 * np.pi * 2**20
"""So many that lengths of any size are no turn."""
_EXTENTS = np.geomspace(1e-15, 1e15, 61)
_SECANTS = 6
_ALIKE = 0.8
"""Powers of a thousand up to which what does not turn is left as it is: Euler parameters off the unit sphere make so much."""
_MANY_STEPS, _MANY_HALVINGS, _PATIENCE = 60, 20, 10
"""Steps, halvings of one, and steps after which no more is waited for where half of the starts have ended and one is closed."""
_QUICK, _MOST, _HALF, _PART = 10, 0.75, 0.5, 0.15
"""Whole steps from many starts at once, and the shares of these that are enough: soon, later, at last."""
_STALLED = 0.998
"""Share of f² that must not be left by a step for others to follow."""


def _exact(x: Array, starts: Indices) -> float:
    return 0.0


class NaturalSizes(NamedTuple):
    """The natural sizes of x (n) and of the terms of f (m), and which x are angles: f is periodic in them with 2π."""

    x: Array
    f: Array
    turns: Mask


@dataclass(frozen=True, slots=True, eq=False)
class ClosedMany:
    """The ends of the iterations, x (k × n), their `residual` f (k × m), and `shares`, the residual over the size of its terms."""

    x: Array
    residual: Array
    shares: Array

    @property
    def left(self) -> Array:
        """The largest share (k)."""
        return np.asarray(np.abs(self.shares).max(axis=1, initial=0))


def sizes(
    function: Residuals, x: Array, unit: Sequence[int] = (), rounding: Rounding = _exact, by_thousands: bool = True
) -> NaturalSizes:
    """The natural sizes from values of f at x (k × n): that of an entry of x is the change that f's other terms correspond to.

    Entries that are no angles are scaled first so that they change f as much as its other terms, exactly or only `by_thousands`; those
    of `unit` size are not. Values and slopes within `rounding` are ignored; an f that vanishes everywhere gets a size beside which
    rounding is zero.
    """
    f, g, error = _values(function, x, rounding)
    g, usable = np.abs(g), _finite(f, g)
    if not usable.any():
        return NaturalSizes(np.ones(x.shape[1]), np.ones(f.shape[1]), np.zeros(x.shape[1], dtype=bool))
    everywhere = np.asarray((np.abs(f) <= error)[usable].all(axis=0))
    turning = _turning(function, x, f, g, usable) | everywhere[:, None]
    turns = np.asarray(turning.all(axis=0))
    turning[:, list(unit)] = True
    extent = _extent(function, x, turning, rounding, by_thousands)
    if np.any(extent != 1.0):
        x = extent * x
        f, g, error = _values(function, x, rounding)
        g, usable = np.abs(g), _finite(f, g)
    left = error[usable].max(axis=0)
    typical, slope = medians(np.abs(f[usable])), g[usable].max(axis=0)
    typical = np.where(typical > left, typical, 0.0)
    slope = np.where(slope * np.abs(x).max(axis=0) > left[:, None], slope, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        own = np.where((slope > 0) & (typical[:, None] > 0), typical[:, None] / slope, np.inf).min(
            axis=0, initial=np.inf
        )
    own = np.where(turns, 1.0, np.where(np.isfinite(own), own, extent))
    terms = np.maximum(np.maximum(typical, (slope * own).max(axis=1, initial=0)), left / CLOSED_FULLY)
    return NaturalSizes(own, np.where(terms > 0, terms, 1.0), turns)


def _values(function: Residuals, x: Array, rounding: Rounding) -> tuple[Array, Array, Array]:
    f, g = function(x, np.arange(len(x)))
    return f, g, _error(x, f, rounding)


def _error(x: Array, f: Array, rounding: Rounding) -> Array:
    return np.asarray(np.nan_to_num(np.broadcast_to(rounding(x, np.arange(len(x))), f.shape), posinf=0.0))


def _finite(f: Array, g: Array) -> Mask:
    return np.asarray(np.isfinite(f).all(axis=1) & np.isfinite(g).all(axis=(1, 2)))


def _turning(function: Residuals, x: Array, f: Array, g: Array, usable: Mask) -> Mask:
    """Which f (m × n) are periodic in which x, or do not depend on it: their values are the same many multiples of 2π further."""
    n, j = x.shape[1], int(np.argmax(usable))
    with np.errstate(all="ignore"):
        more, _ = function(x[j] + _TURNS * np.eye(n), np.full(n, j))
    slope = g[usable].max(axis=0)
    # beside the possible change by this entry, and the rounding error of f, which grows with its constant terms
    limit = 1e-9 * slope * np.maximum(np.abs(x[j]), _TURNS) + 1e-14 * np.abs(f[usable]).max(axis=0)[:, None]
    return np.asarray(limit >= np.abs(more - f[j]).T)


def _extent(function: Residuals, x: Array, turning: Mask, rounding: Rounding, by_thousands: bool) -> Array:
    """The factor (n) for each entry of x (k × n) that is no angle, so that it changes some f as much as the other terms do.

    `by_thousands` it is a power of a thousand, so that models in metres have the same starts; 1 if the other terms are only rounding.
    """
    k, free = len(x), ~turning.all(axis=0)
    extent = np.ones(x.shape[1])
    if not free.any():
        return extent
    shares = np.append(0.0, _EXTENTS)
    every = np.tile(x, (len(shares), 1)) * np.where(free, np.repeat(shares, k)[:, None], 1.0)
    with np.errstate(all="ignore"):
        f = function(every, np.tile(np.arange(k), len(shares)))[0].reshape(len(shares), k, -1)
        error = _error(every[:k], f[0], rounding)
        without, moved = medians(np.abs(f[0])), medians(np.abs(f[1:] - f[0]), 1)
        enough = (moved >= without) & (without > error.max(axis=0)) & np.isfinite(moved)
    first = np.where(enough.any(axis=0), np.log10(_EXTENTS)[np.argmax(enough, axis=0)], np.nan)
    if not by_thousands:
        first = _crossing(function, np.where(free, x, 0.0), np.where(free, 0.0, x), first, without)
    for i in np.flatnonzero(free):
        own = first[~turning[:, i] & np.isfinite(first)]
        if len(own):
            power = float(own.min()) / 3
            extent[i] = 1000.0 ** ((round(power) if abs(power) > _ALIKE else 0) if by_thousands else power)
    return extent


def _crossing(function: Residuals, x: Array, rest: Array, above: Array, without: Array) -> Array:
    """The logarithm of the factor (m) of x (k × n) at which each f changes by `without` (m), from one somewhat `above`, by secants."""
    k, m = len(x), len(above)

    def excess(power: Array) -> Array:
        """log |f(s x + rest) − f(rest)|/without, each f at its own s = 10^power."""
        shares = np.where(np.isfinite(power), 10.0**power, 1.0)
        every = np.concatenate([rest, *(s * x + rest for s in shares)])
        f = function(every, np.tile(np.arange(k), m + 1))[0].reshape(m + 1, k, m)
        return np.asarray(np.log10(medians(np.abs(f[1:] - f[0])[np.arange(m), :, np.arange(m)].T) / without))

    with np.errstate(all="ignore"):
        a, b = above - np.log10(_EXTENTS[1] / _EXTENTS[0]), above
        at_a, at_b = excess(a), excess(b)
        for _ in range(_SECANTS):
            trial = b - at_b * (b - a) / (at_b - at_a)
            trial = np.where(np.abs(trial - above) <= 1.0, trial, b)
            a, at_a, b = b, at_b, trial
            at_b = excess(b)
    return b


def close_many(function: Residuals, x: Array, size: NaturalSizes, accepted: Accepted | None = None) -> ClosedMany:
    """The ends of steps from each x (k × n), halved until they reduce f; angles move by at most 1 rad per step."""
    x = x.copy()
    f, g = _scaled(function, x, np.arange(len(x)), size)
    left = np.abs(f).max(axis=1, initial=0)
    going = np.isfinite(left) & np.isfinite(g).all(axis=(1, 2)) & (left > CLOSED_FULLY)
    for step in range(_MANY_STEPS):
        at = np.flatnonzero(going)
        if not len(at) or (step >= _PATIENCE and 2 * len(at) <= len(x) and _enough(x, left, accepted)):
            break
        change = _change(f[at], g[at], size)
        share = np.ones(len(at))
        before, pending = (f[at] ** 2).sum(axis=1), np.arange(len(at))
        for _ in range(_MANY_HALVINGS):
            members = at[pending]
            trial = x[members] + share[pending, None] * change[pending]
            new, slope = _scaled(function, trial, members, size)
            norm = (new**2).sum(axis=1)
            good = (norm < before[pending]) & np.isfinite(slope).all(axis=(1, 2))
            done = members[good]
            x[done], f[done], g[done] = trial[good], new[good], slope[good]
            going[done[norm[good] > _STALLED * before[pending[good]]]] = False
            pending = pending[~good & (left[members] > CLOSED)]
            if not len(pending):
                break
            share[pending] /= 2
        left[at], last = np.abs(f[at]).max(axis=1, initial=0), left[at]
        going[at[(left[at] <= CLOSED_FULLY) | (left[at] >= last)]] = False
    return _polished(function, x, f, g, size)


def close_most(function: Residuals, x: Array, size: NaturalSizes, accepted: Accepted | None = None) -> ClosedMany:
    """The ends of a few undamped steps, if many starts converge by them, else `close_many`; starts may change their branch."""
    start, every = x, np.arange(len(x))
    f, g = _scaled(function, x, every, size)
    for step in range(_QUICK):
        finite = np.isfinite(f).all(axis=1) & np.isfinite(g).all(axis=(1, 2))
        left = np.where(finite, np.abs(f).max(axis=1, initial=0), np.inf)
        if (left <= ROUNDED_CHAIN).sum() >= (_MOST if step < _QUICK // 2 else _HALF) * len(x):
            break
        at = np.flatnonzero(finite & (left > CLOSED_FULLY))
        if not len(at):
            break
        x = x.copy()
        x[at] += _change(f[at], g[at], size)
        f, g = _scaled(function, x, every, size)
    left = np.abs(f).max(axis=1, initial=0)
    if (left <= ROUNDED_CHAIN).sum() < _PART * len(x) or not _enough(x, left, accepted):
        return close_many(function, start, size, accepted)
    return _polished(function, x, f, g, size)


def _polished(function: Residuals, x: Array, f: Array, g: Array, size: NaturalSizes) -> ClosedMany:
    """One more step for the starts that have converged, unless it increases f, so that the residual is only rounding."""
    at = np.flatnonzero((np.abs(f).max(axis=1, initial=0) <= CLOSED) & np.isfinite(g).all(axis=(1, 2)))
    if len(at):
        trial = x[at] + _change(f[at], g[at], size)
        new, _ = _scaled(function, trial, at, size)
        better = np.abs(new).max(axis=1, initial=0) <= np.abs(f[at]).max(axis=1, initial=0)
        x, f = x.copy(), f.copy()
        x[at[better]], f[at[better]] = trial[better], new[better]
    return ClosedMany(x, f * size.f, f)


def _enough(x: Array, left: Array, accepted: Accepted | None) -> bool:
    """Whether one of the starts has converged and is accepted."""
    closed = np.flatnonzero(left <= ROUNDED_CHAIN)
    return len(closed) > 0 and (accepted is None or bool(accepted(x[closed], closed).any()))


def _scaled(function: Residuals, x: Array, members: Indices, size: NaturalSizes) -> tuple[Array, Array]:
    f, g = function(x, members)
    return f / size.f, g * size.x / size.f[:, None]


def _change(f: Array, g: Array, size: NaturalSizes) -> Array:
    """The minimum-norm steps δ (k × n) with G δ = −f; G Gᵀ is regularized, so that dependent rows do no harm."""
    across = np.swapaxes(g, 1, 2)
    square = g @ across
    m = f.shape[1]
    firm = ROUNDED * np.trace(square, axis1=1, axis2=2) / m
    square[:, range(m), range(m)] += np.where(firm > 0, firm, 1.0)[:, None]
    least = (across @ np.linalg.solve(square, -f[:, :, None]))[:, :, 0]
    share = np.abs(least[:, size.turns]).max(axis=1, initial=1.0)
    return np.asarray(least * (size.x / share[:, None]))
