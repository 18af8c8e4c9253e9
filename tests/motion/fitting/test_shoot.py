# SPDX-License-Identifier: BSD-3-Clause
"""Motions that end where they should, beside optimal control in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.fitting import curve
from kane.gallery import load, pendulum_on_cart
from tests.gallery.test_scales import factor


def pushed():
    """A particle of 2 kg with a force: 2 ẍ = F."""
    N, F, m = kn.Frame("N"), kn.input("F"), kn.parameter("m", 2.0)
    x, u = kn.coordinate("x"), kn.speed("u")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("B", P, m)], speeds={u: x.dt}, loads=[kn.Force(P, F * N.x)]))


@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_least_effort_from_rest_to_rest(kind):
    """F = m (6 − 12 t) takes a mass by 1 m in 1 s from rest to rest with the least ∫ F² dt = 12 m²."""
    eom = pushed()
    F = curve("F", [0, 0.5, 1] if kind == "linear" else np.linspace(0, 1, 5), 0.1, kind=kind)
    shot = kn.fitting.shoot(
        eom, (0, 1), F.nodes, q=[0], u=[0], inputs={"F": F.expression}, end={"x": 1, "u": 0}, integral=F.expression**2
    )
    assert shot.cost == pytest.approx(48.0, rel=1e-7)
    assert shot.off < 1e-7
    np.testing.assert_allclose(list(shot.values.values())[:: 1 if kind == "linear" else 2], [12, 0, -12], atol=1e-3)
    again = kn.simulate(eom, (0, 1), start=shot.start, parameters=shot.parameters, inputs={"F": F.expression})
    np.testing.assert_allclose(again.states[-1], [1, 0], atol=1e-7)


def test_bounds_and_conditions_between_values():
    """The farthest that |F| ≤ 4 reaches in 1 s is 1 m at 2 m/s; with u ≤ 1 at the end the force is not all used."""
    eom = pushed()
    F = curve("F", [0, 0.5], 1.0, kind="steps")
    bounds = dict.fromkeys(F.nodes, (-4, 4))
    given = {"q": [0], "u": [0], "inputs": {"F": F.expression}, "bounds": bounds}
    far = kn.fitting.shoot(eom, (0, 1), F.nodes, cost=-eom.coordinates[0], **given)
    assert far.cost == pytest.approx(-1.0, abs=1e-6)
    held = kn.fitting.shoot(eom, (0, 1), F.nodes, cost=-eom.coordinates[0], end={"u": (None, 1)}, **given)
    assert -held.cost == pytest.approx(0.75, abs=1e-6)  # 2 m/s² for half a second, then none
    np.testing.assert_allclose(list(held.values.values()), [4.0, 0.0], atol=1e-5)


def test_a_start_that_hits():
    """The speed at which a ball must be thrown to be back at its place after 1 s: g/2."""
    eom = kn.derive(load("bouncing_ball").system())
    y, u = eom.coordinates[0], eom.speeds[0]
    shot = kn.fitting.shoot(eom, (0, 1), u, q={y: 1.0}, u={u: 4.5}, end={y: 1.0})
    assert shot.values[u] == pytest.approx(9.81 / 2, rel=1e-9)
    assert shot.cost == 0.0


def test_a_switching_time():
    """F = m up to b, then −m: ∫ u² dt = 2 b³/3 − (2 b − 2)³/3 over 2 s is least at b = 2/3; u = 0 at the end at b = 1."""
    eom, b = pushed(), kn.parameter("b", 1.2)
    u, m = eom.speeds[0], eom.parameters[0]
    law = m * kn.where(kn.less(kn.time, b), 1.0, -1.0)
    given = {"q": [0], "u": [0], "inputs": {"F": law}, "parameters": {b: 1.2}, "bounds": {b: (0.1, 1.9)}}
    least = kn.fitting.shoot(eom, (0, 2), [b], integral=u**2, **given)
    assert least.values[b] == pytest.approx(2 / 3, abs=1e-4)
    assert least.cost == pytest.approx(8 / 27, rel=1e-7)
    assert kn.fitting.shoot(eom, (0, 2), [b], end={u: 0.0}, **given).values[b] == pytest.approx(1.0, rel=1e-9)
    with pytest.raises(kn.SimulationError, match="jumps where the state crosses a threshold"):
        kn.fitting.shoot(eom, (0, 2), [b], integral=kn.sign(u - 0.1), **given)


@pytest.mark.parametrize("begin", [1.5, 0.5])
def test_an_integrand_that_jumps_when_the_unknowns_say(begin):
    """2 ẍ = F = A + B t ends at u = 1 after 2 s: A = 1 − B, and F ≥ 0.9 from 1 − 0.1/B on; J = 2 + 0.1/B + B²/3."""
    A, B, eom = kn.parameter("A"), kn.parameter("B"), pushed()
    (F,) = eom.inputs
    integral = kn.where(kn.less(F, 0.9), 0.0, 1.0) + 0.5 * (F - 2) ** 2
    given = {"q": [0], "u": [0], "inputs": {F: A + B * kn.time}, "parameters": {A: 1 - begin, B: begin}}
    bounds = {A: (-5, 0.85), B: (0.15, 3)}
    shot = kn.fitting.shoot(eom, (0, 2), [A, B], end={"u": 1}, integral=integral, bounds=bounds, **given)
    assert shot.values[B] == pytest.approx(0.15 ** (1 / 3), abs=1e-3)
    assert shot.cost == pytest.approx(2 + 0.1 / 0.15 ** (1 / 3) + 0.15 ** (2 / 3) / 3, abs=1e-6)


def test_integrals_across_bounces():
    """∫ u² dt of a ball, least where it begins lowest, is that of the same ball with the integral as a state."""
    ball = load("bouncing_ball").system()
    eom, J = kn.derive(ball), kn.state("J")
    (y,), (u,) = eom.coordinates, eom.speeds
    shot = kn.fitting.shoot(eom, (0, 1.2), [y], q={y: 0.7}, u={u: 0.3}, bounds={y: (0.6, 0.9)}, integral=u**2)
    assert shot.values[y] == pytest.approx(0.6)
    with_sum = kn.derive(ball.replace(states={J: u**2}))
    one = kn.simulate(with_sum, (0, 1.2), q=[0.6], u=[0.3], states=[0.0], samples=2, rtol=1e-11, atol=1e-11)
    assert shot.cost == pytest.approx(one[J][-1], rel=1e-7)


def test_a_pendulum_swings_up():
    """Without a cost the conditions are solved: from hanging to standing, the cart back at rest."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    F = curve("F", np.linspace(0, 2, 11), 0.5)
    end = {"theta": np.pi, "x": 0, "u_x": 0, "u_theta": 0}
    shot = kn.fitting.shoot(eom, (0, 2), F.nodes, q=[0, 0], u=[0, 0], inputs={"F": F.expression}, end=end)
    assert shot.off < 1e-8
    np.testing.assert_allclose(shot.motion.states[-1], [0, np.pi, 0, 0], atol=1e-7)


