# SPDX-License-Identifier: BSD-3-Clause
"""Motions with contacts in space, on incline, belt, turning and shaken tables, by ropes, stops and clutches, beside closed forms."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

import kane as kn

G = 9.81
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def times(sol, what):
    return [t for e, t in sol.events if e.name == what]


def words(sol, name):
    return [modes[name] for _, modes in sol.mode_history]


def ground():
    N = kn.Frame("N")
    return N, kn.Point("O", fixed_in=N)


def inclined_block(mu, slope, **laws):
    """A particle whose coordinates are horizontal and vertical, on an incline."""
    N, O = ground()
    I = N.rotate("I", slope, N.z)
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=I.y), mu, **laws)
    bodies = [kn.Particle("block", P, 2.0)]
    loads = [kn.gravity(-G * N.y)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor])), floor


def crate(mu, slope, w=0.2, h=0.1, **laws):
    """A box of 1 kg, half width w and half height h, with both lower corners on an incline."""
    N, O = ground()
    I = N.rotate("I", slope, N.z)
    x, y, a = kn.coordinates("q1:4")
    B = I.rotate("B", a, I.z)
    C = O.at("C", x * I.x + y * I.y)
    inertia = kn.inertia(B, 1, 1, (w * w + h * h) / 3)
    corners = [C.fixed_in(B, name, s * w * B.x - h * B.y) for name, s in (("l", -1), ("r", 1))]
    contacts = [kn.contact(kn.joints.point_on_plane(p.name, p, O, normal=I.y), mu, **laws) for p in corners]
    bodies = [kn.RigidBody("box", frame=B, mass_center=C, mass=1.0, inertia=inertia)]
    loads = [kn.gravity(-G * N.y)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts)), contacts


# Blocks ----------------------------------------------------------------------------------------------------------------------


def test_a_block_across_its_coordinates_sticks():
    """On an incline along neither of its coordinates it does not move at all in 1,000 s."""
    eom, floor = inclined_block(0.5, 0.3)
    sol = kn.simulate(eom, (0, 1000), q=[2 * np.cos(0.3), 2 * np.sin(0.3)], u=[0, 0])
    assert not sol.events
    assert np.ptp(sol["x"]) == 0
    assert np.ptp(sol["y"]) == 0
    assert not sol.u.any()
    np.testing.assert_allclose(sol[floor.normal_force], 2 * G * np.cos(0.3), rtol=1e-13)
    np.testing.assert_allclose(np.abs(sol[floor.friction_forces[0]]), 2 * G * np.sin(0.3), rtol=1e-13)


@pytest.mark.slow
def test_a_crate_sticks_on_an_incline():
    """Two corners stick for 1,000 s by one row: exactly 0, friction in proportion to the normal forces."""
    slope, w, h = 0.3, 0.2, 0.1
    eom, (left, right) = crate(0.5, slope, w, h)
    sol = kn.simulate(eom, (0, 1000), q=[0, h, 0], u=[0, 0, 0])
    assert not sol.events
    assert not np.ptp(sol.states, axis=0).any()
    weight = G * np.array([np.cos(slope), np.sin(slope)])
    for c, sign in ((left, 1), (right, -1)):
        n = weight[0] / 2 + sign * weight[1] * h / (2 * w)
        np.testing.assert_allclose(sol[c.normal_force], n, rtol=1e-12)
        np.testing.assert_allclose(sol[c.friction_forces[0]], weight[1] * n / weight[0], rtol=1e-12)


@pytest.mark.parametrize("static", [0.25, 0.4])
def test_a_block_thrown_up_stays_or_comes_back(static):
    """μ_k < tan α: it stops after v/a₊, and stays if μ_s > tan α; else it is back after √(2 s/a₋)."""
    slope, mu, v = 0.3, 0.2, 3.0
    eom, _ = inclined_block(mu, slope, static=static)
    up, down = (G * (np.sin(slope) + s * mu * np.cos(slope)) for s in (1, -1))
    t, s = v / up, v * v / (2 * up)
    end = t + np.sqrt(2 * s / down)
    sol = kn.simulate(eom, (0, end), q=[0, 0], u=[v * np.cos(slope), v * np.sin(slope)], **TIGHT)
    along = np.array([np.cos(slope), np.sin(slope)])
    assert times(sol, "floor sticks") == [pytest.approx(t, abs=1e-10)]
    if static > np.tan(slope):
        assert words(sol, "floor") == ["slip", "stick"]
        assert sol.q[-1] @ along == pytest.approx(s, abs=1e-10)
        assert not sol.u[-1].any()
    else:
        assert set(words(sol, "floor")) == {"slip"}
        assert sol.q[-1] @ along == pytest.approx(0, abs=1e-9)
        assert sol.u[-1] @ along == pytest.approx(-down * (end - t), abs=1e-9)


def test_a_dry_oscillator_with_a_gap_stops_early():
    """μ_s m g = 0.15 k m holds it where μ_k = 0.1 has it turn: from 0.72 it turns at −0.52, 0.32 and stays at −0.12."""
    N, O = ground()
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    table = kn.contact(kn.joints.point_on_plane("table", P, O, normal=N.y), 0.1, static=0.15)
    loads = [kn.gravity(-N.y), kn.Force(P, -x * N.x)]
    bodies = [kn.Particle("m", P, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[table]))
    sol = kn.simulate(eom, (0, 20), q=[0.72, 0], u=[0, 0], **TIGHT)
    np.testing.assert_allclose(times(sol, "table sticks"), np.pi * np.arange(1, 4), rtol=0, atol=1e-9)
    assert sol["x"][-1] == pytest.approx(-0.12, abs=1e-9)
    assert sol[table.friction_forces[0]][-1] == pytest.approx(-0.12, abs=1e-9)
    assert not sol["y"].any()


def test_a_mass_rides_on_a_belt():
    """m 2, k 50, v 0.1: it slips where k x = μ_s m g, and again each 2 (π − atan(x₀ω/v))/ω + 2 x₀/v, with x₀ = (μ_s − μ_k) m g/k."""
    m, k, v, mu, mus = 2.0, 50.0, 0.1, 0.3, 0.4
    N, O = ground()
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    place = kn.joints.point_on_plane("belt", P, O, normal=N.y, surface=v * N.x)
    belt = kn.contact(place, mu, static=mus)
    loads = [kn.gravity(-G * N.y), kn.Force(P, -k * x * N.x)]
    bodies = [kn.Particle("m", P, m)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[belt]))
    sol = kn.simulate(eom, (0, 10), q=[0, 0], u=[v, 0], **TIGHT)
    begins = times(sol, "belt slips")
    w, x0 = np.sqrt(k / m), (mus - mu) * m * G / k
    assert begins[0] == pytest.approx(mus * m * G / (k * v), abs=1e-10)
    np.testing.assert_allclose(np.diff(begins), 2 * (np.pi - np.arctan(x0 * w / v)) / w + 2 * x0 / v, rtol=0, atol=1e-9)
    np.testing.assert_allclose(sol["x"].max(), mu * m * G / k + np.hypot(x0, v / w), rtol=1e-3)
    stuck = sol.modes["belt"] == "stick"
    np.testing.assert_allclose(sol.u[stuck, 0], v, rtol=0, atol=1e-15)


# Balls and disks -------------------------------------------------------------------------------------------------------------


def ball_in_space(mu, ratio=0.4, R=0.1, turning=None, surface=None, e=0.0):
    """A ball with the angular velocity's components in N as speeds, over a table that may turn."""
    N, O = ground()
    q = kn.coordinates("q1:7")
    u = kn.speeds("u1:7")
    A = N.rotate("A", q[0], N.z)
    B = A.rotate("B", q[1], A.x)
    C = B.rotate("C", q[2], B.y)
    G_ = O.at("G", q[3] * N.x + q[4] * N.y + q[5] * N.z)
    table = N if turning is None else N.rotate("T", kn.parameter("Omega", turning, "rad/s") * kn.time, N.z)
    plane = O
    m = 2.0
    inertia = kn.inertia(C, *[ratio * m * R * R] * 3)
    surface = None if surface is None else surface(G_.position(O), N)
    place = kn.joints.sphere_on_plane("table", C, G_, plane, radius=R, normal=table.z, surface=surface)
    contact = kn.contact(place, mu, restitution=e)
    w, v = C.angular_velocity(N), G_.velocity(N)
    speeds = dict(zip(u, [f.dot(e) for f in (w, v) for e in (N.x, N.y, N.z)], strict=True))
    bodies = [kn.RigidBody("ball", frame=C, mass_center=G_, mass=m, inertia=inertia)]
    return kn.derive(
        kn.System(N, bodies=bodies, speeds=speeds, loads=[kn.gravity(-G * N.z)], contacts=[contact])
    ), contact


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [2 / 5, 2 / 3])
def test_a_ball_thrown_with_spin_in_space(ratio):
    """Slip keeps its direction: with s = v + ω × (−R n) it rolls after |s|/(μ g (1 + 1/c)), with v₀ − s c/(1 + c), c = I/(m R²)."""
    R, mu = 0.1, 0.2
    eom, contact = ball_in_space(mu, ratio, R)
    w, v, n = np.array([3.0, -8.0, 5.0]), np.array([0.7, -0.4, 0.0]), np.array([0, 0, 1.0])
    s = v + np.cross(w, -R * n)
    t = np.linalg.norm(s) / (mu * G * (1 + 1 / ratio))
    sol = kn.simulate(eom, (0, 2), q=[0.1, 0.2, 0.3, 0, 0, R], u=[*w, *v], **TIGHT)
    assert times(sol, "table sticks") == [pytest.approx(t, abs=1e-9)]
    last = v - s * ratio / (1 + ratio)
    np.testing.assert_allclose(sol.u[-1, 3:], last, rtol=0, atol=1e-9)
    np.testing.assert_allclose(sol.u[-1, :3], [*np.cross(n, last)[:2] / R, w[2]], rtol=0, atol=1e-8)
    way = v * t - mu * G * s / np.linalg.norm(s) * t * t / 2 + last * (2 - t)
    np.testing.assert_allclose(sol.q[-1, 3:] - [0, 0, R], way, rtol=0, atol=1e-9)
    slips = sol.modes["table"] == "slip"
    forces = np.array([sol[f] for f in contact.friction_forces])
    np.testing.assert_allclose(np.linalg.norm(forces[:, slips], axis=0), mu * 2 * G, rtol=1e-10)
    assert not np.abs(forces[:, ~slips]).max() > 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("by", ["frame", "surface"])
