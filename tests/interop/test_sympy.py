# SPDX-License-Identifier: BSD-3-Clause
"""To SymPy and back."""

import subprocess
import sys

import pytest
import sympy
from hypothesis import given

from kane import (
    Expr,
    Rational,
    coordinate,
    coordinates,
    evaluate,
    from_sympy,
    parameter,
    parameters,
    pi,
    speeds,
    time,
    to_sympy,
)
from kane.errors import ExpressionError
from kane.expr import as_expr, postorder
from tests.expr.expressions import LEAVES, MP, Program, programs, value_of

q1, q2 = coordinates("q1:3")
(u1,) = speeds("u1")
m, l = parameters("m, l")
OURS = {s.name: s for s in (q1, q2, u1, m, l)}
Q1, Q2, U1, M, L, T = sympy.symbols("q1 q2 u1 m l t")


@given(programs())
def test_values_are_kept_both_ways(program: Program) -> None:
    root = program.root
    theirs = to_sympy(root)
    at = {sympy.Symbol(s.name): sympy.Float(v, 40) for s, v in zip(LEAVES, program.values, strict=True)}
    expected = value_of(root, program.values)
    assert abs(MP.mpf(str(sympy.N(theirs.subs(at), 30))) - expected) <= 1e-10 * (1 + abs(expected))
    back = from_sympy(theirs, {s.name: s for s in LEAVES})
    assert abs(value_of(back, program.values) - expected) <= 1e-10 * (1 + abs(expected))


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (m * l * l / 12, M * L**2 / 12),
        (q1 - q2, Q1 - Q2),
        (-(q1 / q2), -Q1 / Q2),
        (pi / 2 - q1, sympy.pi / 2 - Q1),
        (Rational(1, 3), sympy.Rational(1, 3)),
        (q1.sqrt(), sympy.sqrt(Q1)),
        (1 / q1.sqrt(), 1 / sympy.sqrt(Q1)),
        (q1**2.3, Q1 ** sympy.Float(2.3)),
        (m**q1, M**Q1),
        (q1.sin(), sympy.sin(Q1)),
        (q1.cos(), sympy.cos(Q1)),
        (q1.tan(), sympy.tan(Q1)),
        (q1.asin(), sympy.asin(Q1)),
        (q1.acos(), sympy.acos(Q1)),
        (q1.atan(), sympy.atan(Q1)),
        (q1.atan2(q2), sympy.atan2(Q1, Q2)),
        (q1.sinh(), sympy.sinh(Q1)),
        (q1.cosh(), sympy.cosh(Q1)),
        (q1.tanh(), sympy.tanh(Q1)),
        (q1.exp(), sympy.exp(Q1)),
        (q1.log(), sympy.log(Q1)),
        (abs(q1), sympy.Abs(Q1)),
        (q1.sign(), sympy.sign(Q1)),
        (q1.min(q2), sympy.Min(Q1, Q2)),
        (q1.max(q2), sympy.Max(Q1, Q2)),
        (q1.less(q2), Q1 < Q2),
        (q1.less(q2).where(q1, q2 + 1), sympy.Piecewise((Q1, Q1 < Q2), (Q2 + 1, True))),
    ],
)
def test_each_operation_both_ways(ours: Expr, theirs) -> None:
    assert to_sympy(ours) == theirs
    assert to_sympy(from_sympy(theirs, OURS)) == theirs


def test_constants_stay_exact() -> None:
    assert to_sympy(Rational(2, 3) + pi) == sympy.Rational(2, 3) + sympy.pi
    assert from_sympy(sympy.Rational(2, 3), {}) is Rational(2, 3)
    assert from_sympy(sympy.pi, {}) is pi
    assert float(from_sympy(sympy.Float(0.1), {})) == 0.1
    assert float(to_sympy(as_expr(0.1))) == 0.1
    assert from_sympy(7, {}) is as_expr(7)
    assert float(from_sympy(sympy.E, {})) == pytest.approx(float(sympy.E), rel=1e-15)


