# SPDX-License-Identifier: BSD-3-Clause
"""u = Y q̇ + z and its inverse, the recovery of speeds by matching, and what speeds must not be."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk
from kane.kinematics import generalized_speeds
from tests.paths import Path

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:7")
u = kn.speeds("u1:7")
m = kn.parameter("m", 2.0)


def array(values):
    return np.array([np.asarray(v, dtype=float) for v in values])


def free_body(definitions, sequence="zxz", orientation=None):
    """A free rigid body; `definitions(P, B)` gives its six speeds."""
    P = O.at("P", q[3] * N.x + q[4] * N.y + q[5] * N.z)
    B = N.rotate_body("B", q[:3], sequence) if orientation is None else orientation
    body = kn.RigidBody("body", frame=B, mass_center=P, mass=m, inertia=kn.inertia(B, 1.5, 2, 3, 0.1, 0.2, 0.3))
    loads = [kn.Torque(B, 0.4 * B.x - 0.3 * N.y), kn.Force(P.at("tip", B.y), 2 * N.z), kn.gravity(-9.81 * N.z)]
    system = kn.System(
        N, bodies=[body], speeds=dict(zip((*u, kn.speed("u7")), definitions(P, B), strict=False)), loads=loads
    )
    return kn.derive(system), P, B


def components(v, frame):
    return [v.dot(axis) for axis in (frame.x, frame.y, frame.z)]


def rates(P, B):
    return [x.dt for x in q]


def omega(P, B):
    return [*components(B.angular_velocity(N), B), *(x.dt for x in q[3:])]


def omega_and_v(P, B):
    return [*components(B.angular_velocity(N), B), *components(P.velocity(N), B)]


def omega_and_v_by_components(P, B):
    return [*B.angular_velocity(N).components(B), *P.velocity(N).express(B).components(B)]


def shifted(P, B):
    w = B.angular_velocity(N)
    return [
        w.dot(B.y) + kn.sin(kn.time),
        2 * w.dot(B.z) - q[3] * kn.time,
        w.dot(B.x),
        q[3].dt + 0.5,
        q[4].dt,
        q[5].dt - m,
    ]


def scrambled(P, B):
    w = components(B.angular_velocity(N), B)
    return [w[1], -w[0], q[3].dt, w[2], -q[5].dt, q[4].dt]


def mixed(P, B):
    w = components(B.angular_velocity(N), N)
    x = q
    return [
        w[0] + x[3].dt,
        x[3].dt - 2 * w[1],
        w[1] + kn.cos(x[0]) * x[4].dt,
        w[2],
        x[5].dt + w[2] * x[0],
        3 * x[4].dt - w[2],
    ]


CHOICES = [rates, omega, omega_and_v, omega_and_v_by_components, shifted, scrambled, mixed]


@pytest.mark.parametrize("choice", CHOICES, ids=lambda f: f.__name__)
class TestKinematicalEquations:
    def test_definitions_hold(self, choice):
        """With q̇ from u the definitions give u again; Y, z, W, X say the same."""
        eom, _, _ = free_body(choice)
        path = Path(q, 41, t0=0.6)
        speeds = np.random.default_rng(1).normal(size=6)
        state = {"q": dict(zip(q, path.q, strict=True)), "u": dict(zip(u, speeds, strict=True)), "t": 0.6}
        back = array(eom.evaluate(list(eom.system.speeds.values()), **state))
        assert back == pytest.approx(speeds, abs=1e-12)
        Y, W = eom.evaluate(eom.Y, **state), eom.evaluate(eom.W, **state)
        z, X = array(eom.evaluate(list(eom.z), **state)), array(eom.evaluate(list(eom.X), **state))
        q_dot = array(eom.evaluate(list(eom.rates), **state))
        assert pytest.approx(np.eye(6), abs=1e-11) == Y @ W
        assert Y @ q_dot + z == pytest.approx(speeds, abs=1e-11)
        assert W @ speeds + X == pytest.approx(q_dot, abs=1e-11)
        assert Y @ X + z == pytest.approx(np.zeros(6), abs=1e-11)
        if choice is shifted:
            assert np.abs(z).max() > 0.1
        else:
            assert z == pytest.approx(np.zeros(6))

    def test_motion_does_not_depend_on_the_choice(self, choice):
        """The same q̇ gives the same q̈, ω, α, v, a whatever the speeds."""
        reference, P0, B0 = free_body(rates)
        eom, P, B = free_body(choice)
        path = Path(q, 42, t0=0.2)
        common = {"q": dict(zip(q, path.q, strict=True)), "t": 0.2}
        given = kn.evaluate(list(eom.system.speeds.values()), path.values())
        ours = common | {"u": dict(zip(eom.speeds, given, strict=True))}
        theirs = common | {
            "u": dict(zip(reference.speeds, [path.values()[x.dt] for x in reference.coordinates], strict=True))
        }

        def everything(eom, P, B, state):
            wanted = [x.dt.dt for x in q]
            for v in (
                eom.angular_velocities[B],
                eom.angular_accelerations[B],
                eom.velocities[P],
                eom.point_accelerations[P],
            ):
                wanted += v.components(N)
            return array(eom.evaluate([*wanted, eom.kinetic_energy, eom.power], **state))

        expected = everything(reference, P0, B0, theirs)
        assert everything(eom, P, B, ours) == pytest.approx(expected, rel=1e-9, abs=1e-10)


class TestMatching:
    """A measure number whose row in the rates is a combination of rows of Y becomes those speeds, before W is used."""

    def test_the_disk(self):
        """ω prints in three speeds; it and its partials are finite at cos q2 = 0, where W is not."""
        disk = rolling_disk.model()
        eom = kn.derive(disk.system)
        w = eom.angular_velocities[disk.C]
        assert str(w) == "u1 B.x + u2 B.y + u3 B.z"
        partials = eom.partial_angular_velocities[disk.C]
        assert [str(partials[s]) for s in disk.u] == ["B.x", "B.y", "B.z", "0", "0"]
        state = {
            "q": dict(zip(disk.q, [0.4, np.pi / 2, 0.1, 1.0, 2.0], strict=True)),
            "u": dict(zip(disk.u, [0.3, 0.7, 1.0, 0.2, 0.1], strict=True)),
        }
        assert array(eom.evaluate(w.components(disk.B), **state)) == pytest.approx([0.3, 0.7, 1.0], abs=1e-15)
        # B = Y there: b2 lies in the plane, along the yaw's y, and b3 is up
        expected = [0.3 * np.cos(0.4) - 0.7 * np.sin(0.4), 0.3 * np.sin(0.4) + 0.7 * np.cos(0.4), 1.0]
        assert array(eom.evaluate(w.components(disk.N), **state)) == pytest.approx(expected, abs=1e-12)
        # the yaw rate is u2/cos q2, so that the frame B and the point above the trace run away: that is no artefact
        for what in (disk.q[0].dt, eom.mass_matrix):
            with pytest.raises(kn.SingularError, match=r"W of q' = W u \+ X divided by cos\(q2\) = 6\.12e-17"):
                eom.evaluate(what, **state)

    @pytest.mark.parametrize(
        "choice", [omega, omega_and_v, omega_and_v_by_components, scrambled], ids=lambda f: f.__name__
    )
    def test_a_free_body_at_exact_gimbal_lock(self, choice):
        """u̇ is right at θ = 0, though φ̇ and ψ̇ are not finite: Euler's equations in NumPy are the second route."""
        eom, P, B = free_body(choice)
        state = {
            "q": dict(zip(q, [0.3, 0.0, 0.5, 1, 2, 3], strict=True)),
            "u": dict(zip(u, [1, 2, 3, 4, 5, 6.0], strict=True)),
        }
        with pytest.raises(kn.SingularError, match=r"W of q' = W u \+ X divided by sin"):
            eom.evaluate(list(eom.rates), **state)
        angle = 0.3 + 0.5
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        inertia = np.array([[1.5, 0.1, 0.3], [0.1, 2, 0.2], [0.3, 0.2, 3]])
        w = array(eom.evaluate(eom.angular_velocities[B].components(B), **state))
        v = array(eom.evaluate(eom.velocities[P].components(N), **state))
        force = np.array([0, 0, 2 - 2 * 9.81])
        torque = np.array([0.4, 0, 0]) + turn.T @ np.array([0, -0.3, 0]) + np.cross([0, 1, 0], turn.T @ [0, 0, 2])
        alpha = np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))
        a = force / 2
        solved = dict(zip(eom.speeds, array(eom.evaluate(list(eom.accelerations), **state)), strict=True))
        found = array([solved[s] for s in u])
        relative = turn.T @ a - np.cross(w, turn.T @ v)
        expected = {
            omega: [*alpha, *a],
            omega_and_v: [*alpha, *relative],
            omega_and_v_by_components: [*alpha, *relative],
            scrambled: [alpha[1], -alpha[0], a[0], alpha[2], -a[2], a[1]],
        }[choice]
        assert found == pytest.approx(np.array(expected), abs=1e-12)

    def test_velocity_components_of_the_mass_center(self):
        eom, P, _ = free_body(omega_and_v)
        assert str(eom.velocities[P]) == "u4 B.x + u5 B.y + u6 B.z"
        assert str(eom.partial_velocities[P][u[4]]) == "B.y"

    def test_velocity_components_beside_a_prescribed_one(self):
        """In a plane that turns by itself the third component holds no speed: the other two are matched all the same."""
        x, y, angle = kn.coordinates("x y angle")
        plane = N.rotate("plane", kn.parameter("Omega", 2.0) * kn.time, N.y)
        E = plane.rotate("E", angle, plane.z)
        P = O.at("P", x * plane.x + y * plane.y)
        a, b, w = kn.speeds("a b w")
        v = P.velocity(N)
        far = kn.Particle("far", P.at("Q", kn.parameter("L", 0.5) * E.x), m)
        definitions = {a: v.dot(E.x), b: v.dot(E.y), w: angle.dt}
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("near", P, m), far], speeds=definitions))
        assert str(eom.velocities[P]) == "a E.x + b E.y - Omega*x E.z"
        assert [str(eom.partial_velocities[P][s]) for s in (a, b, w)] == ["E.x", "E.y", "0"]
        by_rates = kn.derive(kn.System(N, bodies=[kn.Particle("near", P, m), far], speeds="rates"))
        state = {"q": {x: 0.3, y: -0.2, angle: 0.7}, "t": 0.4}
        there = {**state, "u": [1.1, 0.6, -0.9]}
        c, s = np.cos(0.7), np.sin(0.7)
        here = {**state, "u": [1.1 * c + 0.6 * s, 0.6 * c - 1.1 * s, -0.9]}
        read = lambda e, at: array(e.evaluate(e.point_accelerations[far.point].components(N), **at))  # noqa: E731
        np.testing.assert_allclose(read(eom, here), read(by_rates, there), rtol=1e-12)

    def test_a_child_on_a_matched_body(self):
        """A link pinned to a free body inherits its speeds, and is finite at gimbal lock too."""
        P = O.at("P", q[3] * N.x + q[4] * N.y + q[5] * N.z)
        B = N.rotate_body("B", q[:3], "zxz")
        hinge = kn.coordinate("h")
        C = B.rotate("C", hinge, (B.x + 2 * B.y - 2 * B.z) / 3)
        tip = P.at("J", 2 * B.x).at("C*", -C.y)
        bodies = [
            kn.RigidBody("b", frame=B, mass_center=P, mass=m, inertia=kn.inertia(B, 1, 2, 3)),
            kn.RigidBody("c", frame=C, mass_center=tip, mass=1, inertia=kn.inertia(C, 0.1, 0.2, 0.3)),
        ]
        hinge_speed = kn.speed("uh")
        definitions = dict(zip(u, omega_and_v(P, B), strict=True)) | {hinge_speed: hinge.dt}
        eom = kn.derive(kn.System(N, bodies=bodies, speeds=definitions))
        values = {s: 0.3 * k for k, s in enumerate(eom.speeds, 1)}
        state = {"q": dict.fromkeys(q, 0.0) | {hinge: 0.4}, "u": values}
        found = array(eom.evaluate(list(eom.accelerations), **state))
        assert np.isfinite(found).all()
        near = {"q": dict.fromkeys(q, 1e-07) | {hinge: 0.4}, "u": values}
        assert found == pytest.approx(array(eom.evaluate(list(eom.accelerations), **near)), rel=1e-5)

    def test_signs(self):
        """A measure number that is the negative of a speed."""
        A = N.rotate("A", q[0], N.z)
        P = O.at("P", A.x)
        w = A.angular_velocity(N)
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds={u[0]: -w.dot(A.z)}))
        assert str(eom.angular_velocities[A]) == "-u1 A.z"
        assert str(eom.velocities[P]) == "-u1 A.y"


