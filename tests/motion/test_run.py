# SPDX-License-Identifier: BSD-3-Clause
"""Simulations against closed forms; how they end."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
v = kn.speed("v")
T = kn.input("T")
m, k, c = kn.parameter("m", 2.0), kn.parameter("k", 8.0), kn.parameter("c", 0.4)
P = O.at("P", x * N.x)
METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


def line(force, events=(), loads=()):
    """A particle on a line under a force."""
    load = [] if force is None else [kn.Force(P, force * N.x)]
    system = kn.System(N, bodies=[kn.Particle("p", P, m)], speeds={v: x.dt}, loads=[*load, *loads], events=events)
    return kn.derive(system)


OSCILLATOR = line(None, loads=[kn.linear_spring(P, O, k)])


def damped(t, drive=0.0):
    """m ẍ + c ẋ + k x = drive, from x = 1 at rest."""
    w0, d = 2.0, 0.4 / 4
    w = np.sqrt(w0 * w0 - d * d)
    rest = drive / 8
    return rest + (1 - rest) * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))


class TestClosedForms:
    def test_harmonic_oscillator(self):
        sol = kn.simulate(OSCILLATOR, (0, 10), q={x: 1.5}, u={v: -0.6}, rtol=1e-11, atol=1e-11)
        expected = 1.5 * np.cos(2 * sol.t) - 0.3 * np.sin(2 * sol.t)
        assert sol[x] == pytest.approx(expected, abs=1e-8)
        assert sol[v] == pytest.approx(-3 * np.sin(2 * sol.t) - 0.6 * np.cos(2 * sol.t), abs=1e-8)
        assert (sol.status, sol.event) == ("finished", None)
        assert sol.energy_check.relative < 1e-9

    @pytest.mark.parametrize("method", METHODS)
    def test_every_method(self, method):
        tight = {} if method != "RK23" else {"rtol": 1e-8, "atol": 1e-8}
        eom = line(-k * x - c * v + T)
        sol = kn.simulate(eom, (0, 3), q=[1], u=[0], inputs={T: 0.8}, method=method, samples=31, **tight)
        assert sol[x] == pytest.approx(damped(sol.t, 0.8), abs=2e-6)

    def test_projectile(self):
        q, g = kn.coordinates("a b"), 9.81
        point = O.at("Q", q[0] * N.x + q[1] * N.y)
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", point, m)], speeds="rates", loads=[kn.gravity(-g * N.y)]))
        sol = kn.simulate(eom, (1, 4), q={"a": 1, "b": 2}, u={"u_a": 3, "u_b": 20})
        t = sol.t - 1
        assert sol[point.position(O)] == pytest.approx(
            np.stack([1 + 3 * t, 2 + 20 * t - g * t * t / 2, 0 * t], -1), abs=1e-8
        )
        assert sol[point.velocity(N)] == pytest.approx(np.stack([3 + 0 * t, 20 - g * t, 0 * t], -1), abs=1e-8)
        assert sol.energy[-1] == pytest.approx(sol.energy[0])

    def test_free_symmetric_top(self):
        """A body of revolution without torque: its axis cones about H at the rate |H|/I."""
        angles = kn.coordinates("psi theta phi")
        B = N.rotate_body("B", angles, "zxz")
        body = kn.RigidBody("top", frame=B, mass_center=O.at("G", 0), mass=1, inertia=kn.inertia(B, 2, 2, 1))
        eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
        tilt, H = 0.7, 3.0  # H along N.z; ω = H (sin, cos/…): precession H/I, spin (1/J − 1/I) H cos θ
        start = {"u_psi": H / 2, "u_theta": 0.0, "u_phi": H * np.cos(tilt) * (1 - 0.5)}
        sol = kn.simulate(eom, (0, 6), q={"psi": 0.2, "theta": tilt, "phi": 0.0}, u=start)
        assert sol["theta"] == pytest.approx(np.full(len(sol), tilt), abs=1e-7)
        assert sol["psi"] == pytest.approx(0.2 + 1.5 * sol.t, abs=1e-7)
        assert sol[eom.angular_momentum(O)] == pytest.approx(np.tile([0, 0, 3.0], (len(sol), 1)), abs=1e-7)

    def test_euler_parameters_keep_their_length(self):
        e = kn.coordinates("e0:4")
        B = N.rotate_euler_parameters("B", e)
        body = kn.RigidBody("b", frame=B, mass_center=O.at("G", 0), mass=1, inertia=kn.inertia(B, 1, 2, 3))
        eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
        sol = kn.simulate(eom, (0, 10), q=[1, 0, 0, 0], u=[0.1, 2.0, 0.1])
        assert np.abs(sum(sol[x] ** 2 for x in e) - 1).max() < 1e-7
        assert np.ptp(sol[eom.angular_momentum(O)], axis=0) == pytest.approx(np.zeros(3), abs=1e-6)
        assert sol.energy_check.relative < 1e-8
        assert np.sign(sol["w2_e0"]).min() < 0  # the unstable axis: it tumbles


class TestInputsAndParameters:
    EOM = line(-k * x - c * v + T)

    def test_input_as_a_function_of_time(self):
        """From rest under T = sin 3t without spring or damper: ẋ = (1 − cos 3t)/(3 m)."""
        sol = kn.simulate(
            self.EOM, (0, 2), q=[0], u=[0], inputs={"T": lambda t: np.sin(3 * t)}, parameters={"k": 0, c: 0, m: 4}
        )
        assert sol[v] == pytest.approx((1 - np.cos(3 * sol.t)) / 12, abs=1e-9)
        assert sol[T] == pytest.approx(np.sin(3 * sol.t))
        assert sol.energy_check.relative < 1e-8

    def test_parameters_by_name_and_by_symbol_and_by_default(self):
        by_name = kn.simulate(self.EOM, (0, 2), q=[1], u=[0], inputs={T: 0}, parameters={"m": 3.0, "k": 5})
        by_symbol = kn.simulate(self.EOM, (0, 2), q=[1], u=[0], inputs={T: 0}, parameters={m: 3.0, k: 5})
        default = kn.simulate(self.EOM, (0, 2), q=[1], u=[0], inputs={T: 0})
        assert by_name[x] == pytest.approx(by_symbol[x], abs=0)
        assert default[x] == pytest.approx(damped(default.t), abs=1e-8)
        assert by_name.parameters[m] == 3.0
        assert by_name.parameters[c] == 0.4
        assert by_name["k"] == pytest.approx(np.full(len(by_name), 5))

    @pytest.mark.parametrize(
        ("q", "u"), [([1], [0]), ({x: 1}, {v: 0}), ({"x": 1}, {"v": 0}), (np.array([1.0]), np.array([0.0]))]
    )
    def test_start_in_every_form(self, q, u):
        sol = kn.simulate(OSCILLATOR, (0, 1), q=q, u=u)
        assert sol[x] == pytest.approx(np.cos(2 * sol.t), abs=1e-8)

    def test_a_start_by_rates(self):
        """u = R q' + r(t) with R left to its default: 2 · 1 + 3 at t = 0.5."""
        radius, r = kn.parameter("R", 2.0), kn.input("r")
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds={v: radius * x.dt + r}))
        drive = (lambda t: 6 * t, lambda t: 6.0, lambda t: 0.0)
        sol = kn.simulate(eom, (0.5, 1), q=[0], rates={x: 1.0}, inputs={r: drive})
        assert sol[v][0] == pytest.approx(5)
        # without a load the point keeps its velocity
        assert sol[x] == pytest.approx(sol.t - 0.5, abs=1e-9)
        with pytest.raises(kn.ValueMissingError, match=r"start value for all rates .* x are undetermined"):
            kn.simulate(eom, (0.5, 1), q=[0], rates={}, inputs={r: drive})


