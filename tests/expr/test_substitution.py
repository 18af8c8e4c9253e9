# SPDX-License-Identifier: BSD-3-Clause
"""Replacement of leaves and nodes."""

import pytest
from hypothesis import given

import kane as kn
from kane import Expr, coordinates
from kane.expr import ONE, ZERO, as_expr, postorder, substituted
from tests.expr.expressions import M, Program, X, Y, programs, value_of

x, y, z = coordinates("x, y, z")


def test_what_changes_is_rewritten_and_the_rest_stays() -> None:
    e = x * y.sin() + y.sin() / z
    assert substituted(e, {x: ZERO}) is y.sin() / z
    assert substituted(e, {x: z}) is z * y.sin() + y.sin() / z
    assert substituted(e, {}) is e
    assert substituted(y.sin(), {x: z}) is y.sin()


def test_replacement_is_simultaneous() -> None:
    assert substituted(x - y, {x: y, y: x}) is y - x


def test_nodes_can_be_replaced() -> None:
    assert substituted((x + y) * z, {x + y: ONE}) is z
    assert substituted(x + y, {x + y: z}) is z


@given(programs())
def test_a_replacement_of_equal_value_keeps_the_value(program: Program) -> None:
    """No place where an operation is not defined is met."""
    x_value, _, _, m_value = program.values
    expected = value_of(program.root, program.values)
    for instead in (as_expr(x_value), M + (x_value - m_value), M * (x_value / m_value)):
        replaced = substituted(program.root, {X: instead})
        assert X not in set(postorder([replaced]))
        assert abs(value_of(replaced, program.values) - expected) <= 1e-9 * (1 + abs(expected))


@given(programs())
def test_back_and_forth(program: Program) -> None:
    there = substituted(program.root, {X: Y, Y: X})
    back = substituted(there, {X: Y, Y: X})
    ours, theirs = value_of(back, program.values), value_of(program.root, program.values)
    assert abs(ours - theirs) <= 1e-10 * (1 + abs(theirs))


def test_a_memo_is_shared() -> None:
    memo: dict[Expr, Expr] = {}
    e = (x + y).sin()
    substituted(e, {x: z}, memo)
    assert memo[e] is (z + y).sin()
    assert substituted(e * y, {x: z}, memo) is (z + y).sin() * y


def test_a_deep_graph() -> None:
    e: Expr = x
    for _ in range(10_000):
        e = (e + y).sin()
    assert y not in set(postorder([substituted(e, {y: z})]))


def test_numbers_names_and_whatever_is_made_of_expressions() -> None:
    frame = kn.Frame("N")
    assert kn.substitute(x * y + 1, {x: 0}) is ONE
    assert kn.substitute(x * y, {"x": 2, y: z}) is 2 * z
    assert kn.substitute([x, (y, x)], {"x": 3}) == [as_expr(3), (y, as_expr(3))]
    assert kn.substitute(kn.Matrix([[x, y]]), {x: y}).entries[0] is y
    assert kn.substitute(x * frame.x + y * frame.y, {"y": 0}).dot(frame.y) is ZERO
    with pytest.raises(kn.ValueMissingError, match=r"names of symbols to replace .x, y., got 'z'"):
        kn.substitute(x + y, {"z": 1})
    with pytest.raises(kn.ExpressionError, match="to substitute in, got 'x'"):
        kn.substitute("x", {x: 1})
