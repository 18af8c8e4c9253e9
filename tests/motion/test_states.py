# SPDX-License-Identifier: BSD-3-Clause
"""Further states along motions: against closed forms, against SciPy on equations written by hand, by every method."""

import pickle
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import kane as kn
from tests.lanes import SMOOTH
from tests.systems import states as made

METHODS = ("auto", "gauss16", "dop853", "tsitpap8", "tsit5", "DOP853", "Radau", "LSODA")


@cache
def equations(name):
    return kn.derive(getattr(made, name)())


def cart_matrix():
    """ẋ = A x + B r of x = (x, v, z, w)."""
    a = np.array([[0, 1, 0, 0], [-9 / 2, 0, -4 / 2, -7 / 2], [1, 0, 0, 0], [0, 5, 0, -5.0]])
    return a, np.array([0, 9 / 2, -1, 0.0])


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_controllers_integral_and_a_filter_are_an_exponential(method):
    sol = kn.simulate(
        equations("cart"), (0, 6), q=[0.2], u=[0], inputs={"r": 1}, states={"z": 0.3}, samples=41, method=method
    )
    a, b = cart_matrix()
    rest = np.linalg.solve(a, -b)
    exact = np.array([rest + expm(a * s) @ ([0.2, 0, 0.3, 0] - rest) for s in sol.t])
    assert np.abs(sol.states - exact).max() < 1e-8
    assert np.array_equal(sol[made.z], sol.a[:, 0])
    assert np.allclose(sol[made.w.dt], (sol.u[:, 0] - sol["w"]) / 0.2, rtol=1e-12)
    assert np.allclose(sol.rates(), sol.states @ a.T + b, rtol=1e-12, atol=1e-12)
    assert sol.keeps_energy
    if method == "auto":
        assert sol.method in SMOOTH


def test_a_muscle_is_activated_as_de_groote_says():
    sol = kn.simulate(
        equations("arm"), (0, 0.4), q=[-1], u=[0], inputs={"e": 0.8 - 0.5 * kn.sin(9 * kn.time)}, samples=21
    )

    def f(t, y):
        q, u, a = y
        e = 0.8 - 0.5 * np.sin(9 * t)
        return [
            u,
            (9.0 * a - 2 * 9.81 * 0.3 * np.cos(q)) / (0.02 + 2 * 0.09),
            made.activation(e, a, np.tanh, 0.015, 0.06),
        ]

    own = solve_ivp(f, (0, 0.4), [-1, 0, 0.05], method="DOP853", rtol=1e-12, atol=1e-12, t_eval=sol.t)
    assert np.abs(sol.states - own.y.T).max() < 1e-8
    assert sol.status == "finished"


@pytest.mark.slow
@pytest.mark.parametrize("method", ["auto", "gauss16", "dop853", "DOP853", "Radau"])
def test_projection_leaves_states_alone(method):
    eom = equations("rod")
    start = {"q": [1, 0], "u": [0, 0.3]}
    sol = kn.simulate(eom, (0, 4), **start, samples=41, method=method, states={"i": 0.5})
    assert method != "auto" or sol.method in ("gauss16", "vern9", "tsitpap8", "dop853")

    def f(t, y):
        q, u, i, h = y
        return [u, -9.81 * np.cos(q) + 5 * i / (1 + h), 3 - 4 * i - u, 2 * i**2 - h / 5]

    own = solve_ivp(f, (0, 4), [0, 0.3, 0.5, 1], method="DOP853", rtol=1e-12, atol=1e-12, t_eval=sol.t)
    assert np.abs(np.array(sol[[made.X, made.i, made.h]]) - [np.cos(own.y[0]), *own.y[2:]]).max() < 1e-6
    assert np.abs(sol.constraint_residuals[eom.system.constraints[0]]).max() < 1e-12
    assert sol.energy_check.relative < 1e-6


def test_states_are_compiled_and_emitted_after_the_speeds():
    eom = equations("cart")
    a, b = cart_matrix()
    x = np.array([0.1, -0.2, 0.3, 0.4])
    compiled = eom.compile()
    assert [s.name for s in eom.state] == ["x", "v", "z", "w"]
    assert np.allclose(compiled.rhs(0, x, None, [0.7]), a @ x + 0.7 * b, rtol=1e-14)
    assert np.allclose(compiled.jac(0, x, None, [0.7]), a, rtol=1e-14)
    assert np.allclose(eom.jacobian().at(q=[0.1], u=[-0.2], states=x[2:], inputs={"r": 0}), a)
    module: dict = {}
    exec(compiled.emit("numpy"), module)  # noqa: S102
    assert np.allclose(module["rhs"](0, x, compiled.parameters(), [0.7]), a @ x + 0.7 * b, rtol=1e-14)


