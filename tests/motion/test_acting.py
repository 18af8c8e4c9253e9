# SPDX-License-Identifier: BSD-3-Clause
"""Events that change a motion: impacts, resets, parameters and inputs of the next phase."""

from __future__ import annotations

import pickle
import re
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import four_bar
from kane.motion import Course, loop
from tests.examples import examples

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
y = kn.coordinate("y", "m")
v = kn.speed("v", "m/s")
m, g, e = kn.parameter("m", 2.0, "kg"), kn.parameter("g", 9.81, "m/s^2"), kn.parameter("e", 0.8)
F = kn.input("F", "N")
P = O.at("P", y * N.y)
METHODS = ("gauss16", "dop853", "tsitpap8", "tsit5", "DOP853")


def ball(*events, loads=(), floor=0):
    made = [kn.gravity(-g * N.y), *loads]
    return kn.derive(
        kn.System(N, bodies=[kn.Particle("ball", P, m)], speeds={v: y.dt}, loads=made, events=list(events))
    )


BOUNCE = kn.Event("bounce", y, direction=-1, then={v: -e * v})
EOM = ball(BOUNCE)


def stopped_by(sol, t, message):
    """A motion ends at the event whose action cannot be carried out, and says why."""
    assert (sol.status, sol.event) == ("stopped", None)
    assert re.match(f".*the event '{sol.events[-1][0].name}'.* at t = .*{message}", sol.message, re.DOTALL), sol.message
    assert (sol.t[-1], sol.events[-1][1]) == pytest.approx((t, t), rel=1e-8)


