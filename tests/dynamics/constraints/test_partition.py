# SPDX-License-Identifier: BSD-3-Clause
"""Which speeds the constraints give: rank, preference, sparsity."""

from __future__ import annotations

import numpy as np
import pytest

from kane.dynamics import Partition, choose, choose_each, qualities, qualities_of, quality
from kane.numeric import balanced


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 5), (4, 4), (5, 9)])
def test_the_dependent_block_is_regular_in_any_units(m, n, rng):
    for _ in range(20):
        a = rng.normal(size=(m, n)) * 10.0 ** rng.integers(-3, 4, (m, 1)) * 10.0 ** rng.integers(-3, 4, n)
        found = choose(a)
        assert sorted(found.rows) == list(range(m))
        assert not found.redundant
        assert sorted((*found.dependent, *found.independent(n))) == list(range(n))
        assert np.linalg.cond(balanced(a)[np.ix_(found.rows, found.dependent)]) < 1e4


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_rows_that_follow_from_others_are_redundant(rank, rng):
    a = rng.normal(size=(5, rank)) @ rng.normal(size=(rank, 7))
    found = choose(a)
    assert (len(found.rows), len(found.redundant)) == (rank, 5 - rank)
    assert sorted((*found.rows, *found.redundant)) == list(range(5))


def test_nothing_is_chosen_from_what_rounding_left_of_zero():
    """A speed that the constraints do not hold: its column is a difference of equal products."""
    a = np.array([[0.7, 3e-17, 0.2]])
    assert choose(a).dependent in ((0,), (2,))
    assert choose(np.array([[3e-17, 1.0], [2e-17, 1.0]])) == Partition((0,), (1,), (1,))


def test_preferred_speeds_come_first(rng):
    a = rng.normal(size=(2, 5))
    assert set(choose(a, [4, 1]).dependent) == {4, 1}
    assert 3 in choose(a, [3]).dependent
    a[:, 2] = 0.0
    assert 2 not in choose(a, [2]).dependent


def test_numbers_are_the_cheapest_pivots():
    a = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]])
    assert set(choose(a, easy=np.array([[True, False, False], [False, False, True]])).dependent) == {0, 2}


def test_quality_is_that_of_the_block_in_whatever_order_it_is_eliminated():
    """What is solved has no fixed order that could fail: a rotation is as good at 90° as elsewhere."""
    for angle in (0.0, 1.0, np.pi / 2):
        c, s = np.cos(angle), np.sin(angle)
        a = np.array([[c, s, 0.5], [-s, c, 0.2]])
        assert quality(a, Partition((0, 1), (0, 1), ())) == pytest.approx(1.0)
    assert quality(np.array([[1e-9, 1.0]]), Partition((0,), (0,), ()), np.ones((1, 2))) == pytest.approx(1e-9)
    assert quality(np.zeros((1, 2)), Partition((0,), (0,), ())) == 0


@pytest.mark.parametrize("noise", [0.0, 3e-13, -3e-13, 1e-10])
def test_what_rounding_leaves_of_zero_fills_nothing(noise, rng):
    """Of entries that are alike the first is taken, and a row that is zero where another is eliminated stays as empty as it was."""
    a = np.array([[1.0, 0, 0, -1, 1], [noise, 1, 0, 1, 0], [-1.0, 0, 1, 0, 0], [noise, 0, 1, 0, 1]])
    plain = choose(np.where(np.abs(a) > 1e-9, a, 0.0))
    assert choose(a) == plain
    assert choose(a * (1 + 1e-12 * rng.normal(size=a.shape))) == plain


def test_matrices_side_by_side_are_eliminated_as_each_alone(rng):
    for _ in range(20):
        a = np.round(rng.normal(size=(4, 4, 6)), 1) * (rng.random((4, 4, 6)) < 0.6)
        preferred, easy = rng.permutation(6)[: rng.integers(0, 3)].tolist(), rng.random((4, 6)) < 0.3
        before = easy.copy()
        together = choose_each(a, preferred, easy=easy)
        assert together == [choose(x, preferred, easy=easy) for x in a]
        assert np.array_equal(easy, before)
        scaled = balanced(a)
        every = qualities_of(scaled, together)
        assert every == pytest.approx(np.array([qualities(a, p) for p in together]), rel=1e-12)
