# SPDX-License-Identifier: BSD-3-Clause
"""The frozen result of a derivation: each of the seven steps can be read off it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from kane import show
from kane.dynamics.constraints.embed import Embedding, multipliers
from kane.dynamics.constraints.singular import Pivot, pivots
from kane.dynamics.loads import loads_in_speeds
from kane.dynamics.readings import energy, forces
from kane.dynamics.readings.contributions import Contributions, MassContribution, contributions, mass_contributions
from kane.dynamics.readings.joint_reactions import JointReaction, Place, reaction
from kane.dynamics.readings.steps import Step, seven_steps
from kane.dynamics.readings.values import evaluate_along, speeds_from_rates
from kane.dynamics.routes.classical import Moving
from kane.dynamics.routes.reduce import Blocks, Solved
from kane.errors import ExpressionError
from kane.expr.build import add, sub
from kane.expr.count import Operations, count_operations
from kane.expr.diff import tangent
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Input, Parameter, Rate, Reaction, Speed, Time, input_of, rate
from kane.kinematics.constraints import ConstraintRows
from kane.kinematics.motion import Kinematics, Motion, acceleration_form, velocity_form
from kane.kinematics.speeds import Speeds
from kane.model.constraints import Constraint
from kane.model.events import Event
from kane.model.loads import Load
from kane.model.system import System
from kane.model.units import unit_in
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

if TYPE_CHECKING:
    from kane.equations.compiled import compile

K = TypeVar("K")
V = TypeVar("V")


class Table(Mapping[K, V], Generic[K, V]):
    """A read-only mapping that computes each value when it is first read."""

    __slots__ = ("_keys", "_known", "_make")

    def __init__(self, keys: Sequence[K], make: Callable[[K], V]) -> None:
        self._keys, self._make, self._known = dict.fromkeys(keys), make, {}  # type: ignore[var-annotated]

    def __getitem__(self, key: K) -> V:
        if key not in self._known:
            if key not in self._keys:
                raise KeyError(f"Expected one of {', '.join(map(_label, self._keys))}, got {_label(key)}.")
            self._known[key] = self._make(key)
        found: V = self._known[key]
        return found

    def __iter__(self) -> Iterator[K]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{_label(k)}: {self[k]}" for k in self) + "}"


def _label(key: object) -> str:
    if isinstance(key, tuple):
        return "(" + ", ".join(map(_label, key)) + ")"
    return str(getattr(key, "name", key))


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """Equations of motion M u̇ = f + Aᵀ λ, A u + b = 0 of a system, with everything that led to them.

    `mass_matrix` (n × n) and `forcing` (n) hold the equations as derived; `forcing` may contain reactions. `accelerations` (u̇)
    and `reaction_values` are solved for, as functions of q, u, t, parameters and inputs; `rates` gives q̇ = W u + X. With
    constraints, `u_D = A_n u_I + b_n` gives the dependent speeds, and `multipliers` the forces λ that hold them.
    """

    system: System
    speeds: tuple[Speed, ...]
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    reactions: tuple[Reaction, ...]
    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Input | Rate, ...]
    kinematical: Speeds
    kinematics: Kinematics
    bodies: tuple[Moving, ...]
    pairs: dict[tuple[Expr, Expr], Expr]
    rates: tuple[Expr, ...]
    blocks: Blocks
    constraints: ConstraintRows
    embedding: Embedding | None
    solved: Solved
    events: tuple[Event, ...]

    @cached_property
    def mass_matrix(self) -> Matrix:
        """M (n × n), of all speeds."""
        n = len(self.speeds)
        return Matrix(self.blocks.mass, (n, n))

    @cached_property
    def auxiliary_mass_matrix(self) -> Matrix:
        """M_a (auxiliary × n)."""
        return Matrix(self.blocks.mass_a, (len(self.auxiliary_speeds), len(self.speeds)))

    @cached_property
    def forcing(self) -> tuple[Expr, ...]:
        """f (n), reactions that loads hold included, forces of the constraints not."""
        return self._with_reactions(self.blocks.forcing, self.blocks.coupling)

    @cached_property
    def auxiliary_forcing(self) -> tuple[Expr, ...]:
        """f_a (auxiliary speeds), with the reactions."""
        return self._with_reactions(self.blocks.forcing_a, self.blocks.coupling_a)

    def _with_reactions(self, plain: Sequence[Expr], coupling: Sequence[Sequence[Expr]]) -> tuple[Expr, ...]:
        return tuple(add(f, dot(row, self.reactions)) for f, row in zip(plain, coupling, strict=True))

    @property
    def accelerations(self) -> tuple[Expr, ...]:
        """u̇, solved."""
        return self.solved.accelerations

    @property
    def reaction_values(self) -> tuple[Expr, ...]:
        """The reactions, solved."""
        return self.solved.reactions

    @property
    def right_hand_side(self) -> tuple[Expr, ...]:
        """(q̇, u̇) as functions of the state."""
        return (*self.rates, *self.accelerations)

    @cached_property
    def operations(self) -> Operations:
        """Operations of one evaluation of the whole right-hand side, solution included."""
        return count_operations((*self.right_hand_side, *self.reaction_values))

    # Steps 3 and 4: kinematics ---------------------------------------------------------------------------------------

    @cached_property
    def _matrices(self) -> tuple[Matrix, tuple[Expr, ...], Matrix, tuple[Expr, ...]]:
        return self.kinematical.matrices()

    @property
    def Y(self) -> Matrix:
        """Y of u = Y q̇ + z."""
        return self._matrices[0]

    @property
    def z(self) -> tuple[Expr, ...]:
        """z of u = Y q̇ + z."""
        return self._matrices[1]

    @property
    def W(self) -> Matrix:
        """W = Y⁻¹ of q̇ = W u + X."""
        return self._matrices[2]

    @property
    def X(self) -> tuple[Expr, ...]:
        """X of q̇ = W u + X."""
        return self._matrices[3]

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The frames of the system."""
        return self.system.frames

    @property
    def points(self) -> tuple[Point, ...]:
        """The points of the system."""
        return self.system.points

    @cached_property
    def angular_velocities(self) -> Mapping[Frame, Vector]:
        """ω of each frame in the inertial frame, in speeds."""
        return Table(self.frames, lambda f: velocity_form(self.kinematics.frame(f)))

    @cached_property
    def velocities(self) -> Mapping[Point, Vector]:
        """v of each point in the inertial frame, in speeds."""
        return Table(self.points, lambda p: velocity_form(self.kinematics.point(p)))

    @cached_property
    def angular_accelerations(self) -> Mapping[Frame, Vector]:
        """α of each frame, in speeds and u̇."""
        return Table(self.frames, lambda f: acceleration_form(self.kinematics.frame(f)))

    @cached_property
    def point_accelerations(self) -> Mapping[Point, Vector]:
        """a of each point, in speeds and u̇."""
        return Table(self.points, lambda p: acceleration_form(self.kinematics.point(p)))

    @cached_property
    def partial_angular_velocities(self) -> Mapping[Frame, Mapping[Expr, Vector]]:
        """ω_r of each frame for each speed, auxiliary ones too."""
        return Table(self.frames, lambda f: self._partials(self.kinematics.frame(f)))

    @cached_property
    def partial_velocities(self) -> Mapping[Point, Mapping[Expr, Vector]]:
        """v_r of each point for each speed, auxiliary ones too."""
        return Table(self.points, lambda p: self._partials(self.kinematics.point(p)))

    def _partials(self, motion: Motion) -> Mapping[Expr, Vector]:
        return Table((*self.speeds, *self.auxiliary_speeds), lambda s: motion.partials.get(s, Vector()))

    # Steps 5 to 7: generalized forces ------------------------------------------------------------------------------------

    @property
    def all_speeds(self) -> tuple[Expr, ...]:
        """Generalized speeds, then auxiliary ones: the rows of Fr and Fr_star."""
        return (*self.speeds, *self.auxiliary_speeds)

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """The loads in speeds, gravity written out as one force a body."""
        return loads_in_speeds(self.system.all_loads(), self.kinematical)

    @cached_property
    def Fr_contributions(self) -> Mapping[tuple[Expr, Load], Expr]:
        """What each load contributes to each generalized active force."""
        keys = [(s, load) for s in self.all_speeds for load in self.loads]
        return Table(keys, lambda key: forces.active(self.kinematics, *key))

    @cached_property
    def Fr_star_contributions(self) -> Mapping[tuple[Expr, Any], Expr]:
        """What each body contributes to each generalized inertia force."""
        by_body = {b.body: b for b in self.bodies}
        keys = [(s, body) for s in self.all_speeds for body in by_body]
        return Table(keys, lambda key: forces.inertia(by_body[key[1]], key[0]))

    @cached_property
    def Fr(self) -> tuple[Expr, ...]:
        """Generalized active forces F_r; the auxiliary ones hold the reactions they bring into evidence."""
        return tuple(
            forces.sum_of([self.Fr_contributions[s, load] for load in self.loads])
            + forces.sum_of([self.pairs[s, r] * r for r in self.reactions if (s, r) in self.pairs])
            for s in self.all_speeds
        )

    @cached_property
    def Fr_star(self) -> tuple[Expr, ...]:
        """Generalized inertia forces F*_r, in u̇."""
        return tuple(
            forces.sum_of([self.Fr_star_contributions[s, b.body] for b in self.bodies]) for s in self.all_speeds
        )

    def contributions(self, speed: Expr) -> Contributions:
        """The terms of F_r and F*_r for one speed: each force and body with the partial velocity it meets."""
        return contributions(self, speed)

    def mass_contributions(self, r: Expr, s: Expr) -> tuple[MassContribution, ...]:
        """What each body adds to M_rs; bodies that add nothing are left out."""
        return mass_contributions(self, r, s)

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """The seven steps of the method, each with its results."""
        return seven_steps(self)

    # Constraints ---------------------------------------------------------------------------------------------------------

    @property
    def A(self) -> Matrix:
        """A of the constraints A u + b = 0, a row for each of `system.constraints`."""
        return Matrix(self.constraints.a, (len(self.constraints.a), len(self.speeds)))

    @property
    def b(self) -> tuple[Expr, ...]:
        """b of the constraints A u + b = 0."""
        return self.constraints.b

    @property
    def dependent_speeds(self) -> tuple[Speed, ...]:
        """u_D, the speeds that the constraints give."""
        return tuple(self.speeds[i] for i in self.embedding.partition.dependent) if self.embedding else ()

    @property
    def independent_speeds(self) -> tuple[Speed, ...]:
        """u_I, as many as there are degrees of freedom."""
        return tuple(self.speeds[i] for i in self.embedding.independent) if self.embedding else self.speeds

    @property
    def A_n(self) -> Matrix:
        """A_n of u_D = A_n u_I + b_n."""
        return self.embedding.a_n if self.embedding else Matrix([], (0, len(self.speeds)))

    @property
    def b_n(self) -> tuple[Expr, ...]:
        """b_n of u_D = A_n u_I + b_n."""
        return self.embedding.b_n if self.embedding else ()

    @cached_property
    def pivots(self) -> tuple[Pivot, ...]:
        """What A_n and b_n are divided by, where it changes with the state, with the dependent speed that it gives."""
        return pivots(self)

    @property
    def redundant(self) -> tuple[Constraint, ...]:
        """Constraints that follow from the others, where they were compared; their multipliers are taken as zero."""
        chosen = self.embedding.partition.redundant if self.embedding else ()
        return tuple(self.constraints.constraints[r] for r in chosen)

    @cached_property
    def multipliers(self) -> Mapping[Constraint, Expr]:
        """λ of M u̇ = f + Aᵀ λ by constraint: the force or torque that holds it, in u̇ and reactions."""
        if self.embedding is None:
            return {}
        u_dot = [rate(u) for u in self.speeds]
        residual = [sub(dot(row, u_dot), f) for row, f in zip(self.blocks.mass, self.forcing, strict=True)]
        return dict(
            zip(
                self.constraints.constraints,
                multipliers(self.constraints, self.embedding.partition, residual),
                strict=True,
            )
        )

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
        return reaction(self, place, frame)

    def _nonholonomic(self, values: Sequence[Expr]) -> tuple[Expr, ...]:
        e, n = self.embedding, len(self.speeds)
        if e is None:
            return tuple(values)
        own = [values[d] for d in e.partition.dependent]
        free = [add(values[i], dot(column, own)) for i, column in zip(e.independent, e.a_n.T.rows, strict=True)]
        return (*free, *(add(v, dot(c, own)) for v, c in zip(values[n:], e.a_na.T.rows, strict=True)))

    @cached_property
    def Fr_nh(self) -> tuple[Expr, ...]:
        """Nonholonomic generalized active forces F̃_r = F_r + Σ_D A_n[D, r] F_D: of the independent, then the auxiliary speeds."""
        return self._nonholonomic(self.Fr)

    @cached_property
    def Fr_star_nh(self) -> tuple[Expr, ...]:
        """Nonholonomic generalized inertia forces F̃*_r."""
        return self._nonholonomic(self.Fr_star)

    # Energies and momenta ----------------------------------------------------------------------------------------------

    @cached_property
    def kinetic_energy(self) -> Expr:
        """K = ½ Σ m v·v + ω·I·ω."""
        return energy.kinetic_energy(self.bodies)

    @cached_property
    def potential_energy(self) -> Expr:
        """V, the sum of the loads' potentials; gravity's is zero at the root point's height."""
        return forces.sum_of([load.potential for load in self.loads if load.potential is not None])

    @cached_property
    def energy(self) -> Expr:
        """E = K + V."""
        return self.kinetic_energy + self.potential_energy

    @cached_property
    def power(self) -> Expr:
        """P with dE/dt = P: the power of the loads without a potential and of prescribed motions."""
        return energy.power(self)

    def mass_center(self, origin: Point) -> Vector:
        """Position of the system's mass centre from `origin`."""
        return energy.mass_center(self.bodies, origin)

    def linear_momentum(self) -> Vector:
        """Σ m v."""
        return energy.linear_momentum(self.bodies)

    def angular_momentum(self, about: Point) -> Vector:
        """Σ I·ω + r × m v about a point fixed in the inertial frame."""
        return energy.angular_momentum(self.bodies, about)

    # Numbers --------------------------------------------------------------------------------------------------------------

    def time_derivative(self, e: Any) -> Expr:
        """de/dt along the motion: q̇ = W u + X, u̇ as the leaves u'."""
        known: dict[Expr, Expr] = dict(zip(self.coordinates, self.rates, strict=True))

        def leaf_rate(leaf: Expr) -> Expr:
            if isinstance(leaf, Time):
                return ONE
            if isinstance(leaf, Speed) or input_of(leaf) is not None:
                return rate(leaf)  # type: ignore[arg-type]  # a Speed, an Input or its rate
            if isinstance(leaf, Rate | Reaction):
                raise ExpressionError(
                    f"Expected an expression of coordinates, rates and speeds to differentiate along the motion, got {leaf} in it. "
                    "Differentiate a trajectory's values instead."
                )
            return known.get(leaf, ZERO)

        return tangent(self.in_speeds(e), leaf_rate)

    def in_speeds(self, e: Any) -> Expr:
        """The expression with every rate q̇ written in speeds, and every q̈ in u̇."""
        from kane.dynamics.readings.values import without_rates

        return without_rates(self, as_expr(e))

    def unit(self, e: Any) -> str:
        """The unit of an expression, such as "m/s^2", "" where it is unknown; a speed that declares none has its definition's."""
        return unit_in(self.system, as_expr(e))

    def evaluate(
        self,
        exprs: Any,
        *,
        q: Mapping[Any, Any] | Sequence[Any] | np.ndarray[Any, Any] | None = None,
        u: Mapping[Any, Any] | Sequence[Any] | np.ndarray[Any, Any] | None = None,
        parameters: Mapping[Any, Any] | None = None,
        inputs: Mapping[Any, Any] | None = None,
        t: Any = 0.0,
    ) -> Any:
        """Numbers of expressions, of a Matrix, or of one expression, at a state.

        Rates become W u + X, accelerations u̇ and reactions their solved values. Values may be arrays (they broadcast);
        parameters not given take their defaults.

        Raises
        ------
        SingularError
            if the values are divided by a pivot that vanishes at this state: the dependent speeds of `dependent_speeds` do not follow
            there. Of arrays a warning names the first such place, and the values there are NaN
        """
        return evaluate_along(self, exprs, q, u, parameters, inputs, t)

    def speeds_from_rates(
        self,
        q: Mapping[Any, Any] | Sequence[Any] | np.ndarray[Any, Any],
        rates: Mapping[Any, Any] | Sequence[Any] | np.ndarray[Any, Any],
        *,
        parameters: Mapping[Any, Any] | None = None,
        t: Any = 0.0,
    ) -> dict[Speed, Any]:
        """u = Y q̇ + z at numbers: the generalized speeds of a motion known by the rates of its coordinates."""
        return speeds_from_rates(self, q, rates, parameters, t)

    if TYPE_CHECKING:
        compile = compile

    def reaction_condition(self, **state: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Reciprocal condition number (2-norm) of the matrix that the reactions are solved from; 1 without reactions."""
        if not self.reactions:
            return np.ones(())
        return np.asarray(1.0 / np.linalg.cond(self.evaluate(self.solved.reaction_matrix, **state)))

    _repr_html_ = show.html

    def __repr__(self) -> str:
        return (
            f"Equations({', '.join(b.body.name for b in self.bodies)}: {len(self.coordinates)} coordinates, "
            f"{len(self.speeds)} speeds, {len(self.reactions)} reactions, {self.operations.total} operations)"
        )
