# SPDX-License-Identifier: BSD-3-Clause
"""Motions in lanes are those that the same kernel runs alone, bit for bit without contraction."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import Settings
from kane.gallery import double_pendulum, four_bar, furuta_pendulum, pendulums, slider_crank, spherical_pendulum
from kane.motion import Begin, Method, ReturnCode, Stepper, admitted_start, input_functions, run_in_lanes, runs_in_lanes
from tests.examples import examples

EXACT = Settings(contract=False)
SYSTEMS = {
    "double pendulum": double_pendulum.system,
    "Furuta's pendulum": furuta_pendulum.system,
    "three pendulums": lambda: pendulums.system(3),
    "spherical pendulum": spherical_pendulum.system,
}
TOLERANCE = 1e-8


def instances(eom, rng, count, samples=7):
    """Starts, parameters, inputs, spans and times that all differ."""
    defaults = np.array([s.default if s.default is not None else 1.0 for s in eom.parameters])
    spans = np.column_stack([rng.uniform(-1, 1, count), np.zeros(count)])
    spans[:, 1] = spans[:, 0] + rng.uniform(0.2, 3.0, count)
    shares = np.sort(rng.uniform(0.01, 1, (count, samples)), axis=1)
    return (
        rng.uniform(0.3, 1.2, (count, len(eom.state))),
        defaults * rng.uniform(0.8, 1.25, (count, len(defaults))),
        rng.normal(size=(count, len(eom.inputs))),
        spans,
        spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * shares,
    )


def stepper(eom, settings=EXACT):
    drives = input_functions(eom, dict.fromkeys(eom.inputs, 0.0), (0.0, 1.0))
    return Stepper(eom, np.ones(len(eom.parameters)), tuple(drives.values()), settings)


def alone(eom, method, x, p, r, span, times, settings=EXACT):
    nq, nu = len(eom.coordinates), len(eom.speeds)
    return kn.simulate(
        eom,
        tuple(span),
        q=x[:nq],
        u=x[nq : nq + nu],
        states=x[nq + nu :] if len(x) > nq + nu else None,
        parameters=dict(zip(eom.parameters, p, strict=True)),
        inputs=dict(zip(eom.inputs, r, strict=True)),
        method=method,
        rtol=TOLERANCE,
        atol=TOLERANCE,
        samples=[span[0], *times],
        settings=settings,
    )


def same(eom, method, given, width, settings=EXACT, close=None):
    """Motions in lanes are those of the kernel alone, with as many steps."""
    way = Method(method, TOLERANCE, TOLERANCE, 100_000)
    one = stepper(eom, settings)
    assert runs_in_lanes(one, way)
    found = run_in_lanes(one, way, *given, width=width)
    for k, instance in enumerate(zip(*given, strict=True)):
        sol = alone(eom, method, *instance, settings)
        states = np.column_stack([sol.states, sol.work])[1 : 1 + len(instance[-1])]
        if close is None:
            assert np.array_equal(found.samples[k], states)
            assert found.steps[k] == sol.steps
        else:
            assert found.samples[k] == pytest.approx(states, abs=close)
        assert found.back[k] == ReturnCode.END
        assert found.t[k] == instance[3][1]
        assert np.array_equal(found.states[k, :-1], sol.states[-1]) or close


@pytest.mark.parametrize("name", SYSTEMS)
def test_systems(name, rng):
    """Starts, parameters, spans and samples of its own in each lane; more instances than lanes, or fewer."""
    eom = kn.derive(SYSTEMS[name]())
    same(eom, "tsitpap8", instances(eom, rng, 19), 8)
    same(eom, "tsit5", instances(eom, rng, 3), 4)


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5", "tsitpap8"])
def test_methods(method, rng):
    eom = kn.derive(double_pendulum.system())
    same(eom, method, instances(eom, rng, 13), 8)


def test_contracted_motions_differ_by_rounding(rng):
    eom = kn.derive(double_pendulum.system())
    same(eom, "vern9", instances(eom, rng, 9), 8, Settings(), close=1e-6)


def test_inputs_of_lanes(rng):
    """A force of its own in each lane: x = F t²/2 with the mass 1."""
    N = kn.Frame("N")
    x, F = kn.coordinate("x"), kn.input("F")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", P, 1)], loads=[kn.Force(P, F * N.x)], speeds="rates"))
    same(eom, "dop853", instances(eom, rng, 11), 8)


@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 8]), st.sampled_from(["tsit5", "vern9"]))
@examples(0.05, 3)
def test_random_chains(seed, width, method):
    """Links on turning and sliding joints, with springs between them."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    q = kn.coordinates(" ".join(f"q{k}" for k in range(count)))
    q = q if isinstance(q, tuple) else (q,)
    m, c = kn.parameters("m c", 1.0)
    N = kn.Frame("N")
    frame, point, bodies, loads = N, kn.Point("O", fixed_in=N), [], []
    for k, s in enumerate(q):
        axis = (frame.x, frame.y, frame.z)[rng.integers(3)]
        if rng.random() < 0.6:
            frame = frame.rotate(f"A{k}", s, axis)
            point = point.at(f"P{k}", frame.x * rng.uniform(0.3, 1) + frame.y * rng.uniform(0.3, 1))
        else:
            point = point.at(f"P{k}", s * axis + frame.x * rng.uniform(0.3, 1))
        bodies.append(kn.Particle(f"B{k}", point, m * rng.uniform(0.5, 2)))
        loads.append(kn.Force(point, -c * rng.uniform(0.5, 2) * N.y + N.z * kn.cos(s)))
    eom = kn.derive(kn.System(N, bodies=bodies, loads=loads, speeds="rates"))
    same(eom, method, instances(eom, rng, 2 * width + 3, samples=4), width)


