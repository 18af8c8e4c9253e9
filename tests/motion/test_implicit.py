# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives for methods that solve for a step."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import kane as kn
from kane import substitute
from kane.gallery import load, pendulum_on_cart
from kane.motion import SOLVERS, Formula, exact, right_hand_side, routines
from tests.oracles.duals import values_and_slopes


@cache
def derived(name):
    return kn.derive(load(name).system())


def routines_of(eom):
    return routines(eom, np.array([p.default for p in eom.parameters]), [lambda t: 0.4] * len(eom.inputs), None)


@pytest.mark.slow
@pytest.mark.parametrize("long", [0, np.inf])
@pytest.mark.parametrize("name", ["double_pendulum", "rolling_disk", "four_bar", "pendulum_on_cart"])
def test_they_are_those_of_the_rates_and_of_the_power(name, long, monkeypatch, rng):
    monkeypatch.setattr(right_hand_side, "_LONG", long)
    eom = derived(name)
    now = routines_of(eom)
    y = rng.uniform(0.3, 1.1, size=now.width + 1)
    roots = [*eom.right_hand_side, eom.power]
    plain = right_hand_side.without_unknowns(eom.solved, roots)
    _, expected = values_and_slopes(plain, now.values(0.2, y), (*eom.coordinates, *eom.speeds))
    found = exact(now)(0.2, y)
    assert found.shape == (now.width + 1, now.width + 1)
    assert not found[:, -1].any()
    assert found[:, :-1] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_inputs_that_follow_from_the_state_count(rng):
    """Against the derivatives of the rates with the law written in."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    (force,), symbols = eom.inputs, eom.state
    law = 3 * symbols[0] * symbols[3] - kn.sin(symbols[1]) + kn.time
    now = routines(eom, np.array([p.default for p in eom.parameters]), [Formula(law, {}, symbols)], None)
    y = rng.uniform(0.3, 1.1, size=now.width)
    plain = [
        substitute(e, {force: law})
        for e in right_hand_side.without_unknowns(eom.solved, [*eom.right_hand_side, eom.power])
    ]
    _, expected = values_and_slopes(plain, now.values(0.2, y), symbols)
    found = eom.numeric(None).routine(right_hand_side.closed, law)(0.2, y, now.p, now.inputs(0.2, y))
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA"])
def test_a_stiff_motion_takes_no_evaluations_for_differences(method):
    """A pendulum with a stiff spring in the place of its rod: each change of J by differences would cost an evaluation a state."""
    assert method in SOLVERS
    N = kn.Frame("N")
    q1, q2 = kn.coordinates("q1:3")
    u1, u2 = kn.speeds("u1:3")
    P = kn.Point("O", fixed_in=N).at("P", q1 * N.x + q2 * N.y)
    stretch = kn.sqrt(q1 * q1 + q2 * q2) - 1
    along = (q1 * N.x + q2 * N.y).normalized()
    damper = 2e3 * (along.dot(N.x) * u1 + along.dot(N.y) * u2)
    loads = [kn.Force(P, -(1e6 * stretch + damper) * along), kn.gravity(-9.81 * N.y)]
    speeds = {u1: q1.dt, u2: q2.dt}
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("bob", P, 1.0)], speeds=speeds, loads=loads))
    calls = []
    start = {"q": {q1: 1.0, q2: 0.0}, "u": [0.0, 0.0]}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("kane.motion.steps.exact", lambda now: lambda t, y: calls.append(t) or exact(now)(t, y))
        sol = kn.simulate(eom, (0, 0.2), **start, method=method, rtol=1e-6, atol=1e-8)
    assert sol.status == "finished"
    assert calls
    fine = kn.simulate(eom, (0, 0.2), **start, method="DOP853", rtol=1e-9, atol=1e-11)
    assert sol.q[-1] == pytest.approx(fine.q[-1], abs=1e-4)
    assert sol.evaluations < fine.evaluations
