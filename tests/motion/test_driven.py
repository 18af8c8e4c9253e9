# SPDX-License-Identifier: BSD-3-Clause
"""Random driven systems against motions at 1e-12 that are told where drives begin and end: what is wrong is warned of."""

import math
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

END = 10.0
N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, th = kn.coordinate("x", "m"), kn.coordinate("th", "rad")
v, w = kn.speed("v", "m/s"), kn.speed("w", "rad/s")
F, T = kn.input("F", "N"), kn.input("T", "N*m")
PARAMETERS = [
    kn.parameter(name, 1.0, unit)
    for name, unit in zip(
        ["M", "m", "k", "c", "g", "d", "l"], ["kg", "kg", "N/m", "N*s/m", "m/s^2", "N*m*s", "m"], strict=True
    )
]
M, m, k, c, g, d, length = PARAMETERS
A = N.rotate("A", th, N.z)
CART = O.at("C", x * N.x)
BOB = CART.at("B", -length * A.y)
EOM = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("cart", CART, M), kn.Particle("bob", BOB, m)],
        speeds={v: x.dt, w: th.dt},
        loads=[
            kn.gravity(-g * N.y),
            kn.Force(CART, (F - k * x - c * v) * N.x),
            kn.Torque(A, (T - d * w) * N.z),
        ],
    )
)  # fmt: skip
BLOCK = kn.System(N, bodies=[kn.Particle("block", CART, 1)], speeds={v: x.dt}, loads=[kn.Force(CART, F * N.x)])
t = kn.time


def sine(rng, a):
    pace, phase = rng.uniform(0.2, 60), rng.uniform(0, 6)
    return a * kn.sin(pace * t + phase), []


def pulse(rng, a):
    """Over 3 ms to 3 s."""
    width = 10.0 ** rng.uniform(-2.5, 0.5)
    begin = rng.uniform(0.1, END - 0.1)
    return a / width * kn.where(kn.less(begin, t), kn.where(kn.less(t, begin + width), 1, 0), 0), [begin, begin + width]


def bump(rng, a):
    width, at = 10.0 ** rng.uniform(-1.7, 0), rng.uniform(0.5, END - 0.5)
    return a / width * kn.exp(-(((t - at) / width) ** 2)), list(at + width * np.linspace(-6, 6, 25))


def points(rng, a):
    kind = rng.choice(["linear", "cubic", "steps"])
    at = np.sort(rng.uniform(0, END, 8))
    return kn.table(at, a * rng.normal(size=8), str(kind)), at.tolist()


def function(rng, a):
    pace = rng.uniform(0.2, 20)
    return lambda s: a * math.sin(pace * s), []


def jumping(rng, a):
    """A function of Python that jumps there and back and tells nobody: it is warned of."""
    width, begin = rng.uniform(0.02, 2), rng.uniform(0.1, END - 0.1)
    return lambda s: a / width * (begin <= s < begin + width), [begin, begin + width]


def law(rng, a):
    return lambda s, y: -a * y[2] + math.cos(s), []


def feedback(rng, a):
    return -a * v + kn.cos(3 * t), []


def controller(rng, a):
    return kn.sampled(lambda s, y: -a * y[0], period=float(rng.uniform(0.03, 0.5))), []


DRIVES = (sine, pulse, bump, points, function, jumping, law, feedback, controller)


def motion(seed, **options):
    """The motion of a seed, whether anything was warned of, and when its drives begin and end."""
    rng = np.random.default_rng(seed)
    values = dict(
        zip(PARAMETERS, [*rng.uniform(0.5, 3, 2), 10.0 ** rng.uniform(-1, 2), *rng.uniform(0.1, 2, 4)], strict=True)
    )
    chosen = [DRIVES[i](rng, float(rng.normal())) for i in rng.integers(len(DRIVES), size=2)]
    start = {"q": rng.normal(size=2), "u": rng.normal(size=2), "parameters": values, "samples": 101}
    if "max_step" in options:
        options["breakpoints"] = sorted({s for _, times in chosen for s in times if 0 < s < END})
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sol = kn.simulate(
            EOM, (0, END), inputs=dict(zip((F, T), (one for one, _ in chosen), strict=True)), **start, **options
        )
    return sol, bool([s for s in said if issubclass(s.category, kn.KaneWarning)])