@pytest.mark.parametrize(("ratio", "share"), [(2 / 5, 2 / 7), (2 / 3, 2 / 5)])
def test_a_ball_on_a_turning_table_circles(ratio, share, by):
    """Rolling, its centre goes round a circle with 2 Ω/7, a hollow one with 2 Ω/5: v̇ = c/(1 + c) Ω × v."""
    R, Omega = 0.1, 3.0
    more = {"turning": Omega} if by == "frame" else {"surface": lambda r, N: Omega * N.z.cross(r)}
    eom, contact = ball_in_space(0.8, ratio, R, **more)
    r, v, n = np.array([0.2, 0.1, R]), np.array([0.1, 0.3, 0.0]), np.array([0, 0, 1.0])
    s = Omega * np.cross(n, r) - v  # = ω × (−R n)
    w = [*np.cross(-s, n)[:2] / -R, 0.0]
    np.testing.assert_allclose(np.cross([*w[:2], 0], -R * n), s, atol=1e-15)
    sol = kn.simulate(eom, (0, 5), q=[0.1, 0.2, 0.3, *r], u=[*w, *v], rtol=1e-12, atol=1e-13)
    assert words(sol, "table") == ["stick"]
    turn = share * Omega
    middle = r + np.cross(n, v) / turn
    a, arm = turn * sol.t, r - middle
    x = middle[0] + arm[0] * np.cos(a) - arm[1] * np.sin(a)
    y = middle[1] + arm[0] * np.sin(a) + arm[1] * np.cos(a)
    np.testing.assert_allclose(sol["q4"], x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(sol["q5"], y, rtol=0, atol=1e-9)
    f = np.hypot(*(sol[f] for f in contact.friction_forces))
    np.testing.assert_allclose(f, 2 * turn * np.linalg.norm(v), rtol=1e-8)


@pytest.mark.slow
def test_an_upright_disk_thrown_without_spin_rolls():
    """disk_on_plane in space, upright: after v₀/(3 μ g) it rolls with 2 v₀/3."""
    R, mu, v = 0.3, 0.15, 2.0
    N, O = ground()
    yaw, lean, spin, x, y, z = kn.coordinates("q1:7")
    Y = N.rotate("Y", yaw, N.z)
    B = Y.rotate("B", lean, Y.x)
    C = B.rotate("C", spin, B.y)
    G_ = O.at("G", x * N.x + y * N.y + z * N.z)
    inertia = kn.solids.thin_disk(C, 1.2, R, axis=C.y)
    disk = kn.RigidBody("disk", frame=C, mass_center=G_, mass=1.2, inertia=inertia)
    place = kn.joints.disk_on_plane("floor", C, G_, O, axis=C.y, radius=R, normal=N.z)
    floor = kn.contact(place, mu)
    eom = kn.derive(kn.System(N, bodies=[disk], speeds="rates", loads=[kn.gravity(-G * N.z)], contacts=[floor]))
    heading = 0.4
    start = [v * np.cos(heading), v * np.sin(heading), 0]
    sol = kn.simulate(eom, (0, 1), q=[heading, 0, 0, 0, 0, R], u=[0, 0, 0, *start], **TIGHT)
    assert times(sol, "floor sticks")[0] == pytest.approx(v / (3 * mu * G), abs=1e-9)
    assert np.hypot(*sol.u[-1, 3:5]) == pytest.approx(2 * v / 3, abs=1e-9)
    assert sol.u[-1, 2] == pytest.approx(2 * v / (3 * R), abs=1e-8)


@pytest.mark.parametrize(("mu", "rolls"), [(0.2, True), (0.1, False)])
def test_a_ball_on_an_incline_rolls_if_friction_allows(mu, rolls):
    """From rest: 5/7 g sin α where μ ≥ 2/7 tan α, else g (sin α − μ cos α)."""
    slope, R, m = 0.5, 0.1, 2.0
    N, O = ground()
    I = N.rotate("I", -slope, N.z)
    x, y, a = kn.coordinates("q1:4")
    B = I.rotate("B", a, I.z)
    C = O.at("C", x * I.x + y * I.y)
    floor = kn.contact(kn.joints.sphere_on_plane("floor", B, C, O, radius=R, normal=I.y), mu)
    body = kn.RigidBody("ball", frame=B, mass_center=C, mass=m, inertia=kn.solids.solid_sphere(B, m, R))
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[floor]))
    sol = kn.simulate(eom, (0, 1), q=[0, R, 0], u=[0, 0, 0], **TIGHT)
    assert words(sol, "floor") == ["stick" if rolls else "slip"]
    assert rolls == (mu >= 2 / 7 * np.tan(slope))
    along = 5 / 7 * G * np.sin(slope) if rolls else G * (np.sin(slope) - mu * np.cos(slope))
    turning = -along / R if rolls else -mu * G * np.cos(slope) * 5 / (2 * R)
    np.testing.assert_allclose(sol.q[-1], [along / 2, R, turning / 2], rtol=0, atol=1e-10)
    np.testing.assert_allclose(sol.u[-1], [along, 0, turning], rtol=0, atol=1e-10)


