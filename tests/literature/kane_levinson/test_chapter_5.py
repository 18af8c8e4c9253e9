# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 5: potential energy, dissipation functions, kinetic energy, inertia forces by it.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.literature.kane_levinson.world import N, O, derived, g, rigid


def bare(load: kn.Load) -> kn.Load:
    return kn.Load(load.name, load.forces, load.torques)


# 5.1 Potential energy -----------------------------------------------------------------------------------------------------


def test_double_pendulum_by_speeds_of_its_own() -> None:
    """V of two rods follows from F_r by the speeds of their ends: the heights of the centres."""
    q1, q2 = kn.coordinates("q1 q2")
    u1, u2 = kn.speeds("u1 u2")
    A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
    a, b = O.at("a", 0.4 * A.x), O.at("b", 0.8 * A.x + 0.3 * B.x)
    end = O.at("E", 0.8 * A.x + 0.6 * B.x)
    rods = [
        rigid("a", A, a, 2.0, kn.rod(A, 2.0, 0.8, axis=A.x)),
        rigid("b", B, b, 1.0, kn.rod(B, 1.0, 0.6, axis=B.x)),
    ]
    speeds = {u1: q1.dt, u2: end.velocity(N).dot(B.y)}
    eom = derived(rods, [kn.gravity(-g * N.y)], speeds)
    v = eom.find_potential().value
    rng = np.random.default_rng(1)
    for x, y in rng.uniform(-3, 3, (5, 2)):
        height = 2.0 * 0.4 * np.sin(x) + 0.8 * np.sin(x) + 0.3 * np.sin(y)
        assert kn.evaluate(v, {q1: x, q2: y}) == pytest.approx(g * height, abs=1e-12)


def test_gravitation_of_a_fixed_point() -> None:
    """−G M m/r of a force towards O in space, in cylindrical coordinates with z."""
    r, a, z = kn.coordinates("r a z")
    A = N.rotate("A", a, N.z)
    P = O.at("P", r * A.x + z * A.z)
    p = P.position(O)
    pull = kn.Force(P, -5.0 * p / kn.sqrt(p.dot(p)) ** 3, "pull")
    found = derived([kn.Particle("P", P, 2.0)], [pull]).find_potential()
    here, there = ({r: x, a: 0.3, z: y} for x, y in ((0.7, 1.1), (1.3, -0.4)))
    expected = -5.0 / np.hypot(0.7, 1.1) + 5.0 / np.hypot(1.3, -0.4)
    assert found.how == "closed form"
    assert kn.evaluate(found.value, here) - kn.evaluate(found.value, there) == pytest.approx(expected, rel=1e-12)


def test_spring_between_two_bodies() -> None:
    """½ k (|r| − l)² of the distance between a slider and a bob, found from the forces."""
    x, q = kn.coordinates("x q")
    A = N.rotate("A", q, N.z)
    S, B = O.at("S", x * N.x), O.at("B", -0.5 * A.y + 0.2 * N.x)
    eom = derived(
        [kn.Particle("S", S, 1.0), kn.Particle("B", B, 1.0)], [bare(kn.linear_spring(S, B, 30.0, 0.25, "spring"))]
    )
    v = eom.find_potential().value

    def energy(s: float, t: float) -> float:
        length = np.hypot(s - 0.2 - 0.5 * np.sin(t), 0.5 * np.cos(t))
        return float(15.0 * (length - 0.25) ** 2)

    change = kn.evaluate(v, {x: 0.9, q: 0.4}) - kn.evaluate(v, {x: -0.3, q: 1.1})
    assert change == pytest.approx(energy(0.9, 0.4) - energy(-0.3, 1.1), rel=1e-12)


def test_disk_rolling_down_an_incline() -> None:
    """Nonholonomic: an upright disk steered on an incline; F̃_r = −Σ ∂V/∂q_s (W_sr + …) with V = −m g x sin 0.3."""
    x, y, h, s = q = kn.coordinates("x y h s")
    D = N.rotate("D", h, N.z)
    W = D.rotate("W", s, D.x)
    C = O.at("C", x * N.x + y * N.y + 0.2 * N.z)
    T = C.fixed_in(W, "T", -0.2 * N.z)
    body = rigid("disk", W, C, 1.5, kn.thin_disk(W, 1.5, 0.2, axis=W.x))
    slope = kn.gravity(g * (np.sin(0.3) * N.x - np.cos(0.3) * N.z))
    eom = derived([body], [slope], nonholonomic=kn.rolling(T, normal=N.z, along=D.y), coordinates=q)
    v = eom.find_potential().value
    at = {"q": [0.1, 0.2, 0.7, 0.3], "u": dict(zip(eom.independent_speeds, (0.4, 0.9), strict=True))}
    slopes = np.array(eom.evaluate(list(kn.gradient(v, q)), **at))
    assert slopes == pytest.approx([-1.5 * g * np.sin(0.3), 0, 0, 0], abs=1e-12)
    n = len(eom.speeds)
    full, w, a_n = eom.evaluate([list(eom.Fr_nh[:2]), eom.W, eom.A_n], **at)
    names = [eom.speeds.index(u) for u in eom.independent_speeds], [eom.speeds.index(u) for u in eom.dependent_speeds]
    through = w[:, names[0]] + w[:, names[1]] @ a_n
    assert n == 4
    assert np.array(full) == pytest.approx(-slopes @ through, abs=1e-12)


