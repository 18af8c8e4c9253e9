# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives against central differences with 50 digits, complex steps, SymPy, and each other."""

import numpy as np
import pytest
import sympy
from hypothesis import given

from kane.errors import ExpressionError
from kane.expr.diff import diff, euler_parameter_rates, gradient, jacobian, tangent, time_derivative
from kane.expr.evaluate import evaluate
from kane.expr.node import BUILDERS, ONE, ZERO, Expr, as_expr, postorder
from kane.expr.operators import rational
from kane.expr.ops import OPS
from kane.expr.symbols import (
    QuasiRate,
    Reaction,
    coordinate,
    coordinates,
    input,
    parameter,
    speed,
    time,
)
from kane.interop.sympy import to_sympy
from tests.expr.expressions import LEAVES, MP, SMOOTH, Program, identical, programs, value_of, values_of

x, y = coordinates("x, y")


def central_difference(program: Program, i: int):
    h = MP.mpf(10) ** -16
    ahead, behind = ([MP.mpf(v) + (s * h if j == i else 0) for j, v in enumerate(program.values)] for s in (1, -1))
    return (program.direct(ahead)[-1] - program.direct(behind)[-1]) / (2 * h)


@given(programs())
def test_forward_and_reverse_agree_with_central_differences(program: Program) -> None:
    root = program.root
    backward = values_of(list(gradient(root, LEAVES)), program.values)
    for i, leaf in enumerate(LEAVES):
        expected = central_difference(program, i)
        assert abs(value_of(diff(root, leaf), program.values) - expected) <= 1e-10 * (1 + abs(expected))
        assert abs(backward[i] - expected) <= 1e-10 * (1 + abs(expected))


@given(programs(operations=SMOOTH, length=6))
def test_derivatives_agree_with_sympy(program: Program) -> None:
    root = program.root
    at = {sympy.Symbol(leaf.name): sympy.Float(v, 40) for leaf, v in zip(LEAVES, program.values, strict=True)}
    for leaf in LEAVES[:2]:
        theirs = sympy.N(sympy.diff(to_sympy(root), sympy.Symbol(leaf.name)).subs(at), 30)
        ours = value_of(diff(root, leaf), program.values)
        assert abs(ours - MP.mpf(str(theirs))) <= 1e-10 * (1 + abs(ours))


COMPLEX = ("add", "sub", "mul", "div", "neg", "pow", "sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log")


@pytest.mark.parametrize("name", COMPLEX)
def test_single_operations_by_complex_steps(name: str) -> None:
    op, h = OPS[name], 1e-200
    assert op.numpy is not None
    values = (0.7, 1.3)[: op.arity]
    node = BUILDERS[name](*(x, y)[: op.arity])
    for i in range(op.arity):
        stepped = [complex(v, h if i == j else 0) for j, v in enumerate(values)]
        expected = op.numpy(*[np.complex128(v) for v in stepped]).imag / h
        got = evaluate(diff(node, (x, y)[i]), {x: 0.7, y: 1.3})
        assert got == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("expr", "derivative"),
    [
        (x * x, 2 * x),
        (x.sin(), x.cos()),
        (x.cos(), -x.sin()),
        (x.tan(), 1 + x.tan() * x.tan()),
        (x.exp(), x.exp()),
        (x.sqrt(), 1 / (2 * x.sqrt())),
        (x.log(), 1 / x),
        (3 * x - y, as_expr(3)),
        (y.sin(), ZERO),
        (rational(1, 2) * x * x, x),
        (abs(x), x.sign()),
        (x.sign(), ZERO),
        (x.max(y), y.less(x).where(1, 0)),
        (x.less(y).where(x * y, y), x.less(y).where(1, 0) * y),
    ],
)
def test_derivatives_read_well(expr: Expr, derivative: Expr) -> None:
    assert diff(expr, x) is derivative


def test_second_derivatives_commute() -> None:
    e = (x * y).sin() * (x / y).exp()
    at = {x: 0.3, y: 0.8}
    assert evaluate(diff(diff(e, x), y), at) == pytest.approx(float(evaluate(diff(diff(e, y), x), at)), rel=1e-13)


