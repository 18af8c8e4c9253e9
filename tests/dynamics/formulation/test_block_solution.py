# SPDX-License-Identifier: BSD-3-Clause
"""The linear system of u̇ and the reactions against NumPy's solution of the whole block system."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import Blocks, block_solution
from kane.errors import SingularError
from kane.expr import ZERO


def symbols(name, rows, columns):
    return [[kn.parameter(f"{name}{i}_{j}") for j in range(columns)] for i in range(rows)]


def blocks(mass, forcing, coupling, mass_a, forcing_a, coupling_a):
    n, r = len(forcing), len(forcing_a)
    g, m_a, g_a = kn.Matrix(coupling, (n, r)), kn.Matrix(mass_a, (r, n)), kn.Matrix(coupling_a, (r, r))
    return Blocks(kn.Matrix(mass), tuple(forcing), g, m_a, tuple(forcing_a), g_a, g_a)


def values_of(block, numbers):
    return {s: v for row, line in zip(block, numbers, strict=True) for s, v in zip(row, line, strict=True)}


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize(("n", "r"), [(1, 0), (4, 0), (1, 1), (3, 1), (4, 2), (2, 3)])
def test_against_the_block_system(n, r, coupled):
    """[[M, −G], [M_a, −G_a]] [u̇; R] = [f; f_a]."""
    rng = np.random.default_rng(10 * n + r)
    square = rng.normal(size=(n, n))
    M, f = square @ square.T + np.eye(n), rng.normal(size=n)
    G = rng.normal(size=(n, r)) if coupled else np.zeros((n, r))
    Ma, fa, Ga = rng.normal(size=(r, n)), rng.normal(size=r), rng.normal(size=(r, r))
    m, ma, ga = symbols("M", n, n), symbols("Ma", r, n), symbols("Ga", r, r)
    for i in range(n):
        for j in range(i):
            m[i][j] = m[j][i]
    g = symbols("G", n, r) if coupled else [[ZERO] * r for _ in range(n)]
    right, right_a = kn.parameters(f"f0:{n}"), kn.parameters(f"h0:{r}") if r else ()
    solved = block_solution(blocks(m, list(right), g, ma, list(right_a), ga))
    numbers = values_of(m, M) | values_of(ma, Ma) | values_of(ga, Ga) | dict(zip(right, f, strict=True))
    numbers |= dict(zip(right_a, fa, strict=True)) | (values_of(g, G) if coupled else {})
    found = np.array(kn.evaluate([*solved.accelerations, *solved.reactions], numbers))
    whole = np.block([[M, -G], [Ma, -Ga]]) if r else M
    assert found == pytest.approx(np.linalg.solve(whole, np.concatenate([f, fa])), rel=1e-9)
    assert np.prod(kn.evaluate(list(solved.pivots), numbers)) == pytest.approx(np.linalg.det(M))
    if r:
        matrix = kn.evaluate(solved.reaction_matrix, numbers)
        assert matrix == pytest.approx(Ga - Ma @ np.linalg.solve(M, G))
        assert kn.evaluate(solved.bare_reaction_matrix, numbers) == pytest.approx(Ga)


def test_diagonal_reactions_are_divided_by():
    a, b, c, d = kn.parameters("a b c d")
    solved = block_solution(blocks([[a]], [b], [[ZERO, ZERO]], [[c], [ZERO]], [c, d], [[a, ZERO], [ZERO, b]]))
    assert [str(x) for x in solved.accelerations] == ["b/a"]
    assert str(solved.reactions[1]) == "-d/b"


def test_a_reaction_that_its_own_equation_lacks():
    a, b = kn.parameters("a b")
    with pytest.raises(SingularError, match="own equation"):
        block_solution(blocks([[a]], [b], [[ZERO]], [[b]], [a], [[ZERO]]))


def test_pivoting_at_run_time():
    """The block of the reactions may have a zero pivot at some states: rows change places where they must."""
    one, zero = kn.parameter("one"), kn.parameter("zero")
    solved = block_solution(
        blocks([[one]], [one], [[ZERO] * 2], [[ZERO], [ZERO]], [-one, -2 * one], [[zero, one], [one, zero]])
    )
    assert np.array(kn.evaluate(list(solved.reactions), {one: 1.0, zero: 0.0})) == pytest.approx([2, 1])
    assert np.array(kn.evaluate(list(solved.reactions), {one: 1.0, zero: 0.5})) == pytest.approx([2, 0])
