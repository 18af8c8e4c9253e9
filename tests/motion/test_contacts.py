# SPDX-License-Identifier: BSD-3-Clause
"""Motions with contacts beside closed forms: stick, slip, impacts, and what goes from one to the other."""

import pickle

import numpy as np
import pytest
from scipy.optimize import brentq

import kane as kn
from kane.gallery import mass_on_belt
from kane.gallery.contacts import bouncing_ball
from kane.motion import at_start, stepped
from tests.oracles.planar_contacts import Plane, Plate, Touch
from tests.systems.planar_contacts import model

G = 9.81
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def times(sol, what):
    return [t for e, t in sol.events if e.name == what]


def block(mu=0.5, slope=0.0, acceleration=None, **laws):
    """A particle on an incline, which may be shaken: x along it, y above it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    I = N.rotate("I", slope, N.z)
    g = kn.parameter("g", G, "m/s^2")
    x, y = kn.coordinates("x y")
    ground = O if acceleration is None else O.at("table", acceleration * I.x)
    P = O.at("P", x * I.x + y * I.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, ground, normal=I.y), mu, **laws)
    bodies = [kn.Particle("block", P, kn.parameter("m", 2.0, "kg"))]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], contacts=[floor])
    return kn.derive(system), floor


def ball(e=0.5, mu=0.3, ratio=0.4):
    """A ball (2/5) or a disk (1/2) in the plane."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinates("x y a")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    inertia = kn.inertia(B, 1, 1, ratio * 2.0 * 0.1**2)
    floor = kn.contact(kn.joints.sphere_on_plane("floor", B, C, O, radius=0.1, normal=N.y), mu, restitution=e)
    bodies = [kn.RigidBody("ball", frame=B, mass_center=C, mass=2.0, inertia=inertia)]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[floor])
    return kn.derive(system), floor


def on_spring(mu, static=None, surface=0.0, g=G, **more):
    """A mass on a spring, kept on a surface by its coordinate."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    normal = kn.reaction("N_P", at=P, along=N.y)
    place = kn.joints.point_on_plane("table", P, O, normal=N.y, surface=surface * N.x if surface else None)
    loads = [kn.gravity(-g * N.y), kn.Force(P, -x * N.x)]
    contacts = [kn.contact(place, mu, static=static, normal=normal)]
    system = kn.System(N, bodies=[kn.Particle("m", P, 1.0)], speeds="rates", loads=loads, contacts=contacts, **more)
    return kn.derive(system), contacts[0]


def test_a_stuck_block_moves_exactly_zero():
    eom, floor = block(0.5, 0.3)
    sol = kn.simulate(eom, (0, 1000), q=[1, 0], u=[0, 0])
    assert not sol.events
    assert np.ptp(sol["x"]) == 0
    assert not sol.u.any()
    np.testing.assert_allclose(sol[floor.normal_force], 2 * G * np.cos(0.3), rtol=1e-14)
    np.testing.assert_allclose(sol[floor.friction_forces[0]], 2 * G * np.sin(0.3), rtol=1e-14)
    assert set(sol.modes["floor"]) == {"stick"}


def test_a_block_slides_down_and_one_thrown_up_stays():
    eom, floor = block(0.2, 0.3)
    sol = kn.simulate(eom, (0, 1), q=[1, 0], u=[0, 0], **TIGHT)
    assert sol["x"][-1] == pytest.approx(1 - G * (np.sin(0.3) - 0.2 * np.cos(0.3)) / 2, abs=1e-12)
    eom, floor = block(0.5, 0.3)
    sol = kn.simulate(eom, (0, 2), q=[0, 0], u=[3, 0], **TIGHT)
    a = G * (np.sin(0.3) + 0.5 * np.cos(0.3))
    assert times(sol, "floor sticks") == [pytest.approx(3 / a, abs=1e-12)]
    assert sol["x"][-1] == pytest.approx(9 / (2 * a), abs=1e-11)
    friction = sol[floor.friction_forces[0]]
    np.testing.assert_allclose(friction[[0, -1]], [-G * np.cos(0.3), 2 * G * np.sin(0.3)], rtol=1e-12)
    assert [m["floor"] for _, m in sol.mode_history] == ["slip", "stick"]


def test_a_dry_oscillator_stops():
    """m = k = 1, μ N = 0.1, from 1.05: it loses 0.2 a half cycle and stops at −0.05 after 5 π."""
    eom, _ = on_spring(0.1, g=1.0)
    sol = kn.simulate(eom, (0, 20), q=[1.05], u=[0], **TIGHT)
    np.testing.assert_allclose(times(sol, "table sticks"), np.pi * np.arange(1, 6), rtol=0, atol=1e-9)
    assert sol["x"][-1] == pytest.approx(-0.05, abs=1e-9)


def test_a_block_that_lies_flat_leaves_with_all_its_corners():
    """On a table that is shaken up and down it leaves where s̈ = −g, and falls back; its corners' forces vanish at one instant."""
    A, w = 0.02, 30.0
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinates("x y a")
    table = O.at("T", A * kn.sin(w * kn.time) * N.y)
    B = N.rotate("B", a, N.z)
    C = table.at("C", x * N.x + (y + 0.1) * N.y)
    corners = [C.fixed_in(B, n, s * 0.2 * B.x - 0.1 * B.y) for n, s in (("left", -1), ("right", 1))]
    bodies = [kn.RigidBody("block", frame=B, mass_center=C, mass=1.5, inertia=kn.inertia(B, 1, 1, 0.02))]
    places = kn.joints.corners_on_plane("floor", corners, table, normal=N.y)
    contacts = [kn.contact(p, 0.3, law="moreau") for p in places]
    loads = [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts))
    sol = kn.simulate(eom, (0, 0.5), q=[0, 0, 0], u=[0, 0, 0], **TIGHT)
    leaves = np.arcsin(G / (A * w * w)) / w
    assert sol.mode_history[1] == (pytest.approx(leaves, abs=1e-11), {"floor 1": "separated", "floor 2": "separated"})

    def height(t):
        up = A * np.sin(w * leaves) + A * w * np.cos(w * leaves) * (t - leaves) - G * (t - leaves) ** 2 / 2
        return up - A * np.sin(w * t)

    lands = brentq(height, leaves + 0.05, leaves + 0.2, xtol=1e-15)
    assert times(sol, "floor 1 closes")[0] == pytest.approx(lands, abs=1e-10)
    assert max(np.abs(sol["a"]).max(), np.abs(sol["x"]).max()) < 1e-12
    for c in contacts:
        assert sol[c.normal_force].min() > -1e-9


