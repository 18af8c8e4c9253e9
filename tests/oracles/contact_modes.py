# SPDX-License-Identifier: BSD-3-Clause
"""Modes of contacts a second way, without kane: every mode tried, directions of slip on grids, cones by a conic solver.

A state has W, b, `static`, `kinetic` and `sliding` (k × d − 1, zero where a contact does not slip yet). Numbers are near 1.
"""

from itertools import product

import numpy as np
from scipy import sparse
from scipy.optimize import brentq, root

NEAR = 1e-8


def rounds(state, answers):
    """μ_s first, then μ_k for what slips: (labels, a, …) of the last round, or all of the first that has not just one."""
    mu = state.static.copy()
    while True:
        found = answers(state, mu)
        if len(found) != 1:
            return found
        begins = np.array([kind == "begins" for kind in found[0][0]])
        new = begins & (state.kinetic < mu)
        if not new.any():
            return found
        mu = np.where(new, state.kinetic, mu)


def enumerated(state, mu):
    """All (labels, a) with one coefficient a contact, different in a."""
    found = []
    for mode in product(*[("open", "slides") if slides else ("open", "stick", "begins") for slides in state.slides]):
        for a, forces, directions in _solved(state, mode, mu):
            holds = violation(state, mode, mu, a, forces, directions) < NEAR
            if holds and not any(np.abs(a - other).max() < 1e-6 for _, other in found):
                found.append((labels(state, a), a))
    return found


def labels(state, a, near=NEAR):
    rows = a.reshape(len(state.static), -1)
    kinds = []
    for slides, row in zip(state.slides, rows, strict=True):
        rests = np.abs(row[1:]).max() < near
        kinds.append("open" if row[0] > near else "slides" if slides else "stick" if rests else "begins")
    return tuple(kinds)


def _solved(state, mode, mu):
    """(a, λ, directions) for each set of directions that contacts which begin to slip may have."""
    begins = [i for i, kind in enumerate(mode) if kind == "begins"]
    if state.d == 2:
        for signs in product((1.0, -1.0), repeat=len(begins)):
            directions = dict(zip(begins, np.reshape(signs, (-1, 1)), strict=True))
            yield *_linear(state, mode, mu, directions), directions
        return
    for angles in _angles(state, mode, mu, begins):
        directions = _by_angle(begins, angles)
        yield *_linear(state, mode, mu, directions, conic=True), directions


def _by_angle(begins, angles):
    return {i: np.array([np.cos(t), np.sin(t)]) for i, t in zip(begins, angles, strict=True)}


def _columns(state, mode, mu, directions):
    d, unit, rows, columns = state.d, np.eye(len(state.b)), [], []
    for i, kind in enumerate(mode):
        if kind == "open":
            continue
        rows.append(d * i)
        if kind == "stick":
            rows += range(d * i + 1, d * i + d)
            columns += list(unit[d * i : d * i + d])
        else:
            t = state.sliding[i] if kind == "slides" else directions[i]
            coefficient = state.kinetic[i] if kind == "slides" else mu[i]
            columns.append(unit[d * i] - coefficient * t @ unit[d * i + 1 : d * i + d])
    return rows, np.reshape(columns, (-1, len(state.b))).T


def _linear(state, mode, mu, directions, conic=False):
    rows, columns = _columns(state, mode, mu, directions)
    if not rows:
        return state.b.copy(), np.zeros_like(state.b)
    a = (state.W @ columns)[rows]
    x, _, rank, _ = np.linalg.lstsq(a, -state.b[rows], rcond=1e-11)
    if conic and rank < len(rows) and "stick" in mode:
        x = _cone_point(mode, mu, a, -state.b[rows], x)
    forces = columns @ x
    return state.W @ forces + state.b, forces


def _cone_point(mode, mu, a, c, otherwise):
    """The least x in the cones with A x = c by clarabel."""
    import clarabel

    n, blocks, cones, first = len(c), [], [], 0
    for i, kind in enumerate(mode):
        if kind == "open":
            continue
        size = 3 if kind == "stick" else 1
        block = np.zeros((size, n))
        block[:, first : first + size] = -np.eye(size)
        if size > 1:
            block[0] *= mu[i]
        blocks.append(block)
        cones.append(clarabel.SecondOrderConeT(3) if size > 1 else clarabel.NonnegativeConeT(1))
        first += size
    u, s, v = np.linalg.svd(a)
    rank = int((s > 1e-11 * s[0]).sum())
    if np.abs(u[:, rank:].T @ c).max(initial=0) > 1e-9:
        return otherwise
    rows = s[:rank, None] * v[:rank]
    right = np.concatenate([u[:, :rank].T @ c, np.zeros(sum(len(b) for b in blocks))])
    solution = _clarabel(np.eye(n), np.zeros(n), np.vstack([rows, *blocks]), right, [clarabel.ZeroConeT(rank), *cones])
    # what the solver leaves of the equations is taken away, by as little as is possible
    return otherwise if solution is None else solution - np.linalg.pinv(a, 1e-11) @ (a @ solution - c)


