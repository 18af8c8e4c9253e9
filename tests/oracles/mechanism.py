# SPDX-License-Identifier: BSD-3-Clause
"""A neutral description of a mechanism with closed loops, its kinematics in numbers, and the oracle's form of it.

A tree of bodies in Cartesian terms: a joint starts at `offset` in the parent's axes, turned by `tilt`; its steps follow one
another, slides before turns, and end in the child's origin and axes. Closures are further joints and contacts between
bodies, with a mark (a point and axes, in body axes and from the body's origin) on each. `q` holds, part by part, the values of
the steps at a configuration at which every closure holds exactly: the description is a state as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracles.loops import contacts, joints
from tests.oracles.loops.jets import constant
from tests.oracles.loops.joints import Joint, Law
from tests.oracles.loops.quaternions import turned
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, Twist
from tests.oracles.loops.rows import factors, stack
from tests.oracles.tree import Array, rotation, skew

Step = tuple[str, int]  # "slide" or "turn" about axis 0, 1, 2 of the joint; "sphere" by Euler parameters

STEPS: dict[str, tuple[Step, ...]] = {
    "pin": (("turn", 2),),
    "slider": (("slide", 2),),
    "rail": (("slide", 0),),
    "cylindrical": (("slide", 2), ("turn", 2)),
    "universal": (("turn", 2), ("turn", 0)),
    "gimbal": (("turn", 0), ("turn", 1), ("turn", 2)),
    "ball": (("sphere", 0),),
    "planar": (("slide", 0), ("slide", 1), ("turn", 2)),
    "free": (("slide", 0), ("slide", 1), ("slide", 2), ("sphere", 0)),
}
WIDTH = {"slide": (1, 1), "turn": (1, 1), "sphere": (4, 3)}  # coordinates, rates
ROLLED = np.roll(np.eye(3), 2, axis=1)  # e2, e3, e1: a slide along e1 is the oracle's slider along e3
LAWS: dict[str, Law] = {
    "pin": joints.pin,
    "slider": joints.slider,
    "rail": joints.slider,
    "cylindrical": joints.cylindrical,
    "universal": joints.universal,
    "gimbal": joints.ball,
    "ball": joints.ball,
    "planar": joints.planar,
    "weld": joints.weld,
    "on line": joints.point_on_line,
    "on plane": joints.point_on_plane,
    "knife edge": contacts.knife_edge,
    "groove": contacts.groove,
}
CONTACTS = ("sphere", "wheel", "knife edge", "groove")


@dataclass(frozen=True, slots=True)
class Part:
    """A body and the joint that carries it; `center`, `inertia` (about it) in its own axes, `force`, `torque` in inertial ones."""

    parent: int
    joint: str
    offset: Array
    tilt: Array
    mass: float
    center: Array
    inertia: Array
    force: Array
    torque: Array


@dataclass(frozen=True, slots=True)
class Closure:
    """A joint or contact that closes a loop, or holds a body to the ground; `size` is a length or radius."""

    kind: str
    bodies: tuple[int, int]
    marks: tuple[Mark, Mark]
    size: float = 0.0


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Parts (parents before children), closures, gravity, and a configuration of the tree that closes them."""

    parts: tuple[Part, ...]
    closures: tuple[Closure, ...]
    gravity: Array
    q: tuple[Array, ...]

    @property
    def steps(self) -> list[tuple[int, Step]]:
        """Every step, with the number of its part."""
        return [(i, step) for i, part in enumerate(self.parts) for step in STEPS[part.joint]]

    @property
    def coordinates(self) -> Array:
        """All coordinates in order."""
        return np.concatenate(self.q)


@dataclass(frozen=True, slots=True)
class Frames:
    """Origins and axes (columns) of the bodies, and the rows (v of the origin, ω) by the rates of the steps."""

    poses: list[Pose]
    J: list[Array]

    def center(self, i: int, part: Part) -> tuple[Pose, Array]:
        """The same of the mass centre."""
        arm = self.poses[i].R @ part.center
        J = self.J[i].copy()
        J[:3] -= skew(arm) @ J[3:]
        return Pose(self.poses[i].r + arm, self.poses[i].R), J


