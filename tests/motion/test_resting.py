# SPDX-License-Identifier: BSD-3-Clause
"""Starts on the threshold of an event: the first derivative that is not zero says whether it is met."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, v, t = kn.coordinate("x"), kn.speed("v"), kn.time
P = O.at("P", x * N.x)
F, LEVEL, JERK, SNAP = kn.input("F"), *kn.parameters("level jerk snap", 0.0)
METHODS = ("gauss16", "dop853", "tsit5", "DOP853", "Radau", "LSODA")


def line(force, *events):
    loads = [kn.Force(P, force * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads, events=list(events)))


LEVELS = {
    d: line(F + JERK * t + SNAP * t**2, kn.Event("level", x - LEVEL, direction=d, terminal=False)) for d in (-1, 1)
}


def floor(direction=-1, **more):
    return kn.Event("floor", x, direction=direction, **more)


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_that_starts_on_the_floor_moving_down_bounces(method):
    """At 0, and after flights of 2 · 0.8ⁿ/9.81 s; one that moves up bounces after its flight alone."""
    eom = line(-9.81, floor(then={v: -0.8 * v}))
    for u, first in ((-1, 0.8), (1, 1.0)):
        sol = kn.simulate(eom, (0, 0.3), q=[0], u=[u], method=method)
        times = np.cumsum([0.0, *(2 * first * 0.8**k / 9.81 for k in range(9))])[0 if u < 0 else 1 :]
        assert [at for _, at in sol.events] == pytest.approx(times[times < 0.3], abs=1e-8)
        assert sol["x"].min() > -1e-9
        assert sol.keeps_energy


def test_one_that_lies_there_does_not_fall_through():
    sol = kn.simulate(line(-9.81, floor(then={v: -0.8 * v})), (0, 1), q=[0], u=[0])
    assert (sol.status, sol.t[-1]) == ("stopped", 0)
    assert "the event 'floor' acts without end at t = 0" in sol.message


@given(
    st.integers(1, 4),
    st.sampled_from([-1, 1]),
    st.sampled_from([-1, 1]),
    st.one_of(st.just(0.0), st.floats(-9, -0.1), st.floats(0.1, 9)),
    st.floats(0.1, 9),
    st.integers(-1, 1),
    st.sampled_from(METHODS),
)
@examples(1.0)
def test_the_first_derivative_that_is_not_zero_decides(order, side, direction, at, size, off, method):
    """x = c ± a tⁿ, which begins on its threshold but for a rounding, and passes none later."""
    a = [side * size * (k == order) for k in range(5)]
    given = {"inputs": {F: a[2]}, "parameters": {LEVEL: at, JERK: a[3], SNAP: a[4]}, "method": method}
    start = float(np.nextafter(at, off * math.inf)) if off and at else at
    sol = kn.simulate(LEVELS[direction], (0, 1), q=[start], u=[a[1]], samples=3, **given)
    assert [when for _, when in sol.events] == ([0.0] if side == direction else [])
    assert sol.status == "finished"


@pytest.mark.parametrize("method", ["auto", "DOP853"])
def test_a_terminal_one_ends_the_motion_where_it_begins_and_it_goes_on_from_there(method):
    eom = line(-x, kn.Event("falls", v, direction=-1))
    sol = kn.simulate(eom, (0, 9), q=[1], u=[0], method=method)
    assert (sol.status, sol.event.name, len(sol)) == ("event", "falls", 1)
    assert sol.keeps_energy
    on = kn.simulate(eom, 9, start=sol)
    assert on.t[-1] == pytest.approx(2 * np.pi, abs=1e-8)
    assert [at for _, at in (sol + on).events] == pytest.approx([0, 2 * np.pi], abs=1e-8)


def test_an_event_at_the_very_end_is_not_met_again_by_what_goes_on():
    eom = line(-9.81, floor(terminal=False))
    end = kn.simulate(line(-9.81, floor()), (0, 9), q=[1], u=[0]).t[-1]
    sol = kn.simulate(eom, (0, end), q=[1], u=[0])
    on = kn.simulate(eom, end + 1, start=sol)
    assert len((sol + on).events) == 1


@pytest.mark.parametrize(
    ("force", "event", "message"),
    [
        (-x, floor(), r"the first 4 derivatives do not show .* Start off the threshold"),
        (F, floor(), r"the first 4 derivatives do not show .* Start off the threshold"),
        (-9.81, floor(0, then={v: -v}), r"no crossing\. Give direction=1 or -1, or start off the threshold"),
        (-9.81, floor(0), r"no crossing\. Give direction=1 or -1, or start off the threshold"),
    ],
)
def test_what_the_derivatives_do_not_say_is_warned_of(force, event, message):
    """At rest, driven by a function whose derivatives are not known, or in both directions."""
    given = {"inputs": {F: lambda s: 0.0 * s}} if force is F else {}
    with pytest.warns(kn.KaneWarning, match=f"Expected a start beside the threshold 0 of the event 'floor'.*{message}"):
        kn.simulate(line(force, event), (0, 1), q=[0], u=[0], **given)
