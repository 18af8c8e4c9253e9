# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one file of C99 and its header, to be built into other programs: it needs nothing but <math.h>.

Its functions are `<system>_hoist(p, h)` and `<system>_<routine>(t, x, p, r, h, out)`; its tables give the parameters, the
state, the inputs and what the results are. One operation a statement; z12 is the twelfth value of its routine.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from kane.expr.ops import COS, SIN, Op
from kane.expr.symbols import Symbol
from kane.program.emit.names import c_comment, c_string, distinct, identifier, input_names, is_free_in_c, stem
from kane.program.emit.sincos import C_SINCOS
from kane.program.passes.split import Chunk, split
from kane.program.program import Program

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
_ROUNDING = {
    True: "Options such as -march=native -ffp-contract=fast give fused multiply-adds: faster, other last digits.",
    False: "Each operation is rounded by itself. Not with clang's -ffp-contract=fast, which no file can refuse.",
}
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
    """The text of a file of C99, complete in itself.

    Parameters
    ----------
    program
        What to compute.
    contract
        False: every operation is rounded by itself; the results of + − × ÷ √ are those of NumPy bit by bit. True: the
        compiler may round a·b + c once, where its options say so.
    version
        Kane's version, for the comment at the head.
    longest
        The most instructions in one function; a longer routine becomes several.
    """
    names = _names(program)
    inputs = input_names(program, lambda name: is_free_in_c(name) and not name.startswith(f"{names.prefix}_"))
    code = "\n".join(_definition(program, f, _sources(program, inputs, f), longest) for f in names.functions)
    helpers = _angles(code)
    parts = [
        _head(program, names, contract, version),
        _NO_FAST_MATH
        + ("" if contract else _NO_CONTRACTION)
        + "#include <math.h>\n"
        + (_FOR_SINCOS if helpers else ""),
        _declarations(program, names),
        _tables(program, names),
        _PART if "\nKANE_PART " in f"\n{code}" else "",
        helpers,
        code,
    ]
    return "\n".join(part for part in parts if part)


def emit_header(program: Program, *, version: str = "") -> str:
    """The text of the header that belongs to the file of `emit_c`, for C and C++."""
    names = _names(program)
    title = f"/* {c_comment(program.name)}: declarations. {_made_by(version)} */"
    return f"{title}\n#ifndef {names.guard}\n#define {names.guard}\n\n{_declarations(program, names)}\n#endif\n"


@dataclass(frozen=True, slots=True)
class _Function:
    """What a function of the file is called, takes and gives: target[k] is the value `places[k]`."""

    name: str
    part: str  # what the functions of a long block are called, with a number
    arguments: Mapping[str, str]  # declaration by name
    target: str
    block: tuple[int, ...]
    places: tuple[int, ...]
    labels: tuple[str, ...]
    title: str

    @property
    def signature(self) -> str:
        return f"void {self.name}({', '.join(self.arguments.values())})"


_HOIST = {"p": "const double *p", "h": "double *h"}
_KERNEL = {"t": "double t", **{k: f"const double *{k}" for k in "xprh"}, "out": "double *out"}


@dataclass(frozen=True, slots=True)
class _Names:
    """Identifiers that the file shows to others, tables and sizes in the order p, x, r (h, routines)."""

    prefix: str
    record: str
    tables: tuple[str, ...]
    functions: tuple[_Function, ...]
    labels: tuple[str, ...]
    sizes: tuple[str, ...]
    guard: str


def _names(program: Program) -> _Names:
    prefix = identifier(program.name) or "system"
    routines = [identifier(r.name) or "routine" for r in program.routines]
    tails = ["quantity", "parameters", "state", "inputs", "hoist", *routines, *(f"{r}_labels" for r in routines)]
    record, *lower = distinct([f"{prefix}_{tail}" for tail in tails], is_free_in_c)
    tails = ["H", "PARAMETERS", "STATES", "INPUTS", "HOISTED", *(f"{r.upper()}_SIZE" for r in routines)]
    guard, *sizes = distinct([f"{prefix.upper()}_{tail}" for tail in tails], is_free_in_c, [record, *lower])
    labels = lower[4 + len(routines) :]

    title = f"What depends on parameters alone; {_cost(program, program.hoisted)} operations."
    parts = [stem(f"{name}_part", lower) for name in lower]
    functions = [_Function(lower[3], parts[3], _HOIST, "h", program.hoisted, program.kept, (), title)]
    for routine, name, part in zip(program.routines, lower[4:], parts[4:], strict=False):
        shape = " x ".join(map(str, routine.shape)) or "a number"
        title = f"{routine.name}: {shape}{', row by row' * (len(routine.shape) > 1)}; {_cost(program, routine.body)} operations."
        functions.append(_Function(name, part, _KERNEL, "out", routine.body, routine.results, routine.labels, title))
    return _Names(prefix, record, tuple(lower[:3]), tuple(functions), tuple(labels), tuple(sizes), guard)


