# SPDX-License-Identifier: BSD-3-Clause
"""A routine on lanes gives, lane by lane, what it gives of one state."""

import ctypes

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.expr import OPS
from kane.program import CompiledRoutine, Task, build_program, hoisted, wide_entry
from tests.program.programs import SPECIAL, ports

X, PARAMETERS, INPUTS = kn.coordinates("a b c"), kn.parameters("k l", 1.5), (kn.input("F"),)


def wide(routine, width, t, x, p, r):
    """Results (n × width) at times (width), states (n × width), inputs (n × width)."""
    code = wide_entry(routine, width)
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 6)(code.library.address(code.symbol))
    h, out = hoisted(routine, 0.0, x[:, 0], p, r[:, 0]), np.full((len(routine.labels), width), np.nan)
    arrays = [np.ascontiguousarray(v) for v in (t, x, p, r)]
    call(*(v.ctypes.data for v in (*arrays, h, out)))
    return out


def compiled(roots, contract):
    task = Task("all", roots, (len(roots),), [f"y{k}" for k in range(len(roots))])
    program = build_program("wide", ports(X, PARAMETERS, INPUTS), [task])
    return CompiledRoutine(program, "all", Settings(contract=contract, cache=False), not_finite="ignore")


def roots():
    """Every operation of the table, of states, parameters, time and inputs."""
    (a, b, c), (k, l) = X, PARAMETERS
    given = [a * l + b, b * k - c, c + kn.time]
    found = [kn.expr.intern_node(op, *given[: op.arity]) for op in OPS.values() if op.arity]
    return [*found, *given, k, k * l, kn.time, INPUTS[0] * a, a]


@pytest.mark.parametrize("width", [4, 8])
def test_lanes_are_independent(width, rng):
    """At special numbers and others, among them angles beyond the short reduction: the same bits, NaN where there is none."""
    routine = compiled(roots(), contract=False)
    p = np.array([0.3, -1.7])
    for _ in range(5):
        x, t = rng.choice([*SPECIAL, 3e5, 0.7, 2.1], (3, width)), rng.normal(size=width)
        r = rng.normal(size=(1, width))
        got = wide(routine, width, t, x, p, r)
        for j in range(width):
            expected = routine(t[j], x[:, j], p, r[:, j])
            assert np.array_equal(got[:, j], expected, equal_nan=True)


@pytest.mark.slow
def test_long_routines_are_cut(rng):
    """One of several pieces, which pass values on."""
    total, values = X[0], []
    for k in range(400):
        total = kn.sin(total + X[k % 3] * PARAMETERS[k % 2]) * X[(k + 1) % 3] + k
        values.append(total)
    routine = compiled([values[150], total], contract=True)
    x = rng.normal(size=(3, 8))
    got = wide(routine, 8, np.zeros(8), x, np.array([0.3, -1.7]), np.zeros((1, 8)))
    expected = np.array([routine(0.0, x[:, j], np.array([0.3, -1.7]), np.zeros(1)) for j in range(8)]).T
    assert got == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["linear", "cubic", "periodic", "steps"])
@pytest.mark.parametrize("width", [4, 8])
def test_tables_of_the_state_in_lanes(kind, width, rng):
    """Random tables of 4 to 60 points: each lane in a piece of its own, at the points, out of range, many periods on, and NaN."""
    for count in (4, 17, 60):
        places, values = np.cumsum(rng.uniform(0.01, 2, count)) - 5, rng.normal(size=count)
        values[-1] = values[0]  # so that it goes round
        table = kn.table(places, values, kind)
        a, b, c = X
        routine = compiled(
            [table(a), table(b * 2) * c, table.derivative()(a), table(kn.sin(c) + kn.time)], contract=False
        )
        reach = places[-1] - places[0]
        far = [places[0] - 1e-9, places[-1] + 1e-9, places[0] - 7.3 * reach, places[-1] + 113.7 * reach, 0.0, -0.0]
        for _ in range(6):
            x = rng.choice([*places, *far, *rng.uniform(places[0], places[-1], 20)], (3, width))
            if width == 8:
                x[:, 3] = np.nan
            got = wide(routine, width, np.full(width, 0.3), x, np.array([0.3, -1.7]), np.zeros((1, width)))
            one = np.array([routine(0.3, s, np.array([0.3, -1.7]), np.zeros(1)) for s in x.T]).T
            assert np.array_equal(got, one, equal_nan=True)
            # NumPy's interpolation takes the same operations in the same order
            wanted = np.array([table(x[0]), table(2 * x[1]) * x[2], table.derivative()(x[0])])
            known = ~np.isnan(wanted)
            assert np.array_equal(got[:3][known], wanted[known])
            if kind in ("cubic", "periodic"):  # what is constant in pieces is so beside NaN too
                assert np.isnan(got[:3][~known]).all()
                assert got[3] == pytest.approx(table(np.sin(x[2]) + 0.3), rel=1e-6, abs=1e-9, nan_ok=True)
