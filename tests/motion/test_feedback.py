# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that follow from the state: expressions, functions of Python, sampled controllers."""

import gc
import os
import pickle
import threading

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are

import kane as kn
from kane.gallery import pendulum_on_cart
from kane.motion import Sampled
from kane.program import CompiledRoutine
from tests.lanes import SMOOTH

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
v, w = kn.speeds("v w")
m, c = kn.parameter("m", 2.0), kn.parameter("c", 0.5)
F, G = kn.input("F"), kn.input("G")
P = O.at("P", x * N.x + y * N.y)
EOM = kn.derive(
    kn.System(N, bodies=[kn.Particle("P", P, m)], speeds={v: x.dt, w: y.dt}, loads=[kn.Force(P, F * N.x + G * N.y)])
)
START = {"q": [1, 0], "u": [0, 0.5], "samples": 21}
K = np.array([[3.0, 0.2, 0.7, 0.0], [0.1, 2.0, 0.0, 0.9]])
CLOSED = np.block([[np.zeros((2, 2)), np.eye(2)], [-K / 2]])


def exact(t):
    return np.array([expm(CLOSED * s) @ [1, 0, 0, 0.5] for s in t])


STATE = np.array([x, y, v, w], dtype=object)
LAWS = {
    "expressions": {F: -(3 * x + 0.2 * y + 0.7 * v), G: -(0.1 * x + 2 * y + 0.9 * w)},
    "matrix": {(F, G): -K @ STATE},
    "names": {("F", "G"): list(-K @ STATE)},
    "parameters": {F: -(6 * c * x + 0.2 * y + 0.7 * v), G: -(0.1 * x + m * y + 0.9 * w)},
    "function": {(F, G): lambda t, x: -K @ x},
    "functions": {F: lambda t, x: -K[0] @ x, G: lambda t, x: -K[1] @ x},
    "mixed": {F: lambda t, x: -K[0] @ x, G: -(0.1 * x + 2 * y + 0.9 * w)},
}


def test_laws_in_the_order_of_the_inputs():
    laws = [lambda t, x: -K[0] @ x, kn.sampled(lambda t, x: 2.0, 0.5)]
    one, other = (
        kn.simulate(EOM, (0, 1), inputs=given, **START) for given in (laws, dict(zip((F, G), laws, strict=True)))
    )
    assert np.array_equal(one.states, other.states)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("method", ["auto", "DOP853", "Radau"])
def test_linear_feedback_is_an_exponential(law, method):
    tight = {"rtol": 1e-8, "atol": 1e-8} if method == "Radau" else {}
    sol = kn.simulate(EOM, (0, 4), inputs=LAWS[law], method=method, **START, **tight)
    assert np.abs(sol.states - exact(sol.t)).max() < (1e-6 if method == "Radau" else 1e-8)
    assert np.allclose(sol[[F, G]], -(K @ sol.states.T), rtol=1e-12)
    assert sol.energy_check.relative < (1e-5 if method == "Radau" else 1e-8)
    if method == "auto":
        native = law in ("expressions", "matrix", "names", "parameters")
        assert sol.method in (SMOOTH if native else ("dop853",))
    if method == "Radau":
        assert sol.steps < 400


def test_a_law_is_kept_by_pickles_and_files(tmp_path):
    sol = kn.simulate(EOM, (0, 1), inputs=LAWS["matrix"], **START)
    sol.save(tmp_path / "run.npz")
    for again in (pickle.loads(pickle.dumps(sol)), kn.load_solution(tmp_path / "run.npz", EOM)):
        assert np.array_equal(again["F"], sol[F])


def zero_order_hold(period, end):
    """The same controller on the exact discrete motion."""
    a, b = np.zeros((4, 4)), np.zeros((4, 2))
    a[:2, 2:], b[2:] = np.eye(2), np.eye(2) / 2
    whole = expm(np.block([[a, b], [np.zeros((2, 6))]]) * period)
    states = [np.array([1, 0, 0, 0.5])]
    for _ in range(round(end / period)):
        states.append(whole[:4, :4] @ states[-1] + whole[:4, 4:] @ (-K @ states[-1]))
    return np.array(states)