def test_a_lane_that_fails_disturbs_no_other(rng):
    """NaN among the parameters, steps that do not suffice, and a state that runs away end alone, and the next one is taken up."""
    eom = kn.derive(double_pendulum.system())
    given = instances(eom, rng, 21)
    way = Method("tsitpap8", TOLERANCE, TOLERANCE, 100_000)
    good = run_in_lanes(stepper(eom), way, *given)
    given[1][[2, 3, 12]] = np.nan
    given[0][9] = np.inf
    found = run_in_lanes(stepper(eom), way, *given)
    bad = [2, 3, 9, 12]
    others = np.setdiff1d(np.arange(21), bad)
    assert all(found.back[k] in (ReturnCode.NOT_FINITE, ReturnCode.UNDERFLOW) for k in bad)
    assert np.isnan(found.samples[bad]).all()
    for before, after in zip(good[:5], found[:5], strict=True):
        assert np.array_equal(before[others], after[others])
    few = run_in_lanes(stepper(eom), Method("tsitpap8", TOLERANCE, TOLERANCE, int(np.median(good.steps))), *given)
    short = others[good.steps[others] <= np.median(good.steps)]
    assert set(found.back[short]) == {ReturnCode.END}
    assert np.array_equal(few.samples[short], good.samples[short])
    assert ReturnCode.LIMIT in few.back


def test_what_lanes_do_not_run():
    """Implicit methods, methods on lanes of their own, breakpoints, and contacts."""
    one = stepper(kn.derive(double_pendulum.system()))
    assert not runs_in_lanes(one, Method("gauss16", 1e-9, 1e-9, 100))
    assert not runs_in_lanes(one, Method("radau9", 1e-9, 1e-9, 100))
    assert not runs_in_lanes(one, Method("vern9", 1e-9, 1e-9, 100, breakpoints=(0.5,)))
    assert not runs_in_lanes(one, Method("DOP853", 1e-9, 1e-9, 100))


def ball():
    """A ball that bounces and is thrown through a gate: events that act, are noted, and end the motion."""
    N = kn.Frame("N")
    x, y = kn.coordinates("x y")
    (u, v), (m, g, e) = kn.speeds("u v"), kn.parameters("m g e")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    return kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("ball", P, m)],
            loads=[kn.Force(P, -m * g * N.y)],
            speeds={u: x.dt, v: y.dt},
            events=[
                kn.Event("bounce", y, terminal=False, direction=-1, then={v: -e * v}),
                kn.Event("gate", x - 0.7, terminal=False),
                kn.Event("out", x - 3, terminal=True),
            ],
        )
    )


