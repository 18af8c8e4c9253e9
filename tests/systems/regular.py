# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms that are regular where a fixed order of elimination, or a pole of W, is not.

Each comes with what Newton's and Euler's equations in redundant coordinates need: bodies, joints, and the forces on the bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

import kane as kn
from kane.gallery import whipple_bicycle
from tests.dynamics.test_poles import cart, sled
from tests.literature.rods import X, Y, Z, rod
from tests.literature.test_whipple import bodies_and_joints
from tests.oracles.loops import joints
from tests.oracles.loops.contacts import knife_edge, rolling_wheel
from tests.oracles.loops.joints import Joint, Law
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, mark, marks_at
from tests.oracles.tree import Array
from tests.systems.rotated_wheel import rotated_wheel

ROAD = Mark(np.zeros(3), np.eye(3))
Frames = tuple[kn.Frame, ...]
Pushed = Callable[[list[Pose]], tuple[Array, Array]]
"""Forces and torques (bodies × 3) at and about the mass centres."""
level: Law = joints._held(lambda ends: (ends[0].axis(3).dot(ends[1].axis(3)),))
"""e3 of the second mark square to e3 of the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Redundant:
    """A system, its bodies' axes, and the same in redundant coordinates.

    States are closed by the constraints of `closing`, where the system leaves out what follows from others, changing coordinates that
    are `moving`. They are drawn up to `reach`; at `special` ones some coordinates are given.
    """

    system: kn.System
    axes: Frames
    bodies: list[Body]
    joints: list[Joint]
    pushed: Pushed | None = None
    gravity: Array | None = None
    closing: kn.System | None = None
    moving: tuple[int, ...] | None = None
    reach: float = 3.0
    special: Sequence[dict[int, float]] = ()


def wheel() -> Redundant:
    """The rotated wheel, at every heading."""
    system = rotated_wheel()
    body = Body(2.0, np.diag([0.05, 0.09, 0.05]))
    floor, axle = mark(-0.3 * Z, Z), mark(np.zeros(3), Y)
    held = [Joint((GROUND, 0), (floor, axle), law) for law in (rolling_wheel(0.3), level)]
    pushed = np.array([[0.7, -0.4, 0.0]]), np.array([[0.0, 0.0, 0.3]])
    return Redundant(system, _axes(system), [body], held, lambda _: pushed, special=_headings(2))


def sledge() -> Redundant:
    """The sled, at every heading: W has poles at ± 90°."""
    system = sled()
    body = Body(2.0, 0.3 * np.eye(3))
    edge = mark(np.zeros(3), Z, Y)
    held = [Joint((GROUND, 0), (ROAD, edge), law) for law in (joints.planar, knife_edge)]

    def pushed(poses: list[Pose]) -> tuple[Array, Array]:
        return (poses[0].R @ [6, 0.5, 0])[None], np.array([[0, 0, 0.9]])

    return Redundant(system, _axes(system), [body], held, pushed, special=_headings(2))


def trolley() -> Redundant:
    """The cart, likewise."""
    system = cart()
    wheels = [Body(0.5, np.diag([0.01, 0.02, 0.01]))] * 2
    middle = -0.2 * X
    held = [
        Joint((GROUND, 0), (ROAD, mark(middle, Z, Y)), joints.planar),
        Joint((GROUND, 0), (ROAD, mark(middle, Z, Y)), knife_edge),
    ]
    for k, side in ((1, 0.3), (2, -0.3)):
        held.append(Joint((0, k), (mark(middle + side * Y, Y), mark(np.zeros(3), Y)), joints.pin))
        held.append(Joint((GROUND, k), (mark(-0.2 * Z, Z), mark(np.zeros(3), Y)), rolling_wheel(0.2)))

    def pushed(_: list[Pose]) -> tuple[Array, Array]:
        return np.array([[2, 1, 0], [0, 0, 0], [0, 0, 0.0]]), np.array([[0, 0, 0.3], [0, 0, 0], [0, 0, 0]])

    return Redundant(system, _axes(system), [Body(5.0, 0.4 * np.eye(3)), *wheels], held, pushed, special=_headings(2))


def bicycle(axes: str, speeds: str, dependent: Sequence[str] = ()) -> Redundant:
    """The Whipple bicycle with rolling written along N, Y or the fork's axes, with the gallery's speeds or "rates"."""
    system = whipple_bicycle.system()
    frames = {f.name: f for f in system.frames}
    rear, front = (system.nonholonomic[k].forces[0][0] for k in (0, 2))
    first, second = (frames[name] for name in axes)
    rolling = [
        *kn.no_slip(rear, along=(first.x, first.y), name="rear wheel"),
        *kn.no_slip(front, along=(second.x, second.y), name="front wheel"),
    ]
    system = system.replace(nonholonomic=rolling, **({"speeds": "rates"} if speeds == "rates" else {}))
    system = system.replace(dependent_speeds=dependent)
    bodies, held = bodies_and_joints()
    own = tuple(b.inertia.frames()[0] if b.name == "fork" else b.frame for b in system.rigid_bodies)
    special = [dict.fromkeys((3, 4, 5), 0.0) | h for h in _headings(2)]
    return Redundant(system, own, bodies, held, None, 9.81 * Z, moving=(4,), reach=0.6, special=special)


CORNERS = (0 * X, X, X - Y, X - Y + Z, Z - Y, Z)
HINGES = (Y, Z, X, Y, Z, X)


def bricard(cut: int, redundant: bool, dependent: Sequence[int] = ()) -> Redundant:
    """Bricard's mechanism cut at hinge `cut`; not `redundant`, the place along that hinge's axis is left to the others."""
    whole, less = (_bricard(cut, all_five) for all_five in (True, False))
    made = [rod(1.0, p, q, 0.1) for p, q in pairwise(CORNERS)]
    # the inertias along the inertial axes, in which every body's frame is at rest
    bodies = [Body(b.mass, pose.R @ b.inertia @ pose.R.T) for b, pose in made]
    poses = [Pose(pose.r, np.eye(3)) for _, pose in made]
    chain = [GROUND, 0, 1, 2, 3, 4, GROUND]
    held = [
        Joint(pair, marks_at(poses, pair, p, axis), joints.pin)
        for pair, p, axis in zip(pairwise(chain), CORNERS, HINGES, strict=True)
    ]
    system = whole if redundant else less
    own = tuple(system.speeds)
    system = system.replace(dependent_speeds=[own[k] for k in dependent])
    order = sorted(system.rigid_bodies, key=lambda b: b.name)
    assert list(system.rigid_bodies) == order
    return Redundant(system, _axes(system), bodies, held, gravity=-9.81 * Y, closing=whole)


def _bricard(cut: int, redundant: bool) -> kn.System:
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:6", "rad")
    frames: dict[int, kn.Frame] = {GROUND: N, 5: N}
    ends: dict[tuple[int, int], kn.Point] = {(GROUND, 0): O, (5, 5): O.at("P5", _along(N, CORNERS[5]))}
    bodies: dict[int, kn.RigidBody] = {}
    waiting = iter(q)
    # rod k lies from corner k to corner k + 1; those before the cut hang on the first hinge, the others on the last
    for k, near, far in [*((k, k, k + 1) for k in range(cut)), *((k, k + 1, k) for k in range(4, cut - 1, -1))]:
        parent = k - 1 if near == k else k + 1
        base = frames[parent]
        frames[k] = frame = base.rotate(f"B{k}", next(waiting), _along(base, HINGES[near]))
        way = _along(frame, CORNERS[far] - CORNERS[near])
        center = ends[parent, near].at(f"B{k}*", way / 2)
        ends[k, near], ends[k, far] = ends[parent, near], ends[parent, near].at(f"P{far}", way)
        edges = [1.0 if x else 0.1 for x in CORNERS[far] - CORNERS[near]]
        bodies[k] = kn.RigidBody(f"rod {k}", frame=frame, mass_center=center, mass=1, inertia=kn.box(frame, 1, *edges))
    one, two = frames[cut - 1], frames[cut]
    others = [a for a, x in zip((one.x, one.y, one.z), HINGES[cut], strict=True) if not x]
    along = (_along(one, HINGES[cut]), *others) if redundant else others
    place = kn.coincident(ends[cut, cut], ends[cut - 1, cut], along=along, name="hinge")
    axis = kn.parallel(_along(two, HINGES[cut]), _along(one, HINGES[cut]), across=others, name="axis")
    return kn.System(
        N,
        bodies=[bodies[k] for k in range(5)],
        speeds="rates",
        loads=[kn.gravity(-9.81 * N.y)],
        holonomic=[*place, *axis],
        coordinates=q,
    )


def windows(signs: Sequence[int], dependent: Sequence[int]) -> Redundant:
    """Two windows of four-bar linkages, cranks turning about ± the normal; the speeds in these places depend."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, p = kn.coordinates("q0:3", "rad"), kn.coordinates("p1:3", "rad")
    g = kn.parameter("g", 9.81, "m/s^2")
    bodies: list[kn.RigidBody] = []
    tops: list[kn.Point] = []
    closing: list[kn.Constraint] = []
    for k, s in enumerate(signs):
        A = N.rotate(f"A{k}", q[k], s * N.z)
        foot = O.at(f"A_{k}", k * N.x)
        tops.append(foot.at(f"B_{k}", A.y))
        bodies.append(_bar(f"link {k}", A, foot.at(f"A{k}*", A.y / 2), A.y))
    for k in (0, 1):
        C = N.rotate(f"C{k}", p[k], N.z)
        end = tops[k].at(f"end {k}", C.x)
        bodies.append(_bar(f"coupler {k}", C, tops[k].at(f"C{k}*", C.x / 2), C.x))
        closing += kn.coincident(end, tops[k + 1], along=(N.x, N.y), name=f"pin {k}")
    system = kn.System(
        N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], holonomic=closing, coordinates=(*q, *p)
    )
    own = tuple(system.speeds)
    system = system.replace(dependent_speeds=[own[k] for k in dependent])
    across, about = 1 / 12, 1e-3
    made = [Body(1.0, np.diag([across, about, across]))] * 3 + [Body(1.0, np.diag([about, across, across]))] * 2
    centers = [k * X + Y / 2 for k in range(3)] + [k * X + Y + X / 2 for k in range(2)]
    poses = [Pose(c, np.eye(3)) for c in centers]
    pairs = [((GROUND, k), k * X) for k in range(3)]
    pairs += [(pair, (k + c) * X + Y) for k in range(2) for c, pair in enumerate(((k, 3 + k), (k + 1, 3 + k)))]
    held = [Joint(pair, marks_at(poses, pair, place, Z), joints.pin) for pair, place in pairs]
    return Redundant(system, _axes(system), made, held, gravity=-9.81 * Y)