def _cost(program: Program, block: Iterable[int]) -> int:
    return sum(program.op(i).cost for i in block)


def _symbols(program: Program, port: str) -> tuple[Symbol, ...]:
    return next((p.symbols for p in program.ports if p.name == port), ())


# --------------------------------------------------------------------------------------- the comment and the tables


def _made_by(version: str) -> str:
    return f"Made by kane{' ' + c_comment(version) if version else ''}: derive and emit again instead of editing."


def _head(program: Program, names: _Names, contract: bool, version: str) -> str:
    hoist, *routines = names.functions
    lines = [
        f"{c_comment(program.name)}: equations of motion. {_made_by(version)}",
        "",
        f"Compile:  cc -std=c99 -O2 -fno-math-errno -c {names.prefix}.c   and link with -lm",
        f"          {_ROUNDING[contract]}",
        f"Call:     {hoist.name}(p, h) once for each set of parameters, with double h[{names.sizes[3]}]; then",
        *(f"          {f.name}(t, x, p, r, h, out) with double out[{n}]" for f, n in zip(routines, names.sizes[4:], strict=True)),
        "          for time t, state x, parameters p, inputs r. A pointer to no elements may be null; out overlaps none of",
        "          the others. Nothing is kept between calls: threads may call at the same time.",
    ]  # fmt: skip
    for port in program.ports:
        lines.append("")
        for k, s in enumerate(port.symbols):
            place = "t" if port.name == "t" else f"{port.name}[{k}]"
            unit = f", {s.unit}" if s.unit else ""
            lines.append(c_comment(f"{place:7} {s.name}{unit}{': ' if s.description else ''}{s.description}"))
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */", ""])


def _declarations(program: Program, names: _Names) -> str:
    counts = [len(_symbols(program, port)) for port in "pxr"] + [len(f.places) for f in names.functions]
    sizes = ",\n".join(f"    {name} = {count}" for name, count in zip(names.sizes, counts, strict=True))
    lines = [
        "#ifdef __cplusplus",
        'extern "C" {',
        "#endif",
        "",
        f"enum {{\n{sizes}\n}};",
        "",
        "/* `value` is the default of a parameter, NAN where there is none. A null pointer follows the last name. */",
        f"typedef struct {{\n    const char *name, *unit, *description;\n    double value;\n}} {names.record};",
        *(f"extern const {names.record} {t}[{n} + 1];" for t, n in zip(names.tables, names.sizes, strict=False)),
        *(f"extern const char *const {t}[{n} + 1];" for t, n in zip(names.labels, names.sizes[4:], strict=True)),
        "",
        *(f"{f.signature};" for f in names.functions),
        "",
        "#ifdef __cplusplus\n}\n#endif\n",
    ]
    return "\n".join(lines)


def _tables(program: Program, names: _Names) -> str:
    lines = []
    for table, size, port in zip(names.tables, names.sizes, "pxr", strict=False):
        lines.append(f"const {names.record} {table}[{size} + 1] = {{")
        for s in _symbols(program, port):
            texts = ", ".join(map(c_string, (s.name, s.unit, s.description)))
            lines.append(f"    {{{texts}, {_number(math.nan if s.default is None else float(s.default))}}},")
        lines += ["    {0, 0, 0, NAN}", "};"]
    for table, size, f in zip(names.labels, names.sizes[4:], names.functions[1:], strict=True):
        rows = [f"    {c_string(label)}," for label in f.labels]
        lines += [f"const char *const {table}[{size} + 1] = {{", *rows, "    0", "};"]
    return "\n".join([*lines, ""])


def _angles(code: str) -> str:
    """What `code` calls of kane_sincos, kane_sin and kane_cos. A sine alone is faster so than the library's."""
    called = set(re.findall(r"^    (?:const double \w+ = )?kane_(sin|cos|sincos)\(", code, re.MULTILINE))
    lone = [_LONE.format(name=name, value=name[0]) for name in ("sin", "cos") if name in called]
    return "\n".join([C_SINCOS, *lone]) if called else ""


# ------------------------------------------------------------------------------------------------------- functions


@dataclass(frozen=True, slots=True)
class _Source:
    """How a function gets a value that it does not compute: argument, expression, local name (the same if none)."""

    argument: str
    text: str
    name: str


def _number(value: float) -> str:
    """An operand that is exactly `value`: the shortest decimal number that reads back as it."""
    if math.isfinite(value):
        return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"
    return "NAN" if math.isnan(value) else "INFINITY" if value > 0 else "(-INFINITY)"


