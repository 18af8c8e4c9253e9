# SPDX-License-Identifier: BSD-3-Clause
"""Checks that need the derivation: speeds that move no mass, reactions along free directions or not independent."""

from collections.abc import Iterable, Sequence

import numpy as np

from kane.errors import ModelError, NotAffineError, ReactionError, cut
from kane.expr.build import sub
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Reaction, Speed
from kane.kinematics.velocities import Kinematics
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.constraints import Constraint, Cut, cut_of
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.rank import null_direction
from kane.numeric.sampling import SEED, SEEDS, sample
from kane.numeric.scale import SOLVE_RANK, TAKES_PART, vanish
from kane.space.frame import Frame
from kane.space.vector import Vector


def check_mass(system: System, speeds: Sequence[Expr], mass: Matrix) -> None:
    """Every speed must move some mass."""
    massless = [u for u, row in zip(speeds, mass, strict=True) if all(x is ZERO for x in row)]
    if massless:
        raise ModelError(
            f"Expected every generalized speed to move some mass, got a zero row of the mass matrix for {_defined(system, massless)}. "
            "Give the massless part a mass or inertia (a rod has none about its axis), or leave out its coordinate."
        )
    free = _null_vector(mass, system)
    if free is not None:
        culprits = [u for u, c in zip(speeds, free, strict=True) if abs(c) > TAKES_PART]
        raise ModelError(
            f"Expected every motion to move some mass, got a combination of {', '.join(map(str, culprits))} that moves none: the mass "
            f"matrix is singular at every configuration. Here {_defined(system, culprits)}. Give the massless part a mass or inertia "
            "(a rod has none about its axis), or leave out a coordinate."
        )


def _defined(system: System, speeds: Iterable[Expr]) -> str:
    """Speeds with their definitions, in which the coordinates can be read."""
    return ", ".join(f"{u} = {cut(system.speeds[u], 80)}" for u in speeds if isinstance(u, Speed))


def check_reactions_independent(system: System, reactions: Sequence[Expr], matrix: Matrix) -> None:
    """The matrix that the reactions are solved from must have an inverse at some configuration."""
    free = _null_vector(matrix, system)
    if free is not None:
        culprits = ", ".join(str(r) for r, c in zip(reactions, free, strict=True) if abs(c) > TAKES_PART)
        raise ReactionError(
            f"Expected reactions that can be told apart, got {culprits}, which the auxiliary equations do not determine. Bring into "
            "evidence at most three independent directions at one cut."
        )


def _null_vector(matrix: Matrix, system: System) -> Array | None:
    """x with A x = 0 at a random point, its entries scaled; None where A is regular at one of several, or at zero.

    Deflections of about 1 m would coil a beam of 1e-4 m, and a mass at its tip then outweighs all else.
    """
    sets = [s.coordinates for s in system.euler_parameters]

    def numbers(seed: int, spread: float = 1.0) -> Array:
        return np.array(sample(matrix.entries, seed, sets, spread)).reshape(matrix.shape)

    found = None
    for seed in SEEDS:
        found = null_direction(numbers(seed), SOLVE_RANK) if matrix.rows else None
        if found is None:
            return None
    at_zero = numbers(SEED, 0.0)
    regular = np.all(np.isfinite(at_zero)) and null_direction(at_zero, SOLVE_RANK) is None
    return None if regular else found


def check_released(system: System, rows: ConstraintRows) -> None:
    """Reactions at cuts need to know what the constraints exert on the far side."""
    cuts = [str(r) for r in (*system.reactions, *system.auxiliary_speeds) if cut_of(r) is not None]
    if cuts:
        check_placed(f"reactions {', '.join(cuts)} feel", rows.constraints, "kn.rolling.")


def check_placed(who: str, constraints: Iterable[Constraint], last: str) -> None:
    """Constraints whose forces `who` ("reactions … feel") needs must say where they act; `last` ends the list of what does."""
    bare = [c.name for c in constraints if not c.placed]
    if bare:
        raise ReactionError(
            f"Expected constraints that say where their forces act, as the {who} them, got the bare "
            f"{'expression' if len(bare) == 1 else 'expressions'} {', '.join(bare)}. Declare them by places: kn.coincident, "
            f"kn.distance, kn.perpendicular, kn.no_slip, {last}"
        )


def check_reaction_places(system: System, kinematics: Kinematics) -> None:
    """Loads are linear in reactions, and none of these is along a direction in which the far side moves freely already."""
    _check_loads_linear(system)
    defaults = {p: float(p.default) for p in system.parameters if p.default is not None}
    for symbol in (*system.reactions, *system.auxiliary_speeds):
        cut = cut_of(symbol)
        if cut is None:
            continue
        free = _free_rate(cut, kinematics)
        if free is not ZERO and not all(vanish([free], known=defaults)):
            raise ReactionError(
                f"Expected the reaction {symbol} along a direction in which the far side is held, got {cut.along} at "
                f"{cut.at.name}, along which it moves freely with {free}. Choose a direction across the motion."
            )


def _check_loads_linear(system: System) -> None:
    """A load may be proportional to reactions, as friction is, since they are solved for together with u̇."""
    for load in system.loads if system.reactions else ():
        numbers = [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]
        if not any(isinstance(s, Reaction) for s in free_symbols(numbers)):
            continue
        try:
            affine_forms(numbers, system.reactions)
        except NotAffineError as error:
            came = str(error).rpartition("got ")[2].rstrip(".")
            raise ReactionError(
                f"Expected loads linear in the reactions, so that they can be solved for together with u', got {came} in "
                f"{load.name!r}. Write it as a reaction times a factor that is free of reactions, such as -mu*N_z."
            ) from error


def _free_rate(cut: Cut, kinematics: Kinematics) -> Expr:
    """Rate of the far side relative to the near side along the reaction, prescribed motion left out."""
    if isinstance(cut.at, Frame):
        relative = cut.at.angular_velocity(cut.at.parent) if cut.at.parent is not None else Vector()
    else:
        relative = cut.at.offset.map(time_derivative)
    (form,) = kinematics.speeds.forms([relative.dot(cut.along)])
    return sub(form.total(), form.rest) if form.coefficients else ZERO