def off(seed, tolerance):
    """How far the motion at a tolerance is off, over its size; 0 where it was warned of."""
    sol, warned = motion(seed, rtol=tolerance, atol=tolerance)
    exact, _ = motion(seed, rtol=1e-12, atol=1e-12, max_step=0.05, method="dop853")
    assert (sol.status, exact.status) == ("finished", "finished")
    return 0.0 if warned else np.abs(sol.states - exact.states).max() / np.abs(exact.states).max()


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1))
@examples(0.4, least=8)
def test_what_is_wrong_is_warned_of(seed):
    assert off(seed, 1e-9) < 1e-6


@given(seed=st.integers(0, 2**32 - 1), tolerance=st.sampled_from([1e-3, 1e-4, 1e-6]))
@examples(0.4, least=4)
def test_at_loose_tolerances_it_is_off_by_some_of_them(seed, tolerance):
    assert off(seed, tolerance) < 300 * tolerance


def test_an_implicit_method_takes_over_where_a_period_of_a_controller_ends():
    """Stiffness that is noticed by the very steps that end at a breakpoint: the first step after it had no length."""
    assert off(27, 1e-3) < 0.1
    assert motion(27, rtol=1e-3, atol=1e-3)[0].method == "dop853, radau9"


def kernel_calls(run):
    """How often a motion calls its kernel, and what it returns."""
    count = 0

    def profile(frame, event, _):
        nonlocal count
        count += event == "call" and frame.f_code.co_qualname == "Bound.__call__"

    sys.setprofile(profile)
    try:
        return run(), count
    finally:
        sys.setprofile(None)


@pytest.mark.parametrize("method", ["gauss16", "dop853", "vern9", "rk4"])
def test_breakpoints_are_passed_within_the_kernel(method):
    """Steps of a force, by which the block's speed is a broken line."""
    eom, times = kn.derive(BLOCK), np.linspace(0.1, 1.9, 19)
    force = kn.table([0.0, *times], [float((-1) ** k) for k in range(20)], "steps")
    given = {"q": [0.0], "u": [0.0], "inputs": {F: force}, "method": method, "samples": 33}
    options = {"max_step": 0.02} if method == "rk4" else {}
    sol, count = kernel_calls(lambda: kn.simulate(eom, (0, 2), **given, **options))
    assert count <= 1 + sol.steps // 100  # so often it is asked whether steps are short for stability alone
    corners = np.concatenate([[0.0], np.cumsum([(-1) ** k * 0.1 for k in range(20)])])
    assert sol.u[:, 0] == pytest.approx(np.interp(sol.t, [0.0, *times, 2.0], corners), abs=1e-12)


def test_a_sampled_controller_is_all_that_is_asked():
    """Between two periods nothing of Python's runs but the controller."""
    eom = kn.derive(BLOCK)
    control = kn.sampled(lambda t, x: -4 * x[0] - 3 * x[1], 0.05)
    run = {"q": [1.0], "u": [0.0], "inputs": {F: control}, "method": "dop853", "samples": 2}
    sol, count = kernel_calls(lambda: kn.simulate(eom, (0, 20), **run))
    assert count <= 1 + sol.steps // 100
    x, v = np.array([1.0, 0.0])
    for _ in range(400):  # by hand
        f = -4 * x - 3 * v
        x, v = x + 0.05 * v + 0.05**2 / 2 * f, v + 0.05 * f
    assert sol.states[-1] == pytest.approx([x, v], abs=1e-12)
