# SPDX-License-Identifier: BSD-3-Clause
"""Dyadics against matrices."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.paths import Path, numbers

N = kn.Frame("N")
q = kn.coordinates("q1:4")
A = N.rotate("A", q[0], N.y)
B = A.rotate_body("B", q, "zxz")
STATE = Path(q, 5).values()
M1 = np.array([[1.0, 0.5, 0], [0, 2, -0.25], [0.75, 0, 3]])
M2 = np.array([[0.0, 1, 2], [1, 0, 0], [-2, 0, 0.5]])


def turn(frame):
    return numbers(N.dcm(frame), STATE)


def in_n(matrix, frame):
    return turn(frame) @ matrix @ turn(frame).T


D1, D2 = kn.Dyadic.of(A, M1), kn.Dyadic.of(B, M2)
E1, E2 = in_n(M1, A), in_n(M2, B)


def along(d, frame=N):
    return numbers(d.components(frame), STATE)


@pytest.mark.parametrize("frame", [N, A, B], ids=lambda f: f.name)
def test_components(frame):
    assert along(D1, frame) == pytest.approx(turn(frame).T @ E1 @ turn(frame), abs=1e-14)
    assert along((D1 + D2).express(frame)) == pytest.approx(E1 + E2, abs=1e-14)
    assert D1.express(frame).frames() == (frame,)


def test_algebra():
    k = q[1]
    assert along(D1 + D2) == pytest.approx(E1 + E2, abs=1e-14)
    assert along(D1 - D2) == pytest.approx(E1 - E2, abs=1e-14)
    assert along(-D1) == pytest.approx(-E1, abs=1e-14)
    assert along(k * D1) == pytest.approx(STATE[k] * E1, abs=1e-14)
    assert along(D1 * 2 / k) == pytest.approx(2 * E1 / STATE[k], abs=1e-13)
    assert along(sum([D1, D2])) == pytest.approx(E1 + E2, abs=1e-14)
    assert (D1 + D2).frames() == (A, B)


def test_dot():
    v = N.x * q[0] - 2 * B.z
    numeric = numbers(v.components(N), STATE)
    assert numbers((D1 + D2).dot(v).components(N), STATE) == pytest.approx((E1 + E2) @ numeric, abs=1e-13)
    assert D1.dot(kn.Vector()).is_zero


def test_order_of_the_vectors_in_a_dyad():
    dyad = N.x.outer(N.y)
    assert str(dyad.dot(N.y)) == "N.x"
    assert dyad.dot(N.x).is_zero
    assert along(dyad) == pytest.approx(np.outer([1, 0, 0], [0, 1, 0]))


def test_unit_dyadic_is_the_same_in_every_frame():
    unit = kn.Dyadic.of(A, np.eye(3))
    assert along(unit, B) == pytest.approx(np.eye(3), abs=1e-15)


def test_zero_dyads_are_left_out():
    assert str(kn.Dyadic.of(N, np.zeros((3, 3)))) == "0"
    assert str(0 * N.x.outer(N.y)) == "0"
    assert str(N.x.outer(N.y - N.y)) == "0"
    assert str(N.x.outer(2 * N.y)) == "(N.x)(2 N.y)"


def test_frozen():
    with pytest.raises(AttributeError, match="frozen"):
        D1.dyads = ()
    with pytest.raises(kn.SpaceError, match="Expected a dyadic"):
        D1 + N.x
