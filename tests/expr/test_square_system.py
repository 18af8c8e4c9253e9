# SPDX-License-Identifier: BSD-3-Clause
"""Square systems that are solved wherever their determinant is not zero, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import free_symbols
from kane.errors import SingularError
from kane.expr import ZERO, Adjugate, InOrder, Triangular, guarding, guards, square, unguarded

EPS = np.finfo(float).eps


def symbols(pattern):
    """Entries a_ij where the pattern is not zero, and a right-hand side."""
    n = len(pattern)
    rows = [[kn.parameter(f"a{i}_{j}") if pattern[i][j] else ZERO for j in range(n)] for i in range(n)]
    return rows, [kn.parameter(f"b{i}") for i in range(n)]


def solved(rows, b, numbers, right):
    """x at numbers, with guards, and the solver."""
    solver = square(rows)
    x = solver.solve(b)
    before = [e for row in rows for e in row]
    x = list(map(guarding(guards([(d.value, d.size) for d in solver.divisors], before, x)), x))
    values = {
        s: v for row, line in zip(rows, numbers, strict=True) for s, v in zip(row, line, strict=True) if s is not ZERO
    }
    return np.array(kn.evaluate(x, values | dict(zip(b, right, strict=True)))), solver


PATTERNS = [
    [[1]],
    [[1, 1], [1, 1]],
    [[0, 1], [1, 1]],
    [[1, 1, 1], [1, 1, 1], [1, 1, 1]],
    [[0, 1, 1], [1, 0, 1], [1, 1, 0]],
    [[1, 1, 0, 0], [1, 1, 1, 0], [0, 0, 1, 1], [0, 0, 1, 1]],
    np.ones((4, 4), int).tolist(),
    [[0, 1, 1, 1], [1, 0, 1, 1], [1, 1, 0, 1], [1, 1, 1, 0]],
    np.ones((5, 5), int).tolist(),
    [[1, 1, 1, 1, 1, 1], *[[0] * k + [1] * (6 - k) for k in range(1, 6)]],
]


@pytest.mark.slow
@pytest.mark.parametrize("pattern", PATTERNS, ids=str)
def test_every_regular_matrix_is_solved_with(pattern, rng):
    """Leading minors that vanish, rows of other units, and ordinary numbers."""
    rows, b = symbols(pattern)
    mask, n = np.array(pattern, bool), len(pattern)
    tried = 0
    for k in range(60):
        numbers = np.where(mask, rng.integers(-2, 3, (n, n)).astype(float) if k % 2 else rng.normal(size=(n, n)), 0)
        if abs(np.linalg.det(numbers)) < 0.3:
            continue
        tried += 1
        numbers *= (10.0 ** rng.integers(-3, 4, n))[:, None]
        right = rng.normal(size=n) * np.abs(numbers).max(axis=1)
        x, _ = solved(rows, b, numbers, right)
        level = numbers / np.abs(numbers).max(axis=1)[:, None]
        wanted = np.linalg.solve(level, right / np.abs(numbers).max(axis=1))
        assert np.abs(x - wanted).max() <= 100 * EPS * np.linalg.cond(level) * np.abs(wanted).max()
    assert tried > 5


@pytest.mark.parametrize("pattern", PATTERNS, ids=str)
def test_where_the_determinant_vanishes_nothing_is_finite_that_depends_on_it(pattern, rng):
    rows, b = symbols(pattern)
    mask, n = np.array(pattern, bool), len(pattern)
    numbers = np.where(mask, rng.normal(size=(n, n)), 0)
    numbers[n - 1] = 0 if n == 1 else numbers[n - 1]
    if n > 1:  # the last row is made to follow from others of its pattern, or, where there are none, is empty
        others = [i for i in range(n - 1) if not (mask[i] & ~mask[n - 1]).any()]
        numbers[n - 1] = sum((rng.normal() * numbers[i] for i in others), np.zeros(n))
    assert abs(np.linalg.det(numbers)) < 1e-13
    x, _ = solved(rows, b, numbers, rng.normal(size=n))
    assert np.isnan(x).any()
    assert not np.isinf(x).any()


@given(st.integers(-40, 40), st.integers(-40, 40))
def test_the_units_of_rows_do_not_matter(i, j):
    rows, b = symbols(np.ones((4, 4), int).tolist())
    numbers = np.random.default_rng(3).normal(size=(4, 4))
    scale = 2.0 ** np.array([i, j, 0, -i])
    x, _ = solved(rows, b, numbers * scale[:, None], scale)
    assert np.abs(x - np.linalg.solve(numbers, np.ones(4))).max() < 1e-12


def test_the_order_given_is_kept_where_its_pivots_cannot_vanish():
    q = kn.coordinate("q")
    a, c = kn.parameters("a c")
    assert isinstance(square([[q / q, a], [c, q]]), InOrder)
    assert isinstance(square([[1 + q**2, a], [c, q]]), InOrder)
    assert isinstance(square([[q, a], [ZERO, c]]), InOrder)
    rotation = square([[kn.cos(q), kn.sin(q)], [-kn.sin(q), kn.cos(q)]])
    assert isinstance(rotation, Triangular)
    assert isinstance(rotation.blocks[0][2], Adjugate)
    assert rotation.divisors == ()
    assert isinstance(square([[a, c], [c, q]]), Triangular)  # a parameter may be zero


def test_a_matrix_without_an_inverse_is_refused():
    a, b = kn.parameters("a b")
    with pytest.raises(SingularError, match="determinant 0"):
        square([[a, b], [a, b]])
    with pytest.raises(SingularError, match="structural rank 1 of 2"):
        square([[a, b], [ZERO, ZERO]])


def test_what_is_left_of_zero_is_told_from_what_is_small():
    """cos q beside 1, a difference beside its terms, a length beside itself."""
    q, x = kn.coordinates("q x")
    r, s = kn.parameters("r s")
    for divisor, zero, small in (
        (r * kn.cos(q), {q: np.pi / 2}, {q: np.pi / 2 - 1e-9}),
        (r * kn.cos(q) + s * kn.sin(q), {q: np.arctan2(-1e-6, 1e-6)}, {q: -0.7}),
        (r - s, {s: np.nextafter(1e-6, 1)}, {s: 1e-6 * (1 + 1e-9)}),
        (x, {x: 0.0}, {x: 1e-30}),
    ):
        found = square([[divisor]])
        quotient = guarding(guards([(d.value, d.size) for d in found.divisors], [], []))(1 / divisor)
        usual = {q: 0.3, x: 0.4, r: 1e-6, s: 1e-6}
        assert np.isnan(kn.evaluate(quotient, usual | zero))
        assert np.isfinite(kn.evaluate(quotient, usual | small))
        assert unguarded([quotient])[0] is 1 / divisor
        assert str(quotient) == str(1 / divisor)


@pytest.mark.parametrize("transposed", [False, True])
def test_parameters_of_whole_columns_or_rows_stay_out_of_the_determinant(transposed):
    """A loop of two links: sin (q1 − q2) is compared with 1, whatever their lengths."""
    (p, q), (a, b) = kn.coordinates("p q"), kn.parameters("a b")
    rows = [[a * kn.sin(p), b * kn.sin(q)], [a * kn.cos(p), b * kn.cos(q)]]
    rows = [list(row) for row in zip(*rows, strict=True)] if transposed else rows
    right = list(kn.parameters("f g"))
    x, solver = square(rows).solve(right), square(rows)
    assert not {a, b} & set(free_symbols([solver.divisors[0].value]))
    assert kn.count_operations(x).total <= 4 + 3 + 6 + 4
    guarded = list(map(guarding(guards([(d.value, d.size) for d in solver.divisors], [], x)), x))
    for shift in (0.7, 0.0):
        numbers = {p: 0.4 + shift, q: 0.4, a: 1e-9, b: 3e5, right[0]: 0.3, right[1]: -2.0}
        found = np.array(kn.evaluate(guarded, numbers))
        matrix = np.array([kn.evaluate(row, numbers) for row in rows])
        assert np.isnan(found).all() if shift == 0 else found == pytest.approx(np.linalg.solve(matrix, [0.3, -2.0]))