def bounces(h, restitution, count, floor=0.0):
    """Times and speeds after each bounce of a ball that is dropped."""
    fall = np.sqrt(2 * (h - floor) / 9.81)
    speed = restitution ** np.arange(1, count + 1) * 9.81 * fall
    flights = 2 * speed[:-1] / 9.81
    return fall + np.concatenate([[0], np.cumsum(flights)]), speed


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_bounces(method):
    sol = kn.simulate(EOM, (0, 3), q=[1], u=[0], method=method, samples=301)
    times, speeds = bounces(1, 0.8, 6)
    times, speeds = times[times < 3], speeds[times < 3]
    assert [x.name for x, _ in sol.events] == ["bounce"] * len(times)
    np.testing.assert_allclose([t for _, t in sol.events], times, atol=1e-9)
    assert sol.status == "finished"
    assert sol.t[-1] == 3
    assert [j.t for j in sol.jumps] == pytest.approx(times, abs=1e-9)
    for jump, speed in zip(sol.jumps, speeds, strict=True):
        assert jump.changes[v] == pytest.approx((-speed / 0.8, speed), rel=1e-9)
        assert jump.energy == pytest.approx(2 / 2 * speed**2 * (1 - 1 / 0.64), rel=1e-9)
        assert jump.events[0].name == "bounce"
    assert sol.energy_check.relative < 1e-9
    assert np.abs(sol.energy_drift).max() < 1e-8
    first = int(np.flatnonzero(sol.phase == 1)[0])
    assert sol.t[first] == sol.t[first - 1]
    assert sol["v"][first] == pytest.approx(-0.8 * sol["v"][first - 1], rel=1e-14)
    # on both sides of a jump it is interpolated to what it is there
    near = np.interp(times[0] + np.array([-1e-6, 1e-6]), sol.t, sol["v"])
    assert near == pytest.approx([-speeds[0] / 0.8, speeds[0]], rel=1e-5)
    assert sol["y"].min() > -1e-12
    work = sum(sol.load_works[load] for load in EOM.loads)
    assert work[-1] == pytest.approx(-2 * 9.81 * (sol["y"][-1] - 1), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("floor", [0.0, 5.0])
def test_bounces_without_end_are_named(method, floor):
    eom = ball(kn.Event("bounce", y, threshold=floor, direction=-1, then={v: -0.5 * v}))
    sol = kn.simulate(eom, (0, 3), q=[floor + 1], u=[0], method=method)
    assert sol.status == "stopped"
    assert "the event 'bounce' acts without end at t = 1.3545" in sol.message
    assert sol.t[-1] == pytest.approx(3 * np.sqrt(2 / 9.81), abs=1e-6)
    assert sol["y"].min() > floor - 1e-6
    # the cure that the message names
    rests = kn.Event("rests", v**2 / 2 + g * y, threshold=9.81 * floor + 1e-3, direction=-1)
    sol = kn.simulate(ball(*eom.system.events, rests), (0, 3), q=[floor + 1], u=[0], method=method)
    assert (sol.status, sol.event.name) == ("event", "rests")
    assert sol.t[-1] == pytest.approx(1.3, abs=0.1)


@pytest.mark.parametrize(
    ("start", "method"),
    [
        *((1e4, method) for method in ("dop853", "gauss16", "DOP853", "RK45")),
        (1e8, "gauss16"),
        *(pytest.param(1e8, method, marks=pytest.mark.slow) for method in ("dop853", "DOP853", "RK45")),
    ],
)
def test_a_ball_bounces_at_any_time(start, method):
    """Numbers there are so far apart that the ball is below the floor, by 1e-8 m, when the event is met, as a fast step leaves it."""

    def rebound(u, **_):
        return {v: -0.8 * u[v]}

    for event in (BOUNCE, kn.Event("bounce", y, direction=-1, then=rebound)):
        eom = ball(event)
        for h in (0.7, 0.8, 0.9):
            times = bounces(h, 0.8, 12)[0]
            sol = kn.simulate(eom, (start, start + 3), q=[h], u=[0], method=method, samples=2)
            found = [t - start for _, t in sol.events]
            np.testing.assert_allclose(found, times[times < 3], rtol=0, atol=1e-6)


@pytest.mark.parametrize("height", [0.5, 1, 1.1, 1.2, 1.3, 2, 3])
def test_a_ball_that_does_not_rebound_rests(height):
    """Whatever sign rounding leaves of the place where it stands."""
    sol = kn.simulate(ball(kn.Event("hits", y, direction=-1, then={v: 0})), (0, 3), q=[height], u=[0])
    assert sol.status == "stopped"
    assert "acts without end" in sol.message
    assert sol["y"].min() > -1e-9


def test_values_are_those_before_whatever_the_order():
    x, w = kn.coordinate("x", "m"), kn.speed("w", "m/s")
    Q = O.at("Q", x * N.x)
    swap = kn.Event("swap", y, threshold=1, then={w: v, v: w, y: 2 * y})
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("a", P, 1), kn.Particle("b", Q, 1)], speeds={v: y.dt, w: x.dt}, events=[swap])
    )
    sol = kn.simulate(eom, (0, 2), q={y: 0, x: 0}, u={v: 1, w: 3})
    assert [sol[s][-1] for s in (v, w, y, x)] == pytest.approx([3, 1, 5, 4])


def test_parameters_and_inputs_of_the_next_phase():
    thrust = kn.Event("burnt out", y, threshold=10, direction=1, then={F: 0, m: m / 2})
    ceiling = kn.Event("high", y, threshold=20, direction=1, then={"F": -3 * kn.time * N.y.dot(N.y)})
    eom = ball(thrust, ceiling, loads=[kn.Force(P, F * N.y)])
    sol = kn.simulate(eom, (0, 2.5), q=[0], u=[0], inputs={F: 100.0}, rtol=1e-11, atol=1e-11)
    a = 50 - 9.81
    t1 = np.sqrt(20 / a)
    assert sol.events[0][1] == pytest.approx(t1, rel=1e-11)
    assert sol[F][0] == 100
    assert sol[m][-1] == 1
    v1 = a * t1
    t2 = t1 + (v1 - np.sqrt(v1**2 - 2 * 9.81 * 10)) / 9.81
    assert sol.events[1][1] == pytest.approx(t2, rel=1e-10)
    assert sol[F][-1] == pytest.approx(-7.5)
    v2 = v1 - 9.81 * (t2 - t1)
    assert sol["v"][-1] == pytest.approx(v2 - 9.81 * (2.5 - t2) - 1.5 * (2.5**2 - t2**2), rel=1e-9)
    assert sol.keeps_energy
    assert sol.jumps[0].changes == {m: (2.0, 1.0)}
    assert sol.jumps[0].energy == pytest.approx(-(v1**2 / 2 + 9.81 * 10), rel=1e-9)


