# SPDX-License-Identifier: BSD-3-Clause
"""Motions with contacts from mode to mode in a kernel are those that Python decides, and Python is not asked between start and end."""

from __future__ import annotations

import importlib
import math
import time
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery.contacts import (
    ball_on_turntable,
    bouncing_ball,
    mass_on_belt,
    rocking_block,
    shaken_block,
    slider_crank_with_clearance,
)
from kane.motion import ContactMotion, ContactRunner
from kane.progress import Interrupted
from tests.examples import examples
from tests.laws.test_contacts import started
from tests.motion import test_contact_friction as friction
from tests.motion.many.separate import simulated_separately
from tests.oracles.planar_contacts import Plane, Plate, Support, Touch
from tests.systems.planar_contacts import model, planes, system

TIGHT = {"rtol": 1e-10, "atol": 1e-11}
SPANS = {
    "bouncing_ball": 5,
    "clutch": 5,
    "mass_on_belt": 20,
    "painleve_rod": 1,
    "skidding_disk": 2,
    "thrown_disk": 3,
    "woodpecker": 1,
}


@pytest.fixture
def decisions(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The events after which Python has decided."""
    asked, own = list[str](), ContactMotion.after

    def after(self: Any, t: float, x: Any, now: Any, event: kn.Event) -> Any:
        asked.append(event.name)
        return own(self, t, x, now, event)

    monkeypatch.setattr(ContactMotion, "after", after)
    return asked


@pytest.fixture
def separate(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The instances that were simulated separately."""
    return simulated_separately(monkeypatch)


def by_python(eom: kn.Equations, *args: Any, **options: Any) -> kn.Solution:
    """The motion with every mode chosen by Python."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("place", "start", "leads"):
            patch.setattr(ContactRunner, name, lambda *_: None)
        return kn.simulate(eom, *args, **options)


def begun(own: Any, starts: list[float]) -> Any:
    """`begin` of a motion that notes that it was asked."""

    def begin(self: Any, t: float, x: Any) -> Any:
        starts.append(t)
        return own(self, t, x)

    return begin


def agree(one: kn.Solution, other: kn.Solution, exact: float) -> None:
    """The same modes at the same times, events, samples and states."""
    assert (one.status, one.message) == (other.status, other.message)
    assert [m for _, m in one.mode_history] == [m for _, m in other.mode_history]
    assert [e.name for e, _ in one.events] == [e.name for e, _ in other.events]
    assert len(one.t) == len(other.t)
    for a, b in ((one.t, other.t), (one.states, other.states), (one.work, other.work)):
        np.testing.assert_allclose(a, b, rtol=0, atol=exact * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize("name", SPANS)
def test_the_gallerys_motions_are_those_that_python_decides(
    name: str, decisions: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = importlib.import_module(f"kane.gallery.contacts.{name}")
    eom = kn.derive(module.system())
    options: dict[str, Any] = {**module.START, **TIGHT}
    wanted = by_python(eom, (0, SPANS[name]), **options)
    assert decisions
    decisions.clear()
    starts: list[float] = []
    monkeypatch.setattr(ContactMotion, "begin", begun(ContactMotion.begin, starts))
    first = kn.simulate(eom, (0, SPANS[name]), **options)
    again = kn.simulate(eom, (0, SPANS[name]), **options)
    assert decisions == []  # what is not known is compiled, and goes on as it was decided
    assert len(starts) == 1  # of the first call
    agree(first, wanted, 1e-9)
    agree(again, first, 0.0)


def test_bits_are_the_same_whatever_ran_before() -> None:
    """Blocks that rock: alone, one after the other the other way round, after one that cannot start, and together on threads."""
    eom, made = kn.derive(rocking_block.system()), kn.derive(rocking_block.system())
    thrown, q = np.linspace(-0.4, 0.4, 12), rocking_block.START["q"]
    options: dict[str, Any] = {"samples": 3, **TIGHT}

    def ends(eom: kn.Equations, speeds: Any) -> list[Any]:
        starts = ({"u_x": w, "u_y": 0.0, "u_theta": w} for w in speeds)
        return [kn.simulate(eom, (0, 1.5), q=q, u=u, **options).states[-1] for u in starts]

    alone = ends(eom, thrown)
    with pytest.raises(kn.SimulationError, match="at or above zero"):
        kn.simulate(made, (0, 1.5), q={**q, "y": 0.5}, u=[0.0, 0.0, 0.0], **options)
    assert np.array_equal(alone, ends(made, thrown[::-1])[::-1])
    speeds = {"u_x": thrown, "u_y": 0.0, "u_theta": thrown}
    many = kn.simulate_many(kn.derive(rocking_block.system()), (0, 1.5), q=q, u=speeds, threads=2, **options)
    assert np.array_equal(alone, many["end_state"])


def test_friction_that_turns_at_a_time_of_each_motion(decisions: list[str]) -> None:
    """A block thrown along a floor that becomes smoother at t1, beyond the span or within it: v = v0 − μ g t1 − ν g (t − t1)."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y", "m")
    m, g, turns = kn.parameter("m", 1.0, "kg"), kn.parameter("g", 9.81, "m/s^2"), kn.parameter("t1", 1.0, "s")
    P = O.at("P", x * N.x + y * N.y)
    place = kn.joints.point_on_plane("floor", P, O, normal=N.y)
    floor = kn.contact(place, kn.where(kn.less(kn.time, turns), 0.3, 0.1))
    block = kn.System(
        N, bodies=[kn.Particle("block", P, m)], speeds="rates", loads=[kn.gravity(-g * N.y)], contacts=[floor]
    )
    eom, times = kn.derive(block), np.tile([5.0, 0.3, 0.6, 0.9], 8)
    start: dict[str, Any] = {"q": {"x": 0, "y": 0}, "u": {"u_x": 4.0, "u_y": 0}, **TIGHT}
    many = kn.simulate_many(eom, (0, 1), parameters={"t1": times}, samples=3, threads=1, **start)
    early = np.minimum(times, 1)
    np.testing.assert_allclose(many["u_x"][:, -1], 4 - 9.81 * (0.3 * early + 0.1 * (1 - early)), rtol=1e-12)
    each = [kn.simulate(eom, (0, 1), parameters={"t1": t}, samples=3, **start).states[-1] for t in times[:4]]
    assert np.array_equal(many["end_state"], np.tile(each, (8, 1)))
    assert decisions == []
    sol = kn.simulate(eom, (0, 5), parameters={"t1": 0.5}, samples=3, **start)
    assert decisions == []
    assert sol.mode_history[-1][0] == pytest.approx(0.5 + (4 - 0.3 * 9.81 * 0.5) / (0.1 * 9.81), abs=1e-9)