def test_a_mass_on_a_belt():
    """It sticks up to k x = μ_s m g, slips from there, and sticks again where the belt's speed is reached: a limit cycle."""
    v, mu, mus = 0.1, 0.3, 0.4
    eom, _ = on_spring(mu, mus, v)
    sol = kn.simulate(eom, (0, 100), q=[0], u=[v], **TIGHT)
    begins, ends = (np.array(times(sol, f"table {w}")) for w in ("slips", "sticks"))
    x0 = (mus - mu) * G  # from the middle of the slip, where k x = μ_k m g
    slip = 2 * (np.pi - np.arctan(x0 / v))
    assert begins[0] == pytest.approx(mus * G / v, abs=1e-9)
    n = min(len(begins), len(ends))
    np.testing.assert_allclose(ends[:n] - begins[:n], slip, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.diff(begins), slip + 2 * x0 / v, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("ratio", "share"), [(0.4, 2 / 7), (0.5, 1 / 3)])
def test_thrown_without_spin_it_rolls(ratio, share):
    """A ball after t = 2 v₀/(7 μ g) with 5 v₀/7, a disk after v₀/(3 μ g) with 2 v₀/3."""
    eom, _ = ball(ratio=ratio)
    sol = kn.simulate(eom, (0, 2), q=[0, 0.1, 0], u=[2, 0, 0], **TIGHT)
    assert times(sol, "floor sticks") == [pytest.approx(share * 2 / (0.3 * G), abs=1e-11)]
    np.testing.assert_allclose(sol.u[-1], [2 * (1 - share), 0, -20 * (1 - share)], rtol=0, atol=1e-11)


