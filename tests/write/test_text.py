# SPDX-License-Identifier: BSD-3-Clause
"""Text: how expressions read, and that reading does not depend on memory, hash seeds or what came before."""

import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given

from kane import Expr, Rational, coordinates, evaluate, input, parameter, parameters, pi, speeds, time, to_text
from kane.expr import ADD, MUL, OPS, as_expr, intern_node, postorder
from kane.write import natural
from tests.expr.expressions import DEEP, LEAVES, Program, programs, random_program
from tests.write.lines import text_lines

q1, q2, q10 = coordinates("q1, q2, q10")
u1, u2 = speeds("u1:3")
m, l, R, g = parameters("m, l, R, g")
mu = parameter("mu_k", 0.25, "1", "coefficient of friction")


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (as_expr(0), "0"),
        (as_expr(-3), "-3"),
        (Rational(5, 7), "5/7"),
        (Rational(-5, 7), "-5/7"),
        (as_expr(0.1), "0.1"),
        (q1, "q1"),
        (-q1, "-q1"),
        (pi / 2 - q2, "pi/2 - q2"),
        (pi * q1 / 3, "pi*q1/3"),
        (u2 * q2.tan(), "u2*tan(q2)"),
        (-R * u2 * q2.sin() / q2.cos(), "-R*u2*tan(q2)"),
        (q2.sin() ** 2 / q2.cos(), "sin(q2)*tan(q2)"),
        (u1 * q2.sin() / (m * q2.cos() ** 2), "u1*tan(q2)/(m*cos(q2))"),
        (q2.cos() / q2.sin(), "1/tan(q2)"),
        (q2.cos() * q2.tan(), "cos(q2)*tan(q2)"),
        (q2.sin() / q1.cos(), "sin(q2)/cos(q1)"),
        (R * q2.sin() * g * m, "m*g*R*sin(q2)"),
        (m * g * mu, "mu_k*m*g"),
        (2 * m * l * l, "2*m*l^2"),
        (m * l * l / 12, "m*l^2/12"),
        (5 * m / (7 * g * l), "5*m/(7*g*l)"),
        (-m / 3, "-m/3"),
        (m / (l * l), "m/l^2"),
        (1 / m, "1/m"),
        (1 / (m * l), "1/(m*l)"),
        (m / l / q1, "m/(l*q1)"),
        ((m * l) ** 3, "m^3*l^3"),
        ((q1 + q2) ** 2 / m, "(q1 + q2)^2/m"),
        (m / (q1 + q2), "m/(q1 + q2)"),
        (q10 + q2 + q1, "q1 + q2 + q10"),
        (1 - q1.cos(), "1 - cos(q1)"),
        (q1 - 1, "q1 - 1"),
        (-q1 - q2, "-q1 - q2"),
        (-(q1 + q2) * m, "-m*(q1 + q2)"),
        (-(-q1 - q2) * m, "m*(q1 + q2)"),
        (q1 - (q2 - (m - l)), "m - l + q1 - q2"),
        (q1 * q1 + 2 * q1 + 1, "q1^2 + 2*q1 + 1"),
        (q1 * (q1 * q2 + 1), "q1*(q1*q2 + 1)"),
        (2 * (q1 + q2), "2*(q1 + q2)"),
        (0.5 * (q1 - q2), "(q1 - q2)/2"),
        (m * (1 - q1.cos()), "m*(1 - cos(q1))"),
        (-m * (1 - q1.cos()), "-m*(1 - cos(q1))"),
        ((q1 - q2) / m * (l - R), "(l - R)*(q1 - q2)/m"),
        ((q1 - q2) * (R - l), "-(l - R)*(q1 - q2)"),
        ((q2 - q1) ** 2, "(q1 - q2)^2"),
        (-((q2 - q1) ** 2), "-(q1 - q2)^2"),
        ((q1 - q2).sin(), "sin(q1 - q2)"),
        ((q2 - q1).sin(), "-sin(q1 - q2)"),
        ((q2 - q1).cos(), "cos(q1 - q2)"),
        (m - (q2 - q1).sin(), "m + sin(q1 - q2)"),
        ((q2 - q1).exp(), "exp(q2 - q1)"),
        (0.3 * q1 * (0.2 * q2), "0.06*q1*q2"),
        (q1.dt * u1.dt, "q1'*u1'"),
        (u1.dt * q1, "q1*u1'"),
        (m * u1 * q1.dt * time, "m*q1'*u1*t"),
        (q1 * input("T"), "q1*T"),
        (q1**2.5, "q1^(5/2)"),
        (q1**0.3, "q1^0.3"),
        (m**q1, "m^q1"),
        (m ** (-q1), "m^(-q1)"),
        ((-q1) ** 0.3, "(-q1)^0.3"),
        ((m + l) ** (q1 + 1), "(m + l)^(q1 + 1)"),
        ((q1**0.3) ** 2, "(q1^0.3)^2"),
        (q1**40, "q1^40"),
        ((q1**40) * q1 / m, "q1^41/m"),
        ((q1 + q2).sqrt(), "sqrt(q1 + q2)"),
        (q1.sqrt() ** 3, "q1*sqrt(q1)"),
        (abs(q1) * q1.sign(), "abs(q1)*sign(q1)"),
        (q1.less(q2).where(q1, q2 + 1), "where(q1 < q2, q1, q2 + 1)"),
        (m * q1.less(q2).where(q1, q2), "m*where(q1 < q2, q1, q2)"),
        (q1.less(q2 * 2), "q1 < 2*q2"),
        (q1.atan2(-q2), "atan2(q1, -q2)"),
        (q1.max(m).min(0), "min(0, max(m, q1))"),
        ((q1 * m).sin() * (q1 + q2), "(q1 + q2)*sin(m*q1)"),
        (((q1 + 1) * 2 - 2 * q1) * q2, "-q2*(2*q1 - 2*(q1 + 1))"),
        (m * (q1 / 4 - 3 * q2 / 2), "m*(q1 - 6*q2)/4"),
        (-4 * (R - q1 * (q1 * q2 / 4 - 3 * m / 2)) / 5, "-(4*R + q1*(6*m - q1*q2))/5"),
        (R * (m * (q1 / 4 - q2 / 2) + l / 4), "R*(m*(q1 - 2*q2) + l)/4"),
        (q1 * (m / 2 + l / 2) - R, "q1*(m + l)/2 - R"),
        (R / (m / 2 - l / 2) ** 2, "4*R/(m - l)^2"),
        (q1 * (1 - q2 / 24), "q1*(1 - q2/24)"),
        (q1 * (m / 3 + l / 5), "q1*(m/3 + l/5)"),
        (2 * (q1 + q2 / 2), "2*(q1 + q2/2)"),
        (m * (0.1 * q1 + 0.3 * q2), "m*(0.1*q1 + 0.3*q2)"),
        (m * (q1 / 2 + as_expr(3).sqrt() * q2 / 2) / 3, "m*(q1/2 + sqrt(3)*q2/2)/3"),
        ((q1 + q2) - (q1 - m), "m + q2"),
    ],
)
def test_short_expressions(expr: Expr, text: str) -> None:
    assert to_text(expr) == text
    assert str(expr) == repr(expr) == to_text(expr)


