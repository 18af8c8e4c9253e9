# SPDX-License-Identifier: BSD-3-Clause
"""Motions prepared once, and those of which `simulate` keeps what it needs: the same motion, bit for bit, as one begun anew."""

import pickle
import sys
import threading
import warnings
from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane.gallery import chaplygin_sleigh, four_bar, pendulums, pure_rolling_disk, rolling_disk, slider_crank
from kane.program import Bound
from tests.systems import thrown_stone
from tests.systems.thrown_stone import FLOOR, E

TWO = kn.derive(pendulums.system(2))
FOUR = kn.derive(four_bar.system())
START = {"q": [1.57, 1.67], "u": [0, 0]}
SPAN = (0, 3)

x, v = kn.coordinate("x"), kn.speed("v")
m, k, e = kn.parameter("m", 2.0), kn.parameter("k"), kn.parameter("e", 0.8)
F = kn.input("F")
N = kn.Frame("N")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)


def block(*loads, **more):
    """A block on a line."""
    return kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("block", P, m)],
            speeds={v: x.dt},
            loads=[kn.Force(P, f * N.x) for f in loads],
            **more,
        )
    )


BALL = kn.System(
    N,
    bodies=[kn.Particle("ball", P, 1)],
    speeds={v: x.dt},
    loads=[kn.Force(P, -9.81 * N.x)],
    events=[kn.Event("bounce", x, direction=-1, then={v: -0.9 * v})],
)


def anew(eom, span=SPAN, **given):
    """A motion of equations that have seen none."""
    return kn.simulate(kn.derive(eom.system), span, **given)


def same(one, other):
    """Whether two motions are the same to the bit, and say the same of themselves."""
    told = ("status", "message", "steps", "evaluations", "method", "rtol", "atol")
    arrays = all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ("t", "states", "work", "phase"))
    names = [[(event.name, t) for event, t in motion.events] for motion in (one, other)]
    return arrays and names[0] == names[1] and all(getattr(one, name) == getattr(other, name) for name in told)


@pytest.mark.parametrize("samples", [2, 501, [0.5, 1.25], [3.0]])
@pytest.mark.parametrize("method", ["auto", "dop853", "radau9", "midpoint"])
def test_a_prepared_motion_is_that_of_simulate(method, samples):
    options = {"method": method, "samples": samples} | ({"max_step": 0.01} if method == "midpoint" else {})
    run = kn.prepare(TWO, SPAN, **options)
    assert run.in_one_call
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # a fixed step keeps no energy
        first = anew(TWO, **START, **options)
        for _ in range(2):
            assert same(run(**START), first)
        for _ in range(3):
            assert same(kn.simulate(TWO, SPAN, **START, **options), first)


def test_each_call_has_parameters_of_its_own():
    run = kn.prepare(TWO, SPAN)
    for given in (None, {"m1": 3.0}, {"m1": 3.0, "l2": 0.7}, None):
        motion = run(**START, parameters=given)
        assert same(motion, anew(TWO, **START, parameters=given))
        assert motion.parameters == anew(TWO, **START, parameters=given).parameters
    for given in ({"m1": 3.0}, None):  # an implicit method's derivatives have them too
        stiff = kn.prepare(TWO, SPAN, method="radau9")
        stiff(**START)
        assert same(stiff(**START, parameters=given), anew(TWO, **START, parameters=given, method="radau9"))


def test_a_motion_does_not_change_with_the_next_one():
    run = kn.prepare(TWO, SPAN, samples=5)
    first = run(**START)
    kept = first.states.copy(), first.t.copy(), dict(first.parameters)
    run(q=[0.3, 0.2], u=[1, 1], parameters={"m1": 9})
    assert np.array_equal(first.states, kept[0])
    assert np.array_equal(first.t, kept[1])
    assert dict(first.parameters) == kept[2]
    first.states[:] = 0  # nor the next one with it
    assert same(run(**START), anew(TWO, **START, samples=5))


