# SPDX-License-Identifier: BSD-3-Clause
"""Sine and cosine of one angle with a common argument reduction, as steps from which code in several languages is generated.

Method: x = n π/2 + r − tail with n = round(2x/π) and π/2 in three parts P1 + P2 + P3 (Cody & Waite, *Software Manual for the
Elementary Functions*, 1980, ch. 8), then the minimax polynomials of fdlibm (Sun Microsystems, 1993, k_sin.c and k_cos.c) at r and the
tail to first order. The error is below 1 ulp for |x| ≤ LIMIT, also near multiples of π/2, where a result is tiny. For other x,
infinities and NaN the C library's sin and cos are called.

Accuracy, with and without FMA: |n| < 2¹⁸ and P1, P2 have 35 bits, so that n P1 and n P2 fit in 53 bits. a = x − n P1 is below 1 and a
multiple of 2⁻⁵³, which ulp(n P2) divides, so that Fast2Sum gives the rounding error of r = a − n P2. The remaining errors, n (π/2 − P1
− P2 − P3) and the rounding of n P3, are below 2⁻⁵⁹ |r| even at the double nearest to each n π/2.

Rounding to nearest is assumed. All code is generated from `STEPS`; without FMA all results are the same bits, at every width.
"""

from collections.abc import Collection

import numpy as np

from kane.numeric.arrays import Array
from kane.program.emit.llvm_printer import Lanes

LIMIT = 262144.0
"""The largest |x| in rad for this argument reduction: 2¹⁸."""

