# SPDX-License-Identifier: BSD-3-Clause
"""Couplings, closures of loops, tendons and actuators of a robot."""

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kane.expr.build import sum_of
from kane.expr.differentiation import time_derivative
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.operators import less, max, min, where
from kane.expr.symbols import Coordinate, Input, StateVariable
from kane.interop.robots.making import Making, on_joint, turned, vector
from kane.interop.robots.records import Actuation, Closure, Coupling, Robot, Strand
from kane.model.constraints import coincident, configuration_constraint
from kane.model.contacts import rope, stop
from kane.model.joints.closing import close_weld
from kane.model.joints.joint import Joint
from kane.model.loads import Load, action_reaction
from kane.numeric.arrays import Array
from kane.space.frame import Point


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
        slack = where(less(length, low), length - low, where(less(high, length), length - high, 0))
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
        effort = min(max(effort, d.bounds[0]), d.bounds[1])
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
        effort = whole if bounds is None else min(max(whole, bounds[0]), bounds[1])
        made.loads.append(on_joint(made.joints[joint], effort, f"actuators on {made.joints[joint].name}"))
