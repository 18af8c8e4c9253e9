# SPDX-License-Identifier: BSD-3-Clause
"""A report as a list of headings, sentences, formulas, tables and figures, in reading order, for formats without collapsible parts.

Its figures are files beside it. Intermediates are numbered consecutively through the report, so that each Z is unique.
"""

import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kane.present import chapters
from kane.present.content import Content, run_text
from kane.present.document.line_breaks import broken_lines, em_width
from kane.present.formula_list import DisplayedFormula
from kane.present.languages.catalogue import tr
from kane.present.notes import Image, title_of
from kane.present.overview import Cell, PageTable, Tex
from kane.present.pages import figure_text, plain, segments
from kane.present.provenance import Provenance
from kane.present.sketch.draw import MARKS, WIDE, draw_each
from kane.present.sketch.draw import save as save_sketch
from kane.whole import FIGURES

if TYPE_CHECKING:
    from kane.present.motion_plots import Plot

_COPIED = b"<!-- A picture in a report of kane -->"
DRAWN = (*MARKS, *FIGURES, _COPIED)
"""Marks by which a figure written by kane is recognized."""


@dataclass(frozen=True, slots=True)
class ReportPicture:
    """A figure: its name within the report, heading, caption (with LaTeX), and the function that writes it in the format of a path.

    A picture that is copied from a file has its `ending`.
    """

    name: str
    title: str
    caption: str
    save: Callable[[Path], object]
    ending: str = ""


def sketch_of(content: Content) -> Iterator[ReportPicture]:
    """The labelled sketch, if the system can be drawn."""
    if content.seen.drawable:
        (drawn,) = draw_each(content.seen, (WIDE,), title=content.title)
        said = "; ".join(f"${symbol}$ {plain(meaning)}" for symbol, meaning in content.meanings)
        yield ReportPicture("sketch", "", said, partial(save_sketch, drawn))


def plots_of(content: Content) -> Iterator[ReportPicture]:
    """The plots of the motion."""
    if content.solution is None:
        return
    from kane.present.motion_plots import plots

    yield from map(printed, plots(content.solution))


def printed(plot: "Plot") -> ReportPicture:
    """A plot in colours for white paper."""
    from kane.present.figure import save
    from kane.present.motion_plots import to_print

    return ReportPicture(plot.name, plot.title, plain(plot.caption), partial(save, to_print(plot.figure)))


def picture_of(note: Any, name: str) -> ReportPicture:
    """A matplotlib figure, or a picture read from a file, among the notes."""
    if isinstance(note, Image):
        return ReportPicture(name, "", "", partial(_copy, note.data), note.ending)
    from kane.present.figure import save

    return ReportPicture(name, "", plain(title_of(note)), partial(save, note))


def _copy(data: bytes, path: Path) -> None:
    """Write a copy of a picture, marked as part of a report."""
    if path.suffix == ".svg":
        path.write_bytes(data.rstrip() + b"\n" + _COPIED + b"\n")
        return
    from PIL import Image as Pixels
    from PIL.PngImagePlugin import PngInfo

    told = PngInfo()
    told.add_text("Software", "kane")
    Pixels.open(io.BytesIO(data)).save(path, pnginfo=told)


def beside(pieces: Iterable[object], report: str, ending: str) -> dict[str, Callable[[Path], object]]:
    """Functions that write the figures among the pieces, by file name."""
    return {file_name(report, p, ending): p.save for p in pieces if isinstance(p, ReportPicture)}


def file_name(report: str, picture: ReportPicture, ending: str) -> str:
    """The file name of a figure beside a report, in characters that LaTeX and URLs accept."""
    return f"{re.sub(r'[^A-Za-z0-9.-]+', '-', report)}-{picture.name}{picture.ending or ending}"


WIDTH = 46.0
"""Width of a line of formulas, in em: a sheet of A4 at 10 pt, and GitHub's column."""
_HANG = 2.0
_SHRUNK = 1.3
"""Ratio to the line width above which a matrix is written entry by entry."""
_LONG = 80
"""Number of lines above which formulas in all speeds, and origins of terms, are omitted; HTML has them collapsed."""


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; chapters have level 1."""

    level: int
    text: str


@dataclass(frozen=True, slots=True)
class Words:
    """A paragraph, with LaTeX between dollar signs."""

    text: str


@dataclass(frozen=True, slots=True)
class Formulas:
    """Equations in LaTeX, each as its lines."""

    equations: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Listed:
    """A list of plain sentences."""

    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MarkdownText:
    """The author's Markdown, with LaTeX between dollar signs."""

    text: str


