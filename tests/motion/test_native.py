# SPDX-License-Identifier: BSD-3-Clause
"""Motions in machine code are those of SciPy's solvers, and stop where these do."""

import pickle
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.errors import SimulationError
from kane.gallery import pendulums
from tests.examples import examples
from tests.lanes import SMOOTH
from tests.motion.steppers.runs import spring

NATIVE = ["gauss16", "dop853", "tsitpap8", "vern9", "radau9"]
WATCHES = NATIVE


@pytest.fixture(scope="module")
def pendulum():
    return kn.derive(pendulums.system(2))


def simulated(eom, method, **more):
    return kn.simulate(eom, (0, 3), q=[1.0, 2.0], u=[0.5, 0.0], method=method, samples=31, **more)


@pytest.mark.parametrize("method", NATIVE)
def test_a_motion_is_scipys(method, pendulum):
    """At 1e-12 they differ by less than 1e-10; so they do where steps end at a breakpoint, and where the end is no sample."""
    reference = simulated(pendulum, "DOP853", rtol=1e-12, atol=1e-12)
    for more in ({}, {"breakpoints": [0.7, 1.0]}):
        sol = simulated(pendulum, method, rtol=1e-12, atol=1e-12, **more)
        assert sol.method == method
        assert sol.status == "finished"
        assert np.array_equal(sol.t, reference.t)
        assert sol.states == pytest.approx(reference.states, abs=1e-10)
        assert not sol.energy_check.exceeds(1e-12)
    few = kn.simulate(
        pendulum, (0, 3), q=[1.0, 2.0], u=[0.5, 0.0], method=method, rtol=1e-12, atol=1e-12, samples=[1.0]
    )
    assert few.t.tolist() == [0, 1, 3]
    assert few.states == pytest.approx(reference.states[[0, 10, 30]], abs=1e-10)


@pytest.mark.parametrize("method", NATIVE)
def test_work_and_constant_inputs_are_there(method):
    """A force F on a mass of 1 kg: x = F t²/2, and F x is the work."""
    N = kn.Frame("N")
    x, F = kn.coordinate("x"), kn.input("F")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, F * N.x)], speeds="rates"))
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: 3}, method=method)
    np.testing.assert_allclose(sol.q[:, 0], 1.5 * sol.t**2, rtol=1e-13, atol=1e-13 * 24)
    np.testing.assert_allclose(sol.work, 4.5 * sol.t**2, rtol=1e-13, atol=1e-13 * 72)
    assert kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: 3}, method="auto").method in NATIVE


def pushed():
    """A mass of 1 kg under a force F along x."""
    N = kn.Frame("N")
    x, F = kn.coordinate("x"), kn.input("F")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, F * N.x)], speeds="rates")), F


def test_inputs_in_python_are_asked_at_the_stages():
    """F = cos 3t; a spline to its very ends; a jump at a breakpoint, which no stage before it sees. Collocation does not ask."""
    eom, F = pushed()
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: lambda t: np.cos(3 * t)})
    assert sol.method == "dop853"
    assert sol.u[:, 0] == pytest.approx(np.sin(3 * sol.t) / 3, abs=1e-9)
    t = np.linspace(0, 4, 9)
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: kn.signal(t, t**3)})
    assert sol.u[-1, 0] == pytest.approx(64, rel=1e-9)
    jump = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: lambda t: float(t >= 1.5)}, breakpoints=[1.5])
    assert jump.u[-1, 0] == pytest.approx(2.5, rel=1e-12)
    assert jump.work[-1] == pytest.approx(2.5**2 / 2, rel=1e-12)
    for method in ("gauss16", "tsitpap8"):
        told = (
            rf'method="{method}", got one in which inputs are functions of time or state in Python\. Use method="auto"'
        )
        with pytest.raises(SimulationError, match=told):
            kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: np.sin}, method=method)


