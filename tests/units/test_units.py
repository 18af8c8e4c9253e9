# SPDX-License-Identifier: BSD-3-Clause
"""Units: the table against printed factors, texts, random expressions, the scales that go together; what does not fit is refused."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import kane as kn
from kane.expr import CONST, OPS, per_second
from kane.units import PLAIN, PREFIXED, RULES, conflict, parse, unit
from tests.units.factors import UNITS as PRINTED

WORDS = st.sampled_from(sorted(PRINTED.keys() - {"1"}))
FACTORS = st.tuples(
    st.sampled_from(["*", "/", " ", " * ", " / ", "·"]),
    WORDS,
    st.sampled_from(["", "^2", "**3", "^-1", "**-2", "^(1/2)", "³"]),
)
EXPONENTS_OF = {"": 1, "^2": 2, "**3": 3, "^-1": -1, "**-2": -2, "^(1/2)": Fraction(1, 2), "³": 3}
BARE = ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log")


@dataclass(frozen=True)
class Plain:
    """A unit as it is reckoned here: its text, its scale, its exponents."""

    text: str
    scale: float
    exponents: tuple[Fraction, ...]

    @classmethod
    def of(cls, name):
        scale, exponents = PRINTED[name]
        return cls(name, float(scale), tuple(map(Fraction, exponents)))

    def __mul__(self, other):
        exponents = tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True))
        return Plain(f"({self.text})*({other.text})", self.scale * other.scale, exponents)

    def __pow__(self, p):
        return Plain(f"({self.text})^({p})", self.scale ** float(p), tuple(p * e for e in self.exponents))

    def __truediv__(self, other):
        return Plain(f"({self.text})/({other.text})", *(v for k, v in vars(self * other**-1).items() if k != "text"))

    def is_like(self, other):
        return math.isclose(self.scale, other.scale, rel_tol=1e-9) and self.exponents == tuple(other.exponents)


def product_of(first, factors):
    """A text of factors, and what they are together."""
    text, whole = first, Plain.of(first)
    for sign, word, exponent in factors:
        text += sign + word + exponent
        factor = Plain.of(word) ** EXPONENTS_OF[exponent]
        whole = whole / factor if "/" in sign else whole * factor
    return text, whole


class TestTexts:
    @pytest.mark.parametrize("name", PRINTED)
    def test_each_unit_has_the_factor_that_is_printed(self, name):
        scale, exponents = PRINTED[name]
        assert parse(name).scale == pytest.approx(scale, rel=1e-11)
        assert parse(name).exponents == exponents

    def test_each_row_is_held_to_a_printed_factor(self):
        assert {names.split()[0] for names, *_ in (*PREFIXED, *PLAIN)} == PRINTED.keys() - {"kg"}

    @pytest.mark.parametrize("row", [*PREFIXED, *PLAIN], ids=lambda row: row[0])
    def test_all_names_of_a_row_are_one_unit(self, row):
        first, *others = row[0].split()
        assert all(parse(name) is parse(first) for name in others)

    @pytest.mark.parametrize(
        ("text", "same"),
        [
            ("mm", 1e-3), ("km", 1e3), ("cm", 1e-2), ("µm", 1e-6), ("um", 1e-6), ("μm", 1e-6), ("nm", 1e-9), ("Mm", 1e6),
            ("kilometer", 1e3), ("millimetres", 1e-3), ("meters", 1), ("feet", 0.3048), ("inches", 0.0254), ("dam", 10),
        ],
    )  # fmt: skip
    def test_prefixes_and_plurals(self, text, same):
        assert parse(text) is unit((0, 1, 0, 0, 0, 0, 0), same)

    @pytest.mark.parametrize(("text", "scale"), [("min", 60), ("h", 3600), ("d", 86400), ("ms", 1e-3), ("a", 31557600)])
    def test_a_name_goes_before_a_prefix(self, text, scale):
        assert parse(text) is unit((0, 0, 1, 0, 0, 0, 0), scale)

    @given(WORDS, st.lists(FACTORS, max_size=4))
    def test_products_are_read_from_left_to_right(self, first, factors):
        text, whole = product_of(first, factors)
        assert whole.is_like(parse(text))

    @given(WORDS, st.lists(FACTORS, max_size=3))
    def test_a_rate_is_a_unit_per_second(self, first, factors):
        text, whole = product_of(first, factors)
        second = Plain.of("s")
        assert (whole / second).is_like(parse(per_second(text)))
        assert (whole / second / second).is_like(parse(per_second(per_second(text))))

    @pytest.mark.parametrize(
        ("text", "scale", "exponents"),
        [
            ("lbf*ft", 1.3558179483314, (1, 2, -2)),
            ("kg m^2", 1, (1, 2, 0)),
            ("m²", 1, (0, 2, 0)),
            ("kg·m⁻²", 1, (1, -2, 0)),
            ("N·m", 1, (1, 2, -2)),
            ("N*m/(rad*s)", 1, (1, 2, -3)),
            ("m^(1/2)", 1, (0, Fraction(1, 2), 0)),
            ("m^0.5", 1, (0, Fraction(1, 2), 0)),
            ("µm", 1e-6, (0, 1, 0)),
            ("newton*meter", 1, (1, 2, -2)),
            ("meter per second", 1, (0, 1, -1)),
            ("(kg*(m/s)^2)/(m)", 1, (1, 1, -2)),
            ("m/s/s", 1, (0, 1, -2)),
            ("1/s", 1, (0, 0, -1)),
        ],
    )
    def test_ways_of_writing(self, text, scale, exponents):
        assert parse(text).scale == pytest.approx(scale, rel=1e-11)
        assert parse(text).exponents == (*exponents, 0, 0, 0, 0)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("kgg", r"got 'kgg'\. Did you mean 'kg'\?"),
            ("Kg", r"got 'Kg'\. Did you mean 'kg'\?"),
            ("m/s2", r"got 'm/s2'\. Did you mean 'm/s\^2'\?"),
            ("Nm", r"got 'Nm'\. Did you mean 'N\*m'\?"),
            ("kNm/rad", r"got 'kNm/rad'\. Did you mean 'kN\*m/rad'\?"),
            ("Ns", r"got 'Ns'\. Did you mean 'N\*s'\?"),
            ("kgm^2", r"got 'kgm\^2'\. Did you mean 'kg\*m\^2'\?"),
            ("newtonn/m", r"got 'newtonn/m'\. Did you mean 'newton/m'\?"),
            ("<b>", "got '<b>'"),
            ("m\n*s", "got"),
            ("m$", "got 'm.'"),
            ("2*m", r'Expected a unit such as "kg\*m\^2", "m/s\^2", "rad" or "1", got \'2\*m\'\. Leave the unit out'),
            ("m/", "got 'm/'"),
            ("(m", r"got '\(m'"),
            ("m)", r"got 'm\)'"),
            ("m^(1/0)", "got"),
            ("(" * 5000, "got"),
            ("kPas", r"got 'kPas'\. Did you mean 'kPa\*s'\?"),
            (" ", "got ' '"),
            ("m+s", r"got 'm\+s'"),
            ("km^9999", r"got 'km\^9999'"),
            ("km^99*km^99", r"got 'km\^99\*km\^99'"),
            ("degC", "got 'degC', which has an offset or is a logarithm. Use K"),
            ("dB", "got 'dB', which has an offset or is a logarithm"),
            ("pixel", r"got 'pixel', which is of \[printing_unit\]"),
        ],
    )
    def test_what_is_no_unit_is_refused_with_the_nearest_one(self, text, message):
        with pytest.raises(kn.UnitError, match=message):
            parse(text)


UNITS = ("m", "mm", "s", "kg", "t", "N", "kN", "N/m", "J", "rad/s", "rad", "1", "m/s^2", "Pa", "K", "A")


STEPS = {  # x and y with units a and b, `alike` with a too, a function of what is of dimension one
    "mul": lambda x, y, alike, a, b, f: (x * y, a * b),
    "div": lambda x, y, alike, a, b, f: (x / y, a / b),
    "add": lambda x, y, alike, a, b, f: (x + 2 * alike, a),
    "max": lambda x, y, alike, a, b, f: (kn.max(x, 0), a),
    "sqrt": lambda x, y, alike, a, b, f: (kn.sqrt(kn.abs(x)), a ** Fraction(1, 2)),
    "pow": lambda x, y, alike, a, b, f: (kn.abs(x) ** kn.Rational(3, 4), a ** Fraction(3, 4)),
    "neg": lambda x, y, alike, a, b, f: (-x, a),
    "scale": lambda x, y, alike, a, b, f: (kn.pi * x / 7, a),
    "atan2": lambda x, y, alike, a, b, f: (kn.atan2(x, alike), a / a),
    "bare": lambda x, y, alike, a, b, f: (f(x / alike), a / a),
    "where": lambda x, y, alike, a, b, f: (kn.where(kn.less(y, 0), x, alike), a),
}


@st.composite
def expressions(draw):
    """A consistent expression and its unit, made side by side."""

    def leaf(text):
        number = draw(st.integers(0, 2))
        return kn.parameter(f"p{number}[{text.replace(' ', '')}]", 1.5, text)

    texts = draw(st.lists(st.sampled_from(UNITS), min_size=2, max_size=4))
    made = [(leaf(text), written(text)) for text in texts]
    for step in draw(st.lists(st.sampled_from(sorted(STEPS)), max_size=8)):
        (x, a), (y, b) = (draw(st.sampled_from(made)) for _ in "xy")
        f = getattr(kn, draw(st.sampled_from(BARE)))
        made.append(STEPS[step](x, y, leaf(a.text), a, b, f))
    e, found = made[-1]
    assume(e.op is not CONST)
    return e, found


def written(text):
    """A unit of `UNITS`."""
    known = {"mm": Plain("mm", 1e-3, Plain.of("m").exponents), "kN": Plain("kN", 1e3, Plain.of("N").exponents)}
    whole, *below = (known.get(word) or Plain.of(word) for word in text.removesuffix("^2").split("/"))
    for unit_below in below:
        whole = whole / (unit_below**2 if text.endswith("^2") else unit_below)
    return whole


class TestExpressions:
    def test_every_operation_has_a_rule(self):
        assert RULES.keys() == set(OPS.values()) - {OPS["symbol"]}

    @given(expressions())
    def test_units_are_those_of_the_same_steps(self, pair):
        e, theirs = pair
        assert theirs.is_like(parse(kn.unit_of(e))), e

    @given(expressions(), st.sampled_from(UNITS), st.sampled_from(["s", "kg", "m", "mm"]))
    def test_a_sum_of_two_units_is_found_wherever_it_is(self, pair, text, odd):
        e, theirs = pair
        assume(not theirs.is_like(parse(odd)))
        wrong = e + kn.parameter("odd", 1.0, odd)
        around = kn.sqrt(kn.abs(wrong * kn.parameter("around", 1.0, text)))
        for root in (wrong, around, kn.where(kn.less(kn.time, 0), around, 0)):
            with pytest.raises(kn.UnitError, match="Expected terms of one unit"):
                kn.unit_of(root)

    @given(expressions(), st.booleans())
    def test_one_symbol_without_a_unit_makes_it_unknown(self, pair, inside):
        free = kn.parameter("free")
        assert kn.unit_of(kn.sin(free) * pair[0] if inside else pair[0] * free) == ""

    x, t, F, k = kn.coordinate("x", "m"), kn.time, kn.parameter("F", 1, "N"), kn.parameter("k", 1, "N/m")
    q, d, mm = kn.coordinate("q", "rad"), kn.parameter("d", 1, "deg"), kn.parameter("mm", 1, "mm")

    @pytest.mark.parametrize(
        ("expr", "message"),
        [
            (
                x + t,
                "Expected terms of one unit in x + t, got t [s] and x [m]. Correct the expression, or the unit of a symbol in it.",
            ),
            (x + mm, "got mm [mm] and x [m]. Give both in one unit."),
            (2 + x, 'got 2 [a number] and x [m]. Give the number a unit: kn.parameter(name, value, "unit").'),
            (kn.max(k * x, 3), "got 3 [a number] and k*x [N]. Give the number a unit"),
            (kn.where(kn.less(x, 1), 1, 2), "in x < 1"),
            (
                kn.sin(x),
                "Expected an angle (rad) or a ratio in sin(…), got x [m] in sin(x). Divide by a quantity of the same unit.",
            ),
            (kn.exp(-t), "got -t [s] in exp(-t)"),
            (kn.cos(d), "got d [deg] in cos(d). Give angles in rad."),
            (x**q, "Expected an angle (rad) or a ratio in pow(…), got x [m]"),
            (q**x, "Expected an angle (rad) or a ratio in pow(…), got x [m]"),
            (mm**1000.5, "Expected a power whose unit has a finite scale, got mm^(2001/2)"),
            (kn.atan2(x, t), "Expected terms of one unit in atan2(x, t)"),
        ],
    )
    def test_messages(self, expr, message):
        with pytest.raises(kn.UnitError, match=re.escape(message)):
            kn.unit_of(expr)

    @pytest.mark.parametrize(
        ("expr", "text"),
        [
            (x, "m"),
            (x.dt, "m/s"),
            (x.dt.dt, "m/s^2"),
            (q.dt.dt, "rad/s^2"),
            (k * x, "N"),
            (k * x * x / 2, "J"),
            (F * x.dt, "W"),
            (k * x.dt, "kg*m/s^3"),
            (F / x.dt, "N*s/m"),
            (q + kn.pi / 2, "rad"),
            (2 * q - kn.pi, "rad"),
            (kn.cos(q), "1"),
            (kn.sqrt(k / F), "1/m^(1/2)"),
            (F * kn.parameter("c", 1, "N*m"), "kg^2*m^3/s^4"),
            (kn.parameter("c", 1, "N*m") * kn.cos(q), "N*m"),
            (mm / t, "mm/s"),
            (kn.parameter("kN", 1, "kN") / mm, "kg/ms^2"),
            (kn.parameter("f", 1, "ft") ** 2, "ft^2"),
            (t, "s"),
            (1, "1"),
            (0, ""),
        ],
    )
    def test_spellings(self, expr, text):
        assert kn.unit_of(expr) == text


EXPONENTS = st.lists(st.tuples(*[st.integers(-3, 3)] * 3), min_size=1, max_size=8)
TENS = st.tuples(*[st.integers(-3, 3)] * 3)


def scaled(exponents, tens, factor=1.0):
    return unit((*exponents, 0, 0, 0, 0), factor * 10.0 ** sum(e * k for e, k in zip(exponents, tens, strict=True)))


class TestScales:
    @given(EXPONENTS, TENS)
    def test_units_of_one_choice_of_base_units_go_together(self, rows, tens):
        assert conflict([scaled(row, tens) for row in rows]) is None

    @given(EXPONENTS, TENS, st.lists(st.integers(-2, 2), min_size=8, max_size=8))
    def test_a_combination_of_them_with_a_factor_does_not(self, rows, tens, shares):
        combined = tuple(sum(s * row[i] for s, row in zip(shares, rows, strict=False)) for i in range(3))
        odd = scaled(combined, tens, 1000.0)
        found = conflict([*(scaled(row, tens) for row in rows), odd])
        assert found is not None
        assert odd in found.units
        assert found.factor == pytest.approx(1000)

    @pytest.mark.parametrize(
        "units",
        [
            "kg m s N J",
            "t mm s N mJ",
            "N mm",
            "lb ft s",
            "g mm s",
            "N/m kg mm s",
        ],
    )
    def test_accepted(self, units):
        assert conflict([parse(u) for u in units.split()]) is None

    @pytest.mark.parametrize("units", ["m mm", "N g mm s", "kg m s kN", "s rpm", "deg", "kg m s lbf", "%"])
    def test_refused(self, units):
        assert conflict([parse(u) for u in units.split()]) is not None


def test_powers_of_units_are_exact():
    root = kn.parameter("A", 1.0, "m^2") ** kn.Rational(1, 3)
    assert parse(kn.unit_of(root)).exponents[1] == Fraction(2, 3)
    assert kn.unit_of(root**3 / kn.parameter("A", 1.0, "m^2")) == "1"
