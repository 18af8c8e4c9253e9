# SPDX-License-Identifier: BSD-3-Clause
"""A system from a robot's record: frames and points of its links, joints, loads, constraints, tendons, actuators and contacts.

Coordinates are named q_<joint>, speeds u_<joint>, inputs tau_<joint>, or as their actuators; parameters of a link are m_<link>,
c_x_<link>, …, I_xx_<link>, ….

A rotor (armature a) is the inertia of a massless disk that rotates by the joint value relative to the ground, with kinetic energy ½ a
q̇²; it does not couple to the motion of the links.
"""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from keyword import kwlist
from math import inf
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from kane import expect
from kane.equations.state import State, guess
from kane.errors import ModelError, cut, listed_warnings, warn
from kane.expr import operators
from kane.expr.build import sum_of
from kane.expr.differentiation import time_derivative
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Input, Parameter, Speed, StateVariable
from kane.interop.imported import FreeNames, Imported, Remark, Remarks
from kane.interop.robots.records import DOFS, Actuation, Closure, Coupling, Move, Robot, RobotLink, Strand
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint, coincident, configuration_constraint
from kane.model.contacts import ContactLaw, rope, stiction, stop
from kane.model.joints.closing import close_weld
from kane.model.joints.joint import Joint, ball, free, pin, planar, slider
from kane.model.loads import Force, Gravity, Load, action_reaction, gravity, torque_pair
from kane.model.solids import inertia
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.scale import DECLARED, LAST_DIGIT, NO_SIZE
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Symbolic = Literal["none", "masses", "all"]
KINDS = ("none", "masses", "all")
LONGEST = 80
"""The number of characters of a name that are kept in an identifier."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of the import."""

    parameters: Symbolic = "all"
    stops: bool = False
    damping: bool = True
    friction: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Making:
    """The system under construction."""

    robot: Robot
    options: Options
    ground: Frame
    origin: Point
    frames: list[Frame] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    falling: list[Vector] = field(default_factory=list)
    carriers: dict[int, int] = field(default_factory=lambda: {-1: -1})
    remarks: Remarks = field(default_factory=Remarks)
    bodies: list[Any] = field(default_factory=list)
    joints: dict[str, Joint] = field(default_factory=dict)
    moves: dict[str, Move] = field(default_factory=dict)
    loads: list[Load | Gravity] = field(default_factory=list)
    efforts: dict[str, list[Expr]] = field(default_factory=dict)
    states: dict[StateVariable, Expr] = field(default_factory=dict)
    inputs: dict[str, Input] = field(default_factory=dict)
    holonomic: list[Constraint] = field(default_factory=list)
    contacts: list[ContactLaw] = field(default_factory=list)
    dependent: list[Coordinate] = field(default_factory=list)
    names: dict[str, FreeNames] = field(
        default_factory=lambda: {of: FreeNames(kwlist) for of in ("links", "joints", "symbols")}
    )
    called: dict[str, dict[str, str]] = field(default_factory=lambda: {"links": {}, "joints": {}, "inputs": {}})

    def placed(self, link: int) -> tuple[Frame, Point]:
        """The frame and origin of a link, or of the ground."""
        return (self.ground, self.origin) if link < 0 else (self.frames[link], self.points[link])

    def identifier(self, of: str, name: str, what: str, where: str = "") -> str:
        """A unique identifier among links, joints or symbols for the object `what` of this name; a remark notes a changed name."""
        result = self.names[of].identifier(name[:LONGEST], what)
        if result != name:
            self.remarks.say("inferred", f"{what} {cut(name)!r} is called {result}", where)
        return result

    def parameter(self, name: str, value: float, unit: str, what: str, kinds: tuple[str, ...] = ("all",)) -> Expr:
        """A number of the robot, as a parameter if the option `parameters` is in `kinds`; zero stays a constant."""
        if value == 0 or self.options.parameters not in kinds:
            return as_expr(float(value))
        return Parameter.declare(self.identifier("symbols", name, "parameter"), float(value), unit, what)

    def coordinate(self, joint: str) -> Coordinate:
        """The coordinate of a joint that has exactly one."""
        return self.joints[joint].coordinates[0]


