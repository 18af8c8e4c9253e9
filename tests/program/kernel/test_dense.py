# SPDX-License-Identifier: BSD-3-Clause
"""Small matrices in kernels against NumPy's, and in all languages alike."""

import numpy as np
import pytest

from kane.program import INT, CompiledKernel, Writer, decompose, factor, invert, solve, substitute
from tests.program.kernel.kernels import EXACT, agree


def kernel(write):
    """Of an array `a`, the width of its rows and how many of them count."""
    w = Writer("small")
    a, width, count = w.array("a"), w.number("width"), w.number("count")
    write(w, a, width, count)
    return w.finished(w.variable("back", INT))


def cholesky(w, a, n, k):
    factor(a, w.integer(0), n, k)
    solve(a, w.integer(0), n, k, n * n)


def elimination(w, a, n, k):
    decompose(a, w.integer(0), n, n * n)
    substitute(a, w.integer(0), n, n * n, n * n + n)


ELIMINATION = kernel(elimination)
CHOLESKY = kernel(cholesky)
INVERSE = kernel(lambda w, a, n, k: invert(a, w.integer(0), n))


@pytest.mark.parametrize(("size", "count"), [(1, 1), (3, 2), (6, 6)])
def test_positive_definite_systems_are_solved(size, count, rng):
    rows = rng.normal(size=(size, size + 2))
    matrix, right = rows @ rows.T, rng.normal(size=size)
    a = np.append(matrix.reshape(-1), right)
    CompiledKernel(CHOLESKY, EXACT)({"a": a, "width": size, "count": count})
    assert matrix[:count, :count] @ a[size * size :][:count] == pytest.approx(right[:count], rel=1e-10)


@pytest.mark.parametrize("size", [1, 2, 7])
def test_systems_are_solved_though_their_first_entry_vanishes(size, rng):
    matrix, right = rng.normal(size=(size, size)), rng.normal(size=size)
    matrix[0, 0] = 0.0 if size > 1 else 2.0
    a = np.concatenate([matrix.reshape(-1), np.zeros(size), right])
    CompiledKernel(ELIMINATION, EXACT)({"a": a, "width": size, "count": size})
    assert a[-size:] == pytest.approx(np.linalg.solve(matrix, right), rel=1e-10)


@pytest.mark.parametrize("size", [1, 2, 7])
def test_matrices_are_inverted_though_their_first_entry_vanishes(size, rng):
    matrix = rng.normal(size=(size, size))
    matrix[0, 0] = 0.0 if size > 1 else 2.0
    a = np.hstack([matrix, np.eye(size)]).reshape(-1)
    CompiledKernel(INVERSE, EXACT)({"a": a, "width": size, "count": size})
    assert a.reshape(size, -1)[:, size:] == pytest.approx(np.linalg.inv(matrix), rel=1e-10)


def test_a_singular_matrix_gives_no_finite_inverse():
    a = np.array([[1.0, 2.0, 1, 0], [2.0, 4.0, 0, 1]]).reshape(-1)
    CompiledKernel(INVERSE, EXACT)({"a": a, "width": 2, "count": 2})
    assert not np.isfinite(a).all()


@pytest.mark.parametrize("made", [CHOLESKY, INVERSE, ELIMINATION])
def test_every_language_gives_the_same_bits(made, rng, tmp_path):
    a = np.append(np.eye(4) + 0.1 * rng.normal(size=(4, 4)), rng.normal(size=16))
    agree(made, {"a": a, "width": 4, "count": 4}, tmp_path / "k.c")
