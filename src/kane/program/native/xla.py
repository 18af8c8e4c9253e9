# SPDX-License-Identifier: BSD-3-Clause
"""A routine as a function that XLA calls, compiled through LLVM as all others: no compiler of C++ is asked for."""

from kane.program.emit.xla_handler import emit_xla
from kane.program.native import store
from kane.program.native.entry import Entry
from kane.program.native.machine import Settings, compile_text, target
from kane.program.program import Program
from kane.progress import working


def xla_function(program: Program, settings: Settings) -> tuple[str, Entry]:
    """A name that no other code has, and the function, which keeps its code alive; `program` has one routine.

    Programs that XLA keeps on disk find the function by this name: it is the digest of the code's text.
    """
    (routine,) = program.routines
    on = target(settings.cpu, settings.features)
    text = emit_xla(program, routine, settings.contract, on.lanes)
    symbol = f"{routine.name}.xla"
    with working("Compiling"):
        library = compile_text(text, on, [symbol], settings.cache)
    return f"kane.{routine.name}.{store.key(text)[:32]}", Entry(library, symbol)
