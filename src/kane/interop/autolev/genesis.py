# SPDX-License-Identifier: BSD-3-Clause
"""The methods of MotionGenesis, such as `B.RotateZ(A, q)`, `P.Translate(Q, r>)`, `B.GetAngularVelocity(N)`, in a table by name."""

import re
from collections.abc import Sequence
from typing import Any

from kane.expr.node import ZERO, Expr, constant_value
from kane.interop.autolev.commands import by_elements, kinematics, orient, turn
from kane.interop.autolev.evaluate import Call, FileReading, quantity
from kane.interop.autolev.functions import center, expression, frame_of, mass, output, point_of, scalars, word
from kane.interop.autolev.grammar import Line, bare
from kane.interop.autolev.sheet import FileTurn
from kane.interop.autolev.values import UNIT, Dyad, FileMatrix, Unread, Value, Vec, along, transposed

Args = Sequence[Any]
_SIMPLE = re.compile("(?:body|space)([xyz])", re.IGNORECASE)
_DONE = Unread("a method that gives no value")


def _rotate(axis: int, sign: int) -> Call:
    def call(r: FileReading, args: Args, line: Line) -> Value:
        b, a = frame_of(r, args[0], line), frame_of(r, args[1], line)
        angle = r.scalar(expression(args[2]), line)
        turn(r.sheet, a, b, UNIT[axis], angle * sign, line)
        r.sheet.spins[b, a] = r.sheet.spin(b, a)
        return _DONE

    return call


def _rotate_general(r: FileReading, args: Args, line: Line) -> Value:
    """B.Rotate(A, BodyXYZ, q1, q2, q3), B.Rotate(A, BodyX, q), B.SetRotationMatrix(A, axis>, q), B.SetRotationMatrix(A, matrix)."""
    simple = _SIMPLE.fullmatch(str(_token(args[2].children[0]))) if len(args) == 4 else None
    if simple:
        return _rotate("xyz".index(simple[1].lower()), 1)(r, (args[0], args[1], args[3]), line)
    b, a = frame_of(r, args[0], line), frame_of(r, args[1], line)
    if len(args) == 3:
        table = r.value(expression(args[2]), line)
        if not isinstance(table, FileMatrix) or [len(row) for row in table.rows] != [3, 3, 3]:
            raise line.refuse("a 3 × 3 matrix that orients", "another value")
        r.sheet.orient(FileTurn(a, b, transposed(scalars(table, line))))
    elif len(args) == 4:
        axis = r.vector(expression(args[2]), line)
        along_axis = axis.components(b if axis.frames() == (b,) else a)
        turn(r.sheet, a, b, along_axis, r.scalar(expression(args[3]), line), line)
    else:
        orient(r, a, b, word(args[2], line), [expression(x) for x in args[3:]], line)
    r.sheet.spins[b, a] = r.sheet.spin(b, a)
    return _DONE


def _rotation_ode(r: FileReading, args: Args, line: Line) -> Value:
    """B.SetRotationMatrixODE(A, Quaternion, e0, e1, e2, e3), or Poisson with nine elements: the orientation and its rates."""
    b, a, kind = frame_of(r, args[0], line), frame_of(r, args[1], line), word(args[2], line)
    if kind.startswith("poisson"):
        told = [r.scalar(expression(x), line) for x in args[3:]]
        by_elements(r, b, a, [told[k : k + 3] for k in range(0, len(told), 3)], line)
        return _DONE
    spin = r.sheet.spin(b, a)
    orient(r, a, b, kind, [expression(x) for x in args[3:]], line)
    r.sheet.spins[b, a] = spin
    kinematics(r.sheet, a, b, kind, [r.scalar(expression(x), line) for x in args[3:]], line)
    return _DONE


def _set(kind: str) -> Call:
    """B.SetAngularVelocity(A, w>), P.SetVelocity(A, v>), P.SetPosition(Q, r>), the position of P from Q."""

    def call(r: FileReading, args: Args, line: Line) -> Value:
        first, second = (frame_of if kind == "w" else point_of), (point_of if kind == "p" else frame_of)
        pair = first(r, args[0], line), second(r, args[1], line)
        r.sheet.place(kind, *(pair[::-1] if kind == "p" else pair), r.vector(expression(args[2]), line), line)
        return _DONE

    return call


