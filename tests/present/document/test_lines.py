# SPDX-License-Identifier: BSD-3-Clause
r"""Long formulas in lines: nothing is lost, each line is in balance for TeX, and what can be broken fits."""

from __future__ import annotations

import re

import pytest

import kane as kn
from kane.gallery import four_bar
from kane.present import broken_lines, chapters_of, em_width
from tests.present.disk import derived

WIDTH = 30.0


def joined(lines: list[str]) -> str:
    """The formula again: what the lines add is taken off, and brackets take TeX's size."""
    text = lines[0] + "".join(line.removeprefix("{}").removeprefix(r"\cdot ") for line in lines[1:])
    return re.sub(r"\s", "", text.replace(r"\bigl", r"\left").replace(r"\bigr", r"\right"))


@pytest.mark.parametrize(
    "system",
    [
        pytest.param(lambda: derived()[1], id="disk"),
        pytest.param(lambda: kn.derive(four_bar.system()), marks=pytest.mark.slow),
    ],
)
def test_formulas_of_a_report_fit_and_stay_what_they_are(system):
    parts = [b for c in chapters_of(system()) for b in (c.block, c.solution, c.by_all_speeds)]
    latex = [f.latex for b in parts for f in (*b.between, *b.formulas)]
    broken = 0
    for formula in latex:
        lines = broken_lines(formula, WIDTH, 2.0)
        broken += len(lines) > 1
        for line in lines:
            assert line.count(r"\left") == line.count(r"\right"), line
            assert line.count("{") == line.count("}"), line
        opened = [s for s in (r"^{1/2}", r"\big/", r"\frac{1}") if "".join(lines).count(s) != formula.count(s)]
        if not opened:
            assert joined(lines) == re.sub(r"\s", "", formula)
            assert all(em_width(line) <= 1.25 * WIDTH for line in lines) or "frac" in formula
    assert broken > 5


def test_the_outermost_sum_is_broken():
    long = " + ".join(f"a_{{{i}}} b_{{{i}}}" for i in range(9))
    assert broken_lines(rf"x = \left({long}\right) c + d", em_width(long) + 4.5)[1] == "{}+ d"
    first, *others = broken_lines(rf"x = \left({long}\right) c", em_width(long) / 2)
    assert r"\bigl(" in first
    assert others[-1].endswith(r"\bigr) c")


def test_a_fraction_or_root_wider_than_a_line_is_opened():
    long = " + ".join(f"a_{{{i}}} b_{{{i}}}" for i in range(20))
    assert broken_lines(rf"x = \frac{{{long}}}{{2}}", 25.0)[0].startswith(r"x = \frac{1}{2} \bigl(a_{0}")
    assert broken_lines(rf"x = \sqrt{{{long}}}", 25.0)[-1].endswith(r"\bigr)^{1/2}")
    assert r"\big/ " in "".join(broken_lines(rf"x = \frac{{{long}}}{{{long}}}", 25.0))


def test_a_short_formula_and_a_sign_are_left_alone():
    assert broken_lines(r"F_{x} = -\frac{a}{b}", 30.0) == [r"F_{x} = -\frac{a}{b}"]
    assert broken_lines(r"x = - a b c d", 2.0) == [r"x = - a b c d"]
