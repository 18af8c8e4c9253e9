# SPDX-License-Identifier: BSD-3-Clause
"""Stiff equations: "auto" goes over to an implicit method, and only there."""

from functools import cache

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums
from kane.motion import right_hand_side
from tests.lanes import SMOOTH

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinates("x1:5")
c, k = kn.parameter("c", 1e6), kn.parameter("k", 1.0)
SHAKE = kn.sin(kn.time)


def chain(*more, shake=SHAKE):
    """Four masses in a row, each tied to the one before by a spring and a strong damper, the first one shaken."""
    points = [O.at(f"P{i}", x[i] * N.x) for i in range(4)]
    loads = [kn.Force(points[0], (shake + sum(more)) * N.x)]
    for i, at in enumerate(points):
        before = x[i - 1] if i else 0
        pull = -k * (x[i] - before) - c * (x[i].dt - (before.dt if i else 0))
        loads += [kn.Force(at, pull * N.x)] + ([kn.Force(points[i - 1], -pull * N.x)] if i else [])
    bodies = [kn.Particle(f"p{i}", p, 1) for i, p in enumerate(points)]
    return kn.derive(kn.System(N, bodies=bodies, loads=loads, speeds="rates"))


@cache
def derived(*more, **shake):
    return chain(*more, **shake)


@pytest.mark.parametrize(("more", "method"), [((), SMOOTH[0]), ((-kn.tanh(x[0].dt),), "vern9")])
@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_a_stiff_chain_is_led_on_by_an_implicit_method(more, method, unit):
    """Rates of 1e6 /s and a motion of seconds; found in a few hundred steps, in other units too."""
    eom, given = derived(*more), {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 6}
    given["parameters"] = {c: 1e6 * unit}
    own, other = (kn.simulate(eom, (0, 5), **given, method=m, rtol=1e-9, atol=1e-13 / unit) for m in ("auto", "Radau"))
    assert own.method == f"{method}, radau9"
    assert own.steps < 1100
    assert [e.name for e, _ in own.events] == ["the equations are stiff"]
    assert f"steps of {method} were limited by stability, not accuracy; radau9 continues" in own.events[0][0].message
    assert own.q == pytest.approx(other.q, abs=1e-7 * np.abs(other.q).max())


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-12])
@pytest.mark.parametrize(
    ("more", "shake", "method"),
    [
        ((), SHAKE, SMOOTH[0]),
        ((-kn.tanh(x[0].dt),), SHAKE, "vern9"),
        ((-kn.tanh(x[0].dt),), 1e6, "tsitpap8"),
    ],
)
def test_stiffness_is_noticed_at_every_tolerance(more, shake, method, tolerance):
    given = {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 2}
    sol = kn.simulate(derived(*more, shake=shake), (0, 5), **given, rtol=tolerance, atol=1e-7 * tolerance)
    first = "vern9" if method == "tsitpap8" and tolerance < 1e-8 else method
    assert (sol.method, sol.status) == (f"{first}, radau9", "finished")


@pytest.mark.parametrize("gain", [0.1, 1e5])
def test_feedback_is_differentiated(gain, monkeypatch):
    """A law that holds the first mass by what all move: with its derivatives it takes no more steps than without it.

    Of large systems, whose derivatives are products, SciPy's Radau leads on.
    """
    f = kn.input("F")
    eom, given = derived(f), {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 3, "rtol": 1e-8, "atol": 1e-14}
    law = -gain * (x[0] + eom.speeds[3])
    own, other = (kn.simulate(eom, (0, 0.5), **given, inputs={f: law}, method=m) for m in ("auto", "Radau"))
    assert own.method in [f"{method}, radau9" for method in SMOOTH]
    assert own.steps < 1100
    assert own.q == pytest.approx(other.q, abs=1e-6 * np.abs(other.q).max())
    monkeypatch.setattr(right_hand_side, "_LONG", 0)
    left = kn.simulate(eom, (0, 0.5), **given, inputs={f: law})
    assert left.method in [f"{method}, Radau" for method in SMOOTH]
    assert "SciPy's Radau continues" in left.events[0][0].message


