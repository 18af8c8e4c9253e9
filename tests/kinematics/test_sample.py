# SPDX-License-Identifier: BSD-3-Clause
"""The numbers at a random configuration rule out only what symbolic matching would not find."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk
from kane.kinematics import Sample, generalized_speeds

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
LOADS = [kn.gravity(-9.81 * N.z)]


def balls(count, euler):
    """A chain of ball joints whose speeds are the measure numbers of each angular velocity along its own axes."""
    point, frame, bodies, speeds = O, N, [], {}
    for i in range(count):
        if euler:
            body = frame.rotate_euler_parameters(f"B{i}", kn.coordinates(f"e{i}_0:4"))
        else:
            body = frame.rotate_body(f"B{i}", kn.coordinates(f"a{i} b{i} c{i}"), "zxy")
        w = body.angular_velocity(N)
        speeds.update(zip(kn.speeds(f"u{i}_1:4"), (w.dot(body.x), w.dot(body.y), w.dot(body.z)), strict=True))
        center = point.at(f"G{i}", body.x)
        bodies.append(kn.RigidBody(f"b{i}", frame=body, mass_center=center, mass=1, inertia=kn.inertia(body, 1, 2, 3)))
        point, frame = point.at(f"P{i}", 2 * body.x), body
    return kn.System(N, bodies=bodies, speeds=speeds, loads=LOADS)


def free_in_its_own_axes():
    q, u = kn.coordinates("q1:7"), kn.speeds("u1:7")
    point = O.at("P", q[3] * N.x + q[4] * N.y + q[5] * N.z + kn.sin(kn.time) * N.x)
    body = N.rotate_body("B", (q[0] + kn.time, q[1], q[2]), "zxz")
    w, v = body.angular_velocity(N), point.velocity(N)
    definitions = [-w.dot(body.y), w.dot(body.x), w.dot(body.z), v.dot(body.x), v.dot(body.y), v.dot(body.z)]
    rigid = kn.RigidBody("b", frame=body, mass_center=point, mass=1, inertia=kn.inertia(body, 1, 2, 3))
    return kn.System(N, bodies=[rigid], speeds=dict(zip(u, definitions, strict=True)), loads=LOADS)


CASES = {
    "disk": rolling_disk.system,
    "balls": lambda: balls(3, False),
    "balls with Euler parameters": lambda: balls(3, True),
    "free": free_in_its_own_axes,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_same_equations_without_it(name, monkeypatch):
    """With nothing ruled out the search finds the same matches: the same nodes."""
    system = CASES[name]()
    quick = kn.derive(system)
    monkeypatch.setattr(Sample, "whole", lambda self, coefficients, frames: [(3, True)] * len(frames))
    thorough = kn.derive(system)
    assert all(a is b for a, b in zip(quick.right_hand_side, thorough.right_hand_side, strict=True))


@pytest.mark.parametrize("euler", [False, True])
def test_what_it_sees(euler):
    system = balls(2, euler)
    sample = Sample(generalized_speeds(system))
    inner, outer = (b.frame for b in system.rigid_bodies)
    w = sample.coefficients(outer.angular_velocity(N))
    assert sample.whole(w, (outer, inner)) == [(3, True), (0, False)]
    turn = sample.turn(outer)
    assert turn.T @ turn == pytest.approx(np.eye(3), abs=1e-12)
    assert turn.T @ w == pytest.approx(np.hstack([np.zeros((3, 3)), np.eye(3)]), abs=1e-10)
    v = sample.coefficients(system.bodies[0].mass_center.velocity(N))
    assert sample.whole(v, (inner,)) == [(2, True)]  # along x nothing, along y and z one speed each
    assert sample.turn(inner).T @ v @ [0, 1, 2, 0, 0, 0] == pytest.approx([0, 2, -1], abs=1e-10)


def test_the_order_of_asking_does_not_matter():
    speeds = generalized_speeds(balls(2, True))
    exprs = [c for row in speeds.rows for c in row.values()]
    forwards, backwards = Sample(speeds), Sample(speeds)
    forwards.numbers(exprs)
    for e in exprs[::-1]:
        backwards.numbers([e])
    assert forwards.values.keys() == backwards.values.keys()
    assert all(np.array_equal(v, backwards.values[s]) for s, v in forwards.values.items())


def test_where_the_numbers_say_nothing_nothing_is_ruled_out():
    x = kn.coordinate("x")
    point = O.at("P", x * N.x)
    beyond = kn.asin(2 + x)  # defined nowhere
    speeds = {kn.speed("v"): x.dt * (1 + beyond)}
    system = kn.System(N, bodies=[kn.Particle("p", point, 1)], speeds=speeds)
    sample = Sample(generalized_speeds(system))
    assert sample.whole(sample.coefficients(point.velocity(N)), (N,)) == [(3, True)]


@pytest.mark.parametrize("euler", [False, True])
def test_other_speeds_of_the_same_rates_share_the_numbers(euler):
    """What was computed for one set of speeds serves another one: the same numbers as from the start, W aside."""
    system = balls(2, euler)
    given = Sample(generalized_speeds(system))
    v = system.bodies[1].mass_center.velocity(N)
    given.coefficients(v)
    other = generalized_speeds(system.redefined({u: 2 * e for u, e in system.speeds.items()}))
    shared, alone = given.by(other), Sample(other)
    assert shared.values is given.values
    assert np.array_equal(shared.coefficients(v), alone.coefficients(v))
    assert shared.coefficients(v) == pytest.approx(given.coefficients(v) / 2, rel=1e-9)


def test_plain_numbers_divide_as_ieee_754_says():
    q = kn.coordinate("q")
    speeds = generalized_speeds(kn.System(N, bodies=[kn.Particle("p", O.at("P", q * N.x), 1)], speeds="rates"))
    assert np.isinf(Sample(speeds, 1, {q: 0}).numbers([1 / q])[0])


@pytest.mark.parametrize("name", CASES)
def test_rates_by_speeds_are_those_of_the_inverse(name):
    """An expression of rates has the value that it has in speeds."""
    system = CASES[name]()
    speeds = generalized_speeds(system)
    sample = Sample(speeds)
    for e in (kn.sin(q) * q.dt + kn.time for q in system.coordinates):
        (wanted,) = sample.numbers([speeds.in_speeds(e, {})])
        assert sample.at_speeds(e) == pytest.approx(float(wanted), rel=1e-9)