def test_a_function_that_asks_the_impact_equations():
    """A ball on a slope of 45°, smooth: it leaves with the reversed normal speed; the equations of impact are those of `kn.impact`."""
    x, w = kn.coordinate("x", "m"), kn.speed("w", "m/s")
    C = N.rotate("C", 0, N.z)
    Q = O.at("Q", x * N.x + y * N.y)
    normal = (N.x + N.y) * (1 / kn.sqrt(2))
    seen = []

    def blow(**at):
        seen.append(at)
        return kn.impact(eom, hit, normal, restitution=0.5, **at).u

    hit = Q.fixed_in(C, "hit", 0 * N.x)
    hits = kn.Event("hits", x + y, direction=-1, then=blow)
    body = kn.RigidBody("b", frame=C, mass_center=Q, mass=m, inertia=kn.inertia(C, 1, 1, 1))
    eom = kn.derive(kn.System(N, bodies=[body], speeds={w: x.dt, v: y.dt}, loads=[kn.gravity(-g * N.y)], events=[hits]))
    sol = kn.simulate(eom, (0, 0.6), q={x: 0, y: 1}, u=[0, 0], parameters={m: 3.0})
    k = int(np.flatnonzero(sol.phase == 1)[0])
    before, after = sol.u[k - 1], sol.u[k]
    s = -np.sqrt(2 * 9.81)
    np.testing.assert_allclose(before, [0, s], rtol=1e-9)
    np.testing.assert_allclose(after, [-0.75 * s, s - 0.75 * s], rtol=1e-9)
    assert seen[0]["parameters"][m] == 3.0
    assert sol.keeps_energy


def test_several_at_one_instant():
    x, w = kn.coordinate("x", "m"), kn.speed("w", "m/s")
    Q = O.at("Q", x * N.x)

    def system(*events):
        bodies = [kn.Particle("a", P, 1), kn.Particle("b", Q, 1)]
        return kn.derive(kn.System(N, bodies=bodies, speeds={v: y.dt, w: x.dt}, events=list(events)))

    one = kn.Event("one", y, threshold=1, then={v: -v})
    two = kn.Event("two", x, threshold=2, then={w: 0.5 * w})
    mark = kn.Event("mark", x + 2 * y, threshold=4, terminal=False)
    for method in METHODS:
        sol = kn.simulate(system(one, two, mark), (0, 2), q={y: 0, x: 0}, u={v: 1, w: 2}, method=method)
        assert sorted(e.name for e, _ in sol.events) == ["mark", "one", "two"]
        assert [t for _, t in sol.events] == pytest.approx([1, 1, 1], abs=1e-12)
        assert [sol[s][-1] for s in (y, x)] == pytest.approx([0, 3])
    same = kn.Event("same", x, threshold=2, then={v: -v})
    sol = kn.simulate(system(one, same), (0, 2), q={y: 0, x: 0}, u={v: 1, w: 2})
    assert sol["v"][-1] == -1
    other = kn.Event("other", x, threshold=2, then={"v": 3 * v})
    stopped_by(
        kn.simulate(system(one, other), (0, 2), q={y: 0, x: 0}, u={v: 1, w: 2}),
        1.0,
        r"Expected one value for v at t = 1, got -1.* 'one' and 3.* from 'other' at the same time",
    )


