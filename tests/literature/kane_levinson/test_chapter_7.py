# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 7: integrals, checking functions, closed-form solutions, constraint forces, vibrations.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.literature.kane_levinson.world import N, O, derived, g, rigid


def names(eom: kn.Equations) -> set[str]:
    return {one.name for one in eom.integrals}


# 7.1 to 7.4 Integrals ----------------------------------------------------------------------------------------------------------


def test_energy_by_a_potential_that_nobody_declared() -> None:
    """Pendulum with a spiral spring whose torque alone is known: E = ½ m l² q̇² − m g l cos q + ¼ k q⁴."""
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    bob = kn.Particle("bob", O.at("P", -0.6 * A.y), 1.5)
    eom = derived([bob], [kn.gravity(-g * N.y), kn.Torque(A, -2.0 * q**3 * N.z, "spiral")])
    (one,) = eom.integrals
    change = eom.evaluate(one.value, q=[0.7], u=[1.1]) - eom.evaluate(one.value, q=[-0.2], u=[0.4])

    def energy(x: float, v: float) -> float:
        return float(0.75 * 0.36 * v**2 - 1.5 * g * 0.6 * np.cos(x) + 0.5 * x**4)

    assert change == pytest.approx(energy(0.7, 1.1) - energy(-0.2, 0.4), rel=1e-13)


def test_bead_on_a_turning_hoop_keeps_the_hamiltonian() -> None:
    """H = ½ m R² (θ̇² − Ω² sin² θ) − m g R cos θ; what turns the hoop does work, so that E is no integral."""
    th = kn.coordinate("theta")
    H = N.rotate("H", 6.0 * kn.time, N.z)
    P = O.at("P", 0.5 * (kn.sin(th) * H.x - kn.cos(th) * H.z))
    eom = derived([kn.Particle("bead", P, 0.3)], [kn.gravity(-g * N.z)])
    (one,) = eom.integrals
    assert one.name == "Hamiltonian"
    expected = 0.3 * 0.25 * (1.2**2 - 36 * np.sin(0.4) ** 2) / 2 - 0.3 * g * 0.5 * np.cos(0.4)
    assert eom.evaluate(one.value, q=[0.4], u=[1.2], t=0.9) == pytest.approx(expected, rel=1e-12)


def test_satellite_in_a_central_field() -> None:
    """r² φ̇ and the energy; with a tangential drag neither."""
    r, f = kn.coordinates("r f")
    A = N.rotate("A", f, N.z)
    P = O.at("P", r * A.x)
    pull = kn.Force(P, -4.0 / r**2 * A.x, "pull")
    eom = derived([kn.Particle("P", P, 1.0)], [pull], coordinates=(r, f))
    assert names(eom) == {"energy", "momentum of f"}
    drag = kn.Force(P, -1e-6 * P.velocity(N), "drag")
    assert names(derived([kn.Particle("P", P, 1.0)], [pull, drag], coordinates=(r, f))) == set()


def test_two_bodies_that_attract_each_other() -> None:
    """Linear and angular momentum of a pair in a plane, and the energy: as many as mechanics promises."""
    a, b, c, d = kn.coordinates("a b c d")
    P, Q = O.at("P", a * N.x + b * N.y), O.at("Q", c * N.x + d * N.y)
    pair = kn.linear_spring(P, Q, 3.0, 0.5)
    eom = derived([kn.Particle("P", P, 1.0), kn.Particle("Q", Q, 2.0)], [pair], coordinates=(a, b, c, d))
    found = names(eom)
    assert "energy" in found
    assert sum("linear momentum" in n for n in found) == 2
    assert any(n.startswith("angular momentum about O along N.z") for n in found)


def test_a_cylinder_that_rolls_on_a_cart() -> None:
    """Under a motion constraint: the momentum along the floor, and the energy."""
    x, s, h = kn.coordinates("x s h")
    cart = O.at("cart", x * N.x)
    C = cart.at("C", s * N.x + 0.1 * N.y)
    B = N.rotate("B", -h, N.z)
    wheel = rigid("wheel", B, C, 1.0, kn.inertia(B, 1, 1, 0.005))
    rolling = kn.motion_constraint("rolling", s.dt - 0.1 * h.dt)
    eom = derived([kn.Particle("cart", cart, 2.0), wheel], [], nonholonomic=rolling, coordinates=(x, s, h))
    found = names(eom)
    assert {"energy", "momentum of x"} <= found


# 7.5 Closed form ---------------------------------------------------------------------------------------------------------------


def test_free_symmetric_body() -> None:
    """ω₁ + i ω₂ turns at (1 − I₃/I) ω₃ in the body, without end."""
    e, w = kn.coordinates("e0:4"), kn.speeds("w1:4")
    B = N.rotate_euler_parameters("B", e)
    body = rigid("body", B, O, 1.0, kn.inertia(B, 2.0, 2.0, 1.2))
    eom = derived([body], [], dict(zip(w, B.angular_velocity(N).components(B), strict=True)))
    assert "speed w3" in names(eom)
    motion = kn.simulate(
        eom, (0, 2), q=[1, 0, 0, 0], u=[0.3, 0.1, 2.5], samples=21, rtol=1e-11, atol=1e-11, method="DOP853"
    )
    turned = (0.3 + 0.1j) * np.exp(1j * (1.2 / 2.0 - 1) * 2.5 * motion.t)
    assert motion.u[:, 0] + 1j * motion.u[:, 1] == pytest.approx(turned, abs=1e-9)


# 7.7 Constraint forces -----------------------------------------------------------------------------------------------------------


