# SPDX-License-Identifier: BSD-3-Clause
"""Andrews' squeezing mechanism against the Test Set for IVP Solvers: start, first accelerations, multipliers, end at 0.03 s."""

from __future__ import annotations

import numpy as np

import kane as kn
from kane.gallery import andrews_squeezer

# Printed positions at 0.03 s; they are off by up to 1.4e-9 themselves, as integrations at 1e-12 by different methods agree.
END = (
    0.1581077119629904e2,
    -0.1575637105984298e2,
    0.4082224013073101e-1,
    -0.5347301163226948e0,
    0.5244099658805304e0,
    0.5347301163226948e0,
    0.1048080741042263e1,
)


def test_end() -> None:
    eom = kn.derive(andrews_squeezer.system())
    sol = kn.simulate(eom, andrews_squeezer.SPAN, rtol=1e-11, atol=1e-11, **andrews_squeezer.START)
    np.testing.assert_allclose(sol.q[-1], END, rtol=0, atol=5e-9)
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-12
    assert sol.energy_check.relative < 1e-9


def test_start() -> None:
    """The accelerations and multipliers printed with the start."""
    eom = kn.derive(andrews_squeezer.system())
    start = andrews_squeezer.START
    found = eom.evaluate(list(eom.accelerations), **start)
    expected = [14222.4439199541138705911625887, -10666.8329399655854029433719415, 0, 0, 0, 0, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-6)
    # Printed multipliers enter M q̈ + Gᵀ λ = f: the opposite sign.
    multipliers = eom.evaluate(list(eom.multipliers.values()), **start)
    expected = [-98.5668703962410896057654982170, 6.12268834425566265503114393122, 0, 0, 0, 0]
    np.testing.assert_allclose(multipliers, expected, rtol=1e-10, atol=1e-8)
