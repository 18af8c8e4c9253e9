# SPDX-License-Identifier: BSD-3-Clause
"""`Derived`: motions, generalized forces, M, f, G and constraint rows of a system, before u̇ is solved for, with model checks."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from kane.dynamics import forcing
from kane.dynamics.constraints.dependence import check_determinate, steady_speeds
from kane.dynamics.constraints.manifold import Manifold, manifold, numbers_near
from kane.dynamics.constraints.partition import Compared, Partition, chosen, compared
from kane.dynamics.forcing import Blocks, Inertias, Moving, blocks, homes, inertias_of, mass_rows, moving_parts
from kane.dynamics.lazy import LazyMapping, read
from kane.errors import ModelError, NotAffineError, ReactionError, cut
from kane.expect import Words, said
from kane.expr.build import add, sub, sum_of
from kane.expr.differentiation import Affine, affine_forms, time_derivative
from kane.expr.evaluation import Prices, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr, Exprs, constant_value
from kane.expr.ops import Immutable
from kane.expr.symbols import AuxiliarySpeed, Reaction, Speed, StateVariable, Symbol, Symbols
from kane.kinematics.aligned import AS_DECLARED, Aligned, aligned_bases
from kane.kinematics.definitions import generalized_speeds
from kane.kinematics.speeds import Sample, Speeds
from kane.kinematics.velocities import ContactPoint, Kinematics, Motion, acceleration_form, cuts_of, velocity_form
from kane.kinematics.velocity_constraints import ConstraintRows, constraint_rows
from kane.model.bodies import Body
from kane.model.constraints import Constraint, Cut, constraint_of, cut_of
from kane.model.loads import Load
from kane.model.system import System, gravity_load
from kane.numeric.arrays import Array
from kane.numeric.rank import null_direction
from kane.numeric.sampling import SEED, SEEDS, sample
from kane.numeric.scale import SOLVE_RANK, TAKES_PART, vanish
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


def check_mass(system: System, speeds: Sequence[Expr], mass: Matrix) -> None:
    """Raises a ModelError if a speed, or a combination of speeds, moves no mass, so that M is singular."""
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
    """Speeds with their definitions, as text for messages."""
    return ", ".join(f"{u} = {cut(system.speeds[u], 80)}" for u in speeds if isinstance(u, Speed))


def check_reactions_independent(system: System, reactions: Sequence[Expr], matrix: Matrix) -> None:
    """Raises a ReactionError if the matrix that the reactions are solved from is singular at all sampled configurations."""
    free = _null_vector(matrix, system)
    if free is not None:
        culprits = ", ".join(str(r) for r, c in zip(reactions, free, strict=True) if abs(c) > TAKES_PART)
        raise ReactionError(
            f"Expected linearly independent reactions, got {culprits}, which the auxiliary equations do not determine. Bring into "
            "evidence at most three independent directions at one cut."
        )


_SPREADS = (0.0, *(10.0**k for k in (-3, -6, -9, -12, 3, 6, 9, 12)))
"""Lengths (m) at which A is looked at where it is singular at those of about 1 m."""


def _null_vector(matrix: Matrix, system: System) -> Array | None:
    """A scaled x with A x = 0 at a random point; None if A is regular at one of several points.

    Random lengths are about 1 m, which may be far from the sizes in the model: such deflections would coil a beam of 1e-4 m, and the
    mass at its tip would dominate M. So if A is singular, smaller, larger and zero lengths are tried.
    """
    sets = [s.coordinates for s in system.euler_parameters]

    def numbers(seed: int, spread: float = 1.0) -> Array:
        return np.array(sample(matrix.entries, seed, sets, spread)).reshape(matrix.shape)

    found = None
    for seed in SEEDS:
        found = null_direction(numbers(seed), SOLVE_RANK) if matrix.rows else None
        if found is None:
            return None
    others = (numbers(SEED, spread) for spread in _SPREADS)
    regular = any(np.all(np.isfinite(a)) and null_direction(a, SOLVE_RANK) is None for a in others)
    return None if regular else found


def check_placed(who: Words, constraints: Iterable[Constraint], last: str) -> None:
    """Raises a ReactionError, worded by `who` and `last`, if the points of application of a constraint's forces are unknown."""
    bare = [c.name for c in constraints if not c.placed]
    if bare:
        raise ReactionError(
            f"Expected constraints with known points of application of their forces, which the {said(who)}, got the plain "
            f"{'expression' if len(bare) == 1 else 'expressions'} {', '.join(bare)}. Declare them by points or frames: kn.coincident, "
            f"kn.distance, kn.perpendicular, kn.no_slip, {last} Their multipliers alone are in eom.multipliers."
        )


