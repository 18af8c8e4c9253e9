# SPDX-License-Identifier: BSD-3-Clause
"""Tree joints against poses and velocities by hand, and against Newton and Euler in redundant coordinates."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kane as kn
from tests.model.joints.kinds import AXIS, KINDS, PITCH, rigid
from tests.oracles import newton_euler
from tests.oracles.compare import error, tolerance
from tests.oracles.kane_tree import vector
from tests.oracles.tree import Body, Tree, rotation, six_points, square, triple

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def numbers(exprs, values):
    return np.array([float(x) for x in kn.evaluate(list(exprs), values)])


def state(joint, seed=1):
    """Random coordinates and rates; Euler parameters of unit length, with rates along the unit sphere."""
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-1.0, 1.0, len(joint.coordinates)), rng.uniform(-1.0, 1.0, len(joint.coordinates))
    e = [k for k, s in enumerate(joint.coordinates) if s.name.startswith("e")]
    if e:
        q[e] /= np.linalg.norm(q[e])
        v[e] -= q[e] * (q[e] @ v[e])
    return q, v


def in_steps(joint, values):
    """Values by coordinate in the order of the joint's steps: a free child is displaced before it is turned."""
    return [*values[3:], *values[:3]] if joint.kind == "free" else values


def pose(joint, q):
    values = dict(zip(joint.coordinates, q, strict=True))
    turn = np.array(kn.evaluate(joint.parent.dcm(joint.frame), values), dtype=float)
    return turn, numbers(joint.point.position(joint.at).components(joint.parent), values)


def stepped(steps, q):
    turn, point = np.eye(3), np.zeros(3)
    for step, x in zip(steps, q, strict=True):
        if step.kind == "slide":
            point = point + turn @ np.array(step.axis) * x
        else:
            turn = turn @ rotation(step.axis, x)
    return turn, point


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "screw"])
def test_the_pose_is_that_of_the_steps(kind):
    joint = KINDS[kind].make("J", O, N)
    q, _ = state(joint)
    turn, point = pose(joint, q)
    expected_turn, expected_point = stepped(KINDS[kind].steps, in_steps(joint, q))
    np.testing.assert_allclose(turn, expected_turn, atol=1e-14)
    np.testing.assert_allclose(point, expected_point, atol=1e-14)


def test_the_pose_of_a_screw():
    joint = KINDS["screw"].make("J", O, N)
    turn, point = pose(joint, [7.0])
    np.testing.assert_allclose(turn, rotation(AXIS, 7.0), atol=1e-14)
    np.testing.assert_allclose(point, PITCH * 7.0 * np.array(AXIS), atol=1e-14)


MAKES = {
    **{kind: KINDS[kind].make for kind in KINDS},
    "ball by Euler parameters": lambda *a: kn.ball(*a),
    "free by Euler parameters": lambda *a: kn.free(*a),
    "free with speeds along the parent": lambda *a: kn.free(*a, velocity="parent"),
}


@pytest.mark.parametrize("kind", MAKES)
def test_speeds_are_along_the_free_motions(kind):
    """ω = Σ rotation u and v = Σ translation u, u at its definition; ω and v by central differences of the pose."""
    joint = MAKES[kind]("J", O, N)
    q, v = state(joint)
    values = dict(zip(joint.coordinates, q, strict=True)) | {s.dt: x for s, x in zip(joint.coordinates, v, strict=True)}
    o = joint.frame.orientation
    if o.quasi:  # the quasi-rates' meaning: w = 2 G ė
        e, rates = q[:4], v[:4]
        g = np.array([[-e[1], e[0], e[3], -e[2]], [-e[2], -e[3], e[0], e[1]], [-e[3], e[2], -e[1], e[0]]])
        values |= dict(zip(o.quasi, 2 * g @ rates, strict=True))
    h = 1e-6
    (back, behind), (ahead, before) = pose(joint, q - h * v), pose(joint, q + h * v)
    spin = (ahead - back) / (2 * h) @ pose(joint, q)[0].T
    omega, velocity = np.array([spin[2, 1], spin[0, 2], spin[1, 0]]), (before - behind) / (2 * h)
    u = numbers(joint.speeds.values(), values) if joint.speeds else []
    rotation_sum, translation_sum = np.zeros(3), np.zeros(3)
    for twist, x in zip(joint.free, u, strict=True):
        rotation_sum += x * numbers(twist.rotation.components(N), values)
        translation_sum += x * numbers(twist.translation.components(N), values)
    np.testing.assert_allclose(rotation_sum, omega, atol=1e-8)
    np.testing.assert_allclose(translation_sum, velocity, atol=1e-8)
    np.testing.assert_allclose(numbers(joint.angular_velocity.components(N), values), omega, atol=1e-8)
    np.testing.assert_allclose(numbers(joint.velocity.components(N), values), velocity, atol=1e-8)


