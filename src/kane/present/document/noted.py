# SPDX-License-Identifier: BSD-3-Clause
"""The author's Markdown as pieces of a report: headings, paragraphs, list items and tables; emphasis is dropped."""

from collections.abc import Iterator, Sequence
from typing import Any

from kane.present.document.pieces import Formulas, Heading, MarkdownText, Piece, Words, cell_of
from kane.present.notes import parser
from kane.present.overview import PageTable
from kane.present.pages import plain


def parts_of(note: MarkdownText) -> Iterator[Piece]:
    """The pieces of a note."""
    points: list[str] = []
    rows: list[list[str]] = []
    heading = 0
    for token in parser().parse(note.text):
        kind, inner = token.type, token.children or []
        if kind == "heading_open":
            heading = int(token.tag[1]) - 1  # the parser has lowered it below that of the section
        elif kind in ("bullet_list_open", "ordered_list_open"):
            points.append("1" if kind.startswith("ordered") else "•")
        elif kind in ("bullet_list_close", "ordered_list_close"):
            points.pop()
        elif kind == "tr_open":
            rows.append([])
        elif kind == "table_close":
            head, *others = rows
            yield PageTable("", tuple(head), tuple(tuple(map(cell_of, row)) for row in others))
            rows = []
        elif kind in ("fence", "code_block"):
            yield from (Words(plain(line)) for line in token.content.splitlines())
        elif kind == "inline" and rows:
            rows[-1].append(_sentence(inner))
        elif kind == "inline" and heading:
            yield Heading(heading, _sentence(inner))
            heading = 0
        elif kind == "inline":
            yield from _paragraph(inner, _point(points))


def _point(points: list[str]) -> str:
    """The bullet or the next number of a list item."""
    if not points or points[-1] == "•":
        return "• " if points else ""
    number = int(points[-1])
    points[-1] = str(number + 1)
    return f"{number}. "


def _paragraph(tokens: Sequence[Any], begin: str) -> Iterator[Piece]:
    """Sentences, with displayed formulas between them."""
    told: list[Any] = []
    for token in tokens:
        if token.type == "math" and token.markup == "$$":
            if _sentence(told).strip():
                yield Words(begin + _sentence(told).strip())
            yield Formulas(((token.content,),))
            told, begin = [], ""
        else:
            told.append(token)
    if _sentence(told).strip():
        yield Words(begin + _sentence(told).strip())


def _sentence(tokens: Sequence[Any]) -> str:
    parts = []
    for token in tokens:
        if token.type == "math":
            parts.append(f"${token.content}$")
        else:
            parts.append(" " if token.type in ("softbreak", "hardbreak") else plain(token.content))
    return "".join(parts)
