# SPDX-License-Identifier: BSD-3-Clause
"""`Equations`, the frozen result of a derivation by the seven steps of Kane's method, and `derive`, which makes it."""

from __future__ import annotations

import copyreg
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, TypeVar, Unpack

import numpy as np
import numpy.typing as npt

from kane import expect, show
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, derived, first_partition
from kane.dynamics.forcing import Moving
from kane.dynamics.formulation.table import ASKED, solved
from kane.dynamics.lazy import LazyMapping, read
from kane.dynamics.methods.base import Formulation
from kane.dynamics.methods.table import formulation
from kane.dynamics.poles import watched_events, without_poles
from kane.dynamics.readings import energy, unsolved
from kane.dynamics.readings.contributions import (
    Contributions,
    MassContribution,
    Noncontributing,
    contributions,
    inertia_forces,
    mass_contributions,
    noncontributing,
)
from kane.dynamics.readings.energy import Impulse, KineticParts
from kane.dynamics.readings.integrals import Integral, integrals
from kane.dynamics.readings.joint_reactions import JointReaction, Place, reaction
from kane.dynamics.readings.potential import FoundPotential, check_potentials, find_potential
from kane.dynamics.readings.quantities import evaluate_along, speeds_from_rates, time_derivative, without_rates
from kane.dynamics.readings.seven_steps import Kind, Quantity, Step, seven_steps
from kane.dynamics.solved import Solved
from kane.equations.compiled import Compiled, Numeric, compiled
from kane.equations.jacobian import Jacobian, jacobian
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, ModelError, SimulationError, none_of
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, Exprs, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Input, Parameter, Rate, Speed
from kane.expr.visit import remembering
from kane.kinematics.speeds import Speeds
from kane.kinematics.velocities import Kinematics
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.bodies import Body
from kane.model.declarations import Event
from kane.model.force_systems import ForceSystem
from kane.model.loads import Load
from kane.model.system import System
from kane.model.unit_checks import unit_in
from kane.program.native.compiled_routine import NotFinite
from kane.program.native.machine import Settings
from kane.progress import collecting_seldom, working
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

V = TypeVar("V")
_SETTINGS = Settings()
Values = Mapping[Any, Any] | Sequence[Any] | npt.NDArray[Any]


def _named(kind: Kind, of: str, values: read[Exprs]) -> read[Exprs]:
    """Expressions that say what each is: the quantity of this kind of the symbols that the equations call `of`."""
    exprs = read[Exprs](
        lambda e: show.Named(values.func(e), [Quantity(kind, s) for s in getattr(e, of)]), values.__doc__
    )
    exprs.func.__annotations__["return"] = Exprs
    return exprs


