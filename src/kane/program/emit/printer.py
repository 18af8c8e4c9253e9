# SPDX-License-Identifier: BSD-3-Clause
"""What printers of all languages share: a method for each kind of statement, lines, indented blocks."""

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from kane.expr.ops import OPS, Op
from kane.program.kernel import language


def shared(rows: Mapping[str, str]) -> dict[Op | str, str]:
    """Forms by the name of an operation, for kernels, which have the names, and for Programs."""
    return {key: form for name, form in rows.items() for key in (name, OPS[name])}


class Printer:
    """The lines of one function; a language says what each statement is in it."""

    methods: ClassVar[Mapping[type[Any], str]] = {
        language.Compute: "compute",
        language.SinCos: "sincos",
        language.Read: "load",
        language.Write: "store",
        language.Get: "get",
        language.Put: "put",
        language.CallRoutine: "call",
        language.If: "choice",
        language.While: "loop",
        language.Count: "count",
    }

    def __init__(self, depth: int = 1) -> None:
        self.lines: list[str] = []
        self.depth = depth
        self._print = {kind: getattr(self, name, None) for kind, name in self.methods.items()}

    def add(self, *lines: str) -> None:
        """Lines of the block at hand."""
        indent = "    " * self.depth
        self.lines += [f"{indent}{line}" for line in lines]

    def block(self, block: Iterable[language.Statement]) -> None:
        """The lines of statements in order."""
        printers: Mapping[type[Any], Any] = self._print
        for s in block:
            printers[type(s)](s)

    def indented(self, *blocks: Iterable[language.Statement]) -> None:
        """Blocks one step to the right."""
        self.depth += 1
        for block in blocks:
            self.block(block)
        self.depth -= 1


class NamedPrinter(Printer):
    """A printer of a language with expressions; `names` are those of a Program's values, `vectors` those of its vectors."""

    def __init__(
        self, depth: int, names: Mapping[int, str] | None = None, vectors: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(depth)
        self.names, self.vectors = names or {}, vectors or {}
