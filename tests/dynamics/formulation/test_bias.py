# SPDX-License-Identifier: BSD-3-Clause
"""What composite bodies leave at no accelerations is what bodies one by one press with at trial ones."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import kane as kn
from benchmarks.random_trees import BRANCHES, random_tree
from benchmarks.systems import COUNTED, wrist_arm
from kane.dynamics import by_recursion, carrying, derived, regrouped
from kane.kinematics import Unsuited
from kane.tree import are_slender, composite
from tests.dynamics.formulation.test_recursive import state
from tests.systems import jointed

SYSTEMS = {
    **{f"joints {k}": partial(jointed.system, k, 1 + k % 5, jointed.PLAIN) for k in range(16)},
    "wrist": wrist_arm,
    "tree": partial(random_tree, (-1, 0, 0, 1, -1), 3),
    "free": partial(random_tree, (-1, 0), 2, floating=True),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
def test_both_give_the_same_accelerations(name, monkeypatch):
    parts, found = derived(SYSTEMS[name]()), []
    for slender in (False, True):
        monkeypatch.setattr(composite, "are_slender", lambda bodies, slender=slender: slender)
        try:
            found.append(by_recursion(parts, carrying(parts), "composite").accelerations)
        except Unsuited:
            pytest.skip("no recursion expresses it")
    a, b = found
    for seed in (1, 2):
        values = state([*a, *b], seed)
        x, y = (np.array(kn.evaluate(list(e), values), dtype=float) for e in found)
        np.testing.assert_allclose(x, y, rtol=1e-9, atol=1e-10 * np.abs(y).max())


def test_rods_along_their_axes_are_taken_one_by_one():
    counts = []
    for name in ("7R arm", "7R arm with wrist, full inertias"):
        parts = derived(COUNTED[name]())
        carried = carrying(parts)
        counts.append(are_slender(regrouped(carried.bodies, carried.segments.steps, balanced=False)))
    assert counts == [True, False]


def test_operations_of_a_tree():
    """Twenty bodies with general axes: 2,348 operations with the state body by body, about four fifths of that joint by joint.

    Regrouped bodies take 1,790 of them, but 667 of parameters for 480.
    """
    eom = kn.derive(random_tree(BRANCHES, 1))
    assert eom.route == "composite"
    assert eom.operations.state <= 1_884
    assert eom.operations.state + eom.operations.parameter <= 2_364
