# SPDX-License-Identifier: BSD-3-Clause
"""Reactions brought into evidence, against Newton and Euler."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest

import kane as kn
from tests.oracles import newton_euler
from tests.oracles.compare import error, tolerance
from tests.oracles.kane_tree import vector
from tests.oracles.tree import random_states, random_tree

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
g = kn.parameter("g", 9.81)
G = 9.81


def array(values):
    return np.array([np.asarray(v, dtype=float) for v in values])


def along(eom, v, **state):
    return array(eom.evaluate(v.components(N), **state))


class TestPendulum:
    """A skew rigid body on a pin along N.z: force and torque of the pin against Newton's and Euler's laws by hand."""

    q = kn.coordinate("q")
    B = N.rotate("B", q, N.z)
    pin = O.at("pin", 0)
    center = pin.at("B*", 0.7 * B.x + 0.2 * B.y + 0.3 * B.z)
    inertia = np.array([[1.0, 0.1, 0.3], [0.1, 2.0, 0.2], [0.3, 0.2, 1.5]])
    body = kn.RigidBody("body", frame=B, mass_center=center, mass=2, inertia=kn.Dyadic.of(B, inertia))
    drag = kn.Torque(B, -0.4 * q.dt * B.z)
    state = MappingProxyType({"q": [0.6], "u": [1.3]})

    def derive(self, *reactions, **more):
        loads = [kn.gravity(-g * N.y), self.drag, kn.Force(self.center.at("tip", self.B.y), 3 * N.x)]
        return kn.derive(kn.System(N, bodies=[self.body], speeds="rates", loads=loads, reactions=reactions, **more))

    def by_hand(self, q_ddot):
        turn = newton_euler.rotation(np.array([0, 0, 1.0]), 0.6)
        w, alpha, arm = np.array([0, 0, 1.3]), np.array([0, 0, q_ddot]), turn @ [0.7, 0.2, 0.3]
        a = np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
        push = np.array([3.0, 0, 0])
        force = 2 * a + np.array([0, 2 * G, 0]) - push
        inertia = turn @ self.inertia @ turn.T
        moment = inertia @ alpha + np.cross(w, inertia @ w)  # about the mass centre
        moment -= np.cross(turn @ [0, 1, 0], push) + np.array([0, 0, -0.4 * 1.3])
        return force, moment - np.cross(-arm, force)

    def test_force_and_torque(self):
        forces = [kn.reaction(f"F{k}", at=self.pin, along=e) for k, e in enumerate((N.x, N.y, N.z))]
        torques = [kn.reaction(f"T{k}", frame=self.B, along=e) for k, e in enumerate((N.x, N.y))]
        eom = self.derive(*forces, *torques)
        q_ddot = float(eom.evaluate(self.q.dt.dt, **self.state))
        force, torque = self.by_hand(q_ddot)
        assert torque[2] == pytest.approx(0, abs=1e-12)  # the equation of motion itself
        assert array(eom.evaluate(forces, **self.state)) == pytest.approx(force)
        assert array(eom.evaluate(torques, **self.state)) == pytest.approx(torque[:2])
        assert array(eom.evaluate(list(eom.reaction_values), **self.state)) == pytest.approx([*force, *torque[:2]])

    def test_each_alone_gives_the_same(self):
        force, torque = self.by_hand(float(self.derive().evaluate(self.q.dt.dt, **self.state)))
        for axis, f, t in zip((N.x, N.y, N.z), force, torque, strict=True):
            one = kn.reaction("F", at=self.pin, along=axis)
            assert float(self.derive(one).evaluate(one, **self.state)) == pytest.approx(f)
            if axis is not N.z:
                one = kn.reaction("T", frame=self.B, along=axis)
                assert float(self.derive(one).evaluate(one, **self.state)) == pytest.approx(t)

    def test_torque_along_axes_that_turn_with_the_body(self):
        _, torque = self.by_hand(float(self.derive().evaluate(self.q.dt.dt, **self.state)))
        both = [kn.reaction("Tx", frame=self.B, along=self.B.x), kn.reaction("Ty", frame=self.B, along=self.B.y)]
        eom = self.derive(*both)
        turn = newton_euler.rotation(np.array([0, 0, 1.0]), 0.6)
        assert array(eom.evaluate(both, **self.state)) == pytest.approx((turn.T @ torque)[:2])

    def test_directions_that_are_not_orthogonal(self):
        """Σ R_k n_k is the force, whatever independent directions it is resolved along."""
        force, _ = self.by_hand(float(self.derive().evaluate(self.q.dt.dt, **self.state)))
        skew = [(N.x + N.y).normalized(), self.B.x, (2 * N.x - N.y + 2 * N.z) / 3]
        reactions = [kn.reaction(f"S{k}", at=self.pin, along=n) for k, n in enumerate(skew)]
        eom = self.derive(*reactions)
        total = sum((n * r for n, r in zip(skew, reactions, strict=True)), start=kn.Vector())
        assert along(eom, total, **self.state) == pytest.approx(force)
        assert 0 < float(eom.reaction_condition(**self.state)) < 1

    def test_two_skew_directions_give_the_part_in_their_plane(self):
        force, _ = self.by_hand(float(self.derive().evaluate(self.q.dt.dt, **self.state)))
        skew = [(N.x + N.y).normalized(), N.x]
        reactions = [kn.reaction(f"S{k}", at=self.pin, along=n) for k, n in enumerate(skew)]
        eom = self.derive(*reactions)
        total = sum((n * r for n, r in zip(skew, reactions, strict=True)), start=kn.Vector())
        assert along(eom, total, **self.state) == pytest.approx([*force[:2], 0])

    def test_they_do_not_change_the_motion(self):
        plain = self.derive()
        more = self.derive(kn.reaction("F", at=self.pin, along=N.x), kn.reaction("T", frame=self.B, along=N.y))
        assert plain.mass_matrix[0, 0] is more.mass_matrix[0, 0]
        assert plain.accelerations[0] is more.accelerations[0]

    def test_explicit_auxiliary_speeds_give_the_same(self):
        named = kn.reaction("F", at=self.pin, along=N.x)
        expected = float(self.derive(named).evaluate(named, **self.state))
        bare, speed = kn.reaction("F"), kn.auxiliary_speed("ua", at=self.pin, along=N.x)
        system = kn.System(
            N,
            bodies=[self.body],
            speeds="rates",
            loads=[
                kn.gravity(-g * N.y),
                self.drag,
                kn.Force(self.center.at("tip", self.B.y), 3 * N.x),
                kn.action_reaction(self.pin, O, bare * N.x),
            ],
            reactions=[bare],
            auxiliary_speeds=[speed],
        )
        eom = kn.derive(system)
        assert float(eom.evaluate(bare, **self.state)) == pytest.approx(expected)
        assert str(eom.partial_velocities[self.pin][speed]) == "N.x"

    def test_explicit_auxiliary_speed_on_a_frame(self):
        named = kn.reaction("T", frame=self.B, along=N.x)
        expected = float(self.derive(named).evaluate(named, **self.state))
        bare, speed = kn.reaction("T"), kn.auxiliary_speed("wa", frame=self.B, along=N.x)
        loads = [kn.gravity(-g * N.y), self.drag, kn.Force(self.center.at("tip", self.B.y), 3 * N.x)]
        loads.append(kn.torque_pair(self.B, N, bare * N.x))
        system = kn.System(
            N, bodies=[self.body], speeds="rates", loads=loads, reactions=[bare], auxiliary_speeds=[speed]
        )
        assert float(kn.derive(system).evaluate(bare, **self.state)) == pytest.approx(expected)

    def test_condition(self):
        assert float(self.derive().reaction_condition(**self.state)) == 1
        pair = [kn.reaction("Fx", at=self.pin, along=N.x), kn.reaction("Fy", at=self.pin, along=N.y)]
        assert float(self.derive(*pair).reaction_condition(**self.state)) == pytest.approx(1)
        close = [pair[0], kn.reaction("Fc", at=self.pin, along=(N.x + 1e-3 * N.y).normalized())]
        assert float(self.derive(*close).reaction_condition(**self.state)) == pytest.approx(
            2.5e-7, rel=1e-3
        )  # of the Gram matrix


@pytest.mark.slow
@pytest.mark.parametrize("bodies", [1, 2, 4])
def test_all_joint_reactions_of_random_trees(bodies):
    """Three force and three torque components at every joint, brought into evidence together."""
    rng = np.random.default_rng(700 + bodies)
    tree = random_tree(rng, bodies)
    states = random_states(rng, tree, 4)
    coordinates = kn.coordinates(f"q1:{tree.size + 1}")
    unused = iter(coordinates)
    frames, origins, joints, made, reactions = [], [], [], [], []
    loads = [kn.gravity(vector(N, tree.gravity))]
    for i, body in enumerate(tree.bodies):
        frame, origin = (N, O) if body.parent < 0 else (frames[body.parent], origins[body.parent])
        origin = joint = origin.at(f"J{i}", vector(frame, body.offset))
        frame = base = frame.rotate_matrix(f"J{i}", body.tilt)
        for k, step in enumerate(body.steps):
            axis, x = vector(frame, step.axis), next(unused)
            if step.kind == "slide":
                origin = origin.at(f"P{i}{k}", axis * x)
            else:
                frame = frame.rotate(f"B{i}{k}", x, axis)
        (xx, xy, zx), (_, yy, yz), (_, _, zz) = body.inertia
        center = origin.at(f"B{i}*", vector(frame, body.center))
        made.append(
            kn.RigidBody(f"B{i}", frame=frame, mass_center=center, mass=body.mass,
                         inertia=kn.inertia(frame, xx, yy, zz, xy, yz, zx))
        )  # fmt: skip
        if body.force is not None:
            loads.append(kn.Force(origin.at(f"F{i}", vector(frame, body.load_point)), vector(N, body.force)))
        if body.torque is not None:
            loads.append(kn.Torque(frame, vector(N, body.torque)))
        for n, axis in zip("xyz", (N.x, N.y, N.z), strict=True):
            reactions.append(kn.reaction(f"F{i}{n}", at=joint, along=axis))
        for n, axis in zip("xyz", (N.x, N.y, N.z), strict=True):
            reactions.append(kn.reaction(f"T{i}{n}", frame=base, along=axis))
        frames.append(frame)
        origins.append(origin)
        joints.append(joint)
    eom = kn.derive(kn.System(N, bodies=made, speeds="rates", loads=loads, reactions=reactions))
    plain = kn.derive(kn.System(N, bodies=made, speeds="rates", loads=loads))
    by_coordinate = dict(zip(eom.coordinates, eom.speeds, strict=True))
    for state in range(4):
        q, qdot = states[0][:, state], states[1][:, state]
        motion = newton_euler.solve(tree, q, qdot)
        numbers = {
            "q": dict(zip(coordinates, q, strict=True)),
            "u": {by_coordinate[x]: v for x, v in zip(coordinates, qdot, strict=True)},
        }
        found = array(eom.evaluate(reactions, **numbers)).reshape(bodies, 2, 3)
        limit = tolerance(1e-9, motion.condition)
        for i in range(bodies):
            arm = along(eom, origins[i].position(joints[i]), **numbers)
            torque = motion.torque[i] + np.cross(arm, motion.force[i])  # from the body's origin to the joint's start
            assert error(found[i, 0], motion.force[i]) <= limit
            assert error(found[i, 1], torque) <= limit
        ours, theirs = (array(e.evaluate(list(e.accelerations), **numbers)) for e in (eom, plain))
        assert ours == pytest.approx(theirs, rel=1e-11, abs=1e-11)


class TestIntermediateJoint:
    """A double pendulum of two rods in space of one plane: force between them by Newton's law of the second alone."""

    q = kn.coordinates("q1:3")
    A, B = N.rotate("A", q[0], N.z), N.rotate("B", q[1], N.z)
    elbow = O.at("A*", -0.5 * A.y).at("elbow", -0.5 * A.y)
    G2 = elbow.at("B*", -0.4 * B.y)
    state = MappingProxyType({"q": [0.5, -0.8], "u": [1.1, 2.0]})

    def bodies(self):
        return [
            kn.RigidBody(
                "a", frame=self.A, mass_center=self.elbow.parent, mass=1.5, inertia=kn.rod(self.A, 1.5, 1, self.A.y)
            ),
            kn.RigidBody("b", frame=self.B, mass_center=self.G2, mass=0.8, inertia=kn.rod(self.B, 0.8, 0.8, self.B.y)),
        ]

    def derive(self, speeds, *reactions):
        return kn.derive(
            kn.System(N, bodies=self.bodies(), speeds=speeds, loads=[kn.gravity(-g * N.y)], reactions=reactions)
        )

    @pytest.mark.parametrize("speeds", ["rates", "others"])
    def test_force_at_the_elbow(self, speeds):
        u = kn.speeds("u1:3")
        if speeds == "others":
            v = self.G2.velocity(N)
            speeds = {u[0]: v.dot(self.B.x), u[1]: self.q[0].dt - 2 * self.q[1].dt}
        forces = [kn.reaction("Fx", at=self.elbow, along=N.x), kn.reaction("Fy", at=self.elbow, along=N.y)]
        eom = self.derive(speeds, *forces)
        rates = {x.dt: v for x, v in zip(self.q, self.state["u"], strict=True)} | dict(
            zip(self.q, self.state["q"], strict=True)
        )
        values = [float(kn.evaluate(d, rates)) for d in eom.system.speeds.values()]
        state = {"q": dict(zip(self.q, self.state["q"], strict=True)), "u": values}
        second = array(eom.evaluate([x.dt.dt for x in self.q], **state))

        def acceleration(q, w, alpha, length):
            """Of the far end of a rod at `q` from the downward vertical."""
            s, c = np.sin(q), np.cos(q)
            return length * np.array([alpha * c - w * w * s, alpha * s + w * w * c])

        a = acceleration(0.5, 1.1, second[0], 1.0) + acceleration(-0.8, 2.0, second[1], 0.4)
        expected = 0.8 * (a + np.array([0, G]))
        assert array(eom.evaluate(forces, **state)) == pytest.approx(expected)

    def test_the_torque_there_is_zero(self):
        """B is born in N: its torque from N is that of no part, zero along the pin's axis."""
        torque = kn.reaction("T", frame=self.A, along=N.x)
        assert float(self.derive("rates", torque).evaluate(torque, q=[0.5, -0.8], u=[1.1, 2.0])) == pytest.approx(
            0, abs=1e-12
        )


