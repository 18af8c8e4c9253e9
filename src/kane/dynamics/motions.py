# SPDX-License-Identifier: BSD-3-Clause
"""Velocities, accelerations and partial velocities of frames and points in any frame, without bodies and loads.

    ᴬω^B = Σ ᴬω_r^B u_r + ᴬω_t^B,   ᴬv^P = Σ ᴬv_r^P u_r + ᴬv_t^P

Kane & Levinson 1985, ch. 2. In another frame A than the inertial one N: ᴬω^B = ᴺω^B − ᴺω^A, and, with a point Q fixed in A and r
from Q to P, ᴬv^P = ᴺv^P − ᴺv^Q − ᴺω^A × r; partial velocities likewise.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from kane import show
from kane.dynamics.constraints.partition import Embedding, Partition, embedding
from kane.dynamics.derivation import Derived, derived, first_partition
from kane.dynamics.lazy import read
from kane.dynamics.readings.quantities import without_rates
from kane.errors import SpaceError, SpeedsError, cut
from kane.expr.evaluation import free_symbols, price
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, Exprs, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Speed, Symbols
from kane.kinematics.velocities import Kinematics, Motion, acceleration_form, velocity_form
from kane.model.declarations import frames_and_points, geometry
from kane.model.system import placed, scaffold
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Partials = Mapping[Speed, Vector]


@dataclass(frozen=True, eq=False, repr=False)
class Motions(Immutable):
    """Velocities, accelerations and partial velocities of frames and points in generalized speeds, from `kn.analysis.motions`.

    Each method takes the frame or point, the frame A in which its motion is observed, `in_`, by default the inertial frame, and for
    points in a different frame A a point `origin` fixed in A. `independent` gives the same in the independent speeds.
    """

    derived: Derived
    embedding: Embedding | None
    nonholonomic: bool = False

    coordinates = read[Symbols[Coordinate]](lambda m: m.derived.system.coordinates, "q.")
    speeds = read[tuple[Speed, ...]](
        lambda m: m.independent_speeds if m.nonholonomic else m.derived.speeds, "The speeds u, or u_I."
    )
    rates = read[Exprs](lambda m: m.derived.rates, "q̇ = W u + X.")
    Y = Derived.Y.within("derived")
    z = Derived.z.within("derived")
    W = Derived.W.within("derived")
    X = Derived.X.within("derived")

    # Constraints ---------------------------------------------------------------------------------------------------------

    _embedded = read[Embedding](
        lambda m: m.embedding or embedding(m.derived.constraints, Partition((), (), ())),
        "Of nothing without constraints.",
    )
    A = Derived.A.within("derived")
    b = Derived.b.within("derived")
    dependent_speeds = read[tuple[Speed, ...]](
        lambda m: Symbols(m.derived.speeds[i] for i in m._embedded.partition.dependent), "The dependent speeds u_D."
    )
    independent_speeds = read[tuple[Speed, ...]](
        lambda m: Symbols(m.derived.speeds[i] for i in m._embedded.independent), "u_I."
    )
    degrees_of_freedom = read[int](
        lambda m: len(m.independent_speeds), "p = n − m: the number of speeds less that of independent constraints."
    )
    A_n = read[Matrix](lambda m: m._embedded.a_n, "A_n of u_D = A_n u_I + b_n.")
    b_n = read[Exprs](lambda m: m._embedded.b_n, "b_n of u_D = A_n u_I + b_n.")

    @read
    def independent(self) -> "Motions":
        """The same motions in the independent speeds, with nonholonomic partial velocities ṽ_r and ω̃_r (sec. 2.14)."""
        return Motions(self.derived, self.embedding, True)

    @read
    def _kinematics(self) -> Kinematics:
        whole = self.derived.as_declared.kinematics
        return whole.with_following(self._embedded.following(self.derived.speeds), {}) if self.nonholonomic else whole

    # Frames --------------------------------------------------------------------------------------------------------------

    def angular_velocity(self, frame: Frame, in_: Frame | None = None) -> Vector:
        """Angular velocity ᴬω^B of the frame B, in speeds."""
        return _short(self._relative(velocity_form, frame, in_))

    def partial_angular_velocities(self, frame: Frame, in_: Frame | None = None) -> Partials:
        """Partial angular velocities ᴬω_r^B of the frame B, by speed."""
        return self._by_speed(lambda u: self._relative(lambda m: m.partials.get(u, Vector()), frame, in_))

    def angular_acceleration(self, frame: Frame, in_: Frame | None = None) -> Vector:
        """Angular acceleration ᴬα^B = ᴺα^B − ᴺα^A − ᴺω^A × ᴬω^B, in speeds and u̇."""
        turned = self._relative(acceleration_form, frame, in_)
        if in_ is None:
            return _short(turned)
        spin = velocity_form(self._frame(in_))
        return _short(turned - spin.cross(self._relative(velocity_form, frame, in_)))

    # Points --------------------------------------------------------------------------------------------------------------

    def velocity(self, point: Point, in_: Frame | None = None, origin: Point | None = None) -> Vector:
        """Velocity ᴬv^P of the point P, in speeds."""
        return _short(self._shifted(velocity_form, point, in_, origin))

    def partial_velocities(self, point: Point, in_: Frame | None = None, origin: Point | None = None) -> Partials:
        """Partial velocities ᴬv_r^P of the point P, by speed."""
        return self._by_speed(lambda u: self._shifted(lambda m: m.partials.get(u, Vector()), point, in_, origin))

    def acceleration(self, point: Point, in_: Frame | None = None, origin: Point | None = None) -> Vector:
        """Acceleration ᴬa^P = ᴺa^P − ᴺa^Q − ᴺα^A × r − ᴺω^A × (ᴺω^A × r) − 2 ᴺω^A × ᴬv^P, in speeds and u̇."""
        shifted = self._shifted(acceleration_form, point, in_, origin)
        if in_ is None or origin is None:
            return _short(shifted)
        spin, r = velocity_form(self._frame(in_)), point.position(origin)
        v = self._shifted(velocity_form, point, in_, origin)
        return _short(shifted - spin.cross(spin.cross(r)) - spin.cross(v) * 2)

    # Expressions ---------------------------------------------------------------------------------------------------------

    def in_speeds(self, e: Any) -> Any:
        """An expression or vector with each rate q̇ written in speeds, and each q̈ in speeds and u̇."""
        if isinstance(e, Vector):
            found = iter(without_rates(self.derived, e.scalars()))
            return e.map(lambda _: next(found))
        return without_rates(self.derived, [as_expr(e)])[0]

    def _by_speed(self, vector: Callable[[Speed], Vector]) -> Partials:
        return MappingProxyType({u: _short(vector(u)) for u in self.speeds})

    def _relative(self, read_off: Callable[[Motion], Vector], frame: Frame, in_: Frame | None) -> Vector:
        own = read_off(self._frame(frame))
        return own if in_ is None else own - read_off(self._frame(in_))

    def _shifted(
        self, read_off: Callable[[Motion], Vector], point: Point, in_: Frame | None, origin: Point | None
    ) -> Vector:
        own = read_off(self._point(point))
        if in_ is None or in_ is self.derived.system.inertial:
            return own if origin is None else own - read_off(self._point(origin))
        turned = read_off(self._frame(in_))
        if origin is None:
            raise SpaceError(
                f"Expected a point fixed in {in_.name} as origin for the motion of {point.name}, got none. Pass it: origin=Q."
            )
        carried = turned.cross(point.position(origin))
        return own - read_off(self._point(origin)) - carried

    def _frame(self, frame: Frame) -> Motion:
        if not isinstance(frame, Frame):
            raise SpaceError(f"Expected a frame, got {cut(repr(frame))}.")
        self._check(frame)
        return self._kinematics.frame(frame)

    def _point(self, point: Point) -> Motion:
        if not isinstance(point, Point):
            raise SpaceError(f"Expected a point, got {cut(repr(point))}.")
        self._check(point)
        return self._kinematics.point(point)

    def _check(self, item: Frame | Point) -> None:
        """A SpeedsError where a place depends on a coordinate without a speed."""
        shape = geometry(*frames_and_points(self.derived.system.inertial, (), (placed([item]),), ()))
        strange = [q for q in free_symbols(shape) if isinstance(q, Coordinate) and q not in self.coordinates]
        if strange:
            own, others = (", ".join(map(str, qs)) for qs in (self.coordinates, strange))
            raise SpeedsError(
                f"Expected a point or frame that depends on {own}, got {item.name}, which depends on {others}. "
                f"Define a speed for each, or list it: kn.motions({self.derived.system.inertial.name}, …, of=[{item.name}])."
            )

    def __reduce__(self) -> "tuple[Callable[..., Motions], tuple[Any, ...]]":
        system = self.derived.system
        named = {
            "of": (*system.frames, *system.points),
            "holonomic": system.holonomic,
            "nonholonomic": system.nonholonomic,
            "dependent_speeds": self.dependent_speeds,
            "coordinates": system.coordinates,
            "near": self.derived.near,
        }
        return _restored, (system.frames, system.points, system.inertial, dict(system.speeds), named, self.nonholonomic)

    _repr_html_ = show.html

    def __repr__(self) -> str:
        return (
            f"Motions({show.counts(coordinates=len(self.coordinates))}, speeds {', '.join(map(str, self.speeds))}, "
            f"{self.degrees_of_freedom} degrees of freedom)"
        )


def _short(v: Vector) -> Vector:
    """The vector along one frame where that takes fewer operations: what cancels is gone there."""
    return min(v, v.gathered(), key=lambda w: (price(w.scalars()), sum(x is not ZERO for x in w.scalars())))


def motions(
    inertial: Frame,
    speeds: Mapping[Speed, Any] | str = "rates",
    *,
    of: Sequence[Frame | Point] = (),
    holonomic: Any = (),
    nonholonomic: Any = (),
    dependent_speeds: Sequence[Speed | str] = (),
    coordinates: Sequence[Coordinate | str] | None = None,
    near: Mapping[Any, Any] | None = None,
) -> Motions:
    """Velocities, accelerations and partial velocities of frames and points in generalized speeds; no body or load is needed.

    Parameters
    ----------
    inertial : the root frame
    speeds : mapping of each speed to its definition, affine in the rates, or "rates" for u = q̇ throughout
    of : frames and points whose coordinates do not occur in the definitions of speeds; with "rates", all frames and points of
        interest
    holonomic, nonholonomic : constraints, as for `kn.System`
    dependent_speeds : the speeds to solve the constraints for; by default chosen by rank
    coordinates : order of the coordinates
    near : approximate coordinates, if constraints have several branches, as for `kn.derive`

    Raises
    ------
    SpeedsError
        if the speeds do not determine the rates
    ModelError
        if a constraint is not affine in the rates, or restricts no motion
    """
    system = scaffold(inertial, speeds, of, holonomic, nonholonomic, dependent_speeds, coordinates)
    parts = derived(system, near)
    partition = first_partition(parts)
    return Motions(parts, None if partition is None else embedding(parts.constraints, partition))


def _restored(
    frames: object,
    points: object,
    inertial: Frame,
    speeds: dict[Speed, Expr],
    named: dict[str, Any],
    nonholonomic: bool,
) -> Motions:
    """Motions that were pickled, after their frames and points, parents first."""
    found = motions(inertial, speeds, **named)
    return found.independent if nonholonomic else found