def test_inputs_that_are_numbers_stay_and_others_are_asked():
    eom = block(F - k * x)
    constant = kn.prepare(eom, SPAN, inputs={F: 2.5})
    assert constant.in_one_call
    assert same(
        constant([1], [0], parameters={"k": 3}), anew(eom, q=[1], u=[0], inputs={"F": 2.5}, parameters={"k": 3})
    )
    other = kn.prepare(eom, SPAN, inputs={F: lambda t: np.sin(t)})
    assert not other.in_one_call
    assert other([1], [0], parameters={"k": 3}).q[-1] == pytest.approx(
        kn.simulate(eom, SPAN, q=[1], u=[0], inputs={F: kn.sin(kn.time)}, parameters={"k": 3}).q[-1], abs=1e-7
    )
    controller = kn.prepare(eom, SPAN, inputs={F: kn.sampled(lambda t, s: -3 * s[1], 0.1)})
    given = {"inputs": {F: kn.sampled(lambda t, s: -3 * s[1], 0.1)}, "parameters": {"k": 3}}
    for _ in range(2):  # it begins anew each time
        assert same(controller([1], [0], parameters={"k": 3}), anew(eom, q=[1], u=[0], **given))


@pytest.mark.parametrize("method", ["gauss16", "dop853", pytest.param("radau9", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "law",
    [
        -2 * x - 3 * v,
        kn.table([0, 0.7, 1.9], [2, -1, 3], "steps")(kn.time),
        kn.sin(3 * kn.time) - v,
        -kn.sign(x - 0.3) - 0.2 * v,
    ],
    ids=["feedback", "steps", "time and state", "relay"],
)
def test_inputs_that_are_expressions_are_known_beforehand(law, method):
    eom = block(F - k * x)
    run = kn.prepare(eom, SPAN, inputs={F: law}, method=method)
    assert run.in_one_call
    for start in ({"q": [1], "u": [0]}, {"q": [0.2], "u": [-1]}):
        for value in (3, 5):
            given = start | {"parameters": {"k": value}}
            assert same(run(**given), anew(eom, **given, inputs={F: law}, method=method))


def test_inputs_that_hold_parameters_follow_these():
    """Gains may be other ones in each call."""
    eom, gain = block(F - k * x), kn.parameter("gain", 1.0)
    run = kn.prepare(eom, SPAN, inputs={F: -gain * v})
    assert run.in_one_call
    for value in (0.5, 2.0):
        given = {"q": [1], "u": [0], "parameters": {k: 3, gain: value}}
        assert same(run(**given), anew(eom, **given, inputs={F: -gain * v}))


def test_repeated_motions_differ_by_their_inputs():
    eom = block(F - k * x)
    ends = [
        kn.simulate(eom, SPAN, q=[1], u=[0], inputs={F: f}, parameters={"k": 3}).q[-1, 0]
        for f in (1, 2, 1.0, 2.0, 1, 2)
    ]
    assert ends[0] == ends[2] == ends[4] != ends[1] == ends[3] == ends[5]


def test_a_count_of_samples_is_no_time():
    eom = block(-k * x)
    for samples, expected in ((np.int64(11), 11), (np.int64(11), 11), ([11.0], 3)):
        assert len(kn.simulate(eom, (0, 20), q=[1], u=[0], parameters={"k": 3}, samples=samples)) == expected


def test_an_event_that_python_decides_is_looked_after_on_the_way():
    eom = kn.derive(BALL.replace(events=[kn.Event("rest", x, then=lambda **now: {v: 0.0})]))
    run = kn.prepare(eom, (0, 0.5))
    assert not run.in_one_call
    assert same(run([1], [0.4]), anew(eom, (0, 0.5), q=[1], u=[0.4]))


@pytest.mark.parametrize("system", [chaplygin_sleigh, four_bar, slider_crank], ids=lambda m: m.__name__.split(".")[-1])
@pytest.mark.parametrize("method", ["gauss16", "dop853"])
def test_constraints_are_kept_in_one_call(system, method):
    """Starts that are sought, and known ones, other parameters, and other dependent speeds on the way: as anew, to the bit."""
    eom = kn.derive(system.system())
    run = kn.prepare(eom, (0, 1.5), method=method, samples=31)
    assert run.in_one_call
    start = getattr(
        system, "START", {"q": [0.3] * len(eom.coordinates), "u": dict.fromkeys(eom.independent_speeds, 0.4)}
    )
    heavier = {"parameters": {eom.parameters[-1]: 1.5 * eom.parameters[-1].default}}
    for given in (start, start, start | heavier, start):
        one, other = run(**given), anew(eom, (0, 1.5), **given, method=method, samples=31)
        # a step is taken again where dependent speeds are compiled that it wants for the first time
        assert same(replace(one, evaluations=other.evaluations), other)
        places = [[(s.start, s.equations.dependent_speeds) for s in motion.segments] for motion in (one, other)]
        assert str(places[0]) == str(places[1])
        assert [e.dependent_speeds for e in one.samples] == [e.dependent_speeds for e in other.samples]


def test_between_start_and_end_no_python_is_called(monkeypatch):
    """A linkage with dry friction in its crank's pin, driven by a table of steps, its dead centres noted: one call of machine code."""
    linkage = FOUR.system
    T, q1, speed = kn.input("T"), FOUR.coordinates[0], FOUR.speeds[0]
    crank = next(b for b in linkage.bodies if b.name == "crank")
    loads = [*linkage.loads, kn.Torque(crank.frame, (T - 0.3 * kn.sign(speed)) * crank.frame.z)]
    events = [kn.Event("dead centre", kn.sin(q1), terminal=False)]
    eom = kn.derive(linkage.replace(loads=loads, events=events))
    given = four_bar.START | {"inputs": {T: kn.table([0, 0.5, 1, 1.5], [2, -6, 3, 1], "steps")(kn.time)}, "samples": 41}
    first, calls = kn.simulate(eom, (0, 1.8), **given), []
    call = Bound.__call__

    def watched(self, **integers):
        seen = []
        sys.setprofile(lambda frame, event, what: seen.append(event))
        try:
            return call(self, **integers)
        finally:
            sys.setprofile(None)
            calls.append(seen.count("call"))

    monkeypatch.setattr(Bound, "__call__", watched)
    again = kn.simulate(eom, (0, 1.8), **given)
    assert first.status == again.status == "finished"
    assert len({np.sign(u) for u in first[speed]}) > 1
    assert sum(event.name == "dead centre" for event, _ in first.events) > 1
    assert np.array_equal(first.states, again.states)
    assert calls == [1]  # that of the kernel itself


def test_what_is_wrong_is_said_as_ever():
    run = kn.prepare(block(-k * x), SPAN)
    with pytest.raises(kn.errors.ValueMissingError, match="got none for k"):
        run([1], [0])
    with pytest.raises(kn.SimulationError, match="Expected a mass ≥ 0 for block, got m = -2"):
        run([1], [0], parameters={"k": 1, "m": -2})
    with pytest.raises(kn.SimulationError, match="finite rates at the start"):
        run([1], [0], parameters={"k": 1, "m": 0})
    with pytest.raises(kn.errors.ValueMissingError, match="Expected 1 coordinates"):
        run([1, 2], [0], parameters={"k": 1})
    with pytest.raises(kn.SimulationError, match="finite start value for x"):
        run(np.array([np.nan]), [0], parameters={"k": 1})
    assert run([1], [0], parameters={"k": 1}).status == "finished"
    with pytest.raises(kn.SimulationError, match="t1 > t0"):
        kn.prepare(TWO, (1, 0))
    with pytest.raises(kn.SimulationError, match="Expected method to be one of"):
        kn.prepare(TWO, SPAN, method="euler")
    with pytest.raises(kn.SimulationError, match="start values"):
        run(None, [0], parameters={"k": 1})


def test_a_mass_matrix_that_is_singular_by_chance_is_named():
    """The determinant is what rounding leaves: rates are finite, and mean nothing."""
    s, w = kn.coordinate("s"), kn.speed("w")
    a, b = kn.parameters("a b")
    origin = kn.Point("O", fixed_in=N)
    one = origin.at("one", (0.7 * x + a * s) * N.x)
    two = origin.at("two", (2.1 * x + b * s) * N.x)
    system = kn.System(
        N,
        bodies=[kn.Particle("first", one, 0.1), kn.Particle("second", two, 0.2)],
        speeds={v: x.dt, w: s.dt},
        loads=[kn.Force(one, -x * N.x)],
    )
    eom = kn.derive(system)
    given = {"q": [1, 0], "u": [0, 1], "parameters": {"a": 0.1, "b": 0.3}}
    with pytest.raises(kn.SimulationError, match="finite rates at the start, got none for") as first:
        anew(eom, **given)
    run = kn.prepare(eom, SPAN)
    assert run([1, 0], [0, 1], parameters={"a": 0.1, "b": 0.4}).status == "finished"
    with pytest.raises(kn.SimulationError) as told:
        run(**given)
    assert str(told.value) == str(first.value)


def test_kinematics_that_can_be_singular_are_judged_at_the_start():
    """Where W has a pole that the motion has not, other speeds go on: a prepared motion is that begun anew there, too.

    From the pole itself every step is some 1e-22 s long: a few hundred are as good as ten thousand.
    """
    eom = kn.derive(pure_rolling_disk.system())
    run, start = kn.prepare(eom, SPAN, max_steps=300), pure_rolling_disk.START
    assert run.in_one_call
    found = []
    for given in (start, {"q": start["q"] | {"q2": np.pi / 2}, "u": start["u"]}, start):
        found.append(run(**given))
        assert same(found[-1], anew(eom, SPAN, max_steps=300, **given))
    assert [motion.status for motion in found] == ["finished", "stopped", "finished"]


def test_a_motion_that_loses_energy_warns_each_time():
    start = {"q": [1.0], "u": [0.0], "parameters": {"k": 400.0}}
    run = kn.prepare(block(-k * x), SPAN, method="rk4", max_step=0.04)
    for call in (lambda: run(**start), lambda: kn.simulate(run.equations, SPAN, method="rk4", max_step=0.04, **start)):
        for _ in range(3):
            with pytest.warns(kn.KaneWarning, match="E − ∫P dt constant"):
                call()


def test_functions_are_checked():
    run = kn.prepare(block(-k * x), SPAN, check=[m * v**2 / 2 + k * x**2 / 2])
    run([1], [0], parameters={"k": 4})
    other = kn.prepare(run.equations, SPAN, check=[x])
    with pytest.warns(kn.KaneWarning, match="Expected x constant"):
        other([1], [0], parameters={"k": 4})
    with pytest.raises(kn.errors.ArgumentError, match="Expected a list of integrals"):
        kn.prepare(run.equations, SPAN, check="x")


def test_many_steps_and_their_bounds():
    """Beyond a thousand steps Python looks at the clock; where steps run out, what was reached is kept."""
    eom, long = block(-k * x), (0, 400)
    given = {"parameters": {"k": 100.0}, "method": "dop853"}
    run = kn.prepare(eom, long, method="dop853")
    whole = run([1], [0], parameters=given["parameters"])
    assert whole.steps > 1000
    assert same(whole, anew(eom, long, q=[1], u=[0], **given))
    for most in (7, 1000, 1500):
        few = kn.prepare(eom, long, method="dop853", max_steps=most)([1], [0], parameters=given["parameters"])
        assert (few.status, few.steps) == ("stopped", most)
        assert same(few, anew(eom, long, q=[1], u=[0], max_steps=most, **given))
    late = kn.prepare(eom, (0, 1e7), method="dop853", max_seconds=0.05, max_steps=10**9)(
        [1], [0], parameters=given["parameters"]
    )
    assert late.message.startswith("max_seconds=0.05 have passed")
    assert 0 < late.t[-1] < 1e7


def test_stiffness_is_seen():
    """A fast damper: "auto" goes over to the implicit method, prepared or not."""
    eom = block(-1e6 * v - k * x)
    given = {"q": [1], "u": [0], "parameters": {"k": 1.0}}
    first = anew(eom, (0, 5), **given)
    assert "radau9" in first.method
    run = kn.prepare(eom, (0, 5))
    for _ in range(2):
        assert same(run(**given), first)


def test_threads_have_arrays_of_their_own():
    run = kn.prepare(TWO, SPAN, samples=51)
    starts = np.random.default_rng(3).uniform(-2, 2, (24, 2))
    wanted = [run(q, [0, 0]).states for q in starts]
    found = [None] * len(starts)

    def work(own):
        for i in own:
            found[i] = run(starts[i], [0, 0]).states

    threads = [threading.Thread(target=work, args=(range(i, len(starts), 4),)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(wanted, found, strict=True))


def test_a_prepared_motion_can_be_taken_once_more():
    run = kn.prepare(TWO, SPAN, samples=11)
    motion = run(**START, parameters={"m1": 2})
    assert np.array_equal(motion.at([3.0]).states[-1], motion.states[-1])
    assert motion.at([0.05]).q == pytest.approx(
        anew(TWO, **START, parameters={"m1": 2}, samples=[0.05]).q[1:2], abs=1e-9
    )
    assert motion.accuracy().relative < 1e-5
    longer = kn.simulate(TWO, 4, start=motion)
    assert longer.t[0] == 3
    assert len(motion + longer) > 11
    assert np.array_equal(pickle.loads(pickle.dumps(motion)).states, motion.states)


def test_it_says_what_it_is():
    run = kn.prepare(TWO, SPAN)
    assert "t = 0 … 3 s, in one call of machine code" in repr(run)
    assert "as by kn.simulate" in repr(kn.prepare(kn.derive(rolling_disk.system()), SPAN))
    assert (run.equations, run.span) == (TWO, (0.0, 3.0))
    assert np.array_equal(pickle.loads(pickle.dumps(run))(**START).states, run(**START).states)


def jumping(sol):
    """What is told of events and phases."""
    return [[e.name for e in jump.events] + [jump.t, jump.energy] for jump in sol.jumps]


@pytest.mark.parametrize("method", ["auto", "dop853", "radau9"])
@pytest.mark.parametrize(
    ("events", "status"),
    [
        ([kn.Event("bounce", x, direction=-1, then={v: -0.9 * v})], "finished"),
        ([kn.Event("top", v, direction=-1, terminal=False)], "finished"),
        ([kn.Event("bounce", x, then={v: -e * v}, direction=-1), kn.Event("late", kn.time - 1.3)], "event"),
        ([kn.Event("bounce", x, direction=-1, then={v: -0.5 * v}), kn.Event("low", v**2 + 19.62 * x - 5)], "event"),
        ([kn.Event("out", x, direction=-1, then={x: 1.0, v: 0.0}, terminal=True)], "event"),
    ],
)
def test_events_are_those_of_simulate(events, status, method):
    """Located, noted, acted on, and the end of the motion, in one call; parameters change from call to call."""
    eom = kn.derive(BALL.replace(events=events))
    run = kn.prepare(eom, SPAN, method=method, samples=[0.25, 1.0, 2.0, 3.0])
    assert run.in_one_call
    parameters = [{e: value} for value in (0.9, 0.5, 0.9)] if e in eom.parameters else [None, None]
    for values in parameters:
        given = {"q": [1.0], "u": [0.5], "parameters": values}
        first = anew(eom, method=method, samples=[0.25, 1.0, 2.0, 3.0], **given)
        found = run(**given)
        assert (found.status, first.status) == (status, status)
        assert same(found, first)
        assert jumping(found) == jumping(first)


def test_more_events_than_are_noted_at_a_time():
    """A ball that bounces some three hundred times, and one that comes to rest: what is not sure is simulated from the start."""
    quick = kn.derive(BALL.replace(events=[kn.Event("bounce", x, direction=-1, then={v: -v})]))
    first, found = (kn.simulate(quick, (0, 30), q=[0.0125], u=[0], rtol=1e-11, atol=1e-11) for _ in range(2))
    again = kn.simulate(quick, (0, 30), q=[0.0125], u=[0], rtol=1e-11, atol=1e-11)
    assert len(first.jumps) > 250
    assert same(first, found)
    assert same(first, again)
    rests = [
        kn.simulate(kn.derive(BALL), (0, 60), q=[1], u=[0]),
        *(kn.simulate(REST, (0, 60), q=[1], u=[0]) for _ in range(3)),
    ]
    assert {sol.status for sol in rests} == {"stopped"}
    assert len({sol.message for sol in rests}) == 1


REST = kn.derive(BALL)


def test_a_motion_with_events_calls_python_neither_for_steps_nor_events(monkeypatch):
    """Between start and end the kernel is called once, and nothing that looks at steps is."""
    from kane.motion import Course

    calls = []
    for name in ("advance", "judge"):
        own = getattr(Course, name)
        monkeypatch.setattr(Course, name, lambda *args, own=own, name=name: (calls.append(name), own(*args))[1])
    sol = anew(kn.derive(BALL), q=[1.0], u=[0.0])
    assert (calls, len(sol.jumps)) == (["advance"], 4)
    calls.clear()
    disk = kn.simulate(kn.derive(rolling_disk.system()), (0, 9), q=[0, 0, 0.3, 1.2, 0.1], u=[1.0, -0.5, 3.0, 0.5, 0.2])
    assert disk.event.name == "onset of rolling (friction)"
    assert calls == ["advance"]


@pytest.mark.parametrize("method", ["gauss16", "dop853", "tsitpap8", "radau9"])
def test_samples_at_the_instants_of_events(method):
    """No row is lost, doubled or left as it was, whichever way rounding leads the event beside a sample."""
    instants = [0.3, 0.7, 1.1, 2.0, 2.9]
    events = [kn.Event(f"e{n}", kn.time - t, direction=1, then={v: 1.0 + n - v}) for n, t in enumerate(instants)]
    eom = kn.derive(BALL.replace(events=events))
    given = {"method": method, "samples": sorted([*instants, 0.1, 0.9, 1.5, 2.5, 3.0])}
    begins = [(0.0, 1.0, 0.0)]  # of each phase, by the closed form
    for n, t in enumerate(instants):
        t0, x0, v0 = begins[-1]
        fallen = v0 - 9.81 * (t - t0)
        begins.append((t, x0 + (v0 + fallen) / 2 * (t - t0), 1.0 + n - fallen))
    for sol in (kn.simulate(eom, SPAN, q=[1], u=[0], **given) for _ in range(3)):
        t0, x0, v0 = np.array(begins)[sol.phase].T
        dt = sol.t - t0
        assert set(np.round(sol.t, 9)) == {0.0, *given["samples"]}
        assert len(sol.jumps) == len(instants)
        assert np.abs(sol.states - np.transpose([x0 + v0 * dt - 9.81 / 2 * dt**2, v0 - 9.81 * dt])).max() < 1e-11


def test_samples_that_are_written_alike_are_not_taken_for_each_other():
    """A number of samples, a time, and times in two rows, of the same bytes."""
    eom = block(-x)
    start = {"q": [1], "u": [0]}
    for _ in range(3):
        assert kn.simulate(eom, (0, 6), samples=[4.0], **start).t.tolist() == [0, 4, 6]
        assert kn.simulate(eom, (0, 6), samples=[1.0, 2.0], **start).t.tolist() == [0, 1, 2, 6]
    assert kn.simulate(eom, (0, 6), samples=np.int64(4), **start).t.tolist() == [0, 2, 4, 6]
    with pytest.raises(kn.SimulationError, match=r"array of shape \(1, 2\)"):
        kn.simulate(eom, (0, 6), samples=[[1.0, 2.0]], **start)
    with pytest.raises(kn.SimulationError, match="Expected method to be one of auto"):
        kn.simulate(eom, (0, 6), method=np.array(["gauss16", "vern9"]), **start)


def test_motions_with_contacts_are_one_call():
    """Once modes are known a motion is one call of the kernel, and the same in all that is told of it."""
    eom = kn.derive(thrown_stone.SYSTEM)
    run = kn.prepare(eom, (0, 2), samples=11)
    assert run.in_one_call
    given = [
        {"q": [0, h], "u": [1, 0], "parameters": {E: k}} for h, k in ((1.0, 0.6), (0.0, 0.6), (0.5, 0.0), (1.0, 0.9))
    ]
    for own in given * 2:
        first = kn.simulate(kn.derive(eom.system), (0, 2), samples=11, **own)
        sol = run(**own)
        for name in ("t", "states", "work", "phase"):
            np.testing.assert_array_equal(getattr(sol, name), getattr(first, name))
        for name in ("status", "message", "steps", "evaluations", "method", "mode_history", "parameters"):
            assert getattr(sol, name) == getattr(first, name)
        assert [(e.name, t) for e, t in sol.events] == [(e.name, t) for e, t in first.events]
        assert [(j.t, str(j)) for j in sol.jumps] == [(j.t, str(j)) for j in first.jumps]
        np.testing.assert_array_equal(sol[FLOOR.normal_force], first[FLOOR.normal_force])
        np.testing.assert_array_equal(sol.at(1.1).states, first.at(1.1).states)
    with pytest.raises(kn.ModelError, match=r"restitution from 0 to 1"):
        run(**given[0] | {"parameters": {E: 1.5}})
