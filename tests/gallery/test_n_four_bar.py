# SPDX-License-Identifier: BSD-3-Clause
"""N four-bar linkages: sizes, and the aligned position as a start."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import kane as kn
from kane.gallery import n_four_bar


@pytest.mark.parametrize("n", [1, 3, 6])
def test_one_degree_of_freedom(n: int) -> None:
    eom = kn.derive(n_four_bar.system(n))
    assert len(eom.system.bodies) == 2 * n + 1
    assert len(eom.independent_speeds) == 1
    assert eom.redundant == ()


def test_no_window() -> None:
    with pytest.raises(kn.ModelError, match="at least one window, got 0"):
        n_four_bar.system(0)


@pytest.mark.slow
def test_it_can_start_aligned() -> None:
    """Where the constraints lose rank the motion starts all the same, as parallelograms if it is told so by its speeds."""
    eom = kn.derive(n_four_bar.system())
    q = [-pi / 2] * 3 + [0.0] * 2
    sol = kn.simulate(eom, (0, 0.3), q=q, u=[-6.0] * 3 + [0.0] * 2, rtol=1e-11, atol=1e-11)
    assert sol.status == "finished"
    assert [event.name for event, _ in sol.events][:1] == ["rank of the constraints drops"]
    assert sol.energy_check.relative < 1e-6
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-10
