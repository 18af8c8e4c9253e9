# SPDX-License-Identifier: BSD-3-Clause
"""Loads that are given by a function: V(q, t) with F_r = −Σ_s ∂V/∂q_s W_sr, or R(q, q̇, t) with F_r = −∂R/∂u_r.

(Kane & Levinson 1985, sec. 5.1 and 5.3.) What a function says of one coordinate is a force Q_s for its rate, v·F = Q_s q̇_s. It gets a
place like any other load: where a frame of a body turns by the coordinate alone, a pair of torques there; else a point that moves by
it along the inertial frame's first axis, or a frame that turns by it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from kane.errors import ModelError
from kane.expr.build import add
from kane.expr.differentiation import diff
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Rate, Speed, Symbol
from kane.expr.visit import substituted
from kane.model.bodies import Body
from kane.model.loads import Load
from kane.model.survey import places
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector, axes
from kane.units.parser import parse

Pulls = list[tuple[Coordinate, Expr]]
_LENGTH = parse("m").exponents


def with_forces(loads: Iterable[Load], inertial: Frame, bodies: Sequence[Body], speeds: Any) -> tuple[Load, ...]:
    """The loads, those made from a function with forces and torques; `speeds` defines the speeds that it may hold."""
    return tuple(
        x if x.scalar is None or x.forces or x.torques else _placed(x, _pulls(x, speeds), inertial, bodies)
        for x in loads
    )


def _pulls(load: Load, speeds: Any) -> Pulls:
    """Q_s by coordinate: −∂V/∂q_s, or −∂R/∂q̇_s."""
    assert load.scalar is not None
    if load.potential is not None:
        return [(q, -diff(load.potential, q)) for q in free_symbols([load.potential]) if isinstance(q, Coordinate)]
    by_speed = speeds if isinstance(speeds, Mapping) else {}
    known: dict[Expr, Expr] = {
        u: as_expr(e) for u, e in by_speed.items() if isinstance(u, Speed) and not isinstance(e, Vector)
    }
    function = substituted(load.scalar, known)
    left = [s for s in free_symbols([function]) if isinstance(s, Speed)]
    if left:
        names = ", ".join(u.name for u in known if isinstance(u, Speed)) or "none, as all are the rates"
        raise ModelError(
            f"Expected the dissipation function of {load.name!r} in rates or in speeds that the system defines ({names}), got "
            f"{left[0]} in it. Write it by rates, q.dt."
        )
    rates = [s for s in free_symbols([function]) if isinstance(s, Rate) and isinstance(s.place, Coordinate)]
    return [(r.place, -diff(function, r)) for r in rates if isinstance(r.place, Coordinate)]


def _turning(frames: Iterable[Frame]) -> Mapping[Symbol, tuple[Frame, Frame, int]]:
    """By coordinate the frame that turns by it alone in its parent, the parent, and about which basis axis."""
    found: dict[Symbol, tuple[Frame, Frame, int]] = {}
    for frame in frames:
        o, parent = frame.orientation, frame.parent
        if o is None or o.axis is None or o.angle is None or parent is None:
            continue
        before = parent.orientation
        start = before.angle if before is not None and before.base is o.base and before.axis == o.axis else None
        for q in free_symbols([o.angle]):
            if isinstance(q, Coordinate) and o.angle is (q if start is None else add(start, q)):
                found.setdefault(q, (frame, parent, o.axis))
    return found


def _placed(load: Load, pulls: Pulls, inertial: Frame, bodies: Sequence[Body]) -> Load:
    frames, points = places(inertial, tuple(bodies), (), ())
    root = points[0].root()
    turning, angles = _turning(frames), set(free_symbols(x for f in frames for x in _scalars(f)))
    forces: list[tuple[Point, Vector]] = []
    torques: list[tuple[Frame, Vector]] = []
    for q, pull in pulls:
        name = f"{load.name} by {q.name}"
        if pull is ZERO:
            continue
        if q in turning:
            frame, base, axis = turning[q]
            torque = axes(base)[axis] * pull
            torques += [(frame, torque), *([] if base is inertial else [(base, -torque)])]
        elif parse(q.unit).exponents == _LENGTH if q.unit else q not in angles:
            forces.append((root.at(name, inertial.x * q), inertial.x * pull))
        else:
            torques.append((inertial.rotate(name, q, inertial.x), inertial.x * pull))
    return replace(load, forces=tuple(forces), torques=tuple(torques))


def _scalars(frame: Frame) -> Sequence[Expr]:
    return () if frame.orientation is None else frame.orientation.scalars()
