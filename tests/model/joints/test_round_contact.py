# SPDX-License-Identifier: BSD-3-Clause
"""Spheres on spheres and cylinders, capsules and corners on planes: rates beside powers, Newton and Euler, closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from tests.model.joints.kinds import rigid
from tests.model.joints.rates import power_and_rate

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G = 9.81
TIGHT = {"rtol": 1e-12, "atol": 1e-13}
PLACES = {
    "on a ball": lambda a, b: ball_on_ball(a, b),
    "in a bowl": lambda a, b: ball_on_ball(a, b, inside=True),
    "told by y": lambda a, b: ball_on_ball(a, b, pole=N.y),
    "told by the other": lambda a, b: ball_on_ball(a, b, pole=a.frame.x),
    "on a cylinder": lambda a, b: on_cylinder(a, b),
    "in a pipe": lambda a, b: on_cylinder(a, b, inside=True),
}


def ball_on_ball(a: kn.Joint, b: kn.Joint, **more: Any) -> Any:
    """The ball b on the ball a."""
    return kn.joints.sphere_on_sphere("c", b.frame, b.point, a.frame, a.point, radius=0.1, other_radius=0.3, **more)


def on_cylinder(a: kn.Joint, b: kn.Joint, **more: Any) -> Any:
    """The ball b on the cylinder a, whose axis is x of its frame."""
    at = a.point.at("Q", 0.2 * a.frame.y)
    return kn.joints.sphere_on_cylinder(
        "c", b.frame, b.point, a.frame, at, axis=a.frame.x, radius=0.1, cylinder_radius=0.3, **more
    )


@pytest.mark.parametrize("place", PLACES)
def test_the_rate_of_each_constraint_is_the_power_of_its_forces(place: str) -> None:
    a, b = kn.free("a", O, N, child="A"), kn.free("b", O, N, child="B")
    contact = PLACES[place](a, b)
    bodies = [rigid(j.name, j.frame, j.point, 1, kn.inertia(j.frame, 1, 2, 2.5)) for j in (a, b)]
    system = kn.System(N, bodies=bodies, joints=[a, b], holonomic=contact.height, nonholonomic=contact.rolling)
    power, rate, drift, second = power_and_rate(system, 4)
    assert np.abs(rate).min() > 1e-3
    np.testing.assert_allclose(power, rate, atol=1e-12)
    np.testing.assert_allclose(drift, second, atol=1e-11)


def free_ball(name: str, m: float, J: float) -> tuple[Any, ...]:
    """A ball by its centre and Euler parameters, its speeds along fixed axes."""
    x, e = kn.coordinates(f"{name}_x {name}_y {name}_z"), kn.coordinates(f"{name}_e0:4", "1")
    B = N.rotate_euler_parameters(name, e)
    C = O.at(f"{name}*", x[0] * N.x + x[1] * N.y + x[2] * N.z)
    w, v = B.angular_velocity(N), C.velocity(N)
    u = kn.speeds(f"{name}_v1:4 {name}_w1:4")
    axes = (N.x, N.y, N.z)
    speeds = dict(zip(u, [*(v.dot(k) for k in axes), *(w.dot(k) for k in axes)], strict=True))
    body = kn.RigidBody(f"ball {name}", frame=B, mass_center=C, mass=m, inertia=kn.inertia(B, J, J, J))
    return B, C, body, speeds, (*x, *e)


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize("seed", [1, 2])
def test_two_balls_that_roll_on_each_other_beside_newton_and_euler(inside: bool, seed: int) -> None:
    """N n + F acts at the contact, where particles have equal velocities and, but for their turning, equal accelerations."""
    rng = np.random.default_rng(seed)
    m, J, r = rng.uniform(0.5, 2, 2), rng.uniform(0.01, 0.1, 2), np.array([0.1, 0.4])
    (B, C, b, ub, qb), (A, D, a, ua, qa) = (free_ball(k, float(m[i]), float(J[i])) for i, k in enumerate("BA"))
    place = kn.joints.sphere_on_sphere("c", B, C, A, D, radius=r[0], other_radius=r[1], inside=inside)
    system = kn.System(
        N, bodies=[b, a], speeds=ub | ua, loads=[kn.gravity(-G * N.z)], contacts=[kn.contact(place, 0.5)]
    )
    eom = kn.derive(system.in_modes({"c": "stick"}))
    out = rng.normal(size=3)
    out /= np.linalg.norm(out)
    sense = -1 if inside else 1
    n, apart = sense * out, r[1] - r[0] if inside else r[0] + r[1]
    arms = -r[0] * n, -r[1] * n if inside else r[1] * n
    place_a = rng.normal(size=3)
    v_a, w_b, w_a = rng.normal(size=(3, 3))
    v_b = v_a + np.cross(w_a, arms[1]) - np.cross(w_b, arms[0])
    q = dict.fromkeys((*qb, *qa), 0.0)
    q |= dict(zip(qb, [*(place_a + apart * out), 1, 0, 0, 0], strict=True))
    q |= dict(zip(qa, [*place_a, 1, 0, 0, 0], strict=True))
    u = dict(zip((*ub, *ua), [*v_b, *w_b, *v_a, *w_a], strict=True))
    found = np.array(eom.evaluate(list(eom.solved.accelerations), q=q, u=u), dtype=float)
    # accelerations by the force on the ball B, and what turning adds to that of the particles in contact
    turn = sense * (v_b - v_a) / apart
    added = np.cross(w_b, -r[0] * turn) - np.cross(w_a, (-r[1] if inside else r[1]) * turn)
    across = np.array([np.cross(np.eye(3)[k], arms[0]) for k in range(3)])
    other = np.array([np.cross(np.eye(3)[k], arms[1]) for k in range(3)])

    def accelerations(force: Any) -> Any:
        alpha_b, alpha_a = np.cross(arms[0], force) / J[0], np.cross(arms[1], -force) / J[1]
        return force / m[0] - np.array([0, 0, G]), alpha_b, -force / m[1] - np.array([0, 0, G]), alpha_a

    def apart_by(force: Any) -> Any:
        a_b, alpha_b, a_a, alpha_a = accelerations(force)
        return a_b + alpha_b @ across - a_a - alpha_a @ other + added

    # the normal one: d/dt of n·(v_b − v_a), centres alone, as turning of the balls has no part in it
    def closing(force: Any) -> float:
        a_b, _, a_a, _ = accelerations(force)
        return float(n @ (a_b - a_a) + turn @ (v_b - v_a))

    t = np.linalg.svd(n[None])[2][1:]

    def conditions(force: Any) -> Any:
        return np.array([closing(force), *(t @ apart_by(force))])

    zero = conditions(np.zeros(3))
    matrix = np.array([conditions(k) - zero for k in np.eye(3)]).T
    force = np.linalg.solve(matrix, -zero)
    np.testing.assert_allclose(found, np.concatenate(accelerations(force)), rtol=0, atol=1e-10 * np.abs(found).max())
    normal = float(eom.evaluate([eom.solved.reactions[0]], q=q, u=u)[0])
    assert normal == pytest.approx(force @ n, abs=1e-10 * np.abs(force).max())


def on_dome(radius: float, inertia: float, mu: Any) -> tuple[kn.Equations, Any]:
    """A ball on a fixed dome of the radius 1, in the plane."""
    x, y, a = kn.coordinates("x y a")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    J = inertia * radius**2 if radius else 1.0
    body = kn.RigidBody("ball", frame=B, mass_center=C, mass=1.0, inertia=kn.inertia(B, J, J, J))
    place = kn.joints.sphere_on_sphere("dome", B, C, N, O, radius=radius, other_radius=1.0)
    assert len([c for c in place.rolling if c.expr is not kn.expr.ZERO]) == 1
    dome = kn.contact(place, mu)
    return kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[dome])), dome


def test_a_particle_leaves_a_dome_at_two_thirds() -> None:
    """Without friction, from rest near the top: cos θ = (2/3) cos θ₀."""
    eom, _ = on_dome(0.0, 0.0, 0)
    top = 0.1
    sol = kn.simulate(eom, (0, 3), q=[np.sin(top), np.cos(top), 0], u=[0, 0, 0], **TIGHT)
    (leaves,) = (t for e, t in sol.events if e.name == "dome opens")
    k = int(np.flatnonzero(sol.t == leaves)[0])
    assert sol["y"][k] == pytest.approx(2 / 3 * np.cos(top), abs=1e-10)


def test_a_ball_that_rolls_off_a_dome_slips_before_it_leaves() -> None:
    """From rest at the top: 2 sin θ = μ (17 cos θ − 10), where F = (2/7) m g sin θ and N = m g (17 cos θ − 10)/7."""
    mu, r = 0.3, 0.2
    eom, dome = on_dome(r, 0.4, mu)
    top = 1e-3
    start = [(1 + r) * np.sin(top), (1 + r) * np.cos(top), 0]
    sol = kn.simulate(eom, (0, 5), q=start, u=[0, 0, 0], **TIGHT)
    words = [m["dome"] for _, m in sol.mode_history]
    assert words == ["stick", "slip", "separated"]
    slips = next(t for e, t in sol.events if e.name == "dome slips")
    k = int(np.flatnonzero(sol.t == slips)[0])
    c, s = sol["y"][k] / (1 + r), sol["x"][k] / (1 + r)
    assert 2 * s == pytest.approx(mu * (17 * c - 10 * np.cos(top)), abs=1e-9)
    before = np.arange(len(sol.t)) < k
    np.testing.assert_allclose(np.hypot(sol["x"], sol["y"])[before], 1 + r, rtol=0, atol=1e-11)
    c = sol["y"][before] / (1 + r)
    np.testing.assert_allclose(sol[dome.normal_force][before], G * (17 * c - 10 * np.cos(top)) / 7, rtol=0, atol=1e-9)


def test_a_ball_rolls_up_and_down_in_a_pipe() -> None:
    """It goes round at Ω, and up and down at Ω √(κ/(1 + κ)), from where its spin about the radius is none."""
    R, r, kappa, rate = 0.5, 0.1, 0.4, 12.0
    B, C, body, speeds, q = free_ball("B", 0.3, kappa * 0.3 * r**2)
    place = kn.joints.sphere_on_cylinder("pipe", B, C, N, O, axis=N.z, radius=r, cylinder_radius=R, inside=True)
    eom = kn.derive(
        kn.System(N, bodies=[body], speeds=speeds, loads=[kn.gravity(-G * N.z)], contacts=[kn.contact(place, 2.0)])
    )
    b = R - r
    sol = kn.simulate(
        eom,
        (0, 3),
        q=dict.fromkeys(q, 0.0) | {q[0]: b, q[3]: 1.0},
        u=dict(zip(speeds, [0, rate * b, 0, 0, 0, -rate * b / r], strict=True)),
        **TIGHT,
    )
    assert [m["pipe"] for _, m in sol.mode_history] == ["stick"]
    vertical = rate * np.sqrt(kappa / (1 + kappa))
    np.testing.assert_allclose(sol["B_x"] + 1j * sol["B_y"], b * np.exp(1j * rate * sol.t), rtol=0, atol=1e-9)
    deep = G / (1 + kappa) / vertical**2
    np.testing.assert_allclose(sol["B_z"], -deep * (1 - np.cos(vertical * sol.t)), rtol=0, atol=1e-9)


def test_capsules_and_corners() -> None:
    """A capsule's ends are spheres, and corners are particles; what has one place alone is no capsule."""
    j = kn.free("b", O, N, child="B")
    ends = [j.point.at(n, s * j.frame.x) for n, s in (("P", -1), ("Q", 1))]
    one, two = kn.joints.capsule_on_plane("c", j.frame, ends, O, radius=0.1, normal=N.z)
    sphere = kn.sphere_on_plane("c 2", j.frame, ends[1], O, radius=0.1, normal=N.z)
    assert [one.name, two.name] == ["c 1", "c 2"]
    assert two.height.expr is sphere.height.expr
    assert [c.expr for c in two.rolling] == [c.expr for c in sphere.rolling]
    corners = [
        j.point.fixed_in(j.frame, f"c{k}", x * j.frame.x + y * j.frame.y)
        for k, (x, y) in enumerate([(1, 0), (0, 1), (-1, 0)])
    ]
    places = kn.joints.corners_on_plane("t", corners, O, normal=N.z)
    assert [p.name for p in places] == ["t 1", "t 2", "t 3"]
    assert all(p.particle is c for p, c in zip(places, corners, strict=True))
    with pytest.raises(kn.ModelError, match="Expected 2 or more centres of the ends of 'c', got 1"):
        kn.joints.capsule_on_plane("c", j.frame, ends[:1], O, radius=0.1, normal=N.z)


def test_what_is_no_round_contact() -> None:
    j = kn.free("b", O, N, child="B")

    def at(**more: Any) -> Any:
        return kn.joints.sphere_on_sphere("c", j.frame, j.point, N, O, **({"radius": 0.1, "other_radius": 0.3} | more))

    with pytest.raises(kn.ModelError, match=r"radii of 'c' at or above zero, got -0.1"):
        at(radius=-0.1)
    with pytest.raises(kn.ModelError, match=r"radii of 'c' that are not both zero"):
        at(radius=0, other_radius=0)
    with pytest.raises(kn.ModelError, match=r"the radius of the hollow body of 'c' above that of the sphere"):
        at(radius=0.5, inside=True)
    with pytest.raises(kn.ModelError, match=r"an axis of a frame as the pole of 'c'"):
        at(pole=0.6 * N.x + 0.8 * N.y)
    with pytest.raises(kn.ModelError, match="apart from that of the other body"):
        kn.joints.sphere_on_sphere("c", N, O, N, O, radius=0.1, other_radius=0.3)
