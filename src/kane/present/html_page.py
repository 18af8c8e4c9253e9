# SPDX-License-Identifier: BSD-3-Clause
"""A report as one self-contained HTML file."""

from collections.abc import Iterable
from importlib.metadata import version
from typing import TYPE_CHECKING

from jinja2 import Template
from markupsafe import Markup

from kane.expr.node import Expr
from kane.motion.solution.solution import Solution
from kane.present.chapters import LONG, by_all_text, operations_text, solved_text
from kane.present.content import Content, run_text
from kane.present.first_screen import screen_of
from kane.present.notes import written
from kane.present.overview import Tex
from kane.present.pages import Document, asset, carried, environment, figure_text, segments
from kane.present.scene.records import Scene
from kane.present.sketch.draw import NARROW, WIDE, draw_each
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
        sketches=_sketches(seen, content.title),
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


def _sketches(seen: Scene, title: str) -> list[Markup]:
    """The sketch for desktop and phone widths; none if the system cannot be drawn."""
    return [Markup(s.svg) for s in draw_each(seen, (WIDE, NARROW), title=title)] if seen.drawable else []


def _template() -> Template:
    page = environment(trim_blocks=True, lstrip_blocks=True)
    page.filters["segments"] = segments
    page.filters["figure"] = figure_text
    page.tests["tex"] = lambda cell: isinstance(cell, Tex)
    return page.get_template("report.html")
