# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a JavaScript module (ES2015): `import { rhs } from "./model.mjs"`."""

import json

from kane.program.emit.identifiers import decimal, free_in
from kane.program.emit.languages.straight import GONE_TEXT, Emitted, Language, file_of, forms, head, numbers_of
from kane.program.program import Program

_JAVASCRIPT = Language(
    forms(
        {
            "min": "({0} < {1} || {0} !== {0}) ? {0} : {1}",
            "max": "({0} > {1} || {0} !== {0}) ? {0} : {1}",
            "less": "({0} < {1}) ? 1.0 : 0.0",
            "sign": "({0} !== {0}) ? {0} : (({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : 0.0))",
            "where": "({0} !== 0.0) ? {1} : {2}",
            "regular": f"(Math.abs({{0}}) > {GONE_TEXT} * {{1}}) ? {{0}} : NaN",
            "atan2": "Math.atan2({0}, {1})",
            "pow": "kane_pow({0}, {1})",
        },
        "sqrt sin cos tan asin acos atan sinh cosh tanh exp log abs floor",
        "Math.{}({{0}})",
    ),
    lambda value: decimal(value, "NaN", "Infinity"),
    free_in("javascript"),
    "//",
    define="const {0} = {1};",
    store="{0} = {1};",
)
_POW = """
function kane_pow(x, p) { // as C has it: 1 to any power, and -1 to an infinite one, is 1
    return (x === 1 || (x === -1 && Math.abs(p) === Infinity)) ? 1.0 : Math.pow(x, p);
}
"""


def emit_javascript(program: Program, *, version: str = "") -> str:
    """The text of the module; a matrix is one array in row-major order."""
    file = file_of(program, _JAVASCRIPT, ("defaults", "names"))
    first, arguments = file.first.name, file.arguments
    call = [
        f'Call:     import {{ {first} }} from "./{file.prefix}.mjs"; {first}({arguments}) with arrays for the vectors gives an',
        "          array, of matrices row by row. `defaults` are the parameters, `names` what the ports hold.",
    ]
    names = {file.names.arguments[p.name]: [s.name for s in p.symbols] for p in program.ports}
    lines = [f"// {line}".rstrip() for line in head(file, version, call)]
    lines += ["", f"export const defaults = [{numbers_of(program, _JAVASCRIPT)}];"]
    lines += [f"export const names = {json.dumps(names)};"]
    for f in file.functions:
        lines += _function(f)
    return "\n".join([*lines, _POW if "pow" in file.used else ""])


def _function(f: Emitted) -> list[str]:
    lines = ["", f"export function {f.name}({f.given}) {{"]
    lines += [f"    const h = {f.hoisting};"] if f.hoisting else []
    lines += [f"    const {f.target} = new Array({len(f.function.results)});", *f.lines]
    return [*lines, f"    return {f.target};", "}"]
