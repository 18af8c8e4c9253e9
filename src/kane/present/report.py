# SPDX-License-Identifier: BSD-3-Clause
"""`report`: the derivation, and a motion, as one HTML file that needs nothing else."""

import re
from collections.abc import Iterable, Sequence
from functools import cache, partial
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup

from kane.equations.equations import Equations, check_equations
from kane.errors import ArgumentError, cut
from kane.motion.solution.solution import Solution
from kane.present.checks import Check, motion_checks
from kane.present.costs import costs
from kane.present.report_chapters import LONG, chapters
from kane.present.tables import PageTable, Tex, declared_tables
from kane.progress import working
from kane.units.text import unit_text
from kane.whole import exchange, path_of
from kane.write.latex import latex_name

_MARK = b'<meta name="generator" content="kane '
"""By which a report is known."""


def report(
    eom: Equations,
    path: str | Path,
    *,
    solution: Solution | None = None,
    title: str | None = None,
    sources: Sequence[str] = (),
    checks: Iterable[Check] = (),
) -> Path:
    """Write the report of a derivation to `path` and return it; a report that has that name is replaced, nothing else.

    One self-contained HTML file: what was declared, a chapter for each of the seven steps with its formulas and where their terms
    come from, the operations that one evaluation costs, checks with their figures and, with a solution, checks and plots of
    the motion.

    Parameters
    ----------
    eom : Equations
    path : where to write; missing folders are made
    solution : a motion of the same equations
    title : heading; by default the bodies' names
    sources : where the system comes from, a line each
    checks : figures to show, each with its limit

    Raises
    ------
    ArgumentError
        if there are no equations, the solution is one of other equations, or something else than a report has that name
    """
    target = path_of(path, 'kn.report(eom, "report.html")')
    text = page(eom, solution=solution, title=title, sources=sources, checks=checks)
    target.parent.mkdir(parents=True, exist_ok=True)
    exchange(target, partial(Path.write_text, data=text, encoding="utf-8"), lambda p: _MARK in p.read_bytes())
    return target


def page(
    eom: Equations,
    *,
    solution: Solution | None = None,
    title: str | None = None,
    sources: Sequence[str] = (),
    checks: Iterable[Check] = (),
) -> str:
    """The text of the report."""
    check_equations(eom)
    if solution is not None and not isinstance(solution, Solution):
        raise ArgumentError(f"Expected solution= as a motion from kn.simulate, got {cut(repr(solution))}.")
    if solution is not None and solution.equations is not eom:
        raise ArgumentError(
            "Expected a solution of the equations reported, got one of others: pass solution.equations as eom."
        )
    with working("Writing the report"):
        told = list(checks)
        motion = {"checks": told} if solution is None else _motion(solution, told)
        return _template().render(
            title=title or f"Equations of motion: {', '.join(b.name for b in eom.system.bodies)}",
            eom=eom,
            summary=_summary(eom),
            receipt=costs(eom),
            declared=declared_tables(eom, solution.parameters if solution is not None else None),
            chapters=chapters(eom),
            long=LONG,
            solution=solution,
            **motion,
            sources=tuple(sources),
            version=version("kane"),
            katex_css=Markup(asset("katex.min.css")),
            katex_js=Markup(asset("katex.min.js")),
        )


def _template() -> Template:
    loader = PackageLoader("kane.present")
    page = Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    page.filters["segments"] = _segments
    page.filters["figure"] = lambda x: f"{x:.3g}" if 0.1 <= x < 1e4 else f"{x:.1e}"
    page.tests["tex"] = lambda cell: isinstance(cell, Tex)
    return page.get_template("report.html")


def _segments(text: str) -> list[tuple[bool, str]]:
    """Pieces of a sentence, LaTeX between dollar signs marked."""
    return [(i % 2 == 1, piece) for i, piece in enumerate(re.split(r"\$", text)) if piece]


def _summary(eom: Equations) -> list[tuple[int, str]]:
    counts: list[tuple[Sequence[Any], str, str]] = [
        (eom.system.bodies, "body", "bodies"),
        (eom.coordinates, "coordinate", "coordinates"),
        (eom.speeds, "generalized speed", "generalized speeds"),
        (eom.independent_speeds if eom.embedding else (), "degree of freedom", "degrees of freedom"),
        (eom.states, "further state", "further states"),
        (eom.reactions, "reaction", "reactions"),
    ]
    sizes = [(len(some), one if len(some) == 1 else many) for some, one, many in counts if some]
    return [*sizes, (eom.operations.total, "operations")]


def _motion(solution: Solution, told: list[Check]) -> dict[str, Any]:
    """Start and end, plots, and the checks of a motion after those `told`."""
    from kane.present.motion_plots import plots

    eom = solution.equations
    symbols = eom.state
    rows = tuple(
        (Tex(latex_name(s.name)), f"{a:.6g}", f"{b:.6g}", unit_text(eom.unit(s)))
        for s, a, b in zip(symbols, solution.states[0], solution.states[-1], strict=True)
    )
    head = ("", f"t = {solution.t[0]:g} s", f"t = {solution.t[-1]:.6g} s", "unit")
    return {
        "checks": [*told, *motion_checks(solution, told)],
        "start": PageTable("Start and end", head, rows, unfolded=False),
        "plots": [(p, Markup(p.svg)) for p in plots(solution)],
    }


@cache
def asset(name: str) -> str:
    """Text of a file in present/assets."""
    return files("kane.present").joinpath("assets", name).read_text(encoding="utf-8")
