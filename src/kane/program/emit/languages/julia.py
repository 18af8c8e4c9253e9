# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a Julia module, generic in the number type, so that it accepts the dual numbers of ForwardDiff."""

from kane.program.emit.identifiers import decimal, free_in
from kane.program.emit.languages.straight import GONE_TEXT, Emitted, File, Language, file_of, forms, head, numbers_of
from kane.program.program import Program

_DOMAINS = {"sqrt": "x < 0", "log": "x < 0", "asin": "abs(x) > 1", "acos": "abs(x) > 1"}
_DOMAINS |= dict.fromkeys(("sin", "cos", "tan"), "isinf(x)")
_JULIA = Language(
    forms(
        {
            **{name: f"kane_{name}({{0}})" for name in _DOMAINS},
            "atan2": "atan({0}, {1})",
            "pow": "kane_pow({0}, {1})",
            "min": "ifelse(({0} < {1}) | isnan({0}), {0}, {1})",
            "max": "ifelse(({0} > {1}) | isnan({0}), {0}, {1})",
            "less": "ifelse({0} < {1}, 1.0, 0.0)",
            "where": "ifelse({0} != 0.0, {1}, {2})",
            "regular": f"ifelse(abs({{0}}) > {GONE_TEXT} * {{1}}, {{0}}, NaN)",
            "sign": "ifelse({0} == 0.0, 0.0, sign({0}))",
        },
        "atan sinh cosh tanh exp abs floor",
    ),
    lambda value: decimal(value, "NaN", "Inf"),
    free_in("julia"),
    "#",
    first=1,
)
_POW = (
    "kane_pow(x, p) = (x < 0 && (isinf(p) || (isinf(x) && !isinteger(p)))) ? abs(x)^p : "
    "(x < 0 && !isinteger(p)) ? oftype(x, NaN) : x^p"
)


def emit_julia(program: Program, *, version: str = "") -> str:
    """The text of `<Name>.jl`; results are vectors or matrices."""
    file = file_of(program, _JULIA, ("defaults", "T"))
    module = file.prefix[:1].upper() + file.prefix[1:] + "Model"
    first, arguments = file.first.name, file.arguments
    call = [
        f'Call:     include("{file.prefix}.jl"); {module}.{first}({arguments}) with vectors; {module}.defaults are the parameters.',
        f"          In OrdinaryDiffEq: ODEProblem((x, p, t) -> {module}.{file.functions[1].name if program.routines else 'hoist'}"
        "(t, x, p, Float64[]), x0, (0.0, 5.0), p).",
    ]
    lines = [f"# {line}".rstrip() for line in head(file, version, call, 1)]
    lines += ["", f"module {module}", "", f"const defaults = Float64[{numbers_of(program, _JULIA)}]", ""]
    for name in sorted(file.used & _DOMAINS.keys()):
        lines.append(f"kane_{name}(x) = {_DOMAINS[name]} ? oftype(x, NaN) : {name}(x)")
    lines += [_POW] if "pow" in file.used else []
    for f in file.functions:
        lines += _function(file, f)
    return "\n".join([*lines, "", "end", ""])


def _function(file: File, f: Emitted) -> list[str]:
    names = file.names.arguments
    types = ", ".join(f"{'typeof' if p.scalar else 'eltype'}({names[p.name]})" for p in f.function.ports)
    lines = ["", f"function {f.name}({f.given})"]
    lines += [f"    h = {f.hoisting}"] if f.hoisting else []
    lines += [f"    T = promote_type(Float64{', ' if types else ''}{types})"]
    lines += [f"    {f.target} = Vector{{T}}(undef, {len(f.function.results)})", *f.lines]
    if len(f.shape) == 2:
        lines.append(f"    out = permutedims(reshape(out, {f.shape[1]}, {f.shape[0]}))")
    return [*lines, f"    return {f.target}", "end"]
