# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one source file of C99 and its header, for use in other programs; <math.h> is the only dependency.

Its functions are `<system>_hoist(parameters, h)` and `<system>_<routine>(ports, h, out)`; its tables list the symbols of the ports and
the labels of the results. Each statement is one operation; z12 is the twelfth value of its routine. In kernels, a vector value is an
array, and an operation on it is a loop over the lanes.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kane.expr import ops
from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.emit import walk
from kane.program.emit.identifiers import (
    ARITHMETIC,
    Names,
    c_comment,
    c_number,
    c_string,
    decimal,
    distinct,
    identifier,
    is_free_in_c,
    local_names,
    made_by,
    stem,
)
from kane.program.emit.sincos import c_sincos
from kane.program.kernel import language
from kane.program.kernel.language import Read, Statement, Write
from kane.program.program import Port, Program

KINDS = {"float": "double", "int": "int64_t", "bool": "bool"}
"""C types by the kinds of values."""
_FORMS: Mapping[Op | str, str] = {
    **walk.shared(ARITHMETIC),
    **walk.shared({n: f"{f}({{0}})" for n, f in (("sqrt", "sqrt"), ("abs", "fabs"))}),
    **walk.shared(
        {n: f"(({{0}} {s} {{1}}) || ({{0}} != {{0}})) ? {{0}} : {{1}}" for n, s in (("min", "<"), ("max", ">"))}
    ),
    "less": "{0} < {1}",
    "at_most": "{0} <= {1}",
    "and": "{0} && {1}",
    "or": "{0} || {1}",
    "not": "!{0}",
    "select": "{0} ? {1} : {2}",
    "float": "(double){0}",
    "int": "(int64_t){0}",
    **{OPS[n]: f"{n}({{0}})" for n in ("tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "floor")},
    **{OPS[n]: f"{n}({{0}}, {{1}})" for n in ("pow", "atan2")},
    OPS["less"]: "({0} < {1}) ? 1.0 : 0.0",
    OPS["sign"]: "({0} != {0}) ? {0} : (({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : 0.0))",
    ops.WHERE: "({0} != 0.0) ? {1} : {2}",
    ops.REGULAR: f"(fabs({{0}}) > ({ops.GONE!r} * {{1}})) ? {{0}} : (double)NAN",
}
"""C expressions of operations on {0}, {1}, …, per lane; an operation not listed copies {0}. Sines and cosines: see `sincos`."""
_FOLDS = {"sum": "add", "largest": "max"}


def extent(type_: language.Type) -> str:
    """The array bound that follows a variable's name in its declaration; "" for a scalar."""
    return f"[{type_.width}]" if type_.width > 1 else ""


def each(type_: language.Type, statement: str) -> str:
    """A loop over the lanes k around a statement; the statement itself for a scalar."""
    return f"for (int k = 0; k < {type_.width}; k++) {{ {statement} }}" if type_.width > 1 else statement


class CPrinter(walk.NamedPrinter):
    """Prints the statements of one function; `helpers` are the sine and cosine functions that it calls."""

    def __init__(self, names: Mapping[int, str] | None = None, vectors: Mapping[str, str] | None = None) -> None:
        super().__init__(1, names, vectors)
        self.folds = 0
        self.helpers: set[str] = set()

    def text(self, operand: language.Operand, lane: str = "k") -> str:
        """The text of an operand: a scalar, or the given lane of a vector."""
        if isinstance(operand, int):
            return self.names[operand]
        if not isinstance(operand, language.Immediate):
            return f"v{operand}{f'[{lane}]' * (operand.type.width > 1)}"
        if isinstance(operand.value, tuple):
            numbers = ", ".join(decimal(v, "NAN", "INFINITY") for v in operand.value)
            return f"((const double[]){{{numbers}}})[{lane}]"
        if operand.type.kind == "int":
            return f"INT64_C({operand.value})" if operand.value >= 0 else f"(-INT64_C({-operand.value}))"
        return decimal(float(operand.value), "(double)NAN", "(double)INFINITY")

    def define(self, value: language.Operand, text: str) -> None:
        """Adds the assignment of `text`, an expression for lane k, to a value."""
        type_, name = language.type_of(value), self.text(value)
        if type_.width == 1:
            self.add(f"const {KINDS[type_.kind]} {name} = {text};")
        else:
            self.add(f"{KINDS[type_.kind]} v{value}{extent(type_)};", each(type_, f"{name} = {text};"))

    def at(self, s: language.Address | language.Read | language.Write, type_: language.Type) -> str:
        """An element of an array, or the element of lane k of several consecutive ones."""
        index = str(s.offset) if isinstance(s.offset, int) else self.text(s.offset)
        return f"{self.vectors.get(s.base, s.base)}[{index}{' + k' * (type_.width > 1)}]"

    def compute(self, s: language.Compute) -> None:
        """Adds an operation, in each lane."""
        op, first = s.op, s.arguments[0]
        if op in _FOLDS:
            self.define(s.value, self.fold(_FORMS[_FOLDS[str(op)]], first))
        elif op == "any":
            self.define(s.value, " || ".join(self.text(first, str(k)) for k in range(language.type_of(first).width)))
        else:
            lane = str(s.lane) if op == "lane" else "k"
            self.define(s.value, _FORMS.get(op, "{0}").format(*(self.text(a, lane) for a in s.arguments)))

    def fold(self, form: str, operand: language.Operand) -> str:
        """Adds a reduction over lanes by repeated halving, in temporaries."""
        names: Sequence[str] = [self.text(operand, str(k)) for k in range(language.type_of(operand).width)]
        self.folds += 1
        while len(names) > 1:
            half = len(names) // 2
            pairs = list(zip(names[:half], names[half:], strict=True))
            names = [f"f{self.folds}_{half}_{k}" for k in range(half)]
            self.add(*(f"const double {n} = {form.format(*pair)};" for n, pair in zip(names, pairs, strict=True)))
        return names[0]

    def sincos(self, s: language.SinCos) -> None:
        """Adds the sine, the cosine or both of one angle."""
        ((angle,), (own,)) = s.angles, s.values
        names = {op.name: self.names[i] for op, i in own.items()}
        if len(names) == 1:
            ((function, name),) = names.items()
            self.add(f"const double {name} = kane_{function}({self.names[angle]});")
        else:
            function, (sine, cosine) = "sincos", (names[op.name] for op in (SIN, COS))
            self.add(f"double {sine};", f"double {cosine};", f"kane_sincos({self.names[angle]}, &{sine}, &{cosine});")
        self.helpers.add(function)

    def load(self, s: language.Read) -> None:
        """Adds a load from an array."""
        self.define(s.value, self.at(s, language.type_of(s.value)))

    def store(self, s: language.Write) -> None:
        """Adds a store to an array."""
        type_, comment = language.type_of(s.value), f" /* {c_comment(s.label)} */" if s.label else ""
        self.add(f"{each(type_, f'{self.at(s, type_)} = {self.text(s.value)};')}{comment}")


NO_FAST_MATH = """\
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
PART = """\
#if defined(__GNUC__)
#define KANE_PART static __attribute__((noinline)) /* in one piece it would take long to compile */
#elif defined(_MSC_VER)
#define KANE_PART static __declspec(noinline)
#else
#define KANE_PART static
#endif
"""
_ROUNDING = {
    True: "Options such as -march=native -ffp-contract=fast give fused multiply-adds: faster, other last digits.",
    False: "Each operation is rounded by itself. Not with clang's -ffp-contract=fast, which no file can refuse.",
}

LONGEST = 2000
"""Maximum number of instructions in one function: compile time grows faster than the length beyond it."""


def emit_c(
    program: Program,
    *,
    contract: bool = True,
    version: str = "",
    longest: int = LONGEST,
    headers: str = "",
    besides: Sequence[Program] = (),
) -> str:
    """The text of a complete C99 file; a routine of more than `longest` instructions is split into several functions.

    Without `contract` every operation is rounded separately, and the results of + − × ÷ √ equal those of NumPy bit for bit. With it
    the compiler may round a·b + c once, if its options permit. `headers` are lines that include more headers. The functions of the
    Programs `besides` are static, and their ports have no tables.
    """
    file = c_file(program)
    style = walk.Style(lanes=1, whole=longest, piece=longest)
    called: set[str] = set()
    functions = [c_definition(file, f, style, called) for f in file.functions]
    for other in map(c_file, besides):
        functions += [c_definition(other, replace(f, linkage="static "), style, called) for f in other.functions]
    headers = "#include <math.h>\n" + (_FOR_SINCOS if called else "") + headers
    parts = [
        _head(file, contract, version),
        NO_FAST_MATH + ("" if contract else _NO_CONTRACTION) + headers,
        _declarations(file),
        _tables(file),
        PART if any("KANE_PART" in text for text in functions) else "",
        c_sincos(called),
        "\n".join(functions),
    ]
    return "\n".join(part for part in parts if part)


def emit_header(program: Program, *, version: str = "") -> str:
    """The text of the header, for C and C++, that declares the functions and tables of the file of `emit_c`."""
    file = c_file(program)
    title = f"/* {c_comment(f'{program.name}: declarations. {made_by(version)}')} */"
    return f"{title}\n#ifndef {file.guard}\n#define {file.guard}\n\n{_declarations(file)}\n#endif\n"


# ------------------------------------------------------------------------------------------------------- functions


@dataclass(frozen=True, slots=True, eq=False)
class CFunction:
    """A C function: its name, arguments (declarations by name) and result, `size` doubles with the names `labels`."""

    function: walk.Function
    name: str
    part: str  # the name prefix of the functions into which a long block is split
    arguments: Mapping[str, str]
    title: str
    size: str
    labels: str
    linkage: str = ""

    @property
    def signature(self) -> str:
        """The function's declaration."""
        return f"{self.linkage}void {self.name}({', '.join(self.arguments.values())})"


@dataclass(frozen=True, slots=True, eq=False)
class CFile:
    """The public identifiers of the file; `tables` are the tables of the vector ports, each with its length."""

    program: Program
    names: Names
    prefix: str
    record: str
    tables: tuple[tuple[Port, str, str], ...]
    functions: tuple[CFunction, ...]
    guard: str

    @property
    def first(self) -> CFunction:
        """The first routine, the example in the comment at the head of the file."""
        return self.functions[min(1, len(self.program.routines))]


def c_file(program: Program) -> CFile:
    """The names of a program's C file, distinct and not reserved in C or C++; vectors of parameters come first."""
    prefix = identifier(program.name) or "system"
    vectors = sorted((port for port in program.ports if not port.scalar), key=lambda port: not port.hoisted)
    routines = [identifier(r.name) or "routine" for r in program.routines]
    functions = ["hoist", *routines]
    tails = ["quantity", *(identifier(p.noun) for p in vectors), *functions, *(f"{r}_labels" for r in routines)]
    record, *lower = distinct([f"{prefix}_{tail}" for tail in tails], is_free_in_c)
    tails = ["H", *(identifier(p.nouns).upper() for p in vectors), "HOISTED", *(f"{r.upper()}_SIZE" for r in routines)]
    guard, *sizes = distinct([f"{prefix.upper()}_{tail}" for tail in tails], is_free_in_c, [record, *lower])

    names = local_names(program, lambda name: is_free_in_c(name) and not name.startswith(f"{prefix}_"))
    first = len(vectors)
    labels = ["", *lower[first + len(functions) :]]
    written = [walk.hoisting(program), *(walk.function_of(program, r) for r in program.routines)]
    titles = [_title(program, function) for function in written]
    own = zip(written, lower[first:], titles, sizes[first:], labels, strict=False)
    return CFile(
        program,
        names,
        prefix,
        record,
        tuple(zip(vectors, lower, sizes, strict=False)),
        tuple(CFunction(f, n, stem(f"{n}_part", lower), _arguments(f, names), t, s, k) for f, n, t, s, k in own),
        guard,
    )


def c_definition(file: CFile, f: CFunction, style: walk.Style, called: set[str]) -> str:
    """The definition of a function; a long block is split into several. Sine and cosine functions in use are added to `called`."""
    parts = walk.pieces(file.program, f.function, style)
    cut = len(parts.chunks) > 1
    names = file.names.of(f.function, c_number)
    arguments = {**f.arguments, "w": "double *w"} if cut else f.arguments
    bodies = []
    for piece in parts.chunks:
        body = walk.statements(file.program, f.function, piece, style)
        used, printer = _used(file, body), CPrinter(names, file.names.arguments)
        printer.add(*(f"(void){a};" for a in arguments if a not in used))
        printer.block(body)
        called |= printer.helpers
        bodies.append(printer.lines)
    lines = []
    if cut:
        for k, own in enumerate(bodies):
            lines += [f"KANE_PART void {f.part}{k}({', '.join(arguments.values())})", "{", *own, "}", ""]
        calls = [f"    {f.part}{k}({', '.join(arguments)});" for k in range(len(bodies))]
        bodies = [[f"    double w[{max(1, parts.slots)}];", *calls]]
    return "\n".join([*lines, f"/* {c_comment(f.title)} */", f.signature, "{", *bodies[0], "}", ""])


def _used(file: CFile, body: Sequence[Statement]) -> set[str]:
    """The arguments that a piece reads or writes."""
    bases = {s.base for s in body if isinstance(s, Read | Write)}
    ports = [port for port in file.program.ports for _ in port.symbols]
    scalars = {i: port.name for i, port in enumerate(ports) if port.scalar}
    bases.update(scalars[i] for s in body for i in walk.values_read(s) if i in scalars)
    return {file.names.arguments[base] for base in bases}


def _arguments(function: walk.Function, names: Names) -> dict[str, str]:
    """The declarations of the arguments, by name."""
    ports = {names.arguments[port.name]: port.scalar for port in function.ports}
    declared = {name: f"double {name}" if scalar else f"const double *{name}" for name, scalar in ports.items()}
    target = walk.VECTORS[function.target]
    return declared | {"h": "const double *h"} | {target: f"double *{target}"}


def _title(program: Program, function: walk.Function) -> str:
    operations = sum(program.op(i).cost for i in function.block)
    if function.target != walk.RESULTS:
        return f"What depends on parameters alone; {operations} operations."
    shape = program.routine(function.name).shape
    size = " x ".join(map(str, shape)) or "a number"
    return f"{function.name}: {size}{', row by row' * (len(shape) > 1)}; {operations} operations."


# ------------------------------------------------------------------------------------------------------------ tables


def _head(file: CFile, contract: bool, version: str) -> str:
    """The comment at the head of the file: how to compile it and call its functions, and the contents of the ports."""
    program, (hoist, *routines) = file.program, file.functions
    nouns = ", ".join(f"{p.noun} {file.names.arguments[p.name]}" for p in program.ports)
    lines = [
        c_comment(f"{program.name}: {program.subject}. {made_by(version)}"),
        "",
        f"Compile:  cc -std=c99 -O2 -fno-math-errno -c {file.prefix}.c   and link with -lm",
        f"          {_ROUNDING[contract]}",
        f"Call:     {hoist.name}({', '.join(hoist.arguments)}) once for each set of parameters, with double h[{hoist.size}]; then",
        *(f"          {f.name}({', '.join(f.arguments)}) with double out[{f.size}]" for f in routines),
        f"          for {nouns}. A pointer to no elements may be null; out overlaps none of",
        "          the others. Nothing is kept between calls: threads may call at the same time.",
    ]
    if program.lost:
        lines += ["", *map(c_comment, program.lost)]
    lines += port_lines(file)
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */", ""])


def port_lines(file: CFile) -> list[str]:
    """Lines that list the contents of the ports, with an empty line before each port."""
    lines = []
    for port in file.program.ports:
        lines.append("")
        for k, s in enumerate(port.symbols):
            place = file.names.arguments[port.name] + f"[{k}]" * (not port.scalar)
            unit = f", {s.unit}" if s.unit else ""
            lines.append(c_comment(f"{place:7} {s.name}{unit}{': ' if s.description else ''}{s.description}"))
    return lines


def _declarations(file: CFile) -> str:
    """Sizes, tables and functions, as the header declares them."""
    counts = {size: len(port.symbols) for port, _, size in file.tables}
    counts |= {f.size: len(f.function.results) for f in file.functions}
    sizes = ",\n".join(f"    {name} = {count}" for name, count in counts.items())
    lines = [
        "#ifdef __cplusplus",
        'extern "C" {',
        "#endif",
        "",
        f"enum {{\n{sizes}\n}};",
        "",
        "/* `value` is the default of a parameter, NAN where there is none. A null pointer follows the last name. */",
        "typedef struct {",
        *(f"    const char *{name};" for name in ("name", "unit", "description")),
        "    double value;",
        f"}} {file.record};",
        *(f"extern const {file.record} {table}[{size} + 1];" for _, table, size in file.tables),
        *(f"extern const char *const {f.labels}[{f.size} + 1];" for f in file.functions if f.labels),
        "",
        *(f"/* {c_comment(line.strip())} */" for line in file.program.lost),
        *(f"{f.signature};" for f in file.functions),
        "",
        "#ifdef __cplusplus\n}\n#endif\n",
    ]
    return "\n".join(lines)


def _tables(file: CFile) -> str:
    """The tables of the ports' symbols and the results' labels."""
    lines = []
    for port, table, size in file.tables:
        lines.append(f"const {file.record} {table}[{size} + 1] = {{")
        for s in port.symbols:
            texts = ", ".join(map(c_string, (s.name, s.unit, s.description)))
            lines.append(f"    {{{texts}, {c_number(math.nan if s.default is None else float(s.default))}}},")
        lines += ["    {0, 0, 0, NAN}", "};"]
    for f in file.functions:
        if f.labels:
            rows = [f"    {c_string(label)}," for label in f.function.labels]
            lines += [f"const char *const {f.labels}[{f.size} + 1] = {{", *rows, "    0", "};"]
    return "\n".join([*lines, ""])
