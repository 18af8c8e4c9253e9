# SPDX-License-Identifier: BSD-3-Clause
"""Linearization against differences of the constrained flow, closed forms and published numbers."""

import functools

import numpy as np
import pytest

import kane as kn
from kane.gallery import whipple_bicycle
from tests.systems import steady as systems
from tests.systems.whipple import BIKE_C1, BIKE_K0, BIKE_K2, BIKE_M

STEP = 1e-6


def flow(eom, linear, base, x, r):
    """ẋ of the independent states at x, the dependent values solved for by assembly."""
    own = dict(zip(linear.states, x, strict=True))
    q = {s: own.get(s.name, kn.guess(base.q[s])) for s in eom.coordinates}
    u = {s: own[s.name] for s in eom.speeds if s.name in own}
    inputs = dict(zip(eom.inputs, r, strict=True))
    at = kn.assemble(eom, q=q, u=u, inputs=inputs)
    values = np.array(eom.evaluate(eom.right_hand_side, q=at.q, u=at.u, inputs=inputs))
    names = [s.name for s in (*eom.coordinates, *eom.speeds)]
    outputs = eom.evaluate(list(eom.reactions), q=at.q, u=at.u, inputs=inputs) if eom.reactions else []
    return np.array([*(values[names.index(n)] for n in linear.states), *outputs])


def differences(eom, linear):
    """Central differences of the flow and of the reactions in the states and inputs."""
    base = linear.point
    x = np.array([base[n] for n in linear.states])
    r = np.array(list(base.inputs.values()))
    columns = []
    for k in range(len(x) + len(r)):
        step = np.zeros(len(x) + len(r))
        step[k] = STEP
        ahead = flow(eom, linear, base, x + step[: len(x)], r + step[len(x) :])
        behind = flow(eom, linear, base, x - step[: len(x)], r - step[len(x) :])
        columns.append((ahead - behind) / (2 * STEP))
    return np.array(columns).T


def disk_point():
    return {"q": [0.3, 0.4, 0.2, 1.0, -2.0], "u": {"u1": 0.3, "u2": 0.7, "u3": -5.0}}


