# SPDX-License-Identifier: BSD-3-Clause
"""One solution for many contacts: Lemke's method for polyhedral friction cones, then Newton iteration on the exact cones in space.

Lemke's method is for w = M z + q, 0 ≤ w ⊥ z ≥ 0, and exact in the plane. The unknowns z are the normal forces and, for each contact
that may stick, the friction forces along the directions of the facets and the slip speed σ (Stewart & Trinkle 1996, Int. J. Numer.
Meth. Engng 39, 2673).

The semi-smooth Newton iteration starts from its forces:

λ_n = (λ_n − r a_n)₊, λ_t = P_{μ(λ_n − r a_n)₊}(λ_t − r a_t), where 1/r is the norm of the contact's diagonal block of W (Alart &
Curnier 1991, Comput. Meth. Appl. Mech. Engng 92, 353). Redundant contacts make the Jacobian singular; proximal steps then replace W by
W + ε diag(W), with decreasing ε, which keeps forces near the previous ones.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kane.contacts.angles import unit
from kane.contacts.mode_solution import ModeSolution, shown, solve
from kane.contacts.problem import ContactProblem, ContactStatus
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, ROUNDED, ROUNDED_CHAIN, ROUNDED_ROOT, ROUNDED_SUM

_STEPS, _INNER, _OUTER, _HALVINGS = 60, 40, 30, 6
_FIRST, _LEAST, _LARGEST = 1e-2, 1e-4, 10.0
"""First, least and largest ε of the proximal steps."""
_FACETS = 8
_PIVOTS = 400


def complementary(m: Array, q: Array) -> Array | None:
    """z (n), by lexicographic pivoting, which does not cycle; None on ray termination or after too many pivots."""
    n = len(q)
    if q.min(initial=0) >= 0:
        return np.zeros(n)
    table = np.hstack([np.eye(n), -m, -np.ones((n, 1)), q[:, None]])
    basis = np.arange(n)
    row, enters = int(np.argmin(q)), 2 * n
    for _ in range(_PIVOTS):
        table[row] /= table[row, enters]
        column = table[:, enters].copy()
        column[row] = 0
        table -= np.multiply.outer(column, table[row])
        table[:, enters] = np.arange(n) == row
        left, basis[row] = int(basis[row]), enters
        if left == 2 * n:
            values = np.zeros(2 * n + 1)
            values[basis] = table[:, -1]
            return values[n : 2 * n]
        enters = left + n if left < n else left - n
        pivots = table[:, enters]
        possible = np.flatnonzero(pivots > ROUNDED_SUM)
        if not len(possible):
            return None
        ratios = table[possible, -1] / pivots[possible]
        least = ratios.min()
        ties = possible[ratios <= least + ROUNDED_CHAIN * (1 + abs(least))]
        artificial = ties[basis[ties] == 2 * n]
        order = np.lexsort((table[ties, :n] / pivots[ties, None]).T[::-1])
        row = int(artificial[0]) if len(artificial) else int(ties[order[0]])
    return None


def faceted(problem: ContactProblem) -> Array | None:
    """Forces λ (dk) for one coefficient per contact, with polyhedral cones in space; None if Lemke's method finds none."""
    k, d = problem.count, problem.dimension
    facets = np.array([[1.0], [-1.0]]) if d == 2 else unit(2 * np.pi * np.arange(_FACETS) / _FACETS)
    m, free = len(facets), np.flatnonzero(~problem.slides)
    n = k + (m + 1) * len(free)
    forces, gaps, speeds = np.zeros((d * k, n)), np.zeros((n, d * k)), np.zeros((n, n))
    for i in range(k):
        forces[d * i, i], gaps[i, d * i] = 1.0, 1.0
        forces[d * i + 1 : d * i + d, i] = -problem.kinetic[i] * problem.directions[i]
    for j, i in enumerate(free.tolist()):
        here, sigma, tangents = slice(k + j * m, k + j * m + m), n - len(free) + j, slice(d * i + 1, d * i + d)
        forces[tangents, here], gaps[here, tangents] = facets.T, facets
        speeds[here, sigma], speeds[sigma, i], speeds[sigma, here] = 1.0, problem.static[i], -1.0
    # scaled: accelerations by the largest |b|, forces by the largest |b| over the largest W_ii
    most, bias = np.diag(problem.mobility).max(), np.abs(problem.bias).max()
    if bias <= 0:
        return np.zeros(d * k)
    z = complementary(gaps @ (problem.mobility / most) @ forces + speeds, gaps @ (problem.bias / bias))
    return None if z is None else forces @ z * (bias / most)


