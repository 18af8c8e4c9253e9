# SPDX-License-Identifier: BSD-3-Clause
"""Loads whose switches and tables turn at times that parameters set: a road of given heights under a wheel at speed V."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import kane as kn
from tests.examples import examples

N = kn.Frame("N")
x, v = kn.coordinate("x"), kn.speed("v")
V, S, L = kn.parameter("V", 2.0, "m/s"), kn.parameter("S", 1.0, "m"), kn.parameter("L", 1.0, "m")
K, C, M = 400.0, 3.0, 1.5
"""Stiffness, damping, mass."""
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
ALONG = V * kn.time - S
KINDS = {
    "abs": (abs(ALONG) / L, lambda s: abs(s)),
    "max": (kn.max(ALONG, 0) / L, lambda s: max(s, 0.0)),
    "min": (kn.min(ALONG, L) / L, lambda s: min(s, 1.0)),
    "sign": (kn.sign(ALONG), np.sign),
    "where": (kn.where(kn.less(ALONG, L), 1, -1), lambda s: 1.0 if s < 1 else -1.0),
    "linear": ("linear", None),
    "cubic": ("cubic", None),
    "steps": ("steps", None),
    "periodic": ("periodic", None),
}


PULSES = {
    "where": (lambda s: kn.where(kn.less(0, s), kn.where(kn.less(s, 0.02), 7, 0), 0), 0.14),
    "steps": (kn.table([-1, 0, 0.02, 1], [0, 7, 0, 0], "steps"), 0.14),
    "linear": (kn.table([-1, 0, 0.01, 0.02, 1], [0, 0, 7, 0, 0], "linear"), 0.07),
    "smooth": (lambda s: 7 * kn.exp(-((s / 0.02) ** 2)), 0.14 * np.sqrt(np.pi)),
    "later": (lambda s: kn.where(kn.less(0, s + 0.5), 7 * kn.exp(-((s / 0.02) ** 2)), 0), 0.14 * np.sqrt(np.pi)),
}
"""Functions that are zero but for a pulse from 0 to 0.02, or about 0, and their integrals."""


def wheel(height):
    """Equations of a mass on spring and damper over a road of this height, of which the damper feels nothing."""
    force = K * (height - x) - C * v
    return kn.derive(kn.System(N, bodies=[kn.Particle("m", P, M)], speeds={v: x.dt}, loads=[kn.Force(P, force * N.x)]))


def reached(height, ends, span):
    """(x, v) at the end of a span, from rest, integrated from one of the ends of pieces to the next."""
    state = np.zeros(2)
    for a, b in pairwise([span[0], *sorted(t for t in ends if span[0] < t < span[1]), span[1]]):
        inside = lambda t, a=a, b=b: min(max(t, np.nextafter(a, b)), np.nextafter(b, a))  # noqa: E731
        found = solve_ivp(
            lambda t, y, inside=inside: [y[1], (K * (height(inside(t)) - y[0]) - C * y[1]) / M],
            (a, b), state, "DOP853", rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        state = found.y[:, -1]
    return state


@pytest.mark.parametrize("kind", KINDS)
def test_a_road_at_speed_is_felt(kind, rng):
    """Tables, corners and steps of V t, with V as a run-time parameter, against SciPy's steps from one corner to the next."""
    check(kind, "auto", rng)


@given(
    kind=st.sampled_from(sorted(KINDS)),
    method=st.sampled_from(["auto", "dop853", "gauss16", "tsit5", "radau9", "DOP853"]),
    seed=st.integers(0, 2**32 - 1),
)
@examples(0.3)
def test_any_road_at_any_speed_is_felt(kind, method, seed):
    check(kind, method, np.random.default_rng(seed))


@pytest.mark.parametrize("name", PULSES)
def test_no_pulse_is_leapt_over_wherever_it_stands(name):
    """In a load, in gravity and in the rate of a further state; of t, and of c t², which comes to 0 at t = 3, by 6 c a second."""
    form, whole = PULSES[name]
    a, c = kn.state("a", 0.0), kn.parameter("c", 1.0)
    for quantity, per_second in ((kn.time - 3 * c, 1.0), (c * (kn.time**2 - 9), 6.0)):
        pulse = form(quantity)
        for loads, states in (
            ([kn.Force(P, pulse * N.x)], {a: -a}),
            ([kn.gravity(pulse * N.x)], {a: -a}),
            ([kn.Force(P, 0 * N.x)], {a: pulse}),
        ):
            system = kn.System(N, bodies=[kn.Particle("m", P, 1)], speeds={v: x.dt}, loads=loads, states=states)
            sol = kn.simulate(kn.derive(system), (0, 10), q=[0], u=[0], samples=2)
            assert sol.u[-1, 0] + sol.a[-1, 0] == pytest.approx(
                whole / per_second, rel=2e-3 if per_second > 1 else 1e-6
            )