def test_the_least_effort_that_swings_up():
    """∇J = Gᵀν with the conditions' Jacobian G by the variational equations of the whole motion; the bound that holds has its sign."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    F = curve("F", np.linspace(0, 2, 11))
    given = {"q": [0, 0], "u": [0, 0], "inputs": {"F": F.expression}}
    end, bounds = {"theta": np.pi, "x": 0, "u_x": 0, "u_theta": 0}, dict.fromkeys(F.nodes, (-14, 14))
    shot = kn.shoot(eom, (0, 2), F.nodes, end=end, integral=F.expression**2, bounds=bounds, **given)
    values = np.array([*shot.values.values()])
    h, weights = 0.2, np.diag([2, *[4] * 9, 2]) + np.eye(11, k=1) + np.eye(11, k=-1)
    assert shot.cost == pytest.approx(h / 6 * values @ weights @ values, rel=1e-9)
    s = kn.fitting.sensitivities(eom, (0, 2), F.nodes, samples=2, **given, parameters=shot.values)
    slopes = h / 3 * weights @ values
    held = np.abs(values) > 14 - 1e-9
    G = s.states[-1].T
    nu = np.linalg.lstsq(G[~held], slopes[~held])[0]
    rest = (slopes - G @ nu) / np.abs(slopes).max()
    assert 0 < held.sum() < 4
    assert np.abs(rest[~held]).max() < 1e-6
    assert (rest[held] * np.sign(values[held]) < 0).all()


def test_what_cannot_be_met():
    eom = pushed()
    F = curve("F", [0, 1], 0.0)
    given = {"q": [0], "u": [0], "inputs": {"F": F.expression}}
    with pytest.raises(kn.SimulationError, match="satisfies the end conditions, got"):
        kn.fitting.shoot(eom, (0, 1), F.nodes, end={"x": 1, "u": 0}, bounds=dict.fromkeys(F.nodes, (-1, 1)), **given)
    with pytest.raises(kn.SimulationError, match="Expected end=, cost= or integral="):
        kn.fitting.shoot(eom, (0, 1), F.nodes, **given)
    with pytest.raises(kn.SimulationError, match="within the bounds"):
        kn.fitting.shoot(eom, (0, 1), F.nodes, end={"x": 1}, bounds=dict.fromkeys(F.nodes, (1, 2)), **given)
    with pytest.raises(kn.SimulationError, match="bounds of F_0"):
        kn.fitting.shoot(eom, (0, 1), F.nodes, end={"x": 1}, bounds={F.nodes[0]: (2, 1)}, **given)


def test_values_that_are_none_are_named():
    eom = pushed()
    given = {"q": [0], "u": [0], "inputs": {"F": 1.0}}
    found = kn.shoot(
        eom, (0, 1), "m", end={"x": [0.3, 0.4]}, bounds={"m": np.array([0.1, 1.5])}, parameters={"m": 1}, **given
    )
    assert 1.25 - 1e-9 <= next(iter(found.values.values())) <= 1.5
    for end, told in (
        ({"x": "far"}, "a value of x at the end"),
        ([0.3], "end= as a dict"),
        ({"x": [1, 2, 3]}, "a value of x"),
    ):
        with pytest.raises(kn.SimulationError, match=f"Expected {told}"):
            kn.shoot(eom, (0, 1), "m", end=end, **given)
    with pytest.raises(kn.SimulationError, match=r"Expected bounds of m as \(low, high\)"):
        kn.shoot(eom, (0, 1), "m", end={"x": 0.3}, bounds={"m": ("little", 2)}, **given)
    for times, values in (([], 0), ([0, 1], [1, 2, 3]), ("now", 0)):
        with pytest.raises(kn.SimulationError, match="of a curve"):
            curve("F", times, values)


def test_few_numbers_by_many_unknowns_are_differentiated_on_the_way_back(monkeypatch):
    """A mass on a spring that a wall throws back ends where it should, at the least cost: no variational equations are solved."""
    monkeypatch.setattr("kane.motion.derivatives.parametric_motion.ParametricMotion.sensitivities", None)
    m, k, e, N = kn.parameter("m", 1.0), kn.parameter("k", 9.0), kn.parameter("e", 0.8), kn.Frame("N")
    x, u = kn.coordinate("x"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    system = kn.System(
        N,
        bodies=[kn.Particle("B", P, m)],
        speeds={u: x.dt},
        loads=[kn.Force(P, -k * x * N.x)],
        events=[kn.Event("wall", x + 0.2, direction=-1, then={u: -e * u})],
    )
    eom = kn.derive(system)
    given = {"q": {x: 1.0}, "u": {u: 0.3}}
    span, end = (0, 1.2), {"end": {x: 0.4}, "bounds": {x: (0.5, 1.5)}}
    shot = kn.shoot(eom, span, [x, u, e, k], **end, **given)
    assert len(shot.motion.events) == 1
    assert abs(shot.motion.q[-1, 0] - 0.4) < 1e-8
    cost = end | {"cost": (e - 0.7) ** 2 + u**2}
    least = kn.shoot(eom, span, [x, u, e], **cost, **given)
    assert len(least.motion.events) == 1
    for value in (least.values[u] - 0.05, least.values[u] + 0.05):
        assert least.cost < kn.shoot(eom, span, [x, e], **cost, **given | {"u": {u: value}}).cost


UNITS = [(1.0, 1.0, 1.0), (1e5, 1.0, 1.0), (1e3, 1e3, 1e-3), (1e-4, 1e6, 1e4)]
"""How many of its units metre, kilogram and second are."""


@pytest.mark.parametrize(
    ("scale", "cost"),
    [
        pytest.param(scale, cost, marks=[pytest.mark.slow] * (cost != 1e-8 or scale != UNITS[3]))
        for scale in UNITS[1:]
        for cost in (1.0, 1e-8, 1e7)
    ],
)
def test_a_swing_up_is_the_same_in_any_units(scale, cost):
    """Conditions, defects and costs are compared by their sizes: the same steps, whatever the units."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    end = {"theta": np.pi, "x": 0, "u_x": 0, "u_theta": 0}

    def found(scale, cost):
        force, second = factor("N", scale), scale[2]
        F = curve("F", np.linspace(0, 2 * second, 11))
        given = {"q": [0, 0], "u": [0, 0], "inputs": {"F": F.expression}}
        given["parameters"] = {p: p.default * factor(p.unit, scale) for p in eom.parameters}
        least = min(1.0, scale[0], 1 / second, scale[0] / second)
        bounds = dict.fromkeys(F.nodes, (-14 * force, 14 * force))
        shot = kn.shoot(
            eom, (0, 2 * second), F.nodes, end=end, integral=cost * F.expression**2, bounds=bounds, atol=1e-9 * least,
            **given,
        )  # fmt: skip
        return np.array([*shot.values.values()]) / force, shot.steps

    expected, steps = found(UNITS[0], 1.0)
    values, own = found(scale, cost)
    np.testing.assert_allclose(values, expected, rtol=1e-6)
    assert own == steps


