# SPDX-License-Identifier: BSD-3-Clause
"""Pulses and barriers of loads that lie within a step: the step is taken again, up to them."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x")
v = kn.speed("v")
P = O.at("P", x * N.x)
at, width = kn.parameter("at", 3.0), kn.parameter("w", 0.5)


def line(force):
    """A particle of 1 kg on a line."""
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, force * N.x)]))


WALL = line(-0.2 / width * kn.where(kn.less((x - at) ** 2, (width / 2) ** 2), 1.0, 0.0))
PULSE = line(kn.where(kn.less((kn.time - at) ** 2, (width / 2) ** 2), 1 / width, 0.0))
SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    "method", ["DOP853", "RK23", *(pytest.param(m, marks=SLOW) for m in ("RK45", "Radau", "BDF", "LSODA"))]
)
@pytest.mark.parametrize("seed", range(5))
def test_walls_and_pulses_anywhere_are_felt(method, seed):
    """A wall takes 0.2 J of 0.5 J, a pulse gives 1 m/s, however thin they are beside the steps that the rest of the way needs."""
    rng = np.random.default_rng(seed)
    values = {at: rng.uniform(1, 9), width: 10 ** rng.uniform(-2, 0)}
    given = {"q": [0], "method": method, "rtol": 1e-7, "atol": 1e-7, "samples": 2, "parameters": values}
    through = kn.simulate(WALL, (0, 14), u=[1], **given)
    assert through["v"][-1] == pytest.approx(np.sqrt(0.6), abs=1e-4)
    kicked = kn.simulate(PULSE, (0, 14), u=[0], **given)
    assert kicked["v"][-1] == pytest.approx(1, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("unit", [1e6, 1e-6])
def test_units_do_not_matter(unit):
    wall = line(-0.2 * unit**2 / width * kn.where(kn.less((x - at) ** 2, (width / 2) ** 2), 1.0, 0.0))
    values = {at: 3.0 * unit, width: 0.1 * unit}
    sol = kn.simulate(wall, (0, 14), q=[0], u=[unit], parameters=values, rtol=1e-7, atol=1e-7 * unit, samples=2)
    assert sol["v"][-1] == pytest.approx(np.sqrt(0.6) * unit, rel=1e-4)
