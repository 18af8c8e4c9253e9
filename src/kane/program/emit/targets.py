# SPDX-License-Identifier: BSD-3-Clause
"""The languages in which a Program can be printed: a new one is a file and a row here."""

from typing import Protocol

from kane.program.emit.c import emit_c, emit_header
from kane.program.emit.numpy import emit_numpy
from kane.program.program import Program


class Emitter(Protocol):
    """A function from a Program to text. `contract` allows a·b + c in one rounding, `version` is kane's, for comments."""

    def __call__(self, program: Program, *, contract: bool, version: str) -> str:
        """The text."""


EMITTERS: dict[str, Emitter] = {"c": emit_c, "h": emit_header, "numpy": emit_numpy}
"""By target."""
