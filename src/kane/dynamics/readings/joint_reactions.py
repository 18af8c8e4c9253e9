# SPDX-License-Identifier: BSD-3-Clause
"""The force and torque that one side of a system exerts on the other: at a joint, a point, a frame, or through a constraint.

The Newton–Euler equations of the far side, all that is connected through the place (Kane & Levinson 1985, sec. 4.9, in vectors):

    F = Σ (m a − F_load − Σ λ F_c)        T = Σ (I·α + ω × I·ω − T_load − Σ λ T_c) + Σ r × (m a − F_load − Σ λ F_c)

with r from the joint's point. The result is that of auxiliary speeds in three directions of force and three of torque, computed after
the derivation, when accelerations and multipliers λ are known.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import takewhile
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived, check_placed
from kane.dynamics.forcing import Moving
from kane.dynamics.formulation.joint_cuts import ancestry
from kane.dynamics.readings.quantities import without_unknowns
from kane.dynamics.solved import Solved
from kane.errors import Attributes, ReactionError, cut, none_of
from kane.expect import is_list
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix
from kane.kinematics.velocities import acceleration_form
from kane.model.bodies import parts_of
from kane.model.constraints import Constraint
from kane.model.joints.joint import Joint
from kane.model.system import System
from kane.numeric.rank import balance, dependencies
from kane.numeric.sampling import values_of
from kane.numeric.scale import ROUNDED_ROOT
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis
from kane.space.vector import Vector

Share = Callable[[Constraint], tuple[Vector, Vector]]
"""The force and torque, about the place's point, that a multiplier of one exerts on the side asked for."""
_CLOSED = "kn.rolling, kn.close_pin, …."
Place = str | Joint | Point | Frame | Constraint | Sequence[Constraint]


@dataclass(frozen=True, slots=True, eq=False)
class JointReaction(Attributes):
    """The force at `point` and the torque about it that the near side (towards the root of the tree) exerts on the far side.

    For a reaction at a frame alone, force and point are None.
    """

    name: str
    force: Vector | None
    torque: Vector
    point: Point | None

    def __repr__(self) -> str:
        return f"JointReaction({self.name!r}{f', about {self.point.name}' if self.point is not None else ''})"


@dataclass(frozen=True, slots=True, eq=False)
class _FarSide:
    """The far side of a joint, point or frame: its points and frames, and the arm of a force at a point."""

    name: str
    has_point: Callable[[Point], bool]
    has_frame: Callable[[Basis], bool]
    arm: Callable[[Point], Vector]
    point: Point | None


def reaction(solved: Solved, place: Place, frame: Frame | None = None) -> JointReaction:
    """The reaction in q, u, t, parameters and inputs; along `frame`, by default the inertial one. See Equations.reaction."""
    target = solved.derived.system.inertial if frame is None else frame
    unknown = unsolved(solved, place)
    force = None if unknown.force is None else unknown.force.components(target)
    numbers = without_unknowns(solved, [*(force or ()), *unknown.torque.components(target)])
    vectors = [Vector(((target, (a, b, c)),)) for a, b, c in zip(*[iter(numbers)] * 3, strict=True)]
    return JointReaction(unknown.name, None if force is None else vectors[0], vectors[-1], unknown.point)


def unsolved(solved: Solved, place: Place) -> JointReaction:
    """The reaction in u̇ and reactions as leaves."""
    where = _looked_up(solved.derived.system, place)
    if isinstance(where, tuple):
        return _closure(solved, where)
    return _balance(solved, _far_side(solved.derived, where))


# The place -------------------------------------------------------------------------------------------------------------------


def _looked_up(system: System, place: Any) -> Joint | Point | Frame | tuple[Constraint, ...]:
    if isinstance(place, Joint | Point | Frame):
        return place
    if isinstance(place, str):
        return _by_name(system, place)
    wanted = (place,) if isinstance(place, Constraint) else tuple(place) if is_list(place) else (place,)
    strangers = [getattr(c, "name", None) or cut(repr(c)) for c in wanted if c not in set(system.constraints)]
    if strangers or not wanted:
        raise ReactionError(
            f"Expected a joint, a point, a frame, constraints of the system or a name at which to find the reaction, got "
            f"{', '.join(strangers) or 'nothing'}."
        )
    return wanted


