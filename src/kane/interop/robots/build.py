# SPDX-License-Identifier: BSD-3-Clause
"""A system of a robot's record: frames and points of its links, joints, loads, constraints and contacts.

Coordinates are q_<joint>, speeds u_<joint>, inputs tau_<joint> and those of actuators by their names; a link's numbers are
m_<link>, c_x_<link>, …, I_xx_<link>, …. A rotor's inertia (an armature) is that of a disk without mass that turns by the joint's
value in the ground: ½ a q̇² is its kinetic energy, and it takes no part in the motion of the links.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from kane import expect
from kane.errors import ModelError, listed_warnings, warn
from kane.expr.build import sum_of
from kane.expr.differentiation import time_derivative
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.operators import less, max, min, where
from kane.expr.symbols import Coordinate, Input, Parameter, Speed
from kane.interop.imported import Imported, Remark
from kane.interop.robots.names import Names
from kane.interop.robots.records import DOFS, Closure, Coupling, Drive, Link, Move, Robot, Strand
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint, coincident, configuration_constraint
from kane.model.contacts import ContactLaw, rope, stiction, stop
from kane.model.joints.closing import close_weld
from kane.model.joints.joint import Joint
from kane.model.joints.tree_joints import ball, free, pin, planar, slider
from kane.model.loads import Force, Gravity, Load, action_reaction, gravity, torque_pair
from kane.model.solids import inertia
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.scale import DECLARED, LAST_DIGIT
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Symbolic = Literal["none", "masses", "all"]
KINDS = ("none", "masses", "all")
UNITS = {"hinge": "N*m", "slide": "N"}


@dataclass(frozen=True, slots=True)
class Options:
    """What is asked for beside the tree."""

    parameters: Symbolic = "all"
    stops: bool = False
    damping: bool = True
    friction: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Making:
    """The system so far."""

    robot: Robot
    options: Options
    ground: Frame
    origin: Point
    frames: list[Frame] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    bodies: list[Any] = field(default_factory=list)
    joints: dict[str, Joint] = field(default_factory=dict)
    moves: dict[str, Move] = field(default_factory=dict)
    loads: list[Load | Gravity] = field(default_factory=list)
    inputs: dict[str, Input] = field(default_factory=dict)
    holonomic: list[Constraint] = field(default_factory=list)
    contacts: list[ContactLaw] = field(default_factory=list)
    dependent: list[Coordinate] = field(default_factory=list)
    link_names: Names = field(default_factory=Names)
    joint_names: Names = field(default_factory=Names)
    symbol_names: Names = field(default_factory=Names)
    called: dict[str, dict[str, str]] = field(default_factory=lambda: {"links": {}, "joints": {}, "inputs": {}})

    def placed(self, link: int) -> tuple[Frame, Point]:
        """Frame and origin of a link, or of the ground."""
        return (self.ground, self.origin) if link < 0 else (self.frames[link], self.points[link])

    def parameter(self, name: str, value: float, unit: str, what: str, kinds: tuple[str, ...] = ("all",)) -> Expr:
        """A number of the robot, as a parameter where these kinds are; one that is zero is none."""
        if value == 0 or self.options.parameters not in kinds:
            return as_expr(float(value))
        return Parameter.declare(self.symbol_names.identifier(name, "parameter"), float(value), unit, what)

    def coordinate(self, joint: str) -> Coordinate:
        """The coordinate of a joint that has one."""
        return self.joints[joint].coordinates[0]


def vector(frame: Frame, v: Array) -> Vector:
    """The vector of these measure numbers."""
    return frame.x * float(v[0]) + frame.y * float(v[1]) + frame.z * float(v[2])


def turned(frame: Frame, name: str, rotation: Array) -> Frame:
    """The frame of a placement: the same one where it is not turned. What rounding leaves of a zero is one."""
    if np.array_equal(rotation, np.eye(3)):
        return frame
    return frame.rotate_matrix(name, [[as_expr(float(x)) for x in row] for row in rotation])


def plain(rotation: Array) -> Array:
    """Direction cosines whose zeros, and ones, are exact."""
    r = np.where(np.abs(rotation) <= LAST_DIGIT, 0.0, rotation)
    return np.where(np.abs(np.abs(r) - 1) <= LAST_DIGIT, np.sign(r), r)


def built(robot: Robot, options: Options) -> Imported:
    """The system of a robot, with remarks on what it is made of.

    Raises
    ------
    ModelError
        if numbers are none that a body can have, or nothing moves
    """
    expect.one_of(options.parameters, KINDS, "parameters= to be")
    ground = Frame("N")
    made = _Making(robot, options, ground, Point("O", fixed_in=ground))
    with listed_warnings() as doubts:
        for link in robot.links:
            _add_link(made, link)
        _add_gravity(made)
        for closure in robot.closures:
            _close(made, closure)
        strands = {s.name: _strung(made, s) for s in robot.strands}
        for coupling in robot.couplings:
            _couple(made, coupling, strands)
        for drive in robot.drives:
            _drive(made, drive, strands)
        if not made.joints:
            raise ModelError(f"Expected a joint that moves in {robot.name!r}, got none.")
        system = System(
            ground,
            bodies=made.bodies,
            loads=made.loads,
            joints=list(made.joints.values()),
            holonomic=made.holonomic,
            dependent_coordinates=made.dependent,
            contacts=made.contacts,
        )
    return _imported(made, system, doubts)


def _imported(made: _Making, system: System, doubts: list[str]) -> Imported:
    robot = made.robot
    renamed = [r for n in (made.link_names, made.joint_names) for r in n.remarks]
    remarks = (*robot.remarks, *renamed, *(Remark("inferred", text) for text in doubts))
    refused = [r for r in remarks if r.kind == "refused"]
    if refused:
        warn(f"Expected all of {robot.name!r} to be a model, got {len(refused)} things that are none here, the first: {refused[0]}.")
    q = {c.name: c for c in system.coordinates}
    u: dict[str, Speed] = {s.name: s for s in system.speeds}
    parameters = {p.name: p for p in system.parameters}
    limits = {j: m.limits for j, m in made.moves.items() if m.limits is not None}
    extras = {
        **{what: MappingProxyType(names) for what, names in made.called.items()},
        "limits": MappingProxyType(limits),
        "shapes": robot.shapes,
        **robot.extras,
    }
    symbols = {**q, **u, **made.inputs, **parameters}
    frozen = (MappingProxyType(x) for x in (symbols, q, u, parameters, extras))
    s, q_, u_, p, e = frozen
    return Imported(system, s, q_, u_, p, remarks, e)  # type: ignore[arg-type]


def _add_link(made: _Making, link: Link) -> None:
    """Frame, origin, joints and body of a link."""
    frame, point = made.placed(link.parent)
    name = made.link_names.identifier(link.name, "link", link.where)
    made.called["links"][link.name] = name
    offset = vector(frame, link.placement.offset)
    frame = turned(frame, f"{name} seat" if link.moves else name, link.placement.rotation)
    point = point if offset.is_zero else point.at(f"{name} seat" if link.moves else f"{name} origin", offset)
    for k, move in enumerate(link.moves, 1):
        frame, point = _add_move(made, move, frame, point, name if k == len(link.moves) else f"{name}_{k}")
    if link.moves:
        point = point.at(f"{name} origin", 0)
    made.frames.append(frame)
    made.points.append(point)
    _add_body(made, link, name, frame, point)


def _add_body(made: _Making, link: Link, name: str, frame: Frame, point: Point) -> None:
    if float(np.abs(link.inertia).max()) <= DECLARED**2 * link.mass:  # of what is smaller than a nanometre: zeros, rounded
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
    if not link.inertia.any():
        made.bodies.append(Particle(name, center, mass))
        return
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    moments = [
        made.parameter(f"I_{axes[i]}{axes[j]}_{name}", link.inertia[i, j], "kg*m^2", f"central inertia of {name}")
        for i, j in pairs
    ]
    if link.buoyancy:
        lift = vector(made.ground, made.robot.gravity) * (mass * -link.buoyancy)
        made.loads.append(Force(center, lift, f"gravity compensation of {name}"))
    body = RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=inertia(frame, *moments))
    made.bodies.append(body)


def _check_numbers(link: Link) -> None:
    """A mass and principal moments that are not negative."""
    if link.mass < 0:
        raise expect.refusal(ModelError, f"a mass ≥ 0 of the link {link.name!r}", f"{link.mass:g} ({link.where})")
    low, middle, high = np.linalg.eigvalsh(link.inertia)
    if low < -DECLARED * high:
        came = f"{low:g}, {middle:g}, {high:g} ({link.where})"
        cure = "Check the signs: ixy is −∫ x y dm, and the moments are about the mass centre."
        raise expect.refusal(ModelError, f"principal moments of inertia ≥ 0 of the link {link.name!r}", came, cure)


def _add_move(made: _Making, move: Move, frame: Frame, point: Point, child: str) -> tuple[Frame, Point]:
    """The child of a joint, and its loads; the origin of the child is that of the parent, moved by the joint."""
    name = made.joint_names.identifier(move.name, "joint", move.where)
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
    elif move.kind == "ball":
        joint = ball(name, at, frame, child=child)
    else:
        joint = free(name, at, frame, child=child)
    for s in (*joint.coordinates, *joint.speeds):
        if made.symbol_names.identifier(s.name, "symbol") != s.name:
            came = f"{s.name} of {move.name!r} too ({move.where})"
            raise expect.refusal(ModelError, "names of joints that make symbols of different names", came, "Rename it.")
    made.joints[move.name], made.moves[move.name] = joint, move
    made.called["joints"][move.name] = name
    _load_joint(made, move, joint)
    return joint.frame, joint.point.at(f"{child} back", vector(joint.frame, -move.anchor)) if not anchor.is_zero else joint.point


def _on_joint(joint: Joint, effort: Any, name: str) -> Load:
    """A torque or force along the axis of a pin or slider, and its opposite on the parent."""
    if joint.kind == "pin":
        return torque_pair(joint.frame, joint.parent, joint.axis * effort, name)
    return action_reaction(joint.point, joint.at, joint.axis * effort, name)


def _damping(joint: Joint, c: Expr) -> list[Load]:
    """A torque and a force against the joint's motion."""
    turn, slide = joint.angular_velocity, joint.velocity
    loads = [] if turn.is_zero else [torque_pair(joint.frame, joint.parent, turn * -c, f"damping of {joint.name}")]
    if not slide.is_zero:
        loads.append(action_reaction(joint.point, joint.at, slide * -c, f"damping of the slide of {joint.name}"))
    return loads