@pytest.mark.parametrize("least", ["cost", "change"])
@pytest.mark.parametrize("scale", UNITS)
def test_a_ball_is_thrown_in_any_units(scale, least):
    """In one motion to 1.2 m after 0.8 s: y + 0.8 u = 1.2 + 0.32 g, with the least u² or with the least change of both."""
    eom = kn.derive(load("bouncing_ball").system())
    (y,), (u,) = eom.coordinates, eom.speeds
    metre, speed = scale[0], scale[0] / scale[2]
    given = {"parameters": {p: p.default * factor(p.unit, scale) for p in eom.parameters}}
    given |= {"q": {y: metre}, "u": {u: 4.5 * speed}, "end": {y: 1.2 * metre}, "atol": 1e-9 * min(1.0, metre, speed)}
    if least == "cost":
        given |= {"cost": u**2, "bounds": {u: (0, 6 * speed), y: (0.5 * metre, 2 * metre)}}
    shot = kn.shoot(eom, (0, 0.8 * scale[2]), [u, y], **given)
    way = np.array([0.8 * 4.5, 1.0])  # of u and y, each over its first value
    one = 1.0 + way * (0.2 + 0.32 * 9.81 - way[0]) / (way @ way)
    expected = [4.799, 0.5] if least == "cost" else one * [4.5, 1.0]
    np.testing.assert_allclose(np.array([*shot.values.values()]) / [speed, metre], expected, rtol=1e-6)


