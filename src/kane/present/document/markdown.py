# SPDX-License-Identifier: BSD-3-Clause
"""A report as GitHub-flavoured Markdown: formulas between dollar signs, tables with pipes, figures beside it as SVG."""

import re
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from kane.present.content import Content
from kane.present.document.pieces import (
    Formulas,
    Heading,
    Listed,
    MarkdownText,
    ReportPicture,
    Words,
    beside,
    file_name,
    pieces,
)
from kane.present.languages.catalogue import tr
from kane.present.overview import Cell, PageTable, Tex
from kane.present.pages import Document, segments

_ENDING = ".svg"
_MARKS = re.compile(r"([\\`*_{}\[\]<>#|~$&])")
"""Characters with a meaning in Markdown."""


def markdown(content: Content, name: str) -> Document:
    """The file, with its figures, whose names begin with `name`."""
    told = list(pieces(content))
    parts = [
        f"<!-- A report of kane {version('kane')} -->",
        f"# {_text(content.title)}",
        *(_WRITERS[type(piece)](piece, name) for piece in told),
        tr("Derived by Kane's method with kane %(version)s.", version=version("kane")),
    ]
    return Document("\n\n".join(parts) + "\n", beside(told, name, _ENDING))


def _text(plain: str) -> str:
    return _MARKS.sub(r"\\\1", " ".join(plain.split()))


def _math(latex: str) -> str:
    """A formula without Markdown syntax: an asterisk would emphasize, a bar end a cell; spaces at the ends are removed."""
    return latex.replace("*", r"\ast ").replace("|", r"\vert ").strip()


def _prose(sentence: str) -> str:
    return "".join(
        f"${_math(piece)}$" if formula else _MARKS.sub(r"\\\1", piece) for formula, piece in segments(sentence)
    )


def _formulas(piece: Formulas, _: str) -> str:
    return "\n\n".join(map(_equation, piece.equations))


def _equation(lines: tuple[str, ...]) -> str:
    first, *others = map(_math, lines)
    if not others:
        return f"$$\n{first}\n$$"
    rows = " \\\\\n".join([f"& {first}", *(rf"& \quad {line}" for line in others)])
    return f"$$\n\\begin{{aligned}}\n{rows}\n\\end{{aligned}}\n$$"


def _table(table: PageTable, _: str) -> str:
    rows = [tuple(map(_prose, table.head)), ("---",) * len(table.head), *(tuple(map(_cell, row)) for row in table.rows)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _cell(cell: Cell) -> str:
    return f"${_math(cell.source)}$" if isinstance(cell, Tex) else _text(cell)


def _picture(piece: ReportPicture, name: str) -> str:
    heading = f"## {_text(piece.title)}\n\n" if piece.title else ""
    caption = f"\n\n{_prose(piece.caption)}" if piece.caption else ""
    return f"{heading}![{_text(piece.title or piece.name)}]({file_name(name, piece, _ENDING)}){caption}"


_WRITERS: dict[type, Callable[[Any, str], str]] = {
    Heading: lambda piece, _: f"{'#' * (piece.level + 1)} {_prose(piece.text)}",
    Words: lambda piece, _: _prose(piece.text),
    Formulas: _formulas,
    Listed: lambda piece, _: "\n".join(f"- {_text(item)}" for item in piece.items),
    PageTable: _table,
    ReportPicture: _picture,
    MarkdownText: lambda piece, _: piece.text.strip(),
}
