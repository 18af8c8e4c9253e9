# SPDX-License-Identifier: BSD-3-Clause
"""The record of a tree joint: a child frame and point, with the coordinates and speeds of their motion relative to the parent.

Every joint function takes the joint's name, the parent's point `at` and the parent frame, in this order; axes are unit vectors fixed
in the parent frame. With all coordinates zero the child frame has the parent's orientation. Coordinates and speeds given by name are
angles in rad, lengths in m, and their rates.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, TypedDict

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
        object.__setattr__(self, "child", self.child or self.name)

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
        several = isinstance(names, Iterable) and not isinstance(names, Expr)
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
