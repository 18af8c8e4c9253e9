# SPDX-License-Identifier: BSD-3-Clause
"""Friction beyond Coulomb's: viscous, falling with the speed of slip, of ropes round drums, against rolling and drilling."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import kane as kn
from kane.gallery.contacts import pool_ball

G = 9.81
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def times(sol, what):
    return [t for e, t in sol.events if e.name == what]


def words(sol, name):
    return [modes[name] for _, modes in sol.mode_history]


def ground():
    N = kn.Frame("N")
    return N, kn.Point("O", fixed_in=N)


def block(mu, *, height=0.0, surface=0.0, force=0.0, opens=True, space=False, **laws):
    """A particle of 2 kg over a floor that may run, pulled by a force along x; x, y (and z)."""
    N, O = ground()
    q = kn.coordinates("x y z" if space else "x y" if opens else "x")
    P = O.at("P", q[0] * N.x + (q[1] if opens else 0) * N.y + (q[2] if space else 0) * N.z)
    place = kn.joints.point_on_plane("floor", P, O, normal=N.y, surface=surface * N.x if surface else None)
    normal = None if opens else kn.reaction("N_P", at=P, along=N.y)
    floor = kn.contact(place, mu, normal=normal, **laws)
    loads = [kn.gravity(-G * N.y), kn.Force(P, force(q[0]) * N.x if callable(force) else force * N.x)]
    bodies = [kn.Particle("block", P, 2.0)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor])), floor


# Viscous ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("opens", [True, False])
def test_viscous_friction_alone_decays(opens):
    """v = v₀ exp(−c t/m), and a slip that never ends."""
    eom, floor = block(0, opens=opens, viscous=0.8)
    sol = kn.simulate(eom, (0, 5), q=[0.0] * (1 + opens), u=[3.0] + [0.0] * opens, **TIGHT)
    assert sol.u[-1, 0] == pytest.approx(3 * np.exp(-0.4 * 5), abs=1e-11)
    np.testing.assert_allclose(sol[floor.friction_forces[0]], -0.8 * sol.u[:, 0], rtol=1e-12)
    assert words(sol, "floor") == ["slip"]


def test_dry_and_viscous_friction():
    """m v̇ = −μ m g − c v stops at (m/c) ln(1 + c v₀/(μ m g)), after m v₀/c − (μ m g/c) t."""
    m, mu, c, v = 2.0, 0.2, 0.8, 3.0
    eom, _ = block(mu, viscous=c)
    sol = kn.simulate(eom, (0, 5), q=[0, 0], u=[v, 0], **TIGHT)
    t = m / c * np.log(1 + c * v / (mu * m * G))
    assert times(sol, "floor sticks") == [pytest.approx(t, abs=1e-12)]
    assert sol["x"][-1] == pytest.approx(m * v / c - mu * m * G / c * t, abs=1e-11)
    assert words(sol, "floor") == ["slip", "stick"]


def test_viscous_friction_in_space():
    """Across the plane it slips along v, whose direction stays, wherever steps end beside the end of the slip."""
    m, mu, c = 2.0, 0.2, 0.8
    eom, _ = block(mu, viscous=c, space=True)
    t = m / c * np.log(1 + c * 5 / (mu * m * G))
    for way in np.linspace(0, 6.2, 40):
        v = 5 * np.array([np.cos(way), 0.0, -np.sin(way)])
        sol = kn.simulate(eom, (0, 5), q=[0, 0, 0], u=v, **TIGHT)
        assert times(sol, "floor sticks") == [pytest.approx(t, abs=1e-10)]
        np.testing.assert_allclose(sol.q[-1], v / 5 * (m * 5 / c - mu * m * G / c * t), rtol=0, atol=1e-9)


TOLERANCES = [
    {"rtol": 1e-8, "atol": 1e-8},
    pytest.param({"rtol": 1e-9, "atol": 1e-6}, marks=pytest.mark.slow),
    {"rtol": 1e-9, "atol": 1e-4},
    pytest.param({"rtol": 1e-6, "atol": 1e-12}, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("tolerances", TOLERANCES)
def test_a_slip_in_space_ends_whatever_tolerances_leave_of_it(tolerances):
    """A block and a ball of radius R, after m/c ln(1 + c v/(μ m g)) and 2 v/(7 μ g), however slips turn in their coordinates."""
    eom, _ = block(0.2, viscous=0.8, space=True)
    ball, (v, spin), radius = kn.derive(pool_ball.system()), (2.0, 8.0), 0.3
    near = 100 * max(tolerances.values())
    stops = 2 / 0.8 * np.log(1 + 0.8 * 5 / (0.2 * 2 * G))
    for way in np.linspace(0, 6.2, 20):
        along = np.array([np.cos(way), np.sin(way)])
        sol = kn.simulate(eom, (0, 5), q=[0, 0, 0], u=[5 * along[0], 0, 5 * along[1]], samples=2, **tolerances)
        assert times(sol, "floor sticks") == [pytest.approx(stops, abs=near)]
        start = {"q": [0, 0, radius, 1, 0, 0, 0], "u": [*(v * along[::-1]), 0, *(spin * along), 20 * along[0]]}
        sol = kn.simulate(ball, (0, 2), **start, parameters={"R": radius}, samples=2, **tolerances)
        slip = np.hypot(v * along[1] - radius * spin * along[1], (v + radius * spin) * along[0])
        assert words(sol, "table") == ["slip", "stick"]
        assert times(sol, "table sticks") == [pytest.approx(2 * slip / (7 * 0.2 * G), abs=near)]


def test_a_separated_contact_has_no_viscous_friction():
    """It flies with v₀, and lands with the impulse of dry friction alone."""
    eom, _ = block(0.1, viscous=0.8)
    sol = kn.simulate(eom, (0, 1), q=[0, 0.2], u=[3, 0], **TIGHT)
    fall = np.sqrt(2 * 0.2 / G)
    begin = 3 - 0.1 * G * fall
    t = 1 - fall
    assert times(sol, "floor closes") == [pytest.approx(fall, abs=1e-11)]
    dry = 0.1 * 2 * G / 0.8
    assert sol.u[-1, 0] == pytest.approx((begin + dry) * np.exp(-0.4 * t) - dry, abs=1e-10)


def test_a_force_moves_what_has_viscous_friction_alone():
    """Dry friction of 0 does not hold: v = (F/c)(1 − exp(−c t/m)) from rest."""
    eom, _ = block(0, force=1.0, viscous=0.8)
    sol = kn.simulate(eom, (0, 3), q=[0, 0], u=[0, 0], **TIGHT)
    assert sol.u[-1, 0] == pytest.approx((1 - np.exp(-0.4 * 3)) / 0.8, abs=1e-11)


@pytest.mark.parametrize("begins", [0.0, 0.5])
def test_a_force_that_changes_its_sign_where_dry_friction_is_none(begins):
    """m v̇ = F sin ω t − c v from rest, where F begins at zero; a stick of no size holds nothing."""
    m, c, w = 2.0, 0.8, 3.0
    eom, _ = block(0, force=kn.sin(w * kn.time), viscous=c)
    sol = kn.simulate(eom, (begins, 10), q=[0, 0], u=[0, 0], **TIGHT)

    def forced(t):
        return (c * np.sin(w * t) - m * w * np.cos(w * t)) / ((m * w) ** 2 + c * c)

    v = forced(10) - forced(begins) * np.exp(-c / m * (10 - begins))
    assert sol.u[-1, 0] == pytest.approx(v, abs=1e-11)


@pytest.mark.parametrize("apart", [0.0, 0.1])
def test_viscous_friction_presses_another_contact(apart):
    """Two blocks, the first braked by c v, the second by less: the one behind stays at the first, or hits it and stays there."""
    N, O = ground()
    x, y = kn.coordinates("x y")
    P, Q = O.at("P", x * N.x), O.at("Q", y * N.x)
    normals = [kn.reaction(f"N_{p.name}", at=p, along=N.y) for p in (P, Q)]
    places = [kn.joints.point_on_plane(f"floor of {p.name}", p, O, normal=N.y) for p in (P, Q)]
    first = kn.contact(places[0], 0, viscous=2.0, normal=normals[0])
    second = kn.contact(places[1], 0.05, normal=normals[1])
    (gap_row,) = kn.coincident(P, Q, N.x)
    bumper = kn.joints.stop("bumper", gap_row)
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("q", Q, 3.0)]
    contacts = [first, second, bumper]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=contacts)
    sol = kn.simulate(kn.derive(system), (0, 0.7), q=[apart, 0], u=[2, 2], **TIGHT)
    a = 0.05 * G

    def gap(t):
        return apart + 1 - np.exp(-2 * t) - 2 * t + a * t * t / 2

    hit = brentq(gap, 0.01, 0.7, xtol=1e-15) if apart else 0.0
    v = (2 * np.exp(-2 * hit) + 3 * (2 - a * hit)) / 4
    v = (v + 1.5 * a) * np.exp(-(0.7 - hit) / 2) - 1.5 * a
    np.testing.assert_allclose(sol.u[-1], [v, v], rtol=0, atol=1e-10)
    assert words(sol, "bumper") == (["separated", "closed"] if apart else ["closed"])
    np.testing.assert_allclose(sol[bumper.normal_force][-1], 2 * v - (v / 2 + 0.75 * a), rtol=1e-9)


# Of the speed of slip --------------------------------------------------------------------------------------------------------


def stribeck(v, kinetic=0.3, static=0.4, speed=0.2):
    return kinetic + (static - kinetic) * np.exp(-((v / speed) ** 2))


@pytest.mark.parametrize("opens", [True, False])
def test_stick_slip_on_a_belt_by_stribecks_law(opens):
    """The slips of a mass on a spring beside an integration of their own equation: k x = μ_s m g, v̇ = 0 at their beginning."""
    belt, k, m, c = 0.1, 4.0, 2.0, 0.05
    law = kn.joints.stribeck(0.3, 0.4, 0.2)
    eom, _ = block(law, surface=belt, force=lambda x: -k * x, opens=opens, viscous=c)
    sol = kn.simulate(eom, (0, 60), q=[0.0] * (1 + opens), u=[belt] + [0.0] * opens, **TIGHT)

    def slip(t, y):
        v = belt - y[1]
        return [y[1], (-k * y[0] + stribeck(v) * m * G + c * v) / m]

    def sticks(t, y):
        return y[1] - belt if t > 0.1 else -1.0

    sticks.terminal, sticks.direction = True, 1
    start = [0.4 * m * G / k, belt]
    own = solve_ivp(slip, (0, 20), start, method="DOP853", rtol=1e-13, atol=1e-14, events=sticks, max_step=0.1)
    begins, ends = np.array(times(sol, "floor slips")), np.array(times(sol, "floor sticks"))
    assert words(sol, "floor")[:4] == ["stick", "slip", "stick", "slip"]
    assert len(begins) >= 2
    assert begins[0] == pytest.approx(start[0] / belt, abs=1e-9)
    np.testing.assert_allclose(ends - begins[: len(ends)], own.t[-1], rtol=0, atol=1e-9)
    stuck = (start[0] - own.y[0, -1]) / belt
    np.testing.assert_allclose(np.diff(begins), own.t[-1] + stuck, rtol=0, atol=1e-8)


def test_stribecks_law_in_space():
    """On a belt that runs across the throw the slip turns: |s| falls by its own equation until it sticks."""
    eom, _ = block(kn.joints.stribeck(0.3, 0.4, 0.2), space=True, surface=0.5)
    sol = kn.simulate(eom, (0, 1), q=[0, 0, 0], u=[0, 0, 1.0], **TIGHT)
    t = quad(lambda s: 1 / (stribeck(s) * G), 0, np.hypot(0.5, 1.0), epsabs=1e-13)[0]
    assert times(sol, "floor sticks") == [pytest.approx(t, abs=1e-9)]
    np.testing.assert_allclose(sol.u[-1], [0.5, 0, 0], rtol=0, atol=1e-14)


def test_onset_of_slip_on_a_slope_of_force():
    """μ(0) = μ_s: a force that grows by r a second moves the block when it exceeds μ_s m g, once and for all."""
    N, O = ground()
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    normal = kn.reaction("N_P", at=P, along=N.y)
    place = kn.joints.point_on_plane("floor", P, O, normal=N.y)
    floor = kn.contact(place, kn.joints.stribeck(0.1, 0.2, 0.05), normal=normal)
    loads = [kn.gravity(-G * N.y), kn.Force(P, 2 * kn.time * N.x)]
    system = kn.System(N, bodies=[kn.Particle("block", P, 1.0)], speeds="rates", loads=loads, contacts=[floor])
    sol = kn.simulate(kn.derive(system), (0, 2), q=[0], u=[0], **TIGHT)
    assert words(sol, "floor") == ["stick", "slip"]
    begin = 0.1 * G
    assert times(sol, "floor slips") == [pytest.approx(begin, abs=1e-11)]
    own = solve_ivp(
        lambda t, v: 2 * t - stribeck(v, 0.1, 0.2, 0.05) * G, (begin, 2), [0.0], method="DOP853", rtol=1e-13, atol=1e-15
    )
    assert sol.u[-1, 0] == pytest.approx(own.y[0, -1], abs=1e-9)


def test_friction_that_grows_with_the_slip():
    """μ = μ₀ + b v, beyond μ_s: v̇ = −g (μ₀ + b v) stops at ln(1 + b v₀/μ₀)/(b g)."""
    mu, b, v = 0.1, 0.3, 3.0
    eom, _ = block(lambda s: mu + b * s)
    sol = kn.simulate(eom, (0, 2), q=[0, 0], u=[v, 0], **TIGHT)
    assert times(sol, "floor sticks") == [pytest.approx(np.log(1 + b * v / mu) / (b * G), abs=1e-11)]
    assert words(sol, "floor") == ["slip", "stick"]


def test_a_joint_with_stribecks_and_viscous_friction():
    """A pin that is spun: ω̇ = −(T(ω) + c ω)/I, beside an integration of its own."""
    N, O = ground()
    a = kn.coordinate("a")
    pin = kn.joints.pin("pin", O, N, axis=N.z, coordinates=[a])
    body = kn.RigidBody(
        "rotor", frame=pin.frame, mass_center=pin.point, mass=1.0, inertia=kn.inertia(pin.frame, 1, 1, 0.5)
    )
    rub = kn.joints.stiction(pin, kn.joints.stribeck(0.2, 0.5, 1.0), viscous=0.1)
    system = kn.System(N, bodies=[body], joints=[pin], speeds="rates", contacts=[rub])
    sol = kn.simulate(kn.derive(system), (0, 20), q=[0], u=[4.0], **TIGHT)

    def ends(t, w):
        return w[0]

    ends.terminal = True
    own = solve_ivp(
        lambda t, w: -(stribeck(w, 0.2, 0.5, 1.0) + 0.1 * w) / 0.5,
        (0, 20),
        [4.0],
        "DOP853",
        rtol=1e-13,
        atol=1e-14,
        events=ends,
    )
    assert times(sol, f"{rub.name} sticks") == [pytest.approx(own.t[-1], abs=1e-10)]


# Ropes round drums -----------------------------------------------------------------------------------------------------------


def hoist(m1, m2, mu, angle, **more):
    """Two loads, by their depths x and y below two drums 0.6 m apart, round the first of which the rope is wound."""
    N, O = ground()
    x, y = kn.coordinates("x y")
    P, Q = O.at("P", -0.3 * N.x - x * N.y), O.at("Q", 0.3 * N.x - y * N.y)
    drum, pulley = O.at("drum", -0.3 * N.x), O.at("pulley", 0.3 * N.x)
    rope = kn.joints.capstan("rope", [P, drum, pulley, Q], 3.6, mu, drum=drum, angle=angle, **more)
    bodies = [kn.Particle("p", P, m1), kn.Particle("q", Q, m2)]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[rope])
    return kn.derive(system), rope


def tensions(sol, rope):
    n, f = (np.asarray(sol[s]) for s in (rope.normal_force, rope.friction_forces[0]))
    return n + f / 2, n - f / 2


MU, TURN = 0.2, 2 * np.pi
RATIO = np.exp(MU * TURN)


def test_a_capstan_holds_a_load():
    """1 kg holds 3 kg by one turn at μ = 0.2, of e^(0.4 π) = 3.51; nothing moves at all."""
    eom, rope = hoist(1.0, 3.0, MU, TURN)
    sol = kn.simulate(eom, (0, 100), q=[1, 2], u=[0, 0], **TIGHT)
    assert words(sol, "rope") == ["stick"]
    assert not np.ptp(sol.q, axis=0).any()
    np.testing.assert_allclose(np.transpose(tensions(sol, rope)), [[G, 3 * G]] * len(sol.t), rtol=1e-14)


@pytest.mark.parametrize(("m1", "m2"), [(1.0, 6.0), (6.0, 1.0)])
def test_a_capstan_lowers_a_load(m1, m2):
    """Atwood's machine with T₂ = e^(μθ) T₁: a = g (M − e^(μθ) m)/(M + e^(μθ) m), either way."""
    eom, rope = hoist(m1, m2, MU, TURN)
    sol = kn.simulate(eom, (0, 0.5), q=[1, 2], u=[0, 0], **TIGHT)
    heavy, light = max(m1, m2), min(m1, m2)
    a = G * (heavy - RATIO * light) / (heavy + RATIO * light) * (1 if m2 > m1 else -1)
    np.testing.assert_allclose(sol.u[-1], [-a * 0.5, a * 0.5], rtol=0, atol=1e-11)
    before, behind = tensions(sol, rope)
    np.testing.assert_allclose(behind / before, RATIO ** (1 if m2 > m1 else -1), rtol=1e-12)
    assert words(sol, "rope") == ["slip"]


