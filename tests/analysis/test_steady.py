# SPDX-License-Identifier: BSD-3-Clause
"""What speeds depend on is read off numbers in which rounding leaves traces; these count for nothing."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis.steady import dependence
from tests.systems.turning_disk import disk


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-14])
def test_rounding_makes_no_coordinate_matter(noise):
    """x' = u, and u' holds x by rounding alone: balanced with the chain that leads back, both would be the root of it."""
    assert dependence(np.array([[0.0, 1.0], [noise, 0.0]]), 1).tolist() == [False, True]
    assert dependence(np.array([[0.0, 1.0, 0.0], [noise, 0.0, -2.0], [0.0, 1.0, 0.0]]), 1).tolist() == [
        False,
        True,
        True,
    ]


def test_units_make_no_coordinate_cyclic():
    """A spring of 1 N/m in Mm, Mg and hours, or in mm: what holds x is small beside the rest, and is no rounding."""
    for small in (1.0, 1e-6, 1e-9):
        assert dependence(np.array([[0.0, 1.0], [-small, 0.0]]), 1).all()


def test_an_upright_disk_is_steady_whatever_its_dependent_speeds():
    """They turn with it and change; what is independent does not. Of a thin disk that leans and yaws ω² = 12/5 Ω² − 4/5 g/R."""
    eom = kn.derive(disk())
    for spin in (0.2, 1.0, 1.5, 2.2, 3.0):
        q = dict(zip(("yaw", "lean", "spin", "x", "y"), (0.3, 0.0, spin, 0.0, 0.0), strict=True))
        state = kn.assemble(eom, q=q, rates={"yaw": 0.0, "lean": 0.0, "spin": 5.0})
        linear = kn.linearize(eom, q=state.q, u=state.u)
        found = np.sort(np.abs(np.linalg.eigvals(linear.A).imag))[-2:]
        np.testing.assert_allclose(found, np.sqrt(12 / 5 * 25 - 4 / 5 * 9.81 / 0.3), rtol=1e-9)
        assert set(linear.cyclic) == {"yaw", "spin", "x", "y"}
