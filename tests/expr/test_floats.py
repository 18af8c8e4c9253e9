# SPDX-License-Identifier: BSD-3-Clause
"""Python's floats against NumPy's: every operation at every kind of number, and random graphs, bit by bit."""

import itertools

import numpy as np
import pytest
from hypothesis import given

from kane import coordinates
from kane.expr import FLOAT, OPS, Walk
from tests.expr.expressions import Program, programs

x, y = coordinates("x, y")
NUMBERS = (0.0, -0.0, 1.0, -2.5, 0.5, np.inf, -np.inf, np.nan, 5e-324, 1e308)


def same(a, b):
    """The same double, NaN of any kind being one."""
    return np.float64(a).tobytes() == np.float64(b).tobytes() or (a != a and b != b)


@pytest.mark.parametrize("op", FLOAT, ids=lambda op: op.name)
def test_an_operation_gives_what_numpy_gives(op):
    with np.errstate(all="ignore"):
        for args in itertools.product(NUMBERS, repeat=op.arity):
            found = FLOAT[op](*args)
            assert type(found) is float
            assert same(found, op.numpy(*map(np.float64, args))), args


def test_every_operation_is_there():
    own = {op for op in FLOAT if op.name in OPS}  # tables that were made come besides
    assert own == {op for op in OPS.values() if op.arity}


@given(programs())
def test_all_ways_through_a_graph_agree(program: Program) -> None:
    walk = Walk([program.root, *program.nodes()])
    first, second, third = walk(program.at), walk(program.at), walk(program.at)
    arrays = walk({s: np.array([v, v]) for s, v in program.at.items()})
    for a, b, c, d in zip(first, second, third, arrays, strict=True):
        assert same(a, b)
        assert same(a, c)
        if np.ndim(d):
            # NumPy may round functions of arrays in another way than those of numbers
            assert d[0] == pytest.approx(a, rel=1e-9, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("at", [(0.0, 0.0), (0.0, -0.0), (1.0, 0.0), (-1.0, -0.0), (np.inf, 1.0), (3.0, 4.0)])
def test_products_within_sums_round_and_overflow_as_they_stand(at):
    roots = [x * y + x, x + x * y, x * y - x, x - x * y, x * y + y * y, x * y - x * x, x / y - y / x, (x - y).sqrt()]
    walk, values = Walk(roots), dict(zip((x, y), at, strict=True))
    arrays = walk({s: np.array([v]) for s, v in values.items()})
    for _ in range(3):
        assert all(same(a, b[0]) for a, b in zip(walk(values), arrays, strict=True))
