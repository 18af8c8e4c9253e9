# SPDX-License-Identifier: BSD-3-Clause
"""Reactions asked for after the derivation: against auxiliary speeds, against the oracle of loops, and by hand."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.oracles.compare import error
from tests.oracles.loops import joints as held
from tests.oracles.loops.equations import solve
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, Twist

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G = 9.81
LENGTHS = {"a": 0.4, "b": 1.0, "c": 0.8}
FAR = 1.1


def numbers(eom, v, frame=N, **state):
    return np.array([float(x) for x in eom.evaluate(v.components(frame), **state)])


def rod(name, frame, start, length, mass=1.0):
    center = start.at(f"{name}*", length / 2 * frame.x)
    return kn.RigidBody(
        name, frame=frame, mass_center=center, mass=mass, inertia=kn.rod(frame, mass, length, axis=frame.x)
    )


class FourBar:
    """Crank, coupler and rocker in absolute angles about z, closed at G; the pin on the ground can be cut at O1."""

    q = kn.coordinates("q1:4")
    frames = tuple(N.rotate(n.upper(), x, N.z) for n, x in zip(LENGTHS, q, strict=True))
    O1 = O.at("O1", 0)
    P1 = O1.at("P1", LENGTHS["a"] * frames[0].x)
    P2 = P1.at("P2", LENGTHS["b"] * frames[1].x)
    P3 = P2.at("P3", LENGTHS["c"] * frames[2].x)
    ground = O.at("G", FAR * N.x)
    bodies = tuple(rod(n, f, p, LENGTHS[n]) for n, f, p in zip(LENGTHS, frames, (O1, P1, P2), strict=True))

    @classmethod
    def derive(cls, *reactions, **more):
        loads = [kn.gravity(-G * N.y), kn.Torque(cls.frames[0], 2 * N.z)]
        constraints = {"holonomic": kn.coincident(cls.P3, cls.ground, (N.x, N.y), name="pin G")} | more
        return kn.derive(
            kn.System(N, bodies=cls.bodies, speeds="rates", loads=loads, reactions=reactions, **constraints)
        )

    @classmethod
    def state(cls, eom):
        found = kn.assemble(eom, q={"q1": 1.2, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)}, u={"u1": 5.0})
        return {"q": found.q, "u": found.u}


def oracle(eom, state):
    """The same four-bar in maximal coordinates: the force on each rod at its first pin, then on the rocker at G."""
    poses, twists = [], []
    for body in FourBar.bodies:
        turn = np.array(eom.evaluate(N.dcm(body.frame), **state), dtype=float)
        poses.append(Pose(numbers(eom, body.mass_center.position(O), **state), turn))
        v, w = eom.velocities[body.mass_center], eom.angular_velocities[body.frame]
        twists.append(Twist(numbers(eom, v, **state), numbers(eom, w, **state)))
    matter = [Body(1.0, np.diag([1e-3, x**2 / 12, x**2 / 12])) for x in LENGTHS.values()]
    half = [np.array([x / 2, 0, 0]) for x in LENGTHS.values()]
    pins = [
        held.Joint((GROUND, 0), (Mark(), Mark(-half[0])), held.pin),
        held.Joint((0, 1), (Mark(half[0]), Mark(-half[1])), held.pin),
        held.Joint((1, 2), (Mark(half[1]), Mark(-half[2])), held.pin),
        held.Joint((GROUND, 2), (Mark(np.array([FAR, 0, 0])), Mark(half[2])), held.pin),
    ]
    torques = np.array([[0, 0, 2.0], [0, 0, 0], [0, 0, 0]])
    return solve(matter, pins, poses, twists, torques=torques, gravity=np.array([0, -G, 0]))


class TestFourBar:
    def test_every_pin_carries_what_the_oracle_of_loops_says(self):
        eom = FourBar.derive()
        state = FourBar.state(eom)
        expected = [r.force for r in oracle(eom, state).reactions]
        for place, force in zip((FourBar.O1, "P1", "P2", "pin G"), expected, strict=True):
            assert error(numbers(eom, eom.reaction(place).force, **state), force) < 1e-10

    def test_both_ground_pins_carry_the_weight_and_what_accelerates_the_mass_centre(self):
        eom = FourBar.derive()
        state = FourBar.state(eom)
        total = numbers(eom, eom.reaction("O1").force + eom.reaction("pin G").force, **state)
        a = sum(numbers(eom, eom.point_accelerations[b.mass_center], **state) for b in FourBar.bodies)
        np.testing.assert_allclose(total, a + np.array([0, 3 * G, 0]), atol=1e-11)

    def test_auxiliary_speeds_yield_the_same(self):
        close = kn.coincident(FourBar.P3, FourBar.ground, (N.x, N.y), name="pin G")
        listed = [kn.reaction(f"O{k}", at=FourBar.O1, along=n) for k, n in (("x", N.x), ("y", N.y))]
        listed += [kn.reaction("G_x", constraint=close[0]), kn.reaction("T", frame=FourBar.frames[1], along=N.x)]
        eom = FourBar.derive(*listed, holonomic=close)
        state = FourBar.state(eom)
        o, g, t = eom.reaction("O1"), eom.reaction(close), eom.reaction(FourBar.frames[1])
        found = eom.evaluate([o.force.dot(N.x), o.force.dot(N.y), g.force.dot(N.x), t.torque.dot(N.x)], **state)
        assert error(found, eom.evaluate(listed, **state)) < 1e-11
        assert t.force is None
        assert t.point is None

    def test_one_constraint_alone(self):
        eom = FourBar.derive()
        state = FourBar.state(eom)
        (x, y), whole = eom.system.constraints, eom.reaction("pin G")
        for c, n in ((x, N.x), (y, N.y)):
            one = eom.reaction(c)
            assert one.name == c.name
            assert error(numbers(eom, one.force, **state), numbers(eom, whole.force.project(n), **state)) < 1e-12
        assert whole.name == "pin G"
        assert whole.point is FourBar.P3

    @pytest.mark.parametrize(
        ("names", "whole"),
        [
            (("pin G x", "pin G y"), "pin G"),
            (("wheel on the road", "wheel 1"), "wheel"),
            (("wheel on the road", "wheel"), "wheel"),
            (("left", "right"), "left, right"),
            (("foot on the left rail", "foot of the right leg"), "foot on the left rail, foot of the right leg"),
        ],
    )
    def test_several_are_named_by_what_is_common(self, names, whole):
        pair = [
            kn.coincident(FourBar.P3, FourBar.ground, n, name=name)[0]
            for n, name in zip((N.x, N.y), names, strict=True)
        ]
        assert FourBar.derive(holonomic=pair).reaction(pair).name == whole

    @pytest.mark.slow
    def test_along_a_motion_and_in_any_frame(self):
        """The samples are those of the reaction listed, in segments that were stepped with other dependent speeds too."""
        listed = [kn.reaction(f"O{k}", at=FourBar.O1, along=n) for k, n in (("x", N.x), ("y", N.y))]
        eom = FourBar.derive(*listed)
        state = FourBar.state(eom)
        sol = kn.simulate(eom, (0, 1.5), q=state["q"], u=state["u"], rtol=1e-9, atol=1e-9)
        force, torque = sol.reaction("O1")
        assert force.shape == torque.shape == (len(sol), 3)
        np.testing.assert_allclose(force[:, :2].T, [sol[r] for r in listed], rtol=1e-9, atol=1e-8)
        turned, _ = sol.reaction("O1", frame=FourBar.frames[0])
        c, s = np.cos(sol["q1"]), np.sin(sol["q1"])
        np.testing.assert_allclose(turned[:, 0], c * force[:, 0] + s * force[:, 1], atol=1e-9)
        none, _ = sol.reaction(FourBar.frames[0])
        assert none is None


def pendulum():
    hinge = kn.pin("hinge", O, N, axis=N.z, child="B")
    body = rod("rod", hinge.frame, hinge.point, 1.2, 2.0)
    return hinge, body, kn.derive(kn.System(N, bodies=[body], joints=[hinge], loads=[kn.gravity(-G * N.y)]))


class TestPendulum:
    """A hanging rod: the pin carries m (g cos θ + ω² l/2) along it, and θ from the downward vertical."""

    def test_by_hand(self):
        hinge, _, eom = pendulum()
        theta, w, m, half = 0.7, 1.3, 2.0, 0.6
        state = {"q": [theta - np.pi / 2], "u": [w]}
        alpha = -m * G * half * np.sin(theta) / (m * (2 * half) ** 2 / 3)
        force = numbers(eom, eom.reaction("hinge").force, hinge.frame, **state)
        expected = [-m * (G * np.cos(theta) + half * w**2), m * (G * np.sin(theta) + half * alpha), 0]
        np.testing.assert_allclose(force, expected, atol=1e-12)
        np.testing.assert_allclose(numbers(eom, eom.reaction("hinge").torque, **state), 0, atol=1e-12)

    def test_by_joint_name_point_or_record(self):
        hinge, _, eom = pendulum()
        values = [
            [*numbers(eom, r.force, q=[0.4], u=[2.0]), *numbers(eom, r.torque, q=[0.4], u=[2.0])]
            for r in map(eom.reaction, ("hinge", hinge, hinge.point, "hinge point"))
        ]
        assert np.ptp(values, axis=0).max() < 1e-13

    def test_vectors_are_solved_and_along_the_frame_asked_for(self):
        hinge, _, eom = pendulum()
        found = eom.reaction("hinge", frame=hinge.frame)
        assert [f for f, _ in found.force.parts] == [hinge.frame]
        known = {*eom.coordinates, *eom.speeds, *eom.parameters}
        assert set(kn.free_symbols(found.force.scalars())) <= known
        assert repr(found) == "JointReaction('hinge', about hinge point)"


def test_friction_of_a_reaction_that_is_listed_is_felt():
    """A block on a rail pressed by a spring: Coulomb friction μ R drives it; the rail's force is that of R and friction together."""
    mu = 0.2
    block = kn.slider("rail", O, N, axis=N.x, child="B")
    normal = kn.reaction("R", at=block.point, along=N.y)
    body = kn.Particle("block", block.point, 3)
    loads = [kn.gravity(-G * N.y), kn.Force(block.point, -mu * normal * N.x, name="friction")]
    eom = kn.derive(kn.System(N, bodies=[body], joints=[block], loads=loads, reactions=[normal]))
    state = {"q": [0.0], "u": [1.0]}
    assert float(eom.evaluate(eom.accelerations[0], **state)) == pytest.approx(-mu * G)
    np.testing.assert_allclose(numbers(eom, eom.reaction("rail").force, **state), [0, 3 * G, 0], atol=1e-13)


