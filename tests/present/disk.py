# SPDX-License-Identifier: BSD-3-Clause
"""The disk, its equations and a short motion, made once for the tests of this folder."""

from __future__ import annotations

from functools import cache

import kane as kn
from kane.gallery import rolling_disk
from kane.gallery.rolling.rolling_disk import Model


@cache
def derived() -> tuple[Model, kn.Equations]:
    disk = rolling_disk.model()
    return disk, kn.derive(disk.system)


@cache
def moved() -> kn.Solution:
    disk, eom = derived()
    return kn.simulate(eom, (0.0, 0.3), q=[0, 0.1, 0, 0, 0], u=[0, 2, 25, 2, 0], parameters={disk.mu: 0.1}, samples=31)