def test_a_jet_has_none() -> None:
    """A thrust fixed in a body that moves in a plane derives from no potential energy; its torque about the mass centre would."""
    x, y, h = kn.coordinates("x y h")
    B = N.rotate("B", h, N.z)
    C = O.at("C", x * N.x + y * N.y)
    body = rigid("craft", B, C, 2.0, kn.inertia(B, 1, 1, 1))
    eom = derived([body], [kn.Load("jet", ((C, 4.0 * B.x),)), kn.Torque(B, 0.5 * N.z, "wheel")])
    with pytest.raises(kn.PotentialError, match="∂Q_"):
        eom.find_potential(["jet"])
    assert str(eom.find_potential(["wheel"]).value) == "-h/2"


# 5.2 Contributions, 5.3 dissipation ----------------------------------------------------------------------------------------


def test_contributions_add_up() -> None:
    """F_r = −Σ ∂V/∂q_s W_sr + what has none: gravity and a spring found one by one, a drive left over."""
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    P = O.at("P", 0.7 * A.x)
    spring = kn.Torque(A, -3.0 * (q - 0.2) * N.z, "spring")
    eom = derived(
        [kn.Particle("P", P, 2.0)], [kn.gravity(-g * N.y), spring, kn.Torque(A, kn.sin(kn.time) * N.z, "drive")]
    )
    parts = [eom.find_potential([name]).value for name in ("gravity", "spring", "drive")]
    v = sum(parts[:2])
    assert kn.evaluate(kn.diff(v, q), {q: 0.9}) == pytest.approx(2.0 * g * 0.7 * np.cos(0.9) + 3.0 * 0.7)
    assert kn.evaluate(parts[2], {q: 0.9, kn.time: 0.3}) == pytest.approx(-0.9 * np.sin(0.3))


def test_dashpot_and_drag() -> None:
    """Rayleigh's ½ c (q̇₁ − q̇₂)² and c |v|³/3 give c (q̇₁ − q̇₂) and c |v| v, whatever the speeds."""
    x, y = kn.coordinates("x y")
    u1, u2 = kn.speeds("u1 u2")
    beads = [kn.Particle("a", O.at("a", x * N.x), 1.0), kn.Particle("b", O.at("b", y * N.x), 1.0)]
    shock, drag = 2.5 * (x.dt - y.dt) ** 2 / 2, 0.4 * kn.sqrt(y.dt**2) ** 3 / 3
    loads = [kn.Load.from_dissipation(shock, "dashpot"), kn.Load.from_dissipation(drag, "drag")]
    eom = derived(beads, loads, {u1: x.dt + y.dt, u2: x.dt - y.dt})
    v1, v2 = 0.7, -1.2
    forces = np.array([-2.5 * (v1 - v2), 2.5 * (v1 - v2) - 0.4 * abs(v2) * v2])
    w = np.linalg.inv([[1, 1], [1, -1]])
    found = eom.evaluate(list(eom.Fr), q=[0, 0], u=[v1 + v2, v1 - v2])
    assert np.array(found) == pytest.approx(forces @ w, rel=1e-13)
    assert eom.evaluate(eom.power, q=[0, 0], u=[v1 + v2, v1 - v2]) == pytest.approx(forces @ [v1, v2], rel=1e-13)


# 5.4 Kinetic energy, 5.5 homogeneous functions ------------------------------------------------------------------------------


def test_ladder_on_a_wall() -> None:
    """A rod of length L sliding on a wall and the floor: K = m L² q̇²/6."""
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    C = O.at("C", 0.5 * (kn.cos(q) * N.x + kn.sin(q) * N.y))
    eom = derived([rigid("rod", A, C, 3.0, kn.rod(A, 3.0, 1.0, axis=A.x))], [])
    assert eom.evaluate(eom.kinetic_energy, q=[0.4], u=[1.3]) == pytest.approx(3.0 * 1.3**2 / 6, rel=1e-14)