def test_what_drives_a_prescribed_motion():
    """A rod turned as 0.3 t²: its drive gives I α, and the bearing holds it against its weight."""
    B = N.rotate("B", 0.3 * kn.time**2, N.z)
    hub = O.at("hub", 0)
    tip = hub.at("tip", kn.coordinate("s") * B.x)
    wheel = kn.RigidBody("wheel", frame=B, mass_center=hub, mass=2, inertia=kn.inertia(B, 1, 1, 0.5))
    eom = kn.derive(kn.System(N, bodies=[wheel, kn.Particle("bead", tip, 1)], speeds="rates"))
    found = eom.reaction(hub)
    state = {"q": [0.8], "u": [0.5], "t": 2.0}
    w, alpha, s, v = 1.2, 0.6, 0.8, 0.5
    assert numbers(eom, found.torque, **state)[2] == pytest.approx((0.5 + s**2) * alpha + 2 * s * v * w)
    assert numbers(eom, found.force, B, **state) == pytest.approx([0, alpha * s + 2 * w * v, 0])


class TestFrame:
    """The torque that turns a frame, with all that turns with it: bodies off the axis, loads and closures included."""

    def test_a_pin_transmits_none_about_its_axis(self):
        hinge, _, eom = pendulum()
        state = {"q": [0.4], "u": [1.0]}
        np.testing.assert_allclose(numbers(eom, eom.reaction(hinge.frame).torque, **state), 0, atol=1e-13)

    def test_an_arm_on_a_turntable_by_angular_momentum(self):
        """Ḣ_z = d/dt [(m ρ² + I₁ s² + I₃ c²) ẇ] of an arm that tilts by θ on a table turned by w(t), ρ = h + l cos θ."""
        tilt, w = kn.coordinate("tilt"), kn.input("w")
        table = N.rotate("table", w, N.z)
        arm = table.rotate("arm", tilt, table.y)
        center = O.at("edge", 0.1 * table.x).at("center", 0.4 * arm.x)
        body = kn.RigidBody("b", frame=arm, mass_center=center, mass=1.5, inertia=kn.inertia(arm, 0.1, 0.2, 0.25))
        listed = [kn.reaction(f"T{k}", frame=table, along=n) for k, n in enumerate((N.x, N.y, N.z))]
        drag = kn.Force(center, -0.7 * center.velocity(N))
        loads = [kn.gravity(-G * N.z), drag, kn.Torque(arm, -0.3 * listed[2] * arm.y)]
        eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=loads, reactions=listed))
        q, u, rate, acceleration = 0.5, 0.9, 1.3, -0.4
        state = {"q": [q], "u": [u], "inputs": {w: 0.2, w.dt: rate, w.dt.dt: acceleration}}
        s, c = np.sin(q), np.cos(q)
        rho, slope = 0.1 + 0.4 * c, -0.4 * s * u
        inertia = 1.5 * rho**2 + 0.1 * s**2 + 0.25 * c**2
        change = 3 * rho * slope + 2 * (0.1 - 0.25) * s * c * u
        by_hand = inertia * acceleration + change * rate + 0.7 * rho**2 * rate
        found = numbers(eom, eom.reaction(table).torque, **state)
        assert found[2] == pytest.approx(by_hand, abs=1e-12)
        np.testing.assert_allclose(found, eom.evaluate(listed, **state), atol=1e-12)

    def test_in_a_closed_loop(self):
        """A frame between the ground and the crank: the torque of a reaction listed there."""
        base = N.rotate("base", 0.3, N.z)
        q = kn.coordinates("q1:4")
        crank, *others = (n.rotate(f"f{k}", x, N.z) for k, (n, x) in enumerate(zip((base, N, N), q, strict=True)))
        point, bodies = O.at("hub", 0), []
        for frame, length in zip((crank, *others), LENGTHS.values(), strict=True):
            bodies.append(rod(frame.name, frame, point, length))
            point = point.at(f"end {frame.name}", length * frame.x)
        closed = kn.coincident(point, O.at("anchor", FAR * N.x), (N.x, N.y), name="pin")
        hold = kn.reaction("T", frame=base, along=base.x)
        loads = [kn.gravity(-G * N.y), kn.Torque(crank, 2 * N.z)]
        eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, holonomic=closed, reactions=[hold]))
        found = kn.assemble(eom, q={q[0]: 0.9, q[1]: kn.guess(-0.2), q[2]: kn.guess(-1.5)}, u={"u1": 5.0})
        state = {"q": found.q, "u": found.u}
        torque = numbers(eom, eom.reaction(base).torque, base, **state)
        np.testing.assert_allclose(torque[0], eom.evaluate(hold, **state), atol=1e-12)
        np.testing.assert_allclose(torque, 0, atol=1e-12)