def test_the_size_of_an_unknown_that_begins_at_zero():
    """A force and a speed that both begin at zero, with the least change of both: the same in any units."""
    eom = pushed()
    (u,), level = eom.speeds, kn.parameter("level", 0.0, "N")

    def found(metre, kilogram):
        force = metre * kilogram
        given = {"parameters": {"m": 2 * kilogram, level: 0.0}, "inputs": {"F": level}, "atol": 1e-9 * min(1.0, metre)}
        shot = kn.shoot(eom, (0, 1), [level, u], q=[0], u=[0], end={"x": metre}, **given)
        return np.array([*shot.values.values()]) / [force, metre]

    expected = found(1.0, 1.0)
    np.testing.assert_allclose(
        expected, [2.0, 0.5], rtol=1e-8
    )  # each half of the way, as each could the whole: 4 N or 1 m/s
    for units in ((1e4, 1.0), (1e-3, 1e5)):
        np.testing.assert_allclose(found(*units), expected, rtol=1e-6)


@pytest.mark.parametrize("metre", [1.0, 1e5, 1e-6])
def test_a_cost_that_begins_at_zero(metre):
    """(x − a)² − a² at the end is least at x = a, whatever the unit: a small one is not yet a minimum."""
    eom = pushed()
    (x,), (u,), a = eom.coordinates, eom.speeds, metre
    given = {"q": [0], "u": [0], "inputs": {"F": 0.0}, "bounds": {u: (-2 * metre, 3 * metre)}}
    shot = kn.shoot(eom, (0, 1), [u], cost=(x - a) ** 2 - a**2, atol=1e-9 * min(1.0, metre), **given)
    assert shot.values[u] == pytest.approx(metre, rel=1e-6)


