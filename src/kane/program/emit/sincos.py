# SPDX-License-Identifier: BSD-3-Clause
"""Sine and cosine of one angle by one argument reduction, as steps that languages spell for generated code.

Method: x = n π/2 + r − tail with n = round(2x/π) and π/2 in three parts P1 + P2 + P3 (Cody & Waite, *Software Manual for the
Elementary Functions*, 1980, ch. 8), then the minimax polynomials of fdlibm (Sun Microsystems, 1993, k_sin.c and k_cos.c) at r
and the tail to first order. The error is below 1 ulp for |x| ≤ LIMIT, also next to multiples of π/2, where a result is tiny.
For other x, infinities and NaN the C library's sin and cos are called.

Exactness, with and without FMA: |n| < 2¹⁸ and P1, P2 have 35 bits, so that n P1 and n P2 fit in 53 bits. a = x − n P1 is
below 1 and a multiple of 2⁻⁵³, which ulp(n P2) divides, so that Fast2Sum gives the rounding error of r = a − n P2. Left are
n (π/2 − P1 − P2 − P3) and the rounding of n P3: below 2⁻⁵⁹ |r| even at the double nearest to each n π/2.

Rounding to nearest is assumed. Every text is written from `STEPS`; without FMA all give the same bits, at every width.
"""

import numpy as np

from kane.numeric.arrays import Array

LIMIT = 262144.0
"""The largest |x| in rad of the short reduction: 2¹⁸."""

CONSTANTS: dict[str, float] = {
    "ROUND": 6755399441055744.0,  # 1.5 · 2⁵²: a sum with it is rounded to an integer, which its low bits hold
    "TWO_OVER_PI": float.fromhex("0x1.45f306dc9c883p-1"),
    "P1": float.fromhex("0x1.921fb54440000p+0"),
    "P2": float.fromhex("0x1.68c234c4c0000p-39"),
    "P3": float.fromhex("0x1.98a2e03707345p-77"),
    "HALF": 0.5,
    "ONE": 1.0,
    # (r − sin r) / r³ in powers of r²
    "S1": float.fromhex("0x1.5555555555549p-3"),
    "S2": float.fromhex("-0x1.111111110f8a6p-7"),
    "S3": float.fromhex("0x1.a01a019c161d5p-13"),
    "S4": float.fromhex("-0x1.71de357b1fe7dp-19"),
    "S5": float.fromhex("0x1.ae5e68a2b9cebp-26"),
    "S6": float.fromhex("-0x1.5d93a5acfd57cp-33"),
    # (cos r − 1 + r²/2) / r⁴ in powers of r²
    "C1": float.fromhex("0x1.555555555554cp-5"),
    "C2": float.fromhex("-0x1.6c16c16c15177p-10"),
    "C3": float.fromhex("0x1.a01a019cb1590p-16"),
    "C4": float.fromhex("-0x1.27e4f809c52adp-22"),
    "C5": float.fromhex("0x1.1ee9ebdb4b1c4p-29"),
    "C6": float.fromhex("-0x1.8fae9be8838d4p-37"),
}

# The tail has the sign that makes sin(−0) = −0: with it x − (…) ends in −0 − (+0).
STEPS: tuple[tuple[str, ...], ...] = (
    ("t", "mul_add", "x", "TWO_OVER_PI", "ROUND"),
    ("n", "sub", "t", "ROUND"),
    ("a", "mul_add", "n", "-P1", "x"),
    ("r", "mul_add", "n", "-P2", "a"),
    ("d", "sub", "r", "a"),
    ("e", "mul_add", "n", "P2", "d"),
    ("tail", "mul_add", "n", "P3", "e"),
    ("z", "mul", "r", "r"),
    ("z2", "mul", "z", "z"),
    # even and odd powers apart: as few operations as Horner's rule and half its depth
    ("s56", "mul_add", "z", "S6", "S5"),
    ("s34", "mul_add", "z", "S4", "S3"),
    ("s12", "mul_add", "z", "S2", "S1"),
    ("s36", "mul_add", "z2", "s56", "s34"),
    ("ps", "mul_add", "z2", "s36", "s12"),
    ("c56", "mul_add", "z", "C6", "C5"),
    ("c34", "mul_add", "z", "C4", "C3"),
    ("c12", "mul_add", "z", "C2", "C1"),
    ("c36", "mul_add", "z2", "c56", "c34"),
    ("pc", "mul_add", "z2", "c36", "c12"),
    # cos r = w + (1 − w − z/2) + z² pc + r tail, the bracket being the rounding error of w = 1 − z/2
    ("w", "mul_add", "z", "-HALF", "ONE"),
    ("f", "sub", "ONE", "w"),
    ("g", "mul_add", "z", "-HALF", "f"),
    ("h", "mul_add", "r", "tail", "g"),
    ("i", "mul_add", "z2", "pc", "h"),
    ("cosine", "add", "w", "i"),
    # sin r = r − (r³ ps + w tail)
    ("r3", "mul", "r", "z"),
    ("j", "mul", "tail", "w"),
    ("k", "mul_add", "r3", "ps", "j"),
    ("sine", "sub", "r", "k"),
)
"""The steps from x to `t`, `sine` and `cosine`: a name, one of mul, add, sub and mul_add, and its operands."""


def constant(operand: str) -> float | None:
    """The value of an operand that is a constant with or without a sign."""
    value = CONSTANTS.get(operand.removeprefix("-"))
    return -value if value is not None and operand.startswith("-") else value


def sine_cosine(x: Array) -> tuple[Array, Array]:
    """sin x and cos x for |x| ≤ LIMIT, by the steps without FMA: the same bits on every machine, which NumPy's own are not."""
    values: dict[str, Array] = {"x": x}

    def value(operand: str) -> Array | float:
        number = constant(operand)
        return values[operand] if number is None else number

    for name, form, *operands in STEPS:
        a, b, *c = map(value, operands)
        if form == "mul_add":
            values[name] = np.asarray(a * b + c[0])
        else:
            values[name] = np.asarray({"add": np.add, "sub": np.subtract, "mul": np.multiply}[form](a, b))
    quarter = np.asarray(np.mod(values["n"], 4))
    s, c0 = values["sine"], values["cosine"]
    sine = np.where(quarter == 0, s, np.where(quarter == 1, c0, np.where(quarter == 2, -s, -c0)))
    cosine = np.where(quarter == 0, c0, np.where(quarter == 1, -s, np.where(quarter == 2, -c0, s)))
    return sine, cosine