class TestOneClosure:
    """What is asked for together acts on one point."""

    def test_two_rods_of_one_stem_are_told_apart(self):
        x, y, z, w = kn.coordinates("x y z w")
        p, q = O.at("p", x * N.x + y * N.y), O.at("q", z * N.x + w * N.y)
        rods = [kn.distance(p, O, 1.0, name="rod 1"), kn.distance(q, p, 1.0, name="rod 2")]
        bodies = [kn.Particle("p", p, 1), kn.Particle("q", q, 2)]
        eom = kn.derive(
            kn.System(
                N,
                bodies=bodies,
                speeds="rates",
                holonomic=rods,
                loads=[kn.gravity(-G * N.y)],
                dependent_speeds=[kn.speed("u_y"), kn.speed("u_w")],
            )
        )
        for place in ("rod", rods):
            with pytest.raises(
                kn.ReactionError, match=r"constraints of one closure.*got 'rod 1' on p, 'rod 2' on q for 'rod'"
            ):
                eom.reaction(place)
        hanging = {"q": [0, -1, 0, -2], "u": [0, 0, 0, 0]}  # given by the vertical speeds
        assert numbers(eom, eom.reaction("rod 1").force, **hanging) == pytest.approx([0, 3 * G, 0])
        assert numbers(eom, eom.reaction("rod 2").force, **hanging) == pytest.approx([0, 2 * G, 0])

    def test_a_constraint_that_holds_nothing_is_no_obstacle_to_the_others(self):
        """A plane loop closed in space too: across the plane its force is not determined, along it as ever."""
        plain = FourBar.derive()
        whole = kn.coincident(FourBar.P3, FourBar.ground, (N.x, N.y, N.z), name="space")
        with pytest.warns(kn.KaneWarning, match="'space z' is always satisfied: it is redundant"):
            eom = FourBar.derive(holonomic=whole)
        state = FourBar.state(plain)
        for one, c in zip(plain.system.constraints, whole, strict=False):
            assert (
                error(numbers(eom, eom.reaction(c).force, **state), numbers(plain, plain.reaction(one).force, **state))
                < 1e-12
            )
        for place in (FourBar.P1, "space", "space z"):
            with pytest.raises(kn.ReactionError, match=r"a reaction that is uniquely determined.*'space z'"):
                eom.reaction(place)


