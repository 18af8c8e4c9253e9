# SPDX-License-Identifier: BSD-3-Clause
"""The linear equations of a contact mode, solved with error bounds, and the margins by which its inequalities hold.

The unknowns x are the forces of sticking contacts and the normal forces of slipping ones, λ = C x; R selects the accelerations that
vanish: R a = 0, so A x = −R b with A = R W C. Directions of incipient slip in space result from Newton's method on d⊥·a_t = 0.

Errors: with s_i = √W_ii the error of W_ij is relative to s_i s_j, even if rows i and j have no body in common, as for J M⁻¹ Jᵀ and its
singular values; so r_i = s_i Σ s_j |λ_j| + terms, |Δx| ≤ u |A⁻¹| r and |Δa| ≤ u (r + |W C A⁻¹| r) with u = 1024 ε. A margin is the
value of an inequality over its error bound: above 1 it holds, below −1 it is violated, between both lies its boundary.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.contacts.angles import across
from kane.contacts.cones import Block, inside, least_forces
from kane.contacts.problem import ContactProblem, ContactStatus
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import singular
from kane.numeric.scale import EPS, INVERSE_RANK, LAST_DIGIT, ROUNDED_CHAIN, SIX_DIGITS

U = 1024 * EPS
"""Relative error of W and b beside the terms that cancel in them: their rows are products along chains of bodies."""
_REDUNDANT = 2 * ROUNDED_CHAIN
"""Error of undetermined forces relative to the largest force: the accuracy of the dual problem for the least forces."""
MET = 64.0
"""Multiple of its error bound up to which an equation counts as satisfied."""
_DEPENDS = 1e-8
"""Relative effect of undetermined forces up to which accelerations count as independent of them."""
_TURNS, _TURN = 30, 0.7
"""Largest number of Newton steps in the directions of incipient slip, and the largest step in rad."""


@dataclass(frozen=True, slots=True, eq=False)
class ModeSolution:
    """The solution of the equations of a mode of all contacts, whether or not its inequalities hold.

    Attributes
    ----------
    modes : status of each contact (k)
    directions : unit vectors of slip (k × d − 1), zero for contacts that open or stick
    forces, accelerations : λ and a (dk)
    force_errors, acceleration_errors : bounds of their errors (dk)
    margins : least margin of each contact's inequalities (k); −∞ if the equations are not satisfied
    rank, unknowns : rank of A and number n of unknown forces
    determined : whether the accelerations are determined, even if the forces are not
    certain : false if the search for forces in the cones failed without proof that none exist
    """

    modes: tuple[ContactStatus, ...]
    directions: Array
    forces: Array
    accelerations: Array
    force_errors: Array
    acceleration_errors: Array
    margins: Array
    rank: int
    unknowns: int
    determined: bool
    certain: bool

    @property
    def consistent(self) -> bool:
        """Whether every inequality holds up to its error; boundaries are included."""
        return bool((self.margins >= -1).all())


class ModeConditions(NamedTuple):
    """Indices `rows` of accelerations that vanish, `columns` C (dk × n), `blocks` of x by contact, and their contacts `owners`."""

    rows: Array
    columns: Array
    blocks: tuple[Block, ...]
    owners: tuple[int, ...]


class LinearSolution(NamedTuple):
    """x and a; W C, A and its pseudo-inverse; bases of its row space (r × n, orthonormal if m > 0) and of its null space (n × m)."""

    x: Array
    a: Array
    rates: Array
    matrix: Array
    inverse: Array
    basis: Array
    null: Array


def equations(problem: ContactProblem, modes: Sequence[ContactStatus], directions: Array) -> ModeConditions:
    """The equations of a mode, ordered by contact."""
    d, rows, columns, blocks, owners = problem.dimension, list[int](), list[Array](), list[Block](), list[int]()
    unit = np.eye(d * problem.count)
    for i, mode in enumerate(modes):
        if mode is ContactStatus.OPEN:
            continue
        size = d if mode is ContactStatus.STICK else 1
        owners.append(i)
        blocks.append(Block(len(columns), size, problem.static[i] if size > 1 else 0.0))
        rows += range(d * i, d * i + size)
        if size > 1:
            columns += list(unit[d * i : d * i + d])
            continue
        column = unit[d * i].copy()
        column[d * i + 1 : d * i + d] = -problem.kinetic[i] * directions[i]
        columns.append(column)
    stacked = np.array(columns).reshape(-1, d * problem.count).T
    return ModeConditions(np.array(rows, dtype=np.intp), stacked, tuple(blocks), tuple(owners))


def linear(problem: ContactProblem, mode: ModeConditions, near: Array | None = None) -> LinearSolution:
    """The solution x of A x = −R b, if it has one, that is nearest to `near` (n), zero unless given."""
    rates = problem.mobility @ mode.columns
    a, right = rates[mode.rows], problem.bias[mode.rows]
    size = np.sqrt(np.diag(problem.mobility))
    size = np.where(size > LAST_DIGIT * size.max(), size, size.max())[mode.rows]
    values = singular(a / np.multiply.outer(size, size))
    rank = values.rank(INVERSE_RANK)
    left, kept = values.left[:, :rank], values.right[:rank]
    inverse = (kept.T / size[:, None]) @ ((left / values.values[:rank]).T / size)
    basis, null = kept, values.right[rank:].T / size[:, None]
    if null.size:
        basis = np.linalg.qr((kept * size).T)[0].T
        inverse = basis.T @ (basis @ inverse)  # least norm in x itself, not in x scaled by √W_ii
    x = -inverse @ right if near is None else near - inverse @ (right + a @ near)
    return LinearSolution(x, rates @ x + problem.bias, rates, a, inverse, basis, null)


class SlipAlignment(NamedTuple):
    """d⊥·a_t (f) of contacts that begin to slip; derivatives by their angles of d⊥·a_t (f × f), of x (n × f) and of a (dk × f)."""

    across: Array
    slope: Array
    x: Array
    a: Array


def turning(
    problem: ContactProblem, mode: ModeConditions, fresh: Sequence[int], directions: Array, at: LinearSolution
) -> SlipAlignment:
    """d⊥·a_t and derivatives by the angles of incipient slip, at the solution `at`."""
    quarter = across(directions)
    x_slopes, a_slopes = np.zeros((len(at.x), len(fresh))), np.zeros((len(at.a), len(fresh)))
    for r, i in enumerate(fresh):
        force = -problem.kinetic[i] * at.x[mode.blocks[mode.owners.index(i)].first] * quarter[i]
        direct = problem.mobility[:, 3 * i + 1 : 3 * i + 3] @ force
        x_slopes[:, r] = -at.inverse @ direct[mode.rows]
        a_slopes[:, r] = direct + at.rates @ x_slopes[:, r]
    tangents = [slice(3 * i + 1, 3 * i + 3) for i in fresh]
    value = np.array([quarter[i] @ at.a[t] for i, t in zip(fresh, tangents, strict=True)])
    along = np.array([directions[i] @ at.a[t] for i, t in zip(fresh, tangents, strict=True)])
    slope = np.array([quarter[i] @ a_slopes[t] for i, t in zip(fresh, tangents, strict=True)]) - np.diag(along)
    return SlipAlignment(value, slope, x_slopes, a_slopes)


def aligned(
    problem: ContactProblem, modes: Sequence[ContactStatus], directions: Array, near: Array | None = None
) -> Array:
    """Directions of incipient slip in space, parallel to the accelerations they cause, by Newton's method from `directions`."""
    fresh = [i for i, mode in enumerate(modes) if mode is ContactStatus.FRESH_SLIP]
    directions = directions.copy()
    for _ in range(_TURNS):
        mode = equations(problem, modes, directions)
        start = None if near is None else near[mode.rows]
        at = turning(problem, mode, fresh, directions, linear(problem, mode, start))
        try:
            step = np.linalg.solve(at.slope, -at.across)
        except np.linalg.LinAlgError:
            break
        most = np.abs(step).max()
        if not np.isfinite(most) or most <= LAST_DIGIT:
            break
        step *= min(1.0, _TURN / most)
        turned = directions[fresh] * np.cos(step)[:, None] + across(directions[fresh]) * np.sin(step)[:, None]
        directions[fresh] = turned / np.sqrt((turned * turned).sum(axis=1))[:, None]
    return directions


