# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 6, from section 6.4 on: linearization, rest, steady motion, impulses, collisions.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.literature.kane_levinson.world import N, O, derived, g, rigid

# 6.4 Linearization -----------------------------------------------------------------------------------------------------------


def first_order(v: kn.Vector, at: dict[kn.Expr, int]) -> list[kn.Expr]:
    """Measure numbers along the inertial axes, terms of degree one and less in deviations."""
    return [kn.taylor(x, at, 1) for x in v.components(N)]


def summed(a: list[kn.Expr], b: list[kn.Expr]) -> kn.Expr:
    return sum((x * y for x, y in zip(a, b, strict=True)), start=kn.Rational(0))


def test_linearized_before_expansion_is_the_same_as_after() -> None:
    """Nonlinear velocities → partial velocities → linearized, times linearized F − m a: F_r + F*_r to first order.

    Velocities that are linearized before partial velocities are taken lose the stiffness of the weight.
    """
    q1, q2 = kn.coordinates("q1 q2")
    u1, u2 = kn.speeds("u1 u2")
    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", q2, A.z)
    P, Q = O.at("P", 0.7 * A.x), O.at("Q", 0.7 * A.x + 0.4 * B.x)
    bobs = [kn.Particle("P", P, 1.3), kn.Particle("Q", Q, 0.8)]
    eom = derived(bobs, [kn.gravity(g * N.x)], {u1: q1.dt + kn.cos(q2) * q2.dt, u2: q2.dt})
    small = (q1, q2, u1, u2, *map(eom.time_derivative, (u1, u2)))
    at = dict.fromkeys(small, 0)
    after = [kn.taylor(f + s, at, 1) for f, s in zip(eom.Fr, eom.Fr_star, strict=True)]
    before, early = [], []
    for r in eom.speeds:
        whole = too_soon = kn.Rational(0)
        for body in bobs:
            force = first_order(body.mass * (g * N.x - eom.point_accelerations[body.point]), at)
            whole += summed(first_order(eom.partial_velocities[body.point][r], at), force)
            too_soon += summed([kn.diff(x, r) for x in first_order(eom.velocities[body.point], at)], force)
        before.append(kn.taylor(whole, at, 1))
        early.append(too_soon)
    values = dict(zip(small, np.random.default_rng(2).uniform(-1, 1, 6), strict=True))
    ways = [[float(kn.evaluate(e, values)) for e in way] for way in (before, after, early)]
    assert ways[0] == pytest.approx(ways[1], rel=1e-12)
    assert ways[2] != pytest.approx(ways[1], rel=1e-3)


# 6.5 Rest --------------------------------------------------------------------------------------------------------------------


def test_rod_in_a_bowl() -> None:
    """A rod of length 3R/2 in a smooth bowl of radius R, over its rim: cos θ = (L + √(L² + 128 R²))/(16 R)."""
    th = kn.coordinate("theta")
    R, L = 1.0, 1.5
    e = kn.cos(th) * N.x - kn.sin(th) * N.y  # downwards from the rim at (R, 0) … the lower end at 2R cos θ along it
    rim = O.at("rim", -R * N.x)
    C = rim.at("C", (2 * R * kn.cos(th) - L / 2) * e)
    A = N.rotate("A", -th, N.z)
    eom = derived([rigid("rod", A, C, 1.0, kn.rod(A, 1.0, L, axis=A.x))], [kn.gravity(-g * N.y)])
    (condition,) = eom.equilibrium_conditions
    angle = np.arccos((L + np.sqrt(L**2 + 128 * R**2)) / (16 * R))
    assert kn.evaluate(condition, {th: angle}) == pytest.approx(0, abs=1e-13)
    assert abs(kn.evaluate(condition, {th: angle + 0.1})) > 0.1


