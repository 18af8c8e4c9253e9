# SPDX-License-Identifier: BSD-3-Clause
"""Motions that go on from where another one ended, and that are joined."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, four_bar, rolling_disk

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x", "m")
v = kn.speed("v", "m/s")
k, c = kn.parameter("k", 4.0, "N/m"), kn.parameter("c", 0.2, "N*s/m")
g = kn.parameter("g", 2.0, description="a gain of laws, which no load holds")
F = kn.input("F", "N")
P = O.at("P", x * N.x)
HIGH = kn.Event("high", x, threshold=0.5, direction=1)


def system(force=F, events=(), extra=0.0):
    loads = [kn.linear_spring(P, O, k), kn.Force(P, (force - (c + extra) * v) * N.x)]
    return kn.System(N, bodies=[kn.Particle("p", P, 2)], speeds={v: x.dt}, loads=loads, events=events)


EOM = kn.derive(system())
WHOLE = kn.simulate(EOM, (0, 6), q=[1], u=[0.5], inputs={F: kn.sin(kn.time)}, samples=61, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "dop853", "tsitpap8", "tsit5", "DOP853", "Radau"])
def test_a_motion_in_two_parts_is_the_motion(method):
    exact = {"rtol": 1e-10, "atol": 1e-10, "method": method}
    first = kn.simulate(EOM, (0, 2.5), q=[1], u=[0.5], inputs={F: kn.sin(kn.time)}, samples=26, **exact)
    second = kn.simulate(EOM, 6, start=first, samples=36)
    assert (second.rtol, second.atol, second.method) == (1e-10, 1e-10, method)
    assert second.work[0] == first.work[-1]
    assert np.array_equal(second.states[0], first.states[-1])
    both = first + second
    assert np.all(np.diff(both.t) > 0)
    np.testing.assert_allclose(both.t, WHOLE.t, atol=1e-12)
    np.testing.assert_allclose(both.states, WHOLE.states, atol=3e-8)
    np.testing.assert_allclose(both.work, WHOLE.work, atol=3e-8)
    np.testing.assert_allclose(both[F], WHOLE[F], atol=1e-12)
    assert both.energy_check.relative < 1e-7
    assert both.keeps_energy
    assert both.jumps == ()
    assert len(both.phases) == 1
    assert both.steps == first.steps + second.steps


def test_parameters_and_inputs_go_on_unless_given_anew():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], parameters={k: 9.0, c: 0.0}, inputs={F: 3.0})
    second = kn.simulate(EOM, 2, start=first, parameters={k: 1.0})
    assert second.parameters == {k: 1.0, c: 0.0}
    assert set(second[F]) == {3.0}
    third = kn.simulate(EOM, (2, 3), start=second, inputs={F: k * kn.time})
    assert third[F] == pytest.approx(third.t)
    fourth = kn.simulate(EOM, 4, start=third, parameters={k: 2.0})
    assert fourth[F] == pytest.approx(2 * fourth.t)  # the law stays, with what its parameters are now
    whole = first + second + third + fourth
    assert [whole[k][i] for i in (0, len(first), -1)] == [9.0, 1.0, 2.0]
    assert len(whole.jumps) == 3
    assert whole.jumps[0].t == 1
    assert whole.jumps[0].changes == {k: (9.0, 1.0)}
    assert whole.jumps[0].energy == pytest.approx((1.0 - 9.0) * first.q[-1, 0] ** 2 / 2)
    assert whole.keeps_energy
    assert whole.energy_check.relative < 1e-8
    assert np.abs(whole.energy_drift).max() < 1e-7
    work = sum(whole.load_works[load] for load in EOM.loads)
    assert work[-1] == pytest.approx(
        (0.5 * 2 * whole.u[-1, 0] ** 2), abs=1e-5
    )  # all of it went into the kinetic energy
    assert "k: 9 → 1" in repr(whole.jumps[0])


def test_inputs_in_their_order_are_given_anew():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], parameters={k: 9.0, c: 0.0}, inputs=[3.0])
    for given, value in ([2.0], 2.0), (0, 0.0):
        assert set(kn.simulate(EOM, 2, start=first, inputs=given)[F]) == {value}


def test_what_jumps_is_right_on_both_sides():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], inputs={F: 0.0}, samples=11)
    second = kn.simulate(EOM, 2, start=first, inputs={F: 5.0}, samples=11)
    whole = first + second
    assert list(whole.t[10:12]) == [1, 1]
    assert list(whole[F][10:12]) == [0, 5]
    a = whole[x.dt.dt]
    assert a[11] - a[10] == pytest.approx(2.5)
    assert np.interp([0.999999, 1.000001], whole.t, a) == pytest.approx([a[10], a[11]], abs=1e-4)


def test_an_event_that_ended_a_motion_does_not_end_the_next_at_once():
    eom = kn.derive(system(0, [HIGH]))
    for method in ("gauss16", "dop853", "DOP853"):
        first = kn.simulate(eom, (0, 20), q=[0], u=[2], parameters={c: 0.0}, method=method)
        assert first.status == "event"
        second = kn.simulate(eom, 20, start=first)
        assert second.status == "event"
        period = 2 * np.pi / np.sqrt(2)
        assert second.t[-1] - first.t[-1] == pytest.approx(period, abs=1e-7)
        assert [e.name for e, _ in (first + second).events] == ["high", "high"]


def test_files_and_pickles_are_starts(tmp_path):
    first = kn.simulate(
        EOM, (0, 2.5), q=[1], u=[0.5], inputs={F: 1.5}, parameters={k: 5.0}, samples=26, rtol=1e-11, atol=1e-11
    )
    plain = kn.simulate(EOM, 6, start=first)
    first.save(tmp_path / "run.npz")
    for again in (kn.load_solution(tmp_path / "run.npz", EOM), pickle.loads(pickle.dumps(first))):
        second = kn.simulate(EOM, 6, start=again)
        assert np.array_equal(second.states, plain.states)
        assert second.rtol == 1e-11
    whole = first + plain
    kn.simulate(EOM, 7, start=plain, inputs={F: lambda t: 0.0})
    joined = whole + kn.simulate(EOM, 7, start=plain, parameters={k: 1.0}, inputs={F: kn.time})
    joined.save(tmp_path / "both.npz")
    for again in (kn.load_solution(tmp_path / "both.npz", EOM), pickle.loads(pickle.dumps(joined))):
        assert np.array_equal(again[F], joined[F])
        assert np.array_equal(again.energy, joined.energy)
        assert again.energy_check == joined.energy_check
        assert [list(j.changes) for j in again.jumps] == [[k]]
        with pytest.raises(
            kn.SimulationError, match=r"the input F again, inputs=\{F: …\}, as the motion to continue was"
        ):
            kn.simulate(EOM, 9, start=again)


def test_a_sampled_controller_keeps_its_period_and_memory():
    def control(t, x, z):
        return -z - x[0], z + 0.1

    law = {F: kn.sampled(control, 0.3, state=0.0)}
    given = {"q": [1], "u": [0], "inputs": law, "rtol": 1e-11, "atol": 1e-11}
    whole = kn.simulate(EOM, (0, 2), samples=[0.7, 1.9], **given)
    first = kn.simulate(EOM, (0, 0.7), **given)
    for _ in range(2):  # what went on from it has left it as it was
        second = kn.simulate(EOM, 2, start=first, samples=[1.9])
        np.testing.assert_allclose(second.states[-1], whole.states[-1], atol=1e-9)
    both = first + second
    assert both[F][-1] == pytest.approx(whole[F][-1], abs=1e-9)
    assert (len(both.phases), both.jumps) == (1, ())  # nothing changes where one goes on from the other


@pytest.mark.parametrize("law", [-g * c * v, k * x * kn.sin(g * kn.time)])
@pytest.mark.parametrize(("start", "then"), [(5.0, {g: 0.0}), (0.0, {g: 5.0, k: 9.0}), (3.0, {k: 9.0}), (3.0, {})])
def test_gains_of_laws_go_on_unless_given_anew(law, start, then):
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], parameters={g: start}, inputs={F: law})
    own = kn.simulate(EOM, (1, 2), q=first.q[-1], u=first.u[-1], parameters={g: start, **then}, inputs={F: law})
    for given in {}, {"inputs": {F: 1 * law}}:  # the law that goes on, and one that is given with the gains that were
        second = kn.simulate(EOM, 2, start=first, parameters=then, **given)
        np.testing.assert_allclose(second.states, own.states, atol=1e-9)
        np.testing.assert_allclose((first + second)[F][-501:], own[F], atol=1e-8)


def test_a_mechanism_goes_on():
    eom = kn.derive(four_bar.system())
    whole = kn.simulate(eom, (0, 2), **four_bar.START, samples=21)
    first = kn.simulate(eom, (0, 0.9), **four_bar.START, samples=10)
    both = first + kn.simulate(eom, 2, start=first, samples=12)
    np.testing.assert_allclose(both.states, whole.states, atol=1e-6)
    assert both.keeps_energy
    length = next(p for p in eom.parameters if p.unit == "m")
    with pytest.raises(
        kn.SimulationError, match=r"Expected start= whose end satisfies the constraints .* kn\.assemble\(eom"
    ):
        kn.simulate(eom, 2, start=first, parameters={length: 1.1 * first.parameters[length]})


SLIDING = rolling_disk.model()


def test_the_disk_slides_until_it_rolls_and_rolls_on():
    """Upright, on a straight line: it slides for t = v0 / (3 μ g), and rolls at 2/3 of its speed. The rest by the rolling model."""
    m = SLIDING
    friction = kn.friction(m.Ch, m.normal, m.mu, name="friction", threshold=1e-10)
    eom = kn.derive(m.system.replace(loads=[m.system.gravities[0], friction]))
    del friction
    start = {"q": [0, 0, 0, 0, 0], "u": [0, 0, 0, 3.0, 0]}
    sol = kn.simulate(eom, (0, 8), **start, rtol=1e-12, atol=1e-12)
    assert sol.status == "event"
    assert "onset of rolling" in sol.message
    assert sol.t[-1] == pytest.approx(3.0 / (3 * 0.25 * 9.81), rel=1e-9)
    slip = np.linalg.norm(sol[m.slip], axis=1)
    assert slip[-1] <= 1.1e-10
    assert sol["u4"][-1] == pytest.approx(2.0, rel=1e-9)
    rolling = kn.derive(rolling_disk.model(contact="rolling").system)
    on = kn.simulate(rolling, 8, start=sol)
    assert on["q4"][-1] == pytest.approx(sol["q4"][-1] + 2.0 * (8 - sol.t[-1]), abs=1e-8)
    assert on.status == "finished"


@pytest.mark.slow
def test_the_disk_that_leans_and_turns_rolls_on_from_where_it_has_slid():
    """Beside a motion at 1e-13 by another method: its time to 1e-9, and what comes 8 s later to 1e-8."""
    friction = kn.friction(SLIDING.Ch, SLIDING.normal, SLIDING.mu, name="friction", threshold=1e-10)
    eom = kn.derive(SLIDING.system.replace(loads=[SLIDING.system.gravities[0], friction]))
    rolling = kn.derive(rolling_disk.model(contact="rolling").system)
    ends = []
    for method, rtol, atol in (("auto", 1e-12, 1e-12), ("dop853", 1e-13, 1e-15)):
        given = {"method": method, "rtol": rtol, "atol": atol}
        sol = kn.simulate(eom, (0, 8), q=[0, 0.2, 0, 0, 0], u=[0.3, 0.5, -8, 1.0, 0.2], samples=2, **given)
        assert "onset of rolling" in sol.message
        on = kn.simulate(rolling, sol.t[-1] + 8, start=sol, samples=2, method="auto", rtol=1e-12, atol=1e-12)
        ends.append((sol.t[-1], on.states[-1]))
    (t, x), (exact_t, exact_x) = ends
    assert t == pytest.approx(exact_t, abs=1e-9)
    np.testing.assert_allclose(x, exact_x, atol=1e-8)


def test_errors():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], inputs={F: 0.0})
    cases = [
        (EOM, 2, {"start": first, "q": [1]}, r"Expected start= or start values, got both, q= beside start="),
        (EOM, (0.5, 2), {"start": first}, r"begins at the time of the start values, t = 1, got one from 0\.5"),
        (EOM, 0.5, {"start": first}, r"with t1 > t0, got \(1, 0\.5\)"),
        (EOM, (0, 2), {}, r"Expected start values, q= and u=, got none"),
        (EOM, 2, {"q": [1], "u": [0]}, r"Expected a time span"),
        (EOM, 2, {"start": "run.npz"}, r"a motion to continue or to join, got 'run\.npz'"),
        (kn.derive(double_pendulum.system()), 2, {"start": first}, r"with the coordinates q1, q2, got one with x"),
    ]
    for eom, span, given, message in cases:
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(eom, span, **given)
    heavy = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2.001)], speeds={v: x.dt}))
    with pytest.raises(kn.SimulationError, match=r"of the same bodies, got one along which the kinetic energy is"):
        kn.simulate(heavy, 2, start=first)
    other = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2)], speeds={v: 2 * x.dt}))
    with pytest.raises(kn.SimulationError, match=r"of the same bodies, got one along which x' is"):
        kn.simulate(other, 2, start=first)
    free = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2)], speeds={v: x.dt}))
    on = kn.simulate(free, 2, start=first)  # the same body without its loads
    assert on["v"][-1] == first["v"][-1]
    with pytest.raises(kn.SimulationError, match=r"Expected motions of the same equations to join"):
        first + on
    with pytest.raises(kn.SimulationError, match=r"begins at t = 1, where the first one ends, got one from 0"):
        first + first
    with pytest.raises(TypeError):
        first + 1


def rope():
    """A mass on a rope of length 1, taut and slack: the equations, each with the event that ends them."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    v, w = kn.speeds("v w")
    P = O.at("P", x * N.x + y * N.y)
    model = {
        "bodies": [kn.Particle("mass", P, 1)],
        "speeds": {v: x.dt, w: y.dt},
        "loads": [kn.gravity(-9.81 * N.y)],
    }
    tension = v**2 + w**2 - 9.81 * y
    taut = kn.System(N, **model, holonomic=[kn.distance(O, P, 1)], events=[kn.Event("slack", tension, direction=-1)])
    slack = kn.System(N, **model, events=[kn.Event("taut", kn.sqrt(x**2 + y**2) - 1, direction=1)])
    return kn.derive(taut), kn.derive(slack)


