# SPDX-License-Identifier: BSD-3-Clause
"""A system from a robot's record: frames and points of its links, joints, loads, constraints and contacts.

Coordinates are named q_<joint>, speeds u_<joint>, inputs tau_<joint>, or as their actuators; parameters of a link are m_<link>,
c_x_<link>, …, I_xx_<link>, ….
"""

from collections.abc import Callable
from math import inf
from types import MappingProxyType
from typing import Any

from kane import expect
from kane.equations.state import State, guess
from kane.errors import ModelError, listed_warnings, warn
from kane.expr.symbols import Speed
from kane.interop.imported import Imported, Remark
from kane.interop.robots.links import add_gravity, add_link
from kane.interop.robots.making import KINDS, Making, Options
from kane.interop.robots.records import Robot
from kane.interop.robots.ties import close, couple, drive, exert, strung
from kane.model.system import System
from kane.space.frame import Frame, Point


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