class TestSamples:
    def test_how_many(self):
        assert kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0], samples=5).t == pytest.approx([0, 0.5, 1, 1.5, 2])
        assert len(kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0])) == 501
        assert len(kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0], samples=np.int64(7))) == 7

    def test_times(self):
        """The times asked for, with the start and the end of the span."""
        sol = kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0], samples=[0.3, 1.1])
        assert sol.t == pytest.approx([0, 0.3, 1.1, 2])
        assert sol[x] == pytest.approx(np.cos(2 * sol.t), abs=1e-8)

    @pytest.mark.parametrize("samples", [1, 0, -3, [1.0, 0.5], [0.5, 0.5], [0.5, 3.0], [-1.0], [[0.5]], "many"])
    def test_errors(self, samples):
        with pytest.raises(kn.SimulationError, match=r"samples|sample times"):
            kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0], samples=samples)

    @pytest.mark.parametrize(
        ("samples", "message"),
        [
            ([1.0, 0.5], r"got 0\.5 after 1\. Sort them"),
            ([0.5, 3.0], r"within \(0, 2\), got 3\. Leave it out, or give a longer span"),
            ([-1.0, 1.0], r"got -1\. Leave it out"),
            ([[0.5]], r"got an array of shape \(1, 1\)\. Give one list"),
            (2.5, r"whole number of samples, .* got the number 2\.5\. Give samples=\[2\.5\] for a time"),
        ],
    )
    def test_what_came(self, samples, message):
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(OSCILLATOR, (0, 2), q=[1], u=[0], samples=samples)


