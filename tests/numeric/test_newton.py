# SPDX-License-Identifier: BSD-3-Clause
"""Gauss–Newton steps: to a root, past a step that is too long, from the start that closes."""

from __future__ import annotations

import numpy as np
import pytest

from kane.numeric import close, closest, improved, starts


def circle(x):
    """x² + y² = 4."""
    return np.array([x @ x - 4.0]), 2 * x[None, :]


def test_least_steps_go_straight_to_the_circle():
    found = close(circle, np.array([0.3, 0.4]), range(2))
    np.testing.assert_allclose(found.x, [1.2, 1.6], atol=1e-12)
    assert found.size < 1e-12
    held = close(circle, np.array([0.3, 0.4]), [1])
    np.testing.assert_allclose(held.x, [0.3, np.sqrt(4 - 0.09)], atol=1e-12)


def test_a_step_that_is_too_long_is_halved():
    found = close(lambda x: (np.arctan(x), np.diag(1 / (1 + x**2))), np.array([3.0]), [0])
    assert abs(found.x[0]) < 1e-12


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-3])
def test_what_is_linear_is_solved_whatever_its_sizes(size, rng):
    """Sizes of x that are much too small only make the first steps short."""
    a, b = rng.normal(size=(4, 4)), rng.normal(size=4)
    found = close(lambda x: (a @ x - b, a), np.zeros(4), range(4), sizes=(1.0, size))
    np.testing.assert_allclose(found.x, np.linalg.solve(a, b), rtol=1e-9)
    assert found.steps < 30


def test_steps_stay_short_where_the_function_bends():
    """From x = 1.5 the tangent of sin x leads to −12.6, a root far away; steps of 1 at most lead to a near one."""
    found = close(lambda x: (np.sin(x), np.diag(np.cos(x))), np.array([1.5]), [0])
    assert abs(found.x[0]) < 1e-10


def test_what_cannot_close_ends_nearest():
    found = close(lambda x: (np.array([x[0] ** 2 + 1]), np.array([[2 * x[0]]])), np.array([2.0]), [0])
    assert found.size == pytest.approx(1, abs=1e-6)


def test_the_first_start_that_closes_is_taken():
    first, *others = starts(np.zeros(3), [0, 2], 5, [0.1, 10.0])
    assert not first.any()
    assert [x[1] for x in others] == [0, 0]
    assert 0 < np.abs(others[0]).max() < 1 < np.abs(others[1]).max()
    again = list(starts(np.zeros(3), [0, 2], 5, [0.1, 10.0]))
    np.testing.assert_array_equal(np.array(again[1:]), np.array(others))
    found = closest(circle, [np.zeros(2), np.array([0.0, 1.0]), np.array([1.0, 0.0])], range(2))
    np.testing.assert_allclose(found.x, [0, 2], atol=1e-10)


def test_changes_go_on_while_they_help():
    assert improved(1.0, abs, lambda x: x / 2, 0.1, 10) == 0.0625
    assert improved(1.0, abs, lambda x: x / 2, 0.1, 2) == 0.25
    assert improved(1.0, abs, lambda x: 2 * x, 0.1, 10) == 1


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_steps_are_those_of_sizes(unit):
    """A circle of two units, and an angle that follows: the same steps in any units."""

    def function(x):
        f = np.array([x[0] ** 2 + x[1] ** 2 - (2 * unit) ** 2, x[2] - x[0] / unit])
        return f, np.array([[2 * x[0], 2 * x[1], 0], [-1 / unit, 0, 1]])

    found = close(
        function,
        np.array([0.3 * unit, 0.4 * unit, 0.0]),
        range(3),
        sizes=(np.array([unit**2, 1]), np.array([unit, unit, 1])),
    )
    assert found.steps == close(circle_and_angle, np.array([0.3, 0.4, 0.0]), range(3)).steps
    np.testing.assert_allclose(found.x[:2] @ found.x[:2], 4 * unit**2, rtol=1e-12)
    np.testing.assert_allclose(found.x[2], found.x[0] / unit, rtol=1e-12)


def circle_and_angle(x):
    """The same in one unit."""
    return np.array([x[0] ** 2 + x[1] ** 2 - 4, x[2] - x[0]]), np.array([[2 * x[0], 2 * x[1], 0], [-1, 0, 1]])


@pytest.mark.parametrize("off", [1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8])
def test_what_follows_from_the_rest_where_all_is_closed_moves_nothing(off):
    """x = y, twice: beside it the two rows seem to be independent, by as much as x and y are apart."""

    def function(x):
        gap = x[0] - x[1]
        return np.array([gap, gap * (1 + x[0])]), np.array([[1, -1], [1 + x[0] + gap, -1 - x[0]]])

    found = close(function, np.array([0.3, 0.3 + off]), range(2))
    assert found.size <= 1e-13
    assert np.abs(found.x - 0.3).max() <= 2 * off
