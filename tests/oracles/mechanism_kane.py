# SPDX-License-Identifier: BSD-3-Clause
"""A mechanism of `tests.oracles.mechanism` declared to kane: speeds of several kinds, closures by places, reactions by name."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import kane as kn
from tests.oracles.loops.records import GROUND, Mark
from tests.oracles.mechanism import STEPS, Closure, Mechanism, coordinate_rates
from tests.oracles.tree import Array

SPEEDS = ("rates", "angular", "mixed")


@dataclass(frozen=True, slots=True)
class Asked:
    """What of a mechanism is asked for: the kind of speeds, at which joints' reactions, and whether of the closures' multipliers.

    `joined` closes loops by `kn.close_…` where there is one; `symbolic` makes parameters of the geometry.
    """

    speeds: str = "rates"
    cuts: tuple[int, ...] = ()
    multipliers: bool = False
    seed: int = 0
    joined: bool = False
    symbolic: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """The reaction of part `part`'s joint along axis `axis` of its tilted axes: a force, or a torque about the joint's start."""

    reaction: kn.Reaction
    part: int
    torque: bool
    axis: int


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """The system; frames, mass centres and where the joint starts, body by body; constraints, closure by closure."""

    mechanism: Mechanism
    system: kn.System
    coordinates: tuple[kn.Coordinate, ...]
    frames: tuple[kn.Frame, ...]
    centers: tuple[kn.Point, ...]
    starts: tuple[tuple[kn.Point, kn.Frame], ...]
    closures: tuple[tuple[kn.Constraint, ...], ...]
    cuts: tuple[Cut, ...]

    def q(self) -> dict[Any, float]:
        """The configuration of the mechanism."""
        return dict(zip(self.coordinates, self.mechanism.coordinates.tolist(), strict=True))

    def u(self, eom: kn.Equations, rates: Array) -> dict[Any, float]:
        """Speeds at the rates of the steps."""
        given = dict(zip(self.coordinates, coordinate_rates(self.mechanism, rates).tolist(), strict=True))
        return eom.speeds_from_rates(self.q(), given)


Number = Callable[[Any], Any]


def vector(frame: kn.Frame, v: Array, number: Number = float) -> kn.Vector:
    """The vector with these components along the frame's axes."""
    x, y, z = (number(c) for c in v)
    made: kn.Vector = x * frame.x + y * frame.y + z * frame.z
    return made


def _numbers(symbolic: bool) -> Number:
    """What makes numbers of the geometry, or parameters that have them as defaults."""
    count = itertools.count()
    return (lambda x: kn.parameter(f"g{next(count)}", float(x))) if symbolic else float


def _axes(frame: kn.Frame) -> tuple[kn.Vector, kn.Vector, kn.Vector]:
    return frame.x, frame.y, frame.z


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A mark on a body: the body's frame, the mark's point and its axes."""

    body: kn.Frame
    point: kn.Point
    frame: kn.Frame


Declare = Callable[[str, Closure, Place, Place], Sequence[kn.Constraint] | None]
"""A closure's constraints by name and the places on both sides; None for those that are declared as they always are."""


def _coincident(name: str, near: Place, far: Place, axes: Sequence[kn.Vector]) -> list[kn.Constraint]:
    return list(kn.coincident(far.point, near.point, along=axes, name=name))


def _parallel(name: str, near: Place, far: Place) -> list[kn.Constraint]:
    return list(kn.parallel(far.frame.z, near.frame.z, across=(near.frame.x, near.frame.y), name=f"{name} axis"))


def _wheel(name: str, near: Place, far: Place, size: float, thin: bool) -> list[kn.Constraint]:
    """The particle in contact is at the floor's height and does not move along it."""
    up, axle = near.frame.z, far.frame.z
    down = (up.dot(axle) * axle - up).normalized() if thin else -up
    particle = far.point.fixed_in(far.body, f"{name} particle", size * down)
    height = kn.touching(particle, near.point, normal=up, name=f"{name} height")
    return [height, *kn.rolling(particle, normal=up, name=name)]


def _joined(name: str, c: Closure, near: Place, far: Place) -> list[kn.Constraint]:
    """The loop closed by a joint."""
    x, _, z = _axes(near.frame)
    own: dict[str, dict[str, Any]] = {"universal": {"axes": (z, x)}, "ball": {}, "planar": {"normal": z}}
    given = own.get(c.kind, {"axis": z})
    return list(getattr(kn, f"close_{c.kind}")(name, near.point, near.frame, far.point, far.frame, **given))


def _closed(name: str, c: Closure, near: Place, far: Place, joined: bool) -> list[kn.Constraint]:
    if joined and c.kind in ("pin", "slider", "cylindrical", "universal", "ball", "planar"):
        return _joined(name, c, near, far)
    x, y, z = _axes(near.frame)
    root = near.point.root().frame
    if c.kind == "distance":
        return [kn.distance(far.point, near.point, c.size, name=name)]
    if c.kind in ("sphere", "wheel"):
        return _wheel(name, near, far, c.size, c.kind == "wheel")
    if c.kind in ("knife edge", "groove"):
        edge = far.frame.x if c.kind == "knife edge" else near.frame.x
        particle = far.point.fixed_in(far.body, f"{name} particle")
        return list(kn.no_slip(particle, along=edge, name=name))
    directions = {
        "ball": _axes(root), "pin": (x, y, z), "universal": (x, y, z), "cylindrical": (x, y), "slider": (x, y),
        "on line": (x, y), "on plane": (z,), "planar": (z,),
    }  # fmt: skip
    made = _coincident(name, near, far, directions[c.kind])
    if c.kind in ("pin", "cylindrical", "slider", "planar"):
        made += _parallel(name, near, far)
    if c.kind == "slider":
        made.append(kn.perpendicular(far.frame.x, near.frame.y, name=f"{name} turn"))
    if c.kind == "universal":
        made.append(kn.perpendicular(far.frame.x, near.frame.z, name=f"{name} cross"))
    return made


