# SPDX-License-Identifier: BSD-3-Clause
"""Matching of rows and columns: as large as SciPy's, and without recursion."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from kane.expr import ONE, ZERO, matched_columns, structural_rank


@given(
    st.integers(1, 9).flatmap(
        lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=n, max_size=n)
    )
)
def test_the_rank_is_that_of_a_maximum_matching(entries):
    rows = [[ONE if x else ZERO for x in row] for row in entries]
    match = matched_columns(rows)
    taken = [c for c in match if c >= 0]
    assert len(set(taken)) == len(taken) == structural_rank(rows, len(rows))
    assert all(rows[i][c] is ONE for i, c in enumerate(match) if c >= 0)
    assert len(taken) == np.sum(maximum_bipartite_matching(csr_array(np.array(entries, dtype=int))) >= 0)


def test_a_long_chain_is_matched_without_recursion():
    """Row k holds columns k and k + 1; the last row holds the first column alone and moves all others on."""
    n = 1010
    zeros = [ZERO] * n
    rows = [[*zeros[:k], ONE, ONE, *zeros[k + 2 :]] for k in range(n - 1)] + [[ONE, *zeros[1:]]]
    assert matched_columns(rows) == [*range(1, n), 0]


def test_a_triangular_matrix_is_matched_at_once():
    """Row k holds the columns 0 to k, as sums of rates do: by augmenting paths alone 500 rows take some seconds."""
    n = 500
    rows = [[ONE] * (k + 1) + [ZERO] * (n - k - 1) for k in range(n)]
    assert matched_columns(rows) == list(range(n))
    assert matched_columns(rows[::-1]) == list(range(n))[::-1]
