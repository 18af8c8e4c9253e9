# SPDX-License-Identifier: BSD-3-Clause
"""The double pendulum is the chain of two links; its equations are held to textbooks in tests/literature."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, pendulums


@pytest.mark.slow
@pytest.mark.parametrize("bobs", [False, True])
@pytest.mark.parametrize("relative", [False, True])
def test_it_is_the_chain_of_two_links(relative: bool, bobs: bool) -> None:
    for speeds in double_pendulum.SPEEDS:
        one = kn.derive(double_pendulum.system(relative=relative, bobs=bobs, speeds=speeds))
        two = kn.derive(pendulums.system(2, relative=relative, bobs=bobs, speeds=speeds))
        assert all(a is b for a, b in zip(one.right_hand_side, two.right_hand_side, strict=True))


def test_simple_pendulum_where_the_second_particle_is_light() -> None:
    """θ̈₁ = −(g/l₁) sin θ₁ at m₂ = 0, whatever the light particle does."""
    eom = kn.derive(double_pendulum.system(bobs=True))
    q, u = np.random.default_rng(5).uniform(-2, 2, (2, 2, 20))
    light = {"m2": 1e-14, "l1": 0.7}
    found = eom.evaluate(eom.accelerations, q=q, u=u, parameters=light)[0]
    np.testing.assert_allclose(found, -9.81 / 0.7 * np.sin(q[0]), rtol=1e-10)


def test_slow_mode() -> None:
    """Small motions in the slow mode keep the ratio θ₂/θ₁ = √2 of two equal particles."""
    eom = kn.derive(double_pendulum.system(bobs=True))
    start = 1e-5
    period = 2 * np.pi / np.sqrt(9.81 * (2 - np.sqrt(2)))
    sol = kn.simulate(eom, (0, period), q=[start, np.sqrt(2) * start], u=[0, 0], rtol=1e-10, atol=1e-17)
    np.testing.assert_allclose(sol["q2"], np.sqrt(2) * sol["q1"], atol=1e-7 * start)
    np.testing.assert_allclose(sol["q1"], start * np.cos(2 * np.pi * sol.t / period), atol=1e-7 * start)
