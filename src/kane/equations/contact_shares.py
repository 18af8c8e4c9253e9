# SPDX-License-Identifier: BSD-3-Clause
"""The distribution of contact forces among several contacts of a body on a plane, which rigid bodies leave undetermined.

The rows of all contacts are combinations of a few rows B that constrain the body, J = G B; forces λ with Gᵀ λ = R are equivalent to
the multipliers R of those rows. Normal forces are the minimum-norm ones with that sum and those moments (as on equal springs), and
friction is proportional to μ_s N, F_i = μ_i N_i (V + Ω × r_i), as of a body on equal bristles:

    N = G_n (G_nᵀ G_n)⁻¹ R_n          F = D G_t (G_tᵀ D G_t)⁻¹ R_t,    D = diag(μ_i N_i)

If these forces leave a friction cone and others do not, the forces furthest within all cones are taken, as shares of (R_n, R_t) at one
instant, with which forces grow in proportion. A body thus slips or tips only if no admissible forces hold it. If some contacts slip,
their friction is proportional to N: R follows from the shares, and any shares give the same accelerations.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kane.contacts.cones import Block, inside, least_forces
from kane.equations.mode_equations import ContactsAtState, undetermined
from kane.model.contact_modes import Stand
from kane.model.contacts import ContactMode, Modes
from kane.numeric.arrays import Array
from kane.numeric.rank import singular
from kane.numeric.scale import GIVEN, INVERSE_RANK

_HALVINGS, _MORE = 36, 3
"""Margins that are tried, each half of the one before, and halvings of the interval behind the first that forces have."""
_ENOUGH = 1e-3
"""Margin of forces as of springs and bristles with which a mode may begin: with less it soon ends."""
_APART = 0.1
"""Share of the mean normal force that a margin of 1 asks of each."""


class Shares(NamedTuple):
    """The shares of a stand's multipliers in N (k × r), and in F of the contacts that stick (k_s (d − 1) × r_t).

    `margin` is the largest relative distance of forces from their friction cones, from 0, where the body slips or tips, to 1.
    """

    normal: Array
    along: Array
    margin: float


class StandRows(NamedTuple):
    """Normals (k × r) and zero slips (k_s (d − 1) × r_t) of a stand in the rows that constrain it, and the contacts that stick.

    `held` are the rows that hold it (r + r_t × kd); `columns` (kd × k + k_s (d − 1)) the forces λ by N of all and F of those that
    stick.
    """

    normal: Array
    along: Array
    sticks: tuple[int, ...]
    held: Array
    columns: Array


def rows_of(touch: ContactsAtState, stand: Stand, modes: Modes, directions: Array) -> StandRows:
    """The rows of a stand at an instant.

    Raises
    ------
    SimulationError
        if rows across the plane and along it depend on each other: it is not one plane
    """
    d, contacts, unit = touch.layout.d, touch.layout.contacts, np.eye(len(touch.mobility))
    sticks = tuple(i for i in stand.members if not modes[i].slips and contacts[i].slips)
    normals = [d * i for i in stand.members]
    along = [d * i + j for i in sticks for j in range(1, d)]
    held = [unit[d * i] for i in stand.members if not modes[i].carried]
    n, r = len(normals), len(held)
    for i in sticks:
        if modes[i] is ContactMode.STICK:
            held += [unit[d * i + j] for j in range(1, d)]
        elif modes[i] is ContactMode.ACROSS:
            held.append(directions[i][0] * unit[d * i + 2] - directions[i][1] * unit[d * i + 1])
    rows, w = np.array(held), touch.mobility
    g = np.linalg.solve(rows @ w @ rows.T, rows @ w[:, normals + along]).T
    beside = np.abs(g[:n, r:]).max(initial=0), np.abs(g[n:, :r]).max(initial=0)
    if max(beside) > GIVEN * np.abs(g).max():
        raise undetermined(*(contacts[i] for i in stand.members))
    columns = unit[:, normals + along]
    for k, i in enumerate(stand.members):
        if modes[i].slips:
            columns[d * i + 1 : d * i + d, k] = -touch.numbers.laws[i, 1] * directions[i]
    return StandRows(g[:n, :r], g[n:, r:], sticks, rows, columns)


def shares(touch: ContactsAtState, stand: Stand, modes: Modes, rows: StandRows, forces: Array) -> Shares:
    """The shares of a stand in a mode; `forces` (kd) are any forces equivalent to those of all contacts at this instant."""
    d, members = touch.layout.d, list(stand.members)
    mu = touch.numbers.laws[list(rows.sticks), 0]
    normal, along = forces[[d * i for i in members]], forces[[d * i + j for i in rows.sticks for j in range(1, d)]]
    given, r = np.concatenate([normal, along]), rows.normal.shape[1]
    of_n = _like_springs(rows.normal, np.ones(len(members)))
    n = of_n @ (rows.normal.T @ normal)
    places = [members.index(i) for i in rows.sticks]
    of_t = _like_springs(rows.along, np.repeat(mu * n[places], d - 1))
    by = np.concatenate([rows.normal.T @ normal, rows.along.T @ along])
    if len(rows.sticks) < len(members):
        pulled = rows.held @ touch.mobility @ rows.columns
        by = np.linalg.lstsq(np.hstack([pulled[:, : len(n)] @ of_n, pulled[:, len(n) :] @ of_t]), pulled @ given)[0]
    n, f = of_n @ by[:r], of_t @ by[r:]
    mean, pressing = float(n.sum()) / len(n), mu * n[places]
    sizes = np.linalg.norm(f.reshape(-1, d - 1), axis=1)
    most = max(
        (float(a / b) if b > 0 else float(a > 0) * np.inf for a, b in zip(sizes, pressing, strict=True)), default=0
    )
    margin = min(float(n.min()) / mean, 1 - most) if mean > 0 else 0.0
    if margin >= _ENOUGH:
        return Shares(of_n, of_t, margin)
    all_stick = len(rows.sticks) == len(members)
    found = _furthest_inside(touch, rows, members, mu, np.concatenate([n, f]) if all_stick else given, d)
    if found is None and all_stick:
        return Shares(of_n, of_t, 0.0)
    x, margin = found or (given, 0.0)
    return Shares(_led(of_n, rows.normal, x[: len(n)]), _led(of_t, rows.along, x[len(n) :]), margin)


def _like_springs(g: Array, stiffness: Array) -> Array:
    """D G (Gᵀ D G)⁻¹ with D = diag(stiffness), where a zero stiffness is replaced by a small one."""
    if not g.size:
        return g
    least = 1e-9 * stiffness.max(initial=0)
    by = np.maximum(stiffness, least)[:, None] * g if least > 0 else g
    return np.asarray(np.linalg.solve(g.T @ by, by.T).T)


def _led(of: Array, g: Array, forces: Array) -> Array:
    """Shares by which the multipliers give these forces at this instant."""
    r = g.T @ forces
    size = float(r @ r) if r.size else 0.0
    return of + np.multiply.outer(forces - of @ r, r) / size if size > 0 else of


def _what_they_do(touch: ContactsAtState, rows: StandRows, k: int) -> Array:
    """An orthonormal basis (rows) of the resultants of a stand's forces: sums and moments, or accelerations if some contacts slip."""
    if len(rows.sticks) == k:
        r = rows.normal.shape[1]
        g = np.zeros((rows.columns.shape[1], r + rows.along.shape[1]))
        g[:k, :r], g[k:, r:] = rows.normal, rows.along
        return np.asarray(np.linalg.qr(g)[0].T)
    size = np.sqrt(np.maximum(np.diag(touch.mobility), 0.0))
    moved = (touch.mobility @ rows.columns)[size > 0] / size[size > 0, None]
    values = singular(moved)
    return np.asarray(values.right[: values.rank(INVERSE_RANK)])