def _sources(program: Program, inputs: Sequence[str], function: _Function) -> dict[int, _Source]:
    """The values that a function reads from its arguments or writes as numbers."""
    found: list[_Source] = []
    for port in program.ports:
        for k in range(len(port.symbols)):
            name = inputs[len(found)]
            found.append(_Source(port.name, "t" if port.name == "t" else f"{port.name}[{k}]", name))
    found += [_Source("", number, number) for number in map(_number, program.constants)]
    sources = dict(enumerate(found))
    if "out" in function.arguments:
        h = stem("h", inputs)
        sources.update({i: _Source("h", f"h[{k}]", f"{h}{k}") for k, i in enumerate(program.kept)})
    return sources


def _definition(program: Program, function: _Function, sources: Mapping[int, _Source], limit: int) -> str:
    """One function, or for a long block several and one that calls them in turn."""
    parts = split(program, function.block, limit, limit)
    z = stem("z", [s.name for s in sources.values()])
    names = {i: s.name for i, s in sources.items()} | {i: f"{z}{k}" for k, i in enumerate(function.block, 1)}
    last = len(parts.chunks) - 1
    made = {i: k for k, chunk in enumerate(parts.chunks) for i in chunk.instructions}
    places: list[list[int]] = [[] for _ in parts.chunks]
    for place, i in enumerate(function.places):
        places[made.get(i, last)].append(place)
    arguments = {**function.arguments, "w": "double *w"} if last else function.arguments
    bodies = []
    for chunk, written in zip(parts.chunks, places, strict=True):
        used, lines = _statements(program, function, chunk, written, sources, names)
        bodies.append([*(f"    (void){a};" for a in arguments if a not in used), *lines])
    head = f"({', '.join(function.arguments.values())})"
    lines = []
    if last:
        for k, body in enumerate(bodies):
            lines += [f"KANE_PART void {function.part}{k}({', '.join(arguments.values())})", "{", *body, "}", ""]
        calls = [f"    {function.part}{k}({', '.join(arguments)});" for k in range(len(bodies))]
        bodies = [[f"    double w[{max(1, parts.slots)}];", *calls]]
    lines += [f"/* {c_comment(function.title)} */", f"void {function.name}{head}", "{", *bodies[0], "}", ""]
    return "\n".join(lines)


def _statements(
    program: Program,
    function: _Function,
    chunk: Chunk,
    places: Iterable[int],
    sources: Mapping[int, _Source],
    names: Mapping[int, str],
) -> tuple[set[str], list[str]]:
    """The arguments that are used, and what stands between the braces."""
    results = [(k, function.places[k]) for k in places]
    read = {a for i in chunk.instructions for a in program.arguments(i)}.union(i for _, i in results)
    given = [sources[i] for i in sorted(read) if i in sources]
    used = {s.argument for s in given} | ({function.target} if results else set())
    if chunk.loads or chunk.stores:
        used.add("w")
    lines = [f"    const double {s.name} = {s.text};" for s in given if s.text != s.name]
    lines += [f"    const double {names[i]} = w[{slot}];" for i, slot in chunk.loads.items()]
    partner = _partners(program, chunk)
    done: set[int] = set()
    for i in chunk.instructions:
        op, operands = program.op(i), [names[a] for a in program.arguments(i)]
        if i in done:
            continue
        if i in partner:
            sine, cosine = (i, partner[i]) if op is SIN else (partner[i], i)
            lines.append(f"    double {names[sine]}, {names[cosine]};")
            lines.append(f"    kane_sincos({operands[0]}, &{names[sine]}, &{names[cosine]});")
            done.add(partner[i])
        else:
            text = f"kane_{op.name}({operands[0]})" if op in (SIN, COS) else op.c.format(*operands)
            lines.append(f"    const double {names[i]} = {text};")
    lines += [f"    w[{slot}] = {names[i]};" for i, slot in chunk.stores.items()]
    for k, i in results:
        label = function.labels[k] if function.labels else ""
        lines.append(f"    {function.target}[{k}] = {names[i]};" + (f" /* {c_comment(label)} */" if label else ""))
    return used, lines


def _partners(program: Program, chunk: Chunk) -> dict[int, int]:
    """The cosine to each sine of one angle and the sine to each cosine, where both are computed."""
    found: dict[tuple[Op, int], int] = {}
    for i in chunk.instructions:
        if program.op(i) in (SIN, COS):
            found[program.op(i), program.arguments(i)[0]] = i
    other = {SIN: COS, COS: SIN}
    return {i: found[other[op], angle] for (op, angle), i in found.items() if (other[op], angle) in found}
