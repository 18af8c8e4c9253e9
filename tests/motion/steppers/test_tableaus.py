# SPDX-License-Identifier: BSD-3-Clause
"""Tables of explicit methods meet the order conditions of all rooted trees: Hairer, Nørsett & Wanner I, sec. II.2."""

from functools import cache
from math import prod

import numpy as np
import pytest

from kane.motion.steppers.dop853 import DOP853
from kane.motion.steppers.rk4 import RK4
from kane.motion.steppers.tsit5 import TSIT5
from kane.motion.steppers.vern9 import VERN9

ORDERS = [(DOP853, (5, 3), 7), (TSIT5, (4,), 4), (RK4, (), 3), (VERN9, (8,), 8)]
"""A method, the orders of what its estimates compare with, and that of its dense output."""


@cache
def trees(n):
    """All rooted trees with n nodes, each as the tuple of what its root bears."""
    return forests(n - 1, n - 1)


@cache
def forests(n, most):
    """All sets of trees with n nodes, none of which has more than `most`."""
    if n == 0:
        return ((),)
    found = {
        tuple(sorted((tree, *rest)))
        for k in range(1, min(n, most) + 1)
        for tree in trees(k)
        for rest in forests(n - k, k)
    }
    return tuple(sorted(found))


def nodes(tree):
    return 1 + sum(map(nodes, tree))


def density(tree):
    return nodes(tree) * prod(map(density, tree))


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
