# SPDX-License-Identifier: BSD-3-Clause
"""Motions under tables of time and of the state: code, derivatives, jumps that steps end at."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import kane as kn
from kane.motion import breakpoints

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
v = kn.speed("v")
m, k = kn.parameter("m", 2.0), kn.parameter("k", 3.0)
F = kn.input("F")
P = O.at("P", x * N.x)


def line(force):
    system = kn.System(N, bodies=[kn.Particle("P", P, m)], speeds={v: x.dt}, loads=[kn.Force(P, force * N.x)])
    return kn.derive(system)


STEPS = kn.table([0.0, 5.0, 5.02], [0.0, 7.0, 0.0], "steps", name="pulse")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "given"),
    [
        (STEPS(kn.time), {}),
        (F, {"inputs": {F: STEPS}}),
        (F, {"inputs": {F: STEPS(kn.time)}}),
        (F, {"inputs": {F: kn.where(kn.less(kn.time, 5), 0, kn.where(kn.less(kn.time, 5.02), 7, 0))}}),
        (7 * kn.where(kn.less(5, kn.time), 1, 0) * kn.where(kn.less(kn.time, 5.02), 1, 0), {}),
        (kn.where(kn.less(kn.abs(kn.time - 5.01), k / 300), 7, 0), {}),
        (
            3.5
            * (1 + kn.sign(kn.sin(kn.pi * (kn.time - 5) / 0.02)))
            * kn.where(kn.less(kn.abs(kn.time - 5.01), 0.015), 1, 0),
            {},
        ),
    ],
)
@pytest.mark.parametrize("method", ["auto", "RK45"])
def test_a_pulse_gives_its_impulse(force, given, method):
    """20 ms of 10 s, written in any way, are not stepped over."""
    sol = kn.simulate(line(force), (0, 10), q=[0], u=[0], samples=11, method=method, **given)
    assert sol.u[-1, 0] == pytest.approx(7 * 0.02 / 2, rel=1e-9)
    assert sol.status == "finished"


@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_a_table_of_time_is_integrated_exactly(kind):
    t, y = np.linspace(0, 4, 9), np.random.default_rng(1).normal(size=9)
    table = kn.table(t, y, kind)
    sol = kn.simulate(line(F), (0, 4), q=[0], u=[0], inputs={F: table}, samples=5)
    whole = np.trapezoid(y, t) if kind == "linear" else CubicSpline(t, y).integrate(0, 4)
    assert sol.u[-1, 0] == pytest.approx(whole / 2, abs=1e-10)
    assert np.array_equal(sol[F], table(sol.t))


def test_a_force_over_the_position():
    """½ m v² = ∫ F dx, and a corner is passed by the tolerances."""
    places, values = [0.0, 0.5, 1.0, 2.0], [1.0, 3.0, 0.0, 2.0]
    for kind in ("linear", "cubic"):
        table = kn.table(places, values, kind, name="p")
        sol = kn.simulate(line(table(x)), (0, 3), q=[0], u=[0], samples=31)
        at = sol.q[:, 0]
        inside = np.clip(at, 0, 2)
        fine = [np.linspace(0, a, 20_001) for a in inside]
        work = np.array([np.trapezoid(table(a), a) for a in fine]) + 2 * (at - inside)
        assert sol.u[:, 0] ** 2 == pytest.approx(work, rel=1e-6, abs=1e-9)
        assert sol.method == "dop853"  # the ends of a table are corners
        assert sol.energy_check.relative < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["linear", "cubic", "periodic", "steps"])
def test_code_and_its_derivatives(kind):
    places = np.array([-1.0, 0.0, 0.7, 2.0])
    table = kn.table(places, [1.0, 3.0, 0.5, 1.0], kind)
    eom = line(table(x) * k - table.derivative()(x + v))
    states = np.random.default_rng(2).uniform(-4, 4, (50, 2))
    states = np.vstack([states, np.column_stack([places, np.full(4, 0.3)])])
    rates = eom.evaluate(list(eom.accelerations), q=[states[:, 0]], u=[states[:, 1]])[0]
    for options in ({}, {"contract": False}):
        code = eom.compile(**options)
        own = code.rhs(0.0, states)[:, 1]
        # with contraction off the arithmetic is that of NumPy, but for the order of terms
        assert np.allclose(own, rates, rtol=1e-12, atol=1e-12)
        columns = eom.evaluate([kn.diff(eom.accelerations[0], s) for s in (x, v)], q=[states[:, 0]], u=[states[:, 1]])
        assert np.allclose(code.jac(0.0, states)[:, 1], np.column_stack(columns), rtol=1e-12, atol=1e-12)
    module: dict = {}
    exec(eom.compile().emit("numpy"), module)  # noqa: S102
    assert np.allclose(module["rhs"](0.0, states, np.array([2.0, 3.0]))[..., 1], rates, rtol=1e-12, atol=1e-12)
    assert ("floor(" in eom.compile().emit("c")) == (kind == "periodic")


def test_linear_tables_have_corners_and_cubic_ones_none():
    for kind in ("linear", "cubic"):
        table = kn.table([-1, 0, 1], [1, 0, 3], kind)
        eom = line(-table(x) - v)
        if kind == "cubic":
            assert kn.linearize(eom, q=[0], u=[0]).A[1, 0] == pytest.approx(-float(table.derivative()(0)) / 2)
            continue
        with pytest.raises(kn.CornerError, match=r"table\(x\)"):
            kn.linearize(eom, q=[0], u=[0])
        assert kn.linearize(eom, q=[0], u=[0], side={x: 1}).A[1, 0] == pytest.approx(-1.5)
        assert kn.linearize(eom, q=[0], u=[0], side={x: -1}).A[1, 0] == pytest.approx(0.5)


def test_a_table_that_moves_something():
    """A prescribed motion takes the table's own derivatives; one that jumps is refused."""
    A = O.at("A", F * N.y)
    Q = A.at("Q", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("Q", Q, m)], speeds={v: x.dt}, loads=[kn.Force(Q, -k * x * N.x)]))
    t = np.linspace(0, 3, 8)
    table = kn.table(t, np.sin(t), "cubic")
    sol = kn.simulate(eom, (0.1, 2.9), q=[1], u=[0], inputs={F: table}, samples=9)
    assert np.allclose(sol[F.dt], table.derivative()(sol.t), rtol=1e-12)
    assert sol.energy_check.relative < 1e-8
    with pytest.raises(kn.SimulationError, match="without jumps"):
        kn.simulate(eom, (0, 3), q=[1], u=[0], inputs={F: kn.table([0, 1.03, 2], [0, 1, 2], "steps")})


def test_breakpoints_are_those_of_time_alone():
    t = kn.time
    linear = kn.table([0, 1, 3], [0, 1, 0])
    wave = kn.table([0, 1, 2, 3], [0, 1, 2, 0], "periodic")
    cases = [
        (linear(2 * t), (0.5, 1.5)),
        (kn.abs(t - k), (3.0,)),
        (linear(t + x), ()),
        (wave(t), (1.0, 2.0, 3.0, 4.0)),
        (kn.max(t, 2), (2.0,)),
        (kn.sign(kn.cos(kn.pi * t)), (0.5, 1.5, 2.5, 3.5, 4.5)),
        (kn.less(t * t, k), (3**0.5,)),
        (kn.less(k, m), ()),
    ]
    for root, wanted in cases:
        assert breakpoints([root], {m: 2.0, k: 3.0}, (0.0, 5.0)) == pytest.approx(wanted, abs=1e-13)