def test_a_capstan_brakes_a_load():
    """Lowered at v₀ it stops after v₀/a with a = g (e^(μθ) m − M)/(M + e^(μθ) m), and stays."""
    eom, _ = hoist(1.0, 3.0, MU, TURN)
    sol = kn.simulate(eom, (0, 1), q=[1, 2], u=[-0.4, 0.4], **TIGHT)
    a = G * (RATIO - 3) / (RATIO + 3)
    assert times(sol, "rope sticks") == [pytest.approx(0.4 / a, abs=1e-11)]
    assert sol["y"][-1] == pytest.approx(2 + 0.16 / (2 * a), abs=1e-11)


def test_a_capstan_that_turns():
    """The rope runs with the drum; static friction holds more than sliding friction."""
    eom, _ = hoist(1.0, 6.0, MU, TURN, static=0.4, surface=0.5)
    sol = kn.simulate(eom, (0, 1), q=[1, 2], u=[-0.5, 0.5], **TIGHT)
    assert words(sol, "rope") == ["stick"]
    np.testing.assert_allclose(sol.q[-1], [0.5, 2.5], rtol=0, atol=1e-14)


def test_a_capstan_becomes_taut():
    """Impulses on both sides are in the ratio e^(μθ), too."""
    eom, _ = hoist(1.0, 6.0, MU, TURN)
    sol = kn.simulate(eom, (0, 0.3), q=[1, 1.9], u=[0, 0], **TIGHT)
    (jump,) = sol.jumps
    dp, dq = (after - before for before, after in jump.changes.values())
    assert 6 * dq / dp == pytest.approx(RATIO, rel=1e-12)


