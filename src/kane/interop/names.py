# SPDX-License-Identifier: BSD-3-Clause
"""Unique names from those of a source: unchanged, or converted to Python identifiers."""

from collections.abc import Iterable

from kane.program.emit.identifiers import numbered, word


class FreeNames:
    """The names in use, and new ones derived from wanted names."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def free(self, wanted: str) -> str:
        """`wanted` without spaces, with a number appended if the name is in use."""
        return numbered("".join("_" if c.isspace() else c for c in wanted) or "x", self._taken)

    def identifier(self, wanted: str, kind: str) -> str:
        """`wanted` as an identifier, with `kind` appended if it is in use."""
        plain = word(wanted, kind)
        return numbered(f"{plain}_{kind}" if plain in self._taken else plain, self._taken)
