# SPDX-License-Identifier: BSD-3-Clause
"""Elimination in a given order against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.errors import SingularError
from kane.expr import ZERO, lu


@pytest.mark.parametrize("n", [1, 2, 4])
def test_factors_and_solution(n):
    numbers = np.random.default_rng(n).normal(size=(n, n + 1)) + 3 * np.eye(n, n + 1)
    table = [[kn.parameter(f"a{i}_{j}") for j in range(n + 1)] for i in range(n)]
    rows, b = [row[:n] for row in table], [row[n] for row in table]
    values = {s: x for row, line in zip(table, numbers, strict=True) for s, x in zip(row, line, strict=True)}
    factors = lu(rows)
    lower, upper = np.eye(n), np.zeros((n, n))
    for i in range(n):
        lower[i, :i] = kn.evaluate(factors.lower[i], values) if i else []
        upper[i] = kn.evaluate(factors.upper[i], values)
    assert np.tril(upper, -1) == pytest.approx(0)
    assert lower @ upper == pytest.approx(numbers[:, :n])
    assert np.diag(upper) == pytest.approx(np.array(kn.evaluate(list(factors.pivots), values)))
    assert np.array(kn.evaluate(factors.solve(b), values)) == pytest.approx(
        np.linalg.solve(numbers[:, :n], numbers[:, n])
    )


def test_a_pivot_that_is_zero_is_named():
    a, b = kn.parameters("a b")
    with pytest.raises(SingularError, match="row 2 of 2"):
        lu([[a, b], [a, b]])
    with pytest.raises(SingularError, match="row 1 of 1"):
        lu([[ZERO]])