def vector(frame: Frame, v: Array) -> Vector:
    """The vector with these measure numbers."""
    return frame.x * float(v[0]) + frame.y * float(v[1]) + frame.z * float(v[2])


def turned(frame: Frame, name: str, rotation: Array) -> Frame:
    """The frame rotated by direction cosines; `frame` itself for the identity."""
    if np.array_equal(rotation, np.eye(3)):
        return frame
    return frame.rotate_matrix(name, [[as_expr(float(x)) for x in row] for row in rotation])


def plain(rotation: Array) -> Array:
    """Direction cosines with exact zeros and ones."""
    r = np.where(np.abs(rotation) <= LAST_DIGIT, 0.0, rotation)
    return np.where(np.abs(np.abs(r) - 1) <= LAST_DIGIT, np.sign(r), r)


def on_joint(joint: Joint, effort: Any, name: str) -> Load:
    """A torque or force along the axis of a pin or slider, and its opposite on the parent."""
    if joint.kind == "pin":
        return torque_pair(joint.frame, joint.parent, joint.axis * effort, name)
    return action_reaction(joint.point, joint.at, joint.axis * effort, name)


UNITS = {"hinge": "N*m", "slide": "N"}


def add_link(made: Making, link: RobotLink) -> None:
    """Adds the frame, origin, joints and body of a link."""
    frame, point = made.placed(link.parent)
    name = made.identifier("links", link.name, "link", link.where)
    made.called["links"][link.name] = name
    offset = vector(frame, link.placement.offset)
    frame = turned(frame, f"{name} seat" if link.moves else name, link.placement.rotation)
    point = point if offset.is_zero else point.at(f"{name} seat" if link.moves else f"{name} origin", offset)
    for k, move in enumerate(link.moves, 1):
        frame, point = _add_move(made, move, frame, point, name if k == len(link.moves) else f"{name}_{k}")
    if link.moves:
        point = point.at(f"{name} origin", 0)
    made.carriers[len(made.frames)] = len(made.frames) if link.moves else made.carriers[link.parent]
    made.frames.append(frame)
    made.points.append(point)
    _add_body(made, link, name, frame, point)


def _add_body(made: Making, link: RobotLink, name: str, frame: Frame, point: Point) -> None:
    if float(np.abs(link.inertia).max()) <= NO_SIZE**2 * link.mass:
        link = replace(link, inertia=np.zeros((3, 3)))
    if link.mass == 0 and not link.inertia.any():
        return
    _check_numbers(link)
    mass = made.parameter(f"m_{name}", link.mass, "kg", f"mass of {name}", ("masses", "all"))
    axes = "xyz"
    c = [
        made.parameter(f"c_{a}_{name}", v, "m", f"mass centre of {name}")
        for a, v in zip(axes, link.center, strict=True)
    ]
    center = point.at(f"{name} center", frame.x * c[0] + frame.y * c[1] + frame.z * c[2])
    if link.buoyancy and made.falling:
        lift = made.falling[0] * (mass * -link.buoyancy)
        made.loads.append(Force(center, lift, f"gravity compensation of {name}"))
    if not link.inertia.any():
        made.bodies.append(Particle(name, center, mass))
        return
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    moments = [
        made.parameter(f"I_{axes[i]}{axes[j]}_{name}", link.inertia[i, j], "kg*m^2", f"central inertia of {name}")
        for i, j in pairs
    ]
    body = RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=inertia(frame, *moments))
    made.bodies.append(body)


def _check_numbers(link: RobotLink) -> None:
    """Raises if the mass or a principal moment of inertia is negative."""
    if link.mass < 0:
        raise expect.refusal(ModelError, f"a mass ≥ 0 of the link {link.name!r}", f"{link.mass:g} ({link.where})")
    low, middle, high = np.linalg.eigvalsh(link.inertia)
    if low < -DECLARED * high:
        came = f"{low:g}, {middle:g}, {high:g} ({link.where})"
        cure = "Check the signs: ixy is −∫ x y dm, and the moments are about the mass centre."
        raise expect.refusal(ModelError, f"principal moments of inertia ≥ 0 of the link {link.name!r}", came, cure)


