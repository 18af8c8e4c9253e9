# SPDX-License-Identifier: BSD-3-Clause
"""The chapters of a report on steady motions, according to the given results."""

from collections.abc import Iterator
from typing import Any

from kane.analysis.linear import Linear
from kane.analysis.solution_branches import Branch
from kane.equations.equations import Equations
from kane.equations.state import State
from kane.errors import ArgumentError, cut
from kane.present.linearized.chapter import Section
from kane.present.linearized.eigenvalues import eigenvalues
from kane.present.linearized.linearization_point import operating_point, state_space


def check_small_motions(eom: Equations, linearization: Any, root_locus: Any) -> None:
    """Raise ArgumentError for arguments that are not a linearization, or a branch, of these equations."""
    _of(eom, linearization, Linear, "linearization= as kn.linearize(eom, …) returns it", lambda x: [x.point])
    _of(eom, root_locus, Branch, "root_locus= as kn.analysis.continuation(eom, …) returns it", lambda x: x.points)


def _of(eom: Equations, given: Any, kind: type, expected: str, points: Any) -> None:
    if given is None:
        return
    if not isinstance(given, kind):
        raise ArgumentError(f"Expected {expected}, got {cut(repr(given))}.")
    if not all(_belongs(eom, point) for point in points(given)):
        raise ArgumentError(f"Expected {expected} for the equations reported, got one of others.")


def _belongs(eom: Equations, point: State) -> bool:
    groups: tuple[Any, ...] = (point.q, point.u, point.states, point.inputs, point.parameters)
    return {*eom.state, *eom.inputs, *eom.parameters} == {s for group in groups for s in group or ()}


def sections(eom: Equations, linearization: Linear | None, root_locus: Branch | None) -> Iterator[Section]:
    """The chapters, in order."""
    if linearization is not None:
        yield from (made(eom, linearization) for made in (operating_point, state_space, eigenvalues))
    if root_locus is not None:
        from kane.present.linearized.root_loci import root_loci

        yield root_loci(root_locus)
