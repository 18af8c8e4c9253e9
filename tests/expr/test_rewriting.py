# SPDX-License-Identifier: BSD-3-Clause
"""What is computed together, in fewer operations: the same values, nothing new that is divided by, what is kept stays."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import Expr, evaluate
from kane.expr import combined, joined, named, postorder, price, scaled, shared
from tests.examples import examples

R, M, G, L = kn.parameters("R m g L")
Q = kn.coordinate("q")
U, V, W = kn.speeds("u v w")
ATOMS = (R, M, G, L, U, V, W, kn.sin(Q), kn.cos(Q))
REWRITINGS = {"products": shared, "sums": combined, "scales": scaled}


def random_roots(rng: random.Random) -> list[Expr]:
    """Sums, products and quotients of each other; divisors are squares plus what is positive, cos q or parameters."""
    found: list[Expr] = list(ATOMS)
    for _ in range(rng.randint(5, 30)):
        a, b = rng.choice(found), rng.choice(found[-12:])
        kind = rng.random()
        if kind < 0.35:
            found.append(a + b * rng.choice([1, 1, 2, kn.expr.constant(0.5)]))
        elif kind < 0.45:
            found.append(a - b / rng.choice([1, 3, 4]))
        elif kind < 0.85:
            found.append(a * b)
        elif kind < 0.95:
            found.append(a / rng.choice([R, M, R * M, kn.cos(Q), R * R * M / 3 + R * R * (1 + kn.cos(Q))]))
        else:
            found.append(kn.sqrt(1 + a * a))
    return found[-rng.randint(2, 8) :]


def numbers(roots, **given):
    values = {R: 0.7, M: 1.3, G: 9.81, L: 0.4, Q: 0.4, U: -1.7, V: 0.6, W: 1.1}
    values |= {s: given[s.name] for s in values if s.name in given}
    with np.errstate(all="ignore"):
        return np.array(evaluate(list(roots), values), dtype=float)


@pytest.mark.parametrize("name", REWRITINGS)
@given(st.integers(0, 10**6))
@examples(1)
def test_values_stay_and_operations_become_fewer(name, seed):
    roots = random_roots(random.Random(seed))
    found = REWRITINGS[name](roots)
    assert numbers(found) == pytest.approx(numbers(roots), rel=1e-9, abs=1e-9 * np.abs(numbers(roots)).max())
    assert price(found) <= price(roots)


@pytest.mark.parametrize("name", REWRITINGS)
@given(st.integers(0, 10**6))
@examples(1)
def test_what_has_a_value_has_one_still(name, seed):
    """Nothing is divided by a parameter that may be zero."""
    roots = random_roots(random.Random(seed))
    found = REWRITINGS[name](roots)
    for zero in ("R", "m", "g", "L", "u"):
        before, after = numbers(roots, **{zero: 0.0}), numbers(found, **{zero: 0.0})
        finite = np.isfinite(before)
        size = 1e-9 * max(1.0, np.abs(before[finite]).max(initial=0))
        assert after[finite] == pytest.approx(before[finite], rel=1e-9, abs=size)


@pytest.mark.parametrize("name", REWRITINGS)
@given(st.integers(0, 10**6))
@examples(0.5)
def test_what_is_kept_stays(name, seed):
    rng = random.Random(seed)
    roots = random_roots(rng)
    inner = [e for e in postorder(roots) if len(e.args) == 2]
    kept = frozenset(rng.sample(inner, min(2, len(inner))))
    there = set(postorder(REWRITINGS[name](roots, kept)))
    outer = set(postorder([e for k in kept for e in k.args]))
    assert all(k in there or k in outer or not _needed(roots, k) for k in kept)


def _needed(roots, e):
    """Whether the roots change where e does."""
    other = kn.expr.substituted
    return not np.array_equal(numbers(roots), numbers([other(r, {e: e + 1}) for r in roots]), equal_nan=True)


def test_lengths_are_counted_in_radii():
    """The first acceleration of a disk and the normal force at its contact."""
    u_dot = (G * kn.sin(Q) + R * (U * W)) / (R * 5 / 4)
    force = M * (G - R * (U * U))
    found = scaled([u_dot, force])
    assert [str(e) for e in found] == ["4*(g*sin(q)/R + u*w)/5", "m*R*(g/R - u^2)"]
    assert price(found) < price([u_dot, force])


def test_nothing_is_divided_by_a_length_that_may_be_zero():
    roots = [G * kn.sin(Q) + R * (U * W), M * (G - R * (U * U)), M * R * V]
    assert all(R not in kn.expr.denominators([e]) for e in scaled(roots))


def test_products_share_quotients_and_squares():
    w = U / kn.cos(Q)
    assert price(shared([w, V * U / (kn.cos(Q) * kn.cos(Q))])) == price([w, (w * V) / kn.cos(Q)])
    c, s = kn.cos(Q), kn.sin(Q)
    assert price(shared([(c * U) * U, (s * U) * U])) == 5


def test_sums_of_the_same_two_terms_are_made_of_each_other():
    x, y = kn.sin(Q), U
    sums = [x - y, 2 * x - y, 3 * x / 2 - y / 4]
    found = combined(sums)
    assert price(sums) == 7
    assert price(found) == 5
    assert [str(e) for e in joined(found)] == [str(e) for e in sums]


def test_reading_joins_like_terms_and_leaves_others():
    e = U * (V + (2 * V - W) / 4)
    assert str(joined([e])[0]) == "u*(6*v - w)/4"
    assert joined([U * V + W])[0] is U * V + W
    assert joined([(V - W) - V + W])[0] is kn.expr.ZERO


def test_known_products_have_their_names():
    e = R * (kn.sin(Q) * V)
    a, b = named([(W * V) * (R * kn.sin(Q)), kn.sqrt(-(e / M))], {e: U})
    assert a is W * U
    assert b is kn.sqrt(-(U / M))
    assert named([V * V], {e: U}) == (V * V,)
    assert named([V + e], {-e: U})[0] is V - U
    assert named([W * (R * V)], {e: U})[0] is W * (R * V)