def _add_move(made: Making, move: Move, frame: Frame, point: Point, child: str) -> tuple[Frame, Point]:
    """Adds a joint and its loads; returns the frame and origin of the child, those of the parent moved by the joint."""
    name = made.identifier("joints", move.name, "joint", move.where)
    anchor = vector(frame, move.anchor)
    at = point if anchor.is_zero else point.at(f"{name} anchor", anchor)
    axis = vector(frame, move.axis)
    if move.kind == "hinge":
        frame = frame.rotate(f"{name} seat", -move.reference, axis) if move.reference else frame
        axis = vector(frame, move.axis)
        joint = pin(name, at, frame, axis=axis, child=child)
    elif move.kind == "slide":
        at = at.at(f"{name} seat", axis * -move.reference) if move.reference else at
        joint = slider(name, at, frame, axis=axis, child=child)
    elif move.kind == "planar":
        joint = planar(name, at, frame, normal=axis, child=child)
    else:
        joint = {"ball": ball, "free": free}[move.kind](name, at, frame, child=child)
    for s in (*joint.coordinates, *joint.speeds):
        if made.identifier("symbols", s.name, "symbol") != s.name:
            came = f"{s.name} of {move.name!r} too ({move.where})"
            raise expect.refusal(ModelError, "names of joints that make symbols of different names", came, "Rename it.")
    made.joints[move.name], made.moves[move.name] = joint, move
    made.called["joints"][move.name] = name
    _load_joint(made, move, joint)
    if anchor.is_zero:
        return joint.frame, joint.point
    return joint.frame, joint.point.at(f"{child} back", vector(joint.frame, -move.anchor))


def _damping(joint: Joint, c: Expr) -> list[Load]:
    """Damping loads of a joint; for ball and free joints in terms of the speeds, along the child's axes."""
    turn, slide = joint.angular_velocity, joint.velocity
    if joint.kind in ("ball", "free"):
        u, axes = [*joint.speeds, ZERO, ZERO, ZERO], (joint.frame.x, joint.frame.y, joint.frame.z)
        turn, slide = (sum((e * x for e, x in zip(axes, part, strict=False)), Vector()) for part in (u[:3], u[3:6]))
    loads = [] if turn.is_zero else [torque_pair(joint.frame, joint.parent, turn * -c, f"damping of {joint.name}")]
    if not slide.is_zero:
        there = joint.point.position(joint.at)
        opposite = joint.at.fixed_in(joint.parent, f"{joint.name} rubbed", there)  # the parent's particle
        loads.append(action_reaction(joint.point, opposite, slide * -c, f"damping of the slide of {joint.name}"))
    return loads


def _load_joint(made: Making, move: Move, joint: Joint) -> None:
    """Adds effort, spring, damper, rotor, stops and dry friction of a joint."""
    name = joint.name
    if move.damping and made.options.damping:
        c = made.parameter(f"d_{name}", move.damping, "", f"damping of {name}")
        made.loads.extend(_damping(joint, c))
    if move.armature:
        _add_rotor(made, move, joint)
    if DOFS[move.kind] > 1:
        if move.friction and made.options.friction:
            made.remarks.say("refused", f"joint {move.name!r}: dry friction in a {move.kind} joint", move.where)
        return
    (q,) = joint.coordinates
    if move.effort:
        tau = Input.declare(f"tau_{name}", None, UNITS[move.kind], f"effort of {name}")
        made.inputs[tau.name] = tau
        made.called["inputs"][move.name] = tau.name
        made.loads.append(on_joint(joint, tau, f"effort of {name}"))
    if move.stiffness:
        k = made.parameter(f"k_{name}", move.stiffness, "", f"stiffness of {name}")
        made.loads.append(Load.from_potential(k * (q - move.rest) ** 2 / 2, f"spring of {name}"))
    if move.limits is not None and made.options.stops:
        low, high = move.limits
        made.contacts.extend([stop(f"{name} lower", q - low)] if np.isfinite(low) else [])
        made.contacts.extend([stop(f"{name} upper", high - q)] if np.isfinite(high) else [])
    if move.friction and made.options.friction:
        made.contacts.append(stiction(joint, move.friction))


