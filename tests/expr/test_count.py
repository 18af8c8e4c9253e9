# SPDX-License-Identifier: BSD-3-Clause
"""Operation counts by tier."""

import pytest
from hypothesis import given

from kane import Expr, coordinates, count_operations, parameters, pi, time
from kane.expr import postorder
from tests.expr.expressions import Program, programs

x, y = coordinates("x, y")
m, k = parameters("m, k")


@pytest.mark.parametrize(
    ("exprs", "parameter", "state"),
    [
        ([x], 0, 0),
        ([-x], 0, 0),
        ([x + y], 0, 1),
        ([m * k * x], 1, 1),
        ([x.sin() + x.cos()], 0, 3),
        ([x.sin() * x.sin()], 0, 2),
        ([x * y + 1, x * y + 2], 0, 3),
        ([m / k, (m / k).sqrt() * time], 2, 1),
        ([pi / 2 - x], 0, 1),
        ([x - y, y - x], 0, 1),
        ([x.less(y).where(x, y), abs(x), x.max(y), x.sign()], 0, 0),
        ([], 0, 0),
    ],
)
def test_counts(exprs: list[Expr], parameter: int, state: int) -> None:
    count = count_operations(exprs)
    assert (count.parameter, count.state, count.total) == (parameter, state, parameter + state)


def test_one_expression_and_its_text() -> None:
    count = count_operations(m * k * x.sin() + x.sin() * y)
    assert count.by_operation == (("add", 1), ("mul", 3), ("sin", 1))
    assert str(count) == "5 operations: 4 with the state, 1 of parameters (1 add, 3 mul, 1 sin)"
    assert str(count_operations([x])) == "0 operations: 0 with the state, 0 of parameters"


@given(programs())
def test_each_operation_counts_once(program: Program) -> None:
    roots = program.nodes()
    together = count_operations(roots)
    assert together.total == sum(n for _, n in together.by_operation)
    assert together.total <= sum(n.op.cost for n in postorder(roots))
    assert count_operations([*roots, *roots]) == together
