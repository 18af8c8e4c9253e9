# SPDX-License-Identifier: BSD-3-Clause
"""Rooted trees, by which the conditions of order of Runge–Kutta methods count: Hairer, Nørsett & Wanner I, sec. II.2."""

from collections import Counter
from functools import cache
from math import factorial, prod


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


@cache
def nodes(tree):
    return 1 + sum(map(nodes, tree))


@cache
def density(tree):
    """γ: a tree's nodes times those of all that its nodes bear."""
    return nodes(tree) * prod(map(density, tree))


@cache
def symmetry(tree):
    """σ: in how many ways a tree's branches may be exchanged for one another."""
    return prod(factorial(times) * symmetry(branch) ** times for branch, times in Counter(tree).items())
