# SPDX-License-Identifier: BSD-3-Clause
"""`report`: the derivation, in seven chapters, and a motion, as HTML, LaTeX or Markdown; with the operation receipt."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from kane.analysis.linear import Linear
from kane.analysis.solution_branches import Branch
from kane.equations.equations import Equations
from kane.errors import ArgumentError, alike, cut
from kane.motion.solution.solution import Solution
from kane.present.check_figures import Check
from kane.present.content import Content, content_of
from kane.present.document.latex_file import latex
from kane.present.document.markdown import markdown
from kane.present.document.pictures import DRAWN
from kane.present.html_page import html
from kane.present.languages.catalogue import checked, spoken
from kane.present.pages import Document
from kane.present.scene.shapes import BodyShape
from kane.progress import working
from kane.whole import exchange_marked, path_of


@dataclass(frozen=True, slots=True)
class Format:
    """The endings of its files, its writer from content and the file's name, and what a report in it is known by."""

    endings: tuple[str, ...]
    write: Callable[[Content, str], Document]
    mark: bytes


FORMATS = {
    "html": Format((".html", ".htm"), html, b'<meta name="generator" content="kane '),
    "latex": Format((".tex",), latex, b"% A report of kane "),
    "markdown": Format((".md", ".markdown"), markdown, b"<!-- A report of kane "),
}
"""HTML comes first: it is what a path without an ending gets."""


def report(
    eom: Equations,
    path: str | Path,
    *,
    format: str | None = None,
    solution: Solution | None = None,
    title: str | None = None,
    sources: Sequence[str] = (),
    checks: Iterable[Check] = (),
    shapes: Iterable[BodyShape] = (),
    why: bool | None = None,
    linearization: Linear | None = None,
    root_locus: Branch | None = None,
    notes: Sequence[Any] = (),
    language: str = "en",
) -> Path:
    """Write the report of a derivation to `path` and return it; a report that has that name is replaced, nothing else.

    A sketch, what was declared, a chapter for each of the seven steps with its formulas and where their terms come from, what
    other methods would have to solve, the operations that one evaluation costs, checks with their figures and, with
    a solution, checks and plots of the motion. HTML is one self-contained file; beside LaTeX and Markdown lie their
    figures, whose names begin with that of the report.

    Parameters
    ----------
    eom : Equations
    path : where to write, .html, .tex or .md; missing folders are made
    format : "html", "latex" or "markdown"; by default what the path's ending says, without one HTML
    solution : a motion of the same equations
    title : heading; by default the bodies' names
    sources : where the system comes from, a line each
    checks : figures to show, each with its limit
    shapes : of bodies, from `kn.figures.shape`, for the sketch
    why : whether there is a chapter on the same system by Lagrange's and by Newton's and Euler's equations; by default where that
        takes no time to speak of
    linearization : from `kn.linearize`, for chapters on its operating point with the reactions there, its matrices and its eigenvalues
    root_locus : from `kn.analysis.continuation`, for a chapter on its eigenvalues as the value changes
    notes : what else the reader is told, at the end: Markdown as text, with LaTeX between dollar signs; figures of matplotlib;
        Paths of pictures, .svg or .png. HTML in the text is shown as text
    language : "en" or "ko", of all texts but what is given; LaTeX is written in English alone

    Raises
    ------
    ArgumentError
        if there are no equations, the solution, linearization or branch is one of other equations, format or language is none of
        these, something else than a report, or a figure of one, has that name, or a note is no text, figure or picture
    """
    target = path_of(path, 'kn.report(eom, "report.html")')
    form = FORMATS[format_of(target, format)]
    written = document(
        eom, target, format, language=language, solution=solution, title=title, sources=sources, checks=checks, shapes=shapes,
        why=why, linearization=linearization, root_locus=root_locus, notes=notes,
    )  # fmt: skip
    for name, save in written.beside.items():
        exchange_marked(target.with_name(name), save, *DRAWN)
    exchange_marked(target, partial(Path.write_text, data=written.text, encoding="utf-8"), form.mark)
    return target


def format_of(path: Path, format: str | None = None) -> str:
    """The name of a format, given or by the path's ending."""
    if format is not None:
        if format not in FORMATS:
            known = ", ".join(map(repr, FORMATS))
            raise ArgumentError(
                f"Expected format= as one of {known}, got {cut(repr(format))}.{alike(str(format), FORMATS)}"
            )
        return format
    ending = path.suffix.lower()
    result = next((name for name, form in FORMATS.items() if ending in form.endings), None if ending else "html")
    if result is None:
        endings = ", ".join(e for form in FORMATS.values() for e in form.endings)
        raise ArgumentError(
            f"Expected a file for the report that ends in {endings}, got {str(path)!r}. Or say format=."
        )
    return result


def spoken_in(format: str, language: str) -> None:
    """Refuse a language that reports are not written in, or not in this format: Korean in LaTeX takes another engine."""
    if checked(language) != "en" and format == "latex":
        raise ArgumentError(f'Expected language="en" for LaTeX, got {language!r}. Write the report as .html or .md.')


def document(eom: Equations, path: Path, format: str | None = None, *, language: str = "en", **told: Any) -> Document:
    """The text of the report for a path, and the figures beside it; `told` is what else `report` takes."""
    form = format_of(path, format)
    write = FORMATS[form].write
    spoken_in(form, language)
    with working("Writing the report"), spoken(language):
        return write(content_of(eom, **told), path.stem)