# Impacts ---------------------------------------------------------------------------------------------------------------------


def thrown(e, slope=0.0, mu=0.0, law="stronge"):
    """A particle over an incline without friction."""
    N, O = ground()
    I = N.rotate("I", slope, N.z)
    x, y = kn.coordinates("x y")
    P = O.at("P", x * I.x + y * I.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=I.y), mu, restitution=e, law=law)
    bodies = [kn.Particle("ball", P, 0.7)]
    loads = [kn.gravity(-G * N.y)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor])), floor


@pytest.mark.parametrize("law", ["stronge", "poisson", "newton"])
def test_a_bouncing_ball_by_each_law(law):
    """The n-th impact comes after √(2h/g)(1 + 2e(1 − eⁿ⁻¹)/(1 − e)); they end at √(2h/g)(1 + e)/(1 − e), and x knows nothing of it."""
    e, h = 0.9, 1.0
    eom, _ = thrown(e, law=law)
    sol = kn.simulate(eom, (0, 10), q=[0, h], u=[0.5, 0], **TIGHT)
    closes = np.array(times(sol, "floor closes"))
    n = np.arange(1, len(closes) + 1)
    fall = np.sqrt(2 * h / G)
    expected = fall * (1 + 2 * e * (1 - e ** (n - 1)) / (1 - e))
    np.testing.assert_allclose(closes, expected, rtol=0, atol=1e-11)
    assert closes[9] == pytest.approx(5.43021800258535, abs=1e-12)
    assert times(sol, "floor rests")[-1] == pytest.approx(8.57894917872889, abs=1e-12)
    np.testing.assert_allclose(sol["x"], 0.5 * sol.t, rtol=0, atol=1e-11)
    energies = [j.energy for j in sol.jumps[:10]]
    np.testing.assert_allclose(energies, -(1 - e * e) * 0.7 * G * h * e ** (2 * n[:10] - 2), rtol=1e-9)