class TestEulerParameters:
    e = kn.coordinates("e0:4")
    B = N.rotate_euler_parameters("B", e)

    def eom(self, definitions=None):
        B = self.B
        w = components(B.angular_velocity(N), B)
        definitions = w if definitions is None else definitions(w, B)
        return free_body(lambda P, F: [*definitions, *components(P.velocity(N), F)], orientation=B)[0], B

    def state(self, seed=5):
        rng = np.random.default_rng(seed)
        e = rng.normal(size=4)
        e /= np.linalg.norm(e)
        return {"q": dict(zip((*self.e, *q[3:]), (*e, *rng.normal(size=3)), strict=True)),
                "u": dict(zip(u, rng.normal(size=6), strict=True))}  # fmt: skip

    @pytest.mark.parametrize(
        "definitions",
        [None, lambda w, B: components(B.angular_velocity(N), N), lambda w, B: [w[0] + w[1], 2 * w[2], w[1] - kn.time]],
    )
    def test_Y_is_square_and_has_the_row_of_the_unit_length(self, definitions):
        eom, _ = self.eom(definitions)
        assert eom.Y.shape == eom.W.shape == (7, 7)
        state = self.state()
        Y, W = eom.evaluate(eom.Y, **state), eom.evaluate(eom.W, **state)
        assert pytest.approx(np.eye(7), abs=1e-12) == Y @ W
        row = Y[6]  # last: eᵀė = 0
        e = [state["q"].get(x, 0.0) if x in set(self.e) else 0.0 for x in eom.coordinates]
        assert row == pytest.approx(e)
        speeds = [*(state["u"][s] for s in eom.speeds), 0.0]
        q_dot = array(eom.evaluate(list(eom.rates), **state))
        z, X = array(eom.evaluate(list(eom.z), **state)), array(eom.evaluate(list(eom.X), **state))
        assert W @ speeds + X == pytest.approx(q_dot, abs=1e-12)
        assert Y @ q_dot + z == pytest.approx(speeds, abs=1e-12)
        rate_of = dict(zip(eom.coordinates, q_dot, strict=True))
        assert sum(state["q"][x] * rate_of[x] for x in self.e) == pytest.approx(0, abs=1e-15)

    def test_same_motion_as_with_angles(self):
        """α and a of the body with Euler parameters and with Euler angles at one orientation."""
        eom, _ = self.eom()
        other, _, _ = free_body(omega_and_v)
        state = self.state(6)
        e = np.array([state["q"][x] for x in self.e])
        from scipy.spatial.transform import Rotation

        angles = Rotation.from_quat([*e[1:], e[0]]).as_euler("ZXZ")
        angled = {"q": dict(zip(q, (*angles, *(state["q"][x] for x in q[3:])), strict=True)), "u": state["u"]}
        found = dict(zip(eom.speeds, array(eom.evaluate(list(eom.accelerations), **state)), strict=True))
        expected = dict(zip(other.speeds, array(other.evaluate(list(other.accelerations), **angled)), strict=True))
        assert [found[s] for s in u] == pytest.approx([expected[s] for s in u])

    def test_rates_in_the_angular_acceleration_in_rates(self):
        """α written in rates holds the derivatives of the quasi-rates; along the motion they are known."""
        eom, B = self.eom()
        state = self.state(7)
        expected = array(eom.evaluate(eom.angular_accelerations[B].components(N), **state))
        assert array(eom.evaluate(B.angular_acceleration(N).components(N), **state)) == pytest.approx(expected)
        second = array(eom.evaluate([x.dt.dt for x in self.e], **state))
        e, e_dot = array([state["q"][x] for x in self.e]), array(eom.evaluate([x.dt for x in self.e], **state))
        assert e @ second + e_dot @ e_dot == pytest.approx(0, abs=1e-13)  # twice differentiated unit length

    def test_too_many_speeds(self):
        with pytest.raises(kn.SpeedsError, match=r"independent rates, 6 \(each set of Euler parameters needs three\)"):
            free_body(lambda P, B: [*(x.dt for x in self.e), *(x.dt for x in q[3:])], orientation=self.B)


