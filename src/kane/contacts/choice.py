# SPDX-License-Identifier: BSD-3-Clause
"""The consistent modes of contacts, with forces and accelerations, and the number of solutions.

For μ_s ≥ μ_k the problem is solved in rounds with one coefficient per contact. Contacts that do not slip have μ_s at first; one that
begins to slip has μ_k in all later rounds, until no further contact begins to slip. Each round may have one solution, none or several.

Of several solutions, those without a slip that friction jams are preferred, as any compliance makes such a slip diverge (Or & Rimon
2012, Nonlinear Dynamics 67, 1647); then the one that continues the previous modes, then the one with the least forces, then that with
the most closed contacts and the most that stick.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from kane.contacts.enumeration import ModeSolutions, canonical, enumerated, few
from kane.contacts.iteration import iterated
from kane.contacts.mode_solution import ModeSolution, solve
from kane.contacts.problem import ContactProblem, ContactStatus
from kane.errors import ArgumentError, ContactError
from kane.expect import that
from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import EQUAL, INVERSE_RANK, ROUNDED, SIX_DIGITS


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
    problem: ContactProblem, friction: Array, before: Sequence[ContactStatus] | None, met: list[ModeSolutions]
) -> Iterator[tuple[tuple[ModeSolutions, ModeSolution], ...]]:
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


def _answers(one: ContactProblem) -> ModeSolutions:
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
