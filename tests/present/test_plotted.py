# SPDX-License-Identifier: BSD-3-Clause
"""`plot` of several motions, of y against x, of passages: what is drawn is the motion, what is nothing is not; energies; cycles."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import simplest_walker
from kane.present import asset, series_colours, spread


@pytest.fixture(scope="module")
def eom():
    """A pendulum of 2 kg on a rod of 0.7 m, with a coordinate x on which nothing acts and the path of the bob."""
    system = kn.System("pendulum with a slow slider")
    N = system.inertial
    q, x = system.coordinates("q x", unit=("rad", "m"))
    u, v = system.speeds("u v", unit=("rad/s", "m/s"))
    return system, N, q, x, u, v


OMEGA, AMPLITUDE = 2.0, 0.3


def oscillator():
    """m q̈ + k q = 0: q = a cos ωt."""
    system = kn.System("oscillator")
    q = system.coordinate("q", unit="m")
    u = system.speed("u", q.dt if hasattr(q, "dt") else None)
    return system, q, u
