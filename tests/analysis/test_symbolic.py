# SPDX-License-Identifier: BSD-3-Clause
"""Symbolic linearization against closed forms and against the numeric one; the unsolved equations against the solved ones."""

import numpy as np
import pytest

import kane as kn
from kane.dynamics import unsolved
from tests.systems import steady as systems


def test_cart_in_symbols():
    eom = systems.cart()
    made = kn.linearize_symbolic(eom, {"q1": 0, "q2": 0, "u1": 0, "u2": 0, "F": 0})
    M, m, l, g = (next(p for p in eom.parameters if p.name == n) for n in ("M", "m", "l", "g"))
    for values in ({M: 2.0, m: 0.5, l: 0.7, g: 9.81}, {M: 1.1, m: 3.0, l: 0.2, g: 1.6}):
        a, b = kn.evaluate(made.A, values), kn.evaluate(made.B, values)
        Mv, mv, lv, gv = (values[p] for p in (M, m, l, g))
        expected = [[0, 0, 1, 0], [0, 0, 0, 1], [0, mv * gv / Mv, 0, 0], [0, -(Mv + mv) * gv / (Mv * lv), 0, 0]]
        np.testing.assert_allclose(a, expected, atol=1e-13)
        np.testing.assert_allclose(b[:, 0], [0, 0, 1 / Mv, -1 / (Mv * lv)], atol=1e-13)
    assert made.states == ("q1", "q2", "u1", "u2")


def test_inverted_pendulum_reads_as_in_a_book():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (q,) = kn.coordinates("q1:2")
    m, l, g = kn.parameter("m", 1.0), kn.parameter("l", 1.0), kn.parameter("g", 10.0)
    A = N.rotate("A", q, N.z)
    system = kn.System(
        N, bodies=[kn.Particle("p", O.at("P", l * A.y), m)], speeds="rates", loads=[kn.gravity(-g * N.y)]
    )
    made = kn.linearize_symbolic(kn.derive(system), {"q1": 0, "u1": 0})
    assert [[str(x) for x in row] for row in made.A.rows] == [["0", "1"], ["g/l", "0"]]


@pytest.mark.parametrize("name", ["disk", "sleigh", "free body", "double pendulum"])
def test_symbols_and_numbers_agree(name):
    """The same A and B as by `linearize`, with constraints, Euler parameters and inputs."""
    make, q, u, inputs = {
        "disk": (systems.rolling_disk, [0.3, 0, 0.1, 2, 3], {"u1": 0, "u2": 0, "u3": -7.0}, {}),
        "sleigh": (systems.sleigh, [1, 2, 0.3], {"v": 1.5, "w": 0, "s": 0}, {"F": 0.3}),
        "free body": (
            systems.free_body,
            [0, 0, 0, 1, 0, 0, 0],
            [0, 2.0, 0, 1.0, 0, 0],
            {"T": 0},
        ),
        "double pendulum": (systems.double_pendulum, [0, np.pi], [0, 0], {"s1": 0, "s2": 0}),
    }[name]
    eom = make()
    numeric = kn.linearize(eom, q=q, u=u, inputs=inputs)
    at = numeric.point
    values = {s.name: v for group in (at.q, at.u, at.inputs) for s, v in group.items()}
    symbolic = kn.linearize_symbolic(eom, values)
    assert symbolic.states == numeric.states
    np.testing.assert_allclose(kn.evaluate(symbolic.A, {}), numeric.A, atol=1e-12)
    if symbolic.inputs:
        np.testing.assert_allclose(kn.evaluate(symbolic.B, {}), numeric.B, atol=1e-12)


def test_rolling_disk_in_symbols():
    """The critical speed v² = g R/3 from the symbolic matrix, v left as a symbol."""
    eom = systems.rolling_disk()
    v = kn.parameter("v", 1.0)
    R = next(p for p in eom.parameters if p.name == "R")
    made = kn.linearize_symbolic(
        eom, dict.fromkeys(["q1", "q2", "q3", "q4", "q5", "u1", "u2", "u5"], 0) | {"u3": -v / R, "u4": v}
    )
    at = {"v": np.sqrt(9.81 * 0.3 / 3)}
    a = kn.evaluate(made.A, {v: at["v"]})
    assert np.sum(np.linalg.eigvals(a) ** 2).real == pytest.approx(0, abs=1e-9)
    a = kn.evaluate(made.A, {v: 2.0})
    assert np.sum(np.linalg.eigvals(a) ** 2).real < -10