def check_reaction_places(system: System, kinematics: Kinematics) -> None:
    """Raises a ReactionError if loads are not linear in reactions, or if the far side moves freely along a reaction."""
    _check_loads_linear(system)
    defaults = {p: float(p.default) for p in system.parameters if p.default is not None}
    for symbol in (*system.reactions, *system.auxiliary_speeds):
        cut = cut_of(symbol)
        if cut is None:
            continue
        free = _free_rate(cut, kinematics)
        if free is not ZERO and not all(vanish([free], known=defaults)):
            raise ReactionError(
                f"Expected the reaction {symbol} along a direction in which the far side of the cut is constrained, got {cut.along} "
                f"at {cut.at.name}, along which it moves freely with {free}. Choose a direction perpendicular to that motion."
            )


def _check_loads_linear(system: System) -> None:
    """Raises a ReactionError unless loads are linear in reactions, as friction is; R is then solved for together with u̇."""
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
    """The velocity of the far side relative to the near side along the reaction, without prescribed motion."""
    if isinstance(cut.at, Frame):
        relative = cut.at.angular_velocity(cut.at.parent) if cut.at.parent is not None else Vector()
    else:
        relative = cut.at.offset.map(time_derivative)
    (form,) = kinematics.speeds.forms([relative.dot(cut.along)])
    return sub(form.total(), form.rest) if form.coefficients else ZERO


K = TypeVar("K")
V = TypeVar("V")
Pairs = dict[tuple[Expr, Expr], Expr]
OfFrames = Mapping[Frame, Vector]
OfPoints = Mapping[Point, Vector]