def test_numbers_are_accepted() -> None:
    assert to_text(as_expr(2)) == "2"
    assert to_text(3) == "3"  # type: ignore[arg-type]


def test_natural_order_of_names() -> None:
    names = ["q10", "q2", "R", "g", "q1", "Q1", "l_2", "l_10", "m"]
    assert sorted(names, key=natural) == ["g", "l_2", "l_10", "m", "Q1", "q1", "q2", "q10", "R"]


def parse(text: str):
    """Our text as Python, for tests only: it holds nothing but what `to_text` wrote."""
    text, _, where = text.partition(", where Z1 = ")
    scope = {
        name: getattr(np, {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}.get(name, name))
        for name in (*OPS, "pi")
        if hasattr(np, name) or name.startswith("a")
    } | {"min": np.minimum, "max": np.maximum}

    def run(line: str, values):
        return eval(re.sub(r"\^", "**", line), {"__builtins__": {}}, scope | values)  # noqa: S307

    def value(values):
        if where:
            for i, line in enumerate(re.split(r", Z\d+ = ", where)):
                values = values | {f"Z{i + 1}": run(line, values)}
        return run(text, values)

    return value


@given(programs(length=40))
def test_text_means_what_the_expression_means(program: Program) -> None:
    root = program.root
    values = {s.name: v for s, v in zip(LEAVES, program.values, strict=True)}
    expected = float(evaluate(root, program.at))
    for intermediates in (None, True, False):
        text = to_text(root, intermediates=intermediates)
        if len(text) < 20_000:
            assert float(parse(text)(values)) == pytest.approx(expected, rel=1e-8, abs=1e-8)


