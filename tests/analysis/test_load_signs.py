# SPDX-License-Identifier: BSD-3-Clause
"""What energy says of the signs of loads: springs that push away, dampers that feed, and nothing of what is sound."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.analysis import doubtful_loads

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
th = kn.coordinate("th")
A = N.rotate("A", th, N.z)
P = O.at("P", x * N.x + y * N.y)
Q = P.at("Q", 0.3 * A.x + 0.1 * A.y)
BODY = kn.RigidBody("body", frame=A, mass_center=P, mass=2, inertia=kn.inertia(A, 1, 1, 1))
START = {x: 0.4, y: -0.2, th: 0.7}
SHAKEN = O.at("S", 0.1 * kn.sin(kn.time) * N.x)
F = kn.input("F")
SIGNED = {
    name: kn.parameter(name) for name in ("spring", "damper")
}  # without defaults, as declarations refuse negative ones


def doubts(load: Any, values: dict[Any, float] = START, **more: Any) -> list[str]:
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[load], **more))
    given = {kn.time: 0.3, SIGNED["spring"]: -7.0, SIGNED["damper"]: -0.4}
    numbers = {**given, **values, **dict.fromkeys(eom.speeds, 0.0), **dict.fromkeys(eom.inputs, 1.5)}
    return [d.does for d in doubtful_loads(eom, numbers)]


def springs(k: Any) -> dict[str, kn.Load]:
    return {
        "between points": kn.linear_spring(Q, O, k),
        "stretched": kn.linear_spring(Q, O, k, 0.2),
        "pressed": kn.linear_spring(Q, O, k, 2.0),
        "by hand": kn.Force(P, -k * x * N.x),
        "along a turning frame": kn.Force(Q, -k * Q.position(O)),
        "against the ground alone": kn.Force(P, -k * (x - 0.1) ** 3 * N.x),
        "torsional": kn.torsional_spring(A, N, th, k, N.z, 0.3),
        "with a damper": kn.Force(P, (-k * x - 0.3 * x.dt) * N.x),
        "from a moving support": kn.linear_spring(Q, SHAKEN, k, 0.2),
    }


def dampers(c: Any) -> dict[str, kn.Load]:
    return {
        "between points": kn.linear_damper(Q, O, c),
        "drag": kn.Force(Q, -c * Q.velocity(N)),
        "quadratic drag": kn.Force(P, -c * P.velocity(N).magnitude() * P.velocity(N)),
        "dry": kn.Force(P, -c * kn.tanh(50 * x.dt) * N.x),
        "torsional": kn.torsional_damper(A, N, c, N.z),
        "with a spring": kn.Force(P, (-3 * x - c * x.dt) * N.x),
        "against the wind": kn.Force(P, -c * (P.velocity(N) - 3 * N.x)),
        "from a moving support": kn.linear_damper(Q, SHAKEN, c),
    }


@pytest.mark.parametrize("name", springs(1))
def test_a_spring_of_the_wrong_sign_pushes_away(name):
    assert doubts(springs(7.0)[name]) == []
    assert doubts(springs(SIGNED["spring"])[name]) == ["pushes"]


@pytest.mark.parametrize("name", dampers(1))
def test_a_damper_of_the_wrong_sign_feeds(name):
    assert doubts(dampers(0.4)[name]) == []
    assert doubts(dampers(SIGNED["damper"])[name]) == ["feeds"]


@pytest.mark.parametrize(
    "load",
    [
        kn.gravity(-9.81 * N.y),
        kn.Force(Q, 3 * A.x),  # follows the body
        kn.Force(Q, -3 * A.x),
        kn.Torque(A, 2 * N.z),
        kn.Force(P, F * N.x),
        kn.Force(Q, F * A.y),
        kn.Force(P, kn.sin(kn.time) * N.x),
        kn.Force(P, 0.3 * N.z.cross(P.velocity(N))),  # across the velocity
        kn.Force(P, (1 - 40 * x**2 * y) * x.dt * y.dt * N.x),  # of no sign
        kn.Torque(A, 0.4 * P.velocity(N).dot(N.x) * N.z),
    ],
    ids=str,
)
def test_what_has_no_sign_is_not_doubted(load):
    assert doubts(load) == []


def test_what_is_not_defined_at_rest_is_no_spring():
    assert doubts(kn.Force(P, -0.3 * x * P.velocity(N).normalized())) == []


def test_at_the_place_of_rest():
    still = {x: 0.0, y: 0.0, th: 0.0}
    assert doubts(kn.Force(P, -7 * x * N.x), still) == []
    assert doubts(kn.Force(P, 7 * x * N.x), still) == ["pushes"]


def test_directions_are_those_that_constraints_leave():
    """A brake of the body's turn, written by the speed of the place that rolls: of no sign but along the constraint."""
    rolls = x.dt + 0.3 * th.dt
    brake = kn.Torque(A, 0.4 * x.dt * N.z)
    assert doubts(brake) == []
    assert doubts(brake, nonholonomic=rolls) == []
    assert doubts(kn.Torque(A, -0.4 * x.dt * N.z), nonholonomic=rolls) == ["feeds"]
    held = kn.distance(P, O, float(np.hypot(0.4, 0.2)))
    assert doubts(kn.linear_damper(Q, O, SIGNED["damper"]), holonomic=held) == ["feeds"]


def test_the_figures():
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Force(P, 7 * x * N.x, name="spring")]))
    numbers = {kn.time: 0.0, **START, **dict.fromkeys(eom.speeds, 0.0)}
    (doubt,) = doubtful_loads(eom, numbers)
    assert (doubt.load.name, doubt.does) == ("spring", "pushes")
    assert doubt.most == pytest.approx(7)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_do_not_matter(unit):
    """The same spring and damper with all lengths in mm, or in km."""
    l = unit * 0.3
    start = {x: 0.4 * unit, y: -0.2 * unit, th: 0.7}
    R = P.at("R", l * A.x)
    assert doubts(kn.linear_spring(R, O, SIGNED["spring"], l / 2), start) == ["pushes"]
    assert doubts(kn.linear_spring(R, O, 7.0, l / 2), start) == []
    assert doubts(kn.linear_damper(R, O, SIGNED["damper"]), start) == ["feeds"]