class TestRedundant:
    """A door on two hinges: neither hinge's force along the axis is determined, but the rest is."""

    base = kn.free("door", O, N, child="D")
    D = base.frame
    body = kn.RigidBody("door", frame=D, mass_center=base.point, mass=3, inertia=kn.inertia(D, 0.3, 0.2, 0.5))
    low, high = base.point.at("low", -0.4 * D.x - 0.8 * D.z), base.point.at("high", -0.4 * D.x + 0.8 * D.z)

    def derive(self):
        hinges = (
            kn.coincident(self.low, O.at("A", -0.8 * N.z), (N.x, N.y, N.z), name="lower"),
            kn.coincident(self.high, O.at("B", 0.8 * N.z), (N.x, N.y, N.z), name="upper"),
        )
        loads = [kn.gravity(-G * N.z), kn.Torque(self.D, 2 * N.z)]
        with pytest.warns(kn.KaneWarning, match="'lower z'.*'upper z'|'upper z'.*'lower z'"):
            return kn.derive(kn.System(N, bodies=[self.body], joints=[self.base], loads=loads, holonomic=hinges))

    def state(self):
        place = [0.4 * np.cos(0.6), 0.4 * np.sin(0.6), 0]
        return {"q": [np.cos(0.3), 0, 0, np.sin(0.3), *place], "u": [0, 0, 1.5, 0, 0.4 * 1.5, 0]}

    def test_what_is_not_determined_is_refused(self):
        eom = self.derive()
        for place in ("lower", "upper", "lower z"):
            with pytest.raises(kn.ReactionError, match=rf"got '{place}': it contains.*'lower z', 'upper z'"):
                eom.reaction(place)

    def test_what_is_determined_is_told(self):
        """The hinges' forces across the axis, and that the free joint of the door transmits nothing, are as ever."""
        eom = self.derive()
        across = eom.system["lower x"], eom.system["upper x"]
        total = sum(numbers(eom, eom.reaction(c).force, **self.state()) for c in across)
        a = numbers(eom, eom.point_accelerations[self.base.point], **self.state())
        alpha = 2 / (0.5 + 3 * 0.4**2)
        c, s = np.cos(0.6), np.sin(0.6)
        np.testing.assert_allclose(a, 0.4 * np.array([-c * 1.5**2 - s * alpha, -s * 1.5**2 + c * alpha, 0]), atol=1e-12)
        assert total[0] == pytest.approx(3 * a[0])
        np.testing.assert_allclose(numbers(eom, eom.reaction("door").force, **self.state()), 0, atol=1e-11)


