# SPDX-License-Identifier: BSD-3-Clause
"""Mode shapes: eigenfunctions against their properties, functions of one's own, tables, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.errors import ModelError
from kane.model import FAMILIES, foreshortening, moments_beyond
from kane.numeric import gauss

RULE = gauss(80)
EIGENVALUES = {  # Blevins (1979), table 8-1
    "clamped-free": (1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839),
    "free-free": (4.73004074, 7.85320462, 10.9956079, 14.1371655, 17.2787597),
    "pinned": tuple(np.pi * np.arange(1, 6)),
}


@pytest.mark.parametrize("family", ["clamped-free", "free-free", "pinned", "rod", "polynomials", "rod polynomials"])
def test_orthonormal(family: str) -> None:
    values = kn.mode_shapes(family, 12).evaluate(RULE.places, 0)
    np.testing.assert_allclose(RULE.gram(values, values), np.eye(12), atol=1e-12)


@pytest.mark.parametrize("family", sorted(EIGENVALUES))
def test_eigenfunctions(family: str) -> None:
    """∫ φ''² = β⁴, and no other products."""
    curvatures = kn.mode_shapes(family, 12).evaluate(RULE.places, 2)
    stiff = RULE.gram(curvatures, curvatures)
    beta = np.diag(stiff) ** 0.25
    np.testing.assert_allclose(beta[:5], EIGENVALUES[family], rtol=1e-8)
    np.testing.assert_allclose(stiff / np.multiply.outer(beta, beta) ** 2, np.eye(12), atol=1e-12)


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_derivatives_and_ends(family: str) -> None:
    shapes, x, h = kn.mode_shapes(family, 5), np.linspace(0.1, 0.9, 9), 1e-5
    for order in (0, 1):
        slope = (shapes.evaluate(x + h, order) - shapes.evaluate(x - h, order)) / (2 * h)
        size = np.abs(shapes.evaluate(x, order + 1)).max()
        np.testing.assert_allclose(slope, shapes.evaluate(x, order + 1), atol=1e-6 * size)
    for end, orders in ((0, FAMILIES[family].root), (1, FAMILIES[family].tip)):
        for order in orders:
            np.testing.assert_allclose(shapes.at(end, order), 0, atol=1e-12 * np.abs(shapes.evaluate(x, order)).max())


def test_functions_of_ones_own_are_differentiated() -> None:
    shapes = kn.mode_shapes([lambda x: 1 - np.cos(np.pi * x), lambda x: x**3])
    x = np.linspace(0, 1, 11)
    expected = np.array([np.pi**2 * np.cos(np.pi * x), 6 * x]).T
    np.testing.assert_allclose(shapes.evaluate(x, 2), expected, atol=1e-8)


@pytest.mark.parametrize("slopes", [False, True])
def test_tables(slopes: bool) -> None:
    """A table of the eigenfunctions gives their stiffness to the error of cubic elements."""
    own = kn.mode_shapes("clamped-free", 2)
    x = np.linspace(0, 1, 41)
    columns = [own.evaluate(x, k) for k in range(2 if slopes else 1)]
    shapes = kn.mode_shapes(table=(x, *columns))
    rule = gauss(4, shapes.breaks)
    curvatures = shapes.evaluate(rule.places, 2)
    np.testing.assert_allclose(np.diag(rule.gram(curvatures, curvatures)), [1.87510407**4, 4.69409113**4], rtol=1e-3)


def test_foreshortening_and_its_moments() -> None:
    """H and ∫ r H, ∫ r ξ H of polynomials, by hand: φ = ξ², H = 4 ξ³/3; r = 1 − ξ/2."""
    shapes = kn.mode_shapes([lambda x: x**2])
    np.testing.assert_allclose(foreshortening(shapes, 0.6), [[4 * 0.6**3 / 3]], rtol=1e-13)
    slopes = shapes.evaluate(RULE.places, 1)
    m0, m1 = moments_beyond(kn.tapered(1, lambda x: 1 - x / 2).share, RULE.places)
    np.testing.assert_allclose(RULE.gram(slopes, slopes, m0), [[4 / 3 * (1 / 4 - 1 / 10)]], rtol=1e-12)
    np.testing.assert_allclose(RULE.gram(slopes, slopes, m1), [[4 / 3 * (1 / 5 - 1 / 12)]], rtol=1e-12)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"kind": "clamped", "count": 2}, "Did you mean clamped-free"),
    ({"kind": "rod", "count": 0}, "a number of modes from 1 to 1000, got 0"),
    ({"kind": "rod"}, "a number of modes from 1 to 1000, got None"),
    ({"kind": 3}, "mode shapes as a name and a count"),
    ({"kind": [lambda x: np.abs(x - 0.3)]}, "smooth functions as mode shapes, got function 1"),
    (
        {"kind": [lambda x: "a"]},
        "function 1 of the mode shapes to take an array of ξ and give a number for each, got ValueError",
    ),
    ({"kind": [lambda x: x, lambda x: x if x < 1 else 2]}, "function 2 of the mode shapes to take an array of ξ"),
    (
        {"kind": [lambda: 3]},
        "function 1 of the mode shapes to take an array of ξ and give a number for each, got TypeError",
    ),
    ({"kind": [lambda x: x[:2]]}, "a finite number for each"),
    ({"table": (np.linspace(0, 1, 5), np.zeros((4, 2)))}, "array of 5 positions × modes, got the shape"),
    ({"table": (np.linspace(0, 1, 5), np.zeros(5))}, "array of 5 positions × modes"),
    ({"table": (np.linspace(0, 1, 5), np.zeros((5, 2)), np.zeros((5, 1)))}, "slopes of the tabulated modes"),
    ({"table": (np.linspace(0, 2, 5), np.zeros((5, 2)))}, "increase from 0 to 1"),
    ({"table": ("a", "b")}, "arrays of real numbers, got"),
    ({"table": (np.linspace(0, 1, 5), [[1, 2], [3]])}, "arrays of real numbers, got"),
    ({"table": (np.linspace(0, 1, 5) + 0j, np.zeros((5, 1)))}, "arrays of real numbers, got"),
    ({"table": 3}, r"table=\(ξ, values\)"),
]


@pytest.mark.parametrize(("given", "said"), WRONG, ids=[said[:30] for _, said in WRONG])
def test_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        kn.mode_shapes(**given)
