# SPDX-License-Identifier: BSD-3-Clause
"""Gradients by the way back along a motion, beside differences of motions at 1e-13, the way forwards, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.fitting import curve, sensitivities
from kane.gallery import load
from tests.motion.derivatives.test_sensitivities import TIGHT, differences, four_bar, oscillator, pushed

ADJOINT = {"method": "adjoint"}


def belt():
    """A mass on a belt, through changes of mode."""
    own = load("mass_on_belt")
    system = own.system()
    eom = kn.derive(system)
    given = {"parameters": {p: p.default for p in eom.parameters}}
    given |= {
        kind: {s: own.START[kind][s.name] for s in group} for kind, group in (("q", eom.coordinates), ("u", eom.speeds))
    }
    return system, eom, given


def with_integral(system, integrand):
    """The system with a further state of that rate, and the state."""
    J = kn.state("J")
    return kn.derive(system.replace(states={J: integrand})), J


def test_by_parameters_of_equations_and_inputs_and_starts():
    """At samples, and of a cost of an end, an integral of the input's power and weighted samples."""
    eom, inputs, by = oscillator()
    k, c, A, w, x, u = by
    given = {"q": {x: 0.4}, "u": {u: 0.0}, "parameters": {k: 2.0, c: 0.1, A: 0.7, w: 1.3}, "inputs": inputs}
    F = eom.inputs[0]
    s = sensitivities(eom, (0, 6), by, samples=4, **ADJOINT, **given)
    wanted = differences(eom, (0, 6), by, given, 4)
    np.testing.assert_allclose(s.states, wanted, rtol=0, atol=2e-9 * np.abs(wanted).max())
    with_work, J = with_integral(eom.system, F * u + k * x**2)
    work = differences(with_work, (0, 6), by, {**given, "states": {J: 0.0}}, 4, J)[-1]
    weights = np.array([0.0, 2.0, -1.0, 0.5])
    found = s.cost(k * x, integral=F * u + k * x**2, samples={x: weights})
    whole = work + 2.0 * wanted[-1, 0] + weights @ wanted[:, 0]
    whole[0] += s.motion[x][-1]
    np.testing.assert_allclose(found.gradient, whole, rtol=0, atol=5e-9 * np.abs(whole).max())


def test_across_bounces():
    """A ball: ẏ(T) and ∫ (y + ẏ²) dt, which jumps with the speed."""
    ball = load("bouncing_ball").system()
    eom = kn.derive(ball)
    m, g, e = eom.parameters
    (y,), (v,) = eom.coordinates, eom.speeds
    given = {"q": {y: 1.0}, "u": {v: 0.3}, "parameters": {m: 1.0, g: 9.81, e: 0.8}}
    by = [y, v, g, e]
    s = sensitivities(eom, (0, 2), by, samples=2, **ADJOINT, **given)
    assert len(s.motion.events) >= 2
    with_sum, J = with_integral(ball, y + v**2)
    wanted = differences(with_sum, (0, 2), by, {**given, "states": {J: 0.0}}, 2, 3 * v + J, 1e-4, -1)
    found = s.cost(3 * v, integral=y + v**2)
    np.testing.assert_allclose(found.gradient, wanted, rtol=1e-7, atol=1e-7)
    one = kn.simulate(with_sum, (0, 2), states={J: 0.0}, samples=2, **given, **TIGHT)
    assert found.value == pytest.approx(one[3 * v + J][-1], rel=1e-9)


@pytest.mark.slow
def test_across_slips():
    system, eom, given = belt()
    mu = [p for p in eom.parameters if p.name.startswith("mu")]
    k = next(p for p in eom.parameters if p.name == "k")
    x = eom.coordinates[0]
    by = [*mu, k, x]
    s = sensitivities(eom, (0, 6), by, samples=2, **ADJOINT, **given)
    assert len(s.motion.mode_history) >= 3
    with_work, J = with_integral(system, k * x**2 / 2)
    wanted = differences(with_work, (0, 6), by, {**given, "states": {J: 0.0}}, 2, x + J, 1e-4, -1)
    found = s.cost(x, integral=k * x**2 / 2).gradient
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-7)


def test_of_a_four_bar():
    eom, given = four_bar()
    by = [next(s for s in (*eom.state, *eom.parameters) if s.name == name) for name in ("a", "m2", "q1", "u1")]
    q3 = next(q for q in eom.coordinates if q.name == "q3")
    s = sensitivities(eom, (0, 1.5), by, samples=3, **ADJOINT, **given)
    wanted = sensitivities(eom, (0, 1.5), by, samples=3, **given)
    np.testing.assert_allclose(s[q3], wanted[q3], rtol=0, atol=1e-9 * np.abs(wanted[q3]).max())
    for name in ("a",), ("u1", "m2"):
        some = [b for b in by if b.name in name]
        own = sensitivities(eom, (0, 1.5), some, samples=2, **ADJOINT, **given)
        beside = differences(eom, (0, 1.5), some, given, 2, q3, 1e-4, -1)
        np.testing.assert_allclose(own.cost(q3).gradient, beside, rtol=0, atol=2e-7 * np.abs(beside).max())


