# SPDX-License-Identifier: BSD-3-Clause
"""Kernels run with NumPy, as machine code and as C, on copies of the same arrays."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from kane import Settings
from kane.program import (
    ArrayOf,
    Callee,
    CompiledKernel,
    Integer,
    Kernel,
    emit_kernel_c,
    emit_kernel_numpy,
    emit_kernel_wasm,
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
        runs["wasm"] = in_wasm(kernel, emit_kernel_wasm)
    results = []
    for language, run in runs.items():
        own = {name: v[language] if isinstance(v, dict) else v for name, v in copied(given).items()}
        back = run(own)
        results.append((back, {a.name: own[a.name].view(np.int64) for a in kernel.arguments if isinstance(a, ArrayOf)}))
    for back, arrays in results[1:]:
        assert back == results[0][0]
        for name, bits in arrays.items():
            assert np.array_equal(bits, results[0][1][name]), name
    return results[0][0]