CASES = {
    "rolling disk": (systems.rolling_disk, disk_point()),
    "four-bar": (
        systems.four_bar,
        {
            "q": {"q1": 1.2, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)},
            "u": {"u1": 3.0},
            "inputs": {"tau": 2.0},
            "independent": ("q1", "u1"),
        },
    ),
    "double pendulum": (
        systems.double_pendulum,
        {"q": [0.5, -0.8], "u": [0.4, 1.1], "inputs": {"s1": 1.0, "s2": -0.5}},
    ),
    "sleigh": (systems.sleigh, {"q": [1.0, 2.0, 0.6], "u": {"v": 1.2, "w": 0.5}, "inputs": {"F": 0.7}}),
    "moved guide": (
        systems.moved_guide,
        {
            "q": {"q1": 0.3, "q2": kn.guess(-0.2)},
            "u": {"u1": 0.8},
            "inputs": {"s": 0.1, "s'": -0.4, "s''": 2.0},
            "independent": ("q1", "u1"),
        },
    ),
    "cart": (systems.cart, {"q": [0.1, 0.9], "u": [0.3, -0.6], "inputs": {"F": 0.4}}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_differences_of_the_constrained_flow(name):
    make, at = CASES[name]
    eom = make()
    linear = kn.linearize(eom, **at, steady=False, outputs={r.name: r for r in eom.reactions})
    found = np.block([[linear.A, linear.B], [linear.C, linear.D]])
    expected = differences(eom, linear)
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(found, expected, atol=1e-6 * scale, rtol=0)


def test_rates_and_values_at_the_point_are_those_of_the_equations():
    eom = systems.rolling_disk()
    linear = kn.linearize(eom, **disk_point(), steady=False, outputs={r.name: r for r in eom.reactions})
    point = {"q": linear.point.q, "u": linear.point.u}
    rates = dict(
        zip([s.name for s in (*eom.coordinates, *eom.speeds)], eom.evaluate(eom.right_hand_side, **point), strict=True)
    )
    np.testing.assert_allclose(linear.rates, [rates[n] for n in linear.states], atol=1e-11)
    np.testing.assert_allclose(linear.values, eom.evaluate(list(eom.reactions), **point), atol=1e-10)


# Euler parameters ---------------------------------------------------------------------------------------------------------


def turned(e, angles):
    """e turned by small angles about its frame's axes, to second order."""
    half = np.append(1.0, np.asarray(angles) / 2)
    a0, a = e[0], e[1:]
    b0, b = half[0], half[1:]
    found = np.append(a0 * b0 - a @ b, a0 * b + b0 * a + np.cross(a, b))
    return found / np.linalg.norm(found)


def test_euler_parameters_are_perturbed_by_three_angles():
    """At rest θ̇ = ω, and the accelerations change as differences along small turns say."""
    eom = systems.free_body(torsion=4.0)
    e = np.array([0.5, 0.1, -0.7, 0.4])
    e /= np.linalg.norm(e)
    q = dict(zip([s.name for s in eom.coordinates], [0.0] * 7, strict=True))
    q |= {f"e{k}": v for k, v in enumerate(e)} | {"x": 0.2, "y": -0.3, "z": 0.5}
    linear = kn.linearize(eom, q=q, u=[0.0] * 6, steady=False)
    assert linear.states == (
        "x", "y", "z", "theta1_e0", "theta2_e0", "theta3_e0", "w1", "w2", "w3", "v1", "v2", "v3",
    )  # fmt: skip
    np.testing.assert_allclose(linear.A[3:6], np.hstack([np.zeros((3, 6)), np.eye(3), np.zeros((3, 3))]), atol=1e-14)

    def accelerations(angles):
        own = q | {f"e{k}": v for k, v in enumerate(turned(e, angles))}
        return np.array(eom.evaluate(eom.accelerations, q=own, u=[0.0] * 6, inputs={"T": 0}))

    for k in range(3):
        step = STEP * np.eye(3)[k]
        expected = (accelerations(step) - accelerations(-step)) / (2 * STEP)
        np.testing.assert_allclose(linear.A[6:, 3 + k], expected, atol=1e-8)


def test_free_body_spinning_about_a_principal_axis():
    """ω̇ of small changes by Euler's equations, θ̇ = δω − ω × θ; the middle axis is unstable with λ = ω √((B−A)(C−B)/(AC))."""
    eom = systems.free_body()
    q = {"e0": 1.0, "e1": 0, "e2": 0, "e3": 0, "x": 0, "y": 0, "z": 0}
    linear = kn.linearize(eom, q=q, u={"w1": 0, "w2": 2.0, "w3": 0, "v1": 1.0, "v2": 0, "v3": 0})
    assert set(linear.cyclic) == {"x", "y", "z", "theta1_e0", "theta2_e0", "theta3_e0"}
    spin = linear.A[3:6, 3:6]
    np.testing.assert_allclose(spin, -np.array([[0, 0, 2], [0, 0, 0], [-2, 0, 0]]), atol=1e-14)
    values = linear.without("cyclic").eigenvalues
    assert values[0].real == pytest.approx(2.0 * np.sqrt(1 * 1 / (1 * 3)), rel=1e-12)
    assert not linear.stable


@pytest.mark.parametrize(("share", "stable"), [(0.99, False), (1.01, True)])
def test_sleeping_top(share, stable):
    """Upright, spinning about its axis of symmetry, oriented by Euler parameters: stable where C² ω² > 4 A m g l.

    The spin moves the third angle, on which nothing depends; the point is a steady motion though the Euler parameters turn.
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    B = N.rotate_euler_parameters("B", kn.coordinates("e0:4"))
    G = O.at("G", 0.5 * B.z)
    w = B.angular_velocity(N)
    speeds = dict(zip(kn.speeds("w1:4"), (w.dot(a) for a in (B.x, B.y, B.z)), strict=True))
    A, C, m, l, g = 1.0 + 2.0 * 0.5**2, 0.3, 2.0, 0.5, 9.81
    body = kn.RigidBody("top", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, 1.0, 1.0, C))
    eom = kn.derive(kn.System(N, bodies=[body], speeds=speeds, loads=[kn.gravity(-g * N.z)]))
    spin = share * np.sqrt(4 * A * m * g * l) / C
    e = [np.cos(0.4), 0, 0, np.sin(0.4)]
    linear = kn.linearize(eom, q=e, u=[0, 0, spin])
    assert linear.cyclic == ("theta3_e0",)
    assert linear.rates[2] == pytest.approx(spin)
    roots = linear.without("cyclic").eigenvalues
    # in body axes: p = λ, of A p² + i ω (2A − C) p − (ω² (A − C) + m g l) = 0 and its conjugate, and 0 of the spin
    own = np.roots([A, 1j * spin * (2 * A - C), -(spin**2 * (A - C) + m * g * l)])
    expected = np.array([*own, *own.conj(), 0])
    for r in expected:
        assert np.abs(roots - r).min() < 1e-6 * spin
    assert (roots.real.max() < 1e-6) == stable


# Closed forms -------------------------------------------------------------------------------------------------------------


def test_cart_and_pendulum():
    eom = systems.cart()
    M, m, l, g = 2.0, 0.5, 0.7, 9.81
    linear = kn.linearize(eom, q=[0.3, 0], u=[0, 0], outputs={"rail": eom.reactions[0], "tip": eom.coordinates[0]})
    expected = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [0, m * g / M, 0, 0], [0, -(M + m) * g / (M * l), 0, 0]])
    np.testing.assert_allclose(linear.A, expected, atol=1e-13)
    np.testing.assert_allclose(linear.B[:, 0], [0, 0, 1 / M, -1 / (M * l)], atol=1e-14)
    np.testing.assert_allclose(linear.values, [(M + m) * g, 0.3], rtol=1e-14)
    np.testing.assert_allclose(linear.C[1], [1, 0, 0, 0])
    assert linear.cyclic == ("q1",)
    with pytest.raises(kn.SimulationError, match="got q1: the output tip depends on it"):
        linear.without("cyclic")
    swing = kn.linearize(eom, q=[0.3, 0], u=[0, 0], leave_out=["q1"]).modes[0]
    assert swing.frequency == pytest.approx(np.sqrt((M + m) * g / (M * l)), rel=1e-12)
    assert swing.damping == pytest.approx(0, abs=1e-12)
    assert list(swing.shape) == ["q2", "u1", "u2"]
    np.testing.assert_allclose(swing.vector @ [0, 1, m * l / (M + m)], 0, atol=1e-12)  # momentum stays


def test_second_order_form():
    eom = systems.cart()
    M, m, l, g = 2.0, 0.5, 0.7, 9.81
    both = kn.linearize(eom, q=[0, 0], u=[0, 0]).second_order()
    np.testing.assert_allclose(both.M, [[M + m, m * l], [m * l, m * l**2]], atol=1e-13)
    np.testing.assert_allclose(both.K, [[0, 0], [0, m * g * l]], atol=1e-13)
    np.testing.assert_allclose(both.F, [[1], [0]], atol=1e-13)
    one = kn.linearize(eom, q=[0, 0], u=[0, 0]).second_order(["q2"])
    np.testing.assert_allclose(one.M, [[m * l**2 * M / (M + m)]], rtol=1e-13)
    np.testing.assert_allclose(one.K, [[m * g * l]], rtol=1e-13)


def test_second_order_form_in_speeds_that_are_not_rates():
    """M q̈ + C q̇ + K q = F r has the eigenvalues of A and the mass matrix of the rates."""
    eom = systems.double_pendulum()
    linear = kn.linearize(eom, q=[0, 0], u=[0, 0])
    form = linear.second_order()
    first = np.array([[1, 0], [1, 1.0]])
    np.testing.assert_allclose(form.M, first.T @ linear.mass @ first, rtol=1e-13)
    np.testing.assert_allclose(form.F, [[1, 0], [0, 1]], atol=1e-13)
    back = np.linalg.inv(form.M)
    whole = np.block([[np.zeros((2, 2)), np.eye(2)], [-back @ form.K, -back @ form.C]])
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(whole)), np.sort_complex(linear.eigenvalues), rtol=1e-11
    )


@pytest.mark.parametrize("off", [0.0, 1e-12, 4e-10])
@pytest.mark.parametrize("dependent", [(), (0,), (1,)])
def test_a_pendulum_in_two_coordinates_hangs(dependent, off):
    """λ² = −g/l at x² + y² = l², however near to x = 0 the point is: y and its speed say nothing of small motions there."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    bob = O.at("bob", x * N.x + y * N.y)
    speeds = kn.speeds("u_x u_y")
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("bob", bob, 2.0)],
            speeds=dict(zip(speeds, (x.dt, y.dt), strict=True)),
            loads=[kn.gravity(-9.81 * N.y)],
            holonomic=kn.distance(bob, O, 0.5),
            dependent_speeds=[speeds[k] for k in dependent],
        )
    )
    linear = kn.linearize(eom, q=[off, -np.sqrt(0.25 - off**2)], u=[0, 0])
    np.testing.assert_allclose(linear.eigenvalues**2, -9.81 / 0.5, rtol=1e-8)
    assert linear.states == ("x", "u_x")
    np.testing.assert_allclose(linear.second_order().M, [[2.0]], rtol=1e-8)


