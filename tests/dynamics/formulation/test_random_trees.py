# SPDX-License-Identifier: BSD-3-Clause
"""Random trees of up to 40 bodies, a thousand in the full profile: route against route, and against Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import tree_with_reactions
from tests.dynamics.formulation.test_recursive import by_all_routes, state
from tests.examples import examples
from tests.oracles import kane_tree
from tests.oracles.compare import tolerance
from tests.oracles.tree import random_states, random_tree
from tests.peer import require
from tests.systems import cuts, jointed

sizes = st.floats(0, 1).map(lambda x: round(2 + 38 * x**11))
"""Bodies: small trees are derived soon, and one in fifteen has more than 20."""
seeds = st.integers(0, 10**6)


def by_both_routes(system):
    """The accelerations and reactions by articulated and by composite inertias at one state; None where no recursion expresses it."""
    parts, found = by_all_routes(system)
    if not found:
        return None
    whole = [tree_with_reactions(parts, s) for s in found]
    roots = [x for s in whole for x in (*s.accelerations, *s.reactions)]
    return np.array(kn.evaluate(roots, state(roots, 1)), dtype=float).reshape(2, -1)


def agree(numbers):
    return numbers is None or np.abs(numbers[0] - numbers[1]).max() <= 1e-9 * np.abs(numbers[1]).max()


@pytest.mark.slow
@examples(0.4, 12)
@given(seeds, sizes, st.booleans(), st.booleans())
def test_trees_of_any_joints_by_any_speeds(seed, bodies, mixed, meeting):
    """Loads, inputs, driven joints; several joints at one point; speeds that are combinations of those of the joints."""
    system = jointed.system(seed, bodies, meeting=0.4 * meeting)
    assert agree(by_both_routes(jointed.by_mixed_speeds(system, seed) if mixed else system))


@examples(0.4, 6)
@given(seeds, st.integers(2, 8))
def test_reactions(seed, bodies):
    """What joints transmit is read from articulated inertias, or found by partial velocities beside composite ones."""
    assert agree(by_both_routes(cuts.tree(seed, bodies, friction=False)))


@pytest.mark.slow
@examples(0.3, 12)
@given(seeds, sizes)
def test_trees_of_pins_and_sliders_against_a_robotics_engine(seed, bodies):
    require("pinocchio")
    from tests.oracles import pinocchio_tree

    rng = np.random.default_rng(seed)
    tree = random_tree(rng, bodies)
    q, u = random_states(rng, tree, 1)
    engine = pinocchio_tree.solve(tree, q[:, 0], u[:, 0])
    limit = tolerance(1e-9, engine.condition)
    model = kane_tree.derive(tree)
    found = model.accelerations(q, u)[:, 0]
    assert np.abs(found - engine.qddot).max() <= limit * np.abs(engine.qddot).max()