def test_capstans_that_cannot_be():
    N, O = ground()
    x = kn.coordinate("x")
    P, Q, R = O.at("P", x * N.x), O.at("Q", N.x), O.at("R", N.y)
    with pytest.raises(
        kn.ModelError, match=r"Expected the drum of 'rope' among the points between the rope's ends, got .*P"
    ):
        kn.joints.capstan("rope", [P, Q, R], 3, 0.1, drum=P, angle=1)
    with pytest.raises(kn.ModelError, match="Expected an angle of 'rope' at or above zero, got -1"):
        kn.joints.capstan("rope", [P, Q, R], 3, 0.1, drum=Q, angle=-1)
    with pytest.raises(kn.ModelError, match="Expected a speed v_s of Stribeck's friction above zero, got 0"):
        kn.joints.stribeck(0.1, 0.2, 0)
    with pytest.raises(kn.ModelError, match="Expected viscous= of 'floor' at or above zero, got -1"):
        block(0.1, viscous=-1)
    with pytest.raises(kn.ModelError, match="μ_k ≤ μ_s of the contact 'floor'"):
        block(kn.joints.stribeck(0.3, 0.4, 0.1), static=0.2)
    with pytest.raises(kn.ModelError, match=r"μ_s − μ_k of Stribeck's friction at or above zero.*Swap them"):
        kn.joints.stribeck(0.4, 0.3, 0.1)