def matter(rng):
    return {
        "mass": float(rng.uniform(0.5, 2.0)),
        "center": triple(rng.uniform(-0.4, 0.4, 3)),
        "inertia": square(np.array(six_points(1.0, rng.uniform(0.2, 0.6, 3), rotation(AXIS, rng.uniform(-2, 2))))),
    }


def chain(kinds, seed):
    """The chain in kane, and in the oracle."""
    rng = np.random.default_rng(seed)
    at, frame = O, N
    joints, bodies, described = [], [], []
    for i, kind in enumerate(kinds):
        offset, m = triple(rng.uniform(-1, 1, 3)), matter(rng)
        tilt = square(rotation(AXIS, rng.uniform(-2, 2)))
        base = frame.rotate_matrix(f"T{i}", tilt)
        joint = KINDS[kind].make(f"joint {i}", at.at(f"P{i}", vector(frame, offset)), base, child=f"B{i}")
        f, c = joint.frame, joint.point.at(f"B{i}*", vector(joint.frame, m["center"]))
        (xx, xy, zx), (_, yy, yz), (_, _, zz) = m["inertia"]
        bodies.append(rigid(f"B{i}", f, c, m["mass"], kn.inertia(f, xx, yy, zz, xy, yz, zx)))
        described.append(Body(i - 1, offset, tilt, KINDS[kind].steps, **m))
        joints.append(joint)
        at, frame = joint.point, f
    gravity = (1.0, -9.81, 2.0)
    eom = kn.derive(kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(vector(N, gravity))]))
    return eom, joints, Tree(tuple(described), gravity)


@pytest.mark.parametrize(
    "kinds",
    [
        ("pin", "slider", "universal"),
        ("cylindrical", "pin", "ball"),
        ("planar", "weld", "cylindrical"),
        ("free", "universal"),
        ("ball", "planar"),
    ],
)
def test_chains_move_as_newton_and_euler_say_and_transmit_their_forces(kinds):
    """Accelerations, and the force and torque of each joint by name along the inertial axes."""
    eom, joints, tree = chain(kinds, len(kinds))
    symbols = [q for joint in joints for q in in_steps(joint, joint.coordinates)]
    rng = np.random.default_rng(5)
    q, v = rng.uniform(-1, 1, tree.size), rng.uniform(-1, 1, tree.size)
    expected = newton_euler.solve(tree, q, v)
    at = dict(zip(symbols, q, strict=True))
    u = eom.speeds_from_rates(at, dict(zip(symbols, v, strict=True)))
    limit = tolerance(1e-10, expected.condition)
    assert error(eom.evaluate([s.dt.dt for s in symbols], q=at, u=u), expected.qddot) < limit
    for i, joint in enumerate(joints):
        found = eom.reaction(f"joint {i}")
        assert found.point is joint.point
        assert error(eom.evaluate(found.force.components(N), q=at, u=u), expected.force[i]) < limit
        assert error(eom.evaluate(found.torque.components(N), q=at, u=u), expected.torque[i]) < limit