def solve(
    problem: ContactProblem, modes: Sequence[ContactStatus], directions: Array, near: Array | None = None
) -> ModeSolution:
    """The forces and accelerations of a mode, whether or not its inequalities hold.

    If A is rank-deficient, the forces are those nearest to λ = `near` that satisfy the equations and lie in the cones, if any do.
    """
    directions = np.where(np.array([m >= ContactStatus.FRESH_SLIP for m in modes])[:, None], directions, 0.0)
    fresh = [i for i, m in enumerate(modes) if m is ContactStatus.FRESH_SLIP] if problem.dimension == 3 else []
    if fresh:
        directions = aligned(problem, modes, directions, near)
    mode = equations(problem, modes, directions)
    start = None if near is None else near[mode.rows]
    at = linear(problem, mode, start)
    lost, certain = at.null.shape[1] > 0, True
    if lost and not inside(mode.blocks, at.x):
        found = least_forces(mode.blocks, at.basis, at.x, np.zeros(len(at.x)) if start is None else start)
        certain = found.certain
        if found.forces is not None:
            at = at._replace(x=found.forces, a=at.rates @ found.forces + problem.bias)
    forces = mode.columns @ at.x
    moved = at.rates @ at.null
    depends = np.abs(moved) > _DEPENDS * np.abs(at.rates).max(initial=0) * np.abs(at.null).max(initial=0)
    size = np.sqrt(np.diag(problem.mobility))
    own = problem.terms + size * (size @ np.abs(forces))
    terms = own[mode.rows]
    x_errors = U * (np.abs(at.inverse) @ terms)
    a_errors = U * (own + np.abs(at.rates @ at.inverse) @ terms)
    met = np.abs(at.a[mode.rows]) <= MET * a_errors[mode.rows]
    if fresh:
        turn = turning(problem, mode, fresh, directions, at)
        limits = np.array([a_errors[3 * i + 1 : 3 * i + 3].max() for i in fresh])
        met = np.append(met, np.abs(turn.across) <= MET * limits)
        angles = np.minimum(np.abs(np.linalg.pinv(turn.slope)) @ limits, SIX_DIGITS)  # larger if any direction fits
        x_errors, a_errors = x_errors + np.abs(turn.x) @ angles, a_errors + np.abs(turn.a) @ angles
    force_errors = np.abs(mode.columns) @ x_errors + (_REDUNDANT * np.abs(forces).max(initial=0) if lost else 0.0)
    margins = np.full(problem.count, -np.inf)
    if met.all() and np.isfinite(forces).all():
        margins = _margins(problem, modes, directions, forces, at.a, force_errors, a_errors)
    rank, determined = len(at.basis), not depends.any()
    return ModeSolution(
        tuple(modes), directions, forces, at.a, force_errors, a_errors, margins, rank, len(at.x), determined, certain
    )