# Against rolling and drilling ------------------------------------------------------------------------------------------------

RADIUS, ARM, HALF = 0.1, 0.004, 0.5


def disk(slope=0.0, *, opens=True, restitution=0.0, mu=0.5, **more):
    """A disk of 2 kg in the plane, on an incline, with its centre's x and y (unless the coordinates keep it closed) and its angle."""
    N, O = ground()
    I = N.rotate("I", slope, N.z)
    x, y, a = kn.coordinates("x y a")
    B = I.rotate("B", a, I.z)
    C = O.at("C", x * I.x + (y if opens else RADIUS) * I.y)
    normal = None if opens else kn.reaction("N_C", at=C, along=I.y)
    place = kn.joints.sphere_on_plane("floor", B, C, O, radius=RADIUS, normal=I.y)
    floor = kn.contact(place, mu, normal=normal, restitution=restitution)
    roll = kn.joints.rolling_resistance(floor, **{"arm": ARM, **more})
    body = kn.RigidBody("disk", frame=B, mass_center=C, mass=2.0, inertia=kn.inertia(B, 1, 1, HALF * 2 * RADIUS**2))
    loads = [kn.gravity(-G * N.y)]
    order = (x, y, a) if opens else (x, a)
    system = kn.System(N, bodies=[body], speeds="rates", loads=loads, contacts=[floor, roll], coordinates=order)
    return kn.derive(system), floor, roll