def long_expression() -> Expr:
    a = (q1 + q2).sin() * m + l * u1
    b = a * a + a.cos() / (1 + a)
    return b * b + b.exp() * a - (b + a).sqrt() + q10


def test_long_expressions_have_named_intermediates() -> None:
    text = to_text(long_expression())
    first, _, definitions = text.partition(", where ")
    assert first == "q10 + Z1*exp(Z2) + Z2^2 - sqrt(Z1 + Z2)"
    assert definitions == "Z1 = m*sin(q1 + q2) + l*u1, Z2 = Z1^2 + cos(Z1)/(Z1 + 1)"


def test_a_tangent_needs_no_name() -> None:
    tangent = q2.sin() / q2.cos()
    e = (tangent * u1 + m).exp() + (tangent * u2 + l).exp() + (tangent * R + g).exp()
    assert to_text(e, intermediates=True) == "exp(m + u1*tan(q2)) + exp(g + R*tan(q2)) + exp(l + u2*tan(q2))"


def test_intermediates_on_request() -> None:
    e = (q1 + q2 * m).sin() * (q1 + q2 * m).cos() * (q1 + q2 * m)
    assert "where" not in to_text(e)
    short = (q1 * q2 * m + 1).sin() + (q1 * q2 * m + 1).cos()
    assert to_text(short, intermediates=True) == "cos(Z1) + sin(Z1), where Z1 = m*q1*q2 + 1"
    assert "Z" not in to_text(long_expression(), intermediates=False)


def test_lines_share_one_list_of_intermediates() -> None:
    e = long_expression()
    lines = text_lines({"a": e, "b": 2 * e + 1, "c": q1 + q2})
    assert [line.partition(" = ")[0] for line in lines] == ["Z1", "Z2", "Z3", "a", "b", "c"]
    assert lines[-3:] == ["a = Z3", "b = 2*Z3 + 1", "c = q1 + q2"]
    assert text_lines({}) == []


def test_intermediates_do_not_take_the_names_of_symbols() -> None:
    taken = parameter("Z1")
    text = to_text(long_expression() * taken)
    assert "Z1 =" not in text
    assert "Z2 = m*sin(q1 + q2) + l*u1" in text


def test_every_intermediate_is_used_and_defined_before() -> None:
    for seed in range(60):
        lines = text_lines({"r": random_program(seed, length=60).root})
        defined: set[str] = set()
        used: set[str] = set()
        for line in lines:
            name, _, body = line.partition(" = ")
            inside = set(re.findall(r"Z\d+", body))
            assert inside <= defined
            used |= inside
            defined.add(name)
        assert defined - {"r"} == used