@pytest.mark.slow
@pytest.mark.parametrize("method", NATIVE)
def test_inputs_are_expressions_of_time_and_parameters(method):
    """F = a cos 3t, evaluated in machine code, a with its value; as a function of Python it gives the same motion."""
    eom, F = pushed()
    m = kn.parameter("m", 2.0)
    heavy = eom.system.replace(bodies=[kn.Particle("P", eom.system.bodies[0].point, m)])
    eom = kn.derive(heavy)
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: m * kn.cos(3 * kn.time)}, parameters={m: 5}, method=method)
    assert sol.method == method
    assert sol.u[:, 0] == pytest.approx(np.sin(3 * sol.t) / 3, abs=1e-9)
    assert sol[F] == pytest.approx(5 * np.cos(3 * sol.t), rel=1e-12, abs=1e-12)
    assert kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: kn.cos(kn.time)}).method in SMOOTH
    assert kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: abs(kn.cos(kn.time))}).method == "dop853"
    with pytest.raises(
        SimulationError,
        match=r"input F as .* an expression of time, coordinates, .* got the expression 2\*x' with x' \(Rate\)",
    ):
        kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: eom.coordinates[0].dt * 2}, method=method)


@pytest.mark.slow
@pytest.mark.parametrize("method", [*NATIVE, "DOP853"])
def test_a_prescribed_motion_is_an_expression(method):
    """A pivot that is moved by r = 0.1 sin 2t: its velocity and acceleration are derived; a pendulum hangs on it."""
    N = kn.Frame("N")
    q, r = kn.coordinate("q"), kn.input("r")
    A = N.rotate("A", q, N.z)
    P = kn.Point("O", fixed_in=N).at("S", r * N.x).at("P", -A.y)
    system = kn.System(N, bodies=[kn.Particle("P", P, 1)], loads=[kn.gravity(-9.81 * N.y)], speeds="rates")
    eom = kn.derive(system)
    own = kn.simulate(eom, (0, 3), q=[0.3], u=[0], inputs={r: 0.1 * kn.sin(2 * kn.time)}, method=method)
    functions = tuple(lambda t, k=k: 0.1 * 2**k * np.sin(2 * t + k * np.pi / 2) for k in range(3))
    other = kn.simulate(eom, (0, 3), q=[0.3], u=[0], inputs={r: functions}, method="DOP853")
    assert own.method == method
    assert own.states == pytest.approx(other.states, abs=1e-7)
    assert own.work == pytest.approx(other.work, abs=1e-7)


def test_what_goes_wrong_in_an_input_is_raised():
    """At the place where it does, an interrupt too; a value that is none ends the motion before it."""
    eom, F = pushed()

    def broken(t):
        return 1 / (t < 2)

    def interrupted(t):
        if t > 2:
            raise KeyboardInterrupt
        return 1.0

    with pytest.raises(SimulationError, match=r"input F, got ZeroDivisionError from it at t = 2"):
        kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: broken})
    with pytest.raises(KeyboardInterrupt):
        kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: interrupted})
    sol = kn.simulate(eom, (0, 4), q=[0], u=[0], inputs={F: lambda t: 1.0 if t < 2 else np.nan})
    assert sol.status == "stopped"
    assert 1.9 < sol.t[-1] < 2
    assert np.isfinite(sol.states).all()


@pytest.mark.parametrize("method", NATIVE)
def test_limits_are_kept(method, pendulum):
    """So many steps and no more, though the kernel takes them by the thousand; so much time; none longer than asked for."""
    sol = simulated(pendulum, method, max_steps=7)
    assert (sol.status, sol.steps) == ("stopped", 7)
    assert "7 steps were not enough; at t = " in sol.message
    assert sol.t[-1] == pytest.approx(float(sol.message.split()[-1]), rel=1e-5)
    assert simulated(pendulum, method, max_step=1e-3).steps == 3000
    late = kn.simulate(
        pendulum, (0, 1e9), q=[1.0, 2.0], u=[0.5, 0.0], method=method, max_seconds=0.05, max_steps=10**9, samples=2
    )
    assert "max_seconds=0.05 have passed" in late.message
    slow = kn.simulate(pendulum, (0, 1e9), q=[1.0, 2.0], u=[0.5, 0.0], method=method, samples=2)
    assert "10000 steps advanced from t = 0 to" in slow.message