@pytest.mark.slow
def test_by_fifty_values_of_an_input():
    """All nodes of a curve in one way back; a cost of the input alone is what the quadrature of its table says."""
    eom, _, (k, _, _, _, x, u) = oscillator()
    F = eom.inputs[0]
    law = curve("F", np.linspace(0, 4, 50), np.sin(np.linspace(0, 9, 50)))
    by = [*law.nodes, k, x]
    given = {"q": [0.4], "u": [0.0], "inputs": {F: law.expression}}
    back = sensitivities(eom, (0, 4), by, samples=2, **ADJOINT, **given)
    some = [0, 7, 33, 50, 51]
    forth = sensitivities(eom, (0, 4), [by[i] for i in some], samples=2, **given)
    np.testing.assert_allclose(back.cost(x * u).gradient[some], forth[x * u][-1], rtol=1e-9, atol=1e-11)
    h = 4 / 49
    trapezia = back.cost(integral=F).gradient[:50]
    np.testing.assert_allclose(trapezia, h * np.array([0.5, *[1.0] * 48, 0.5]), rtol=1e-12)


def test_stages_are_made_anew_a_few_steps_at_a_time(monkeypatch):
    """The same numbers, whatever is kept together."""
    eom, inputs, by = oscillator()
    s = sensitivities(eom, (0, 6), by, samples=2, q=[0.4], u=[0.0], inputs=inputs, **ADJOINT)
    once = s.cost("x").gradient
    monkeypatch.setattr("kane.motion.derivatives.pulling._DOUBLES", 300)
    np.testing.assert_allclose(s.cost("x").gradient, once, rtol=1e-13, atol=1e-14)


def test_what_is_stiff_is_left_to_collocation():
    """m ẍ = F(t) − c ẋ − k x with c/m = 300/s: the way forwards beside it."""
    m, k, c, N = kn.parameter("m", 1.0), kn.parameter("k", 2.0), kn.parameter("c", 300.0), kn.Frame("N")
    x, u, F = kn.coordinate("x"), kn.speed("u"), kn.input("F")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    force = kn.Force(P, (F - c * u - k * x) * N.x)
    system = kn.System(N, bodies=[kn.Particle("B", P, m)], speeds={u: x.dt}, loads=[force])
    given, by = {"q": [1.0], "u": [0.3], "inputs": {F: np.sin}}, [m, k, c, x, u]
    with_sum, J = with_integral(system, x**2 + u)
    forth = sensitivities(with_sum, (0, 1), by, samples=2, states={J: 0.0}, **given)[J][-1]
    found = sensitivities(kn.derive(system), (0, 1), by, samples=2, **ADJOINT, **given).cost(integral=x**2 + u)
    np.testing.assert_allclose(found.gradient, forth, rtol=1e-9, atol=1e-12)