def test_gradient_of_a_leaf_and_of_a_constant() -> None:
    assert identical(gradient(x, (x, y)), (ONE, ZERO))
    assert identical(gradient(as_expr(3), (x,)), (ZERO,))


def test_reverse_mode_visits_only_what_depends_on_the_symbols() -> None:
    e = as_expr(-2) ** x * y  # ∂/∂x is not real
    assert identical(gradient(e, (y,)), (diff(e, y),))
    with pytest.raises(ExpressionError, match="Logarithm of the constant -2"):
        gradient(e, (x,))


def test_jacobian_by_rows_and_by_columns() -> None:
    tall = jacobian([x * y, x + y, x.sin()], [x, y])
    wide = jacobian([x * y], [x, y])
    assert tall.shape == (3, 2)
    assert [str(e) for e in tall.rows[0]] == ["y", "x"]
    assert identical(tall.rows[0], wide.rows[0])
    assert jacobian([x], []).shape == (1, 0)
    assert jacobian([], [x]).shape == (0, 1)


@given(programs())
def test_jacobian_is_the_same_by_both_modes(program: Program) -> None:
    roots = program.nodes()[-3:]
    wide = jacobian(roots, LEAVES)
    tall = jacobian([*roots, *roots], LEAVES)
    for i in range(3):
        by_rows, by_columns = (values_of(list(m.rows[i]), program.values) for m in (wide, tall))
        assert all(abs(a - b) <= 1e-10 * (1 + abs(a)) for a, b in zip(by_rows, by_columns, strict=True))


def test_time_derivative_brings_rates() -> None:
    q, u, m, torque = coordinate("q"), speed("u"), parameter("m"), input("T")
    assert time_derivative(q.sin()) is q.cos() * q.dt
    assert (q.sin()).dt is q.cos() * q.dt
    assert (m * u).dt is m * u.dt
    assert (time * time).dt is 2 * time
    assert (torque * time).dt is torque.dt * time + torque
    assert m.dt is ZERO
    assert q.dt.place is q  # type: ignore[attr-defined]


def test_rates_have_rates_of_their_own() -> None:
    q = coordinate("q", "rad")
    quasi = QuasiRate.declare("w1", None, "rad/s", "", (x, 1))
    assert (q.dt.name, q.dt.dt.name, q.dt.dt.place) == ("q'", "q''", q.dt)  # type: ignore[attr-defined]
    assert (x * q.dt).dt is x.dt * q.dt + x * q.dt.dt
    assert str(quasi.dt) == "w1'"


def test_a_reaction_has_no_named_rate() -> None:
    with pytest.raises(ExpressionError, match="reaction N_z has no name"):
        time_derivative(Reaction.declare("N_z") * x)


def test_tangents_share_a_memo() -> None:
    memo: dict[Expr, Expr] = {}
    e = (x * y).sin()
    first = tangent(e, {x: ONE}, memo)
    size = len(memo)
    assert tangent(e, {x: ONE}, memo) is first
    assert len(memo) == size


@pytest.mark.slow
def test_derivative_of_a_deep_graph() -> None:
    e: Expr = x
    for _ in range(10_000):
        e = (e + y).sin()
    assert diff(e, parameter("m")) is ZERO
    assert len(postorder([diff(e, x)])) > 20_000
    assert len(postorder(gradient(e, (x, y)))) > 20_000


def test_euler_parameters_keep_their_length() -> None:
    e = coordinates("e0:4")
    w = speed("w1"), speed("w2"), speed("w3")
    rates = euler_parameter_rates(e, w)
    total = ZERO
    for a, b in zip(e, rates, strict=True):
        total = total + a * b
    values = dict(zip((*e, *w), (0.1, -0.7, 0.3, 0.6, 1.1, -0.4, 2.0), strict=True))
    assert evaluate(total, values) == pytest.approx(0, abs=1e-15)
    assert [str(r) for r in euler_parameter_rates((ONE, ZERO, ZERO, ZERO), w)] == ["0", "w1/2", "w2/2", "w3/2"]
