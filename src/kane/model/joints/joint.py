# SPDX-License-Identifier: BSD-3-Clause
"""Joints of the tree: a child frame and point, with the coordinates and speeds of their motion relative to the parent.

Every joint function takes the joint's name, the parent's point `at` and the parent frame, in this order; axes are unit vectors fixed
in the parent frame. With all coordinates zero the child frame has the parent's orientation. Coordinates and speeds given by name are
angles in rad, lengths in m, and their rates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, TypedDict, Unpack

from kane import expect
from kane.errors import ModelError, UnitError, cut
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Speed, Symbol, rate
from kane.expr.symbols import names as _names
from kane.model.constraints import check_unit
from kane.numeric.sampling import SEED, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point
from kane.space.vector import Vector
from kane.units.rules import parse, unit_of

Names = str | Coordinate | Sequence[str | Coordinate] | None
SpeedNames = str | Speed | Sequence[str | Speed] | Mapping[Speed, Any] | None


class JointNames(TypedDict, total=False):
    """Names of a joint's child frame, coordinates and speeds, by default derived from the joint's name."""

    child: str
    coordinates: Names
    speeds: SpeedNames


class Twist(NamedTuple):
    """A relative motion of the child: unit `rotation`, and unit `translation` of its joint point, as seen from the parent frame."""

    rotation: Vector
    translation: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Joint(Immutable):
    """A joint between a parent and a child, from `kn.pin`, `kn.slider`, ….

    `frame` and `point` are the child's, for its body to be declared with; `parent` and `at` are the parent's frame and point.
    `coordinates` are the joint's symbols. `speeds` maps each of its generalized speeds to its definition, for `speeds=` of a System:
    `{**hinge.speeds, **slider.speeds}`. `free` holds the relative motions (twists) that the joint allows; the force and torque that
    it transmits do no work on them. `named` are the coordinates and speeds whose units the joint chose.
    """

    _other_names = MappingProxyType(
        {
            "coordinates": "q angle position",
            "speeds": "u rate",
            "frame": "child child_frame child_interframe",
            "parent": "parent_frame parent_interframe",
            "point": "child_point",
            "at": "parent_point",
        }
    )

    name: str
    kind: str
    at: Point
    parent: Frame
    point: Point
    frame: Frame
    coordinates: tuple[Coordinate, ...]
    speeds: Mapping[Speed, Expr]
    axes: tuple[Vector, ...]
    free: tuple[Twist, ...]
    named: frozenset[Symbol] = frozenset()

    @property
    def axis(self) -> Vector:
        """The axis of the joint, a unit vector; the first of several."""
        if not self.axes:
            raise ModelError(f"Expected a joint with an axis, got {self.name!r}, a {self.kind} joint, which has none.")
        return self.axes[0]

    @property
    def angular_velocity(self) -> Vector:
        """Angular velocity of the child frame in the parent frame, written in rates of coordinates."""
        return self.frame.angular_velocity(self.parent)

    @property
    def velocity(self) -> Vector:
        """Velocity of the child's joint point in the parent frame, written in rates of coordinates."""
        return self.point.position(self.at).dt(self.parent)

    def defined_by(self, definitions: Mapping[Speed, Expr]) -> bool:
        """Whether one of the definitions contains the rate of a coordinate of this joint."""
        o = self.frame.orientation
        own = {rate(q) for q in self.coordinates} | set(o.quasi if o is not None else ())
        return any(s in own for s in free_symbols(definitions.values()))

    def __repr__(self) -> str:
        moves = ", ".join(map(str, self.coordinates)) or "none"
        return f"Joint({self.name!r}: {self.kind}, {self.parent.name} to {self.frame.name}; coordinates {moves})"


