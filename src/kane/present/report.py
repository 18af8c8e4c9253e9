# SPDX-License-Identifier: BSD-3-Clause
"""`report`: the derivation in seven chapters, and a motion, as HTML, LaTeX or Markdown, with operation counts."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Template
from markupsafe import Markup

from kane.analysis.linear import Linear
from kane.analysis.solution_branches import Branch
from kane.equations.equations import Equations
from kane.errors import ArgumentError, alike, cut
from kane.expr.node import Expr
from kane.motion.solution.solution import Solution
from kane.present.chapters import LONG, by_all_text, operations_text, solved_text
from kane.present.check_figures import Check
from kane.present.content import Content, content_of, run_text
from kane.present.document.latex_file import latex
from kane.present.document.markdown import markdown
from kane.present.document.pieces import DRAWN
from kane.present.first_screen import screen_of
from kane.present.languages.catalogue import checked, spoken
from kane.present.notes import written
from kane.present.overview import Tex
from kane.present.pages import Document, asset, carried, environment, figure_text, segments
from kane.present.scene.shapes import BodyShape
from kane.present.sketch.draw import NARROW, WIDE, draw_each
from kane.progress import working
from kane.whole import exchange_marked, path_of
from kane.write.latex import symbol_latex

if TYPE_CHECKING:
    from kane.present.motion_plots import Plot


def html(content: Content, name: str) -> Document:
    """The page; the file's name is not used."""
    solution, seen = content.solution, content.seen
    screen = None if solution is None or not seen.drawable else screen_of(solution, content.moving)
    drawn = () if screen is None else [q.expr for _, _, lines in screen.plots for _, q in lines]
    scripts = ("report", "symbols", *(("viewer", "engine", "first_screen") if screen else ()))
    text = _template().render(
        {name: getattr(content, name) for name in content.__slots__},
        sketches=[Markup(s.svg) for s in draw_each(seen, (WIDE, NARROW), title=content.title)] if seen.drawable else [],
        screen=screen,
        shown_notes=list(map(written, content.notes)),
        texts={
            "solved": solved_text(bool(content.eom.reactions)),
            "operations": operations_text(bool(content.eom.reactions)),
            "run": None if solution is None else run_text(solution),
        },
        by_all_text=by_all_text,
        meanings=content.meanings,
        symbols=[(s.name, symbol_latex(s)) for s in content.symbols],
        long=LONG,
        plots=[] if solution is None else _plots(solution, drawn),
        drawn=_drawn,
        version=version("kane"),
        carried=carried(
            asset("katex.min.css"), asset("katex.min.js"), *(asset(f"{x}.js", "templates") for x in scripts)
        ),
    )
    return Document(text)


def _plots(solution: Solution, drawn: Iterable[Expr]) -> "list[tuple[Plot, Markup]]":
    """Plots of quantities that the first screen does not show."""
    from kane.present.motion_plots import plots

    return _drawn(plots(solution, drawn))


def _drawn(some: "Iterable[Plot]") -> "list[tuple[Plot, Markup]]":
    return [(p, Markup(p.svg)) for p in some]


def _template() -> Template:
    page = environment(trim_blocks=True, lstrip_blocks=True)
    page.filters["segments"] = segments
    page.filters["figure"] = figure_text
    page.tests["tex"] = lambda cell: isinstance(cell, Tex)
    return page.get_template("report.html")


@dataclass(frozen=True, slots=True)
class Format:
    """A format: its file endings, its writer from content and the file's name, and the mark by which its reports are recognized."""

    endings: tuple[str, ...]
    write: Callable[[Content, str], Document]
    mark: bytes


FORMATS = {
    "html": Format((".html", ".htm"), html, b'<meta name="generator" content="kane '),
    "latex": Format((".tex",), latex, b"% A report of kane "),
    "markdown": Format((".md", ".markdown"), markdown, b"<!-- A report of kane "),
}
"""The first, HTML, is the default for a path without an ending."""


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
    """Write a report of a derivation to `path`, and return the path; an existing file is replaced if it is a report.

    It contains a sketch, the declarations, a chapter for each of the seven steps with its formulas and the origin of their terms, a
    comparison with other methods, numbers of operations, checks with their results and, with a solution, checks and plots of the
    motion. HTML is one self-contained file; LaTeX and Markdown have their figures in files beside, with the name of the report as
    prefix.

    Parameters
    ----------
    eom : Equations
    path : file to write, .html, .tex or .md; missing folders are created
    format : "html", "latex" or "markdown"; by default by the ending of the path, or HTML without an ending
    solution : a motion of the same equations, from `kn.simulate`
    title : heading; by default the names of the bodies
    sources : references for the system, one line each
    checks : `kn.figures.Check` records to show, each with its limit
    shapes : shapes of bodies for the sketch, from `kn.figures.shape`
    why : whether to include a chapter on the same system by Lagrange's and by the Newton–Euler equations; by default if this takes
        little time
    linearization : a result of `kn.linearize`, for chapters on the operating point with its reactions, the matrices and eigenvalues
    root_locus : a result of `kn.analysis.continuation`, for a chapter on the eigenvalues along the branch
    notes : additional content at the end: strings in Markdown, with LaTeX between dollar signs; matplotlib figures; Paths of
        pictures, .svg or .png. HTML in strings is shown as plain text
    language : "en" or "ko", for all texts but the given ones; LaTeX is available in English alone

    Raises
    ------
    ArgumentError
        if `eom` is not Equations; if the solution, linearization or branch belongs to different equations; if format or language is
        unknown; if the path is that of a different kind of file; or if a note is not a string, figure or picture
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
    """The name of a format, given explicitly or by the path's ending."""
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
    """Raise ArgumentError for a language without reports, or without reports in this format: Korean in LaTeX needs another engine."""
    if checked(language) != "en" and format == "latex":
        raise ArgumentError(f'Expected language="en" for LaTeX, got {language!r}. Write the report as .html or .md.')


def document(eom: Equations, path: Path, format: str | None = None, *, language: str = "en", **told: Any) -> Document:
    """The text of the report for a path, and the figures beside it; `told` are the other arguments of `report`."""
    form = format_of(path, format)
    write = FORMATS[form].write
    spoken_in(form, language)
    with working("Writing the report"), spoken(language):
        return write(content_of(eom, **told), path.stem)
