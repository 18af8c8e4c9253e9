# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one Python module that rebuilds it in symbols of another tool: SX of CasADi, or SymPy with intermediate variables."""

import math

from kane.program.emit.identifiers import decimal, free_in_module, python_comment
from kane.program.emit.languages.numpy import described
from kane.program.emit.languages.straight import GONE_TEXT, Language, file_of, forms, head, numbers_of
from kane.program.program import Program

_CASADI = Language(
    forms(
        {
            "atan2": "ca.atan2({0}, {1})",
            "pow": "ca.power({0}, {1})",
            "abs": "ca.fabs({0})",
            "min": "ca.fmin({0}, {1})",
            "max": "ca.fmax({0}, {1})",
            "less": "ca.if_else({0} < {1}, 1.0, 0.0)",
            "where": "ca.if_else({0} != 0.0, {1}, {2})",
            "regular": f"ca.if_else(ca.fabs({{0}}) > {GONE_TEXT} * {{1}}, {{0}}, NAN)",
        },
        "sqrt sin cos tan asin acos atan sinh cosh tanh exp log sign floor",
        "ca.{}({{0}})",
    ),
    lambda value: decimal(value, "NAN", "INFINITY"),
    free_in_module("ca", "NAN", "INFINITY", "SX"),
    "#",
    listed=True,
    wrapped="ca.SX({0})",
)


def emit_casadi(program: Program, *, version: str = "") -> str:
    """The text of a module; each routine is a function of SX, DM or numbers."""
    file = file_of(program, _CASADI, ("SIZES", "DEFAULTS", "ROUTINES", "function", "out", "routine", "given"))
    hoist, *routines = file.functions
    arguments, first = file.arguments, file.first.name
    call = [
        f"Call: {first}({arguments}) with columns of SX or DM; function({first}) is",
        "      the casadi.Function of these arguments; DEFAULTS are the parameters. fmin and fmax pass no NaN on.",
    ]
    given = [(file.names.arguments[p.name], 1 if p.scalar else len(p.symbols)) for p in program.ports]
    sizes = ", ".join(f"{name!r}: {size}" for name, size in given)
    parts = [
        *(f"# {line}".rstrip() for line in head(file, version, call)),
        "",
        "import casadi as ca",
        "",
        'NAN, INFINITY = float("nan"), float("inf")',
        f"SIZES = {{{sizes}}}",
        f"DEFAULTS = [{numbers_of(program, _CASADI)}]",
        "",
        "",
        f"def {hoist.name}({hoist.given}):",
        '    """What depends on parameters alone: the routines call it themselves."""',
        *hoist.lines,
        *hoist.listed("    "),
        "    return out",
    ]
    for f in routines:
        parts += ["", "", f"def {f.name}({arguments}):", described(program.routine(f.function.name))]
        parts += [f"    h = {f.hoisting}", *f.lines, *f.listed("    ")]
        shape, whole = f.shape, "ca.vertcat(*out)"
        whole = f"ca.reshape({whole}, {shape[1]}, {shape[0]}).T" if len(shape) == 2 else whole
        parts.append(f"    return {whole}")
    return "\n".join([*parts, _FUNCTION])


_FUNCTION = '''

def function(routine):
    """The casadi.Function of a routine of this module."""
    given = [ca.SX.sym(name, size) for name, size in SIZES.items()]
    return ca.Function(routine.__name__, given, [ca.SX(routine(*given))], list(SIZES), [routine.__name__ + "_"])
'''


def _sympy_number(value: float) -> str:
    if math.isfinite(value) and value == int(value) and abs(value) < 2**53:
        return f"sp.Integer({int(value)})" if math.copysign(1.0, value) > 0 or value else "sp.Float(-0.0)"
    return (
        "sp.nan"
        if math.isnan(value)
        else f"sp.Float({value!r}, 17)"
        if math.isfinite(value)
        else decimal(value, "", "sp.oo")
    )


_SYMPY = Language(
    forms(
        {
            "atan2": "sp.atan2({0}, {1})",
            "pow": "sp.Pow({0}, {1})",
            "abs": "sp.Abs({0})",
            "min": "sp.Min({0}, {1})",
            "max": "sp.Max({0}, {1})",
            "less": "sp.Piecewise((sp.Integer(1), {0} < {1}), (sp.Integer(0), True))",
            "where": "sp.Piecewise(({1}, sp.Ne({0}, 0)), ({2}, True))",
            "regular": f"sp.Piecewise(({{0}}, sp.Abs({{0}}) > sp.Float({GONE_TEXT}, 17) * {{1}}), (sp.nan, True))",
        },
        "sqrt sin cos tan asin acos atan sinh cosh tanh exp log sign floor",
        "sp.{}({{0}})",
    ),
    _sympy_number,
    free_in_module("sp", "Steps", "out"),
    "#",
    define='{0} = steps.put("{0}", {1})',
    listed=True,
    load="{0} = {1}",
)
_STEPS = '''
class Steps(list):
    """Pairs (symbol, expression), each of symbols before it."""

    def put(self, name, expression):
        symbol = sp.Symbol(name)
        self.append((symbol, expression))
        return symbol
'''


def emit_sympy(program: Program, *, version: str = "") -> str:
    """The text of a module; each routine returns (intermediates, results) like `sympy.cse`, so that expressions stay small."""
    file = file_of(program, _SYMPY, ("steps", "SYMBOLS"), whole=True)
    routines = file.functions[1:]
    call = [
        f"Call: steps, out = {file.first.name}(): pairs (symbol, expression), and the results in these symbols,",
        "      as sympy.cse gives them. SYMBOLS holds the symbols of time, state, parameters and inputs by port.",
    ]
    rows, k = [], 0
    for port in program.ports:
        names = file.names.inputs[k : k + len(port.symbols)]
        k += len(names)
        own = ", ".join(f'sp.Symbol("{name}")' for name in names)
        comment = ", ".join(python_comment(s.name) for s in port.symbols)
        rows.append(f"    {file.names.arguments[port.name]!r}: [{own}],  # {comment}".rstrip(" #"))
    parts = [
        *(f"# {line}".rstrip() for line in head(file, version, call)),
        "",
        "import sympy as sp",
        "",
        "SYMBOLS = {",
        *rows,
        "}",
        "",
        _STEPS,
    ]
    for f in routines:
        ports = [
            f"    {file.names.arguments[p.name]} = SYMBOLS[{file.names.arguments[p.name]!r}]" for p in program.ports
        ]
        scalars = [
            f"    ({file.names.arguments[p.name]},) = {file.names.arguments[p.name]}" for p in program.ports if p.scalar
        ]
        parts += ["", f"def {f.name}():", described(program.routine(f.function.name)), *ports, *scalars]
        parts += ["    steps = Steps()", *f.lines, *f.listed("    "), "    return steps, out", ""]
    return "\n".join(parts)
