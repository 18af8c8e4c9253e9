# SPDX-License-Identifier: BSD-3-Clause
"""Nonholonomic classics of the gallery against closed forms and against Newton and Euler written for each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import (
    car_with_trailer,
    chaplygin_sleigh,
    furuta_pendulum,
    knife_edge,
    rattleback,
    rolling_disk,
    snakeboard,
    sphere_on_turntable,
)
from tests.oracles.compare import error
from tests.oracles.loops.contacts import rolling_sphere, rolling_wheel
from tests.oracles.loops.equations import solve
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, Twist, mark, turning

TIGHT = {"rtol": 1e-12, "atol": 1e-12}


def numbers(eom: kn.Equations, v: kn.Vector, state: dict[str, Any]) -> Any:
    return np.array(eom.evaluate(v.components(eom.system.inertial), **state))


def test_knife_edge_drifts_across_the_slope() -> None:
    """x = g sin α/(2 ω²) sin² ωt, y = g sin α/(2 ω²) (ωt − ½ sin 2ωt) from rest with spin ω (Neimark & Fufaev 1972, ch. 3)."""
    eom = kn.derive(knife_edge.system())
    sol = kn.simulate(eom, (0, 5), **knife_edge.START, **TIGHT)
    w = 2.0
    scale = 9.81 * np.sin(0.3) / (2 * w**2)
    np.testing.assert_allclose(sol["x"], scale * np.sin(w * sol.t) ** 2, atol=1e-9)
    np.testing.assert_allclose(sol["y"], scale * (w * sol.t - np.sin(2 * w * sol.t) / 2), atol=1e-9)
    # what holds the blade: m (v ω + g sin α sin θ), by Newton across it
    np.testing.assert_allclose(sol["S"], sol["v"] * w + 9.81 * np.sin(0.3) * np.sin(sol["theta"]), atol=1e-8)


def test_chaplygin_sleigh_in_closed_form() -> None:
    """With E = ½ (m v² + (J + m a²) ω²): v = c tanh(k t + k0), ω = ω_m / cosh(k t + k0), k = a c m / (J + m a²)."""
    eom = kn.derive(chaplygin_sleigh.system())
    sol = kn.simulate(eom, (0, 6), **chaplygin_sleigh.START, **TIGHT)
    m, J, a = 2.0, 0.1, 0.3
    v0, w0 = chaplygin_sleigh.START["u"]["v"], chaplygin_sleigh.START["u"]["w"]
    about = J + m * a**2
    c = np.sqrt(v0**2 + about / m * w0**2)
    k = a * c * m / about
    phase = k * sol.t + np.arctanh(v0 / c)
    np.testing.assert_allclose(sol["v"], c * np.tanh(phase), atol=1e-9)
    np.testing.assert_allclose(sol["w"], c * np.sqrt(m / about) / np.cosh(phase), atol=1e-9)


def test_sphere_on_a_turntable_runs_on_a_circle() -> None:
    """v = v_0 turned by 2/7 Ω t (homogeneous sphere); the spin about the vertical stays."""
    eom = kn.derive(sphere_on_turntable.system())
    sol = kn.simulate(eom, (0, 8), **sphere_on_turntable.START, **TIGHT)
    angle = 2 / 7 * 3.0 * sol.t
    vx, vy = 0.1, 0.2
    np.testing.assert_allclose(sol["u_x"], vx * np.cos(angle) - vy * np.sin(angle), atol=1e-9)
    np.testing.assert_allclose(sol["u_y"], vx * np.sin(angle) + vy * np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(sol["w_z"], 1.0, atol=1e-9)
    e = np.array([sol[f"e{i}"] for i in range(4)])
    np.testing.assert_allclose((e**2).sum(axis=0), 1, atol=1e-12)
    assert max(np.abs(r).max() for r in sol.constraint_residuals.values()) < 1e-12
    assert sol.energy_check.relative < 1e-9  # the table does work


@pytest.mark.parametrize("seed", range(3))
def test_sphere_against_newton_and_euler(seed: int) -> None:
    eom = kn.derive(sphere_on_turntable.system())
    rng = np.random.default_rng(seed)
    e = rng.normal(size=4)
    q = dict(zip(("x", "y", "e0", "e1", "e2", "e3"), [*rng.normal(size=2), *(e / np.linalg.norm(e))], strict=True))
    start = kn.assemble(eom, q=q, u=dict(zip(("u_x", "u_y", "w_z"), rng.normal(size=3), strict=True)))
    state: dict[str, Any] = {"q": start.q, "u": start.u, "t": 0.4}
    body = eom.system.rigid_bodies[0]
    axes = np.column_stack([numbers(eom, a, state) for a in (body.frame.x, body.frame.y, body.frame.z)])
    r = numbers(eom, body.mass_center.position(body.mass_center.root()), state)
    twist = Twist(
        numbers(eom, eom.velocities[body.mass_center], state), numbers(eom, eom.angular_velocities[body.frame], state)
    )
    joint = Joint(
        (GROUND, 0),
        (mark(np.zeros(3), np.array([0.0, 0.0, 1.0])), Mark()),
        rolling_sphere(0.05),
        turning(np.array([0.0, 0.0, 1.0]), 3.0),
    )
    inertia = 0.4 * 0.4 * 0.05**2 * np.eye(3)
    found = solve([Body(0.4, inertia)], [joint], [Pose(r, axes)], [twist], gravity=np.array([0.0, 0.0, -9.81]), t=0.4)
    assert found.drift < 1e-12
    assert error(numbers(eom, eom.point_accelerations[body.mass_center], state), found.a[0]) < 1e-10
    assert error(numbers(eom, eom.angular_accelerations[body.frame], state), found.alpha[0]) < 1e-10
    assert error(eom.evaluate(list(eom.reactions), **state), found.reactions[0].force) < 1e-10


def test_rolling_disk_against_newton_and_euler() -> None:
    """Accelerations and contact forces at 100 random states."""
    disk = rolling_disk.model(contact="rolling")
    eom = kn.derive(disk.system)
    rng = np.random.default_rng(1)
    inertia = 1.2 * 0.3**2 * np.diag([0.25, 0.25, 0.5])
    floor = mark(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    joint = Joint((GROUND, 0), (floor, mark(np.zeros(3), np.array([0.0, 0.0, 1.0]))), rolling_wheel(0.3))
    for _ in range(100):
        q = dict(zip(disk.q, rng.uniform(-1.2, 1.2, 5), strict=True))
        start = kn.assemble(eom, q=q, u=dict(zip(disk.u[:3], rng.uniform(-4, 4, 3), strict=True)))
        state: dict[str, Any] = {"q": start.q, "u": start.u}
        C = disk.C
        axes = np.column_stack([numbers(eom, a, state) for a in (C.x, C.y, C.z)])
        pose = Pose(numbers(eom, disk.Cs.position(disk.O), state), axes)
        twist = Twist(numbers(eom, eom.velocities[disk.Cs], state), numbers(eom, eom.angular_velocities[C], state))
        found = solve([Body(1.2, inertia)], [joint], [pose], [twist], gravity=np.array([0.0, 0.0, -9.81]))
        assert found.drift < 1e-11
        assert error(numbers(eom, eom.point_accelerations[disk.Cs], state), found.a[0]) < 1e-10
        assert error(numbers(eom, eom.angular_accelerations[C], state), found.alpha[0]) < 1e-10
        normal, fx, fy = eom.evaluate(list(eom.reactions), **state)
        assert error([fx, fy, normal], found.reactions[0].force) < 1e-10


def test_rattleback_against_newton_and_euler() -> None:
    """I ω̇ + ω × Iω = ρ × F and m a = F − m g n in the body's axes, with the contact ρ(n) from the mass centre and v = −ω × ρ."""
    eom = kn.derive(rattleback.system())
    rng = np.random.default_rng(4)
    semi, h, g = np.array([0.2, 0.03, 0.02]), np.array([0, 0, 0.01]), 9.81
    inertia = np.array([[2e-4, -0.2e-4, 0], [-0.2e-4, 16e-4, 0], [0, 0, 17e-4]])
    B = eom.system.rigid_bodies[0].frame
    N = eom.system.inertial
    for _ in range(20):
        q = dict(zip(("q1", "q2", "q3", "x", "y"), rng.uniform(-0.5, 0.5, 5), strict=True))
        start = kn.assemble(eom, q=q, u=dict(zip(("u1", "u2", "u3"), rng.normal(size=3), strict=True)))
        state: dict[str, Any] = {"q": start.q, "u": start.u}
        n = np.array(eom.evaluate([N.z.dot(a) for a in (B.x, B.y, B.z)], **state))
        w = np.array([start.u[u] for u in eom.speeds[:3]])
        size = np.sqrt(((semi * n) ** 2).sum())
        n_dot = -np.cross(w, n)
        rho = -(semi**2) * n / size + h
        rho_dot = -(semi**2) * n_dot / size + semi**2 * n * (semi**2 * n * n_dot).sum() / size**3
        # unknown ω̇: m (−ω̇ × ρ − ω × ρ̇ − ω × (ω × ρ)) = F − m g n, m = 1
        tilde = np.array([[0, -rho[2], rho[1]], [rho[2], 0, -rho[0]], [-rho[1], rho[0], 0]])
        rest = -np.cross(w, rho_dot) - np.cross(w, np.cross(w, rho)) + g * n
        spin = np.linalg.solve(inertia - tilde @ tilde, np.cross(rho, rest) - np.cross(w, inertia @ w))
        force = tilde @ spin + rest
        assert error(eom.evaluate([u.dt for u in eom.speeds[:3]], **state), spin) < 1e-10
        assert eom.evaluate(eom.reactions[0], **state) == pytest.approx(n @ force, rel=1e-10)


