# SPDX-License-Identifier: BSD-3-Clause
"""Square roots of rationals stay exact: in products, powers and sums of one kind, in sines of π/4 and π/6, and on paper."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.expr import Surd, constant, constant_value, digest, root

RATIOS = st.fractions(min_value=-20, max_value=20, max_denominator=30).filter(bool)
RADICANDS = st.sampled_from([2, 3, 5, 6, 7, 10, 15, 21, 30])


@pytest.mark.parametrize(
    ("made", "shown"),
    [
        (lambda: kn.sqrt(2) / 2, "sqrt(2)/2"),
        (lambda: 1 / kn.sqrt(2), "sqrt(2)/2"),
        (lambda: kn.sqrt(kn.Rational(1, 2)), "sqrt(2)/2"),
        (lambda: kn.sqrt(8), "2*sqrt(2)"),
        (lambda: kn.sqrt(2) * kn.sqrt(2), "2"),
        (lambda: kn.sqrt(6) * kn.sqrt(3), "3*sqrt(2)"),
        (lambda: kn.sqrt(3) / kn.sqrt(12), "1/2"),
        (lambda: kn.sqrt(2) - kn.sqrt(2), "0"),
        (lambda: kn.sqrt(2) + kn.sqrt(8), "3*sqrt(2)"),
        (lambda: kn.Rational(1, 3) * kn.sqrt(2), "sqrt(2)/3"),
        (lambda: kn.sqrt(2) ** 3, "2*sqrt(2)"),
        (lambda: kn.cos(kn.pi / 4), "sqrt(2)/2"),
        (lambda: kn.sin(kn.pi / 3), "sqrt(3)/2"),
        (lambda: kn.sin(5 * kn.pi / 6), "1/2"),
        (lambda: kn.cos(2 * kn.pi / 3), "-1/2"),
        (lambda: kn.sin(-kn.pi / 4), "-sqrt(2)/2"),
        (lambda: kn.cos(kn.pi / 5), "cos(pi/5)"),
        (lambda: kn.tan(kn.pi / 4), "1"),
        (lambda: kn.tan(2 * kn.pi / 3), "-sqrt(3)"),
        (lambda: kn.tan(-kn.pi / 6), "-sqrt(3)/3"),
        (lambda: kn.tan(kn.pi / 2), "tan(pi/2)"),
        (lambda: kn.sqrt(2) * kn.parameter("a") / 2, "sqrt(2)*a/2"),
        (lambda: kn.parameter("a") / kn.sqrt(3), "sqrt(3)*a/3"),
        (lambda: (kn.parameter("a") / kn.sqrt(3)) ** 2, "(sqrt(3)*a/3)^2"),
        (lambda: kn.sqrt(2) * kn.parameter("a") + kn.sqrt(8) * kn.parameter("a"), "3*sqrt(2)*a"),
    ],
)
def test_what_is_shown(made, shown):
    assert str(made()) in {shown, shown.replace("(sqrt(3)*a/3)^2", "a^2/3")}


def test_latex():
    a = kn.parameter("a")
    assert kn.to_latex(kn.sqrt(2) / 2) == r"\frac{\sqrt{2}}{2}"
    assert kn.to_latex(3 * kn.sqrt(2)) == r"3 \sqrt{2}"
    assert kn.to_latex(kn.sqrt(3) * a / 2) == r"\frac{\sqrt{3} a}{2}"


@given(RATIOS, RADICANDS, RATIOS, RADICANDS)
def test_arithmetic_is_that_of_the_numbers(p, m, q, n):
    a, b = constant(Surd(p, m)), constant(Surd(q, n))
    x, y = Surd(p, m), Surd(q, n)
    for exact, number in (
        (a * b, float(x) * float(y)), (a / b, float(x) / float(y)), (-a, -float(x)), (a * a, float(p) ** 2 * m),
        (q * a, float(q) * float(x)), (a / kn.Rational(q.numerator, q.denominator), float(x) / float(q)),
        (a**3, float(x) ** 3), (1 / a, 1 / float(x)), (a**-2, float(x) ** -2),
    ):  # fmt: skip
        assert float(exact) == pytest.approx(number, rel=1e-15)
        value = constant_value(exact)
        assert isinstance(value, Surd) or Fraction(value) == Fraction(value).limit_denominator(10**9)
    for total, number in ((a + b, float(x) + float(y)), (a - b, float(x) - float(y))):
        assert float(total) == pytest.approx(number, rel=1e-14, abs=1e-14 * (abs(x) + abs(y)))
    assert a * b is b * a
    assert a / a is kn.Rational(1)
    assert a - a is kn.Rational(0)


def test_a_root_and_its_float_are_two_nodes():
    exact, rounded = kn.sqrt(2), constant(math.sqrt(2))
    assert exact is not rounded
    assert exact.key != rounded.key
    assert digest(exact) != digest(rounded)
    assert float(exact) == float(rounded)
    assert pickle.loads(pickle.dumps(exact)) is exact
    assert pickle.loads(pickle.dumps(kn.parameter("a") * exact)) is kn.parameter("a") * exact
    assert kn.evaluate(exact, {}).dtype == float


def test_floats_and_large_numbers_stay_floats():
    assert type(root(0.3)) is float
    assert type(root(Fraction(10**7, 3))) is float
    assert root(Fraction(10**14)) == 10**7
    assert type(constant_value(kn.sqrt(2) * 0.3)) is float
    assert type(constant_value(1 + kn.sqrt(2))) is float


def test_sines_at_all_multiples():
    for k in range(-48, 49):
        for n in (4, 6):
            angle = k * kn.pi / n
            assert float(kn.evaluate(kn.sin(angle), {})) == pytest.approx(math.sin(k * math.pi / n), abs=1e-14)
            assert float(kn.evaluate(kn.cos(angle), {})) == pytest.approx(math.cos(k * math.pi / n), abs=1e-14)


def test_directions_are_exact():
    N = kn.Frame("N")
    A = N.rotate("A", kn.pi / 4, N.z)
    assert [str(x) for x in N.dcm(A).rows[0]] == ["sqrt(2)/2", "-sqrt(2)/2", "0"]
    assert str((N.x + N.y).normalized()) == "sqrt(2)/2 N.x + sqrt(2)/2 N.y"
    m, R = kn.parameter("m"), kn.parameter("R")
    about = kn.thin_disk(N, m, R, axis=(N.x + N.y).normalized()).components(N)
    assert [str(x) for x in about.rows[0]] == ["3*m*R^2/8", "m*R^2/8", "0"]


def test_sympy_there_and_back():
    pytest.importorskip("sympy")
    e = kn.sqrt(2) * kn.parameter("a") / 3
    there = kn.to_sympy(e)
    assert str(there) == "sqrt(2)*a/3"
    assert kn.from_sympy(there, {"a": kn.parameter("a")}) is e


def test_code_takes_the_float():
    a = kn.coordinate("a")
    assert kn.evaluate(kn.sqrt(2) * a, {a: 1}) == math.sqrt(2)
    np.testing.assert_array_equal(kn.evaluate(kn.sqrt(2) * a, {a: np.array([1, 2])}), math.sqrt(2) * np.array([1, 2]))
