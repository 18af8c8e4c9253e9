# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives by parameters that move the times at which rates jump: phase by phase, and where several such times come together."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

import kane as kn
from kane.fitting import sensitivities
from tests.motion.derivatives.test_sensitivities import differences, pushed

METHODS = pytest.mark.parametrize("method", ["forward", "adjoint"])
WHERE = "kane.motion.derivatives.return_map"


def step(at):
    return kn.where(kn.less(kn.time, at), 0.0, 1.0)


@METHODS
def test_of_friction_that_changes(method):
    """μ = 0.2, and 0.5 from b on: u = 5 − 0.2 g b − 0.5 g (t − b), so that ∂u/∂b = 0.3 g and ∂x/∂b = 0.3 g (t − b)."""
    N, b = kn.Frame("N"), kn.parameter("b", 0.5)
    x, y, u, v = kn.coordinate("x"), kn.coordinate("y"), kn.speed("u"), kn.speed("v")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y)
    mu = 0.2 + 0.3 * step(b)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), mu)
    block = kn.System(
        N,
        bodies=[kn.Particle("B", P, 1.0)],
        speeds={u: x.dt, v: y.dt},
        loads=[kn.gravity(-9.81 * N.y)],
        contacts=[floor],
    )
    s = sensitivities(
        kn.derive(block), (0, 0.8), [b], q={x: 0, y: 0}, u={u: 5, v: 0}, parameters={b: 0.5}, samples=2, method=method
    )
    np.testing.assert_allclose([s[x][-1, 0], s[u][-1, 0]], [0.3 * 0.3 * 9.81, 0.3 * 9.81], rtol=1e-9)


@METHODS
@pytest.mark.parametrize("of_state", [False, True])
def test_of_a_time_that_an_event_moves(method, of_state):
    """F = 1, and 4 from c k on, where an event sets k: then parameters move the time c k of that phase."""
    c, k = kn.parameter("c", 2.0), kn.parameter("k", 2.0)
    N, x, u = kn.Frame("N"), kn.coordinate("x"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    load = kn.Force(P, (1 + 3 * step(c * k)) * (x if of_state else 1) * N.x)
    sets = kn.Event("sets", kn.time - 0.5, then={k: 0.75})
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("B", P, 1)], speeds={u: x.dt}, loads=[load], events=[sets]))
    given = {"q": {x: 1.0}, "u": {u: 0.0}, "parameters": {c: 2.0, k: 2.0}}
    s = sensitivities(eom, (0, 3), [c], samples=2, method=method, **given)
    wanted = differences(eom, (0, 3), (c,), given, 2, rows=[-1])
    np.testing.assert_allclose(s.states[-1:], wanted, rtol=1e-7)


def pulses(*laws):
    """ẍ = F, from rest to t = 3."""
    _, eom, (_, F, x, u) = pushed()
    return eom, {"q": {x: 0.0}, "u": {u: 0.0}, "inputs": {F: sum(laws)}, "samples": 2}


@METHODS
def test_jumps_that_come_together_and_are_moved_apart_are_refused(method):
    a, b, w = kn.parameter("a", 1.0), kn.parameter("b", 1.0), kn.parameter("w", 0.0)
    width = kn.where(kn.less(kn.time, 1.0), 0.0, 1 - step(1 + w))
    for law, by in ((step(a) - step(b), [a, b]), (width, [w]), (step(w), [w])):
        eom, given = pulses(law)
        with pytest.raises(kn.SimulationError, match="times change differently with parameters"):
            np.asarray(sensitivities(eom, (0, 3), by, method=method, **given).states)


@METHODS
def test_jumps_that_come_together_and_are_moved_as_one(method):
    """F = 1 from a b on, and 1 more from (a² b² + 1)/2 on: at a = b = 1 both are at 1, and moved alike."""
    a, b = kn.parameter("a", 1.0), kn.parameter("b", 1.0)
    eom, given = pulses(step(a * b), step((a**2 * b**2 + 1) / 2))
    s = sensitivities(eom, (0, 3), [a, b], method=method, **given)
    np.testing.assert_allclose(s.states[-1], [[-4.0, -4.0], [-2.0, -2.0]], atol=1e-11)
    eom, given = pulses(step(1.0), kn.abs(kn.time - b))  # a jump that stays, and a corner
    s = sensitivities(eom, (0, 3), [b], method=method, **given)
    np.testing.assert_allclose(s.states[-1, :, 0], [0.5, -1.0], atol=1e-9)  # ∂u = ∫ sign(b − t) dt


def test_a_corner_of_an_integrand_at_a_jump():
    """F = b from t = 1 on, b = 1: ∫ |t − b| dt over 3 s has ∂/∂b = 2 b − 3 there; a jump at b in place of the corner is refused."""
    b = kn.parameter("b", 1.0)
    eom, given = pulses(b * step(1.0))
    s = sensitivities(eom, (0, 3), [b], method="adjoint", **given)
    cost = s.cost(integral=kn.abs(kn.time - b))
    np.testing.assert_allclose([cost.value, *cost.gradient], [2.5, -1.0], rtol=1e-10)
    with pytest.raises(kn.SimulationError, match="times change differently with parameters"):
        s.cost(integral=step(b))


@METHODS
def test_a_jump_at_an_event(method):
    """ẍ = 1 from b on, and at an event at c, where the speed turns: they are at one time, and one time if c is b."""
    b, (system, _, (_, F, x, u)) = kn.parameter("b", 1.0), pushed()
    given = {"q": {x: 0.0}, "u": {u: 1.0}, "inputs": {F: step(b)}, "samples": 2, "parameters": {b: 1.0}}
    apart = kn.derive(system.replace(events=[kn.Event("turns", kn.time - 1, then={u: -u})]))
    with pytest.raises(kn.SimulationError, match="times change differently with parameters"):
        np.asarray(sensitivities(apart, (0, 3), [b], method=method, **given).states)
    one = kn.derive(system.replace(events=[kn.Event("turns", kn.time - b, then={u: -u})]))
    s = sensitivities(one, (0, 3), [b], method=method, **given)
    # behind b: u = −1 + (t − b), x = b − (t − b) + (t − b)²/2
    np.testing.assert_allclose(s.states[-1, :, 0], [2 - 2.0, -1.0], atol=1e-9)


def test_many_moved_times_take_one_more_motion(monkeypatch):
    """A square wave from b on, all of it moved by b: of 20 switches as many motions are run as of two."""
    b, counts, run = kn.parameter("b", 0.1), [], import_module(WHERE).ReturnMap.motion
    calls = []
    monkeypatch.setattr(f"{WHERE}.ReturnMap.motion", lambda *own: calls.append(1) or run(*own))
    for n in (2, 20):
        calls.clear()
        eom, given = pulses(*(step(b + 0.01 * i) * (-1) ** i for i in range(n)))
        s = sensitivities(eom, (0, 3), [b], **given)
        counts.append(len(calls))
        np.testing.assert_allclose(s.states[-1, :, 0], [-0.01 * n / 2, 0.0], atol=1e-10)
    assert counts[0] == counts[1]
