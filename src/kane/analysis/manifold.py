# SPDX-License-Identifier: BSD-3-Clause
"""The constraints during a motion: residuals, and projection back onto them with the least change in the mass metric.

With the metric ½ δᵀM δ, displacements Δq = W δ and changes of the speeds Δu are

    δ  = −M⁻¹A_cᵀ (A_c M⁻¹ A_cᵀ)⁺ f          f the configuration constraints, A_c their rows of A
    Δu = −M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ (A u + b)

with pseudo-inverses, so that redundant constraints do no harm. Euler parameters are divided by their length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kane.analysis.routines import routine
from kane.dynamics.constraints.partition import Partition, balanced
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.program.native.handle import Handle

Array = npt.NDArray[np.float64]

_ROUNDS = 6
_CLOSED = 1e-13
_ROUNDING = 1e-13
"""Share of the largest entry of A below which an entry is what rounding left of zero."""
RANK = 1e-4
"""Singular values σ of A without units below this share of the largest count as zero. Where a linkage comes through a position at
which the constraints lose rank, what rounding leaves of f becomes f/σ in q and f/σ² in u, however short the steps: f = c ≠ 0 does
not go through there, but turns off."""
LIGHT = 1e-6
"""Inertia given to a coordinate without mass, over what the constraints reflect onto it: others take that share of its changes."""
_DEFINITE = 1e-10
"""Least eigenvalue of M, scaled to a unit diagonal, over the largest."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """f (configuration), A, b, M and W at a state."""

    f: Array
    a: Array
    b: Array
    m: Array
    w: Array


@dataclass(frozen=True, slots=True, eq=False)
class Manifold:
    """The constraints of equations of motion as one compiled routine."""

    handle: Handle
    coordinates: int
    speeds: int
    configuration: int
    rows: int
    euler: tuple[tuple[int, ...], ...]

    def numbers(self, t: float, x: Array, p: Array, r: Array) -> Numbers:
        """Residuals and matrices at a state x = (q, u)."""
        flat = self.handle(t, x, p, r)
        n, nq, m, c = self.speeds, self.coordinates, self.rows, self.configuration
        at = np.cumsum([c, m * n, m, n * n])
        return Numbers(
            flat[: at[0]],
            flat[at[0] : at[1]].reshape(m, n),
            flat[at[1] : at[2]],
            flat[at[2] : at[3]].reshape(n, n),
            flat[at[3] :].reshape(nq, -1)[:, :n],
        )

    def project(self, t: float, x: Array, p: Array, r: Array, reach: Array | float = 0.0) -> tuple[Array, Numbers]:
        """The state moved onto the constraints, and the numbers there; `reach` holds the sizes that entries of A have had."""
        x = x.copy()
        nq = self.coordinates
        for places in self.euler:
            e = x[list(places)]
            x[list(places)] = e / np.linalg.norm(e)
        now = self.numbers(t, x, p, r)
        if not all(np.all(np.isfinite(v)) for v in (now.f, now.a, now.b, now.m)):
            return x, now
        c = len(now.f)
        reach = np.maximum(reach, np.abs(now.a))
        size = np.abs(now.f).max(initial=0)
        for _ in range(_ROUNDS):
            if not size > _CLOSED:
                break
            trial = x.copy()
            trial[:nq] += now.w @ step(now.m, now.a[:c], -now.f, reach[:c])
            for places in self.euler:
                e = trial[list(places)]
                trial[list(places)] = e / np.linalg.norm(e)
            new = self.numbers(t, trial, p, r)
            left = np.abs(new.f).max(initial=0)
            if not left < size:
                break
            x, now, size = trial, new, left
        if len(now.b):
            x[nq:] += step(now.m, now.a, -(now.a @ x[nq:] + now.b), reach)
        return x, now


def step(m: Array, a: Array, right: Array, reach: Array | float = 0.0) -> Array:
    """The δ of least δᵀM δ with A δ = right, in the least-squares sense where the rows of A are dependent."""
    scale = metric(m, np.maximum(reach, np.abs(a)))
    combined, sigma = combinations(a, reach)
    sure = combined[sigma > RANK * sigma[0]]
    y, *_ = np.linalg.lstsq(sure @ a @ scale, sure @ right, rcond=1e-14)
    return np.asarray(scale @ y)


def nearest(m: Array, a: Array, f: Array, right: Array, reach: Array | float = 0.0) -> Array:
    """The x of least ½ xᵀ M x − fᵀ x with A x = right: M x + Aᵀ λ = f, M being definite where A leaves x free."""
    size = np.sqrt(reflected(_diagonal(m), np.maximum(reach, np.abs(a))))
    combined, sigma = combinations(a, reach)
    sure = combined[sigma > RANK * sigma[0]]
    rows = sure @ a / size
    tall = np.linalg.norm(rows, axis=1, keepdims=True)
    rows, wanted = rows / tall, sure @ right / tall[:, 0]
    whole = np.block([[m / np.outer(size, size), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    found = np.linalg.lstsq(whole, np.append(f / size, wanted), rcond=1e-14)[0]
    return np.asarray(found[: len(size)] / size)


def combinations(a: Array, reach: Array | float = 0.0) -> tuple[Array, Array]:
    """Rows that combine those of A into independent ones, and singular values of A divided by the sizes its rows and columns have had.

    So units do not matter, and a row that vanishes now is not mistaken for one in small units.
    """
    a = np.where(np.abs(a) > _ROUNDING * np.abs(a).max(), a, 0.0)
    reach = np.maximum(reach, np.abs(a))
    size = reach.max(axis=1, keepdims=True)
    size = np.where(size > 0, size, 1.0)
    width = (reach / size).max(axis=0)
    left, sigma, _ = np.linalg.svd(a / size / np.where(width > 0, width, 1.0))
    return (left / size).T[: len(sigma)], sigma


def quality(a: Array, partition: Partition, reach: Array | None = None) -> float:
    """How well the rows give the dependent speeds, A balanced: the least of three shares, 1 at best, 0 where they do not.

    The reciprocal condition number of the dependent block; its largest entry over that of the rows, since all of it may be small;
    and the least share that a pivot of its elimination has.
    """
    rows = balanced(a, reach)[list(partition.rows)]
    block = rows[:, list(partition.dependent)]
    if not block.any():
        return 0.0 if block.size else 1.0
    found = float(min(1.0 / np.linalg.cond(block), np.abs(block).max() / np.abs(rows).max()))
    for j in range(len(block)):
        rest = block[j:, j:]
        if not rest[0, 0]:
            return 0.0
        found = min(found, float(abs(rest[0, 0]) / np.abs(rest).max()))
        block[j + 1 :, j:] -= np.outer(block[j + 1 :, j] / block[j, j], block[j, j:])
    return found


def mobility(m: Array, a: Array) -> Array:
    """S with S Sᵀ = M⁻¹, where what has no mass moves as the masses do that the constraints join to it."""
    return metric(m, a, 1.0)


def sizes(a: Array, root: Array) -> Array:
    """How large the entries of A could be: a row's largest share of A S, over what the mass lets each x move, S Sᵀ = M⁻¹ in x.

    Near a dead centre a row is a short one in one x alone; divided by themselves its entries would all look alike.
    """
    mobile = np.linalg.norm(root, axis=1)
    mobile = np.where(mobile > 0, mobile, 1.0)
    return np.asarray((np.abs(a) * mobile).max(axis=1, keepdims=True, initial=0) / mobile)


def metric(m: Array, a: Array | None = None, light: float = LIGHT) -> Array:
    """S with S Sᵀ = M⁻¹; directions that move no mass are made a little heavy, so that they are free to move but not arbitrary.

    For a coordinate alone that means: it has `light` of the inertia that the constraints reflect onto it, whatever its unit.
    """
    own = _diagonal(m)
    added = np.maximum(light * reflected(own, np.zeros((0, len(m))) if a is None else a) - own, 0.0)
    heavy = m + np.diag(added)
    size = np.sqrt(np.diag(heavy))
    values, vectors = np.linalg.eigh(heavy / np.outer(size, size))
    values = np.maximum(values, _DEFINITE * values[-1])
    return np.asarray((vectors / np.sqrt(values)) / size[:, None])


def _diagonal(m: Array) -> Array:
    """The diagonal of M, where what rounding left of zero in a partial velocity comes squared."""
    own = np.diag(m)
    return np.where(own > _ROUNDING**2 * own.max(initial=0), own, 0.0)


def reflected(mass: Array, a: Array) -> Array:
    """What each x has of inertia: its own mass, or without one m (a_i/a)² of the lightest m that a row a of A joins to it.

    Row after row, so that it comes through chains of parts without mass. Where no mass is joined at all, x is measured by its rows.
    """
    if np.all(mass > 0):
        return mass
    a = np.where(np.abs(a) > _ROUNDING * np.abs(a).max(initial=0), np.abs(a), 0.0)
    found = mass.copy()
    for _ in range(len(a)):
        known = found > 0
        pace = (a[:, known] / np.sqrt(found[known])).max(axis=1, initial=0)
        joined = np.where(known, 0.0, (a[pace > 0] / pace[pace > 0, None]).max(axis=0, initial=0))
        if not joined.any():
            break
        found = np.where(known, found, joined**2)
    rows = np.maximum(a.max(axis=1, keepdims=True, initial=0), np.finfo(float).tiny)
    alone = (a / rows).max(axis=0, initial=0)
    return np.asarray(np.where(found > 0, found, np.where(alone > 0, alone, 1.0) ** 2))


def manifold(eom: Equations) -> Manifold | None:
    """The constraints of the equations, None where there is nothing to keep."""
    place = {c: i for i, c in enumerate(eom.coordinates)}
    euler = tuple(tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters)
    if not eom.constraints.constraints and not euler:
        return None
    roots: list[Expr] = [c.expr for c in eom.system.holonomic]
    roots += [x for row in eom.A.rows for x in row]
    roots += list(eom.b)
    roots += [x for row in eom.mass_matrix.rows for x in row]
    roots += [x for row in eom.W.rows for x in row]
    handle = routine(eom, "constraints", roots)
    return Manifold(handle, len(eom.coordinates), len(eom.speeds), len(eom.system.holonomic), len(eom.b), euler)
