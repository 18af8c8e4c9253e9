# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one file of C99 and its header, to be built into other programs: it needs nothing but <math.h>.

Its functions are `<system>_hoist(parameters, h)` and `<system>_<routine>(ports, h, out)`; its tables give what the ports hold and
what the results are. One operation a statement; z12 is the twelfth value of its routine.
"""

from collections.abc import Mapping, Sequence

from kane.expr import ops
from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.emit.c_tables import CFile, CFunction, c_declarations, c_file, c_head, c_number, c_tables
from kane.program.emit.names import ARITHMETIC, c_comment, made_by
from kane.program.emit.sincos import LIMIT, STEPS, constant
from kane.program.emit.walk import Assign, Read, SinCos, Statement, Style, pieces, statements
from kane.program.program import Program

_FUNCTIONS = {
    OPS[n]: f"{n}({{0}})" for n in ["sqrt", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log"]
}
_FORMS = {
    **ARITHMETIC,
    **_FUNCTIONS,
    ops.POW: "pow({0}, {1})",
    OPS["atan2"]: "atan2({0}, {1})",
    OPS["abs"]: "fabs({0})",
    OPS["floor"]: "floor({0})",
    OPS["sign"]: "{0} != {0} ? {0} : ({0} > 0.0) - ({0} < 0.0)",
    OPS["min"]: "{0} < {1} || {0} != {0} ? {0} : {1}",
    OPS["max"]: "{0} > {1} || {0} != {0} ? {0} : {1}",
    ops.LESS: "{0} < {1}",
    ops.WHERE: "{0} != 0.0 ? {1} : {2}",
    ops.REGULAR: f"fabs({{0}}) > {ops.GONE!r} * {{1}} ? {{0}} : (double)NAN",
}
"""An operation of {0}, {1}, …; sines and cosines are ours."""

_NO_FAST_MATH = """\
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) \\
    || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "Compile without -ffast-math, -Ofast and the like: infinity, NaN and the order of operations matter here."