class TestEvents:
    def test_located(self):
        """x = cos 2t falls below 0.25 at acos(0.25)/2."""
        eom = line(-k * x, events=[kn.Event("low", x, 0.25, -1, message="too low")])
        sol = kn.simulate(eom, (0, 10), q=[1], u=[0], rtol=1e-11, atol=1e-11)
        assert sol.status == "event"
        assert sol.event.name == "low"
        assert sol.t[-1] == pytest.approx(np.arccos(0.25) / 2, abs=1e-9)
        assert sol[x][-1] == pytest.approx(0.25, abs=1e-9)
        assert sol.message == f"low at t = {sol.t[-1]:.6g}: too low"

    @pytest.mark.parametrize(("direction", "time"), [(-1, np.pi / 4), (1, 3 * np.pi / 4), (0, np.pi / 4)])
    def test_direction(self, direction, time):
        eom = line(-k * x, events=[kn.Event("zero", x, 0.0, direction)])
        assert kn.simulate(eom, (0, 10), q=[1], u=[0]).t[-1] == pytest.approx(time, abs=1e-7)

    def test_the_first_of_several(self):
        events = [kn.Event("late", x, -0.5, -1), kn.Event("early", x, 0.5, -1), kn.Event("other", v, 100.0)]
        sol = kn.simulate(line(-k * x, events=events), (0, 10), q=[1], u=[0])
        assert sol.event.name == "early"

    def test_not_terminal(self):
        eom = line(-k * x, events=[kn.Event("zero", x, terminal=False)])
        assert kn.simulate(eom, (0, 5), q=[1], u=[0]).status == "finished"

    def test_quantity_in_rates_accelerations_and_reactions(self):
        """A bead that slides off a smooth ball leaves it where 3 cos θ = 2 cos θ0 + v0²/(g r)."""
        th, w = kn.coordinate("th"), kn.speed("w")
        A = N.rotate("A", -th, N.z)
        bead = O.at("bead", 0.5 * A.y)
        normal = kn.reaction("R", at=bead, along=A.y)
        events = [
            kn.Event("lift-off", normal, 0.0, -1),
            kn.Event("fast", th.dt, 50.0),
            kn.Event("hasty", th.dt.dt, 90.0),
            kn.Event("hasty too", w.dt, 90.0),
        ]
        eom = kn.derive(
            kn.System(
                N, bodies=[kn.Particle("p", bead, m)], speeds={w: th.dt}, loads=[kn.gravity(-9.81 * N.y)],
                reactions=[normal], events=events,
            )
        )  # fmt: skip
        sol = kn.simulate(eom, (0, 5), q=[0.1], u=[0.4])
        assert sol.event.name == "lift-off"
        assert 3 * np.cos(sol[th][-1]) == pytest.approx(2 * np.cos(0.1) + 0.2**2 / (9.81 * 0.5), abs=1e-8)
        assert sol[normal][-1] == pytest.approx(0, abs=1e-6)

    def test_start_on_the_far_side_of_an_event(self):
        """A ball thrown from the floor: at the start it is at the threshold, and it ends when it comes back."""
        eom = line(-9.81 * m, events=[kn.Event("floor", x, 0.0, -1)])
        sol = kn.simulate(eom, (0, 10), q=[0], u=[5.0])
        assert sol.t[-1] == pytest.approx(10 / 9.81, abs=1e-8)
        below = kn.simulate(eom, (0, 10), q=[-1], u=[5.0])
        assert below.t[-1] == pytest.approx((5 + np.sqrt(25 - 2 * 9.81)) / 9.81, abs=1e-8)


