# SPDX-License-Identifier: BSD-3-Clause
"""Work load by load along a motion."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulum

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def test_works_make_up_the_kinetic_energy():
    """Σ of the works of all loads is ΔK where nothing is prescribed."""
    eom = kn.derive(pendulum.system())
    motion = kn.simulate(eom, (0, 2), q=[1.2], u=[0.4], samples=401)
    total = sum(motion.load_works[load] for load in motion.load_works)
    kinetic = motion[eom.kinetic_energy]
    assert total == pytest.approx(kinetic - kinetic[0], abs=1e-7 * kinetic.max())
    gravity = eom.system.gravities[0]
    assert motion.load_works["gravity"] is motion.load_works[gravity]
    assert np.ptp(motion.load_works["gravity"]) > 0


def test_a_push_in_closed_form():
    """F = sin t on a mass of 2 kg from rest: v = (1 − cos t)/2, W = m v²/2."""
    x = kn.coordinate("x")
    bead = kn.Particle("bead", O.at("B", x * N.x), 2.0)
    push = kn.Force(bead.point, kn.sin(kn.time) * N.x, "push")
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", loads=[push]))
    motion = kn.simulate(eom, (0, 3), q=[0], u=[0], samples=301)
    assert motion.load_works[push] == pytest.approx((1 - np.cos(motion.t)) ** 2 / 4, abs=1e-9)
    few = kn.simulate(eom, (0, 0.02), q=[0], u=[0], samples=3)
    assert few.load_works["push"][-1] == pytest.approx((1 - np.cos(0.02)) ** 2 / 4, rel=0.3)