def singular(exponent):
    """x'' = 1/(2 − x)^exponent from rest at 0."""
    N = kn.Frame("N")
    x = kn.coordinate("x")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    load = kn.Force(p, (2 - x) ** exponent * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))


@pytest.mark.slow
@pytest.mark.parametrize("method", NATIVE)
@pytest.mark.parametrize("exponent", [-2, 0.5])
def test_what_breaks_off_says_where_and_why(method, exponent):
    """A pole, and the root of what becomes negative: the solution ends before, as by SciPy's DOP853, and no number is NaN."""
    eom = singular(exponent)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        ends = {m: kn.simulate(eom, (0, 10), q=[0], u=[0.5], method=m) for m in (method, "DOP853")}
    own, other = ends[method], ends["DOP853"]
    assert own.status == other.status == "stopped"
    assert own.t[-1] == pytest.approx(other.t[-1], rel=1e-4)
    assert np.isfinite(own.states).all()
    told = "changes fastest" if exponent == -2 else "(2 - x) = nan|x - 2|not finite"
    assert f"singular or not finite near t = {own.t[-1]:.6g}" in own.message
    assert any(part in own.message for part in told.split("|")), own.message


@pytest.mark.parametrize("method", NATIVE)
def test_rounding_of_time_does_not_add_up(method):
    """A million steps of 1e-3 end at 1000 s exactly, and the spring's phase is right to what its own steps leave."""
    sol = kn.simulate(spring(), (0, 1000), q=[1], u=[0], method=method, max_step=1e-2, samples=2)
    assert 0 <= sol.steps - 100_000 <= (method == "radau9")  # whose first step is shorter
    assert sol.q[-1, 0] == pytest.approx(np.cos(1000), abs=1e-12)


def test_a_pickle_keeps_the_method(pendulum):
    sol = simulated(pendulum, "auto")
    assert pickle.loads(pickle.dumps(sol)).method == sol.method


def test_methods_that_are_none_are_named(pendulum):
    with pytest.raises(SimulationError, match=r"Expected method to be one of auto, .*dop853.*, got 'euler'"):
        simulated(pendulum, "euler")
    with pytest.raises(SimulationError, match=r"Expected method to be one of auto, .*, got \['dop853'\]"):
        simulated(pendulum, ["dop853"])


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (lambda x, v: -x * (1 + x**2) - v, {"gauss16", "vern9"}),
        (lambda x, v: -x - abs(v) * v, {"dop853"}),
        (lambda x, v: kn.where(kn.less(x, 0), -100 * x, 0) - 1, {*SMOOTH}),
        (lambda x, v: kn.max(-100 * x, 0) - 1, {"dop853"}),
        (lambda x, v: -kn.exp(x), {"vern9"}),
    ],
)
def test_auto_takes_collocation_where_rates_are_smooth(force, expected):
    """Its estimate is a square, which no corner obeys; library functions are called lane by lane: Verner's method does not mind.

    Where loads switch, Python looks.
    """
    N = kn.Frame("N")
    x = kn.coordinate("x")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    load = kn.Force(p, force(x, x.dt) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))
    sol = kn.simulate(eom, (0, 2), q=[1], u=[0.3], rtol=1e-10, atol=1e-10, samples=11)
    assert sol.method in expected
    reference = kn.simulate(eom, (0, 2), q=[1], u=[0.3], rtol=1e-10, atol=1e-10, samples=11, method="DOP853")
    assert sol.states == pytest.approx(reference.states, abs=1e-7)
    loose = kn.simulate(eom, (0, 2), q=[1], u=[0.3], rtol=1e-7, atol=1e-7, samples=11)
    assert loose.method in {{"vern9": "tsitpap8"}.get(name, name) for name in expected}


