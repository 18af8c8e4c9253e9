# SPDX-License-Identifier: BSD-3-Clause
"""The recursive route gives the accelerations of the classical one, wherever it expresses the tree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.systems import COUNTED
from kane.dynamics.derived import derived
from kane.dynamics.routes.classical import classical
from kane.dynamics.routes.recursive import recursive
from kane.gallery import pendulums
from tests.examples import examples
from tests.oracles import kane_tree
from tests.oracles.compare import tolerance
from tests.oracles.tree import trees
from tests.systems import jointed

SEEDS = (1, 2, 3)


def state(expressions, seed):
    """A value for every symbol, sets of Euler parameters of length 1."""
    rng = np.random.default_rng(seed)
    symbols = sorted(kn.expr.evaluate.free_symbols(expressions), key=lambda s: s.name)
    values = {s: float(s.default) if getattr(s, "default", None) else rng.uniform(-1.2, 1.2) for s in symbols}
    sets = {}
    for s in symbols:
        if s.name[:1] == "e" and s.name[1:2].isdigit():
            sets.setdefault(s.name[2:], []).append(s)
    for group in sets.values():
        length = np.sqrt(sum(values[e] ** 2 for e in group))
        values |= {e: values[e] / length for e in group}
    return values


def difference(system, solve=recursive):
    """The largest difference of u̇ by both routes over the largest u̇, over what rounding allows; None where there is one route."""
    parts = derived(system)
    found = solve(parts)
    if found is None:
        return None
    usual = classical(parts, None)
    roots = [*found.accelerations, *usual.accelerations]
    n, worst = len(usual.accelerations), 0.0
    for seed in SEEDS:
        values = state([*roots, *parts.mass_matrix.entries], seed)
        numbers = np.array(kn.evaluate(roots, values), dtype=float)
        condition = np.linalg.cond(np.array(kn.evaluate(parts.mass_matrix, values), dtype=float))
        off = np.abs(numbers[:n] - numbers[n:]).max() / np.abs(numbers[n:]).max()
        worst = max(worst, off / tolerance(1e-9, condition))
    return worst


@pytest.mark.parametrize("seed", range(12))
def test_trees_of_joints(seed):
    off = difference(jointed.system(seed, 1 + seed % 5, jointed.PLAIN))
    assert off is not None
    assert off <= 1


@examples(0.3)
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_trees_of_any_joints(seed, bodies):
    off = difference(jointed.system(seed, bodies))
    assert off is None or off <= 1


@examples(0.3)
@given(trees(4))
def test_trees_of_turns_and_slides(tree):
    off = difference(kane_tree.derive(tree).eom.system)
    assert off is None or off <= 1


@pytest.mark.parametrize("name", [n for n in COUNTED if "general axes" in n or "planar" in n or n == "7R arm"])
def test_what_is_counted(name):
    assert difference(COUNTED[name]()) <= 1


@pytest.mark.parametrize("speeds", ["rates", "mixed"])
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("cart", [False, True])
def test_speeds_of_chains_in_any_way(speeds, relative, cart):
    assert difference(pendulums.system(5, relative=relative, cart=cart, speeds=speeds)) <= 1


@pytest.mark.parametrize("speeds", ["tips", "scrambled"])
def test_speeds_that_change_with_the_configuration_are_left(speeds):
    assert recursive(derived(pendulums.system(4, speeds=speeds))) is None
