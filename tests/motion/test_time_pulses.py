# SPDX-License-Identifier: BSD-3-Clause
"""Smooth pulses of time are not stepped over; and no motion whose energy is wrong passes the energy check."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.motion import bumps, bumps_of, pulses
from tests.examples import examples

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
u, v = kn.speeds("u v")
F = kn.input("F")
PARAMETERS = kn.parameters("k k3 c a1 w1 f1 a2 w2 r2 a3 t3 s3 m3")
k, k3, c, a1, w1, f1, a2, w2, r2, a3, t3, s3, m3 = PARAMETERS
P, Q = O.at("P", x * N.x), O.at("Q", y * N.x)
PULSE = a3 * kn.exp(-(((kn.time - t3) / s3) ** 2))
DRIVE = a1 * kn.sin(w1 * kn.time + f1) + a2 * kn.sin((w2 + r2 * kn.time) * kn.time) + PULSE


def line(force):
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={u: x.dt}, loads=[kn.Force(P, force * N.x)]))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "dop853", "tsitpap8", "tsit5", "DOP853"])
@pytest.mark.parametrize("width", [0.3, 0.02])
def test_a_smooth_pulse_on_a_free_way_is_felt(method, width):
    """A pulse of √π · 20 · width N s on 1 kg that nothing else moves, in a load, as an input and as a function."""
    eom, driven = line(PULSE), line(F)
    values = {a3: 20.0, t3: 6.3, s3: width}
    given = {"q": [0], "u": [0], "method": method, "samples": 2}
    motions = [kn.simulate(eom, (0, 10), parameters=values, **given)]
    motions.append(kn.simulate(driven, (0, 10), inputs={F: PULSE}, parameters=values, **given))
    if method in ("dop853", "DOP853") and width > 0.1:
        motions.append(
            kn.simulate(driven, (0, 10), inputs={F: lambda t: 20 * np.exp(-(((t - 6.3) / width) ** 2))}, **given)
        )
    for sol in motions:
        assert sol["u"][-1] == pytest.approx(np.sqrt(np.pi) * 20 * width, rel=1e-6)
        assert sol.steps < 300


def test_where_pulses_are():
    values = {a1: 1.0, w1: 3.0, f1: 0.0, a3: 2.0, t3: 5.0, s3: 0.1, k: 2.0}
    terms = pulses([k * x + a1 * kn.sin(w1 * kn.time + f1) - x * PULSE])
    found = sorted(bumps(terms, values, (0, 10)))
    assert len(found) == 3  # the sine is none
    assert found[1] == pytest.approx(5, abs=0.005)
    assert found == pytest.approx([5 - 0.372, 5, 5 + 0.372], abs=0.01)
    assert bumps(pulses([kn.sin(kn.time), kn.time**2, kn.time, k * kn.time + x]), values, (0, 10)) == set()
    # what has corners is looked into
    assert pulses([kn.where(kn.less(kn.time, a1), PULSE, x) * kn.abs(k * kn.time)]) == (PULSE, k * kn.time)
    assert bumps_of(lambda t: 1 / (t - 5), (0, 10)) == set()
    assert bumps_of(lambda t: 0 * t + 3, (0, 10)) == set()


BOTH = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("p", P, 1), kn.Particle("q", Q, m3)],
        speeds={u: x.dt, v: y.dt},
        loads=[kn.Force(P, (DRIVE - k * x - k3 * x**3 - c * u) * N.x), kn.linear_spring(P, Q, k, 0)],
    )
)
STEPS, DIGITS, MOST = 1e3, 1e-5, 0.1


@given(seed=st.integers(0, 2**32 - 1))
@examples(0.4, least=4)
def test_no_motion_with_a_wrong_energy_passes(seed):
    """Driven by sines, chirps and pulses of 5 ms to 1 s, free or on springs, at tolerances of 1e-9 to 1e-2, beside a run at 1e-12."""
    rng = np.random.default_rng(seed)
    values = {
        k: rng.choice([0.0, rng.uniform(0.1, 30)]), k3: rng.choice([0.0, rng.uniform(0, 3)]), c: rng.uniform(0, 0.5),
        a1: rng.choice([0, rng.normal() * 3]), w1: rng.uniform(0, 20), f1: rng.uniform(0, 7),
        a2: rng.choice([0, rng.normal()]), w2: rng.uniform(0, 3), r2: rng.uniform(0, 2),
        a3: rng.choice([0, rng.normal() * 20]), t3: rng.uniform(1, 9), s3: 10 ** rng.uniform(-2.3, 0), m3: rng.uniform(0.3, 3),
    }  # fmt: skip
    given = {"q": rng.normal(size=2), "u": rng.normal(size=2), "parameters": {p: float(z) for p, z in values.items()}}
    tolerance, method = 10 ** rng.uniform(-9, -2), str(rng.choice(["gauss16", "dop853", "tsitpap8", "tsit5", "RK45"]))
    exact = {"rtol": 1e-12, "atol": 1e-12, "method": "dop853", "max_step": 0.02}
    true = kn.simulate(BOTH, (0, 10), samples=201, **given, **exact)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sol = kn.simulate(BOTH, (0, 10), samples=201, rtol=tolerance, atol=tolerance, method=method, **given)
    wrong = np.abs(sol.energy - true.energy).max() / max(np.abs(true.energy).max(), np.abs(true.work).max())
    assert told or wrong <= 10 * min(max(STEPS * tolerance, DIGITS), MOST)