def test_second_order_form_of_fewer_coordinates_than_speeds():
    """Cart and pendulum with u1 = q1' + 2 q2', u2 = q2' − 3 q1': both speeds move q2, whose own equation they give all the same."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1:3")
    M, m, l, g = 2.0, 0.5, 0.7, 9.81
    cart = O.at("cart", q1 * N.x)
    bob = cart.at("bob", -l * N.rotate("A", q2, N.z).y)
    u1, u2 = kn.speeds("u1:3")
    push = kn.input("F")
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("cart", cart, M), kn.Particle("bob", bob, m)],
            speeds={u1: q1.dt + 2 * q2.dt, u2: q2.dt - 3 * q1.dt},
            loads=[kn.gravity(-g * N.y), kn.Force(cart, push * N.x)],
        )
    )
    linear = kn.linearize(eom, q=[0, 0], u=[0, 0])
    one, both = linear.second_order(["q2"]), linear.second_order()
    np.testing.assert_allclose(one.M, [[m * l**2 * M / (M + m)]], rtol=1e-13)
    np.testing.assert_allclose(one.K, [[m * g * l]], rtol=1e-13)
    np.testing.assert_allclose(one.C, [[0]], atol=1e-13)
    np.testing.assert_allclose(one.F, [[-m * l / (M + m)]], rtol=1e-12)
    np.testing.assert_allclose(both.M, [[M + m, m * l], [m * l, m * l**2]], atol=1e-13)
    np.testing.assert_allclose(both.K, [[0, 0], [0, m * g * l]], atol=1e-13)
    with pytest.raises(kn.SimulationError, match=r"do not depend on others, got q1, which depends on q2\. Name all"):
        linear.second_order(["q1"])


@pytest.mark.slow
@pytest.mark.parametrize("independent", [(), ("u1", "u4", "u5"), ("u1", "u3", "u6")])
def test_second_order_form_for_any_independent_speeds(independent):
    eom = kn.derive(whipple_bicycle.system())
    q = dict.fromkeys((s.name for s in eom.coordinates), 0.0) | {"psi": 0.4}
    start = kn.assemble(eom, q=q, u={"u1": 0, "u4": 0, "u5": -3 / 0.3})
    form = kn.linearize(eom, q=start.q, u=start.u, independent=independent).second_order(["phi", "delta"])
    for found, expected in (
        (form.M, BIKE_M), (form.C, 3 * BIKE_C1), (form.K, 9.81 * BIKE_K0 + 9 * BIKE_K2), (form.F, np.eye(2)),
    ):  # fmt: skip
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@functools.cache
def disk():
    """A function that linearizes the rolling disk."""
    return kn.linearizer(systems.rolling_disk())


def critical(v):
    """Σ λ² of the rolling disk without the cyclic coordinates: twice the one that changes its sign."""
    lin = disk()
    at = lin(q=[0] * 5, u={"u1": 0, "u2": 0, "u3": -v / 0.3}, leave_out="cyclic")
    assert at.states == ("q2", "u1", "u2", "u3")
    return float(np.sum(at.eigenvalues**2).real)


def test_critical_speed_of_the_rolling_disk():
    """v² = g R / 3 for the thin uniform disk; above it the lean swings, below it grows."""
    from scipy.optimize import brentq

    v = brentq(critical, 0.5, 2.0, xtol=1e-15, rtol=1e-14)
    assert v**2 == pytest.approx(9.81 * 0.3 / 3, rel=1e-9)
    assert critical(1.5) < 0 < critical(0.7)


def test_the_disk_may_move_along_its_cyclic_coordinates():
    lin = disk()
    linear = lin(q=[0.8, 0, 2.0, 5.0, 1.0], u={"u1": 0, "u2": 0, "u3": -9.0})
    assert linear.cyclic == ("q1", "q3", "q4", "q5")
    straight = lin(q=[0] * 5, u={"u1": 0, "u2": 0, "u3": -9.0})
    np.testing.assert_allclose(linear.without("cyclic").A, straight.without("cyclic").A, atol=1e-12)


# Meijaard, Papadopoulos, Ruina, Schwab (2007), eqs. (5.3), (5.4), (5.5)
@pytest.mark.slow
def test_whipple_bicycle():
    eom = kn.derive(whipple_bicycle.system())
    lin = kn.linearizer(eom)

    def at(v):
        q = dict.fromkeys((s.name for s in eom.coordinates), 0.0)
        start = kn.assemble(eom, q=q, u={"u1": 0, "u4": 0, "u5": -v / 0.3})
        return lin(q=start.q, u=start.u, independent=("u1", "u4", "u5"))

    form = {v: at(v).second_order(["phi", "delta"]) for v in (0.0, 1.0)}
    for found, expected in (
        (form[0.0].M, BIKE_M),
        (form[0.0].K / 9.81, BIKE_K0),
        (form[1.0].C, BIKE_C1),
        (form[1.0].K - form[0.0].K, BIKE_K2),
        (form[0.0].F, np.eye(2)),
    ):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    for v in range(1, 11):
        back = np.linalg.inv(BIKE_M)
        whole = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-back @ (9.81 * BIKE_K0 + v**2 * BIKE_K2), -back @ (v * BIKE_C1)]]
        )
        linear = at(float(v)).without("cyclic")
        assert linear.states == ("phi", "delta", "u1", "u4", "u5")
        own = np.sort_complex(linear.eigenvalues)
        own = np.delete(own, np.argmin(np.abs(own)))  # the forward speed is kept
        np.testing.assert_allclose(own, np.sort_complex(np.linalg.eigvals(whole)), rtol=1e-11, atol=1e-11)


def test_steady_circle_takes_dependent_speeds_that_change_as_dependent():
    """In a circle the trace's speeds turn with the heading; the independent ones are constant."""
    lin = disk()
    point = kn.trim(lin.eom, q={"q2": 0.3}, u={"u3": -8.0, "u2": kn.guess(1.0)})
    linear = lin(**point.arguments)
    assert linear.without("cyclic").states == ("q2", "u1", "u2", "u3")
    np.testing.assert_allclose(linear.without("cyclic").rates, 0, atol=1e-12)


