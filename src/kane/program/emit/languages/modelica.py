# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a Modelica package: pure functions, and, if there is a right-hand side, a block `Motion` that integrates it.

Modelica has no NaN: an assertion or an error of the tool takes its place.
"""

from kane.program.emit.identifiers import c_comment, decimal, free_in
from kane.program.emit.languages import straight
from kane.program.program import Program

_MODELICA = straight.Language(
    straight.forms(
        {
            "atan2": "atan2({0}, {1})",
            "pow": "{0} ^ {1}",
            "min": "if {0} < {1} then {0} else {1}",
            "max": "if {0} > {1} then {0} else {1}",
            "less": "if {0} < {1} then 1.0 else 0.0",
            "sign": "if {0} > 0.0 then 1.0 elseif {0} < 0.0 then -1.0 else 0.0",
            "where": "if {0} <> 0.0 then {1} else {2}",
            "regular": f"kane_regular({{0}}, {straight.GONE_TEXT} * {{1}})",
        },
        "sqrt sin cos tan asin acos atan sinh cosh tanh exp log abs floor",
    ),
    lambda value: decimal(value, "(0.0 / 0.0)", "(1.0 / 0.0)"),
    free_in("modelica"),
    "//",
    define="{0} := {1};",
    store="{0} := {1};",
    first=1,
)
_REGULAR = """
  function kane_regular "A divisor, refused where it is zero but for rounding"
    input Real x;
    input Real least;
    output Real y;
  algorithm
    assert(abs(x) > least, "A divisor is zero beside the terms that it is made of.");
    y := x;
  end kane_regular;
"""


def emit_modelica(program: Program, *, version: str = "") -> str:
    """The text of `<name>.mo`; results are vectors, matrices in row-major order."""
    file = straight.file_of(program, _MODELICA, ("kane_regular",))
    call = [
        f"Call:     {file.prefix}.{file.first.name}({file.arguments}), of matrices row by row;",
        f"          {file.prefix}.Motion is a block with the state x, the parameters p and the inputs r.",
    ]
    lines = [f"// {line}".rstrip() for line in straight.head(file, version, call, 1)]
    lines += [f'package {file.prefix} "{_text(program)}"', *([_REGULAR] if "regular" in file.used else [])]
    for f in file.functions:
        lines += _function(file, f)
    motion = next((f.name for f in file.functions[1:] if f.function.name == "rhs"), None)
    lines += _motion(file, motion) if motion else []
    return "\n".join([*lines, f"end {file.prefix};", ""])


def _text(program: Program) -> str:
    return c_comment(f"{program.name}: {program.subject}").replace('"', "'")


def _function(file: straight.File, f: straight.Emitted) -> list[str]:
    lines = ["", f"  function {f.name}"]
    for port in f.function.ports:
        size = "" if port.scalar else f"[{len(port.symbols)}]"
        lines.append(f"    input Real {file.names.arguments[port.name]}{size};")
    lines.append(f"    output Real {f.target}[{len(f.function.results)}];")
    local = [line.split(" := ")[0].strip() for line in f.lines if not line.strip().startswith(f"{f.target}[")]
    if f.hoisting:
        local.insert(0, f"h[{len(file.program.kept)}] = {f.hoisting}")
    if local:
        lines += ["  protected", *(f"    Real {name};" for name in local)]
    return [*lines, "  algorithm", *f.lines, f"  end {f.name};"]


def _motion(file: straight.File, rhs: str) -> list[str]:
    program = file.program
    names = {port.name: file.names.arguments[port.name] for port in program.ports}
    length = {port.name: len(port.symbols) for port in program.ports}
    given = all(s.default is not None for port in program.hoisted_ports for s in port.symbols)
    values = f" = {{{straight.numbers_of(program, _MODELICA)}}}" if given and length["p"] else ""
    passed = ", ".join("time" if p.scalar else names[p.name] for p in program.ports)
    lines = [
        "",
        '  block Motion "The state by its right-hand side"',
        f"    parameter Real {names['p']}[{length['p']}]{values};",
    ]
    lines += (
        [f"    input Real {names['r']}[{length['r']}];"]
        if length["r"]
        else [f"    constant Real {names['r']}[0] = fill(0.0, 0);"]
    )
    lines += [f"    Real {names['x']}[{length['x']}](each fixed = true);", "  equation"]
    return [*lines, f"    der({names['x']}) = {rhs}({passed});", "  end Motion;"]
