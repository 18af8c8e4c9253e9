# SPDX-License-Identifier: BSD-3-Clause
"""The unit of an expression from those of its symbols: one rule an operation.

None means unknown: a symbol below carries no unit, and nothing is checked there. Numbers are of dimension one, 0 fits
any unit, angles are of dimension one.

A unit is exponents over base quantities and a scale to SI; units multiply, divide and take powers.

Equal units are one object: scales are rounded to twelve digits. Units go together without factors where one choice of base units
explains them all: N with kg, m and s does, N with t, mm and s does, mm with m does not. With e the exponents of a unit, c its scale
and b the scales of the base units, Σ eᵢ log bᵢ = log c must have a solution b. Elimination in exact exponents finds out, and keeps
track of which units a contradiction is made of.

Units are read from texts, products and quotients of powers of the names in a table, with prefixes, plurals and brackets, and written
in the spelling of the symbols at hand where one of them has that unit. Sources of the table:
BIPM, The International System of Units, 9th edition (2019), tables 2, 4, 7 and 8; NIST Special Publication 811 (2008),
appendix B; for the unified atomic mass unit CODATA 2022. All other factors are exact.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import cache, lru_cache
from itertools import product as choices
from typing import Any, NoReturn

from kane.errors import UnitError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr, constant_value, postorder
from kane.expr.ops import OPS, SYMBOL
from kane.expr.piecewise import Piecewise
from kane.expr.visit import fold

BASES = {
    "kg": "mass",
    "m": "length",
    "s": "time",
    "A": "current",
    "K": "temperature",
    "mol": "substance",
    "cd": "luminosity",
}
"""Symbols of the base units, and the quantities they measure, in the order of `Unit.exponents`."""

PREFIXES = {
    "q": -30, "r": -27, "y": -24, "z": -21, "a": -18, "f": -15, "p": -12, "n": -9, "µ": -6, "m": -3, "c": -2, "d": -1,
    "da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12, "P": 15, "E": 18, "Z": 21, "Y": 24, "R": 27, "Q": 30,
    "pico": -12, "nano": -9, "micro": -6, "milli": -3, "centi": -2, "deci": -1,
    "deca": 1, "hecto": 2, "kilo": 3, "mega": 6, "giga": 9, "tera": 12, "u": -6,
}  # fmt: skip
"""Powers of ten by prefix."""

_POUND, _FOOT, _GRAVITY = 0.45359237, 0.3048, 9.80665
_LBF = _POUND * _GRAVITY
_DEGREE = math.pi / 180

PREFIXED = (
    # base units, angles
    ("g gram gramme", 1e-3, "kg"), ("m meter metre", 1, "m"), ("s second sec", 1, "s"), ("A ampere amp", 1, "A"),
    ("K kelvin", 1, "K"), ("mol mole", 1, "mol"), ("cd candela", 1, "cd"), ("rad radian", 1, "1"), ("sr steradian", 1, "1"),
    # derived units with names
    ("N newton", 1, "kg*m/s^2"), ("J joule", 1, "N*m"), ("W watt", 1, "J/s"), ("Pa pascal", 1, "N/m^2"), ("Hz hertz", 1, "1/s"),
    ("V volt", 1, "W/A"), ("C coulomb", 1, "A*s"), ("F farad", 1, "C/V"), ("Ω ohm", 1, "V/A"), ("S siemens", 1, "A/V"),
    ("Wb weber", 1, "V*s"), ("T tesla", 1, "Wb/m^2"), ("H henry", 1, "Wb/A"), ("lm lumen", 1, "cd"), ("lx lux", 1, "cd/m^2"),
    ("Bq becquerel", 1, "1/s"), ("Gy gray", 1, "J/kg"), ("Sv sievert", 1, "J/kg"), ("kat katal", 1, "mol/s"),
    # used with them
    ("t tonne metric_ton", 1e3, "kg"), ("L l liter litre", 1e-3, "m^3"), ("bar", 1e5, "Pa"), ("Wh watt_hour", 3600, "J"),
    ("cal calorie", 4.184, "J"), ("dyn dyne", 1e-5, "N"), ("P poise", 0.1, "Pa*s"), ("St stokes", 1e-4, "m^2/s"),
    ("eV electron_volt electronvolt", 1.602176634e-19, "J"), ("u amu Da dalton", 1.66053906892e-27, "kg"),
)  # fmt: skip
"""Names, how many, of what: units that take prefixes."""

PLAIN = (
    # ratios, angles, turns
    ("1 dimensionless", 1, ""), ("% percent", 1e-2, "1"), ("ppm", 1e-6, "1"), ("deg degree °", _DEGREE, "rad"),
    ("arcmin arcminute", _DEGREE / 60, "rad"), ("arcsec arcsecond", _DEGREE / 3600, "rad"), ("gon grad grade", math.pi / 200, "rad"),
    ("rev revolution turn cycle", 2 * math.pi, "rad"),
    ("rpm revolutions_per_minute", math.pi / 30, "rad/s"), ("rps revolutions_per_second", 2 * math.pi, "rad/s"),
    # time
    ("min minute", 60, "s"), ("h hr hour", 3600, "s"), ("d day", 86400, "s"), ("week", 604800, "s"), ("yr a year", 31557600, "s"),
    # length, area, volume
    ("Å angstrom", 1e-10, "m"), ("micron", 1e-6, "m"), ("thou", _FOOT / 12000, "m"), ("in inch inches", _FOOT / 12, "m"),
    ("ft foot feet", _FOOT, "m"), ("yd yard", 3 * _FOOT, "m"), ("mi mile", 5280 * _FOOT, "m"), ("nmi nautical_mile", 1852, "m"),
    ("au astronomical_unit", 149597870700, "m"), ("are", 100, "m^2"), ("ha hectare", 1e4, "m^2"),
    ("cc cubic_centimeter", 1e-6, "m^3"), ("gal gallon", 231 * (_FOOT / 12) ** 3, "m^3"),
    # velocity, acceleration
    ("kph kmh kilometer_per_hour", 1 / 3.6, "m/s"), ("mph mile_per_hour", 5280 * _FOOT / 3600, "m/s"),
    ("kn kt knot", 1852 / 3600, "m/s"), ("g0 g_0 g_n standard_gravity", _GRAVITY, "m/s^2"), ("Gal galileo", 1e-2, "m/s^2"),
    # mass
    ("lb lbs lbm pound", _POUND, "kg"), ("oz ounce", _POUND / 16, "kg"), ("gr grain", _POUND / 7000, "kg"),
    ("stone", 14 * _POUND, "kg"), ("slug", _LBF / _FOOT, "kg"),
    ("ton short_ton", 2000 * _POUND, "kg"), ("long_ton", 2240 * _POUND, "kg"),
    # force, pressure
    ("lbf pound_force force_pound", _LBF, "N"), ("ozf ounce_force", _LBF / 16, "N"), ("kip", 1000 * _LBF, "N"),
    ("pdl poundal", _POUND * _FOOT, "N"), ("kgf kp kilogram_force kilopond", _GRAVITY, "N"), ("gf gram_force", 1e-3 * _GRAVITY, "N"),
    ("psi", 144 * _LBF / _FOOT**2, "Pa"), ("ksi", 144000 * _LBF / _FOOT**2, "Pa"), ("atm atmosphere", 101325, "Pa"),
    ("torr Torr", 101325 / 760, "Pa"), ("mmHg", 133.322387415, "Pa"), ("inHg", 25.4 * 133.322387415, "Pa"),
    # energy, power
    ("Btu BTU british_thermal_unit", 1055.05585262, "J"), ("erg", 1e-7, "J"), ("foot_pound", _LBF * _FOOT, "J"),
    ("hp horsepower", 550 * _LBF * _FOOT, "W"), ("metric_horsepower", 75 * _GRAVITY, "W"),
)  # fmt: skip
"""Names, how many, of what: units that take none."""

SHIFTED = {
    "degC", "°C", "celsius", "degree_Celsius", "degF", "°F", "fahrenheit", "degree_Fahrenheit", "dB", "decibel", "dBm", "dBu", "bel",
    "Np", "neper", "pH",
}  # fmt: skip
"""Units in which twice the number is not twice the quantity."""

FOREIGN = {"pixel": "printing_unit", "dot": "printing_unit", "bit": "information", "byte": "information"}
"""Units of what mechanics does not measure, and what that is."""


Exponent = int | Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Unit:
    """Exponents over kg, m, s, A, K, mol and cd, and how many coherent SI units one of it is."""

    exponents: tuple[Exponent, ...]
    scale: float

    @property
    def is_bare(self) -> bool:
        """Whether it is of dimension one: an angle, a ratio."""
        return self.exponents == NONE


NONE: tuple[Exponent, ...] = (0,) * 7
NUMBER = Unit(NONE, 1.0)
"""Of a number without a unit: of dimension one, and nobody said so."""
ANY = Unit(NONE, 1.0)
"""Of the number 0, which is zero in any unit."""

_units: dict[tuple[tuple[Exponent, ...], float], Unit] = {}


def unit(exponents: tuple[Exponent, ...], scale: float = 1.0) -> Unit:
    """The one unit with these exponents and this scale; an OverflowError where the scale is zero or infinite."""
    rounded = float(f"{scale:.12g}")
    if not 0 < rounded < math.inf:
        raise OverflowError(scale)
    key = (tuple(int(e) if e == int(e) else e for e in exponents), rounded)
    return _units.setdefault(key, Unit(*key))


ONE = unit(NONE)
"""Of what is said to be of dimension one: a ratio, an angle in radians."""


@lru_cache(8192)
def product(a: Unit, b: Unit) -> Unit:
    """The unit of x y."""
    if a is NUMBER or b is ANY:
        return b
    if b is NUMBER or a is ANY:
        return a
    return unit(tuple(x + y for x, y in zip(a.exponents, b.exponents, strict=True)), a.scale * b.scale)


@lru_cache(8192)
def power(a: Unit, p: Exponent) -> Unit:
    """The unit of x**p."""
    return a if a is NUMBER or a is ANY else unit(tuple(e * p for e in a.exponents), a.scale**p)


@lru_cache(8192)
def quotient(a: Unit, b: Unit) -> Unit:
    """The unit of x / y."""
    return product(a, power(b, -1))


_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class Conflict:
    """Units that no choice of base units explains together, and the factor that is left over."""

    units: tuple[Unit, ...]
    factor: float


def conflict(units: Iterable[Unit]) -> Conflict | None:
    """The first contradiction among the units; those that come early are believed."""
    rows: dict[int, tuple[list[Fraction], float, dict[Unit, Fraction]]] = {}
    for unit in units:
        exponents, rest = [Fraction(e) for e in unit.exponents], math.log(unit.scale)
        parts = {unit: Fraction(1)}
        for i in range(len(BASES)):
            if not exponents[i]:
                continue
            if i not in rows:
                rows[i] = (exponents, rest, parts)
                break
            row, scale, others = rows[i]
            factor = exponents[i] / row[i]
            exponents = [x - factor * y for x, y in zip(exponents, row, strict=True)]
            rest -= float(factor) * scale
            for other, share in others.items():
                parts[other] = parts.get(other, Fraction(0)) - factor * share
        else:
            if abs(rest) > _SLACK:
                return Conflict(tuple(u for u, share in parts.items() if share), math.exp(rest))
    return None


_NAME = r"°[A-Za-z]*|%|[^\W\d_]\w*"
_WORD = re.compile(_NAME)
_FACTOR = re.compile(rf"( *[*·⋅](?!\*) *| */ *| +per +| +|^)({_NAME}|1(?!\d)|\()")
_EXPONENT = re.compile(r" *(?:\^|\*\*) *(?:(-?\d+(?:\.\d+)?)|\( *(-?\d+(?:\.\d+)?(?: */ *\d+)?) *\))")
_LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹μΩ", "-0123456789µΩ")
_FINEST = 10_000
_NEAR = 0.8
_PLURAL = 3
"""Letters that a name needs to take a plural: 2 newtons, but Ns is no unit."""

_BASES = tuple(BASES)
_ROWS = {name: row for rows in (PREFIXED, PLAIN) for row in rows for name in row[0].split()}
_TAKES_PREFIX = {name for names, *_ in PREFIXED for name in names.split()}
USUAL = [p + s for s in ("g", "m", "s", "A", "N", "J", "W", "Pa", "Hz", "V") for p in ("", "m", "k", "M")]
USUAL += ["1", "rad", "deg", "cm", "t", "min", "h", "rpm", "K"]
"""Symbols that are proposed in place of what is no unit."""


@lru_cache(4096)
def parse(text: str) -> Unit:
    """The unit that "kg*m^2" or "m/s^2" means; a UnitError for what means none, or one that models cannot be written in (degC, dB)."""
    meant = _read(text)
    if meant is None:
        _refuse(text)
    return meant


def _read(text: str) -> Unit | None:
    """The unit of a text, None where it is none, or one whose scale is no number."""
    try:
        return _product(re.sub("[⁻⁰¹²³⁴-⁹]+", r"^\g<0>", text).translate(_LOWERED).strip(" "))
    except (OverflowError, ZeroDivisionError, RecursionError):
        return None


def _product(text: str) -> Unit | None:
    whole, at = ONE, 0
    while at < len(text):
        factor = _FACTOR.match(text, at)
        if factor is None:
            return None
        at = factor.end()
        if factor[2] == "(":
            close = _closing(text, at)
            base = _product(text[at:close].strip(" ")) if close else None
            at = close + 1
        else:
            base = symbol(factor[2])
        if base is None:
            return None
        exponent = _EXPONENT.match(text, at)
        if exponent is not None:
            base = power(base, Fraction((exponent[1] or exponent[2]).replace(" ", "")).limit_denominator(_FINEST))
            at = exponent.end()
        inverse = "/" in factor[1] or "per" in factor[1]
        whole = quotient(whole, base) if inverse else product(whole, base)
    return whole if text else None


def _closing(text: str, at: int) -> int:
    """Where the bracket closes that is open at `at`; 0 where it does not."""
    depth = 1
    for i in range(at, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if not depth:
            return i
    return 0


@cache
def symbol(word: str) -> Unit | None:
    """The unit of one name, with a prefix or in the plural; None for what is no unit."""
    if word in BASES:
        return unit(tuple(int(word == base) for base in _BASES))
    if word in _ROWS:
        _, scale, of = _ROWS[word]
        base = parse(of) if of else ONE
        return unit(base.exponents, scale * base.scale)
    for i in range(1, len(word)):
        whole = symbol(word[i:]) if word[:i] in PREFIXES and _singular(word[i:]) in _TAKES_PREFIX else None
        if whole is not None:
            return unit(whole.exponents, float(f"1e{PREFIXES[word[:i]]}") * whole.scale)
    return symbol(word[:-1]) if _singular(word) != word else None


def _singular(word: str) -> str:
    return (
        word[:-1] if word not in _ROWS and word.endswith("s") and len(word) > _PLURAL and word[:-1] in _ROWS else word
    )


# What is no unit -----------------------------------------------------------------------------------------------------------


def _refuse(text: str) -> NoReturn:
    words = _WORD.findall(text)
    if not SHIFTED.isdisjoint(words):
        raise UnitError(
            f"Expected a unit in which twice the number is twice the quantity, got {text!r}, which has an offset or is a "
            "logarithm. Use K for temperatures, ratios for levels."
        )
    others = [FOREIGN[w] for w in words if w in FOREIGN]
    if others:
        raise UnitError(f"Expected a unit of {', '.join(BASES.values())}, got {text!r}, which is of [{others[0]}].")
    mended = _WORD.sub(lambda word: word[0] if symbol(word[0]) else _nearest(word[0]), text)
    cure = f" Did you mean {mended!r}?" if mended != text and _read(mended) is not None else ""
    raise UnitError(
        f'Expected a unit such as "kg*m^2", "m/s^2", "rad" or "1", got {cut(repr(text), 80)}.{cure} Leave the unit out '
        '("") for a symbol that '
        "is not to be checked."
    )


def _nearest(word: str) -> str:
    stem = word.rstrip("0123456789")
    if stem != word and symbol(stem):
        return f"{stem}^{word[len(stem) :]}"
    for name in USUAL:
        if name.lower() == word.lower():
            return name
    near = _apart(word) or get_close_matches(word, USUAL, 1) or get_close_matches(word, _ROWS, 1, _NEAR)
    return near[0] if near else word


def _apart(word: str) -> list[str]:
    """A word that is two or three symbols of different dimensions written as one: Ns as N*s."""
    for i in range(1, len(word)):
        head, tail = word[:i], word[i:]
        rest = [tail] if tail in USUAL else _apart(tail) if head in USUAL else []
        if head in USUAL and rest and all(_exponents(head) != _exponents(s) for s in rest[0].split("*")):
            return [f"{head}*{rest[0]}"]
    return []


def _exponents(word: str) -> object:
    meant = symbol(word)
    return meant and meant.exponents


_NAMED = {parse(p + s): p + s for s in "NJW" for p in ("", "m", "k", "M")} | {
    parse(text): text for text in ("N/m", "N*s/m", "N*m*s")
}
_USUAL = (("kg", "g", "t"), ("m", "mm", "cm", "km"), ("s", "ms", "min", "h"), ("A",), ("K",), ("mol",), ("cd",))
_SI = tuple(names[0] for names in _USUAL)
_LINEAR = {"add", "sub", "neg", "symbol", "const", "pi"}


def spelled(unit: Unit, e: Expr | None = None) -> str:
    """A unit as text that `parse` reads; a symbol's spelling where one in `e` has this unit, for an angle in rad too."""
    leaves = () if e is None else free_symbols((e,))
    written = {parse(s.unit): s.unit for s in reversed(leaves) if s.unit}
    own = written.get(unit, "")
    if unit.is_bare and unit.scale == 1:
        linear = e is not None and all(_keeps_angles(node) for node in postorder((e,)))
        return own if own and linear else "1"
    plain = f"{unit.scale:.6g} {_joined(_SI, unit.exponents)}"
    return own or _NAMED.get(unit) or next(_composed(unit, written), plain)


