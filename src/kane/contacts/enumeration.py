# SPDX-License-Identifier: BSD-3-Clause
"""All consistent modes of few contacts with one coefficient of friction each, and so how many there are: one, none or several.

Modes with equal accelerations are one solution, as on a boundary between two.
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
"""Contacts that may begin to slip, in the plane and in space, up to which modes are enumerated: the directions of three in space are
no zeros of one polynomial."""
_MODES = 256
"""Modes up to which they are."""
_SAME = 1e3
"""Errors up to which accelerations are the same."""


class ModeSolutions(NamedTuple):
    """Solutions with different accelerations, and whether these are all."""

    solutions: tuple[ModeSolution, ...]
    complete: bool


def few(problem: ContactProblem) -> bool:
    """Whether contacts are few enough to enumerate their modes: up to four in the plane, two in space besides those that slip."""
    slide, free, plane = int(problem.slides.sum()), int((~problem.slides).sum()), problem.dimension == 2
    return free <= _BEGIN[problem.dimension] and 2**slide * (4 if plane else 3) ** free <= _MODES


def enumerated(problem: ContactProblem) -> ModeSolutions:
    """Every solution of a problem with one coefficient a contact (`with_friction`); an ArgumentError where there are too many."""
    that(few(problem), "few contacts to count modes of", problem.count, "Take `choose`.", error=ArgumentError)
    found, complete = list[ModeSolution](), True
    for modes, directions in _modes(problem):
        solution = solve(problem, modes, directions)
        complete = complete and (solution.certain or solution.consistent)
        if solution.consistent and not any(same(solution, other) for other in found):
            found.append(canonical(problem, solution, least=True))
    return ModeSolutions(tuple(found), complete)


def same(a: ModeSolution, b: ModeSolution) -> bool:
    """Whether the accelerations are equal but for rounding."""
    error = _SAME * (a.acceleration_errors + b.acceleration_errors)
    return bool((np.abs(a.accelerations - b.accelerations) <= error).all())


def canonical(problem: ContactProblem, solution: ModeSolution, least: bool = False) -> ModeSolution:
    """The same accelerations in the mode that they show, with the least forces where these are not determined (`least`: they are).

    Where accelerations depend on these, because redundant contacts slip, theirs are taken if they are consistent.
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
    """Modes of all contacts, with directions of slip."""
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
    """Directions that fresh slip in space may have in a mode, the forces of other contacts eliminated."""
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
