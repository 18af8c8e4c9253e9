# SPDX-License-Identifier: BSD-3-Clause
"""The governor: steady precession by Watt's formula, its symmetry, and what both kinds of couplers share."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import flyball_governor


def test_steady_turning() -> None:
    """No acceleration where the moments about a hinge vanish, those of the slider's weight through the couplers included.

    With rods at α below level, x = e + r cos α the distances from the axis: Σ m ω² x r sin α = Σ m g r cos α + the slider's
    share; all four bars of a side equally long and its ends at e, the slider moves by 2 (l/2) d(sin α), so its share is
    M g/2 · 2 (l/2) cos α.
    """
    eom = kn.derive(flyball_governor.system())
    m, B, M, e, g, w, l = 0.3, 5.0, 3.0, 0.05, 9.81, 0.01, 1.0
    alpha = 0.9
    s, c = np.sin(alpha), np.cos(alpha)
    pull = (B * g * l + m * g * l / 2 + M * g * l / 2) * c
    # ∫ x z dm of a rod: m (e + l c/2) l s/2 + its central inertia, m (l² − w²)/12 s c
    throw = B * (e + l * c) * l * s + m * (e + l * c / 2) * l * s / 2 + m * (l * l - w * w) / 12 * s * c
    rate = np.sqrt(pull / throw)
    q = {"psi": 0.3, "alpha1": alpha, "alpha2": alpha, "s": l - 2 * (l / 2) * s}
    found = eom.evaluate(list(eom.accelerations), q=q, u=[rate, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(found, 0, atol=1e-10)


def test_both_sides_move_alike_and_spin_is_conserved() -> None:
    eom = kn.derive(flyball_governor.system())
    sol = kn.simulate(eom, (0, 3), rtol=1e-10, atol=1e-10, **flyball_governor.START)
    np.testing.assert_allclose(sol["alpha1"], sol["alpha2"], atol=1e-9)
    np.testing.assert_allclose(sol["s"], 1 - np.sin(sol["alpha1"]), atol=1e-12)
    N, O = eom.system.inertial, eom.points[0]
    spin = sol[eom.angular_momentum(O).dot(N.z)]
    np.testing.assert_allclose(spin, spin[0], rtol=1e-9)
    assert np.ptp(sol["s"]) > 0.1


def test_stiff_springs_come_near_rods() -> None:
    """The springs give by about force over stiffness, some 1e-4 m."""
    rods = kn.simulate(kn.derive(flyball_governor.system()), (0, 1), **flyball_governor.START)
    eom = kn.derive(flyball_governor.system(couplers="springs"))
    assert eom.system.constraints == ()
    springs = kn.simulate(eom, (0, 1), method="Radau", **flyball_governor.START)
    apart = np.abs(springs["s"] - rods["s"]).max()
    assert 1e-6 < apart < 5e-3


def test_other_couplers() -> None:
    with pytest.raises(kn.ModelError, match="'rods' or 'springs', got 'chains'"):
        flyball_governor.system(couplers="chains")  # type: ignore[arg-type]