@pytest.mark.parametrize("method", ["dop853", "gauss16", "DOP853"])
@pytest.mark.parametrize("then", [None, {v: v + 1}, lambda u, **_: {v: u[v] + 1}], ids=["noted", "kernel", "python"])
def test_an_event_at_a_breakpoint_is_met_beside_loads_that_switch(method, then):
    """Steps end just before t = 0.5 and begin just after it: the event lies between, whatever the sides of switches are begun with."""
    step = kn.Event("step", kn.time, threshold=0.5, terminal=False, then=then)
    force = kn.Force(P, (kn.where(kn.less(kn.time, 0.5), 0, 2) - kn.sign(x + 5)) * N.x)
    system = kn.System(N, bodies=[kn.Particle("m", P, 1)], speeds={v: x.dt}, loads=[force], events=[step])
    sol = kn.simulate(kn.derive(system), (0, 2), q=[0], u=[2], method=method, samples=3)
    assert [(e.name, pytest.approx(t)) for e, t in sol.events] == [("step", 0.5)]
    before, more, rest = 1.5, 0.0 if then is None else 1.0, 1.5  # −1 N, then 1 N
    assert sol.u[-1, 0] == pytest.approx(before + more + rest)
    assert sol.q[-1, 0] == pytest.approx(2 * 0.5 - 0.5**2 / 2 + (before + more) * rest + rest**2 / 2)


@pytest.mark.parametrize("method", ["dop853", "gauss16", "tsit5", "radau9", "RK45"])
def test_a_motion_begins_anywhere_beside_a_breakpoint(method):
    """A force of 1 N sets in at t = 1.7: from a few numbers before that on there is no room for a step up to it."""
    F = kn.input("F")
    system = kn.System(N, bodies=[kn.Particle("m", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, (F - x) * N.x)])
    eom, law = kn.derive(system), kn.where(kn.less(kn.time, 1.7), 0, 1)
    for k in range(-12, 13):
        start = 1.7 + k * math.ulp(1.7)
        sol = kn.simulate(eom, (start, start + 1), q=[0], u=[0], inputs={F: law}, method=method, samples=2)
        again = kn.prepare(eom, (start, start + 1), inputs={F: law}, samples=2)(q=[0], u=[0])
        for one in (sol, again):
            assert (one.status, one.t[0]) == ("finished", start)
            np.testing.assert_allclose(one.states[-1, :2], [1 - np.cos(1), np.sin(1)], rtol=0, atol=1e-7)


FIRST, SECOND = kn.parameters("T1 T2", unit="s")


def pushed_twice():
    """Equations of a mass of 1 kg on which 1 N sets in at a first time, and at a second one more."""
    force = kn.where(kn.less(kn.time, FIRST), 0, 1) + kn.where(kn.less(kn.time, SECOND), 0, 1)
    return kn.derive(kn.System(N, bodies=[kn.Particle("m", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, force * N.x)]))


@pytest.mark.parametrize("method", ["dop853", "gauss16", "tsit5", "radau9"])
def test_breakpoints_with_hardly_a_number_between_them(method):
    """Steps go on beyond both: 13 to 15 numbers apart there is no room for one between."""
    eom = pushed_twice()
    for apart in range(1, 40):
        values = {FIRST: 0.7, SECOND: 0.7 + apart * math.ulp(0.7)}
        for _ in range(2):
            sol = kn.simulate(eom, (0, 1), q=[0], u=[0], parameters=values, method=method, samples=2)
            np.testing.assert_allclose(sol.states[-1], [0.3**2, 2 * 0.3], rtol=1e-12)


def check(kind, method, rng):
    height, plain = KINDS[kind]
    values = {V: float(rng.uniform(0.5, 20)), S: float(rng.uniform(-2, 5))}
    speed, begin = values[V], values[S]
    corners = [0.0, 1.0]
    if plain is None:
        corners = np.cumsum(rng.uniform(0.01, 1, 9)).tolist()
        heights = rng.normal(size=9)
        heights[-1] = heights[0]
        table = kn.table(corners, heights.tolist(), height)
        height, plain = table(ALONG / L), lambda s: float(table(s))
    first = (
        np.array(corners)
        if kind != "periodic"
        else np.add.outer(np.arange(-9, 50) * (corners[-1] - corners[0]), corners)
    )
    span = (0.0, 2.0)
    sol = kn.simulate(wheel(height), span, q=[0], u=[0], parameters=values, method=method, rtol=1e-10, atol=1e-10)
    assert sol.status == "finished"
    expected = reached(lambda t: plain(speed * t - begin), ((first + begin) / speed).ravel().tolist(), span)
    assert sol.states[-1] == pytest.approx(expected, abs=1e-7 * max(1, *np.abs(sol.states).max(axis=0)))