def _keeps_angles(node: Expr) -> bool:
    return node.op.name in _LINEAR or (node.op.name == "mul" and node.args[0].op.name in ("const", "pi"))


def _composed(unit: Unit, written: Mapping[Unit, str]) -> Iterator[str]:
    """Products of base units that have its scale, those of the symbols at hand first, then those of SI."""
    options: list[list[str]] = []
    for i, names in enumerate(_USUAL):
        base = (*NONE[:i], 1, *NONE[i + 1 :])
        options.append([*(t for u, t in written.items() if u.exponents == base), *names] if unit.exponents[i] else [""])
    for chosen in choices(*options):
        scale = math.prod(parse(n).scale ** float(e) for n, e in zip(chosen, unit.exponents, strict=True) if e)
        if math.isclose(scale, unit.scale, rel_tol=1e-9):
            yield _joined(chosen, unit.exponents)


def _joined(names: Sequence[str], exponents: tuple[Exponent, ...]) -> str:
    pairs = list(zip(names, exponents, strict=True))
    above = "*".join(_powered(n, e) for n, e in pairs if e > 0)
    below = "".join(f"/{_powered(n, -e)}" for n, e in pairs if e < 0)
    return (above or "1") + below


def _powered(name: str, exponent: Exponent) -> str:
    if exponent == 1:
        return name
    return f"{name}^({exponent})" if isinstance(exponent, Fraction) else f"{name}^{exponent}"