def test_rates_of_time_are_not_asked_for_behind_the_end(pushed_until_two):
    """A stage of Tsitouras and Papakostas's method lies there, where √(2 − t) is none: auto takes it for rates of the state alone."""
    eom, F, x = pushed_until_two
    given = {"q": [0], "u": [0], "rtol": 1e-7, "atol": 1e-7}
    for law in (0, kn.sin(x)):
        assert kn.simulate(eom, (0, 2), inputs={F: law}, **given).method == "vern9"
    steady = kn.derive(eom.system.replace(loads=eom.system.loads[:1]))
    for law, method in ((0, "tsitpap8"), (kn.sin(x), "tsitpap8"), (kn.sin(kn.time), "vern9")):
        assert kn.simulate(steady, (0, 2), inputs={F: law}, **given).method == method
    own = kn.simulate(eom, (0, 2), inputs={F: 0}, **given)
    other = kn.simulate(eom, (0, 2), inputs={F: 0}, **(given | {"rtol": 1e-10, "atol": 1e-10}), method="radau9")
    assert own.states[-1] == pytest.approx(other.states[-1], rel=1e-5)


@pytest.fixture
def pushed_until_two():
    """A mass under F − exp x, and beside it √(2 − t)."""
    eom, F = pushed()
    (x,) = eom.coordinates
    p, N = eom.system.bodies[0].point, eom.system.inertial
    loads = [kn.Force(p, (F - kn.exp(x)) * N.x, name="drive"), kn.Force(p, kn.sqrt(2 - kn.time) * N.x, name="fades")]
    return kn.derive(eom.system.replace(loads=loads)), F, x


def thrown(*events):
    """A ball of 1 kg that is thrown upwards in air, x above the ground."""
    N = kn.Frame("N")
    x = kn.coordinate("x")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    load = kn.Force(p, -(9.81 + 0.02 * x.dt) * N.x)
    found = [kn.Event(name, make(x), **more) for name, make, more in events]
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates", events=found))


@pytest.mark.slow
@pytest.mark.parametrize("method", WATCHES)
@pytest.mark.parametrize("end", ["ceiling", "floor"])
def test_events_are_those_of_scipys_steps(method, end):
    """Passed twice, passed in one direction, at a threshold, and one that ends the motion; samples stand before it."""
    eom = thrown(
        ("half", lambda x: x - 2.5, {"terminal": False}),
        ("down", lambda x: x - 1, {"terminal": False, "direction": -1}),
        ("top", lambda x: x.dt, {"terminal": False, "threshold": 0.25}),
        ("ceiling", lambda x: 4.9 - x, {"terminal": end == "ceiling"}),
        ("floor", lambda x: x + 0.5, {}),
    )
    own, other = (kn.simulate(eom, (0, 9), q=[0], u=[10], method=m, rtol=1e-12, atol=1e-12) for m in (method, "DOP853"))
    assert (own.status, own.event.name) == ("event", end)
    assert own.message == other.message
    assert [e.name for e, _ in own.events] == [e.name for e, _ in other.events]
    assert [t for _, t in own.events] == pytest.approx([t for _, t in other.events], abs=1e-11)
    assert own.t[:-1].tolist() == other.t[:-1].tolist()
    assert own.t[-1] == pytest.approx(other.t[-1], abs=1e-11)
    assert own.states == pytest.approx(other.states, abs=1e-10)
    assert kn.simulate(eom, (0, 1), q=[0], u=[10]).method in NATIVE


@pytest.mark.parametrize("method", WATCHES)
def test_kinematics_end_where_they_end_for_scipy(method):
    """Body axes 1, 2, 3 turned to cos q2 = 0; and turned by it, at which W is far from it for most of the way."""
    N = kn.Frame("N")
    q1, q2, q3 = kn.coordinates("q1:4")
    B = N.rotate("A", q1, N.x)
    B = B.rotate("C", q2, B.y)
    B = B.rotate("B", q3, B.z)
    w = B.angular_velocity(N)
    u1, u2, u3 = kn.speeds("u1:4")
    O = kn.Point("O", fixed_in=N)
    body = kn.RigidBody("body", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    eom = kn.derive(kn.System(N, bodies=[body], speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)}))
    assert eom.events
    for u in ([0.0, 1.0, 0.0], [0.1, 1.0, 0.3]):
        own, other = (kn.simulate(eom, (0, 5), q=[0, 0, 0], u=u, method=m) for m in (method, "DOP853"))
        assert own.method == method
        assert own.status == other.status
        assert own.t[-1] == pytest.approx(other.t[-1], abs=1e-6)
        assert own.states[-2] == pytest.approx(other.states[-2], abs=1e-5)