def to_kane(m: Mechanism, asked: Asked = Asked(), declare: Declare | None = None) -> Model:
    """The system of a mechanism; `declare` makes the constraints of a closure."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    number = _numbers(asked.symbolic)
    coordinates: list[kn.Coordinate] = []
    rates: list[kn.Expr] = []
    angular: list[kn.Expr] = []
    frames: list[kn.Frame] = []
    origins: list[kn.Point] = []
    bodies: list[kn.RigidBody] = []
    loads: list[Any] = [kn.gravity(vector(N, m.gravity))]
    starts: list[tuple[kn.Point, kn.Frame]] = []

    def more(count: int) -> list[kn.Coordinate]:
        first = len(coordinates) + 1
        made = list(kn.coordinates(f"q{first}:{first + count}"))
        coordinates.extend(made)
        return made

    for i, part in enumerate(m.parts):
        near, point = (N, O) if part.parent == GROUND else (frames[part.parent], origins[part.parent])
        start = origin = point.at(f"J{i}", vector(near, part.offset, number))
        joint = frame = near.rotate_matrix(f"J{i}", [[number(x) for x in row] for row in part.tilt])
        starts.append((start, joint))
        for k, (kind, axis) in enumerate(STEPS[part.joint]):
            if kind == "sphere":
                frame = frame.rotate_euler_parameters(f"B{i}", more(4))
                turns = [frame.angular_velocity(joint).dot(e) for e in _axes(frame)]
                rates += turns
                angular += [frame.angular_velocity(N).dot(e) for e in _axes(frame)]
                continue
            (q,) = more(1)
            if kind == "slide":
                origin = origin.at(f"P{i}{k}", q * _axes(frame)[axis])
            else:
                frame = frame.rotate(f"B{i}{k}", q, _axes(frame)[axis])
            rates.append(q.dt)
            angular.append(q.dt)
        if part.joint == "gimbal":
            angular[-3:] = [frame.angular_velocity(N).dot(e) for e in _axes(frame)]
        inertia = [float(part.inertia[r, c]) for r, c in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))]
        center = origin.at(f"B{i}*", vector(frame, part.center, number))
        mass = kn.parameter(f"m{i}", part.mass, "kg")
        bodies.append(
            kn.RigidBody(f"B{i}", frame=frame, mass_center=center, mass=mass, inertia=kn.inertia(frame, *inertia))
        )
        if np.any(part.force):
            loads.append(kn.Force(center, vector(N, part.force), name=f"force {i}"))
        if np.any(part.torque):
            loads.append(kn.Torque(frame, vector(N, part.torque), name=f"torque {i}"))
        frames.append(frame)
        origins.append(origin)

    def place(k: int, side: str, body: int, mark: Mark) -> Place:
        own, base = (N, O) if body == GROUND else (frames[body], origins[body])
        point = base.at(f"C{k}{side}", vector(own, mark.point, number))
        return Place(own, point, own.rotate_matrix(f"C{k}{side}", [[number(x) for x in row] for row in mark.axes]))

    closures = []
    for k, c in enumerate(m.closures):
        near_mark, far_mark = (place(k, side, b, mark) for side, b, mark in zip("ab", c.bodies, c.marks, strict=True))
        made = None if declare is None else declare(f"{c.kind} {k}", c, near_mark, far_mark)
        closures.append(tuple(_closed(f"{c.kind} {k}", c, near_mark, far_mark, asked.joined) if made is None else made))
    cuts = []
    for i in asked.cuts:
        point, frame = starts[i]
        for axis, e in enumerate(_axes(frame)):
            cuts.append(Cut(kn.reaction(f"F{i}{axis}", at=point, along=e), i, False, axis))
            cuts.append(Cut(kn.reaction(f"T{i}{axis}", frame=frame, along=e), i, True, axis))
    held = [c for group in closures for c in group]
    multipliers = [kn.reaction(f"L{k}", constraint=c) for k, c in enumerate(held)] if asked.multipliers else []
    system = kn.System(
        N,
        bodies=bodies,
        speeds=_speeds(asked, rates, angular),
        loads=loads,
        reactions=[*(c.reaction for c in cuts), *multipliers],
        holonomic=[c for c in held if c.kind == "configuration"],
        nonholonomic=[c for c in held if c.kind == "motion"],
    )
    centers = tuple(b.mass_center for b in bodies)
    return Model(m, system, tuple(coordinates), tuple(frames), centers, tuple(starts), tuple(closures), tuple(cuts))


def _speeds(asked: Asked, rates: list[kn.Expr], angular: list[kn.Expr]) -> Any:
    if asked.speeds == "rates":
        return "rates"
    u = kn.speeds(f"v1:{len(rates) + 1}")
    if asked.speeds == "angular":
        return dict(zip(u, angular, strict=True))
    # a product of shears: of determinant one, in no particular order
    rng = np.random.default_rng(asked.seed)
    order = rng.permutation(len(rates))
    mixed = [rates[order[0]]]
    for k in range(1, len(rates)):
        mixed.append(rates[order[k]] + float(rng.integers(-2, 3)) / 2 * rates[order[rng.integers(k)]])
    return dict(zip(u, mixed, strict=True))
