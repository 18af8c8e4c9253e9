# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles against published numbers, closed forms, and a Taylor integration with 20 digits and more."""

import math

import numpy as np
import pytest

import kane as kn
from kane.gallery import compass_gait, mass_on_belt, rimless_wheel, simplest_walker


@pytest.fixture(scope="module")
def walker():
    return kn.derive(simplest_walker.system())


LONG = (0.20031090054424708936, -0.19983247300495235454, 3.8824637528513741)
PAIR = -0.1900998410658881 + 0.5575987766820683j
SHORT = (0.19393736981018180853, -0.2038669274420069268, 3.0961058680781637)
REAL = (4.00386435892974, 0.45958958979768)


def started(eom, theta, rate, **more):
    swing = [2 * theta, (1 - math.cos(2 * theta)) * rate]
    return kn.limit_cycle(eom, section="strike", q=[theta], u=[rate], states=swing, **more)


def test_simplest_walker_long_gait(walker):
    """Garcia, Chatterjee, Ruina, Coleman 1998; digits by a Taylor integration with 34 digits."""
    cycle = started(walker, 0.2, -0.2)
    assert np.allclose(cycle.x[:2], LONG[:2], rtol=0, atol=1e-11)
    assert abs(cycle.period - LONG[2]) < 1e-11
    assert np.abs(cycle.multipliers - [PAIR, PAIR.conjugate(), 0]).max() < 1e-10
    assert cycle.stable


@pytest.mark.slow
def test_simplest_walker_short_gait_by_continuation(walker):
    """From small steps, whose limit is known: θ* → 0.943976 γ^⅓, T → π (Garcia et al. 1998, sec. 4); digits by mpmath.odefun."""
    theta = 0.943976 * 1e-3 ** (1 / 3)
    small = started(walker, theta, -theta * (1 + math.cosh(math.pi)) / math.sinh(math.pi), parameters={"gamma": 1e-3})
    assert abs(small.period - math.pi) < 2e-2
    cycle = small.follow("gamma", 0.009, locate=False).cycles[-1]
    assert np.allclose(cycle.x[:2], SHORT[:2], rtol=0, atol=1e-11)
    assert abs(cycle.period - SHORT[2]) < 1e-11
    assert np.allclose(cycle.multipliers[:2], REAL, rtol=1e-10)
    assert not cycle.stable


@pytest.mark.slow
def test_simplest_walker_doubles_its_period(walker):
    """The long gait is stable up to a slope of about 0.0151, where a multiplier passes −1 (Garcia et al. 1998, fig. 4)."""
    branch = kn.limit_cycle(walker, section="strike", **simplest_walker.START).follow("gamma", 0.016)
    (change,) = branch.changes
    assert (change.kind, change.grows) == ("flip", True)
    assert abs(change.value - 0.0151) < 1e-4
    assert abs(change.multiplier + 1) < 1e-6
    assert branch.stable.tolist() == [True, False]