def test_a_bouncing_ball_comes_to_rest():
    """Heights fall as e²ⁿ; the series ends at √(2 h/g) (1 + e)/(1 − e)."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y")
    P = O.at("P", y * N.y)
    floor = kn.joints.stop("floor", y, restitution=0.9)
    loads = [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("ball", P, 2.0)], speeds="rates", loads=loads, contacts=[floor]))
    sol = kn.simulate(eom, (0, 10), q=[1], u=[0], **TIGHT)
    assert times(sol, "floor closes")[9] == pytest.approx(5.43021800258535, abs=1e-12)
    assert times(sol, "floor rests") == [pytest.approx(8.57894917872889, abs=1e-12)]
    assert sol.mode_history[-1] == (pytest.approx(8.57894917872889, abs=1e-4), {"floor": "closed"})
    assert not sol.q[-1].any()
    assert not sol.u[-1].any()
    assert sol.jumps[0].energy == pytest.approx(-(1 - 0.81) * 2 * G, rel=1e-12)
    np.testing.assert_allclose(sol[floor.normal_force][sol.t > 9], 2 * G, rtol=1e-14)


def test_a_ball_with_backspin_returns():
    """Energy falls by what friction and impacts take, and after the last impact it rolls."""
    eom, floor = ball()
    sol = kn.simulate(eom, (0, 2), q=[0, 0.6, 0], u=[2, 0, 30], **TIGHT)
    assert np.diff(sol.energy).max() < 1e-10
    assert np.nanmin(sol[floor.normal_force]) >= 0
    v = 2 * 5 / 7 - 2 / 7 * 0.1 * 30  # momentum about the floor's line stays
    np.testing.assert_allclose(sol.u[-1], [v, 0, -10 * v], rtol=0, atol=1e-9)


def test_a_block_on_a_shaken_table():
    """It sticks while |a| ≤ μ g, and slides with μ g where the table leaves it behind."""
    amplitude, w = 0.2, 5.0
    swing = kn.parameter("A", amplitude, "m") * kn.sin(kn.parameter("w", w, "rad/s") * kn.time)
    eom, _ = block(0.3, acceleration=swing)
    begin = np.arcsin(0.3 * G / (amplitude * w * w)) / w
    sol = kn.simulate(eom, (0, 0.5), q=[0, 0], u=[amplitude * w, 0], **TIGHT)
    assert times(sol, "floor slips")[0] == pytest.approx(begin, abs=1e-9)


def box(mu, w, h):
    """A box of half width w and half height h, 1 kg, with both lower corners on the floor."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinates("x y a")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    inertia = kn.inertia(B, 1, 1, (4 * w * w + 4 * h * h) / 12)
    corners = [C.fixed_in(B, name, s * w * B.x - h * B.y) for name, s in (("l", -1), ("r", 1))]
    contacts = [kn.contact(kn.joints.point_on_plane(p.name, p, O, normal=N.y), mu) for p in corners]
    bodies = [kn.RigidBody("box", frame=B, mass_center=C, mass=1.0, inertia=inertia)]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=contacts)
    return kn.derive(system), contacts


@pytest.mark.slow
def test_a_rocking_block():
    """At each impact of a slender block ω⁺/ω⁻ = 1 − 1.5 sin² α (Housner 1963); it comes to rest on both corners."""
    alpha, r = 0.2, 0.5
    w, h = r * np.sin(alpha), r * np.cos(alpha)
    eom, contacts = box(2.0, w, h)
    tilt = 0.05
    start = [w * np.cos(tilt) - h * np.sin(tilt), h * np.cos(tilt) + w * np.sin(tilt), tilt]
    sol = kn.simulate(eom, (0, 15), q=start, u=[0, 0, 0], **TIGHT)
    (jump,) = [j for j in sol.jumps if j.t == times(sol, "r closes")[0] or j.t == times(sol, "l closes")[0]][:1]
    (before, after) = next(v for s, v in jump.changes.items() if s.name == "u_a")
    assert after / before == pytest.approx(1 - 1.5 * np.sin(alpha) ** 2, abs=1e-9)
    assert set(sol.mode_history[-1][1].values()) == {"stick"}
    assert np.diff(sol.energy).max() < 1e-9
    forces = sol[[c.normal_force for c in contacts]]
    np.testing.assert_allclose([f[-1] for f in forces], G / 2, rtol=1e-9)