ROPE = rope()


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("speed", [4.8, 5.3, 5.9, 6.6])
def test_a_rope_that_goes_slack_is_not_taut_at_once(rtol, speed):
    """The length begins at its threshold, its first two rates being what tolerances leave: the third one says where it goes.

    The mass flies on a parabola that meets the circle again after 4 w/g, w the speed upwards.
    """
    taut, slack = ROPE
    held = kn.simulate(taut, (0, 5), q=[0, -1], u=[speed, 0], rtol=rtol, atol=rtol)
    flown = kn.simulate(slack, 9, start=held)
    assert (held.event.name, flown.event.name) == ("slack", "taut")
    assert flown.t[-1] - held.t[-1] == pytest.approx(4 * held.u[-1, 1] / 9.81, rel=1e4 * rtol)
    q, u = flown.q[-1], flown.u[-1]
    assert q @ q == pytest.approx(1, abs=1e-11)  # and so the next phase may begin there, with what is left of the speed
    again = kn.simulate(taut, (flown.t[-1], 9), start=kn.State(q, u - (u @ q) * q, t=flown.t[-1]), samples=3)
    assert again.t[-1] > flown.t[-1] + 0.1


def test_a_joined_motion_goes_on_as_its_last_part():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], inputs={F: 0.0}, rtol=1e-5, atol=1e-5, method="tsit5", max_step=0.01)
    second = kn.simulate(EOM, 2, start=first, rtol=1e-11, atol=1e-11, method="vern9", max_step=0.5)
    one, two = (kn.simulate(EOM, 3, start=sol) for sol in (first + second, second))
    assert np.array_equal(one.states, two.states)
    assert (one.method, one.rtol) == ("vern9", 1e-11)


def test_the_time_of_the_start_is_not_passed_over():
    first = kn.simulate(EOM, (0, 1), q=[1], u=[0], inputs={F: 0.0})
    assert kn.simulate(EOM, 2, start=first, t=1.0).t[0] == 1.0
    with pytest.raises(kn.SimulationError, match="begins at the time of the start values, t = 3"):
        kn.simulate(EOM, 2, start=first, t=3.0)
