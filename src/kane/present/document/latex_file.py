# SPDX-License-Identifier: BSD-3-Clause
"""A report as one LaTeX file, in ASCII for pdflatex with its default fonts, with its figures beside it as PDF."""

import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from typing import Any

from kane.errors import ArgumentError
from kane.present.content import Content
from kane.present.document.line_breaks import broken_lines, em_width
from kane.present.document.pieces import (
    WIDTH,
    Formulas,
    Heading,
    Listed,
    MarkdownText,
    Piece,
    ReportPicture,
    Words,
    beside,
    cell_of,
    file_name,
    pieces,
)
from kane.present.notes import parser
from kane.present.overview import Cell, PageTable, Tex
from kane.present.pages import Document, environment, plain, segments

_SPECIAL = {c: "\\" + c for c in "#$%&{}_"} | {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$", "|": "$|$", '"': "''",
}  # fmt: skip
_SIGNS = {
    "−": "-", "×": r"\times ", "÷": r"\div ", "√": r"\surd ", "≤": r"\le ", "≥": r"\ge ", "≠": r"\ne ", "→": r"\to ", "∫": r"\int ",
    "·": r"\cdot ", "⋅": r"\cdot ", "°": r"^{\circ}", "∂": r"\partial ", "∞": r"\infty ", "≈": r"\approx ", "±": r"\pm ", "∈": r"\in ",
    "○": r"\circ ",
    "●": r"\bullet ", "•": r"\bullet ", "′": "'", "∑": r"\sum ", "∆": r"\Delta ", "↦": r"\mapsto ", "‖": r"\| ",
}  # fmt: skip
"""Commands in formulas."""
_WRITTEN = {
    "–": "--", "—": "---", "…": r"\dots{}", "‘": "`", "’": "'", "“": "``", "”": "''", "„": ",,", "\u00a0": "~", "ß": r"\ss{}",
    "æ": r"\ae{}", "Æ": r"\AE{}", "ø": r"\o{}", "Ø": r"\O{}", "å": r"\aa{}", "Å": r"\AA{}", "ł": r"\l{}", "Ł": r"\L{}", "œ": r"\oe{}",
    "§": r"\S{}", "ı": r"\i{}", "\u200b": "",
}  # fmt: skip
"""Commands in text."""
_ACCENTS = {
    "\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u", "\u0307": ".",
    "\u0308": '"', "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0327": "c",
}  # fmt: skip
_RAISED = {"<super>": "^", "<sub>": "_"}
_CAPITALS = {"Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"}
_BEYOND = re.compile(r"[^\x00-\x7f]")


def text_latex(plain: str) -> str:
    """Plain text as LaTeX."""
    letters: list[str] = []
    # accents are separated from their letters, except letters with their own command
    for c in "".join(c if c in _WRITTEN else unicodedata.normalize("NFD", c) for c in plain):
        if c in _ACCENTS and letters:
            letters.append(rf"\{_ACCENTS[c]}{{{letters.pop()}}}")
        else:
            letters.append(_SPECIAL.get(c) or _WRITTEN.get(c) or (c if c < "\x7f" else _written(c)))
    return "".join(letters).replace("$$", "")


def prose(sentence: str) -> str:
    """Text with formulas between dollar signs as LaTeX."""
    return "".join(f"${math_latex(piece)}$" if formula else text_latex(piece) for formula, piece in segments(sentence))


def math_latex(latex: str) -> str:
    """A formula as LaTeX in ASCII."""
    return _BEYOND.sub(lambda m: _sign(m[0]) or rf"\text{{{text_latex(m[0])}}}", latex)


def _written(c: str) -> str:
    sign = _sign(c)
    plain = unicodedata.normalize("NFKD", c).replace("\u2044", "/").encode("ascii", "ignore").decode()
    return f"${sign}$" if sign else plain or f"[U+{ord(c):04X}]"