Piece = Heading | Words | Formulas | Listed | PageTable | ReportPicture | MarkdownText
_Rename = Callable[[str], str]


def pieces(content: Content) -> Iterator[Piece]:
    """All pieces of a report except its title."""
    yield Words(", ".join(tr("%(n)s %(what)s", n=n, what=what) for n, what in content.summary) + ".")
    if content.mode:
        yield Words(content.mode)
    yield from sketch_of(content)
    yield Heading(1, tr("The system"))
    for table in content.declared:
        yield from _table(table)
    parts = [part for c in content.chapters for part in _blocks(c)]
    eom = content.eom
    named = (*eom.parameters, *eom.state, *eom.inputs, *eom.reactions, *eom.all_speeds)
    taken = any(re.fullmatch(r"Z\d+", s.name) for s in named)  # then intermediates are not renumbered
    starts = accumulate((0 if taken or _length(p) > most else len(p.between) for p, most in parts), initial=0)
    renames = map(_renamed, (part for part, _ in parts), starts)
    for chapter in content.chapters:
        yield from _chapter(content, chapter, [next(renames) for _ in _blocks(chapter)])
    yield from _other_methods(content)
    yield from _operations(content)
    if content.checks:
        yield Heading(1, tr("Checks"))
        yield _checks(content)
    if content.solution is not None:
        yield from _motion(content)
    for section in content.sections:
        yield from _section(section)
    if content.notes:
        yield Heading(1, tr("Notes"))
        for k, note in enumerate(content.notes, 1):
            yield MarkdownText(note) if isinstance(note, str) else picture_of(note, f"note{k}")
    if content.sources:
        yield Heading(1, tr("Sources"))
        yield Listed(content.sources)


def _blocks(chapter: chapters.Chapter) -> tuple[tuple[chapters.FormulaBlock | Provenance, float], ...]:
    """The parts of a chapter with their own numbering of intermediates, and the number of lines above which each is omitted."""
    folded = chapter.by_all_speeds, chapter.provenance or chapters.FormulaBlock()
    return (chapter.block, math.inf), (chapter.solution, math.inf), *((part, _LONG) for part in folded)


def _length(part: chapters.FormulaBlock | Provenance) -> int:
    rows = (
        part.formulas
        if isinstance(part, chapters.FormulaBlock)
        else [row for o in part.origins for row in o.table.rows]
    )
    return len(part.between) + len(rows)


def _renamed(part: chapters.FormulaBlock | Provenance, start: int) -> _Rename:
    """A function that shifts the numbers of a part's intermediates in LaTeX."""
    own = {z.left for z in part.between}
    return lambda latex: re.sub(
        r"(?<![A-Za-z\\])Z_\{(\d+)\}", lambda m: f"Z_{{{int(m[1]) + start}}}" if m[0] in own else m[0], latex
    )


def _chapter(content: Content, chapter: chapters.Chapter, renames: Sequence[_Rename]) -> Iterator[Piece]:
    own, solved, every, origins = renames
    eom = content.eom
    yield Heading(1, f"{chapter.number}. {chapter.title}")
    yield Words(chapter.text)
    yield from _block(chapter.block, own)
    for table in chapter.tables:
        yield from _table(table, own)
    if chapter.solution.formulas:
        yield Heading(2, chapters.solved_text(bool(eom.reactions)))
        yield from _block(chapter.solution, solved)
    if chapter.by_all_speeds.formulas:
        yield Heading(2, chapters.by_all_text(chapter.number))
        yield from _unless_long(_length(chapter.by_all_speeds), _block(chapter.by_all_speeds, every))
    if chapter.note:
        yield Words(plain(chapter.note))
    if chapter.provenance is not None:
        told = chapter.provenance
        yield Heading(2, told.title)
        yield from _unless_long(_length(told), _provenance(told, origins))


def _unless_long(count: int, some: Iterable[Piece]) -> Iterator[Piece]:
    if count > _LONG:
        yield Words(tr("The %(n)s lines are left out here; the HTML report has them.", n=count))
    else:
        yield from some


