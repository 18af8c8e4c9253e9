# SPDX-License-Identifier: BSD-3-Clause
"""Roots followed along data: on their branch, up to its end."""

import numpy as np

from kane.numeric import follow, surely_regular

ONE = np.ones(1)


def parabola(x, d):
    """x² = d: two branches that meet at a fold at zero."""
    return x**2 - d, np.diag(2 * x)


def test_both_branches_of_a_root():
    d = np.linspace(4, 0.01, 50)[:, None]
    for sign in (1, -1):
        found = follow(parabola, d, np.array([2.0 * sign]), ONE)
        assert not found.ends
        np.testing.assert_allclose(found.x[:, 0], sign * np.sqrt(d[:, 0]), rtol=1e-14)


def test_a_branch_ends_at_a_fold_and_is_taken_up_again():
    d = np.array([[1.0], [0.5], [-0.5], [-1.0], [0.25]])
    found = follow(parabola, d, ONE, ONE)
    assert sorted(found.ends) == [2, 3]
    assert np.isnan(found.x[2:4]).all()
    np.testing.assert_allclose(found.x[4], 0.5, rtol=1e-14)
    end = found.ends[2]
    assert end.last == 1
    np.testing.assert_allclose(end.share, 0.5, atol=1e-4)
    np.testing.assert_allclose(end.x, 0.0, atol=0.02)


def test_long_ways_are_gone_in_parts():
    """exp x = d by steps no longer than half a unit."""
    found = follow(lambda x, d: (np.exp(x) - d, np.diag(np.exp(x))), np.exp([[0.0], [5.0], [-3.0]]), np.zeros(1), ONE)
    np.testing.assert_allclose(found.x[:, 0], [0, 5, -3], atol=1e-13)


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
