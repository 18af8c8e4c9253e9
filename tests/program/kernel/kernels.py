# SPDX-License-Identifier: BSD-3-Clause
"""Kernels run with NumPy, as machine code and as C, on copies of the same arrays."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from kane import Settings
from kane.expr import GONE, OPS
from kane.program import (
    ArrayOf,
    Callee,
    CompiledKernel,
    Integer,
    Kernel,
    NamedPrinter,
    emit_kernel_c,
    language,
)
from tests.program.emitted import library, module
from tests.program.hosted import in_wasm

HEAD = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n"
C = ("-std=c99", "-O2", "-march=native", "-ffp-contract=off")
EXACT = Settings(contract=False)


def copied(given):
    """The arguments with arrays of their own."""
    return {name: v.copy() if isinstance(v, np.ndarray) else v for name, v in given.items()}


def in_c(kernel: Kernel, source: Path, *options: str):
    """A function of the arguments by name, of which routines are addresses."""
    loaded = library(HEAD + emit_kernel_c(kernel), source, *(options or C))
    function = getattr(loaded, kernel.name)
    function.restype = ctypes.c_int64
    function.argtypes = [ctypes.c_int64 if isinstance(a, Integer) else ctypes.c_void_p for a in kernel.arguments]

    def call(given):
        passed = [given[a.name] for a in kernel.arguments]
        return function(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in passed))

    return call


def _call(op):
    return f"np.{op.ufunc.__name__}({{0}}{', {1}' * (op.arity > 1)})"


_ORDERED = "np.where(({{0}} {} {{1}}) | ({{0}} != {{0}}), {{0}}, {{1}})[()]"
_FORMS = {
    **{key: _call(op) for name, op in OPS.items() if op.ufunc for key in (name, op)},
    OPS["floor"]: "np.floor({0})",
    OPS["less"]: "np.where({0} < {1}, 1.0, 0.0)",
    OPS["where"]: "np.where({0} != 0.0, {1}, {2})",
    OPS["regular"]: f"np.where(np.absolute({{0}}) > {GONE!r} * {{1}}, {{0}}, np.nan)",
    "min": _ORDERED.format("<"),
    "max": _ORDERED.format(">"),
    "less": "{0} < {1}",
    "at_most": "{0} <= {1}",
    "and": "np.logical_and({0}, {1})",
    "or": "np.logical_or({0}, {1})",
    "not": "np.logical_not({0})",
    "select": "np.where({0}, {1}, {2})[()]",
    "float": "np.float64({0})",
    "int": "int({0})",
    "splat4": "np.full(4, {0})",
    "splat8": "np.full(8, {0})",
    "lane": "{0}[{lane}]",
    "any": "np.any({0})",
}
"""An operation as NumPy does it."""
_FOLDS = {"sum": "add", "largest": "max"}
_ZEROS = {"float": "np.float64(0.0)", "int": "0", "bool": "False"}


def _number(value):
    """An operand of Python that is exactly `value`."""
    return {"inf": "np.inf", "-inf": "-np.inf", "nan": "np.nan"}.get(repr(value), repr(value))


class NumPyPrinter(NamedPrinter):  # type: ignore[misc]  # offered when it is first used
    """The lines of one kernel, statement by statement: a second route to what machine code gives."""

    def within(self, head, block):
        """An indented block."""
        self.add(head, *([] if block else ["    pass"]))
        self.indented(block)

    def text(self, operand):
        """An operand; constants of kernels are NumPy's numbers, as Python's own refuse to divide by zero."""
        if not isinstance(operand, language.Immediate):
            return f"v{operand}"
        if isinstance(operand.value, tuple):
            return f"np.array([{', '.join(map(_number, operand.value))}])"
        return str(operand.value) if operand.type.kind == "int" else f"np.float64({_number(operand.value)})"

    def at(self, s):
        """Numbers of an array."""
        index, width = self.text(s.offset), language.type_of(s.value).width
        return f"{s.base}[{index} : {index} + {width}]" if width > 1 else f"{s.base}[{index}]"

    def compute(self, s):
        """An operation."""
        name, operands = self.text(s.value), [self.text(a) for a in s.arguments]
        if s.op in _FOLDS:
            form, half = _FORMS[_FOLDS[str(s.op)]], language.type_of(s.arguments[0]).width // 2
            while half:
                self.add(f"{name} = {form.format(f'{operands[0]}[:{half}]', f'{operands[0]}[{half}:]')}")
                operands, half = [name], half // 2
            self.add(f"{name} = {name}[0]")
            return
        self.add(f"{name} = {_FORMS[s.op].format(*operands, lane=s.lane)}")

    def load(self, s):
        """A value from an array."""
        self.add(f"{self.text(s.value)} = {self.at(s)}{'.copy()' * (language.type_of(s.value).width > 1)}")

    def store(self, s):
        """A value to an array."""
        self.add(f"{self.at(s)} = {self.text(s.value)}")

    def get(self, s):
        """A value from a cell."""
        self.add(f"v{s.value} = cell_{s.cell.name}")

    def put(self, s):
        """A value to a cell."""
        self.add(f"cell_{s.cell.name} = {self.text(s.value)}")

    def call(self, s):
        """A routine, which is given arrays from a place on."""
        given = [
            f"{a.base}[{self.text(a.offset)} :]" if isinstance(a, language.Address) else self.text(a)
            for a in s.arguments
        ]
        self.add(f"{s.callee.name}({', '.join(given)})")

    def choice(self, s):
        """One of two blocks."""
        self.within(f"if {self.text(s.condition)}:", s.then)
        if s.other:
            self.within("else:", s.other)

    def loop(self, s):
        """A block as long as a condition holds."""
        self.add("while True:")
        self.indented(s.head)
        self.add(f"    if not {self.text(s.condition)}:", "        break")
        self.indented(s.body)

    def count(self, s):
        """A block for each integer."""
        index, start, stop = (self.text(x) for x in (s.counter, s.start, s.stop))
        self.within(f"for {index} in range({start}, {stop}):", s.body)


def emit_kernel_numpy(kernel: Kernel):
    """The text of a module with the one function `<name>(arguments)`, of arrays with one axis, from a place on for routines."""
    printer = NumPyPrinter(2)
    for c in kernel.cells:
        zero = _ZEROS[c.type.kind]
        printer.add(f"cell_{c.name} = {f'np.full({c.type.width}, {zero})' if c.type.width > 1 else zero}")
    printer.block(kernel.body)
    arguments = ", ".join(f"v{a.value}" if isinstance(a, Integer) else a.name for a in kernel.arguments)
    head = ["import numpy as np", "", "", f"def {kernel.name}({arguments}):", '    with np.errstate(all="ignore"):']
    return "\n".join([*head, *printer.lines, f"    return int(cell_{kernel.result.name})", ""])


def in_numpy(kernel: Kernel, source: Path):
    """A function of the arguments by name; a routine takes a number for each double, and for each address the array from there."""
    function = getattr(module(emit_kernel_numpy(kernel), source), kernel.name)

    def call(given):
        passed = [given[a.name] for a in kernel.arguments]
        return function(*(v.reshape(-1) if isinstance(v, np.ndarray) else v for v in passed))

    return call


def agree(kernel: Kernel, given, source: Path):
    """What the kernel returns, which NumPy, machine code, C and WebAssembly agree on; so do the arrays, bit by bit.

    A routine is given as a dict of what each of the three takes.
    """
    runs = {
        "numpy": in_numpy(kernel, source.with_suffix(".py")),
        "llvm": CompiledKernel(kernel, EXACT),
        "c": in_c(kernel, source),
    }
    if not any(isinstance(a, Callee) for a in kernel.arguments):
        runs["wasm"] = in_wasm(kernel)
    results = []
    for spoken, run in runs.items():
        own = {name: v[spoken] if isinstance(v, dict) else v for name, v in copied(given).items()}
        back = run(own)
        results.append((back, {a.name: own[a.name].view(np.int64) for a in kernel.arguments if isinstance(a, ArrayOf)}))
    for back, arrays in results[1:]:
        assert back == results[0][0]
        for name, bits in arrays.items():
            assert np.array_equal(bits, results[0][1][name]), name
    return results[0][0]
