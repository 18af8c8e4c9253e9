# SPDX-License-Identifier: BSD-3-Clause
"""Matrices of expressions."""

import pickle

import numpy as np
import pytest

from kane import Matrix, coordinates, evaluate
from kane.errors import ExpressionError
from kane.expr import ONE, ZERO, dot
from tests.expr.expressions import identical

x, y = coordinates("x, y")
A = Matrix([[x, 1, y], [0, x * y, 2]])


def test_shape_and_entries() -> None:
    assert A.shape == (2, 3)
    assert len(A) == 2
    assert A[0, 2] is y
    assert A[-1, -1] is A[1, 2]
    assert [len(row) for row in A] == [3, 3]
    assert A.T.shape == (3, 2)
    assert all(A.T[j, i] is A[i, j] for i in range(2) for j in range(3))


def test_products_and_sums() -> None:
    unit = Matrix.identity(3)
    assert all((A @ unit)[i, j] is A[i, j] for i in range(2) for j in range(3))
    square = A @ A.T
    assert square.shape == (2, 2)
    assert square[0, 1] is square[1, 0]
    assert (A @ (x, 0, 1))[0] is x * x + y
    assert (A + A)[0, 0] is 2 * x
    assert (A - A)[1, 1] is ZERO
    assert (-A)[0, 2] is -y
    assert (2 * A)[1, 1] is 2 * (x * y)
    assert (A * 2)[1, 1] is 2 * (x * y)
    assert dot((x, y), (ONE, ZERO)) is x


def test_products_have_the_values_that_numpy_has() -> None:
    at = {x: 0.3, y: -1.2}
    a, product = evaluate(A, at), evaluate(A @ A.T, at)
    assert a.shape == (2, 3)
    assert product == pytest.approx(a @ a.T, rel=1e-15)


def test_evaluation_over_arrays_puts_the_matrix_last() -> None:
    value = evaluate(A, {x: np.array([0.1, 0.2, 0.3, 0.4]), y: 2.0})
    assert value.shape == (4, 2, 3)
    assert value[2] == pytest.approx(np.array([[0.3, 1, 2], [0, 0.6, 2]]))


def test_matrices_without_rows_or_columns() -> None:
    none = Matrix([], (2, 0))
    assert none.T.shape == (0, 2)
    assert len(none.rows) == 2
    assert (none @ none.T).shape == (2, 2)
    assert all(e is ZERO for row in (none @ none.T) for e in row)
    assert (none.T @ none).shape == (0, 0)
    assert identical(none @ (), (ZERO, ZERO))


def test_sizes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ExpressionError, match=r"lengths \[1, 2\]"):
        Matrix([[1], [1, 2]])
    with pytest.raises(ExpressionError, match=r"\(2, 3\) @ \(2, 3\)"):
        A @ A
    with pytest.raises(ExpressionError, match="length 3, got 1"):
        A @ (x,)
    with pytest.raises(ExpressionError, match="one shape"):
        A + A.T


def test_frozen_and_pickled() -> None:
    with pytest.raises(AttributeError, match="frozen"):
        A.rows = ()
    again = pickle.loads(pickle.dumps(A))
    assert all(again[i, j] is A[i, j] for i in range(2) for j in range(3))


def test_to_numpy() -> None:
    array = A.to_numpy()
    assert array.dtype == object
    assert array.shape == (2, 3)
    assert array[1, 1] is x * y


def test_text() -> None:
    assert repr(Matrix([[x, 1], [0, y]])) == "Matrix([[x, 1],\n        [0, y]])"


def test_parts_of_a_matrix() -> None:
    assert identical(A.entries, [e for row in A.rows for e in row])
    assert identical(Matrix.column(A.entries).T.rows[0], A.entries)
    assert A.take([1], [2, 0]).shape == (1, 2)
    assert identical(A.take([1], [2, 0]).entries, (A[1, 2], A[1, 0]))
    assert identical(A.take(columns=[1]).entries, (A[0, 1], A[1, 1]))
    assert A.take([]).shape == (0, 3)
    assert A.take(columns=[]).shape == (2, 0)
    square = (A @ A.T).mirrored()
    assert square[0, 1] is square[1, 0]
    assert square[1, 0] is (A @ A.T)[1, 0]
