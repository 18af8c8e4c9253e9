# SPDX-License-Identifier: BSD-3-Clause
"""Emitted text made callable: the C compiled and loaded, the NumPy module imported."""

import ctypes
import importlib.util
import subprocess
from itertools import count

import numpy as np

from kane.program.emit_c import emit_c
from kane.program.emit_numpy import emit_numpy
from tests.program.programs import compiler

_numbers = count()
FLAGS = ("-std=c99", "-O2", "-march=native", "-Wall", "-Wextra", "-Werror", "-pedantic")


def from_c(program, folder, contract, flags=FLAGS):
    """call(routine, t, x, p, r) over rows, through the compiled C."""
    source, library = folder / "emitted.c", folder / "emitted.so"
    source.write_text(emit_c(program, contract=contract), encoding="utf-8")
    extra = ("-ffp-contract=fast",) if contract else ()
    subprocess.run([compiler(), *flags, *extra, "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))

    def call(name, t, x, p, r):
        function, hoist = getattr(loaded, f"{program.name}_{name}"), getattr(loaded, f"{program.name}_hoist")
        pointer = ctypes.c_void_p
        function.argtypes, function.restype = [ctypes.c_double, *[pointer] * 5], None
        hoist.argtypes, hoist.restype = [pointer] * 2, None
        results = np.empty((len(t), len(program.routine(name).results)))
        h = np.empty(len(program.kept) + 1)
        for k in range(len(t)):
            row = [np.ascontiguousarray(a[k]) for a in (x, p, r)]
            out = np.empty(results.shape[1] + 1)
            hoist(row[1].ctypes.data, h.ctypes.data)
            function(t[k], row[0].ctypes.data, row[1].ctypes.data, row[2].ctypes.data, h.ctypes.data, out.ctypes.data)
            results[k] = out[:-1]
        return results

    return call


def from_numpy(program, folder):
    """The emitted module."""
    path = folder / "emitted.py"
    path.write_text(emit_numpy(program), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"emitted_{next(_numbers)}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