def _load_joint(made: _Making, move: Move, joint: Joint) -> None:
    """Effort, spring, damper, rotor, stops and dry friction of a joint."""
    name = joint.name
    if move.damping and made.options.damping:
        c = made.parameter(f"d_{name}", move.damping, "", f"damping of {name}")
        made.loads.extend(_damping(joint, c))
    if move.armature:
        _add_rotor(made, move, joint)
    if DOFS[move.kind] > 1:
        return
    (q,) = joint.coordinates
    if move.effort:
        tau = Input.declare(f"tau_{name}", None, UNITS[move.kind], f"effort of {name}")
        made.inputs[tau.name] = tau
        made.called["inputs"][move.name] = tau.name
        made.loads.append(_on_joint(joint, tau, f"effort of {name}"))
    if move.stiffness:
        k = made.parameter(f"k_{name}", move.stiffness, "", f"stiffness of {name}")
        made.loads.append(Load.from_potential(k * (q - move.rest) ** 2 / 2, f"spring of {name}"))
    if move.limits is not None and made.options.stops:
        low, high = move.limits
        made.contacts.extend([stop(f"{name} lower", q - low)] if np.isfinite(low) else [])
        made.contacts.extend([stop(f"{name} upper", high - q)] if np.isfinite(high) else [])
    if move.friction and made.options.friction:
        made.contacts.append(stiction(joint, move.friction))


