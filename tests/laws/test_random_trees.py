# SPDX-License-Identifier: BSD-3-Clause
"""Physical laws on random trees: power balance, the mass matrix, the bodies' accelerations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from tests.examples import examples
from tests.oracles import kane_tree, newton_euler
from tests.oracles.compare import error, tolerance
from tests.oracles.tree import Array, Tree, random_states, random_tree, trees_in_motion

Motion = tuple[Tree, Array, Array]


def check_laws(motion: Motion) -> None:
    tree, q, qdot = motion
    model = kane_tree.derive(tree)
    eom = model.eom
    scalars = [eom.time_derivative(eom.energy), eom.power, eom.kinetic_energy, eom.potential_energy]
    derivative, power, kinetic, potential = model.evaluate(scalars, q, qdot)
    accelerations = model.accelerations(q, qdot)
    matrices = model.mass_matrix(q, qdot)
    centers = [x for C in model.centers for x in eom.point_accelerations[C].components(model.inertial)]
    frames = [x for B in model.frames for x in eom.angular_accelerations[B].components(model.inertial)]
    a, alpha = (model.evaluate(exprs, q, qdot) for exprs in (centers, frames))
    oracles = [newton_euler.solve(tree, q[:, k], qdot[:, k]) for k in range(q.shape[1])]
    for k, oracle in enumerate(oracles):
        M = matrices[k]
        limit = tolerance(1e-9, float(np.linalg.cond(M)))

        np.testing.assert_array_equal(M, M.T)
        assert np.linalg.eigvalsh(M)[0] > 0.0
        assert error(M, oracle.mass_matrix) <= 1e-12
        assert error(kinetic[k], oracle.kinetic) <= 1e-12
        assert error(potential[k] - potential[0], oracle.potential - oracles[0].potential) <= 1e-11
        assert error(power[k], oracle.power) <= 1e-12

        # What flows within the sum, |u| . (|M| |u'|), sets the scale of the rounding.
        scale = max(1.0, float(np.abs(qdot[:, k]) @ np.abs(M) @ np.abs(accelerations[:, k])))
        off = abs(derivative[k] - power[k]) / scale
        assert off <= limit, f"dE/dt - P, state {k}: {off:.1e}, limit {limit:.1e}"

        assert error(a[:, k], oracle.a.ravel()) <= limit
        assert error(alpha[:, k], oracle.alpha.ravel()) <= limit


@pytest.mark.slow
@examples(0.2)  # tests/peers has as many as the profile says
@given(trees_in_motion())
def test_laws_on_trees_of_round_numbers(motion: Motion) -> None:
    check_laws(motion)


@pytest.mark.slow
@pytest.mark.parametrize("bodies", [1, 3, 5])
def test_laws_on_trees_of_generic_numbers(bodies: int) -> None:
    rng = np.random.default_rng(100 + bodies)
    tree = random_tree(rng, bodies)
    check_laws((tree, *random_states(rng, tree, 10)))