def unit_text(unit: str) -> str:
    """A unit with raised exponents: m/s², N·m."""
    return re.sub(r"\^(-?\d+)", lambda m: m[1].translate(_RAISED), unit).replace("*", "·").replace(" ", " ")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


Known = dict[Expr, Unit | None]
Rule = Callable[..., Unit]

_HALF = Fraction(1, 2)


def infer(root: Expr, units: Known) -> Unit | None:
    """The unit of `root`, None where a symbol without one is below; `units` is filled on the way. Errors are those of `unit_of`."""

    def combine(node: Expr) -> Unit | None:
        if node.op is SYMBOL:
            text: str = node.unit  # type: ignore[attr-defined]  # the operation says that it is a Symbol
            return parse(text) if text else None
        own = [units[a] for a in node.args]
        if isinstance(node.op, Piecewise):
            return _of_table(node, node.op, own[0])
        return None if None in own else RULES[node.op](node, *own)

    return fold(root, units, combine)


def _of_table(node: Expr, op: Piecewise, argument: Unit | None) -> Unit | None:
    """The unit that a table declares, over that of its argument where it is a derivative."""
    declared = parse(op.of) if op.of else None
    if argument not in (None, ANY) and declared is not None and not agree(argument, declared):
        raise UnitError(
            f"Expected an argument in {op.of} of {op.label}, got {_said(node.args[0], argument)} in {cut(node)}."
        )
    argument = argument if declared is None else declared
    if not op.unit or (op.order and argument is None):
        return None
    return quotient(parse(op.unit), power(argument, Fraction(op.order))) if op.order else parse(op.unit)


