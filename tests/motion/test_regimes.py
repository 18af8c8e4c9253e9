# SPDX-License-Identifier: BSD-3-Clause
"""Loads that switch, in machine code: steps end where they turn, and what comes back at once from both sides stops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import rolling_disk
from kane.motion import quantities
from tests.examples import examples
from tests.lanes import SMOOTH

N = kn.Frame("N")
x, v = kn.coordinate("x"), kn.speed("v")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
t = kn.time


def line(force, **more):
    """A particle of 1 kg on a line."""
    load = kn.Force(P, force * N.x, name="pull")
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[load], **more))


def moved(eom, span, x0, v0, **more):
    sol = kn.simulate(eom, (0, span), q=[x0], u=[v0], **{"samples": 2, **more})
    assert sol.method in SMOOTH
    return sol


BEGIN = kn.parameter("begin", 1.0)
PULSE = line(kn.where(kn.less(BEGIN, t), kn.where(kn.less(t, BEGIN + 0.02), 50.0, 0.0), 0.0))


@pytest.mark.parametrize("at", [0.3, 1.0, 1.98])
def test_a_pulse_gives_its_impulse(at):
    """50 N over 20 ms, on a way that needs steps of seconds: 1 N s to 1e-12."""
    sol = kn.simulate(PULSE, (0, 4), q=[0], u=[0], parameters={BEGIN: at}, samples=2)
    assert sol.method == "dop853"
    assert sol["v"][-1] == pytest.approx(1, abs=1e-12)
    assert sol["x"][-1] == pytest.approx(4 - at - 0.01, abs=1e-12)
    assert sol.steps < 60


def test_a_pull_towards_a_place_is_parabola_after_parabola():
    """x'' = −2 sign x from rest at 1: a period of 4, the motion t², 1 − t² … put together."""
    sol = moved(line(-2 * kn.sign(x)), 40, 1, 0, samples=81, rtol=1e-12, atol=1e-12)
    phase = (sol.t + 1) % 4
    expected = np.where(phase < 2, 1 - (phase - 1) ** 2, (phase - 3) ** 2 - 1)
    assert sol["x"] == pytest.approx(expected, abs=1e-9)
    assert not sol.energy_check.exceeds(1e-10)


def test_friction_against_a_spring_swings_between_shifted_places():
    """Sliding friction of 3 N on 50 N/m from 0.5 m: each half swing is an arc about ±0.06, until it sticks at 0.02."""
    sol = moved(line(-50 * x - 3 * kn.sign(v)), 20, 0.5, 0.1)
    turn = np.hypot(0.56, 0.1 / 50**0.5) - 0.06  # where it turns first; each half swing ends 0.12 nearer
    assert sol.status == "stopped"
    assert (
        "sign(v) in the pull switches back and forth, as v reaches zero again and again. Declare friction"
        in sol.message
    )
    assert sol["x"][-1] == pytest.approx(turn % 0.12, abs=1e-8)
    assert abs(sol["v"][-1]) < 1e-9


def test_a_pulse_beside_friction_gives_its_impulse():
    """Ends at the times that are known beforehand, where another side of time begins, and at rest, where one of friction does."""
    force = kn.where(kn.less(BEGIN, t), kn.where(kn.less(t, BEGIN + 0.02), 50.0, 0.0), 0.0) - 0.1 * kn.sign(v)
    sol = moved(line(force), 4, 0, 2, parameters={BEGIN: 1.3})
    assert sol["v"][-1] == pytest.approx(2 + 1 - 0.4, abs=1e-11)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
@examples(0.1)
def test_barriers_anywhere_take_what_they_take(seed):
    """Up to four barriers, met one after the other, thin and wide, some overlapping: the energy is that left by each."""
    rng = np.random.default_rng(seed)
    at, wide, high = rng.uniform(0.5, 9, 4), 10 ** rng.uniform(-3, 0, 4), rng.uniform(0, 0.1, 4)
    sol = moved(LANE, 25, 0, 1, parameters=dict(zip(SYMBOLS, [*at, *wide, *high], strict=True)))
    assert sol["v"][-1] ** 2 / 2 == pytest.approx(0.5 - high.sum(), abs=1e-8)


def barrier(at, wide, high):
    """A force against the motion over a width, that takes an energy."""
    return -high / wide * kn.where(kn.less((x - at) ** 2, (wide / 2) ** 2), 1.0, 0.0)


SYMBOLS = (*kn.parameters("a1:5", 1.0), *kn.parameters("w1:5", 0.1), *kn.parameters("h1:5", 0.1))
LANE = line(sum(barrier(*(SYMBOLS[k + 4 * i] for i in range(3))) for k in range(4)))


@pytest.mark.slow
def test_a_wall_that_is_touched_alone_turns_nothing():
    """A ball thrown to just below, just to, and just above a place at which a load begins."""
    eom = line(-9.81 - 5 * kn.where(kn.less(2.0, x), 1.0, 0.0))
    for above in (-1e-6, 0.0, 1e-6):
        speed = (2 * 9.81 * (2 + above)) ** 0.5
        sol = moved(eom, 1, 0, speed)
        assert sol["x"][-1] == pytest.approx(speed - 9.81 / 2, abs=2e-3 if above > 0 else 1e-9)


def test_what_stays_at_a_switch_is_left_to_scipy():
    """At rest without a force sign(v) stays 0: nothing moves."""
    eom = line(-3 * kn.sign(v))
    sol = kn.simulate(eom, (0, 5), q=[1], u=[0], samples=3)
    assert sol.status == "finished"
    assert sol["x"] == pytest.approx([1, 1, 1])


def test_a_side_has_no_switches_left():
    """Signs, absolute values, comparisons, the larger of two: all are watched."""
    eom = line(kn.max(-x, 0) - abs(x) * kn.sign(v) + kn.where(kn.less(x, 1), x, 2))
    assert len(quantities(eom)) == 3


def test_events_are_met_beside_switches():
    eom = line(-2 * kn.sign(x), events=[kn.Event("half", x - 0.5, terminal=False), kn.Event("far", t - 6.5)])
    sol = moved(eom, 40, 1, 0)
    assert (sol.status, sol.event.name) == ("event", "far")
    half = 0.5**0.5
    assert [a for e, a in sol.events if e.name == "half"] == pytest.approx([half, 4 - half, 4 + half], abs=1e-9)


F = kn.input("F")
DRIVEN = line(F)


def test_an_input_that_switches_is_as_exact_as_a_load():
    """x'' = −5 sign x from rest at 1: parabolas with a period of 4 √(2/5)."""
    quarter = (2 / 5) ** 0.5
    sol = moved(DRIVEN, 9 * quarter, 1, 0, inputs={F: -5 * kn.sign(x)}, rtol=1e-12, atol=1e-12)
    assert sol.states[-1] == pytest.approx([0, -5 * quarter], abs=1e-11)
    assert sol.steps == moved(line(-5 * kn.sign(x)), 9 * quarter, 1, 0, rtol=1e-12, atol=1e-12).steps


def test_an_input_of_the_next_phase_that_switches():
    on = kn.Event("on", x, threshold=0.5, direction=-1, then={F: -5 * kn.sign(x)})
    sol = moved(line(F, events=[on]), 3, 1, 0, inputs={F: -1.0}, rtol=1e-12, atol=1e-12)
    speed, t1 = 6**0.5, 1 + (6**0.5 - 1) / 5  # at 0, where its energy is 3; from there it swings on with 4 √6/5
    left = (3 - t1) % (2 * speed / 5)
    assert sol["v"][-1] == pytest.approx((-1) ** ((3 - t1) // (2 * speed / 5) + 1) * (speed - 5 * left), abs=1e-11)


def test_an_input_that_turns_to_and_fro_is_named():
    sol = moved(DRIVEN, 20, 0.5, 0.1, inputs={F: -50 * x - 3 * kn.sign(v)})
    assert sol.status == "stopped"
    assert "sign(v) in the inputs switches back and forth, as v reaches zero again and again" in sol.message
    assert abs(sol["v"][-1]) < 1e-9


SIZES = st.floats(0.5, 5)
LAWS = st.sampled_from(
    [
        lambda a, b, c: -a * kn.sign(x - c),
        lambda a, b, c: kn.where(kn.less(x, c), a, -b),
        lambda a, b, c: -a * kn.sign(x) - b * kn.max(x, c),
        lambda a, b, c: -a * kn.sign(x - c) * abs(x),
        lambda a, b, c: -(a + b) * kn.sign(x) - b * kn.sign((x - c) * kn.sign(v)),
    ]
)


@given(LAWS, LAWS, SIZES, SIZES, st.floats(-0.5, 0.5), st.floats(-2, 2), st.sampled_from(["auto", "tsit5"]))
@examples(0.04, 4)
def test_random_laws_move_as_loads_and_as_inputs(one, other, a, b, c, v0, method):
    """Two laws in a load, or one of them as an input beside the other: the same motion, step for step."""
    first, second = one(a, b, c), other(b, a, -c)
    plain = kn.simulate(line(first + second), (0, 4), q=[1], u=[v0], method=method, samples=9)
    sol = kn.simulate(line(F + second), (0, 4), q=[1], u=[v0], method=method, samples=9, inputs={F: first})
    assert (sol.method, sol.status) == (plain.method, plain.status)
    np.testing.assert_allclose(sol.states, plain.states, rtol=1e-9, atol=1e-9)
    assert sol.keeps_energy


@given(st.floats(0.2, 2), st.floats(0.2, 2), st.floats(-0.4, 0.4), st.floats(-2, 2))
@examples(0.04, 4)
def test_switches_of_what_jumps(a, b, c, v0):
    """−(a + b) sign x − b sign((x − c) sign v) is −a sign x − b sign x − b sign(x − c) sign v."""
    nested = -(a + b) * kn.sign(x) - b * kn.sign((x - c) * kn.sign(v))
    plain = -(a + b) * kn.sign(x) - b * kn.sign(x - c) * kn.sign(v)
    ends = [kn.simulate(line(f), (0, 5), q=[1], u=[v0], samples=3) for f in (nested, plain)]
    np.testing.assert_allclose(ends[0].states, ends[1].states, atol=1e-8)


@pytest.mark.slow
def test_a_disk_slides_until_its_slip_is_gone():
    """Down to 1e-10 m/s; when, is known to 1e-9 from steps at 1e-13: worse than the motion, so that 1e-9 gives 5e-9 s."""
    model = rolling_disk.model()
    friction = kn.friction(model.Ch, model.normal, model.mu, name="friction", threshold=1e-10)
    eom = kn.derive(model.system.replace(loads=[kn.gravity(-model.g * model.N.z), friction]))
    start = {"q": [0, 0.1, 0, 0, 0], "u": [0, 2, 25, 2, 0], "parameters": {model.mu: 0.1}, "samples": 3}
    ends = [kn.simulate(eom, (0, 5), **start, rtol=tol, atol=tol) for tol in (1e-12, 1e-13)]
    for sol in ends:
        assert sol.method == "vern9"
        assert sol.event.name == "onset of rolling (friction)"
        assert sol[model.slip.magnitude()][-1] == pytest.approx(1e-10, rel=1e-4)
    assert ends[0].t[-1] == pytest.approx(ends[1].t[-1], abs=1e-9)