#endif
"""
_NO_CONTRACTION = """\
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract (off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
#include <float.h>
#if !defined(FLT_EVAL_METHOD) || (FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16)
#error "Doubles are computed with excess precision here: compile with -msse2 -mfpmath=sse or the like."
#endif
"""
_FOR_SINCOS = "#include <stdint.h>\n#include <string.h>\n"
_LONE = """\
static double kane_{name}(double x)
{{
    double s, c;
    kane_sincos(x, &s, &c);
    return {value};
}}
"""
_PART = """\
#if defined(__GNUC__)
#define KANE_PART static __attribute__((noinline)) /* in one piece it would take long to compile */
#elif defined(_MSC_VER)
#define KANE_PART static __declspec(noinline)
#else
#define KANE_PART static
#endif
"""

LONGEST = 2000
"""Instructions in one function at most: compilers take more than twice as long for one of twice the length."""


def emit_c(program: Program, *, contract: bool = True, version: str = "", longest: int = LONGEST) -> str:
    """The text of a file of C99, complete in itself; a routine of more than `longest` instructions becomes several functions.

    Without `contract` every operation is rounded by itself: the results of + − × ÷ √ are those of NumPy bit by bit. With it the
    compiler may round a·b + c once, where its options say so.
    """
    file = c_file(program)
    style = Style(lanes=1, whole=longest, piece=longest)
    writer = _Writer(file, style)
    code = "\n".join(map(writer.definition, file.functions))
    parts = [
        c_head(file, contract, version),
        _NO_FAST_MATH
        + ("" if contract else _NO_CONTRACTION)
        + "#include <math.h>\n"
        + (_FOR_SINCOS if writer.helpers else ""),
        c_declarations(file),
        c_tables(file),
        _PART if writer.parts else "",
        _angles(writer.helpers),
        code,
    ]
    return "\n".join(part for part in parts if part)


def emit_header(program: Program, *, contract: bool = True, version: str = "") -> str:
    """The text of the header that belongs to the file of `emit_c`, for C and C++; it is the same for both ways to round."""
    file = c_file(program)
    title = f"/* {c_comment(f'{program.name}: declarations. {made_by(version)}')} */"
    return f"{title}\n#ifndef {file.guard}\n#define {file.guard}\n\n{c_declarations(file)}\n#endif\n"


def _angles(helpers: set[str]) -> str:
    """Our sines and cosines, as far as they are called. A sine alone is faster so than the library's."""
    lone = [_LONE.format(name=name, value=name[0]) for name in ("sin", "cos") if name in helpers]
    return "\n".join([C_SINCOS, *lone]) if helpers else ""


class _Writer:
    """The functions' text; `helpers` are the helpers for angles that they call, `parts` says whether one was cut."""

    def __init__(self, file: CFile, style: Style) -> None:
        self.file, self.style = file, style
        self.helpers: set[str] = set()
        self.parts = False

    def definition(self, f: CFunction) -> str:
        """One function, or for a long block several and one that calls them in turn."""
        parts = pieces(self.file.program, f.function, self.style)
        cut = len(parts.chunks) > 1
        names = self.file.names.of(f.function, c_number)
        arguments = {**f.arguments, "w": "double *w"} if cut else f.arguments
        bodies = []
        for piece in parts.chunks:
            steps = statements(self.file.program, f.function, piece, self.style)
            used = self._used(f, steps)
            unused = [f"    (void){a};" for a in arguments if a not in used]
            bodies.append([*unused, *(line for s in steps for line in self._lines(s, names))])
        lines = []
        if cut:
            self.parts = True
            for k, body in enumerate(bodies):
                lines += [f"KANE_PART void {f.part}{k}({', '.join(arguments.values())})", "{", *body, "}", ""]
            calls = [f"    {f.part}{k}({', '.join(arguments)});" for k in range(len(bodies))]
            bodies = [[f"    double w[{max(1, parts.slots)}];", *calls]]
        return "\n".join([*lines, f"/* {c_comment(f.title)} */", f.signature, "{", *bodies[0], "}", ""])

    def _used(self, f: CFunction, body: Sequence[Statement]) -> set[str]:
        """The arguments that a piece uses."""
        names = self.file.names.arguments
        bases = {s.base for s in body if not isinstance(s, Assign | SinCos)}
        ports = [port for port in self.file.program.ports for _ in port.symbols]
        for s in body:
            operands = s.arguments if isinstance(s, Assign) else s.angles if isinstance(s, SinCos) else (s.value,)
            bases.update(ports[i].name for i in operands if i < len(ports) and ports[i].scalar)
        return {names[base] for base in bases}

    def _lines(self, s: Statement, names: Mapping[int, str]) -> list[str]:
        if isinstance(s, Read):
            return [f"    const double {names[s.value]} = {self._place(s.base, s.place)};"]
        if isinstance(s, Assign):
            text = _FORMS[s.op].format(*(names[a] for a in s.arguments))
            return [f"    const double {names[s.value]} = {text};"]
        if isinstance(s, SinCos):
            return self._sincos(names[s.angles[0]], {op: names[i] for op, i in s.values[0].items()})
        comment = f" /* {c_comment(s.label)} */" if s.label else ""
        return [f"    {self._place(s.base, s.place)} = {names[s.value]};{comment}"]

    def _place(self, base: str, place: int) -> str:
        return f"{self.file.names.arguments[base]}[{place}]"

    def _sincos(self, angle: str, names: Mapping[Op, str]) -> list[str]:
        if len(names) == 1:
            ((op, name),) = names.items()
            self.helpers.add(op.name)
            return [f"    const double {name} = kane_{op.name}({angle});"]
        self.helpers.add("sincos")
        sine, cosine = names[SIN], names[COS]
        return [f"    double {sine}, {cosine};", f"    kane_sincos({angle}, &{sine}, &{cosine});"]


# --------------------------------------------------------------------------------------------------- sine and cosine

_STEP = {"mul": "{0} * {1}", "add": "{0} + {1}", "sub": "{0} - {1}", "mul_add": "{0} * {1} + {2}"}

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


def _sincos_operand(operand: str) -> str:
    value = constant(operand)
    return operand if value is None else repr(value) if (2 * value).is_integer() else value.hex()


_STEPS = "\n".join(
    f"    const double {name} = {_STEP[form].format(*map(_sincos_operand, operands))};"
    for name, form, *operands in STEPS
)
C_SINCOS = _SINCOS.format(limit=LIMIT, steps=_STEPS)
"""`static void kane_sincos(double x, double *s, double *c)` in C99; needs <math.h>, <stdint.h> and <string.h>."""