def residual(problem: ContactProblem, forces: Array) -> tuple[Array, Array]:
    """The residual of Alart and Curnier's equations (dk), in units of force, and its generalized Jacobian (dk × dk)."""
    k, d = problem.count, problem.dimension
    a, each = problem.mobility @ forces + problem.bias, np.eye(len(forces))
    value, slope = np.zeros_like(forces), np.zeros_like(problem.mobility)
    for i in range(k):
        n, t = d * i, slice(d * i + 1, d * i + d)
        r = 1.0 / np.linalg.norm(problem.mobility[n : n + d, n : n + d], 2)
        pressed, moved = forces[n] - r * a[n], forces[t] - r * a[t]
        by_normal, by_tangents = each[n] - r * problem.mobility[n], each[t] - r * problem.mobility[t]
        length = float(np.sqrt(moved @ moved))
        radius = problem.static[i] * pressed
        value[n], slope[n] = forces[n], each[n]
        if pressed > 0:
            value[n], slope[n] = r * a[n], r * problem.mobility[n]
        if problem.slides[i]:
            value[t] = forces[t] + problem.kinetic[i] * forces[n] * problem.directions[i]
            slope[t] = each[t] + problem.kinetic[i] * np.multiply.outer(problem.directions[i], each[n])
        elif pressed <= 0:
            value[t], slope[t] = forces[t], each[t]
        elif length <= radius:
            value[t], slope[t] = r * a[t], r * problem.mobility[t]
        else:
            u = moved / length
            value[t] = forces[t] - radius * u
            turned = by_tangents - np.multiply.outer(u, u @ by_tangents)
            slope[t] = each[t] - problem.static[i] * np.multiply.outer(u, by_normal) - radius / length * turned
    return value, slope


def newton(problem: ContactProblem, forces: Array, steps: int = _STEPS) -> tuple[Array, float]:
    """Forces (dk) after at most `steps` damped Newton steps, and the residual relative to their size."""
    size = np.abs(problem.bias).max() / np.diag(problem.mobility).max()
    value, slope = residual(problem, forces)
    length = float(np.linalg.norm(value))
    for _ in range(steps):
        if length <= ROUNDED * (size + np.abs(forces).max()):
            break
        try:
            step = np.linalg.solve(slope, -value)
        except np.linalg.LinAlgError:
            step = np.linalg.lstsq(slope, -value, rcond=ROUNDED_CHAIN)[0]
        share = 1.0
        for _ in range(_HALVINGS):
            value, slope = residual(problem, forces + share * step)
            if np.linalg.norm(value) < (1 - 0.1 * share) * length:
                break
            share /= 2
        else:  # no descent, as at a kink: take the full step
            share = 1.0
            value, slope = residual(problem, forces + step)
        forces, length = forces + share * step, float(np.linalg.norm(value))
    size += float(np.abs(forces).max())
    return forces, length / (size or 1.0) if np.isfinite(size) else np.inf


def proximal(problem: ContactProblem, forces: Array) -> tuple[Array, float]:
    """Forces (dk) by proximal steps, for redundant contacts; then 0 if converged, else the last relative change or infinity."""
    weights, share, change = np.diag(np.diag(problem.mobility)), _FIRST, np.inf
    for _ in range(_OUTER):
        nearer = replace(
            problem, mobility=problem.mobility + share * weights, bias=problem.bias - share * (weights @ forces)
        )
        found, left = newton(nearer, forces, _INNER)
        if left > EQUAL:
            share *= 10
            if share > _LARGEST:
                return forces, np.inf
            continue
        change = float(np.abs(found - forces).max() / max(np.abs(found).max(), np.finfo(float).tiny))
        forces, share = found, max(share / 10, _LEAST)
        if change <= ROUNDED_CHAIN:
            return forces, 0.0
    return forces, change


def iterated(problem: ContactProblem) -> ModeSolution | None:
    """A solution of a problem with one coefficient per contact; None if none was found, which does not prove that none exists."""
    exact = (_exact(problem, forces) for forces in _nearly(problem))
    return next((solution for solution in exact if solution is not None), None)


def _nearly(problem: ContactProblem) -> Iterator[Array]:
    """Approximate forces (dk): in the plane Lemke's, which are exact; in space those of Newton's method, then of proximal steps."""
    start = faceted(problem)
    if start is not None and problem.dimension == 2:
        yield start
    if problem.dimension == 3:
        begins = np.zeros(len(problem.bias)) if start is None else start
        for method in (newton, proximal):
            forces, left = method(problem, begins)
            if left <= ROUNDED_ROOT:
                yield forces


def _exact(problem: ContactProblem, forces: Array) -> ModeSolution | None:
    """The solution in the mode that approximate forces show; while it is inconsistent the contact of least margin changes; or None."""
    modes, directions = _read(problem, forces)
    for _ in range(problem.count + 1):
        solution = solve(problem, modes, directions, forces)
        if solution.consistent:
            return solution
        worst = int(np.argmin(solution.margins))
        if not np.isfinite(solution.margins[worst]) or modes[worst] is ContactStatus.OPEN:
            return None
        if modes[worst] is ContactStatus.FRESH_SLIP:
            modes[worst] = ContactStatus.STICK
        elif problem.normals(solution.forces)[worst] < 0:
            modes[worst] = ContactStatus.OPEN
        else:
            return None
    return None


def _read(problem: ContactProblem, forces: Array) -> tuple[list[ContactStatus], Array]:
    """Modes (k) and directions of slip (k × d − 1) that approximate forces show."""
    a = problem.mobility @ forces + problem.bias
    force, acceleration = np.abs(forces).max(initial=0), np.abs(problem.bias).max(initial=0)
    normal, gap, tangential = problem.normals(forces), problem.normals(a), problem.tangents(a)
    length = np.sqrt((tangential * tangential).sum(axis=1))
    leaves = (normal <= ROUNDED_ROOT * force) & (
        (gap > ROUNDED_ROOT * acceleration) | (normal <= ROUNDED_CHAIN * force)
    )
    rests = length <= ROUNDED_ROOT * acceleration
    directions = tangential / np.where(length > 0, length, 1.0)[:, None]
    kinds = list(shown(problem, leaves, rests))
    return kinds, np.where(problem.slides[:, None], problem.directions, directions)