def test_without_python_control(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "control", None)
    linear = kn.linearize(systems.cart(), q=[0, 0], u=[0, 0])
    with pytest.raises(kn.SimulationError, match=r"Expected python-control .* pip install control"):
        linear.state_space()


def test_in_a_notebook():
    page = kn.linearize(systems.cart(), q=[0, 0], u=[0, 0])._repr_html_()
    assert "2 inputs" not in page
    assert "4 states, 1 inputs; no speed depends on q1" in page
    assert "4.1" in page


# Messages -----------------------------------------------------------------------------------------------------------------


def test_a_point_off_the_constraints():
    eom = systems.four_bar()
    with pytest.raises(
        kn.SimulationError, match=r"on the constraints, got coordinates that miss pin 1 by 1\.1\. .*kn\.assemble"
    ):
        kn.linearize(eom, q=[0, 0, 0.0], u=[0, 0, 0])
    lin = disk()
    with pytest.raises(
        kn.SimulationError,
        match=r"satisfy the constraints A u \+ b = 0, got some that miss .rolling of C\^ 1. by 0\.3",
    ):
        lin(q=[0] * 5, u=[0, 0, 1.0, 0, 0])


def test_a_point_that_is_not_steady():
    lin = disk()
    with pytest.raises(
        kn.SimulationError, match=r"these accelerations are not zero: u1' = -7\.73.*kn\.trim.*steady=False"
    ):
        lin(q=[0, 0.3, 0, 0, 0], u={"u1": 0, "u2": 0, "u3": 1.0})
    with pytest.raises(kn.SimulationError, match=r"these accelerations are not zero: u1' = 0\.99\d*, u2' = -12\.2\d*"):
        kn.linearize(systems.cart(), q={"q1": 0, "q2": 0.95}, u={"u1": 0, "u2": 0})


