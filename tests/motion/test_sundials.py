# SPDX-License-Identifier: BSD-3-Clause
"""CVODE as a method: closed forms, a stiff chain, and what a motion looks after along its steps."""

import sys

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import cvode, exact, pattern, routines
from tests.motion.test_stiff import chain, derived
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
P = O.at("P", x * N.x)
F = kn.input("F")


def line(force, events=()):
    """A particle of 1 kg on a line."""
    loads = [kn.Force(P, force * N.x)]
    return kn.derive(
        kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={kn.speed("v"): x.dt}, loads=loads, events=events)
    )


def test_without_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "sksundae", None)
    monkeypatch.setitem(sys.modules, "sksundae.cvode", None)
    with pytest.raises(
        kn.SimulationError, match=r"package scikit-sundae .* pip install 'kane\[stiff\]', or use method=\"radau9\""
    ):
        kn.simulate(line(-x), (0, 1), q=[1], u=[0], method="cvode")


def test_a_polynomial_of_a_step_is_exact_to_order_5():
    c = np.random.default_rng(1).normal(size=(6, 3))
    t = 2.0 + 0.3 * cvode._SHARES
    along = cvode.Polynomial(2.0, 2.3, np.vander(t, 6) @ c)
    at = np.linspace(2.0, 2.3, 17)
    np.testing.assert_allclose(along(at).T, np.vander(at, 6) @ c, atol=1e-11)
    np.testing.assert_allclose(along(2.1), (np.vander([2.1], 6) @ c)[0], atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["double_pendulum", "rolling_disk", "four_bar", "flyball_governor"])
def test_the_pattern_holds_all_derivatives_that_are_not_zero(name, rng):
    eom = kn.derive(load(name).system())
    now = routines(eom, np.array([p.default or 1.0 for p in eom.parameters]), [lambda t: 0.4] * len(eom.inputs), None)
    found = pattern(now)
    for _ in range(3):
        y = rng.uniform(0.3, 1.1, size=now.width + 1)
        assert found[exact(now)(0.2, y) != 0].all()
    assert not found[:, -1].any()


def test_the_pattern_of_a_chain_is_that_of_its_neighbours():
    """q̇ and u̇ of four masses in a row: each depends on its own and its neighbours' states, the power on all."""
    now = routines(derived(), np.array([1e6, 1.0]), [], None)
    near = np.abs(np.subtract.outer(range(4), range(4))) <= 1
    found = pattern(now)
    assert not found[:4, :4].any()
    assert (found[4:8, :4] == near).all()
    assert (found[4:8, 4:8] == near).all()