@pytest.mark.slow
def test_the_rattleback_turns_back() -> None:
    eom = kn.derive(rattleback.system())
    sol = kn.simulate(eom, (0, 8), **rattleback.START)
    assert sol["u3"][0] == -5
    assert sol["u3"].max() > 4
    assert sol.energy_check.relative < 1e-6
    other = {**rattleback.START, "u": {"u1": 0.0, "u2": 0.0, "u3": 5.0}}
    assert kn.simulate(eom, (0, 4), **other)["u3"].min() > 4.5  # the way it likes


def test_snakeboard_by_its_momentum() -> None:
    """About the instantaneous centre of the axles the constraints do no work, so that the total spin follows from the torques alone.

    With both axles straight across the board (φ = 0) only x and the spins move: (J + J_r + 2 J_w) θ̈ = 0 is then held by the wheels.
    """
    eom = kn.derive(snakeboard.system())
    rng = np.random.default_rng(2)
    q = dict(zip((c.name for c in eom.coordinates), rng.uniform(-0.5, 0.5, 6), strict=True))
    given = dict(zip(("u_theta", "u_psi", "u_phi_b", "u_phi_f"), rng.normal(size=4), strict=True))
    start = kn.assemble(eom, q=q, u=given)
    state: dict[str, Any] = {"q": start.q, "u": start.u, "inputs": {"T_psi": 0.3, "T_phi_b": -0.1, "T_phi_f": 0.2}}
    m, J, J_r, J_w, l = 6.0, 0.016, 0.072, 0.0013, 0.2
    # Lagrange with multipliers, planar: coordinates x, y, theta, psi, phi_b, phi_f
    th, pb, pf = q["theta"], q["phi_b"], q["phi_f"]
    M = np.diag([m, m, J + J_r + 2 * J_w, J_r, J_w, J_w])
    for k, j in ((3, J_r), (4, J_w), (5, J_w)):
        M[2, k] = M[k, 2] = j
    A = np.zeros((2, 6))
    for row, (phi, arm) in enumerate(((pb, -l), (pf, l))):
        A[row, :3] = -np.sin(th + phi), np.cos(th + phi), arm * np.cos(phi)
    rates = {s.name[2:]: v for s, v in start.u.items()}
    bias = [
        -np.cos(th + p) * (rates["theta"] + pd) * rates["x"]
        - np.sin(th + p) * (rates["theta"] + pd) * rates["y"]
        - arm * np.sin(p) * pd * rates["theta"]
        for p, pd, arm in ((pb, rates["phi_b"], -l), (pf, rates["phi_f"], l))
    ]
    whole = np.block([[M, -A.T], [A, np.zeros((2, 2))]])
    expected = np.linalg.solve(whole, np.concatenate([[0, 0, 0, 0.3, -0.1, 0.2], -np.array(bias)]))
    assert error(eom.evaluate(list(eom.accelerations), **state), expected[:6]) < 1e-11
    assert error(eom.evaluate(list(eom.multipliers.values()), **state), expected[6:]) < 1e-10