def test_points_that_are_refused():
    eom = systems.rolling_disk()
    still = dict.fromkeys(["q1", "q2", "q3", "q4", "q5", "u1", "u2", "u3", "u4", "u5"], 0.0)
    with pytest.raises(
        kn.SimulationError, match=r"a point on the constraints, got one that violates rolling of C\^ 1 by 0\.9"
    ):
        kn.linearize_symbolic(eom, still | {"u3": 3.0})
    with pytest.raises(kn.SimulationError, match=r"equilibrium or a steady motion, got a point at which u1' = -7\.73"):
        kn.linearize_symbolic(eom, still | {"q2": 0.3})
    with pytest.raises(kn.ValueMissingError, match="the point of the system"):
        kn.linearize_symbolic(eom, still | {"q9": 0.3})


@pytest.mark.parametrize("make", [systems.rolling_disk, systems.cart, systems.sleigh, systems.double_pendulum])
def test_unsolved_equations_hold_at_the_solved_values(make):
    """K z = k with the accelerations, multipliers and reactions that the solved equations give, on the constraints."""
    eom = make()
    made = unsolved(eom.derived)
    rng = np.random.default_rng(4)
    q = dict(zip(eom.coordinates, rng.uniform(0.2, 0.9, len(eom.coordinates)), strict=True))
    given = dict(zip(eom.independent_speeds, rng.normal(size=len(eom.independent_speeds)), strict=True))
    at = kn.assemble(eom, q=q, u=given)
    inputs = dict.fromkeys(eom.inputs, 0.4)
    n, m = len(eom.speeds), len(eom.b)
    z = np.concatenate(
        [
            eom.evaluate(list(group), q=at.q, u=at.u, inputs=inputs) if group else np.zeros(0)
            for group in (eom.accelerations, list(eom.multipliers.values()), eom.reactions)
        ]
    )
    assert len(made.unknowns) == len(z) == n + m + len(eom.reactions)
    matrix = np.array(eom.evaluate(kn.Matrix(made.matrix), q=at.q, u=at.u, inputs=inputs))
    right = np.array(eom.evaluate(list(made.right), q=at.q, u=at.u, inputs=inputs))
    np.testing.assert_allclose(matrix @ z, right, atol=1e-11)


def test_euler_parameters_of_a_point_in_symbols_are_of_unit_length():
    """Where they are left out they are so at the sample: a compound pendulum at rest has its frequencies at any heading."""
    N = kn.Frame("N")
    m, l, g = kn.parameter("m", 2.0), kn.parameter("l", 0.7), kn.parameter("g", 9.81)
    hinge = kn.ball("b", kn.Point("O", fixed_in=N), N)
    center, inertia = hinge.point.at("C", -l * hinge.frame.z), kn.inertia(hinge.frame, 1, 2, 3)
    body = kn.RigidBody("bob", frame=hinge.frame, mass_center=center, mass=m, inertia=inertia)
    eom = kn.derive(kn.System(N, bodies=[body], joints=[hinge], loads=[kn.gravity(-g * N.z)]))
    e0, e1, e2, e3 = eom.coordinates
    still = dict.fromkeys(eom.speeds, 0)
    with pytest.raises(kn.SimulationError, match="violates unit length of Euler parameters by 3 "):
        kn.linearize_symbolic(eom, {**still, e0: 2, e1: 0, e2: 0, e3: 0})
    made = kn.linearize_symbolic(eom, {**still, e1: 0, e2: 0})
    for turn in (0.0, 0.8, 3.0):
        numeric = kn.linearize(eom, q=[np.cos(turn), 0, 0, np.sin(turn)], u=0)
        a = kn.evaluate(made.A, {e0: np.cos(turn), e3: np.sin(turn)})
        np.testing.assert_allclose(a, numeric.A, atol=1e-12)