class TestInstalled:
    @pytest.fixture(autouse=True)
    def _there(self):
        require("sksundae")

    @pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-11])
    def test_an_oscillation(self, tolerance):
        """x = cos t, between the steps too."""
        sol = kn.simulate(line(-x), (0, 10), q=[1], u=[0], method="cvode", rtol=tolerance, atol=tolerance)
        assert (sol.method, sol.status, len(sol)) == ("cvode", "finished", 501)
        assert np.abs(sol["x"] - np.cos(sol.t)).max() < 200 * tolerance
        assert sol.steps < sol.evaluations < 3 * sol.steps

    @pytest.mark.slow
    @pytest.mark.parametrize("sparse", [False, True])
    def test_a_stiff_chain(self, sparse, monkeypatch):
        """Rates of 1e6 /s; J as a whole and by its entries give the same steps, and Radau's the same motion to 1e-7."""
        if sparse:
            monkeypatch.setattr(cvode, "_LARGE", 1)
            monkeypatch.setattr(cvode, "_SPARSE", 1.0)
        given = {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 6}
        own = kn.simulate(derived(), (0, 5), **given, method="cvode", rtol=1e-12, atol=1e-19)
        for method, tolerance in (("radau9", 1e-9), ("Radau", 1e-9)):
            other = kn.simulate(derived(), (0, 5), **given, method=method, rtol=tolerance, atol=1e-13)
            assert own.q == pytest.approx(other.q, abs=1e-7 * np.abs(other.q).max())
        assert own.steps < 1000

    def test_feedback_is_differentiated(self):
        f = kn.input("F")
        eom, given = derived(f), {"q": [0.0] * 4, "u": [0.0] * 4, "samples": 3}
        law = -1e5 * (x_of(eom) + eom.speeds[3])
        own = kn.simulate(eom, (0, 0.5), **given, inputs={f: law}, method="cvode", rtol=1e-10, atol=1e-16)
        other = kn.simulate(eom, (0, 0.5), **given, inputs={f: law}, method="radau9", rtol=1e-10, atol=1e-16)
        assert own.q == pytest.approx(other.q, abs=1e-6 * np.abs(other.q).max())
        assert own.steps < 500

    @pytest.mark.slow
    def test_constraints_are_kept(self):
        module = load("four_bar")
        eom = kn.derive(module.system())
        found = kn.assemble(eom, q={eom.coordinates[0]: 1.0}, u={eom.speeds[0]: 3.0})
        given = {"q": found.q, "u": found.u, "rtol": 1e-10, "atol": 1e-10, "samples": 50}
        own, other = (kn.simulate(eom, (0, 2), **given, method=m) for m in ("cvode", "DOP853"))
        assert max(np.abs(r).max() for r in own.constraint_residuals.values()) < 1e-10
        np.testing.assert_allclose(own.q, other.q, atol=1e-6)
        assert own.keeps_energy

    def test_events_are_located_and_act(self):
        """A ball that bounces: t of the nth bounce in closed form; two crossings within a step are both met."""
        g, e = 9.81, 0.8
        bounce = kn.Event("bounce", x, direction=-1, then={kn.speed("v"): -e * kn.speed("v")})
        high = kn.Event("high", x, 0.9, terminal=False)
        sol = kn.simulate(line(-g, [bounce, high]), (0, 1.9), q=[1], u=[0], method="cvode", rtol=1e-9, atol=1e-9)
        first = np.sqrt(2 / g)
        times = [t for event, t in sol.events if event.name == "bounce"]
        assert times == pytest.approx([first, first * (1 + 2 * e), first * (1 + 2 * e + 2 * e * e)], abs=1e-7)
        assert next(t for event, t in sol.events if event.name == "high") == pytest.approx(np.sqrt(0.2 / g), abs=1e-7)

    def test_a_pulse_between_breakpoints(self):
        eom = line(F)
        force = 1000 * kn.where(kn.less(kn.time, 30), 0.0, kn.where(kn.less(kn.time, 30.001), 1.0, 0.0))
        sol = kn.simulate(eom, (0, 100), q=[0], u=[0], inputs={F: force}, method="cvode", samples=3)
        assert sol["v"][-1] == pytest.approx(1, abs=1e-8)

    def test_steps_that_are_bounded(self):
        sol = kn.simulate(line(-x), (0, 1), q=[1], u=[0], method="cvode", max_step=1e-3, samples=2)
        assert sol.steps >= 1000
        sol = kn.simulate(line(-x), (0, 1), q=[1], u=[0], method="cvode", max_steps=7)
        assert (sol.status, sol.steps) == ("stopped", 7)
        assert "7 steps were not enough" in sol.message
        first = kn.simulate(line(-x), (0, 1), q=[1], u=[0], method="cvode", first_step=1e-7)
        assert first.status == "finished"

    def test_a_right_hand_side_that_becomes_infinite(self):
        """v' = v² from 1: infinite at t = 1."""
        v = kn.speed("v")
        sol = kn.simulate(line(v * v), (0, 2), q=[0], u=[1], method="cvode")
        assert sol.status == "stopped"
        assert "singular or not finite near t = 1" in sol.message

    def test_an_exception_in_an_input_is_raised(self):
        def broken(t):
            if t > 0.5:
                raise ZeroDivisionError("mine")
            return 0.0

        with pytest.raises((ZeroDivisionError, kn.SimulationError), match="mine"):
            kn.simulate(line(F), (0, 1), q=[0], u=[1], inputs={F: broken}, method="cvode")

    def test_an_exception_in_a_function_of_the_state_is_raised(self):
        """With its place: a solver that fails is another thing."""
        with pytest.raises(kn.SimulationError, match=r"got KeyError from it at t = (0\.[5-9]\d*|1), x = \["):
            kn.simulate(
                line(F), (0, 1), q=[0], u=[1], inputs={F: lambda t, x: {}["a"] if t > 0.5 else 0.0}, method="cvode"
            )

    def test_motions_go_on_and_tell_of_their_errors(self):
        eom = line(-x)
        sol = kn.simulate(eom, (0, 1), q=[1], u=[0], method="cvode")
        more = kn.simulate(eom, 3, start=sol)
        assert more.method == "cvode"
        assert (sol + more)["x"][-1] == pytest.approx(np.cos(3), abs=1e-6)
        found = sol.accuracy()
        assert 0.1 < found.relative / (np.abs(sol["x"] - np.cos(sol.t)).max()) < 10


def x_of(eom):
    """The first coordinate."""
    return eom.coordinates[0]


def test_it_is_one_of_the_methods():
    with pytest.raises(kn.SimulationError, match=r"radau9.*LSODA, cvode, got 'CVODES'"):
        kn.simulate(chain(), (0, 1), q=[0] * 4, u=[0] * 4, method="CVODES")