def test_a_coordinate_that_moves_though_the_speeds_depend_on_it():
    """A pendulum that balances gravity at every instant but moves."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (q,) = kn.coordinates("q1:2")
    A = N.rotate("A", q, N.z)
    body = kn.Particle("p", O.at("P", -1.0 * A.y), 1.0)
    tau = kn.input("tau")
    system = kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-10 * N.y), kn.Torque(A, tau * N.z)])
    with pytest.raises(kn.SimulationError, match=r"at which coordinates change on which the speeds depend: q1' = 2"):
        kn.linearize(kn.derive(system), q={"q1": np.pi / 6}, u={"u1": 2.0}, inputs={"tau": 5.0})


def test_equations_that_change_with_what_moves():
    """cos q has no slope at q = 0, so that only a look elsewhere shows what depends on it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinate("x"), kn.coordinate("y")
    P = O.at("P", x * N.x + y * N.y)
    spring = kn.Force(P, (-kn.cos(x) * y) * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=[spring]))
    with pytest.raises(kn.SimulationError, match=r"coordinates change on which the equations depend: x' = 1"):
        kn.linearize(eom, q=[0, 0], u=[1.0, 0])
    kn.linearize(eom, q=[0, 0], u=[0, 0])


def test_equations_that_change_with_time():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    spring = kn.Force(P, -(2 + kn.cos(kn.time)) * x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=[spring]))
    with pytest.raises(kn.SimulationError, match="whose equations depend on the time t"):
        kn.linearize(eom, q=[0], u=[0])
    assert kn.linearize(eom, q=[0], u=[0], steady=False).A[1, 0] == pytest.approx(-3)