P2 = O.at("P", q[0] * N.x + q[1] * N.y)
POINT = kn.Particle("p", P2, m)
x, y = q[0].dt, q[1].dt


@pytest.mark.parametrize(
    ("definitions", "message"),
    [
        ({u[0]: x}, r"every rate in some speed's definition, got none with q2'.*u = q.dt"),
        ({}, "got none with q1', q2'"),
        ({u[0]: x + y}, "as many generalized speeds as independent rates, 2: q1', q2'; got 1: u1"),
        ({u[0]: x, u[1]: y, u[2]: x + y}, "independent rates, 2.*got 3: u1, u2, u3"),
        ({u[0]: x + y, u[1]: 2 * x + 2 * y}, "combination of u1, u2 that vanishes at every configuration"),
        ({u[0]: kn.cos(q[0]) * (x + y), u[1]: kn.sin(q[0]) * (x + y)}, "combination of u1, u2 that vanishes"),
        ({u[0]: x, u[1]: x}, "got none with q2'"),
        ({u[0]: x * y, u[1]: y}, r"definition of u1 to be linear in the rates \(u = Y q' \+ z\)"),
        ({u[0]: kn.sin(x), u[1]: y}, "linear in the rates"),
        ({u[0]: kn.sqrt(x * x), u[1]: y}, "linear in the rates"),
        ({u[0]: u[1], u[1]: y}, "definition of u1 in rates such as q', got the speed u2"),
        ({u[0]: x + q[2].dt, u[1]: y}, "got q3', but no frame or point of the system depends on that coordinate.*missing from bodies"),
        ({u[0]: q[0], u[1]: y}, "definition of u1 to contain a rate, got q1"),
        ({u[0]: 3, u[1]: y}, "definition of u1 to contain a rate"),
    ],
)  # fmt: skip
def test_what_speeds_must_not_be(definitions, message):
    with pytest.raises(kn.SpeedsError, match=message):
        kn.derive(kn.System(N, bodies=[POINT], speeds=definitions))


