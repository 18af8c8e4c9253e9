# SPDX-License-Identifier: BSD-3-Clause
"""Rank in any units: what a matrix determines, and what it leaves open."""

from __future__ import annotations

import numpy as np
import pytest

from kane.numeric import (
    DERIVE_RANK,
    SOLVE_RANK,
    balance,
    balanced,
    decays,
    dependencies,
    indeterminate,
    null_direction,
    singular,
    sure_rows,
    surely_regular,
    within,
)


def units(rng, count):
    return 10.0 ** rng.integers(-2, 3, count)


def test_multipliers_of_rows_that_depend_on_each_other():
    a = np.array([[1.0, 2, 0, 0], [0, 0, 1, 0], [2, 4, 0, 0], [0, 0, 0, 0]])
    np.testing.assert_array_equal(indeterminate(a), [True, False, True, True])
    assert not indeterminate(a[:2]).any()
    assert indeterminate(np.zeros((0, 3))).shape == (0,)


def test_what_the_forces_determine():
    """A column of A_a is determined where it is a combination of the columns of A: then xᵀ A = 0 says xᵀ A_a = 0."""
    a = np.array([[1.0, 2, 0], [0, 0, 1], [2, 4, 0]])
    assert within(a, np.array([1.0, 5.0, 2.0]))
    assert not within(a, np.array([1.0, 5.0, 3.0]))
    assert within(a, np.zeros(3))


@pytest.mark.parametrize("rank", [0, 1, 2, 4])
def test_rank_in_any_units(rank, rng):
    a = (rng.normal(size=(4, rank)) @ rng.normal(size=(rank, 6))) * units(rng, (4, 1)) * units(rng, 6)
    scaled = balance(a)
    np.testing.assert_allclose(scaled.matrix * scaled.rows * scaled.columns, a)
    found = singular(scaled.matrix)
    assert found.rank(DERIVE_RANK) == rank
    assert np.abs(scaled.matrix @ found.kernel(DERIVE_RANK).T).max(initial=0) < 1e-12
    assert np.abs(found.cokernel(DERIVE_RANK) @ scaled.matrix).max(initial=0) < 1e-12
    assert len(dependencies(a)) == 4 - rank
    assert np.abs((dependencies(a) / balance(a).rows[:, 0]) @ a).max(initial=0) < 1e-9 * np.abs(a).max(initial=1e-300)


def test_a_direction_in_which_nothing_is_felt(rng):
    a = rng.normal(size=(4, 4))
    assert null_direction(a * units(rng, 4), SOLVE_RANK) is None
    a[:, 3] = a[:, 0] - 2 * a[:, 1]
    size = units(rng, 4)
    x = null_direction(a * size, SOLVE_RANK)
    assert np.abs(balanced(a * size) @ x).max() < 1e-12
    a[0, 0] = np.nan
    assert null_direction(a, SOLVE_RANK) is None


def test_a_row_that_vanishes_now_is_no_row_in_small_units():
    a = np.array([[1.0, 0.0], [0.0, 1e-9]])
    assert len(sure_rows(a)) == 2
    np.testing.assert_allclose(np.abs(sure_rows(a, np.ones((2, 2)))), [[1.0, 0.0]], atol=1e-8)


def test_surely_regular_says_nothing_that_is_not_so():
    """By the singular values themselves, of square and of wide matrices."""
    rng = np.random.default_rng(4)
    for m, n in ((3, 3), (2, 5)):
        a = rng.normal(size=(60, m, n))
        a[:, 0] = a[:, 1] + a[:, 0] * 10.0 ** -rng.uniform(0, 14, 60)[:, None]
        values = np.linalg.svd(a, compute_uv=False)
        share = values[:, -1] / values[:, 0]
        sure = surely_regular(a, 1e-4)
        assert (share[sure] > 1e-4).all()
        assert sure[share > 1e-3].all()
        assert sure.any()
        assert not sure.all()
    assert not surely_regular(np.full((1, 2, 2), np.nan), 1e-4).any()
    assert not surely_regular(np.zeros((1, 2, 2)), 1e-4).any()


def test_what_dies_out_does_so_by_more_than_rounding():
    swings = np.array([[0.0, 1.0], [-1.0, 0.0]])
    for damping, dies in ((0.0, False), (1e-15, False), (1e-9, True), (2.0, True), (-1e-9, False)):
        for t in (1e-6, 1.0, 1e6):  # other units of time
            a = np.array([[0.0, 1.0], [-1.0 / t**2, -damping / t]])
            assert decays(a) == dies
            assert not decays(np.block([[swings, np.eye(2)], [np.zeros((2, 2)), a]]))
    assert decays(np.array([[0.0, 1.0], [-1.0, -1e7]]))
    for n, k in (
        (8, 1e12),
        (60, 1.0),
    ):  # a chain on one soft spring with a weak damper; modes of very different frequencies
        links = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        links[0, 0] = links[-1, -1] = 1
        one = np.diag([1.0] + [0.0] * (n - 1))
        for damping, dies in ((1e-3, True), (0.0, False)):
            stiff, damped = k * links + one, damping * (k / 1e3 * links + one)
            assert decays(np.block([[np.zeros((n, n)), np.eye(n)], [-stiff, -damped]])) == dies
    assert decays(np.eye(4, k=1) - np.eye(4))
    assert decays(np.diag([-1e6, -1e-4]))
    assert not decays(np.zeros((1, 1)))
