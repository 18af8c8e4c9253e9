# SPDX-License-Identifier: BSD-3-Clause
"""Emitted text made callable: the C compiled and loaded, the NumPy module imported."""

import ctypes
import importlib.util
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from kane.program import Program, emit_c, emit_numpy
from tests.program.programs import by_port, compiler

STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic")
OPTIMIZED = ("-std=c99", "-O2", "-march=native")
Pointer = ctypes.POINTER(ctypes.c_double)


def run(command: list[Any], **more: Any) -> str:
    """What a command prints; it must succeed and say nothing on stderr."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, timeout=300, **more)
    assert not done.returncode, f"{done.stderr}\n{done.stdout}"
    assert not done.stderr, done.stderr
    printed: str = done.stdout
    return printed


def library(text: str, source: Path, *options: str) -> ctypes.CDLL:
    """C, written to `source` and compiled without a warning beside it."""
    source.write_text(text, encoding="utf-8")
    built = source.with_suffix(".so")
    run([compiler(), *(options or OPTIMIZED), *STRICT, "-shared", "-fPIC", source, "-o", built, "-lm"])
    return ctypes.CDLL(str(built))


def call(loaded: ctypes.CDLL, program: Program, routine: str, values: Any, prefix: str | None = None) -> np.ndarray:
    """The results at one point, between guards that must stay as they are."""
    prefix = prefix or program.name
    given = {name: np.ascontiguousarray(v) for name, v in by_port(program, values).items()}
    h, out = (np.full(n + 2, 7.25) for n in (len(program.kept), len(program.routine(routine).results)))
    arguments = {
        port: ctypes.c_double(given[port.name][0]) if port.scalar else given[port.name].ctypes.data_as(Pointer)
        for port in program.ports
    }
    inside = [a[1:].ctypes.data_as(Pointer) for a in (h, out)]
    getattr(loaded, f"{prefix}_hoist")(*(a for port, a in arguments.items() if port.hoisted), inside[0])
    getattr(loaded, f"{prefix}_{routine}")(*arguments.values(), *inside)
    assert {h[0], h[-1], out[0], out[-1]} == {7.25}
    return out[1:-1].copy()


def from_c(program: Program, folder: Path, contract: bool) -> Callable[[str, np.ndarray], np.ndarray]:
    """A function of a routine's name and rows of all inputs, through the compiled C."""
    options = (*OPTIMIZED, "-ffp-contract=fast") if contract else OPTIMIZED
    loaded = library(emit_c(program, contract=contract), folder / "emitted.c", *options)
    return lambda name, rows: np.array([call(loaded, program, name, row) for row in rows])


def module(text: str, path: Path) -> ModuleType:
    """Python, written to `path` and imported."""
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def from_numpy(program: Program, folder: Path) -> ModuleType:
    """The emitted module."""
    return module(emit_numpy(program), folder / "emitted.py")
