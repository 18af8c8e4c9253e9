# SPDX-License-Identifier: BSD-3-Clause
"""A system in the rates of its coordinates: motions of places, kinetic energy, generalized forces, constraints.

Nothing here comes from the kinematics in generalized speeds: velocities and accelerations are derivatives of positions and direction
cosines, so that methods in q̇ check those in u.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.equations import holds_reactions
from kane.dynamics.lazy import read
from kane.errors import ModelError
from kane.expr.build import add, mul
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, constant
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, rate
from kane.expr.visit import substituted
from kane.kinematics.speeds import twice_g
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.bodies import Part, parts_of
from kane.model.variables import constraint_rate
from kane.numeric.sampling import SEED, values_of
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Exprs = tuple[Expr, ...]
Partials = dict[Expr, Vector]


@dataclass(frozen=True, eq=False)
class LinearConstraints:
    """Constraints that do not follow from others, A q̇ + b = 0 (the `rates`) and A q̈ + `drift` = 0; `dependent` are given."""

    a: Matrix
    drift: Exprs
    dependent: tuple[int, ...]
    names: tuple[str, ...]
    rates: Exprs

    @cached_property
    def embedding(self) -> Embedding:
        """The dependent unknowns by the others, q̈_D = A_n q̈_I + c_D."""
        m = len(self.drift)
        nothing = Matrix([[]] * m, (m, 0))
        rows = ConstraintRows((), self.a, nothing, (ZERO,) * m, lambda: self.drift)
        return embedding(rows, Partition(tuple(range(m)), self.dependent, ()))


@dataclass(frozen=True, eq=False, repr=False)
class InRates(Immutable):
    """The system of `derived` in the rates of its coordinates, `partition` its constraints that do not follow from others."""

    derived: Derived
    partition: Partition | None

    def __post_init__(self) -> None:
        if holds_reactions(self.derived):
            raise ModelError(
                "Expected loads that hold no reaction, got friction or another one: methods that eliminate constraint forces from the "
                "start have no place for it. Kane's, with the reaction in evidence, solves for both: read eom itself."
            )

    coordinates = read[tuple[Coordinate, ...]](lambda s: s.derived.system.coordinates, "q.")
    rates = read[Exprs](lambda s: tuple(map(rate, s.coordinates)), "q̇.")
    accelerations = read[Exprs](lambda s: tuple(map(rate, s.rates)), "q̈.")
    parts = read[tuple[Part, ...]](lambda s: tuple(parts_of(s.derived.system.bodies)), "What has mass.")

    @read
    def quasi(self) -> dict[Expr, Expr]:
        """Measure numbers of ω along frames with Euler parameters, w = 2 G ė, and their derivatives, in ė and ë."""
        found: dict[Expr, Expr] = {}
        for s in self.derived.system.euler_parameters:
            for w, row in zip(s.quasi, twice_g(s.coordinates), strict=True):
                total = ZERO
                for c, e in zip(row, s.coordinates, strict=True):
                    total = add(total, mul(c, rate(e)))
                found[w], found[rate(w)] = total, time_derivative(total)
        return found

    def own(self, e: Expr) -> Expr:
        """An expression without quasi-rates."""
        return substituted(e, self.quasi) if self.quasi else e

    # Motions -------------------------------------------------------------------------------------------------------------

    def velocity(self, place: Point | Frame) -> Vector:
        """v of a point, ω of a frame."""
        base = self.derived.system.inertial
        v = place.velocity(base) if isinstance(place, Point) else place.angular_velocity(base)
        return v.map(self.own).gathered()

    def acceleration(self, place: Point | Frame) -> Vector:
        """a of a point, α of a frame."""
        base = self.derived.system.inertial
        a = place.acceleration(base) if isinstance(place, Point) else place.angular_acceleration(base)
        return a.map(self.own).gathered()

    def partials(self, v: Vector) -> Partials:
        """∂v/∂q̇ by rate, where it is not zero."""
        found: dict[Expr, Vector] = {}
        for frame, triple in v.parts:
            forms = [form for form, _ in affine_forms(triple, self.rates)]
            for s in dict.fromkeys(s for form in forms for s in form):
                x, y, z = (form.get(s, ZERO) for form in forms)
                share = Vector(((frame, (x, y, z)),))
                found[s] = found[s] + share if s in found else share
        return found

    # Energy and forces ---------------------------------------------------------------------------------------------------

    @read
    def kinetic_energy(self) -> Expr:
        """T(q, q̇) = ½ Σ m v·v + ω·I·ω."""
        twice = ZERO
        for part in self.parts:
            v = self.velocity(part.mass_center)
            for point, mass in momenta(part):
                twice = add(twice, mul(mass, v.dot(self.velocity(point))))
            if part.frame is not None and part.inertia is not None:
                w = self.velocity(part.frame).express(part.frame)
                twice = add(twice, w.dot(part.inertia.dot(w)))
        return mul(constant(0.5), twice)

    def inertia(self) -> Iterator[tuple[Point | Frame, Vector]]:
        """m a of mass centres, I·α + ω × I·ω of frames, in q̈."""
        for part in self.parts:
            yield part.mass_center, sum((self.acceleration(p) * mass for p, mass in momenta(part)), start=Vector())
            if part.frame is not None and part.inertia is not None:
                w, alpha = (v.express(part.frame) for v in (self.velocity(part.frame), self.acceleration(part.frame)))
                yield part.frame, part.inertia.dot(alpha) + w.cross(part.inertia.dot(w))

    def acting(self) -> Iterator[tuple[Point | Frame, Vector]]:
        """Forces with their points, torques with their frames; gravity's too."""
        for load in self.derived.system.all_loads():
            for point, force in load.forces:
                yield point, force.map(self.own)
            for frame, torque in load.torques:
                yield frame, torque.map(self.own)

    @read
    def forces(self) -> Exprs:
        """Q_s = Σ F·∂v/∂q̇_s + T·∂ω/∂q̇_s."""
        return self.power_by(self.acting())

    def power_by(self, forces: Iterator[tuple[Point | Frame, Vector]]) -> Exprs:
        """What forces at points and torques on frames do for each rate."""
        total = dict.fromkeys(self.rates, ZERO)
        for place, v in forces:
            for s, partial in self.partials(self.velocity(place)).items():
                total[s] = add(total[s], partial.dot(v))
        return tuple(total.values())

    # Constraints ---------------------------------------------------------------------------------------------------------

    @read
    def held(self) -> LinearConstraints | None:
        """The constraints, those of Euler parameters among them; None without any."""
        system, p = self.derived.system, self.partition
        every = self.derived.constraints.constraints
        given = [(every[r].name, self.own(constraint_rate(every[r]))) for r in (sorted(p.rows) if p else ())]
        for s in system.euler_parameters:
            unit = ZERO
            for e in s.coordinates:
                unit = add(unit, mul(e, rate(e)))
            given.append((f"unit length of {s.coordinates[0].name}, …", unit))
        if not given:
            return None
        forms = affine_forms([e for _, e in given], self.rates)
        a = Matrix([[form.get(s, ZERO) for s in self.rates] for form, _ in forms])
        changes = affine_forms([self.own(time_derivative(e)) for _, e in given], self.accelerations)
        known = self.derived.compared.at.at(0) if every else {}
        numbers = evaluate(a.entries, values_of(free_symbols(a.entries), SEED, known))
        places = choose(np.array(numbers, dtype=float).reshape(a.shape)).dependent
        return LinearConstraints(
            a, tuple(rest for _, rest in changes), tuple(places), *map(tuple, zip(*given, strict=True))
        )

    # The state in q and u ------------------------------------------------------------------------------------------------

    @read
    def by_speeds(self) -> dict[Expr, Expr]:
        """q̇ = W u + X."""
        return dict(zip(self.rates, self.derived.rates, strict=True))

    def speeds_rates(self, q_ddot: Sequence[Expr]) -> Exprs:
        """u̇ = d/dt (Y q̇ + z) in q and u, from q̈ in q and q̇."""
        values = dict(zip(self.accelerations, q_ddot, strict=True))
        memo: dict[Expr, Expr] = {}
        found = [
            substituted(self.own(time_derivative(definition)), values)
            for definition in self.derived.system.speeds.values()
        ]
        return tuple(substituted(e, self.by_speeds, memo) for e in found)


def momenta(part: Part) -> tuple[tuple[Point, Expr], ...]:
    """The momentum as Σ m v: points, each with its mass; of a flexible body those that share it."""
    return part.momenta or ((part.mass_center, part.mass),)