@pytest.mark.parametrize(("method", "width"), [("dop853", 8), pytest.param("vern9", 4, marks=pytest.mark.slow)])
def test_events(method, width, rng):
    """Each lane bounces, passes and ends by itself, event for event; what the kernel asks of Python is told."""
    eom, count = ball(), 29
    p = {"m": 1.0, "g": rng.uniform(5, 15, count), "e": rng.uniform(0.6, 0.9, count)}
    parameters = np.column_stack([np.broadcast_to(p[s.name], count) for s in eom.parameters])
    starts = rng.uniform((0, 1, 0.2, -1), (0.5, 2, 3, 1), (count, 4))
    starts[5] = 0.0, 0.0, 1.0, 1.0  # at a threshold
    spans = np.column_stack([np.zeros(count), rng.uniform(1, 2, count)])
    times = spans[:, 1:] * np.linspace(0.1, 1, 9)
    given = starts, parameters, np.zeros((count, 0)), spans, times
    one, way = stepper(eom), Method(method, TOLERANCE, TOLERANCE, 100_000)
    assert runs_in_lanes(one, way)
    found, asked = run_in_lanes(one, way, *given, width=width), 0
    for k, instance in enumerate(zip(*given, strict=True)):
        if found.back[k] not in (ReturnCode.END, ReturnCode.EVENT):
            asked += 1
            assert found.back[k] == ReturnCode.LOOK
            continue
        sol = alone(eom, method, *instance)
        assert [(eom.events[int(i)], t) for t, i in found.events[k]] == [*sol.events]
        at = dict(zip(sol.t, sol.states, strict=True))
        for t, state in zip(times[k], found.samples[k], strict=True):
            assert np.array_equal(state[:-1], at[t]) if t in at else np.isnan(state).all()
        assert np.array_equal(found.states[k, :-1], sol.states[-1])
        assert found.t[k] == sol.t[-1]
        assert found.steps[k] == sol.steps
        assert (found.back[k] == ReturnCode.EVENT) == (sol.status == "event")
    assert found.back[5] == ReturnCode.LOOK
    assert asked < count / 4
    assert max(map(len, found.jumps)) > 2


CONSTRAINED = {
    "four-bar": (four_bar.system, {"q1": 1.57}, {"u1": 5.0}, 2.0),
    "slider-crank": (slider_crank.system, {"q1": 0.7}, {"u1": 3.0}, 0.5),
}


@pytest.mark.parametrize("name", [pytest.param("four-bar", marks=pytest.mark.slow), "slider-crank"])
def test_constraints(name, rng):
    """Steps and samples are moved onto the constraints, and each lane goes over to the dependent speeds that it wants."""
    make, q, u, longest = CONSTRAINED[name]
    eom, count = kn.derive(make()), 19
    defaults = np.array([s.default for s in eom.parameters])
    parameters = defaults * rng.uniform(0.98, 1.02, (count, len(defaults)))
    starts, begun, reach = [], [], []
    for p in parameters:
        begun.append(({s: v + rng.normal() * 0.01 for s, v in q.items()}, u))
        one = Stepper(eom, p, (), EXACT)
        named = dict(zip(eom.parameters, p, strict=True))
        starts.append(admitted_start(one, Begin(*begun[-1], None, None), named, 0.0)[:-1])
        reach.append(one.reach)
    spans = np.column_stack([np.zeros(count), rng.uniform(0.02, longest, count)])
    times = spans[:, 1:] * np.linspace(0.1, 1, 5)
    way = Method("tsitpap8", TOLERANCE, TOLERANCE, 100_000)
    assert runs_in_lanes(stepper(eom), way)
    given = np.array(starts), parameters, np.zeros((count, 0)), spans, times
    found, changed = run_in_lanes(stepper(eom), way, *given, np.array(reach)), 0
    for k, (start, span) in enumerate(zip(begun, spans, strict=True)):
        options = {"rtol": TOLERANCE, "atol": TOLERANCE, "samples": [0, *times[k]], "settings": EXACT}
        named = dict(zip(eom.parameters, parameters[k], strict=True))
        sol = kn.simulate(eom, tuple(span), q=start[0], u=start[1], parameters=named, method="tsitpap8", **options)
        assert found.back[k] == ReturnCode.END
        assert np.array_equal(found.samples[k, :, :-1], sol.states[1:])
        assert found.steps[k] == sol.steps
        assert [t for t, _ in found.changes[k]] == [t for event, t in sol.events if "dependent" in event.name]
        changed += bool(found.changes[k])
    assert changed > count / 2


def test_dependent_speeds_that_another_thread_wants_first(monkeypatch, rng):
    """Instances that come back for dependent speeds run once more, also where these have been compiled for others since."""
    make, q, u, longest = CONSTRAINED["slider-crank"]
    eom, count, module = kn.derive(make()), 19, run_in_lanes.__globals__
    one, run = stepper(eom), module["_run"]

    def as_another(*given):
        found = run(*given)
        one.numeric.value(module["wanted"]).update(module["choices"](eom))
        return found

    monkeypatch.setitem(module, "_run", as_another)
    p = np.tile([s.default for s in eom.parameters], (count, 1))
    at = kn.assemble(eom, q={**q, "q2": kn.guess(-0.2), "x": kn.guess(0.3)}, u=u)
    starts = np.tile([*at.q.values(), *at.u.values()], (count, 1))
    spans = np.column_stack([np.zeros(count), longest * rng.uniform(0.8, 1, count)])
    way = Method("tsitpap8", TOLERANCE, TOLERANCE, 100_000)
    found = run_in_lanes(one, way, starts, p, np.zeros((count, 0)), spans, spans[:, 1:])
    assert (found.back == ReturnCode.END).all()
    assert all(found.changes)