@dataclass(frozen=True, eq=False, repr=False)
class Equations(Immutable):
    """Equations of motion M u̇ = f + Aᵀ λ, A u + b = 0 of a system, with everything that led to them.

    `mass_matrix` (n × n) and `forcing` (n) hold the equations as derived; `forcing` may contain reactions. `accelerations` (u̇)
    and `reaction_values` are solved for, as functions of q, u, t, parameters and inputs; `rates` gives q̇ = W u + X. With
    constraints, `u_D = A_n u_I + b_n` gives the dependent speeds, and `multipliers` the forces λ that hold them; `redundant` are those
    that follow from the others at the configurations compared, see `derive(system, near=…)`.
    """

    _other_names = MappingProxyType(
        {
            "mass_matrix": "M",
            "forcing": "f",
            "right_hand_side": "rhs",
            "multipliers": "lam",
            "accelerations": "u_dot udot u_dots qdd q_ddot",
            "coordinates": "q",
            "speeds": "u",
            "rates": "qdot q_dot",
            "state": "x",
            "generalized_momenta": "p",
            "kinetic_energy": "T K",
            "potential_energy": "V U",
            "jacobian": "jac",
            "bodies": "bodylist",
            "loads": "loadlist",
            "parameters": "params",
        }
    )

    solved: Solved
    events: tuple[Event, ...]

    derived = read[Derived](lambda e: e.solved.derived, "What no choice of dependent speeds changes.")
    _shown = read[Derived](lambda e: e.derived.as_declared, "The same along the declared frames.")
    system = read[System](lambda e: e.derived.system, "The system.")
    coordinates = read[tuple[Coordinate, ...]](lambda e: e.system.coordinates, "q.")
    parameters = read[tuple[Parameter, ...]](lambda e: e.system.parameters, "The parameters of the system.")
    inputs = read[tuple[Input | Rate, ...]](lambda e: e.system.inputs, "The inputs of the system, and their rates.")
    frames = read[tuple[Frame, ...]](lambda e: e.system.frames, "The frames of the system.")
    points = read[tuple[Point, ...]](lambda e: e.system.points, "The points of the system.")
    speeds = Derived.speeds.within("derived")
    auxiliary_speeds = read[tuple[AuxiliarySpeed, ...]](lambda e: e.derived.auxiliary_speeds, "u_a, one a reaction.")
    all_speeds = Derived.all_speeds.within("derived")
    states = Derived.states.within("derived")
    state_rates = _named(Kind.RATE, "states", read(lambda e: e.solved.state_rates, "ȧ of the further states."))
    state = Derived.state.within("derived")
    reactions = Derived.reactions.within("derived")
    bodies = read[tuple[Moving, ...]](lambda e: e._shown.bodies, "The bodies with their motions.")
    kinematical = read[Speeds](lambda e: e.derived.kinematical, "The kinematical equations.")
    kinematics = read[Kinematics](lambda e: e._shown.kinematics, "Motions of frames and points.")
    pairs = read[Mapping[tuple[Expr, Expr], Expr]](lambda e: e.derived.pairs, "What reactions put into auxiliary rows.")
    constraints = read[ConstraintRows](lambda e: e.derived.constraints, "The rows of A u + A_a u_a + b = 0.")

    # Steps 3 and 4: kinematics -------------------------------------------------------------------------------------------

    Y = Derived.Y.within("derived")
    z = Derived.z.within("derived")
    W = Derived.W.within("derived")
    X = Derived.X.within("derived")
    rates = _named(Kind.RATE, "coordinates", Derived.rates.within("derived"))
    angular_velocities = Derived.angular_velocities.within("_shown")
    velocities = Derived.velocities.within("_shown")
    angular_accelerations = Derived.angular_accelerations.within("_shown")
    point_accelerations = Derived.point_accelerations.within("_shown")
    partial_angular_velocities = Derived.partial_angular_velocities.within("_shown")
    partial_velocities = Derived.partial_velocities.within("_shown")

    # Steps 5 to 7: generalized forces, dynamical equations ---------------------------------------------------------------

    loads = Derived.loads.within("_shown")
    Fr_contributions = Derived.Fr_contributions.within("_shown")
    Fr_star_contributions = Derived.Fr_star_contributions.within("_shown")
    Fr = _named(Kind.ACTIVE_FORCE, "all_speeds", Derived.Fr.within("_shown"))
    Fr_star = _named(Kind.INERTIA_FORCE, "all_speeds", Derived.Fr_star.within("_shown"))
    blocks = Derived.blocks.within("derived")
    mass_matrix = Derived.mass_matrix.within("derived")
    auxiliary_mass_matrix = Derived.auxiliary_mass_matrix.within("derived")
    forcing = _named(Kind.FORCING, "speeds", Derived.forcing.within("derived"))
    auxiliary_forcing = _named(Kind.FORCING, "auxiliary_speeds", Derived.auxiliary_forcing.within("derived"))
    accelerations = _named(Kind.RATE, "speeds", read(lambda e: e.solved.shown[0], "u̇, solved."))
    reaction_values = _named(Kind.SYMBOL, "reactions", read(lambda e: e.solved.shown[1], "The reactions, solved."))
    right_hand_side = _named(Kind.RATE, "state", Solved.right_hand_side.within("solved"))
    operations = Solved.operations.within("solved")
    route = read[str](lambda e: e.solved.route, "The route by which the equations were solved.")
    routes = read[Mapping[str, int]](
        lambda e: MappingProxyType(dict(e.solved.routes) or {e.route: e.operations.total}),
        "The operations of the routes that were compared, by name.",
    )
    steps = read[tuple[Step, ...]](
        lambda e: seven_steps(e.solved), "The seven steps of the method, each with its results."
    )

    def by(self, method: str) -> Formulation:
        """The equations of motion of the system by another method, with what it must eliminate, and the same u̇.

        Parameters
        ----------
        method : "kane", "lagrange" (second kind; where constraints are left, Maggi's), "lagrange first kind" (with multipliers),
            "hamilton", "boltzmann-hamel", "newton-euler" (all constraint forces unknown), "virtual work" or "virtual power"

        Raises
        ------
        ModelError
            where the method does not take the system: all but Kane's where loads hold reactions, as friction does its normal force;
            Hamilton's where a coordinate moves no mass; his and Hamel's of Euler parameters
        """
        return formulation(self.solved, method)

    def contributions(self, speed: Expr | str) -> Contributions:
        """The terms of F_r and F*_r for one speed: each force and body with the partial velocity it meets."""
        return contributions(self._shown, speed)

    noncontributing = read[tuple[Noncontributing, ...]](
        lambda e: noncontributing(e.solved),
        "The loads that are in no (nonholonomic) generalized active force, each with the reason.",
    )
    inertia_forces = read[Mapping[Body, ForceSystem]](
        lambda e: LazyMapping(e.system.bodies, lambda body: inertia_forces(e._shown, body)),
        "The inertia force −m a at the mass centre and the inertia torque −(I·α + ω × I·ω) of each body, in u̇.",
    )

    def mass_contributions(self, r: Expr | str, s: Expr | str) -> tuple[MassContribution, ...]:
        """What each body adds to M_rs; bodies that add nothing are left out."""
        return mass_contributions(self._shown, r, s)

    # Constraints ---------------------------------------------------------------------------------------------------------

    A = Derived.A.within("derived")
    b = Derived.b.within("derived")
    embedding = read[Embedding | None](lambda e: e.solved.embedding, "u_D by u_I, None without constraints.")
    dependent_speeds = Solved.dependent_speeds.within("solved")
    independent_speeds = Solved.independent_speeds.within("solved")
    A_n = Solved.A_n.within("solved")
    b_n = Solved.b_n.within("solved")
    pivots = Solved.dependent_pivots.within("solved")
    redundant = Solved.redundant.within("solved")
    multipliers = Solved.multipliers.within("solved")
    partial_velocities_nh = Solved.partial_velocities_nh.within("solved")
    partial_angular_velocities_nh = Solved.partial_angular_velocities_nh.within("solved")
    mass_matrix_nh = Solved.mass_matrix_nh.within("solved")
    forcing_nh = _named(Kind.NONHOLONOMIC_FORCING, "independent_speeds", Solved.forcing_nh.within("solved"))
    kinetic_energy_nh = read[Expr](
        lambda e: e.solved.short([energy.kinetic_energy_in_speeds(e.solved.nonholonomic.bodies)])[0],
        "K in the independent speeds.",
    )
    _rows_nh = read[tuple[Any, ...]](lambda e: (*e.independent_speeds, *e.auxiliary_speeds), "The speeds of ~F_r.")
    Fr_nh = _named(Kind.NONHOLONOMIC_ACTIVE_FORCE, "_rows_nh", Solved.Fr_nh.within("solved"))
    Fr_star_nh = _named(Kind.NONHOLONOMIC_INERTIA_FORCE, "_rows_nh", Solved.Fr_star_nh.within("solved"))

    def reaction(self, place: Place, frame: Frame | None = None) -> JointReaction:
        """The force and torque that the near side exerts on the far side, in q, u, t, parameters and inputs.

        Parameters
        ----------
        place : a joint, a geometric point of the tree, a frame (the torque alone), a constraint, those of a closure, or a name:
            of a joint in System(joints=…), a constraint or a closure, a point, a frame, looked up in this order
        frame : the frame along which both vectors are written, by default the inertial one

        Returns
        -------
        JointReaction
            `.force` at `.point`, which is the far side's, and `.torque` about it

        Raises
        ------
        ReactionError
            if the place is none of the system's, a body is on both sides of it, a constraint does not say where its forces act, or
            redundant constraints leave the reaction undetermined
        """
        return reaction(self.solved, place, frame)

    # Rest and steady motion --------------------------------------------------------------------------------------------

    equilibrium_conditions = read[Exprs](
        lambda e: unsolved.equilibrium_conditions(e.solved),
        "F̃_r at rest, one for each independent speed: what vanishes in equilibrium (Kane & Levinson 1985, sec. 6.5).",
    )

    def steady_conditions(self, values: Mapping[Any, Any]) -> Exprs:
        """F̃_r + F̃*_r at u̇ = 0, one for each independent speed: what vanishes in steady motion (Kane & Levinson 1985, sec. 6.6).

        Parameters
        ----------
        values : of some coordinates and speeds, by symbol or name, numbers or expressions of parameters

        Raises
        ------
        ValueMissingError
            if a value is given for something else
        """
        return unsolved.steady_conditions(self.solved, values)

    # Energies, momenta, integrals (Kane & Levinson 1985, ch. 5, sec. 6.8, 7.1 to 7.4) --------------------------------------

    kinetic_energy = read[Expr](lambda e: energy.whole_kinetic_energy(e.solved), "K = ½ Σ m v·v + ω·I·ω.")
    kinetic_energy_parts = read[KineticParts](
        lambda e: energy.kinetic_energy_parts(e.bodies, e.speeds),
        "K₂, K₁ and K₀, of degree 2, 1 and 0 in the speeds; K₂ = ½ Σ M_rs u_r u_s. Their sum is K.",
    )
    potential_energy = read[Expr](
        lambda e: energy.potential_energy(e.loads),
        "V, the sum of the loads' potentials; gravity's is zero at the root point's height.",
    )
    energy = read[Expr](lambda e: e.kinetic_energy + e.potential_energy, "E = K + V.")
    power = read[Expr](
        lambda e: energy.power(e.solved),
        "P with dE/dt = P: the power of the loads without a potential and of prescribed motions.",
    )
    load_powers = read[Mapping[Load, Expr]](
        lambda e: energy.load_powers(e._shown, dict(zip((*e.system.gravities, *e.system.loads), e.loads, strict=True))),
        "Σ F·v + Σ T·ω of each load, by the load or its name.",
    )
    gibbs_function = read[Expr](
        lambda e: energy.gibbs_function(e.bodies),
        "G = ½ Σ m a·a + α·I·α + 2 α·(ω × I·ω), with ∂G/∂u̇_r = −F*_r: Gibbs's function, in u̇.",
    )
    Fr_star_by_energy = read[Exprs](
        lambda e: energy.inertia_forces_by_energy(e._shown),
        "F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr: a second way to the generalized inertia forces of all speeds.",
    )
    generalized_momenta = read[Exprs](
        lambda e: energy.generalized_momenta(e.bodies, e.speeds), "p_r = Σ m v_r·v + ω_r·I·ω, one a speed."
    )
    generalized_momenta_nh = read[Exprs](
        lambda e: energy.generalized_momenta(e.solved.nonholonomic.bodies, e.independent_speeds),
        "Σ m ṽ_r·v + ω̃_r·I·ω, one for each independent speed.",
    )
    conjugate_momenta = read[Exprs](
        lambda e: energy.conjugate_momenta(e._shown), "p_s = ∂K/∂q̇_s, one a coordinate, in speeds."
    )
    cyclic_coordinates = read[tuple[Coordinate, ...]](
        lambda e: energy.cyclic_coordinates(e._shown),
        "Coordinates on which neither K nor forces nor constraints depend, and along which none acts: their momenta are constant.",
    )
    central_angular_momentum = read[Vector](
        lambda e: energy.central_angular_momentum(e.bodies), "Σ I·ω + r × m v about the mass centre."
    )
    integrals = read[tuple[Integral, ...]](
        lambda e: integrals(e.solved),
        "Integrals of the equations of motion, each with its name, value and reason: energy, Hamiltonian, momenta, speeds.",
    )

    def find_potential(self, loads: Sequence[Any] | None = None) -> FoundPotential:
        """V found from F_r = −Σ_s ∂V/∂q_s W_sr, whatever the speeds, also under constraints (Kane & Levinson 1985, sec. 5.1).

        Parameters
        ----------
        loads : some of the system's loads, themselves or by name; all of them if left out

        Returns
        -------
        FoundPotential
            `.value` is V, and `.how` says how it was integrated

        Raises
        ------
        PotentialError
            if there is none, or none was found: says which forces depend on rates, or which coordinates' derivatives disagree where
        """
        return find_potential(self.derived, loads)

    def generalized_impulses(self, impulses: Sequence[Impulse]) -> Exprs:
        """I_r = Σ v_r·∫F dt + ω_r·∫T dt, one a speed, of impulses (point, vector) and impulses of torques (frame, vector)."""
        return energy.generalized_impulses(self.derived, impulses)

    def mass_center(self, origin: Point) -> Vector:
        """Position of the system's mass centre from `origin`."""
        return energy.mass_center(self.bodies, origin)

    def linear_momentum(self) -> Vector:
        """Σ m v."""
        return energy.linear_momentum(self.bodies)

    def angular_momentum(self, about: Point) -> Vector:
        """Σ I·ω + r × m v about a point fixed in the inertial frame."""
        return energy.angular_momentum(self.bodies, about)

    # Numbers and code -----------------------------------------------------------------------------------------------------

    def time_derivative(self, e: Any) -> Expr:
        """de/dt along the motion: q̇ = W u + X, u̇ as the leaves u'."""
        return time_derivative(self.derived, as_expr(e))

    def in_speeds(self, e: Any) -> Expr:
        """The expression with every rate q̇ written in speeds, and every q̈ in u̇."""
        return without_rates(self.derived, as_expr(e))

    def unit(self, e: Any) -> str:
        """The unit of an expression, such as "m/s^2", "" where it is unknown; a speed that declares none has its definition's."""
        return unit_in(self.system, as_expr(e))

    @by_keyword
    def evaluate(self, exprs: Any, state: State | None = None, **values: Unpack[StateValues]) -> Any:
        """Numbers of an expression, name, Vector, Dyadic or Matrix, or of a list of these, at a `kn.State`, or values by keyword.

        Measure numbers are along the inertial frame, those of a vector the last axis, those of a dyadic or matrix the last two.
        Rates become W u + X, accelerations u̇ and reactions their solved values, dependent speeds that are not given A_n u_I + b_n.
        Values may be arrays (they broadcast); parameters and states not given take their defaults.

        Raises
        ------
        SimulationError
            if dependent speeds are given that miss the constraints; of arrays a warning names the first such place
        SingularError
            if the values are divided by a pivot that vanishes at this state: the dependent speeds of `dependent_speeds` do not follow
            there. Or if constraints left out as redundant hold something at this state, on another branch than those compared. Of
            arrays a warning names the first such place, and the values there are NaN
        """
        return evaluate_along(self.solved, exprs, *state_of(state, **values).in_order)

    inverse_dynamics = read[Exprs](
        lambda e: unsolved.inverse_dynamics(e.solved),
        "M u̇ − f in u̇: the generalized forces that a motion wants besides the loads; of trees by recursion.",
    )
    centroidal_momentum_matrix = read[Matrix](
        lambda e: unsolved.centroidal_momentum_matrix(e.solved),
        "A_G (6 × n): Σ m v, then the angular momentum about the mass centre, along the inertial frame, per unit of each speed.",
    )

    def operational_inertia(self, place: Point | Frame, along: Sequence[Vector] | None = None) -> Matrix:
        """Λ = (J M⁻¹ Jᵀ)⁻¹: the force at a point along each axis per unit of acceleration; of a frame torque and angular acceleration.

        Without `along` the axes are those of the inertial frame. Axes must be independent: a SingularError where they never are.
        """
        return unsolved.operational_inertia(self.solved, place, along)

    def operational_mobility(self, place: Point | Frame, along: Sequence[Vector] | None = None) -> Matrix:
        """Λ⁻¹ = J M⁻¹ Jᵀ, which exists along any axes."""
        return unsolved.operational_mobility(self.solved, place, along)

    def jacobian(self, by: Any = "state") -> Jacobian:
        """The derivatives of the right-hand side (q̇, u̇, ȧ), exact, with their pattern.

        Parameters
        ----------
        by : "state" (all coordinates, all speeds, then further states), "inputs", "parameters", "time", or a list of symbols and names

        Raises
        ------
        ValueMissingError
            if a name is none of the system's
        """
        return jacobian(self.solved, by)

    def speeds_from_rates(
        self,
        q: Values,
        rates: Values,
        *,
        parameters: Mapping[Any, Any] | None = None,
        inputs: Mapping[Any, Any] | None = None,
        t: Any = 0.0,
    ) -> dict[Speed, Any]:
        """u = Y q̇ + z at numbers: the generalized speeds of a motion known by the rates of its coordinates."""
        return speeds_from_rates(self.derived, q, rates, parameters, inputs, t)

    @by_keyword
    def reaction_condition(self, state: State | None = None, **values: Unpack[StateValues]) -> npt.NDArray[np.float64]:
        """Reciprocal condition number (2-norm) of the matrix that the reactions are solved from; 1 without reactions."""
        if not self.reactions:
            return np.ones(())
        return np.asarray(1.0 / np.linalg.cond(self.evaluate(self.solved.reaction_matrix, state, **values)))

    def compile(
        eom: Equations,  # kn.compile(eom, …) is this method
        *,
        name: str = "model",
        outputs: Mapping[str, Any] | None = None,
        parameters: Mapping[Any, float] | None = None,
        contract: bool = True,
        cpu: str = "host",
        features: str = "",
        cache: bool = True,
        not_finite: NotFinite = "warn",
        optimize: bool = True,
    ) -> Compiled:
        """Machine code of the equations, through LLVM; no compiler is needed on the machine.

        Parameters
        ----------
        eom : Equations
        name : what the emitted functions are called after
        outputs : expressions, vectors, matrices by name, for `Compiled.outputs`
        parameters : values by symbol or name that replace defaults where a call gives no p
        contract : let a·b + c round once (FMA) and divisions by one divisor share its reciprocal; False rounds each operation of the
            expressions by itself, so that those of + − × ÷ √ are NumPy's bit by bit
        cpu : "host", or "generic" for what every processor of this kind has
        features : what to add to "generic", as LLVM calls it: "+avx2,+fma"
        cache : keep the code in the user's cache folder, so that a second run compiles nothing (see `KANE_CACHE`)
        not_finite : "warn", "raise" or "ignore" where a result is infinite or NaN
        optimize : rewrite to fewer operations, nearly as exact, where `contract` lets results round in another way

        Raises
        ------
        ValueMissingError
            if `parameters` names something else
        ProgramError
            if the code could not run on this processor
        """
        settings = Settings(contract, cpu, features, cache, optimize)
        return compiled(eom, name, outputs, parameters, settings, not_finite)

    _numeric = read[dict[Settings, "Numeric[Equations]"]](lambda e: {}, "What was compiled, by settings.")

    def numeric(self, settings: Settings | None = None) -> Numeric[Equations]:
        """What motions and analyses compile of these equations with `settings`, kept with them."""
        key = _SETTINGS if settings is None else settings
        expect.instance(key, Settings, "kn.Settings(…) as settings", error=ArgumentError)
        found = self._numeric.get(key)
        return self._numeric.setdefault(key, Numeric(replace(self), key)) if found is None else found

    _repr_html_ = show.html

    def __repr__(self) -> str:
        size = show.counts(
            coordinates=len(self.coordinates),
            speeds=len(self.speeds),
            reactions=len(self.reactions),
            operations=self.operations.total,
        )
        return f"Equations({', '.join(b.name for b in self.system.bodies)}: {size})"


