# SPDX-License-Identifier: BSD-3-Clause
"""Minimization of the cost of lifted motions subject to final conditions and bounds, by sequential quadratic programming.

With the defects c_k = Φ_k(x_k, z) − x_{k+1}, the condensation δx_k = S_k δz + s_k leaves a problem in δz alone. The Hessian is that
of L_k + λ_{k+1}·Φ_k with adjoint states λ. A step is halved until J + μ (|c| + violations) decreases, μ above the multipliers; each is
relative to its size, as states and conditions have units.

A step is the solution of a quadratic program, min ½ d·H d + g·d subject to E d = e and A d ≥ b. On the null space of E, eigenvalues
of H are replaced by their magnitudes; the remaining least-distance problem is solved by non-negative least squares (Lawson & Hanson
1974, ch. 23).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import nnls

from kane.motion.fitting.lifted import StepEnds, Steps
from kane.numeric.arrays import Array, by_substitution
from kane.progress import far

_LEAST = 1e-8
"""Least eigenvalue, relative to the largest."""
_FLAT = 1e-6
"""If all eigenvalues are below this fraction of the gradient, they are replaced by it: the program is linear, solved by bounds."""
SizesOf = Callable[[Array, float], Array]
"""The sizes of states (n) from some (k × n), each at least a share of the largest of its kind."""
_NONE, _TINY = 1e-10, 1e-300
"""Residual at which rows contradict each other; least size of a row or condition."""


class QuadraticStep(NamedTuple):
    """d, and the multipliers with H d + g + Eᵀ y − Aᵀ w = 0, w ≥ 0."""

    d: Array
    equal: Array
    above: Array


def least(H: Array, g: Array, equal: tuple[Array, Array], above: tuple[Array, Array]) -> QuadraticStep | None:
    """The solution and its multipliers; None if no d satisfies the conditions."""
    (E, e), (A, b) = equal, above
    first = np.linalg.lstsq(E, e)[0] if len(E) else np.zeros(len(g))
    free = null_space(E) if len(E) else np.eye(len(g))
    if len(E) and np.abs(E @ first - e).max() > 1e-6 * (1 + np.abs(e).max()):
        return None
    values, vectors = np.linalg.eigh(free.T @ H @ free)
    most, slope = float(np.abs(values).max(initial=0.0)), float(np.abs(g).max(initial=0.0))
    size = np.maximum(np.abs(values), _LEAST * most if most > _FLAT * slope else (_FLAT * slope or 1.0))
    root = vectors * np.sqrt(size)
    lower = np.linalg.cholesky(root @ root.T)
    toward = -by_substitution(lower, free.T @ (g + H @ first))
    u, w = toward, np.zeros(len(A))
    if len(A):
        C = by_substitution(lower, (A @ free).T).T
        need = b - A @ first - C @ toward
        if need.max() > 0:
            found = _nearest(C, need)
            if found is None:
                return None
            u, w = toward + found[0], found[1]
    d = first + free @ np.linalg.solve(lower.T, u)
    rest = H @ d + g - A.T @ w
    y = -np.linalg.lstsq(E.T, rest)[0] if len(E) else np.zeros(0)
    return QuadraticStep(np.asarray(d), np.asarray(y), w)


def _nearest(C: Array, h: Array) -> tuple[Array, Array] | None:
    """The u of least norm with C u ≥ h, and its multipliers; None if there is none."""
    size, wide = max(float(np.abs(h).max()), _TINY), max(float(np.abs(C).max(initial=0)), _TINY)
    E = np.vstack([C.T / wide, h / size])
    y, left = nnls(E, np.append(np.zeros(C.shape[1]), 1.0), maxiter=30 * len(h))
    if left <= _NONE:
        return None
    r = E @ y
    r[-1] -= 1.0
    return size / wide * r[:-1] / -r[-1], size / wide**2 * y / -r[-1]


_ARRIVED, _SHORT, _FALL, _NEAR = 1e-9, 1e-6, 1e-4, 0.3
"""Step at convergence, least fraction of a step, required fraction of the predicted decrease; and the relative change of states
below which the Hessian includes the curvature of the motion, which is misleading far from the solution."""
_SMALL = 1e-2
"""Least size of a state, relative to the largest of its kind."""
_SHARES = (1.0, 0.5, 0.25, 0.1, 0.02)
"""Fractions of the defects and conditions that a step may satisfy, tried in order if bounds prevent more."""


@dataclass(frozen=True, slots=True, eq=False)
class CostMinimum:
    """The minimizer z, the states at the starts of steps, and the number of evaluations of the motion."""

    z: Array
    x: Array
    rounds: int


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Bounds `low` and `high` of z, and `least` and `most` of the final conditions."""

    low: Array
    high: Array
    least: Array
    most: Array

    @property
    def wide(self) -> Array:
        """The largest magnitudes of the final conditions that are admitted, as far as they are bounded."""
        ends = np.abs([self.least, self.most])
        return np.asarray(np.where(np.isfinite(ends), ends, 0.0).max(axis=0))


