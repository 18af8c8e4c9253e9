# SPDX-License-Identifier: BSD-3-Clause
"""Inputs as functions of time; prescribed motion by an input with its derivatives, by a spline, by an expression of time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.motion import input_functions

m, l, g = kn.parameter("m", 1.3), kn.parameter("l", 0.6), kn.parameter("g", 9.81)
theta, r, F = kn.coordinate("theta"), kn.input("r"), kn.input("F")


def pendulum(shift: Any) -> kn.Equations:
    """A pendulum whose pivot is at `shift` along x, pushed by F."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = O.at("A", shift * N.x)
    B = N.rotate("B", theta, N.z)
    P = A.at("P", -l * B.y)
    loads = [kn.gravity(-g * N.y), kn.Force(P, F * N.x - 0.4 * P.velocity(N))]
    return kn.derive(kn.System(N, bodies=[kn.Particle("bob", P, m)], speeds="rates", loads=loads))


def test_inputs_are_numbers_or_functions() -> None:
    eom = pendulum(0)
    functions = input_functions(eom, {F: 3}, (0, 1))
    assert functions[F](12.0) == 3.0
    assert input_functions(eom, {"F": np.cos}, (0, 1))[F](0.5) == np.cos(0.5)
    with pytest.raises(kn.ValueMissingError, match=r"got none for F: pass inputs=\{…\}"):
        input_functions(eom, None, (0, 1))


def test_an_input_that_moves_the_pivot_equals_an_expression_of_time() -> None:
    t = kn.time
    driven, written = pendulum(r), pendulum(0.2 * kn.sin(3 * t))
    assert [s.name for s in driven.inputs] == ["r", "r'", "r''", "F"]
    state: dict[str, Any] = {"q": [0.7], "u": [-0.4], "t": 0.3}
    moved = {"r": 0.2 * np.sin(0.9), "r'": 0.6 * np.cos(0.9), "r''": -1.8 * np.sin(0.9), "F": 0.5}
    for what in ("accelerations", "energy", "power"):
        a = driven.evaluate(getattr(driven, what), **state, inputs=moved)
        b = written.evaluate(getattr(written, what), **state, inputs={"F": 0.5})
        np.testing.assert_allclose(a, b, rtol=1e-13)
    functions = (lambda t: 0.2 * np.sin(3 * t), lambda t: 0.6 * np.cos(3 * t), lambda t: -1.8 * np.sin(3 * t))
    one = kn.simulate(driven, (0, 2), q=[0.7], u=[-0.4], inputs={r: functions, F: 0})
    two = kn.simulate(written, (0, 2), q=[0.7], u=[-0.4], inputs={F: 0})
    np.testing.assert_allclose(one.states, two.states, atol=1e-8)
    assert one.energy_check.relative < 1e-8


def test_a_spline_through_points() -> None:
    times = np.linspace(0, 2, 81)
    eom = pendulum(r)
    smooth = kn.signal(times, 0.2 * np.sin(3 * times))
    assert smooth(0.5) == pytest.approx(0.2 * np.sin(1.5), abs=1e-6)
    assert smooth.derivative(2)(0.5) == pytest.approx(-1.8 * np.sin(1.5), abs=1e-2)
    sol = kn.simulate(eom, (0, 2), q=[0.7], u=[-0.4], inputs={r: smooth, F: 0})
    exact = kn.simulate(pendulum(0.2 * kn.sin(3 * kn.time)), (0, 2), q=[0.7], u=[-0.4], inputs={F: 0})
    np.testing.assert_allclose(sol.q, exact.q, atol=1e-4)
    assert sol.energy_check.relative < 1e-6  # the spline's own motion, exactly


def test_a_constant_input_has_no_rate() -> None:
    sol = kn.simulate(pendulum(r), (0, 1), q=[0.7], u=[0], inputs={r: 0.3, F: 0})
    rest = kn.simulate(pendulum(0), (0, 1), q=[0.7], u=[0], inputs={F: 0})
    np.testing.assert_allclose(sol.q, rest.q, atol=1e-12)


