# SPDX-License-Identifier: BSD-3-Clause
"""The system: what it gathers, in which order, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.model import gravity_load, total_mass
from tests.paths import Path, numbers

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2, x = kn.coordinates("q1 q2 x")
u1, u2, u3 = kn.speeds("u1:4")
m, L, g = kn.parameter("m", 2.0, "kg"), kn.parameter("L", 1.5, "m"), kn.parameter("g", 9.81)
A = N.rotate("A", q1, N.z)
B = A.rotate("B", q2, A.x)
P = O.at("P", x * N.x)
G = P.at("G", -L * A.y)
E = G.at("E", -L * B.z)
bob = kn.Particle("bob", G, m)
link = kn.RigidBody("link", frame=B, mass_center=E, mass=3, inertia=kn.inertia(B, 1, 2, 3))


def make(**changes):
    options = {"bodies": [bob, link], "speeds": "rates"} | changes
    return kn.System(options.pop("inertial", N), **options)


def test_it_finds_frames_points_coordinates_and_parameters():
    T = kn.input("T")
    system = make(loads=[kn.gravity(-g * N.y), kn.Torque(B, T * B.x), kn.Force(E.at("tip", B.z), kn.time * N.x)])
    assert [f.name for f in system.frames] == ["N", "A", "B"]
    assert [p.name for p in system.points] == ["O", "P", "G", "E", "tip"]
    assert {s.name for s in system.coordinates} == {"q1", "q2", "x"}
    assert {s.name for s in system.parameters} == {"m", "L", "g"}
    assert system.inputs == (T,)
    assert [b.name for b in system.rigid_bodies] == ["link"]
    assert str(total_mass(system.bodies)) == "m + 3"
    assert repr(system) == "System(bob, link; 3 coordinates, 3 speeds)"


def test_order_of_coordinates():
    system = make(coordinates=(x, q2, q1))
    assert system.coordinates == (x, q2, q1)
    assert [u.name for u in system.speeds] == ["u_x", "u2", "u1"]


def test_rates_as_speeds():
    assert {u.name: str(d) for u, d in make().speeds.items()} == {"u1": "q1'", "u2": "q2'", "u_x": "x'"}
    e = kn.coordinates("e0:4")
    free = N.rotate_euler_parameters("F", e)
    body = kn.RigidBody("b", frame=free, mass_center=O.at("C", 0), mass=1, inertia=kn.inertia(free, 1, 1, 2))
    system = make(bodies=[body])
    assert [u.name for u in system.speeds] == ["w1_e0", "w2_e0", "w3_e0"]
    assert system.euler_parameters[0].coordinates == e


def test_frozen():
    with pytest.raises(AttributeError):
        make().bodies = ()  # type: ignore[misc]


def test_two_systems_share_their_parts():
    """Nothing in a body, point or frame knows of the system: it may be in several."""
    first, second = make(), make(speeds={u1: q1.dt, u2: q2.dt, u3: x.dt + q1.dt}, bodies=[bob, link])
    assert first.bodies == second.bodies
    ready = [kn.derive(s) for s in (first, second, first)]
    assert ready[0].mass_matrix[0, 0] is ready[2].mass_matrix[0, 0]


class TestGravity:
    def test_force_and_potential(self):
        load = gravity_load(kn.gravity(-g * N.y), (bob, link))
        assert [p.name for p, _ in load.forces] == ["G", "E"]
        path = Path((q1, q2, x), 3)
        values = path.values()
        heights = [numbers(p.position(O).components(N), values)[1] for p in (G, E)]
        assert numbers([load.potential], values) == pytest.approx(9.81 * np.dot([2, 3], heights))
        for symbol in (q1, q2, x):
            work = sum(
                numbers(p.velocity(N).map(lambda e, s=symbol: kn.diff(e, s.dt)).components(N), values)
                @ numbers(f.components(N), values)
                for p, f in load.forces
            )
            assert numbers([kn.diff(load.potential, symbol)], values) == pytest.approx(-work)

    @pytest.mark.parametrize("field", [-g * A.y, g * kn.sin(kn.time) * N.y, x * N.y])
    def test_a_field_that_is_not_constant_has_no_potential(self, field):
        assert gravity_load(kn.gravity(field), (bob, link)).potential is None

    def test_constant_in_a_frame_that_does_not_turn(self):
        tilted = N.rotate("T", kn.parameter("slope", 0.1), N.z)
        assert gravity_load(kn.gravity(-g * tilted.y), (bob,)).potential is not None


M = kn.Frame("M")
PM = kn.Point("PM", fixed_in=M)
N_reaction = kn.reaction("F", at=P, along=N.y)
push, weight = kn.Force(G, N.x, name="push"), kn.gravity(-g * N.y)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"inertial": A}, kn.ModelError, "root frame as the inertial frame"),
        ({"inertial": "N"}, kn.ModelError, "root frame"),
        ({"inertial": M}, kn.ModelError, "whose root is N|whose root O"),
        ({"bodies": []}, kn.ModelError, "at least one body"),
        ({"bodies": [G]}, kn.ModelError, "kn.RigidBody or kn.Particle, got Point"),
        ({"bodies": [bob, kn.Particle("bob", E, 1)]}, kn.ModelError, "different names, got bob more than once"),
        ({"bodies": [bob, kn.Particle("far", PM, 1)]}, kn.ModelError, "placed from one fixed in N, got PM"),
        ({"bodies": [bob, kn.Particle("far", kn.Point("O2", fixed_in=N), 1)]}, kn.ModelError, "one fixed point, got O, O2"),
        ({"loads": [N.x]}, kn.ModelError, "loads from kn.Force"),
        ({"loads": [push, push]}, kn.ModelError, r"each load once in loads=, got Load\('push'\) more than once"),
        ({"loads": [weight, kn.gravity(-g * N.y), weight]}, kn.ModelError, "each load once"),
        ({"loads": [kn.Torque(M, M.x)]}, kn.ModelError, "whose root is M"),
        ({"loads": [kn.Force(PM, M.x)]}, kn.ModelError, "is fixed in M"),
        ({"coordinates": (q1, q2)}, kn.ModelError, "list each of"),
        ({"coordinates": (q1, q2, x, x)}, kn.ModelError, "list each of"),
        ({"speeds": "velocities"}, kn.SpeedsError, '"rates", got \'velocities\''),
        ({"speeds": {q1: q1.dt}}, kn.SpeedsError, r"keys of speeds=, got q1 \(Coordinate\)"),
        ({"speeds": {u1: N.x}}, kn.SpeedsError, "scalar definition of u1"),
        ({"loads": [kn.Force(G, N_reaction * N.x)]}, kn.ReactionError, "F is used in a load but not listed"),
        ({"reactions": [N_reaction, N_reaction]}, kn.ReactionError, "one twice"),
        ({"reactions": [kn.reaction("bare")]}, kn.ReactionError, "got 0 and 1"),
        ({"auxiliary_speeds": [kn.auxiliary_speed("ua", at=P, along=N.y)]}, kn.ReactionError, "got 1 and 0"),
        ({"bodies": [kn.Particle("bob", G, kn.parameter("m", 3.0)), link], "loads": [kn.Force(G, m * N.x)]},
         kn.ModelError, "one symbol of the name 'm', got two"),
        ({"loads": [kn.Force(G, kn.coordinate("z") * N.x)]}, kn.ModelError, "symbols of the system, got z"),
        ({"loads": [kn.Force(G, kn.coordinate("z").dt * N.x)]}, kn.ModelError, "symbols of the system, got z'"),
        ({"loads": [kn.Force(G, kn.speed("w") * N.x)]}, kn.ModelError, "symbols of the system, got w"),
        ({"events": [kn.Event("e", kn.speed("w"))]}, kn.ModelError, "symbols of the system, got w"),
        ({"loads": [kn.Force(G, q1.dt.dt * N.x)]}, kn.ModelError, "got q1'', which is not known before"),
        ({"loads": [kn.Force(G, kn.speed("u1").dt * N.x)]}, kn.ModelError, "got u1', which is not known before"),
    ],
)  # fmt: skip
def test_errors(changes, error, message):
    with pytest.raises(error, match=message):
        make(**changes)


def test_one_coordinate_in_two_sets_of_euler_parameters():
    e = kn.coordinates("e0:7")
    first, second = N.rotate_euler_parameters("F", e[:4]), N.rotate_euler_parameters("S", e[3:])
    bodies = [
        kn.RigidBody(f.name, frame=f, mass_center=O.at(f.name, 0), mass=1, inertia=kn.inertia(f, 1, 1, 2))
        for f in (first, second)
    ]
    with pytest.raises(kn.ModelError, match="different sets of Euler parameters"):
        make(bodies=bodies)


def test_two_frames_of_one_set_of_euler_parameters():
    """Two bodies that always lie alike may share their orientation."""
    e = kn.coordinates("e0:4")
    frames = [N.rotate_euler_parameters(name, e) for name in "FS"]
    bodies = [
        kn.RigidBody(f.name, frame=f, mass_center=O.at(f.name, k * f.x), mass=1, inertia=kn.inertia(f, 1, 1.5, 2))
        for k, f in enumerate(frames)
    ]
    eom = kn.derive(make(bodies=bodies))
    single = kn.RigidBody(
        "both",
        frame=frames[0],
        mass_center=O.at("C", 0.5 * frames[0].x),
        mass=2,
        inertia=kn.inertia(frames[0], 2, 3.5, 4.5),
    )
    other = kn.derive(make(bodies=[single]))
    state = {"q": np.array([0.5, -0.5, 0.1, np.sqrt(0.49)]), "u": [0.3, -0.2, 0.7]}
    expected = np.array(other.evaluate(list(other.accelerations), **state))
    assert np.array(eom.evaluate(list(eom.accelerations), **state)) == pytest.approx(expected)


def test_events_may_watch_accelerations_and_reactions():
    system = make(
        speeds={u1: q1.dt, u2: q2.dt, u3: x.dt},
        reactions=[N_reaction],
        events=[kn.Event("lift", N_reaction), kn.Event("jerk", u1.dt), kn.Event("pull", q1.dt.dt)],
    )
    assert [e.name for e in kn.derive(system).events] == ["lift", "jerk", "pull"]


def test_replace_and_lookup_by_name():
    from kane.gallery import rolling_disk

    disk = rolling_disk.model()
    other = disk.system.replace(speeds="rates")
    assert [str(e) for e in other.speeds.values()] == ["q1'", "q2'", "q3'", "q4'", "q5'"]
    assert other.bodies == disk.system.bodies
    assert other.reactions == disk.system.reactions
    assert other.loads == disk.system.loads
    assert disk.system["disk"] is disk.disk
    assert disk.system["B"] is disk.B
    assert disk.system["C*"] is disk.Cs
    with pytest.raises(kn.ModelError, match="to replace, got colour"):
        disk.system.replace(colour=1)
    with pytest.raises(kn.ModelError, match="got 'nothing'"):
        disk.system["nothing"]


def test_coordinates_of_positions_come_first_and_numbered_ones_stay_together():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    r, theta, q10, q2 = kn.coordinates("r theta q10 q2")
    A = N.rotate("A", theta, N.z)
    B = A.rotate("B", q10, A.x).rotate("B2", q2, A.x)
    P = O.at("P", r * A.x)
    body = kn.RigidBody("b", frame=B, mass_center=P, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    system = kn.System(N, bodies=[body], speeds="rates")
    assert [q.name for q in system.coordinates] == ["r", "theta", "q2", "q10"]


class TestCounters:
    """Coordinates that no frame or point depends on."""

    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, angle = kn.coordinates("x angle")
    u, w = kn.speeds("u w")
    R = kn.parameter("R", 0.3)
    P = O.at("P", x * N.x)

    def system(self, **more):
        pull = kn.Force(self.P, -self.x * self.N.x)
        return kn.System(self.N, bodies=[kn.Particle("p", self.P, 2)], loads=[pull], **more)

    @pytest.mark.parametrize("kind", ["motion", "configuration"])
    def test_a_wheel_without_mass_that_rolls_along(self, kind):
        if kind == "motion":
            speeds = {self.u: self.x.dt, self.w: self.angle.dt}
            system = self.system(speeds=speeds, nonholonomic=[self.x.dt - self.R * self.angle.dt])
        else:
            system = self.system(speeds="rates", holonomic=[self.x - self.R * self.angle])
        eom = kn.derive(system)
        sol = kn.simulate(eom, (0, 2), q={"x": 0.6, "angle": 2.0}, u=[0, 0], samples=5)
        assert sol["x"] == pytest.approx(0.6 * np.cos(sol.t / 2**0.5), rel=1e-6)
        assert sol["angle"] == pytest.approx(sol["x"] / 0.3, rel=1e-6)

    def test_one_without_a_speed_is_a_stray(self):
        with pytest.raises(kn.ModelError, match="symbols of the system, got angle"):
            self.system(speeds={self.u: self.x.dt}, holonomic=[self.x - self.angle])