class TestFriction:
    normal = kn.reaction("N", at=P, along=N.y)
    EOM = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("p", P, m)],
            speeds={v: x.dt},
            reactions=[normal],
            loads=[kn.gravity(-9.81 * N.y), kn.friction(P, normal, 0.3, name="friction")],
        )
    )

    @pytest.mark.parametrize("sign", [1, -1])
    def test_a_block_that_slides_to_rest(self, sign):
        sol = kn.simulate(self.EOM, (0, 5), q=[0], u=[2.0 * sign])
        decline = 0.3 * 9.81
        assert sol.status == "event"
        assert sol.event.name == "onset of sticking (friction)"
        assert sol.t[-1] == pytest.approx(2 * (1 - 1e-4) / decline, abs=1e-6)
        assert sol[v] == pytest.approx(sign * (2 - decline * sol.t), abs=1e-7)
        assert sol[x][-1] == pytest.approx(sign * 4 / decline / 2, abs=1e-6)
        assert sol[self.normal] == pytest.approx(np.full(len(sol), 2 * 9.81))
        assert sol.energy_check.relative < 1e-8
        assert sol.work[-1] == pytest.approx(-4, abs=1e-6)

    def test_a_start_without_slip(self):
        with pytest.raises(kn.SimulationError, match=r"onset of sticking \(friction\).*slip"):
            kn.simulate(self.EOM, (0, 5), q=[0], u=[0.0])

    @pytest.mark.parametrize("speed", [1e-6, 1.0, 1e6])
    def test_what_rounding_leaves_of_rolling_is_no_slip(self, speed):
        """A wheel that slides at s' = x' − R w: nothing but rounding is left of it where x' = R w."""
        turn, w = kn.coordinate("turn"), kn.speed("w")
        A = N.rotate("A", turn, N.z)
        center = O.at("C", x * N.x)
        rim = center.fixed_in(A, "rim", -0.3 * N.y)
        normal = kn.reaction("N", at=center, along=N.y)
        wheel = kn.RigidBody("w", frame=A, mass_center=center, mass=m, inertia=kn.inertia(A, 1, 1, 1))
        rub = kn.friction(rim, normal, 0.3, name="friction")
        loads, speeds = [kn.gravity(-9.81 * N.y), rub], {v: x.dt, w: turn.dt}
        eom = kn.derive(kn.System(N, bodies=[wheel], speeds=speeds, reactions=[normal], loads=loads))
        rolling = {v: -0.3 * speed, w: speed * (1 + 1e-14)}
        with pytest.raises(kn.SimulationError, match=r"onset of rolling \(friction\).*slip"):
            kn.simulate(eom, (0, 1), q=[0, 0], u=rolling)
        sol = kn.simulate(eom, (0, 1e9), q=[0, 0], u=rolling | {w: 1.01 * speed}, samples=3, atol=1e-9 * speed)
        assert sol.event is not None
        assert sol.event.name == "onset of rolling (friction)"