class TestFaults:
    def test_bare_constraints(self):
        P = O.at("P", kn.coordinate("x") * N.x + kn.coordinate("y") * N.y)
        x, y = kn.coordinate("x"), kn.coordinate("y")
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", holonomic=x**2 + y**2 - 1))
        for place in (P, "holonomic 1"):
            with pytest.raises(
                kn.ReactionError, match=r"the plain expression holonomic 1\. Declare them by points or frames: kn"
            ):
                eom.reaction(place)

    def test_names_and_places(self):
        _, body, eom = pendulum()
        with pytest.raises(
            kn.ReactionError, match=r"name of a joint .*, one of hinge, O, hinge point, rod\*, N, B, got 'elbow'"
        ):
            eom.reaction("elbow")
        with pytest.raises(kn.ReactionError, match="got O, a root, which has no near side"):
            eom.reaction(O)
        with pytest.raises(kn.ReactionError, match=r"got Q, a particle of a body, which has no far side"):
            eom.reaction(body.mass_center.fixed_in(body.frame, "Q"))
        with pytest.raises(kn.ReactionError, match=r"a body on the far side of Q, got none"):
            eom.reaction(body.mass_center.at("Q", 0))
        with pytest.raises(kn.ReactionError, match=r"constraints of the system or a name.*got stray"):
            eom.reaction(kn.configuration_constraint("stray", 1))
        with pytest.raises(kn.ReactionError, match=r"constraints of the system or a name.*got nothing"):
            eom.reaction(())
        with pytest.raises(kn.ReactionError, match=r"constraints of the system or a name.*got 3"):
            eom.reaction(3)

    def test_a_body_on_both_sides(self):
        hinge = kn.pin("hinge", O, N, axis=N.z, child="B")
        body = kn.RigidBody(
            "b", frame=hinge.frame, mass_center=O.at("b*", hinge.frame.x), mass=1, inertia=kn.inertia(N, 1, 1, 1)
        )
        eom = kn.derive(kn.System(N, bodies=[body], joints=[hinge]))
        with pytest.raises(
            kn.ReactionError,
            match=r"on one side of the joint 'hinge', got b.*frame, but not from its point.*joint\.point",
        ):
            eom.reaction(hinge)

    def test_a_torque_on_a_massless_frame(self):
        yaw = kn.pin("yaw", O, N, axis=N.z, child="Y")
        lean = kn.pin("lean", yaw.point, yaw.frame, axis=yaw.frame.x, child="L")
        body = kn.RigidBody(
            "b", frame=lean.frame, mass_center=lean.point, mass=1, inertia=kn.inertia(lean.frame, 1, 2, 3)
        )
        eom = kn.derive(kn.System(N, bodies=[body], joints=[yaw, lean], loads=[kn.Torque(yaw.frame, 3 * N.z)]))
        with pytest.raises(kn.ReactionError, match=r"frames of bodies.*at the point yaw point, got one on Y"):
            eom.reaction(yaw.point)
        torque = numbers(eom, eom.reaction("lean").torque, q=[0.2, 0.4], u=[0.0, 0.0])
        assert torque[2] == pytest.approx(3)
        np.testing.assert_allclose(
            numbers(eom, eom.reaction("yaw").torque, q=[0.2, 0.4], u=[0.0, 0.0])[2], 0, atol=1e-13
        )
