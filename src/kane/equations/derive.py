# SPDX-License-Identifier: BSD-3-Clause
"""`derive`: from a declared system to its equations of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.checks import check_reaction_places, check_released
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.events import painleve_events, singular_events, slip_events
from kane.dynamics.loads import loads_in_speeds
from kane.dynamics.routes.classical import forcing_terms, generalized, homes, mass_matrix, moving_bodies
from kane.dynamics.routes.reduce import Blocks, Solved
from kane.dynamics.routes.solve import first_partition, solve
from kane.equations.equations import Equations
from kane.expr.affine import affine_forms
from kane.expr.evaluate import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Reaction
from kane.kinematics.constraints import constraint_rows
from kane.kinematics.definitions import generalized_speeds
from kane.kinematics.motion import Kinematics, cuts_of
from kane.kinematics.sample import Sample
from kane.kinematics.speeds import Speeds
from kane.model.events import Event
from kane.model.reactions import Cut, constraint_of, cut_of
from kane.model.system import System


def derive(system: System) -> Equations:
    """Equations of motion of `system` by Kane's method, classical route.

    M u̇ = f + G R for the generalized speeds and M_a u̇ = f_a + G_a R for the auxiliary ones (Kane & Levinson 1985, ch. 4 to 6),
    solved together for u̇ and the reactions R. Constraints A u + b = 0 are embedded: the independent speeds are solved for, the
    dependent ones follow.

    Raises
    ------
    SpeedsError
        if the generalized speeds do not determine the rates
    ReactionError
        if a reaction enters nonlinearly, or its direction is free already
    ModelError
        if a speed moves no mass, or a constraint is not affine in the rates or holds nothing
    """
    speeds = generalized_speeds(system)
    auxiliary, pairs = auxiliary_speeds(system)
    home, inertias = homes(system)
    kinematics = Kinematics(speeds, cuts_of(auxiliary), Sample(speeds), home)
    check_reaction_places(system, kinematics)
    bodies = moving_bodies(system, kinematics, inertias)
    loads = loads_in_speeds(system.loads, speeds)
    forces, torques = forcing_terms(system, kinematics, bodies, loads)
    u: Sequence[Expr] = speeds.speeds
    rows = [*u, *auxiliary]
    mass_rows = mass_matrix(bodies, u, auxiliary)
    right = [generalized(forces, r) + generalized(torques, r) for r in rows]
    plain, coupling = _reaction_form(right, system, rows)
    n = len(u)
    for i, s in enumerate(auxiliary):
        for j, reaction in enumerate(system.reactions):
            coupling[n + i][j] = coupling[n + i][j] + pairs.get((s, reaction), ZERO)
    blocks = Blocks(mass_rows[:n], plain[:n], coupling[:n], mass_rows[n:], plain[n:], coupling[n:])
    held = constraint_rows(system, kinematics, auxiliary)
    check_released(system, held)
    embedding, solved = solve(system, u, blocks, held, first_partition(system, u, held))
    return Equations(
        system=system,
        speeds=tuple(speeds.speeds),
        auxiliary_speeds=auxiliary,
        reactions=system.reactions,
        coordinates=system.coordinates,
        parameters=system.parameters,
        inputs=system.inputs,
        kinematical=speeds,
        kinematics=kinematics,
        bodies=bodies,
        pairs=pairs,
        rates=speeds.coordinate_rates(),
        blocks=blocks,
        constraints=held,
        embedding=embedding,
        solved=solved,
        events=_events(system, speeds, solved),
    )


def repartition(eom: Equations, partition: Partition) -> Equations:
    """The same equations with other dependent speeds."""
    rows, speeds = eom.constraints, eom.kinematical
    embedding, solved = solve(eom.system, speeds.speeds, eom.blocks, rows, partition)
    return replace(eom, embedding=embedding, solved=solved, events=_events(eom.system, speeds, solved))


def _events(system: System, speeds: Speeds, solved: Solved) -> tuple[Event, ...]:
    return (
        *painleve_events(solved),
        *slip_events(loads_in_speeds(system.loads, speeds)),
        *singular_events(speeds),
        *(_event_in_speeds(e, speeds) for e in system.events),
    )


def auxiliary_speeds(
    system: System,
) -> tuple[tuple[AuxiliarySpeed, ...], dict[tuple[Expr, Expr], Expr]]:
    """Auxiliary speeds, one a reaction, and what the action–reaction pairs put into their equations: n_a·n_b at one cut."""
    explicit = iter(system.auxiliary_speeds)
    made: list[AuxiliarySpeed] = []
    for r in system.reactions:
        cut, held = cut_of(r), constraint_of(r)
        if cut is None and held is None:
            made.append(next(explicit))
        else:
            made.append(AuxiliarySpeed.declare(f"u_{r.name}", None, "", f"auxiliary speed of {r.name}", cut or held))
    pairs: dict[tuple[Expr, Expr], Expr] = {}
    for a in made:
        for r in system.reactions:
            here, there = cut_of(a), cut_of(r)
            if constraint_of(a) is not None and constraint_of(a) is constraint_of(r):
                pairs[a, r] = ONE
            if isinstance(here, Cut) and isinstance(there, Cut) and here.at is there.at:
                pairs[a, r] = here.along.dot(there.along)
    return tuple(made), pairs


def _reaction_form(right: list[Expr], system: System, rows: Sequence[Expr]) -> tuple[list[Expr], list[list[Expr]]]:
    if not system.reactions or not any(isinstance(s, Reaction) for s in free_symbols(right)):
        return right, [[ZERO] * len(system.reactions) for _ in rows]
    forms = affine_forms(right, system.reactions)
    return [rest for _, rest in forms], [[c.get(r, ZERO) for r in system.reactions] for c, _ in forms]


def _event_in_speeds(event: Event, speeds: Speeds) -> Event:
    quantity = speeds.in_speeds(event.quantity, {})
    return Event(event.name, quantity, event.threshold, event.direction, event.terminal, event.message)
