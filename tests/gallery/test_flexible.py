# SPDX-License-Identifier: BSD-3-Clause
"""Systems of the gallery with flexible beams: their motions keep what they must, and go to those of rigid ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import load

LOOPS = ("flexible_slider_crank", "flexible_four_bar")
TREES = (
    "rotating_beam",
    "flexible_pendulum",
    "flexible_spacecraft",
    "flexible_satellite",
    "flap_lag_blade",
    "flexible_arm",
)


def moved(name: str, end: float, **more: Any) -> tuple[kn.Equations, kn.Solution]:
    """A motion from the module's start, or from a little deformation and some speed."""
    module = load(name)
    eom = kn.derive(module.system(**more))
    start = getattr(module, "START", None)
    if start is None:
        rng = np.random.default_rng(17)
        start = {
            "q": {q: 0.003 * rng.standard_normal() for q in eom.coordinates},
            "u": {u: 0.1 * rng.standard_normal() for u in eom.speeds},
        }
    if name in LOOPS:
        at = kn.assemble(eom, **start)
        start = {"q": at.q, "u": at.u}
    return eom, kn.simulate(eom, (0, end), samples=21, rtol=1e-9, atol=1e-11, **start)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
@pytest.mark.parametrize("name", [*TREES, *LOOPS])
def test_energy_and_work(name: str, form: str) -> None:
    _, sol = moved(name, 0.2, form=form)
    assert sol.energy_check.relative < 1e-7


@pytest.mark.parametrize("name", ["flexible_spacecraft", pytest.param("flexible_satellite", marks=pytest.mark.slow)])
def test_the_spacecraft_keep_their_momenta(name: str) -> None:
    eom, sol = moved(name, 2.0)
    origin = eom.system.points[0]
    for vector in (eom.linear_momentum(), eom.angular_momentum(origin)):
        rows = np.array([sol[x] for x in vector.components(eom.system.inertial)])
        assert np.ptp(rows, axis=1).max() < 1e-8 * np.abs(rows).max()


@pytest.mark.slow
def test_the_loops_stay_closed() -> None:
    _, sol = moved("flexible_four_bar", 0.1)
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-10
    assert np.abs(sol["v1_link"]).max() > 1e-5