def _translate(r: FileReading, args: Args, line: Line) -> Value:
    """P.Translate(Q, r>): the position, and the velocity as of a point fixed in P's body, or else the derivative of the position."""
    _set("p")(r, args, line)
    p, q = point_of(r, args[0], line), point_of(r, args[1], line)
    s, body = r.sheet, r.sheet.fixed.get(p)
    n = s.inertial
    together = body is not None and body != n and (s.fixed.get(q) == body or not p.endswith(("o", "cm")))
    if body is not None and together:
        s.velocities[p, n] = s.carried(n, body, q, p)
    else:
        s.velocities[p, n] = s.velocity(q, n) + s.dt(s.positions[q, p], n)
    return _DONE


def _defined(r: FileReading, arg: Any, line: Line) -> Expr:
    """A scalar, which may be defined in the argument: mA = 640 kg."""
    if arg.data != "named":
        tree = arg.children[0]
        token = _token(tree)
        if token is not None and str(token).lower() not in (*r.sheet.symbols, *r.sheet.values, "pi"):
            return r.sheet.parameter(str(token))
        value = quantity(r, tree, arg.children[1], line)
        return value if isinstance(value, Expr) else r.scalar(tree, line)
    return defined(r, str(_token(arg.children[0])), arg.children[2], arg.children[3], line)


def defined(r: FileReading, name: str, tree: Any, unit: Any, line: Line) -> Expr:
    """Defines, in the argument of a call, a constant with its value (mA = 10 kg) or a name for an expression (IA = mA*L^2/12)."""
    value = quantity(r, tree, unit, line)
    if not isinstance(value, Expr):
        raise line.refuse("a scalar for a constant that is defined in a call", "another value")
    number = constant_value(value)
    symbol = r.sheet.parameter(name, None if number is None else float(number))
    if number is not None:
        return symbol
    r.sheet.late[symbol] = r.sheet.values[name.lower()] = value
    return value


def _token(tree: Any) -> Any:
    """The name of which an expression consists, or None."""
    tree = bare(tree)
    return tree.children[0] if tree.data == "name" else None


def _set_mass(r: FileReading, args: Args, line: Line) -> Value:
    r.sheet.masses[word(args[0], line)] = _defined(r, args[1], line)
    return _DONE


def _set_inertia(r: FileReading, args: Args, line: Line) -> Value:
    """B.SetInertia(Bcm, frame, Ixx, Iyy, Izz, Ixy, Iyz, Izx); point and frame are optional, and a dyadic may replace the elements."""
    b, rest = frame_of(r, args[0], line), list(args[1:])
    point, frame = r.sheet.bodies.get(b, f"{b}cm"), b
    for known in (r.sheet.points, r.sheet.frames):
        token = _token(rest[0].children[0]) if rest and len(rest) % 3 and rest[0].data == "argument" else None
        if token is not None and str(token).lower() in known:
            name = str(token).lower()
            point, frame = (name, frame) if known is r.sheet.points else (point, name)
            rest = rest[1:]
    whole = r.value(expression(rest[0]), line) if len(rest) == 1 else None
    if isinstance(whole, Dyad):
        r.sheet.inertias[b] = (whole, point, line)
        return _DONE
    if len(rest) not in (3, 6):
        raise line.refuse("three or six measures of inertia", len(rest))
    values = [_defined(r, x, line) for x in rest]
    r.sheet.inertias[b] = (tensor(frame, values), point, line)
    return _DONE


def _set_mass_inertia(r: FileReading, args: Args, line: Line) -> Value:
    _set_mass(r, args[:2], line)
    return _set_inertia(r, [args[0], *args[2:]], line)


def tensor(frame: str, values: Sequence[Expr]) -> Dyad:
    """The dyadic with the elements 11, 22, 33, 12, 23, 31 along the axes of a frame."""
    a, b, c, d, e, f = (*values, ZERO, ZERO, ZERO)[:6]
    rows = ((a, d, f), (d, b, e), (f, e, c))
    return Dyad(tuple((along(frame, row), along(frame, unit)) for row, unit in zip(rows, UNIT, strict=True)))


def _add_load(what: str) -> Call:
    def call(r: FileReading, args: Args, line: Line) -> Value:
        names = r.sheet.points if what == "force" else r.sheet.frames
        loads = r.sheet.forces if what == "force" else r.sheet.torques
        on, vector = word(args[0], line), r.vector(expression(args[max(len(args) - 1, 1)]), line)
        for name in [on, *(word(x, line) for x in args[1:-1])]:
            if name not in names:
                raise line.refuse("a point of a force or a frame of a torque", name)
        if len(args) > 2:
            r.sheet.act(loads, on, word(args[1], line), vector, line)
        else:
            loads.append((on, vector, line))
        return vector

    return call


def _torque_damper(r: FileReading, args: Args, line: Line) -> Value:
    b, a = frame_of(r, args[0], line), frame_of(r, args[1], line)
    vector = r.sheet.spin(b, a).times(-r.scalar(expression(args[2]), line))
    r.sheet.act(r.sheet.torques, b, a, vector, line)
    return vector