@pytest.mark.slow
def test_what_stays_at_its_threshold_but_for_rounding_is_no_event():
    """x + y is 3 from the swap on; x₁ − x₂ of two balls that move alike is zero all along."""
    x, w = kn.coordinate("x", "m"), kn.speed("w", "m/s")
    Q = O.at("Q", x * N.x)
    bodies = [kn.Particle("a", P, 1), kn.Particle("b", Q, 1)]
    swap = kn.Event("swap", y, threshold=1, then={v: -v})
    still = kn.Event("still", x + y, threshold=3, terminal=False)
    springs = [kn.linear_spring(place, O, kn.parameter("k", 0.3, "N/m")) for place in (P, Q)]
    told = []
    for method in METHODS:
        eom = kn.derive(kn.System(N, bodies=bodies, speeds={v: y.dt, w: x.dt}, events=[swap, still]))
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            sol = kn.simulate(eom, (0, 3), q={y: 0, x: 1}, u={v: 0.7, w: 0.7}, method=method)
        assert len(sol.events) <= 2
        told += [str(f.message) for f in found]
        zero = kn.Event("zero", x - y)
        eom = kn.derive(kn.System(N, bodies=bodies, speeds={v: y.dt, w: x.dt}, events=[zero], loads=springs))
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            sol = kn.simulate(eom, (0, 20), q={y: 0.3, x: 0.3 * (1 + 3e-16)}, u={v: 0.2, w: 0.2}, method=method)
        assert sol.status == "finished"
        told += [str(f.message) for f in found]
    assert any("'still' that crosses 3, got one that stays there, except for rounding errors" in text for text in told)


def test_an_action_may_end_the_motion_and_set_off_others():
    last = kn.Event("last", y, direction=-1, then={v: -v}, terminal=True)
    sol = kn.simulate(ball(last), (0, 3), q=[1], u=[0])
    assert (sol.status, sol.event.name) == ("event", "last")
    assert sol["v"][-1] == pytest.approx(np.sqrt(2 * 9.81))
    on = kn.simulate(ball(last), 3, start=sol)
    assert on.t[-1] == pytest.approx(3 * sol.t[-1])
    # v leaps across zero with the bounce: what that sets off is of the same instant
    doubled = kn.Event("upwards", v, direction=1, then={g: 2 * g})
    sol = kn.simulate(ball(BOUNCE, doubled), (0, 0.6), q=[1], u=[0])
    assert [x.name for x, _ in sol.events] == ["bounce", "upwards"]
    assert sol[g][-1] == pytest.approx(2 * 9.81)
    assert [x.name for x in sol.jumps[0].events] == ["bounce", "upwards"]


def asked(monkeypatch):
    """What Python is asked for from now on: steps that it looks at, actions that it takes."""
    found = []
    for module, name in ((Course, "judge"), (loop, "after_actions")):
        own = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *args, own=own: (found.append(1), own(*args))[1])
    return found


def test_kernels_set_parameters(monkeypatch):
    """Also of masses; where Python acts the motion is the same, and the next one begins with the values that are given."""
    k = kn.parameter("k", 3.0, "N/m")
    stiffer = kn.Event("stiffer", v, then={k: 1.1 * k, v: 0.9 * v})
    lighter = kn.Event("lighter", y, direction=1, then={m: 0.9 * m})
    eom, seen = ball(stiffer, lighter, loads=[kn.Force(P, -k * y * N.y)]), asked(monkeypatch)
    sols = [kn.simulate(eom, (0, 9), q=[1], u=[0.3], rtol=1e-11, atol=1e-11) for _ in range(3)]
    assert seen == []
    other = kn.simulate(eom, (0, 9), q=[1], u=[0.3], rtol=1e-11, atol=1e-11, method="DOP853")
    assert seen
    for sol in sols:
        assert sol.states[-1] == pytest.approx(other.states[-1], rel=1e-7)
        assert [(sol[k][-1], sol[m][-1])] == [(other[k][-1], other[m][-1])]
        assert [[e.name for e in j.events] for j in sol.jumps] == [[e.name for e in j.events] for j in other.jumps]
        assert sol.keeps_energy
    # a mass below zero, and parameters of inputs, are Python's to judge
    sol = kn.simulate(ball(kn.Event("gone", y, then={m: m - 3 * kn.sqrt(m**2)})), (0, 1), q=[1], u=[0])
    stopped_by(sol, np.sqrt(2 / 9.81), "mass")
    driven = ball(stiffer, loads=[kn.Force(P, (F - k * y) * N.y)])
    sol, other = (
        kn.simulate(driven, (0, 9), q=[1], u=[0.3], inputs={F: k * kn.parameter("l", 0.1, "m")}, method=how)
        for how in ("tsit5", "DOP853")
    )
    assert sol[F][-1] == pytest.approx(0.1 * sol[k][-1])
    assert sol.states[-1] == pytest.approx(other.states[-1], rel=1e-5)


