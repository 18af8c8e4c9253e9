# SPDX-License-Identifier: BSD-3-Clause
"""Builders: what is rewritten keeps the value, and reads as it should."""

import math

import mpmath  # type: ignore[import-untyped]
import numpy as np
import pytest
from hypothesis import given

from kane import Expr, Rational, coordinates, parameter, pi
from kane.errors import ExpressionError
from kane.expr import BUILDERS, NODE_BUILDERS, ONE, OPS, ZERO, as_expr, constant_value, postorder
from tests.expr.expressions import MP, Program, programs, values_of

x, y, z = coordinates("x, y, z")
sin, cos = BUILDERS["sin"], BUILDERS["cos"]


@given(programs())
def test_rewriting_keeps_the_value(program: Program) -> None:
    ours, direct = values_of(program.nodes(), program.values), program.direct()
    for a, b in zip(ours, direct, strict=True):
        assert abs(a - b) <= 1e-11 * (1 + abs(b))


@given(programs())
def test_signs_and_constants_stand_outside(program: Program) -> None:
    for node in postorder(program.nodes()):
        if node.op.name in ("add", "mul", "div", "neg"):
            assert all(a.op.name != "neg" for a in node.args)
        if node.op.name == "mul":
            assert node.args[1].op.name != "const"
        value = constant_value(node.args[0]) if node.op.name == "mul" else None
        assert value is None or value > 0


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (x + 0, x),
        (0 + x, x),
        (x - 0, x),
        (0 - x, -x),
        (x * 1, x),
        (x * 0, ZERO),
        (x / 1, x),
        (0 / x, ZERO),
        (x - x, ZERO),
        (x / x, ONE),
        (x + x, 2 * x),
        (x + 2 * x, 3 * x),
        (5 * x - 2 * x, 3 * x),
        (2 * x - 2 * x, ZERO),
        (0.1 * x + 0.2 * x, (0.1 + 0.2) * x),
        (x + -x, ZERO),
        ((-x).__neg__(), x),
        (+x, x),
        (x + -y, x - y),
        (-x + y, y - x),
        (-x - y, -(x + y)),
        (-x * y, -(x * y)),
        (-x * -y, x * y),
        (x / -y, -(x / y)),
        (-2 * x, -(2 * x)),
        (2 * (3 * x), 6 * x),
        (x / 4, 0.25 * x),
        ((x + y) - y, x),
        ((x + y) - x, y),
        (x - (x + y), -y),
        ((x - y) + y, x),
        (x - (x - y), y),
        ((x - y) - x, -y),
        (x * y / y, x),
        (x / y * y, x),
        (x / (x * y), 1 / y),
        (1 / (1 / x), x),
        (x / (y / z), x * z / y),
        (x * (1 / y), x / y),
        (sin(x) * sin(x) + cos(x) * cos(x), ONE),
        (cos(x) ** 2 + sin(x) ** 2, ONE),
        (x.sqrt() * x.sqrt(), x),
        (x**0, ONE),
        (x**1, x),
        (x**2, x * x),
        (x**-2, 1 / (x * x)),
        (x**0.5, x.sqrt()),
        (x**-0.5, 1 / x.sqrt()),
        (as_expr(4).sqrt(), as_expr(2)),
        (Rational(4, 9).sqrt(), Rational(2, 3)),
        (as_expr(3) ** 2, as_expr(9)),
        (as_expr(0) ** 2.5, ZERO),
        (x.max(x), x),
        (x.min(y), y.min(x)),
        (abs(-x), abs(x)),
        ((-x).cosh(), x.cosh()),
        ((-x).tanh(), -x.tanh()),
        ((-x).sign(), -x.sign()),
        ((-x).atan(), -x.atan()),
        (as_expr(1).less(2).where(x, y), x),
        (as_expr(2).less(1).where(x, y), y),
        (x.less(y).where(z, z), z),
    ],
)
def test_local_rewriting(made: Expr, expected: Expr) -> None:
    assert made is expected


def test_of_two_opposite_differences_one_exists() -> None:
    assert (x - y) is -(y - x)
    assert (x - y) + (y - x) is ZERO


def test_nothing_is_expanded() -> None:
    assert (x * (y + z)).op.name == "mul"
    assert ((x + y) ** 2).op.name == "mul"