compile = Equations.compile


def check_equations(eom: object) -> None:
    """A SimulationError for what is no equations, such as the system itself."""
    cure = "Derive them first: eom = kn.derive(system)."
    expect.instance(eom, Equations, "equations of motion", cure, error=SimulationError)


# Derivation ----------------------------------------------------------------------------------------------------------


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
        parts = derived(system, near)
        partition = first_partition(parts)
        if system.loads:
            check_potentials(parts)
        return _solved(parts, partition, route)


def repartition(eom: Equations, partition: Partition) -> Equations:
    """The same equations with other dependent speeds, as if these had been named: free of false poles of W where they make them so."""
    return _solved(eom.derived, partition, eom.solved.asked, fixed=True)


def _solved(parts: Derived, partition: Partition | None, asked: str | None, *, fixed: bool = False) -> Equations:
    """By the route that is `asked` for; else the shortest, or, with speeds that are regular at false poles, the one without these."""
    if asked is not None:
        return _equations(replace(solved(parts, partition, asked), asked=asked))
    regular = without_poles(parts, partition, fixed)
    return _equations(solved(parts, partition) if regular is None else solved(parts, regular, "constraint speeds"))


def _reduced(solution: Solved) -> tuple[Any, ...]:
    """Pickled are the system, and which speeds are dependent: what follows from them is derived again."""
    partition = None if solution.embedding is None else solution.embedding.partition
    return _restored, (solution.derived.system, solution.derived.near, partition, solution.asked)


def _restored(system: System, near: Mapping[Any, Any] | None, partition: Partition | None, route: str | None) -> Solved:
    eom = derive(system, near=near, route=route)
    if partition is None or (eom.embedding is not None and eom.embedding.partition == partition):
        return eom.solved
    return repartition(eom, partition).solved


copyreg.pickle(Solved, _reduced)
copyreg.pickle(Equations, lambda eom: (_equations, (eom.solved,)))


def _equations(solution: Solved) -> Equations:
    return Equations(solution, watched_events(solution))
