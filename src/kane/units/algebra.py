# SPDX-License-Identifier: BSD-3-Clause
"""Units: a unit is exponents over base quantities and a scale to SI; units multiply, divide and take powers.

Equal units are one object: scales are rounded to twelve digits. Units go together without factors where one choice of base units
explains them all: N with kg, m and s does, N with t, mm and s does, mm with m does not. With e the exponents of a unit, c its scale
and b the scales of the base units, Σ eᵢ log bᵢ = log c must have a solution b. Elimination in exact exponents finds out, and keeps
track of which units a contradiction is made of.

The table of units: names, how many, of what.

Sources: BIPM, The International System of Units, 9th edition (2019), tables 2, 4, 7 and 8; NIST Special Publication 811 (2008),
appendix B; for the unified atomic mass unit CODATA 2022. All other factors are exact.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

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