def _add_rotor(made: Making, move: Move, joint: Joint) -> None:
    """Adds a body that contributes the armature a to the diagonal of M."""
    name = f"{joint.name} rotor"
    a = made.parameter(f"a_{joint.name}", move.armature, "", f"armature of {joint.name}")
    N, O = made.ground, made.origin
    if move.kind == "hinge":
        frame = N.rotate(name, joint.coordinates[0], N.z)
        made.bodies.append(RigidBody(name, frame=frame, mass_center=O, mass=0, inertia=inertia(frame, a / 2, a / 2, a)))
    elif move.kind == "slide":
        made.bodies.append(Particle(name, O.at(name, _level(made) * joint.coordinates[0]), a))
    elif move.kind == "ball":
        frame = N.rotate_euler_parameters(name, joint.coordinates)
        made.bodies.append(RigidBody(name, frame=frame, mass_center=O, mass=0, inertia=inertia(frame, a, a, a)))
    else:
        raise expect.refusal(
            ModelError, f"no armature of the {move.kind} joint {move.name!r}", f"{move.armature:g} ({move.where})"
        )


def _level(made: Making) -> Vector:
    """A unit vector perpendicular to gravity."""
    g = made.robot.gravity
    least = np.eye(3)[int(np.argmin(np.abs(g)))]
    across = np.cross(g, np.cross(least, g)) if g.any() else least
    return vector(made.ground, plain(across / np.linalg.norm(across)))


def add_gravity(made: Making) -> None:
    """Adds gravity, unless it is zero."""
    g = made.robot.gravity
    size = float(np.linalg.norm(g))
    if size:
        symbol = made.parameter("g", size, "m/s^2", "gravitational acceleration", ("masses", "all"))
        made.falling.append(vector(made.ground, plain(g / size)) * symbol)
        made.loads.append(gravity(made.falling[0]))


def built(robot: Robot, options: Options) -> Imported:
    """The system of a robot, with remarks.

    Raises
    ------
    ModelError
        if numbers are impossible for a body, or nothing moves
    """
    expect.one_of(options.parameters, KINDS, "parameters= to be")
    for name in ("stops", "damping", "friction"):
        expect.flag(getattr(options, name), f"{name}= to be True or False")
    ground = Frame("N")
    made = Making(robot, options, ground, Point("O", fixed_in=ground))
    with listed_warnings() as doubts:
        add_gravity(made)
        for link in robot.links:
            add_link(made, link)
        for closure in robot.closures:
            close(made, closure)
        strands = {s.name: strung(made, s) for s in robot.strands}
        for coupling in robot.couplings:
            couple(made, coupling, strands)
        for actuator in robot.drives:
            drive(made, actuator, strands)
        exert(made)
        if not made.joints:
            raise ModelError(f"Expected a joint that moves in {robot.name!r}, got none.")
        if not made.bodies:
            raise ModelError(f"Expected a link with mass in {robot.name!r}, got none.")
        system = System(
            ground,
            bodies=made.bodies,
            loads=made.loads,
            joints=list(made.joints.values()),
            holonomic=made.holonomic,
            dependent_coordinates=made.dependent,
            states=made.states,
            contacts=made.contacts,
        )
    return _imported(made, system, doubts)