@pytest.mark.parametrize("method", ["auto", "gauss16", "tsitpap8", "vern9", "tsit5", "Radau"])
def test_a_sampled_controller_holds_its_values(method):
    control = kn.sampled(lambda t, x: -K @ x, period=0.1)
    sol = kn.simulate(EOM, (0, 2), inputs={(F, G): control}, method=method, **START)
    assert np.abs(sol.states - zero_order_hold(0.1, 2)).max() < 1e-8
    assert sol.method == {"auto": "dop853"}.get(method, method)
    # at the end nothing is asked any more
    assert np.allclose(np.array(sol[[F, G]]).T[:-1], (-sol.states @ K.T)[:-1], atol=1e-8)
    between = kn.simulate(
        EOM, (0, 2), inputs={(F, G): control}, **{**START, "samples": np.array([0.05, 0.1, 0.149, 0.199])}
    )
    assert between[F][2] == between[F][3] == between[F][4]
    assert between[F][1] == between[F][0] != between[F][2]
    assert between.energy_check.relative < 1e-8


def test_a_controller_with_a_state_of_its_own():
    """PI control of the velocity; its integral is begun anew by every motion."""

    def control(t, x, z):
        e = 1.0 - x[2]
        z = z + 0.05 * e
        return 2 * e + 3 * z, z

    inputs = {F: kn.sampled(control, 0.05, state=0.0), G: 0}
    one, two = (kn.simulate(EOM, (0, 3), inputs=inputs, **START) for _ in range(2))
    assert np.array_equal(one.states, two.states)
    u, z, x_ = 0.0, 0.0, 1.0
    for _ in range(60):
        e = 1 - u
        z += 0.05 * e
        f = (2 * e + 3 * z) / 2
        x_, u = x_ + 0.05 * u + f * 0.05**2 / 2, u + 0.05 * f
    assert one.u[-1, 0] == pytest.approx(u, abs=1e-8)
    assert one.q[-1, 0] == pytest.approx(x_, abs=1e-8)


def test_two_periods_and_constraints_and_breakpoints():
    asked = []

    def slow(t, x):
        asked.append(t)
        return 0.0

    inputs = {F: kn.sampled(slow, 0.3), G: kn.sampled(lambda t, x: -x[1], 0.1)}
    kn.simulate(EOM, (0.05, 1), inputs=inputs, breakpoints=[0.7], **START)
    assert asked == pytest.approx([0.05, 0.35, 0.65, 0.95])


def test_linear_quadratic_control_of_a_trimmed_point():
    eom = kn.derive(pendulum_on_cart.system(force=True))
    linear = kn.linearize(eom, q={"x": 0, "theta": np.pi}, u=[0, 0], inputs={"F": 0})
    gain = linear.B.T @ solve_continuous_are(linear.A, linear.B, np.eye(4), np.eye(1))
    up = np.array([0, np.pi, 0, 0])
    sol = kn.simulate(eom, (0, 30), q=[0.3, np.pi + 0.2], u=[0, 0], inputs={"F": lambda t, x: -gain @ (x - up)})
    law = -gain @ (np.array([*eom.coordinates, *eom.speeds]) - up)
    same = kn.simulate(eom, (0, 30), q=[0.3, np.pi + 0.2], u=[0, 0], inputs={("F",): law})
    assert np.abs(sol.states[-1] - up).max() < 1e-4
    assert np.abs(sol.states - same.states).max() < 1e-5
    assert sol.method == "dop853"
    assert same.method in SMOOTH


def test_gains_are_parameters_of_their_own():
    k = kn.parameter("k", 1.0)
    for given, wanted in (({}, 1.0), ({k: 3.0}, 3.0)):
        sol = kn.simulate(EOM, (0, 1), inputs={F: -k * x, G: 0}, parameters=given, **START)
        assert np.allclose(sol[F], -wanted * sol[x], rtol=1e-12)