@dataclass(frozen=True, eq=False)
class Seat:
    """The place of a joint, and the names of its child, coordinates and speeds; the child has the joint's name by default."""

    kind: str
    name: str
    at: Point
    parent: Frame
    child: str = ""
    coordinates: Names = None
    speeds: SpeedNames = None

    def __post_init__(self) -> None:
        check_attachment(self.name, self.at, self.parent)
        object.__setattr__(self, "child", expect.label(self.child, "a text as child=") or self.name)

    def axis(self, axis: Any, what: str = "axis") -> Vector:
        """A unit vector fixed in the parent, written along its axes."""
        return fixed(axis, self.parent, f"{what} of {self.name!r}")

    def symbols(self, **units: str) -> tuple[Coordinate, ...]:
        """The coordinates: symbols, names, or by default stems with the joint's name; with their units."""
        return _symbols(Coordinate, "coordinates", self.name, self.coordinates, tuple(units), tuple(units.values()))

    def turned(self, angle: Any, axis: Vector) -> Frame:
        """The child frame, rotated about an axis of the parent."""
        return self.parent.rotate(self.child, angle, axis)

    def joint(
        self,
        coordinates: Sequence[Coordinate],
        frame: Frame,
        offset: Vector | int = 0,
        *,
        axes: Sequence[Vector] = (),
        free: Sequence[Twist] = (),
        stems: Sequence[str] = ("u",),
        definitions: Sequence[Expr] | None = None,
    ) -> Joint:
        """The joint, with speeds by name, symbol or definition, by default the rates.

        The child's point is distinct from the parent's even if they coincide, so that the joint can be cut there.
        """
        definitions = [q.dt for q in coordinates] if definitions is None else definitions
        if isinstance(self.speeds, Mapping):
            own = {u: as_expr(e) for u, e in self.speeds.items()}
            named: Sequence[Symbol] = ()
        else:
            units = [_rate_unit(e) for e in definitions]
            symbols = _symbols(Speed, "speeds", self.name, self.speeds, stems, units)
            own = dict(zip(symbols, definitions, strict=True))
            named = _chosen(symbols, self.speeds)
        right = len(own) == len(definitions) and all(isinstance(u, Speed) for u in own)
        expected = f"{len(definitions)} definitions of speeds, by Speed, for the {self.kind} joint {self.name!r}"
        expect.that(right, expected, came=f"{len(own)}: {', '.join(map(str, own)) or 'none'}")
        point = self.at.at(f"{self.name} point", offset)
        unasked = frozenset((*_chosen(coordinates, self.coordinates), *named))
        return Joint(
            self.name, self.kind, self.at, self.parent, point, frame, tuple(coordinates), own, tuple(axes), tuple(free), unasked
        )  # fmt: skip


def check_attachment(name: Any, at: Any, parent: Any) -> None:
    """Raise ModelError unless a joint has a name, a geometric point and a frame."""
    expect.name(name, "a name for the joint")
    geometric = isinstance(at, Point) and at.body is None
    order = "The order is name, point, frame." if isinstance(at, Frame) or isinstance(parent, Point) else ""
    expect.that(geometric, f"at=geometric point of the parent for the joint {name!r}", at, order)
    expect.instance(parent, Frame, f"parent=frame for the joint {name!r}", order)


def fixed(axis: Any, frame: Frame, what: str) -> Vector:
    """`axis` written along the axes of `frame`; raises ModelError unless it is a unit vector fixed there."""
    check_unit(axis, what)
    v: Vector = axis.express(frame)
    if not is_constant_in_time(v.scalars()):
        raise ModelError(f"Expected the {what} fixed in {frame.name}, got {axis}, which turns in it.")
    return v


def _rate_unit(definition: Expr) -> str:
    """The unit of a speed, "" if a coordinate has none; ω is in rad/s in any form."""
    if isinstance(definition, Symbol):
        return definition.unit
    try:
        unit = unit_of(definition)
    except UnitError:  # the System reports it, with the place
        return ""
    return "rad/s" if unit and parse(unit) is parse("rad/s") else unit


def _chosen(symbols: Sequence[Symbol], names: Any) -> tuple[Symbol, ...]:
    """The symbols that were not given as symbols but by name."""
    own = {names} if isinstance(names, Symbol) else set() if isinstance(names, str) else set(names or ())
    return tuple(s for s in symbols if s not in own)


def _symbols(
    kind: type[Any], what: str, name: str, names: Any, stems: Sequence[str], units: Sequence[str]
) -> tuple[Any, ...]:
    count = len(units)
    if names is None:
        wanted: list[Any] = [f"{stem}_{'_'.join(name.split())}" for stem in stems[:count]]
    else:
        several = (expect.is_list(names) or isinstance(names, str)) and not isinstance(names, Expr)
        wanted = list(_names(names) if isinstance(names, str) else names) if several else [names]
    right = len(wanted) == count and all(isinstance(x, str | kind) for x in wanted) and len(set(wanted)) == count
    expected, cure = (
        f"{count} {what}, by name or symbol, for the joint {name!r}",
        "Left out, they are named after the joint.",
    )
    expect.that(right, expected, came=cut(repr(names), 80), cure=cure)
    return tuple(
        kind.declare(x, None, unit) if isinstance(x, str) else x for x, unit in zip(wanted, units, strict=True)
    )