@pytest.mark.slow
def test_kernels_act_under_constraints(monkeypatch):
    """A crank is struck again and again: what depends on it follows in the kernel."""
    system = four_bar.system()
    u1, q1 = next(iter(system.speeds)), system.coordinates[0]
    struck = kn.Event("struck", kn.sin(q1), then={u1: 0.5 * u1})
    eom, seen = kn.derive(system.replace(events=[struck])), asked(monkeypatch)
    for method in ("auto", "tsit5"):
        sol = kn.simulate(eom, (0, 2.0), **four_bar.START, method=method)
        assert len(sol.jumps) > 0
        assert max(np.abs(r).max() for r in sol.constraint_residuals.values()) < 1e-9
        assert sol.keeps_energy
        assert seen == []
    other = kn.simulate(eom, (0, 2.0), **four_bar.START, method="DOP853")
    assert seen
    assert sol.states[-1] == pytest.approx(other.states[-1], rel=1e-6)


@pytest.mark.slow
def test_a_mechanism_is_struck():
    """The crank's speed is halved; what depends on it follows, and the constraints hold."""
    system = four_bar.system()
    u1, u2 = system.speeds.keys() if len(system.speeds) == 2 else list(system.speeds)[:2]
    q1 = system.coordinates[0]
    struck = kn.Event("struck", q1, threshold=2.0, direction=1, then={u1: u1 / 2})
    eom = kn.derive(system.replace(events=[struck]))
    sol = kn.simulate(eom, (0, 1.0), **four_bar.START)
    jump = sol.jumps[0]
    before, after = jump.changes[u1]
    assert after == pytest.approx(before / 2)
    assert u2 in jump.changes
    assert jump.changes[u2][1] == pytest.approx(jump.changes[u2][0] / 2, rel=1e-8)  # one freedom, at rest otherwise
    assert max(np.abs(r).max() for r in sol.constraint_residuals.values()) < 1e-9
    assert sol.keeps_energy
    eom = kn.derive(system.replace(events=[kn.Event("wrong", q1, threshold=2.0, direction=1, then={u1: 7, u2: 7})]))
    sol = kn.simulate(eom, (0, 1.0), **four_bar.START)
    stopped_by(sol, jump.t, r"Expected actions after which the constraints hold.* 'wrong' .* follow from .*: set")
    length = next(p for p in system.parameters if p.unit == "m")
    eom = kn.derive(
        system.replace(events=[kn.Event("torn", q1, threshold=2.0, direction=1, then={length: 1.2 * length})])
    )
    sol = kn.simulate(eom, (0, 1.0), **four_bar.START)
    stopped_by(
        sol, jump.t, r"Expected actions after which the constraints hold.* 'torn' .* that the constraints leave free"
    )


@pytest.mark.slow
def test_it_lasts(tmp_path):
    sol = kn.simulate(EOM, (0, 2), q=[1], u=[0], parameters={e: 0.7})
    sol.save(tmp_path / "run.npz")
    for again in (kn.load_solution(tmp_path / "run.npz", EOM), pickle.loads(pickle.dumps(sol))):
        assert np.array_equal(again.states, sol.states)
        assert again.energy_check == sol.energy_check
        assert [[x.name for x in j.events] for j in again.jumps] == [["bounce"]] * len(sol.jumps)
        on, plain = (kn.simulate(EOM, 2.5, start=s) for s in (again, sol))
        assert np.array_equal(on.states, plain.states)
    found = sol.accuracy()
    assert found.relative < 1e-6


