# SPDX-License-Identifier: BSD-3-Clause
"""The gallery's systems with contacts, beside closed forms and published numbers."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import kane as kn
from kane.gallery import (
    ball_on_turntable,
    bouncing_ball,
    clutch,
    dry_oscillator,
    eulers_disk,
    light_cart_pole,
    mass_on_belt,
    newtons_cradle,
    painleve_rod,
    pool_ball,
    rocking_block,
    shaken_block,
    skidding_disk,
    slider_crank_with_clearance,
    stacked_blocks,
    thrown_disk,
    tippe_top,
    winch,
    woodpecker,
)
from tests.oracles.one_contact import Happened, Model, Touch
from tests.oracles.one_contact import motion as second

g = 9.81
TIGHT = {"rtol": 1e-12, "atol": 1e-13}


def motion(module: Any, end: float, u: Any = None, **options: Any) -> kn.Solution:
    """From where the module starts, with other speeds by name."""
    start, eom = module.START, kn.derive(module.system())
    at_rest = {s.name: 0.0 for s in eom.speeds}
    return kn.simulate(eom, (0, end), q=start["q"], u=at_rest | start["u"] | (u or {}), **options)


def changes(sol: kn.Solution) -> list[tuple[float, str]]:
    """When the mode of the one contact begins, and which it is."""
    return [(t, next(iter(modes.values()))) for t, modes in sol.mode_history]


@pytest.mark.parametrize("spin", [60.0, 30.0, 0.0])
def test_a_thrown_disk_rolls_and_returns(spin: float) -> None:
    """t = (v + R ω)/(3 μ g); then (2 v − R ω)/3."""
    sol = motion(thrown_disk, 2, u={"u_theta": spin})
    (_, first), (t, second) = changes(sol)
    assert (first, second) == ("slip", "stick")
    assert t == pytest.approx((1 + 0.05 * spin) / (3 * 0.1 * g), rel=1e-13)
    assert sol["u_x"][-1] == pytest.approx((2 - 0.05 * spin) / 3, rel=1e-12)
    rolls = sol.t > t
    np.testing.assert_allclose((sol["u_x"] + 0.05 * sol["u_theta"])[rolls], 0, atol=1e-15)
    assert sol.energy_check.drift < 1e-11


def test_a_thrown_disk_beside_an_integration() -> None:
    """Newton and Euler of (x, θ) by SciPy with rtol 1e-13: from slip to its end, and a second of rolling."""
    m, R, mu = 0.2, 0.05, 0.1
    inertia = np.diag([m, m * R * R / 2])
    slip = np.array([1.0, R])  # the rate of slip is this row by the rates of x and θ

    def slides(_: float, z: Any) -> Any:
        return [*z[2:], *np.linalg.solve(inertia, -mu * m * g * np.sign(slip @ z[2:]) * slip)]

    def rolls(_: float, z: Any) -> Any:  # F is what keeps the slip at zero
        left = np.block([[inertia, -slip[:, None]], [slip[None], np.zeros((1, 1))]])
        return [*z[2:], *np.linalg.solve(left, np.zeros(3))[:2]]

    def ends(_: float, z: Any) -> float:
        return float(slip @ z[2:])

    ends.terminal = True  # type: ignore[attr-defined]
    exact: Any = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    first = solve_ivp(slides, (0, 5), [0, 0, 1, 60], events=ends, **exact)
    t = first.t[-1]
    later = solve_ivp(rolls, (t, t + 1), first.y[:, -1], **exact)
    sol = motion(thrown_disk, t + 1, **TIGHT)
    _, (holds, mode) = changes(sol)
    assert mode == "stick"
    assert holds == pytest.approx(t, abs=1e-9)
    found = [sol[name][-1] for name in ("x", "theta", "u_x", "u_theta")]
    np.testing.assert_allclose(found, later.y[:, -1], rtol=0, atol=1e-9)


def test_a_mass_on_a_belt_sticks_and_slips() -> None:
    mu_k, mu_s, k, v, w = 0.2, 0.4, 25.0, 0.2, 5.0
    sol = motion(mass_on_belt, 10)
    begins = [t for t, _ in changes(sol)]
    assert [m for _, m in changes(sol)] == ["stick", "slip"] * 6 + ["stick"]
    apart = (mu_s - mu_k) * g / k
    assert begins[1] == pytest.approx(mu_s * g / k / v, rel=1e-12)
    np.testing.assert_allclose(np.diff(begins)[1::2], (np.pi + 2 * np.arctan(v / (w * apart))) / w, rtol=1e-9)
    np.testing.assert_allclose(np.diff(begins)[2::2], 2 * apart / v, rtol=1e-9)
    sticks = sol.modes["belt"] == "stick"
    np.testing.assert_array_equal(sol["u_x"][sticks], v)


@pytest.mark.slow
def test_the_disk_of_the_article_rolls_in_the_end_and_slips_again() -> None:
    sol = motion(skidding_disk, 4, parameters={"mu_k": 0.1})
    (_, first), (rolls, second), (again, third) = changes(sol)
    assert (first, second, third) == ("slip", "stick", "slip")
    assert rolls == pytest.approx(3.170416, abs=5e-7)
    held = (sol.t > rolls) & (sol.t < again)
    slides = (sol.t < rolls) | (sol.t > again)
    floor = sol.equations.system.contacts[0]
    slip = np.array([sol[c.expr] for c in floor.slips])
    size = np.hypot(*(sol[f] for f in floor.friction_forces))
    np.testing.assert_allclose(slip[:, held], 0, atol=1e-10)
    assert (size[held] < 0.1 * sol[floor.normal_force][held]).all()
    np.testing.assert_allclose(size[slides], 0.1 * sol[floor.normal_force][slides], rtol=1e-12)


def test_a_ball_bounces_until_it_rests() -> None:
    sol = motion(bouncing_ball, 10)
    fall, e = np.sqrt(2 / g), 0.9
    times = [j.t for j in sol.jumps]
    expected = fall * (1 + 2 * np.cumsum(np.r_[0, e ** np.arange(1, 40)]))
    np.testing.assert_allclose(times[:40], expected, rtol=1e-13)
    assert times[9] == pytest.approx(5.43021800258535, abs=1e-12)
    _, mode = changes(sol)[-1]
    (rests,) = (t for e, t in sol.events if e.name == "floor rests")
    assert mode == "closed"
    assert rests == pytest.approx(8.57894917872889, abs=1e-12)
    np.testing.assert_array_equal(sol["y"][sol.t > rests], 0)


def test_a_clutch_brings_engine_and_load_together_and_slips_again() -> None:
    J, J_l, T_l = 0.2, 0.8, 40.0
    sol = motion(clutch, 2, inputs={"P": 3000 - 1000 * kn.time, "T": 80.0})
    (_, first), (holds, second), (lets, third) = changes(sol)
    assert (first, second, third) == ("slip", "stick", "slip")
    # the size is 120 − 40 t, whose mean until then is 120 − 20 t
    assert ((120 - 20 * holds - 80) / J + (120 - 20 * holds - T_l) / J_l) * holds == pytest.approx(150, rel=1e-10)
    assert 0.04 * (3000 - 1000 * lets) == pytest.approx((80 * J_l + T_l * J) / (J + J_l), rel=1e-12)
    momentum = J * sol["u_phi"] + J_l * sol["u_phi_l"]
    np.testing.assert_allclose(momentum, 150 * J + (80 - T_l) * sol.t, rtol=1e-10)


def test_a_winch_jerks_the_crate_off_the_floor() -> None:
    m, v = 50.0, 0.5
    sol = motion(winch, 1)
    assert [list(modes.values()) for _, modes in sol.mode_history] == [["separated", "closed"], ["closed", "separated"]]
    (jerk,) = sol.jumps
    assert jerk.t == pytest.approx(0.2 / v, rel=1e-14)
    assert jerk.energy == pytest.approx(m * v**2 / 2, rel=1e-14)
    rope, floor = (c.normal_force for c in sol.equations.system.contacts)
    hangs = np.arange(len(sol.t)) >= sol.begins[0]
    np.testing.assert_allclose(sol[rope], np.where(hangs, m * g, 0), rtol=1e-14)
    np.testing.assert_allclose(sol[floor], np.where(hangs, 0, m * g), rtol=1e-14)
    np.testing.assert_allclose(sol["y"], np.where(hangs, v * sol.t - 0.2, 0), atol=1e-13)


@pytest.mark.slow
def test_a_tippe_top_turns_over_and_keeps_jelletts_integral() -> None:
    """L·r, whatever the friction; in the end it rolls upside down."""
    sol = motion(tippe_top, 3, rtol=1e-10, atol=1e-12)
    (_, first), (rolls, second) = changes(sol)
    assert (first, second) == ("slip", "stick")
    m, R, a = 0.015, 0.025, 0.0075
    system = sol.equations.system
    (ball,) = system.bodies
    assert isinstance(ball, kn.RigidBody)
    B, N = ball.frame, system.inertial
    up = np.array([sol[N.z.dot(b)] for b in (B.x, B.y, B.z)])
    L = m * R**2 * np.array([131 / 350 * sol["w_x"], 131 / 350 * sol["w_y"], 0.4 * sol["w_z"]])
    r = np.array([[0], [0], [a]]) - R * up
    slides = sol.t <= rolls
    jellett = (L * r).sum(axis=0)
    np.testing.assert_allclose(jellett[slides], jellett[0], rtol=1e-9)
    np.testing.assert_allclose(jellett[~slides], jellett[0], rtol=1e-9)
    assert np.degrees(np.arccos(up[2][-1])) > 155
    assert sol[system.contacts[0].normal_force].min() > 0


def test_painleves_rod() -> None:
    """The factor of N vanishes at two angles; between them no force agrees with the laws, and that is said."""
    eom = kn.derive(painleve_rod.system())
    slides = kn.derive(eom.system.in_modes({"floor": "straight"}))

    def state(degrees: float, turns: float = 0.0) -> dict[str, list[float]]:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        return {"q": [0, s, np.radians(degrees)], "u": [-3 - s * turns, c * turns, turns]}

    for degrees, turns in ((20.0, 0.0), (50.0, 2.0), (60.0, 6.0), (80.0, 1.0)):
        (N,) = slides.evaluate(list(slides.reactions), **state(degrees, turns), parameters={"d_floor": -1.0})
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        assert pytest.approx((g - s * turns**2) / (1 + 3 * c * (c - 1.4 * s)), rel=1e-12) == N
    for degrees, sense in ((55.58581080789, -1), (69.95186698409, 1)):
        signs = [
            slides.evaluate(list(slides.reactions), **state(degrees + d), parameters={"d_floor": -1.0})[0]
            for d in (-1e-10, 1e-10)
        ]
        assert np.sign(signs).tolist() == [-sense, sense]
    for degrees in (50.0, 75.0):
        assert kn.simulate(eom, (0, 0.01), **state(degrees)).status == "finished"
    with pytest.raises(kn.SimulationError, match="got none: floor slides and its friction increases the normal force"):
        kn.simulate(eom, (0, 0.01), **state(60))
    with pytest.warns(
        kn.KaneWarning, match="got 2 that satisfy the laws of friction. The motion continues with floor separates"
    ):
        sol = kn.simulate(eom, (0, 0.01), **state(60, 6.0))
    assert changes(sol) == [(0.0, "separated")]
    flat = {"q": [0, np.sin(np.arctan(2)), np.arctan(2)], "u": [-3, 0, 0]}
    assert kn.simulate(eom, (0, 1e-6), **flat, parameters={"mu": 4 / 3 * (1 - 1e-2)}).status == "finished"
    with pytest.raises(kn.SimulationError, match="got none"):
        kn.simulate(eom, (0, 1e-6), **flat, parameters={"mu": 4 / 3 * (1 + 1e-9)})


def test_a_dry_oscillator_stops() -> None:
    """It loses 0.2 each half cycle, and stops at −0.05 after 5 π."""
    sol = motion(dry_oscillator, 20, **TIGHT)
    turns = [t for e, t in sol.events if e.name == "table sticks"]
    np.testing.assert_allclose(turns, np.pi * np.arange(1, 6), rtol=0, atol=1e-9)
    at = [sol["x"][np.flatnonzero(sol.t == t)[0]] for t in turns]
    np.testing.assert_allclose(np.abs(at), [0.85, 0.65, 0.45, 0.25, 0.05], rtol=0, atol=1e-9)
    assert sol["x"][-1] == pytest.approx(-0.05, abs=1e-9)
    assert [m for _, m in changes(sol)] == ["slip", "stick"]
    np.testing.assert_array_equal(sol["x"][sol.t > turns[-1]], sol["x"][-1])


def test_a_shaken_block_sticks_exactly() -> None:
    """With 60 % of the friction that it has, for 1,000 s."""
    sol = motion(shaken_block, 1000)
    assert changes(sol) == [(0.0, "stick")]
    assert not sol.states.any()
    floor = sol.equations.system.contacts[0]
    friction = 2 * (g * np.sin(0.2) - 0.01 * 100 * np.cos(10 * sol.t))
    np.testing.assert_allclose(sol[floor.friction_forces[0]], friction, rtol=0, atol=1e-12)


@pytest.mark.parametrize("scale", [1e4, 1e6])
def test_a_slowly_shaken_block_keeps_its_energy(scale: float) -> None:
    """Its energies are below atol in J: ∫P dt along the motion has errors of their size, which are no errors of the motion."""
    sol = motion(shaken_block, 3 * scale, parameters={"w": 10 / scale, "g": g / scale**2})
    assert not sol.states.any()
    assert sol.energy.max() < 1e-8
    assert sol.energy_check.relative < 1e-6
    with pytest.warns(kn.KaneWarning, match="∫P dt, whose errors may be atol = 1e-09 J a step"):
        motion(shaken_block, 1000 * scale, parameters={"w": 10 / scale, "g": g / scale**2})


def test_a_shaken_block_slips_as_it_must() -> None:
    """Slips by their closed forms: a slip ends where its speed vanishes, a stick where its friction does not suffice."""
    A, w, slope, mu, end = 0.06, 10.0, 0.2, 0.4, 3.0
    sol = motion(shaken_block, end, parameters={"A": A}, **TIGHT)
    most, pull = mu * g * np.cos(slope), g * np.sin(slope)
    fine = np.linspace(0, end, 300_001)

    def needed(t: Any) -> Any:
        return pull - A * w**2 * np.cos(w * t)

    t, x, expected = 0.0, 0.0, list[tuple[float, str, float]]()
    while t < end:
        sense = -np.sign(needed(t + 1e-9))

        def speed(z: Any, t: float = t, sense: float = sense) -> Any:
            return -(pull + sense * most) * (z - t) + A * w * (np.sin(w * z) - np.sin(w * t))

        slips = abs(needed(t + 1e-9)) > most
        expected.append((t, "slip" if slips else "stick", x))
        later = fine[fine > t + 1e-4]
        ends = sense * speed(later) < 0 if slips else np.abs(needed(later)) > most
        if not ends.any():
            break
        k = int(np.argmax(ends))
        what = speed if slips else (lambda z: abs(needed(z)) - most)
        begin, t = t, float(brentq(what, later[k] - 1.1e-5, later[k], xtol=1e-15))
        if slips:
            moved = A * (np.cos(w * begin) - np.cos(w * t)) - A * w * np.sin(w * begin) * (t - begin)
            x += -(pull + sense * most) * (t - begin) ** 2 / 2 + moved
    assert {m for _, m, _ in expected} == {"slip", "stick"}
    assert len(expected) > 15
    assert [m for _, m in changes(sol)] == [m for _, m, _ in expected]
    np.testing.assert_allclose([t for t, _ in changes(sol)], [t for t, _, _ in expected], rtol=0, atol=1e-9)
    at = [sol["x"][np.flatnonzero(sol.t == t)[-1]] for t, _ in changes(sol)]
    np.testing.assert_allclose(at, [x for _, _, x in expected], rtol=0, atol=1e-9)


def test_the_lower_of_stacked_blocks_is_pulled_away() -> None:
    """With F = 10 t N/s they start at μ M g, and part at (μ + μ_u) M g."""
    m, m_u, mu, mu_u = 3.0, 1.0, 0.2, 0.3
    M = m + m_u
    sol = motion(stacked_blocks, 3, inputs={"F": 10 * kn.time}, **TIGHT)
    both, alone = mu * M * g / 10, (mu + mu_u) * M * g / 10
    assert [list(modes.values()) for _, modes in sol.mode_history] == [
        ["stick", "stick"],
        ["slip", "stick"],
        ["slip", "slip"],
    ]
    np.testing.assert_allclose([t for t, _ in sol.mode_history], [0, both, alone], rtol=1e-11)
    v, v_u = (10 * (alone - both) ** 2 / 2 / M,) * 2
    t = 3 - alone
    v += ((10 * alone - mu * M * g - mu_u * m_u * g) * t + 5 * t**2) / m
    v_u += mu_u * g * t
    np.testing.assert_allclose([sol["u_x"][-1], sol["u_x_u"][-1]], [v, v_u - v], rtol=0, atol=1e-10)
    x = 10 * (alone - both) ** 3 / 6 / M
    first = 10 * (alone - both) ** 2 / 2 / M
    x_u = x + first * t + mu_u * g * t**2 / 2
    x += first * t + ((10 * alone - mu * M * g - mu_u * m_u * g) * t**2 / 2 + 5 * t**3 / 3) / m
    np.testing.assert_allclose([sol["x"][-1], sol["x_u"][-1]], [x, x_u - x], rtol=0, atol=1e-10)
    np.testing.assert_allclose(sol["u_x_u"][sol.t < alone], 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(sol["u_x"][sol.t < both], 0, rtol=0, atol=1e-15)


def test_a_rocking_block_loses_speed_by_housners_ratio() -> None:
    """ω⁺/ω⁻ = 1 − (3/2) sin² α at each impact, and the tilts between follow from the energy."""
    alpha = 0.2
    sol = motion(rocking_block, 4, **TIGHT)
    ratio = 0.940795745502164
    assert 1 - 1.5 * np.sin(alpha) ** 2 == pytest.approx(ratio, abs=1e-15)
    assert len(sol.jumps) >= 6
    turns = [jump.changes[sol.equations.speeds[2]] for jump in sol.jumps]
    for before, after in turns:
        assert after / before == pytest.approx(ratio, abs=1e-12)
    drop = np.cos(alpha - 0.1) - np.cos(alpha)  # of g (cos(α − θ₁) − cos α) = (2/3) R ω²
    speeds = [abs(before) for before, _ in turns]
    expected = np.sqrt(1.5 * g * drop) * ratio ** np.arange(len(speeds))
    np.testing.assert_allclose(speeds, expected, rtol=1e-9)
    np.testing.assert_allclose([j.energy for j in sol.jumps], -(2 / 3) * expected**2 * (1 - ratio**2), rtol=1e-9)
    assert sol.energy_check.drift < 1e-10


@pytest.mark.parametrize(
    ("rtol", "atol", "method"), [(1e-8, 1e-16, "tsit5"), (1e-10, 1e-30, "dop853"), (1e-8, 1e-16, "RK45")]
)
def test_a_corner_that_is_thrown_off_strikes_next_when_the_other_has_fallen(
    rtol: float, atol: float, method: str
) -> None:
    """The corners strike in turn: one whose gap is below zero by the error of the tilt, as the other strikes, does not strike anew."""
    sol = motion(rocking_block, 4, rtol=rtol, atol=atol, method=method)
    times = np.array([t for _, t in sol.events])
    assert [e.name for e, _ in sol.events] == ["left closes", "right closes"] * 3
    drop, ratio = np.cos(0.1) - np.cos(0.2), 1 - 1.5 * np.sin(0.2) ** 2
    for k, (a, b) in enumerate(
        pairwise([-times[0], *times])
    ):  # up from ω and down again: (2/3) R ω² = 2 g (cos(α − φ) − cos α)
        energy = drop * ratio ** (2 * k)
        top = 0.2 - np.arccos(np.cos(0.2) + energy)
        half, _ = quad(
            lambda s, top=top: 2 * s / np.sqrt(1.5 * g * (np.cos(0.2 - top) - np.cos(0.2 - top + s * s))),
            0,
            np.sqrt(top),
            epsabs=1e-13,
        )
        assert b - a == pytest.approx(2 * half, abs=1e-6)


def ball_thrown(sol: kn.Solution, v: Any, w: Any, mu: float, R: float) -> None:
    """Its slip v + R n × ω keeps its direction d: v falls by μ g along d until t = 2 |v_s|/(7 μ g)."""
    slip = np.array([v[0] - R * w[1], v[1] + R * w[0]])
    size = np.hypot(*slip)
    d, rolls = slip / size, 2 * size / (7 * mu * g)
    (_, first), (t, second) = changes(sol)
    assert (first, second) == ("slip", "stick")
    assert t == pytest.approx(rolls, abs=1e-10)
    slides = np.minimum(sol.t, rolls)
    for k, (x, u) in enumerate((("x", "u_x"), ("y", "u_y"))):
        path = v[k] * slides - mu * g * d[k] * slides**2 / 2
        speed = v[k] - mu * g * d[k] * slides
        np.testing.assert_allclose(sol[u], speed, rtol=0, atol=1e-10)
        np.testing.assert_allclose(sol[x], path + speed * (sol.t - slides), rtol=0, atol=1e-10)
    np.testing.assert_allclose(sol["w_z"], w[2], rtol=0, atol=1e-9)
    floor = sol.equations.system.contacts[0]
    force = np.array([sol[f] for f in floor.friction_forces])
    clearly = force[:, sol.t < rolls - 1e-3]  # at the end of the slip its direction is what rounding leaves of it
    np.testing.assert_allclose(clearly, np.outer(-mu * 0.17 * g * d, np.ones(clearly.shape[1])), rtol=0, atol=1e-9)
    assert np.abs(force[:, sol.modes[floor.name] == "stick"]).max() < 1e-12


def test_a_ball_struck_off_centre_slides_along_a_parabola_and_rolls() -> None:
    sol = motion(pool_ball, 2, **TIGHT)
    ball_thrown(sol, (2.0, 0.0), (-60.0, -20.0, 30.0), 0.2, 0.0286)


def test_a_ball_thrown_without_spin_rolls_with_five_sevenths() -> None:
    v = 2.0
    sol = motion(pool_ball, 2, u={"w_x": 0.0, "w_y": 0.0, "w_z": 0.0}, **TIGHT)
    ball_thrown(sol, (v, 0.0), (0.0, 0.0, 0.0), 0.2, 0.0286)
    assert changes(sol)[-1][0] == pytest.approx(2 * v / (7 * 0.2 * g), abs=1e-10)
    assert sol["u_x"][-1] == pytest.approx(5 * v / 7, abs=1e-10)


@pytest.mark.parametrize(("kappa", "share"), [(2 / 5, 2 / 7), (2 / 3, 2 / 5)])
def test_a_ball_on_a_turntable_runs_on_a_circle(kappa: float, share: float) -> None:
    """It goes round at κ Ω/(1 + κ), wherever it begins."""
    sol = motion(ball_on_turntable, 8, parameters={"kappa": kappa}, **TIGHT)
    assert changes(sol) == [(0.0, "stick")]
    rate = 3.0 * share
    v = np.array([0.1 + 0.2j])
    expected = 0.3 + v / (1j * rate) * (np.exp(1j * rate * sol.t) - 1)
    np.testing.assert_allclose(sol["x"] + 1j * sol["y"], expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize(("share", "mode"), [(1 + 1e-6, "stick"), (1 - 1e-6, "slip")])
def test_a_ball_on_a_turntable_slips_where_its_friction_does_not_suffice(share: float, mode: str) -> None:
    """It needs κ/(1 + κ) Ω |v| = μ g to roll on."""
    needed = 3 * (2 / 7) * np.hypot(0.1, 0.2) / g
    sol = motion(ball_on_turntable, 1, parameters={"mu": share * needed})
    assert changes(sol)[0] == (0.0, mode)


def test_eulers_disk_runs_round_with_its_centre_at_rest() -> None:
    """Ω² = 4 g/(R sin θ)."""
    R, tilt = 0.0375, 0.5
    sol = motion(eulers_disk, 2, **TIGHT)
    assert changes(sol) == [(0.0, "stick")]
    rate = np.sqrt(4 * g / (R * np.sin(tilt)))
    np.testing.assert_allclose(sol["psi"], rate * sol.t, rtol=0, atol=1e-9)
    for name in ("x", "y", "w_1", "w_3", "u_x", "u_y", "u_z"):
        np.testing.assert_allclose(sol[name], 0, atol=1e-9)
    np.testing.assert_allclose(sol["theta"], tilt, rtol=0, atol=1e-9)


def test_eulers_disk_slides_and_then_keeps_its_energy() -> None:
    """Friction takes what its power says while it slides, and nothing while it rolls."""
    sol = motion(eulers_disk, 2, u={"w_3": 3.0}, **TIGHT)
    (_, first), (rolls, second) = changes(sol)
    assert (first, second) == ("slip", "stick")
    assert sol.jumps == ()
    (floor,) = sol.equations.system.contacts
    slips = np.array([sol[c.expr] for c in floor.slips])
    force = np.array([sol[f] for f in floor.friction_forces])
    held = sol.t > rolls
    np.testing.assert_allclose(slips[:, held], 0, atol=1e-11)
    np.testing.assert_allclose(sol.energy[held], sol.energy[-1], rtol=1e-11)
    assert (np.hypot(*force)[held] <= 0.3 * sol[floor.normal_force][held]).all()
    assert sol.energy[0] - sol.energy[-1] > 1e-4
    assert sol.energy_check.drift < 1e-10


def test_eulers_disk_falls_flat_from_rest() -> None:
    """About the place of contact, which stays: (5/4) R θ̇² = 2 g (sin θ₀ − sin θ)."""
    R, tilt = 0.0375, 0.5
    sol = motion(eulers_disk, 2, u={"w_2": 0.0}, parameters={"mu": 5.0}, **TIGHT)
    assert sol.event is not None
    assert (sol.event.name, changes(sol)) == ("lies flat", [(0.0, "stick")])

    def time(s: float) -> float:  # θ = θ₀ − s² takes the root from the integrand
        fall = 2 * np.cos(tilt - s * s / 2) * np.sin(s * s / 2)
        return float(2 * s * np.sqrt(5 * R / (8 * g * fall))) if s > 0 else 0.0

    expected = quad(time, 1e-12, np.sqrt(tilt - 1e-3), epsabs=1e-13, epsrel=1e-12)[0]
    assert sol.t[-1] == pytest.approx(expected, abs=1e-10)


def test_a_pendulum_on_a_light_cart() -> None:
    """θ after 10 s with 11 peaks of 4,429 rad/s, and the time to the first, by an integral."""
    M, m = 1e-6, 1.0
    sol = motion(light_cart_pole, 10, **TIGHT)
    assert sol["theta"][-1] == pytest.approx(-1.549129441897076, abs=1e-8)
    sine = np.sin  # cos θ = sin² p takes the root from the integrand

    def rate(p: float) -> float:
        s = sine(p)
        return float(np.sqrt((M + m * np.cos(p) ** 2 * (1 + s * s)) / (2 * g * (M + m))) * 2 / np.sqrt(1 + s * s))

    ends = (0, 1.5, np.pi / 2 - 1e-2, np.pi / 2 - 1e-3, np.pi / 2)
    quarter = sum(quad(rate, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in pairwise(ends))
    assert quarter == pytest.approx(0.451524535681659, abs=1e-14)
    system = light_cart_pole.system()
    theta = system.coordinates[1]
    more = kn.derive(system.replace(events=[kn.Event("bottom", theta, terminal=False)]))
    whole = kn.simulate(more, (0, 10), q=light_cart_pole.START["q"], u=light_cart_pole.START["u"], **TIGHT)
    passes = np.array([t for _, t in whole.events])
    assert len(passes) == 11
    np.testing.assert_allclose(passes, quarter * np.arange(1, 22, 2), rtol=0, atol=1e-9)
    assert np.sqrt(2 * g * (1 + m / M)) == pytest.approx(4429, abs=1)


@pytest.mark.parametrize(("e", "last"), [(1.0, 1.0), (0.9, 0.81450625), (0.5, 0.31640625)])
@pytest.mark.parametrize("gap", [1e-6, 0.0])
def test_newtons_cradle(e: float, last: float, gap: float) -> None:
    """The last ball leaves with ((1 + e)/2)⁴ of the speed of the first, whether or not the balls touch; momentum stays."""
    assert last == pytest.approx(((1 + e) / 2) ** 4, rel=1e-15)
    start = {"x_1": -0.1} | {f"x_{k}": (k - 1) * gap for k in range(2, 6)}
    sol = kn.simulate(kn.derive(newtons_cradle.system()), (0, 0.2), q=start, u=[1, 0, 0, 0, 0], parameters={"e": e})
    assert sol.u[-1][4] == pytest.approx(last, rel=1e-14)
    assert sol.u[-1].sum() == pytest.approx(1, rel=1e-14)
    assert (np.diff(sol.u[-1]) > -1e-15).all()
    assert len(sol.jumps) == (1 if gap == 0 else 4 if e == 1 else 10)
    if e == 1:
        np.testing.assert_allclose(sol.u[-1][:4], 0, atol=1e-15)


@pytest.mark.parametrize("e", [1.0, 0.6, 0.0])
def test_two_balls_share_the_speed(e: float) -> None:
    """(1 − e)/2 and (1 + e)/2."""
    eom = kn.derive(newtons_cradle.system(balls=2))
    sol = kn.simulate(eom, (0, 0.2), q=[-0.1, 0], u=[1, 0], parameters={"e": e})
    np.testing.assert_allclose(sol.u[-1], [(1 - e) / 2, (1 + e) / 2], rtol=0, atol=1e-15)
    (jump,) = sol.jumps
    assert jump.t == pytest.approx(0.1, rel=1e-13)
    assert jump.energy == pytest.approx(-0.1 * (1 - e * e) / 4, abs=1e-16)


def woodpeckers_model() -> Model:
    """M q̈ + K q = f with rows that do not change."""
    r_O, r_M, h_M, l_M, l_G, h_S, l_S = 0.0025, 0.0031, 0.0058, 0.010, 0.015, 0.02, 0.0201
    m_M, m_S, J_M, J_S, c, mu = 0.0003, 0.0045, 5e-9, 7e-7, 0.0056, 0.3
    first, bird = np.array([1, 0, 0]), np.array([1, l_M, l_G])
    M = m_M * np.outer(first, first) + m_S * np.outer(bird, bird) + np.diag([0, J_M, J_S])
    K = c * np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])
    f = -g * (m_M * first + m_S * bird)

    def touch(name: str, gap: float, normal: list[float], along: list[float], e: float) -> Touch:
        J = np.array([normal, along])
        return Touch(name, lambda q: gap + J[0] @ q, lambda _: J, mu, e)

    beak = touch("beak", l_M + l_G - l_S - r_O, [0, 0, -h_S], [1, l_M, l_G - l_S], 0.5)
    lower, upper = (touch(n, r_M - r_O, [0, s * h_M, 0], [1, r_M, 0], 0.0) for n, s in (("lower", 1), ("upper", -1)))
    return Model(lambda _: M, lambda q, _: f - K @ q, (beak, lower, upper))


def assert_same_events(sol: kn.Solution, expected: list[Happened], near: float) -> None:
    """Names, times and states after them."""
    assert [e.name for e, _ in sol.events][: len(expected)] == [x.name for x in expected]
    for (_, t), x in zip(sol.events, expected, strict=False):
        k = np.flatnonzero(sol.t == t)[-1]
        assert t == pytest.approx(x.t, abs=1e-12)
        np.testing.assert_allclose(sol.q[k], x.q, rtol=0, atol=near)
        np.testing.assert_allclose(sol.u[k], x.u, rtol=0, atol=near * max(1, np.abs(x.u).max()))


def test_a_woodpecker_beside_a_second_route() -> None:
    """Fourteen events of a period and a half."""
    start = woodpecker.START
    q, u = (np.array(list(start[k].values())) for k in ("q", "u"))
    expected = second(woodpeckers_model(), q, u, 0.25, (1, -1.0), 14, 1e-3)
    assert len(expected) == 14
    assert_same_events(motion(woodpecker, 0.25, rtol=1e-12, atol=1e-15), expected, 1e-11)


def test_a_woodpeckers_period() -> None:
    """It falls by 19.4454 mm in 0.145976 s, again and again; steps of 20 µs make 19.48 mm in 0.14604 s of the first period."""
    # where the upper edge opens, on the limit cycle: after 80 periods
    start = [0.0, 6 / 58, 6 / 58], [0.0530265056, 0.0, -6.2406723571]
    sol = kn.simulate(kn.derive(woodpecker.system()), (0, 0.2), q=start[0], u=start[1], rtol=1e-12, atol=1e-15)
    opens = next(t for e, t in sol.events if e.name == "upper opens" and t > 0.1)
    k = np.flatnonzero(sol.t == opens)[-1]
    assert opens == pytest.approx(0.1459761, abs=1e-7)
    assert sol["y"][k] == pytest.approx(-0.0194454, abs=5e-8)
    np.testing.assert_allclose(sol.states[k][1:], np.concatenate(start)[1:], rtol=0, atol=1e-7)


def test_a_slider_crank_with_a_clearance_beside_a_second_route() -> None:
    """Five impacts of corners; then the slider clatters until it lies flat, and nothing penetrates, pulls or gains energy."""
    l_1, l_2, a, b, c = 0.153, 0.306, 0.05, 0.025, 0.001
    m_1, m_2, m_3, inertia = 0.038, 0.038, 0.076, np.array([7.4e-5, 5.9e-4, 2.7e-6])
    both, lengths = m_2 / 2 + m_3, np.array([l_1, l_2])

    def mass(q: Any) -> Any:
        own = inertia + np.array([(m_1 / 4 + m_2 + m_3) * l_1**2, (m_2 / 4 + m_3) * l_2**2, 0])
        k = both * l_1 * l_2 * np.cos(q[1] - q[0])
        return np.diag(own) + k * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])

    def forces(q: Any, u: Any) -> Any:
        k = both * l_1 * l_2 * np.sin(q[0] - q[1])
        weights = np.array([(m_1 / 2 + m_2 + m_3) * l_1, both * l_2]) * g * np.cos(q[:2])
        return np.array([-k * u[1] ** 2 - weights[0], k * u[0] ** 2 - weights[1], 0])

    def corner(name: str, side: int, end: int) -> Touch:
        def gap(q: Any) -> float:
            return float(b + c - side * (lengths @ np.sin(q[:2]) + end * a * np.sin(q[2]) + side * b * np.cos(q[2])))

        def rows(q: Any) -> Any:
            up = [*(lengths * np.cos(q[:2])), end * a * np.cos(q[2]) - side * b * np.sin(q[2])]
            level = [*(-lengths * np.sin(q[:2])), -end * a * np.sin(q[2]) - side * b * np.cos(q[2])]
            return np.array([-side * np.array(up), level])

        return Touch(name, gap, rows, 0.01, 0.4)

    corners = tuple(corner(f"{n} {k}", s, end) for n, s in (("top", 1), ("bottom", -1)) for k, end in ((1, -1), (2, 1)))
    expected = second(Model(mass, forces, corners), np.zeros(3), np.array([150, -75, -0.01]), 0.05, None, 5, 1e-4)
    sol = motion(slider_crank_with_clearance, 0.05, rtol=1e-11, atol=1e-13)
    assert [x.name for x in expected] == [
        "top 1 closes",
        "top 2 closes",
        "top 1 closes",
        "top 2 closes",
        "top 1 closes",
    ]
    assert_same_events(sol, expected, 1e-11)
    assert sol.status == "finished"
    assert ["slip", "slip", "separated", "separated"] in [list(modes.values()) for _, modes in sol.mode_history]
    assert np.diff(sol.energy).max() < 1e-9
    for floor in sol.equations.system.contacts:
        assert floor.gap is not None
        assert sol[floor.gap.expr].min() > -1e-12
        assert sol[floor.normal_force].min() > -1e-9


@pytest.mark.slow
def test_a_slider_that_rebounds_where_its_gap_opened_without_speed() -> None:
    """Its corners hit a tolerance below the wall and leave from there: no impact is found twice, and the tolerance hardly matters."""
    times = []
    for atol in (1e-9, 1e-7, 1e-6, 1e-5, 1e-4):
        sol = motion(slider_crank_with_clearance, 0.065, rtol=1e-9, atol=atol, samples=2)
        assert sol.status == "finished", (atol, sol.message)
        hits = [t for e, t in sol.events if e.name in ("bottom 1 closes", "top 1 closes")]
        assert min(np.diff(hits)) > 0, atol  # none twice at one instant
        times.append([next(t for t in hits if t > after) for after in (0.035, 0.055)])
    np.testing.assert_allclose(times, [times[0]] * len(times), rtol=0, atol=2e-6)