def over(value: Array, error: Array) -> Array:
    """value / error; 0, on the boundary, where the value is exactly zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(value == 0, 0.0, value / error))


def _margins(
    problem: ContactProblem,
    modes: Sequence[ContactStatus],
    directions: Array,
    forces: Array,
    a: Array,
    force_errors: Array,
    a_errors: Array,
) -> Array:
    """The least margin of the inequalities of each contact (k)."""
    kinds, tangential, pressed = np.array(modes), problem.tangents(forces), problem.normals(forces)
    uncertain, friction = problem.normals(force_errors), np.sqrt((tangential * tangential).sum(axis=1))
    values = pressed, problem.normals(a), problem.static * pressed - friction, (directions * problem.tangents(a)).sum(1)
    cones = problem.static * uncertain + problem.tangents(force_errors).max(axis=1)
    errors = uncertain, problem.normals(a_errors), cones, problem.tangents(a_errors).max(axis=1)
    normal, gap, cone, along = over(np.array(values), np.array(errors))
    second = np.where(kinds == ContactStatus.STICK, cone, np.where(kinds == ContactStatus.FRESH_SLIP, along, np.inf))
    return np.asarray(np.where(kinds == ContactStatus.OPEN, gap, np.minimum(normal, second)))


def labelled(problem: ContactProblem, solution: ModeSolution) -> tuple[ContactStatus, ...]:
    """The status of each contact by its acceleration, independent of the solution's mode: closed before open, stick before slip."""
    a, error = solution.accelerations, 8 * solution.acceleration_errors
    leaves = problem.normals(a) > problem.normals(error)
    rests = np.abs(problem.tangents(a)).max(axis=1) <= problem.tangents(error).max(axis=1)
    return shown(problem, leaves, rests)


def shown(problem: ContactProblem, leaves: Mask, rests: Mask) -> tuple[ContactStatus, ...]:
    """The status of each contact, from masks (k) of those that leave and of those without tangential acceleration."""
    kinds = [ContactStatus.OPEN, ContactStatus.SLIP, ContactStatus.STICK]
    found = np.select([leaves, problem.slides, rests], kinds, ContactStatus.FRESH_SLIP)
    return tuple(map(ContactStatus, found.tolist()))