def test_tension_by_multipliers_and_by_auxiliary_speeds() -> None:
    """Side by side: λ of the constraint |OP| = l, a reaction brought into evidence (sec. 4.9), and m g cos θ + m l θ̇²."""
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    l, m, th, rate = 0.8, 1.5, 0.6, 1.7
    held = derived([kn.Particle("P", P, m)], [kn.gravity(-g * N.y)], holonomic=kn.distance(P, O, l), coordinates=(x, y))
    q = [l * np.sin(th), -l * np.cos(th)]
    u = [rate * l * np.cos(th), rate * l * np.sin(th)]
    (multiplier,) = held.multipliers.values()
    by_multiplier = abs(held.evaluate(multiplier, q=q, u=u))
    h = kn.coordinate("h")
    A = N.rotate("A", h, N.z)
    Q = O.at("Q", -l * A.y)
    tension = kn.reaction("T", at=Q, along=A.y)
    free = derived([kn.Particle("Q", Q, m)], [kn.gravity(-g * N.y)], reactions=[tension])
    by_speed = free.evaluate(tension, q=[th], u=[rate])
    assert by_speed == pytest.approx(m * g * np.cos(th) + m * l * rate**2, rel=1e-13)
    assert by_multiplier == pytest.approx(by_speed, rel=1e-12)


# 7.9 Vibrations -----------------------------------------------------------------------------------------------------------------


def pendulums() -> tuple[kn.Linear, kn.Equations]:
    q1, q2 = kn.coordinates("q1 q2")
    A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
    P = O.at("P", -0.5 * A.y)
    bobs = [kn.Particle("P", P, 1.0), kn.Particle("Q", P.at("Q", -0.5 * B.y), 1.0)]
    eom = derived(bobs, [kn.gravity(-g * N.y)])
    return kn.linearize(eom, q=[0, 0], u=[0, 0]), eom


def test_double_pendulum() -> None:
    """ω² = (2 ∓ √2) g/l, q₂ = ±√2 q₁."""
    modes = kn.normal_modes(pendulums()[0])
    assert modes.squares == pytest.approx((2 + np.array([-1, 1]) * np.sqrt(2)) * g / 0.5, rel=1e-12)
    assert modes.shapes[1] / modes.shapes[0] == pytest.approx([np.sqrt(2), -np.sqrt(2)], rel=1e-12)
    assert modes.shapes.T @ modes.M @ modes.shapes == pytest.approx(np.eye(2), abs=1e-12)
    assert modes.shapes.T @ modes.K @ modes.shapes == pytest.approx(np.diag(modes.squares), abs=1e-11)
    assert modes.frequencies == pytest.approx(sorted(m.frequency for m in pendulums()[0].modes), rel=1e-9)


def test_closed_form_motion_is_the_small_motion() -> None:
    """What normal coordinates give is what a simulation of the nonlinear equations does, to the square of the amplitude."""
    linear, eom = pendulums()
    modes, t = kn.normal_modes(linear), np.linspace(0, 1, 11)
    small = 1e-4
    x, v = small * np.array([1.0, -0.4]), small * np.array([0.3, 2.0])
    motion = kn.simulate(eom, (0, 1), q=list(x), u=list(v), samples=t, rtol=1e-11, atol=1e-15, method="DOP853")
    assert np.abs(motion.q - modes.motion(t, x, v)).max() < 1e-6 * small


def test_linear_molecule() -> None:
    """CO₂ along its axis: 0, k/m, k (1/m + 2/M); the whole drifts, η₀ = η̇₀ t."""
    a, b, c = kn.coordinates("a b c")
    k, m, M = 3.0, 1.6, 1.2
    points = [O.at(n, (x + at) * N.x) for n, x, at in zip("PQR", (a, b, c), (-1.0, 0.0, 1.0), strict=True)]
    bodies = [kn.Particle(p.name, p, w) for p, w in zip(points, (m, M, m), strict=True)]
    bonds = [kn.linear_spring(points[0], points[1], k, 1.0), kn.linear_spring(points[1], points[2], k, 1.0)]
    eom = derived(bodies, bonds, coordinates=(a, b, c))
    modes = kn.normal_modes(kn.linearize(eom, q=[0, 0, 0], u=[0, 0, 0]))
    assert modes.squares == pytest.approx([0, k / m, k * (1 / m + 2 / M)], abs=1e-9)
    assert modes.motion([2.0], [0, 0, 0], [0.1, 0.1, 0.1]) == pytest.approx(np.array([[0.2, 0.2, 0.2]]), abs=1e-6)


def test_a_mode_that_grows() -> None:
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    eom = derived([kn.Particle("P", O.at("P", 0.5 * A.y), 1.0)], [kn.gravity(-g * N.y)])
    modes = kn.normal_modes(kn.linearize(eom, q=[0], u=[0]))
    assert not modes.stable
    assert np.isnan(modes.frequencies).all()
    assert modes.motion([0.4], [1e-3], [0.0]) == pytest.approx(
        np.array([[1e-3 * np.cosh(np.sqrt(g / 0.5) * 0.4)]]), rel=1e-10
    )


def test_damping_and_gyroscopic_terms_have_no_normal_modes() -> None:
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    loads = [kn.gravity(-g * N.y), kn.torsional_damper(A, N, 0.1, N.z)]
    eom = derived([kn.Particle("P", O.at("P", -0.5 * A.y), 1.0)], loads)
    with pytest.raises(kn.SimulationError, match="without damping and gyroscopic terms"):
        kn.normal_modes(kn.linearize(eom, q=[0], u=[0]))
    with pytest.raises(kn.ArgumentError, match="Linearize first"):
        kn.normal_modes(eom)