CONSTANTS: dict[str, float] = {
    "ROUND": 6755399441055744.0,  # 1.5 · 2⁵²: adding it rounds to an integer, which the low bits of the sum hold
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

# The sign of the tail makes sin(−0) = −0: with it x − (…) ends in −0 − (+0).
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
    # even and odd powers separately: as few operations as Horner's rule and half its depth
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
    # cos r = w + (1 − w − z/2) + z² pc + r tail, where the bracket is the rounding error of w = 1 − z/2
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
    """The value of an operand that is a constant, possibly with a sign; None for other operands."""
    value = CONSTANTS.get(operand.removeprefix("-"))
    return -value if value is not None and operand.startswith("-") else value


def sine_cosine(x: Array) -> tuple[Array, Array]:
    """sin x and cos x for |x| ≤ LIMIT, by the steps without FMA: unlike those of NumPy, the same bits on every machine."""
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


# ------------------------------------------------------------------------------------------------------------- LLVM

# Sine and cosine are exchanged if n is odd. Bit 1 of n is the sign of the sine, bit 1 xor bit 0 that of the cosine. Masks instead of
# `select`, which for one double LLVM turns into a branch that is mispredicted half the time.
_QUADRANT = """\
  %t.bits = bitcast {v} %t to {i}
  %half = shl {i} %t.bits, {n62}
  %odd = shl {i} %t.bits, {n63}
  %mask = ashr {i} %odd, {n63}
  %flip = and {i} %half, {sign}
  %s.bits = bitcast {v} %sine to {i}
  %c.bits = bitcast {v} %cosine to {i}
  %differ = xor {i} %s.bits, %c.bits
  %swap = and {i} %differ, %mask
  %s.change = xor {i} %swap, %flip
  %c.change = xor {i} %s.change, %odd
  %s.turned = xor {i} %s.bits, %s.change
  %c.turned = xor {i} %c.bits, %c.change
  %s.near = bitcast {i} %s.turned to {v}
  %c.near = bitcast {i} %c.turned to {v}"""

_FAR = """\
  %x.bits = bitcast {v} %x to {i}
  %x.size = and {i} %x.bits, {unsigned}
  %x.abs = bitcast {i} %x.size to {v}
  %far = fcmp ugt {v} %x.abs, {limit}"""

_ANY = """\
  %bits = bitcast {b} %far to i{width}
  %any = icmp ne i{width} %bits, 0"""

_LIBRARY = """\
  br i1 {any}, label %library, label %done
library:
  %both = call {pair} @kane.sincos.far.{width}({v} %x)
  %s.library = extractvalue {pair} %both, 0
  %c.library = extractvalue {pair} %both, 1
  %s.far = select {b} %far, {v} %s.library, {v} %s.near
  %c.far = select {b} %far, {v} %c.library, {v} %c.near
  br label %done
done:
  %s = phi {v} [ %s.near, %entry ], [ %s.far, %library ]
  %c = phi {v} [ %c.near, %entry ], [ %c.far, %library ]"""

_RETURN = """\
  %result.s = insertvalue {pair} poison, {v} {s}, 0
  %result = insertvalue {pair} %result.s, {v} {c}, 1
  ret {pair} %result
}}"""

_LANE = """\
  %x{k} = extractelement {v} %x, i32 {k}
  %sin{k} = call double @sin(double %x{k})
  %cos{k} = call double @cos(double %x{k})
  %s{k} = insertelement {v} {s}, double %sin{k}, i32 {k}
  %c{k} = insertelement {v} {c}, double %cos{k}, i32 {k}"""


def llvm_sincos(width: int, contract: bool) -> str:
    """The functions of `width` angles at a time, `{V, V} @kane.sincos.<width>(V)` with V = double or <width x double>.

    Lanes are independent: a lane beyond LIMIT has the library's values, the others are unaffected. The module must declare `double
    @sin(double)` and `double @cos(double)`. With `contract`, products and sums may become FMA.
    """
    lanes = Lanes(width)
    fields = {
        "width": str(width),
        "v": lanes.double,
        "i": lanes.of("i64"),
        "b": lanes.of("i1"),
        "n62": lanes.all("i64", 62),
        "n63": lanes.all("i64", 63),
        "sign": lanes.all("i64", -(2**63)),
        "unsigned": lanes.all("i64", 2**63 - 1),
        "limit": lanes.number(LIMIT),
        "any": "%any" if width > 1 else "%far",
        "pair": f"{{{lanes.double}, {lanes.double}}}",
    }
    lines = [
        "define internal {pair} @kane.sincos.{width}({v} %x) alwaysinline nounwind {{",
        "entry:",
        *_llvm_steps(lanes, "contract " if contract else ""),
        _QUADRANT,
        _FAR,
        *([_ANY] if width > 1 else []),
        _LIBRARY,
        _RETURN,
    ]
    near = "\n".join(lines).format(**fields, s="%s", c="%c")
    return f"{near}\n{_llvm_far(width, fields)}"


def _llvm_far(width: int, fields: dict[str, str]) -> str:
    """The library's values of all lanes, in a separate cold function, to keep the callers small."""
    lines = ["define internal {pair} @kane.sincos.far.{width}({v} %x) noinline cold nounwind {{".format(**fields)]
    s, c = "poison", "poison"
    if width == 1:
        s, c = "%sin", "%cos"
        lines += ["  %sin = call double @sin(double %x)", "  %cos = call double @cos(double %x)"]
    else:
        for k in range(width):
            lines.append(_LANE.format(**fields, k=k, s=s, c=c))
            s, c = f"%s{k}", f"%c{k}"
    return "\n".join([*lines, _RETURN.format(**fields, s=s, c=c), ""])


def _llvm_steps(lanes: Lanes, flags: str) -> list[str]:
    lines = []
    for name, form, *operands in STEPS:
        x, y, *added = (_llvm_operand(o, lanes) for o in operands)
        if added:
            lines.append(f"  %{name}.product = fmul {flags}{{v}} {x}, {y}")
            form, x, y = "add", f"%{name}.product", added[0]
        lines.append(f"  %{name} = f{form} {flags}{{v}} {x}, {y}")
    return lines


def _llvm_operand(operand: str, lanes: Lanes) -> str:
    value = constant(operand)
    return f"%{operand}" if value is None else lanes.number(value)


# ---------------------------------------------------------------------------------------------------------------- C

STEP_FORMS = {"mul": "{0} * {1}", "add": "{0} + {1}", "sub": "{0} - {1}", "mul_add": "({0} * {1}) + {2}"}
"""The forms of `STEPS` in C and Rust."""

_SINCOS = """\
/* Sine and cosine of x, below 1 ulp for |x| <= {limit:.0f}; the library's beyond. */
static void kane_sincos(double x, double *s, double *c)
{{
    if (!(fabs(x) <= {limit:.1f})) {{
        *s = sin(x);
        *c = cos(x);
        return;
    }}
{steps}
    uint64_t n_bits;
    uint64_t s_bits;
    uint64_t c_bits;
    (void)memcpy((unsigned char *)&n_bits, (const unsigned char *)&t, sizeof t);
    (void)memcpy((unsigned char *)&s_bits, (const unsigned char *)&sine, sizeof sine);
    (void)memcpy((unsigned char *)&c_bits, (const unsigned char *)&cosine, sizeof cosine);
    const uint64_t odd = n_bits & UINT64_C(1);
    const uint64_t mask = (~odd) + UINT64_C(1);
    const uint64_t flip = (n_bits & UINT64_C(2)) << 62U;
    const uint64_t change = ((s_bits ^ c_bits) & mask) ^ flip;
    s_bits ^= change;
    c_bits ^= change ^ (odd << 63U);
    (void)memcpy((unsigned char *)s, (const unsigned char *)&s_bits, sizeof *s);
    (void)memcpy((unsigned char *)c, (const unsigned char *)&c_bits, sizeof *c);
}}
"""


def _sincos_operand(operand: str) -> str:
    value = constant(operand)
    return operand if value is None else repr(value) if (2 * value).is_integer() else value.hex()


_STEPS = "\n".join(
    f"    const double {name} = {STEP_FORMS[form].format(*map(_sincos_operand, operands))};"
    for name, form, *operands in STEPS
)
C_SINCOS = _SINCOS.format(limit=LIMIT, steps=_STEPS)
"""`static void kane_sincos(double x, double *s, double *c)` in C99; needs <math.h>, <stdint.h> and <string.h>."""
_LONE = """\
static double kane_{name}(double x)
{{
    double s;
    double c;
    kane_sincos(x, &s, &c);
    return {value};
}}
"""


def c_sincos(called: Collection[str]) -> str:
    """The text of the functions kane_sincos, kane_sin and kane_cos in `called`; the latter two are faster than the library's."""
    lone = [_LONE.format(name=name, value=name[0]) for name in ("sin", "cos") if name in called]
    return "\n".join([C_SINCOS, *lone]) if called else ""