def test_a_ball_bounces_down_an_incline():
    """Across the incline it bounces with g cos α, along it falls with g sin α, which keeps on after the last impact."""
    e, slope, h = 0.5, -0.4, 0.3
    eom, _ = thrown(e, slope)
    sol = kn.simulate(eom, (0, 2), q=[0, h], u=[0, 0], **TIGHT)
    a = G * np.cos(slope)
    assert times(sol, "floor rests")[-1] == pytest.approx(np.sqrt(2 * h / a) * (1 + e) / (1 - e), abs=1e-12)
    np.testing.assert_allclose(sol["x"], -G * np.sin(slope) * sol.t**2 / 2, rtol=0, atol=1e-11)
    assert not sol["y"][-1]


def test_an_elastic_ball_loses_nothing():
    """e = 1: an impact each 2 √(2h/g), and no energy lost."""
    eom, _ = thrown(1.0)
    sol = kn.simulate(eom, (0, 20), q=[0, 0.5], u=[0, 0], **TIGHT)
    fall = np.sqrt(2 * 0.5 / G)
    closes = np.array(times(sol, "floor closes"))
    assert len(closes) == int((20 / fall + 1) / 2)
    np.testing.assert_allclose(closes, fall * (1 + 2 * np.arange(len(closes))), rtol=0, atol=1e-10)
    np.testing.assert_allclose(sol.energy, sol.energy[0], rtol=1e-10)


RODS = {
    "newton": (0.9, 0.043335269814),
    "poisson": (0.630199778052, -0.124384327581),
    "stronge": (0.688336122294, -0.093243291926),
}


@pytest.mark.parametrize("law", RODS)
def test_a_rod_hits_a_rough_floor(law):
    """Routh's process: the tip sticks in compression; what it rebounds with, and the energy, by each restitution."""
    N, O = ground()
    x, y, a = kn.coordinates("q1:4")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    tip = C.fixed_in(B, "tip", -B.x)
    body = kn.RigidBody("rod", frame=B, mass_center=C, mass=1.0, inertia=kn.inertia(B, 1, 1, 1 / 3))
    floor = kn.contact(kn.joints.point_on_plane("tip", tip, O, normal=N.y), 0.5, restitution=0.9, law=law)
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", contacts=[floor]))
    angle = np.radians(60)

    def run():
        return kn.simulate(eom, (-0.1, 0.1), q=[0, np.sin(angle) + 0.1, angle], u=[0.75, -1, 0], samples=3, **TIGHT)

    if law == "newton":
        with pytest.warns(kn.KaneWarning, match="energy"):
            sol = run()
    else:
        sol = run()
    (jump,) = sol.jumps
    rebound, change = RODS[law]
    assert jump.t == pytest.approx(0, abs=1e-12)
    assert jump.energy == pytest.approx(change, abs=1e-11)
    after = sol.u[-1]
    v_tip = after[:2] + after[2] * np.array([np.sin(angle), -np.cos(angle)])
    np.testing.assert_allclose(v_tip, [0, rebound], rtol=0, atol=1e-11)


