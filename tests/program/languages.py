# SPDX-License-Identifier: BSD-3-Clause
"""Emitted text of every language made to run: `LANGUAGES[target](program, folder, rows)` gives the results of all routines by name.

Programs of other languages read the rows as doubles from their standard input and write the results, row by row, to their output.
"""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from kane.program import Program, targets
from tests.peer import require
from tests.program.emitted import call, library, module, run
from tests.program.programs import by_port, compiler

Results = dict[str, np.ndarray]
Language = Callable[[Program, Path, np.ndarray], Results]


def emit(target: str, program: Program) -> str:
    """What the registry's emitter prints."""
    text = targets.emit(program, target, contract=False, version="1")
    assert isinstance(text, str)
    return text


def names(text: str, pattern: str) -> list[str]:
    """The routines that a text defines, in their order."""
    return [name for name in re.findall(pattern, text, re.MULTILINE) if not name.startswith(("_", "kane_"))]


def split(program: Program, flat: np.ndarray) -> Results:
    """Results of all routines of each row, one after the other."""
    ends = np.cumsum([len(r.results) for r in program.routines])
    parts = np.split(flat, ends[:-1], axis=1)
    return {r.name: part for r, part in zip(program.routines, parts, strict=True)}


def piped(command: list[Any], program: Program, rows: np.ndarray, folder: Path) -> Results:
    """The results of a program that reads rows and writes results."""
    done = subprocess.run(
        list(map(str, command)),
        input=np.asarray(rows, float).tobytes(),
        capture_output=True,
        check=False,
        timeout=300,
        cwd=folder,
    )
    assert not done.returncode, done.stderr.decode()
    assert not done.stderr, done.stderr.decode()
    size = sum(len(r.results) for r in program.routines)
    return split(program, np.frombuffer(done.stdout).reshape(len(rows), size))


def places(program: Program) -> list[tuple[str, int, int]]:
    """Where in a row the values of each port stand."""
    found, at = [], 0
    for port in program.ports:
        found.append((port.name, at, at + len(port.symbols)))
        at += len(port.symbols)
    return found


# ------------------------------------------------------------------------------------------------------------ Python


def _array_module(target: str, peer: str, to: Callable[[Any], Any]) -> Language:
    def run_module(program: Program, folder: Path, rows: np.ndarray) -> Results:
        require(peer)
        text = emit(target, program)
        loaded = module(text, folder / f"{target}_module.py")
        functions = names(text, r"^def (\w+)\(")[1:]
        given = by_port(program, rows)
        passed = [to(given[p.name][..., 0] if p.scalar else given[p.name]) for p in program.ports]
        found = [np.asarray(getattr(loaded, name)(*passed)) for name in functions]
        for routine, value in zip(program.routines, found, strict=True):
            assert value.shape == (len(rows), *routine.shape)
        return {r.name: v.reshape(len(rows), -1) for r, v in zip(program.routines, found, strict=True)}

    return run_module