def _by_name(system: System, name: str) -> Joint | Point | Frame | tuple[Constraint, ...]:
    group = tuple(c for c in system.constraints if c.name == name)
    group = group or tuple(c for c in system.constraints if c.name.rpartition(" ")[0] == name)
    places: tuple[Point | Frame, ...] = (*system.points, *system.frames)
    joint = next((x for x in system.joints if x.name == name), None)
    place = joint or group or next((x for x in places if x.name == name), None)
    if place:
        return place
    names = [x.name for x in system.joints] + [c.name for c in system.constraints] + [x.name for x in places]
    raise ReactionError(
        f"Expected the name of a joint (listed in System(joints=…)), constraint, point or frame, one of {none_of(names, name)}"
    )


# The far side ----------------------------------------------------------------------------------------------------------------


def _far_side(derived: Derived, place: Joint | Point | Frame) -> _FarSide:
    if isinstance(place, Joint):
        point = place.point
        side = _FarSide(
            place.name, _through_point(point), _through_frame(place.frame), lambda p: p.position(point), point
        )
        _check_body_frames(derived.system, side)
    elif isinstance(place, Point):
        _check_cut(place)
        reached = _through_point(place)
        side = _FarSide(place.name, reached, _owned(derived.system, place, reached), lambda p: p.position(place), place)
    else:
        _check_cut(place)
        turned = _through_frame(place)
        arm = partial(_turned_arm, turned=turned)
        side = _FarSide(place.name, lambda p: not arm(p).is_zero, turned, arm, None)
    if not any(_holds(side, b) for b in derived.bodies):
        raise ReactionError(f"Expected a body on the far side of {place.name}, got none: no body is placed from it.")
    return side


def _holds(side: _FarSide, b: Moving) -> bool:
    return side.has_point(b.part.mass_center) or (b.rotation is not None and side.has_frame(b.rotation.frame))


def _check_cut(place: Point | Frame) -> None:
    if place.parent is None or (isinstance(place, Point) and place.body is not None):
        what = (
            "a root, which has no near side" if place.parent is None else "a particle of a body, which has no far side"
        )
        raise ReactionError(
            f"Expected a point or frame between two bodies at which to find the reaction, got {place.name}, {what}."
        )


def _through_point(point: Point) -> Callable[[Point], bool]:
    return lambda p: point in p.ancestry()


def _through_frame(frame: Frame) -> Callable[[Basis], bool]:
    return lambda f: frame in ancestry(f)


def _turned_arm(p: Point, turned: Callable[[Basis], bool]) -> Vector:
    """The part of a point's position that rotates with a frame, so that v = n × arm for a rotation about n."""
    total = Vector()
    for x in p.ancestry():
        if x.body is not None:
            total = total + x.offset if turned(x.body) else total
        else:
            total = total + Vector((f, r) for f, r in x.offset.parts if turned(f))
    return total


def _check_body_frames(system: System, side: _FarSide) -> None:
    for name, center, frame in _extended(system):
        if side.has_point(center) != side.has_frame(frame):
            placed = (
                "its point, but not from its frame" if side.has_point(center) else "its frame, but not from its point"
            )
            raise ReactionError(
                f"Expected each body on one side of the joint {side.name!r}, got {name}, which is placed from {placed}. Build "
                "its mass centre on joint.point and its frame on joint.frame."
            )


def _extended(system: System) -> list[tuple[str, Point, Frame]]:
    """Name, mass centre and frame of the parts that have a frame."""
    return [(p.name, p.mass_center, p.frame) for p in parts_of(system.bodies) if p.frame is not None]


def _owned(system: System, point: Point, reached: Callable[[Point], bool]) -> Callable[[Basis], bool]:
    """The test whether a frame is beyond a point; a frame belongs to its nearest ancestor that is the frame of a body."""
    sides = {frame: reached(center) for _, center, frame in _extended(system)}
    between = {f for frame, far in sides.items() if far for f in ancestry(frame)}

    def far(frame: Basis) -> bool:
        owner = next((f for f in ancestry(frame) if f in sides), None)
        if owner is not None:
            return sides[owner]
        if frame in between and frame.parent is not None:
            raise ReactionError(
                f"Expected torques on frames of bodies to find the torque at the point {point.name}, got one on {frame.name}, which "
                "belongs to no body, so that its side is unknown. Ask for the reaction at a joint, or give the frame a body."
            )
        return False

    return far


# Newton and Euler -------------------------------------------------------------------------------------------------------------