def _bar(name: str, frame: kn.Frame, center: kn.Point, along: kn.Vector) -> kn.RigidBody:
    return kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=kn.rod(frame, 1, 1, along))


def _along(frame: kn.Frame, v: Array) -> kn.Vector:
    made: kn.Vector = kn.Vector()
    for axis, x in zip((frame.x, frame.y, frame.z), v, strict=True):
        made = made + int(x) * axis
    return made


def _axes(system: kn.System) -> Frames:
    return tuple(b.frame for b in system.rigid_bodies)


def _headings(place: int) -> list[dict[int, float]]:
    """Yaw at and beside the places where a cosine or sine of it vanishes."""
    right = np.pi / 2
    return [{place: x} for x in (right, right - 1e-8, right + 1e-8, -right, 0.0, 1e-8, np.pi)]


CASES: dict[str, Callable[[], Redundant]] = {
    "wheel": wheel,
    "sled": sledge,
    "cart": trolley,
    **{f"bicycle {a} {s}": partial(bicycle, a, s) for a in ("NN", "YY", "YH") for s in ("speeds", "rates")},
    **{f"Bricard {k} {'whole' if r else 'less'}": partial(bricard, k, r) for k in range(6) for r in (False, True)},
    "Bricard 5 less 0123": partial(bricard, 5, False, (0, 1, 2, 3)),
    "windows +++ 0134": partial(windows, (1, 1, 1), (0, 1, 3, 4)),
    "windows +-+ 0234": partial(windows, (1, -1, 1), (0, 2, 3, 4)),
    "windows -+- 1234": partial(windows, (-1, 1, -1), (1, 2, 3, 4)),
}