class TestCoaxialRotations:
    """Two links in a plane whose angles add up: the elbow's bending torque at the second, third, … frame of the run."""

    q = kn.coordinates("q1:4")

    def make(self, *, split):
        """Three links along one axis, or one body after three rotations, with the mass off the plane."""
        A = N.rotate("A", self.q[0], N.z)
        B = A.rotate("B", self.q[1], A.z)
        C = B.rotate("C", self.q[2], B.z)
        at_a = O.at("A*", A.x + 0.3 * A.z)
        elbow = O.at("E", 2 * A.x)
        at_b = elbow.at("B*", B.x - 0.4 * B.z)
        at_c = elbow.at("W", 2 * B.x).at("C*", C.x + 0.2 * C.z)
        inertias = [(1.0, 2.0, 2.5, 0.1, 0.2, 0.3), (0.5, 1.0, 1.2, 0.0, -0.1, 0.2), (0.4, 0.6, 0.7, 0.1, 0.0, -0.2)]
        bodies = [
            kn.RigidBody(f.name, frame=f, mass_center=p, mass=m, inertia=kn.inertia(f, *i))
            for f, p, m, i in zip((A, B, C), (at_a, at_b, at_c), (2.0, 1.0, 0.7), inertias, strict=True)
        ]
        return (A, B, C), (at_a, at_b, at_c), elbow, bodies, inertias

    @pytest.mark.parametrize("cut", [1, 2])
    def test_bending_torque(self, cut):
        """Newton–Euler on what lies beyond the cut: Σ I α + ω × I ω + r × m (a − g) about the joint."""
        frames, points, elbow, bodies, inertias = self.make(split=True)
        place = frames[cut]
        joint = elbow if cut == 1 else elbow.at("W", 2 * frames[1].x)
        reactions = [kn.reaction("Tx", frame=place, along=N.x), kn.reaction("Ty", frame=place, along=N.y)]
        eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.z)], reactions=reactions))
        state = {"q": [0.3, -0.5, 0.9], "u": [1.0, -2.0, 0.6]}
        torque = np.zeros(3)
        for frame, point, body, i in zip(frames[cut:], points[cut:], bodies[cut:], inertias[cut:], strict=True):
            turn = eom.evaluate(N.dcm(frame), **state)
            xx, yy, zz, xy, yz, zx = i
            inertia = turn @ np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) @ turn.T
            w, alpha = (
                along(eom, eom.angular_velocities[frame], **state),
                along(eom, eom.angular_accelerations[frame], **state),
            )
            a = along(eom, eom.point_accelerations[point], **state)
            r = along(eom, point.position(joint), **state)
            mass = float(kn.evaluate(body.mass, {}))
            torque += inertia @ alpha + np.cross(w, inertia @ w) + np.cross(r, mass * (a + np.array([0, 0, G])))
        assert torque[2] == pytest.approx(0, abs=1e-10)
        assert array(eom.evaluate(reactions, **state)) == pytest.approx(torque[:2])

    def test_two_cuts_in_one_run(self):
        """Cuts on two frames of the run at once give what each gives alone."""
        frames, _, _, bodies, _ = self.make(split=True)
        one = kn.reaction("T1", frame=frames[1], along=frames[0].x)
        two = kn.reaction("T2", frame=frames[2], along=frames[1].y)
        state = {"q": [0.3, -0.5, 0.9], "u": [1.0, -2.0, 0.6]}

        def derive(*reactions):
            return kn.derive(
                kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.z)], reactions=reactions)
            )

        both = array(derive(one, two).evaluate([one, two], **state))
        assert both == pytest.approx([float(derive(r).evaluate(r, **state)) for r in (one, two)])
        assert np.abs(both).min() > 1e-3


