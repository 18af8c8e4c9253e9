# SPDX-License-Identifier: BSD-3-Clause
"""Random nonholonomic systems: carts in a train on wheels and blades, and disks that lean, with a body on the axle.

Each comes with the same in redundant coordinates, and with the constraints whose forces are to be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

import kane as kn
from tests.oracles.loops import joints
from tests.oracles.loops.contacts import knife_edge, rolling_wheel
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, mark
from tests.oracles.tree import Array
from tests.systems.regular import ROAD, Redundant

X, Y, Z = np.eye(3)
GRAVITY = 9.81


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Constraints of one contact, with their directions, and the joint of the oracle that holds the same."""

    constraints: Sequence[kn.Constraint]
    directions: Sequence[kn.Vector]
    joint: int


@dataclass(eq=False)
class Parts:
    """What is gathered while a system is made up."""

    rng: np.random.Generator
    bodies: list[kn.RigidBody] = field(default_factory=list)
    loads: list[kn.Load] = field(default_factory=list)
    nonholonomic: list[kn.Constraint] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    records: list[Body] = field(default_factory=list)
    held: list[Joint] = field(default_factory=list)
    forces: list[Array] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    definitions: dict[kn.Speed, kn.Expr] = field(default_factory=dict)

    def number(self, low: float, high: float) -> float:
        return round(float(self.rng.uniform(low, high)), 3)

    def body(self, name: str, frame: kn.Frame, center: kn.Point, inertia: Sequence[float], push: bool = True) -> int:
        """A body, with a constant force in the plane and a torque about the vertical; its number."""
        mass = self.number(0.5, 3.0)
        a, b, c = (float(x) for x in inertia)
        N = frame.lineage[-1]
        force = np.array([self.number(-2, 2), self.number(-2, 2), 0.0]) if push else np.zeros(3)
        torque = np.array([0.0, 0.0, self.number(-1, 1)]) if push else np.zeros(3)
        self.bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=kn.inertia(frame, a, b, c))
        )
        if push:
            self.loads.append(kn.Force(center, force[0] * N.x + force[1] * N.y, name=f"push on {name}"))
            self.loads.append(kn.Torque(frame, torque[2] * N.z, name=f"turn of {name}"))
        self.records.append(Body(mass, np.diag([a, b, c])))
        self.forces.append(force)
        self.torques.append(torque)
        return len(self.records) - 1

    def moments(self, least: float, most: float) -> tuple[float, float, float]:
        """Principal moments of inertia that a body can have."""
        a, b, c = (self.number(least, most) for _ in range(3))
        return b + c, c + a, a + b

    def speed(self, definition: kn.Expr) -> None:
        (u,) = kn.speeds(f"u{len(self.definitions) + 1}")
        self.definitions[u] = definition

    def touch(self, constraints: Sequence[kn.Constraint], directions: Sequence[kn.Vector], joint: Joint) -> None:
        self.nonholonomic += constraints
        self.held.append(joint)
        self.contacts.append(Contact(constraints, directions, len(self.held) - 1))

    def system(self, N: kn.Frame, **more: object) -> tuple[kn.System, tuple[kn.Frame, ...]]:
        """The system, and the axes of its bodies."""
        system = kn.System(
            N, bodies=self.bodies, loads=self.loads, nonholonomic=self.nonholonomic, speeds=self.definitions, **more
        )
        assert list(system.rigid_bodies) == self.bodies
        return system, tuple(b.frame for b in self.bodies)

    def finished(self, N: kn.Frame, gravity: Array | None, reach: float) -> tuple[Redundant, list[Contact]]:
        system, axes = self.system(N)
        forces, torques = np.array(self.forces), np.array(self.torques)

        def pushed(_: list[Pose]) -> tuple[Array, Array]:
            return forces, torques

        return Redundant(system, axes, self.records, self.held, pushed, gravity, reach=reach), self.contacts


def train(rng: np.random.Generator) -> tuple[Redundant, list[Contact]]:
    """One to three carts, each hinged to the one before, on a blade or a wheel at any heading, at least one of them."""
    made, N = Parts(rng), kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    start, base, last = O.at("P0", x * N.x + y * N.y), N, GROUND
    hinge = np.zeros(3)
    count = int(rng.integers(1, 4))
    needed = int(rng.integers(count))
    relative = rng.random() < 0.5
    for i in range(count):
        yaw = kn.coordinate(f"yaw{i}")
        A = (base if relative else N).rotate(f"A{i}", yaw, N.z)
        offset = np.array([made.number(-0.5, 0.5), made.number(-0.3, 0.3), 0.0])
        center = start.at(f"C{i}", offset[0] * A.x + offset[1] * A.y)
        own = made.body(f"cart {i}", A, center, made.moments(0.05, 0.3))
        if last == GROUND:
            made.held.append(Joint((GROUND, own), (ROAD, mark(np.zeros(3), Z)), joints.planar))
            _speeds_of_place(made, center if rng.random() < 0.5 else start, A, N, (x, y))
        else:
            made.held.append(Joint((last, own), (mark(hinge, Z), mark(-offset, Z)), joints.pin))
        made.speed(A.angular_velocity(N).dot(N.z) if rng.random() < 0.5 else yaw.dt)
        kind = rng.choice(["wheel", "blade", "none"]) if i != needed else rng.choice(["wheel", "blade"])
        if kind != "none":
            (_wheel if kind == "wheel" else _blade)(made, i, own, A, start, offset, N)
        way = np.array([made.number(0.3, 1.0), made.number(-0.4, 0.4), 0.0])
        start, base, last, hinge = start.at(f"P{i + 1}", way[0] * A.x + way[1] * A.y), A, own, way - offset
    return made.finished(N, None, 3.0)


