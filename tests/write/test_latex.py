# SPDX-License-Identifier: BSD-3-Clause
"""LaTeX: names, functions, fractions; balanced whatever comes."""

import re

import pytest
from hypothesis import given

import kane as kn
from kane import Expr, Rational, coordinate, coordinates, parameter, parameters, pi, speeds, to_latex
from kane.expr import as_expr, rate
from kane.write import latex_name, symbol_latex, unit_vector_latex
from tests.expr.expressions import Program, programs
from tests.write.lines import latex_lines

q1, q2 = coordinates("q1:3")
u1, u2 = speeds("u1:3")
m, l, R = parameters("m, l, R")
mu, theta = parameter("mu_k"), coordinate("theta1")


def test_a_prime_in_a_name_is_no_derivative() -> None:
    """Of a coordinate q' and its rate beside those of q."""
    q, own = kn.coordinates("q, q'")
    texts = [symbol_latex(s) for s in (q, rate(q), own, rate(own), rate(rate(own)))]
    assert texts == ["q", r"\dot{q}", r"{q^{\prime}}", r"{\dot{q}^{\prime}}", r"{\ddot{q}^{\prime}}"]
    assert kn.to_latex(own * own) == r"{q^{\prime}}^{2}"


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("q", "q"),
        ("q1", "q_{1}"),
        ("q12", "q_{12}"),
        ("rod at 0.5", r"\mathrm{rod\ at\ 0.5}"),
        ("mu", r"\mu"),
        ("mu_k", r"\mu_{k}"),
        ("theta1", r"\theta_{1}"),
        ("Omega_max", r"\Omega_{\mathrm{max}}"),
        ("Ixx", "I_{xx}"),
        ("Ix", "I_{x}"),
        ("N_z", "N_{z}"),
        ("l_arm2", r"l_{\mathrm{arm}2}"),
        ("k_1_2", "k_{1,2}"),
        ("m1_rotor", r"m_{1,\mathrm{rotor}}"),
        ("mass", r"\mathrm{mass}"),
        ("mass2", r"\mathrm{mass}_{2}"),
        ("q1'", r"\dot{q}_{1}"),
        ("q1''", r"\ddot{q}_{1}"),
        ("theta'", r"\dot{\theta}"),
        ("a%", r"\mathrm{a\%}"),
        ("_", r"\mathrm{\_}"),
        ("7", "7"),
        ("end of the rod", r"\mathrm{end\ of\ the\ rod}"),
    ],
)
def test_names(name: str, latex: str) -> None:
    assert latex_name(name) == latex


@pytest.mark.parametrize(
    ("expr", "latex"),
    [
        (u2 * q2.tan(), r"u_{2} \tan q_{2}"),
        (-R * u2 * q2.sin() / q2.cos(), r"-R u_{2} \tan q_{2}"),
        (2 * m * l * l, "2 m l^{2}"),
        (m * l * l / 12, r"\frac{m l^{2}}{12}"),
        (-5 * m / 7, r"-\frac{5 m}{7}"),
        (Rational(5, 7), r"\frac{5}{7}"),
        (pi / 2 - q2, r"\frac{\pi}{2} - q_{2}"),
        (as_expr(1e-12), "10^{-12}"),
        (2.5e-7 * q1, r"2.5 \cdot 10^{-7} q_{1}"),
        ((q1 + q2) / m, r"\frac{q_{1} + q_{2}}{m}"),
        (m / (q1 + q2) ** 2, r"\frac{m}{\left(q_{1} + q_{2}\right)^{2}}"),
        (m * (q1 + q2), r"m \left(q_{1} + q_{2}\right)"),
        (q1.sin() ** 2, r"\sin^{2} q_{1}"),
        ((q1 + q2).sin() ** 2, r"\sin^{2}\left(q_{1} + q_{2}\right)"),
        ((m * q1).cos(), r"\cos\left(m q_{1}\right)"),
        (q1.asin() ** 2, r"\left(\arcsin q_{1}\right)^{2}"),
        ((q1 + 1).sqrt(), r"\sqrt{q_{1} + 1}"),
        (q1.exp(), "e^{q_{1}}"),
        (q1.exp() ** 2, r"\left(e^{q_{1}}\right)^{2}"),
        (abs(q1), r"\left|q_{1}\right|"),
        (q1.log(), r"\ln q_{1}"),
        (q1.sign(), r"\operatorname{sgn} q_{1}"),
        (q1.atan2(q2), r"\operatorname{atan2}\left(q_{1}, q_{2}\right)"),
        (m * q1.max(q2), r"m \max\left(q_{1}, q_{2}\right)"),
        (q1**2.5, r"q_{1}^{\frac{5}{2}}"),
        (m**q1, "m^{q_{1}}"),
        ((m / l) ** 0.3, r"\left(\frac{m}{l}\right)^{0.3}"),
        (q1.dt * u1.dt * theta.dt, r"\dot{q}_{1} \dot{\theta}_{1} \dot{u}_{1}"),
        (mu * theta, r"\mu_{k} \theta_{1}"),
        (
            q1.less(q2).where(q1, q2 + 1),
            r"\begin{cases} q_{1} & \text{if } q_{1} < q_{2} \\ q_{2} + 1 & \text{otherwise} \end{cases}",
        ),
        (q1.less(q2), "q_{1} < q_{2}"),
    ],
)
def test_expressions(expr: Expr, latex: str) -> None:
    assert to_latex(expr) == latex