def test_a_screw_jack_by_hand():
    """A nut driven down its thread by gravity: (I + m h²) q̈ = −m g h, its bearing torque is what accelerates it."""
    joint = kn.screw("jack", O, N, axis=N.z, pitch=PITCH, child="B")
    m, inertia, g = 2.0, 0.05, 9.81
    nut = rigid("nut", joint.frame, joint.point.at("nut*", 0), m, kn.inertia(joint.frame, 1, 1, inertia))
    eom = kn.derive(kn.System(N, bodies=[nut], joints=[joint], loads=[kn.gravity(-g * N.z)]))
    turn = -m * g * PITCH / (inertia + m * PITCH**2)
    assert float(eom.evaluate(eom.accelerations[0], q=[0.3], u=[1.0])) == pytest.approx(turn)
    found = eom.reaction("jack")
    assert float(eom.evaluate(found.force.dot(N.z), q=[0.3], u=[1.0])) == pytest.approx(m * (g + PITCH * turn))
    assert float(eom.evaluate(found.torque.dot(N.z), q=[0.3], u=[1.0])) == pytest.approx(inertia * turn)


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_joint_transmits_does_no_work_on_its_free_motions(kind):
    carrier = kn.pin("carrier", O, N, axis=N.x, child="A")
    joint = KINDS[kind].make("J", carrier.point.at("P", 0.5 * carrier.frame.y), carrier.frame)
    bodies = [
        rigid(n, j.frame, j.point.at(f"{n}*", 0.1 * j.frame.x + 0.3 * j.frame.y), 1.5, kn.inertia(j.frame, 2, 3, 4))
        for n, j in (("a", carrier), ("b", joint))
    ]
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[carrier, joint], loads=[kn.gravity(-9.81 * N.z)]))
    q, u = np.linspace(0.2, 0.9, len(eom.coordinates)), np.linspace(-1, 1, len(eom.speeds))
    found = eom.reaction(joint)
    work = [found.force.dot(t.translation) + found.torque.dot(t.rotation) for t in joint.free]
    size = max(1.0, *(abs(float(x)) for x in eom.evaluate([*found.force.components(N)], q=q, u=u)))
    assert all(abs(float(x)) < 1e-11 * size for x in (eom.evaluate(work, q=q, u=u) if work else []))


@pytest.mark.parametrize("kind", MAKES)
def test_coordinates_and_speeds_stand_in_one_order(kind):
    """Turns and displacements follow each other in the speeds as in the coordinates."""
    joint = MAKES[kind]("J", O, N)
    turns = [s.unit == "m" for s in joint.coordinates], [s.unit == "m/s" for s in joint.speeds]
    q, u = (list(dict.fromkeys(t)) for t in turns)
    assert q == u
    assert [twist.rotation.is_zero for twist in joint.free] == turns[1]


class TestNames:
    def test_after_the_joint(self):
        joint = kn.free("left foot", O, N)
        assert " ".join(map(str, joint.coordinates)) == " ".join(
            f"{s}_left_foot" for s in ("e0", "e1", "e2", "e3", "x", "y", "z")
        )
        assert [str(u) for u in joint.speeds] == [f"{s}_left_foot" for s in ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")]
        assert (joint.frame.name, joint.point.name) == ("left foot", "left foot point")

    def test_as_given(self):
        q = kn.coordinate("q7", "rad")
        joint = kn.pin("hinge", O, N, axis=N.z, coordinates=q, speeds="u7", child="B")
        assert (joint.coordinates, list(map(str, joint.speeds)), joint.frame.name) == ((q,), ["u7"], "B")

    def test_speeds_defined_otherwise(self):
        q, u = kn.coordinate("q"), kn.speed("u")
        joint = kn.pin("hinge", O, N, axis=N.z, coordinates=q, speeds={u: 2 * q.dt})
        assert joint.speeds[u] is 2 * q.dt


class TestSystem:
    hinge = kn.pin("hinge A", O, N, axis=N.z, child="A")
    rail = kn.slider("rail", hinge.point.at("P", hinge.frame.x), hinge.frame, axis=hinge.frame.x)
    bodies = (
        rigid("a", hinge.frame, hinge.point, 1, kn.inertia(hinge.frame, 1, 1, 1)),
        kn.Particle("b", point=rail.point, mass=2),
    )

    def test_speeds_come_in_the_order_of_the_joints(self):
        system = kn.System(N, bodies=self.bodies, joints=[self.hinge, self.rail])
        assert list(map(str, system.speeds)) == ["u_hinge_A", "u_rail"]
        assert system["hinge A"] is self.hinge
        merged = kn.System(N, bodies=self.bodies, speeds={**self.hinge.speeds, **self.rail.speeds})
        assert list(system.speeds) == list(merged.speeds)

    def test_speeds_of_ones_own_take_their_place(self):
        u, (q,) = kn.speed("w"), self.hinge.coordinates
        system = kn.System(N, bodies=self.bodies, joints=[self.hinge, self.rail], speeds={u: 3 * q.dt})
        assert list(map(str, system.speeds)) == ["w", "u_rail"]
        assert list(map(str, system.replace(speeds="rates").speeds)) == ["u_q_hinge_A", "u_q_rail"]

    def test_faults(self):
        with pytest.raises(kn.ModelError, match="different names, got 'rail' more than once"):
            kn.System(N, bodies=self.bodies, joints=[self.rail, self.rail])
        with pytest.raises(kn.ModelError, match=r"joints= made by kn\.pin"):
            kn.System(N, bodies=self.bodies, joints=[self.bodies[0]])
        with pytest.raises(kn.ModelError, match=r"Expected speeds=.*got none"):
            kn.System(N, bodies=self.bodies)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.pin("", O, N, axis=N.z), "Expected a name for the joint"),
        (lambda: kn.pin("J", N, O, axis=N.z), "geometric point of the parent for the joint 'J'"),
        (lambda: kn.pin("J", O, O, axis=N.z), "Expected parent=frame"),
        (lambda: kn.pin("J", O, N, axis=2 * N.z), "Expected a unit vector as the axis of 'J'.*length 2"),
        (lambda: kn.pin("J", O, N, axis=N.rotate("B", kn.coordinate("q"), N.x).z), "fixed in N, got B.z, which turns"),
        (lambda: kn.pin("J", O, N, axis=N.z, coordinates=["a", "b"]), "Expected 1 coordinates.*named after the joint"),
        (lambda: kn.universal("J", O, N, axes=(N.z,)), "two perpendicular unit vectors for 'J'"),
        (lambda: kn.universal("J", O, N, axes=(N.z, N.z)), "perpendicular axes for the universal joint 'J'"),
        (lambda: kn.ball("J", O, N, orientation="quaternion"), "orientation= of 'J' to be one of euler parameters, angles"),
        (lambda: kn.free("J", O, N, velocity="N"), "velocity= of 'J' to be one of child, parent"),
        (lambda: kn.weld("J", O, N).axis, "a joint with an axis, got 'J', a weld joint"),
        (lambda: kn.close_screw("J", O, N, O.at("P", 0), N.rotate("B", 0, N.x), axis=N.z, pitch=0), "pitch that is not zero"),
        (lambda: kn.close_ball("J", O, N, O.at("P", 0), N), "two different frames.*got N twice"),
        (lambda: kn.planar("J", O, N, normal=N.z, speeds={kn.speed("u"): 1}), "Expected 3 definitions of speeds"),
    ],
)  # fmt: skip
def test_faults_are_named(make, message):
    with pytest.raises(kn.ModelError, match=message):
        make()


