# SPDX-License-Identifier: BSD-3-Clause
"""Bricard's mechanism: which constraint is redundant is said, and leaving one out changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import bricard


def test_it_moves_though_it_could_not_by_count() -> None:
    eom = kn.derive(bricard.system())
    assert len(eom.coordinates) - len(eom.system.holonomic) == 1
    assert eom.redundant == ()
    sol = kn.simulate(eom, (0, 1), **bricard.START)
    assert np.ptp(sol["q1"]) > 1


@pytest.mark.slow
def test_the_hinge_whole_is_redundant() -> None:
    with pytest.warns(
        kn.KaneWarning, match="'last hinge x', .*depend on each other.*motion is determined nevertheless"
    ):
        whole = kn.derive(bricard.system(redundant=True))
    five = kn.simulate(whole, (0, 2), rtol=1e-10, atol=1e-10, **bricard.START)
    four = kn.simulate(kn.derive(bricard.system()), (0, 2), rtol=1e-10, atol=1e-10, **bricard.START)
    np.testing.assert_allclose(five.states, four.states, atol=1e-7)
    # What the four do not hold by name they hold all the same.
    assert np.abs(four[whole.system.holonomic[0].expr]).max() < 1e-9


def test_along_the_motion_four_of_five_are_independent() -> None:
    with pytest.warns(kn.KaneWarning, match="depend on each other"):
        eom = kn.derive(bricard.system(redundant=True))
    sol = kn.simulate(eom, (0, 5), samples=20, rtol=1e-10, atol=1e-10, **bricard.START)
    for q in sol.q:
        a = np.array(eom.evaluate([x for row in eom.A for x in row], q=list(q), u=[0.0] * 5), dtype=float).reshape(5, 5)
        sigma = np.linalg.svd(a, compute_uv=False)
        assert sigma[3] > 1
        assert sigma[4] < 1e-12