def test_simplest_walker_is_the_limit_of_light_feet():
    """A hip of mass M with feet of mass β M, by Kane's method: as β → 0 the accelerations are those of the gallery."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    theta, phi = kn.coordinates("theta phi")
    beta, gamma = kn.parameter("beta", 1e-9), kn.parameter("gamma", 0.009)
    A = N.rotate("A", theta, N.z)
    hip = O.at("hip", A.y)
    foot = hip.at("foot", -A.rotate("B", -phi, N.z).y)
    down = -kn.cos(gamma) * N.y + kn.sin(gamma) * N.x
    bodies = [kn.Particle("hip", hip, 1.0), kn.Particle("foot", foot, beta)]
    whole = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(down)], coordinates=(theta, phi)))
    light = kn.derive(simplest_walker.system())
    state = [0.1, 0.3], [-0.25, 0.4]
    own = light.evaluate(
        [*light.accelerations, *light.state_rates], q=[0.1], u=[-0.25], states=[0.3, 0.4], parameters={}
    )
    assert np.allclose(whole.evaluate(list(whole.accelerations), q=state[0], u=state[1]), [own[0], own[2]], atol=1e-8)


def test_compass_gait():
    """Goswami, Thuilot, Espiau 1996: 3°, m 5, m_H 10, a = b = 0.5, g 9.8; twelve printed digits."""
    cycle = kn.limit_cycle(kn.derive(compass_gait.system()), q=[-0.32, 0.22], u=[-0.38, -1.09], section="strike")
    assert np.allclose(cycle.x, [-0.323388558059, 0.218668802939, -0.377181558403, -1.091826677490], rtol=0, atol=1e-12)
    assert abs(cycle.period - 0.734720962155) < 1e-12
    assert abs(2 * math.sin((cycle.x[1] - cycle.x[0]) / 2) - 0.535445415430) < 1e-12
    assert np.allclose(cycle.multipliers, [-0.199726 + 0.544476j, -0.199726 - 0.544476j, 0.131573], rtol=0, atol=6e-7)


def test_rimless_wheel():
    """McGeer 1990: ω*² = 4 (g/l) sin α sin γ cot² 2α; ω² − ω*² shrinks by cos² 2α a step, and so does ω − ω* to first order."""
    cycle = kn.limit_cycle(kn.derive(rimless_wheel.system()), section="strike", **rimless_wheel.START)
    alpha, gamma = math.pi / 8, 0.08
    assert abs(cycle.x[1] ** 2 - 4 * 9.81 * math.sin(alpha) * math.sin(gamma) / math.tan(2 * alpha) ** 2) < 1e-11
    assert abs(cycle.multipliers[0] - math.cos(2 * alpha) ** 2) < 1e-11


def test_mass_on_a_belt():
    """Stick-slip: it sticks for 2 Δ/v and slips for (π + 2 arctan(v/(ω Δ)))/ω; what sticks forgets, so that the multiplier is 0."""
    eom = kn.derive(mass_on_belt.system())
    turns = kn.Event("turns", eom.speeds[0], direction=-1)
    cycle = kn.limit_cycle(eom, q=[0.16], u=[0], section=turns)
    delta, omega, v = 0.2 * 9.81 / 25, 5.0, 0.2
    assert abs(cycle.period - 2 * delta / v - (math.pi + 2 * math.atan(v / (omega * delta))) / omega) < 1e-11
    assert np.abs(cycle.multipliers).max() < 1e-11
    assert [m["belt"] for _, m in cycle.solution.mode_history] == ["slip", "stick", "slip"]


def test_ball_on_a_shaken_table():
    """One bounce a period: it leaves with V (1 + e) = ½ g T (1 − e) over the table's speed V; the map of (time, speed) by hand."""
    a, w, e, g = 0.01, 40.0, 0.6, 9.81
    length = 2 * math.pi / w
    phase = math.acos(g * length / 2 * (1 - e) / (1 + e) / (a * w))
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y", "m")
    A, W = kn.parameter("A", a, "m"), kn.parameter("W", w, "rad/s")
    ball, table = O.at("ball", y * N.y), O.at("table", A * kn.sin(W * kn.time) * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", ball, table, normal=N.y), restitution=e)
    loads = [kn.gravity(-kn.parameter("g", g, "m/s^2") * N.y)]
    bodies = [kn.Particle("ball", ball, kn.parameter("m", 1.0, "kg"))]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor]))
    half, v = length / 2, g * length / 2
    top = a * math.sin(phase) + v * half - g * half**2 / 2
    cycle = kn.limit_cycle(eom, q=[1.001 * top], u=[0.003], period=2 * kn.pi / W, t=phase / w + half)
    assert np.allclose(cycle.x, [top, 0], rtol=0, atol=1e-12)
    speed, lift = a * w * math.cos(phase), -a * w**2 * math.sin(phase)
    late = -length / (v - g * length - speed)
    by_hand = [[1, late], [(1 + e) * lift, (1 + e) * lift * late - e * (1 - g * late)]]
    wanted = np.sort(np.linalg.eigvals(np.array(by_hand)))
    assert np.allclose(np.sort(cycle.multipliers.real), wanted, rtol=1e-10)
    assert np.isclose(np.prod(cycle.multipliers).real, e**2, rtol=1e-10)


def test_van_der_pol():
    """The period for μ = 1 (Andersen & Geer 1982: 6.66328686)."""
    x, u = kn.coordinate("x"), kn.speed("u")
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    force = kn.Force(P, ((1 - x**2) * u - x) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", P, 1)], speeds={u: x.dt}, loads=[force]))
    cycle = kn.limit_cycle(eom, q=[2.1], u=[0], section=kn.Event("turns", u, direction=-1))
    assert abs(cycle.period - 6.663286859323) < 1e-12
    # Liouville: the multiplier is exp ∮ (1 − x²) dt
    t, values = cycle.solution.t, 1 - cycle.solution["x"] ** 2
    from scipy.interpolate import make_interp_spline

    assert np.isclose(
        np.log(cycle.multipliers[0].real), make_interp_spline(t, values, k=7).integrate(t[0], t[-1]), rtol=1e-9
    )
