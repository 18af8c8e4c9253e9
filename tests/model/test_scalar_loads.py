# SPDX-License-Identifier: BSD-3-Clause
"""Loads made from a potential energy or a dissipation function."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
q1, q2 = kn.coordinates("q1 q2")
u1, u2, u3 = kn.speeds("u1:4")
k, c = kn.parameter("k", 3.0), kn.parameter("c", 0.4)
A = N.rotate("A", q1, N.z)
B = A.rotate("B", q1 + q2, A.x)
P = O.at("P", x * A.x)
BODY = kn.RigidBody("b", frame=B, mass_center=P, mass=2, inertia=kn.inertia(B, 1, 2, 3))
MIXED = {u1: q1.dt + x * q2.dt, u2: q2.dt, u3: 2 * x.dt + q1.dt}
V = k * q1**2 * kn.cos(q2) * x
R = c * q1.dt**2 / 2 + c * (x.dt - q2.dt) ** 4


def test_generalized_forces_are_minus_the_slopes():
    """F_r = −Σ ∂V/∂q_s W_sr and F_r = −∂R/∂u_r, with R written by speeds or by rates."""
    eom = kn.derive(
        kn.System(N, bodies=[BODY], speeds=MIXED, loads=[kn.Load.from_potential(V), kn.Load.from_dissipation(R)])
    )
    state = {"q": [0.3, 0.4, 0.5], "u": [0.6, -0.7, 0.8]}
    slopes, w = np.array(eom.evaluate(kn.gradient(V, eom.coordinates), **state)), eom.evaluate(eom.W, **state)
    lost = np.array(eom.evaluate(kn.gradient(eom.in_speeds(R), eom.speeds), **state))
    assert np.array(eom.evaluate(eom.Fr, **state)) == pytest.approx(-slopes @ w - lost, rel=1e-12)
    by_speeds = eom.system.replace(loads=[kn.Load.from_potential(V), kn.Load.from_dissipation(eom.in_speeds(R))])
    other = kn.derive(by_speeds)
    assert np.array(other.evaluate(other.Fr, **state)) == pytest.approx(-slopes @ w - lost, rel=1e-12)


def test_energy_and_power_know_them():
    eom = kn.derive(
        kn.System(N, bodies=[BODY], speeds=MIXED, loads=[kn.Load.from_potential(V), kn.Load.from_dissipation(R)])
    )
    state = {"q": [0.3, 0.4, 0.5], "u": [0.6, -0.7, 0.8]}
    rate, power = eom.evaluate([eom.time_derivative(eom.energy), eom.power], **state)
    assert rate == pytest.approx(power, rel=1e-12)
    assert eom.potential_energy is V


def test_a_spring_and_a_damper_are_the_same_by_their_functions():
    declared = [kn.torsional_spring(A, N, q1, k, N.z), kn.torsional_damper(A, N, c, N.z)]
    scalar = [kn.Load.from_potential(k * q1**2 / 2), kn.Load.from_dissipation(c * q1.dt**2 / 2)]
    one, other = (kn.derive(kn.System(N, bodies=[BODY], speeds=MIXED, loads=own)) for own in (declared, scalar))
    assert list(map(str, one.Fr)) == list(map(str, other.Fr))


def test_recursion_stays_where_forces_have_a_place():
    """A chain by joint angles is solved by recursion with a potential of them as without."""
    plain = (
        pendulums.system(7, relative=True)
        if "relative" in pendulums.system.__code__.co_varnames
        else pendulums.system(7)
    )
    own = kn.Load.from_potential(k * plain.coordinates[3] ** 2 / 2)
    eom = kn.derive(plain.replace(loads=(*plain.gravities, *plain.loads, own)))
    assert eom.route == kn.derive(plain).route


def test_with_euler_parameters():
    e = kn.coordinates("e0:4")
    C = N.rotate_euler_parameters("C", e)
    body = kn.RigidBody("body", frame=C, mass_center=O, mass=1, inertia=kn.inertia(C, 1, 2, 3))
    level = C.x.dot(N.z)
    eom = kn.derive(
        kn.System(
            N,
            bodies=[body],
            speeds=dict(zip((u1, u2, u3), C.angular_velocity(N).components(C), strict=True)),
            loads=[kn.Load.from_potential(k * level)],
        )
    )
    q = np.array([0.5, -0.1, 0.7, 0.2])
    state = {"q": q / np.linalg.norm(q), "u": [0.3, 0.2, -0.5]}
    rate, power = eom.evaluate([eom.time_derivative(eom.energy), eom.power], **state)
    assert rate == pytest.approx(power, abs=1e-13)
    assert np.array(eom.evaluate(eom.Fr, **state)) == pytest.approx(
        np.array(eom.evaluate(C.x.cross(N.z).components(C), **state)) * -3.0, abs=1e-12
    )


def test_pickles_and_other_speeds_keep_them():
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds=MIXED, loads=[kn.Load.from_dissipation(c * u1**2 / 2)]))
    other = kn.derive(eom.system.replace(speeds="rates"))
    state = {"q": [0.3, 0.4, 0.5], "u": [0.6, -0.7, 0.8]}
    rates = eom.evaluate(eom.rates, **state)
    assert eom.evaluate(eom.power, **state) == pytest.approx(
        other.evaluate(other.power, q=state["q"], u=rates), rel=1e-12
    )


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: kn.Load.from_potential(k * x.dt), "Load.from_dissipation"),
        (lambda: kn.Load.from_potential(k * u1), "with u1"),
        (lambda: kn.Load.from_dissipation(k * x), "Load.from_potential"),
    ],
)
def test_functions_of_the_wrong_kind(make, said):
    with pytest.raises(kn.ModelError, match=said):
        make()


def test_lengths_have_units():
    """A coordinate in m gets a force in N; one without a unit is a length where no frame turns by it."""
    r, s = kn.coordinate("r", unit="m"), kn.coordinate("s")
    stiff, far = kn.parameter("kappa", 5.0, "N/m"), kn.parameter("d", 0.2, "m")
    bead = kn.Particle("bead", O.at("Q", (r + far) * N.x + (s + far) * N.y), kn.parameter("m", 2.0, "kg"))
    own = kn.Load.from_potential(stiff * (r**2 + s**2 + r * s) / 2)
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", loads=[own]))
    assert np.array(eom.evaluate(eom.Fr, q=[0.3, 0.4], u=[0, 0])) == pytest.approx([-2.5, -2.75])


def test_frames_that_only_points_are_written_along_are_found():
    """A pendulum of a particle has a frame that turns by its angle: there the torque acts, and no point is added."""
    bob = kn.Particle("bob", O.at("W", -A.y), 1.0)
    system = kn.System(N, bodies=[bob], speeds="rates", loads=[kn.Load.from_potential(k * q1**2 / 2)])
    assert [p.name for p in system.points] == ["O", "W"]
    assert [f.name for f, _ in system.loads[0].torques] == ["A"]


def test_speeds_that_the_system_does_not_define():
    with pytest.raises(kn.ModelError, match=r"speeds that the system defines \(none, as all are rates\), got u1"):
        kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Load.from_dissipation(c * u1**2)])
    with pytest.raises(kn.ModelError, match="got other"):
        kn.System(N, bodies=[BODY], speeds=MIXED, loads=[kn.Load.from_dissipation(c * kn.speed("other") ** 2)])


def test_coordinates_that_nothing_moves_by():
    stray = kn.Load.from_potential(k * kn.coordinate("stray") ** 2)
    with pytest.raises(kn.KaneError, match="stray"):
        kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[stray]))


@pytest.mark.parametrize("carried", [False, True])
def test_dissipation_by_an_angular_velocity_is_a_torque(carried):
    """R = c ω·ω/2 of a ball joint, by the joint's speeds or by ω, is the torque −c ω of a damper; the base feels the opposite."""
    hinge = kn.pin("hinge", O, N, axis=N.x)
    joint = kn.ball("ball", hinge.point if carried else O, hinge.frame if carried else N)
    joints = [hinge, joint] if carried else [joint]
    bodies = [
        kn.RigidBody(j.name, frame=j.frame, mass_center=j.point, mass=1, inertia=kn.inertia(j.frame, 1, 2, 2.5))
        for j in joints
    ]
    w = joint.angular_velocity
    ways = [
        kn.torque_pair(joint.frame, joint.parent, -c * w),
        kn.Load.from_dissipation(c * w.dot(w) / 2),
        kn.Load.from_dissipation(c * sum(u * u for u in joint.speeds) / 2),
    ]
    q, u = [0.3, 0.6, 0.0, 0.0, 0.8][not carried :], [0.5, 1.0, 2.0, 3.0][not carried :]
    forces = []
    for load in ways:
        eom = kn.derive(kn.System(N, bodies=bodies, joints=joints, loads=[load]))
        forces.append(np.array(eom.evaluate(eom.Fr, q=q, u=u)))
    assert np.abs(forces[0]).max() > 0.3
    assert forces[1] == pytest.approx(forces[0], rel=1e-12)
    assert forces[2] == pytest.approx(forces[0], rel=1e-12)