@pytest.mark.parametrize(
    ("then", "message"),
    [
        ({}, r"then= of the event 'a' to give new values"),
        (3, r"to give new values, got 3"),
        ({y.dt: 1}, r"got the rate y'\. Set the speed"),
        ({kn.time: 1}, r"to set coordinates, speeds, states, parameters or inputs, got"),
        ({v: "fast"}, r"Expected an expression or a number for v"),
        ({v: None}, r"Expected an expression or a number for v"),
    ],
)
def test_wrong_actions(then, message):
    with pytest.raises(kn.ModelError, match=message):
        kn.Event("a", y, then=then)


def test_wrong_actions_of_a_system():
    for event, message in (
        (kn.Event("a", y, then={"w": 1}), r"to set one of y, v, .* got 'w'"),
        (kn.Event("a", y, then={v: 1, "v": 2}), r"Expected one value for each symbol .* by symbol and by name"),
        (kn.Event("a", y - y), r"'a' to change along a motion, got 0, which is constant"),
        (kn.Event("a", m * g), r"to change along a motion, got .*which is constant"),
        (kn.Event("a", y, then={v: y}), r"the value of v set by the event 'a'"),
    ):
        with pytest.raises(kn.ModelError, match=message):
            ball(event)
    for function, message in (
        (lambda **at: {v: np.nan}, r"Expected a finite value from the event 'a' for v, got nan"),
        (
            lambda **at: 1 / 0,
            r"got ZeroDivisionError from it at t = 0\.45.* called with the keywords t, q, u, parameters",
        ),
        (lambda **at: [1], r"Expected a dict \{symbol: value\} .* got \[1\]"),
        (lambda **at: {"nobody": 1}, r"to set one of y, v"),
        (lambda **at: {m: -1}, r"Expected a mass ≥ 0"),
    ):
        sol = kn.simulate(ball(kn.Event("a", y, direction=-1, then=function)), (0, 1), q=[1], u=[0])
        stopped_by(sol, np.sqrt(2 / 9.81), message)


WRONG = {
    "a number that no mass is": lambda number: {m: -number},
    "no number": lambda number: {v: number * kn.sqrt(-(v**2))},
    "an infinite one": lambda number: lambda **at: {v: number * np.inf},
    "no number of a function": lambda number: lambda **at: {y: float("nan")},
    "an error in a function": lambda number: lambda **at: {m: at["nothing"]},
    "no mapping": lambda number: lambda **at: number,
    "no input": lambda number: {F: "much"},
    "another system's symbol": lambda number: lambda **at: {kn.speed("w"): number},
}


@given(st.sampled_from(sorted(WRONG)), st.floats(0.1, 3), st.floats(0.1, 9), st.sampled_from(METHODS))
@examples(0.2)
def test_the_motion_up_to_an_action_that_cannot_be_is_kept(what, height, number, method):
    """A ball is dropped: what it did up to the floor stands, and the message names event and cause."""
    then = WRONG[what](number)
    sol = kn.simulate(
        ball(kn.Event("floor", y, direction=-1, then=then), loads=[kn.Force(P, F * N.y)]),
        (0, 2),
        q=[height],
        u=[0],
        inputs={F: 0.0},
        method=method,
    )
    stopped_by(sol, np.sqrt(2 * height / 9.81), "")
    np.testing.assert_allclose(sol["y"], height - 9.81 / 2 * sol.t**2, atol=1e-8)
    assert sol.keeps_energy