def test_ladder_held_by_a_string() -> None:
    """Constraints by multipliers or by a dependent coordinate: F̃_r = 0 of a ladder on a spring, tan q = m g/(2 k L sin q)…"""
    q, x = kn.coordinates("q x")
    m, k, L = 2.0, 40.0, 1.0
    A = N.rotate("A", q, N.z)
    foot = O.at("F", x * N.x)
    top = foot.at("T", L * A.x)
    C = foot.at("C", L / 2 * A.x)
    spring = kn.Force(foot, -k * x * N.x, "spring")
    wall = kn.configuration_constraint("wall", top.position(O).dot(N.x))
    eom = derived(
        [rigid("ladder", A, C, m, kn.rod(A, m, L, axis=A.x))],
        [spring, kn.gravity(-g * N.y)],
        holonomic=wall,
        coordinates=(q, x),
        dependent_speeds=[],
    )
    (condition,) = eom.equilibrium_conditions
    for angle in (0.3, 0.8, 1.2):
        # power: k x ẋ with x = −L cos q, and the weight's
        moment = k * L**2 * np.cos(angle) * np.sin(angle) - m * g * L / 2 * np.cos(angle)
        share = 1.0 if str(eom.independent_speeds[0]) == "u_q" else 1 / (L * np.sin(angle))
        assert kn.evaluate(condition, {q: angle, x: -L * np.cos(angle)}) == pytest.approx(moment * share, rel=1e-12)


def test_no_rest_where_motion_is_prescribed() -> None:
    s = kn.coordinate("s")
    rail = kn.motion_constraint("drive", s.dt - kn.sin(kn.time))
    y = kn.coordinate("y")
    eom = derived([kn.Particle("P", O.at("P", s * N.x + y * N.y), 1.0)], [], nonholonomic=rail, coordinates=(s, y))
    with pytest.raises(kn.ModelError, match="steady_conditions"):
        _ = eom.equilibrium_conditions


# 6.6 Steady motion -------------------------------------------------------------------------------------------------------------


def test_conical_pendulum() -> None:
    """l Ω² cos θ = g."""
    p, th = kn.coordinates("p theta")
    A = N.rotate("A", p, N.z)
    B = A.rotate("B", -th, A.y)
    P = O.at("P", -0.8 * B.z)
    eom = derived([kn.Particle("P", P, 1.5)], [kn.gravity(-g * N.z)], coordinates=(p, th))
    W = kn.parameter("Omega")
    conditions = eom.steady_conditions({eom.speeds[0]: W, eom.speeds[1]: 0})
    angle, spin = 0.7, np.sqrt(g / (0.8 * np.cos(0.7)))
    values = [kn.evaluate(e, {th: angle, W: spin}) for e in conditions]
    assert np.array(values) == pytest.approx([0, 0], abs=1e-12)
    with pytest.raises(kn.ValueMissingError, match="coordinates and speeds"):
        eom.steady_conditions({"speed": 1})


def test_steady_precession_of_a_top() -> None:
    """A φ̇² cos θ − C n φ̇ + m g l = 0 has two rates of precession for one spin n."""
    f, th, s = kn.coordinates("f theta s")
    A = N.rotate("A", f, N.z)
    B = A.rotate("B", th, A.x)
    R = B.rotate("R", s, B.z)
    C = O.at("C", 0.2 * B.z)
    top = rigid("top", R, C, 1.2, kn.inertia(R, 0.01, 0.01, 0.006))
    u1, u2, u3 = kn.speeds("u1:4")
    eom = derived([top], [kn.gravity(-g * N.z)], {u1: f.dt, u2: th.dt, u3: R.angular_velocity(N).dot(B.z)})
    a, c, n, angle = 0.01 + 1.2 * 0.04, 0.006, 150.0, 0.5
    for rate in np.roots([a * np.cos(angle), -c * n, 1.2 * g * 0.2]).real:
        conditions = eom.steady_conditions({u1: rate, u2: 0, u3: n, th: angle})
        assert [kn.evaluate(e, {}) for e in conditions] == pytest.approx([0, 0, 0], abs=1e-10)


# 6.7 Motions that resemble rest --------------------------------------------------------------------------------------------------


