# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of u̇ by inverse dynamics along a tree are those of u̇ as they stand, by every symbol there is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_tree
from benchmarks.systems import arm
from kane.dynamics import acceleration_slopes, forward
from kane.expr import ONE, price
from kane.gallery import four_bar, pendulums
from kane.kinematics import Unsuited
from tests.equations.test_jacobian import numbers, tangents
from tests.examples import examples
from tests.oracles.compare import tolerance
from tests.oracles.duals import values_and_slopes
from tests.systems import jointed


def by_tree(eom, symbols, route=None):
    d = eom.derived
    own = route or (eom.route if eom.route in ("recursive", "composite") else "recursive")
    columns = acceleration_slopes(d, eom.accelerations, symbols, own)
    return [column[k] for k in range(len(d.speeds)) for column in columns]


def check(eom, rng, route=None):
    """All columns, each to 1e-9 of its largest entry, which is zero where it is 1e-5 of the largest of all."""
    symbols = (*eom.coordinates, *eom.speeds, *eom.inputs, *eom.parameters, kn.time)
    found = by_tree(eom, symbols, route)
    values = numbers(eom, rng)
    _, expected = values_and_slopes(eom.accelerations, values, symbols)
    along = tangents(eom, symbols, values)
    off = (np.array(kn.evaluate(found, values), dtype=float).reshape(expected.shape) - expected) @ along
    scale = np.abs(expected).max(axis=0, initial=0) + 1e-5 * np.abs(expected).max(initial=1e-300)
    condition = np.linalg.cond(np.array(kn.evaluate(eom.mass_matrix, values), dtype=float))
    assert np.abs(off / scale).max(initial=0) < tolerance(1e-9, condition)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_trees_of_joints(seed, rng):
    check(kn.derive(jointed.system(seed, 1 + seed % 4, jointed.PLAIN)), rng)


@given(st.integers(0, 10**6))
@examples(0.05, 3)
def test_trees_of_joints_of_every_kind(seed):
    eom = kn.derive(jointed.system(seed, 1 + seed % 3, jointed.KINDS))
    try:
        check(eom, np.random.default_rng(seed))
    except Unsuited:
        return


@pytest.mark.slow
@pytest.mark.parametrize("route", ["recursive", "composite"])
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("speeds", ["rates", "mixed", "tips"])
def test_links_about_parallel_axes(relative, speeds, route, rng):
    check(kn.derive(pendulums.system(3, relative=relative, cart=True, speeds=speeds)), rng, route)


def test_a_floating_base(rng):
    check(kn.derive(random_tree((-1, 0, -1), 3, floating=True)), rng)


def test_what_is_no_tree():
    eom = kn.derive(four_bar.system())
    with pytest.raises(Unsuited, match="constraints"):
        by_tree(eom, eom.coordinates)


GENERAL = pytest.param(lambda: random_tree(range(-1, 6), 1), 3.6, marks=pytest.mark.slow, id="general axes")


@pytest.mark.parametrize(("make", "share"), [pytest.param(lambda: arm("zyzyzyz"), 4.5, id="aligned"), GENERAL])
def test_an_arm_of_seven_joints_takes_a_few_right_hand_sides(make, share):
    eom = kn.derive(make())
    j = eom.jacobian()
    assert j.operations.total < share * eom.operations.total
    as_they_stand = [e for s in j.columns for e in forward(eom.solved, [s], [ONE])]
    assert price(j.matrix.entries) < 0.6 * price(as_they_stand)