def agree(a: Unit, b: Unit) -> bool:
    """Whether quantities in these units can be added as they are."""
    return a is b or (a.exponents == b.exponents and math.isclose(a.scale, b.scale, rel_tol=_SLACK))


def _common(node: Expr, terms: tuple[Expr, ...], units: tuple[Unit, ...]) -> Unit:
    """The one unit of all the terms."""
    first, shared = terms[0], units[0]
    for term, unit in zip(terms[1:], units[1:], strict=True):
        if shared is ANY or (shared is NUMBER and agree(shared, unit)):
            first, shared = (first, shared) if unit is ANY else (term, unit)
        elif unit is not ANY and not agree(shared, unit):
            raise UnitError(
                f"Expected terms of one unit in {cut(node)}, got {_said(first, shared)} and {_said(term, unit)}. "
                f"{_cure(shared, unit)}"
            )
    return shared


def _said(e: Expr, unit: Unit) -> str:
    return f"{cut(e, 40)} [{'a number' if unit is NUMBER else spelled(unit, e)}]"


def _cure(a: Unit, b: Unit) -> str:
    if NUMBER in (a, b):
        return 'Give the number a unit: kn.parameter(name, value, "unit").'
    if a.exponents == b.exponents:
        return "Give both in one unit."
    return "Correct the expression, or the unit of a symbol in it."