def spring(law):
    """A mass on a line with a force of this law(x, u, parameters), from x = 1 at rest; what is differentiated by."""
    m, k, N = kn.parameter("m", 1.0), kn.parameter("k", 20.0), kn.Frame("N")
    x, u = kn.coordinate("x"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    system = kn.System(N, bodies=[kn.Particle("B", P, m)], speeds={u: x.dt}, loads=[kn.Force(P, law(x, u, k) * N.x)])
    return kn.derive(system), {"q": [1.0], "u": [0.0]}, [m, k, x]


def test_across_bends_of_a_spring():
    """A spring twice as stiff on one side: x(T) = −√2 x₀ sin(√(k/m) T − π/√8) in the first stretch on the other one."""
    eom, given, by = spring(lambda x, u, k: -k * x - k * kn.max(0.0, x))
    end, w, m, k = 0.7, np.sqrt(20.0), 1.0, 20.0
    phase = w * end - np.pi / np.sqrt(8)
    by_phase = -np.sqrt(2) * np.cos(phase) * w * end / 2
    found = sensitivities(eom, (0, end), by, samples=2, **ADJOINT, **given).cost("x")
    wanted = [-by_phase / m, by_phase / k, -np.sqrt(2) * np.sin(phase)]
    np.testing.assert_allclose([found.value, *found.gradient], [wanted[2], *wanted], rtol=1e-8)


def test_by_all_parameters_and_start_values_of_three_rods():
    """A cost of the end, weighted samples and an integral, beside differences of motions with a further state."""
    system = load("pendulums").system(3)
    eom = kn.derive(system)
    q1, q2, _, u1, *_ = eom.state
    m1, by = eom.parameters[1], [*eom.parameters, *eom.state]
    given = {"q": dict(zip(eom.coordinates, (0.9, -0.4, 0.3), strict=True))}
    given |= {
        "u": dict(zip(eom.speeds, (0.1, 0.0, -0.2), strict=True)),
        "parameters": {p: p.default for p in eom.parameters},
    }
    s = sensitivities(eom, (0, 1.5), by, samples=4, **ADJOINT, **given)
    found = s.cost(q1 * u1 + m1 * q2, integral=q1**2, samples={q2: [0.0, -2.0, 0.0, 0.0]}).gradient
    with_sum, J = with_integral(system, q1**2)
    more = {**given, "states": {J: 0.0}}
    wanted = differences(with_sum, (0, 1.5), by, more, 4, q1 * u1 + m1 * q2 + J, rows=-1)
    wanted -= 2.0 * differences(with_sum, (0, 1.5), by, more, 4, q2, rows=1)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


def test_what_nothing_depends_on_is_not_written_out(monkeypatch):
    """The way back needs no ∂f/∂p of all of f, which takes longest to compile."""
    monkeypatch.setattr("kane.motion.derivatives.parameter_slopes.symbol_slopes", None)
    eom, given, by = spring(lambda x, u, k: -k * x)
    found = sensitivities(eom, (0, 1), by, samples=2, **ADJOINT, **given).cost("x").gradient
    w = np.sqrt(20.0)
    np.testing.assert_allclose(found, [np.sin(w) * w / 2, -np.sin(w) / (2 * w), np.cos(w)], rtol=1e-9)


def test_what_cannot_be_asked():
    eom, inputs, (_, _, _, _, x, _) = oscillator()
    given = {"q": [0.4], "u": [0.0], "inputs": inputs, "samples": 3}
    with pytest.raises(kn.SimulationError, match="method= to be"):
        sensitivities(eom, (0, 1), [x], method="backward", **given)
    s = sensitivities(eom, (0, 1), [x], **ADJOINT, **given)
    with pytest.raises(kn.SimulationError, match="something to differentiate"):
        s.cost()
    with pytest.raises(kn.SimulationError, match="3 weights"):
        s.cost(samples={x: [1.0, 2.0]})


def test_integrands_that_jump():
    """∫ L dt of L that jumps at a time which b moves, x = ½ t²: L = x² behind t = 2 b − 1. What jumps at states is refused."""
    _, eom, (_, F, x, _) = pushed()
    b, t = kn.parameter("b", 1.1), kn.time
    push = kn.where(kn.less(t, 9 * b), 1.0, 0.0)
    s = sensitivities(eom, (0, 2), [b], q=[0.0], u=[0.0], inputs={F: push}, parameters={b: 1.1}, **ADJOINT)
    late = kn.where(kn.less(t, 2 * b - 1), 0.0, x**2)
    np.testing.assert_allclose(s.cost(integral=late).gradient, [-2 * (0.5 * 1.2**2) ** 2], rtol=1e-10)
    with pytest.raises(kn.SimulationError, match=r"jumps where the state crosses a threshold: x < 0\.3"):
        s.cost(integral=kn.where(kn.less(x, 0.3), 0.0, 1.0))


@pytest.mark.slow
def test_ways_back_by_collocation_beyond_a_breakpoint_begin_before_later_events():
    """A motion has rows at its events, too: the state where a stretch begins is none of those behind them."""
    g, e, frame = kn.parameter("g", 9.81), kn.parameter("e", 0.8), kn.Frame("N")
    y, v, curved, asked = kn.coordinate("y"), kn.speed("v"), kn.input("F"), kn.input("G")
    place = kn.Point("O", fixed_in=frame).at("P", y * frame.y)
    eom = kn.derive(
        kn.System(
            frame,
            bodies=[kn.Particle("B", place, 1.0)],
            speeds={v: y.dt},
            loads=[kn.Force(place, (-g + curved + asked) * frame.y)],
            events=[kn.Event("b", y, direction=-1, then={v: -e * v})],
        )
    )
    law = curve("F", np.linspace(0, 1.5, 4), [0.1, 0.5, -0.3, 0.2])
    inputs = {curved: law.expression, asked: lambda t, x: -0.1 * x[1] * abs(x[1]) - 0.2 * x[0]}
    given = {"q": [1.0], "u": [0.0], "inputs": inputs, "samples": 2}
    back = sensitivities(eom, (0, 1.5), [y, g, e], method="adjoint", **given).cost(y).gradient
    np.testing.assert_allclose(back, sensitivities(eom, (0, 1.5), [y, g, e], **given)[y][-1], rtol=1e-7)