COMMANDS = re.compile(
    r"\\(frac|left|right|sqrt|sin|cos|tan|arcsin|arccos|arctan|sinh|cosh|tanh|ln|min|max|operatorname|begin|end|text|\\|"
    r"cdot|pi|quad|;)"
)


@given(programs(length=40))
def test_braces_and_parentheses_balance_and_commands_are_plain(program: Program) -> None:
    text = to_latex(program.root)
    assert all(COMMANDS.fullmatch(c) for c in re.findall(r"\\[a-zA-Z]+|\\[^a-zA-Z]", text))
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", text):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0
    assert text.count(r"\left") == text.count(r"\right")
    assert text.count(r"\begin{cases}") == text.count(r"\end{cases}")
    assert "--" not in text.replace(" ", "")


def test_lines_with_intermediates() -> None:
    a = (q1 + q2).sin() * m + l * u1
    b = a * a + a.cos() / (1 + a)
    lines = latex_lines({"u1'": b * b + b.exp() * a - (b + a).sqrt(), r"\dot{q}_{1}": u1})
    assert lines == [
        r"Z_{1} = m \sin\left(q_{1} + q_{2}\right) + l u_{1}",
        r"Z_{2} = Z_{1}^{2} + \frac{\cos Z_{1}}{Z_{1} + 1}",
        r"\dot{u}_{1} = Z_{1} e^{Z_{2}} + Z_{2}^{2} - \sqrt{Z_{1} + Z_{2}}",
        r"\dot{q}_{1} = u_{1}",
    ]


def test_long_expressions_in_one_piece() -> None:
    a = (q1 + q2).sin() * m + l * u1
    e = (a * a + a.cos() / (1 + a) + a.exp()) * (a.tan() + a.sqrt() + a / (a + m)) + (a * l).cos()
    assert r"\quad\text{where}\quad Z_{1} = m \sin\left(q_{1} + q_{2}\right) + l u_{1}" in to_latex(e)
    assert "Z" not in to_latex(e, intermediates=False)


@pytest.mark.slow
def test_a_deep_graph() -> None:
    e: Expr = q1
    for _ in range(10_000):
        e = (e + m).sin()
    assert to_latex(e, intermediates=False).count(r"\sin") == 10_000


def test_frames_with_primes_are_no_time_derivatives():
    """Body angles make frames B', B'' on the way."""
    frame = kn.Frame("N").rotate_body("B", kn.coordinates("q1 q2 q3"), "xyz")
    while frame.parent is not None:
        assert "dot" not in unit_vector_latex(frame.name, "x")
        frame = frame.parent
    assert unit_vector_latex("B'", "x") == r"\hat{e}_{x,\,B^{\prime}}"
    assert unit_vector_latex("B1''", "y") == r"\hat{e}_{y,\,B_{1}^{\prime\prime}}"


def test_names_of_several_letters_stand_apart():
    side, w, a = kn.parameters("side w a")
    assert to_latex(side * w).replace(" ", "") in (r"\mathrm{side}\,w", r"w\,\mathrm{side}")
    assert r"\," not in to_latex(a * w)
    assert to_latex(side * side * w).count(r"\,") == 1
    assert to_latex(3 * side).count(r"\,") == 0
