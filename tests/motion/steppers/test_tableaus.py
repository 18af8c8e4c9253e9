# SPDX-License-Identifier: BSD-3-Clause
"""Tables of explicit methods meet the order conditions of all rooted trees: Hairer, Nørsett & Wanner I, sec. II.2."""

import numpy as np
import pytest
from mpmath import mp  # type: ignore[import-untyped]

from kane.motion import DOP853, RK4, TSIT5, TSITPAP8, VERN9
from tests.motion.steppers import bootstrapped
from tests.motion.steppers.rooted import density, symmetry, trees

ORDERS = [(DOP853, (5, 3), 7), (TSITPAP8, (7,), 7), (TSIT5, (4,), 4), (RK4, (), 3), (VERN9, (8,), 8)]
"""A method, the orders of what its estimates compare with, and that of its dense output."""


def matrix(tableau):
    """A of all stages, those of dense output too; row S is b."""
    last = len(tableau.b)
    rows = [(), *tableau.a, tableau.b, *(row for _, row in tableau.later)]
    a = np.zeros((last + 1 + len(tableau.later),) * 2)
    for i, row in enumerate(rows):
        a[i, : len(row)] = row
    return a


def weights(a, tree):
    """What each stage gives of the derivative that belongs to a tree."""
    found = np.ones(len(a))
    for branch in tree:
        found = found * (a @ weights(a, branch))
    return found


def polynomials(tableau, theta):
    """The weights of all stages in y at a share of the step."""
    found, factor = np.zeros(len(tableau.dense[0])), theta
    for k, row in enumerate(tableau.dense):
        found += factor * np.array(row)
        factor *= theta if k % 2 else 1 - theta
    return found


def test_there_are_as_many_trees_as_there_should_be():
    assert [len(trees(n)) for n in range(1, 10)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]


@pytest.mark.parametrize(("tableau", "embedded", "dense"), ORDERS, ids=lambda x: getattr(x, "name", None))
def test_order_conditions(tableau, embedded, dense):
    """Of y', of each estimate, and of dense output at some shares of the step; and y' has no order more."""
    a, count = matrix(tableau), len(tableau.dense[0])
    b = np.append(tableau.b, np.zeros(len(a) - len(tableau.b)))
    left = {n: max(abs(b @ weights(a, t) - 1 / density(t)) for t in trees(n)) for n in range(1, tableau.order + 2)}
    assert max(left[n] for n in range(1, tableau.order + 1)) < 1e-13
    assert left[tableau.order + 1] > 1e-9
    for order, row in zip(embedded, tableau.errors, strict=True):
        own = np.append(row, np.zeros(len(a) - len(row)))
        assert max(abs(own @ weights(a, t)) for n in range(1, order + 1) for t in trees(n)) < 1e-12
        assert max(abs(own @ weights(a, t)) for t in trees(order + 1)) > 1e-9
    for theta in (0.1, 0.35, 0.5, 0.81, 1.0):
        at = polynomials(tableau, theta)
        for n in range(1, dense + 1):
            for tree in trees(n):
                assert at @ weights(a, tree)[:count] == pytest.approx(theta**n / density(tree), abs=2e-13)


def test_a_pair_has_the_numbers_of_its_source():
    c, a, b, errors = bootstrapped.source()
    assert TSITPAP8.c == tuple(map(float, c))
    assert TSITPAP8.a == tuple(tuple(map(float, row)) for row in a)
    assert TSITPAP8.b == tuple(map(float, b))
    assert TSITPAP8.errors == ((*map(float, errors), 0.0),)


@pytest.mark.slow
def test_dense_output_that_is_not_published_is_worked_out_anew():
    """In 50 digits: every number of it, to the last digit."""
    later, ends = bootstrapped.dense()
    for (c, row), (at, weights) in zip(TSITPAP8.later, later, strict=True):
        assert (c, *row) == (float(at), *map(float, weights))
    assert TSITPAP8.dense[3:] == tuple(tuple(map(float, row)) for row in ends)


@pytest.mark.parametrize("theta", [0.25, 0.5, 0.7])
def test_the_first_stage_more_stands_where_order_6_can_be_met(theta):
    """Elsewhere no weights of the pair's own stages meet its conditions; at the ends and at (7 ± √7)/14 there are some."""
    with mp.workdps(50):
        own = bootstrapped.Conditions(bootstrapped.own_rows(), 6)
        for share in (mp.mpf(1), (7 - mp.sqrt(7)) / 14, (7 + mp.sqrt(7)) / 14):
            assert abs(sum(own.nearest(lambda q, share=share: share**q)) - share) < 1e-40
        with pytest.raises(AssertionError, match="conditions that contradict each other"):
            own.nearest(lambda q: mp.mpf(theta) ** q)


def test_dense_output_errs_less_than_that_of_another_method_of_order_8():
    """By the conditions of order 8, which neither meets, at shares of the step: by a tenth."""
    left = [max(residual(t, theta) for theta in np.arange(0.05, 1, 0.05)) for t in (TSITPAP8, DOP853)]
    assert 0 < left[0] < 0.1 * left[1]


def residual(tableau, theta):
    a, at = matrix(tableau), polynomials(tableau, theta)
    missed = [(at @ weights(a, t)[: len(at)] - theta**8 / density(t)) / symmetry(t) for t in trees(8)]
    return np.linalg.norm(missed)
