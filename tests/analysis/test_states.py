# SPDX-License-Identifier: BSD-3-Clause
"""Further states in what is asked of equations: linearized, trimmed, followed, in inverse dynamics."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.systems import states as made

N, O = made.N, made.O


@cache
def equations(name, **changes):
    return kn.derive(getattr(made, name)().replace(**changes))


def arm_point():
    return kn.trim(equations("arm"), q={"q": 0.3}, u=[0], inputs={"e": kn.guess(0.3)})


def slopes(eom, point, size=1e-6):
    """∂ẋ/∂x by central differences of what is compiled."""
    rhs = eom.compile().rhs
    x, p, r = (np.array([point[s] for s in some]) for some in (eom.state, eom.parameters, eom.inputs))
    steps = size * np.eye(len(x))
    return np.array([(rhs(point.t, x + h, p, r) - rhs(point.t, x - h, p, r)) / (2 * size) for h in steps]).T


def test_a_linearization_holds_the_states():
    lin = kn.linearize(
        equations("cart"), q=[1], inputs={"r": 1}, outputs={"force": -made.k * made.x - made.ki * made.z}
    )
    assert lin.states == ("x", "v", "z", "w")
    assert (lin.speeds, lin.further, lin.coordinates) == (("v",), ("z", "w"), ("x",))
    assert np.allclose(lin.A, [[0, 1, 0, 0], [-4.5, 0, -2, -3.5], [1, 0, 0, 0], [0, 5, 0, -5]], rtol=1e-14)
    assert np.allclose(lin.B.T, [[0, 4.5, -1, 0]], rtol=1e-14)
    assert np.allclose(lin.C, [[-9, 0, -4, 0]], rtol=1e-14)
    in_symbols = kn.linearize_symbolic(equations("cart"), {"x": made.r, "v": 0, "z": 0, "w": 0})
    assert np.allclose(kn.evaluate(in_symbols.A, {}), lin.A, rtol=1e-14)
    assert np.allclose(kn.evaluate(in_symbols.B, {}), lin.B, rtol=1e-14)


def test_an_integral_rests_only_where_its_error_vanishes():
    eom = equations("cart")
    point = kn.trim(eom, inputs={"r": 0.5})
    assert [point[s] for s in ("x", "v", "z", "w")] == pytest.approx([0.5, 0, 0, 0], abs=1e-12)
    assert point.replace(states={"z": 2})["z"] == 2
    with pytest.raises(kn.SimulationError, match=r"at which these accelerations are not zero: .*z' = -0\.5 m"):
        kn.linearize(eom, q=[0.5], inputs={"r": 1}, states=[1.125, 0])


def test_a_muscle_holds_the_hand():
    eom, point = equations("arm"), arm_point()
    assert point["a"] == pytest.approx(2 * 9.81 * 0.3 * np.cos(0.3) / 9, rel=1e-9)
    assert point["e"] == pytest.approx(point["a"], rel=1e-9)
    lin = kn.linearize(eom, **point.arguments)
    assert np.allclose(lin.A, slopes(eom, point), rtol=1e-6, atol=1e-6)
    sol = kn.simulate(eom, (0, 0.1), **point.arguments, samples=3)
    assert np.abs(sol.states - sol.states[0]).max() < 1e-9


@pytest.mark.slow
def test_states_are_followed_along_a_branch():
    branch = kn.continuation(equations("arm"), "q", [0.3, 1.0], u=[0], inputs={"e": kn.guess(0.3)})
    assert branch.points[-1]["a"] == pytest.approx(2 * 9.81 * 0.3 * np.cos(1) / 9, rel=1e-9)
    assert branch.linear[-1].states == ("q", "u", "a")


def test_states_beside_constraints():
    eom = equations("rod")
    point = kn.trim(eom, q={"X": kn.guess(0.1), "Y": kn.guess(-1)}, u=[0, 0])
    assert (point["i"], point["h"]) == (pytest.approx(3 / 4), pytest.approx(10 * 9 / 16))
    assert 9.81 * point["X"] == pytest.approx(5 * point["i"] / (1 + point["h"]))
    lin = kn.linearize(eom, **point.arguments, independent=["X", "u_X"])
    # along the circle: θ̈ = −g sin θ + 5 i/(1 + h) with X = sin θ
    x, y, i, h = (point[s] for s in "XYih")
    assert lin.A[2:] == pytest.approx(np.array([[0, 1 / y, -4, 0], [0, 0, 4 * i, -0.2]]), rel=1e-9)
    assert lin.A[1] == pytest.approx(np.array([9.81 * y, 0, -y * 5 / (1 + h), y * 5 * i / (1 + h) ** 2]), rel=1e-9)
    sides = kn.constraint_forces(eom, q=[x, y], u=[-0.5 * y, 0.5 * x], states={"i": 3.0})
    (c,) = eom.system.constraints
    assert sides.by_multipliers[c] == pytest.approx(sides.by_auxiliary_speeds[c])


def test_what_nothing_depends_on_may_go_on_changing():
    """A wheel that spins evenly: its angle, and the state that counts it, do not matter."""
    q, u = kn.coordinate("q"), kn.speed("u")
    frame = N.rotate("A", q, N.z)
    wheel = kn.RigidBody("wheel", frame=frame, mass_center=O, mass=1, inertia=kn.inertia(frame, 0, 0, 0.02))
    drive = kn.Torque(frame, (kn.input("e") - 0.1 * u) * frame.z)
    eom = kn.derive(kn.System(N, bodies=[wheel], speeds={u: q.dt}, loads=[drive], states={kn.state("far"): u}))
    point = kn.trim(eom, q=[0], inputs={"e": 0.3}, states={"far": 5})
    assert (point["u"], point["far"]) == (pytest.approx(3), 5)
    lin = kn.linearize(eom, **point.arguments)
    assert lin.cyclic == ("q", "far")
    rest = lin.without("cyclic")
    assert (rest.states, rest.further, rest.mass.shape) == (("u",), (), (1, 1))
    with pytest.raises(
        kn.SimulationError, match=r"coordinates and speeds alone for the second-order form, got the further states far"
    ):
        lin.second_order()
    assert np.allclose(lin.without("far").second_order(["q"]).M, [[0.02]])


def test_inverse_dynamics_take_the_states():
    eom = equations("arm")
    u_dot = kn.inverse(eom, [made.u.dt])
    found = u_dot(q=[0.2], u=[0.4], inputs={"e": 0.5}, states={"a": [0.1, 0.9]})[made.u.dt]
    assert np.allclose(
        found, eom.evaluate(made.u.dt, q=[0.2], u=[0.4], inputs={"e": 0.5}, states=[[0.1, 0.9]]), rtol=1e-12
    )
    sol = kn.simulate(eom, (0, 0.2), q=[0], u=[0], inputs={"e": 0.5}, samples=5)
    assert np.allclose(u_dot.along(sol)[made.u.dt], sol[made.u.dt], rtol=1e-10)


CHAIN = 3
Q, U = kn.coordinates(f"q1:{CHAIN + 1}"), kn.speeds(f"u1:{CHAIN + 1}")
S = (kn.state("s1", 0.3), kn.state("s2", -0.2))
R = kn.input("r")
PARTS = (*Q, *U, *S, R, kn.sin(Q[1]) * U[0], S[0] * S[1], kn.tanh(S[1] - Q[0]), U[2] ** 2 / 4, S[0] * kn.cos(Q[2]))
weights = st.lists(st.integers(-3, 3), min_size=len(PARTS), max_size=len(PARTS))


def chain(rows):
    """A pendulum of three rods with a torque on each, and two states; all of them sums of PARTS by weights."""
    sums = [sum((c * e for c, e in zip(row, PARTS, strict=True)), start=kn.sin(S[0]) + R) / 4 for row in rows]
    bodies, loads, point, frame = [], [kn.gravity(-9.81 * N.y)], O, N
    for k, (q, torque) in enumerate(zip(Q, sums, strict=False), 1):
        frame = frame.rotate(f"A{k}", q, N.z)
        bodies.append(kn.Particle(f"P{k}", point := point.at(f"P{k}", -frame.y), 1))
        loads.append(kn.Torque(frame, torque * N.z, name=f"torque {k}"))
    return kn.System(
        N,
        bodies=bodies,
        speeds=dict(zip(U, (q.dt for q in Q), strict=True)),
        loads=loads,
        states=dict(zip(S, sums[CHAIN:], strict=True)),
    )


AT = {"q": [0.3, -0.4, 0.7], "u": [0.2, -0.1, 0.5], "states": [0.6, -0.5], "inputs": {"r": 0.4}}


@given(st.lists(weights, min_size=CHAIN + 2, max_size=CHAIN + 2))
@examples(0.2)
def test_derivatives_of_random_systems_are_those_of_differences(rows):
    eom, size = kn.derive(chain(rows)), 1e-6
    x = np.concatenate([AT[kind] for kind in ("q", "u", "states")])
    sides = [
        np.array(eom.evaluate(eom.right_hand_side, q=y[:3], u=y[3:6], states=y[6:], inputs={"r": 0.4}))
        for y in ((x + sign * size * np.eye(len(x))).T for sign in (1, -1))
    ]
    assert np.allclose(eom.jacobian().at(**AT), (sides[0] - sides[1]) / (2 * size), rtol=1e-6, atol=1e-6)


@pytest.mark.slow
@given(st.lists(weights, min_size=CHAIN + 2, max_size=CHAIN + 2))
@examples(0.05)
def test_random_systems_are_linearized_and_move_as_their_derivatives_say(rows):
    eom = kn.derive(chain(rows))
    lin = kn.linearize(eom, **AT, steady=False)
    assert np.allclose(lin.A, eom.jacobian().at(**AT), rtol=1e-10, atol=1e-10)
    assert np.allclose(eom.evaluate(eom.right_hand_side, **AT), lin.rates, rtol=1e-12, atol=1e-12)
    sol = kn.simulate(eom, (0, 0.2), **AT, samples=3)
    other = kn.simulate(eom, (0, 0.2), **AT, samples=3, method="DOP853")
    assert np.abs(sol.states - other.states).max() < 1e-7
