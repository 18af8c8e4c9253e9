# SPDX-License-Identifier: BSD-3-Clause
"""Gears and racks: reflected inertia, tooth forces, bearings and the planetary train."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.model.joints.kinds import rigid
from tests.model.joints.rates import power_and_rate

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
D = kn.parameter("d", 0.6, "m")
R_A, R_B = kn.parameter("R_a", 0.2, "m"), kn.parameter("R_b", 0.4, "m")
G = 9.81


def spinner(joint, mass, inertia):
    return rigid(joint.name, joint.frame, joint.point, mass, kn.inertia(joint.frame, inertia, inertia, inertia))


def numbers(eom, exprs, **state):
    return np.array([float(x) for x in eom.evaluate(list(exprs), **state)])


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize("flipped", [False, True])
def test_two_gears_on_the_ground(internal, flipped):
    """(J_a + (r_a/r_b)² J_b) α = T; the tooth force turns b, and b's bearing carries it and b's weight."""
    teeth = (20, 40)
    r_a, r_b = (0.6, 1.2) if internal else (0.2, 0.4)
    sense = (1 if internal else -1) * (-1 if flipped else 1)
    a = kn.pin("a", O, N, axis=N.z)
    b = kn.pin("b", O.at("P", D * N.x), N, axis=-N.z if flipped else N.z)
    mesh = kn.gear_pair("mesh", a, b, teeth=teeth, internal=internal, phase=0.1)
    loads = [kn.Torque(a.frame, 5 * N.z), kn.gravity(-G * N.y)]
    bodies = [spinner(a, 1, 0.03), spinner(b, 2, 0.5)]
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[a, b], loads=loads, holonomic=mesh))
    q = {a.coordinates[0]: 0.4, b.coordinates[0]: sense * 0.3 * r_a / r_b}
    state = kn.assemble(eom, q=q, u={"u_a": 2.0})
    at = {"q": state.q, "u": state.u}
    assert state.q[b.coordinates[0]] == pytest.approx(q[b.coordinates[0]], abs=1e-13)
    alpha = 5 / (0.03 + 0.5 * (r_a / r_b) ** 2)
    np.testing.assert_allclose(numbers(eom, eom.accelerations, **at), [alpha, sense * alpha * r_a / r_b])
    tooth = (0.03 * alpha - 5) / r_a  # on a, along the tangent, from a's moment of momentum
    side = -1 if internal else 1  # the pitch point is on this side of a
    force = np.array([0, side * tooth, 0])
    np.testing.assert_allclose(numbers(eom, eom.reaction("mesh").force.components(N), **at), force, atol=1e-12)
    bearing = eom.reaction("b")
    np.testing.assert_allclose(
        numbers(eom, bearing.force.components(N), **at), force + np.array([0, 2 * G, 0]), atol=1e-12
    )
    np.testing.assert_allclose(numbers(eom, bearing.torque.components(N), **at), 0, atol=1e-12)


def planetary():
    """Sun, carrier and planet about z; a ring that is held."""
    sun, carrier = kn.pin("sun", O, N, axis=N.z), kn.pin("carrier", O, N, axis=N.z)
    arm = carrier.point.at("arm", 0.3 * carrier.frame.x)
    planet = kn.pin("planet", arm, carrier.frame, axis=carrier.frame.z)
    mesh = [
        kn.gear_pair("inner", (planet.frame, planet.point), (sun.frame, sun.point), teeth=(20, 40), axis=N.z),
        kn.gear_pair("outer", (planet.frame, planet.point), (N, O), teeth=(20, 80), internal=True, axis=N.z),
    ]
    return sun, carrier, planet, mesh


def test_willis():
    """ω_sun − ω_c = −(z_ring/z_sun)(ω_ring − ω_c), the ring at rest."""
    sun, carrier, planet, mesh = planetary()
    bodies = [spinner(j, 1, 0.1) for j in (sun, carrier, planet)]
    system = kn.System(
        N, bodies=bodies, joints=[sun, carrier, planet], nonholonomic=mesh, loads=[kn.Torque(sun.frame, 3 * N.z)]
    )
    eom = kn.derive(system)
    state = kn.assemble(eom, q=[0.1, 0.2, 0.3], u={"u_sun": 6.0})
    assert state.u[next(iter(carrier.speeds))] == pytest.approx(2.0)
    assert state.u[next(iter(planet.speeds))] == pytest.approx((6 - 2) * -40 / 20)
    power, rate, drift, second = power_and_rate(system, 5)
    np.testing.assert_allclose(power, rate, atol=1e-13)
    np.testing.assert_allclose(drift, second, atol=1e-12)
    at = {"q": state.q, "u": state.u}
    teeth = eom.reaction("outer").torque, eom.reaction("outer").force
    assert teeth[0].is_zero
    # the whole: torque on the ground from the ring's teeth balances the torque on the sun and what accelerates
    alphas = numbers(eom, eom.accelerations, **at)
    momentum = 0.1 * alphas[0] + 0.1 * alphas[1] + 0.1 * (alphas[1] + alphas[2]) + 0.3**2 * alphas[1]
    pitch = 0.3 + 0.1  # ring radius 0.4 = 0.3·80/60
    tangent = eom.reaction("outer").force.dot(carrier.frame.y)
    assert numbers(eom, [tangent], **at)[0] * pitch + 3 == pytest.approx(momentum)


@pytest.mark.parametrize("seed", [1, 2])
def test_gears_on_a_carrier_that_moves_freely(seed):
    """On pins of one carrier: the rate of the configuration constraint is the power of the tooth forces, whatever the carrier does."""
    body = kn.free("carrier", O, N)
    f = body.frame
    a = kn.pin("a", body.point.at("A", 0.1 * f.y), f, axis=f.z)
    b = kn.pin("b", body.point.at("B", 0.1 * f.y + 0.3 * f.x - 0.4 * f.y), f, axis=f.z)
    rail = kn.slider("rail", body.point.at("R", 0.2 * f.z), f, axis=f.x)
    meshes = [
        kn.gear_pair("mesh", a, b, teeth=(1, 2)),
        kn.gear_pair("ring", a, b, teeth=(1, 2), internal=True),
        kn.rack_and_pinion("rack", a, rail, radius=0.25, phase=0.3),
        kn.rack_and_pinion("back", a, rail, radius=0.25, along=-f.x, axis=-f.z),
    ]
    bodies = [spinner(j, 1, 0.1) for j in (body, a, b, rail)]
    power, rate, drift, second = power_and_rate(
        kn.System(N, bodies=bodies, joints=[body, a, b, rail], holonomic=meshes), seed
    )
    np.testing.assert_allclose(power, rate, atol=1e-13)
    np.testing.assert_allclose(drift, second, atol=1e-12)


def test_a_pinion_turns_about_a_unit_vector():
    sides = (N.rotate("W", kn.coordinate("turn"), N.z), O), kn.slider("rail", O, N, axis=N.x)
    with pytest.raises(kn.ModelError, match=r"axis of the pinion of 'rack', got 2 N.z of length 2"):
        kn.rack_and_pinion("rack", *sides, radius=0.2, axis=2 * N.z)


@pytest.mark.parametrize("sign", [1, -1])
def test_rack_and_pinion_on_the_ground(sign):
    """(J + m r²) α = T; the tooth force accelerates the rack; turning about +z moves it along `along`."""
    pinion = kn.pin("pinion", O, N, axis=N.z)
    rack = kn.slider("rack", O.at("below", -sign * 0.2 * N.y), N, axis=N.x)
    mesh = kn.rack_and_pinion("mesh", pinion, rack, radius=0.2, along=sign * N.x)
    loads = [kn.Torque(pinion.frame, 3 * N.z)]
    eom = kn.derive(
        kn.System(
            N,
            bodies=[spinner(pinion, 1, 0.05), spinner(rack, 4, 1)],
            joints=[pinion, rack],
            loads=loads,
            holonomic=mesh,
        )
    )
    state = kn.assemble(eom, q={"q_pinion": 0.5}, u={"u_pinion": 1.0})
    at = {"q": state.q, "u": state.u}
    assert state.q[rack.coordinates[0]] == pytest.approx(sign * 0.1)
    alpha = 3 / (0.05 + 4 * 0.04)
    np.testing.assert_allclose(numbers(eom, eom.accelerations, **at), [alpha, sign * 0.2 * alpha])
    push = numbers(eom, eom.reaction("mesh").force.components(N), **at)
    np.testing.assert_allclose(push, [-sign * 4 * 0.2 * alpha, 0, 0], atol=1e-13)
    np.testing.assert_allclose(numbers(eom, eom.reaction("rack").force.components(N), **at), 0, atol=1e-13)
    np.testing.assert_allclose(numbers(eom, eom.reaction("pinion").force.components(N), **at), -push, atol=1e-13)


a, b = kn.pin("a", O, N, axis=N.z), kn.pin("b", O.at("P", D * N.x), N, axis=N.z)
high = kn.pin("high", O.at("Q", D * N.x + D * N.z), N, axis=N.z)
rail = kn.slider("rail", O, N, axis=N.x)
roving = kn.pin("roving", O.at("R", kn.coordinate("s") * N.x), N, axis=N.z)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.gear_pair("g", rail, b, teeth=(1, 2)), "gears on pins for 'g', got 'rail', a slider"),
        (lambda: kn.gear_pair("g", a, O, teeth=(1, 2)), r"a pin joint or \(frame, centre\) for 'g'"),
        (lambda: kn.gear_pair("g", (a.frame, O), b, teeth=(1, 2)), "axis=unit vector for the gears 'g'"),
        (lambda: kn.gear_pair("g", a, high, teeth=(1, 2)), "one plane across the axis, got them 0.6 m apart"),
        (lambda: kn.gear_pair("g", a, roving, teeth=(1, 2)), "at a constant distance"),
        (lambda: kn.gear_pair("g", a, b, teeth=(2, 1), internal=True), "more on the ring"),
        (lambda: kn.rack_and_pinion("g", b, a, radius=1), "a slider joint for 'g', got 'a', a pin|axis= and along="),
        (lambda: kn.rack_and_pinion("g", (a.frame, O), rail, radius=1), "axis= and along= for 'g'"),
        (lambda: kn.rack_and_pinion("g", a, rail, radius=1, along=N.z), "across the pinion's axis"),
    ],
)
def test_faults_are_named(make, message):
    with pytest.raises(kn.ModelError, match=message):
        make()


@pytest.mark.parametrize("metre", [1e-12, 1e-6, 1.0, 1e6])
@pytest.mark.parametrize("lift", [1e-12, 0.1])
def test_one_plane_is_one_plane_in_any_units(metre, lift):
    """What rounding leaves of a lift is none, a tenth of the distance is one."""
    d = kn.parameter("d", 0.6 * metre)
    other = kn.pin("other", O.at("Q", d * N.x + lift * d * N.z), N, axis=N.z)
    if lift < 1e-9:
        kn.gear_pair("g", a, other, teeth=(1, 2))
    else:
        with pytest.raises(kn.ModelError, match="one plane across the axis"):
            kn.gear_pair("g", a, other, teeth=(1, 2))


@pytest.mark.parametrize(
    ("line", "teeth", "internal", "expected"),
    [
        (D * N.x, (20, 40), False, "d*q1/3 + 2*d*q2/3"),
        (-D * N.y, (20, 40), True, "d*q1 - 2*d*q2"),
        (D / 2 * N.x, (20, 40), False, "d*q1/6 + d*q2/3"),
        (0.6 * D * N.x - 0.8 * D * N.y, (1, 2), False, "d*q1/3 + 2*d*q2/3"),
        ((R_A + R_B) * N.x, (R_A, R_B), False, "R_a*q1 + R_b*q2"),
        ((R_A - R_B) * N.x, (R_A, R_B), True, "R_a*q1 - R_b*q2"),
        ((R_B - R_A) * N.y, (R_A, R_B), True, "R_a*q1 - R_b*q2"),
    ],
)  # fmt: skip
def test_distances_and_radii_print_as_they_are(line, teeth, internal, expected):
    """d is no √d², and pitch radii that add up to the distance are those of the constraint."""
    a = kn.pin("a", O, N, axis=N.z, coordinates="q1")
    b = kn.pin("b", O.at("P", line), N, axis=N.z, coordinates="q2")
    mesh = kn.gear_pair("mesh", a, b, teeth=teeth, internal=internal)
    assert str(mesh.expr) == expected
    assert "sqrt" not in str([*mesh.forces, *mesh.torques])


def test_a_line_of_centres_that_turns_round():
    """The distance changes its sign: the constraint's rate is still the power of the tooth forces."""
    d = kn.parameter("d", 0.6, "m")
    a = kn.pin("a", O, N, axis=N.z)
    b = kn.pin("b", O.at("P", d * N.x), N, axis=N.z)
    mesh = kn.gear_pair("mesh", a, b, teeth=(20, 40))
    eom = kn.derive(kn.System(N, bodies=[spinner(a, 1, 0.03), spinner(b, 2, 0.5)], joints=[a, b], holonomic=mesh,
                              loads=[kn.Torque(a.frame, 5 * N.z)]))  # fmt: skip
    found = []
    for value in (0.6, -0.6):
        state = kn.assemble(eom, q={"q_a": 0.4}, u={"u_a": 2.0}, parameters={d: value})
        at = {"q": state.q, "u": state.u, "parameters": {d: value}}
        found.append(
            [
                *numbers(eom, eom.accelerations, **at),
                *np.abs(numbers(eom, eom.reaction("mesh").force.components(N), **at)),
            ]
        )
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)
    assert found[0][0] == pytest.approx(5 / (0.03 + 0.5 / 4))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (lambda a, b, s: kn.gear_pair("g", a, b, teeth=(1, 1)), "pin joint 'b' whose axis is along N.z, or against it"),
        (
            lambda a, b, s: kn.rack_and_pinion("g", a, s, radius=0.2, along=N.x),
            "slider joint 's' whose axis is along N.x",
        ),
        (
            lambda a, b, s: kn.rack_and_pinion("g", a, s, radius=0.2, axis=N.x, along=N.z),
            "pin joint 'a' whose axis is along N.x",
        ),
        (
            lambda a, b, s: kn.bevel_pair("g", a, a, teeth=(1, 1), radius=0.2, axes=(N.y, N.x)),
            "joint 'a' whose axis is along N.y",
        ),
    ],
)
def test_gears_turn_about_the_axes_of_their_joints(mesh, message):
    """A configuration constraint of coordinates about other axes would not be what the teeth do."""
    a, b = kn.pin("a", O, N, axis=N.z), kn.pin("b", O.at("B", N.y), N, axis=N.x)
    with pytest.raises(kn.ModelError, match=message):
        mesh(a, b, kn.slider("s", O.at("rail", N.y), N, axis=N.z))


def test_gears_about_an_axis_without_numbers():
    n = kn.parameter("n1") * N.x + kn.parameter("n2") * N.z
    a, b = (kn.pin(name, at, N, axis=n) for name, at in (("a", O), ("b", O.at("B", 2 * N.y))))
    assert kn.gear_pair("g", a, b, teeth=(1, 3), axis=-n).kind == "configuration"
