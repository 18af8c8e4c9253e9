# SPDX-License-Identifier: BSD-3-Clause
"""Sums of products collected: the same value, like terms joined, common factors out."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import count_operations
from kane.expr import collected
from tests.examples import examples

R, G = kn.parameter("R"), kn.parameter("g")
Q, (U, V) = kn.coordinate("q"), kn.speeds("u v")
VALUES = {R: 0.7, G: 9.81, Q: 0.4, U: -1.7, V: 0.6}


def test_an_equation_of_the_disk():
    e = G * kn.sin(Q) + R * U * V + R * V * U / 2 - R * U * U * kn.tan(Q) / 4
    assert str(collected(e)) == "g*sin(q) - R*u*(u*tan(q) - 6*v)/4"


def test_like_terms_are_joined_and_may_vanish():
    assert str(collected(R * (U * V) - (R * V) * U * 2 / 3)) == "R*u*v/3"
    assert collected(R * (U * V) - (R * V) * U) is kn.expr.ZERO


def test_what_is_no_sum_is_left():
    e = R * (U + V)
    assert collected(e) is e


def test_long_sums_are_left():
    terms = [kn.parameter(f"a{k}") * U for k in range(20)]
    e = sum(terms[1:], start=terms[0])
    assert collected(e) is e


@given(st.integers(0, 10_000))
@examples(0.5)
def test_random_sums(seed):
    rng = random.Random(seed)
    atoms = [R, G, U, V, kn.sin(Q), kn.cos(Q)]
    e = kn.expr.ZERO
    for _ in range(rng.randint(1, 8)):
        term = kn.expr.constant(rng.choice([1, 2, -3, 0.5]))
        for _ in range(rng.randint(1, 4)):
            term = term * rng.choice(atoms)
        e = e + term if rng.random() < 0.6 else e - term / 4
    found = collected(e)
    assert kn.evaluate(found, VALUES) == pytest.approx(kn.evaluate(e, VALUES), rel=1e-12, abs=1e-12)
    assert count_operations(collected(found)).total <= count_operations(found).total


def test_divisors_of_parameters_are_cancelled_and_tangents_stay():
    m = kn.parameter("m")
    e = (2 * m * R * R / 5) * (G * U / R) / R
    assert str(collected(e)) in ("2*m*g*u/5", "2*g*m*u/5")
    tangent = kn.sin(Q) / kn.cos(Q) * U / R
    assert str(collected(tangent)) == "u*tan(q)/R"
    assert str(collected(U / R + V / R)) == "(u + v)/R"


def test_what_a_quotient_is_divided_by_is_cancelled():
    c = kn.cos(Q)
    assert str(collected((U / c) * (R * V * c) - R * U * V * 2 / 3)) == "R*u*v/3"


def test_sums_that_are_factors_are_collected():
    assert str(collected(G * (R * U * V - (R * V) * U / 2))) == "g*R*u*v/2"
