# SPDX-License-Identifier: BSD-3-Clause
"""The start: complete, named, finite; Euler parameters of unit length."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.analysis import start_state
from kane.gallery import load
from kane.motion import SOLVERS, check_span, check_steps, check_tolerance, sample_times
from tests.motion.steppers.runs import spring

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
e = kn.coordinates("e0:4")
x = kn.coordinate("x")
F, G = kn.input("F"), kn.input("G")
B = N.rotate_euler_parameters("B", e)
BODY = kn.RigidBody("b", frame=B, mass_center=O.at("G", x * N.x), mass=1, inertia=kn.inertia(B, 1, 2, 3))
EOM = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Force(BODY.mass_center, (F + G) * N.x)]))


def test_state_is_in_the_order_of_the_equations():
    state = start_state(
        EOM, {"x": 5, "e0": 0.6, "e2": 0.8, "e1": 0, "e3": 0}, {"u_x": 4, "w1_e0": 1, "w2_e0": 2, "w3_e0": 3}
    )
    order = [s.name for s in (*EOM.coordinates, *EOM.speeds)]
    assert dict(zip(order, state, strict=True)) == {
        "x": 5, "e0": 0.6, "e1": 0, "e2": 0.8, "e3": 0, "u_x": 4, "w1_e0": 1, "w2_e0": 2, "w3_e0": 3,
    }  # fmt: skip


@pytest.mark.parametrize("length", [1.0, 1 + 5e-9, 1 - 5e-9])
def test_unit_euler_parameters(length):
    values = dict(zip(e, length * np.array([0.5, 0.5, -0.5, 0.5]), strict=True)) | {x: 0}
    assert len(start_state(EOM, values, [0] * 4)) == 9


@pytest.mark.parametrize("given", [(1, 0.1, 0, 0), (0, 0, 0, 0), (0.5, 0.5, 0.5, 0.4)])
def test_euler_parameters_of_another_length(given):
    values = dict(zip(e, given, strict=True)) | {x: 0}
    with pytest.raises(kn.SimulationError, match=r"Euler parameters \(e0, e1, e2, e3\).*got length .*Divide"):
        start_state(EOM, values, [0] * 4)
    with pytest.raises(kn.SimulationError, match="Euler parameters"):
        kn.simulate(EOM, (0, 1), q=values, u=[0] * 4, inputs={F: 0, G: 0})


@pytest.mark.parametrize(
    ("first", "more", "told"),
    [
        (0, {}, "Expected first_step > 0, the length of the first step in s, got 0"),
        (-0.1, {}, "Expected first_step > 0"),
        (float("nan"), {}, "Expected a finite length for first_step, got nan"),
        ("long", {}, "Expected a number as the length for first_step, got 'long'"),
        (0.2, {"max_step": 0.1}, r"Expected first_step of at most max_step=0\.1, got 0\.2\. Give a shorter one"),
        (
            0.1,
            {"max_step": 0.1, "method": "rk4"},
            r'no first_step for method="rk4".* max_step, got 0\.1\. Leave it out',
        ),
    ],
)
def test_the_first_step_is_a_length(first, more, told):
    with pytest.raises(kn.SimulationError, match=told):
        kn.simulate(spring(), (0, 1), q=[1], u=[0], first_step=first, **more)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "dop853", "tsitpap8", "vern9", "tsit5", "radau9", *SOLVERS])
def test_the_first_step_is_the_one_that_is_told(method):
    """By the motion that one step makes; one beyond the end, or too long, is cut."""
    short, long = (
        kn.simulate(spring(), (0, 1), q=[1], u=[0], rtol=1e-3, method=method, first_step=h, max_steps=1, samples=2)
        for h in (1e-5, 5.0)
    )
    assert short.t[-1] == pytest.approx(1e-5, rel=1e-9)
    assert long.t[-1] > 3e-5
    first = kn.simulate(spring(), (0, 1), q=[1], u=[0], method=method, first_step=1e-5)
    assert np.abs(first.q[:, 0] - np.cos(first.t)).max() < 1e-6
    assert first.accuracy().relative < 1e-6


def test_missing_values_are_all_named():
    with pytest.raises(kn.ValueMissingError, match="got none for e1, e3"):
        start_state(EOM, {"x": 5, "e0": 0.6, "e2": 0.8}, [0] * 4)
    with pytest.raises(kn.ValueMissingError, match="start value for all coordinates, got none for"):
        start_state(EOM, None, [0] * 4)


def test_span_and_tolerance():
    assert check_span([0, 2]) == (0.0, 2.0)
    assert check_span(np.array([-1, 1])) == (-1.0, 1.0)
    assert check_tolerance("rtol", 1e-3) == 1e-3
    for span in ("ab", None, (1,), (2, 1), (0, float("nan"))):
        with pytest.raises(kn.SimulationError, match="time span"):
            check_span(span)


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        *((x, f"finite sample times, got {x} among them") for x in (np.nan, np.inf, -np.inf)),
        *((x, r"a number of samples or their times, got \[") for x in (None, "0.5")),
    ],
)
@pytest.mark.parametrize("place", [0, 1, 2])
def test_sample_times_are_finite(bad: Any, said: str, place: int) -> None:
    times: list[Any] = [0.0, 0.5, 1.0]
    times[place] = bad
    with pytest.raises(kn.SimulationError, match=said):
        sample_times(times, (0.0, 1.0))


@pytest.mark.parametrize("given", [{"q": ["1"]}, {"parameters": {"k": "1"}}, {"inputs": {"F": "1"}}])
def test_texts_are_no_numbers(given: dict[str, Any]) -> None:
    N, x = kn.Frame("N"), kn.coordinate("x")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    loads = [kn.Force(P, (kn.input("F") - kn.parameter("k") * x) * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", loads=loads))
    start: dict[str, Any] = {"q": [0], "u": [0], "parameters": {"k": 1}, "inputs": {"F": 1}}
    with pytest.raises(kn.SimulationError, match=r"Expected a number as the .* got '1'"):
        kn.simulate(eom, (0, 1), **start | given)


@pytest.mark.parametrize("most", [0, -1, 0.5, "a", None, True, np.nan])
def test_steps_are_counted_in_whole_numbers(most: object) -> None:
    with pytest.raises(kn.SimulationError, match="max_steps to be a whole number above 0"):
        check_steps(most)


def test_times_that_numbers_do_not_tell_apart():
    """Near 1e15 they are 0.125 apart: of a short span nothing is told, in a long one the steps it takes are said to be too short."""
    with pytest.raises(
        kn.SimulationError,
        match=r"they are 0\.12 s apart: 80 in all\. Use an origin of time closer to the span, such as \(0, 10\)",
    ):
        check_span((1e15, 1e15 + 10))
    for method in ("gauss16", "DOP853"):
        sol = kn.simulate(spring(), (1e15, 1e15 + 1e6), q=[1], u=[0], samples=2, method=method, max_seconds=60)
        assert sol.status == "stopped"
        assert "times there are 0.12 s apart" in sol.message
        assert "singular" not in sol.message


def test_a_beam_bent_beyond_its_equations():
    """Its kinetic energy would be negative there: named, where the start is otherwise on the constraints."""
    eom = kn.derive(load("flexible_slider_crank").system())
    far = {"q_crank": 0.5, "v1_rod": 0.8, "v2_rod": -0.8}
    guessed = {name: kn.guess(0.1) for name in ("q_wrist", "x")}
    rest = {u.name: 0.0 for u in eom.independent_speeds}
    with pytest.raises(kn.SimulationError, match="kinetic energy ≥ 0 for all speeds, got a negative one of u_"):
        kn.simulate(eom, (0, 0.1), q=far | guessed, u=rest)