def _sign(c: str) -> str:
    """LaTeX of a sign, a Greek letter, a superscript or subscript character; "" for others."""
    if c in _SIGNS:
        return _SIGNS[c]
    kind, _, code = unicodedata.decomposition(c).partition(" ")
    if kind in _RAISED:
        return f"{_RAISED[kind]}{{{math_latex(''.join(chr(int(x, 16)) for x in code.split()))}}}"
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(c, ""))
    if greek is None:
        return ""
    name = greek[2].lower().replace("lamda", "lambda")
    if greek[1] == "CAPITAL":
        return rf"\{name.title()} " if name.title() in _CAPITALS else rf"\mathrm{{{name[0].upper()}}}"
    return "o" if name == "omicron" else r"\varsigma " if name == "final" else rf"\{name} "


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


_ENDING = ".pdf"
_SURE = 0.93
"""Estimated width, as a fraction of the line, above which LaTeX measures a line."""
_GAP = 1.25
"""Space between columns, in em."""
_LEAST = 5.0
"""Least width of a column, in em, of a table that is wider than the page."""
_LETTER = 0.5
_OFTEN = 1.6
"""Ratio of the width of formulas to that of their column above which they are not broken."""
_HANG = r"\quad "
_LARGE = r"\displaystyle "
_TOGETHER = 6
"""Largest number of lines of a row that are kept on one page."""
_LAST = r"\\* \hline"
"""The end of the last row, which prevents a page break before the rule."""


def latex(content: Content, name: str) -> Document:
    """The file, with its figures, whose names begin with `name`."""
    told = list(pieces(content))
    for piece in told:
        if isinstance(piece, ReportPicture) and piece.ending == ".svg":
            raise ArgumentError(
                "Expected notes= without .svg files for LaTeX, which cannot include them. Give them as .png."
            )
    body = "\n\n".join(_WRITERS[type(piece)](piece, name) for piece in told)
    frame = environment(
        autoescape=False, variable_start_string="<<", variable_end_string=">>", comment_start_string="<#"
    )
    title = text_latex(content.title)
    page = frame.get_template("report.tex").render(
        title=title, pdf_title=re.sub(r"[^\w .,:;()'-]", "", content.title), body=body, version=version("kane")
    )
    return Document(page + "\n", beside(told, name, _ENDING))


def _heading(piece: Heading, _: str) -> str:
    title = prose(piece.text)
    if "$" in title:
        plain = re.sub(r"\$[^$]*\$", "the accelerations", piece.text)
        title = rf"\texorpdfstring{{{title}}}{{{text_latex(plain)}}}"
    return r"\room" + "\\" + "sub" * (piece.level - 1) + f"section{{{title}}}"


def _formulas(piece: Formulas, _: str) -> str:
    rows = [
        "  & " + _fitted(math_latex((_HANG if k else "") + line))
        for equation in piece.equations
        for k, line in enumerate(equation)
    ]
    return "\\closer\n\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"


def _fitted(line: str) -> str:
    return line if em_width(line) < _SURE * WIDTH else rf"\fit{{{line}}}"


def _listed(piece: Listed, _: str) -> str:
    return "\n".join([r"\begin{itemize}", *(rf"  \item {text_latex(item)}" for item in piece.items), r"\end{itemize}"])


def _picture(piece: ReportPicture, name: str) -> str:
    source = file_name(name, piece, _ENDING)
    title = rf"\room\subsection{{{text_latex(piece.title)}}}" + "\n\n" if piece.title else ""
    width = "" if piece.name == "sketch" else "0.75"  # plots have a fixed width
    shown = rf"\includegraphics[width={width}\linewidth,height=0.8\textheight,keepaspectratio]{{{source}}}"
    caption = rf"\par\small {prose(piece.caption)}" if piece.caption else ""
    return f"{title}\\begin{{center}}\n{shown}{caption}\n\\end{{center}}"


# Tables -------------------------------------------------------------------------------------------------