class TestUnits:
    @pytest.mark.parametrize(
        ("kind", "q", "u"),
        [
            ("pin", "rad", "rad/s"),
            ("slider", "m", "m/s"),
            ("screw", "rad", "rad/s"),
            ("cylindrical", "rad m", "rad/s m/s"),
            ("universal", "rad rad", "rad/s rad/s"),
            ("planar", "m m rad", "m/s m/s rad/s"),
            ("ball by Euler parameters", "1 1 1 1", "rad/s rad/s rad/s"),
            ("free by Euler parameters", "1 1 1 1 m m m", "rad/s rad/s rad/s m/s m/s m/s"),
            ("free", "rad rad rad m m m", "rad/s rad/s rad/s m/s m/s m/s"),
        ],
    )
    def test_by_name(self, kind, q, u):
        joint = MAKES[kind]("J", O, N)
        assert " ".join(s.unit for s in joint.coordinates) == q
        assert " ".join(s.unit for s in joint.speeds) == u
        assert joint.named == {*joint.coordinates, *joint.speeds}

    def test_speeds_follow_a_coordinate_of_ones_own(self):
        joints = [
            kn.slider("J", O, N, axis=N.x, coordinates=kn.coordinate("q", unit), speeds="u") for unit in ("mm", "")
        ]
        assert [s.unit for joint in joints for s in joint.speeds] == ["mm/s", ""]
        assert [[s.name for s in joint.named] for joint in joints] == [["u"], ["u"]]

    @staticmethod
    def block(*loads, **options):
        rail = kn.slider("rail", O, N, axis=N.x, **options)
        own = [load(rail.point) for load in loads]
        mass, g = kn.parameter("m", 2.0, "kg"), kn.parameter("g", 9.81, "m/s^2")
        return kn.System(
            N, bodies=[kn.Particle("p", rail.point, mass)], joints=[rail], loads=[kn.gravity(-g * N.x), *own]
        )

    def test_what_a_joint_chose_is_shown_and_refuses_no_numbers(self):
        """A spring of 30 and 0.2, of which nobody said the unit, leaves that of the energy open; so do not parameters with units."""
        bare = kn.derive(self.block(lambda p: kn.linear_spring(p, O, 30.0, 0.2)))
        assert [bare.unit(x) for x in (bare.coordinates[0], bare.speeds[0], bare.energy)] == ["m", "m/s", ""]
        k, l = kn.parameter("k", 30.0, "N/m"), kn.parameter("l", 0.2, "m")
        whole = kn.derive(self.block(lambda p: kn.linear_spring(p, O, k, l)))
        assert whole.unit(whole.energy) == "J"

    def test_units_that_others_carry_are_held_against_what_a_joint_chose(self):
        k, l = kn.parameter("k", 30.0, "N/m"), kn.parameter("l", 0.2, "m")
        for wrong in (
            lambda p: kn.linear_spring(p, O, l, k),
            lambda p: kn.Force(p, -l * p.velocity(N)),
            lambda p: kn.Force(p, -k * p.velocity(N)),
        ):
            with pytest.raises(kn.UnitError, match=r"\[m"):
                self.block(wrong)

    def test_numbers_beside_them_are_not(self):
        k = kn.parameter("k", 30.0, "N/m")
        for right in (
            lambda p: kn.linear_spring(p, O, k, 0.2),
            lambda p: kn.Force(p, -12.5 * p.velocity(N)),
            lambda p: kn.Force(p, -k * 0.037 * p.velocity(N)),
            lambda p: kn.Force(p.at("P", 0.5 * N.x), -k * p.at("P", 0.5 * N.x).position(O)),
        ):
            self.block(right)

    def test_what_is_declared_is_checked(self):
        with pytest.raises(kn.UnitError, match="Give the number a unit"):
            self.block(lambda p: kn.linear_spring(p, O, 30.0, 0.2), coordinates=kn.coordinate("q", "m"))

    def test_other_units_want_symbols(self):
        l = kn.parameter("l", 20.0, "mm")
        k = kn.parameter("k", 20.0, "kg/s^2")
        rail = kn.slider("rail", O, N, axis=N.x)
        bodies, loads = [kn.Particle("p", rail.point, 2)], [kn.linear_spring(rail.point, O, k, l)]
        with pytest.raises(kn.UnitError, match=r"give q_rail as a symbol in another unit\."):
            kn.System(N, bodies=bodies, joints=[rail], loads=loads)