class _MeritSizes(NamedTuple):
    """The sizes of states (n) and of final conditions (e)."""

    x: Array
    end: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Here:
    """The flow, costs, defects and final conditions at z and x."""

    flow: StepEnds
    away: float
    defects: Array
    end: Array
    end_slopes: Array

    def missed(self, limits: Limits) -> Array:
        e = self.end[1:]
        return np.maximum(np.maximum(limits.least - e, e - limits.most), 0.0)

    def off(self, limits: Limits, size: _MeritSizes) -> float:
        """The sum of the defects and violations, relative to their sizes."""
        return float(np.abs(self.defects / size.x).sum() + (self.missed(limits) / size.end).sum())

    def merit(self, limits: Limits, size: _MeritSizes, mu: float) -> float:
        return self.away + float(self.flow.cost.sum()) + float(self.end[0]) + mu * self.off(limits, size)

    def sizes(self, sizes_of: SizesOf, x: Array, limits: Limits) -> _MeritSizes:
        """Sizes along the motion: of states per unit, of conditions those of their terms and bounds."""
        own = sizes_of(np.vstack([x, self.flow.x]), _SMALL)
        return _MeritSizes(own, np.maximum(np.abs(self.end_slopes[1:]) @ own, limits.wide) + _TINY)


def least_cost(
    steps: Steps, z: Array, x: Array, limits: Limits, most: int, sizes_of: SizesOf, near: Array | None
) -> CostMinimum | None:
    """The minimum from z and states x (m + 1 × n) on, with the first state fixed; None if none is found.

    With `near`, ½ |z − near|² is added to the cost.
    """
    weights, mu, close = np.zeros(len(limits.least)), 0.0, False
    here = _at(steps, z, x, near)
    for count in range(1, most + 1):
        size = here.sizes(sizes_of, x, limits)
        far(partial("{} steps".format, count))
        (H, g, S, s), lam = _reduced(steps, z, x, here, weights, size.x, close)
        if near is not None:
            H, g = H + np.eye(len(z)), (g[0] + z - near, g[1])
        found = _step(here, (H, *g), (S[-1], s[-1]), limits, z, size.end)
        if found is None:
            return None
        step, part = found
        d = step.d
        dx = S @ d + part * s
        new = step.equal
        moved, missed = float(np.abs(dx / size.x).max()), here.missed(limits) / size.end
        if max(np.abs(d).max(), moved, missed.max(initial=0.0)) <= _ARRIVED:
            return CostMinimum(z + d, x + dx, count)
        mu = max(mu / 2, 2.0 * max(float(np.abs(lam * size.x).max()), float(np.abs(new * size.end).max(initial=0.0))))
        now, share = here.merit(limits, size, mu), 1.0
        fall = float((g[0] + part * g[1]) @ d) - part * mu * here.off(limits, size)
        while share > _SHORT:
            there = _at(steps, z + share * d, x + share * dx, near)
            value = there.merit(limits, size, mu)
            if np.isfinite(value) and value <= now + _FALL * share * min(fall, 0.0) + 1e-13 * abs(now):
                break
            share /= 2
        else:
            return None
        z, x, weights, here = z + share * d, x + share * dx, weights + share * (new - weights), there
        close = part == 1.0 and moved < _NEAR
    return None