def _balance(solved: Solved, side: _FarSide) -> JointReaction:
    derived = solved.derived

    def share(c: Constraint) -> tuple[Vector, Vector]:
        return _gathered(side, c.forces, c.torques)

    check_placed(f"reaction {side.name} contains", derived.system.constraints, _CLOSED)
    _check_determinate(solved, side.name, share)
    moved = [(b.part.mass_center, acceleration_form(m) * mass) for b in derived.bodies for m, mass in b.momenta]
    rotations = [b.rotation for b in derived.bodies if b.rotation is not None]
    turned = [(r.frame, r.torque(acceleration_form(r.motion))) for r in rotations]
    force, torque = _gathered(side, moved, turned)
    loads = [_gathered(side, load.forces, load.torques) for load in derived.loads]
    multiplied = [(f * λ, t * λ) for c, λ in solved.multipliers.items() for f, t in [share(c)]]
    for f, t in (*loads, *multiplied):
        force, torque = force - f, torque - t
    return JointReaction(side.name, None if side.point is None else force, torque, side.point)


def _gathered(
    side: _FarSide, forces: Iterable[tuple[Point, Vector]], torques: Iterable[tuple[Frame, Vector]]
) -> tuple[Vector, Vector]:
    """Σ F and Σ T + r × F of forces and torques on the far side."""
    force, torque = Vector(), Vector()
    for point, f in forces:
        if side.has_point(point):
            force, torque = force + f, torque + side.arm(point).cross(f)
    for frame, t in torques:
        if side.has_frame(frame):
            torque = torque + t
    return force, torque


def _closure(solved: Solved, constraints: tuple[Constraint, ...]) -> JointReaction:
    """The resultant of constraint forces on the point of the first force, and on the frame of the first pure torque."""
    name = _common_name([c.name for c in constraints])
    check_placed(f"reaction {name} contains", constraints, _CLOSED)
    points = {c.forces[0][0]: c for c in constraints if c.forces}
    frames = {c.torques[0][0]: c for c in constraints if c.torques and not c.forces}
    both: tuple[Mapping[Any, Constraint], ...] = (points, frames)
    several = next((places for places in both if len(places) > 1), None)
    if several is not None:
        listed = ", ".join(f"{c.name!r} on {x.name}" for x, c in several.items())
        raise ReactionError(
            f"Expected the constraints of one closure, which act on one point and one frame, got {listed} for {name!r}. Ask for each "
            "of them."
        )
    point, frame = next(iter(points), None), next(iter(frames), None)

    def share(c: Constraint) -> tuple[Vector, Vector]:
        if c not in constraints:
            return Vector(), Vector()
        force = sum((f for p, f in c.forces if p is point), start=Vector())
        return force, sum((t for x, t in c.torques if x is frame), start=Vector())

    _check_determinate(solved, name, share)
    force, torque = Vector(), Vector()
    for c in constraints:
        f, t = share(c)
        force, torque = force + f * solved.multipliers[c], torque + t * solved.multipliers[c]
    return JointReaction(name, force, torque, point)


def _common_name(names: Sequence[str]) -> str:
    """The common first words of names, if one name has at most one more word ("G" of "G x", "G y"); else all names."""
    words = [n.split() for n in names]
    shared = words[0]
    for other in words[1:]:
        shared = [a for a, _ in takewhile(lambda pair: pair[0] == pair[1], zip(shared, other, strict=False))]
    if shared and min(map(len, words)) <= len(shared) + 1:
        return " ".join(shared)
    return ", ".join(dict.fromkeys(names))


# Checks ----------------------------------------------------------------------------------------------------------------------


def _check_determinate(solved: Solved, name: str, share: Share) -> None:
    """Raises a ReactionError if multipliers x with xᵀ A = 0, which do not affect the motion, change the transmitted force."""
    if not solved.redundant:
        return
    system = solved.derived.system
    constraints = system.constraints
    shares = Matrix([[x for v in share(c) for x in v.components(system.inertial)] for c in constraints])
    values = values_of(free_symbols(shares.entries), 0, solved.derived.compared.at.at(0))
    numbers = np.asarray(evaluate(shares, values), dtype=float)
    a = solved.derived.compared.a[0]
    combinations = dependencies(a) / balance(a).rows[:, 0]
    reach = np.abs(combinations).max(axis=1, initial=0) * np.abs(numbers).max(initial=0)
    changed = np.abs(combinations @ numbers).max(axis=1, initial=0) > ROUNDED_ROOT * reach
    if not changed.any():
        return
    parts = np.abs(combinations[changed]).max(axis=0)
    blamed = [c.name for c, x in zip(constraints, parts, strict=True) if x > ROUNDED_ROOT]
    raise ReactionError(
        f"Expected a reaction that is uniquely determined, got {name!r}: it contains the forces of the constraints "
        f"{', '.join(map(repr, blamed))}, which depend on each other, so that their individual forces are not determined. Leave out "
        "redundant constraints, or model the compliance of the parts."
    )
