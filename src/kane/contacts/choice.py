# SPDX-License-Identifier: BSD-3-Clause
"""The consistent modes of contacts, with forces and accelerations, and the number of solutions.

For μ_s ≥ μ_k the problem is solved in rounds with one coefficient per contact. Contacts that do not slip have μ_s at first; one that
begins to slip has μ_k in all later rounds, until no further contact begins to slip. Each round may have one solution, none or several.

Of several solutions, those without a slip that friction jams are preferred, as any compliance makes such a slip diverge (Or & Rimon
2012, Nonlinear Dynamics 67, 1647); then the one that continues the previous modes, then the one with the least forces, then that with
the most closed contacts and the most that stick.

All modes of few contacts are enumerated. Modes with equal accelerations count as one solution, such as two modes on their common
boundary.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import product
from typing import NamedTuple

import numpy as np

from kane.contacts.angles import one_direction, two_directions
from kane.contacts.iteration import iterated
from kane.contacts.mode_solution import ModeSolution, equations, labelled, linear, solve
from kane.contacts.problem import ContactProblem, ContactStatus
from kane.errors import ArgumentError, ContactError
from kane.expect import that
from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import EQUAL, INVERSE_RANK, ROUNDED, SIX_DIGITS

_BEGIN = {2: 4, 3: 2}
"""Largest number of contacts that may begin to slip, in the plane and in space: the directions of three contacts in space are not the
zeros of a polynomial in one variable."""
_MODES = 256
"""Largest number of modes to enumerate."""
_SAME = 1e3
"""Multiple of the error bounds up to which accelerations are equal."""


class SolutionCount(Enum):
    """The number of solutions with different accelerations; UNKNOWN if the search was incomplete or accelerations are undetermined."""

    ONE = "one"
    SEVERAL = "several"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True, eq=False)
class ModeChoice:
    """The chosen modes of all contacts.

    Attributes
    ----------
    solution : the chosen solution: modes, directions, forces, accelerations, margins
    count : number of solutions; SEVERAL if a round had several
    others : the rejected solutions of the first round with several
    jams : contacts that friction may jam, W_nn < μ |W_tn| (Painlevé's paradox): existence and uniqueness may fail there
    """

    solution: ModeSolution
    count: SolutionCount
    others: tuple[ModeSolution, ...]
    jams: tuple[int, ...]

    @property
    def modes(self) -> tuple[ContactStatus, ...]:
        """The status of each contact (k)."""
        return self.solution.modes

    @property
    def directions(self) -> Array:
        """Unit vectors of slip (k × d − 1), zero for contacts that open or stick."""
        return self.solution.directions

    @property
    def forces(self) -> Array:
        """λ (dk), of least norm if rigid bodies do not determine them."""
        return self.solution.forces

    @property
    def accelerations(self) -> Array:
        """The accelerations a (dk)."""
        return self.solution.accelerations


def choose(problem: ContactProblem, before: Sequence[ContactStatus] | None = None) -> ModeChoice:
    """The consistent modes of contacts whose gaps and gap rates are zero.

    Parameters
    ----------
    problem : from `contact_problem`
    before : the modes up to this instant, continued if several solutions are consistent

    Raises
    ------
    ArgumentError
        if `before` does not have one mode per contact
    ContactError
        if no forces satisfy the laws of friction, or none were found
    """
    that(
        before is None or len(before) == problem.count,
        f"before= as the earlier modes of all {problem.count} contacts",
        before,
        "Leave it out if they are unknown.",
        error=ArgumentError,
    )
    met: list[ModeSolutions] = []
    path = next(_rounds(problem, problem.static, before, met), None)
    if path is None:
        raise ContactError(_none(problem, all(found.complete for found in met)))
    *_, (_, solution) = path
    others = next((tuple(s for s in f.solutions if s is not taken) for f, taken in path if len(f.solutions) > 1), ())
    certain = all(found.complete for found in met) and all(taken.determined for _, taken in path)
    count = SolutionCount.SEVERAL if others else SolutionCount.ONE if certain else SolutionCount.UNKNOWN
    return ModeChoice(solution, count, others, jamming(problem))


def _rounds(
    problem: ContactProblem, friction: Array, before: Sequence[ContactStatus] | None, met: "list[ModeSolutions]"
) -> "Iterator[tuple[tuple[ModeSolutions, ModeSolution], ...]]":
    """Sequences of (solutions found, solution taken), one pair per round, in order of preference; all found are appended to `met`."""
    found = _answers(problem.with_friction(friction))
    met.append(found)
    pressed = problem.slides & (wedging(problem) < 0)
    for solution in sorted(found.solutions, key=lambda s: _rank(s, before, found.solutions, pressed)):
        slips = np.array([m is ContactStatus.FRESH_SLIP for m in solution.modes])
        new = slips & (friction > problem.kinetic)
        if new.any():
            for later in _rounds(problem, np.where(new, problem.kinetic, friction), before, met):
                yield (found, solution), *later
        else:
            yield ((found, solution),)


def _answers(one: ContactProblem) -> "ModeSolutions":
    """Solutions with one coefficient per contact: all for few contacts; one for many, or if small friction makes it unique."""
    sole = unique(one)
    if few(one) and not sole:
        return enumerated(one)
    if sole:  # cheapest candidates: all contacts open, or all stay closed without incipient slip
        leave = bool((one.normals(one.bias) >= 0).all())
        modes = [
            ContactStatus.OPEN if leave else ContactStatus.SLIP if slides else ContactStatus.STICK
            for slides in one.slides
        ]
        at_once = solve(one, modes, one.directions)
        if at_once.consistent:
            return ModeSolutions((canonical(one, at_once, least=True),), True)
    solution = iterated(one)
    if solution is None:
        return enumerated(one) if few(one) else ModeSolutions((), False)
    return ModeSolutions((canonical(one, solution),), sole)


def unique(problem: ContactProblem) -> bool:
    """Whether accelerations are unique because friction is small, by a sufficient condition that costs less than solving one mode.

    Let Δ be the difference of two solutions with one coefficient per contact. a + μ |a_t| n lies in the dual of the friction cone and
    is perpendicular to λ (de Saxcé & Feng 1998, Math. Comput. Modelling 28, 225), so Δλ·Δa ≤ Σ μ |ΔN| |Δa_t|; for contacts that
    already slip along t, N ⟂ a_n gives the same with t·Δa_t. As Δa = W Δλ, accelerations are equal if Σ μ |N| |(W λ)_t| < λ·W λ for
    all λ with W λ ≠ 0. If N = 0 in the null space of W, N and (W λ)_t are linear in y = W^½ λ; 2 |N| |(W λ)_t| ≤ s N² + |(W λ)_t|²/s.
    """
    d, rubs = problem.dimension, np.flatnonzero(problem.kinetic)
    values, vectors = np.linalg.eigh(problem.mobility)
    kept = values > INVERSE_RANK * values[-1]
    root, basis = np.sqrt(values[kept]), vectors[:, kept].reshape(problem.count, d, -1)[rubs]
    if (1 - (basis[:, 0] ** 2).sum(axis=1) > ROUNDED).any():
        return False
    along = np.where(problem.slides[:, None, None], problem.directions[:, None] * np.eye(d - 1)[:, :1], np.eye(d - 1))
    pressing, moving = basis[:, :1] / root, along[rubs] @ (basis[:, 1:] * root)  # N = pressing·y, a_t = moving y
    s = np.sqrt((moving**2).sum(axis=2).max(axis=1) / (pressing**2).sum(axis=(1, 2)))
    s, half = np.maximum(s, np.finfo(float).tiny)[:, None, None], problem.kinetic[rubs, None, None] / 2
    rows = np.hstack([pressing * np.sqrt(half * s), moving * np.sqrt(half / s)]).reshape(-1, len(root))
    return bool(np.linalg.eigvalsh(rows.T @ rows).max(initial=0) < 1 - SIX_DIGITS)


def _rank(
    solution: ModeSolution, before: Sequence[ContactStatus] | None, every: Sequence[ModeSolution], pressed: Mask
) -> tuple[int, ...]:
    """The sort key, smallest if preferred; forces count by how many solutions have smaller ones; `pressed` (k) are jamming slips."""
    diverges = any(m is ContactStatus.SLIP and jams for m, jams in zip(solution.modes, pressed, strict=True))
    goes_on = before is not None and all(_continues(m, n) for m, n in zip(solution.modes, before, strict=True))
    closed = sum(m is not ContactStatus.OPEN for m in solution.modes)
    sticks = sum(m is ContactStatus.STICK for m in solution.modes)
    forces = sum(bool((1 + EQUAL) * (s.forces @ s.forces) < solution.forces @ solution.forces) for s in every)
    return diverges, not goes_on, forces, -closed, -sticks


def _continues(mode: ContactStatus, before: ContactStatus) -> bool:
    """Whether a contact keeps its status, where slip and incipient slip count as the same."""
    return mode is before or {mode, before} == {ContactStatus.SLIP, ContactStatus.FRESH_SLIP}


def wedging(problem: ContactProblem) -> Array:
    """W_nn − μ W_tn·t of each contact (k), along its slip or in the worst direction; negative if friction jams it (Painlevé)."""
    k, d = problem.count, problem.dimension
    blocks = problem.mobility.reshape(k, d, k, d)
    coupling = np.array([blocks[i, 1:, i, 0] for i in range(k)])
    along = (coupling * problem.directions).sum(axis=1)
    worst = np.sqrt((coupling * coupling).sum(axis=1))
    friction = np.where(problem.slides, problem.kinetic, problem.static)
    return np.asarray(np.diag(problem.mobility)[::d] - friction * np.where(problem.slides, along, worst))


def jamming(problem: ContactProblem) -> tuple[int, ...]:
    """The indices of contacts that friction may jam (Painlevé)."""
    return tuple(np.flatnonzero(wedging(problem) < 0).tolist())


def _none(problem: ContactProblem, complete: bool) -> str:
    factors = wedging(problem)
    pressed = ", ".join(
        f"{problem.name(i)} {'slides' if problem.slides[i] else 'would slide'} and its friction increases the normal force "
        f"(W_nn − μ W_tn·t = {factors[i]:.3g})"
        for i in jamming(problem)
    )
    why = f": {pressed}, Painlevé's paradox" if pressed else ""
    rest = "Continue with an impact without approach (`impact` with v_n = 0)"
    got, cure = ("none", rest) if complete else ("none found", "Some may exist; give fewer contacts at a time")
    return f"Expected forces that agree with the laws of friction, got {got}{why}. {cure}, or end the motion."


# All modes of few contacts ------------------------------------------------------------------------------------------


class ModeSolutions(NamedTuple):
    """Solutions with different accelerations; `complete` if these are all."""

    solutions: tuple[ModeSolution, ...]
    complete: bool


def few(problem: ContactProblem) -> bool:
    """Whether there are at most `_MODES` modes, and at most four contacts in the plane, or two in space, that do not slip yet."""
    slide, free, plane = int(problem.slides.sum()), int((~problem.slides).sum()), problem.dimension == 2
    return free <= _BEGIN[problem.dimension] and 2**slide * (4 if plane else 3) ** free <= _MODES


def enumerated(problem: ContactProblem) -> ModeSolutions:
    """All solutions of a problem with one coefficient per contact (`with_friction`); ArgumentError if there are too many contacts."""
    that(few(problem), "fewer contacts to enumerate their modes", problem.count, "Use `choose`.", error=ArgumentError)
    found, complete = list[ModeSolution](), True
    for modes, directions in _modes(problem):
        solution = solve(problem, modes, directions)
        complete = complete and (solution.certain or solution.consistent)
        if solution.consistent and not any(same(solution, other) for other in found):
            shown = canonical(problem, solution, least=True)
            if not any(same(shown, other) for other in found):
                found.append(shown)
    return ModeSolutions(tuple(found), complete)


def same(a: ModeSolution, b: ModeSolution) -> bool:
    """Whether two solutions have accelerations that are equal up to their errors."""
    error = _SAME * (a.acceleration_errors + b.acceleration_errors)
    return bool((np.abs(a.accelerations - b.accelerations) <= error).all())


def canonical(problem: ContactProblem, solution: ModeSolution, least: bool = False) -> ModeSolution:
    """The solution in the mode that its accelerations show; undetermined forces are the least ones (`least`: they are already).

    If accelerations depend on undetermined forces, as redundant contacts slip, those of the least forces are taken if consistent.
    """
    modes = labelled(problem, solution)
    if modes == solution.modes and (least or solution.rank == solution.unknowns):
        return solution
    tangential = problem.tangents(solution.accelerations)
    length = np.sqrt((tangential * tangential).sum(axis=1, keepdims=True))
    directions = np.where(problem.slides[:, None], problem.directions, tangential / np.where(length > 0, length, 1.0))
    for near in (None, solution.forces):
        shown = solve(problem, modes, directions, near)
        if shown.consistent and (same(shown, solution) or not shown.determined):
            return shown
    return solution


def _modes(problem: ContactProblem) -> Iterator[tuple[tuple[ContactStatus, ...], Array]]:
    """All modes (k), each with directions of slip (k × d − 1)."""
    plane = problem.dimension == 2
    begins = (
        ((ContactStatus.FRESH_SLIP, 1.0), (ContactStatus.FRESH_SLIP, -1.0))
        if plane
        else ((ContactStatus.FRESH_SLIP, 0.0),)
    )
    rest = ((ContactStatus.OPEN, 0.0), (ContactStatus.STICK, 0.0), *begins)
    choices = [((ContactStatus.OPEN, 0.0), (ContactStatus.SLIP, 0.0)) if slides else rest for slides in problem.slides]
    for choice in product(*choices):
        modes = tuple(mode for mode, _ in choice)
        if plane:
            signs = np.array([[sign] for _, sign in choice])
            yield modes, np.where(problem.slides[:, None], problem.directions, signs)
        else:
            for directions in _directions(problem, modes):
                yield modes, directions


def _directions(problem: ContactProblem, modes: tuple[ContactStatus, ...]) -> Iterator[Array]:
    """Candidate directions of slip (k × 2) in a mode with incipient slip in space, by elimination of the forces of other contacts."""
    fresh = [i for i, mode in enumerate(modes) if mode is ContactStatus.FRESH_SLIP]
    if not fresh:
        yield problem.directions
        return
    rows = np.array([3 * i + j for i in fresh for j in range(3)])
    others = equations(
        problem, [ContactStatus.OPEN if i in fresh else m for i, m in enumerate(modes)], problem.directions
    )
    at = linear(problem, others)
    w = problem.mobility[np.ix_(rows, rows)] - at.rates[rows] @ at.inverse @ problem.mobility[np.ix_(others.rows, rows)]
    b, mu = at.a[rows], problem.kinetic[fresh]
    found = one_direction(w, b, float(mu[0]))[:, None] if len(fresh) == 1 else two_directions(w, b, mu)
    for some in found:
        directions = problem.directions.copy()
        directions[fresh] = some
        yield directions
