# SPDX-License-Identifier: BSD-3-Clause
"""Forces of constraints in two ways."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import load


@pytest.mark.slow
@pytest.mark.parametrize("evident", [True, False])
@pytest.mark.parametrize("name", ["four_bar", "chaplygin_sleigh", "pure_rolling_disk", "knife_edge"])
def test_both_ways_agree(name, evident):
    """With the reactions that the system brings into evidence, and without."""
    system = load(name).system()
    eom = kn.derive(system if evident else system.replace(reactions=()))
    rng = np.random.default_rng(4)
    q = dict(zip(eom.coordinates, rng.uniform(0.3, 0.8, len(eom.coordinates)), strict=True))
    if eom.system.holonomic:
        q = kn.assemble(eom, q={eom.coordinates[0]: 0.7}).q
    u = dict(zip(eom.independent_speeds, rng.uniform(-1, 1, len(eom.independent_speeds)), strict=True))
    found = kn.constraint_forces(eom, q=q, u=u)
    ways = [np.array(list(way.values())) for way in (found.by_multipliers, found.by_auxiliary_speeds)]
    assert ways[0] == pytest.approx(ways[1], rel=1e-10, abs=1e-11 * np.abs(ways[0]).max())
    assert "by multipliers" in repr(found)


def test_scalars_have_no_places():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    bead = kn.Particle("bead", O.at("B", x * N.x + y * N.y), 1.0)
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", holonomic=x - y**2, coordinates=(x, y)))
    with pytest.raises(kn.SimulationError, match="say where their forces act"):
        kn.constraint_forces(eom, q=[0.25, 0.5], u={})
