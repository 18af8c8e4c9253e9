# SPDX-License-Identifier: BSD-3-Clause
"""A system in q, q̇ and q̈: velocities, accelerations, kinetic energy, generalized forces and constraints.

Velocities and accelerations are time derivatives of positions and direction cosines, independent of the kinematics in generalized
speeds, so that methods in q̇ (Lagrange, Hamilton, …) check Kane's equations.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kane.dynamics.constraints.partition import Embedding, Partition, choose, embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import acting
from kane.dynamics.lazy import read
from kane.expr.build import add, mul, sub, sum_of
from kane.expr.differentiation import affine_forms, gradient, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr, Exprs, constant
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, rate
from kane.expr.visit import substituted, substituting
from kane.kinematics.links import partials_of
from kane.kinematics.speeds import twice_g
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.bodies import Part, parts_of
from kane.model.constraints import Constraint
from kane.model.declarations import constraint_rate
from kane.numeric.sampling import SEED, values_of
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


@dataclass(frozen=True, eq=False)
class LinearConstraints:
    """The nonredundant constraints A q̇ + b = 0 (`rates`) and A q̈ + `drift` = 0, with the coordinates that are `dependent`."""

    a: Matrix
    drift: Exprs
    dependent: tuple[int, ...]
    names: tuple[str, ...]
    rates: Exprs

    @cached_property
    def embedding(self) -> Embedding:
        """The dependent accelerations, q̈_D = A_n q̈_I + c_D."""
        m = len(self.drift)
        nothing = Matrix([[]] * m, (m, 0))
        rows = ConstraintRows((), self.a, nothing, (ZERO,) * m, lambda: self.drift)
        return embedding(rows, Partition(tuple(range(m)), self.dependent, ()))


@dataclass(frozen=True, eq=False, repr=False)
class InRates(Immutable):
    """The system of `derived` in q, q̇ and q̈; `partition` tells its nonredundant constraints."""

    derived: Derived
    partition: Partition | None = None

    coordinates = read[tuple[Coordinate, ...]](lambda s: s.derived.system.coordinates, "q.")
    rates = read[Exprs](lambda s: tuple(map(rate, s.coordinates)), "q̇.")
    accelerations = read[Exprs](lambda s: tuple(map(rate, s.rates)), "q̈.")
    parts = read[tuple[Part, ...]](lambda s: tuple(parts_of(s.derived.system.bodies)), "What has mass.")

    @read
    def quasi(self) -> dict[Expr, Expr]:
        """Measure numbers of ω along frames with Euler parameters, w = 2 G ė, and their derivatives, in ė and ë."""
        result: dict[Expr, Expr] = {}
        for s in self.derived.system.euler_parameters:
            for w, row in zip(s.quasi, twice_g(s.coordinates), strict=True):
                total = sum_of(mul(c, rate(e)) for c, e in zip(row, s.coordinates, strict=True))
                result[w], result[rate(w)] = total, time_derivative(total)
        return result

    @read
    def by_rates(self) -> dict[Expr, Expr]:
        """Substitutions of quasi-rates by ė, and of declared speeds, which loads may contain, by their definitions."""
        defined = self.derived.system.speeds.items()
        return {**self.quasi, **{u: substituted(e, self.quasi) for u, e in defined}}

    def own(self, e: Expr) -> Expr:
        """An expression in q and q̇."""
        return substituted(e, self.by_rates)

    # Motions -------------------------------------------------------------------------------------------------------------

    def declared_velocity(self, place: Point | Frame) -> Vector:
        """v of a point or ω of a frame, as declared."""
        base = self.derived.system.inertial
        return place.velocity(base) if isinstance(place, Point) else place.angular_velocity(base)

    def velocity(self, place: Point | Frame) -> Vector:
        """v of a point or ω of a frame, in q and q̇."""
        return self.declared_velocity(place).map(self.own).gathered()

    def velocity_at_any_length(self, place: Point | Frame) -> Vector:
        """v or ω valid for Euler parameters of any length: v of a point is the derivative of its position.

        Conservative forces are then derivatives of a potential for any length too. v of a particle of a body is as declared, since it
        is not the derivative of its position.
        """
        if not self.quasi or isinstance(place, Frame) or any(p.body is not None for p in place.ancestry()):
            return self.velocity(place)
        base = self.derived.system.inertial
        x, y, z = map(time_derivative, place.position(place.root()).components(base))
        return Vector(((base, (x, y, z)),))

    def acceleration(self, place: Point | Frame) -> Vector:
        """a of a point or α of a frame, in q, q̇ and q̈."""
        base = self.derived.system.inertial
        a = place.acceleration(base) if isinstance(place, Point) else place.angular_acceleration(base)
        return a.map(self.own).gathered()

    # Energy and forces ---------------------------------------------------------------------------------------------------

    kinetic_energy = read[Expr](
        lambda s: s._energy(lambda p: s.velocity(p) if isinstance(p, Point) else s.velocity(p).express(p)),
        "T(q, q̇) = ½ Σ m v·v + ω·I·ω.",
    )
    declared_kinetic_energy = read[Expr](
        lambda s: s.own(s._energy(s.declared_velocity)), "The same straight from where bodies are declared to be."
    )

    def _energy(self, velocity: Callable[[Point | Frame], Vector]) -> Expr:
        twice = ZERO
        for part in self.parts:
            v = velocity(part.mass_center)
            for point, mass in momenta(part):
                twice = add(twice, mul(mass, v.dot(velocity(point))))
            if part.frame is not None and part.inertia is not None:
                w = velocity(part.frame)
                twice = add(twice, w.dot(part.inertia.dot(w)))
        return mul(constant(0.5), twice)

    def lagrange_terms(self, energy: Expr) -> Exprs:
        """d/dt ∂T/∂q̇_s − ∂T/∂q_s."""
        n = len(self.rates)
        slopes = gradient(energy, (*self.rates, *self.coordinates))
        return tuple(sub(time_derivative(p), f) for p, f in zip(slopes[:n], slopes[n:], strict=True))

    def inertia(self) -> Iterator[tuple[Point | Frame, Vector]]:
        """m a of mass centres, I·α + ω × I·ω of frames, in q̈."""
        for part in self.parts:
            yield part.mass_center, sum((self.acceleration(p) * mass for p, mass in momenta(part)), start=Vector())
            if part.frame is not None and part.inertia is not None:
                w, alpha = (v.express(part.frame) for v in (self.velocity(part.frame), self.acceleration(part.frame)))
                yield part.frame, part.inertia.dot(alpha) + w.cross(part.inertia.dot(w))

    def acting(self) -> Iterator[tuple[Point | Frame, Vector]]:
        """Pairs (point, force) and (frame, torque) of loads and gravity."""
        return ((place, v.map(self.own)) for place, v in acting(self.derived.system.all_loads()))

    @read
    def forces(self) -> Exprs:
        """Q_s = Σ F·∂v/∂q̇_s + T·∂ω/∂q̇_s."""
        return self.power_by(self.acting())

    def power_by(
        self, forces: Iterable[tuple[Point | Frame, Vector]], velocity: Callable[[Point | Frame], Vector] | None = None
    ) -> Exprs:
        """Σ F·∂v/∂q̇_s + T·∂ω/∂q̇_s for each rate, with the velocities of `velocity`, by default those of the system."""
        total = dict.fromkeys(self.rates, ZERO)
        for place, v in forces:
            for s, partial in partials_of((velocity or self.velocity)(place), self.rates).items():
                total[s] = add(total[s], partial.dot(v))
        return tuple(total.values())

    # Constraints ---------------------------------------------------------------------------------------------------------

    @read
    def rows(self) -> Matrix:
        """C in C q̇ + c = 0, of all constraints; those of Euler parameters last."""
        return self._matrix(self._rates_held(self.derived.constraints.constraints))

    def _rates_held(self, constraints: Iterable[Constraint]) -> list[tuple[str, Expr]]:
        given = [(c.name, self.own(constraint_rate(c))) for c in constraints]
        for s in self.derived.system.euler_parameters:
            e = s.coordinates
            given.append((f"unit length of {e[0].name}, …", dot(e, tuple(map(rate, e)))))
        return given

    def _matrix(self, given: Sequence[tuple[str, Expr]]) -> Matrix:
        forms = affine_forms([e for _, e in given], self.rates)
        return Matrix([[form.get(s, ZERO) for s in self.rates] for form, _ in forms], (len(forms), len(self.rates)))

    @read
    def held(self) -> LinearConstraints | None:
        """The nonredundant constraints, including those of Euler parameters; None without any."""
        p, every = self.partition, self.derived.constraints.constraints
        given = self._rates_held([every[r] for r in (sorted(p.rows) if p else ())])
        if not given:
            return None
        a = self._matrix(given)
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
        found = (substituted(self.own(time_derivative(e)), values) for e in self.derived.system.speeds.values())
        return tuple(map(substituting(self.by_speeds), found))


def momenta(part: Part) -> tuple[tuple[Point, Expr], ...]:
    """Pairs (point, mass) whose Σ m v is the momentum of a part."""
    return part.momenta or ((part.mass_center, part.mass),)