def test_laws_against_scipy():
    """A law that is not linear, on its own right-hand side."""
    law = -kn.tanh(3 * x) - 0.3 * kn.abs(v) * v
    sol = kn.simulate(EOM, (0, 4), inputs={F: law, G: 0}, **START)

    def rates(t, s):
        return [s[1], (-np.tanh(3 * s[0]) - 0.3 * abs(s[1]) * s[1]) / 2]

    own = solve_ivp(rates, (0, 4), [1, 0], rtol=1e-11, atol=1e-12, t_eval=sol.t)
    assert np.abs(sol.q[:, 0] - own.y[0]).max() < 1e-7


def simulate(**inputs):
    given = {F: 0, G: 0} | {kn.input(k): f for k, f in inputs.items()}
    return kn.simulate(EOM, (0, 1), inputs=given, **START)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (
            lambda t, x: [1, 2],
            r"Expected 1 number from the function of the state for F, got an array of shape \(2,\) at t = 0\. ",
        ),
        (lambda t, x: np.nan, r"Expected finite numbers .* for F, got nan at t = 0\. "),
        (lambda t, x: "much", r"Expected numbers .* for F, got 'much' at t = 0\. Return plain numbers"),
        (
            lambda t, x: 1 / 0,
            r"got ZeroDivisionError from it at t = 0, x = \[1\. .*\]: division by zero\. It is called as f\(t, x\)",
        ),
        (lambda t, x: x[7], r"got IndexError from it at t = 0"),
        (lambda t, x, z, more: 0, r"A function of time and state takes these two, f\(t, x\)"),
        (x.dt, r"Expected the input F as .* got the expression x' with x' \(Rate\)"),
        (kn.input("H") * x, r"with H \(Input\)"),
        (kn.sampled(lambda t, x: [1, 2], 0.1), r"Expected 1 number .* for F, got an array of shape \(2,\)"),
        (kn.sampled(lambda t, x: np.inf if t > 0.35 else 0, 0.1), r"Expected finite numbers .* at t = 0\.4\."),
        (kn.sampled(lambda t, x: 1.0, 0.1, state=0.0), r"got TypeError from it at t = 0.*with a state as f\(t, x, z\)"),
        (
            kn.sampled(lambda t, x, z: 1.0, 0.1, state=0.0),
            r"Expected the value and the next state, \(value, z\), .* got 1\.0 at t = 0",
        ),
        (kn.sampled(lambda t, x: 1.0, 1e-9), r"at most 1e\+07 periods of the sampled controller for F"),
    ],
)
def test_laws_that_are_none(law, said):
    with pytest.raises(kn.SimulationError, match=said):
        simulate(F=law)


def test_calls_that_are_none():
    with pytest.raises(
        kn.SimulationError, match=r"Expected a period > 0 of a sampled controller, got 0\. It is a time in s"
    ):
        kn.sampled(lambda t, x: 0, 0)
    with pytest.raises(kn.SimulationError, match="period"):
        kn.sampled(lambda t, x: 0, -0.1)
    with pytest.raises(kn.SimulationError, match=r"finite period"):
        kn.sampled(lambda t, x: 0, np.nan)
    for period in ("a", "0.1", True, None, np.inf, [0.1, 0.2]):
        with pytest.raises(
            kn.SimulationError, match=r"finite period > 0 of a sampled controller, got .*a time in s, such as"
        ):
            kn.sampled(lambda t, x: 0, period)
    lost = kn.sampled(lambda t, s, z: (0.0, z + np.sqrt(0.5 - t) if t < 0.45 else np.nan), 0.1, state=1.0)
    with pytest.raises(
        kn.SimulationError,
        match=r"next state without NaN from the sampled controller for F, got nan after .* at t = 0\.5",
    ):
        kn.simulate(EOM, (0, 1), inputs={F: lost, G: 0}, **START)
    unset = kn.sampled(lambda t, s, z: (0.0, z), 0.1, state=np.nan)  # one that says "none yet" is the user's
    assert kn.simulate(EOM, (0, 1), inputs={F: unset, G: 0}, **START).status == "finished"
    with pytest.raises(kn.SimulationError, match=r"Expected a function f\(t, x\) as a sampled controller, got 3"):
        kn.sampled(3, 0.1)
    with pytest.raises(kn.SimulationError, match=r"Expected 2 values for the inputs F, G, got \[1\]"):
        kn.simulate(EOM, (0, 1), inputs={(F, G): [1]}, **START)
    for twice in ({(F, G): lambda t, x: [1, 2], F: 5}, {F: 5, (G, F): [1, 2]}, {(F, F): [1, 2], G: 0}):
        with pytest.raises(
            kn.ValueMissingError, match=r"Expected one value for the input F, got two\. Leave one out\."
        ):
            kn.simulate(EOM, (0, 1), inputs=twice, **START)
    locked = kn.sampled(lambda t, x, z: (0.0, z), 0.1, state=threading.Lock())
    with pytest.raises(
        kn.SimulationError, match=r"state of the sampled controller for F that can be copied, .*got <.*lock"
    ):
        kn.simulate(EOM, (0, 1), inputs={F: locked, G: 0}, **START)
    with pytest.raises(kn.ValueMissingError, match=r"got one for H|got one for 'H'"):
        kn.simulate(EOM, (0, 1), inputs={(F, "H"): [1, 2], G: 0}, **START)
    with pytest.raises(
        kn.SimulationError, match=r"runs in machine code .* inputs are functions of time or state in Python"
    ):
        kn.simulate(EOM, (0, 1), inputs=LAWS["function"], method="gauss16", **START)


