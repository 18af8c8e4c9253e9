# SPDX-License-Identifier: BSD-3-Clause
"""Events within a step, steps that are bounded or end where they are told, pivots that vanish without a change of sign."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import kane as kn
from tests.examples import FULL, examples
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
v = kn.speed("v")
P = O.at("P", x * N.x)
F = kn.input("F")


def line(force=None, events=(), speed=None):
    """A particle of 1 kg on a line."""
    loads = [] if force is None else [kn.Force(P, force * N.x)]
    speeds = {v: x.dt if speed is None else speed}
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds=speeds, loads=loads, events=events))


class TestWithinAStep:
    def test_both_crossings_of_one_step_are_met(self):
        """x = t (2 − t) is above 0.9 between 1 ± √0.1, in one step of the many that are not needed."""
        eom = line(-2.0, [kn.Event("high", x, 0.9, terminal=False)])
        sol = kn.simulate(eom, (0, 2), q=[0], u=[2], rtol=1e-6, atol=1e-6)
        assert [t for _, t in sol.events] == pytest.approx([1 - np.sqrt(0.1), 1 + np.sqrt(0.1)], abs=1e-6)
        assert sol.steps < 10

    @pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5", "gauss16", "radau9", "RK45"])
    def test_every_close_passage_is_met(self, method):
        """|x| and √(x² + …) have a corner where x = 0: below 1e-7 they are for a moment, anywhere in a step."""
        distance, radius = kn.sqrt(x**2 + 1e-30), 1e-7
        near = [kn.Event("near", abs(x) - radius, direction=-1, terminal=False)]
        near += [kn.Event("close", distance - radius, direction=-1, terminal=False)]
        eom = line(-9 * x, [*near, kn.Event("zero", x, terminal=False)])
        for k in range(10 if method == "RK45" else 40):
            sol = kn.simulate(eom, (0, 3), q=[0.3 + 0.03 * k], u=[0], rtol=1e-6, atol=1e-8, method=method, samples=2)
            assert sorted(e.name for e, _ in sol.events) == ["close"] * 3 + ["near"] * 3 + ["zero"] * 3
            at = [t for e, t in sol.events if e.name == "near"]
            np.testing.assert_allclose(at, (np.arange(3) + 0.5) * np.pi / 3, rtol=0, atol=1e-4)

    @pytest.mark.parametrize("method", ["dop853", "tsit5", "gauss16"])
    def test_what_passes_where_a_force_switches_is_met_once(self, method):
        """v = 0 ends a slip, and turns its force: −x − 0.1 sign(v) swings until |x| < 0.1, −0.1 sign(v) brakes for 10 v s.

        From 1.101 m the last swing ends with 1e-3 m/s², so that the time is known less exactly than shares of the last steps.
        """
        swing = line(-x - 0.1 * kn.sign(v), [kn.Event("turns", v, terminal=False)])
        brake = line(-0.1 * kn.sign(v), [kn.Event("stands", v)])
        for k in range(16):
            sol = kn.simulate(swing, (0, 30), q=[0.501 + 0.04 * k], u=[0], method=method, samples=2)
            times = [t for _, t in sol.events]
            np.testing.assert_allclose(times, np.pi * np.arange(1, 4 + k // 5), rtol=0, atol=1e-5)
            sol = kn.simulate(brake, (0, 30), q=[0], u=[0.501 + k / 16], method=method, samples=2)
            assert (sol.status, len(sol.events)) == ("event", 1)
            assert sol.t[-1] == pytest.approx(5.01 + k / 1.6, abs=1e-7)

    @pytest.mark.grows
    @pytest.mark.parametrize("method", ["dop853", "gauss16", "tsit5"])
    @pytest.mark.parametrize("then", [{v: -5.0}, lambda t, q, u, parameters: {v: -5.0}])
    def test_an_event_at_a_switch_is_noted_once_before_an_action(self, method, then):
        """It was met where the switch turns; that its quantity passes a little later is no other event, whoever looks at that step."""
        c, at = kn.parameters("c at")
        events = [kn.Event("both", x - c, terminal=False), kn.Event("acts", kn.time - at, then=then)]
        eom = line(-kn.sign(x - c), events)
        rng = np.random.default_rng(0)
        for _ in range(40 if FULL else 12):
            a, place = float(10 ** rng.uniform(-2, 0.4)), float(rng.choice([0, 1.0, 37.3, 1e3]))
            soon = 4 * math.sqrt(2 * a) * (0.25 + 10 ** rng.uniform(-4, -1))
            values = {c: place, at: soon}
            sol = kn.simulate(eom, (0, soon + 0.01), q=[place + a], u=[0], parameters=values, method=method, samples=2)
            assert [e.name for e, _ in sol.events].count("both") == 1

    @pytest.mark.grows
    @pytest.mark.parametrize("method", ["dop853", "gauss16", "tsit5", "RK45"])
    @pytest.mark.parametrize("quantity", [x, kn.time])
    def test_the_end_of_a_span_is_the_same_whoever_looks(self, method, quantity):
        """Where an event comes with the end, but for rounding: by the first motion, by the next ones, by many, and never later."""
        level = kn.parameter("level", 1.0)
        eom = line(None, [kn.Event("there", quantity - level, then={v: -v})])
        alike = {"settings": kn.Settings(contract=False)} if method == "dop853" else {}  # lanes have the same bits
        for k in range(1, 40, 1 if FULL else 4):
            end = 0.1 * k / 3
            given = {"q": [0], "u": [1], "parameters": {level: end}, "method": method, "samples": 3, **alike}
            sols = [kn.simulate(eom, (0, end), **given) for _ in range(3)]
            assert len({(len(s.events), s.u[-1, 0], len(s)) for s in sols}) == 1
            assert {float(s.t[-1]) for s in sols} == {end}
        if method == "dop853":
            require("xarray")
            given |= {"q": [0], "u": {v: np.ones(8)}, "lanes": True}
            assert set(kn.simulate_many(eom, (0, end), **given)["v"].values[:, -1]) == {sols[0].u[-1, 0]}

    @pytest.mark.slow
    @pytest.mark.parametrize("seed", range(4))
    def test_random_levels_of_a_swing_are_met_as_often_as_they_are(self, seed):
        rng = np.random.default_rng(seed)
        levels = rng.uniform(-0.95, 0.95, 4)
        eom = line(-x, [kn.Event(f"level {k}", x, h, terminal=False) for k, h in enumerate(levels)])
        sol = kn.simulate(eom, (0, 30), q=[1], u=[0], rtol=1e-5, atol=1e-5, samples=2)
        assert max(np.diff([0.0, 30.0])) / sol.steps > 0.3  # long steps
        for k, h in enumerate(levels):
            found = [t for e, t in sol.events if e.name == f"level {k}"]
            first = np.arccos(h)
            turns = np.arange(6) * 2 * np.pi
            expected = np.sort(np.concatenate([turns + first, turns + 2 * np.pi - first]))
            np.testing.assert_allclose(found, expected[expected < 30], atol=2e-3)

    @pytest.mark.parametrize("method", ["gauss16", "dop853", "radau9", "RK45"])
    def test_what_is_met_at_the_end_is_met_once_and_not_later(self, method):
        level = kn.parameter("level", 1.0)
        eom = line(
            None, [kn.Event("there", x - level, terminal=False), kn.Event("up", x - level, direction=1, terminal=False)]
        )
        for k in range(1, 31):
            end = 0.1 * k / 3
            sol = kn.simulate(eom, (0, end), q=[0], u=[1], parameters={level: end}, method=method, samples=2)
            assert len({e.name for e, _ in sol.events}) == len(sol.events)
            assert all(t <= end for _, t in sol.events)


class TestSteps:
    def test_a_thin_barrier_is_seen_by_short_steps(self):
        """A wall of 1 mm that takes 0.005 J at a speed of 1 m/s: leapt over, or felt with max_step."""
        wall = kn.where(kn.less((x - 0.5) ** 2, 0.0005**2), -5.0, 0.0)
        sol = kn.simulate(line(wall), (0, 1), q=[0], u=[1], rtol=1e-6, atol=1e-6, max_step=2e-4, samples=3)
        assert sol["v"][-1] == pytest.approx(np.sqrt(1 - 2 * 0.005), abs=1e-4)
        assert sol.steps > 4000

    @pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"])
    def test_a_pulse_between_breakpoints(self, method):
        """1000 N for 1 ms gives 1 m/s, late on a long way without any force; nothing is lost and little is spent."""

        def pulse(t):
            return 1000.0 if 7.0 <= t < 7.001 else 0.0

        given = {"q": [0], "u": [0], "inputs": {F: pulse}, "method": method, "rtol": 1e-6, "atol": 1e-6, "samples": 3}
        sol = kn.simulate(line(F), (0, 10), breakpoints=[7.0, 7.001], **given)
        assert sol["v"][-1] == pytest.approx(1.0, abs=1e-5)
        assert sol["x"][-1] == pytest.approx(2.9995, abs=1e-4)
        assert sol.steps < 150
        assert sol.t[-1] == 10

    def test_breakpoints_in_any_order_and_beyond_the_span(self):
        plain = kn.simulate(line(-x), (0, 3), q=[1], u=[0], samples=4)
        sol = kn.simulate(line(-x), (0, 3), q=[1], u=[0], samples=4, breakpoints=[2, -1, 1, 1, 3, 9, 0])
        np.testing.assert_allclose(sol.states, plain.states, atol=1e-8)
        assert sol.status == "finished"

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"max_step": 0}, "Expected max_step > 0"),
            ({"max_step": "x"}, "max_step"),
            ({"breakpoints": [np.nan]}, "breakpoints at finite times"),
            ({"breakpoints": "soon"}, "Expected breakpoints as times"),
        ],
    )
    def test_errors(self, given, message):
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(line(), (0, 1), q=[0], u=[0], **given)


METHODS = ("gauss16", "dop853", "tsit5", "vern9", "DOP853", "Radau", "LSODA", "BDF")
ROOTS, POLES, RATE = kn.parameters("r1:4", 0.0), kn.parameters("p1:4", 0.0), kn.parameter("rate", 1.0)
RATIO = math.prod((x - r for r in ROOTS), start=1) / math.prod((x - p for p in POLES), start=1)
SWINGS = line(-(RATE**2) * x, [kn.Event("zero", RATIO, terminal=False)])


class TestPoles:
    """A change of sign through infinity is no crossing; through a jump it is."""

    @pytest.mark.parametrize("method", METHODS)
    def test_of_1_over_x_and_of_tan_x(self, method):
        events = [kn.Event("pole", 1 / (x - 2), terminal=False), kn.Event("tan", kn.tan(x), terminal=False)]
        sol = kn.simulate(line(None, events), (0, 6.5), q=[0.5], u=[1], method=method)
        assert [e.name for e, _ in sol.events] == ["tan", "tan"]
        assert [t for _, t in sol.events] == pytest.approx([np.pi - 0.5, 2 * np.pi - 0.5], abs=1e-9)

    @pytest.mark.parametrize("method", ["gauss16", "DOP853"])
    def test_a_pole_at_the_end_of_a_step(self, method):
        events = [kn.Event("pole", 1 / x, terminal=False), kn.Event("no value", kn.sin(x) / x**2, terminal=False)]
        sol = kn.simulate(line(None, events), (0, 2), q=[-1], u=[1], method=method, breakpoints=[1.0])
        assert sol.events == ()

    @pytest.mark.parametrize("method", ["gauss16", "DOP853"])
    def test_a_jump_across_the_threshold_is_met(self, method):
        """From −1 to 1, to a large value, and to one side of a pole."""
        beyond = kn.less(1, x)
        quantities = [kn.sign(x - 1), kn.where(beyond, 1e6, -1), kn.where(beyond, 1 / (x - 1), -1)]
        events = [kn.Event(f"jump {k}", c, direction=1, terminal=False) for k, c in enumerate(quantities)]
        sol = kn.simulate(line(None, events), (0, 2), q=[0], u=[1], method=method)
        assert [t for _, t in sol.events] == pytest.approx([1, 1, 1], abs=1e-9)

    @given(
        st.lists(st.floats(-0.95, 0.95), min_size=6, max_size=6),
        st.floats(-2, 2),
        st.sampled_from(METHODS),
    )
    @examples(0.06, 2)
    def test_random_roots_among_random_poles(self, places, exponent, method):
        """Every root of a rational quantity of x = cos(ω t), and none of its poles."""
        assume(np.diff(np.sort(places)).min() > 1e-3)
        rate, values = 10.0**exponent, dict(zip((*ROOTS, *POLES), places, strict=True))
        given = {
            "q": [1],
            "u": [0],
            "parameters": {RATE: rate, **values},
            "method": method,
            "rtol": 1e-9,
            "atol": 1e-11,
        }
        sol = kn.simulate(SWINGS, (0, 7 / rate), samples=2, **given)
        first = np.arccos(places[:3])
        times = np.sort(np.concatenate([first, 2 * np.pi - first, 2 * np.pi + first]))
        times = times[times < 7]
        assert len(sol.events) == len(times)
        np.testing.assert_allclose([t * rate for _, t in sol.events], times, atol=1e-4)


SLOW = pytest.mark.slow


class TestVanishingPivots:
    """u = xⁿ x' and no force: x = t − 1, which has no rate by u at t = 1. A motion ends there, and none is wrong."""

    @pytest.mark.slow
    @pytest.mark.parametrize("power", [1, 2, 3, 4])
    @pytest.mark.parametrize(
        "method", ["DOP853", "Radau", *(pytest.param(m, marks=SLOW) for m in ("RK23", "RK45", "BDF", "LSODA"))]
    )
    @pytest.mark.parametrize("tolerance", [1e-6, pytest.param(1e-9, marks=SLOW), pytest.param(1e-4, marks=SLOW)])
    def test_none_is_passed(self, power, method, tolerance):
        eom = line(speed=x**power * x.dt)
        given = {"method": method, "rtol": tolerance, "atol": tolerance, "samples": 5}
        sol = kn.simulate(eom, (0, 3), q=[-1], rates={x: 1.0}, max_steps=5000, **given)
        assert sol.status in ("event", "stopped")
        assert "W of q' = W u + X divides by x" in sol.message
        assert sol.t[-1] == pytest.approx(1, abs=0.05)
        np.testing.assert_allclose(sol["x"][:2], sol.t[:2] - 1, atol=1e3 * tolerance)
        np.testing.assert_allclose(sol["x"][-1], sol.t[-1] - 1, atol=0.05)

    def test_a_pivot_that_is_small_without_vanishing(self):
        """u = (x² + c²) x' is regular everywhere, however small c is beside the rest of the way."""
        eom = line(speed=(x**2 + 1e-3**2) * x.dt)
        sol = kn.simulate(eom, (0, 3), q=[-1], rates={x: 1.0}, rtol=1e-11, atol=1e-13, samples=5)
        assert sol.status == "finished"
        np.testing.assert_allclose(sol["x"], sol.t - 1, atol=1e-4)

    def test_by_areal_velocity_through_the_pole(self):
        """u = r² θ' of a particle that passes the pole at 1e-4 of where it comes from goes on; through the pole there is no θ."""
        (r, th), (w, s) = kn.coordinates("r th"), kn.speeds("w s")
        R = N.rotate("R", th, N.z)
        p = O.at("p", r * R.x)
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", p, 1)], speeds={w: r**2 * th.dt, s: r.dt}))
        far = kn.simulate(eom, (0, 2), q=[1, 0], u=[1e-2, -1], rtol=1e-10, atol=1e-10, samples=3)
        assert far.status == "finished"
        np.testing.assert_allclose(far["r"], np.hypot(1 - far.t, 1e-2 * far.t), atol=1e-7)
        through = kn.simulate(eom, (0, 2), q=[1, 0], u=[0, -1], samples=3)
        assert through.status == "event"
        assert "divides by r^2" in through.message
