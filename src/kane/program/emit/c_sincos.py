# SPDX-License-Identifier: BSD-3-Clause
"""Sine and cosine of one angle in C99."""

from __future__ import annotations

from kane.program.emit.sincos import LIMIT, STEPS, constant

_C_FORMS = {"mul": "{0} * {1}", "add": "{0} + {1}", "sub": "{0} - {1}", "mul_add": "{0} * {1} + {2}"}

_C_FUNCTION = """\
/* Sine and cosine of x, below 1 ulp for |x| <= {limit:.0f}; the library's beyond. */
static void kane_sincos(double x, double *s, double *c)
{{
    if (!(fabs(x) <= {limit:.1f})) {{
        *s = sin(x);
        *c = cos(x);
        return;
    }}
{steps}
    uint64_t n_bits, s_bits, c_bits, change;
    memcpy(&n_bits, &t, sizeof t);
    memcpy(&s_bits, &sine, sizeof sine);
    memcpy(&c_bits, &cosine, sizeof cosine);
    change = ((s_bits ^ c_bits) & (0 - (n_bits & 1))) ^ ((n_bits & 2) << 62);
    s_bits ^= change;
    c_bits ^= change ^ ((n_bits & 1) << 63);
    memcpy(s, &s_bits, sizeof *s);
    memcpy(c, &c_bits, sizeof *c);
}}
"""


def _c_steps() -> str:
    lines = [
        f"    const double {name} = {_C_FORMS[form].format(*map(_c_operand, operands))};"
        for name, form, *operands in STEPS
    ]
    return "\n".join(lines)


def _c_operand(operand: str) -> str:
    value = constant(operand)
    if value is None:
        return operand
    return repr(value) if (2 * value).is_integer() else value.hex()


C_SINCOS = _C_FUNCTION.format(limit=LIMIT, steps=_c_steps())
"""`static void kane_sincos(double x, double *s, double *c)` in C99; needs <math.h>, <stdint.h> and <string.h>."""
