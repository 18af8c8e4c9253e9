# SPDX-License-Identifier: BSD-3-Clause
"""The gallery's systems with contacts, beside closed forms and published numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import (
    bouncing_ball,
    clutch,
    mass_on_belt,
    painleve_rod,
    skidding_disk,
    thrown_disk,
    tippe_top,
    winch,
)

g = 9.81


def motion(module: Any, end: float, u: Any = None, **options: Any) -> kn.Solution:
    """From where the module starts, with other speeds by name."""
    start = module.START
    return kn.simulate(kn.derive(module.system()), (0, end), q=start["q"], u=start["u"] | (u or {}), **options)


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
    assert times[9] == pytest.approx(5.43021800258535, abs=1e-13)
    _, mode = changes(sol)[-1]
    (rests,) = (t for e, t in sol.events if e.name == "floor rests")
    assert mode == "stick"
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
    assert [list(modes.values()) for _, modes in sol.mode_history] == [["separated", "stick"], ["stick", "separated"]]
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
    with pytest.raises(kn.SimulationError, match="Painlevé's paradox"):
        kn.simulate(eom, (0, 0.01), **state(60))