def test_structurally_dependent_definitions():
    P = O.at("P", q[0] * N.x + q[1] * N.y + q[2] * N.z)
    definitions = {u[0]: q[0].dt, u[1]: 2 * q[0].dt, u[2]: q[1].dt + q[2].dt}
    with pytest.raises(kn.SpeedsError, match="got structural rank 2 of 3"):
        kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds=definitions))


def test_definitions_at_very_different_scales_are_independent():
    tiny = kn.parameter("tiny", 1e-9)
    eom = kn.derive(kn.System(N, bodies=[POINT], speeds={u[0]: tiny * x, u[1]: y * 1e6}))
    found = array(eom.evaluate(list(eom.rates), q=[0, 0], u=[1e-9, 1e6]))
    assert found == pytest.approx([1, 1])


def test_singular_only_at_some_configurations_is_allowed():
    """W may be singular somewhere: that is for numbers to find."""
    eom = kn.derive(kn.System(N, bodies=[POINT], speeds={u[0]: kn.cos(q[0]) * x, u[1]: y}))
    assert [str(p) for p in eom.kinematical.pivots] == ["cos(q1)"]


def test_speeds_of_a_system_by_hand():
    """The record behind: rows of Y, what W divides by, groups of rates that meet."""
    speeds = generalized_speeds(kn.System(N, bodies=[POINT], speeds={u[0]: x + q[0] * y, u[1]: x - y + kn.time}))
    assert [str(b) for b in speeds.rates] == ["q1'", "q2'"]
    assert [{str(b): str(c) for b, c in row.items()} for row in speeds.rows] == [
        {"q1'": "1", "q2'": "q1"},
        {"q1'": "1", "q2'": "-1"},
    ]
    assert [str(z) for z in speeds.z] == ["0", "t"]
    assert len(set(speeds.groups.values())) == 1
    assert speeds.nontrivial
