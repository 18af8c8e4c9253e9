# SPDX-License-Identifier: BSD-3-Clause
"""A cylindrical, a universal and a planar joint in a row, closed by a slider, in random geometry.

Its equations also hold at seven orientations that a slider does not have. Accelerations agree with Newton's and Euler's equations in
redundant coordinates: from `evaluate`, from machine code, and along a motion.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.laws.test_random_loops import State
from tests.oracles.compare import error
from tests.oracles.loops.motion import simulate
from tests.oracles.loops.records import GROUND
from tests.oracles.mechanism import Mechanism, frames
from tests.oracles.mechanism_draw import _closure, _part, well_posed
from tests.oracles.mechanism_kane import Asked

CHAIN = ("cylindrical", "universal", "planar")


def chain(seed):
    """The chain in a geometry of that seed, at a configuration at which the slider closes it."""
    rng = np.random.default_rng(seed)
    while True:
        parts, q = zip(*(_part(rng, False, i - 1, joint) for i, joint in enumerate(CHAIN)), strict=True)
        m = Mechanism(parts, (), rng.uniform(-10.0, 10.0, 3), q)
        m = Mechanism(parts, (_closure(rng, False, "slider", (GROUND, 2), frames(m)),), m.gravity, q)
        if well_posed(m):
            return m


class Chain(State):
    """The chain with the dependent speeds that were chosen when it was derived."""

    def __init__(self, seed, symbolic=False):
        super().__init__(chain(seed), Asked(joined=True, symbolic=symbolic, seed=seed), seed)
        self.eom = kn.derive(self.model.system)