def falling(quantity):
    """A ball thrown upwards at 10 m/s in vacuum, to 5.0968 m; quantity(x) vanishes at the event."""
    N = kn.Frame("N")
    x = kn.coordinate("x")
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    events = [kn.Event("met", quantity(x), terminal=False)]
    return kn.derive(
        kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, -9.81 * N.x)], speeds="rates", events=events)
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["auto", "dop853", "tsit5", "DOP853", "RK45"])
def test_a_ball_meets_the_ceiling_twice_however_near_the_top(method):
    """Both meetings lie in one step, a millisecond apart where the ceiling is a micrometre below the top."""
    for below in (0.1, 1e-3, 1e-6):
        half = (2 * below / 9.81) ** 0.5
        eom = falling(lambda x, height=50 / 9.81 - below: x - height)
        sol = kn.simulate(eom, (0, 2), q=[0], u=[10], method=method, samples=2)
        assert [t for _, t in sol.events] == pytest.approx([10 / 9.81 - half, 10 / 9.81 + half], abs=1e-9)
    assert kn.simulate(falling(lambda x: x - 5.2), (0, 2), q=[0], u=[10], method=method).events == ()


def test_events_are_met_where_python_is_asked_for_inputs():
    """v = 2 cos 2t, x = sin 2t by a function of time; rates with corners watch too."""
    eom, F = pushed()
    (x,) = eom.coordinates
    events = [kn.Event("half", x - 0.5, terminal=False), kn.Event("drag", x + 0.8)]
    eom = kn.derive(eom.system.replace(events=events))
    sol = kn.simulate(eom, (0, 9), q=[0], u=[2], inputs={F: lambda t: -4 * np.sin(2 * t)}, rtol=1e-11, atol=1e-11)
    assert (sol.method, sol.event.name) == ("dop853", "drag")
    half, end = np.arcsin(0.5), np.pi + np.arcsin(0.8)
    assert [t for _, t in sol.events] == pytest.approx([half / 2, (np.pi - half) / 2, end / 2], abs=1e-9)
    drag = kn.Force(eom.system.bodies[0].point, -abs(x.dt) * x.dt * eom.system.inertial.x)
    bent = kn.derive(eom.system.replace(loads=[*eom.system.loads, drag]))
    own, other = (kn.simulate(bent, (0, 9), q=[0], u=[2], inputs={F: -1}, method=m) for m in ("auto", "DOP853"))
    assert own.method == "dop853"
    assert [t for _, t in own.events] == pytest.approx([t for _, t in other.events], abs=1e-7)


@pytest.fixture(scope="module")
def waves():
    """A point that moves at 1 m/s, and a sum of waves along its way."""
    N = kn.Frame("N")
    x, (a, b, k, l, c) = kn.coordinate("x"), kn.parameters("a b k l c", 1.0)
    p = kn.Point("O", fixed_in=N).at("P", x * N.x)
    events = [kn.Event("met", a * kn.sin(k * x) + b * kn.cos(l * x) + c, terminal=False)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], speeds="rates", events=events)), (a, b, k, l, c)


@given(st.integers(0, 2**32 - 1))
@examples(0.1)
def test_every_crossing_of_random_waves_is_met(waves, seed):
    """Up to fifteen waves of each kind in a step: as many crossings as of the closed form on a fine grid, at the same times."""
    eom, symbols = waves
    rng = np.random.default_rng(seed)
    values = [*rng.normal(size=2), *rng.uniform(0, 50, 2), rng.normal()]
    t = np.linspace(0, 2, 40_001)
    a, b, k, l, c = values
    f = a * np.sin(k * t) + b * np.cos(l * t) + c
    expected = t[:-1][f[:-1] * f[1:] < 0]
    given_ = dict(zip(symbols, values, strict=True))
    for method in ("auto", "dop853", "DOP853"):
        sol = kn.simulate(eom, (0, 2), q=[0], u=[1], parameters=given_, method=method, samples=2)
        assert [time for _, time in sol.events] == pytest.approx(expected.tolist(), abs=1e-4)