def _provenance(told: Provenance, rename: _Rename) -> Iterator[Piece]:
    yield from _equations(told.between, rename)
    for o in told.origins:
        idle = f" {plain(o.idle)}" if o.idle else ""
        yield Words(f"${o.left}$: {o.count}.{idle}")
        if o.table.rows:
            yield from _table(o.table, rename)


def _block(block: chapters.FormulaBlock, rename: _Rename) -> Iterator[Piece]:
    if block.between and block.formulas:
        yield Words(tr("With the shared intermediates"))
    yield from _equations(block.between, rename)
    for display in block.displays:
        yield from _display(display, rename)
    yield from _equations(block.formulas, rename)


def _display(display: chapters.MatrixEquation, rename: _Rename) -> Iterator[Piece]:
    """A matrix, or its entries if it is much too wide."""
    latex = rename(display.latex)
    if em_width(latex) <= _SHRUNK * WIDTH:
        yield Formulas(((latex,),))
        return
    equation = display.head.partition(r", \qquad")[0]
    yield Words(tr("$%(equation)s$, with the entries on and above the diagonal that are not zero:", equation=equation))
    yield from _equations(display.entries, rename)


def _equations(shown: Sequence[DisplayedFormula], rename: _Rename) -> Iterator[Formulas]:
    if shown:
        yield Formulas(tuple(tuple(broken_lines(rename(f.latex), WIDTH, _HANG)) for f in shown))


def _table(table: PageTable, rename: _Rename = str) -> Iterator[Piece]:
    """A table under its title; nothing for a table without rows."""
    if not table.rows:
        return
    if table.title:
        yield Heading(2, table.title)
    cells: Callable[[Cell], Cell] = lambda cell: Tex(rename(cell.source)) if isinstance(cell, Tex) else cell  # noqa: E731
    yield replace(table, title="", rows=tuple(tuple(map(cells, row)) for row in table.rows))


def _other_methods(content: Content) -> Iterator[Piece]:
    others = content.other_methods
    if others is not None:
        yield Heading(1, tr("Why Kane's method"))
        yield Words(others.text)
        yield others.table
        yield from map(Words, others.found)
        yield Words(plain(others.note))


def _section(section: chapters.Section) -> Iterator[Piece]:
    yield Heading(1, section.title)
    for part in section.parts:
        if isinstance(part, PageTable):
            yield from _table(part)
        else:
            yield Formulas(((part.source,),)) if isinstance(part, Tex) else Words(part)
    yield from map(printed, section.plots)


def _operations(content: Content) -> Iterator[Piece]:
    receipt = content.receipt
    yield Heading(1, tr("Operations"))
    yield Words(chapters.operations_text(bool(content.eom.reactions)))
    rows = [(kind, *(str(n or "–") for n in counts)) for kind, *counts in receipt.lines]
    total = (tr("total"), *map(str, receipt.total))
    head = tr("operation"), tr("parameters"), tr("state"), tr("both")
    yield PageTable("", head, (*rows, total))
    groups = [(cell_of(what), str(alone), str(added)) for what, alone, added in receipt.groups]
    head_of_groups = tr("result"), tr("on its own"), tr("added to those above")
    yield PageTable("", head_of_groups, (*groups, (tr("total"), "", str(receipt.total[2]))))


def cell_of(sentence: str) -> Cell:
    """A sentence with LaTeX between dollar signs as a table cell."""
    told = segments(sentence)
    if not any(formula for formula, _ in told):
        return "".join(piece for _, piece in told)
    return Tex("".join(piece if formula else rf"\text{{{piece}}}" for formula, piece in told))


def _checks(content: Content) -> PageTable:
    rows = tuple(
        (
            f"{check.name}: {check.detail}" if check.detail else check.name,
            figure_text(check.figure),
            f"{check.limit:.0e}",
            tr("passed") if check.passed else tr("failed"),
        )
        for check in content.checks
    )
    return PageTable("", (tr("check"), tr("figure"), tr("limit"), tr("result")), rows)


def _motion(content: Content) -> Iterator[Piece]:
    sol = content.solution
    assert sol is not None
    yield Heading(1, tr("Motion"))
    yield Words(run_text(sol))
    for table in content.tables:
        yield from _table(table)
    yield from plots_of(content)
