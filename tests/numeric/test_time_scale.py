# SPDX-License-Identifier: BSD-3-Clause
"""The pace of ẋ = A x against closed forms, eigenvalues and other units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane.numeric import pace


@pytest.mark.parametrize(
    ("a", "expected"),
    [
        ([[0, 1], [-9, 0]], 3),
        ([[-5]], 5),
        ([[0, 1], [0, 0]], 0),
        ([[0, 1, 0], [0, 0, 1], [0, 0, 0]], 0),
        ([[0, 1, 0, 0], [-4, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1e6, 0]], 1e3),
        (np.zeros((0, 0)), 0),
    ],
)
def test_closed_forms(a, expected):
    assert pace(np.array(a, dtype=float)) == pytest.approx(expected)


@given(st.integers(0, 2**32 - 1), st.integers(1, 7))
def test_it_is_near_the_spectral_radius_and_the_same_in_other_units(seed, n):
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.5)
    radius = np.abs(np.linalg.eigvals(np.abs(a))).max()
    found = pace(a)
    if found:
        assert radius / n * (1 - 1e-9) <= found <= radius * (1 + 1e-9)
    else:
        assert not np.linalg.matrix_power((a != 0).astype(int), n).any()
    units = 10.0 ** rng.uniform(-6, 6, n)
    assert pace(a * units / units[:, None]) == pytest.approx(found, rel=1e-12)
