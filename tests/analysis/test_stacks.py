# SPDX-License-Identifier: BSD-3-Clause
"""Linear equations of many states against NumPy's, and what is said of singular ones."""

import numpy as np
import pytest

import kane as kn
from kane.analysis import MatrixEntries, solve_each, surely_independent
from kane.numeric import balanced, surely_regular

SETTINGS = kn.Settings()


def entries(a):
    """Matrices (k × m × n) as they stand, behind a number of each state that is none of theirs."""
    rows = np.hstack([np.full((len(a), 1), np.nan), a.reshape(len(a), -1)])
    return MatrixEntries(rows, 1 + np.arange(a[0].size).reshape(a.shape[1:]))


def bound(a):
    """1/(‖A‖ ‖A⁻¹‖) of A balanced."""
    a = balanced(a)
    return 1 / (np.linalg.norm(a, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(a), axis=(1, 2)))


@pytest.mark.parametrize("filled", [1.0, 0.2])
@pytest.mark.parametrize("size", [1, 2, 7, 8, 9, 17])
def test_solutions_and_inverses(size, filled, rng):
    """Units differ by columns; the first entry vanishes, so that rows must be swapped."""
    a = rng.normal(size=(5, size, size)) * (rng.random((5, size, size)) < filled) + 3 * np.eye(size)[::-1]
    a, b = a * 10.0 ** rng.integers(-3, 4, size), rng.normal(size=(5, size, 3))
    if size > 1:
        a[:, 0, 0] = 0.0
    found = solve_each(entries(a), entries(b), SETTINGS, inverse=True)
    np.testing.assert_allclose(found.x, np.linalg.solve(a, b), rtol=1e-8, atol=1e-9 * np.abs(found.x).max())
    np.testing.assert_allclose(a @ found.inverse, np.broadcast_to(np.eye(size), a.shape), atol=1e-9)
    np.testing.assert_allclose(found.share, bound(a), rtol=1e-8)
    assert found.regular(1e-9).all()


def test_one_that_is_singular_stops_no_other(rng):
    a = rng.normal(size=(6, 4, 4))
    a[1, 2] = 2 * a[1, 3]
    a[2, 0, 1], a[3, 3, 3], a[4] = np.nan, np.inf, 0.0
    found = solve_each(entries(a), entries(np.ones((6, 4, 1))), SETTINGS)
    assert found.regular(1e-12).tolist() == [True, False, False, False, False, True]
    np.testing.assert_allclose(found.x[[0, 5]], np.linalg.solve(a[[0, 5]], np.ones((2, 4, 1))), rtol=1e-9)


def test_what_is_not_a_number_is_not_passed_over(rng):
    """In a column below a pivot, where a zero would be."""
    a = np.tile(np.eye(3), (3, 1, 1))
    a[0, 2, 0], a[1, 0, 2], a[2, 0, 0] = np.nan, np.nan, np.nan
    assert not solve_each(entries(a), entries(np.ones((3, 3, 1))), SETTINGS).regular(1e-12).any()


def test_what_is_rounding_does_not_make_a_matrix_regular():
    """1e-17 beside ones: balanced as they stand the rows would be independent."""
    a = np.array([[[1.0, 1.0], [1e-17, 0.0]], [[1.0, 1.0], [1e-17, 1.0]]])
    found = solve_each(entries(a), entries(np.ones((2, 2, 1))), SETTINGS)
    assert (found.share < 0).all()
    assert found.regular(1e-12).tolist() == [False, True]
    assert solve_each(entries(a), entries(np.ones((2, 2, 1))), SETTINGS, order=(1, 0), rounding=0.0).share.min() > 0.1


@pytest.mark.parametrize("shape", [(1, 3), (4, 6), (9, 17), (5, 5)])
def test_rows_that_are_surely_independent(shape, rng):
    a = rng.normal(size=(20, *shape)) * 10.0 ** rng.integers(-3, 4, shape[1])
    a[3] = 0.0
    a[5, -1] = a[5, 0] if shape[0] > 1 else 0.0
    sure = surely_independent(entries(a), 1e-5, SETTINGS)
    np.testing.assert_array_equal(sure, surely_regular(balanced(a), 1e-5))
    assert not sure[[3, 5]].any()
    assert sure.sum() == 18
