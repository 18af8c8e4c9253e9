# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one MATLAB function file, which Octave runs too: `m = model()` returns a struct of function handles."""

from kane.program.emit.identifiers import decimal, free_in
from kane.program.emit.languages.straight import GONE_TEXT, Emitted, Language, file_of, forms, head, numbers_of
from kane.program.program import Program

_REAL = "sqrt log asin acos sign"
_MATLAB = Language(
    forms(
        {
            **{name: f"kane_{name}({{0}})" for name in _REAL.split()},
            **{name: f"kane_{name}({{0}}, {{1}})" for name in ("pow", "min", "max", "regular")},
            "where": "kane_where({0}, {1}, {2})",
            "atan2": "atan2({0}, {1})",
            "less": "double({0} < {1})",
        },
        "sin cos tan atan sinh cosh tanh exp abs floor",
    ),
    lambda value: decimal(value, "NaN", "Inf"),
    free_in("matlab"),
    "%",
    define="{0} = {1};",
    store="{0} = {1};",
    at="{0}({1})",
    first=1,
)
_HELPERS = {
    "sqrt": ("x", "if x < 0, y = NaN; else, y = sqrt(x); end"),
    "log": ("x", "if x < 0, y = NaN; else, y = log(x); end"),
    "asin": ("x", "if abs(x) > 1, y = NaN; else, y = asin(x); end"),
    "acos": ("x", "if abs(x) > 1, y = NaN; else, y = acos(x); end"),
    "sign": ("x", "if x > 0, y = 1; elseif x < 0, y = -1; elseif x == 0, y = 0; else, y = x; end"),
    "min": ("a, b", "if a < b || a ~= a, y = a; else, y = b; end"),
    "max": ("a, b", "if a > b || a ~= a, y = a; else, y = b; end"),
    "where": ("c, a, b", "if c ~= 0, y = a; else, y = b; end"),
    "regular": ("x, s", f"if abs(x) > {GONE_TEXT} * s, y = x; else, y = NaN; end"),
    "pow": (
        "x, p",
        "if x == 1 || p == 0, y = 1; elseif p ~= p, y = p; elseif x >= 0 || x ~= x, y = x ^ p; "
        "elseif isinf(p) || (isinf(x) && p ~= floor(p)), y = abs(x) ^ p; "
        "elseif p ~= floor(p), y = NaN; else, y = (1 - 2 * mod(p, 2)) * abs(x) ^ p; end",
    ),
}


def emit_matlab(program: Program, *, version: str = "") -> str:
    """The text of `<name>.m`; results are column vectors or matrices."""
    file = file_of(program, _MATLAB, ("m", "s", "c", "a", "b", "y"))
    prefix, arguments = file.prefix, file.arguments
    first = file.first.name
    call = [
        f"Call:     m = {prefix}() from a file {prefix}.m; then m.{first}({arguments}) with columns",
        "          for the vectors. m.defaults are the parameters;",
        f"          [t, x] = ode45(@(t, x) m.{first}(t, x, m.defaults, []), [0 5], x0).",
    ]
    lines = [f"function m = {prefix}()"]
    lines += [f"% {line}".rstrip() for line in head(file, version, call, 1, "()")]
    lines += [f"m = struct('defaults', [{numbers_of(program, _MATLAB).replace(', ', '; ')}]);"]
    lines += [f"m.{f.name} = @{f.name};" for f in file.functions]
    lines += ["end", *(line for f in file.functions for line in _function(f))]
    for name in sorted(file.used & _HELPERS.keys()):
        given, body = _HELPERS[name]
        lines += ["", f"function y = kane_{name}({given})", body, "end"]
    return "\n".join([*lines, ""])


def _function(f: Emitted) -> list[str]:
    lines = ["", f"function {f.target} = {f.name}({f.given})"]
    lines += [f"    h = {f.hoisting};"] if f.hoisting else []
    lines += [f"    {f.target} = zeros({len(f.function.results)}, 1);", *f.lines]
    if len(f.shape) == 2:
        lines.append(f"    out = reshape(out, {f.shape[1]}, {f.shape[0]})';")
    return [*lines, "end"]