def _force_spring(r: FileReading, args: Args, line: Line) -> Value:
    """P.AddForceSpring(Q, k, length, exponent): −k (|r| − length)^exponent along r from Q to P, and the reaction on Q."""
    s, p, q = r.sheet, point_of(r, args[0], line), point_of(r, args[1], line)
    k, length = (r.scalar(expression(args[n]), line) for n in (2, 3))
    power = [r.scalar(expression(x), line) for x in args[4:5]]
    apart = s.position(q, p)
    size = s.magnitude(apart)
    stretch = size - length
    return _between(r, p, q, apart.times(-k * (stretch ** power[0] if power else stretch) / size), line)


def _force_damper(r: FileReading, args: Args, line: Line) -> Value:
    """P.AddForceDamper(Q, b): −b times the rate of the distance, along the line between the points, and the reaction on Q."""
    s, p, q = r.sheet, point_of(r, args[0], line), point_of(r, args[1], line)
    apart = s.position(q, p)
    closing = s.dot(s.velocity(p, s.inertial) - s.velocity(q, s.inertial), apart)
    vector = apart.times(-r.scalar(expression(args[2]), line) * closing / s.dot(apart, apart))
    return _between(r, p, q, vector, line)


def _between(r: FileReading, p: str, q: str, vector: Vec, line: Line) -> Value:
    r.sheet.act(r.sheet.forces, p, q, vector, line)
    return vector


def _add_gravity(r: FileReading, args: Args, line: Line) -> Value:
    on = word(args[0], line)
    names = () if on == "system" else (on,)
    r.sheet.gravities.append((r.vector(expression(args[1]), line), names))
    return _DONE


def _get_rotation(r: FileReading, args: Args, line: Line) -> Value:
    """B.GetRotationMatrix(A): the elements b_i · a_j."""
    b, a = frame_of(r, args[0], line), frame_of(r, args[1], line)
    return (
        FileMatrix(r.sheet.cosines(b, a))
        if r.sheet.connected(a, b)
        else Unread("the orientation of a frame without one")
    )


def _get_mass(r: FileReading, args: Args, line: Line) -> Value:
    on = word(args[0], line)
    return mass(r.sheet, () if on == "system" else (on,))


_OUTPUTS = (
    "getdynamicskane getdynamics getstaticskane getstatics getkineticenergy getpower getgeneralizedmomentum "
    "getangularmomentum getmomentum getpotentialenergy getspecialangularmomentum getinertia getresultantforce "
    "geteffectiveforce getmomentofforce getacceleration getangularacceleration getcmvelocity getpartialvelocity "
    "getpartialangularvelocity getresultantmoment"
)
_PLACING = ("translate", "setpositionvelocity", "setpositionvelocityacceleration")
_AXES = {
    f"rotate{way}{letter}": _rotate(axis, sign)
    for axis, letter in enumerate("xyz")
    for way, sign in (("", 1), ("positive", 1), ("negative", -1))
}
MEMBERS: dict[str, Call] = {
    **_AXES,
    "rotate": _rotate_general, "setrotationmatrix": _rotate_general, "setrotationmatrixode": _rotation_ode,
    **dict.fromkeys(("setangularvelocityacceleration", "setangularvelocity"), _set("w")),
    "setposition": _set("p"), **dict.fromkeys(_PLACING, _translate),
    **dict.fromkeys(("setvelocityacceleration", "setvelocity"), _set("v")),
    "setmass": _set_mass, "setinertia": _set_inertia, "setmassinertia": _set_mass_inertia,
    "addforce": _add_load("force"), "addtorque": _add_load("torque"), "addforcegravity": _add_gravity,
    "addtorquedamper": _torque_damper, "addforcespring": _force_spring, "addforcedamper": _force_damper,
    "getangularvelocity": lambda r, args, line: r.sheet.spin(frame_of(r, args[0], line), frame_of(r, args[1], line)),
    "getvelocity": lambda r, args, line: r.sheet.velocity(point_of(r, args[0], line), frame_of(r, args[1], line)),
    "getposition": lambda r, args, line: r.sheet.position(point_of(r, args[1], line), point_of(r, args[0], line)),
    "getcmposition": lambda r, args, line: center(r.sheet, point_of(r, args[1], line), ()), "getmass": _get_mass,
    **dict.fromkeys(("getrotationmatrix", "getrotation"), _get_rotation),
    **{name: output(name) for name in _OUTPUTS.split()},
}  # fmt: skip
"""The implementation of each method."""
