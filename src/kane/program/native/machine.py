# SPDX-License-Identifier: BSD-3-Clause
"""From Programs to a linked library of machine code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kane.program.emit.llvm import Options, emit_llvm, hoists
from kane.program.native.machine_code import Library, compile_text, target
from kane.program.program import Program


@dataclass(frozen=True, slots=True)
class Settings:
    """How to compile: `contract` allows a·b + c in one rounding (FMA), `cpu` and `features` choose the processor."""

    contract: bool = True
    cpu: str = "host"
    features: str = ""
    cache: bool = True


def build_library(programs: Sequence[Program], settings: Settings) -> Library:
    """Emit and compile as one module, or take the object from the cache. The names of all routines must differ."""
    on = target(settings.cpu, settings.features)
    text = emit_llvm(programs, Options(settings.contract, on.lanes))
    routines = [r.name for program in programs for r in program.routines]
    symbols = [*hoists(programs), *(f"{name}{entry}" for name in routines for entry in ("", ".call", ".batch"))]
    return compile_text(text, on, symbols, settings.cache)
