# SPDX-License-Identifier: BSD-3-Clause
"""What is derived of a system before anything is solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from kane.dynamics.auxiliary import Pairs, auxiliary_speeds
from kane.dynamics.blocks import Blocks, blocks, mass_rows
from kane.dynamics.bodies import Moving, homes, moving_bodies
from kane.dynamics.checks import check_reaction_places, check_released
from kane.dynamics.lazy_mapping import LazyMapping
from kane.dynamics.loads import loads_in_speeds
from kane.dynamics.terms import (
    Term,
    active_terms,
    bias_terms,
    generalized,
    generalized_by_motion,
    inertia_terms,
    sum_of,
)
from kane.expr.build import add
from kane.expr.matrix import Matrix, dot
from kane.expr.node import Expr
from kane.expr.symbols import AuxiliarySpeed, Reaction, Speed, Symbol
from kane.kinematics.constraints import ConstraintRows, constraint_rows
from kane.kinematics.definitions import generalized_speeds
from kane.kinematics.motion import Kinematics, cuts_of
from kane.kinematics.sample import Sample
from kane.kinematics.speeds import Speeds
from kane.model.bodies import Body
from kane.model.loads import Load
from kane.model.system import System, gravity_load
from kane.space.vector import Vector


@dataclass(frozen=True, eq=False, repr=False)
class Derived:
    """What no route to u̇, and no choice of dependent speeds, changes: motions, terms of the generalized forces, constraint rows.

    `pairs` holds n_a·n_b for the auxiliary speed a and the reaction b of one cut. M, f and G are assembled when they are first read.
    """

    system: System
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    pairs: Pairs
    kinematical: Speeds
    kinematics: Kinematics
    bodies: tuple[Moving, ...]
    constraints: ConstraintRows

    @property
    def speeds(self) -> tuple[Speed, ...]:
        """u."""
        return self.kinematical.speeds

    @property
    def reactions(self) -> tuple[Reaction, ...]:
        """R."""
        return self.system.reactions

    @property
    def all_speeds(self) -> tuple[Symbol, ...]:
        """Generalized speeds, then auxiliary ones: the rows of F_r and F*_r."""
        return (*self.speeds, *self.auxiliary_speeds)

    @cached_property
    def rates(self) -> tuple[Expr, ...]:
        """q̇ = W u + X."""
        return self.kinematical.coordinate_rates()

    @cached_property
    def matrices(self) -> tuple[Matrix, tuple[Expr, ...], Matrix, tuple[Expr, ...]]:
        """Y, z, W, X."""
        return self.kinematical.matrices()

    # Generalized forces --------------------------------------------------------------------------------------------------

    @cached_property
    def declared_loads(self) -> tuple[Load, ...]:
        """The loads but for gravity, in speeds."""
        return loads_in_speeds(self.system.loads, self.kinematical)

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """The loads in speeds, gravity written out as one force a body."""
        weights = [gravity_load(g, self.system.bodies) for g in self.system.gravities]
        return (*loads_in_speeds(weights, self.kinematical), *self.declared_loads)

    @cached_property
    def active_terms(self) -> Mapping[Load, tuple[Term, ...]]:
        """The forces and torques of each load."""
        return LazyMapping(self.loads, lambda load: active_terms(load, self.kinematics))

    @cached_property
    def inertia_terms(self) -> Mapping[Body, tuple[Term, ...]]:
        """The inertia force and torque of each body, in u̇."""
        moving = {b.body: b for b in self.bodies}
        return LazyMapping(moving, lambda body: inertia_terms(moving[body]))

    @cached_property
    def active_forces(self) -> Mapping[tuple[Expr, Load], Expr]:
        """What each load contributes to each F_r."""
        keys = [(s, load) for s in self.all_speeds for load in self.loads]
        return LazyMapping(keys, lambda key: generalized(self.active_terms[key[1]], key[0]))

    @cached_property
    def inertia_forces(self) -> Mapping[tuple[Expr, Body], Expr]:
        """What each body contributes to each F*_r."""
        keys = [(s, b.body) for s in self.all_speeds for b in self.bodies]
        return LazyMapping(keys, lambda key: generalized(self.inertia_terms[key[1]], key[0]))

    @cached_property
    def Fr(self) -> tuple[Expr, ...]:
        """F_r of all speeds; those of the auxiliary ones hold the reactions that they bring into evidence."""
        return tuple(
            add(
                sum_of(self.active_forces[s, load] for load in self.loads),
                sum_of(self.pairs[s, r] * r for r in self.reactions if (s, r) in self.pairs),
            )
            for s in self.all_speeds
        )

    @cached_property
    def Fr_star(self) -> tuple[Expr, ...]:
        """F*_r of all speeds, in u̇."""
        return tuple(sum_of(self.inertia_forces[s, b.body] for b in self.bodies) for s in self.all_speeds)

    # Dynamical equations -------------------------------------------------------------------------------------------------

    @cached_property
    def blocks(self) -> Blocks:
        """M, f, G and M_a, f_a, G_a."""
        mass = mass_rows(self.bodies, self.speeds, self.auxiliary_speeds)
        loads = [term for load in self.declared_loads for term in active_terms(load, self.kinematics)]
        fall = sum((g.acceleration for g in self.system.gravities), start=Vector())
        terms = bias_terms(loads, self.bodies, fall)
        right = [generalized_by_motion(terms, s) for s in self.all_speeds]
        return blocks(mass, right, self.auxiliary_speeds, self.reactions, self.pairs)

    @cached_property
    def forcing(self) -> tuple[Expr, ...]:
        """f (n), with the reactions that loads hold."""
        return self._with_reactions(self.blocks.forcing, self.blocks.coupling)

    @cached_property
    def auxiliary_forcing(self) -> tuple[Expr, ...]:
        """f_a (auxiliary speeds), with the reactions."""
        return self._with_reactions(self.blocks.forcing_a, self.blocks.coupling_a)

    def _with_reactions(self, plain: Sequence[Expr], coupling: Matrix) -> tuple[Expr, ...]:
        return tuple(add(f, dot(row, self.reactions)) for f, row in zip(plain, coupling, strict=True))


def derived(system: System) -> Derived:
    """Speeds, motions of bodies and rows of constraints of a system.

    Raises
    ------
    SpeedsError
        if the generalized speeds do not determine the rates
    ReactionError
        if a reaction enters nonlinearly, or its direction is free already
    ModelError
        if a constraint is not affine in the rates or holds nothing
    """
    speeds = generalized_speeds(system)
    auxiliary, pairs = auxiliary_speeds(system)
    home, inertias = homes(system)
    kinematics = Kinematics(speeds, cuts_of(auxiliary), Sample(speeds), home)
    check_reaction_places(system, kinematics)
    bodies = moving_bodies(system, kinematics, inertias)
    rows = constraint_rows(system, kinematics, auxiliary)
    check_released(system, rows)
    return Derived(system, auxiliary, pairs, speeds, kinematics, bodies, rows)
