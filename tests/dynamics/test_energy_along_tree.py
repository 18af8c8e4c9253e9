# SPDX-License-Identifier: BSD-3-Clause
"""Kinetic energy along the tree is that of the bodies one by one, and M of closed trees that of the classical route."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import derived, kinetic_energy_along_tree, mass_matrix
from kane.dynamics import kinetic_energy as by_bodies
from tests.dynamics.formulation.test_recursive import state
from tests.systems import jointed, rings


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_kinetic_energy_of_trees_of_any_joints(seed):
    plain = jointed.system(seed, 2 + seed % 4)
    parts = derived(jointed.by_mixed_speeds(plain, seed) if seed % 2 else plain)
    roots = [kinetic_energy_along_tree(parts), by_bodies(parts.bodies)]
    own, usual = np.array(kn.evaluate(roots, state(roots, 1)), dtype=float)
    assert own == pytest.approx(usual, rel=1e-12)


@pytest.mark.slow
def test_mass_matrix_of_a_ring():
    eom = kn.derive(rings.ring(6, True), route="recursive")
    roots = [*mass_matrix(eom.solved).entries, *eom.mass_matrix.entries]
    own, usual = np.array(kn.evaluate(roots, state(roots, 1)), dtype=float).reshape(2, -1)
    assert np.abs(own - usual).max() <= 1e-12 * np.abs(usual).max()


@pytest.mark.slow
def test_a_ring_in_motion_keeps_its_energy():
    eom = kn.derive(rings.ring(16))
    assert eom.route == "recursive"
    angles = {q: kn.guess(1.2 * np.sin(3 * k)) for k, q in enumerate(eom.coordinates)}
    start = kn.assemble(eom, q=angles, u=dict.fromkeys(eom.independent_speeds, 0.0))
    sol = kn.simulate(eom, (0, 0.1), q=start.q, u=start.u)
    energy = sol[eom.energy]
    assert np.ptp(energy) <= 1e-8 * np.abs(energy).max()