@pytest.mark.parametrize("run", [kn.simulate, by_python])
def test_as_many_steps_as_were_asked_for_and_no_more(run: Any) -> None:
    eom = kn.derive(mass_on_belt.system())
    whole = run(eom, (0, 20), **mass_on_belt.START)
    assert len(whole.mode_history) > 20
    for most in (2, 10, 40, whole.steps - 1):
        sol = run(eom, (0, 20), **mass_on_belt.START, max_steps=most)
        assert (sol.status, sol.steps) == ("stopped", most)
        assert sol.message.startswith(f"{most} steps were not enough")
    assert run(eom, (0, 20), **mass_on_belt.START, max_steps=whole.steps).status == "finished"


BESIDE_ONE_THAT_RESTS = Plane(
    0.5,
    (Plate(0.5, 1.0), Plate(2.0, 0.3, ((0.2, 0.4), (0.5, -0.4)))),
    (
        Touch(0, (0.3, -0.5), kinetic=0.1, static=0.4, restitution=0.5),
        Touch(1, (0.2, -0.2), 0.3, kinetic=0.5, static=0.5, restitution=0.2),
        Touch(0, (0.3, 0.0), stops="a", restitution=0.2),
    ),
)
"""A corner and a stop rebound by turns, ever lower; where the corner comes to rest the stop falls onto it a last time."""


def test_what_rebounds_beside_one_that_rests_does_not_hop() -> None:
    eom = kn.derive(system(BESIDE_ONE_THAT_RESTS, "poisson"))
    q = [-0.003367546485025019, 0.5903493197695717, -0.1551347066200971, -0.022251072607077316]
    u = [1.2719321377014239, 1.0924679696631143, -0.7220543862094954, 0.7047413712900338]
    for run in (kn.simulate, by_python):
        sol = run(eom, (0, 0.43), q=q, u=u, **TIGHT)
        assert sol.status == "finished"
        names = [e.name for e, _ in sol.events]
        assert names[names.index("c0 rests") + 1 :] == ["c2 closes", "c2 rests"]
        assert sol.modes["c2"][-1] == "closed"


