# SPDX-License-Identifier: BSD-3-Clause
"""Andrews' squeezing mechanism: what it is made of; `tests/literature` holds its motion against the Test Set."""

from __future__ import annotations

import numpy as np

import kane as kn
from kane.gallery import andrews_squeezer


def test_seven_bodies_one_degree_of_freedom() -> None:
    eom = kn.derive(andrews_squeezer.system())
    assert (len(eom.system.bodies), len(eom.system.holonomic), len(eom.independent_speeds)) == (7, 6, 1)


def test_the_published_start_is_closed() -> None:
    eom = kn.derive(andrews_squeezer.system())
    found = eom.evaluate([c.expr for c in eom.system.holonomic], **andrews_squeezer.START)
    np.testing.assert_allclose(found, 0, atol=1e-16)