def test_car_with_trailer_kinematics_and_a_steady_turn() -> None:
    """θ̇ = v tan δ/l and β̇ = −θ̇ − (v sin β + h θ̇ cos β)/d ... from the axles; in a steady turn the hitch angle stays."""
    eom = kn.derive(car_with_trailer.system())
    l, h, d, delta = 2.6, 0.8, 3.0, 0.2
    sol = kn.simulate(eom, (0, 20), **car_with_trailer.START)
    v, w = sol["u_v"], sol["w"]
    np.testing.assert_allclose(w, v * np.tan(delta) / l, rtol=1e-9)
    beta = sol["beta"]
    # velocity of the hitch across the trailer equals d times the trailer's spin
    hitch = -v * np.sin(beta) - h * w * np.cos(beta)
    np.testing.assert_allclose(hitch, d * (w + sol["w_t"]), atol=1e-9)
    assert np.ptp(beta[-20:]) < 1e-3  # steady at the end
    assert sol.energy_check.relative < 1e-8
    assert [r.name for r in eom.inputs] == ["delta", "delta'", "delta''", "F"]


def test_furuta_pendulum_against_cazzolato_and_prime() -> None:
    """M q̈ + … = τ of Cazzolato & Prime (2011), eqs. (33) and (34), for slender arms."""
    eom = kn.derive(furuta_pendulum.system())
    m1, l1, L1, J1, m2, l2, J2, b1, b2, g = 0.3, 0.15, 0.278, 2.48e-2, 0.075, 0.148, 3.86e-3, 1e-4, 2.8e-4, 9.81
    J1h, J2h = J1 + m1 * l1**2, J2 + m2 * l2**2
    J0h = J1h + m2 * L1**2
    rng = np.random.default_rng(3)
    for _ in range(20):
        t1, t2, d1, d2, tau = rng.uniform(-3, 3, 5)
        s, c, s2 = np.sin(t2), np.cos(t2), np.sin(2 * t2)
        # the angle of the pendulum is measured the other way round there: θ2 = −q2
        M = np.array([[J0h + J2h * s**2, -m2 * L1 * l2 * c], [-m2 * L1 * l2 * c, J2h]])
        f = np.array(
            [
                tau - b1 * d1 - m2 * L1 * l2 * s * d2**2 - d1 * d2 * s2 * J2h,
                -b2 * d2 + 0.5 * d1**2 * s2 * J2h - g * m2 * l2 * s,
            ]
        )
        found = eom.evaluate(list(eom.accelerations), q=[t1, t2], u=[d1, d2], inputs={"tau": tau})
        expected = np.linalg.solve(M, f)
        mirrored = np.linalg.solve(M * [[1, -1], [-1, 1]], f * [1, 1] + [2 * m2 * L1 * l2 * s * d2**2, 0])
        assert min(error(found, expected), error(found, mirrored)) < 1e-11