def rolling(v, opens=True, height=0.0):
    return {"q": [0, RADIUS + height, 0] if opens else [0, 0], "u": [v, 0, -v / RADIUS] if opens else [v, -v / RADIUS]}


@pytest.mark.parametrize("opens", [True, False])
def test_a_disk_that_rolls_stops(opens):
    """After s = v² (1 + k) R/(2 ρ g), k = I/(m R²), where friction brakes it by ρ N/R − k m a and the couple is ρ N."""
    eom, floor, roll = disk(opens=opens)
    sol = kn.simulate(eom, (0, 5), **rolling(1.0, opens), **TIGHT)
    t = (1 + HALF) * RADIUS / (ARM * G)
    assert times(sol, f"{roll.name} sticks") == [pytest.approx(t, abs=1e-11)]
    assert sol["x"][-1] == pytest.approx(t / 2, abs=1e-11)
    assert words(sol, "floor") == ["stick", "stick"]
    assert words(sol, roll.name) == ["slip", "stick"]
    couple, force, moves = sol[roll.friction_forces[0]], sol[floor.friction_forces[0]], sol.t < t - 1e-9
    np.testing.assert_allclose(couple[moves], ARM * 2 * G, rtol=1e-12)
    np.testing.assert_allclose(force[moves], -2 / t, rtol=1e-12)
    assert not couple[sol.t > t + 1e-9].any()
    assert np.abs(sol.u[-1]).max() < 1e-100