@pytest.mark.parametrize("several", ["a b th", "a, b, th", ["a", "b", "th"], ["a b", "th"]])
def test_names_in_one_text(several):
    if several == ["a b", "th"]:
        with pytest.raises(kn.ModelError, match="Expected 3 coordinates, by name or symbol"):
            kn.planar("plate", O, N, normal=N.z, coordinates=several)
        return
    joint = kn.planar("plate", O, N, normal=N.z, coordinates=several, speeds="u1:4")
    assert [q.name for q in joint.coordinates] == ["a", "b", "th"]
    assert [u.name for u in joint.speeds] == ["u1", "u2", "u3"]
    assert {q.unit for q in joint.coordinates} == {"m", "rad"}


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.sampled_from(sorted(KINDS)), min_size=2, max_size=4), st.randoms(use_true_random=False), st.booleans()
)
def test_coordinates_and_speeds_are_in_one_order_that_of_the_joints(kinds, random, own):
    """Vectors filled joint by joint are right, whichever joints slide, turn or have Euler parameters."""
    at, frame, joints, bodies = O, N, [], []
    for k, kind in enumerate(kinds):
        joint = KINDS[kind].make(f"j{k}", at, frame)
        at, frame = joint.point.at(f"P{k}", 0.1 * joint.frame.x), joint.frame
        joints.append(joint)
        bodies.append(
            kn.RigidBody(f"b{k}", frame=frame, mass_center=at, mass=1, inertia=kn.solid_sphere(frame, 1, 0.1))
        )
    random.shuffle(joints)
    told = (
        {kn.speed(f"v{q}"): 2 * q.dt for q in joints[0].coordinates}
        if own and "e0" not in str(joints[0].coordinates)
        else {}
    )
    system = kn.System(N, bodies=bodies, joints=joints, speeds=told)
    assert list(system.coordinates) == [q for joint in joints for q in joint.coordinates]
    speeds = [told or joint.speeds if joint is joints[0] else joint.speeds for joint in joints]
    assert list(system.speeds) == [u for own_speeds in speeds for u in own_speeds]