BOB = O.at("B", x * N.x + y * N.y)
ROD = kn.System(
    N,
    bodies=[kn.Particle("bob", BOB, m)],
    speeds={v: x.dt, w: y.dt},
    loads=[kn.gravity(-9.81 * N.y), kn.Force(BOB, F * N.x + G * N.y)],
    holonomic=[kn.distance(O, BOB, 1)],
    events=[kn.Event("aside", x - 0.2, terminal=False), kn.Event("pulled", F + 2.5, terminal=False)],
)


@pytest.mark.parametrize(
    "law",
    [
        {F: -3 * v + kn.cos(3 * kn.time), G: -2 * w},
        {F: kn.sampled(lambda t, x: -3 * x[2] + np.cos(3 * t), 0.1), G: -2 * w},
        pytest.param({F: kn.sampled(lambda t, x: -3 * x[2], 0.1), G: lambda t: np.cos(t)}, marks=pytest.mark.slow),
        {F: lambda t, x: -3 * x[2] + np.cos(3 * t), G: -2 * w},
        pytest.param({F: -3 * v + kn.cos(3 * kn.time), G: lambda t: 0.2 * np.cos(t)}, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    "method", ["dop853", *(pytest.param(name, marks=pytest.mark.slow) for name in ("gauss16", "vern9"))]
)
def test_feedback_beside_constraints_and_events_runs_in_machine_code(law, method):
    """Events see the inputs, too; a function of Python alone keeps lanes from running."""
    if method == "gauss16" and any(callable(one) and not isinstance(one, Sampled) for one in law.values()):
        method = "auto"
    eom = kn.derive(ROD)
    start = {"q": [0.8, -0.6], "u": [0, 0], "samples": 21, "inputs": law}
    sol = kn.simulate(eom, (0, 1.7), **start, method=method)
    own = kn.simulate(eom, (0, 1.7), **start, method="DOP853", rtol=1e-11, atol=1e-11)
    assert sol.method == ("dop853" if method == "auto" else method)
    assert np.abs(sol.states - own.states).max() < 1e-6
    names = {e.name for e in eom.events}  # equations with other dependent speeds have events of their own
    met, wanted = ([(e.name, t) for e, t in motion.events if e.name in names] for motion in (sol, own))
    assert [name for name, _ in met] == [name for name, _ in wanted] != []
    assert [t for _, t in met] == pytest.approx([t for _, t in wanted], abs=1e-6)
    assert np.allclose(sol[F], own[F], atol=1e-6)


@pytest.mark.parametrize("method", ["auto", "Radau", "vern9", "radau9"])
def test_an_expression_of_the_state_beside_a_function_of_time_is_asked_at_the_stages(method):
    """ẍ = −1.5 x beside ÿ = cos t/2: the function is asked in Python, where the state of a stage must be known, too."""
    sol = kn.simulate(EOM, (0, 3), inputs={F: -3 * x, G: lambda t: np.cos(t)}, method=method, **START)
    assert np.abs(sol.q[:, 0] - np.cos(np.sqrt(1.5) * sol.t)).max() < 1e-7
    assert np.abs(sol.u[:, 1] - 0.5 - np.sin(sol.t) / 2).max() < 1e-7
    assert sol.method == {"auto": "dop853"}.get(method, method)
    with pytest.raises(kn.SimulationError, match="inputs are functions of time or state in Python"):
        kn.simulate(EOM, (0, 3), inputs={F: -3 * x, G: lambda t: np.cos(t)}, method="gauss16", **START)


def test_a_stiff_function_of_the_state_is_gone_on_with_in_machine_code():
    """ẍ = −x − 10⁵ ẋ beside ÿ = −y: Radau's collocation asks Python for the slopes of the law too."""
    law = {(F, G): lambda t, s: (-2 * s[0] - 2e5 * s[2], -2 * s[1])}
    sol = kn.simulate(EOM, (0, 4), inputs=law, **START)
    assert sol.method == "dop853, radau9"
    assert sol.steps < 2500
    own = kn.simulate(EOM, (0, 4), inputs=law, method="radau9", **START)
    slow, fast = np.roots([1, 1e5, 1]).max(), np.roots([1, 1e5, 1]).min()
    for motion in (sol, own):
        expected = (-fast * np.exp(slow * motion.t) + slow * np.exp(fast * motion.t)) / (slow - fast)
        assert np.abs(motion.q[:, 0] - expected).max() < 1e-8
        assert np.abs(motion.q[:, 1] - np.sin(motion.t) / 2).max() < 1e-7
    assert own.steps < 120


@pytest.mark.parametrize("method", ["dop853", "tsit5", "rk4", "midpoint", "radau9"])
def test_what_goes_wrong_in_a_law_comes_out_of_machine_code(method):
    """With its place, of whatever kind it is; NaN and infinity are named."""
    given = START | {"method": method} | ({"max_step": 0.01} if method in ("rk4", "midpoint") else {})

    def wrong(t, s):
        return 1 / 0 if t > 1 else 0.0

    with pytest.raises(kn.SimulationError, match=r"got ZeroDivisionError from it at t = 1\.\d*, x = \["):
        kn.simulate(EOM, (0, 3), inputs={F: wrong, G: -y}, **given)
    with pytest.raises(kn.SimulationError, match=r"Expected finite numbers .* for G, got inf at t = 1\."):
        kn.simulate(EOM, (0, 3), inputs={F: -x, G: lambda t, s: np.inf if t > 1 else 0.0}, **given)

    def stopped(t, s):
        if t > 1:
            raise KeyboardInterrupt
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        kn.simulate(EOM, (0, 3), inputs={F: stopped, G: 0}, **given)


def test_many_periods_are_asked_one_by_one():
    asked = []

    def control(t, x):
        asked.append(t)
        return -x[0]

    sol = kn.simulate(EOM, (0, 4), inputs={F: kn.sampled(control, 1e-3), G: 0}, **START)
    assert sol.method == "dop853"
    assert asked == pytest.approx(np.arange(4000) * 1e-3)
    assert np.abs(sol.q[:, 0] - np.cos(sol.t / np.sqrt(2))).max() < 1e-2


def test_what_prescribes_a_motion_does_not_follow_from_the_state():
    A = O.at("A", F * N.y)
    Q = A.at("Q", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("Q", Q, m)], speeds={v: x.dt}))
    for law in (lambda t, x: 0.0, kn.sampled(lambda t, x: 0.0, 0.1)):
        with pytest.raises(
            kn.SimulationError, match=r"Expected the input F as a function of time with its derivatives"
        ):
            kn.simulate(eom, (0, 1), q=[0], u=[0], inputs={F: law})
    with pytest.raises(kn.SimulationError, match=r"with v \(Speed\)"):
        kn.simulate(eom, (0, 1), q=[0], u=[0], inputs={F: v})


