# SPDX-License-Identifier: BSD-3-Clause
"""Reference frames, each with a parent and an orientation fixed at creation, and points: geometric points and particles of a frame."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from types import MappingProxyType
from typing import Any, NoReturn

import numpy as np

from kane import expect
from kane.errors import SpaceError, cut
from kane.expr.build import add, cos, mul, neg, sin, sub
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant, constant_value
from kane.expr.ops import Immutable, landmarks
from kane.expr.symbols import Coordinate, Parameter, QuasiRate
from kane.numeric.sampling import SEED, default_of, sample
from kane.numeric.scale import DECLARED, ROUNDED_CHAIN
from kane.space import attitude_formulas as formulas
from kane.space.rotation import (
    UNITS,
    Basis,
    Cosines,
    Orientation,
    Triple,
    about_axis,
    doubt_degrees,
    express,
    path,
    transposed,
)
from kane.space.vector import Vector, angular_velocity, axes, check_connected

_AXES = "xyz"


class Frame(Basis):
    """A reference frame with the right-handed unit vectors `x`, `y`, `z`.

    `Frame("N")` is a root frame; the `rotate…` methods of a frame make all others.
    """

    _other_names = MappingProxyType(
        {
            "rotate": "orient orient_axis orientnew",
            "rotate_body": "orient_body_fixed",
            "rotate_space": "orient_space_fixed",
            "dcm": "matrix rotation_matrix",
            "angular_velocity": "ang_vel_in omega",
            "angular_acceleration": "ang_acc_in alpha",
        }
    )

    __slots__ = ("x", "y", "z")

    parent: Frame | None
    lineage: tuple[Frame, ...]
    x: Vector
    y: Vector
    z: Vector

    def __init__(self, name: str) -> None:
        self._finish(name, None, None)

    def _finish(self, name: str, parent: Frame | None, orientation: Orientation | None) -> None:
        expect.name(name, "a name for the frame", error=SpaceError)
        values: dict[str, Any] = {"name": name, "parent": parent, "orientation": orientation, "_spins": {}}
        values["lineage"] = (self,) if orientation is None else (self, *orientation.base.lineage)
        values |= zip(_AXES, axes(self), strict=True)
        for slot, value in values.items():
            object.__setattr__(self, slot, value)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"The frame {self.name} is fixed: {name!r} cannot be set.")

    def __repr__(self) -> str:
        return f"Frame({self.name!r})" if self.parent is None else f"Frame({self.name!r}, in {self.parent.name})"

    def __reduce__(self) -> tuple[Callable[..., Frame], tuple[Any, ...]]:
        if self.parent is None:
            return Frame, (self.name,)
        return _restored, (landmarks(self), self.parent, self.name, self.orientation)

    def _child(self, name: str, orientation: Orientation) -> Frame:
        child: Frame = object.__new__(Frame)
        child._finish(name, self, orientation)
        return child

    # Birth ----------------------------------------------------------------------------------------------------------

    def rotate(self, name: str, angle: Any, axis: Vector, *, angular_velocity: Vector | None = None) -> Frame:
        """A frame turned from this one by `angle` (rad) about `axis`, a unit vector fixed in this frame.

        Successive rotations about the same basis axis are merged into one by the sum of the angles. The angular velocity follows from
        the angle; if `angular_velocity` is given, it is compared with it.

        Raises
        ------
        SpaceError
            if `axis` is not a unit vector fixed in this frame, or `angular_velocity` differs from that of the angle
        """
        child = self._rotated(name, angle, axis)
        if angular_velocity is not None:
            _check_angular_velocity(child, self, angular_velocity)
        return child

    def _rotated(self, name: str, angle: Any, axis: Vector) -> Frame:
        if isinstance(angle, Vector | list | str):
            raise SpaceError(
                f"Expected an angle by which {self.name} is turned, got {cut(repr(angle))}. The order is name, angle, axis; of three "
                "angles rotate_body(name, angles, sequence) makes a frame."
            )
        theta = as_expr(angle)
        direction = self._direction(axis)
        doubt_degrees(f"The frame {name}", [theta])
        for i in range(3):
            unit = direction[i]
            if all(x is ZERO for k, x in enumerate(direction) if k != i) and constant_value(unit) in (1, -1):
                return self._turned(name, theta if unit is ONE else neg(theta), i)
        rate = time_derivative(theta)
        cosines = turned_about(direction, cos(theta), sin(theta))
        rates = (mul(rate, direction[0]), mul(rate, direction[1]), mul(rate, direction[2]))
        return self._child(name, Orientation(self, rates, angle=theta, cosines=cosines, direction=direction))

    def _turned(self, name: str, theta: Expr, i: int) -> Frame:
        own = self.orientation
        base: Basis = self
        if own is not None and own.axis == i:
            assert own.angle is not None
            base, theta = own.base, add(own.angle, theta)
        return self._child(name, about_axis(base, i, theta))

    def _direction(self, axis: Vector) -> Triple:
        expect.instance(axis, Vector, f"a unit vector as axis, such as {self.name}.z", error=SpaceError)
        direction = axis.components(self)
        moving = [s for s in free_symbols(direction) if not isinstance(s, Parameter)]
        if moving:
            raise SpaceError(
                f"Expected an axis fixed in frame {self.name}, got {axis}: it depends on {', '.join(map(str, moving))}. "
                "Rotate about an axis of the parent, or start from the frame in which the axis is fixed."
            )
        square = default_of(dot(direction, direction))
        if square is not None:
            if square == 0:
                raise SpaceError(
                    f"Expected a unit vector as axis, got the zero vector. Take an axis of the frame, such as {self.name}.z; a cross "
                    "product of parallel vectors is zero."
                )
            if abs(square - 1) > ROUNDED_CHAIN:
                raise SpaceError(
                    f"Expected a unit vector as axis, got {axis} of length {square**0.5:.6g}. Use axis.normalized()."
                )
        return direction

    def rotate_body(self, name: str, angles: Sequence[Any], sequence: str) -> Frame:
        """A frame turned by three successive rotations (rad) about axes of the turning frame: "xyz", "zxz" or "123", "313", ….

        Kane & Levinson 1985, appendix I, "body-three" and "body-two" angles.
        """
        expect.name(name, "a name for the frame", error=SpaceError)
        frame = self
        for k, (angle, i) in enumerate(zip(angles, turning_axes(sequence, angles), strict=True)):
            last = k == 2
            frame = frame.rotate(name if last else name + "'" * (k + 1), angle, (frame.x, frame.y, frame.z)[i])
        return frame

    def rotate_space(self, name: str, angles: Sequence[Any], sequence: str) -> Frame:
        """A frame turned by three successive rotations (rad) about the axes of this frame: "xyz", "zxz" or "123", "313", ….

        Kane & Levinson 1985, appendix I, "space-three" and "space-two" angles.
        """
        turning_axes(sequence, angles)
        return self.rotate_body(name, tuple(reversed(tuple(angles))), sequence[::-1])

    def rotate_euler_parameters(self, name: str, parameters: Sequence[Coordinate]) -> Frame:
        """A frame oriented by Euler parameters (e0, e1, e2, e3), e0 the scalar one, with e0² + e1² + e2² + e3² = 1.

        Its angular velocity has three quasi-rates as measure numbers along the axes of the new frame; ė follows from them.
        """
        e = expect.items(parameters, f"four coordinates (e0, e1, e2, e3) for the frame {name}", error=SpaceError)
        if len(e) != 4 or not all(isinstance(x, Coordinate) for x in e) or len(set(e)) != 4:
            raise SpaceError(f"Expected four different coordinates (e0, e1, e2, e3), got {parameters!r}.")
        e0, e1, e2, e3 = e
        two, one = constant(2), ONE
        cosines: Cosines = (
            (one - two * (e2 * e2 + e3 * e3), two * (e1 * e2 - e0 * e3), two * (e1 * e3 + e0 * e2)),
            (two * (e1 * e2 + e0 * e3), one - two * (e1 * e1 + e3 * e3), two * (e2 * e3 - e0 * e1)),
            (two * (e1 * e3 - e0 * e2), two * (e2 * e3 + e0 * e1), one - two * (e1 * e1 + e2 * e2)),
        )
        quasi = tuple(QuasiRate.declare(f"w{k}({e0.name})", None, "rad/s", "", (*e, k)) for k in (1, 2, 3))
        rates: Triple = (quasi[0], quasi[1], quasi[2])
        return self._child(name, Orientation(self, rates, cosines=cosines, parameters=e, quasi=quasi))

    def rotate_rodrigues_parameters(self, name: str, parameters: Sequence[Any]) -> Frame:
        """A frame B oriented in this frame A by Rodrigues parameters ρ = λ tan θ/2, θ < π.

        Along the axes of B, ᴬω^B = 2 (ρ̇ + ρ̇ × ρ)/(1 + ρ²).

        Kane, Likins & Levinson 1983, *Spacecraft Dynamics*, sec. 1.4 and 1.14.
        """
        expect.name(name, "a name for the frame", error=SpaceError)
        rho = expect.items(parameters, f"three Rodrigues parameters for the frame {name}", error=SpaceError)
        if len(rho) != 3:
            raise SpaceError(f"Expected three Rodrigues parameters, got {cut(repr(parameters))}.")
        x, y, z = map(as_expr, rho)
        a, b, c = map(time_derivative, (x, y, z))
        cosines = formulas.cosines_of(np.array((ONE, x, y, z), dtype=object), unit=False)
        (p, q, r), (s, t, u), (v, w, k) = cosines
        factor = constant(2) / (ONE + x * x + y * y + z * z)
        rates = (factor * (a + b * z - c * y), factor * (b + c * x - a * z), factor * (c + a * y - b * x))
        return self._child(name, Orientation(self, rates, cosines=((p, q, r), (s, t, u), (v, w, k))))

    def rotate_matrix(self, name: str, cosines: Any) -> Frame:
        """A frame oriented by direction cosines: column j of `cosines` (3 × 3) is its j-th unit vector along the axes of this frame.

        The matrix must be orthogonal with determinant 1, which is checked at the defaults of its parameters where they have some.
        """
        expected = f"a 3 × 3 matrix of direction cosines for the frame {name}"
        listed = [
            expect.items(row, expected, error=SpaceError) for row in expect.items(cosines, expected, error=SpaceError)
        ]
        rows = [[as_expr(x) for x in row] for row in listed]
        if len(rows) != 3 or any(len(row) != 3 for row in rows):
            raise SpaceError(f"Expected a 3 × 3 matrix of direction cosines, got {len(rows)} rows.")
        a, b, c = ((row[0], row[1], row[2]) for row in rows)
        matrix: Cosines = (a, b, c)
        columns = transposed(matrix)
        _check_orthogonal(columns)
        x, y, z = ([time_derivative(e) for e in column] for column in columns)
        rates = (dot(y, columns[2]), dot(z, columns[0]), dot(x, columns[1]))
        return self._child(name, Orientation(self, rates, cosines=matrix))

    # Reading --------------------------------------------------------------------------------------------------------

    def dcm(self, other: Frame) -> Matrix:
        """Direction cosine matrix ᴬCᴮ of `other` = B in this frame A: v_A = ᴬCᴮ v_B."""
        check_connected(self, other, "a Frame")
        columns = [express(unit, other, self) for unit in UNITS]
        return Matrix(zip(*columns, strict=True))

    def angular_velocity(self, frame: Frame) -> Vector:
        """Angular velocity of this frame in `frame`, written in rates of coordinates."""
        check_connected(self, frame, "a Frame")
        return angular_velocity(self, frame)

    def angular_acceleration(self, frame: Frame) -> Vector:
        """Angular acceleration of this frame in `frame`, written in rates of coordinates and their derivatives."""
        return self.angular_velocity(frame).dt(frame)

    def simple_rotation(self, frame: Frame) -> tuple[Vector, Expr]:
        """Axis k and angle θ (rad) of the simple rotation of this frame in `frame`; its angular velocity is θ' k.

        Kane & Levinson 1985, sec. 1.2, 2.2.

        Raises
        ------
        SpaceError
            if the frames were not declared with an axis fixed in both: ω is then a sum of simple angular velocities (addition theorem)
        """
        check_connected(self, frame, "a Frame")
        up, down = path(frame, self)
        turning = [
            (o, way) for way, bases in ((-1, up), (1, down)) for b in bases if (o := b.orientation) and _turns(o)
        ]
        angles = [o.angle if way > 0 else neg(o.angle) for o, way in turning if o.angle is not None]
        if turning and len(angles) == len(turning) and len({(o.base, o.axis) for o, _ in turning}) == 1:
            (o, _), *others = turning
            if not others or o.axis is not None:  # two coaxial frames of one base
                x, y, z = UNITS[o.axis] if o.axis is not None else o.direction or UNITS[0]
                return Vector(((o.base, (x, y, z)),)), add(angles[0], angles[1]) if others else angles[0]
        names = ", ".join(b.name for b in (*up, *down) if b.orientation and _turns(b.orientation)) or "none"
        raise SpaceError(
            f"Expected one turn about an axis fixed in {self.name} and in {frame.name}, got those of {names}. The angular velocity is "
            f"a sum of simple ones: {self.name}.angular_velocity({frame.name})."
        )

    def root(self) -> Frame:
        """The frame at the root of the tree."""
        return self.lineage[-1]


def _restored(first: object, parent: Frame, name: str, orientation: Orientation) -> Frame:
    """A frame that was pickled, after the frames `first` of its line."""
    return parent._child(name, orientation)


def frames_of(v: Vector) -> tuple[Frame, ...]:
    """The frames along whose axes `v` is written."""
    return tuple(f for f, _ in v.parts if isinstance(f, Frame))


def _turns(o: Orientation) -> bool:
    """Whether the orientation changes with time or place."""
    return not is_constant_in_time(o.scalars())


def _check_angular_velocity(frame: Frame, base: Frame, claimed: Vector) -> None:
    """Raise a SpaceError unless an angular velocity is, at a random state, the one that follows from the orientation."""
    expect.instance(claimed, Vector, f"angular_velocity= of {frame.name} to be a Vector", error=SpaceError)
    own = frame.angular_velocity(base)
    numbers = sample([*own.components(base), *claimed.components(base)], SEED)
    if not np.allclose(numbers[:3], numbers[3:], rtol=DECLARED, atol=DECLARED * max(map(abs, numbers)), equal_nan=True):
        raise SpaceError(
            f"Expected the angular velocity of {frame.name} in {base.name} that its orientation gives, {cut(own)}, got "
            f"{cut(claimed)}. Correct its sign or the angle, or leave it out: it follows from the angle."
        )


def turning_axes(sequence: str, angles: Sequence[Any]) -> tuple[int, int, int]:
    """The numbers of the axes that a sequence names, for three angles."""
    expect.instance(sequence, str, 'a sequence of three axes, such as "zxz" or "123"', error=SpaceError)
    expect.instance(angles, Sequence, f"three angles for the sequence {sequence!r}", error=SpaceError)
    text = sequence.lower()
    for digit, letter in zip("123", _AXES, strict=True):
        text = text.replace(digit, letter)
    good = len(text) == 3 and set(text) <= set(_AXES) and text[0] != text[1] != text[2]
    if not good:
        raise SpaceError(f'Expected three axes, neighbours different, such as "zxz" or "123", got {sequence!r}.')
    if len(angles) != 3:
        raise SpaceError(f"Expected three angles for the sequence {sequence!r}, got {len(angles)}.")
    a, b, c = map(_AXES.index, text)
    return a, b, c


def turned_about(n: Triple, c: Expr, s: Expr) -> Cosines:
    """C = c 1 + (1 − c) n nᵀ + s [n×]."""
    k = sub(ONE, c)
    rows = [[mul(mul(n[i], n[j]), k) for j in range(3)] for i in range(3)]
    for i in range(3):
        rows[i][i] = add(rows[i][i], c)
        j, m = (i + 1) % 3, (i + 2) % 3
        rows[m][j] = add(rows[m][j], mul(n[i], s))
        rows[j][m] = sub(rows[j][m], mul(n[i], s))
    a, b, d = ((row[0], row[1], row[2]) for row in rows)
    return (a, b, d)


def _check_orthogonal(columns: Cosines) -> None:
    symbols = free_symbols(x for column in columns for x in column)
    if any(isinstance(s, Parameter) and s.default is None for s in symbols):
        return
    c = np.array([sample(column, SEED) for column in columns])
    if not np.all(np.isfinite(c)):
        return
    products = c @ c.T
    off = np.argwhere(np.triu(np.abs(products - np.eye(3)) > DECLARED))
    if off.size:
        i, j = off[0]
        raise SpaceError(
            f"Expected orthogonal unit columns of direction cosines, got column {i + 1} · column {j + 1} = {products[i, j]:.6g}."
        )
    if np.linalg.det(c) < 0:
        raise SpaceError("Expected a right-handed set of direction cosines, got determinant −1: swap two columns.")


# Points --------------------------------------------------------------------------------------------------------------


class Point(Immutable):
    """A point, fixed in a root frame or placed relative to another point.

    `Point("O", fixed_in=N)` is fixed in a root frame N; the methods `at` and `fixed_in` of a point make all others.

    `O.at("P", r)` is a geometric point at r from O. `X.fixed_in(B, "Q", r)` is the particle of B that coincides with X + r now.
    """

    _other_names = MappingProxyType(
        {"at": "locate locatenew set_pos", "position": "pos_from", "velocity": "vel v", "acceleration": "acc a"}
    )

    __slots__ = ("__weakref__", "_known", "body", "frame", "name", "offset", "parent")

    name: str
    parent: Point | None
    offset: Vector
    frame: Frame
    body: Frame | None
    _known: dict[str, Vector]

    def __init__(self, name: str, fixed_in: Frame) -> None:
        expect.instance(fixed_in, Frame, f"Point({name!r}, fixed_in=frame)", error=SpaceError)
        if fixed_in.parent is not None:
            raise SpaceError(
                f"Expected a root frame to fix the point {name} in, got {fixed_in.name}, which is born in "
                f"{fixed_in.parent.name}. Fix a point in {fixed_in.root().name} and reach others from it with at(...)."
            )
        self._finish(name, None, Vector(), fixed_in, None)

    def _finish(self, name: str, parent: Point | None, offset: Vector, frame: Frame, body: Frame | None) -> None:
        expect.name(name, "a name for the point", error=SpaceError)
        known: dict[str, Vector] = {}
        own = {"name": name, "parent": parent, "offset": offset, "frame": frame, "body": body, "_known": known}
        for slot, value in own.items():
            object.__setattr__(self, slot, value)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"The point {self.name} is fixed: {name!r} cannot be set.")

    def __repr__(self) -> str:
        if self.parent is None:
            return f"Point({self.name!r}, fixed in {self.frame.name})"
        kind = f"particle of {self.body.name}, " if self.body is not None else ""
        return f"Point({self.name!r}, {kind}from {self.parent.name} by {self.offset})"

    def __reduce__(self) -> tuple[Callable[..., Point], tuple[Any, ...]]:
        if self.parent is None:
            return Point, (self.name, self.frame)
        return _restored_point, (landmarks(self), self.parent, self.name, self.offset, self.body)

    def _child(self, name: str, offset: object, body: Frame | None) -> Point:
        if self.body is not None:
            raise SpaceError(
                f"Expected a geometric point to build {name} on, got {self.name}, a particle of {self.body.name}: its velocity is not "
                f"the derivative of its position. Build {name} on {self.parent.name if self.parent else 'its parent'}."
            )
        if isinstance(offset, int) and offset == 0:
            offset = Vector()
        what = f"a Vector (or 0) as the position of {name} from {self.name}"
        r = expect.instance(offset, Vector, what, "Give it a direction: x*N.x.", error=SpaceError)
        for frame, _ in r.parts:
            check_connected(self.frame, frame)
        child: Point = object.__new__(Point)
        child._finish(name, self, r, self.frame, body)
        return child

    def at(self, name: str, offset: Vector | int) -> Point:
        """The geometric point at the position vector `offset` from this point; 0 stands for the zero vector."""
        return self._child(name, offset, None)

    def fixed_in(self, frame: Frame, name: str, offset: Vector | int = 0) -> Point:
        """The particle of `frame` that coincides now with the point at r = `offset` from this point.

        Its velocity is v + ω × r and its acceleration a + α × r + ω × (ω × r), with v and a those of this point, which must be fixed
        in `frame`. If r varies in `frame`, as at a contact, it is a different particle at every instant, and its acceleration is not
        the derivative of its velocity. Therefore no further point can be placed relative to a particle.
        """
        expect.instance(frame, Frame, "a frame in fixed_in(frame, name, offset)", error=SpaceError)
        check_connected(self.frame, frame)
        return self._child(name, offset, frame)

    def root(self) -> Point:
        """The point fixed in a root frame from which this point is placed, directly or by points between."""
        return self.ancestry()[-1]

    def ancestry(self, known: Container[Point] = ()) -> list[Point]:
        """The point, its parent, … up to the root, or short of the first that is `known`."""
        line: list[Point] = []
        p: Point | None = self
        while p is not None and p not in known:
            line.append(p)
            p = p.parent
        return line

    def position(self, origin: Point) -> Vector:
        """Position vector from `origin` to this point."""
        expect.instance(origin, Point, f"the point from which {self.name} is seen", error=SpaceError)
        mine, theirs = self.ancestry(), origin.ancestry()
        if mine[-1] is not theirs[-1]:
            raise SpaceError(
                f"Expected points of one tree, got {self.name} and {origin.name}, which have no common root."
            )
        while mine and theirs and mine[-1] is theirs[-1]:
            mine.pop()
            theirs.pop()
        total = sum((p.offset for p in reversed(mine)), start=Vector())
        for p in theirs:
            total = total - p.offset
        return total

    def velocity(self, frame: Frame, origin: Point | None = None) -> Vector:
        """Velocity of this point in `frame`, written in rates of coordinates.

        For a frame A other than the one in which the root point is fixed, give `origin`, a point Q fixed in A: the velocity is
        v − v^Q − ω^A × r with r from Q to this point (Kane & Levinson 1985, sec. 2.6, 2.8).
        """
        if origin is None:
            return self._recall("velocity", frame)
        if self._are_geometric(frame, origin):
            return self.position(origin).dt(frame)
        root = self.root().frame
        carried = frame.angular_velocity(root).cross(self.position(origin))
        return self.velocity(root) - origin.velocity(root) - carried

    def acceleration(self, frame: Frame, origin: Point | None = None) -> Vector:
        """Acceleration of this point in `frame`, written in rates of coordinates and their derivatives.

        For a frame A other than the one in which the root point is fixed, give `origin`, a point Q fixed in A: the acceleration is
        a − a^Q − α^A × r − ω^A × (ω^A × r) − 2 ω^A × v, with v the velocity in A and r from Q to this point.
        """
        if origin is None:
            return self._recall("acceleration", frame)
        if self._are_geometric(frame, origin):
            return self.position(origin).dt(frame).dt(frame)
        root, r = self.root().frame, self.position(origin)
        spin = frame.angular_velocity(root)
        carried = frame.angular_acceleration(root).cross(r) + spin.cross(spin.cross(r))
        coriolis = spin.cross(self.velocity(frame, origin)) * 2
        return self.acceleration(root) - origin.acceleration(root) - carried - coriolis

    def _are_geometric(self, frame: Frame, origin: Point) -> bool:
        """Whether neither this point nor the origin is a particle, whose velocity is not the derivative of its position."""
        expect.instance(frame, Frame, f"a frame in which {self.name} moves", error=SpaceError)
        expect.instance(origin, Point, f"a point fixed in {frame.name} as origin", error=SpaceError)
        check_connected(self.frame, frame)
        return self.body is None and origin.body is None

    def _recall(self, what: str, frame: Frame) -> Vector:
        expect.instance(frame, Frame, f"a frame in which to take the {what} of {self.name}", error=SpaceError)
        line = self.ancestry()
        root = line[-1]
        if frame is not root.frame:
            raise SpaceError(
                f"Expected the {what} of {self.name} in {root.frame.name}, where its root {root.name} is fixed, got frame "
                f"{frame.name}. In another frame it needs a point Q fixed there: {self.name}.{what}({frame.name}, Q)."
            )
        for p in reversed([p for p in line if what not in p._known]):
            start = p.parent._known[what] if p.parent is not None else Vector()
            p._known[what] = start + (p._velocity(frame) if what == "velocity" else p._acceleration(frame))
        return self._known[what]

    def _velocity(self, frame: Frame) -> Vector:
        """What the velocity is more than the parent's."""
        if self.body is not None:
            return self.body.angular_velocity(frame).cross(self.offset)
        return self.offset.dt(frame)

    def _acceleration(self, frame: Frame) -> Vector:
        """What the acceleration is more than the parent's."""
        if self.body is not None:
            spin, r = self.body.angular_velocity(frame), self.offset
            return self.body.angular_acceleration(frame).cross(r) + spin.cross(spin.cross(r))
        return self.offset.dt(frame).dt(frame)


def _restored_point(first: object, parent: Point, name: str, offset: Vector, body: Frame | None) -> Point:
    """A point that was pickled, after the points `first` of its line."""
    return parent.at(name, offset) if body is None else parent.fixed_in(body, name, offset)