def test_a_box_slides_on_two_corners_and_sticks():
    eom, (left, right) = box(0.3, 0.2, 0.1)
    sol = kn.simulate(eom, (0, 1), q=[0, 0.1, 0], u=[1, 0, 0], **TIGHT)
    assert times(sol, "l sticks") == [pytest.approx(1 / (0.3 * G), abs=1e-10)]
    n = np.array([sol[c.normal_force][0] for c in (left, right)])
    np.testing.assert_allclose(n, [G / 2 * (1 - 0.3 * 0.1 / 0.2), G / 2 * (1 + 0.3 * 0.1 / 0.2)], rtol=1e-12)
    assert sol.u[-1] == pytest.approx([0, 0, 0], abs=1e-15)


@pytest.mark.slow
def test_a_rope_goes_taut_and_slack():
    """A ball thrown up at the end of a rope: taut below, an impact without rebound where it goes taut again."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    rope = kn.joints.rope("rope", [O, P], 1.0)
    loads = [kn.gravity(-G * N.y)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("ball", P, 1.0)], speeds="rates", loads=loads, contacts=[rope]))
    v = np.sqrt(3.5 * G)  # slack where cos θ = −(v² − 2 g)/(3 g)
    sol = kn.simulate(eom, (0, 3), q=[0, -1], u=[v, 0], **TIGHT)
    k = int(np.flatnonzero(sol.t == times(sol, "rope opens")[0])[0])
    assert sol["y"][k] == pytest.approx(0.5, abs=1e-9)
    assert sol[rope.normal_force][0] == pytest.approx(G + 3.5 * G, rel=1e-9)
    assert np.hypot(sol["x"], sol["y"]).max() < 1 + 1e-10
    assert sol.jumps[0].energy < 0


def test_a_clutch_locks():
    """Two disks, torque of a given size: they turn alike after t = Δω/(M (1/I₁ + 1/I₂)), with the common speed of their momenta."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a, b = kn.coordinates("a b")
    A, B = N.rotate("A", a, N.z), N.rotate("B", b, N.z)
    bodies = [
        kn.RigidBody(n, frame=f, mass_center=O, mass=1.0, inertia=kn.inertia(f, 2, 2, i))
        for n, f, i in (("A", A, 2.0), ("B", B, 3.0))
    ]
    clutch = kn.joints.clutch("clutch", A, B, N.z, 4.0)
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", contacts=[clutch]))
    sol = kn.simulate(eom, (0, 5), q=[0, 0], u=[10, 0], **TIGHT)
    assert times(sol, "clutch sticks") == [pytest.approx(10 / (4 * (1 / 2 + 1 / 3)), abs=1e-11)]
    np.testing.assert_allclose(sol.u[-1], [4, 4], rtol=1e-12)
    assert sol.energy_check.relative < 1e-9


def test_stiction_in_a_slider():
    """It holds up to its size, and begins to slip where the force is more."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    rail = kn.slider("rail", O, N, axis=N.x, coordinates="x", speeds="v")
    stiction = kn.joints.stiction(rail, 2.0, static=3.0)
    force = kn.Force(rail.point, kn.parameter("r", 1, "N/s") * kn.time * N.x)  # units beside sizes that are numbers
    bodies = [kn.Particle("carriage", rail.point, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, loads=[force], joints=[rail], contacts=[stiction]))
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], **TIGHT)
    assert times(sol, "stiction in rail slips") == [pytest.approx(3, abs=1e-10)]
    assert sol.u[-1][0] == pytest.approx((16 - 9) / 2 - 2, abs=1e-9)


@pytest.mark.slow
def test_the_articles_disk_slides_and_rolls():
    """Rolling sets in at 3.170416 s; where friction is at its most, it slips again."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2, q3, q4, q5 = kn.coordinates("q1:6")
    u1, u2, u3, u4, u5 = kn.speeds("u1:6")
    Y = N.rotate("Y", q1, N.z)
    B = Y.rotate("B", kn.pi / 2 - q2, Y.x)
    C = B.rotate("C", q3, B.z)
    P = O.at("P", q4 * N.x + q5 * N.y)
    Cs = P.at("C*", 0.3 * B.y)
    Ch = Cs.fixed_in(C, "C^", -0.3 * B.y)
    inertia = kn.solids.thin_disk(C, 1.2, 0.3, axis=C.z)
    disk = kn.RigidBody("disk", frame=C, mass_center=Cs, mass=1.2, inertia=inertia)
    normal = kn.reaction("N_z", at=P, along=N.z)
    ground = kn.contact(kn.joints.point_on_plane("ground", Ch, O, normal=N.z), 0.1, normal=normal)
    w = C.angular_velocity(N)
    speeds = {u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: q4.dt, u5: q5.dt}
    loads = [kn.gravity(-G * N.z)]
    eom = kn.derive(kn.System(N, bodies=[disk], speeds=speeds, loads=loads, contacts=[ground]))
    sol = kn.simulate(eom, (0, 4), q=[0, 0.1, 0, 0, 0], u=[0, 2, 25, 2, 0], rtol=1e-12, atol=1e-12)
    assert times(sol, "ground sticks")[0] == pytest.approx(3.170416, abs=5e-7)
    words = [m["ground"] for _, m in sol.mode_history]
    assert words == ["slip", "stick", "slip"]
    assert np.nanmin(sol[normal]) > 0
    f, n = np.hypot(*(sol[x] for x in ground.friction_forces)), sol[normal]
    assert (f <= 0.1 * n * (1 + 1e-9)).all()
    assert sol.energy_check.relative < 1e-9


