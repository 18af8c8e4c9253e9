# SPDX-License-Identifier: BSD-3-Clause
"""What all terms hold in common: found, taken out, and nothing else changed."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import count_operations
from kane.expr import ZERO, constant, content, divider, over_number
from tests.examples import examples

M, R, G = kn.parameter("m"), kn.parameter("R"), kn.parameter("g")
Q, (U,) = kn.coordinate("q"), kn.speeds("u")
VALUES = {M: 1.3, R: 0.7, G: 9.81, Q: 0.4, U: -1.7}


def shared(*exprs):
    return content(exprs, {})


def test_sums_have_what_their_terms_have_in_common():
    assert shared(M * R * R * U / 2 - M * R * U * kn.tan(Q) / 4) == {M: 1, R: 1}
    assert shared(M * R * U + M * G, M * kn.sin(Q)) == {M: 1}
    assert shared(M * R + R * U, G * U) == {}


def test_zero_is_divided_by_anything_and_alone_gives_nothing():
    assert shared(ZERO, M * U) == {M: 1}
    assert shared(ZERO) == {}


def test_quotients_keep_what_is_left():
    assert shared(M * M * U / M, M * R / R) == {M: 1}
    assert shared(U / M) == {}
    assert shared(kn.sin(M * Q)) == {}


@given(st.integers(0, 10_000))
@examples(0.5)
def test_random_sums_of_products(seed):
    """k times a random sum: k is in its content, and what is left times it is the sum, in no more operations."""
    rng = random.Random(seed)

    def term(depth):
        if depth == 0 or rng.random() < 0.3:
            return rng.choice([M, R, G, U, kn.sin(Q), kn.cos(Q), constant(2)])
        a, b = term(depth - 1), term(depth - 1)
        return rng.choice([a * b, a * b, a + b, a - b, -a, a / (2 + U * U)])

    powers = {p: rng.randint(0, 2) for p in (M, R)}
    total = term(4)
    for p, k in powers.items():
        for _ in range(k):
            total = total * p
    memo = {}
    found = content([total], memo)
    if total is ZERO:
        return
    assert all(found.get(p, 0) >= k for p, k in powers.items())
    left = divider(memo)(total, found)
    whole = left
    for p, k in found.items():
        whole = whole * p**k
    assert kn.evaluate(whole, VALUES) == pytest.approx(kn.evaluate(total, VALUES), rel=1e-12, abs=1e-300)
    assert count_operations(left).total <= count_operations(total).total


def test_numbers_go_into_the_terms_that_have_one():
    e = U * U * kn.tan(Q) / 4 - U * R / 2
    quarter = constant(1) / 4
    assert str(over_number(e, quarter)) == "u^2*tan(q) - 2*R*u"
    assert over_number(-e, quarter) is -over_number(e, quarter)
    plain = U * kn.tan(Q) - R
    assert count_operations(over_number(plain, quarter)).total == count_operations(plain).total + 1
