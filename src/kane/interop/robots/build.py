# SPDX-License-Identifier: BSD-3-Clause
"""A system from a robot's record: frames and points of its links, joints, loads, constraints and contacts.

Coordinates are named q_<joint>, speeds u_<joint>, inputs tau_<joint>, or as their actuators; parameters of a link are m_<link>,
c_x_<link>, …, I_xx_<link>, ….

A rotor (armature a) is the inertia of a massless disk that rotates by the joint value relative to the ground, with kinetic energy ½ a
q̇²; it does not couple to the motion of the links.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf
from types import MappingProxyType
from typing import Any

import numpy as np

from kane import expect
from kane.equations.state import State, guess
from kane.errors import ModelError, listed_warnings, warn
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Input, Speed
from kane.interop.imported import Imported, Remark
from kane.interop.robots.making import KINDS, Making, Options, on_joint, plain, turned, vector
from kane.interop.robots.records import DOFS, Move, Robot, RobotLink
from kane.interop.robots.ties import close, couple, drive, exert, strung
from kane.model.bodies import Particle, RigidBody
from kane.model.contacts import stiction, stop
from kane.model.joints.joint import Joint, ball, free, pin, planar, slider
from kane.model.loads import Force, Load, action_reaction, gravity, torque_pair
from kane.model.solids import inertia
from kane.model.system import System
from kane.numeric.scale import DECLARED, NO_SIZE
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

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
