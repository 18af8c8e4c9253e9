# SPDX-License-Identifier: BSD-3-Clause
"""The languages in which a Program can be printed: a new one is a file and a row here."""

from collections.abc import Callable

from kane.program.emit.c import emit_c, emit_header
from kane.program.emit.numpy import emit_numpy
from kane.program.emit.wasm import emit_wasm

EMITTERS: dict[str, Callable[..., str]] = {"c": emit_c, "h": emit_header, "numpy": emit_numpy}
"""By target: functions of a Program; `contract` allows a·b + c in one rounding, `version` is kane's, for comments."""
BINARY: dict[str, Callable[..., bytes]] = {"wasm": emit_wasm}
"""Those of which the result is no text."""