def across(axis: Vector, frame: Frame) -> tuple[Vector, Vector]:
    """Two unit vectors fixed in `frame` that form a right-handed set with `axis`: e₁ × e₂ = axis."""
    basis = (frame.x, frame.y, frame.z)
    for k, e in enumerate(basis):
        after, last = basis[(k + 1) % 3], basis[(k + 2) % 3]
        if axis.cross(e).is_zero:
            return (after, last) if numbers([axis.dot(e)])[0] > 0 else (last, after)
    sizes = [abs(x) for x in numbers(axis.components(frame))]
    start = basis[sizes.index(min(sizes))]
    first = start.reject(axis).normalized().express(frame)
    return first, axis.cross(first).express(frame)


def numbers(exprs: Sequence[Expr]) -> list[float]:
    """Values at a random configuration, with default parameters."""
    return sample(exprs, SEED)


def perpendicular_axes(name: str, axes: Any, frame: Frame) -> tuple[Vector, Vector]:
    """Two perpendicular unit vectors, fixed in `frame`; raises ModelError otherwise."""
    both = expect.pair(axes, f"axes=two perpendicular unit vectors for {name!r}")
    first, second = (fixed(a, frame, f"axis of {name!r}") for a in both)
    product = first.dot(second)
    if product is not ZERO and abs(numbers([product])[0]) > DECLARED:
        raise ModelError(f"Expected perpendicular axes for the universal joint {name!r}, got {first} and {second}.")
    return first, second


def mirrored(v: Vector, frame: Frame, other: Frame) -> Vector:
    """The vector with the same measure numbers in the other frame."""
    return Vector(((other, v.components(frame)),))


_called = expect.keywords(*JointNames.__annotations__)


