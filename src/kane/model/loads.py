# SPDX-License-Identifier: BSD-3-Clause
"""Loads: forces on points, torques on frames, and pairs of them, such as springs and dampers.

A load is one record of forces, torques, and the potential energy from which it derives, if any. Loads with a potential do not count
as power in the power balance.
"""

from dataclasses import dataclass, replace
from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, QuasiRate, Rate, Reaction, Speed, input_of
from kane.model.bodies import Body
from kane.model.constraints import check_unit
from kane.numeric.sampling import not_negative
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_MOVING = Rate | QuasiRate | Speed | Reaction
_SIGN = "Check its sign, or the default; write what pushes away or feeds energy as a kn.loads.action_reaction or torque_pair."


@dataclass(frozen=True, slots=True, eq=False)
class Slip(Immutable):
    """The slip of a friction load: its `speed`, the `threshold` below which sliding ends, and the reactions that must be compressive.

    The speed is None if the load is also valid at rest; the threshold is None if it is a fraction of the largest slip. Below it the
    contact `rolls` if another particle of the body is in contact at every instant, and sticks otherwise. `size` is μ or the magnitude.
    """

    speed: Expr | None
    threshold: float | None = None
    presses: tuple[Reaction, ...] = ()
    rolls: bool = False
    size: Expr = ZERO


@dataclass(frozen=True, slots=True, eq=False)
class Load(Immutable):
    """A load: forces at points and torques on frames that belong together, perhaps with their potential energy.

    `slip` is the slip of a friction load. `scalar` is the function V or R of `from_potential` and `from_dissipation`, for which the
    `System` determines the forces.
    """

    name: str
    forces: tuple[tuple[Point, Vector], ...] = ()
    torques: tuple[tuple[Frame, Vector], ...] = ()
    potential: Expr | None = None
    slip: Slip | None = None
    scalar: Expr | None = None

    def __post_init__(self) -> None:
        expect.instance(self.name, str, "a text as the name of a load")
        if self.potential is not None:  # the potential of a spring between points at rest is a number
            object.__setattr__(self, "potential", as_expr(self.potential))

    @staticmethod
    def from_potential(V: Any, name: str = "potential") -> "Load":
        """The load whose generalized forces are F_r = −Σ_s ∂V/∂q_s W_sr (Kane & Levinson 1985, sec. 5.1).

        Parameters
        ----------
        V : the potential energy, an expression in coordinates, parameters, inputs and time. If it contains inputs that do not also
            prescribe a motion, whose rates are therefore unknown, the work of the load counts as power
        name : of the load

        Raises
        ------
        ModelError
            if V contains rates, speeds or reactions
        """
        potential = as_expr(V)
        found = [s for s in free_symbols([potential]) if isinstance(s, _MOVING) and input_of(s) is None]
        expected = "a potential energy of coordinates, parameters and time"
        cure = "Use Load.from_dissipation(R) for a function of rates or speeds."
        expect.that(not found, expected, came=lambda: f"{cut(potential)} with {found[0]}", cure=cure)
        return Load(name, potential=potential, scalar=potential)

    @staticmethod
    def from_dissipation(R: Any, name: str = "dissipation") -> "Load":
        """The load whose generalized forces are F_r = −∂R/∂u_r: Rayleigh dissipation (Kane & Levinson 1985, sec. 5.3).

        Parameters
        ----------
        R : the dissipation function, an expression in rates or speeds, and in coordinates if desired: c*q.dt**2/2 for a damper,
            c*w.dot(w)/2 for an angular velocity w
        name : of the load

        Raises
        ------
        ModelError
            if R contains neither rates nor speeds, or contains reactions
        """
        function = as_expr(R)
        own = free_symbols([function])
        moving = any(isinstance(s, QuasiRate | Speed) or isinstance(getattr(s, "place", None), Coordinate) for s in own)
        cure = "Write it by rates, as in c*q.dt**2/2; a function of coordinates alone is a potential: Load.from_potential(V)."
        expected = "a dissipation function of rates or speeds"
        expect.that(moving, expected, came=lambda: f"{cut(function)}, which contains none", cure=cure)
        alone, cure = not any(isinstance(s, Reaction) for s in own), "Declare friction with kn.friction."
        expect.that(alone, "a dissipation function without reactions", function, cure)
        return Load(name, scalar=function)

    def __repr__(self) -> str:
        return f"Load({self.name!r})"


@dataclass(frozen=True, slots=True, eq=False)
class Gravity(Immutable):
    """Uniform gravity: the acceleration of free fall, acting on every body of the system."""

    acceleration: Vector
    name: str = "gravity"


def _bound(name: str, what: str, vector: Any, *places: Any) -> Load:
    """A force at its point, or a torque on its frame, and the opposite one at a second place, if given."""
    kind: type[Point] | type[Frame] = Point if what == "force" else Frame
    for place in places:
        if not isinstance(place, kind):
            expected = f"a {what} on a {kind.__name__}"
            raise expect.refusal(ModelError, expected, cut(repr(place)), _instead(place, kind))
    cure = "Write it along axes of a frame: x*B.x + y*B.y + z*B.z."
    expect.instance(vector, Vector, f"a {what} as a Vector", cure)
    pairs, label = tuple(zip(places, (vector, -vector), strict=False)), " and ".join(x.name for x in places)
    label = expect.label(name) or f"{what} {'between' if len(places) > 1 else 'on'} {label}"
    return Load(label, forces=pairs) if kind is Point else Load(label, torques=pairs)