class TestPrescribedMotion:
    def test_force_that_drives_a_pivot(self):
        """The reaction along a prescribed motion is the force of its actuator."""
        q = kn.coordinate("q")
        pivot = O.at("pivot", 0.2 * kn.sin(5 * kn.time) * N.y)
        A = N.rotate("A", q, N.z)
        bob = pivot.at("bob", -1.5 * A.y)
        force = kn.reaction("F", at=pivot, along=N.y)
        eom = kn.derive(
            kn.System(
                N, bodies=[kn.Particle("bob", bob, 2)], speeds="rates", loads=[kn.gravity(-g * N.y)], reactions=[force]
            )
        )
        state = {"q": [0.6], "u": [1.2], "t": 0.3}
        angle = float(eom.evaluate(q.dt.dt, **state))
        a = -0.2 * 25 * np.sin(1.5) + 1.5 * (angle * np.sin(0.6) + 1.2**2 * np.cos(0.6))
        assert float(eom.evaluate(force, **state)) == pytest.approx(2 * (a + G))

    def test_without_any_freedom(self):
        """All motion prescribed: no speeds at all, and still the driving force m (g + ÿ)."""
        table = O.at("table", kn.sin(3 * kn.time) * N.y)
        force = kn.reaction("F", at=table, along=N.y)
        eom = kn.derive(
            kn.System(
                N, bodies=[kn.Particle("p", table, 2)], speeds={}, loads=[kn.gravity(-g * N.y)], reactions=[force]
            )
        )
        assert eom.speeds == ()
        assert float(eom.evaluate(force, t=0.4)) == pytest.approx(2 * (G - 9 * np.sin(1.2)))