def test_balls_in_a_row():
    """Newton's cradle with tiny gaps: equal balls, e = 1, the last leaves with v₀; of a pair with e they leave with (1 ∓ e)/2 v₀."""
    for e, count in ((1.0, 4), (0.6, 2)):
        N, O = ground()
        q = kn.coordinates(f"x1:{count + 1}")
        points = [O.at(f"P{k}", x * N.x) for k, x in enumerate(q)]
        stops = [kn.joints.stop(f"gap {k}", q[k + 1] - q[k] - 1, restitution=e) for k in range(count - 1)]
        bodies = [kn.Particle(f"ball {k}", p, 0.3) for k, p in enumerate(points)]
        eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", contacts=stops))
        start = [1.0001 * k for k in range(count)]
        sol = kn.simulate(eom, (0, 1), q=start, u=[2.0, *[0] * (count - 1)], **TIGHT)
        last = [0] * (count - 1) + [2] if e == 1 else [(1 - e) / 2 * 2, (1 + e) / 2 * 2]
        np.testing.assert_allclose(sol.u[-1], last, rtol=0, atol=1e-12)


def test_an_oscillator_hits_a_wall():
    """m = 1, k = 4, a wall at rest: an impact each π/ω, with eⁿ of the speed; never past the wall."""
    N, O = ground()
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    wall = kn.joints.stop("wall", x, restitution=0.8)
    bodies, loads = [kn.Particle("m", P, 1.0)], [kn.Force(P, -4 * x * N.x)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[wall]))
    sol = kn.simulate(eom, (0, 10), q=[1], u=[0], **TIGHT)
    closes = times(sol, "wall closes")
    np.testing.assert_allclose(closes, np.pi / 4 + np.pi / 2 * np.arange(len(closes)), rtol=0, atol=1e-9)
    after = [j.changes[eom.speeds[0]][1] for j in sol.jumps]
    np.testing.assert_allclose(after, 2 * 0.8 ** np.arange(1, len(closes) + 1), rtol=0, atol=1e-9)
    assert sol["x"].min() > -1e-10


def test_a_preloaded_clearance():
    """P presses a mass to one side of a clearance c: it leaves where F = a t is P, crosses by a t³/6 m, and rebounds with e."""
    N, O = ground()
    x = kn.coordinate("x")
    B = O.at("B", x * N.x)
    m, c, e, P, a = 2.0, 0.003, 0.6, 40.0, 50.0
    sides = [kn.joints.stop("left", x, restitution=e), kn.joints.stop("right", c - x, restitution=e)]
    bodies, loads = [kn.Particle("m", B, m)], [kn.Force(B, (a * kn.time - P) * N.x)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=sides))
    sol = kn.simulate(eom, (0, 1), q=[0], u=[0], **TIGHT)
    assert times(sol, "left opens") == [pytest.approx(P / a, abs=1e-12)]
    crossing = np.cbrt(6 * m * c / a)
    hits = times(sol, "right closes")
    assert hits[0] == pytest.approx(P / a + crossing, abs=1e-9)
    v = a * crossing**2 / (2 * m)
    assert sol.jumps[0].changes[eom.speeds[0]] == pytest.approx((v, -e * v), abs=1e-9)
    assert sol.modes["right"][-1] == "closed"
    np.testing.assert_allclose(sol[sides[0].normal_force], np.maximum(P - a * sol.t, 0), rtol=0, atol=1e-12)
    last = sol.modes["right"] == "closed"
    np.testing.assert_allclose(sol[sides[1].normal_force][last], (a * sol.t - P)[last], rtol=0, atol=1e-12)


@pytest.mark.parametrize("height", [0.3, 0.4, 0.7, 1.0])
def test_a_ball_hits_a_ceiling_without_rebound(height):
    """Thrown up with v it stops there after (v − √(v² − 2 g h))/g, and falls from rest at once."""
    N, O = ground()
    y = kn.coordinate("y")
    P = O.at("P", y * N.y)
    ceiling = kn.joints.stop("ceiling", height - y)
    bodies, loads = [kn.Particle("ball", P, 1.0)], [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[ceiling]))
    sol = kn.simulate(eom, (0, 2), q=[0], u=[6], **TIGHT)
    t = (6 - np.sqrt(36 - 2 * G * height)) / G
    assert sol.status == "finished"
    assert times(sol, "ceiling closes") == [pytest.approx(t, abs=1e-11)]
    assert sol["y"][-1] == pytest.approx(height - G * (2 - t) ** 2 / 2, abs=1e-9)


def test_a_puck_stays_at_a_wall_where_nothing_presses():
    """After an impact without rebound N = 0 and nothing moves: that is no doubtful start."""
    N, O = ground()
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    wall = kn.joints.stop("wall", x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("puck", P, 1.0)], speeds="rates", contacts=[wall]))
    sol = kn.simulate(eom, (0, 3), q=[1], u=[-1])
    assert times(sol, "wall closes") == [pytest.approx(1, abs=1e-12)]
    assert sol.states[-1] == pytest.approx([0, 0], abs=1e-12)