def _clarabel(p, q, a, b, cones):
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    problem = sparse.csc_matrix(np.triu(p)), q, sparse.csc_matrix(a), b, cones, settings
    result = clarabel.DefaultSolver(*problem).solve()
    return np.array(result.x) if "Solved" in str(result.status) else None


def _angles(state, mode, mu, begins):
    """Sets of angles at which accelerations are along the directions of slip: from grids, by Brent's and Powell's methods."""
    if not begins:
        return [()]

    def turned(angles):
        directions = _by_angle(begins, angles)
        a, _ = _linear(state, mode, mu, directions)
        return np.array([directions[i][0] * a[3 * i + 2] - directions[i][1] * a[3 * i + 1] for i in begins])

    count = {1: 360, 2: 36, 3: 8}[len(begins)]
    ring = 2 * np.pi * (np.arange(count) + 0.137) / count
    grid = [np.array(angles) for angles in product(ring, repeat=len(begins))]
    values = np.array([turned(angles) for angles in grid])
    if len(begins) == 3:
        starts, found = range(len(grid)), []
    elif len(begins) == 1:
        v, last = values[:, 0], np.roll(values[:, 0], 1)
        changes = (v * last < 0) & (np.minimum(np.abs(v), np.abs(last)) > 1e-12)
        found = [
            [brentq(lambda t: turned([t])[0], ring[i] - ring[1] + ring[0], ring[i], xtol=1e-15)]
            for i in np.flatnonzero(changes)
        ]
        low = (np.abs(v) <= np.abs(last)) & (np.abs(v) <= np.abs(np.roll(v, -1)))
        starts = np.flatnonzero(low)
    else:
        v, found = np.abs(values).max(axis=1).reshape(count, count), []
        around = [np.roll(v, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        signs = np.sign(values).reshape(count, count, 2)
        cell = np.array([np.roll(signs, (-i, -j), (0, 1)) for i in (0, 1) for j in (0, 1)])
        both = (cell.min(axis=0) < cell.max(axis=0)).all(axis=-1)  # each changes its sign at the corners of a cell
        starts = np.flatnonzero(((v <= np.min(around, axis=0)) | both).ravel())
    results = [root(turned, grid[start], tol=1e-13) for start in starts]
    return found + [result.x for result in results if np.abs(result.fun).max() < 1e-9]


def violation(state, mode, mu, a, forces, directions):
    """By how much the laws of a mode fail, in units of accelerations and of the largest force."""
    d, worst, unit = state.d, np.abs(state.W @ forces + state.b - a).max(), max(1.0, np.abs(forces).max())
    for i, kind in enumerate(mode):
        rows = slice(d * i + 1, d * i + d)
        normal, friction, gap, slip = forces[d * i] / unit, forces[rows] / unit, a[d * i], a[rows]
        if kind == "open":
            fails = [-gap, abs(normal), np.abs(friction).max()]
        else:
            fails = [abs(gap), -normal]
            if kind == "stick":
                fails += [np.abs(slip).max(), np.linalg.norm(friction) - mu[i] * normal]
            elif kind == "slides":
                fails += [np.abs(friction + state.kinetic[i] * normal * state.sliding[i]).max()]
            else:
                t = directions[i]
                fails += [np.abs(friction + mu[i] * normal * t).max(), np.abs(slip - t * (t @ slip)).max(), -t @ slip]
        worst = max(worst, *fails)
    return worst


def conic(state, mu):
    """[(labels, a, λ)] by Cadoux's fixed point, [] if it does not settle; contacts do not slip yet.

    minimize ½ λᵀWλ + (b + μ s n)ᵀλ over the cones, s = |a_t|, again and again
    """
    import clarabel

    k, d = len(mu), state.d
    s, n = np.zeros(k), d * k
    rows = -np.eye(n)
    rows[::d] *= np.maximum(mu, 1e-12)[:, None]
    for _ in range(200):
        q = state.b.copy()
        q[::d] += mu * s
        forces = _clarabel(state.W, q, rows, np.zeros(n), [clarabel.SecondOrderConeT(d)] * k)
        if forces is None:
            return []
        a = state.W @ forces + state.b
        speeds = np.linalg.norm(a.reshape(k, d)[:, 1:], axis=1)
        if np.abs(speeds - s).max() < 1e-9:
            return [(labels(state, a, 1e-6), a, forces)]
        s = speeds
    return []