@pytest.mark.parametrize("inner", ["kane", "scipy"])
def test_one_lsoda_inside_another_is_named(inner):
    """SciPy's LSODA keeps what it is at in one place: the outer motion ends, and says so; other methods nest."""

    def law(t, x):
        if inner == "scipy":
            return -solve_ivp(lambda t, y: -y, (0, 0.1), [1.0], method="LSODA").y[0, -1]
        return -kn.simulate(EOM, (0, 0.1), inputs={F: 0, G: 0}, method="LSODA", **START).q[-1, 0]

    sol = kn.simulate(EOM, (0, 1), inputs={F: law, G: 0}, method="LSODA", **START)
    assert sol.status == "stopped"
    assert "runs LSODA itself: use another method for one of them" in sol.message
    assert "singular" not in sol.message
    assert kn.simulate(EOM, (0, 0.2), inputs={F: law, G: 0}, method="RK45", **START).status == "finished"


def compiled_routines():
    """How many compiled routines there are in this process."""
    gc.collect()
    return sum(isinstance(thing, CompiledRoutine) for thing in gc.get_objects())


CART = kn.derive(pendulum_on_cart.system(force=True))
FORMS = {
    "linear": lambda k, s: k[0] * s[0] + k[1] * s[1] + k[2] * s[2] + k[3] * s[3],
    "differences": lambda k, s: -(k[0] * (s[0] - k[1]) - k[2] * s[2]) / k[3],
    "saturated": lambda k, s: (
        kn.max(kn.min(k[0] * s[0] - k[1] * s[1] ** 3, k[2]), -k[2] - 9) + k[3] * kn.sin(k[1] * kn.time)
    ),
    "switched": lambda k, s: kn.where(kn.less(s[1], k[0]), k[1] * kn.tanh(s[2] / 3), k[2] * s[3]) + k[3],
}


