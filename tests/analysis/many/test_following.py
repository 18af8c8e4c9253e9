# SPDX-License-Identifier: BSD-3-Clause
"""Roots followed along data: on their branch, up to its end."""

import numpy as np
import pytest

import kane as kn
from kane.analysis import Unknowns, follow
from kane.program import CompiledRoutine, Port, Task, build_program

X, Y, D, SCALE = kn.coordinate("x"), kn.coordinate("y"), kn.input("d"), kn.parameter("scale")


def routine(f, gradient):
    """f and ∂f/∂x of t, (x, y), a parameter and d."""
    ports = (
        Port("t", (kn.time,), scalar=True),
        Port("x", (X, Y)),
        Port("p", (SCALE,), "parameter"),
        Port("r", (D,)),
    )
    roots = (*f, *gradient)
    program = build_program("roots", ports, [Task("roots", roots, (len(roots),), [str(k) for k in range(len(roots))])])
    return CompiledRoutine(program, "roots", kn.Settings(cache=False), not_finite="ignore")


def followed(code, d, x, places=(0,)):
    """Along d, where the parameter is 2."""
    data = np.zeros((len(d), 5))
    data[:, 3], data[:, 4] = 2.0, d
    n = len(x)
    return follow(code, data, np.array(x), Unknowns(places, np.ones(n), np.ones(n), 1))


@pytest.fixture(scope="module")
def parabola():
    """scale x² = d: two branches that meet at a fold at zero."""
    return routine([SCALE * X**2 - 2 * D], [2 * SCALE * X])


def test_both_branches_of_a_root(parabola):
    d = np.linspace(4, 0.01, 50)
    for sign in (1, -1):
        found = followed(parabola, d, [2.0 * sign])
        assert not found.ends
        np.testing.assert_allclose(found.x[:, 0], sign * np.sqrt(d), rtol=1e-14)


def test_a_branch_ends_at_a_fold_and_is_taken_up_again(parabola):
    found = followed(parabola, [1.0, 0.5, -0.5, -1.0, 0.25], [1.0])
    assert sorted(found.ends) == [2, 3]
    assert np.isnan(found.x[2:4]).all()
    np.testing.assert_allclose(found.x[4], 0.5, rtol=1e-14)
    end = found.ends[2]
    assert end.last == 1
    np.testing.assert_allclose(end.share, 0.5, atol=1e-4)
    np.testing.assert_allclose(end.x, 0.0, atol=0.02)


def test_long_ways_are_gone_in_parts():
    """exp x = d by steps no longer than half a unit."""
    found = followed(routine([kn.exp(X) - D], [kn.exp(X)]), np.exp([0.0, 5.0, -3.0]), [0.0])
    np.testing.assert_allclose(found.x[:, 0], [0, 5, -3], atol=1e-13)


def test_what_is_linear_follows_without_a_size():
    """x³ = d, and 10⁶ x y = 1 beside it: y, which is not measured, is large where x is small."""
    code = routine([X**3 - D, 1e6 * X * Y - 1], [3 * X**2, 0 * X, 1e6 * Y, 1e6 * X])
    d = np.geomspace(1, 1e-6, 30)
    found = followed(code, d, [1.0, 1e-6], (0, 1))
    np.testing.assert_allclose(found.x, np.stack([np.cbrt(d), 1e-6 / np.cbrt(d)], axis=1), rtol=1e-13)


def test_more_rows_than_one_call_takes(parabola):
    """The way goes on where a call has ended: the other branch is as near."""
    d = 1 + 0.5 * np.sin(np.linspace(0, 60, 25_001))
    found = followed(parabola, d, [-np.sqrt(d[0])])
    np.testing.assert_allclose(found.x[:, 0], -np.sqrt(d), rtol=1e-14)