def _table(table: PageTable, _: str) -> str:
    """A table with columns of natural width; if it is wider than the page, the widest columns share the remaining width.

    If formulas would be broken too often, each row is set as several lines, one for each column.
    """
    natural = [max(map(_width, column)) for column in zip(table.head, *table.rows, strict=True)]
    room = WIDTH - _GAP * (len(natural) - 1)
    widths = _shared(natural, room)
    formulas = [i for i in range(len(widths)) if any(isinstance(row[i], Tex) for row in table.rows)]
    if any(natural[i] > _OFTEN * widths[i] for i in formulas):
        return _stacked(table)
    broken = [None if w >= n else w for w, n in zip(widths, natural, strict=True)]
    heads = " & ".join(prose(h) for h in table.head)
    rows = [" & ".join(_cell(c, w) for c, w in zip(row, broken, strict=True)) for row in table.rows]
    lines = [rf"\hline {heads} \\ \hline \endhead", *(rf"{row} \\" for row in rows[:-1]), rf"{rows[-1]} {_LAST}"]
    return _framed("".join(map(_column, broken)), lines)


def _stacked(table: PageTable) -> str:
    """A line for each column of a row, without columns that are empty or zero."""
    wide = WIDTH - _GAP - max(map(_width, table.head))
    lines = [r"\hline \endhead"]
    for row in table.rows:
        told = [(h, c) for h, c in zip(table.head, row, strict=True) if c not in ("", Tex("0"))]
        end = r"\\*" if len(told) <= _TOGETHER else r"\\"
        lines += [f"{prose(h)} & {_cell(c, wide, _LARGE)} {end}" for h, c in told[:-1]]
        lines += [f"{prose(h)} & {_cell(c, wide, _LARGE)} {_LAST}" for h, c in told[-1:]]
    if any(Tex("0") in row for row in table.rows):
        lines.append(r"\multicolumn{2}{@{}l@{}}{What is zero is left out.} \\")
    return _framed(_column(None) + _column(wide), lines)


def _framed(columns: str, lines: list[str]) -> str:
    return "\n".join([rf"\begin{{longtable}}{{@{{}}{columns}@{{}}}}", *lines, r"\end{longtable}"])


def _column(width: float | None) -> str:
    return "l" if width is None else rf">{{\raggedright\arraybackslash}}p{{{width:.1f}em}}"


def _shared(natural: list[float], room: float) -> list[float]:
    """Widths of columns, beginning with the narrowest: their natural width, but at most an equal share of the remaining width."""
    given: dict[int, float] = {}
    order = sorted(range(len(natural)), key=lambda i: natural[i])
    for k, i in enumerate(order):
        left = room - sum(given.values())
        given[i] = min(natural[i], max(_LEAST, left / (len(order) - k)))
    return [given[i] for i in range(len(natural))]


def _width(cell: Cell) -> float:
    if isinstance(cell, Tex):
        return em_width(cell.source)
    return _LETTER + sum(em_width(piece) if formula else _LETTER * len(piece) for formula, piece in segments(cell))


def _cell(cell: Cell, width: float | None, style: str = "") -> str:
    if not isinstance(cell, Tex):
        return _figure(cell) or text_latex(cell)
    if width is None:
        return f"${math_latex(cell.source)}$"
    return r" \newline ".join(rf"\fitcell{{{style}{math_latex(line)}}}" for line in broken_lines(cell.source, width))


def _figure(cell: str) -> str:
    """A number, with the minus sign and power of ten of formulas; "" for other text."""
    found = re.fullmatch(r"([-+]?[\d.]+)(?:e([-+]?\d+))?", cell)
    if found is None:
        return ""
    mantissa, power = found.groups()
    return f"${mantissa}$" if power is None else rf"${mantissa} \cdot 10^{{{int(power)}}}$"


_WRITERS: dict[type, Callable[[Any, str], str]] = {
    Heading: _heading,
    Words: lambda piece, _: prose(piece.text),
    Formulas: _formulas,
    Listed: _listed,
    PageTable: _table,
    ReportPicture: _picture,
    MarkdownText: lambda piece, name: "\n\n".join(_WRITERS[type(p)](p, name) for p in parts_of(piece)),
}