@pytest.mark.parametrize("static", [None, 0.006])
def test_a_disk_rests_on_a_slope_below_the_friction_angle_of_rolling(static):
    """Up to tan α = ρ_s/R it moves exactly 0, beyond with g (sin α − ρ cos α/R)/(1 + k)."""
    most = (static or ARM) / RADIUS
    below, above = np.arctan(most) + np.array([-1e-6, 1e-6])
    eom, _, roll = disk(below, static=static)
    sol = kn.simulate(eom, (0, 100), **rolling(0.0), **TIGHT)
    assert words(sol, roll.name) == ["stick"]
    assert not np.ptp(sol.q, axis=0).any()
    np.testing.assert_allclose(sol[roll.friction_forces[0]], -2 * G * np.sin(below) * RADIUS, rtol=1e-9)
    eom, _, roll = disk(above, static=static)
    sol = kn.simulate(eom, (0, 2), **rolling(0.0), **TIGHT)
    a = G * (np.sin(above) - ARM / RADIUS * np.cos(above)) / (1 + HALF)
    assert words(sol, roll.name) == ["slip"]
    assert sol["x"][-1] == pytest.approx(-2 * a, abs=1e-11)


def test_a_disk_thrown_slides_rolls_and_stops():
    """While it slides the couple brakes its spin: α = (μ R − ρ) g/(k R²); then it rolls to its end."""
    eom, _, roll = disk(mu=0.3)
    v, mu = 2.0, 0.3
    sol = kn.simulate(eom, (0, 10), q=[0, RADIUS, 0], u=[v, 0, 0], **TIGHT)
    spin_up = (mu * RADIUS - ARM) * G / (HALF * RADIUS**2)
    t = v / (mu * G + spin_up * RADIUS)
    left = v - mu * G * t
    assert times(sol, "floor sticks") == [pytest.approx(t, abs=1e-11)]
    stop = t + left * (1 + HALF) * RADIUS / (ARM * G)
    assert times(sol, f"{roll.name} sticks") == [pytest.approx(stop, abs=1e-10)]
    words_ = [(m["floor"], m[roll.name]) for _, m in sol.mode_history]
    assert words_ == [("slip", "slip"), ("stick", "slip"), ("stick", "stick")]


def test_there_is_no_couple_where_nothing_presses():
    """A disk that spins in flight keeps its spin, bounces, and in the end stops."""
    eom, _, roll = disk(restitution=0.5)
    sol = kn.simulate(eom, (0, 6), **rolling(1.0, height=0.1), **TIGHT)
    flies = np.asarray(sol.modes["floor"]) == "separated"
    assert flies.any()
    assert set(np.asarray(sol.modes[roll.name])[flies]) == {"separated"}
    assert not np.asarray(sol[roll.friction_forces[0]])[flies].any()
    first = sol.t < 0.14
    np.testing.assert_allclose(sol.u[first][:, 2], -1 / RADIUS, rtol=1e-14)
    assert words(sol, roll.name)[-1] == "stick"
    assert np.abs(sol.u[-1]).max() < 1e-100


@pytest.mark.parametrize("sense", [1, -1])
def test_a_couple_that_changes_what_presses(sense):
    """A wheel on an arm below its hinge, on a belt: F R = ρ N, so that N (1 ± (ρ/R) tan β) = m g."""
    N, O = ground()
    b, a = kn.coordinates("b a")
    A = N.rotate("A", b, N.z)
    C = O.at("C", A.x)
    B = A.rotate("B", a, A.z)
    beta, arm = 0.5, 0.03
    floor_point = O.at("F", -(np.sin(beta) + RADIUS) * N.y)
    place = kn.joints.sphere_on_plane("belt", B, C, floor_point, radius=RADIUS, normal=N.y, surface=sense * N.x)
    belt = kn.contact(place, 0.8)
    roll = kn.joints.rolling_resistance(belt, arm)
    body = kn.RigidBody("wheel", frame=B, mass_center=C, mass=2.0, inertia=kn.inertia(B, 1, 1, 0.01))
    system = kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-G * N.y)], contacts=[belt, roll])
    sol = kn.simulate(kn.derive(system), (0, 2), q=[-beta, 0], u=[0, 0], **TIGHT)
    assert words(sol, "belt")[-1] == "stick"
    assert words(sol, roll.name)[-1] == "slip"
    n = 2 * G / (1 + sense * arm / RADIUS * np.tan(beta))
    assert sol[belt.normal_force][-1] == pytest.approx(n, rel=1e-9)
    assert sol[belt.friction_forces[0]][-1] == pytest.approx(sense * arm * n / RADIUS, rel=1e-9)
    assert sol.u[-1, 1] == pytest.approx(sense / RADIUS, abs=1e-9)