def in_jax(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """In double precision, operation by operation as XLA has them."""
    jax = require("jax")
    jax.config.update("jax_enable_x64", True)
    return _array_module("jax", "jax", np.asarray)(program, folder, rows)


def in_torch(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """As tensors."""
    torch = require("torch")
    return _array_module("torch", "torch", lambda v: torch.tensor(np.asarray(v)))(program, folder, rows)


def in_casadi(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """Through the casadi.Function of each routine."""
    require("casadi")
    text = emit("casadi", program)
    loaded = module(text, folder / "casadi_module.py")
    functions = names(text, r"^def (\w+)\(")[1:-1]
    found: Results = {}
    for routine, name in zip(program.routines, functions, strict=True):
        made = loaded.function(getattr(loaded, name))
        each = [np.asarray(made(*(row[a:b] for _, a, b in places(program)))) for row in rows]
        if routine.shape and routine.results:
            assert each[0].shape == (routine.shape if len(routine.shape) == 2 else (*routine.shape, 1))
        found[routine.name] = np.array([e.reshape(-1) for e in each]).reshape(len(rows), -1)
    return found


def in_sympy(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """Each intermediate and result by SymPy's own substitution of numbers."""
    import sympy

    text = emit("sympy", program)
    loaded = module(text, folder / "sympy_module.py")
    functions = names(text, r"^def (\w+)\(")
    symbols = [s for own in loaded.SYMBOLS.values() for s in own]
    found: Results = {}
    for routine, name in zip(program.routines, functions, strict=True):
        steps, out = getattr(loaded, name)()
        rows_of = []
        for row in rows:
            known = dict(zip(symbols, map(np.float64, row), strict=True))
            with np.errstate(all="ignore"):
                for symbol, expression in [*steps, *((None, e) for e in out)]:
                    free = sorted(sympy.sympify(expression).free_symbols, key=str)
                    value = sympy.lambdify(free, expression, "numpy")(*(known[s] for s in free))
                    if symbol is None:
                        rows_of.append(np.float64(value))
                    else:
                        known[symbol] = np.float64(value)
        found[routine.name] = np.array(rows_of).reshape(len(rows), len(routine.results))
    return found


def in_numpy(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The module for NumPy."""
    return _array_module("numpy", "numpy", np.asarray)(program, folder, rows)


def in_c(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """C as a library."""
    loaded = library(emit("c", program), folder / "emitted.c", "-std=c99", "-O1")
    return {r.name: np.array([call(loaded, program, r.name, row) for row in rows]) for r in program.routines}


# ------------------------------------------------------------------------------------------------------- C++ and Rust

_MAIN_CPP = """
#include "model.hpp"
#include <cstdio>
int main() {{
    double row[{count} + 1];
    while (std::fread(row, sizeof(double), {count}, stdin) == {count}) {{
{given}
{calls}
    }}
    return 0;
}}
"""


def _in_cpp(target: str) -> Language:
    def run_cpp(program: Program, folder: Path, rows: np.ndarray) -> Results:
        text = emit(target, program)
        (folder / "model.hpp").write_text(text, encoding="utf-8")
        space = re.findall(r"^namespace (\w+) {", text, re.MULTILINE)[0]
        own = r"^inline (?:std::array|Eigen::Matrix)<[^>]*> (\w+)\("
        wrappers = names(text, own)[1:]
        given, passed = [], []
        for port, (_, a, b) in zip(program.ports, places(program), strict=True):
            kind = f"std::array<double, {b - a}>" if target == "cpp" else f"Eigen::Matrix<double, {b - a}, 1>"
            given.append(
                f"    {kind} a{a}_{port.name}{{}};"
                if not port.scalar
                else f"    const double a{a}_{port.name} = row[{a}];"
            )
            if not port.scalar and b > a:
                given.append(f"    for (int k = 0; k < {b - a}; ++k) a{a}_{port.name}[k] = row[{a} + k];")
            passed.append(f"a{a}_{port.name}")
        calls = []
        for routine, name in zip(program.routines, wrappers, strict=True):
            n = len(routine.results)
            value = f"    {{ const auto found = {space}::{name}({', '.join(passed)});"
            if target == "eigen" and len(routine.shape) == 2:
                rows_, columns = routine.shape
                each = f"for (int i = 0; i < {rows_}; ++i) for (int j = 0; j < {columns}; ++j) "
                calls.append(
                    f"{value} {each}{{ const double v = found(i, j); std::fwrite(&v, sizeof v, 1, stdout); }} (void)found; }}"
                )
            else:
                write = f"std::fwrite(found.data(), sizeof(double), {n}, stdout);" if n else "(void)found;"
                calls.append(f"{value} {write} }}")
        main = _MAIN_CPP.format(count=len(program.inputs), given="\n".join(given), calls="\n".join(calls))
        (folder / "main.cpp").write_text(main, encoding="utf-8")
        include = ["-isystem", eigen()] if target == "eigen" else []
        strict = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-Wno-unused-result"]
        run(
            [
                compiler("g++"),
                "-std=c++17",
                "-O1",
                "-ffp-contract=off",
                *strict,
                *include,
                folder / "main.cpp",
                "-o",
                folder / "main",
            ]
        )
        return piped([folder / "main"], program, rows, folder)

    return run_cpp


def eigen() -> Path:
    """Where the headers of Eigen are: those that Pinocchio's packages bring."""
    require("pinocchio")
    cmeel = Path(str(require("pinocchio").__file__)).parents[4] / "include" / "eigen3"
    assert (cmeel / "Eigen" / "Core").exists(), cmeel
    return cmeel


_MAIN_RUST = """
use std::io::{{Read, Write}};
fn main() {{
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).unwrap();
    let row: Vec<f64> = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    let mut h = [0.0f64; {kept}];
    for row in row.chunks_exact({count}) {{
        let _ = row;
        model::{hoist}({hoisted}&mut h);
{calls}
    }}
}}
"""


def in_rust(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The crate compiled as a library without std, and a program that calls it."""
    rustc = compiler("rustc")
    text = emit("rust", program)
    (folder / "lib.rs").write_text(text, encoding="utf-8")
    assert 'edition = "2021"' in emit("cargo", program)
    hoist, *functions = names(text, r"^pub fn (\w+)\(")
    given = {}
    for port, (_, a, b) in zip(program.ports, places(program), strict=True):
        given[port] = f"row[{a}]" if port.scalar else f"&(row[{a}..{b}].try_into().unwrap())"
    calls = [
        f"        let mut out = [0.0f64; {len(r.results)}]; model::{name}({', '.join(given.values())}, &h, &mut out);\n"
        "        for v in out { std::io::stdout().write_all(&v.to_le_bytes()).unwrap(); }"
        for r, name in zip(program.routines, functions, strict=True)
    ]
    hoisted = "".join(f"{v}, " for p, v in given.items() if p.hoisted)
    main = _MAIN_RUST.format(
        count=len(program.inputs), kept=len(program.kept), hoist=hoist, hoisted=hoisted, calls="\n".join(calls)
    )
    (folder / "main.rs").write_text(main, encoding="utf-8")
    edition = ["--edition", "2021", "-D", "warnings"]
    run(
        [
            rustc,
            *edition,
            "-O",
            "--crate-type",
            "rlib",
            "--crate-name",
            "model",
            folder / "lib.rs",
            "-o",
            folder / "libmodel.rlib",
        ]
    )
    run([rustc, *edition, folder / "main.rs", "--extern", f"model={folder / 'libmodel.rlib'}", "-o", folder / "main"])
    return piped([folder / "main"], program, rows, folder)


# ---------------------------------------------------------------------------------------------- Octave and JavaScript

_OCTAVE = """
rows = fread(stdin, Inf, 'double');
m = {name}();
rows = reshape(rows, {count}, numel(rows) / {count});
for k = 1:size(rows, 2)
    row = rows(:, k);
{calls}
end
"""


def in_octave(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The function file, called by a script."""
    octave = compiler("octave-cli")
    text = emit("matlab", program)
    (name,) = re.findall(r"^function m = (\w+)\(\)", text, re.MULTILINE)
    (folder / f"{name}.m").write_text(text, encoding="utf-8")
    functions = re.findall(r"^m\.(\w+) = @", text, re.MULTILINE)[1:]
    given = [f"row({a + 1}:{b})" for _, a, b in places(program)]
    calls = []
    for routine, own in zip(program.routines, functions, strict=True):
        shape = {0: "[1 1]", 1: f"[{(*routine.shape, 0)[0]} 1]", 2: str(list(routine.shape)).replace(",", "")}[
            len(routine.shape)
        ]
        calls.append(f"    y = m.{own}({', '.join(given)}); assert(isreal(y) && all(size(y) == {shape}));")
        calls.append("    fwrite(stdout, y', 'double');")
    script = _OCTAVE.format(name=name, count=len(program.inputs), calls="\n".join(calls))
    (folder / "kane_script.m").write_text(script, encoding="utf-8")
    return piped([octave, "--norc", "--no-history", "kane_script.m"], program, rows, folder)


_NODE = """
import * as model from "./{module}";
import fs from "fs";
const bytes = fs.readFileSync(0);
const rows = new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const out = [];
for (let k = 0; k < rows.length; k += {count}) {{
    const row = Array.from(rows.slice(k, k + {count}));
{calls}
}}
fs.writeSync(1, Buffer.from(new Float64Array(out).buffer));
"""


def _node(program: Program, folder: Path, rows: np.ndarray, functions: list[str], file: str, first: int = 0) -> Results:
    """Functions of a module, in Node; arrays have their first element at `first`."""
    own = ["row[{}]" if p.scalar else f"[{'0, ' * first}...row.slice({{}}, {{}})]" for p in program.ports]
    given = ", ".join(text.format(a, b) for text, (_, a, b) in zip(own, places(program), strict=True))
    calls = [f"    out.push(...model.{name}({given}){f'.slice({first})' * bool(first)});" for name in functions]
    (folder / "main.mjs").write_text(
        _NODE.format(module=file, count=len(program.inputs), calls="\n".join(calls)), encoding="utf-8"
    )
    return piped([compiler("node"), "main.mjs"], program, rows, folder)


def in_node(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The module of JavaScript."""
    text = emit("javascript", program)
    (folder / "model.mjs").write_text(text, encoding="utf-8")
    return _node(program, folder, rows, names(text, r"^export function (\w+)\(")[1:], "model.mjs")


_MATH = "const {sqrt, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, exp, log, abs, floor, sign} = Math;\n"
_POW = "export const power = (x, p) => (x === 1 || (x === -1 && abs(p) === Infinity)) ? 1 : Math.pow(x, p);\n"


def read_julia(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The statements of the module in JavaScript: Debian has no Julia, so that its grammar is not tested here, its numbers are."""
    text = emit("julia", program)
    body = text.split("const defaults")[1].split("\n", 1)[1]
    body = re.sub(r"^kane_pow\(.*$", "const kane_pow = power;", body, flags=re.MULTILINE)
    body = re.sub(
        r"^(kane_\w+)\(x\) = (.*?) \? oftype\(x, NaN\) : (\w+)\(x\)$",
        r"const \1 = x => (\2) ? NaN : Math.\3(x);",
        body,
        flags=re.MULTILINE,
    )
    body = re.sub(r"^function (.*)$", r"export function \1 {", body, flags=re.MULTILINE)
    body = re.sub(r"^    T = .*\n", "", body, flags=re.MULTILINE)
    body = re.sub(r"permutedims\(reshape\(out, \d+, \d+\)\)", "out", body)
    body = re.sub(r"Vector\{T\}\(undef, (\d+)\)", r"new Array(1 + \1)", body)
    body = re.sub(r"#.*$", "", body, flags=re.MULTILINE)
    body = re.sub(r"^    (\w+) = ", r"    var \1 = ", body, flags=re.MULTILINE).replace("atan(", "arctan(")
    body = re.sub(r"^end$", "}", body, flags=re.MULTILINE).rstrip()[:-1]
    body = body.replace("\nInf\n", "\n").replace("Inf)", "Infinity)")
    more = "const ifelse = (c, a, b) => c ? a : b, isnan = x => x !== x, isinf = x => Math.abs(x) === Infinity;\n"
    more += "const arctan = (y, x) => x === undefined ? Math.atan(y) : Math.atan2(y, x);\n"
    (folder / "julia.mjs").write_text(_MATH + _POW + more + body, encoding="utf-8")
    return _node(program, folder, rows, names(text, r"^function (\w+)\(")[1:], "julia.mjs", 1)


def read_modelica(program: Program, folder: Path, rows: np.ndarray) -> Results:
    """The statements of the package in JavaScript: Debian has no compiler of Modelica, so that its grammar is not tested here."""
    text = emit("modelica", program)
    lines, called = [_MATH, _POW, "const atan2 = Math.atan2;"], []
    for name, body in re.findall(r"^  function (\w+)[^\n]*\n(.*?)^  end \1;", text, re.MULTILINE | re.DOTALL):
        head, statements = body.split("  algorithm\n")
        given = re.findall(r"input Real (\w+)", head)
        (target,) = re.findall(r"output Real (\w+)", head)
        local = re.findall(r"^    Real (\w+)", head, re.MULTILINE)
        assert set(re.findall(r"^    (\w+) :=", statements, re.MULTILINE)) <= {*local, target}
        hoist = re.findall(r"Real (h\[\d+\] = .*);", head)
        hoisted = f"    const h = {hoist[0].partition(' = ')[2]};\n" if hoist else ""
        statements = re.sub(r"//.*$", "", statements, flags=re.MULTILINE)
        statements = re.sub(r'assert\((.*), ".*"\);', r"if (!(\1)) y = NaN;", statements)
        statements = re.sub(r"\belseif (.*?) then", r": \1 ?", statements)
        statements = re.sub(r"\bif (.*?) then", r"\1 ?", statements).replace("else", ":").replace("<>", "!==")
        statements = re.sub(
            r"^    (\S+) := (\S+) \^ (\S+);", r"    \1 := power(\2, \3);", statements, flags=re.MULTILINE
        )
        statements = re.sub(r"^    (\w+) :=", r"    var \1 =", statements, flags=re.MULTILINE).replace(":=", "=")
        kind = "var y;" if name == "kane_regular" else f"const {target} = [0];"
        lines += [
            f"export function {name}({', '.join(given)}) {{",
            kind,
            hoisted + statements,
            f"return {target};",
            "}",
        ]
        called += [name] if name != "kane_regular" else []
    source = "\n".join(lines).replace("var y = x;", "return abs(x) > least ? x : NaN;")
    (folder / "modelica.mjs").write_text(source, encoding="utf-8")
    return _node(program, folder, rows, called[1:], "modelica.mjs", 1)


LANGUAGES: dict[str, Language] = {
    "c": in_c,
    "numpy": in_numpy,
    "jax": in_jax,
    "torch": in_torch,
    "casadi": in_casadi,
    "sympy": in_sympy,
    "cpp": _in_cpp("cpp"),
    "eigen": _in_cpp("eigen"),
    "rust": in_rust,
    "matlab": in_octave,
    "javascript": in_node,
    "julia": read_julia,
    "modelica": read_modelica,
}
"""By target; headers and Cargo.toml belong to another one."""
