# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one self-contained C++17 header: functions on pointers as in C, and wrappers for std::array or fixed-size Eigen."""

from collections.abc import Sequence

from kane.program.emit.c import LONGEST, NO_FAST_MATH, PART, CFile, CFunction, c_definition, c_file, port_lines
from kane.program.emit.identifiers import c_comment, c_number, distinct, identifier, is_free_in_c, made_by
from kane.program.emit.sincos import c_sincos
from kane.program.emit.walk import RESULTS, Style
from kane.program.program import Program

_ARRAY, _EIGEN = "std::array<double, {0}>", "Eigen::Matrix<double, {0}, 1>"


def emit_cpp(program: Program, *, version: str = "", eigen: bool = False) -> str:
    """The text of `<name>.hpp` for std::array, or for vectors and matrices of Eigen."""
    file = c_file(program)
    style, called = Style(lanes=1, whole=LONGEST, piece=LONGEST), set[str]()
    written = [c_definition(file, f, style, called) for f in file.functions]
    space = f"kane_{file.prefix}"
    names = distinct([identifier(f.function.name) or "routine" for f in file.functions], is_free_in_c)
    taken = (*names, *(f.name for f in file.functions))
    kept = len(file.functions[0].function.results)
    arguments, hoist, first = (
        ", ".join(file.names.arguments[p.name] for p in program.ports),
        file.functions[0],
        file.first,
    )
    shown, kind = names[file.functions.index(first)], "vectors of Eigen" if eigen else "std::array"
    head = [
        f"{program.name}: {program.subject}. {made_by(version)}",
        f"Call: {space}::{shown}({arguments}) with {kind}; faster in a loop,",
        f"      {space}::{hoist.name}({', '.join(hoist.arguments)}) once for each set of parameters, then",
        f"      {space}::{first.name}({', '.join(first.arguments)}) with pointers to doubles.",
        *(["", *(line.strip() for line in program.lost)] if program.lost else []),
        *port_lines(file),
    ]
    lines = [
        *(f"// {c_comment(line)}".rstrip() for line in head),
        f"#ifndef KANE_{file.guard}PP",
        f"#define KANE_{file.guard}PP",
        "",
        "#include <Eigen/Core>" if eigen else "#include <array>",
        "#include <math.h>",
        "#include <stdint.h>",
        "#include <string.h>",
        "",
        NO_FAST_MATH,
        f"#ifndef KANE_PART\n{PART}#endif" if any("KANE_PART" in text for text in written) else "",
        f"namespace {space} {{",
        "",
        c_sincos(called).replace("static ", "inline "),
        *(
            text.replace(f"void {f.name}(", f"inline void {f.name}(")
            for f, text in zip(file.functions, written, strict=True)
        ),
        *_defaults(program, distinct(["defaults"], is_free_in_c, taken)[0], eigen),
        *(_wrapper(file, f, n, kept, eigen) for f, n in zip(file.functions[1:], names[1:], strict=True)),
        "}",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _vector(size: int, eigen: bool) -> str:
    return (_EIGEN if eigen else _ARRAY).format(size)


def _defaults(program: Program, name: str, eigen: bool) -> Sequence[str]:
    """The function that returns the default parameters."""
    symbols = [s for port in program.hoisted_ports for s in port.symbols]
    values = [c_number(float("nan") if s.default is None else float(s.default)) for s in symbols]
    own = _vector(len(symbols), eigen)
    puts = [
        f"    p[{k}] = {value}; // {c_comment(s.name)}"
        for k, (s, value) in enumerate(zip(symbols, values, strict=True))
    ]
    return [f"inline {own} {name}()", "{", f"    {own} p{{}};", *puts, "    return p;", "}", ""]


def _wrapper(file: CFile, f: CFunction, name: str, kept: int, eigen: bool) -> str:
    """A function whose arguments and result are vectors of std::array or Eigen."""
    program, names = file.program, file.names.arguments
    hoist = file.functions[0]
    given, passed, hoisted = [], [], []
    for port in program.ports:
        own = names[port.name]
        given.append(f"double {own}" if port.scalar else f"const {_vector(len(port.symbols), eigen)} &{own}")
        passed.append(own if port.scalar else f"{own}.data()")
        hoisted += [passed[-1]] if port.hoisted else []
    shape, size = program.routine(f.function.name).shape, len(f.function.results)
    made = _vector(size, eigen)
    turn = eigen and len(shape) == 2
    if turn:
        order = "Eigen::RowMajor" if shape[1] != 1 else "Eigen::ColMajor"
        made = f"Eigen::Matrix<double, {shape[0]}, {shape[1]}, {order}>"
    lines = [
        f"inline {made} {name}({', '.join(given)})",
        "{",
        f"    double h[{kept}];" if kept else "    double h[1] = {0.0};",
        f"    {made} out;",
        f"    {hoist.name}({', '.join([*hoisted, 'h'])});",
        f"    {f.name}({', '.join([*passed, 'h', 'out.data()'])});",
        "    return out;",
        "}",
        "",
    ]
    assert f.function.target == RESULTS
    return "\n".join(lines)