def test_singular_configuration():
    """A parallelogram stretched out: the rank of its closure drops."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:4")
    at, bodies = O.at("O1", 0), []
    for k, (angle, length) in enumerate(zip(q, (1.0, 2.0, 1.0), strict=True)):
        frame = N.rotate(f"A{k}", angle, N.z)
        bodies.append(kn.RigidBody(f"b{k}", frame=frame, mass_center=at, mass=1.0, inertia=kn.inertia(frame, 1, 1, 1)))
        at = at.at(f"P{k}", length * frame.x)
    close = kn.coincident(at, O.at("G", 2 * N.x), along=(N.x, N.y), name="pin")
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=close))
    with pytest.raises(kn.SingularError, match=r"constant rank 2, got rank 1 .* singular configuration"):
        kn.linearize(eom, q=[0, 0, np.pi], u=[0, 0, 0])


def test_what_cannot_be_independent_or_left_out():
    eom = systems.four_bar()
    at = {"q": {"q1": 1.2, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)}}
    with pytest.raises(kn.SimulationError, match=r"independent= to contain 1 of q1, q2, q3 .* got q1, q2"):
        kn.linearize(eom, **at, independent=("q1", "q2"), steady=False)
    with pytest.raises(kn.ValueMissingError, match="independent= among q1, q2, q3, u1, u2, u3, got q9"):
        kn.linearize(eom, **at, independent=("q9",), steady=False)
    linear = kn.linearize(systems.cart(), q=[0, 0], u=[0, 0])
    with pytest.raises(kn.SimulationError, match=r"nothing depends on, got q2: u1 depends on it.* are q1\."):
        linear.without("q2")
    with pytest.raises(kn.ValueMissingError, match="states among q1, q2, u1, u2, got x"):
        linear.without("x")
    with pytest.raises(kn.SimulationError, match="got the speeds u1"):
        linear.second_order(["u1"])
    lin = disk()
    with pytest.raises(kn.SimulationError, match="as many speeds as coordinates, got 5 coordinates"):
        lin(q=[0] * 5, u={"u1": 0, "u2": 0, "u3": 0}).second_order()
    with pytest.raises(kn.ValueMissingError, match="outputs in symbols of the system, got z"):
        kn.linearize(systems.cart(), q=[0, 0], u=[0, 0], outputs={"z": kn.coordinate("z")})
    with pytest.raises(kn.ValueMissingError, match=r"Expected one of q1, .*got 'x'"):
        kn.linearize(systems.cart(), q=[0, 0], u=[0, 0], outputs={"v": "x"})
    with pytest.raises(kn.ArgumentError, match="an expression, vector or name as the output 'v'"):
        kn.linearize(systems.cart(), q=[0, 0], u=[0, 0], outputs={"v": {"x"}})
