# SPDX-License-Identifier: BSD-3-Clause
"""The target languages of Programs; a new one is a module and a row of these tables."""

from collections.abc import Callable, Mapping
from functools import partial

from kane.errors import ArgumentError, none_of
from kane.program.emit.c import emit_c, emit_header
from kane.program.emit.languages.cpp import emit_cpp
from kane.program.emit.languages.javascript import emit_javascript
from kane.program.emit.languages.julia import emit_julia
from kane.program.emit.languages.matlab import emit_matlab
from kane.program.emit.languages.modelica import emit_modelica
from kane.program.emit.languages.numpy import emit_numpy
from kane.program.emit.languages.python_arrays import JAX, TORCH, emit_arrays
from kane.program.emit.languages.python_symbols import emit_casadi, emit_sympy
from kane.program.emit.languages.rust import emit_cargo, emit_rust
from kane.program.emit.languages.simulink import emit_simulink
from kane.program.emit.wasm import emit_wasm
from kane.program.program import Program

EMITTERS: dict[str, Callable[..., str]] = {
    "c": emit_c,
    "h": emit_header,
    "numpy": emit_numpy,
    "jax": partial(emit_arrays, JAX),
    "torch": partial(emit_arrays, TORCH),
    "casadi": emit_casadi,
    "sympy": emit_sympy,
    "cpp": emit_cpp,
    "eigen": partial(emit_cpp, eigen=True),
    "rust": emit_rust,
    "cargo": emit_cargo,
    "matlab": emit_matlab,
    "julia": emit_julia,
    "modelica": emit_modelica,
    "javascript": emit_javascript,
    "sfunction": emit_simulink,
}
"""Emitters of a Program by target; `version` is the version of kane, for comments."""
BINARY: dict[str, Callable[..., bytes]] = {"wasm": emit_wasm}
"""The emitters whose result is bytes instead of text."""
CONTRACTED = frozenset({"c", "sfunction"})
"""The targets with the option `contract`, which permits compilers to round a·b + c once; others ignore it."""


def emit(program: Program, target: str, *, contract: bool, version: str) -> str | bytes:
    """A Program in the target language."""
    emitters: Mapping[str, Callable[..., str | bytes]] = {**EMITTERS, **BINARY}
    if target not in emitters:
        raise ArgumentError(f"Expected one of {none_of(emitters, target)}")
    return emitters[target](program, version=version, **({"contract": contract} if target in CONTRACTED else {}))
