# SPDX-License-Identifier: BSD-3-Clause
"""Checking functions along motions."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import spherical_pendulum

EOM = kn.derive(spherical_pendulum.system())
START = {"q": [0.8, 0.2], "u": [0.3, 1.4]}


def test_integrals_are_kept_and_reported():
    motion = kn.simulate(EOM, (0, 2), **START, check=EOM.integrals)
    found = motion.checking_functions()
    assert [d.name for d in found] == [one.name for one in EOM.integrals]
    assert all(d.relative < 1e-7 and d.values.shape == motion.t.shape for d in found)


def test_what_is_no_integral_warns():
    with pytest.warns(kn.KaneWarning, match="Expected .* constant along the motion, got a change of"):
        kn.simulate(EOM, (0, 1), **START, check=[EOM.speeds[0]])
    motion = kn.simulate(EOM, (0, 1), **START)
    (one,) = motion.checking_functions([EOM.speeds[0]])
    assert one.drift == pytest.approx(np.abs(motion.u[:, 0] - motion.u[0, 0]).max())


def test_loose_tolerances_show():
    """An integration of 1e-3 drifts more than one of 1e-9, by numbers of its own."""
    loose, fine = (
        max(d.relative for d in kn.simulate(EOM, (0, 5), **START, rtol=r, atol=r, method="tsit5").checking_functions())
        for r in (1e-4, 1e-9)
    )
    assert loose > 100 * fine


def test_they_are_looked_at_before_the_motion_runs():
    with pytest.raises(kn.ArgumentError, match="Write \\[…\\]"):
        kn.simulate(EOM, (0, 1), **START, check=EOM.integrals[0])
    with pytest.raises(kn.ArgumentError, match="got energy"):
        kn.simulate(EOM, (0, 1), **START, check=["energy"])