def _furthest_inside(
    touch: ContactsAtState, rows: StandRows, members: Sequence[int], mu: Array, given: Array, d: int
) -> tuple[Array, float] | None:
    """Forces (N, then F) equivalent to `given` with |F| ≤ (1 − m) μ_s (N − m N₀), N₀ a share of the mean, and the largest m."""
    k, wide = len(members), d - 1
    mean = float(given[:k].mean())
    order, blocks, where = list[int](), list[tuple[int, int, int]](), {i: n for n, i in enumerate(rows.sticks)}
    for n, i in enumerate(members):
        own = [n, *(k + wide * where[i] + j for j in range(wide))] if i in where else [n]
        blocks.append((len(order), len(own), where.get(i, -1)))
        order += own
    q = _what_they_do(touch, rows, k)[:, order]

    def at(m: float) -> Array | None:
        shift = np.zeros(len(given))
        shift[:k] = m * _APART * mean
        cones = [Block(first, size, (1 - m) * mu[n] if n >= 0 else 0.0) for first, size, n in blocks]
        near = (given - shift)[order]
        forces = least_forces(cones, q, near, near).forces
        if forces is None or not inside(cones, forces):  # where there is no choice
            return None
        x = np.zeros(len(given))
        x[order] = forces
        return x + shift

    m, best = 1.0, None
    for _ in range(_HALVINGS):
        m /= 2
        best = at(m)
        if best is not None:
            break
    if best is None:
        return None
    step = m / 2
    for _ in range(_MORE):
        x = at(m + step)
        if x is not None:
            best, m = x, m + step
        step /= 2
    return best, m