def _add_rotor(made: _Making, move: Move, joint: Joint) -> None:
    """What adds an armature a to the diagonal of M."""
    name = f"{joint.name} rotor"
    a = made.parameter(f"a_{joint.name}", move.armature, "", f"armature of {joint.name}")
    N, O = made.ground, made.origin
    if move.kind == "hinge":
        frame = N.rotate(name, joint.coordinates[0], N.z)
        made.bodies.append(RigidBody(name, frame=frame, mass_center=O, mass=0, inertia=inertia(frame, a / 2, a / 2, a)))
    elif move.kind == "slide":
        level = (N.x, N.y, N.z)[int(np.argmin(np.abs(made.robot.gravity)))]
        made.bodies.append(Particle(name, O.at(name, level * joint.coordinates[0]), a))
    elif move.kind == "ball":
        frame = N.rotate_euler_parameters(name, joint.coordinates)
        made.bodies.append(RigidBody(name, frame=frame, mass_center=O, mass=0, inertia=inertia(frame, a, a, a)))
    else:
        raise expect.refusal(
            ModelError, f"no armature of the {move.kind} joint {move.name!r}", f"{move.armature:g} ({move.where})"
        )


def _add_gravity(made: _Making) -> None:
    g = made.robot.gravity
    size = float(np.linalg.norm(g))
    if size:
        symbol = made.parameter("g", size, "m/s^2", "gravitational acceleration", ("masses", "all"))
        made.loads.append(gravity(vector(made.ground, plain(g / size)) * symbol))