def test_a_comparison_in_sums_and_functions_is_one_or_zero() -> None:
    """It was SymPy's relation there, of which SymPy can compute nothing."""
    for ours in (3 * q1.less(q2) + m, q1.less(q2).max(m).sin(), q1.less(q2).less(m)):
        back = from_sympy(to_sympy(ours), OURS)
        for a in (-1.0, 1.0):
            at = {q1: a, q2: 0.5, m: 0.25}
            assert evaluate(back, at) == evaluate(ours, at)


def test_a_condition_that_hangs_on_a_condition() -> None:
    """SymPy writes ITE for a Piecewise of conditions; it meets one where a choice is compared."""
    choice = sympy.ITE(Q1 < 0, Q2 < 1, Q2 < 2)
    theirs = sympy.Piecewise((Q1, choice), (Q2, True), evaluate=False)
    assert theirs.has(sympy.ITE)
    ours = from_sympy(theirs, OURS)
    for a in (-1.0, 1.0):
        for b in (0.5, 1.5, 2.5):
            assert evaluate(ours, {q1: a, q2: b}) == (a if (b < 1 if a < 0 else b < 2) else b)


def test_rates_as_symbols_and_as_derivatives() -> None:
    e = m * q1.dt + u1.dt * time + q1
    t = sympy.Symbol("t")
    plain = to_sympy(e)
    assert plain == M * sympy.Symbol("q1'") + sympy.Symbol("u1'") * t + Q1
    timed = to_sympy(e, functions_of_time=True)
    x, u = sympy.Function("q1")(t), sympy.Function("u1")(t)
    assert timed == M * x.diff(t) + u.diff(t) * t + x
    assert to_sympy(from_sympy(plain, OURS | {"t": time})) == plain
    assert to_sympy(from_sympy(timed, OURS | {"t": time})) == plain
    assert from_sympy(x.diff(t, 2), OURS) is q1.dt.dt
    assert to_sympy(q1.dt.dt, functions_of_time=True) == x.diff(t, 2)


def test_equations_of_motion_agree_with_mechanics() -> None:
    """d/dt ∂T/∂q' of a pendulum, differentiated on either side of the border."""
    t = sympy.Symbol("t")
    x = sympy.Function("q1")(t)
    kinetic = m * (l * q1.dt * q1.cos()) ** 2 / 2
    ours = to_sympy(kinetic, functions_of_time=True).diff(t)
    theirs = (M * (L * x.diff(t) * sympy.cos(x)) ** 2 / 2).diff(t)
    assert sympy.simplify(ours - theirs) == 0
    assert sympy.simplify(to_sympy(kinetic.dt, functions_of_time=True) - theirs) == 0