def test_numbers_at_a_state_take_defaults():
    eom = equations("arm")
    values = {"q": [0.3], "u": [0.1], "inputs": {"e": 0.4}}
    assert eom.evaluate(made.a, **values) == 0.05
    assert eom.evaluate("a'", **values, states={"a": 0.2}) == pytest.approx(
        made.activation(0.4, 0.2, np.tanh, 0.015, 0.06)
    )
    assert np.allclose(eom.evaluate(made.a, **values, states=[[0.1, 0.2]]), [0.1, 0.2])


def test_events_and_outputs_see_states(tmp_path):
    full = kn.Event("full", made.a, threshold=0.6, direction=1)
    eom = kn.derive(made.arm().replace(events=[full]))
    sol = kn.simulate(eom, (0, 1), q=[-1], u=[0], inputs={"e": 1.0})
    assert sol.status == "event"
    assert sol.a[-1, 0] == pytest.approx(0.6, rel=1e-10)
    sol.save(tmp_path / "run.npz")
    for again in (pickle.loads(pickle.dumps(sol)), kn.load_solution(tmp_path / "run.npz", eom)):
        assert np.array_equal(again["a"], sol["a"])
    with pytest.raises(kn.SolutionFileError, match=r"with the states none, got .* with a"):
        kn.load_solution(tmp_path / "run.npz", kn.derive(made.arm().replace(states={}, loads=[])))
    assert sol.accuracy().relative < 1e-6


def test_feedback_and_controllers_see_states():
    eom = equations("cart")
    given = {"q": [0.2], "u": [0], "samples": 11}
    own = kn.simulate(eom, (0, 2), inputs={"r": 1 - made.z}, **given)
    law = kn.simulate(eom, (0, 2), inputs={"r": lambda t, x: 1 - x[2]}, **given)
    assert np.abs(own.states - law.states).max() < 1e-8
    held = kn.simulate(eom, (0, 2), inputs={"r": kn.sampled(lambda t, x: 1 - x[2], 1e-3)}, **given)
    assert np.abs(own.states - held.states).max() < 1e-2


def test_start_values_are_checked():
    eom = equations("arm")
    start = {"q": [0], "u": [0], "inputs": {"e": 0}}
    with pytest.raises(kn.ValueMissingError, match=r"values for states of the system \(a\), got one for 'b'"):
        kn.simulate(eom, (0, 1), **start, states={"b": 1})
    with pytest.raises(kn.SimulationError, match="finite start value for a, got nan"):
        kn.simulate(eom, (0, 1), **start, states={"a": np.nan})


def test_any_speeds_give_the_same_motion():
    """Rates of states hold q̇, which other speeds express otherwise."""
    v = kn.speed("v")
    states = {made.a: made.activation(made.e, made.a) - made.q.dt}
    other = kn.derive(made.arm().replace(speeds={v: (2 + kn.cos(made.q)) * made.q.dt}, states=states))
    own = kn.derive(made.arm().replace(states=states))
    one = kn.simulate(own, (0, 0.5), q=[-1], u=[0.4], inputs={"e": 0.5}, samples=11)
    two = kn.simulate(other, (0, 0.5), q=[-1], rates=[0.4], inputs={"e": 0.5}, samples=11)
    assert np.abs(np.subtract(one[[made.q, made.a]], two[[made.q, made.a]])).max() < 1e-8


def test_stiffness_that_shows_in_the_last_step_changes_nothing():
    """A motor with an integral of the error: its current settles a thousand times faster than its speed."""
    j, c = kn.coordinate("j"), kn.speed("c")
    current, z = kn.state("current"), kn.state("z")
    frame = made.N.rotate("W", j, made.N.z)
    rotor = kn.RigidBody("rotor", frame=frame, mass_center=made.O, mass=1, inertia=kn.inertia(frame, 0, 0, 0.02))
    voltage = (50 - c) / 2 + 0.4 * z
    states = {current: (voltage - 2 * current - 0.1 * c) / 0.05, z: 50 - c}
    motor = kn.Torque(frame, 0.1 * current * frame.z)
    eom = kn.derive(kn.System(made.N, bodies=[rotor], speeds={c: j.dt}, loads=[motor], states=states))
    for end in (40, 60):
        sol = kn.simulate(eom, (0, end), q=[0], u=[0], samples=3)
        assert sol.status == "finished"
        assert sol[c][-1] == pytest.approx(50, rel=1e-6)