class TestFriction:
    """Sliding friction μN: the reaction enters the equations of motion and is solved for with them."""

    mu = kn.parameter("mu", 0.3)
    x = kn.coordinate("x")

    @pytest.mark.parametrize("direction", [1, -1])
    def test_block_on_an_incline(self, direction):
        """ẍ = g (sin β ∓ μ cos β), N = m g cos β."""
        beta = 0.5
        slope = N.rotate("S", kn.parameter("beta", beta), N.z)
        block = O.at("block", self.x * slope.x)
        normal = kn.reaction("N", at=block, along=slope.y)
        v = block.velocity(N)
        eom = kn.derive(
            kn.System(
                N,
                bodies=[kn.Particle("block", block, kn.parameter("m", 4.0))],
                speeds="rates",
                loads=[kn.gravity(-g * N.y), kn.Force(block, -self.mu * normal * v.normalized())],
                reactions=[normal],
            )
        )
        state = {"q": [0.0], "u": [2.0 * direction]}
        assert float(eom.evaluate(normal, **state)) == pytest.approx(4 * G * np.cos(beta))
        expected = -G * np.sin(beta) - direction * 0.3 * G * np.cos(beta)
        assert float(eom.evaluate(eom.accelerations[0], **state)) == pytest.approx(expected)

    def test_it_does_change_the_motion_but_not_by_being_listed(self):
        beta = 0.5
        slope = N.rotate("S", beta, N.z)
        block = O.at("block", self.x * slope.x)
        normal = kn.reaction("N", at=block, along=slope.y)
        other = kn.reaction("side", at=block, along=slope.z)
        v = block.velocity(N)
        loads = [kn.gravity(-g * N.y), kn.Force(block, -self.mu * normal * v.normalized())]
        one, two = (
            kn.derive(kn.System(N, bodies=[kn.Particle("b", block, 4)], speeds="rates", loads=loads, reactions=r))
            for r in ([normal], [normal, other])
        )
        state = {"q": [0.0], "u": [2.0]}
        assert float(two.evaluate(two.accelerations[0], **state)) == pytest.approx(
            float(one.evaluate(one.accelerations[0], **state))
        )
        assert float(two.evaluate(other, **state)) == pytest.approx(0, abs=1e-12)

    def test_two_reactions_coupled_through_friction(self):
        """A ladder that slides at floor and wall: both normal forces press both friction forces, a 2 × 2 block.

        Newton and Euler in NumPy: unknown θ̈, N of the floor, W of the wall.
        """
        th = kn.coordinate("th")
        length, m = 2.0, 5.0
        A = N.rotate("A", th, N.z)  # A.x from the floor's contact to the wall's
        middle = O.at("x", -length / 2 * kn.cos(th) * N.x).at("G", length / 2 * kn.sin(th) * N.y)
        rod = kn.RigidBody("ladder", frame=A, mass_center=middle, mass=m, inertia=kn.rod(A, m, length, A.x))
        low, high = middle.fixed_in(A, "low", -length / 2 * A.x), middle.fixed_in(A, "high", length / 2 * A.x)
        # both normal forces act on the rod: auxiliary motions up and away from the wall of the whole rod
        floor, wall = kn.reaction("floor"), kn.reaction("wall")
        shift = middle.parent
        up = kn.auxiliary_speed("up", at=shift, along=N.y)
        away = kn.auxiliary_speed("away", at=shift, along=-N.x)
        slide_low, slide_high = low.velocity(N).dot(N.x), high.velocity(N).dot(N.y)
        loads = [
            kn.gravity(-g * N.y),
            kn.Force(low, floor * N.y - self.mu * floor * kn.sign(slide_low) * N.x),
            kn.Force(high, -wall * N.x - self.mu * wall * kn.sign(slide_high) * N.y),
        ]
        with pytest.raises(kn.ReactionError, match="moves freely"):
            kn.derive(
                kn.System(
                    N, bodies=[rod], speeds="rates", loads=loads, reactions=[floor, wall], auxiliary_speeds=[up, away]
                )
            )
        start = O.at("free of both", 0)
        up = kn.auxiliary_speed("up", at=start, along=N.y)
        away = kn.auxiliary_speed("away", at=start, along=-N.x)
        middle = start.at("x", -length / 2 * kn.cos(th) * N.x).at("G", length / 2 * kn.sin(th) * N.y)
        rod = kn.RigidBody("ladder", frame=A, mass_center=middle, mass=m, inertia=kn.rod(A, m, length, A.x))
        low, high = middle.fixed_in(A, "low", -length / 2 * A.x), middle.fixed_in(A, "high", length / 2 * A.x)
        slide_low, slide_high = low.velocity(N).dot(N.x), high.velocity(N).dot(N.y)
        loads = [
            kn.gravity(-g * N.y),
            kn.Force(low, floor * N.y - self.mu * floor * kn.sign(slide_low) * N.x),
            kn.Force(high, -wall * N.x - self.mu * wall * kn.sign(slide_high) * N.y),
        ]
        eom = kn.derive(
            kn.System(
                N, bodies=[rod], speeds="rates", loads=loads, reactions=[floor, wall], auxiliary_speeds=[up, away]
            )
        )
        angle, w = 1.1, -0.4  # it slips down: low end away from the wall (−x), high end down
        s, c, h = np.sin(angle), np.cos(angle), length / 2
        # G = (−h cos θ, h sin θ); a_x = h (s θ̈ + c θ̇²), a_y = h (c θ̈ − s θ̇²); friction +x at floor, +y at wall
        mu = 0.3
        lhs = np.array(
            [
                [m * h * s, -mu, 1.0],
                [m * h * c, -1.0, -mu],
                [m * length**2 / 12, h * c - mu * h * s, -(h * s + mu * h * c)],
            ]
        )
        rhs = np.array([-m * h * c * w * w, m * h * s * w * w - m * G, 0.0])
        expected = np.linalg.solve(lhs, rhs)
        found = array(eom.evaluate([th.dt.dt, floor, wall], q=[angle], u=[w]))
        assert eom.solved.reaction_matrix.shape == (2, 2)
        assert found == pytest.approx(expected)
        assert found[1] > 0
        assert found[2] > 0

    def test_painleve(self):
        """A rod that slides on its lower end: the factor of N changes sign with μ, here against the closed form.

        With θ the angle of the rod from the horizontal, N's factor over its frictionless value is
        (1 + 3 cos²θ + 3 μ s sin θ cos θ)/(1 + 3 cos²θ), s the sign of the slip.
        """
        th = kn.coordinate("th")
        A = N.rotate("A", th, N.z)
        contact = O.at("P", self.x * N.x)
        rod = kn.RigidBody("rod", frame=A, mass_center=contact.at("G", A.x), mass=1, inertia=kn.rod(A, 1, 2, A.x))
        normal = kn.reaction("R", at=contact, along=N.y)
        v = contact.velocity(N)
        eom = kn.derive(
            kn.System(
                N,
                bodies=[rod],
                speeds="rates",
                reactions=[normal],
                loads=[kn.gravity(-g * N.y), kn.Force(contact.fixed_in(A, "C"), -self.mu * normal * v.normalized())],
            )
        )
        (watched,) = [e for e in eom.events if e.name.startswith("Painlev")]
        for mu in (0.5, 4 / 3, 2.0):
            for s in (1, -1):
                state = {"q": {th: 1.1, self.x: 0}, "u": {"u_x": s, "u_th": 0}, "parameters": {"mu": mu}}
                sin, cos = np.sin(1.1), np.cos(1.1)
                expected = 1 - mu * -s * 3 * sin * cos / (1 + 3 * cos**2)
                assert float(eom.evaluate(watched.quantity, **state)) == pytest.approx(expected, abs=1e-12)
                force = G / (1 + 3 * cos**2 + 3 * mu * s * sin * cos)  # m g/4 · 4/(…) at rest
                assert float(eom.evaluate(normal, **state)) == pytest.approx(force)
        with pytest.raises(kn.SimulationError, match="Painlevé"):
            kn.simulate(eom, (0, 1), q={th: 1.1, self.x: 0}, u={"u_x": -1, "u_th": 0}, parameters={"mu": 2.0})
        sol = kn.simulate(eom, (0, 1), q={th: 0.5, self.x: 0}, u={"u_x": -9, "u_th": 2}, parameters={"mu": 1.8})
        assert sol.status == "event"
        assert "Painlevé" in sol.event.name

    def test_it_does_not_depend_on_which_speeds_are_dependent(self):
        """A block slides under the force that a connecting rod presses it down with; its motion is read in either speed's terms.
        Without friction the factor of R is 1.
        """
        q1, q2, s = kn.coordinates("q1 q2 s")
        u1, u2, u3 = kn.speeds("u1:4")
        a, b, mu, smooth = 0.15, 0.4, kn.parameter("mu", 0.3), 0.05
        A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
        P, S = O.at("P", a * A.x), O.at("S", s * N.x)
        crank = kn.RigidBody(
            "crank", frame=A, mass_center=O.at("Ac", a * A.x / 2), mass=0.5, inertia=kn.rod(A, 0.5, a, A.x)
        )
        rod = kn.RigidBody(
            "rod", frame=B, mass_center=P.at("Bc", b * B.x / 2), mass=0.12, inertia=kn.rod(B, 0.12, b, B.x)
        )
        tip, block = P.at("T", b * B.x), kn.Particle("block", S, 0.7)
        found = []
        for definitions in (
            {u1: q1.dt, u2: q2.dt, u3: s.dt},
            {u1: q1.dt + 0.2 * q2.dt, u2: q2.dt, u3: s.dt + 0.1 * q1.dt},
        ):
            for dependent in ((u2, u3), (u1, u2), (u1, u3)):
                R = kn.reaction("R", at=S, along=N.y)
                eom = kn.derive(
                    kn.System(
                        N, bodies=[crank, rod, block], speeds=definitions, reactions=[R], dependent_speeds=dependent,
                        holonomic=kn.coincident(tip, S, along=(N.x, N.y)),
                        loads=[kn.gravity(-G * N.y), kn.friction(S, R, mu, along=N.y, smooth=smooth)],
                    )
                )  # fmt: skip
                (watched,) = [e for e in eom.events if e.name.startswith("Painlev")]
                for q in (0.7, 1.2, 1.5, 2.5):
                    at = kn.assemble(eom, q={q1: q, q2: kn.guess(-0.3), s: kn.guess(0.4)}, rates={q1: 8.0})
                    values = [
                        eom.evaluate(watched.quantity, q=at.q, u=at.u, parameters={mu: x}) for x in (0.0, 0.3, 0.9)
                    ]
                    found.append([*map(float, values), float(eom.evaluate(R, q=at.q, u=at.u))])
        cases = np.array(found).reshape(6, 4, 4)
        np.testing.assert_allclose(cases[:, :, 0], 1.0, rtol=1e-12)
        np.testing.assert_allclose(cases, np.broadcast_to(cases[0], cases.shape), rtol=1e-9)
        assert (cases[0, :, 1:3] > 0.01).all()  # the rod never wedges


