# SPDX-License-Identifier: BSD-3-Clause
"""What notebooks show of vectors and dyadics."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

q1, q2 = kn.coordinates("q1:3")
m, R = kn.parameters("m, R")
N = kn.Frame("N")
B = N.rotate("B1", q1, N.z)


@pytest.mark.parametrize(
    ("vector", "latex"),
    [
        (q1.dt * B.z, r"\dot{q}_{1}\,\hat{b}_{1z}"),
        (N.x - 2 * N.y - q1 * B.x, r"\hat{n}_{x} - 2\,\hat{n}_{y} - q_{1}\,\hat{b}_{1x}"),
        (-N.x, r"-\hat{n}_{x}"),
        ((q1 + q2) * N.x, r"\left(q_{1} + q_{2}\right)\,\hat{n}_{x}"),
        (N.y + (-q1 - q2) * N.x, r"-\left(q_{1} + q_{2}\right)\,\hat{n}_{x} + \hat{n}_{y}"),
        ((1 - q2) * N.x, r"\left(1 - q_{2}\right)\,\hat{n}_{x}"),
        (kn.less(q1, q2) * N.x, r"\left(q_{1} \lt q_{2}\right)\,\hat{n}_{x}"),
        (kn.Vector(), "0"),
        (kn.Frame("<b>").x, r"\hat{e}_{x,\,\mathrm{\lt b\gt }}"),
        (2 * kn.Frame("coupler").z, r"2\,\hat{e}_{z,\,\mathrm{coupler}}"),
    ],
)
def test_vectors(vector: kn.Vector, latex: str) -> None:
    assert vector._repr_latex_() == rf"$\displaystyle {latex}$"


def test_dyadics() -> None:
    assert kn.inertia(B, m, 0, R)._repr_latex_() == (
        r"$\displaystyle m\,\hat{b}_{1x} \hat{b}_{1x} + R\,\hat{b}_{1z} \hat{b}_{1z}$"
    )
    assert kn.Dyadic()._repr_latex_() == r"$\displaystyle 0$"
    assert (N.x.outer(N.y) - N.x.outer(N.y))._repr_latex_() == r"$\displaystyle 0$"


def test_a_dyadic_multiplied_out_is_the_same_dyadic() -> None:
    """Terms along pairs of unit vectors are those of the matrix of measure numbers."""
    dyadic = (2 * N.x + 3 * N.y).outer(5 * N.x - N.z)
    assert dyadic._repr_latex_() == (
        r"$\displaystyle 10\,\hat{n}_{x} \hat{n}_{x} - 2\,\hat{n}_{x} \hat{n}_{z} + 15\,\hat{n}_{y} \hat{n}_{x} - "
        r"3\,\hat{n}_{y} \hat{n}_{z}$"
    )
    numbers = [[float(x) for x in row] for row in dyadic.components(N)]
    np.testing.assert_array_equal(numbers, [[10, 0, -2], [15, 0, -3], [0, 0, 0]])


def test_a_very_long_vector_is_a_sentence() -> None:
    e: kn.Expr = q1
    for _ in range(2001):
        e = kn.sin(e)
    assert (e * N.x)._repr_latex_() == "A vector of 2001 operations, too long to typeset; print() shows it."
