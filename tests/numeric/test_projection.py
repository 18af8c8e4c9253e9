# SPDX-License-Identifier: BSD-3-Clause
"""Least changes in the mass metric: against their optimality conditions, in any units, with and without mass."""

from __future__ import annotations

import numpy as np
import pytest

from kane.numeric import least_change, least_constraint, metric, mobility, of_unit_length, reflected
from tests.numeric.kkt import kkt


def spd(n, rng):
    x = rng.normal(size=(n, n))
    return x @ x.T + 0.1 * np.eye(n)


@pytest.mark.parametrize(("n", "k"), [(1, 1), (4, 1), (5, 3), (6, 6)])
def test_a_step_is_the_least_in_the_mass_metric(n, k, rng):
    m, a, right = spd(n, rng), rng.normal(size=(k, n)), rng.normal(size=k)
    np.testing.assert_allclose(least_change(m, a, right, np.abs(a)), kkt(m, a, right), atol=1e-10)


def test_redundant_rows_do_no_harm(rng):
    m, a, right = spd(5, rng), rng.normal(size=(2, 5)), rng.normal(size=2)
    mix = np.array([[1, 0], [0, 1], [2.0, -1], [1e3, 0]])
    found = least_change(m, mix @ a, mix @ right, np.abs(mix @ a))
    np.testing.assert_allclose(found, kkt(m, a, right), atol=1e-9)


def test_a_row_that_vanishes_now_is_no_row_in_small_units():
    """Sizes that entries have had tell the two apart: a rod along x, and one that would be along y were it not for rounding."""
    a, right, m = np.array([[1.0, 0.0], [0.0, 1e-9]]), np.array([0.1, 1e-12]), np.eye(2)
    np.testing.assert_allclose(least_change(m, a, right, np.abs(a)), [0.1, 1e-3])
    np.testing.assert_allclose(least_change(m, a, right, np.ones((2, 2))), [0.1, 0.0], atol=1e-10)


def test_the_metric_is_a_root_of_the_inverse(rng):
    m = spd(4, rng)
    s = metric(m)
    np.testing.assert_allclose(s @ s.T @ m, np.eye(4), atol=1e-10)


def test_what_moves_no_mass_is_free_to_move():
    """The second speed is massless: it takes the whole change, and no more than that."""
    change = least_change(np.diag([1.0, 0.0]), np.array([[1.0, 1.0]]), np.array([0.3]), np.ones((1, 2)))
    assert change.sum() == pytest.approx(0.3)
    assert abs(change[0]) < 1e-3


@pytest.mark.parametrize("singular", ["one without mass", "two without mass in a chain", "singular with a diagonal"])
def test_units_do_not_matter(singular, rng):
    """x in other units, x = D x': the same step, the same accelerations."""
    a, right, f = rng.normal(size=(3, 5)), rng.normal(size=3), rng.normal(size=5)
    root = rng.normal(size=(5, 5))
    if singular == "one without mass":
        root[0] = 0
    elif singular == "two without mass in a chain":
        root[:2] = 0
        a[0, 1:] = 0
        a[0, :2] = 0.7, -0.3
    else:
        root[:, 3:] = 0
    m = root @ root.T
    plain, other = least_change(m, a, right), least_constraint(m, a, f, right)
    np.testing.assert_allclose(a @ plain, right, atol=1e-12)
    np.testing.assert_allclose(a @ other, right, atol=1e-12)
    # the least change: no part of M δ lies along what the constraints leave free
    free = np.linalg.svd(a)[2][3:]
    assert np.abs(free @ m @ plain).max() < 1e-4
    np.testing.assert_allclose(free @ (m @ other - f), 0, atol=1e-10)
    d = np.array([1e5, 1e-4, 1.0, 1e3, 1e-6])
    scaled = d[:, None] * m * d
    np.testing.assert_allclose(d * least_change(scaled, a * d, right), plain, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(d * least_constraint(scaled, a * d, d * f, right), other, rtol=1e-7, atol=1e-7)


def test_a_massive_body_hardly_moves_for_one_without_mass():
    """Where a slide without mass can close a constraint, a flywheel of any inertia stays."""
    a = np.array([[0.2, -1.0, 0.0], [0.0, 0.5, -2.0]])
    for inertia in (1e-9, 1.0, 1e9):
        change = least_change(np.diag([inertia, 0.0, 0.0]), a, np.array([1e-6, -2e-6]))
        np.testing.assert_allclose(a @ change, [1e-6, -2e-6], atol=1e-20)
        assert abs(change[0]) < 1e-4 * abs(change[1])


def test_what_rounding_leaves_of_a_mass_is_none():
    """A partial velocity of 1e-17 where 0 is meant: the other rows are closed all the same."""
    a, right = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]), np.array([0.1, -0.2])
    for mass in (0.0, 1e-34):
        m = np.diag([2.0, 3.0, mass])
        np.testing.assert_allclose(a @ least_change(m, a, right), right, atol=1e-14)
        np.testing.assert_allclose(least_change(m, a, right), kkt(m, a, right), atol=1e-6)


def test_what_is_reflected():
    """m (a_i/a)², through a part without mass between; own mass where there is one."""
    a = np.array([[0.2, -1.0, 0.0], [0.0, 0.5, -2.0]])
    np.testing.assert_allclose(reflected(np.array([3.0, 0, 0]), a), [3, 3 / 0.04, 3 / 0.04 * 16])
    np.testing.assert_allclose(reflected(np.zeros(3), a), [0.04, 1, 1])
    np.testing.assert_allclose(reflected(np.array([3.0, 0, 0]), np.zeros((0, 3))), [3, 1, 1])
    s = mobility(np.diag([3.0, 0, 0]), a)
    np.testing.assert_allclose(np.linalg.norm(s, axis=1) ** 2, [1 / 3, 0.04 / 3, 0.04 / 48])
    assert np.isfinite(metric(np.zeros((3, 3)), a)).all()


def test_a_force_on_what_has_no_mass_is_felt_by_what_has():
    """x1 + x2 = r, a force 2 on x2: x1 is pushed back by it."""
    found = least_constraint(np.diag([4.0, 0.0]), np.array([[1.0, 1.0]]), np.array([0.0, 2.0]), np.array([0.3]))
    np.testing.assert_allclose(found, [-0.5, 0.8])


def test_euler_parameters_get_unit_length():
    x = np.array([5.0, 3.0, 0.0, 4.0, 0.0, 7.0])
    np.testing.assert_allclose(of_unit_length(x, [(1, 2, 3, 4)]), [5, 0.6, 0, 0.8, 0, 7])
    assert x[1] == 3
