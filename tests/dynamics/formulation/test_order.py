# SPDX-License-Identifier: BSD-3-Clause
"""The order of elimination: no fill where a tree has none, full matrices as they are, the same numbers in any order."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import Matrix
from kane.dynamics import Blocks, block_solution
from kane.expr import ONE, ZERO, ldl, sparse_order
from kane.gallery import snakeboard


def pattern(pairs, n):
    rows = [[ONE if i == j else ZERO for j in range(n)] for i in range(n)]
    for i, j in pairs:
        rows[i][j] = rows[j][i] = ONE
    return rows


def fill(rows, order):
    """Entries of L that are not those of the matrix, with symbols in the places of what is not zero."""
    n = len(rows)
    symbols = [[ZERO] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            if rows[i][j] is not ZERO:
                symbols[i][j] = symbols[j][i] = kn.parameter(f"m{i}{j}")
    turned = [[symbols[i][j] for j in order] for i in order]
    lower = ldl(turned).lower
    return sum(lower[a][b] is not ZERO and turned[a][b] is ZERO for a in range(n) for b in range(a))


def test_a_full_matrix_keeps_its_order():
    assert sparse_order([[ONE] * 5] * 5) == list(range(5))


def test_an_arrow_is_eliminated_from_its_tips():
    rows = pattern([(0, k) for k in range(1, 6)], 6)
    assert sparse_order(rows)[:4] == [1, 2, 3, 4]
    assert fill(rows, range(6)) == 10
    assert fill(rows, sparse_order(rows)) == 0


@pytest.mark.parametrize("seed", range(5))
def test_a_tree_is_never_filled(seed):
    """The mass matrix of a tree by joints: entries between each joint and those before it on its branch."""
    rng = np.random.default_rng(seed)
    parent = [-1, *(int(rng.integers(k)) for k in range(1, 9))]
    pairs = []
    for k in range(9):
        p = parent[k]
        while p >= 0:
            pairs.append((k, p))
            p = parent[p]
    rows = pattern(pairs, 9)
    assert fill(rows, sparse_order(rows)) == 0


@pytest.mark.parametrize("seed", range(10))
def test_the_numbers_are_those_of_any_order(seed):
    """Random sparse M with reactions that enter f, so that both are solved together."""
    rng = np.random.default_rng(seed)
    n, r = 6, 2
    m = np.eye(n) * 4
    for _ in range(5):
        i, j = rng.integers(n, size=2)
        m[i, j] = m[j, i] = m[i, j] + 0.3
    f, g = rng.normal(size=n), rng.normal(size=(n, r)) * (rng.random((n, r)) < 0.5)
    m_a, f_a, g_a = rng.normal(size=(r, n)), rng.normal(size=r), np.eye(r) + 0.1 * rng.normal(size=(r, r))
    whole = np.block([[m, -g], [m_a, -g_a]])
    wanted = np.linalg.solve(whole, [*f, *f_a])
    found = block_solution(
        Blocks(Matrix(m.tolist()), tuple(map(kn.expr.as_expr, f.tolist())), Matrix(g.tolist()), Matrix(m_a.tolist()),
               tuple(map(kn.expr.as_expr, f_a.tolist())), Matrix(g_a.tolist()), Matrix(g_a.tolist()))
    )  # fmt: skip
    numbers = kn.evaluate([*found.accelerations, *found.reactions], {})
    assert np.array(numbers, dtype=float) == pytest.approx(wanted, rel=1e-10, abs=1e-10)


def test_the_snakeboard_s_board_is_eliminated_last():
    assert kn.derive(snakeboard.system()).operations.total <= 107