BAD: dict[str, tuple[Any, type[Exception], str]] = {
    "no derivatives": (
        np.sin,
        kn.ValueMissingError,
        r"input r with its derivatives.*bare function.*\(f, f', f''\), or kn.signal",
    ),
    "too few": (
        (np.sin, np.cos),
        kn.ValueMissingError,
        "Expected 3 functions for the input r, itself and its derivatives, got 2",
    ),
    "another's": (
        (np.sin, np.sin, lambda t: -np.sin(t)),
        kn.SimulationError,
        "given derivative of the input r to match it",
    ),
    "jump": (
        (lambda t: 0.1 * (t > 0.5), lambda t: 0.0, lambda t: 0.0),
        kn.SimulationError,
        r"input r without jumps.*got one of 0\.1 at t = 0\.5.*infinite force",
    ),
    "kink": (
        (lambda t: abs(t - 0.5), lambda t: float(np.sign(t - 0.5)), lambda t: 0.0),
        kn.SimulationError,
        r"input r' without jumps.*got one of (1|2) at t = 0\.5",
    ),
    "not a number": ((lambda t: np.nan, np.cos, np.sin), kn.SimulationError, "input r finite over the time span"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_prescribed_motions(what: str) -> None:
    value, error, message = BAD[what]
    with pytest.raises(error, match=message):
        kn.simulate(pendulum(r), (0, 1), q=[0.7], u=[0], inputs={r: value, F: 0})


@pytest.mark.parametrize(
    ("shift", "message"),
    [
        (kn.where(kn.less(kn.time, 0.5), 0, 0.1), r"prescribed .* without jumps.*got one of 0\.1 at t = 0\.5"),
        (kn.abs(kn.time - 0.5), r"velocity of the prescribed .* without jumps.*got one of (1|2) at t = 0\.5"),
    ],
)
def test_expressions_of_time_that_jump(shift: kn.Expr, message: str) -> None:
    with pytest.raises(kn.SimulationError, match=message):
        kn.simulate(pendulum(shift), (0, 1), q=[0.7], u=[0], inputs={F: 0})


def test_a_smooth_piecewise_motion_is_taken() -> None:
    """A rest, then (t − ½)³: twice continuously differentiable."""
    late = kn.time - 0.5
    shift = kn.where(kn.less(kn.time, 0.5), 0, late * late * late)
    sol = kn.simulate(pendulum(shift), (0, 1), q=[0.7], u=[0], inputs={F: 0})
    assert sol.energy_check.relative < 1e-7


@pytest.mark.parametrize(
    ("t", "y", "message"),
    [
        ([0, 1], [0, 1], "at least three points"),
        ([0, 1, 1, 2], [0, 1, 2, 3], "increasing times of a signal, got t = 1 again"),
        ([0, 1, 2], [0, np.nan, 1], "finite points"),
    ],
)
def test_bad_signals(t: list[float], y: list[float], message: str) -> None:
    with pytest.raises(kn.SimulationError, match=message):
        kn.signal(t, y)


def test_ends_that_do_not_suit_a_signal() -> None:
    with pytest.raises(kn.SimulationError, match=r"last value of a periodic signal to equal its first one, 0, got 2\."):
        kn.signal([0, 1, 2], [0, 1, 2], ends="periodic")
    with pytest.raises(kn.SimulationError, match=r"ends of a signal to be one of not-a-knot, .* got 'free'"):
        kn.signal([0, 1, 2], [0, 1, 2], ends="free")  # type: ignore[arg-type]


def test_a_signal_that_ends_before_the_span() -> None:
    eom = pendulum(r)
    times = np.linspace(0, 1, 9)
    short = kn.signal(times, 0.2 * np.sin(3 * times))
    message = (
        r"signal for the input r that covers the time span t = 0 … 2, got one from t = 0 to 1\. Give points up to the ends of the "
        r"span, or a span within the signal\."
    )
    for value in (short, (short, short.derivative(1), short.derivative(2))):
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(eom, (0, 2), q=[0], u=[0], inputs={r: value, F: 0})
    with pytest.raises(
        kn.SimulationError, match=r"for the input F that covers the time span t = -1 … 1, got one from t = 0"
    ):
        kn.simulate(eom, (-1, 1), q=[0], u=[0], inputs={r: 0.0, F: short})
    assert kn.simulate(eom, (0, 1), q=[0], u=[0], inputs={r: short, F: short}).status == "finished"


@pytest.mark.parametrize("samples", [([0, 1, 2], [0, 1, 2]), (np.arange(3), np.arange(3)), [0, 1, 2], np.arange(3)])
def test_samples_are_no_function_of_time(samples: Any) -> None:
    for inputs in ({r: samples, F: 0}, {r: 0, F: samples}):
        with pytest.raises(
            kn.SimulationError, match=r"got samples\. Make them a smooth function of time: [rF]: kn\.signal\(t, y\)"
        ):
            input_functions(pendulum(r), inputs, (0, 1))


def test_a_law_of_gains_by_a_matrix_asks_for_a_tuple_of_inputs() -> None:
    """-K @ x of a K with one row is an array of one expression: under the input's tuple it is the law, under the input an error."""
    eom = pendulum(0)
    off = np.array([*eom.coordinates, *eom.speeds])
    laws = -np.ones((1, len(off))) @ off
    with pytest.raises(kn.SimulationError, match=r"got an array of them\. .* in a tuple: inputs=\{\(F,\): …\}"):
        kn.simulate(eom, (0, 1), q=[0.1], u=[0], inputs={F: laws})
    one, other = (kn.simulate(eom, (0, 1), q=[0.1], u=[0], inputs=given) for given in ({(F,): laws}, {F: laws[0]}))
    assert np.array_equal(one.q, other.q)


class TestWhatComesForAnInput:
    """What is no number or function of time alone is told what it is; so is what goes wrong in the user's function."""

    @pytest.mark.parametrize(
        ("value", "message"),
        [
            (2 * F, r"got the expression 2\*F.*Write what depends on .* into the model instead of F"),
            (
                lambda t, x, z: t,
                r"function of the time alone for the input F, f\(t\), got one of \(t, x, z\).*two, f\(t, x\)",
            ),
            (lambda: 1.0, r"function of the time alone for the input F, f\(t\), got one of \(\)"),
            (
                lambda t: [t, t],
                r"the function of time for the input F, got \[0.0, 0.0\] at t = 0. Return a plain number",
            ),
            (lambda t: "a", "got 'a' at t = 0"),
            (lambda t: 1j, "got 1j at t = 0"),
            (lambda t: None, "got None at t = 0"),
            (lambda t: kn.sin(kn.time), r"got the expression sin\(t\) at t = 0. Use math.sin instead of kn.sin"),
            (lambda t: math.log(t - 0.5), "got ValueError from it at t = 0"),
            (lambda t: math.sqrt(0.5 - t), r"got ValueError from it at t = 0\.[5-9].*Correct the function"),
            (lambda t: {}[t], "got KeyError from it at t = 0"),
            (lambda t: 1 / 0 if t > 0.4 else 1, "got ZeroDivisionError from it"),
            ("sin(t)", "got 'sin.t.'. Give a plain number"),
        ],
    )
    @pytest.mark.parametrize("method", ["DOP853", "BDF"])
    def test_it_is_said(self, value: Any, message: str, method: str) -> None:
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(pendulum(0), (0, 1), q=[0.7], u=[0], inputs={F: value}, method=method)

    @pytest.mark.parametrize(
        "value", [np.array(0.2), np.float32(0.2), lambda t: np.array(0.2), lambda t: np.array([0.2]), math.sin]
    )
    def test_what_is_a_number_passes(self, value: Any) -> None:
        assert kn.simulate(pendulum(0), (0, 0.1), q=[0.7], u=[0], inputs={F: value}, samples=2).status == "finished"


def test_parameters_that_only_inputs_contain_are_given_by_name() -> None:
    """As symbols and names of the equations' parameters are, wherever motions take parameters."""
    eom, gain, ratio = pendulum(0), kn.parameter("gain", 2.0), kn.parameter("ratio")
    start: dict[str, Any] = {"q": [0.4], "u": [0.1], "inputs": {F: -gain * theta + ratio * kn.sin(3 * kn.time)}}
    first = kn.simulate(eom, (0, 1), **start, parameters={gain: 5.0, ratio: 0.7, m: 1.1})
    second = kn.simulate(eom, 2, start=first, parameters={gain: 1.0})
    named = {"gain": 5.0, "ratio": 0.7, "m": 1.1}
    by_name = kn.simulate(eom, (0, 1), **start, parameters=named)
    assert np.array_equal(by_name.states, first.states)
    assert np.array_equal(kn.simulate(eom, 2, start=by_name, parameters={"gain": 1.0}).states, second.states)
    run = kn.prepare(eom, (0, 1), inputs=start["inputs"])
    assert np.array_equal(run(q=start["q"], u=start["u"], parameters=named).states, first.states)
    together = {(F,): np.array([-gain, 0.0]) @ np.array([theta, 0]) + ratio * kn.sin(3 * kn.time)}
    assert np.array_equal(
        kn.simulate(eom, (0, 1), **start | {"inputs": together}, parameters=named).states, first.states
    )
    slopes = kn.fitting.sensitivities(eom, (0, 1), ["gain", "m"], **start, parameters=named, samples=3)
    assert np.array_equal(
        slopes.states,
        kn.fitting.sensitivities(
            eom, (0, 1), [gain, m], **start, parameters=first.parameters | {gain: 5, ratio: 0.7}, samples=3
        ).states,
    )


def test_missing_parameters_of_inputs_are_named() -> None:
    eom, law = pendulum(0), {F: kn.parameter("ratio") * theta}
    missing = r"every parameter of the input F, got none for ratio\. Pass parameters="
    with pytest.raises(kn.ValueMissingError, match=missing):
        kn.simulate(eom, (0, 1), q=[0.4], u=[0], inputs=law)
    with pytest.raises(kn.ValueMissingError, match=r"got one for 'ration'\. Did you mean ratio"):
        kn.simulate(eom, (0, 1), q=[0.4], u=[0], inputs=law, parameters={"ration": 1.0})