@dataclass(frozen=True, eq=False, repr=False)
class Derived(Immutable):
    """The equations of a system before u̇ is solved for: motions, terms of the generalized forces, constraint rows, M, f and G.

    They do not depend on the formulation or on the choice of dependent speeds. `pairs` holds n_a·n_b for the auxiliary speed a and
    the reaction b of one cut; `near` gives values near which constraints are to be closed. M, f and G are assembled when first read.
    """

    system: System
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    pairs: Pairs
    kinematical: Speeds
    kinematics: Kinematics
    inertias: Inertias
    constraints: ConstraintRows
    near: Mapping[Symbol, float] | None = None

    speeds = read[Symbols[Speed]](lambda d: d.kinematical.speeds, "The generalized speeds u.")
    reactions = read[tuple[Reaction, ...]](lambda d: d.system.reactions, "Reactions brought into evidence.")
    all_speeds = read[Symbols[Symbol]](
        lambda d: Symbols((*d.speeds, *d.auxiliary_speeds)),
        "Generalized speeds, then auxiliary ones: the rows of Fr and Fr_star.",
    )

    @read
    def as_declared(self) -> "Derived":
        """The same system written along the declared frames, for reading; solutions are written along aligned bases."""
        if not self.kinematics.aligned.places:
            return self
        kinematics, inertias = _motions(self.system, self.kinematical, self.auxiliary_speeds, AS_DECLARED)
        return replace(self, kinematics=kinematics, inertias=inertias)

    bodies = read[tuple[Moving, ...]](
        lambda d: moving_parts(d.inertias, d.kinematics), "The parts of the bodies with their motions."
    )

    # Steps 3 and 4: kinematics -------------------------------------------------------------------------------------------

    rates = read[Exprs](lambda d: d.kinematical.coordinate_rates(), "q̇ = W u + X.")
    matrices = read[tuple[Matrix, Exprs, Matrix, Exprs]](lambda d: d.kinematical.matrices(), "Y, z, W, X.")
    Y = read[Matrix](lambda d: d.matrices[0], "Y of u = Y q̇ + z.")
    z = read[Exprs](lambda d: d.matrices[1], "z of u = Y q̇ + z.")
    W = read[Matrix](lambda d: d.matrices[2], "W = Y⁻¹ of q̇ = W u + X.")
    X = read[Exprs](lambda d: d.matrices[3], "X of q̇ = W u + X.")
    angular_velocities = read[OfFrames](
        lambda d: d._turns(velocity_form), "Angular velocity ω of each frame in the inertial frame, in speeds."
    )
    velocities = read[OfPoints](lambda d: d._shifts(velocity_form), "Velocity v of each point, in speeds.")
    angular_accelerations = read[OfFrames](
        lambda d: d._turns(acceleration_form), "Angular acceleration α of each frame, in u and u̇."
    )
    point_accelerations = read[OfPoints](
        lambda d: d._shifts(acceleration_form), "Acceleration a of each point, in u and u̇."
    )
    partial_angular_velocities = read[Mapping[Frame, Mapping[Expr, Vector]]](
        lambda d: d._turns(d._partials),
        "Partial angular velocities ω_r of each frame for each speed and auxiliary speed.",
    )
    partial_velocities = read[Mapping[Point, Mapping[Expr, Vector]]](
        lambda d: d._shifts(d._partials), "Partial velocities v_r of each point for each speed and auxiliary speed."
    )

    def _turns(self, reading: Callable[[Motion], V]) -> Mapping[Frame, V]:
        return LazyMapping(self.system.frames, lambda frame: reading(self.kinematics.frame(frame)))

    def _shifts(self, reading: Callable[[Motion], V]) -> Mapping[Point, V]:
        return LazyMapping(self.system.points, lambda point: reading(self.kinematics.point(point)))

    def _partials(self, motion: Motion) -> Mapping[Expr, Vector]:
        return LazyMapping(self.all_speeds, lambda s: motion.partials.get(s, Vector()))

    # Steps 5 and 6: generalized forces -----------------------------------------------------------------------------------

    declared_loads = read[tuple[Load, ...]](
        lambda d: forcing.loads_in_speeds(d.system.loads, d.kinematical), "The loads but for gravity, in speeds."
    )

    @read
    def loads(self) -> tuple[Load, ...]:
        """The loads, written in speeds, with gravity as one force for each body."""
        weights = [gravity_load(g, self.system.bodies) for g in self.system.gravities]
        return (*forcing.loads_in_speeds(weights, self.kinematical), *self.declared_loads)

    @read
    def active_terms(self) -> Mapping[Load, tuple[forcing.LoadTerm, ...]]:
        """The forces and torques of each load."""
        return LazyMapping(self.loads, lambda load: forcing.active_terms(load, self.kinematics))

    @read
    def inertia_terms(self) -> Mapping[Body, tuple[forcing.LoadTerm, ...]]:
        """The inertia force and torque of each body, in u̇."""
        return LazyMapping(
            self.system.bodies,
            lambda body: tuple(term for b in self.bodies if b.body is body for term in forcing.inertia_terms(b)),
        )

    Fr_contributions = read[Mapping[tuple[Expr, Load], Expr]](
        lambda d: d._by_speed(d.active_terms, dict(zip((*d.system.gravities, *d.system.loads), d.loads, strict=True))),
        "Contributions of loads to F_r, by speed and load.",
    )
    Fr_star_contributions = read[Mapping[tuple[Expr, Body], Expr]](
        lambda d: d._by_speed(d.inertia_terms, {}), "Contributions of bodies to F*_r, by speed and body."
    )

    def _by_speed(
        self, table: Mapping[K, tuple[forcing.LoadTerm, ...]], stands_for: Mapping[Any, K]
    ) -> Mapping[tuple[Expr, K], Expr]:
        return LazyMapping(
            product(self.all_speeds, table), lambda key: forcing.generalized(table[key[1]], key[0]), stands_for
        )

    @read
    def Fr(self) -> Exprs:
        """Generalized active forces F_r of all speeds, then of the auxiliary speeds; the latter contain the reactions."""
        evident = (
            sum_of(self.pairs[s, r] * r for r in self.reactions if (s, r) in self.pairs) for s in self.all_speeds
        )
        return tuple(map(add, self._sums(self.Fr_contributions, self.loads), evident))

    @read
    def Fr_star(self) -> Exprs:
        """Generalized inertia forces F*_r of all speeds, then of the auxiliary speeds, in u̇."""
        return self._sums(self.Fr_star_contributions, self.system.bodies)

    def _sums(self, shares: Mapping[tuple[Expr, K], Expr], sources: Sequence[K]) -> Exprs:
        return tuple(sum_of(shares[s, source] for source in sources) for s in self.all_speeds)

    # Further states ------------------------------------------------------------------------------------------------------

    states = read[tuple[StateVariable, ...]](lambda d: Symbols(d.system.states), "The states a beside q and u.")
    state_rates = read[Exprs](
        lambda d: d._in_speeds(d.system.states.values()), "Rates ȧ of these states, with q̇ written in speeds."
    )
    state = read[tuple[Symbol, ...]](
        lambda d: Symbols((*d.system.coordinates, *d.speeds, *d.states)),
        "The whole state x = (q, u, a), in this order.",
    )

    def _in_speeds(self, exprs: Iterable[Expr]) -> Exprs:
        forms: dict[Expr, Affine] = {}
        return tuple(self.kinematical.in_speeds(e, forms) for e in exprs)

    # Step 7: dynamical equations -----------------------------------------------------------------------------------------

    left = read[tuple[forcing.LoadTerm, ...]](
        lambda d: d.left_by(d.kinematics, d.bodies), "Forces and torques, those of inertia too, at u̇ = 0."
    )

    def left_by(
        self, kinematics: Kinematics, bodies: Sequence[Moving], u_dot: Mapping[Expr, Expr] = MappingProxyType({})
    ) -> tuple[forcing.LoadTerm, ...]:
        """The terms of `left` with other motions, or at other accelerations."""
        return tuple(forcing.bias_terms(self._active(kinematics), bodies, free_fall(self.system), u_dot))

    def _active(self, kinematics: Kinematics) -> list[forcing.LoadTerm]:
        return [term for load in self.declared_loads for term in forcing.active_terms(load, kinematics)]

    @read
    def blocks(self) -> Blocks:
        """The matrices M, f and G of the equations of speeds and of auxiliary speeds."""
        mass = mass_rows(self.bodies, self.speeds, self.auxiliary_speeds)
        right = [forcing.generalized_by_motion(self.left, s) for s in self.all_speeds]
        apart = self._with_weights_apart()
        if apart is not None:
            cost = Prices([x for row in mass for x in row])
            right = min(right, apart, key=cost)
        return blocks(mass, right, self.auxiliary_speeds, self.reactions, self.pairs)

    def _with_weights_apart(self) -> list[Expr] | None:
        """f with weights along their own direction if a speed moves nothing up or down, as they would have to cancel; else None."""
        fall = free_fall(self.system)
        if fall.is_zero:
            return None
        weights = [forcing.LoadTerm(m.part.mass_center, fall * m.part.mass, m.center) for m in self.bodies]
        heavy = [forcing.generalized_by_motion(weights, s) for s in self.all_speeds]
        if all(x is not ZERO for x in heavy):
            return None
        rest = forcing.bias_terms(self._active(self.kinematics), self.bodies, Vector())
        return [add(forcing.generalized_by_motion(rest, s), x) for s, x in zip(self.all_speeds, heavy, strict=True)]

    mass_matrix = read[Matrix](lambda d: d.blocks.mass, "The mass matrix M (n × n) of all n speeds.")
    auxiliary_mass_matrix = read[Matrix](
        lambda d: d.blocks.mass_a, "M_a (auxiliary speeds × n) of M_a u̇ = f_a + G_a R."
    )

    @read
    def forcing(self) -> Exprs:
        """f (n) of M u̇ = f + Aᵀ λ, which contains the reactions in loads, and no constraint forces."""
        return tuple(map(add, self.blocks.forcing, self.blocks.coupling @ self.reactions))

    @read
    def auxiliary_forcing(self) -> Exprs:
        """f_a + G_a R of the equations of auxiliary speeds, M_a u̇ = f_a + G_a R."""
        return tuple(map(add, self.blocks.forcing_a, self.blocks.coupling_a @ self.reactions))

    A = read[Matrix](
        lambda d: d.constraints.a, "A of the constraints A u + b = 0, with a row for each of `system.constraints`."
    )
    b = read[Exprs](lambda d: d.constraints.b, "b of the constraints A u + b = 0.")
    conditions = read[Manifold](lambda d: manifold(d.system), "The configuration constraints, with their derivatives.")
    compared = read[Compared](
        lambda d: compared(d.system, d.constraints, d.near, d.conditions),
        "Configurations at which constraints are compared.",
    )
    constraint_rates = read[Exprs](lambda d: tuple(map(add, d.A @ d.speeds, d.b)), "A u + b.")