def test_two_stops_at_one_instant():
    """Two balls that fall alike hit at the same times, a third one at its own."""
    N, O = ground()
    q = kn.coordinates("y1:4")
    points = [O.at(f"P{k}", y * N.y + k * N.x) for k, y in enumerate(q)]
    stops = [kn.joints.stop(f"floor {k}", y, restitution=0.7) for k, y in enumerate(q)]
    bodies = [kn.Particle(f"ball {k}", p, 1.0 + k) for k, p in enumerate(points)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=stops))
    sol = kn.simulate(eom, (0, 1.2), q=[1, 1, 0.5], u=[0, 0, 0], **TIGHT)
    np.testing.assert_allclose(sol["y1"], sol["y2"], rtol=0, atol=1e-12)
    fall = np.sqrt(2 / G)
    hits = fall * (1 + 2 * 0.7 * (1 - 0.7 ** np.arange(2)) / 0.3)
    found = sorted({round(j.t, 9) for j in sol.jumps if eom.speeds[0] in dict(j.changes)})
    np.testing.assert_allclose(found, hits[hits < 1.2], rtol=0, atol=2e-9)


# Tables that shake -----------------------------------------------------------------------------------------------------------


def test_a_block_leaves_a_table_that_shakes_up_and_down():
    """It leaves where −A ω² sin ωt = −g, flies, and lands without rebound where the table has come up to it."""
    A, w = 0.05, 20.0
    N, O = ground()
    y = kn.coordinate("y")
    table = O.at("table", A * kn.sin(w * kn.time) * N.y)
    P = O.at("P", y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, table, normal=N.y), 0)
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("m", P, 1.5)], speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[floor])
    )
    sol = kn.simulate(eom, (0, 0.4), q=[0], u=[A * w], **TIGHT)
    off = np.arcsin(G / (A * w * w)) / w
    height, speed = A * np.sin(w * off), A * w * np.cos(w * off)
    on = brentq(
        lambda t: height + speed * (t - off) - G * (t - off) ** 2 / 2 - A * np.sin(w * t),
        off + 0.05,
        off + 0.4,
        xtol=1e-15,
    )
    assert times(sol, "floor opens")[0] == pytest.approx(off, abs=1e-9)
    assert times(sol, "floor closes")[0] == pytest.approx(on, abs=1e-9)
    closed = (sol.t > 0) & (sol.t < off * 0.99)
    force = 1.5 * (G - A * w * w * np.sin(w * sol.t[closed]))
    np.testing.assert_allclose(sol[floor.normal_force][closed], force, rtol=0, atol=1e-10)


def test_a_block_on_a_table_that_shakes_sideways():
    """It slips from A ω² sin ωt = μ_s g on, is braked by μ_k g, and sticks again where the table has its speed."""
    A, w, mu, mus = 0.2, 5.0, 0.3, 0.35
    N, O = ground()
    x, y = kn.coordinates("x y")
    table = O.at("table", A * kn.sin(w * kn.time) * N.x)
    P = O.at("P", x * N.x + y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, table, normal=N.y), mu, static=mus)
    bodies, loads = [kn.Particle("m", P, 1.5)], [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor]))
    sol = kn.simulate(eom, (0, 0.9), q=[0, 0], u=[A * w, 0], **TIGHT)
    off = np.arcsin(mus * G / (A * w * w)) / w
    speed = A * w * np.cos(w * off)
    on = brentq(lambda t: speed - mu * G * (t - off) - A * w * np.cos(w * t), off + 0.05, off + 0.6, xtol=1e-15)
    assert times(sol, "floor slips")[0] == pytest.approx(off, abs=1e-9)
    assert times(sol, "floor sticks")[0] == pytest.approx(on, abs=1e-9)


@cache
def carried():
    """A block on a table that shakes sideways as A sin ωt, ω = 5/s, μ = 0.4."""
    A, w = kn.parameter("A", 0.2, "m"), kn.parameter("w", 5.0, "rad/s")
    N, O = ground()
    x, y = kn.coordinates("x y")
    table = O.at("table", A * kn.sin(w * kn.time) * N.x)
    P = O.at("P", x * N.x + y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, table, normal=N.y), 0.4)
    bodies, loads = [kn.Particle("m", P, 1.5)], [kn.gravity(-G * N.y)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor]))


@pytest.mark.parametrize(
    "more", [-1e-12, 0.0, 1e-13, 1e-8, *(pytest.param(d, marks=pytest.mark.slow) for d in (1e-15, 1e-11, 1e-10))]
)
def test_a_table_shakes_hardly_more_than_friction_holds(more):
    """Slip lasts 3 √(2 δ)/ω at A ω² = (1 + δ) μ g, and gains a speed of some μ g δ √δ/ω: less than rounding of the table's."""
    A = 0.4 * G / 25 * (1 + more)
    sol = kn.simulate(carried(), (0, 2), q=[0, 0], u=[5 * A, 0], parameters={"A": A}, **TIGHT)
    assert sol.status == "finished", sol.message
    np.testing.assert_allclose(sol["x"], A * np.sin(5 * sol.t), rtol=0, atol=1e-13)
    np.testing.assert_allclose(sol.u[:, 0], 5 * A * np.cos(5 * sol.t), rtol=0, atol=1e-11)
    assert sol.modes["floor"][-1] == "stick"


