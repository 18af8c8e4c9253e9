# SPDX-License-Identifier: BSD-3-Clause
"""Expressions multiplied out: the same values, and zero where only the whole is zero."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.expr import MOST, ONE, ZERO, as_expr, constant, expanded, factored
from tests.examples import examples

M, R, F = kn.parameters("m R F")
Q, U, V = kn.coordinate("q"), *kn.speeds("u v")
S, C, T = kn.sin(Q), kn.cos(Q), kn.tan(Q)
VALUES = {M: 1.3, R: 0.7, F: 2.9, Q: 0.4, U: -1.7, V: 0.6}


def written(e):
    return factored(expanded(as_expr(e)))


@pytest.mark.parametrize(
    ("e", "expected"),
    [
        ((R * U + V) ** 2 + (R * U - V) ** 2, "2*R^2*u^2 + 2*v^2"),
        (M * U * S**2 + M * C * (U * C), "m*u"),
        (M - M * S * S, "m*cos(q)^2"),
        ((U * S + V * C) ** 2 + (U * C - V * S) ** 2, "u^2 + v^2"),
        (M * C * C + 4 * (M * S * S), "m*(3*sin(q)^2 + 1)"),
        (C * (R * T + 0 * U), "R*sin(q)"),
        (S / C * U, "u*tan(q)"),
        (R * (U / R - V / R), "u - v"),
        (F / (M + F / R / R), "F*R^2/(m*R^2 + F)"),
        (R / (M * R + F * R), "1/(m + F)"),
        (U / (R + M) + V / (R + M), "(u + v)/(m + R)"),
    ],
)
def test_what_is_left(e, expected):
    assert str(written(e)) == expected


@pytest.mark.parametrize(
    "e",
    [
        F - (F * S**2 + F * C**2),
        (U + V) * (U - V) - U * U + V * V,
        F / R - F * (1 / R),
        (constant(0.1) * F + U) * V + (constant(0.2) * F - U) * V - constant(0.3) * F * V,
    ],
)
def test_what_cancels_is_gone(e):
    assert expanded(as_expr(e)) == []
    assert written(e) is ZERO


def test_what_would_be_long_stays_a_factor():
    a = sum((kn.parameter(f"a{k}") for k in range(MOST // 2)), start=ZERO)
    b = sum((kn.parameter(f"b{k}") for k in range(3)), start=ZERO)
    assert len(expanded(a * b)) == 3
    assert expanded(a * a + b) is not None
    assert expanded(sum((kn.parameter(f"c{k}") for k in range(MOST + 1)), start=ZERO)) is None


def test_arguments_of_functions_are_left():
    e = kn.sqrt((U + V) * (U - V))
    assert expanded(e) == [(1, ((e, 1),))]
    assert expanded(ONE) == [(1, ())]


@given(st.integers(0, 10_000))
@examples(0.5)
def test_random_expressions(seed):
    rng = random.Random(seed)
    found = [M, R, U, V, S, C, T, constant(2), constant(0.5)]
    for _ in range(rng.randint(2, 8)):
        a, b = rng.choice(found), rng.choice(found)
        found.append(rng.choice([a + b, a - b, a * b, -a, a / (R if rng.random() < 0.7 else C)]))
    e = as_expr(found[-1])
    value = kn.evaluate(e, VALUES)
    terms = expanded(e)
    if terms is not None:
        assert kn.evaluate(factored(terms), VALUES) == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert (expanded(e - factored(terms)) or []) == []