def free_fall(system: System) -> Vector:
    """The acceleration of free fall."""
    return sum((g.acceleration for g in system.gravities), start=Vector())


def derived(system: System, near: Mapping[Any, Any] | Sequence[float] | None = None) -> Derived:
    """The speeds, motions of bodies and constraint rows of a system; `kane.derive` lists the errors."""
    place = None if near is None else numbers_near(system, near)
    speeds = generalized_speeds(system)
    auxiliary, pairs = _auxiliary_speeds(system)
    kinematics, inertias = _motions(system, speeds, auxiliary, aligned_bases(system.frames))
    check_reaction_places(system, kinematics)
    rows = constraint_rows(system.constraints, kinematics, auxiliary)
    cuts = [r for r in (*system.reactions, *system.auxiliary_speeds) if cut_of(r) is not None]
    if cuts:
        check_placed(lambda: f"reactions {', '.join(map(str, cuts))} contain", rows.constraints, "kn.rolling.")
    return Derived(system, auxiliary, pairs, speeds, kinematics, inertias, rows, place)


def first_partition(parts: Derived) -> Partition | None:
    """The dependent speeds chosen at configurations on the constraints, parameters at their defaults; None without constraints.

    `dependent_speeds` of the user are preferred, then speeds that are determined at all configurations, of several such sets the one
    with the shortest equations. ModelError if constraints do not determine `dependent_speeds` or contradict each other, ReactionError
    if a reaction is not determined.
    """
    system, rows = parts.system, parts.constraints
    if not rows.constraints:
        return None
    found = parts.compared
    place = {u: i for i, u in enumerate(system.speeds)}
    easy = np.array([constant_value(x) is not None for x in rows.a.entries]).reshape(rows.a.shape)
    preferred = [place[u] for u in system.dependent_speeds]
    partition = chosen(found.a, found.at.special, preferred, easy)
    if not set(preferred) >= set(partition.dependent):
        steady = steady_speeds(found, rows.a, partition.dependent, preferred, lambda: parts.mass_matrix)
        if steady is not None and set(steady) != set(partition.dependent):
            partition = chosen(found.a, found.at.special, steady, easy)
    strangers = [str(u) for u in system.dependent_speeds if place[u] not in partition.dependent]
    if strangers:
        names = ", ".join(u.name for u, i in place.items() if i in partition.dependent)
        raise ModelError(
            f"Expected dependent_speeds= that the constraints determine, got {', '.join(strangers)}, which they do not determine "
            f"together with the others listed. Leave them out to have them chosen, or name others: {names} will do."
        )
    check_determinate(system, rows, found, partition.redundant)
    return partition


