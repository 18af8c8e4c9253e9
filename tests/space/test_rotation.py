# SPDX-License-Identifier: BSD-3-Clause
"""The change of basis along the tree: shared direction cosines, common bases, what it costs."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.expr import ONE, ZERO
from kane.space import common_base, connected, cost, enter, express, leave, path, single
from tests.paths import numbers

N = kn.Frame("N")
a, b, c = kn.coordinates("a b c")
A = N.rotate("A", a, N.z)
B = A.rotate("B", b, A.x)
C = N.rotate("C", c, N.y)
STATE = {a: 0.3, b: -0.7, c: 1.9}
x, y, z = kn.parameters("x y z", 1.0)


def turn(frame):
    return numbers(N.dcm(frame), STATE)


def test_express_between_all_pairs():
    v = np.array([0.4, -1.2, 2.2])
    triple = tuple(kn.Rational(0) + float(x) for x in v)
    for source in (N, A, B, C):
        for target in (N, A, B, C):
            found = numbers(express(triple, source, target), STATE)
            assert found == pytest.approx(turn(target).T @ turn(source) @ v, abs=1e-14)


def test_multiples_of_a_unit_vector_share_its_cosines():
    first, second = express((x, ZERO, ZERO), B, N), express((y, ZERO, ZERO), B, N)
    unit = express((ONE, ZERO, ZERO), B, N)
    assert all(f is x * u and s is y * u for f, s, u in zip(first, second, unit, strict=True))


def test_path_leaves_only_what_must_be_left():
    up, down = path(B, C)
    assert ([f.name for f in up], [f.name for f in down]) == (["B", "A"], ["C"])
    assert path(B, B) == ((), ())
    assert common_base(B, C) is N
    assert common_base(B, A) is A
    assert common_base(A, B) is A
    assert connected(A, C)
    assert not connected(A, kn.Frame("M"))


def test_enter_undoes_leave():
    assert all(p is q for p, q in zip(enter(A, leave(A, (ZERO, ZERO, z))), (ZERO, ZERO, z), strict=True))
    back = numbers(enter(B, leave(B, (x, y, z))), STATE)
    assert back == pytest.approx([1, 1, 1], abs=1e-15)


@pytest.mark.parametrize(
    ("triple", "place"),
    [((x, ZERO, ZERO), 0), ((ZERO, x, ZERO), 1), ((ZERO, ZERO, x), 2), ((ZERO,) * 3, None), ((x, y, ZERO), None),
     ((x, ZERO, z), None), ((ZERO, y, z), None)],
)  # fmt: skip
def test_single(triple, place):
    assert single(triple) == place


def test_cost_is_zero_along_the_axis_of_rotation():
    assert cost((ZERO, ZERO, z), A, N) == 0
    assert 0 < cost((x, ZERO, ZERO), A, N) < cost((x, y, ZERO), A, N)
    assert cost((x, y, z), A, A) == 0