def ball(*resist, mu=0.5, restitution=0):
    """A ball in space, its centre's velocity and its angular velocity as speeds."""
    N, O = ground()
    q, u = kn.coordinates("q1:7"), kn.speeds("u1:7")
    A = N.rotate("A", q[0], N.z)
    A2 = A.rotate("A2", q[1], A.x)
    B = A2.rotate("B", q[2], A2.y)
    C = O.at("C", q[3] * N.x + q[4] * N.y + q[5] * N.z)
    floor = kn.contact(
        kn.joints.sphere_on_plane("floor", B, C, O, radius=RADIUS, normal=N.z), mu, restitution=restitution
    )
    w, v = B.angular_velocity(N), C.velocity(N)
    speeds = dict(zip(u, [f.dot(e) for f in (w, v) for e in (N.x, N.y, N.z)], strict=True))
    body = kn.RigidBody("ball", frame=B, mass_center=C, mass=2.0, inertia=kn.inertia(B, *[0.4 * 2 * RADIUS**2] * 3))
    contacts = [floor, *(make(floor, arm) for make, arm in resist)]
    return kn.derive(kn.System(N, bodies=[body], speeds=speeds, loads=[kn.gravity(-G * N.z)], contacts=contacts))


def test_a_ball_that_spins_on_a_spot_stops():
    """Drilling: ω̇ = −δ m g/I, to its end at I ω/(δ m g)."""
    eom = ball((kn.joints.drilling_resistance, 0.001))
    sol = kn.simulate(eom, (0, 10), q=[0.1, 0.2, 0.3, 0, 0, RADIUS], u=[0, 0, 8, 0, 0, 0], **TIGHT)
    a = 0.001 * G / (0.4 * RADIUS**2)
    assert times(sol, "drilling of floor sticks") == [pytest.approx(8 / a, abs=1e-9)]
    moves = sol.t < 8 / a
    np.testing.assert_allclose(sol.u[moves, 2], 8 - a * sol.t[moves], rtol=0, atol=1e-9)
    assert words(sol, "drilling of floor") == ["slip", "stick"]


def test_a_ball_rolls_and_drills_to_its_end():
    """Rolling, the couple is against ω in the plane: it goes straight to v² (1 + k) R/(2 ρ g); drilling goes on for itself."""
    eom = ball((kn.joints.rolling_resistance, ARM), (kn.joints.drilling_resistance, 0.001))
    v = np.array([0.6, 0.8])
    w = np.array([-v[1], v[0]]) / RADIUS
    sol = kn.simulate(eom, (0, 6), q=[0.1, 0.2, 0.3, 0, 0, RADIUS], u=[*w, 8, *v, 0], **TIGHT)
    t = 1.4 * RADIUS / (ARM * G)
    assert times(sol, "rolling of floor sticks") == [pytest.approx(t, abs=1e-8)]
    np.testing.assert_allclose(sol.q[-1, 3:5], v * t / 2, rtol=0, atol=1e-8)
    assert times(sol, "drilling of floor sticks") == [pytest.approx(8 * 0.4 * RADIUS**2 / (0.001 * G), abs=1e-8)]
    assert {"floor": "stick", "rolling of floor": "slip", "drilling of floor": "slip"} in [
        m for _, m in sol.mode_history
    ]
    assert set(words(sol, "floor")) == {"stick"}


def test_a_mode_with_resistance_is_read():
    """`in_modes`: what presses being separated, its couples are, too."""
    eom, _, roll = disk()
    assert eom.system.in_modes({"floor": "separated"}).modes == (0, 0)
    rolls = kn.derive(eom.system.in_modes({"floor": "stick", roll: "straight"}))
    assert [str(r) for r in rolls.reactions] == ["N_floor", "F_floor"]


def test_resistances_that_cannot_be():
    N, O = ground()
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    point = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), 0.1)
    with pytest.raises(kn.ModelError, match="Expected a body that turns about axes of 'rolling of floor', got none"):
        kn.joints.rolling_resistance(point, 0.1)
    stop = kn.joints.stop("stop", y)
    with pytest.raises(
        kn.ModelError, match=r"Expected a contact of kn.contact\(…\), which has a normal force at a point, got 'stop'"
    ):
        kn.joints.rolling_resistance(stop, 0.1)
    eom, _, roll = disk()
    with pytest.raises(
        kn.ModelError,
        match=r"Expected the contact whose normal force 'rolling of floor' depends on listed, too, got .*floor",
    ):
        kn.System(eom.system.inertial, bodies=eom.system.bodies, speeds="rates", contacts=[roll])


COIN = 0.01163


