# SPDX-License-Identifier: BSD-3-Clause
"""Affine forms: coefficients, remainder, and what is refused."""

import pytest
from hypothesis import given

import kane as kn
from kane import Expr, affine, coordinates, evaluate, free_symbols, speeds
from kane.errors import NotAffineError
from kane.expr import ONE, ZERO, affine_forms, postorder
from tests.expr.expressions import Program, U, X, programs, values_of

x, y = coordinates("x, y")
u1, u2 = speeds("u1:3")


@pytest.mark.parametrize(
    ("expr", "coefficients", "remainder"),
    [
        (u1, {u1: ONE}, ZERO),
        (x, {}, x),
        (2 * u1 - u2 * x.sin() + y, {u1: ONE + 1, u2: -x.sin()}, y),
        (-(u1 + x) / y, {u1: -(1 / y)}, -(x / y)),
        (x * (u1 + y * (u2 - u1)), {u1: x * (1 - y), u2: x * y}, ZERO),
        ((u1 + u2) - u2, {u1: ONE}, ZERO),
        ((u1 + x) * (u2 + y - u2), {u1: y}, x * y),
        ((u1 - (u1 + x) + x) * (u2 + y), {}, ZERO),
    ],
)
def test_coefficients_and_remainder(expr: Expr, coefficients: dict[Expr, Expr], remainder: Expr) -> None:
    found, rest = affine(expr, (u1, u2))
    assert {s: id(c) for s, c in found.items()} == {s: id(c) for s, c in coefficients.items()}
    assert rest is remainder


def test_the_form_has_the_value_of_the_expression() -> None:
    expr = u1 * (x - y) + (u1 * y - u2) / x.cos() - (u2 - x)
    found, rest = affine(expr, (u1, u2))
    at = {x: 0.3, y: 0.7, u1: -1.1, u2: 0.4}
    assert evaluate(found[u1] * u1 + found[u2] * u2 + rest, at) == pytest.approx(float(evaluate(expr, at)), rel=1e-14)


@given(programs())
def test_what_is_made_affine_comes_apart(program: Program) -> None:
    free = [n for n in program.nodes() if not {U, X} & set(free_symbols([n]))]
    a, b, c = free[-1], free[len(free) // 2], free[-2]
    e = (a * U - b) * c + (X - U) * b
    coefficients, rest = affine(e, (U, X))
    assert not {U, X} & set(postorder([rest, *coefficients.values()]))
    rebuilt = rest
    for s, k in coefficients.items():
        rebuilt = rebuilt + k * s
        assert k is not ZERO
    first, second = values_of([rebuilt, e], program.values)
    assert abs(first - second) <= 1e-10 * (1 + max(abs(v) for v in program.direct())) ** 3


@pytest.mark.parametrize(
    ("expr", "at_fault"),
    [
        (u1 * u1, "u1^2"),
        (u1 * u2, "u1*u2"),
        (u1.sin(), "sin(u1)"),
        (1 / u1, "/u1"),
        (x / (u1 + 1), "x/(u1 + 1)"),
        (u1.sqrt(), "sqrt(u1)"),
        (u1.less(x).where(1, 2), "u1 < x"),
        (x**u1, "x^u1"),
        (abs(u2), "abs(u2)"),
    ],
)
def test_what_is_not_affine_is_refused(expr: Expr, at_fault: str) -> None:
    with pytest.raises(NotAffineError, match="Expected an expression affine in u") as refused:
        affine(y + expr * x, (u1, u2))
    assert at_fault in str(refused.value)


def test_symbols_that_are_not_asked_for_may_be_nonlinear() -> None:
    coefficients, rest = affine(u1 * u2 * u2 + u2.sin(), (u1,))
    assert list(coefficients) == [u1]
    assert evaluate(coefficients[u1], {u2: 3.0}) == 9
    assert rest is u2.sin()


def test_forms_together() -> None:
    forms = affine_forms([u1 + x, u1 - x], (u1,))
    assert [str(r) for _, r in forms] == ["x", "-x"]


@pytest.mark.slow
def test_a_deep_graph() -> None:
    e: Expr = x
    for i in range(1, 10_000):
        e = (e + u1) * (1 + 1 / i)
    assert set(affine(e, (u1,))[0]) == {u1}


def test_choices_between_affine_forms_are_affine() -> None:
    x, y, u = kn.coordinates("x y u")
    form, rest = kn.affine(kn.where(kn.less(x, y), 2 * u + x, x * u), [u])
    assert form[u] is kn.where(kn.less(x, y), 2, x)
    assert rest is kn.where(kn.less(x, y), x, 0)
    with pytest.raises(kn.NotAffineError):
        kn.affine(kn.where(kn.less(u, y), 2 * u, x), [u])
