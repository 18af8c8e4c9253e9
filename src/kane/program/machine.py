# SPDX-License-Identifier: BSD-3-Clause
"""From a Program to a linked library of machine code."""

from __future__ import annotations

from dataclasses import dataclass

from kane.program.emit.llvm import Options, emit_llvm
from kane.program.native.machine_code import Library, compile_text, target
from kane.program.program import Program


@dataclass(frozen=True, slots=True)
class Settings:
    """How to compile: `contract` allows a·b + c in one rounding (FMA), `cpu` and `features` choose the processor."""

    contract: bool = True
    cpu: str = "host"
    features: str = ""
    cache: bool = True


def build_library(program: Program, settings: Settings) -> Library:
    """Emit and compile, or take the object from the cache."""
    on = target(settings.cpu, settings.features)
    text = emit_llvm([program], Options(settings.contract, on.lanes))
    symbols = ["hoist", *(f"{r.name}{entry}" for r in program.routines for entry in ("", ".call", ".batch"))]
    return compile_text(text, on, symbols, settings.cache)