@examples(0.15)
@given(planes(), st.integers(0, 2**32), st.sampled_from(["stronge", "poisson", "newton", "moreau"]))
def test_random_motions_are_those_that_python_decides(plane: Any, seed: int, law: str) -> None:
    eom = kn.derive(system(plane, law))
    q, u = started(plane, eom, np.random.default_rng(seed))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # that Newton's law gains energy, of both
        one, other = (run(eom, (0, 1.0), q=q, u=u, **TIGHT) for run in (kn.simulate, by_python))
    assert [m for _, m in one.mode_history] == [m for _, m in other.mode_history]
    np.testing.assert_allclose(one.states[-1], other.states[-1], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_a_foot_slips_as_that_of_another_body_for_an_instant() -> None:
    """Where the pin between them passes the floor, both feet have one row of W, and b tells that one slips on."""
    first, second = {"kinetic": 0.53, "static": 0.71, "restitution": 0.33}, {"kinetic": 0.16, "static": 0.16}
    touches = (
        Touch(0, (0.16, -0.37), **first),
        Touch(0, (-0.51, -0.52), **first),
        Touch(1, (0.22, -0.27), **second, restitution=0.5),
    )
    plates = (Plate(2.26, 0.91), Plate(0.69, 0.37, ((0.47, 0.25), (0.04, 0.16))))
    own = model(plane := Plane(-0.07, plates, touches, Support((0.15, 2.0), (0.08, 6.0), -0.23)), "moreau")
    q, u = [-0.262, 0.671, 0.225, 0.059], [-0.905, -0.158, -0.861, -1.37]
    given: dict[str, Any] = {"q": q, "u": u, "parameters": own.values(plane), **TIGHT}
    sol = kn.simulate(own.eom, (0, 1.5), **given)
    at = np.searchsorted(sol.t, next(t for e, t in sol.events if e.name == "c2 sticks"))
    assert (sol.modes["c0"][at], sol.modes["c2"][at + 3]) == ("stick", "slip")
    for c in own.eom.system.contacts:
        assert np.abs(sol[c.slips[0].expr][sol.modes[c.name] == "stick"]).max(initial=0) < 1e-12
    agree(sol, by_python(own.eom, (0, 1.5), **given), 1e-7)


def test_what_lands_lies_and_leaves_flat_is_decided_in_the_kernel(decisions: list[str]) -> None:
    """Two corners of a slider hit, rest and open at one instant; at a dead centre N and F are not determined, and Python is asked."""
    module = slider_crank_with_clearance
    eom = kn.derive(module.system())
    options: dict[str, Any] = {**module.START, **TIGHT}
    wanted = by_python(eom, (0, 0.05), **options)
    assert len(decisions) > 25
    kn.simulate(eom, (0, 0.05), **options)
    decisions.clear()
    sol = kn.simulate(eom, (0, 0.05), **options)
    assert decisions == ["bottom 2 sticks"]
    (t,) = (t for e, t in sol.events if e.name == "bottom 2 sticks")
    k = int(np.searchsorted(sol.t, t))
    assert np.sin(sol["theta_1"][k] - sol["theta_2"][k]) == pytest.approx(0, abs=1e-9)  # crank and rod are in line
    assert len(sol.events) > 30
    assert [m for _, m in sol.mode_history] == [m for _, m in wanted.mode_history]
    np.testing.assert_allclose([t for t, _ in sol.mode_history], [t for t, _ in wanted.mode_history], rtol=0, atol=1e-9)
    np.testing.assert_allclose(sol.states[-1], wanted.states[-1], rtol=0, atol=1e-6)


def test_a_belt_for_a_thousand_seconds(decisions: list[str]) -> None:
    """1,248 changes of mode by the closed form, of which Python has decided none."""
    eom = kn.derive(mass_on_belt.system())
    sol = kn.simulate(eom, (0, 1000), **mass_on_belt.START, rtol=1e-12, atol=1e-13)
    assert decisions == []
    k, m, g, v = 25.0, 1.0, 9.81, 0.2
    delta, w = (0.4 - 0.2) * m * g / k, np.sqrt(k / m)
    sticks, slips = 2 * delta / v, (np.pi + 2 * np.arctan(v / (w * delta))) / w
    first = 0.4 * m * g / k / v
    begins = [t for t, modes in sol.mode_history if modes["belt"] == "slip"]
    expected = first + (sticks + slips) * np.arange(len(begins))
    np.testing.assert_allclose(begins, expected, rtol=0, atol=1e-9)


def test_other_parameters_and_threads_have_arrays_of_their_own() -> None:
    from concurrent.futures import ThreadPoolExecutor

    eom = kn.derive(bouncing_ball.system())
    options: dict[str, Any] = {"q": bouncing_ball.START["q"], "u": bouncing_ball.START["u"], **TIGHT}
    e = next(p for p in eom.parameters if p.name == "e")

    def end(value: float) -> Any:
        return kn.simulate(eom, (0, 3), parameters={e: value}, **options).states[-1]

    values = [0.1 * k for k in range(1, 9)] * 3
    alone = [end(value) for value in values]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(end, values))
    assert np.array_equal(alone, together)
    wanted = [by_python(eom, (0, 3), parameters={e: value}, **options).states[-1] for value in values[:8]]
    np.testing.assert_allclose(alone[:8], wanted, rtol=0, atol=1e-9)