@_called
def pin(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A pin (revolute) joint: the child frame turns by an angle q about `axis` of the parent; u = q̇.

    Parameters
    ----------
    name : of the joint; unless given, the child frame, the coordinate (q_name) and the speed (u_name) are named after it
    at, parent : the joint's point and frame on the parent
    axis : unit vector fixed in the parent frame
    child : name of the child frame
    coordinates, speeds : names or symbols; for speeds also a mapping of each to its definition. Coordinates made from names are in
        rad or m, speeds in rad/s or m/s
    """
    s = Seat("pin", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), axes=[a], free=[Twist(a, Vector())])


@_called
def slider(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A slider (prismatic joint): the child slides by q along `axis` of the parent; u = q̇. Arguments as for `kn.pin`."""
    s = Seat("slider", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="m")
    return s.joint([q], s.turned(0, parent.x), a * q, axes=[a], free=[Twist(Vector(), a)])


@_called
def cylindrical(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A cylindrical joint: the child turns by q about `axis`, slides by s along it; u_q = q̇, u_s = ṡ. Arguments as for `kn.pin`."""
    seated = Seat("cylindrical", name, at, parent, **called)
    a = seated.axis(axis)
    q, s = seated.symbols(q="rad", s="m")
    free = [Twist(a, Vector()), Twist(Vector(), a)]
    return seated.joint([q, s], seated.turned(q, a), a * s, axes=[a], free=free, stems=("u_q", "u_s"))


@_called
def screw(name: str, at: Point, parent: Frame, *, axis: Vector, pitch: Any, **called: Unpack[JointNames]) -> Joint:
    """A screw joint: the child turns by q about `axis` and advances by `pitch`·q along it; u = q̇. Other arguments as for `kn.pin`.

    `pitch` is in m/rad, positive for a right-hand thread: a lead of l per turn is a pitch of l/(2π).
    """
    s = Seat("screw", name, at, parent, **called)
    a, h = s.axis(axis), as_expr(pitch)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), a * (h * q), axes=[a], free=[Twist(a, a * h)])


@_called
def planar(name: str, at: Point, parent: Frame, *, normal: Vector, **called: Unpack[JointNames]) -> Joint:
    """A planar joint: the child moves by x e₁ + y e₂ in the plane perpendicular to `normal`, and turns by q about it; u = (ẋ, ẏ, q̇).

    `normal` is a unit vector fixed in the parent frame. So are e₁ and e₂, with e₁ × e₂ = normal (x and y if normal is z);
    `joint.axes` is (normal, e₁, e₂). Other arguments as for `kn.pin`.
    """
    s = Seat("planar", name, at, parent, **called)
    n = s.axis(normal, "normal")
    e1, e2 = across(n, parent)
    x, y, q = s.symbols(x="m", y="m", q="rad")
    free = [Twist(Vector(), e1), Twist(Vector(), e2), Twist(n, Vector())]
    stems = ("u_x", "u_y", "u_q")
    return s.joint([x, y, q], s.turned(q, n), e1 * x + e2 * y, axes=[n, e1, e2], free=free, stems=stems)


@_called
def universal(
    name: str, at: Point, parent: Frame, *, axes: tuple[Vector, Vector], **called: Unpack[JointNames]
) -> Joint:
    """A universal (Cardan) joint: the child turns by q1 about an axis of the parent, then by q2 about an axis of the cross; u = q̇.

    `axes` are these two axes, perpendicular unit vectors given in the parent frame for q1 = 0; the second is fixed in the child
    too. The cross, without mass, is the frame `joint.frame.parent`. Other arguments as for `kn.pin`.
    """
    s = Seat("universal", name, at, parent, **called)
    first, second = perpendicular_axes(name, axes, parent)
    q1, q2 = s.symbols(q1="rad", q2="rad")
    cross = parent.rotate(f"{s.child}'", q1, first)
    turned = mirrored(second, parent, cross)
    free = [Twist(first, Vector()), Twist(turned, Vector())]
    frame = cross.rotate(s.child, q2, turned)
    return s.joint([q1, q2], frame, axes=[first, turned], free=free, stems=("u1", "u2"))


def weld(name: str, at: Point, parent: Frame, *, child: str = "") -> Joint:
    """A weld: a child frame fixed to the parent, without coordinates and speeds."""
    s = Seat("weld", name, at, parent, child)
    return s.joint([], s.turned(0, parent.x))


Orientation = Literal["euler parameters", "angles"]

_STEMS: dict[str, dict[str, str]] = {
    "euler parameters": dict.fromkeys(("e0", "e1", "e2", "e3"), "1"),
    "angles": dict.fromkeys(("q1", "q2", "q3"), "rad"),
}
"""Coordinates of each parametrization of orientation, with their units."""


def _turned(
    s: Seat, orientation: str, sequence: str, **lengths: str
) -> tuple[Frame, tuple[Coordinate, ...], list[Twist], list[Expr]]:
    """The child frame rotated by the coordinates before `lengths`; all coordinates, the free rotations, ω along the child's axes."""
    expect.one_of(orientation, _STEMS, f"orientation= of {s.name!r} to be")
    q = s.symbols(**_STEMS[orientation], **lengths)
    turning = q[: len(_STEMS[orientation])]
    if orientation == "angles":
        frame = s.parent.rotate_body(s.child, turning, sequence)
    else:
        frame = s.parent.rotate_euler_parameters(s.child, turning)
    w, axes = frame.angular_velocity(s.parent), (frame.x, frame.y, frame.z)
    return frame, q, [Twist(e, Vector()) for e in axes], [w.dot(e) for e in axes]


@_called
def ball(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    **called: Unpack[JointNames],
) -> Joint:
    """A ball joint; its speeds are the measure numbers of the child's angular velocity in the parent along the child's axes.

    `orientation` is "euler parameters" (e0, e1, e2, e3; e0 the scalar one) or "angles": three body-fixed ones (rad) about the axes
    of `sequence`, whose rates are singular in some orientation, while u and u̇ are not. Other arguments as for `kn.pin`.
    """
    s = Seat("ball", name, at, parent, **called)
    frame, q, free, spins = _turned(s, orientation, sequence)
    return s.joint(q, frame, free=free, stems=("u_x", "u_y", "u_z"), definitions=spins)


@_called
def free(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    velocity: Literal["child", "parent"] = "child",
    **called: Unpack[JointNames],
) -> Joint:
    """A joint with six degrees of freedom: the child's orientation as for `kn.ball`, and its position x, y, z along the parent's axes.

    Coordinates are those of orientation, then x, y, z. Speeds are the measure numbers of the child's angular velocity in the parent
    along the child's axes, then those of its joint point's velocity in the parent along the axes of the child or of the parent, as
    `velocity` says. Other arguments as for `kn.pin`.
    """
    s = Seat("free", name, at, parent, **called)
    expect.one_of(velocity, ("child", "parent"), f"velocity= of {name!r} to be")
    frame, q, free, spins = _turned(s, orientation, sequence, x="m", y="m", z="m")
    x, y, z = q[-3:]
    offset = parent.x * x + parent.y * y + parent.z * z
    along = frame if velocity == "child" else parent
    v = offset.dt(parent)
    spins += [v.dot(e) for e in (along.x, along.y, along.z)]
    free += [Twist(Vector(), e) for e in (along.x, along.y, along.z)]
    stems = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")
    return s.joint(q, frame, offset, free=free, stems=stems, definitions=spins)