def rod(mu, g=0.0, **laws):
    """A uniform rod of 1 kg and half length 1 with its tip on a floor, and the tip's velocity upward."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinates("x y a")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    tip = C.fixed_in(B, "tip", -B.x)
    place = kn.joints.point_on_plane("tip", tip, O, normal=N.y)
    bodies = [kn.RigidBody("rod", frame=B, mass_center=C, mass=1.0, inertia=kn.inertia(B, 1, 1, 1 / 3))]
    loads = [kn.gravity(-g * N.y)] if g else []
    system = kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[kn.contact(place, mu, **laws)])
    return kn.derive(system), tip.velocity(N).dot(N.y)


def test_newtons_restitution_may_gain_energy():
    """A rod hits a rough floor (Newton 0.9, with a gain, Poisson 0.630199778052, Stronge 0.688336122294)."""
    theta = np.radians(60)
    expected = {
        "newton": (0.9, 0.043335269814),
        "poisson": (0.630199778052, -0.124384327581),
        "stronge": (0.688336122294, -0.093243291926),
    }
    for law, (v, gain) in expected.items():
        eom, up = rod(0.5, restitution=0.9, law=law)
        start = [0, np.sin(theta), theta]

        def run(eom=eom, start=start):
            return kn.simulate(eom, (0, 0.01), q=start, u=[0.75, -1, 0], samples=3)

        if law == "newton":
            with pytest.warns(kn.KaneWarning, match="energy"):
                sol = run()
        else:
            sol = run()
        assert sol[up][0] == pytest.approx(v, abs=1e-11)
        assert sol.energy[0] - (0.75**2 + 1) / 2 == pytest.approx(gain, abs=1e-11)


def test_a_start_within_the_floor_is_refused():
    eom, _ = ball()
    with pytest.raises(kn.SimulationError, match="gap of the contact 'floor' at or above zero"):
        kn.simulate(eom, (0, 1), q=[0, 0.05, 0], u=[0, 0, 0])


def test_coefficients_given_to_a_motion_are_checked():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y")
    e = kn.parameter("e", 0.5)
    P = O.at("P", y * N.y)
    stop = kn.joints.stop("floor", y, restitution=e)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", contacts=[stop]))
    with pytest.raises(kn.ModelError, match="restitution from 0 to 1"):
        kn.simulate(eom, (0, 1), q=[1], u=[0], parameters={"e": 1.5})


def test_a_jammed_rod_is_named():
    """Painlevé: sliding forward at 60° with μ = 2 there is no mode."""
    eom, _ = rod(2.0, g=G)
    theta = np.radians(60)
    with pytest.raises(kn.errors.ContactError, match="Painlevé"):
        kn.simulate(eom, (0, 1), q=[0, np.sin(theta), theta], u=[-1, 0, 0])


def test_files_and_pickles_keep_modes(tmp_path):
    eom, floor = block(0.5, 0.3)
    sol = kn.simulate(eom, (0, 2), q=[0, 0.1], u=[3, 0])
    sol.save(tmp_path / "run.npz")
    again = kn.load_solution(tmp_path / "run.npz", eom)
    copy = pickle.loads(pickle.dumps(sol))
    for other in (again, copy):
        own = other.equations.system.contacts[0]
        assert other.mode_history == sol.mode_history
        for a, b in zip(
            (own.normal_force, *own.friction_forces), (floor.normal_force, *floor.friction_forces), strict=True
        ):
            np.testing.assert_array_equal(other[a], sol[b])


def test_files_keep_that_a_ball_comes_to_rest(tmp_path):
    eom, _ = ball(0.5)
    sol = kn.simulate(eom, (0, 5), q=[0, 1, 0], u=[0, 0, 0])
    assert "rests" in sol.events[-1][0].name
    sol.save(tmp_path / "run.npz")
    again = kn.load_solution(tmp_path / "run.npz", eom)
    assert [(e.name, t) for e, t in again.events] == [(e.name, t) for e, t in sol.events]


def test_a_motion_goes_on():
    eom, _ = ball()
    whole = kn.simulate(eom, (0, 2), q=[0, 0.6, 0], u=[2, 0, 30], **TIGHT)
    first = kn.simulate(eom, (0, 1), q=[0, 0.6, 0], u=[2, 0, 30], **TIGHT)
    both = first + kn.simulate(eom, 2, start=first)
    np.testing.assert_allclose(both.states[-1], whole.states[-1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("begin", [0.0, 1e3])
def test_a_motion_goes_on_from_where_it_hits_but_for_rounding(begin):
    """A gap that a motion leaves a last digit below zero is no penetration: the impact is that of the motion in one go."""
    eom = kn.derive(bouncing_ball.system())
    for height in np.linspace(0.3, 1.9, 9):
        falls, start = begin + np.sqrt(2 * height / G), {"q": [height], "u": [0.0], "samples": 3}
        end = falls + 0.1
        whole = kn.simulate(eom, (begin, end), **start, **TIGHT)
        for ulps in range(-2, 4):
            first = kn.simulate(eom, (begin, falls + ulps * np.spacing(falls)), **start, **TIGHT)
            second = kn.simulate(eom, end, start=first, samples=3)
            np.testing.assert_allclose(second.states[-1], whole.states[-1], rtol=0, atol=1e-9)
    with pytest.raises(kn.SimulationError, match="at or above zero at the start"):
        kn.simulate(eom, (0, 1), q=[-1e-9], u=[-3.0])


def test_each_mode_can_be_derived():
    eom, floor = ball()
    stick = kn.derive(eom.system.in_modes({"floor": "stick"}))
    assert stick.reactions == (floor.normal_force, *floor.friction_forces)
    assert stick.system.modes == (kn.joints.ContactMode.STICK,)
    assert kn.derive(eom.system.in_modes({floor: "separated"})).system.constraints == ()
    with pytest.raises(kn.ModelError, match="a mode of the contact 'floor' among"):
        eom.system.in_modes({"floor": "glued"})
    with pytest.raises(kn.ModelError, match="contacts among floor"):
        eom.system.in_modes({"wall": "stick"})


def test_a_mode_is_linearized():
    """A mass on a spring rides on a belt where it slips, its friction constant: s² = −k/m; a ball that rolls has no such pull."""
    eom, floor = ball()
    rolls = kn.linearize(kn.derive(eom.system.in_modes({floor: "stick"})), q=[0, 0.1, 0], u=[1, 0, -10])
    np.testing.assert_allclose(rolls.eigenvalues, 0, atol=1e-12)
    eom, table = on_spring(0.1, surface=2.0)
    slides = kn.derive(eom.system.in_modes({table: "straight"}))
    linear = kn.linearize(slides, q=[0.1 * G], u=[0], parameters={table.direction[0]: -1.0})
    np.testing.assert_allclose(np.sort(linear.eigenvalues.imag), [-1, 1], rtol=1e-12)
    np.testing.assert_allclose(linear.eigenvalues.real, 0, atol=1e-12)


def test_a_motion_goes_on_from_an_event_of_its_own():
    """The event that ended it is not met again at once, in a mode of contacts as anywhere."""
    system = mass_on_belt.system()
    (u,) = system.speeds
    eom = kn.derive(system.replace(events=[kn.Event("turns", u, direction=-1)]))
    first = kn.simulate(eom, (0, 9), q=[0.16], u=[0.1])
    second = kn.simulate(eom, 9, start=first)
    assert second.event is not None
    assert second.event.name == "turns"
    assert second.t[-1] > first.t[-1] + 1


def test_a_motion_of_many_modes_ends_when_its_time_by_the_clock_is_over():
    eom, _ = ball(e=1.0)
    sol = kn.simulate(
        eom, (0, 1e6), q={"x": 0, "y": 1, "a": 0}, u={"u_x": 0, "u_y": 0, "u_a": 0}, max_seconds=0.3, samples=3
    )
    assert sol.status == "stopped"
    assert sol.message.startswith("max_seconds=0.3 have passed; at t = ")
    assert 0 < sol.t[-1] < 1e5


def test_a_contact_whose_normal_moves_nothing_is_named():
    """At its dead centre a pendulum's gap 1 − cos q has no rate, and N = 49 N, ever larger the nearer; as where it is held twice."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    A = N.rotate("A", q, N.z)
    P = O.at("P", 1.0 * A.x)
    wall = kn.contact(kn.joints.point_on_plane("wall", P, O.at("W", 1.0 * N.x), normal=-N.x), 0.2)
    bodies = [kn.Particle("bob", P, 1.0)]
    swings = kn.derive(
        kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[wall], coordinates=[q])
    )
    sol = kn.simulate(swings, (0, 1), q=[0.3], u=[-1.0])
    assert sol.status == "stopped"
    assert "whose normal force accelerates its bodies, got 'wall', whose gap cannot change here" in sol.message
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), 0.2)
    held = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", holonomic=[y], contacts=[floor]))
    with pytest.raises(kn.SimulationError, match="got 'floor', whose gap cannot change here to first order"):
        kn.simulate(held, (0, 1), q=[0, 0], u=[1, 0])