def _couple(made: _Making, c: Coupling, strands: Mapping[str, Expr]) -> None:
    """A constraint between the values of two joints or tendons, or one of one alone."""
    y, x = (ZERO if not n else made.coordinate(n) if c.what == "joint" else strands[n] for n in (c.first, c.second))
    x = as_expr(x - c.zeros[1])
    course = sum_of(x**n * k if n else as_expr(k) for n, k in enumerate(c.coefficients))
    made.holonomic.append(configuration_constraint(c.name, y - c.zeros[0] - course))
    if isinstance(y, Coordinate) and y not in set(made.dependent):
        made.dependent.append(y)


def _point(made: _Making, link: int, name: str, offset: Array) -> Point:
    frame, point = made.placed(link)
    return point.at(name, vector(frame, offset))


def _close(made: _Making, c: Closure) -> None:
    name = made.joint_names.identifier(c.name, "closure", c.where)
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


def _strung(made: _Making, s: Strand) -> Expr:
    """The length of a tendon; its spring, damper and limits."""
    name = made.joint_names.identifier(s.name, "tendon", s.where)
    points = [_point(made, link, f"{name} {k}", offset) for k, (link, offset) in enumerate(s.points, 1)]
    parts = [q.position(p).magnitude() for p, q in pairwise(points)]
    length = sum_of([*parts, *(made.coordinate(j) * arm for j, arm in s.arms.items())])
    if s.stiffness:
        low, high = s.rest
        slack = where(less(length, low), length - low, where(less(high, length), length - high, 0))
        stretch = length - low if low == high else slack
        made.loads.append(Load.from_potential(s.stiffness * stretch**2 / 2, f"spring of {name}"))
    if s.damping:
        made.loads.append(Load.from_dissipation(s.damping * time_derivative(length) ** 2 / 2, f"damper of {name}"))
    low, high = s.limits
    if made.options.stops and np.isfinite(high):
        made.contacts.append(rope(name, points, high) if points else stop(f"{name} upper", high - length))
    if made.options.stops and np.isfinite(low) and not (points and low <= 0):
        made.contacts.append(stop(f"{name} lower", length - low))
    return length


def _drive(made: _Making, d: Drive, strands: Mapping[str, Expr]) -> None:
    """An actuator's input and its effort; a position or velocity servo feeds back length and its rate."""
    name = made.symbol_names.identifier(d.name, "actuator", d.where)
    control = Input.declare(name, None, "", f"actuator {name}")
    made.inputs[name] = control
    made.called["inputs"][d.name] = name
    length = as_expr((strands[d.strand] if d.strand else made.coordinate(d.joint)) * d.gear)
    constant, slope, drag = d.bias
    effort = control * d.gain + constant + length * slope + time_derivative(length) * drag
    if d.bounds is not None:
        effort = min(max(effort, d.bounds[0]), d.bounds[1])
    if d.strand:
        made.loads.append(Load.from_dissipation(-effort * time_derivative(length), f"actuator {name}"))
    else:
        made.loads.append(_on_joint(made.joints[d.joint], effort * d.gear, f"actuator {name}"))
