# SPDX-License-Identifier: BSD-3-Clause
"""Tables of the state in motions: in machine code, where they bend and beside what jumps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kane as kn
from kane.expr import leaps
from kane.motion import has_jumps, quantities, unfit

N = kn.Frame("N")
x, v = kn.coordinate("x"), kn.speed("v")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)


def line(force, **more):
    loads = [kn.Force(P, force * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads, **more))


@pytest.mark.parametrize("kind", ["linear", "cubic", "periodic", "steps"])
def test_what_leaps_is_a_table_of_steps_alone(kind):
    table = kn.table([-1, 0, 1, 2], [1, 0.5, -2, 1], kind)
    assert leaps(table.op) is (kind == "steps")
    assert leaps(table.derivative().op) is (kind in ("linear", "cubic"))
    assert has_jumps(line(table(x))) is (kind == "steps")


def test_a_table_of_two_lines_is_a_half_turn_of_each_spring():
    """x'' = −x for x > 0 and −4 x for x < 0: half periods π and π/2, and another wall of slope beyond."""
    eom = line(kn.table([-9, 0, 9], [36, 0, -9], "linear")(x))
    period = 1.5 * np.pi
    sol = kn.simulate(eom, (0, 20 * period), q=[0], u=[1], samples=np.arange(21) * period, rtol=1e-11, atol=1e-11)
    assert sol.method == "dop853"
    assert sol["x"] == pytest.approx(np.zeros(21), abs=1e-8)
    assert sol["v"] == pytest.approx(np.ones(21), abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["linear", "cubic", "periodic"])
def test_tables_that_bend_run_beside_what_jumps(kind, rng):
    """A random table and dry friction: against SciPy's steps of NumPy's interpolation, between two turns of the friction's sign."""
    places, values = np.linspace(-2, 2, 9), rng.normal(size=9)
    values[-1] = values[0]
    table = kn.table(places, values, kind)
    eom = line(table(x) - 20 - 0.3 * kn.sign(v))
    assert len(quantities(eom)) == 1
    assert not unfit(eom)
    sol = kn.simulate(eom, (0, 0.9), q=[-3], u=[12], samples=10, rtol=1e-10, atol=1e-10)
    assert sol.method == "dop853"

    def rate(t, y):
        return [y[1], float(table(y[0])) - 20 - 0.3 * np.sign(y[1])]

    def turned(t, y):
        return y[1]

    turned.terminal = True
    tight = {"rtol": 1e-11, "atol": 1e-11, "max_step": 2e-3}
    up = solve_ivp(rate, (0, 0.9), [-3, 12], events=turned, **tight)
    down = solve_ivp(rate, (up.t[-1], 0.9), [up.y[0, -1], -1e-14], **tight)
    assert sol["x"][-1] == pytest.approx(down.y[0, -1], abs=1e-7)
    assert sol["v"][-1] == pytest.approx(down.y[1, -1], abs=1e-7)


def test_steps_of_the_state_are_left_to_scipy_and_told():
    eom = line(kn.table([0, 1, 2], [0, -1, -2], "steps")(x))
    assert kn.simulate(eom, (0, 1), q=[0.5], u=[0], samples=2).method == "DOP853"
    with pytest.raises(kn.SimulationError, match="loads or inputs jump by tables of steps"):
        kn.simulate(eom, (0, 1), q=[0.5], u=[0], method="dop853")