def _compared(node: Expr, *units: Unit) -> Unit:
    _common(node, node.args, units)
    return ONE


def _bare(node: Expr, *units: Unit) -> Unit:
    for e, unit in zip(node.args, units, strict=True):
        if not agree(unit, ONE):
            cure = "Give angles in rad." if unit.is_bare else "Divide by a quantity of the same unit."
            raise UnitError(
                f"Expected an angle (rad) or a ratio in {node.op.name}(…), got {_said(e, unit)} in {cut(node)}. {cure}"
            )
    return ONE


def _power(node: Expr, base: Unit, exponent: Unit) -> Unit:
    value = constant_value(node.args[1])
    if value is None:
        return _bare(node, base, exponent)
    try:
        return power(base, Fraction(value).limit_denominator(_FINEST))
    except OverflowError:
        raise UnitError(f"Expected a power whose unit has a finite scale, got {cut(node)}.") from None


RULES: dict[object, Rule] = {
    OPS[name]: rule
    for names, rule in (
        ("const", lambda node: ANY if constant_value(node) == 0 else NUMBER),
        ("pi", lambda node: NUMBER),
        ("add sub min max", lambda node, *units: _common(node, node.args, units)),
        ("where", lambda node, condition, *units: _common(node, node.args[1:], units)),
        ("less atan2", _compared),
        ("mul", lambda node, a, b: product(a, b)),
        ("div", lambda node, a, b: quotient(a, b)),
        ("neg abs", lambda node, a: a),
        ("regular", lambda node, a, size: a),
        ("sign", lambda node, a: ONE),
        ("sqrt", lambda node, a: power(a, _HALF)),
        ("pow", _power),
        ("sin cos tan asin acos atan sinh cosh tanh exp log floor", _bare),
    )
    for name in names.split()
}
"""The unit of each operation from the node and the units of its arguments."""


def unit_of(expr: Any, known: Known | None = None) -> str:
    """The unit of an expression, such as "m/s^2", from the units of its symbols; "" where one of them has none.

    A symbol's own unit is as it was declared. Numbers are of dimension one, 0 fits any unit; an angle is in "rad", a ratio in
    "1". `known` gives units to symbols that have none.

    Raises
    ------
    UnitError
        if terms of different units are added or compared, or a function takes what is not of dimension one
    """
    e = as_expr(expr)
    unit = infer(e, dict(known or {}))
    return "" if unit is None or unit is ANY else spelled(unit, e)