def test_dissipation_by_the_angular_velocity_of_a_frame_without_a_body():
    e = kn.coordinates("e0:4")
    C = N.rotate_euler_parameters("C", e)
    w = C.angular_velocity(N)
    particles = [kn.Particle(a, O.at(a, v), 2) for a, v in (("X", C.x), ("Y", 2 * C.y))]
    speeds = dict(zip((u1, u2, u3), w.components(C), strict=True))
    eom = kn.derive(
        kn.System(N, bodies=particles, speeds=speeds, loads=[kn.Load.from_dissipation(c * w.dot(C.y) ** 2)])
    )
    forces = np.array(eom.evaluate(eom.Fr, q=[0.6, 0, 0.8, 0], u=[1, 2, 3]), dtype=float)
    assert forces == pytest.approx([0, -2 * 0.4 * 2, 0], abs=1e-14)


@pytest.mark.parametrize("rate", [x.dt.dt, kn.state("activation").dt, kn.input("T").dt])
def test_a_dissipation_function_of_other_rates_alone_is_refused(rate):
    with pytest.raises(kn.errors.ModelError, match="Expected a dissipation function of rates or speeds"):
        kn.Load.from_dissipation(c * rate**2)


@pytest.mark.parametrize("spring", [False, True])
def test_a_potential_with_an_input_moves_what_it_should(spring):
    """q̈ = −k (q − r): the work counts as power, as the rate of the input is not known; of an input that places, it is."""
    r, x0, v0 = kn.input("r"), 0.7, 0.3
    bob = kn.Particle("bob", O.at("bob", x * N.x), 1)
    load = kn.Load.from_potential(4.0 * (x - r) ** 2 / 2)
    if spring:
        load = kn.torsional_spring(N.rotate("turn", x, N.z), N, x - r, 4.0, N.z)
    eom = kn.derive(kn.System(N, bodies=[bob], speeds={u1: x.dt}, loads=[load]))
    assert eom.system.inputs == (r,)
    sol = kn.simulate(eom, (0, 2), q=[x0], u=[v0], inputs={r: lambda t: 0.5 * np.sin(3 * t)}, rtol=1e-10, atol=1e-12)
    a = 4 * 0.5 / (4 - 9)  # of the particular solution a sin 3t
    expected = x0 * np.cos(2 * sol.t) + (v0 - 3 * a) / 2 * np.sin(2 * sol.t) + a * np.sin(3 * sol.t)
    np.testing.assert_allclose(sol.q[:, 0], expected, atol=1e-8)
    placed = kn.linear_spring(bob.point, O.at("hand", r * N.x), 4.0)
    assert kn.System(N, bodies=[bob], speeds={u1: x.dt}, loads=[placed, load]).loads[0].potential is not None
