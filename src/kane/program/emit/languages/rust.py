# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a no_std Rust crate: the text of `src/lib.rs`, and `Cargo.toml`.

Mathematical functions, which `core` lacks, are those of the C library; sines and cosines are those of `emit/sincos.py`, as in C.
"""

from kane.expr.ops import COS, SIN
from kane.program.emit.identifiers import c_comment, decimal, free_in, identifier, made_by
from kane.program.emit.languages import straight
from kane.program.emit.sincos import LIMIT, STEP_FORMS, STEPS, constant
from kane.program.emit.walk import Style
from kane.program.kernel import language
from kane.program.program import Program

_CALLED = "sqrt tan asin acos atan sinh cosh tanh exp log floor"
_RUST = straight.Language(
    straight.forms(
        {
            "atan2": "kane_atan2({0}, {1})",
            "pow": "kane_pow({0}, {1})",
            "abs": "kane_abs({0})",
            "min": "if ({0} < {1}) || ({0} != {0}) {{ {0} }} else {{ {1} }}",
            "max": "if ({0} > {1}) || ({0} != {0}) {{ {0} }} else {{ {1} }}",
            "less": "if {0} < {1} {{ 1.0 }} else {{ 0.0 }}",
            "sign": "if {0} != {0} {{ {0} }} else if {0} > 0.0 {{ 1.0 }} else if {0} < 0.0 {{ -1.0 }} else {{ 0.0 }}",
            "where": "if {0} != 0.0 {{ {1} }} else {{ {2} }}",
            "regular": f"if kane_abs({{0}}) > {straight.GONE_TEXT} * {{1}} {{{{ {{0}} }}}} else {{{{ f64::NAN }}}}",
        },
        _CALLED,
        "kane_{}({{0}})",
    ),
    lambda value: decimal(value, "f64::NAN", "f64::INFINITY"),
    free_in("rust"),
    "//",
    define="let {0}: f64 = {1};",
    store="{0} = {1};",
)
_STYLE = Style(lazy=True, lanes=1, whole=2000, piece=2000)
_ALLOWED = "#![allow(unused_variables, unused_parens, non_snake_case, non_upper_case_globals, dead_code, clippy::all)]"
_ABS = """
#[inline(always)]
fn kane_abs(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !(1u64 << 63))
}"""
_SINCOS = """
/// Sine and cosine of x, below 1 ulp for |x| <= {limit:.0f}; those of C's library beyond.
#[inline(never)]
fn kane_sincos(x: f64) -> (f64, f64) {{
    if !(kane_abs(x) <= {limit:.1f}) {{
        return unsafe {{ (math::sin(x), math::cos(x)) }};
    }}
{steps}
    let n_bits = t.to_bits();
    let (s_bits, c_bits) = (sine.to_bits(), cosine.to_bits());
    let odd = n_bits & 1;
    let mask = 0u64.wrapping_sub(odd);
    let change = ((s_bits ^ c_bits) & mask) ^ ((n_bits & 2) << 62);
    (f64::from_bits(s_bits ^ change), f64::from_bits(c_bits ^ change ^ (odd << 63)))
}}"""


def _operand(name: str) -> str:
    value = constant(name)
    return name if value is None else decimal(value, "", "")


class RustPrinter(straight.StraightPrinter):
    """Prints the statements of one function."""

    def sincos(self, s: language.SinCos) -> None:
        """Adds the sine, the cosine or both of one angle."""
        ((angle,), (own,)) = s.angles, s.values
        sine, cosine = (self.names[own[op]] if op in own else "_" for op in (SIN, COS))
        self.used.add("sincos")
        self.add(f"let ({sine}, {cosine}) = kane_sincos({self.names[angle]});")


def emit_cargo(program: Program, *, version: str = "") -> str:
    """The text of `Cargo.toml` for the `src/lib.rs` of `emit_rust`."""
    name = (identifier(program.name) or "system").lower()
    lines = [
        f"# {c_comment(made_by(version))}",
        "[package]",
        f'name = "kane-{name.replace("_", "-")}"',
        'version = "0.1.0"',
    ]
    return "\n".join([*lines, 'edition = "2021"', 'rust-version = "1.63"', "", "[dependencies]", ""])


def emit_rust(program: Program, *, version: str = "") -> str:
    """The text of `src/lib.rs`: `hoist(p, h)` and `<routine>(ports, h, out)`, on arrays of fixed length.

    Rust rounds each operation separately.
    """
    file = straight.file_of(program, _RUST, ("w", "DEFAULTS"), style=_STYLE, printer=RustPrinter)
    hoist, *routines = file.functions
    call = [
        f"Call: {hoist.name}({', '.join([*_passed(file, hoist), '&mut h'])}) once for each set of parameters; then",
        *(f"      {f.name}({', '.join(_passed(file, f))}, &h, &mut out)," for f in routines),
        "      arrays of doubles, of matrices row by row. Without std: link C's library of mathematics (-lm).",
    ]
    lines = [f"// {line}".rstrip() for line in straight.head(file, version, call)]
    lines += ["#![no_std]", _ALLOWED, "", "/// The parameters, NAN where there is no default."]
    count = sum(len(p.symbols) for p in program.hoisted_ports)
    lines += [f"pub const DEFAULTS: [f64; {count}] = [{straight.numbers_of(program, _RUST)}];"]
    for f in file.functions:
        lines += _function(file, f)
    return "\n".join([*lines, *_helpers(file.used), ""])


def _passed(file: straight.File, f: straight.Emitted) -> list[str]:
    return [f"{'' if p.scalar else '&'}{file.names.arguments[p.name]}" for p in f.function.ports]


def _function(file: straight.File, f: straight.Emitted) -> list[str]:
    """The definition of a function; a long block is split into several functions and one that calls them in turn."""
    names, ports = file.names.arguments, f.function.ports
    given = [f"{names[p.name]}: {'f64' if p.scalar else f'&[f64; {len(p.symbols)}]'}" for p in ports]
    given += [f"h: &[f64; {len(file.program.kept)}]"] if f.hoisting else []
    given.append(f"{f.target}: &mut [f64; {len(f.function.results)}]")
    passed = [g.partition(":")[0] for g in given]
    lines = [""]
    if len(f.parts) > 1:
        work = f"w: &mut [f64; {max(1, f.slots)}]"
        for k, part in enumerate(f.parts):
            lines += ["#[inline(never)]", f"fn kane_{f.name}_part{k}({', '.join([*given, work])}) {{", *part, "}", ""]
        body = [f"    let mut w = [0.0f64; {max(1, f.slots)}];"]
        body += [f"    kane_{f.name}_part{k}({', '.join([*passed, '&mut w'])});" for k in range(len(f.parts))]
    else:
        body = list(f.lines)
    return [*lines, f"pub fn {f.name}({', '.join(given)}) {{", *body, "}"]


def _helpers(used: set[str]) -> list[str]:
    """The mathematical functions in use, and the declarations of the C functions that they call."""
    lines, outside = [], dict[str, int]()
    if used & {"abs", "regular", "sincos"}:
        lines.append(_ABS)
    if "sincos" in used:
        steps = "\n".join(f"    let {n}: f64 = {STEP_FORMS[form].format(*map(_operand, o))};" for n, form, *o in STEPS)
        lines.append(_SINCOS.format(limit=LIMIT, steps=steps))
        outside |= {"sin": 1, "cos": 1}
    own = {name: 2 if name in ("pow", "atan2") else 1 for name in [*_CALLED.split(), "pow", "atan2"] if name in used}
    for name, arity in own.items():
        given, passed = ("x: f64", "x") if arity == 1 else ("x: f64, y: f64", "x, y")
        lines += [
            "",
            "#[inline(always)]",
            f"fn kane_{name}({given}) -> f64 {{",
            f"    unsafe {{ math::{name}({passed}) }}",
            "}",
        ]
    outside |= own
    if outside:
        declared = [
            f"        pub fn {n}({'x: f64' if k == 1 else 'x: f64, y: f64'}) -> f64;" for n, k in outside.items()
        ]
        lines += ["", "mod math {", '    extern "C" {', *declared, "    }", "}"]
    return lines