def test_a_prescribed_motion_does_not_jump():
    r = kn.input("r", "m")
    rail = O.at("R", r * N.x)
    Q = rail.at("Q", y * N.y)

    def moved(then):
        event = kn.Event("late", kn.time, threshold=0.5, then=then)
        return kn.derive(kn.System(N, bodies=[kn.Particle("p", Q, m)], speeds={v: y.dt}, events=[event]))

    t = kn.time
    sol = kn.simulate(moved({r: 0.25 + (t - 0.5) + 2 * (t - 0.5) ** 2}), (0, 1), q=[0], u=[0], inputs={r: t**2})
    assert sol[r][-1] == pytest.approx(0.25 + 0.5 + 0.5)
    assert sol.keeps_energy
    sol = kn.simulate(moved({r: 3.0}), (0, 1), q=[0], u=[0], inputs={r: t**2})
    stopped_by(sol, 0.5, r"Expected the prescribed motion r.* without a jump at t = 0\.5")


@pytest.mark.parametrize(
    "law", [1 - kn.cos(kn.time), (lambda t: 1 - np.cos(t), np.sin, np.cos)], ids=["expression", "functions"]
)
def test_a_prescribed_motion_ends_where_its_rate_is_zero_but_for_rounding(law):
    """sin 2π is −2.4e-16 in numbers. The particle on a spring along a rail that comes to rest swings on as it is then."""
    r = kn.input("r", "m")
    Q = O.at("R", r * N.y).at("Q", y * N.y)
    rests = kn.Event("rests", kn.time, threshold=2 * np.pi, then={r: 0.0})
    pull = kn.Force(Q, -kn.parameter("k", 8.0, "N/m") * y * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", Q, m)], speeds={v: y.dt}, loads=[pull], events=[rests]))
    sol = kn.simulate(eom, (0, 10), q=[1], u=[0], inputs={r: law}, samples=101)
    assert sol.status == "finished"
    # y'' + 4 y = −cos t, at t = 2π again y = 1 and at rest; then y = cos 2t
    exact = np.where(sol.t <= 2 * np.pi, 4 / 3 * np.cos(2 * sol.t) - np.cos(sol.t) / 3, np.cos(2 * sol.t))
    np.testing.assert_allclose(sol["y"], exact, atol=1e-7)


@pytest.mark.parametrize("start", [-0.13, *(pytest.param(-k / 100, marks=pytest.mark.slow) for k in range(1, 200, 7))])
def test_what_acts_where_a_load_switches_acts_once(start):
    """The spring becomes weaker each time that the particle comes up through zero, where friction of the place turns, too."""
    x, v, k = kn.coordinate("x"), kn.speed("v"), kn.parameter("k", 1.0)
    p = O.at("p", x * N.x)
    weaker = kn.Event("weaker", x, direction=1, then={k: 0.9 * k})
    pull = kn.Force(p, (-k * x - 0.5 * kn.sign(x)) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", p, 1)], speeds={v: x.dt}, loads=[pull], events=[weaker]))
    sol = kn.simulate(eom, (0, 8), q=[start], u=[0], method="dop853", samples=2)
    times = [t for _, t in sol.events]
    assert min(np.diff(times), default=1.0) > 0.1
    assert sol[k][-1] == pytest.approx(0.9 ** len(times))


@pytest.mark.parametrize("method", ["auto", "DOP853"])
def test_steps_are_counted_over_all_phases(method):
    """What is said where steps run out is how many there were to be, not how many the last phase had left."""
    x, v = kn.coordinate("x"), kn.speed("v")
    N = kn.Frame("N")
    p = kn.Point("O", fixed_in=N).at("p", x * N.x)
    bounce = kn.Event("bounce", x, direction=-1, then={v: -0.9 * v})
    system = kn.System(
        N, bodies=[kn.Particle("p", p, 1)], speeds={v: x.dt}, loads=[kn.Force(p, -9.81 * N.x)], events=[bounce]
    )
    sol = kn.simulate(kn.derive(system), (0, 5), q=[1], u=[0], method=method, max_step=0.05, max_steps=40)
    assert (sol.status, sol.steps) == ("stopped", 40)
    assert len(sol.phases) > 2
    assert sol.message.startswith("40 steps were not enough")
