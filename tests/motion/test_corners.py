# SPDX-License-Identifier: BSD-3-Clause
"""Rates that jump where no switch is watched, anywhere in a step: none is leapt over."""

import numpy as np
import pytest
from scipy.optimize import brentq

import kane as kn
from kane.motion import cornered, defects, events, gauss, lagrange, routines

N = kn.Frame("N")
x, v, f = kn.coordinate("x"), kn.speed("v"), kn.input("f")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
SPRING = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, (f - x) * N.x)]))


def after(a, jump, t):
    """(x, v) of x'' = −x + J up to x = a, x'' = −x beyond, from (0, 1)."""
    times = np.linspace(0, 1.2, 1000)

    def gap(s):
        return jump - jump * np.cos(s) + np.sin(s) - a

    k = int(np.argmax(gap(times) >= 0))
    at = brentq(gap, times[k - 1], times[k], xtol=1e-15)
    begin, turn = np.array([a, jump * np.sin(at) + np.cos(at)]), t - at
    return np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) @ begin


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "times"),
    [("gauss16", 300), ("dop853", 300), ("tsitpap8", 3000), ("vern9", 60), ("tsit5", 300), ("radau9", 30)],
)
def test_a_jump_anywhere_in_a_step_is_seen(method, times, rng):
    """The force is an input that follows from the state; the end is off by no more than some tolerances."""
    for _ in range(60):
        a, jump = rng.uniform(0.05, 0.8), 10 ** rng.uniform(-6, 0)
        given = {"q": [0], "u": [1], "samples": 2, "rtol": 1e-9, "atol": 1e-9, "method": method}
        sol = kn.simulate(SPRING, (0, 1.2), inputs={f: jump * kn.where(kn.less(x, a), 1, 0)}, **given)
        assert sol.states[-1] == pytest.approx(after(a, jump, 1.2), abs=times * 1e-9)


def test_a_jump_at_the_end_that_is_aimed_at_is_met_there():
    """The step that leads there begins at 0.39 and ends, rounded, one bit before it: it was taken again and again."""
    a, jump = 0.46771069657057773, 0.00037151323886756117
    given = {"q": [0], "u": [1], "samples": 2, "rtol": 1e-9, "atol": 1e-9, "method": "tsitpap8"}
    sol = kn.simulate(SPRING, (0, 1.2), inputs={f: jump * kn.where(kn.less(x, a), 1, 0)}, **given)
    assert sol.states[-1] == pytest.approx(after(a, jump, 1.2), abs=3e-6)


def test_smooth_rates_are_not_looked_at_twice(rng):
    """Smooth rates have a kernel that compares nothing; along rates that bend somewhere else the comparison rejects no step."""
    smooth = kn.simulate(SPRING, (0, 40), q=[0.3], u=[1], inputs={f: 0}, method="gauss16")
    bent = kn.simulate(SPRING, (0, 40), q=[0.3], u=[1], inputs={f: kn.max(x - 9, 0)}, method="gauss16")
    assert bent.steps == smooth.steps
    assert bent.states == pytest.approx(smooth.states, abs=1e-14)
    assert bent.evaluations == smooth.evaluations + smooth.steps


@pytest.mark.parametrize(
    ("force", "bends"),
    [(x.sin(), False), (kn.abs(x), True), (kn.atan2(x, v), True), (kn.table([0, 1, 2], [0, 1, 0], "linear")(x), True)],
)
def test_rates_that_may_bend_or_jump_are_told(force, bends):
    loads = [kn.Force(P, force * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads))
    assert cornered(routines(eom, np.zeros(0), (), None)) is bends


def test_lagranges_polynomials_and_places_along_a_step():
    nodes = gauss(8)
    assert np.array([lagrange(nodes, c) for c in nodes.c]) == pytest.approx(np.eye(8), abs=1e-13)
    assert np.dot(lagrange(nodes, 0.37), np.array(nodes.c) ** 7) == pytest.approx(0.37**7, abs=1e-15)
    at = defects()
    assert at.shares[0] == 0.0
    assert at.shares[-1] == 1.0
    for places in (at, events()):
        t, c = np.array(places.shares), np.array(nodes.c)
        for k in range(8):
            powers = c**k
            assert np.array(places.rates).T @ powers == pytest.approx(t**k, abs=1e-13)
            assert np.array(places.once).T @ powers == pytest.approx(t ** (k + 1) / (k + 1), abs=1e-14)
            assert np.array(places.twice).T @ powers == pytest.approx(t ** (k + 2) / (k + 1) / (k + 2), abs=1e-14)