@np.errstate(over="ignore", invalid="ignore")
def _at(steps: Steps, z: Array, x: Array, near: Array | None) -> _Here:
    flow = steps.flow(np.arange(len(steps.h)), x[:-1], z[steps.active])
    away = 0.0 if near is None else 0.5 * float((z - near) @ (z - near))
    return _Here(flow, away, flow.x - x[1:], *steps.end(x[-1]))


def _reduced(
    steps: Steps, z: Array, x: Array, here: _Here, weights: Array, size: Array, close: bool
) -> tuple[tuple[Array, tuple[Array, Array], Array, Array], Array]:
    """H and g of δz, the part of g due to s, S and s of all states, and the adjoint states."""
    (m, n), count, flow = (len(steps.h), x.shape[1]), len(z), here.flow
    a, b = flow.x_slopes[:, :, :n], flow.x_slopes[:, :, n:]
    end_curvature = steps.end_curvature(x[-1], weights * close, size)
    lam = np.empty((m + 1, n))
    lam[-1] = np.append(1.0, weights) @ here.end_slopes
    S, s = steps.condensed(flow, here.defects, count)
    for k in range(m - 1, -1, -1):
        lam[k] = flow.cost_slopes[k, :n] + a[k].T @ lam[k + 1]
    curvature = steps.curvature(x[:-1], z[steps.active], flow, lam[1:] * close, size)
    whole = np.zeros((m, n + b.shape[2], count))
    whole[:, :n] = S[:-1]
    np.put_along_axis(whole[:, n:], steps.active[:, :, None], 1.0, axis=2)
    shift = np.concatenate([s[:-1], np.zeros((m, b.shape[2]))], axis=1)
    slope = np.einsum("mij,mj->mi", curvature, shift)
    flat = whole.reshape(-1, count)
    H = flat.T @ (curvature @ whole).reshape(-1, count) + S[-1].T @ end_curvature @ S[-1]
    g = flat.T @ flow.cost_slopes.reshape(-1) + S[-1].T @ here.end_slopes[0]
    by_shift = flat.T @ slope.reshape(-1) + S[-1].T @ (end_curvature @ s[-1])
    return (H, (g, by_shift), S, s), lam


def _step(
    here: _Here,
    quadratic: tuple[Array, Array, Array],
    last: tuple[Array, Array],
    limits: Limits,
    z: Array,
    sizes: Array,
) -> tuple[QuadraticStep, float] | None:
    """The step with the multipliers of all conditions as `equal`, and the fraction of defects and conditions that it satisfies.

    The program has the conditions relative to their `sizes`.
    """
    H, g, by_shift = quadratic
    slopes, values = here.end_slopes[1:] / sizes[:, None], here.end[1:] / sizes
    lowest, highest = limits.least / sizes, limits.most / sizes
    by, now = slopes @ last[0], values + slopes @ last[1]
    equal = limits.least == limits.most
    below, above = ~equal & np.isfinite(limits.least), ~equal & np.isfinite(limits.most)
    low, high, unit = np.isfinite(limits.low), np.isfinite(limits.high), np.eye(len(z))
    A = np.vstack([by[below], -by[above], unit[low], -unit[high]])
    fixed = np.concatenate([(limits.low - z)[low], (z - limits.high)[high]])
    for share in _SHARES:
        e, asked = (
            -(now - lowest)[equal],
            np.concatenate([(lowest - now)[below], (now - highest)[above]]),
        )
        b = np.concatenate([np.where(asked > 0, share * asked, asked), fixed])
        step = least(H, g + share * by_shift, (by[equal], share * e), (A, b))
        if step is not None:
            weights, (p, q) = np.zeros(len(values)), (int(below.sum()), int(above.sum()))
            weights[equal] = step.equal
            weights[below] -= step.above[:p]
            weights[above] += step.above[p : p + q]
            return QuadraticStep(step.d, weights / sizes, step.above), share
    return None