def test_bead_on_a_spinning_wire() -> None:
    """K₂ = ½ m ṡ², K₁ = −m h Ω ṡ, K₀ = ½ m Ω² (s² + h²) of a bead on a wire at the distance h."""
    s = kn.coordinate("s")
    W = N.rotate("W", 0.8 * kn.time, N.z)
    eom = derived([kn.Particle("bead", O.at("B", s * W.x + 0.3 * W.y), 2.0)], [])
    parts = eom.evaluate(list(eom.kinetic_energy_parts), q=[0.5], u=[1.1])
    assert np.array(parts) == pytest.approx([1.1**2, -2.0 * 0.3 * 0.8 * 1.1, 0.64 * (0.25 + 0.09)], rel=1e-14)


def test_inertia_coefficients() -> None:
    """m_rs of a gyroscope's gimbals by 3-1-3 angles, against Σ of the squares written in NumPy."""
    a, b, c = kn.coordinates("a b c")
    F = N.rotate("F", a, N.z)
    G = F.rotate("G", b, F.x)
    R = G.rotate("R", c, G.z)
    eom = derived([rigid("rotor", R, O, 1.0, kn.inertia(R, 2.0, 2.0, 3.0))], [])
    k = eom.kinetic_energy_parts.K2
    x, da, db, dc = 0.6, 0.4, -0.9, 5.0
    expected = (2.0 * (db**2 + (da * np.sin(x)) ** 2) + 3.0 * (dc + da * np.cos(x)) ** 2) / 2
    assert eom.evaluate(k, q=[0.1, x, 0.2], u=[da, db, dc]) == pytest.approx(expected, rel=1e-13)


# 5.6 Inertia forces by the kinetic energy ------------------------------------------------------------------------------------


def test_sleigh_by_its_kinetic_energy() -> None:
    """F̃*_r = F*_r + Σ_D A_n[D, r] F*_D of a sleigh, against m(a u₂² − u̇₁) and −(I + m a²) u̇₂ − m a u₁ u₂."""
    x, y, h = kn.coordinates("x y h")
    u1, u2, u3 = kn.speeds("u1:4")
    B = N.rotate("B", h, N.z)
    K = O.at("K", x * N.x + y * N.y)
    C = K.at("C", 0.3 * B.x)
    body = rigid("sleigh", B, C, 2.0, kn.inertia(B, 1, 1, 0.7))
    v = K.velocity(N)
    speeds = {u1: v.dot(B.x), u2: h.dt, u3: v.dot(B.y)}
    eom = derived([body], [], speeds, nonholonomic=kn.no_slip(K, along=B.y), coordinates=(x, y, h))
    star = eom.Fr_star_by_energy
    whole = [star[0] + eom.A_n[0, 0] * star[2], star[1] + eom.A_n[0, 1] * star[2]]
    assert [str(u) for u in eom.independent_speeds] == ["u1", "u2"]
    found = eom.evaluate([*whole, *eom.Fr_star_nh], q=[0.1, 0.2, 0.5], u={u1: 0.7, u2: 1.9})
    d1, d2 = eom.evaluate(list(eom.accelerations[:2]), q=[0.1, 0.2, 0.5], u={u1: 0.7, u2: 1.9})
    expected = [2.0 * (0.3 * 1.9**2 - d1), -(0.7 + 2.0 * 0.09) * d2 - 2.0 * 0.3 * 0.7 * 1.9]
    assert np.array(found) == pytest.approx([*expected, *expected], abs=1e-12)


# Expansions ------------------------------------------------------------------------------------------------------------------


def test_rocking_half_cylinder() -> None:
    """V about the upright position of a body of radius R whose centre is h above the contact: ½ m g (R − h) q² and no q³."""
    q = kn.coordinate("q")
    m, R, h = kn.parameters("m R h")
    A = N.rotate("A", -q, N.z)
    C = O.at("C", R * q * N.x + R * N.y + (h - R) * A.y)
    eom = derived([rigid("body", A, C, m, kn.inertia(A, 1, 1, 1))], [kn.gravity(-g * N.y)])
    v = kn.taylor(eom.potential_energy, {q: 0}, 3)
    at = {m: 2.0, R: 0.5, h: 0.3}
    expected = [2.0 * g * (0.3 + (0.5 - 0.3) * x**2 / 2) for x in (0.0, 0.1, -0.1)]
    assert [kn.evaluate(v, {**at, q: x}) for x in (0.0, 0.1, -0.1)] == pytest.approx(expected, rel=1e-13)