def test_symbols_are_looked_up_by_symbol_or_name() -> None:
    real = sympy.Symbol("x", real=True)
    assert from_sympy(real * 2, {real: q1}) is 2 * q1
    assert from_sympy(real * 2, {"x": q1 + q2}) is 2 * (q1 + q2)
    late = sympy.Function("q1")(T - 1)
    assert from_sympy(late - sympy.Function("q1")(T), {late: q2, "q1": q1}) is q2 - q1


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        (Q1 < Q2, lambda a, b: a < b),
        (Q1 <= Q2, lambda a, b: a <= b),
        (Q1 > Q2, lambda a, b: a > b),
        (Q1 >= Q2, lambda a, b: a >= b),
        (sympy.Eq(Q1, Q2), lambda a, b: a == b),
        (sympy.Ne(Q1, Q2), lambda a, b: a != b),
        ((Q1 < Q2) & (Q1 > 0), lambda a, b: 0 < a < b),
        ((Q1 < Q2) | (Q1 > 1), lambda a, b: a < b or a > 1),
        (sympy.Not((Q1 < Q2) & (Q1 > 0), evaluate=False), lambda a, b: not 0 < a < b),
    ],
)
def test_conditions(condition, holds) -> None:
    chosen = from_sympy(sympy.Piecewise((1, condition), (0, True)), OURS)
    points = [(a, b) for a in (-1.0, 0.5, 2.0) for b in (-1.0, 0.5, 2.0)]
    assert [evaluate(chosen, {q1: a, q2: b}) for a, b in points] == [float(holds(a, b)) for a, b in points]


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        (sympy.sec(Q1), 1 / q1.cos()),
        (sympy.csc(Q1), 1 / q1.sin()),
        (sympy.cot(Q1), q1.cos() / q1.sin()),
        (sympy.coth(Q1), 1 / q1.tanh()),
        (Q1 ** sympy.Rational(3, 2), q1 * q1.sqrt()),
        (Q1**-2, 1 / (q1 * q1)),
        (sympy.Max(Q1, Q2, U1), q1.max(q2).max(u1)),
        (sympy.Add(Q1, Q1, evaluate=False), 2 * q1),
        (M * (Q1 / Q2) / L, m * q1 / (l * q2)),
    ],
)
def test_what_has_no_operation_of_its_own(theirs, ours: Expr) -> None:
    at = {q1: 0.4, q2: 0.9, u1: 0.7, m: 1.3, l: 2.1}
    assert evaluate(from_sympy(theirs, OURS), at) == pytest.approx(float(evaluate(ours, at)), rel=1e-14)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("q1 + 1", "Text is not parsed here"),
        (sympy.Symbol("zz"), "got none for 'zz'. Known here: q1, q2, u1, m, l"),
        (sympy.oo, "real, finite"),
        (sympy.I * Q1, "real, finite"),
        (sympy.nan, "real, finite"),
        (sympy.gamma(Q1), "SymPy's gamma"),
        (sympy.Integral(Q1, Q1), "SymPy's"),
        (sympy.Piecewise((Q1, Q1 < Q2)), "without a last case"),
        ((Q1 < Q2) & (Q2 < 1), "real value"),
        (sympy.Derivative(Q1**2, Q1), "derivatives of functions of time"),
        *(
            (sympy.Function("q1")(*at), "functions of the time alone")
            for at in ((T - 1,), (0,), (T, M), (M,), (2 * T,))
        ),
        (sympy.Function("q1")(M).diff(M), "functions of the time alone"),
    ],
)
def test_what_cannot_be_converted_is_named(expression, message: str) -> None:
    with pytest.raises(ExpressionError) as refused:
        from_sympy(expression, OURS)
    assert message in str(refused.value)


@pytest.mark.parametrize("other", [parameter("q1"), coordinate("q1", "rad")])
def test_namesakes_are_refused(other: Expr) -> None:
    with pytest.raises(ExpressionError, match="two different ones called 'q1'"):
        to_sympy(q1 * other)


@pytest.mark.slow
def test_deep_graphs_pass_the_recursion_limit() -> None:
    e: Expr = q1
    for _ in range(2 * sys.getrecursionlimit()):
        e = e.atan()
    theirs = to_sympy(e)
    assert from_sympy(theirs, OURS) is e


def test_sharing_is_kept() -> None:
    e: Expr = q1
    for _ in range(60):  # 2^60 terms, if it were written out
        e = (e * e.sin() + m).sin()
    theirs = to_sympy(e)
    assert len(postorder([from_sympy(theirs, OURS)])) == len(postorder([e]))


@pytest.mark.slow
def test_long_sums_are_one_sum() -> None:
    e: Expr = q1
    for i in range(1, 2000):
        e = e - i * q1.cos() ** (17 + i)
    assert len(to_sympy(e).args) == 2000


@pytest.mark.slow
def test_sympy_is_imported_only_when_used() -> None:
    code = "import sys, kane.interop.sympy, kane.write.arrange; sys.exit('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-W", "error", "-c", code], check=False).returncode == 0


def test_parts_of_complex_numbers_are_those_of_real_ones() -> None:
    doubled = m.exp() + m.exp()
    assert from_sympy(to_sympy(abs(doubled)), OURS) is doubled
    assert from_sympy(sympy.re(Q1) + sympy.im(Q2) + sympy.conjugate(Q2), OURS) is q1 + q2


def test_a_symbol_called_as_the_time_is_refused_where_functions_are_of_time():
    """Differentiated by t it would count as the time."""
    t, q = parameter("t"), coordinate("q")
    with pytest.raises(ExpressionError, match="two different ones called 't'"):
        to_sympy(t * q, functions_of_time=True)
    assert str(to_sympy(t * q)) == "q*t"
    assert str(to_sympy(time * q, functions_of_time=True)) == "t*q(t)"