def by_other_speeds(
    d: Derived,
    definitions: Mapping[Speed, Expr],
    rows: ConstraintRows,
    contacts: Mapping[Point, ContactPoint] = MappingProxyType({}),
    *,
    matched: bool = True,
) -> Derived:
    """The same system in other speeds: `rows` are its constraints in them, `contacts` points with velocities from contact points.

    If the speeds are sums of rates, velocities need not be `matched` to their definitions.
    """
    system = d.system.redefined(definitions)
    speeds, usual = generalized_speeds(system), d.kinematics
    if not matched:
        speeds = replace(speeds, nontrivial=False)
    kinematics = Kinematics(speeds, usual.cuts, usual.sample.by(speeds), usual.homes, usual.aligned, contacts)
    return replace(d, system=system, kinematical=speeds, kinematics=kinematics, constraints=rows)


def _auxiliary_speeds(system: System) -> tuple[tuple[AuxiliarySpeed, ...], Pairs]:
    """One auxiliary speed per reaction, and the coefficients n_a·n_b of reactions b in their equations a, at one cut."""
    explicit = iter(system.auxiliary_speeds)
    speeds: list[AuxiliarySpeed] = []
    for r in system.reactions:
        place = cut_of(r) or constraint_of(r)
        if place is None:
            speeds.append(next(explicit))
        else:
            speeds.append(AuxiliarySpeed.declare(f"u_{r.name}", None, "", f"auxiliary speed of {r.name}", place))
    pairs: Pairs = {}
    for a in speeds:
        for r in system.reactions:
            here, there = cut_of(a), cut_of(r)
            if constraint_of(a) is not None and constraint_of(a) is constraint_of(r):
                pairs[a, r] = ONE
            if isinstance(here, Cut) and isinstance(there, Cut) and here.at is there.at:
                pairs[a, r] = here.along.dot(there.along)
    return Symbols(speeds), pairs


def _motions(
    system: System, speeds: Speeds, auxiliary: Iterable[AuxiliarySpeed], aligned: Aligned
) -> tuple[Kinematics, Inertias]:
    inertias = inertias_of(system.bodies, aligned)
    kinematics = Kinematics(speeds, cuts_of(auxiliary), Sample(speeds), homes(inertias, aligned), aligned)
    return kinematics, inertias
