# SPDX-License-Identifier: BSD-3-Clause
"""Constraints in numbers at many places: row by row or all at once, the same."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import ROWS, in_rows
from kane.expr import Walk, compile_reference
from tests.systems import rings

X, Y, K = kn.coordinate("x"), kn.coordinate("y"), kn.parameter("k", 1.0)


@pytest.mark.parametrize("rows", [0, 1, ROWS, ROWS + 1])
@pytest.mark.parametrize("k", [2.0, np.float64(2.0), "each"])
def test_few_rows_and_many(rows, k):
    run = compile_reference([kn.sin(X) * K, X / Y, 3 * K], [X, Y, K])
    x = np.random.default_rng(1).normal(size=(rows, 2))
    given = np.linspace(1.0, 2.0, rows) if isinstance(k, str) else k
    found = in_rows(run, x, [given])
    assert found.shape == (rows, 3)
    expected = np.stack([np.sin(x[:, 0]) * given, x[:, 0] / x[:, 1], 3 * given * np.ones(rows)], axis=1)
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_division_by_zero_is_infinite_in_a_few_rows_as_in_many():
    run = compile_reference([X / Y], [X, Y])
    assert np.isinf(in_rows(run, np.array([[1.0, 0.0]]), [])).all()


def test_a_ring_is_assembled_in_floats(monkeypatch):
    """Places are looked at one after the other, each by the list of instructions: node by node the graph is hardly walked."""
    walked = []
    through = Walk._through

    def counted(self, *args):
        walked.append(self)
        return through(self, *args)

    eom = kn.derive(rings.ring(14))
    monkeypatch.setattr(Walk, "_through", counted)
    guesses = {q: kn.guess(0.1 * k) for k, q in enumerate(eom.coordinates)}
    at = kn.assemble(eom, q=guesses, u={u: kn.guess(0.1) for u in eom.speeds})
    assert len(at.q) == 14
    assert len(walked) <= 20