def test_more_guesses_than_constraints_are_sought_once():
    """A pendulum of unknown length in x and y, both guessed: its derivatives and its motions keep the x that is found first."""
    N, a = kn.Frame("N"), kn.parameter("a", 1.0)
    x, y = kn.coordinates("x y")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    rod = kn.configuration_constraint("rod", x**2 + y**2 - a**2)
    loads, bodies = [kn.gravity(-9.81 * N.y)], [kn.Particle("p", P, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, holonomic=[rod]))
    given = {"q": {x: kn.guess(0.6), y: kn.guess(-0.6)}, "u": {eom.speeds[0]: 0.0}}
    s = kn.fitting.sensitivities(eom, (0, 0.4), [a], samples=2, **given)
    first = kn.assemble(eom, **given)
    held = next(q for q in (x, y) if s[q][0, 0] == 0)
    assert first.q[x] == pytest.approx(2**-0.5)
    shot = kn.shoot(eom, (0, 0.4), [a], end={"y": s.motion["y"][-1] + 0.01}, **given)
    assert shot.start.q[held] == pytest.approx(first.q[held], rel=1e-12)
    change = shot.values[a] - 1.0
    assert s[y][-1, 0] * change == pytest.approx(0.01, rel=abs(3 * change))


@pytest.mark.parametrize("effort", [False, True])
@pytest.mark.parametrize("across", [0.0, 0.3])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_condition_that_is_zero_up_to_rounding_along_the_motion(effort, across, turn):
    """A throw with drag against a mark in its vertical plane: the way across, y' cos a − x' sin a, has no size along the motion."""
    N, (x, y, z) = kn.Frame("N"), kn.coordinates("x y z")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y + z * N.z)
    loads = [kn.gravity(-9.81 * N.z), kn.loads.quadratic_drag(P, 0.1)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("ball", P, 1)], loads=loads, speeds="rates"))
    cos, sin = float(np.cos(turn)), float(np.sin(turn))
    end = {x * cos + y * sin: 3, y * cos - x * sin: 0, z: 0}
    start = [2 * cos - across * sin, 2 * sin + across * cos, 1]
    cost = sum(u**2 for u in eom.speeds) if effort else 0
    shot = kn.shoot(eom, (0, 1), eom.speeds, end=end, q=[0, 0, 0], u=start, cost=cost)
    along, aside, up = np.array([*shot.values.values()]) @ [[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]
    np.testing.assert_allclose([along, up], [3.68017854553636, 5.34716330008126], rtol=1e-7)
    assert abs(aside) < 1e-8


def test_the_least_cost_without_conditions_from_unknowns_at_zero():
    eom = pushed()
    (x,), (u,) = eom.coordinates, eom.speeds
    shot = kn.shoot(eom, (0, 1), [u], q=[0], u=[0], inputs={"F": 0}, cost=(x - 3) ** 2)
    np.testing.assert_allclose(shot.values[u], 3, rtol=1e-6)


@pytest.mark.parametrize("effort", [False, True])
@pytest.mark.parametrize("sine", [0.5, 0.0])
def test_a_pendulum_swings_from_rest_up_to_rounding(effort, sine):
    """At π, where the sine is 1e-16 and so is the speed along the motion without a torque: neither tells a size."""
    N, theta, torque = kn.Frame("N"), kn.coordinate("theta"), kn.input("T")
    O, A = kn.Point("O", fixed_in=N), N.rotate("A", theta, N.z)
    loads = [kn.gravity(-9.81 * N.y), kn.loads.Torque(A, torque * N.z)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("bob", O.at("P", A.y), 1)], speeds="rates", loads=loads))
    T = curve("T", np.linspace(0, 2, 11))
    given = {"q": [np.pi], "u": [0], "inputs": {torque: T.expression}, "integral": torque**2 if effort else 0}
    shot = kn.shoot(eom, (0, 2), T.nodes, end={kn.sin(theta): sine, eom.speeds[0]: 0}, **given)
    assert "joined" in shot.message
    assert shot.motion[kn.sin(theta)][-1] == pytest.approx(sine, abs=1e-8)
    assert shot.motion[eom.speeds[0]][-1] == pytest.approx(0, abs=1e-7)