class TestErrors:
    q, x = kn.coordinates("q x")
    A = N.rotate("A", q, N.z)
    pin = O.at("pin", 0)
    bob = kn.Particle("bob", pin.at("bob", -1 * A.y), 2)

    def derive(self, reactions, loads=(), bodies=None):
        return kn.derive(kn.System(N, bodies=bodies or [self.bob], speeds="rates", loads=loads, reactions=reactions))

    @pytest.mark.parametrize("power", [lambda r: r * r, lambda r: abs(r), lambda r: r**3 + r, lambda r: 1 / r, kn.sin])
    def test_a_reaction_that_enters_nonlinearly(self, power):
        R = kn.reaction("R", at=self.pin, along=N.y)
        with pytest.raises(kn.ReactionError, match="linear in the reactions"):
            self.derive([R], [kn.Force(self.bob.point, power(R) * N.x)])

    def test_two_reactions_multiplied(self):
        R, S = kn.reaction("R", at=self.pin, along=N.y), kn.reaction("S", at=self.pin, along=N.x)
        with pytest.raises(kn.ReactionError, match="linear in the reactions"):
            self.derive([R, S], [kn.Force(self.bob.point, R * S * N.x)])

    def test_along_a_free_direction(self):
        slider = O.at("slider", self.x * N.x)
        p = kn.Particle("p", slider, 1)
        for along in (N.x, (N.x + N.y).normalized()):
            with pytest.raises(kn.ReactionError, match=r"moves freely with .*u_x"):
                self.derive([kn.reaction("R", at=slider, along=along)], bodies=[p])

    @pytest.mark.parametrize("size", [1e-15, 1.0, 1e15])
    def test_along_a_free_direction_however_far_it_leads(self, size):
        slider = O.at("slider", kn.parameter("size", size) * self.x * N.x)
        with pytest.raises(kn.ReactionError, match=r"moves freely with .*u_x"):
            self.derive([kn.reaction("R", at=slider, along=N.x)], bodies=[kn.Particle("p", slider, 1)])

    def test_torque_along_a_free_axis(self):
        with pytest.raises(kn.ReactionError, match="moves freely with u_q"):
            self.derive([kn.reaction("T", frame=self.A, along=N.z)])

    def test_torque_along_a_free_axis_in_a_coaxial_run(self):
        B = self.A.rotate("B", self.x, self.A.z)
        p = kn.Particle("p", self.bob.point.at("p", B.x), 1)
        with pytest.raises(kn.ReactionError, match="moves freely with u_x"):
            self.derive([kn.reaction("T", frame=B, along=N.z)], bodies=[self.bob, p])

    def test_directions_that_depend_on_each_other(self):
        axes = (N.x, N.y, self.A.x)
        with pytest.raises(kn.ReactionError, match="independent reactions, got R0, R1, R2"):
            self.derive([kn.reaction(f"R{k}", at=self.pin, along=n) for k, n in enumerate(axes)])
        with pytest.raises(kn.ReactionError, match="independent reactions"):
            self.derive([kn.reaction(f"R{k}", at=self.pin, along=n) for k, n in enumerate((N.x, -N.x))])

    def test_not_listed(self):
        R = kn.reaction("R", at=self.pin, along=N.y)
        with pytest.raises(kn.ReactionError, match=r"System\(reactions=\[…\]\)"):
            self.derive([], [kn.Force(self.bob.point, R * N.x)])