def test_actions_in_a_mode_set_values_of_their_own():
    """What leaves a threshold within rounding is a contact that opens, not every event of a mode's equations."""
    eom, floor = ball()
    flies = kn.derive(eom.system.in_modes({floor: "separated"}))
    x = np.array([0.0, 0.2, 0.0, 0.0, 0.0, 0.0])
    p = np.array([s.default for s in flies.parameters])
    now = stepped(flies, p, (), None)
    known = {e.name: 1.0 for e in flies.events}
    acted, opened = (at_start(now, 0.0, x, known, rounded=share)[1] for share in (0.0, 1e-15))
    assert {n.band for n in acted.values()} == {0.0}
    assert min(n.band for n in opened.values()) > 0


def test_an_arch_on_three_feet_stands_if_the_third_is_smooth():
    """Friction of a foot on the second body would change all normal forces; without any these are those of statics."""
    m, across, along = (2.0, 1.0), G * np.cos(0.1), -G * np.sin(0.1)

    def stood(mu):
        feet = (
            *(Touch(0, (x, -0.5), kinetic=0.6, static=0.6) for x in (0.4, -0.4)),
            Touch(1, (0.3, -0.5), kinetic=mu, static=mu),
        )
        own = model(arch := Plane(0.1, (Plate(m[0], 0.3), Plate(m[1], 0.2, ((0.1, 0.5), (-0.3, 0.5)))), feet))
        return kn.simulate(own.eom, (0, 1), q=[0, 0.5, 0, 0], u=[0] * 4, parameters=own.values(arch))

    sol = stood(0.0)
    n = [float(sol[c.normal_force][-1]) for c in sol.equations.system.contacts]
    third = m[1] * (0.3 * across - 0.5 * along) / 0.6  # moments about the pin, at (0.1, 1); the centre is at (0.4, 0.5)
    about_second = m[0] * (0.4 * across + 0.5 * along) + m[1] * (0.8 * across + 0.5 * along) - 1.1 * third
    first = about_second / 0.8
    assert n == pytest.approx([first, across * sum(m) - first - third, third], rel=1e-12)
    with pytest.raises(
        kn.SimulationError, match="with uniquely determined forces between rigid bodies, got 'c2', 'c0', 'c1'"
    ):
        stood(0.6)