@pytest.mark.slow
@pytest.mark.grows
def test_a_deep_chain_prints() -> None:
    e: Expr = q1
    for _ in range(DEEP // 2):
        e = (e + m).sin()
    lines = text_lines({"e": e})
    assert 0.03 * DEEP < len(lines) < 0.12 * DEEP
    assert max(len(line) for line in lines) < 1_000


def test_deep_expressions_print_in_full_on_request() -> None:
    e: Expr = q1
    for _ in range(5_000):
        e = (e + m).sin()
    assert to_text(e, intermediates=False).count("sin(") == 5_000


@pytest.mark.slow
def test_a_sum_of_10000_terms_prints_flat() -> None:
    e: Expr = q1
    for i in range(1, 10_000):
        e = e + i * m.sin() * (q1 + i).cos()
    assert to_text(e, intermediates=False).count(" + ") == 2 * 9_999


def test_towers_of_squares_print() -> None:
    e: Expr = q1 + m
    for _ in range(200):
        e = e * e
    lines = text_lines({"e": e})
    assert lines[0] == "Z1 = (m + q1)^33554432"
    assert len(lines) == 8


def test_raw_nodes_print_as_what_they_mean() -> None:
    assert to_text(intern_node(MUL, as_expr(2), intern_node(ADD, q1, q1))) == "2*(2*q1)"


def test_large_coefficients_are_not_multiplied_out_of_range() -> None:
    assert to_text((q1 * 1e200) * (q2 * 1e200)) == "1e+200^2*q1*q2"


MODEL = """
import sys
from kane import coordinate, coordinates, jacobian, parameter, parameters, speeds, time_derivative
from kane.expr import digest
from tests.write.lines import text_lines
for i in range(int(sys.argv[1])):
    parameter(f"w{i}") * coordinate(f"v{i}") + i
n = 4
q, u = coordinates(f"q1:{n + 1}"), speeds(f"u1:{n + 1}")
m, l = parameters(f"m1:{n + 1}"), parameters(f"l1:{n + 1}")
x = y = 0
energy = 0
angle = 0
for qi, mi, li in zip(q, m, l):
    angle = angle + qi
    x, y = x + li * angle.cos(), y + li * angle.sin()
    energy = energy + mi * (time_derivative(x) ** 2 + time_derivative(y) ** 2) / 2
rates = [qi.dt for qi in q]
mass = jacobian([jacobian([energy], rates)[0, i] for i in range(n)], rates)
entries = {f"M{i}{j}": mass[i, j] for i in range(n) for j in range(n)}
print("\\n".join(text_lines(entries)))
print(digest(energy).hex(), energy.key)
"""


@pytest.mark.slow
def test_text_is_the_same_under_any_hash_seed_and_history() -> None:
    outputs = {
        subprocess.run(
            [sys.executable, "-W", "error", "-c", MODEL, history],
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(p for p in sys.path if p)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed, history in (("0", "0"), ("1", "0"), ("2", "500"))
    }
    assert len(outputs) == 1
    text = outputs.pop()
    assert "Z1 = " in text
    assert len(text) > 1_000


def test_order_of_construction_does_not_show() -> None:
    there = q1 * m + q2 * l + u1 * R + g
    back = g + R * u1 + l * q2 + m * q1
    assert to_text(there) == to_text(back) == "m*q1 + g + l*q2 + R*u1"
    assert all(isinstance(n, Expr) for n in postorder([there, back]))


def test_terms_alike_once_flattened_are_one():
    x, y, z = coordinates("x y z")
    a, b = parameters("a b")
    assert to_text(a * a * x * y / 4 - a * (a * (x * y)) / 2) == "-a^2*x*y/4"
    assert to_text((a * (b * (x * y))) - (x * (a * (b * y)))) == "0"
    assert to_text(z * ((a * (b * (x * y))) - (x * (a * (b * y)))) + y) == "y"
    assert to_text((1 + (a * (b * (x * y))) - (x * (a * (b * y)))) * z) == "z"
