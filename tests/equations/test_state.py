# SPDX-License-Identifier: BSD-3-Clause
"""`kn.State`: one record in place of q=, u=, states=, parameters=, inputs= and t=, with the same results."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar, pendulums
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q, u = kn.coordinate("q", "rad"), kn.speed("u", "rad/s")
m, L, g = kn.parameter("m", 1.2, "kg"), kn.parameter("L", 0.5, "m"), kn.parameter("g", 9.81, "m/s^2")
C, S = kn.parameter("C", 0.0, "N*m"), kn.parameter("S", 1.0, "s")
T, act = kn.input("T", "N*m"), kn.state("act", 0.2)
A = N.rotate("A", q, N.z)
P = O.at("P", L * A.x)
LOADS = [
    kn.gravity(-g * N.y),
    kn.Torque(A, (T + act + C * kn.sin(kn.time / S)) * N.z, name="motor"),
]
EOM = kn.derive(
    kn.System(N, bodies=[kn.Particle("bob", P, m)], speeds={u: q.dt}, loads=LOADS, states={act: -2 * act + T})
)
GROUPS: dict[str, Any] = {
    "q": {"q": 0.3}, "u": [0.7], "states": {act: 0.1}, "parameters": {"m": 2.0, C: 0.3}, "inputs": {T: 0.4}, "t": 0.5,
}  # fmt: skip
STATE = kn.State(**GROUPS)
NEAR: dict[str, Any] = {"q": {q: kn.guess(-1.5)}, "u": {u: 0.0}, "inputs": {T: 0.1}, "parameters": {L: 0.7}}

x, y = kn.coordinates("x y", "m")
v, w = kn.speeds("v w", "m/s")
BEAD = O.at("B", x * N.x + y * N.y)
ROD = kn.distance(BEAD, O, kn.parameter("R", 1.0, "m"), name="rod")
WEIGHT = kn.gravity(-9.81 * N.y)
CLOSED = kn.derive(
    kn.System(N, bodies=[kn.Particle("bead", BEAD, 1.0)], speeds={v: x.dt, w: y.dt}, loads=[WEIGHT], holonomic=[ROD])
)


def same(one: Any, other: Any) -> None:
    """Numbers alike, whatever record holds them."""
    if isinstance(one, kn.State):
        one, other = (s.arguments for s in (one, other))
        assert one == other
    else:
        np.testing.assert_array_equal(np.asarray(one, dtype=float), np.asarray(other, dtype=float))


def test_evaluation_and_derivatives():
    wanted = [u.dt, kn.state("act", 0.2).dt, EOM.kinetic_energy]
    same(EOM.evaluate(wanted, STATE), EOM.evaluate(wanted, **GROUPS))
    jacobian = EOM.jacobian()
    same(jacobian.at(STATE), jacobian.at(**GROUPS))
    same(EOM.reaction_condition(STATE), EOM.reaction_condition(**GROUPS))
    inverse = kn.inverse(EOM, [T])
    values = {k: v for k, v in GROUPS.items() if k != "inputs"}
    same(inverse(STATE, given={u.dt: 1.0})[T], inverse(**values, given={u.dt: 1.0})[T])


def test_many_states_at_once():
    angles = np.linspace(0, 1, 4)
    state = kn.State(q=[angles], u=[0.0], inputs={"T": angles}, t=angles)
    assert EOM.evaluate(u.dt, state).shape == (4,)
    same(EOM.evaluate(u.dt, state), EOM.evaluate(u.dt, q=[angles], u=[0.0], inputs={T: angles}, t=angles))


def test_steady_motions_and_linearization():
    point = kn.trim(EOM, kn.State(**NEAR))
    assert isinstance(point, kn.State)
    same(point, kn.trim(EOM, **NEAR))
    same(point, kn.equilibrium(EOM, kn.State(**NEAR | {"u": {u: 5.0}})))
    for linear in (kn.linearize(EOM, point), kn.analysis.linearizer(EOM)(point)):
        same(linear.A, kn.linearize(EOM, **point.arguments).A)
        same(linear.point, point)
    branch = kn.analysis.continuation(EOM, "L", [0.5, 1.0], kn.State(**NEAR))
    again = kn.analysis.continuation(EOM, "L", [0.5, 1.0], **NEAR)
    same(branch.eigenvalues.imag, again.eigenvalues.imag)
    assert all(isinstance(p, kn.State) for p in branch.points)


def test_constrained_states():
    start = kn.State({x: 0.6, y: kn.guess(-1)}, {v: 0.2}, parameters={"R": 1.0})
    found = kn.assemble(CLOSED, start)
    by_keyword = kn.assemble(CLOSED, q=start.q, u=start.u, parameters=start.parameters)
    same(found.state, by_keyword.state)
    assert (found.q, found.u) == (found.state.q, found.state.u)
    assert found.q[y] == pytest.approx(-0.8)
    assert kn.assemble(CLOSED, start, all_branches=True)[0].q == found.q
    forces = kn.analysis.constraint_forces
    (one,), (other,) = (
        f.by_multipliers.values()
        for f in (forces(CLOSED, found.state), forces(CLOSED, q=found.q, u=found.u, parameters={"R": 1.0}))
    )
    assert one == other


def test_impacts():
    M = kn.Frame("M")
    ground = kn.Point("ground", fixed_in=M)
    h, fall = kn.coordinate("h", "m"), kn.speed("fall", "m/s")
    body = M.rotate("ball", 0, M.z)
    center = ground.at("center", h * M.y)
    ball = kn.RigidBody("ball", frame=body, mass_center=center, mass=1.0, inertia=kn.inertia(body, 1, 1, 1))
    eom = kn.derive(kn.System(M, bodies=[ball], speeds={fall: h.dt}))
    low = center.fixed_in(body, "low", -0.1 * M.y)
    blow = kn.analysis.impact(eom, low, M.y, kn.State([0.1], [-2.0]), restitution=0.5)
    again = kn.analysis.impact(eom, low, M.y, restitution=0.5, q=[0.1], u=[-2.0])
    assert blow.u[fall] == again.u[fall] == pytest.approx(1.0)
    same(blow.impulse, again.impulse)


def test_motions():
    one, other = kn.simulate(EOM, (0.5, 1), start=STATE), kn.simulate(EOM, (0.5, 1), **GROUPS)
    same(one.states, other.states)
    found = kn.assemble(CLOSED, q={x: 0.6, y: kn.guess(-1)}, u={v: 0.2})
    same(kn.simulate(CLOSED, (0, 1), start=found.state).q, kn.simulate(CLOSED, (0, 1), q=found.q, u=found.u).q)
    with pytest.raises(kn.errors.ArgumentError, match="Expected values of q in the state or by keyword, got both"):
        kn.simulate(EOM, (0.5, 1), start=STATE, q=[0.1])
    with pytest.raises(kn.errors.SimulationError):
        kn.simulate(EOM, (0, 1), start=STATE)


def test_values_beside_a_state():
    """Keywords complete a state, and may not contradict it."""
    rest = {k: v for k, v in GROUPS.items() if k not in ("inputs", "t")}
    same(EOM.evaluate(u.dt, kn.State(**rest), inputs={T: 0.4}, t=0.5), EOM.evaluate(u.dt, STATE))
    with pytest.raises(
        kn.errors.ArgumentError, match=r"inputs, t in the state or by keyword, got both.*state\.replace"
    ):
        kn.linearize(EOM, STATE, inputs={T: 1.0}, t=2.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda s: EOM.evaluate(u.dt, s),
        lambda s: EOM.jacobian().at(s),
        lambda s: kn.inverse(EOM, [T])(s, given={u.dt: 0.0}),
        lambda s: kn.trim(EOM, s),
        lambda s: kn.equilibrium(EOM, s),
        lambda s: kn.assemble(EOM, s),
        lambda s: kn.linearize(EOM, s),
        lambda s: kn.analysis.linearizer(EOM)(s),
        lambda s: kn.analysis.continuation(EOM, "L", [0.5, 1.0], s),
        lambda s: kn.analysis.constraint_forces(CLOSED, s),
        lambda s: kn.analysis.impact(EOM, P, N.y, s, restitution=0.5),
    ],
)
@pytest.mark.parametrize("wrong", [{"q": 0.3}, [0.3], 0.3, "down", EOM])
def test_wrong_kinds_are_named(call, wrong):
    with pytest.raises(kn.errors.ArgumentError, match=r"Expected a kn\.State, or values by keyword, got"):
        call(wrong)


@pytest.mark.parametrize("wrong", [0.3, "q", {"q"}, STATE, q])
def test_groups_of_wrong_kinds_are_named(wrong):
    with pytest.raises(kn.errors.ArgumentError, match=r"Expected u= of a state as a dict .* or as a sequence, got"):
        kn.State([0.3], wrong)


def test_values_that_are_left_out_or_unknown():
    with pytest.raises(kn.errors.ValueMissingError, match="q"):
        EOM.evaluate(q, kn.State())
    with pytest.raises(kn.errors.ValueMissingError, match="got one for 'q9'"):
        EOM.evaluate(u.dt, kn.State({"q9": 1.0}, [0.0]))
    with pytest.raises(kn.errors.ValueMissingError, match="Expected 1 coordinates"):
        EOM.evaluate(u.dt, kn.State([0.3, 0.4], [0.0]))


def test_reading_and_replacing():
    assert (STATE["q"], STATE[q], STATE["act"], STATE[m], STATE["T"]) == (0.3, 0.3, 0.1, 2.0, 0.4)
    with pytest.raises(kn.errors.ValueMissingError, match="got 'R'"):
        _ = kn.State({q: 0.3})["R"]
    changed = STATE.replace(q={q: 0.4}, inputs={"T": 1.0}, u={u: 0.1}, t=0.0)
    assert (changed["q"], changed["T"], changed["u"], changed["m"], changed.t) == (0.4, 1.0, 0.1, 2.0, 0.0)
    assert (STATE["q"], STATE.u, STATE.t) == (0.3, [0.7], 0.5)
    whole = kn.equilibrium(EOM, q={q: kn.guess(-1.5)}, inputs={T: 0.0})
    assert whole.replace(q={"q": kn.guess(0.2)}).q[q] == kn.guess(0.2)
    with pytest.raises(kn.errors.SimulationError, match="Expected a number as the value for q, got None"):
        whole.replace(q={q: None})
    assert STATE.arguments == GROUPS
    assert kn.State([0.3]).arguments == {"q": [0.3], "u": None, "parameters": None, "inputs": None}
    assert pickle.loads(pickle.dumps(STATE)).arguments["u"] == [0.7]


def test_how_it_prints():
    assert repr(STATE) == "State(q = 0.3, u = [0.7], act = 0.1, T = 0.4; t = 0.5)"
    assert repr(kn.State({q: kn.guess(0.25)})) == "State(q = guess(0.25))"


def test_the_former_name():
    assert kn.OperatingPoint is kn.State


def test_a_time_by_keyword_beside_one_of_the_state_is_refused_zero_too():
    state = kn.State(**GROUPS)
    for t in (0.0, 0, np.int64(0)):
        with pytest.raises(kn.ArgumentError, match="Expected values of t in the state or by keyword, got both"):
            EOM.evaluate(EOM.accelerations, state, t=t)


def test_what_follows_the_speeds_is_named():
    with pytest.raises(TypeError):
        kn.State({"q": 0.3}, [0.7], {"m": 2.0})
    assert kn.analysis.OperatingPoint is kn.OperatingPoint is kn.State


def test_what_has_a_state_says_so():
    linear = kn.linearize(EOM, kn.trim(EOM, **NEAR))
    with pytest.raises(kn.errors.ArgumentError, match=r"Pass its \.point\.$"):
        EOM.evaluate(EOM.kinetic_energy, linear)
    assert EOM.evaluate(EOM.kinetic_energy, linear.point) == pytest.approx(0.0)


def test_what_is_assembled_is_a_state():
    found = kn.assemble(CLOSED, q={x: 0.6, y: kn.guess(0.8)})
    assert CLOSED.evaluate(x + y, found) == CLOSED.evaluate(x + y, found.state) == pytest.approx(1.4)
    started = kn.simulate(CLOSED, (0, 0.1), start=found)
    same(started.states, kn.simulate(CLOSED, (0, 0.1), q=found.q, u=found.u).states)
    same(found, pickle.loads(pickle.dumps(found)))


def test_the_states_of_a_dataset_are_read():
    require("xarray")
    places = np.array([0.0, 0.6, 0.8, 2.0])
    table = kn.assemble(CLOSED, q={x: places, y: kn.guess(0.8)}, u={v: 1.0})
    assert table.status.values.tolist() == ["found"] * 3 + ["failed"]
    heights, falls = CLOSED.evaluate([y, w], table)
    np.testing.assert_allclose(heights[:3], np.sqrt(1 - places[:3] ** 2))
    np.testing.assert_allclose(falls[:3], -places[:3] / heights[:3], atol=1e-15)
    assert np.isnan([heights[3], falls[3]]).all()
    at_one = CLOSED.evaluate(w.dt, table.isel(instance=1))
    assert at_one == CLOSED.evaluate(w.dt, kn.assemble(CLOSED, q={x: 0.6, y: kn.guess(0.8)}, u={v: 1.0}))


def test_a_motion_starts_from_a_steady_one_with_another_law_of_an_input():
    point = kn.trim(EOM, **NEAR)
    laws = (kn.time, lambda t: t, kn.table([0, 9], [0, 9]), kn.signal([0, 4, 9], [0, 4, 9]))
    ends = [kn.simulate(EOM, (0, 1), start=point.replace(inputs={"T": law})).states[-1] for law in laws]
    for end in ends:
        np.testing.assert_allclose(end, ends[0], rtol=1e-7, atol=1e-9)
    assert not np.allclose(ends[0], kn.simulate(EOM, (0, 1), start=point).states[-1])
    for wrong in ("1", None, 1j, float("nan")):
        with pytest.raises(kn.SimulationError, match=r"value for T, got"):
            point.replace(inputs={T: wrong})
    with pytest.raises(kn.SimulationError, match="as the value for T, got the expression t"):
        kn.linearize(EOM, point.replace(inputs={T: kn.time}))


def test_zero_stands_for_zeros_wherever_a_state_is_given():
    eom = kn.derive(pendulums.system(2))
    state = kn.State([1.0, 2.0], 0, t=2.0)
    assert repr(state) == "State(q = [1, 2], u = 0; t = 2)"
    named = kn.linearize(eom, q=[0.0, 0.0], u=[0.0, 0.0])
    for point in ({"q": 0, "u": 0}, {"q": {"q1": 0.0, "q2": 0.0}, "u": 0}):
        np.testing.assert_array_equal(kn.linearize(eom, **point).A, named.A)
    np.testing.assert_array_equal(kn.linearize(eom, kn.State([0.0, 0.0]), u=0).A, named.A)
    with pytest.raises(kn.ArgumentError, match="Expected values of u in the state or by keyword, got both"):
        kn.linearize(eom, kn.State([0.0, 0.0], [0.0, 0.0]), u=0)
    with pytest.raises(kn.ValueMissingError, match=r"dict {name: value} for q, got 0\.3\. Write \[0\.3\]\.$"):
        kn.simulate(EOM, (0, 1), q=0.3, u=0, inputs={T: 0})
    rest = kn.simulate(eom, (0, 1), q=[1.0, 2.0], u=[0.0, 0.0]).states
    np.testing.assert_array_equal(kn.simulate(eom, (0, 1), q=[1.0, 2.0], u=0).states, rest)


def test_zero_stands_for_zeros_of_constrained_systems_again_and_again():
    eom = kn.derive(four_bar.system())
    q = four_bar.START["q"]
    runs = [kn.simulate(eom, (0, 0.1), q=q, u=u).states for u in (0, 0, [0.0] * 3)]
    np.testing.assert_array_equal(runs[0], runs[1])
    np.testing.assert_array_equal(runs[0], runs[2])


def test_zero_stands_for_zeros_of_many_motions():
    require("xarray")
    eom = kn.derive(pendulums.system(2))
    starts = np.array([[1.0, 2.0], [0.5, -0.3]])
    many, listed = (kn.simulate_many(eom, (0, 1), q=starts, u=u) for u in (0, [0.0, 0.0]))
    np.testing.assert_array_equal(many["end_state"], listed["end_state"])


@pytest.mark.parametrize("q", [[1.0, 2.0], np.array([1.0, 2.0]), 0])
def test_some_values_of_a_list_are_not_replaced_by_name(q):
    with pytest.raises(kn.ValueMissingError, match="Expected a state with q given by name to replace some of them"):
        kn.State(q, 0).replace(q={"q1": 3.0})
    assert list(kn.State(q, 0).replace(q=[3.0, 2.0]).q) == [3.0, 2.0]


def test_parameters_by_symbol_that_a_state_has_none_of_are_not_dropped_when_some_are_replaced():
    state = kn.State({q: 0.3}, [0.7], parameters={m: 2.0}, inputs={T: 0.0}, states={act: 0.0})
    changed = state.replace(parameters={g: 3.0})
    assert changed.parameters == {m: 2.0, g: 3.0}
    assert EOM.evaluate(g, changed) == 3.0
    assert state.replace(parameters={m: 1.0, g: 3.0}).parameters == {m: 1.0, g: 3.0}
    assert state.parameters == {m: 2.0}


def test_an_array_of_no_dimension_is_a_number_as_the_time_and_none_of_a_group():
    state = kn.State({q: 0.3}, [0.7], t=np.array(0.5))
    assert repr(state) == "State(q = 0.3, u = [0.7]; t = 0.5)"
    assert state.arguments["t"] == 0.5
    assert "t" not in kn.State({q: 0.3}, t=np.array(0.0)).arguments
    with pytest.raises(kn.ArgumentError, match="Expected q= of a state as a dict"):
        EOM.evaluate(q, q=np.array(0.3))
