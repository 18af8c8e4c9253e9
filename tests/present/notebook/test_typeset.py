# SPDX-License-Identifier: BSD-3-Clause
"""What notebooks show of expressions and matrices, and the HTML that all layers are shown with."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

import kane as kn
from kane import Expr, Matrix, coordinate, coordinates, parameters, show, to_latex
from kane.gallery import double_pendulum
from kane.present import ROWS, either, escaped, listed, math, table
from kane.units import unit_text
from tests.expr.expressions import Program, programs

q1, q2 = coordinates("q1:3")
m, l = parameters("m, l")


def shared(times: int) -> Expr:
    e: Expr = q1
    for _ in range(times):
        e = (e + m).sin() * e
    return e


def test_an_expression_is_its_latex() -> None:
    assert (m * l * q1.cos())._repr_latex_() == rf"$\displaystyle {to_latex(m * l * q1.cos())}$"
    assert q1.dt._repr_latex_() == r"$\displaystyle \dot{q}_{1}$"


def test_a_long_expression_has_named_intermediates_on_lines_of_their_own() -> None:
    text = shared(25)._repr_latex_()
    assert text is not None
    assert text.startswith(r"$\displaystyle \begin{aligned} & ")
    assert r"\\ & \text{where} \\ & Z_{1} = " in text
    assert text.endswith(r"\end{aligned}$")


def test_a_very_long_expression_is_a_sentence() -> None:
    sentence = "An expression of 2100 operations, too long to typeset; print() shows it."
    assert shared(700)._repr_latex_() == sentence


def test_a_matrix() -> None:
    shown = Matrix([[m, 0], [q1 / 2, m * l]])._repr_latex_()
    assert shown == r"$\displaystyle \begin{bmatrix} m & 0 \\[3pt] \frac{q_{1}}{2} & m l \end{bmatrix}$"


def test_the_entries_of_a_matrix_share_intermediates() -> None:
    e = shared(22)
    text = Matrix([[e, e * m]])._repr_latex_()
    assert text is not None
    left = re.findall(r"& (Z_\{\d+\}) = ", text)
    assert left == [f"Z_{{{i}}}" for i in range(1, len(left) + 1)]
    assert left


def test_odd_matrices() -> None:
    assert Matrix([], (0, 3))._repr_latex_() == r"$\displaystyle \left[\;\right]_{0 \times 3}$"
    large = Matrix.identity(11)._repr_latex_()
    assert large == (
        "A 11 × 11 matrix with 11 entries that are not zero, of 0 operations, too long to typeset; print() shows it."
    )


@pytest.mark.parametrize("name", ["<script>", "a$b", "a\\b", "x&y", "{", "}", "#", "~", "^", "\\end{aligned}"])
def test_names_cannot_end_a_formula_or_become_markup(name: str) -> None:
    text = coordinate(name)._repr_latex_()
    assert text is not None
    assert not set("<>") & set(text)
    bare = re.sub(r"\\[^a-zA-Z]", "", text)
    assert bare.count("$") == 2
    assert bare.count("{") == bare.count("}")
    assert r"\end" not in text


@given(programs(length=40))
def test_dollars_and_braces_balance(program: Program) -> None:
    text = program.root._repr_latex_()
    assert text is not None
    assert text.startswith(r"$\displaystyle ")
    assert text.count("$") == 2
    assert text.count("{") == text.count("}")
    assert text.count(r"\begin{") == text.count(r"\end{")
    assert "<" not in text


def test_text_is_neither_markup_nor_formula() -> None:
    assert escaped("<i>&") == "&lt;i&gt;&amp;"
    assert escaped(r"$x$ \(y\)") == r"<span>$</span>x<span>$</span> <span>\</span>(y<span>\</span>)"
    assert math("a < b & c") == r"$a \lt b &amp; c$"


def test_tables() -> None:
    assert table(("a",), []) == ""
    shown = table(("<a>", "b", "c"), [("1", "", "2"), ("3", "", "4")])
    assert re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", shown) == ["&lt;a&gt;", "c", "1", "2", "3", "4"]
    long = table(("a", "b"), [("x", "y")] * (ROWS + 7))
    assert long.count("<tr>") == 1 + ROWS + 1
    assert "… and 7 more" in long
    assert "<th" not in table(("", ""), [("x", "y")])


def test_lists_and_units() -> None:
    assert listed(["a", "<b>"]) == "a, &lt;b&gt;"
    assert listed(["a"] * 14).endswith("a and 2 more")
    assert unit_text("kg*m^2") == "kg·m²"


class Broken:
    _repr_html_ = show.html
    _repr_latex_ = show.latex


def test_nothing_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: object) -> str:
        raise RecursionError

    def odd(source: object) -> str:
        raise ValueError("<no>")

    assert Broken()._repr_html_() is None
    monkeypatch.setitem(show.HTML, Broken, broken)
    assert Broken()._repr_html_() is None
    assert Broken()._repr_latex_() is None
    assert either(odd, None) == "<p>Not shown: ValueError: &lt;no&gt;</p>"
    assert object.__new__(Matrix)._repr_latex_() is None


def test_rotations_potentials_and_integrals_are_typeset():
    r = kn.Rotation.from_angles("xyz", kn.coordinates("a b c"))
    assert r"\cos" in r._repr_latex_()
    assert r"\begin" in r._repr_latex_()
    assert kn.Rotation.from_scipy(Rotation.random(3, random_state=1))._repr_latex_() == "Rotation(array of 3)"
    eom = kn.derive(double_pendulum.system())
    assert r"\cos" in eom.find_potential()._repr_latex_()
    assert all(i._repr_latex_().startswith("$") for i in eom.integrals)