# Ropes -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 0.6])
def test_a_rope_goes_taut(e):
    """Dropped from its hook, a ball falls L, and springs back with e √(2 g L); it comes to hang with m g."""
    N, O = ground()
    y = kn.coordinate("y")
    P = O.at("P", y * N.y)
    rope = kn.joints.rope("rope", [O, P], 1.0, restitution=e)
    bodies, loads = [kn.Particle("ball", P, 2.0)], [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[rope]))
    sol = kn.simulate(eom, (0, 4), q=[-0.001], u=[-np.sqrt(2 * G * 0.001)], **TIGHT)
    fall = np.sqrt(2 / G) - np.sqrt(2 * 0.001 / G)
    assert times(sol, "rope closes")[0] == pytest.approx(fall, abs=1e-11)
    assert [*times(sol, "rope rests"), sol.mode_history[-1][0]][0] == pytest.approx(
        fall + 2 * np.sqrt(2 / G) * e / (1 - e), abs=1e-11
    )
    assert sol["y"][-1] == pytest.approx(-1, abs=1e-14)
    assert sol[rope.normal_force][-1] == pytest.approx(2 * G, rel=1e-13)
    assert sol[rope.normal_force][0] == 0


def test_two_balls_and_a_rope():
    """One ball flies off the other: taut, both go on with the momentum shared, and the rope stays taut between them as they turn."""
    N, O = ground()
    x1, y1, x2, y2 = kn.coordinates("q1:5")
    P, Q = O.at("P", x1 * N.x + y1 * N.y), O.at("Q", x2 * N.x + y2 * N.y)
    rope = kn.joints.rope("rope", [P, Q], 1.0)
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("q", Q, 3.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", contacts=[rope]))
    sol = kn.simulate(eom, (0, 3), q=[0, 0, 0, 0.6], u=[0, 0, 1.0, 0], **TIGHT)
    t, r, reduced = 0.8, np.array([0.8, 0.6]), 0.75
    assert times(sol, "rope closes") == [pytest.approx(t, abs=1e-11)]
    turn = 0.6  # across the rope, |r| = 1
    (jump,) = sol.jumps
    assert jump.energy == pytest.approx(-reduced * r[0] ** 2 / 2, rel=1e-10)
    taut = sol.t > t * 1.001
    np.testing.assert_allclose(sol[rope.normal_force][taut], reduced * turn**2, rtol=1e-9)
    np.testing.assert_allclose(
        sol.u @ [[1, 0], [0, 1], [3, 0], [0, 3]], np.broadcast_to([3, 0], (len(sol.t), 2)), atol=1e-11
    )
    apart = np.hypot(sol["q3"] - sol["q1"], sol["q4"] - sol["q2"])
    assert apart.max() < 1 + 1e-10


def test_a_rope_over_pulleys():
    """Atwood's machine over two pulleys: a = (m₂ − m₁)g/(m₁ + m₂), tension 2 m₁ m₂ g/(m₁ + m₂); slack where one lands on the floor."""
    N, O = ground()
    y1, y2 = kn.coordinates("y1 y2")
    A, B = (O.fixed_in(N, name, x * N.x + 2 * N.y) for name, x in (("A", 0.0), ("B", 1.0)))
    P, Q = O.at("P", y1 * N.y), O.at("Q", 1.0 * N.x + y2 * N.y)
    rope = kn.joints.rope("rope", [P, A, B, Q], 3.5)
    floor = kn.joints.stop("floor", y2)
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("q", Q, 3.0)]
    loads = [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[rope, floor]))
    sol = kn.simulate(eom, (0, 1.2), q=[0.5, 1.0], u=[0, 0], **TIGHT)
    lands = np.sqrt(2 / (G / 2))
    assert sol[rope.normal_force][0] == pytest.approx(2 * 3 * G / 4, rel=1e-12)
    assert times(sol, "floor closes")[0] == pytest.approx(lands, abs=1e-10)
    v = G / 2 * lands
    after = sol.t > lands
    flies = 1.5 + v * (sol.t[after] - lands) - G * (sol.t[after] - lands) ** 2 / 2
    tight = sol[rope.normal_force][after] == 0
    np.testing.assert_allclose(sol["y1"][after][tight], flies[tight], rtol=0, atol=1e-9)
    assert sol["y1"][after].max() > 1.6
    np.testing.assert_allclose(sol["y2"][after], 0, rtol=0, atol=1e-15)


# Clutches and joints ---------------------------------------------------------------------------------------------------------


def test_a_clutch_locks_and_is_torn():
    """Two disks, M₀ slipping and M_s locked: after Δω/(M₀ (1/I₁ + 1/I₂)) they turn alike, until a growing torque tears them apart."""
    I1, I2, slip, most, k = 2.0, 3.0, 4.0, 5.0, 1.5
    N, O = ground()
    a, b = kn.coordinates("a b")
    A, B = N.rotate("A", a, N.z), N.rotate("B", b, N.z)
    frames = (("A", A, I1), ("B", B, I2))
    bodies = [kn.RigidBody(n, frame=f, mass_center=O, mass=1.0, inertia=kn.inertia(f, 2, 2, i)) for n, f, i in frames]
    clutch = kn.joints.clutch("clutch", A, B, N.z, slip, static=most)
    loads = [kn.Torque(B, -k * kn.time * N.z)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[clutch]))
    sol = kn.simulate(eom, (0, 10), q=[0, 0], u=[0, 10], **TIGHT)
    # relative rate: 10 − M₀ (1/I₁ + 1/I₂) t − k t²/(2 I₂)
    c = slip * (1 / I1 + 1 / I2)
    lock = (-c + np.sqrt(c * c + 4 * k / (2 * I2) * 10)) / (k / I2)
    torn = most * (I1 + I2) / (I1 * k)  # I₁ shares in k t by I₁/(I₁ + I₂)
    assert times(sol, "clutch sticks")[0] == pytest.approx(lock, abs=1e-10)
    assert times(sol, "clutch slips") == [pytest.approx(torn, abs=1e-10)]
    assert words(sol, "clutch") == ["slip", "stick", "slip"]
    common = (I2 * 10 - k * torn**2 / 2) / (I1 + I2)
    t = 10 - torn
    last = [common - slip / I1 * t, common + slip / I2 * t - k * (100 - torn**2) / (2 * I2)]
    np.testing.assert_allclose(sol.u[-1], last, rtol=0, atol=1e-9)