@pytest.mark.parametrize("turns", range(-5, 6))
def test_quarter_turns(turns: int) -> None:
    quarter = turns * pi / 2
    assert constant_value(sin(quarter)) == (0, 1, 0, -1)[turns % 4]
    assert constant_value(cos(quarter)) == (1, 0, -1, 0)[turns % 4]
    assert sin(x + quarter) is (sin(x), cos(x), -sin(x), -cos(x))[turns % 4]
    assert cos(x + quarter) is (cos(x), -sin(x), -cos(x), sin(x))[turns % 4]
    assert sin(quarter - x) is (-sin(x), cos(x), sin(x), -cos(x))[turns % 4]
    assert cos(quarter - x) is (cos(x), sin(x), -cos(x), -sin(x))[turns % 4]
    assert sin(-(x + quarter)) is -sin(x + quarter)


@pytest.mark.parametrize("turns", [1, -1, 2, 3, 4, 6])
def test_quarter_turns_as_floating_point_numbers(turns: int) -> None:
    assert constant_value(cos(turns * math.pi / 2)) == (1, 0, -1, 0)[turns % 4]
    assert sin(x + turns * (math.pi / 2)) is (sin(x), cos(x), -sin(x), -cos(x))[turns % 4]


def test_other_angles_stay() -> None:
    assert sin(x + pi / 3).op.name == "sin"
    assert constant_value(sin(1)) == math.sin(1)
    assert constant_value(cos(Rational(1, 2))) == math.cos(0.5)
    assert sin(pi / 5).op.name == "sin"


def test_small_powers_become_products_and_larger_ones_stay() -> None:
    assert {n.op.name for n in postorder([x**16])} == {"symbol", "mul"}
    assert (x**17).op.name == "pow"
    assert (x**2.5).op.name == "pow"
    assert (2**x).op.name == "pow"
    assert len(postorder([x**16])) == 5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: x / 0, "Division of x by the constant 0"),
        (lambda: x / (y - y), "Division of x by the constant 0"),
        (lambda: as_expr(-1).sqrt(), "Square root of the negative constant -1"),
        (lambda: as_expr(0).log(), "Logarithm of the constant 0"),
        (lambda: as_expr(2).asin(), "asin of the constant 2"),
        (lambda: as_expr(1000).exp(), "finite number"),
        (lambda: as_expr(1000).sinh(), "finite number"),
        (lambda: as_expr(1e300) ** 1.5, "finite number"),
        (lambda: as_expr(1e300) * 1e300, "finite number"),
        (lambda: x * math.nan, "finite number"),
        (lambda: x + math.inf, "finite number"),
        (lambda: math.inf - x, "finite number"),
        (lambda: BUILDERS["where"](x, 1, 2), r"Expected a condition kn.less\(a, b\)"),
        (lambda: BUILDERS["sin"](x, y), "sin takes 1 argument"),
        (lambda: BUILDERS["sin"]("x"), "Expected a real number or an expression, got str"),
    ],
)
def test_what_cannot_be_is_refused(make, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        make()


@pytest.mark.parametrize("other", ["1", None, [1], 1j, {}])
def test_operands_that_are_no_numbers_are_left_to_python(other) -> None:
    for combine in (lambda: x + other, lambda: other * x, lambda: x / other, lambda: other - x):
        with pytest.raises(TypeError):
            combine()


def test_functions_take_numbers() -> None:
    assert float(BUILDERS["atan2"](1, 1)) == math.pi / 4
    assert float(BUILDERS["max"](1, 2.5)) == 2.5
    assert BUILDERS["less"](x, 1).op.name == "less"


@pytest.mark.parametrize("name", [n for n, op in OPS.items() if op.arity == 1])
def test_functions_of_constants_are_folded(name: str) -> None:
    op = OPS[name]
    assert op.numpy is not None
    assert float(NODE_BUILDERS[name](as_expr(0.3))) == pytest.approx(float(op.numpy(0.3)), rel=1e-15)


@pytest.mark.parametrize("name", [n for n, op in OPS.items() if op.arity])
def test_each_operation_is_a_method(name: str) -> None:
    if name in ("add", "sub", "mul", "div", "neg", "pow"):
        return
    args = (x.less(y), y, z)[: OPS[name].arity] if name == "where" else (x, y)[: OPS[name].arity]
    assert getattr(args[0], name)(*args[1:]) is NODE_BUILDERS[name](*args)


def test_parameters_are_not_replaced_by_their_defaults() -> None:
    m = parameter("m", 2.0)
    assert m * x is not 2 * x
    assert m in set(postorder([m * x]))


def test_the_second_route_is_accurate() -> None:
    """mpmath works with 50 digits here: the comparison is not between two roundings."""
    assert MP.dps == 50
    assert abs(MP.mpf(1) / 3 - mpmath.mpf(1) / 3) > 0
    assert np.finfo(float).eps > 1e-16