def test_order_of_declaration_and_reading_does_not_matter():
    """A reaction declared, even derived with, before or after a velocity is read gives the same equations."""

    def disk(early):
        q = kn.coordinates("q1:6")
        B = N.rotate("Y", q[0], N.z)
        B = B.rotate("B", kn.pi / 2 - q[1], B.x)
        C = B.rotate("C", q[2], B.z)
        P = O.at("P", q[3] * N.x + q[4] * N.y)
        Cs = P.at("C*", 0.3 * B.y)
        Ch = Cs.fixed_in(C, "C^", -0.3 * B.y)
        body = kn.RigidBody("disk", frame=C, mass_center=Cs, mass=1.2, inertia=kn.thin_disk(C, 1.2, 0.3, C.z))
        if early:
            normal = kn.reaction("N_z", at=P, along=N.z)
            kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-g * N.z)], reactions=[normal]))
            slip = Ch.velocity(N).reject(N.z)
        else:
            slip = Ch.velocity(N).reject(N.z)
            normal = kn.reaction("N_z", at=P, along=N.z)
        loads = [kn.gravity(-g * N.z), kn.Force(Ch, -0.2 * normal * slip.normalized())]
        return kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=loads, reactions=[normal]))

    first, second = disk(True), disk(False)
    assert [str(e) for e in first.accelerations] == [str(e) for e in second.accelerations]
    assert all(a is b for a, b in zip(first.accelerations, second.accelerations, strict=True))
    assert str(first.reaction_values[0]) == str(second.reaction_values[0])