def _imported(made: Making, system: System, doubts: list[str]) -> Imported:
    robot = made.robot
    remarks = (*robot.remarks, *made.remarks.all(), *(Remark("inferred", text) for text in doubts))
    refused = [r for r in remarks if r.kind == "refused"]
    if refused:
        warn(
            f"Expected all of {robot.name!r} to have counterparts in kane, got {len(refused)} without one, the first: {refused[0]}."
        )
    q = {c.name: c for c in system.coordinates}
    u: dict[str, Speed] = {s.name: s for s in system.speeds}
    parameters = {p.name: p for p in system.parameters}
    limits = {j: m.limits for j, m in made.moves.items() if m.limits is not None}
    extras = {
        **{what: MappingProxyType(names) for what, names in made.called.items()},
        "limits": MappingProxyType(limits),
        "shapes": robot.shapes,
        "start": _start(made, system),
        "places": MappingProxyType({link.name: made.placed(k) for k, link in enumerate(robot.links)}),
        **robot.extras,
    }
    states = {a.name: a for a in made.states}
    symbols = {**q, **u, **states, **made.inputs, **parameters}
    return Imported(
        system,
        MappingProxyType(symbols),
        MappingProxyType(q),
        MappingProxyType(u),
        MappingProxyType(parameters),
        remarks,
        MappingProxyType(extras),
    )


def _start(made: Making, system: System) -> State:
    """A start of motions: at rest, zero inputs, joints as declared or at the nearest limit; guesses if constraints involve them."""
    free: Callable[[float], Any] = guess if system.constraints else float
    at = dict.fromkeys(system.coordinates, 0.0) | {e.coordinates[0]: 1.0 for e in system.euler_parameters}
    for name, joint in made.joints.items():
        move = made.moves[name]
        if move.coordinates:
            at |= zip(joint.coordinates, move.coordinates, strict=True)
        elif len(joint.coordinates) == 1:
            low, high = move.limits or (-inf, inf)
            at[joint.coordinates[0]] = float(min(max(move.reference, low), high))
    return State(
        q={q: free(x) for q, x in at.items()},
        u={u: free(0.0) for u in system.speeds},
        states=dict.fromkeys(system.states, 0.0),
        inputs=dict.fromkeys(system.inputs, 0.0),
    )


class Strung(NamedTuple):
    """A tendon's length, and where its tension acts: pairs of points, and joints with their moment arms."""

    length: Expr
    ends: tuple[tuple[Point, Point], ...]
    arms: tuple[tuple[Joint, float], ...]
    on: Mapping[str, float]

    def effort(self, f: Expr, name: str) -> list[Load]:
        """The loads of a force f that lengthens it."""
        spans = [(q, p, q.position(p)) for p, q in self.ends]
        pushes = [action_reaction(q, p, r * (f / r.magnitude()), f"{name} {k}") for k, (q, p, r) in enumerate(spans, 1)]
        return [*pushes, *(on_joint(j, f * arm, f"{name} on {j.name}") for j, arm in self.arms)]


def couple(made: Making, c: Coupling, strands: Mapping[str, Strung]) -> None:
    """Adds a constraint between the values of two joints or tendons, or on one of them."""
    y, x = (
        ZERO if not n else made.coordinate(n) if c.what == "joint" else strands[n].length for n in (c.first, c.second)
    )
    x = as_expr(x - c.zeros[1])
    course = sum_of(x**n * k if n else as_expr(k) for n, k in enumerate(c.coefficients))
    made.holonomic.append(configuration_constraint(c.name, y - c.zeros[0] - course))
    if isinstance(y, Coordinate) and y not in set(made.dependent):
        made.dependent.append(y)


def _point(made: Making, link: int, name: str, offset: Array) -> Point:
    frame, point = made.placed(link)
    return point.at(name, vector(frame, offset))


def close(made: Making, c: Closure) -> None:
    """Adds the constraints of a loop closure."""
    name = made.identifier("joints", c.name, "closure", c.where)
    if made.carriers[c.first] == made.carriers[c.second]:
        made.remarks.say("ignored", f"the closure {c.name!r} of bodies without relative motion", c.where)
        return
    first = _point(made, c.first, f"{name} first", c.on_first.offset)
    second = _point(made, c.second, f"{name} second", c.on_second.offset)
    if c.kind == "connect":
        n = made.ground
        made.holonomic.extend(coincident(second, first, (n.x, n.y, n.z), name=name))
        return
    frames = [
        turned(made.placed(link)[0], f"{name} {side}", p.rotation)
        for link, side, p in ((c.first, "first", c.on_first), (c.second, "second", c.on_second))
    ]
    made.holonomic.extend(close_weld(name, first, frames[0], second, frames[1]))


