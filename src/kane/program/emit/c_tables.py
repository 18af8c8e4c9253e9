# SPDX-License-Identifier: BSD-3-Clause
"""What a file of C shows to others, and its header: names, sizes, declarations, the tables of names, units and defaults."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from kane.program.emit.names import (
    Names,
    c_comment,
    c_string,
    decimal,
    distinct,
    identifier,
    is_free_in_c,
    local_names,
    made_by,
    stem,
)
from kane.program.emit.walk import RESULTS, VECTORS, Function, function_of, hoisting
from kane.program.program import Port, Program

_ROUNDING = {
    True: "Options such as -march=native -ffp-contract=fast give fused multiply-adds: faster, other last digits.",
    False: "Each operation is rounded by itself. Not with clang's -ffp-contract=fast, which no file can refuse.",
}


@dataclass(frozen=True, slots=True, eq=False)
class CFunction:
    """What a function of the file is called, takes (declarations by name) and gives: `size` results, named in `labels`."""

    function: Function
    name: str
    part: str  # what the functions of a long block are called, with a number
    arguments: Mapping[str, str]
    title: str
    size: str
    labels: str

    @property
    def signature(self) -> str:
        """Its declaration."""
        return f"void {self.name}({', '.join(self.arguments.values())})"


@dataclass(frozen=True, slots=True, eq=False)
class CFile:
    """Identifiers that the file shows to others; `tables` are those of the vectors among the ports, each with its length."""

    program: Program
    names: Names
    prefix: str
    record: str
    tables: tuple[tuple[Port, str, str], ...]
    functions: tuple[CFunction, ...]
    guard: str


def c_file(program: Program) -> CFile:
    """The names of a program's file, all different and free in C and C++: hoisted vectors come first."""
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
    written = [hoisting(program), *(function_of(program, r) for r in program.routines)]
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


def _arguments(function: Function, names: Names) -> dict[str, str]:
    """Declarations of the arguments by name."""
    ports = {names.arguments[port.name]: port.scalar for port in function.ports}
    declared = {name: f"double {name}" if scalar else f"const double *{name}" for name, scalar in ports.items()}
    target = VECTORS[function.target]
    return declared | {"h": "const double *h"} | {target: f"double *{target}"}


def _title(program: Program, function: Function) -> str:
    operations = sum(program.op(i).cost for i in function.block)
    if function.target != RESULTS:
        return f"What depends on parameters alone; {operations} operations."
    shape = program.routine(function.name).shape
    size = " x ".join(map(str, shape)) or "a number"
    return f"{function.name}: {size}{', row by row' * (len(shape) > 1)}; {operations} operations."


def c_number(value: float) -> str:
    """An operand that is exactly `value`."""
    return decimal(value, "NAN", "INFINITY")


# ------------------------------------------------------------------------------------------------------------- the text


def c_head(file: CFile, contract: bool, version: str) -> str:
    """The comment at the head: how to compile and call, what the ports are."""
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
    for port in program.ports:
        lines.append("")
        for k, s in enumerate(port.symbols):
            place = file.names.arguments[port.name] + f"[{k}]" * (not port.scalar)
            unit = f", {s.unit}" if s.unit else ""
            lines.append(c_comment(f"{place:7} {s.name}{unit}{': ' if s.description else ''}{s.description}"))
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */", ""])


def c_declarations(file: CFile) -> str:
    """Sizes, tables and functions as the header declares them."""
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
        f"typedef struct {{\n    const char *name, *unit, *description;\n    double value;\n}} {file.record};",
        *(f"extern const {file.record} {table}[{size} + 1];" for _, table, size in file.tables),
        *(f"extern const char *const {f.labels}[{f.size} + 1];" for f in file.functions if f.labels),
        "",
        *(f"/* {c_comment(line.strip())} */" for line in file.program.lost),
        *(f"{f.signature};" for f in file.functions),
        "",
        "#ifdef __cplusplus\n}\n#endif\n",
    ]
    return "\n".join(lines)


def c_tables(file: CFile) -> str:
    """The tables of the ports' symbols and of the results' labels."""
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
