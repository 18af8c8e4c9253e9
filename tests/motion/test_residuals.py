# SPDX-License-Identifier: BSD-3-Clause
"""Constraints that a motion leaves: it stops there and names one; those that agree let it go on."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
P = O.at("P", x * N.x + y * N.y)
r = kn.input("r")

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*depend on each other", "ignore:.*some configuration satisfies", "ignore:.*speeds can satisfy together"
)


def driven(kind, first, second):
    """A particle with two drives along x, of which one is redundant if both say the same."""
    system = kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", **{kind: [first, second]})
    return kn.derive(system)


@pytest.mark.slow
@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
def test_two_drives_that_drift_apart(unit):
    """x = sin t and x = t: apart by t³/6, of which each is left half."""
    eom = driven("holonomic", x - unit * kn.sin(kn.time), x - r)
    drive = (lambda t: unit * t, lambda t: unit, lambda t: 0.0)
    sol = kn.simulate(eom, (0, 2.5), q=[0, 0], u=[unit, 0], inputs={r: drive}, atol=1e-9 * unit, samples=3)
    assert sol.status == "stopped"
    assert "'holonomic 1' is violated by" in sol.message or "'holonomic 2' is violated by" in sol.message
    assert "leave one out, or correct it" in sol.message
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 2e-8 * unit
    assert sol.t[-1] == pytest.approx((12 * 1e-8) ** (1 / 3), rel=0.2)


def test_two_drives_of_a_motion_constraint():
    eom = driven("nonholonomic", x.dt - kn.cos(kn.time), x.dt - r)
    drive = (lambda t: 1.0, lambda t: 0.0, lambda t: 0.0)
    sol = kn.simulate(eom, (0, 2), q=[0, 0], u=[1, 0], inputs={r: drive}, samples=3)
    assert sol.status == "stopped"
    assert "is violated by" in sol.message
    assert 0 < sol.t[-1] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_random_drives_that_agree_up_to_some_order(seed):
    """The same polynomial, the second with c tᵏ more; with c = 0 the motion goes on to its end."""
    rng = np.random.default_rng(seed)
    drive = np.polynomial.Polynomial(rng.normal(size=4))
    apart = float(rng.normal()) if seed % 3 else 0.0
    other = drive + apart * np.polynomial.Polynomial([0.0] * int(rng.integers(3, 6)) + [1.0])
    t = kn.time
    eom = driven("holonomic", x - sum(float(k) * t**i for i, k in enumerate(drive.coef)), x - r)
    given = {"q": [drive(0), 0], "u": [drive.deriv()(0), 0], "inputs": {r: (other, other.deriv(), other.deriv(2))}}
    sol = kn.simulate(eom, (0, 2), rtol=1e-7, atol=1e-7, samples=9, **given)
    assert sol.status == ("stopped" if apart else "finished")
    np.testing.assert_allclose(sol["x"], drive(sol.t), atol=1e-5)


def test_a_ring_that_shrinks_away_from_its_string():
    """|r| = 1 − t²/10 and |r| = 1: nothing at the start says that they contradict each other."""
    ring = kn.distance(P, O, 1, name="ring")
    system = kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", holonomic=[ring, x**2 + y**2 - (1 - r) ** 2])
    shrink = (lambda t: t**4 / 10, lambda t: 0.4 * t**3, lambda t: 1.2 * t**2)
    sol = kn.simulate(kn.derive(system), (0, 3), q=[1, 0], u=[0, 1], inputs={r: shrink}, samples=5)
    assert sol.status == "stopped"
    assert "'ring' is violated by" in sol.message or "'holonomic 2' is violated by" in sol.message
    assert sol.t[-1] < 0.1
