# SPDX-License-Identifier: BSD-3-Clause
"""`derive`: from a declared system to its equations of motion."""

import copyreg
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from kane import expect
from kane.dynamics.constraints.configurations import place
from kane.dynamics.constraints.embed import first_partition
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, derived
from kane.dynamics.formulation.table import ASKED, solved
from kane.dynamics.poles import watched_events, without_poles
from kane.dynamics.readings.potential import check_potentials
from kane.dynamics.solved import Solved
from kane.equations.equations import Equations
from kane.errors import ModelError, none_of
from kane.expr.visit import remembering
from kane.model.system import System
from kane.progress import collecting_seldom, working


def derive(
    system: System, *, near: Mapping[Any, Any] | Sequence[float] | None = None, route: str | None = None
) -> Equations:
    """Equations of motion of `system` by Kane's method, by the route that takes the fewest operations.

    M u̇ = f + G R for the generalized speeds and M_a u̇ = f_a + G_a R for the auxiliary ones (Kane & Levinson 1985, ch. 4 to 6),
    solved together for u̇ and the reactions R. Constraints A u + b = 0 are embedded: the independent speeds are solved for, the
    dependent ones follow. Which these are, and which constraints follow from others, is decided by numbers at configurations that
    satisfy the constraints, several on every branch that is found, parameters at their defaults.

    Parameters
    ----------
    system : System
    near : coordinates, by symbol or name, where the motion is, if the mechanism has other branches, and values of parameters, inputs
        and t that its constraints depend on: only configurations around the nearest one then decide
    route : "classical" (M assembled and factored) or, of trees, "recursive" (articulated inertias, in a number of operations that
        grows as they do) or "composite" (composite inertias, shorter along short branches); by default the one with the fewest
        operations: `eom.route` says which, `eom.routes` the operations of those that were compared

    Raises
    ------
    SpeedsError
        if the generalized speeds do not determine the rates
    ReactionError
        if a reaction enters nonlinearly, or its direction is free already
    ModelError
        if a speed moves no mass, or a constraint is not affine in the rates or holds nothing, or cannot be satisfied `near` the place;
        or the system is none that the `route` expresses
    ValueMissingError
        if `near` names something else
    """
    cure = "Gather bodies and speeds in kn.System(…)."
    expect.instance(system, System, "a System to derive equations of", cure)
    if route is not None and route not in ASKED:
        raise ModelError(f"Expected route= None for the shortest or one of {none_of(ASKED, route)}")
    with working("Deriving"), collecting_seldom(), remembering():
        parts = derived(system, place(system, near))
        held = parts.constraints.constraints
        partition = (
            first_partition(system, parts.constraints, parts.compared, lambda: parts.mass_matrix) if held else None
        )
        check_potentials(parts)
        if route is not None:
            return _equations(replace(solved(parts, partition, route), asked=route))
        return _equations(_solved(parts, partition, without_poles(parts, partition)))


def repartition(eom: Equations, partition: Partition) -> Equations:
    """The same equations with other dependent speeds, as if these had been named: free of false poles of W where they make them so."""
    asked = eom.solved.asked
    if asked is not None:
        return _equations(replace(solved(eom.derived, partition, asked), asked=asked))
    return _equations(_solved(eom.derived, partition, without_poles(eom.derived, partition, fixed=True)))


def _solved(parts: Derived, partition: Partition | None, regular: Partition | None) -> Solved:
    """By the shortest route, or, with dependent speeds with which they are `regular` at false poles, by the one without these."""
    return solved(parts, partition) if regular is None else solved(parts, regular, "constraint speeds")


def _reduced(solution: Solved) -> tuple[Any, ...]:
    """Pickled are the system, and which speeds are dependent: what follows from them is derived again."""
    partition = None if solution.embedding is None else solution.embedding.partition
    return _restored, (solution.derived.system, solution.derived.near, partition, solution.asked)


def _restored(system: System, near: Mapping[Any, Any] | None, partition: Partition | None, route: str | None) -> Solved:
    eom = derive(system, near=near, route=route)
    again = partition is None or (eom.embedding is not None and eom.embedding.partition == partition)
    return (eom if again or partition is None else repartition(eom, partition)).solved


copyreg.pickle(Solved, _reduced)
copyreg.pickle(Equations, lambda eom: (_equations, (eom.solved,)))


def _equations(solution: Solved) -> Equations:
    return Equations(solution, watched_events(solution))