def test_a_pressed_clutch_follows_its_input():
    """Its size is an input p(t) = 2 t: locked at once where nothing drives it, after Δω = (1/I₁ + 1/I₂) t² else."""
    N, O = ground()
    a, b = kn.coordinates("a b")
    A, B = N.rotate("A", a, N.z), N.rotate("B", b, N.z)
    bodies = [
        kn.RigidBody(n, frame=f, mass_center=O, mass=1.0, inertia=kn.inertia(f, 2, 2, i))
        for n, f, i in (("A", A, 2.0), ("B", B, 2.0))
    ]
    p = kn.input("p", "N*m")
    clutch = kn.joints.clutch("clutch", A, B, N.z, p)
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", contacts=[clutch]))
    sol = kn.simulate(eom, (0, 5), q=[0, 0], u=[4, 0], inputs={"p": lambda t: 2 * t}, **TIGHT)
    assert times(sol, "clutch sticks") == [pytest.approx(2, abs=1e-9)]
    np.testing.assert_allclose(sol.u[-1], [2, 2], rtol=0, atol=1e-9)


def test_stiction_in_a_pin_holds_a_pendulum():
    """m g l sin θ < M_s: it hangs aslant for 1,000 s and moves exactly 0; let go at more, it swings."""
    for angle, holds in ((0.3, True), (0.8, False)):
        N, O = ground()
        pin = kn.pin("pin", O, N, axis=N.z, coordinates="a", speeds="w")
        P = pin.point.at("P", -1.0 * pin.frame.y)
        stiction = kn.joints.stiction(pin, 4.0, static=5.0)
        bodies, loads = [kn.Particle("bob", P, 1.0)], [kn.gravity(-G * N.y)]
        eom = kn.derive(kn.System(N, bodies=bodies, joints=[pin], loads=loads, contacts=[stiction]))
        sol = kn.simulate(eom, (0, 1000 if holds else 0.01), q=[angle], u=[0], **TIGHT)
        assert holds == (G * np.sin(angle) < 5)
        if holds:
            assert not np.ptp(sol.states, axis=0).any()
            np.testing.assert_allclose(sol[stiction.friction_forces[0]], G * np.sin(angle), rtol=1e-12)
        else:
            assert sol.rates()[0][-1] == pytest.approx(-(G * np.sin(angle) - 4), rel=1e-12)


def test_stiction_in_a_slider_by_a_normal_force():
    """A carriage pressed by μ N: the force c t moves it from c t = μ_s N on, x = ∫∫ (c t − μ_k N)/m."""
    m, c, mu, mus = 2.0, 3.0, 0.2, 0.3
    N, O = ground()
    rail = kn.slider("rail", O, N, axis=N.x, coordinates="x", speeds="v")
    normal = kn.reaction("N_rail", at=rail.point, along=N.y)
    stiction = kn.joints.stiction(rail, mu, static=mus, normal=normal)
    loads = [kn.gravity(-G * N.y), kn.Force(rail.point, c * kn.time * N.x)]
    bodies = [kn.Particle("carriage", rail.point, m)]
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[rail], loads=loads, contacts=[stiction]))
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], **TIGHT)
    begin = mus * m * G / c
    assert times(sol, "stiction in rail slips") == [pytest.approx(begin, abs=1e-10)]
    t = 4 - begin
    speed = ((mus - mu) * m * G * t + c * t * t / 2) / m
    assert sol.u[-1][0] == pytest.approx(speed, abs=1e-9)


# Blocks that rock ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [0.2, 0.35])
def test_a_rocking_block_loses_by_housner(alpha):
    """Each impact leaves ω⁺ = (1 − 1.5 sin² α) ω⁻ (Housner 1963); a quarter period is ∫dθ/θ̇ of I_O θ̈ = −m g R sin(α − θ)."""
    R, tilt = 0.5, 0.3 * alpha
    w, h = R * np.sin(alpha), R * np.cos(alpha)
    eom, _ = crate(2.0, 0.0, w, h)
    start = [w * np.cos(tilt) - h * np.sin(tilt), h * np.cos(tilt) + w * np.sin(tilt), tilt]
    sol = kn.simulate(eom, (0, 1), q=start, u=[0, 0, 0], **TIGHT)
    jump = sol.jumps[0]
    before, after = jump.changes[eom.speeds[2]]
    speed = np.sqrt(1.5 * G / R * (np.cos(alpha - tilt) - np.cos(alpha)))
    assert before == pytest.approx(-speed, abs=1e-9)
    assert after / before == pytest.approx(1 - 1.5 * np.sin(alpha) ** 2, abs=1e-9)