def test_bead_on_a_turning_hoop() -> None:
    """cos θ = g/(R Ω²): relative rest in a hoop that is turned, with F + F* = 0 where nothing is at rest in N."""
    th = kn.coordinate("theta")
    H = N.rotate("H", 6.0 * kn.time, N.z)
    P = O.at("P", 0.5 * (kn.sin(th) * H.x - kn.cos(th) * H.z))
    eom = derived([kn.Particle("bead", P, 0.3)], [kn.gravity(-g * N.z)])
    (condition,) = eom.steady_conditions({eom.speeds[0]: 0})
    assert kn.evaluate(condition, {th: np.arccos(g / (0.5 * 36.0)), kn.time: 0.7}) == pytest.approx(0, abs=1e-13)
    assert kn.evaluate(condition, {th: 0.1, kn.time: 0.7}) == pytest.approx(
        0.3 * 0.5 * np.sin(0.1) * (0.5 * 36 * np.cos(0.1) - g)
    )


# 6.8 Impulses, 6.9 collisions ------------------------------------------------------------------------------------------------------


def ball() -> tuple[kn.Equations, kn.Point, tuple[kn.Expr, ...]]:
    x, y, z = kn.coordinates("x y z")
    e, w, v = kn.coordinates("e0:4"), kn.speeds("w1:4"), kn.speeds("v1:4")
    B = N.rotate_euler_parameters("B", e)
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    body = rigid("ball", B, C, 0.6, kn.solid_sphere(B, 0.6, 0.1))
    speeds = dict(zip((*v, *w), (*C.velocity(N).components(N), *B.angular_velocity(N).components(N)), strict=True))
    return derived([body], [], speeds), C.fixed_in(B, "K", -0.1 * N.z), (*v, *w)


BALL, CONTACT, SPEEDS = ball()
PLACE = {"x": 0, "y": 0, "z": 0.1, "e0": 1, "e1": 0, "e2": 0, "e3": 0}


def bounce(u: list[float], e: float, mu: float | tuple[float, float]) -> tuple[np.ndarray, kn.Impact]:
    blow = kn.impact(BALL, CONTACT, N.z, restitution=e, friction=mu, q=PLACE, u=u)
    return np.array([blow.u[s] for s in BALL.speeds]), blow


def test_ball_with_spin_that_grips() -> None:
    """Grip: the tangential impulse is (2/7) m times the velocity of the contact, which then rests."""
    u = [1.0, 0.5, -2.0, 3.0, -4.0, 5.0]
    after, blow = bounce(u, 0.7, 2.0)
    slip = np.array([1.0 - 0.1 * -4.0, 0.5 + 0.1 * 3.0])  # v + ω × (−r z)
    tangent = -2 / 7 * 0.6 * slip
    assert not blow.slips
    assert blow.normal == pytest.approx(0.6 * 1.7 * 2.0, rel=1e-13)
    assert blow.impulse == pytest.approx([*tangent, blow.normal], rel=1e-12)
    assert after[:3] == pytest.approx([1.0 + tangent[0] / 0.6, 0.5 + tangent[1] / 0.6, 1.4], rel=1e-12)


def test_ball_that_slips() -> None:
    """Slip: the impulse of friction is μ′ ν against the slip, which keeps its direction."""
    u = [5.0, 2.0, -2.0, 3.0, -4.0, 5.0]
    after, blow = bounce(u, 0.4, (0.2, 0.15))
    slip = np.array([5.0 + 0.4, 2.0 + 0.3])
    nu = 0.6 * 1.4 * 2.0
    assert blow.slips
    assert blow.impulse == pytest.approx([*(-0.15 * nu * slip / np.linalg.norm(slip)), nu], rel=1e-10)
    arm = np.array([0, 0, -0.1])
    turned = np.array(u[3:]) + np.cross(arm, blow.impulse) / (0.4 * 0.6 * 0.01)
    assert after[3:] == pytest.approx(turned, rel=1e-12)
    before_k, after_k = (0.3 * v[:3] @ v[:3] + 0.2 * 0.6 * 0.01 * v[3:] @ v[3:] for v in (np.array(u), after))
    assert blow.lost == pytest.approx(before_k - after_k, rel=1e-10)


