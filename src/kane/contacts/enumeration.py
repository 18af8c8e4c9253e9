# SPDX-License-Identifier: BSD-3-Clause
"""Enumeration of all consistent modes of few contacts, with one coefficient of friction per contact.

Modes with equal accelerations count as one solution, such as two modes on their common boundary.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from kane.contacts.angles import one_direction, two_directions
from kane.contacts.mode_solution import ModeSolution, equations, labelled, linear, solve
from kane.contacts.problem import ContactProblem, ContactStatus
from kane.errors import ArgumentError
from kane.expect import that
from kane.numeric.arrays import Array

_BEGIN = {2: 4, 3: 2}
"""Largest number of contacts that may begin to slip, in the plane and in space: the directions of three contacts in space are not the
zeros of a polynomial in one variable."""
_MODES = 256
"""Largest number of modes to enumerate."""
_SAME = 1e3
"""Multiple of the error bounds up to which accelerations are equal."""


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