class TestSingularities:
    @pytest.mark.parametrize("method", METHODS)
    def test_a_right_hand_side_that_ends(self, method):
        """√(1 − x) is not defined beyond x = 1: the run stops there, keeps what it has and says so."""
        eom = line(kn.sqrt(1 - x))
        sol = kn.simulate(eom, (0, 5), q=[0], u=[1], method=method, rtol=1e-6, atol=1e-6)
        assert sol.status == "stopped"
        assert "singular or not finite near t = 0.8" in sol.message
        assert 0.8 < sol[x][-1] <= 1
        assert np.isfinite(sol.states).all()
        assert len(sol) > 50

    @pytest.mark.slow
    @pytest.mark.parametrize("method", METHODS)
    def test_escape_in_finite_time(self, method):
        sol = kn.simulate(line(6 * x**3), (0, 5), q=[1], u=[1], method=method, rtol=1e-6, max_steps=20_000)
        assert sol.status == "stopped"
        assert sol[x][-1] > 1e3
        assert sol.t[-1] < 1

    def test_steps_run_out(self):
        sol = kn.simulate(OSCILLATOR, (0, 100), q=[1], u=[0], max_steps=5)
        assert sol.status == "stopped"
        assert sol.message.startswith("5 steps were not enough")
        assert sol.steps == 5

    def test_spherical_pendulum_through_its_pole(self):
        """Speeds along the sphere's meridian and parallel: φ̇ = −u1/(l sin θ) has no value at the pole."""
        th, ph = kn.coordinates("th ph")
        u = kn.speeds("u1 u2")
        A = N.rotate("A", ph, N.z)
        B = A.rotate("B", th, A.x)
        bob = O.at("bob", -1.5 * B.z)
        velocity = bob.velocity(N)
        eom = kn.derive(
            kn.System(
                N, bodies=[kn.Particle("p", bob, 1)], speeds={u[0]: velocity.dot(B.x), u[1]: velocity.dot(B.y)},
                loads=[kn.gravity(-9.81 * N.z)],
            )
        )  # fmt: skip
        sol = kn.simulate(eom, (0, 3), q={th: 1.0, ph: 0.2}, u={u[0]: 0, u[1]: 0})
        assert sol.status == "event"
        assert "singular kinematics" in sol.event.name
        assert "Euler parameters" in sol.message
        assert sol[th][-1] == pytest.approx(0, abs=1e-9)
        assert sol[u[1]][-1] ** 2 == pytest.approx(2 * 9.81 * 1.5 * (1 - np.cos(1)))
        assert np.isfinite(sol.states).all()
        with pytest.raises(kn.SimulationError, match=r"finite rates at the start, got none for .*singular"):
            kn.simulate(eom, (0, 3), q={th: 0.0, ph: 0.2}, u={u[0]: 0.1, u[1]: 0})

    def test_euler_angles_through_gimbal_lock(self):
        """A body with u = ω turns about the line of nodes: θ reaches 0, where ψ̇ and φ̇ have no values."""
        q, u = kn.coordinates("q1:4"), kn.speeds("u1:4")
        B = N.rotate_body("B", q, "zxz")
        w = B.angular_velocity(N)
        body = kn.RigidBody("b", frame=B, mass_center=O.at("G", 0), mass=1, inertia=kn.inertia(B, 1, 2, 3))
        speeds = dict(zip(u, (w.dot(B.x), w.dot(B.y), w.dot(B.z)), strict=True))
        eom = kn.derive(kn.System(N, bodies=[body], speeds=speeds))
        sol = kn.simulate(eom, (0, 3), q=[0.2, 0.4, 0.0], u=[-1, 0, 0])
        assert sol.status == "event"
        assert sol.t[-1] == pytest.approx(0.4, abs=1e-7)
        assert "singular kinematics" in sol.message
        with pytest.raises(kn.SimulationError, match="rates at the start, got none for q1', q3' at t = 0"):
            kn.simulate(eom, (0, 3), q=[0.2, 0.0, 0.0], u=[-1, 1, 0])


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"span": (1, 0)}, kn.SimulationError, r"t1 > t0, got \(1, 0\)"),
        ({"span": (0, 0)}, kn.SimulationError, "t1 > t0"),
        ({"span": (0, float("inf"))}, kn.SimulationError, "t1 > t0"),
        ({"span": 5}, kn.SimulationError, r"time span \(t0, t1\), got 5"),
        ({"span": (0, 1, 2)}, kn.SimulationError, "time span"),
        ({"rtol": 0}, kn.SimulationError, "rtol > 0, got 0"),
        ({"atol": -1e-9}, kn.SimulationError, "atol > 0"),
        ({"atol": float("nan")}, kn.SimulationError, "finite tolerance for atol"),
        ({"rtol": 1e-17}, kn.SimulationError, r"rtol from 2\.2e-16, .* to below 1, got 1e-17"),
        ({"rtol": 1.0}, kn.SimulationError, r"rtol from 2\.2e-16, .* to below 1, got 1\.0"),
        ({"rtol": True}, kn.SimulationError, "rtol > 0, got True"),
        ({"rtol": "fine"}, kn.SimulationError, "number as the tolerance for rtol"),
        ({"method": "Euler"}, kn.SimulationError, "one of auto, .*RK23, RK45, .*got 'Euler'"),
        ({"q": {}}, kn.ValueMissingError, "start value for all coordinates, got none for x"),
        ({"u": {}}, kn.ValueMissingError, "start value for all speeds, got none for v"),
        ({"q": {"y": 1}}, kn.ValueMissingError, r"coordinates of the system \(x\), got one for 'y'"),
        ({"q": [1, 2]}, kn.ValueMissingError, "Expected 1 coordinates"),
        ({"q": {x: float("nan")}}, kn.SimulationError, "finite start value for x, got nan"),
        ({"u": {v: float("inf")}}, kn.SimulationError, "finite start value for v, got inf"),
        ({"q": {x: "one"}}, kn.SimulationError, "number as the start value for x"),
        ({"inputs": {}}, kn.ValueMissingError, "every input, got none for T"),
        ({"inputs": {"F": 1}}, kn.ValueMissingError, r"inputs of the system \(T\), got one for 'F'"),
        ({"inputs": {T: "big"}}, kn.SimulationError, "number as the value or function of time for T"),
        ({"inputs": {T: lambda t: float("nan")}}, kn.SimulationError, "finite rates at the start, got none for v'"),
        ({"parameters": {"l": 1}}, kn.ValueMissingError, "parameters of the system"),
        ({"parameters": {m: float("nan")}}, kn.SimulationError, "finite value for m"),
        ({"parameters": {kn.parameter("m"): 1}}, kn.ValueMissingError, "parameters of the system"),
        ({"parameters": {m: 0}}, kn.SimulationError, "finite rates at the start"),
    ],
)
def test_errors(changes, error, message):
    given = {"span": (0, 1), "q": {x: 1}, "u": {v: 0}, "inputs": {T: 0}} | changes
    eom = line(-k * x + T)
    with pytest.raises(error, match=message):
        kn.simulate(eom, given.pop("span"), **given)