def _instead(item: Any, kind: type[Point] | type[Frame]) -> str:
    """Advice of a point or frame to take instead of a body, or of a point or frame of the wrong kind."""
    parts = item.parts() if isinstance(item, Body) else ()
    if kind is Point:
        if parts:
            place = parts[0].mass_center.name
            return f"Name the point of the body it acts on, such as its mass centre: kn.Force({place}, …)."
        if isinstance(item, Frame):
            return "Name a point of the body, such as its mass centre, or use kn.Torque for a torque on the frame."
        return "Make one with at(…), or with fixed_in(…) for a particle of a body."
    for part in parts:
        if part.frame is not None:
            return f"Name the body's frame: kn.Torque({part.frame.name}, …)."
    if isinstance(item, Point):
        return "Name the frame of a rigid body, or use kn.Force for a force at the point."
    return "Name the frame of a rigid body."


def _between(what: str, a: Any, b: Any, kind: type[Point] | type[Frame]) -> str:
    """“`what` between a and b”; raises ModelError unless both are of this kind."""
    expected = f"two of {kind.__name__} for the {what}"
    for x in (a, b):
        if not isinstance(x, kind):
            raise expect.refusal(ModelError, expected, cut(repr(x)), _instead(x, kind))
    if a is b:
        raise expect.refusal(ModelError, expected, f"{a.name} twice", "Name a different one for the other end.")
    return f"{what} between {a.name} and {b.name}"


def Force(point: Point, vector: Vector, name: str = "") -> Load:
    """A force (N) that acts at a point; for a force on a particle of a body, make the point with `fixed_in`."""
    return _bound(name, "force", vector, point)


def Torque(frame: Frame, vector: Vector, name: str = "") -> Load:
    """A torque (N m) that acts on the body whose frame is `frame`."""
    return _bound(name, "torque", vector, frame)


def gravity(acceleration: Vector, name: str = "gravity") -> Gravity:
    """Uniform gravity on every body of the system: `gravity(-g*N.z)` for the acceleration g of free fall along −N.z."""
    cure = "Give it a direction, downwards: -g*N.z where N.z points up."
    expect.instance(acceleration, Vector, "the acceleration of free fall as a Vector", cure)
    return Gravity(acceleration, expect.name(name, "a text as the name of gravity"))


def action_reaction(on: Point, from_: Point, force: Vector, name: str = "") -> Load:
    """A load of two forces: `force` at the point `on`, −`force` at the point `from_`."""
    return _bound(name, "force", force, on, from_)


def torque_pair(on: Frame, from_: Frame, torque: Vector, name: str = "") -> Load:
    """A load of two torques: `torque` on the frame `on`, −`torque` on `from_`, as of a motor between two links."""
    return _bound(name, "torque", torque, on, from_)


def linear_spring(a: Point, b: Point, stiffness: Any, free_length: Any = 0, name: str = "") -> Load:
    """Spring between two points: force k (|r| − l) towards each other, potential k (|r| − l)²/2.

    If the stiffness or free length depends on time, inputs or coordinates, the load has no potential, and its work counts as power.
    """
    k = not_negative(stiffness, f"a stiffness of the {_between('spring', a, b, Point)}", _SIGN)
    r, free = a.position(b), as_expr(free_length)
    _check_apart("spring", a, b, r)
    if free is ZERO:
        pull, potential = r * -k, k * r.dot(r) / 2
    else:
        length = r.magnitude()
        pull, potential = r * (-k * (length - free) / length), k * (length - free) ** 2 / 2
    spring = action_reaction(a, b, pull, name or f"spring between {a.name} and {b.name}")
    return replace(spring, potential=potential) if is_constant_in_time((k, free)) else spring


def _check_apart(what: str, a: Point, b: Point, r: Vector) -> None:
    came = f"{a.name} and {b.name} at the same position"
    expect.that(not r.is_zero, f"two points apart for a {what}", came=came, cure="Name another point.")


def linear_damper(a: Point, b: Point, damping: Any, name: str = "") -> Load:
    """Damper between two points: a force c d|r|/dt along their line that opposes the change of their distance |r|."""
    _between("damper", a, b, Point)
    r = a.position(b)
    _check_apart("damper", a, b, r)
    root, r = a.root().frame, r.gathered()
    # r·ṙ = |r| d|r|/dt has no root, and |r| cancels if r has a constant direction
    speed = (a.velocity(root) - b.velocity(root)).dot(r)
    pull = r * (-not_negative(damping, "a damping coefficient", _SIGN) * (speed / r.dot(r)))
    return action_reaction(a, b, pull, name or f"damper between {a.name} and {b.name}")


def torsional_spring(
    on: Frame, from_: Frame, angle: Any, stiffness: Any, axis: Vector, rest: Any = 0, name: str = ""
) -> Load:
    """Torsional spring: torque −k (angle − rest) about `axis` on `on`, the opposite on `from_`; potential k (angle − rest)²/2.

    `angle` (rad) is the rotation of `on` relative to `from_` about the unit vector `axis`, `rest` its value without torque.
    """
    check_unit(axis, _between("axis of the torsional spring", on, from_, Frame))
    k, stretch = not_negative(stiffness, "a stiffness", _SIGN), as_expr(angle) - as_expr(rest)
    torque = axis * (-k * stretch)
    spring = torque_pair(on, from_, torque, name or f"torsional spring between {on.name} and {from_.name}")
    return replace(spring, potential=k * stretch**2 / 2) if is_constant_in_time((k, as_expr(rest))) else spring


def torsional_damper(on: Frame, from_: Frame, damping: Any, axis: Vector, name: str = "") -> Load:
    """Torsional damper: a torque c times the relative angular speed of two frames about the unit vector `axis`, opposing it."""
    check_unit(axis, _between("axis of the torsional damper", on, from_, Frame))
    torque = axis * (-not_negative(damping, "a damping coefficient", _SIGN) * on.angular_velocity(from_).dot(axis))
    return torque_pair(on, from_, torque, name or f"torsional damper between {on.name} and {from_.name}")
