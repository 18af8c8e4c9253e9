# SPDX-License-Identifier: BSD-3-Clause
"""From Programs to a linked library of machine code."""

from collections.abc import Sequence
from dataclasses import dataclass

from kane.collector import collecting_seldom
from kane.errors import Attributes
from kane.program.emit.llvm import emit_llvm, hoists
from kane.program.native.machine_code import Library, compile_text, target
from kane.program.program import Program
from kane.progress import working


@dataclass(frozen=True, slots=True)
class Settings(Attributes):
    """How to compile; the fields are those of `kn.compile`, and motions and analyses take them as `settings=`.

    `contract` allows a·b + c in one rounding (FMA) and shared reciprocals. `cpu` is "host", or "generic" for what every processor of
    this kind has, with the `features` to add. `cache` keeps the code in the user's cache folder. `optimize` rewrites to fewer
    operations where `contract` lets results round in another way.
    """

    contract: bool = True
    cpu: str = "host"
    features: str = ""
    cache: bool = True
    optimize: bool = True


def build_library(programs: Sequence[Program], settings: Settings) -> Library:
    """Emit and compile as one module, or take the object from the cache. The names of all routines must differ."""
    with working("Compiling"), collecting_seldom():
        on = target(settings.cpu, settings.features)
        text = emit_llvm(programs, settings.contract, on.lanes)
        routines = [r.name for program in programs for r in program.routines]
        symbols = [*hoists(programs), *(f"{name}{entry}" for name in routines for entry in ("", ".call", ".batch"))]
        return compile_text(text, on, symbols, settings.cache)