def test_an_event_that_a_parameter_makes_nothing_of():
    """c x with c = 0 stays at zero for ever; away from its threshold it is an event that does not come."""
    c = kn.parameter("c", 1.0)
    given = {"q": [1], "u": [0], "inputs": {T: 0}}
    eom = line(-k * x + T, events=[kn.Event("never", c * x)])
    assert kn.simulate(eom, (0, 3), **given).status == "event"
    with pytest.raises(
        kn.SimulationError, match=r"event 'never' that crosses 0, got c\*x, which remains there because c = 0"
    ):
        kn.simulate(eom, (0, 3), parameters={c: 0}, **given)
    for quantity in (c * x - 1, c + x, x / (1 + c)):
        eom = line(-k * x + T, events=[kn.Event("some", quantity)])
        assert kn.simulate(eom, (0, 3), parameters={c: 0}, **given).status in ("finished", "event")


def test_a_parameter_without_a_value():
    eom = line(-kn.parameter("stiff") * x)
    with pytest.raises(kn.ValueMissingError, match=r"every parameter, got none for stiff: pass parameters=\{…\}"):
        kn.simulate(eom, (0, 1), q=[1], u=[0])


def test_the_disk_at_rest_on_its_contact_is_told_of_slip():
    """Neither the friction's direction nor Painlevé's ratio has a value without slip: the slip is what is named."""
    disk = rolling_disk.model()
    eom = kn.derive(disk.system)
    with pytest.raises(kn.SimulationError, match="onset of rolling"):
        kn.simulate(eom, (0, 1), q=[0, 0.3, 0, 0, 0], u=[0, 0, 0, 0, 0])


def test_events_that_do_not_end_the_motion_are_recorded():
    """x = cos t crosses zero at π/2, 3π/2, 5π/2; falling only at the first and third."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    load = kn.Force(P, -x * N.x)
    both = kn.Event("zero", x, terminal=False)
    falling = kn.Event("down", x, direction=-1, terminal=False)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", loads=[load], events=[both, falling]))
    sol = kn.simulate(eom, (0, 9), q=[1], u=[0])
    assert sol.status == "finished"
    assert sol.event is None
    times = [t for e, t in sol.events if e.name == "zero"]
    np.testing.assert_allclose(times, np.pi * np.array([0.5, 1.5, 2.5]), atol=1e-7)
    np.testing.assert_allclose([t for e, t in sol.events if e.name == "down"], [times[0], times[2]], atol=1e-12)