@pytest.mark.grows
@pytest.mark.parametrize("method", ["gauss16", *(pytest.param(m, marks=pytest.mark.slow) for m in ("radau9", "tsit5"))])
@pytest.mark.parametrize(
    "form", [pytest.param(f, marks=[pytest.mark.slow] * (f in ("differences", "switched"))) for f in FORMS]
)
def test_laws_that_differ_in_numbers_share_what_is_compiled(form, method, rng):
    """Of either sign: as many routines after the last law as after the first; and the motion of each is that of its own numbers."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    count = (200 if form == "linear" else 30) if "KANE_FULL" in os.environ else 4
    start = {"q": [0.3, 0.2], "u": [0.0, 0.0], "samples": 3, "method": method}
    after = []
    for k in range(count):
        gains = rng.uniform(-2, 2, 4)
        law = FORMS[form](gains, eom.state)
        sol = kn.simulate(eom, (0, 0.05), inputs={"F": law}, **start)
        assert np.allclose(
            sol["F"], kn.evaluate(law, {**dict(zip(eom.state, sol.states.T, strict=True)), kn.time: sol.t}), rtol=1e-12
        )
        if k % 100 == 0:
            other = kn.simulate(
                CART,
                (0, 0.05),
                inputs={"F": lambda t, x, law=law: kn.evaluate(law, numbers_at(t, x))},
                **start | {"method": "DOP853"},
            )
            assert np.allclose(sol.states, other.states, rtol=1e-6, atol=1e-8)
        if k in (1, count - 1):
            after.append(compiled_routines())
    stiff = int(method == "radau9")  # another of the stiff method's own, once it is needed
    # and of a law that switches what the other side takes: inputs, their derivatives and what is watched
    assert after[1] - after[0] <= stiff + (2 + stiff) * (form == "switched")


def numbers_at(t, x):
    return {**dict(zip(CART.state, x, strict=True)), kn.time: t}


@pytest.mark.slow
def test_laws_of_different_forms_are_kept_to_a_bound():
    """Each is another expression: what is compiled for the first ones goes when others come."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    x, theta, *_ = eom.state
    law, counts = kn.Rational(0) + x, []
    for k in range(90):
        law = law.sin() + theta
        kn.simulate(eom, (0, 0.001), q=[0.3, 0.2], u=[0, 0], inputs={"F": law}, samples=2, method="tsit5")
        if k in (0, 9, 63, 75, 89):
            counts.append(compiled_routines())
    assert counts[1] == counts[0] + 9
    assert counts[2:] == [counts[0] + 63] * 3
