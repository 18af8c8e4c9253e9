# SPDX-License-Identifier: BSD-3-Clause
"""The frozen result: tables, the seven steps, numbers at a state."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinate("q")
u = kn.speed("u")
m, g, L = kn.parameter("m", 2.0), kn.parameter("g", 9.81), kn.parameter("L")
A = N.rotate("A", q, N.z)
P = O.at("P", 0)
B = P.at("B", -L * A.y)
T = kn.input("T")
R = kn.reaction("R", at=P, along=N.y)
SYSTEM = kn.System(
    N,
    bodies=[kn.Particle("bob", B, m)],
    speeds={u: L * q.dt},
    loads=[kn.gravity(-g * N.y), kn.Torque(A, T * N.z)],
    reactions=[R],
)
EOM = kn.derive(SYSTEM)
AT = {"parameters": {L: 0.5}, "inputs": {T: 0.3}}
STATE = {"q": {q: 0.4}, "u": {u: 0.8}, **AT}


def array(values):
    return np.array([np.asarray(v, dtype=float) for v in values])


def test_the_pendulum_in_text():
    assert str(EOM.mass_matrix[0, 0]) == "m"
    assert [str(x) for x in EOM.rates] == ["u/L"]
    assert str(EOM.velocities[B]) == "u A.x"
    assert str(EOM.partial_velocities[B][u]) == "A.x"
    assert str(EOM.point_accelerations[B]) == "u' A.x + u^2/L A.y"
    assert str(EOM.Fr[0]) in ("T/L - g*m*sin(q)", "T/L - m*g*sin(q)")
    assert str(EOM.Fr_star[0]) == "-m*u'"
    assert (EOM.coordinates, EOM.speeds, EOM.reactions, EOM.inputs) == ((q,), (u,), (R,), (T,))
    assert {p.name for p in EOM.parameters} == {"m", "g", "L"}
    assert [s.name for s in EOM.auxiliary_speeds] == ["u_R"]


def test_closed_form():
    u_dot, reaction = array(EOM.evaluate([u.dt, R], **STATE))
    assert u_dot == pytest.approx(0.3 / 0.5 / 2 - 9.81 * np.sin(0.4))
    expected = 2 * (9.81 + u_dot * np.sin(0.4) + 0.8**2 / 0.5 * np.cos(0.4))
    assert reaction == pytest.approx(expected)


class TestTables:
    def test_keys(self):
        assert set(EOM.velocities) == set(EOM.points)
        assert set(EOM.angular_velocities) == set(EOM.frames)
        assert len(EOM.velocities) == 3
        assert list(EOM.partial_velocities[B]) == [u, *EOM.auxiliary_speeds]
        assert set(EOM.Fr_contributions) == {(s, load) for s in EOM.all_speeds for load in EOM.loads}

    def test_unknown_keys_are_named(self):
        with pytest.raises(KeyError, match="Expected one of O, P, B, got X"):
            EOM.velocities[O.at("X", N.x)]
        with pytest.raises(KeyError, match="got"):
            EOM.partial_velocities[B][kn.speed("other")]
        with pytest.raises(KeyError, match=r"got .u, wind"):
            EOM.Fr_contributions[u, "wind"]

    def test_membership_and_text(self):
        assert B in EOM.velocities
        assert O.at("X", N.x) not in EOM.velocities
        assert "u A.x" in repr(EOM.velocities)

    def test_read_only(self):
        with pytest.raises(TypeError):
            EOM.velocities[B] = None  # type: ignore[index]


def test_frozen():
    with pytest.raises(AttributeError):
        EOM.speeds = ()  # type: ignore[misc]


def test_repr():
    assert repr(EOM).startswith("Equations(bob: 1 coordinate, 1 speed, 1 reaction, ")


def test_the_seven_steps():
    steps = EOM.steps
    assert [s.number for s in steps] == [1, 2, 3, 4, 5, 6, 7]
    assert steps[0].items == (("q", "coordinate"),)
    assert [name for name, _ in steps[2].items] == ["u", "q'"]
    assert "v_B,u = A.x" in str(steps[3])
    assert [name for name, _ in steps[4].items] == ["F_u", "F_u_R"]
    assert [name for name, _ in steps[5].items] == ["F*_u", "F*_u_R"]
    assert {name for name, _ in steps[6].items} == {"M[u, u]", "f[u]", "M[u_R, u]", "f[u_R]"}
    assert str(steps[0]).startswith("Step 1. Coordinates")


class TestDerivatives:
    def test_along_the_motion(self):
        e = kn.sin(q) * u + kn.time**2
        assert float(EOM.evaluate(EOM.time_derivative(e), t=2.0, **STATE)) == pytest.approx(
            np.cos(0.4) * 0.8 / 0.5 * 0.8 + np.sin(0.4) * float(EOM.evaluate(u.dt, **STATE)) + 4
        )

    def test_in_speeds(self):
        assert str(EOM.in_speeds(q.dt)) == "u/L"
        assert str(EOM.in_speeds(q.dt.dt)) == "u'/L"
        assert EOM.in_speeds(3 * q) is 3 * q
        assert str(EOM.in_speeds(2)) == "2"

    @pytest.mark.parametrize("e", [u.dt, q.dt.dt, R, q.dt.dt.dt])
    def test_what_it_cannot_differentiate_it_says(self, e):
        with pytest.raises(kn.ExpressionError, match="to differentiate along the motion"):
            EOM.time_derivative(e)

    def test_third_derivatives_are_refused(self):
        with pytest.raises(kn.ExpressionError, match="differentiate along the motion"):
            EOM.evaluate(q.dt.dt.dt, **STATE)


class TestEvaluate:
    def test_rates_accelerations_and_reactions_are_replaced(self):
        rate, second, mixed = array(EOM.evaluate([q.dt, q.dt.dt, q.dt * u.dt + R], **STATE))
        assert rate == pytest.approx(1.6)
        u_dot, reaction = array(EOM.evaluate([u.dt, R], **STATE))
        assert second == pytest.approx(2 * u_dot)
        assert mixed == pytest.approx(1.6 * u_dot + reaction)

    def test_auxiliary_speeds_are_zero(self):
        assert float(EOM.evaluate(3 + EOM.auxiliary_speeds[0], **STATE)) == 3

    def test_ways_to_give_values(self):
        expected = float(EOM.evaluate(u.dt, **STATE))
        for given in (
            {"q": [0.4], "u": [0.8], "parameters": {"L": 0.5}, "inputs": [0.3]},
            {"q": {"q": 0.4}, "u": {"u": 0.8}, "parameters": {"L": 0.5, "m": 2}, "inputs": {"T": 0.3}},
            {"q": np.array([0.4]), "u": (0.8,), "parameters": {L: 0.5, m: 2.0, g: 9.81}, "inputs": {T: 0.3}},
        ):
            assert float(EOM.evaluate(u.dt, **given)) == pytest.approx(expected)

    def test_arrays_broadcast(self):
        angles, speeds = np.linspace(0, 1, 5), np.array([[0.8], [1.6]])
        found = EOM.evaluate(R, q=[angles], u=[speeds], **AT)
        assert found.shape == (2, 5)
        for i in range(2):
            for j in range(5):
                one = EOM.evaluate(R, q=[angles[j]], u=[speeds[i, 0]], **AT)
                assert found[i, j] == pytest.approx(float(one))
        matrix = EOM.evaluate(EOM.mass_matrix, q=[angles], u=[0.8], parameters={L: 0.5, m: angles}, inputs={T: 0})
        assert matrix.shape == (5, 1, 1)

    def test_shapes(self):
        assert EOM.evaluate([], **STATE) == []
        assert EOM.evaluate(kn.Matrix([[1, q]]), **STATE) == pytest.approx(np.array([[1, 0.4]]))
        assert float(EOM.evaluate(7, **STATE)) == 7

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"q": [0.4, 1]}, "Expected 1 coordinates .q., got 2 values"),
            ({"q": {"x": 1}}, "coordinates of the system .q., got one for 'x'"),
            ({"u": {kn.speed("w"): 1}}, "speeds of the system .u., got one for w"),
            ({"parameters": {kn.parameter("m", 3.0): 1}}, "parameters of the system"),
            ({"parameters": {}}, "got none for L .Parameter."),
            ({"inputs": {}}, "got none for T .Input."),
            ({"u": None}, "got none for u .Speed."),
            ({"q": {3: 1.0}}, "got one for 3"),
        ],
    )
    def test_errors(self, given, message):
        with pytest.raises(kn.ValueMissingError, match=message):
            EOM.evaluate(u.dt + 0 * q + kn.sin(q) * u, **(STATE | given))


def test_operations_count_the_whole_right_hand_side():
    eom = kn.derive(rolling_disk.system())
    assert eom.operations.total == kn.count_operations([*eom.right_hand_side, *eom.solved.reactions]).total
    assert eom.operations.total > 80


def test_momenta_and_mass_center():
    """Of a free body: p = m v, and about a fixed point Σ I ω + r × m v."""
    x = kn.coordinates("a b c x y z")
    F = N.rotate_body("F", x[:3], "xyz")
    C = O.at("C", x[3] * N.x + x[4] * N.y + x[5] * N.z)
    bodies = [
        kn.RigidBody("b", frame=F, mass_center=C, mass=3, inertia=kn.inertia(F, 1, 2, 3)),
        kn.Particle("p", C.at("p", 0.5 * F.x), 1),
    ]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates"))
    state = {"q": np.arange(1, 7) / 7, "u": np.arange(6, 0, -1) / 5}
    v = [array(eom.evaluate(eom.velocities[b.mass_center].components(N), **state)) for b in bodies]
    r = [array(eom.evaluate(b.mass_center.position(O).components(N), **state)) for b in bodies]
    w = array(eom.evaluate(eom.angular_velocities[F].components(F), **state))
    turn = eom.evaluate(N.dcm(F), **state)
    p = array(eom.evaluate(eom.linear_momentum().components(N), **state))
    assert p == pytest.approx(3 * v[0] + v[1])
    h = array(eom.evaluate(eom.angular_momentum(O).components(N), **state))
    assert h == pytest.approx(turn @ np.diag([1, 2, 3]) @ w + np.cross(r[0], 3 * v[0]) + np.cross(r[1], v[1]))
    center = array(eom.evaluate(eom.mass_center(O).components(N), **state))
    assert center == pytest.approx((3 * r[0] + r[1]) / 4)
    # without loads both stay: their rates vanish
    for vector in (eom.linear_momentum(), eom.angular_momentum(O)):
        rates = [eom.time_derivative(e) for e in vector.components(N)]
        assert array(eom.evaluate(rates, **state)) == pytest.approx(np.zeros(3), abs=1e-12)


def test_speeds_from_rates_invert_the_rates():
    """u = Y q̇ + z, then q̇ = W u + X; Euler parameters with rates that keep their length."""
    from kane.gallery import free_body, rolling_disk

    disk = kn.derive(rolling_disk.system())
    q, rates = [0.1, 0.2, 0.3, 0.4, 0.5], np.array([1.0, -2.0, 3.0, 4.0, -5.0])
    u = disk.speeds_from_rates(q, rates)
    np.testing.assert_allclose(disk.evaluate(disk.rates, q=q, u=u), rates, rtol=1e-14)
    start = kn.simulate(disk, (0, 1e-3), q=q, rates=rates, samples=2)
    np.testing.assert_allclose(start.u[0], [float(v) for v in u.values()], rtol=1e-14)
    with pytest.raises(kn.SimulationError, match=r"either u= or rates=.*both"):
        kn.simulate(disk, (0, 1), q=q, u=u, rates=rates)
    with pytest.raises(kn.ValueMissingError, match="none for q2"):
        disk.speeds_from_rates(q, {"q1": 1, "q3": 0, "q4": 0, "q5": 0})

    body = kn.derive(free_body.system())
    e = np.array([0.5, 0.1, -0.7, 0.5])
    e /= np.linalg.norm(e)
    e_dot = np.array([0.3, -0.2, 0.4, 0.9])
    e_dot -= e * (e @ e_dot)
    place = dict(zip(("e0", "e1", "e2", "e3"), e, strict=True))
    change = dict(zip(("e0", "e1", "e2", "e3"), e_dot, strict=True))
    for name in [c.name for c in body.coordinates if c.name not in place]:
        place[name], change[name] = 0.3, 0.7
    found = body.evaluate(body.rates, q=place, u=body.speeds_from_rates(place, change))
    np.testing.assert_allclose(found, [change[c.name] for c in body.coordinates], atol=1e-14)


def test_speeds_from_rates_where_their_definitions_hold_an_input():
    N, x, u, wind = kn.Frame("N"), kn.coordinate("x"), kn.speed("u"), kn.input("wind")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", P, 1.0)], speeds={u: x.dt - wind}))
    assert eom.speeds_from_rates([0.0], [2.0], inputs={wind: 0.5}) == {u: 1.5}


def test_values_share_one_shape():
    from kane.gallery import rolling_disk

    disk = kn.derive(rolling_disk.system())
    found = disk.evaluate([disk.coordinates[0], 1], q={"q1": np.arange(3.0)})
    assert [v.shape for v in found] == [(3,), (3,)]