def test_smooth_and_elastic_loses_nothing() -> None:
    _, blow = bounce([1.0, 0.5, -2.0, 3.0, -4.0, 5.0], 1.0, 0.0)
    assert blow.lost == pytest.approx(0, abs=1e-13)


def test_two_balls_in_line() -> None:
    """Masses 2 and 3 that meet at e = 0.5: v′ = (m₁ v₁ + m₂ v₂ ∓ e m (v₁ − v₂))/(m₁ + m₂)."""
    a, b = kn.coordinates("a b")
    P, Q = O.at("P", a * N.x), O.at("Q", b * N.x)
    eom = derived([kn.Particle("P", P, 2.0), kn.Particle("Q", Q, 3.0)], [])
    blow = kn.impact(eom, Q, N.x, other=P, restitution=0.5, q=[0, 0], u=[4.0, -1.0])
    assert list(blow.u.values()) == pytest.approx([(8 - 3 - 0.5 * 3 * 5) / 5, (8 - 3 + 0.5 * 2 * 5) / 5], rel=1e-13)
    assert blow.lost == pytest.approx(0.5 * 1.2 * 25 * (1 - 0.25), rel=1e-13)


def test_rod_on_ice_struck_at_its_end() -> None:
    """A rod falls flat on an edge at its end: Δv = ν/m, Δω = 6 ν/(m L)…, ν = m (1 + e) v/4."""
    x, y, h = kn.coordinates("x y h")
    A = N.rotate("A", h, N.z)
    C = O.at("C", x * N.x + y * N.y)
    rod = rigid("rod", A, C, 1.5, kn.rod(A, 1.5, 0.8, axis=A.x))
    end = C.fixed_in(A, "E", 0.4 * A.x)
    eom = derived([rod], [kn.gravity(-g * N.y)], coordinates=(x, y, h))
    blow = kn.impact(eom, end, N.y, restitution=0.6, q=[0, 0, 0], u=[0, -3.0, 0])
    nu = 1.5 * 1.6 * 3.0 / 4
    assert blow.normal == pytest.approx(nu, rel=1e-13)
    assert list(blow.u.values()) == pytest.approx([0, -3.0 + nu / 1.5, nu * 0.4 / (1.5 * 0.64 / 12)], rel=1e-12)


def test_constraints_hold_on() -> None:
    """A pendulum written in x and y under a constraint is struck as one by its angle."""
    x, y, h = kn.coordinates("x y h")
    P = O.at("P", x * N.x + y * N.y)
    B = N.rotate("B", h, N.z)
    Q = O.at("Q", 0.5 * B.x)
    free = derived([kn.Particle("Q", Q, 2.0)], [])
    held = derived([kn.Particle("P", P, 2.0)], [], holonomic=kn.distance(P, O, 0.5), coordinates=(x, y))
    place = 0.5 * np.array([np.cos(0.4), np.sin(0.4)])
    normal = (2 * N.x - N.y).normalized()
    one = kn.impact(free, Q, normal, restitution=0.3, q=[0.4], u=[2.0])
    velocity = 2.0 * np.array([-place[1], place[0]])
    other = kn.impact(held, P, normal, restitution=0.3, q=list(place), u=list(velocity))
    (rate,) = one.u.values()
    assert list(other.u.values()) == pytest.approx([-rate * place[1], rate * place[0]], rel=1e-11)


def test_what_is_no_blow() -> None:
    with pytest.raises(kn.SimulationError, match="approach each other"):
        bounce([0, 0, 1.0, 0, 0, 0], 0.5, 0.0)
    with pytest.raises(kn.ArgumentError, match="restitution from 0 to 1"):
        bounce([0, 0, -1.0, 0, 0, 0], 1.5, 0.0)


def test_sliding_friction_has_no_value_at_rest() -> None:
    s = kn.coordinate("s")
    P = O.at("P", s * N.x)
    drag = kn.Force(P, -0.3 * P.velocity(N).normalized(), "friction")
    with pytest.raises(kn.ModelError, match="that are defined at rest"):
        _ = derived([kn.Particle("P", P, 1.0)], [drag]).equilibrium_conditions
