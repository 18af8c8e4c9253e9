# SPDX-License-Identifier: BSD-3-Clause
"""Events along motions in closed form: every crossing is found, none invented, each at its time, however many lie in one step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

import kane as kn
from tests.examples import examples

METHODS = ("gauss16", "dop853", "tsitpap8", "tsit5")
COUNT, SINES, END = 5, 3, 6.0
N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
(th, y), (w, v) = kn.coordinates("th y"), kn.speeds("w v")
ARM = N.rotate("A", th, N.z)
P, Q = O.at("P", ARM.x), O.at("Q", y * N.z)
SIZES, PACES, PHASES = (
    [[kn.parameter(f"{name}{i}{k}", 1.0) for k in range(SINES)] for i in range(COUNT)] for name in "apf"
)
LEVELS = [kn.parameter(f"c{i}", 0.0) for i in range(COUNT)]
QUANTITIES = [
    sum(a * kn.sin(p * th + f) for a, p, f in zip(*row, strict=True)) + 0.1 * y + c
    for *row, c in zip(SIZES, PACES, PHASES, LEVELS, strict=True)
]
EOM = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("p", P, 1), kn.Particle("q", Q, 1)],
        speeds={w: th.dt, v: y.dt},
        loads=[kn.gravity(-1.0 * N.z)],
        events=[kn.Event(f"e{i}", q, terminal=False) for i, q in enumerate(QUANTITIES)],
    )
)


class Witness:
    """Σ a sin(p t + f) + 0.1 y(t) + c along θ = t, y = 2 t − t²/2, and the roots of it."""

    def __init__(self, rng, grazes):
        self.a, self.p, self.f = rng.normal(size=SINES), rng.uniform(0, 20, SINES), rng.uniform(0, 7, SINES)
        self.c = 0.0
        grid = np.linspace(0, END, 4001)
        slopes = self.slope(grid)
        at = np.flatnonzero(slopes[1:] * slopes[:-1] < 0)
        self.turns = np.array([brentq(self.slope, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15) for k in at])
        self.c = float(rng.normal())
        if grazes and len(self.turns):
            k, gap = rng.integers(len(self.turns)), 10.0 ** -rng.uniform(3, 10) * rng.choice([-1, 1])
            self.c = -float(self(self.turns[k]) - self.c) + gap

    def __call__(self, t):
        return (self.a * np.sin(np.multiply.outer(t, self.p) + self.f)).sum(-1) + 0.1 * (2 * t - t * t / 2) + self.c

    def slope(self, t):
        return (self.a * self.p * np.cos(np.multiply.outer(t, self.p) + self.f)).sum(-1) + 0.1 * (2 - t)

    def roots(self):
        ends = np.array([0.0, *self.turns, END])
        values = self(ends)
        return [
            brentq(self, ends[k], ends[k + 1], xtol=1e-15, rtol=1e-15)
            for k in range(len(ends) - 1)
            if values[k] * values[k + 1] < 0
        ]

    @property
    def parameters(self):
        return [*self.a, *self.p, *self.f, self.c]


def check(seed, method):
    rng = np.random.default_rng(seed)
    witnesses = [Witness(rng, grazes=k % 2) for k in range(COUNT)]
    values = {}
    for k, one in enumerate(witnesses):
        symbols = [*SIZES[k], *PACES[k], *PHASES[k], LEVELS[k]]
        values |= dict(zip(symbols, map(float, one.parameters), strict=True))
    sol = kn.simulate(EOM, (0, END), q=[0, 0], u=[1, 2], parameters=values, method=method, samples=2)
    for k, one in enumerate(witnesses):
        found = np.array([t for e, t in sol.events if e.name == f"e{k}"])
        wanted = np.array(one.roots())
        assert len(found) == len(wanted), (method, k, found, wanted)
        # where it grazes, rounding of the quantity and of the state moves its root
        slack = 1e-12 * END + 40 * np.finfo(float).eps * np.abs(one.a).sum() * 20 * END / np.abs(one.slope(wanted))
        assert np.all(np.abs(found - wanted) <= slack), (method, k, found - wanted, slack)
    return sol


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@given(seed=st.integers(0, 2**32 - 1))
@examples(0.03, least=4)
def test_every_crossing_of_random_witnesses_is_found(method, seed):
    sol = check(seed, method)
    assert sol.steps < 200  # many crossings in a step


x, s = kn.coordinate("x"), kn.speed("s")
R = kn.reaction("R", at=(foot := O.at("foot", x * N.x)), along=N.y)
LIFT, BEGIN = kn.parameter("lift", 1.2), kn.parameter("begin", 5.0)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_contact_that_is_lost_for_a_fifth_of_a_second_is_found(method):
    """A block of 1 kg that slides for ten seconds is lifted by 1.2 of its weight for 0.2 s: steps are longer."""
    pull = LIFT * 9.81 * kn.where(kn.less(BEGIN, kn.time), kn.where(kn.less(kn.time, BEGIN + 0.2), 1, 0), 0)
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("block", foot, 1)],
            speeds={s: x.dt},
            reactions=[R],
            loads=[kn.gravity(-9.81 * N.y), kn.Force(foot, pull * N.y), kn.friction(foot, R, 0.01, name="friction")],
        )
    )
    for begin in (2.0, 5.0, 7.7):
        sol = kn.simulate(eom, (0, 10), q=[0], u=[30], parameters={BEGIN: begin}, method=method, samples=2)
        assert sol.event.name == "contact lost (R = 0)"
        assert sol.t[-1] == pytest.approx(begin, abs=1e-9)
        on = kn.simulate(eom, (0, 10), q=[0], u=[30], parameters={BEGIN: begin, LIFT: 0.99}, method=method, samples=2)
        assert on.status == "finished"
        assert on["s"][-1] == pytest.approx(30 - 0.0981 * (10 - 0.2 * 0.99), rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_smooth_lift_that_opens_a_contact_for_a_fifth_of_a_second(method):
    """1.2 of the weight times exp(−((t − 5)/w)²), above the weight for 0.2 s; and one that stays below by a millionth."""
    w = 0.1 / np.sqrt(np.log(1.2))
    pull = LIFT * 9.81 * kn.exp(-(((kn.time - 5) / w) ** 2))
    block = kn.Particle("block", foot, 1)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(foot, pull * N.y), kn.friction(foot, R, 0.01, name="friction")]
    eom = kn.derive(kn.System(N, bodies=[block], speeds={s: x.dt}, reactions=[R], loads=loads))
    sol = kn.simulate(eom, (0, 10), q=[0], u=[30], method=method, samples=2)
    assert sol.event.name == "contact lost (R = 0)"
    assert sol.t[-1] == pytest.approx(4.9, abs=1e-9)
    given = {"parameters": {LIFT: 1 - 1e-6}, "method": method, "samples": 2}
    assert kn.simulate(eom, (0, 10), q=[0], u=[30], **given).status == "finished"


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_of_20_ms_gives_its_impulse(method):
    force = 50 * kn.where(kn.less(BEGIN, kn.time), kn.where(kn.less(kn.time, BEGIN + 0.02), 1, 0), 0)
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", foot, 1)], speeds={s: x.dt}, loads=[kn.Force(foot, force * N.x)])
    )
    for begin in (0.3, 5.0, 9.9):
        sol = kn.simulate(eom, (0, 10), q=[0], u=[0], parameters={BEGIN: begin}, method=method, samples=2)
        assert sol["s"][-1] == pytest.approx(1, abs=1e-9)
        assert sol["x"][-1] == pytest.approx(10 - begin - 0.01, abs=1e-9 * 10)  # of the speed, times the span
