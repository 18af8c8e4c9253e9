# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of random trees by kane, by redundant Newton-Euler equations and by Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from tests.examples import examples
from tests.oracles import kane_tree, newton_euler
from tests.oracles.compare import error, tolerance
from tests.oracles.tree import Array, Tree, random_states, random_tree, trees_in_motion
from tests.peer import require

require("pinocchio")
from tests.oracles import pinocchio_tree  # noqa: E402

Motion = tuple[Tree, Array, Array]


def compare(motion: Motion) -> None:
    tree, q, qdot = motion
    model = kane_tree.derive(tree)
    rates = np.empty_like(q)
    rates[model.order] = model.evaluate(model.eom.rates, q, qdot)
    np.testing.assert_array_equal(rates, qdot)
    found = model.accelerations(q, qdot)
    matrices = model.mass_matrix(q, qdot)
    for k in range(q.shape[1]):
        engine = pinocchio_tree.solve(tree, q[:, k], qdot[:, k])
        redundant = newton_euler.solve(tree, q[:, k], qdot[:, k])
        limit = tolerance(1e-9, engine.condition)
        for name, other in (("Pinocchio", engine.qddot), ("Newton-Euler", redundant.qddot)):
            off = error(found[:, k], other)
            assert off <= limit, f"{name}, state {k}: off by {off:.1e}, limit {limit:.1e}, cond {engine.condition:.1e}"
        off = error(matrices[k], engine.mass_matrix)
        assert off <= 1e-12, f"mass matrix, state {k}: off by {off:.1e}, cond {engine.condition:.1e}"


@pytest.mark.slow
@examples(0.5)
@given(trees_in_motion())
def test_accelerations_of_trees_of_round_numbers(motion: Motion) -> None:
    compare(motion)


@pytest.mark.slow
@pytest.mark.parametrize("bodies", range(1, 7))
def test_accelerations_of_trees_of_generic_numbers(bodies: int) -> None:
    rng = np.random.default_rng(bodies)
    tree = random_tree(rng, bodies)
    compare((tree, *random_states(rng, tree, 20)))