@pytest.mark.parametrize("method", ["auto", "radau9"])
def test_a_switch_turns_where_equations_are_stiff(method):
    """u' = −λ (u − v) with v = 1 up to x = 1 and 2 beyond: x = 1 + 2 s − (1 − exp(−λ s)) / λ, s after that."""
    rate, p = 1e5, O.at("P", x[0] * N.x)
    load = kn.Force(p, -rate * (x[0].dt - kn.where(kn.less(x[0], 1), 1.0, 2.0)) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))
    sol = kn.simulate(eom, (0, 2), q=[0], u=[1], method=method, samples=[0.5, 1 + 1e-6, 1 + 1e-5, 1.1, 1.7])
    assert sol.method.endswith("radau9")
    after = np.maximum(sol.t - 1, 0)
    assert sol.q[:, 0] == pytest.approx(np.minimum(sol.t, 1) + 2 * after + np.expm1(-rate * after) / rate, abs=1e-8)
    assert sol.u[:, 0] == pytest.approx(np.where(sol.t > 1, 2 - np.exp(-rate * after), 1), abs=1e-6)


def forced(damping):
    """The chain with springs of 1 N/m and these dampers, by methods that are told."""
    points = [O.at(f"P{i}", x[i] * N.x) for i in range(4)]
    loads = [kn.Force(points[0], kn.sin(3 * kn.time) * N.x)]
    for i, at in enumerate(points):
        before = x[i - 1] if i else 0
        pull = (-(x[i] - before) - damping * (x[i].dt - (before.dt if i else 0))) * N.x
        loads += [kn.Force(at, pull)] + ([kn.Force(points[i - 1], -pull)] if i else [])
    bodies = [kn.Particle(f"p{i}", p, 1) for i, p in enumerate(points)]
    eom = kn.derive(kn.System(N, bodies=bodies, loads=loads, speeds="rates"))

    def run(method, end=100):
        return kn.simulate(eom, (0, end), q=[0] * 4, u=[0] * 4, rtol=1e-9, atol=1e-11, method=method, samples=51)

    return run


def test_it_comes_back_where_equations_are_stiff_no_more():
    """Dampers that fade from 1e6 N s/m: after a few seconds the explicit method leads on, at fewer steps and as exactly."""
    run = forced(1e6 * kn.exp(-2 * kn.time))
    own, other = run("auto"), run("radau9")
    assert own.method.endswith(", radau9")
    assert [e.name for e, _ in own.events] == ["the equations are stiff", "the equations are stiff no more"]
    assert 3 < own.events[1][1] < 20
    assert "which continues" in own.events[1][0].message
    assert own.steps < other.steps
    assert own.q == pytest.approx(other.q, abs=1e-8)
    assert own.keeps_energy


def test_it_comes_back_less_and_less_often():
    """Dampers that come and go every 6 s: it goes over again, but does not go to and fro for ever."""
    run = forced(1e5 * kn.exp(10 * (kn.sin(kn.time) - 1)))
    own = run("auto")
    names = [e.name for e, _ in own.events]
    assert names[:3] == ["the equations are stiff", "the equations are stiff no more", "the equations are stiff"]
    assert len(names) <= 5
    assert own.q == pytest.approx(run("radau9").q, abs=1e-8)


def test_it_does_not_leave_what_stays_stiff_or_was_asked_for():
    assert [e.name for e, _ in forced(1e6)("auto").events] == ["the equations are stiff"]
    fading = forced(1e6 * kn.exp(-2 * kn.time))("radau9", 20)
    assert (fading.method, fading.events) == ("radau9", ())


def test_a_method_that_is_asked_for_stays():
    given = {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 2, "parameters": {c: 1e4}}
    sol = kn.simulate(chain(), (0, 0.02), **given, method="gauss16")
    assert (sol.method, sol.status) == ("gauss16", "finished")


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_what_oscillates_is_not_stiff(tolerance):
    """A double pendulum; fast and slow springs in a row without damping: their oscillations are the motion."""
    swinging = kn.derive(pendulums.system(2))
    sol = kn.simulate(swinging, (0, 30), q=[1.5, 1.5], u=[0, 0], rtol=tolerance, atol=tolerance, samples=2)
    assert sol.method in SMOOTH
    given = {"q": [0.1, 0.0, 0.3, 0.0], "u": [0.0] * 4, "samples": 2, "parameters": {c: 0.0, k: 1e4}}
    sol = kn.simulate(chain(), (0, 10), **given, rtol=tolerance, atol=tolerance)
    assert sol.method in SMOOTH


def test_nothing_leads_on_from_the_end():
    """A motion that is over when its steps turn out to be short is over: no method is left anything to do."""
    given = {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 2, "parameters": {c: 1e4}}
    for end in (0.02, 0.04):
        sol = kn.simulate(chain(), (0, end), **given)
        assert sol.method in SMOOTH
        assert (sol.status, sol.events) == ("finished", ())
        assert 100 <= sol.steps < 1000
