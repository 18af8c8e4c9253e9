# SPDX-License-Identifier: BSD-3-Clause
"""`Equations`, the frozen result of a derivation by the seven steps of Kane's method, and `derive`, which makes it."""

import copyreg
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, TypeVar, Unpack

import numpy as np
import numpy.typing as npt

from kane import expect, show
from kane.dynamics.constraints.partition import Embedding, Partition
from kane.dynamics.derivation import Derived, derived, first_partition
from kane.dynamics.forcing import Moving
from kane.dynamics.formalisms import Formulation, formulation
from kane.dynamics.formulation.table import ASKED, solved
from kane.dynamics.lazy import LazyMapping, read
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
from kane.dynamics.readings.energy import Impulse, Integral, KineticParts, integrals
from kane.dynamics.readings.joint_reactions import JointReaction, Place, reaction
from kane.dynamics.readings.potential import FoundPotential, check_potentials, find_potential
from kane.dynamics.readings.quantities import evaluate_along, speeds_from_rates, time_derivative, without_rates
from kane.dynamics.readings.seven_steps import Kind, Quantity, Step, seven_steps
from kane.dynamics.solved import Solved
from kane.equations.compiled import Compiled, Numeric, compiled
from kane.equations.jacobian import Jacobian, jacobian
from kane.equations.state import State, StateValues, by_keyword, columns_of, state_of
from kane.errors import ArgumentError, ModelError, SimulationError, none_of
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, Exprs, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Input, Parameter, Rate, Speed, time
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
    """Equations of motion M u̇ = f + Aᵀ λ, A u + b = 0 of a system, from `kn.derive`, with all quantities of the derivation.

    `mass_matrix` M (n × n) and `forcing` f (n) are those of the n generalized speeds; f may contain reactions. `accelerations` u̇
    and `reaction_values` are solved for, as functions of q, u, t, parameters and inputs; `rates` are q̇ = W u + X. Under
    constraints, the dependent speeds are u_D = A_n u_I + b_n, and `multipliers` are the constraint forces λ. `redundant` are the
    constraints that follow from the others at the configurations examined, see `near` of `kn.derive`.
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

    derived = read[Derived](
        lambda e: e.solved.derived, "The quantities that do not depend on the choice of dependent speeds."
    )
    _shown = read[Derived](lambda e: e.derived.as_declared, "The same, written along the declared frames.")
    system = read[System](lambda e: e.derived.system, "The system.")
    coordinates = read[tuple[Coordinate, ...]](lambda e: e.system.coordinates, "The coordinates q.")
    parameters = read[tuple[Parameter, ...]](lambda e: e.system.parameters, "The parameters of the system.")
    inputs = read[tuple[Input | Rate, ...]](lambda e: e.system.inputs, "The inputs of the system, and their rates.")
    frames = read[tuple[Frame, ...]](lambda e: e.system.frames, "The frames of the system.")
    points = read[tuple[Point, ...]](lambda e: e.system.points, "The points of the system.")
    speeds = Derived.speeds.within("derived")
    auxiliary_speeds = read[tuple[AuxiliarySpeed, ...]](
        lambda e: e.derived.auxiliary_speeds, "The auxiliary speeds u_a, one for each reaction."
    )
    all_speeds = Derived.all_speeds.within("derived")
    states = Derived.states.within("derived")
    state_rates = _named(
        Kind.RATE,
        "states",
        read(lambda e: e.solved.state_rates, "Rates ȧ of the states beside q and u, as functions of the state."),
    )
    state = Derived.state.within("derived")
    reactions = Derived.reactions.within("derived")
    bodies = read[tuple[Moving, ...]](
        lambda e: e._shown.bodies, "The parts of the bodies with their velocities and accelerations."
    )
    kinematical = read[Speeds](
        lambda e: e.derived.kinematical, "The kinematical equations u = Y q̇ + z and q̇ = W u + X."
    )
    kinematics = read[Kinematics](lambda e: e._shown.kinematics, "Motions of frames and points.")
    pairs = read[Mapping[tuple[Expr, Expr], Expr]](
        lambda e: e.derived.pairs, "Coefficients of reactions in the equations of auxiliary speeds."
    )
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
    accelerations = _named(
        Kind.RATE,
        "speeds",
        read(lambda e: e.solved.shown[0], "The accelerations u̇ as functions of q, u, t, parameters and inputs."),
    )
    reaction_values = _named(
        Kind.SYMBOL,
        "reactions",
        read(lambda e: e.solved.shown[1], "The reactions as functions of q, u, t, parameters and inputs."),
    )
    right_hand_side = _named(Kind.RATE, "state", Solved.right_hand_side.within("solved"))
    operations = Solved.operations.within("solved")
    route = read[str](
        lambda e: e.solved.route, "The name of the route by which the equations are solved for u̇, as in `kn.derive`."
    )
    routes = read[Mapping[str, int]](
        lambda e: MappingProxyType(dict(e.solved.routes) or {e.route: e.operations.total}),
        "The number of operations of each route that was compared, by name.",
    )
    steps = read[tuple[Step, ...]](
        lambda e: seven_steps(e.solved), "The seven steps of the method, each with its results."
    )

    def by(self, method: str) -> Formulation:
        """The equations of motion of the system by another method; they give the same accelerations u̇.

        Parameters
        ----------
        method : "kane", "lagrange" (second kind; Maggi's equations if there are constraints), "lagrange first kind" (with
            multipliers), "hamilton", "boltzmann-hamel", "newton-euler" (with all constraint forces as unknowns), "virtual work" or
            "virtual power"

        Returns
        -------
        Formulation
            `.equations`, `.unknowns`, `.right_hand_side`, `.eliminated`, `.operations`

        Raises
        ------
        ModelError
            if the method is not applicable: any but Kane's if loads depend on reactions, as `kn.friction` on its normal force;
            Hamilton's if a coordinate moves no mass; Hamilton's and Hamel's with Euler parameters
        """
        return formulation(self.solved, method)

    def contributions(self, speed: Expr | str) -> Contributions:
        """The terms of F_r and F*_r for one speed: each force and torque with the partial velocity that multiplies it."""
        return contributions(self._shown, speed)

    noncontributing = read[tuple[Noncontributing, ...]](
        lambda e: noncontributing(e.solved),
        "The loads that contribute to no (nonholonomic) generalized active force, each with the reason.",
    )
    inertia_forces = read[Mapping[Body, ForceSystem]](
        lambda e: LazyMapping(e.system.bodies, lambda body: inertia_forces(e._shown, body)),
        "The inertia force −m a at the mass centre and the inertia torque −(I·α + ω × I·ω) of each body, in u̇.",
    )

    def mass_contributions(self, r: Expr | str, s: Expr | str) -> tuple[MassContribution, ...]:
        """The contribution of each body to the entry M_rs of the mass matrix; zero contributions are left out."""
        return mass_contributions(self._shown, r, s)

    # Constraints ---------------------------------------------------------------------------------------------------------

    A = Derived.A.within("derived")
    b = Derived.b.within("derived")
    embedding = read[Embedding | None](lambda e: e.solved.embedding, "u_D in terms of u_I; None without constraints.")
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
        "The kinetic energy K in the independent speeds.",
    )
    _rows_nh = read[tuple[Any, ...]](lambda e: (*e.independent_speeds, *e.auxiliary_speeds), "The speeds of ~F_r.")
    Fr_nh = _named(Kind.NONHOLONOMIC_ACTIVE_FORCE, "_rows_nh", Solved.Fr_nh.within("solved"))
    Fr_star_nh = _named(Kind.NONHOLONOMIC_INERTIA_FORCE, "_rows_nh", Solved.Fr_star_nh.within("solved"))

    def reaction(self, place: Place, frame: Frame | None = None) -> JointReaction:
        """The force and torque that are transmitted at a joint, a point, a frame or by constraints, in q, u, t, parameters and inputs.

        Parameters
        ----------
        place : a joint, a geometric point of the tree, a frame (for the torque alone), a constraint or the constraints of a closed
            loop; or the name of a joint in System(joints=…), a constraint or loop, a point or a frame, looked up in this order
        frame : the frame along which both vectors are written; by default the inertial frame

        Returns
        -------
        JointReaction
            what the near side, towards the root of the tree, exerts on the far side: `.force` (N) at `.point` of the far side, and
            `.torque` (N m) about this point

        Raises
        ------
        ReactionError
            if the system does not contain the place, a body is on both sides of it, the forces of a constraint have no known
            points, or redundant constraints leave the reaction undetermined
        """
        return reaction(self.solved, place, frame)

    # Rest and steady motion --------------------------------------------------------------------------------------------

    equilibrium_conditions = read[Exprs](
        lambda e: unsolved.equilibrium_conditions(e.solved),
        "F̃_r at rest for each independent speed, which are zero in equilibrium (Kane & Levinson 1985, sec. 6.5).",
    )

    def steady_conditions(self, values: Mapping[Any, Any]) -> Exprs:
        """F̃_r + F̃*_r at u̇ = 0 for each independent speed, which are zero in steady motion (Kane & Levinson 1985, sec. 6.6).

        Parameters
        ----------
        values : constant values of some coordinates and speeds, by symbol or name: numbers or expressions of parameters

        Raises
        ------
        ValueMissingError
            if a value is given for anything else
        """
        return unsolved.steady_conditions(self.solved, values)

    # Energies, momenta, integrals (Kane & Levinson 1985, ch. 5, sec. 6.8, 7.1 to 7.4) --------------------------------------

    kinetic_energy = read[Expr](
        lambda e: energy.whole_kinetic_energy(e.solved), "Kinetic energy K = ½ Σ (m v·v + ω·I·ω)."
    )
    kinetic_energy_parts = read[KineticParts](
        lambda e: energy.kinetic_energy_parts(e.bodies, e.speeds),
        "The terms K₂, K₁ and K₀ of K that have the degree 2, 1 and 0 in the speeds; K₂ = ½ Σ M_rs u_r u_s.",
    )
    potential_energy = read[Expr](
        lambda e: energy.potential_energy(e.loads),
        "Potential energy V: the sum of the potentials of the loads; that of gravity is zero at the height of the root point.",
    )
    energy = read[Expr](lambda e: e.kinetic_energy + e.potential_energy, "Total energy E = K + V.")
    power = read[Expr](
        lambda e: energy.power(e.solved), "Power P of the loads without potential and of prescribed motions: dE/dt = P."
    )
    load_powers = read[Mapping[Load, Expr]](
        lambda e: energy.load_powers(e._shown, dict(zip((*e.system.gravities, *e.system.loads), e.loads, strict=True))),
        "The power Σ F·v + Σ T·ω of each load, by the load or its name.",
    )
    gibbs_function = read[Expr](
        lambda e: energy.gibbs_function(e.bodies),
        "G = ½ Σ m a·a + α·I·α + 2 α·(ω × I·ω), with ∂G/∂u̇_r = −F*_r: Gibbs's function, in u̇.",
    )
    Fr_star_by_energy = read[Exprs](
        lambda e: energy.inertia_forces_by_energy(e._shown),
        "F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr: the generalized inertia forces of all speeds from K.",
    )
    generalized_momenta = read[Exprs](
        lambda e: energy.generalized_momenta(e.bodies, e.speeds),
        "Generalized momenta p_r = Σ (m v_r·v + ω_r·I·ω), one for each speed.",
    )
    generalized_momenta_nh = read[Exprs](
        lambda e: energy.generalized_momenta(e.solved.nonholonomic.bodies, e.independent_speeds),
        "Nonholonomic generalized momenta Σ (m ṽ_r·v + ω̃_r·I·ω), one for each independent speed.",
    )
    conjugate_momenta = read[Exprs](
        lambda e: energy.conjugate_momenta(e._shown),
        "Conjugate momenta p_s = ∂K/∂q̇_s, one for each coordinate, in speeds.",
    )
    cyclic_coordinates = read[tuple[Coordinate, ...]](
        lambda e: energy.cyclic_coordinates(e._shown),
        "Coordinates on which neither K nor forces nor constraints depend, without a generalized force: their momenta are constant.",
    )
    central_angular_momentum = read[Vector](
        lambda e: energy.central_angular_momentum(e.bodies),
        "Central angular momentum Σ (I·ω + r × m v), about the mass centre of the system.",
    )
    integrals = read[tuple[Integral, ...]](
        lambda e: integrals(e.solved),
        "Integrals (constants) of the motion, each with name, expression and reason: energy, Hamiltonian, momenta, speeds.",
    )

    def find_potential(self, loads: Sequence[Any] | None = None) -> FoundPotential:
        """A potential energy V of loads, by integration of F_r = −Σ_s ∂V/∂q_s W_sr (Kane & Levinson 1985, sec. 5.1).

        Parameters
        ----------
        loads : loads of the system, or their names; by default all

        Returns
        -------
        FoundPotential
            `.value` is V; `.how` describes the integration

        Raises
        ------
        PotentialError
            if no potential exists or none is found; the message names forces that depend on rates, or the coordinates whose cross
            derivatives differ, and where
        """
        return find_potential(self.derived, loads)

    def generalized_impulses(self, impulses: Sequence[Impulse]) -> Exprs:
        """Generalized impulses I_r = Σ (v_r·∫F dt + ω_r·∫T dt), one for each speed.

        `impulses` are pairs (point, ∫F dt) and (frame, ∫T dt), with vectors in N s and N m s.
        """
        return energy.generalized_impulses(self.derived, impulses)

    def mass_center(self, origin: Point) -> Vector:
        """Position of the system's mass centre from `origin`."""
        return energy.mass_center(self.bodies, origin)

    def linear_momentum(self) -> Vector:
        """Linear momentum Σ m v of the system."""
        return energy.linear_momentum(self.bodies)

    def angular_momentum(self, about: Point) -> Vector:
        """Angular momentum Σ (I·ω + r × m v) of the system about a point fixed in the inertial frame."""
        return energy.angular_momentum(self.bodies, about)

    # Numbers and code -----------------------------------------------------------------------------------------------------

    def time_derivative(self, e: Any) -> Expr:
        """de/dt of an expression along the motion, with q̇ = W u + X; the accelerations u̇ stay symbols u'."""
        return time_derivative(self.derived, as_expr(e))

    def in_speeds(self, e: Any) -> Expr:
        """The expression with each rate q̇ written in speeds, and each q̈ in speeds and u̇."""
        return without_rates(self.derived, [as_expr(e)])[0]

    def unit(self, e: Any) -> str:
        """The unit of an expression, such as "m/s^2"; "" if unknown. A speed declared without a unit has that of its definition."""
        return unit_in(self.system, as_expr(e))

    @by_keyword
    def evaluate(self, exprs: Any, state: State | Any | None = None, **values: Unpack[StateValues]) -> Any:
        """Numerical values of an expression, a name, Vector, Dyadic or Matrix, or of a list of these, at a state.

        The state is a `kn.State`, or its values are given by keyword, which may be arrays that broadcast, or a Dataset of states, as
        `kn.assemble` returns for arrays; axes of states come first in the result. Parameters and further states left out take their
        defaults, dependent speeds left out are A_n u_I + b_n. Rates in `exprs` have the values W u + X, accelerations u̇ and reactions
        those that the equations give. Vectors are written along the inertial frame, with the measure numbers in the last axis;
        dyadics and matrices take the last two.

        Raises
        ------
        SimulationError
            if given dependent speeds violate the constraints; for arrays, a warning names the first such entry instead
        SingularError
            if the constraints do not determine `dependent_speeds` at this state (a pivot is zero), or if constraints in
            `redundant` are independent of the others there, on another branch than those examined. For arrays, a warning names the
            first such entry instead, and its values are NaN
        """
        if hasattr(state, "data_vars"):
            kinds = columns_of(self, state)
            state = State(**kinds | {"t": kinds["t"].get(time, 0.0)})
        return evaluate_along(self.solved, exprs, *state_of(state, **values).in_order)

    inverse_dynamics = read[Exprs](
        lambda e: unsolved.inverse_dynamics(e.solved),
        "M u̇ − f as functions of the state and u̇: the generalized forces that a motion needs in addition to the loads.",
    )
    centroidal_momentum_matrix = read[Matrix](
        lambda e: unsolved.centroidal_momentum_matrix(e.solved),
        "A_G (6 × n): linear, then central angular momentum along the inertial axes, per unit of each speed.",
    )

    def operational_inertia(self, place: Point | Frame, along: Sequence[Vector] | None = None) -> Matrix:
        """Operational-space inertia Λ = (J M⁻¹ Jᵀ)⁻¹ of a point: force per unit of acceleration; of a frame: torque per α.

        `along` holds the unit vectors to measure along, by default the inertial axes. Raises a SingularError if the motions along
        them are dependent in every configuration.
        """
        return unsolved.operational_inertia(self.solved, place, along)

    def operational_mobility(self, place: Point | Frame, along: Sequence[Vector] | None = None) -> Matrix:
        """The inverse of `operational_inertia`, Λ⁻¹ = J M⁻¹ Jᵀ, which exists along any axes."""
        return unsolved.operational_mobility(self.solved, place, along)

    def jacobian(self, by: Any = "state") -> Jacobian:
        """The exact derivatives of the right-hand side ẋ = (q̇, u̇, ȧ) as expressions, with their sparsity pattern.

        Parameters
        ----------
        by : what to differentiate with respect to: "state" (all coordinates, all speeds, then further states), "inputs",
            "parameters", "time", or a list of symbols and names

        Raises
        ------
        ValueMissingError
            if the system has no symbol of a given name
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
        """Numerical values of the generalized speeds u = Y q̇ + z, by symbol, for given coordinates `q` and their `rates`."""
        return speeds_from_rates(self.derived, q, rates, parameters, inputs, t)

    @by_keyword
    def reaction_condition(self, state: State | None = None, **values: Unpack[StateValues]) -> npt.NDArray[np.float64]:
        """Reciprocal condition number (2-norm), at a state, of the matrix of the equations for the reactions; 1 without reactions."""
        if not self.reactions:
            return np.ones(())
        return np.asarray(1.0 / np.linalg.cond(self.evaluate(self.solved.reaction_matrix, state, **values)))

    def compile(
        eom: "Equations",  # kn.compile(eom, …) is this method
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
        """Compile the equations to machine code by LLVM, which needs no installed compiler.

        Parameters
        ----------
        eom : Equations
        name : prefix of the names of functions that `Compiled.emit` prints
        outputs : expressions, vectors and matrices by name, to be evaluated by `Compiled.outputs`
        parameters : values by symbol or name that replace the default values in calls without p
        contract : allow a·b + c with one rounding (FMA), and one reciprocal for several divisions by the same divisor. With False
            each operation is rounded by itself, so that + − × ÷ √ agree with NumPy bit by bit
        cpu : "host", or "generic" for the instructions that all processors of this architecture have
        features : processor features in addition to "generic", by LLVM's names: "+avx2,+fma"
        cache : keep the code in the user's cache folder for later runs (see `KANE_CACHE`)
        not_finite : "warn", "raise" or "ignore": what to do if a result is infinite or NaN
        optimize : rewrite expressions to fewer operations, with nearly the same accuracy; takes effect with `contract`

        Raises
        ------
        ValueMissingError
            if `parameters` contains a name that is not a parameter of the system
        ProgramError
            if this processor cannot run the code
        """
        settings = Settings(contract, cpu, features, cache, optimize)
        return compiled(eom, name, outputs, parameters, settings, not_finite)

    _numeric = read[dict[Settings, "Numeric[Equations]"]](lambda e: {}, "What was compiled, by settings.")

    def numeric(self, settings: Settings | None = None) -> "Numeric[Equations]":
        """The compiled routines that motions and analyses of these equations share, for given `settings`."""
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
    """Derive the equations of motion of `system` by Kane's method, and solve them by the route with the fewest operations.

    M u̇ = f + G R for the generalized speeds and M_a u̇ = f_a + G_a R for the auxiliary ones (Kane & Levinson 1985, ch. 4 to 6) are
    solved together for u̇ and the reactions R. Constraints A u + b = 0 are embedded: the equations are solved for the independent
    speeds, which determine the dependent ones. Dependent speeds, and constraints that are redundant, are chosen numerically at
    several configurations on each branch found that satisfies the constraints, with parameters at their defaults.

    Parameters
    ----------
    system : System
    near : approximate coordinates of the motion, by symbol or name, if a mechanism has several branches, and values of parameters,
        inputs and t that its constraints contain. The choice is then made at configurations around the nearest one alone
    route : "classical" (M is assembled and factored) or, for trees of bodies, "recursive" (articulated inertias; the number of
        operations grows linearly with the number of bodies) or "composite" (composite inertias; shorter for short branches). By
        default that with the fewest operations: `eom.route` names it, `eom.routes` has the operations of those compared

    Raises
    ------
    SpeedsError
        if the generalized speeds do not determine the rates
    ReactionError
        if a reaction enters nonlinearly, or the system can already move in its direction
    ModelError
        if a speed moves no mass; if a constraint is not affine in the rates, restricts no motion, or cannot be satisfied near
        `near`; or if `route` is not applicable to the system
    ValueMissingError
        if `near` contains an unknown name
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
