# SPDX-License-Identifier: BSD-3-Clause
"""The linear equations of the Whipple bicycle: Meijaard, Papadopoulos, Ruina & Schwab 2007, Proc. R. Soc. A 463, 1955-1982.

M q̈ + v C1 q̇ + (g K0 + v² K2) q = f for lean and steer: the matrices are eqs. (5.3) to (5.5), the eigenvalues those of table 2.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import whipple_bicycle

G, RADIUS = 9.81, 0.3
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
TABLE_2 = {
    0: [3.13164324790656, -3.13164324790656, 5.53094371765393, -5.53094371765393],
    5: [
        -0.32286642900409,
        -14.07838969279822,
        -0.77534188219585 + 4.46486771378823j,
        -0.77534188219585 - 4.46486771378823j,
    ],
}


@functools.cache
def linear(v: float) -> kn.Linear:
    """Linearized upright and straight ahead at forward speed v."""
    eom = equations()
    q = dict.fromkeys((s.name for s in eom.coordinates), 0.0)
    at = kn.assemble(eom, q=q, u={"u1": 0, "u4": 0, "u5": -v / RADIUS})
    return linearizer()(q=at.q, u=at.u, independent=("u1", "u4", "u5"))


@functools.cache
def equations() -> kn.Equations:
    return kn.derive(whipple_bicycle.system())


@functools.cache
def linearizer() -> kn.Linearizer:
    return kn.linearizer(equations())


def form(v: float) -> kn.SecondOrder:
    return linear(v).second_order(["phi", "delta"])


def published(v: float) -> Any:
    """Eigenvalues of the published matrices."""
    back = np.linalg.inv(M)
    return np.linalg.eigvals(
        np.block([[np.zeros((2, 2)), np.eye(2)], [-back @ (G * K0 + v**2 * K2), -back @ (v * C1)]])
    )


def roots(v: float) -> Any:
    """kane's eigenvalues of lean and steer: of the five, all but that of the forward speed, which is kept."""
    own = linear(v).without("cyclic")
    assert own.states == ("phi", "delta", "u1", "u4", "u5")
    found = own.eigenvalues
    kept = np.argmin(np.abs(found))
    assert abs(found[kept]) < 1e-9
    return np.delete(found, kept)


def apart(found: Any, expected: Any) -> float:
    """Largest distance of paired eigenvalues, relative to their size."""
    left = list(found)
    assert len(left) == len(expected)
    worst = 0.0
    for r in expected:
        nearest = min(left, key=lambda s: abs(s - r))
        left.remove(nearest)
        worst = max(worst, abs(nearest - r) / abs(r))
    return worst


@pytest.mark.parametrize(
    ("name", "expected"),
    [("M", M), ("C1", C1), ("K0", K0), ("K2", K2)],
)
def test_matrices(name: str, expected: Any) -> None:
    """Entry by entry, and what is zero is zero."""
    found = {
        "M": lambda: form(0.0).M,
        "C1": lambda: form(1.0).C,
        "K0": lambda: form(0.0).K / G,
        "K2": lambda: form(1.0).K - form(0.0).K,
    }[name]()
    zero = expected == 0
    np.testing.assert_allclose(found[~zero], expected[~zero], rtol=1e-12)
    np.testing.assert_allclose(found[zero], 0, atol=1e-11)


def test_no_damping_at_rest() -> None:
    np.testing.assert_allclose(form(0.0).C, 0, atol=1e-11)
    np.testing.assert_allclose(form(0.0).F, np.eye(2), atol=1e-11)


@pytest.mark.parametrize("v", range(1, 11))
def test_the_matrices_are_those_of_every_speed(v: int) -> None:
    found = form(float(v))
    for own, expected in ((found.M, M), (found.C, v * C1), (found.K, G * K0 + v**2 * K2)):
        np.testing.assert_allclose(own, expected, rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("v", range(11))
def test_eigenvalues(v: int) -> None:
    assert apart(roots(float(v)), published(v)) < 1e-11


@pytest.mark.parametrize("v", TABLE_2)
def test_table_2(v: int) -> None:
    """To the printed digits."""
    assert apart(published(v), TABLE_2[v]) < 1e-13
    assert apart(roots(float(v)), TABLE_2[v]) < 1e-11