def coin(drilling: float = 0.0) -> kn.Equations:
    """One cent on its edge; friction 0.2 unless told."""
    N, O = ground()
    mu, static = kn.parameter("mu", 0.2), kn.parameter("mu_s", 0.2)
    free = kn.free("coin", O, N, orientation="angles", sequence="zxz", velocity="parent", child="B")
    B, m = free.frame, 0.0075
    across = m * COIN**2 / 4
    inertia = kn.inertia(B, across, across, m * COIN**2 / 2)
    body = kn.RigidBody("coin", frame=B, mass_center=free.point, mass=m, inertia=inertia)
    edge = kn.joints.disk_on_plane("table", B, free.point, O, axis=B.z, radius=COIN, normal=N.z)
    contacts = [kn.contact(edge, mu, static=static)]
    contacts += [kn.joints.drilling_resistance(contacts[0], drilling)] if drilling else []
    return kn.derive(kn.System(N, bodies=[body], joints=[free], loads=[kn.gravity(-G * N.z)], contacts=contacts))


def spun(lean: float, rate: float) -> dict[str, list[float]]:
    """About the vertical through its centre, which is at rest."""
    s, c = np.cos(lean), np.sin(lean)
    return {"q": [0, np.pi / 2 - lean, 0, 0, 0, COIN * s], "u": [0, rate * s, rate * c, 0, 0, 0]}


@pytest.mark.slow
def test_a_coin_that_drills_begins_to_slip_while_its_friction_turns():
    """With μ_s = μ slip begins without acceleration, against the friction before, again and again."""
    eom = coin(2e-4)
    sol, other = (
        kn.simulate(eom, (0, 2), parameters={"mu_s": static}, **spun(0.02, 100.0)) for static in (0.2, 0.2 + 1e-7)
    )
    for one in (sol, other):
        assert one.status == "finished"
        assert one.energy_check.relative < 1e-9
        assert words(one, "table").count("slip") == 4
    assert sol.steps < 5000
    begins = [[t for t, _ in one.mode_history] for one in (sol, other)]
    np.testing.assert_allclose(*begins, rtol=0, atol=1e-6)


def test_slip_that_begins_against_a_friction_it_keeps_turns_with_it():
    """M s' = P(t) − μ m g s/|s| of a block on a cross slide from |P| = μ m g on, s ~ t² along P there, beside SciPy's Radau.

    The slide carries 20 times the block's mass in x: P, which turns, accelerates the block mostly in y, away from where P leads.
    What rounding leaves of the acceleration at that instant, which may be nothing, decides nothing.
    """
    N, O = ground()
    x, z = kn.coordinates("x z", "m")
    P = O.at("P", x * N.x + z * N.z)
    mu, turns, grows = 0.3, 4.0, 2.0
    more = kn.parameter("more", 0.0, "N/s")
    normal = kn.reaction("N_P", at=P, along=N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), mu, normal=normal)
    turned, newton = turns * kn.time * kn.parameter("Hz", 1.0, "1/s"), kn.parameter("f", 1.0, "N")
    pull = mu * G * 0.9 * newton + grows * kn.time * kn.parameter("f'", 1.0, "N/s") + more * kn.time
    loads = [kn.gravity(-G * N.y), kn.Force(P, pull * (kn.cos(turned) * N.x + kn.sin(turned) * N.z))]
    bodies = [kn.Particle("block", P, 1.0), kn.Particle("slide", O.at("S", x * N.x + N.y), 20.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor]))
    for k in range(20):
        one = kn.simulate(eom, (0, 0.5), q=[0, 0], u=[0, 0], parameters={"more": 0.04 * k - 0.2}, **TIGHT)
        assert words(one, "floor") == ["stick", "slip"]
        assert times(one, "floor slips") == [pytest.approx(0.1 * mu * G / (grows + 0.04 * k - 0.2), abs=1e-11)]
    begins, masses = 0.1 * mu * G / grows, np.array([21.0, 1.0])

    def pulled(t):
        return (mu * G * 0.9 + grows * t) * np.array([np.cos(turns * t), np.sin(turns * t)])

    def rates(t, y):
        return [*y[2:], *(pulled(t) - mu * G * y[2:] / np.hypot(*y[2:])) / masses]

    e = pulled(begins) / (mu * G)
    start = [0, 0, *1e-9 * e]
    sol = kn.simulate(eom, (0, 0.5), q=[0, 0], u=[0, 0], **TIGHT)
    again = kn.simulate(eom, (0, 0.5), q=[0, 0], u=[0, 0], **TIGHT)
    second = solve_ivp(rates, (begins, 0.5), start, method="Radau", rtol=1e-9, atol=1e-13)
    for one in (sol, again):
        assert words(one, "floor") == ["stick", "slip"]
        assert times(one, "floor slips") == [pytest.approx(begins, abs=1e-11)]
        np.testing.assert_allclose(one.states[-1], second.y[:, -1], rtol=0, atol=1e-8)
