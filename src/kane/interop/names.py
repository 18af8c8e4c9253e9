# SPDX-License-Identifier: BSD-3-Clause
"""Names of a source as free ones, each given out once: as it stands, or as an identifier of Python."""

from collections.abc import Iterable

from kane.program.emit.identifiers import numbered, word


class FreeNames:
    """Names that are taken, and free ones made of what is wanted."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def free(self, wanted: str) -> str:
        """`wanted` without spaces, with a number behind it where it is taken."""
        return numbered("".join("_" if c.isspace() else c for c in wanted) or "x", self._taken)

    def identifier(self, wanted: str, kind: str) -> str:
        """`wanted` where that is a free identifier, else one made of it, with what `kind` it is of where it is taken."""
        plain = word(wanted, kind)
        return numbered(f"{plain}_{kind}" if plain in self._taken else plain, self._taken)