def strung(made: Making, s: Strand) -> Strung:
    """A tendon; adds its spring, damper and limits."""
    name = made.identifier("joints", s.name, "tendon", s.where)
    points = [_point(made, link, f"{name} {k}", offset) for k, (link, offset) in enumerate(s.points, 1)]
    ends = tuple(pairwise(points))
    arms = tuple((made.joints[j], arm) for j, arm in s.arms.items())
    lengths = [q.position(p).magnitude() for p, q in ends]
    length = sum_of([*lengths, *(j.coordinates[0] * arm for j, arm in arms)])
    tendon = Strung(length, ends, arms, s.arms)
    if s.stiffness:
        low, high = s.rest
        slack = operators.where(
            operators.less(length, low), length - low, operators.where(operators.less(high, length), length - high, 0)
        )
        stretch = length - low if low == high else slack
        made.loads.append(Load.from_potential(s.stiffness * stretch**2 / 2, f"spring of {name}"))
    if s.damping:
        made.loads.extend(tendon.effort(time_derivative(length) * -s.damping, f"damper of {name}"))
    low, high = s.limits
    if made.options.stops and np.isfinite(high):
        made.contacts.append(rope(name, points, high) if points else stop(f"{name} upper", high - length))
    if made.options.stops and np.isfinite(low) and not (points and low <= 0):
        made.contacts.append(stop(f"{name} lower", length - low))
    return tendon


def drive(made: Making, d: Actuation, strands: Mapping[str, Strung]) -> None:
    """Adds an actuator's input and effort; a position or velocity servo feeds back the length and its rate."""
    name = made.identifier("symbols", d.name, "actuator", d.where)
    control = Input.declare(name, None, "", f"actuator {name}")
    made.inputs[name] = control
    made.called["inputs"][d.name] = name
    length = as_expr((strands[d.strand].length if d.strand else made.coordinate(d.joint)) * d.gear)
    rate = time_derivative(length)
    acting: Expr = control
    if d.dynamics:
        acting = StateVariable.declare(
            made.identifier("symbols", f"act_{name}", "state"), 0.0, "", f"activation of {name}"
        )
        made.states[acting] = control if d.dynamics == "integrator" else (control - acting) / d.time_constant
    gain, bias = (k[0] + length * k[1] + rate * k[2] for k in (d.gain, d.bias))
    effort = acting * gain + bias
    if d.bounds is not None:
        effort = operators.min(operators.max(effort, d.bounds[0]), d.bounds[1])
    effort = as_expr(effort * d.gear)
    if d.strand and strands[d.strand].ends:
        for joint in _limited_within(made.robot, d.strand):
            text = f"joint {joint!r}: a limit on actuator forces, without that of {d.name!r} along its tendon"
            made.remarks.say("refused", text, made.moves[joint].where)
        made.loads.extend(strands[d.strand].effort(effort, f"actuator {name}"))
        return
    for joint, arm in strands[d.strand].on.items() if d.strand else ((d.joint, 1.0),):
        made.efforts.setdefault(joint, []).append(effort * arm)


def _limited_within(robot: Robot, strand: str) -> list[str]:
    """Joints with force limits that move some of a tendon's points but not all."""
    (points,) = (s.points for s in robot.strands if s.name == strand)
    moved: Counter[str] = Counter()
    for link, _ in points:
        while link >= 0:
            moved.update(m.name for m in robot.links[link].moves if m.force_limits is not None)
            link = robot.links[link].parent
    return [joint for joint, count in moved.items() if count < len(points)]


def exert(made: Making) -> None:
    """Adds the total efforts of actuators on joints, within the joints' limits."""
    for joint, efforts in made.efforts.items():
        bounds, whole = made.moves[joint].force_limits, sum_of(efforts)
        effort = whole if bounds is None else operators.min(operators.max(whole, bounds[0]), bounds[1])
        made.loads.append(on_joint(made.joints[joint], effort, f"actuators on {made.joints[joint].name}"))