def frames(m: Mechanism) -> Frames:
    """Forward kinematics of the tree; the rates are those of the coordinates, of Euler parameters ω in the axes they give."""
    count = sum(WIDTH[kind][1] for _, (kind, _) in m.steps)
    found = Frames([], [])
    at = 0
    for part, q in zip(m.parts, m.q, strict=True):
        base = Pose(np.zeros(3), np.eye(3)) if part.parent == GROUND else found.poses[part.parent]
        J = np.zeros((6, count)) if part.parent == GROUND else found.J[part.parent].copy()
        r, R = base.r.copy(), base.R @ part.tilt
        arm = base.R @ part.offset
        rest = list(q)
        for kind, axis in STEPS[part.joint]:
            values = [rest.pop(0) for _ in range(WIDTH[kind][0])]
            if kind == "slide":
                arm = arm + values[0] * R[:, axis]
                J[:3, at] += R[:, axis]
            elif kind == "turn":
                J[3:, at] += R[:, axis]
                R = R @ rotation(np.eye(3)[axis], values[0])
            else:
                R = R @ turned(np.array(values))
                J[3:, at : at + 3] += R
            at += WIDTH[kind][1]
        carried = np.zeros((6, count)) if part.parent == GROUND else found.J[part.parent]
        J[:3] -= skew(arm) @ carried[3:]
        found.poses.append(Pose(r + arm, R))
        found.J.append(J)
    return found


def coordinate_rates(m: Mechanism, rates: Array) -> Array:
    """Rates of the coordinates, those of Euler parameters from ω."""
    found: list[float] = []
    left = list(rates)
    for part, q in zip(m.parts, m.q, strict=True):
        rest = list(q)
        for kind, _ in STEPS[part.joint]:
            e = [rest.pop(0) for _ in range(WIDTH[kind][0])]
            w = [left.pop(0) for _ in range(WIDTH[kind][1])]
            if kind == "sphere":
                twice = -np.dot(e[1:], w), *(e[0] * np.array(w) + np.cross(e[1:], w))
                found += [float(x) / 2.0 for x in twice]
            else:
                found += w
    return np.array(found)


@dataclass(frozen=True, slots=True)
class Loops:
    """The mechanism as the oracle has it: tree joints first, then closures; `carried` says which part each joint carries."""

    bodies: list[Body]
    joints: list[Joint]
    carried: list[int]
    poses: list[Pose]
    J: Array  # twists of the mass centres by the rates of the steps

    def rows(self, rates: Array | None = None):
        """Rows of all joints."""
        return stack(self.joints, self.poses, self.twists(np.zeros(self.J.shape[1]) if rates is None else rates), 0.0)

    def twists(self, rates: Array) -> list[Twist]:
        """Twists of the mass centres."""
        return [Twist(t[0], t[1]) for t in (self.J @ rates).reshape(-1, 2, 3)]

    @property
    def rank(self) -> tuple[int, int, float]:
        """Rank of all rows, redundant rows, and the condition of the others."""
        rows = self.rows()
        found = factors(self.bodies, self.poses, rows.A)
        return found.rank, len(rows.A) - found.rank, found.condition()

    def closing(self) -> Array:
        """Rows of the closures on the rates of the steps."""
        return np.asarray(self.rows().A @ self.J)


def law(closure: Closure) -> Law:
    """The oracle's law."""
    if closure.kind == "distance":
        return joints.distance(constant(closure.size))
    if closure.kind == "screw":
        return joints.screw(closure.size)
    if closure.kind == "sphere":
        return contacts.rolling_sphere(closure.size)
    return contacts.rolling_wheel(closure.size) if closure.kind == "wheel" else LAWS[closure.kind]


def to_oracle(m: Mechanism) -> Loops:
    """Bodies, joints and poses for `tests.oracles.loops`."""
    places = frames(m)
    bodies = [Body(part.mass, part.inertia) for part in m.parts]
    centers = [places.center(i, part) for i, part in enumerate(m.parts)]

    def on(body: int, mark: Mark) -> Mark:
        return mark if body == GROUND else Mark(mark.point - m.parts[body].center, mark.axes)

    made, carried = [], []
    for i, part in enumerate(m.parts):
        if part.joint != "free":
            turn = ROLLED if part.joint == "rail" else np.eye(3)
            near, far = Mark(part.offset, part.tilt @ turn), Mark(np.zeros(3), turn)
            made.append(Joint((part.parent, i), (on(part.parent, near), on(i, far)), LAWS[part.joint]))
            carried.append(i)
    for c in m.closures:
        made.append(Joint(c.bodies, (on(c.bodies[0], c.marks[0]), on(c.bodies[1], c.marks[1])), law(c)))
        carried.append(-1)
    return Loops(bodies, made, carried, [pose for pose, _ in centers], np.concatenate([J for _, J in centers]))


def admissible_rates(rng: np.random.Generator, loops: Loops, speed: float = 1.0) -> Array:
    """Rates of the steps at random that every closure admits."""
    rates = speed * rng.normal(size=loops.J.shape[1])
    rows = loops.closing()
    return np.asarray(rates - np.linalg.pinv(rows, rcond=1e-9) @ (rows @ rates))