def test_inputs_that_are_expressions(decisions: list[str]) -> None:
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y", "m")
    m, g, F = kn.parameter("m", 1.0, "kg"), kn.parameter("g", 9.81, "m/s^2"), kn.input("F", "N")
    P = O.at("P", x * N.x + y * N.y)
    place = kn.joints.point_on_plane("floor", P, O, normal=N.y)
    loads = [kn.gravity(-g * N.y), kn.Force(P, F * N.x)]
    block = kn.System(
        N,
        bodies=[kn.Particle("block", P, m)],
        speeds="rates",
        loads=loads,
        contacts=[kn.contact(place, 0.3, static=0.35)],
    )
    eom = kn.derive(block)
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "inputs": {"F": 5 * kn.sin(3 * kn.time)}, **TIGHT}
    wanted = by_python(eom, (0, 20), **options)
    decisions.clear()
    agree(kn.simulate(eom, (0, 20), **options), wanted, 1e-9)
    assert decisions == []
    assert len(wanted.mode_history) > 30


def pushed(mu: Any = 0.5, brake: Any = 0.0) -> kn.Equations:
    """A block on a floor, which inputs F push along it and H lift, against a force."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y", "m")
    g, F, H = kn.parameter("g", 9.81, "m/s^2"), kn.input("F", "N"), kn.input("H", "N")
    P = O.at("P", x * N.x + y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), mu)
    loads = [kn.gravity(-g * N.y), kn.Force(P, (F - brake) * N.x + H * N.y)]
    bodies = [kn.Particle("block", P, kn.parameter("m", 2.0, "kg"))]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[floor]))


STEP = kn.where(kn.less(kn.time, 1), 2.0, 15.0)
PULSE = kn.where(kn.less(kn.time, 1), 2.0, kn.where(kn.less(kn.time, 1.3), 40.0, 0.0))
LIFTED = kn.where(kn.less(kn.time, 1.2), 0.0, kn.where(kn.less(kn.time, 1.5), 30.0, 0.0))
SQUARE = 14 * kn.sign(kn.sin(2 * np.pi * kn.time))


OPTIONS: list[dict[str, Any]] = [{}, {"breakpoints": [0.37, 1.7]}, {"first_step": 1e-4}, {"max_seconds": 1e3}]
DRIVES = {
    "step": (STEP, 0.0),
    "pulse": (PULSE, 0.0),
    "sine": (12 * kn.sin(3 * kn.time), LIFTED),
    "square": (SQUARE, 0.0),
}


@pytest.mark.parametrize(
    ("inputs", "more"),
    [
        pytest.param(f, more, id=f"{name}-{more}", marks=pytest.mark.slow if more and name != "pulse" else ())
        for name, f in DRIVES.items()
        for more in OPTIONS
    ],
)
def test_breakpoints_first_steps_and_clocks_are_the_kernels(inputs: Any, more: Any, decisions: list[str]) -> None:
    eom = pushed()
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "inputs": dict(zip("FH", inputs, strict=True)), "samples": 31}
    one = kn.simulate(eom, (0, 3), **options, **more, **TIGHT)
    assert decisions == []
    other = by_python(eom, (0, 3), **options, **more, **TIGHT)
    assert decisions
    agree(one, other, 1e-9)
    assert one.steps == other.steps


def pulled(t: float, x: Any = None) -> float:
    return 15 * math.sin(3 * t) - (0.0 if x is None else 0.3 * x[2])


def lifted(t: float, x: Any = None) -> float:
    return 25 * math.sin(5 * t)


def both(t: float, x: Any, z: float) -> Any:
    return (15 * math.sin(3 * t) - 0.3 * (z + x[0]), lifted(t)), z + x[0]


def breaks(t: float, x: Any) -> float:
    if t > 1.7:
        raise ValueError("no more")
    return pulled(t, x)


@pytest.mark.parametrize(
    "inputs",
    [
        {"F": lambda t: pulled(t), "H": lambda t: lifted(t)},
        {"F": kn.signal(np.linspace(0, 3, 40), 14 * np.sin(3 * np.linspace(0, 3, 40))), "H": 0.0},
        {"F": lambda t, x: pulled(t, x), "H": 25 * kn.sin(5 * kn.time)},
        {"F": kn.sampled(pulled, 0.01), "H": kn.sampled(lifted, 0.07)},
        {"F": kn.sampled(pulled, 0.05), "H": lambda t: lifted(t)},
        {("F", "H"): kn.sampled(both, 0.02, state=0.0)},
    ],
    ids=["time", "signal", "state", "controllers", "controller and time", "controller with a state"],
)
def test_inputs_that_python_evaluates(inputs: Any, decisions: list[str]) -> None:
    eom = pushed()
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "inputs": inputs, "samples": 31, **TIGHT}
    one = kn.simulate(eom, (0, 3), **options)
    assert decisions == []
    assert len(one.mode_history) > 5
    agree(one, by_python(eom, (0, 3), **options), 1e-7)


@pytest.mark.parametrize("input_", [breaks, kn.sampled(breaks, 0.01)], ids=["function", "controller"])
def test_an_exception_in_an_input_loses_nothing_before(input_: Any) -> None:
    eom, inputs = pushed(), {"F": input_, "H": 25 * kn.sin(5 * kn.time)}
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "inputs": inputs, "samples": 31, **TIGHT}
    one = kn.simulate(eom, (0, 3), **options)
    assert one.status == "stopped"
    assert "ValueError" in one.message
    assert 1 < one.t[-1] < 1.7
    agree(one, by_python(eom, (0, 3), **options), 1e-9)


def test_a_controller_is_called_once_at_each_instant_also_where_python_repeats_a_mode() -> None:
    """A kernel of a mode returns after LIMIT steps, and Python runs that mode again from its beginning."""
    eom, calls = pushed(), list[float]()

    def pushes(t: float, x: Any) -> float:
        calls.append(t)
        return pulled(t, x)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("kane.motion.contact_runner.LIMIT", 20)
        options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "samples": 31, **TIGHT}
        sol = kn.simulate(eom, (0, 3), inputs={"F": kn.sampled(pushes, 0.01), "H": 0.0}, **options)
    np.testing.assert_allclose(calls, np.arange(len(calls)) * 0.01, rtol=1e-12)
    assert len(calls) >= 300
    other = kn.simulate(eom, (0, 3), inputs={"F": kn.sampled(pulled, 0.01), "H": 0.0}, **options)
    assert sol.steps > 20 * len(sol.mode_history)
    agree(sol, other, 1e-9)


@pytest.mark.parametrize("more", [{}, {"parameters": {"m": 5.0}}], ids=str)
def test_a_motion_that_goes_on_asks_its_controllers_anew(more: Any) -> None:
    """The kernel was ahead of the step at which the motion stopped, with other values of controllers and their states."""
    eom = pushed()
    inputs = {("F", "H"): kn.sampled(both, 0.01, state=0.0)}
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "samples": 31, "max_steps": 57, **TIGHT}

    def ends(run: Any) -> list[Any]:
        sol = run(eom, (0, 3), inputs=inputs, **options)
        assert (sol.status, sol.steps) == ("stopped", 57)
        return [run(eom, 2, start=sol, **more).states[-1] for _ in range(2)]

    one, again = ends(kn.simulate)
    assert np.array_equal(one, again)
    np.testing.assert_allclose(one, ends(by_python)[0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("period", [0.0, 0.01], ids=["function", "controller"])
@pytest.mark.parametrize("error", [SystemExit, KeyboardInterrupt, Interrupted, TimeoutError])
def test_an_exception_that_an_input_raises_once_ends_the_motion(error: Any, period: float) -> None:
    eom, raised = pushed(), list[float]()

    def once(t: float, x: Any) -> float:
        if t > 1.7 and not raised:
            raised.append(t)
            raise error("once")
        return pulled(t, x)

    inputs = {"F": kn.sampled(once, period) if period else once, "H": 25 * kn.sin(5 * kn.time)}
    options: dict[str, Any] = {"q": [0, 0], "u": [0, 0], "inputs": inputs, "samples": 31, **TIGHT}
    if error in (SystemExit, KeyboardInterrupt):
        with pytest.raises(error, match="once"):
            kn.simulate(eom, (0, 3), **options)
    else:
        sol = kn.simulate(eom, (0, 3), **options)
        assert sol.status == "stopped"
        if error is Interrupted:  # the motion up to the last step
            assert sol.message == f"interrupted by Ctrl-C at t = {sol.t[-1]:.6g}"
            assert 1.2 < sol.t[-1] < 1.72
        else:
            assert "TimeoutError" in sol.message
            assert 1 < sol.t[-1] < 1.7
    assert raised


def test_a_motion_ends_at_the_step_before_an_exception() -> None:
    """A force that does not move the block, as it sticks up to 0.09 s and from 1.09 s on, still determines when it slips."""
    eom = pushed()

    def motion(last: float) -> tuple[kn.Solution, float]:
        times = list[float]()

        def force(t: float, x: Any) -> float:
            times.append(t)
            if len(times) == last:
                raise Interrupted
            return pulled(t, x)

        inputs = {"F": force, "H": 25 * kn.sin(5 * kn.time)}
        return kn.simulate(eom, (0, 1.2), q=[0, 0], u=[0, 0], inputs=inputs, samples=13), times[-1]

    whole, _ = motion(math.inf)
    for last in (*range(150, 170), *range(700, 1100, 7)):
        sol, t = motion(last)
        assert sol.status == "stopped"
        assert sol.t[-1] <= t + 1e-9
        expected = [(e.name, t) for e, t in whole.events if t <= sol.t[-1] + 1e-9]
        assert [e.name for e, _ in sol.events] == [name for name, _ in expected], last
        np.testing.assert_allclose([t for _, t in sol.events], [t for _, t in expected], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["auto", "radau9", "RK45"])
@pytest.mark.parametrize("slowly", [0.3, 1.7])
def test_a_slow_function_is_not_called_again_after_max_seconds(method: str, slowly: float) -> None:
    """Nor without contacts, while the floor is far below. Where the function is slow from t = 0.3 s on, that is the first mode."""
    eom, limit = pushed(), 0.3
    calls = list[float]()

    def force(t: float, x: Any) -> float:
        calls.append(time.monotonic())
        if t > slowly:
            time.sleep(0.05)
        return pulled(t, x)

    options: dict[str, Any] = {"inputs": {"F": force, "H": 25 * kn.sin(5 * kn.time)}, "samples": 31, "method": method}
    kn.simulate(eom, (0, 0.1 * slowly), q=[0, 0], u=[0, 0], **options)  # what is compiled
    for y in (0.0, 100.0):
        kn.simulate(eom, (0, slowly), q=[0, y], u=[0, 0], **options)
        calls.clear()
        begun = time.monotonic()
        sol = kn.simulate(eom, (0, 3), q=[0, y], u=[0, 0], max_seconds=limit, **options)
        assert sol.message == f"max_seconds=0.3 have passed; at t = {sol.t[-1]:.6g}"
        assert sol.t[-1] < slowly + 1
        assert calls[-1] - begun < limit + 0.5
        again = kn.simulate(eom, (0, float(sol.t[-1])), q=[0, y], u=[0, 0], **options).states[-1]
        np.testing.assert_allclose(sol.states[-1], again, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    "law", [lambda x, u: 15 * kn.sin(3 * kn.time), lambda x, u: STEP, lambda x, u: 10 * kn.sin(3 * kn.time) - 2 * x - u]
)
def test_prepared_and_many_motions_with_inputs_that_are_expressions(law: Any, decisions: list[str]) -> None:
    eom, speeds = pushed(), np.linspace(0.5, 2, 8)
    (x, _), (u, _) = eom.coordinates, eom.speeds
    options: dict[str, Any] = {"inputs": {"F": law(x, u), "H": 20 * kn.sin(5 * kn.time)}, "samples": 11}
    each = [kn.simulate(eom, (0, 3), q=[0, 0], u=[v, 0], **options) for v in speeds]
    run = kn.prepare(eom, (0, 3), **options)
    ones = [run(q=[0, 0], u=[v, 0]) for v in speeds]
    start: dict[str, Any] = {"q": {"x": 0, "y": 0}, "u": {"u_x": speeds, "u_y": 0.0}}
    many = kn.simulate_many(eom, (0, 3), threads=2, **start, **options)
    assert decisions == []
    assert np.array_equal(many["end_state"], [sol.states[-1] for sol in each])
    for one, other in zip(ones, each, strict=True):
        agree(one, other, 0.0)
        assert np.array_equal(one["F"], other["F"])


def test_prepared_motions_begin_with_the_first_step_that_is_given() -> None:
    eom = pushed()
    run = kn.prepare(eom, (0, 0.3), inputs={"F": 3.0, "H": 0.0}, samples=2, first_step=1e-5)
    ends = [run(q=[0, 0.1], u=[1, 0]) for _ in range(3)]
    assert [e.steps for e in ends] == [ends[0].steps] * 3
    assert ends[0].steps > kn.simulate(eom, (0, 0.3), inputs={"F": 3.0, "H": 0.0}, q=[0, 0.1], u=[1, 0]).steps


def test_resistance_to_rolling_and_drilling_is_pressed_in_the_kernel(decisions: list[str]) -> None:
    """Of a ball thrown upward with spin, which bounces, slides, rolls, drills and stops, Python decides nothing the second time."""
    ball = friction.ball((kn.joints.rolling_resistance, 0.004), (kn.joints.drilling_resistance, 0.001), mu=0.2)
    disk, *_ = friction.disk(mu=0.1, restitution=0.4, static=0.006)
    for eom, end, q, u in (
        (disk, 6, [0, friction.RADIUS + 0.2, 0], [2.0, 0, 30.0]),
        (ball, 6, [0.1, 0.2, 0.3, 0, 0, friction.RADIUS], [3, 5, 8, 1.0, 0.8, 0]),
    ):
        wanted = by_python(eom, (0, end), q=q, u=u, **TIGHT)
        assert len(decisions) > 4
        kn.simulate(eom, (0, end), q=q, u=u, **TIGHT)
        decisions.clear()
        sol = kn.simulate(eom, (0, end), q=q, u=u, **TIGHT)
        assert decisions == []
        agree(sol, wanted, 1e-9)
        assert set(sol.mode_history[-1][1].values()) == {"stick"}


@pytest.mark.slow
def test_a_ball_that_bounces_in_space_is_led_by_the_kernel(decisions: list[str]) -> None:
    """Thrown with spin, its slip turns from impact to impact until it rolls: Python decides nothing the second time."""
    eom = friction.ball(mu=0.2, restitution=0.7)
    start: dict[str, Any] = {"q": [0.1, 0.2, 0.3, 0, 0, friction.RADIUS + 0.5], "u": [20.0, -10, 5, 2, 1, 0], **TIGHT}
    wanted = by_python(eom, (0, 4), **start)
    assert len(decisions) > 8
    kn.simulate(eom, (0, 4), **start)
    decisions.clear()
    sol = kn.simulate(eom, (0, 4), **start)
    assert decisions == []
    agree(sol, wanted, 1e-9)
    assert np.diff(sol.energy).max() < 1e-9 * sol.energy[0]
    assert sol.mode_history[-1][1] == {"floor": "stick"}


def test_events_of_prepared_and_many_motions_with_contacts(decisions: list[str]) -> None:
    """One event is noted, another ends some of the motions; Python decides nothing once the modes are known."""
    eom = pushed()
    x, _ = eom.coordinates
    near, far = kn.parameter("near", 0.4, "m"), kn.parameter("far", 0.9, "m")
    events = [kn.Event("passes", x - near, terminal=False), kn.Event("arrives", x - far, message="far enough")]
    eom = kn.derive(eom.system.replace(events=events))
    speeds = np.linspace(0.5, 5, 12)
    options: dict[str, Any] = {"inputs": {"F": 6 * kn.sin(3 * kn.time), "H": 25 * kn.sin(5 * kn.time)}, "samples": 11}
    each = [kn.simulate(kn.derive(eom.system), (0, 3), q=[0, 0], u=[v, 0], **options) for v in speeds]
    assert {sol.status for sol in each} == {"finished", "event"}
    run = kn.prepare(eom, (0, 3), **options)
    assert run.in_one_call
    for _ in range(2):
        decisions.clear()
        ones = [run(q=[0, 0], u=[v, 0]) for v in speeds]
    assert decisions == []
    for one, other in zip(ones, each, strict=True):
        agree(one, other, 0.0)
        assert (one.status, one.message, one.steps) == (other.status, other.message, other.steps)
        assert (one.event and one.event.name) == (other.event and other.event.name)
        assert [(e.name, t) for e, t in one.events] == [(e.name, t) for e, t in other.events]
    start: dict[str, Any] = {"q": {"x": 0, "y": 0}, "u": {"u_x": speeds, "u_y": 0.0}}
    many = kn.simulate_many(eom, (0, 3), threads=2, **start, **options)
    assert decisions == []
    assert many["status"].values.tolist() == [sol.status for sol in each]
    assert many["cause"].values.tolist() == [sol.message for sol in each]
    assert np.array_equal(many["end_state"], [sol.states[-1] for sol in each])
    assert np.array_equal(many["end_t"], [sol.t[-1] for sol in each])
    for k, sol in enumerate(each):
        there = many["t"].values <= sol.t[-1]
        rows = np.searchsorted(sol.t, many["t"].values[there], side="right") - 1
        assert np.array_equal(many["x"].values[k, there], sol["x"][rows])
        assert np.isnan(many["x"].values[k, ~there]).all()


@pytest.mark.parametrize("module", [ball_on_turntable, shaken_block])
def test_batches_take_euler_parameters_and_loads_that_break(module: Any, separate: list[Any]) -> None:
    """Starts on constraints are assembled for all together; the second time no motion is simulated separately."""
    eom = kn.derive(module.system())
    start = {kind: dict(values) for kind, values in module.START.items()}
    name, usual = next(((s, v) for s, v in start["u"].items() if v), ("u_x", 0.1))
    values = usual * np.linspace(0.8, 1.2, 6)
    options: dict[str, Any] = {"samples": 6, "rtol": 1e-9, "atol": 1e-10}
    starts = [{"q": start["q"], "u": {**start["u"], name: float(v)}} for v in values]
    each = [kn.simulate(kn.derive(eom.system), (0, 0.5), **one, **options) for one in starts]
    run = kn.prepare(eom, (0, 0.5), **options)
    assert run.in_one_call
    for one, other in zip([run(**own) for own in starts], each, strict=True):
        agree(one, other, 0.0)
    for _ in range(2):
        separate.clear()
        many = kn.simulate_many(eom, (0, 0.5), q=start["q"], u={**start["u"], name: values}, threads=1, **options)
        np.testing.assert_allclose(many["end_state"], [sol.states[-1] for sol in each], rtol=0, atol=1e-12)
    assert separate == []


@pytest.mark.parametrize("kind", ["input", "load", "friction"])
def test_batches_take_breakpoints_that_differ(kind: str, separate: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """What pushes or brakes the block changes at T and half a second later: one runner for each power of two of breakpoints."""
    T = kn.parameter("T", 0.3, "s")
    D, B = kn.parameter("D", 0.5, "s"), kn.parameter("B", 9.0, "N")
    change = kn.where(kn.less(kn.time, T), 1.0, kn.where(kn.less(kn.time, T + D), 0.1, 0.5))
    eom = pushed(
        mu=0.4 * change if kind == "friction" else 0.4,
        brake=B * change if kind == "load" else 0.0,
    )
    options: dict[str, Any] = {"inputs": {"F": 15 * change if kind == "input" else 15.0, "H": 0.0}, "samples": 11}
    start: dict[str, Any] = {"q": {"x": 0, "y": 0.01}, "u": {"u_x": 0.0, "u_y": 0.0}}
    times = [0.3, 0.71, 1.2, 1.6, 2.3, 0.9]  # the last but one changes nothing before t = 2
    each = [kn.simulate(kn.derive(eom.system), (0, 2), **start, parameters={T: t}, **options) for t in times]
    assert len({round(float(sol.states[-1, 0]), 9) for sol in each}) == len(times)
    made, own = list[Any](), ContactRunner.__init__

    def init(self: Any, *args: Any) -> None:
        made.append(args[-1])
        own(self, *args)

    monkeypatch.setattr(ContactRunner, "__init__", init)
    run = kn.prepare(eom, (0, 2), **options)
    for _ in range(2):
        for t, other in zip(times, each, strict=True):
            agree(run(**start, parameters={T: t}), other, 0.0)
    assert len(made) == 3  # for none, one, and two or three
    for _ in range(2):
        separate.clear()
        many = kn.simulate_many(eom, (0, 2), **start, parameters={T: np.array(times)}, threads=1, **options)
        np.testing.assert_array_equal(many["end_state"], [sol.states[-1] for sol in each])
    assert separate == []
    assert len(made) <= 6


@pytest.mark.parametrize("simulate", [kn.simulate, by_python])
def test_a_corner_rests_that_rebounds_less_than_others_are_moved(simulate: Any) -> None:
    """What closes with a gap of the resolution of times is moved to zero, and the corner beside it below zero."""
    laid = [
        Touch(0, (0.34, -0.38), restitution=0.5),
        Touch(0, (-0.41, -0.36), restitution=0.5),
        Touch(1, (0.52, -0.38)),
    ]
    plates = (Plate(1.31, 0.37), Plate(1.04, 0.66, ((0.04, 0.38), (0.16, 0.47))))
    own = model(plane := Plane(0.46, plates, tuple(laid), Support((0.09, 9.0), (0.07, 4.0), 0.01)), "moreau")
    N, F, body = own.eom.system.inertial, kn.input("F"), own.eom.system.bodies[0]
    assert isinstance(body, kn.RigidBody)
    push = [kn.gravity(-9.81 * N.y), kn.Force(body.mass_center, F * N.x)]
    sol = simulate(
        kn.derive(own.eom.system.replace(loads=push)),
        (0, 0.16),
        q=[0.548663210417, 0.370801516224, 0.0266603483746, 0.191880317836],
        u=[0.82, 0.28, 0, 0],
        parameters=own.values(plane),
        inputs={F: 10.95 * kn.sin(9.98 * kn.time) - 2.1},
        **TIGHT,
    )
    assert sol.status == "finished", sol.message


@pytest.mark.slow
def test_rebounds_that_python_leads_are_seen_in_the_first_step() -> None:
    """A corner rebounds for 2 µs, in a step that could be a thousand times as long."""
    first, second = {"kinetic": 0.58, "static": 0.58, "restitution": 0.72}, {"kinetic": 0.25, "static": 0.34}
    touches = (
        *(Touch(0, place, **first) for place in ((0.33, -0.29), (-0.37, -0.15))),
        *(Touch(1, place, **second, restitution=0.5) for place in ((0.45, -0.49), (-0.55, -0.25))),
        Touch(0, (0.72, 0.0), stops="x", restitution=0.5),
    )
    own = model(
        plane := Plane(-0.23, (Plate(1.57, 0.58), Plate(2.13, 0.61)), touches, Support((0.12, 3.0), (0.08, 5.0), 0.08))
    )
    q = [0.72, 0.219650071355, 0.19739555985, 0.203099628251, 0.371451949357, 0.235544980721]
    u = [0.200972972973, 0.395922779923, 0.173248539458, 0.44, 0.4, 0]
    given: dict[str, Any] = {"q": q, "u": u, "parameters": own.values(plane), **TIGHT}
    ends = [simulate(own.eom, (0, 0.15), **given) for simulate in (kn.simulate, by_python)]
    assert {sol.status for sol in ends} == {"finished"}, ends[1].message
    np.testing.assert_allclose(ends[1].states[-1], ends[0].states[-1], rtol=0, atol=1e-7)
