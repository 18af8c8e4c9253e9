# SPDX-License-Identifier: BSD-3-Clause
"""Events in steps whose ends are moved onto the constraints: none is lost, none is met twice."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.motion import crossings
from kane.numeric import SHARES


def met(kept, dense, direction=0):
    """Times at which the quantity, `kept` at the ends of a step from 0 to 1 and a + b t between, passes zero."""
    event = kn.Event("zero", kn.time, 0.0, direction)
    times = np.array(SHARES)
    values = np.array([kept[0], *(dense[0] + dense[1] * times[1:-1]), kept[1]])[:, None]
    found = crossings([event], lambda t: np.array([dense[0] + dense[1] * t, 0.0]), times, values, np.zeros(1), {})
    return [t for _, t in found]


@pytest.mark.parametrize(
    ("kept", "dense", "expected"),
    [
        ((1.0, -1.0), (1.0, -2.0), [0.5]),
        ((1e-9, -1.0), (-1e-9, -1.0), [0.0]),
        ((1.0, -1e-9), (1.0, -1 + 1e-9), [1.0]),
        ((1.0, 0.0), (1.0, -1.0), [1.0]),
        ((0.0, -1.0), (0.0, -1.0), []),
        ((1.0, 1e-9), (1.0, -1 - 1e-9), []),
    ],
)
def test_the_states_kept_decide_what_is_met(kept, dense, expected):
    """An end that projection moves across the threshold is the place itself."""
    assert met(kept, dense) == pytest.approx(expected)
    assert met(kept, dense, -1) == pytest.approx(expected)
    assert met(kept, dense, 1) == []


@pytest.mark.parametrize(
    "method", ["DOP853", "Radau", *(pytest.param(m, marks=pytest.mark.slow) for m in ("RK23", "BDF", "LSODA"))]
)
def test_every_turn_of_a_pendulum_is_counted_once(method):
    """x² + y² = 1: a turning pendulum passes x = 0 twice a turn, however far projection moves the steps' ends."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    p = O.at("p", x * N.x + y * N.y)
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("p", p, 1)],
            speeds="rates",
            holonomic=kn.distance(p, O, 1),
            events=[kn.Event("across", x, terminal=False)],
        )
    )
    sol = kn.simulate(eom, (0, 40), q=[1, 0], u=[0, 1], rtol=1e-4, atol=1e-4, method=method)
    times = [t for e, t in sol.events if e.name == "across"]
    angle = np.unwrap(np.arctan2(sol["y"], sol["x"]))
    np.testing.assert_allclose(np.interp(times, sol.t, angle), np.pi / 2 + np.pi * np.arange(len(times)), atol=0.02)
    assert len(times) == int((angle[-1] + np.pi / 2) / np.pi)