def _speeds_of_place(
    made: Parts, point: kn.Point, A: kn.Frame, N: kn.Frame, place: tuple[kn.Coordinate, kn.Coordinate]
) -> None:
    v = point.velocity(N)
    own = (v.dot(A.x), v.dot(A.y)) if made.rng.random() < 0.6 else (place[0].dt, place[1].dt)
    for definition in own:
        made.speed(definition)


def _heading(made: Parts, name: str, A: kn.Frame) -> tuple[kn.Frame, Array]:
    """A frame at a fixed angle on a cart, and its axes on the cart."""
    angle = made.number(-1.5, 1.5)
    c, s = np.cos(angle), np.sin(angle)
    return A.rotate(name, angle, A.z), np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _blade(made: Parts, i: int, own: int, A: kn.Frame, start: kn.Point, offset: Array, N: kn.Frame) -> None:
    F, axes = _heading(made, f"F{i}", A)
    p = np.array([made.number(-0.6, 0.6), made.number(-0.3, 0.3), 0.0])
    edge = start.at(f"E{i}", p[0] * A.x + p[1] * A.y)
    held = kn.no_slip(edge, along=(F.y,), name=f"blade {i}")
    made.touch(held, (F.y,), Joint((GROUND, own), (ROAD, mark(p - offset, Z, axes[:, 1])), knife_edge))


def _wheel(made: Parts, i: int, own: int, A: kn.Frame, start: kn.Point, offset: Array, N: kn.Frame) -> None:
    F, axes = _heading(made, f"F{i}", A)
    p, radius = np.array([made.number(-0.6, 0.6), made.number(-0.3, 0.3), 0.0]), made.number(0.1, 0.4)
    spin = kn.coordinate(f"spin{i}")
    W = F.rotate(f"W{i}", spin, F.y)
    center = start.at(f"axle {i}", p[0] * A.x + p[1] * A.y)
    half, width = made.number(0.02, 0.1), made.number(0.0, 0.05)
    wheel = made.body(f"wheel {i}", W, center, (half + width, 2 * half, half + width), push=False)
    made.held.append(Joint((own, wheel), (mark(p - offset, axes[:, 1]), mark(np.zeros(3), Y)), joints.pin))
    contact = center.fixed_in(W, f"c{i}", -radius * N.z)
    D = (N, A, F)[made.rng.integers(3)]
    held = kn.no_slip(contact, along=(D.x, D.y), name=f"wheel {i}")
    rolling = Joint((GROUND, wheel), (mark(-radius * Z, Z), mark(np.zeros(3), Y)), rolling_wheel(radius))
    made.touch(held, (D.x, D.y), rolling)
    made.speed(spin.dt)


def leaning(rng: np.random.Generator) -> tuple[Redundant, list[Contact]]:
    """A disk that rolls and leans, with any principal moments, and perhaps a body that swings about its axle."""
    made, N = Parts(rng), kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    yaw, lean, spin = kn.coordinates("yaw lean spin")
    x, y = kn.coordinates("x y")
    radius = made.number(0.2, 0.5)
    Y_ = N.rotate("Y", yaw, N.z)
    B = Y_.rotate("B", kn.pi / 2 - lean, Y_.x)
    C = B.rotate("C", spin, B.z)
    P = O.at("P", x * N.x + y * N.y)
    center = P.at("C*", radius * B.y)
    contact = center.fixed_in(C, "C^", -radius * B.y)
    own = made.body("disk", C, center, made.moments(0.02, 0.1))
    D = (N, Y_)[rng.integers(2)]
    held = kn.no_slip(contact, along=(D.x, D.y), name="rolling")
    floor = Joint((GROUND, own), (Mark(np.zeros(3), np.eye(3)), mark(np.zeros(3), Z)), rolling_wheel(radius))
    made.touch(held, (D.x, D.y), floor)
    w = C.angular_velocity(N)
    frame = (B, C, None)[rng.integers(3)]
    for rate, axis in zip((yaw.dt, lean.dt, spin.dt), ("x", "y", "z"), strict=True):
        made.speed(rate if frame is None else w.dot(getattr(frame, axis)))
    _speeds_of_place(made, center if rng.random() < 0.3 else P, Y_, N, (x, y))
    if rng.random() < 0.6:
        swing = kn.coordinate("swing")
        E = B.rotate("E", swing, B.z)
        arm = np.array([made.number(0.1, 0.4), made.number(-0.2, 0.2), made.number(-0.2, 0.2)])
        hung = center.at("E*", arm[0] * E.x + arm[1] * E.y + arm[2] * E.z)
        other = made.body("bob", E, hung, made.moments(0.02, 0.1))
        made.held.append(Joint((own, other), (mark(np.zeros(3), Z), mark(-arm, Z)), joints.pin))
        made.speed(E.angular_velocity(C).dot(B.z) if rng.random() < 0.5 else swing.dt)
    made.loads.append(kn.gravity(-GRAVITY * N.z))
    return made.finished(N, -GRAVITY * Z, 1.0)


def drawn(seed: int) -> tuple[Redundant, list[Contact]]:
    """A train, or a disk that leans."""
    rng = np.random.default_rng(seed)
    return (leaning if seed % 3 == 0 else train)(rng)
