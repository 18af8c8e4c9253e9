# SPDX-License-Identifier: BSD-3-Clause
"""`report`: the derivation, in seven chapters, and a motion, as one HTML file that needs nothing else; with the operation receipt."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Template
from markupsafe import Markup

from kane.dynamics.readings.contributions import Contributions
from kane.dynamics.readings.seven_steps import STATES, Kind, Quantity, Result, Step, moving_places, shown_speeds
from kane.equations.equations import Equations, check_equations
from kane.errors import ArgumentError, cut
from kane.expr.evaluation import count_operations
from kane.expr.node import Expr, postorder
from kane.expr.symbols import Parameter, Symbol, rate
from kane.motion.solution.solution import Solution
from kane.present.check_figures import Check, motion_checks
from kane.present.first_screen import FirstScreen, screen_of
from kane.present.formula_list import DisplayedFormula, formulas, quantity_latex, result_formulas
from kane.present.notes import written
from kane.present.other_methods import is_small, why_kane
from kane.present.overview import DECLARED, PageTable, Tex, declared_tables, page_table
from kane.present.pages import asset, carried, environment
from kane.present.provenance import Provenance, force_provenance, mass_provenance, noncontributing
from kane.present.scene.gather import scene
from kane.present.scene.records import Scene
from kane.present.scene.shapes import BodyShape
from kane.present.sketch.draw import NARROW, WIDE, draw_each
from kane.progress import working
from kane.space.frame import Frame, Point
from kane.units.rules import unit_text
from kane.whole import exchange, path_of
from kane.write.latex import symbol_latex

LONG = 300
"""Formulas longer than this, as text, are folded away."""
_FEW = 12
"""At most as many intermediates are unfolded."""
_WIDE, _HIGH = 9, 16
"""Speeds, and speeds with auxiliary ones, beyond which mass matrix and table of partial velocities are not laid out as such."""
_BRIEF, _SHORT = 7, 60
"""More formulas than this, each shorter than this as text, are set in two columns."""
_MOST = 400
"""Lines of the solution beyond which it is left out."""


@dataclass(frozen=True, slots=True)
class Block:
    """Formulas with the intermediates that they share, and matrix equations, which stand first."""

    between: tuple[DisplayedFormula, ...] = ()
    formulas: tuple[DisplayedFormula, ...] = ()
    displays: tuple[str, ...] = ()

    @property
    def unfolded(self) -> bool:
        """Whether the intermediates are few and short."""
        return len(self.between) <= _FEW and all(len(z.text) <= LONG for z in self.between)

    @property
    def brief(self) -> bool:
        """Whether the formulas are many and short, so that two columns hold them."""
        return len(self.formulas) > _BRIEF and all(len(f.name + f.text) < _SHORT for f in self.formulas)


@dataclass(frozen=True, slots=True)
class Chapter:
    """A step: its formulas, what is better laid out as a table, where terms come from; of step 7 the solution.

    Where constraints make speeds dependent, `by_all_speeds` are the forces and equations of all, behind those of the independent ones.
    """

    number: int
    title: str
    text: str
    block: Block = Block()
    tables: tuple[PageTable, ...] = ()
    solution: Block = Block()
    by_all_speeds: Block = Block()
    note: str = ""
    provenance: Provenance | None = None

    @property
    def formulas(self) -> tuple[DisplayedFormula, ...]:
        """All formulas but those of the solution."""
        return (*self.block.formulas, *self.by_all_speeds.formulas)


def chapters(eom: Equations) -> list[Chapter]:
    """One chapter for each of `eom.steps`."""
    terms = [eom.contributions(s) for s in shown_speeds(eom.derived)] if _surveyable(eom) else []
    return [_chapter(eom, step, terms) for step in eom.steps]


def _surveyable(eom: Equations) -> bool:
    return len(eom.speeds) <= _WIDE and len(shown_speeds(eom.derived)) <= _HIGH


def _chapter(eom: Equations, step: Step, terms: list[Contributions]) -> Chapter:
    if step.number == 1:
        coordinates = page_table("", DECLARED["coordinates"](eom.system), "coordinate", "unit", "meaning")
        return Chapter(step.number, step.title, _prose(eom, step), tables=(coordinates,))
    of_independent = [(q, value) for q, value in step.results if q.kind in _OF_INDEPENDENT]
    of_all = [(q, value) for q, value in step.results if q.kind not in _OF_INDEPENDENT]
    own, others = (of_independent, of_all) if of_independent else (of_all, [])
    block, shown = _block(eom, step.number, own)
    tables = (_ALL, _INDEPENDENT)[: 1 + bool(eom.embedding)] if step.number == 4 and _surveyable(eom) else ()
    solution, note = _solution(eom) if step.number == 7 else (Block(), "")
    note = noncontributing(eom, terms) if step.number == 5 and terms else note
    origins = _PROVENANCE[step.number](eom, terms) if step.number in _PROVENANCE and terms else None
    partials, by_all = tuple(_partials(eom, shown, *parts) for parts in tables), _block(eom, step.number, others)[0]
    prose = _prose(eom, step)
    return Chapter(step.number, step.title, prose, block, partials, solution, by_all, note, origins)


def _block(eom: Equations, number: int, results: Sequence[Result]) -> tuple[Block, Mapping[Quantity, DisplayedFormula]]:
    """The results laid out, and the formula of each."""
    between, written = result_formulas(results, eom.system.inertial)
    shown = dict(zip((quantity for quantity, _ in results), written, strict=True))
    displays: list[str] = []
    apart: set[Kind] = set()
    if number == 4 and _surveyable(eom):
        apart = {*_ALL[1:], *_INDEPENDENT[1:]}
    if number == 7 and len(eom.speeds) <= _WIDE:
        apart = {Kind.MASS, Kind.NONHOLONOMIC_MASS}
        held = r" + A^{T} \lambda" if eom.embedding else ""
        heads = {
            Kind.NONHOLONOMIC_MASS: (r"\tilde M \dot{u}_I = \tilde f, \qquad \tilde M = ", eom.independent_speeds),
            Kind.MASS: (rf"M \dot{{u}} = f{held}, \qquad M = ", eom.speeds),
        }
        kinds = {q.kind for q in shown}
        displays = [head + _matrix(speeds, shown, kind) for kind, (head, speeds) in heads.items() if kind in kinds]
    listed = [f for q, f in shown.items() if q.kind not in apart or (number == 7 and q.place not in set(eom.speeds))]
    return Block(tuple(between), tuple(listed), tuple(displays)), shown


_PROVENANCE: dict[int, Callable[[Equations, list[Contributions]], Provenance | None]] = {
    5: lambda eom, terms: force_provenance(eom, Kind.ACTIVE_FORCE, terms),
    6: lambda eom, terms: force_provenance(eom, Kind.INERTIA_FORCE, terms),
    7: lambda eom, _: mass_provenance(eom),
}

_REACTIONS = "; the auxiliary equations give the reactions"
_PROSE = {
    3: r"$u = Y\dot{q} + z$, chosen so that these velocities become short; solved, $\dot{q} = W u + X$.",
    4: "Angular velocities, velocities, their partial velocities, and accelerations.",
    5: r"$F_r = \sum \mathbf{v}_r \cdot \mathbf{F} + \sum \boldsymbol{\omega}_r \cdot \mathbf{T}$ over all loads.",
    6: r"$F^{*}_r = \sum \mathbf{v}_r \cdot (-m\,\mathbf{a}) + \sum \boldsymbol{\omega}_r \cdot (-\mathbf{I}\cdot"
    r"\boldsymbol{\alpha} - \boldsymbol{\omega}\times\mathbf{I}\cdot\boldsymbol{\omega})$ over all bodies.",
    7: r"$F_r + F^{*}_r = 0$, ordered as $M\dot{u} = f$" + f"{_REACTIONS}.",
}


def _prose(eom: Equations, step: Step) -> str:
    plain = _PROSE.get(step.number, step.text)
    text = _EMBEDDED.get(step.number, plain) if eom.embedding else plain
    text = text if eom.reactions else text.replace(_REACTIONS, "")
    return text + STATES if eom.states and step.number == 7 else text


_EMBEDDED = {
    4: _PROSE[4]
    + r" The constraints $A u + b = 0$ give the dependent speeds, $u_D = A_n u_I + b_n$, and with them the "
    r"nonholonomic partial velocities $\tilde{\mathbf{v}}_r = \mathbf{v}_r + \sum_D \mathbf{v}_D A_{n,Dr}$ of the others.",
    5: _PROSE[5] + r" Of the independent speeds, $\tilde F_r = F_r + \sum_D A_{n,Dr} F_D$ over the dependent ones $D$.",
    7: r"$\tilde F_r + \tilde F^{*}_r = 0$, ordered as $\tilde M\dot{u}_I = \tilde f$, "
    r"or $M\dot{u} = f + A^{T} \lambda$ with $A u + b = 0$"
    f"{_REACTIONS}.",
}
"""Of a system with constraints."""


_ALL = ("Partial angular velocities and partial velocities", Kind.PARTIAL_ANGULAR_VELOCITY, Kind.PARTIAL_VELOCITY)
_OF_INDEPENDENT = (Kind.NONHOLONOMIC_INERTIA_FORCE, Kind.NONHOLONOMIC_MASS, Kind.NONHOLONOMIC_FORCING)
"""What stands before, and apart from, the like of all speeds."""
_INDEPENDENT = (
    "Nonholonomic partial angular velocities and partial velocities",
    Kind.NONHOLONOMIC_PARTIAL_ANGULAR_VELOCITY,
    Kind.NONHOLONOMIC_PARTIAL_VELOCITY,
)


def _partials(
    eom: Equations, shown: Mapping[Quantity, DisplayedFormula], title: str, turn: Kind, shift: Kind
) -> PageTable:
    """Kane's table: a row for each speed, a column for each angular velocity and velocity."""
    frames, points = moving_places(eom.system)
    columns: list[tuple[Kind, Kind, Frame | Point]] = [(Kind.ANGULAR_VELOCITY, turn, f) for f in frames]
    columns += [(Kind.VELOCITY, shift, p) for p in points]
    speeds = shown_speeds(eom.derived) if turn is Kind.PARTIAL_ANGULAR_VELOCITY else eom.independent_speeds
    rows = [
        (Tex(symbol_latex(s)), *(Tex(_right(shown, Quantity(partial, place, s))) for _, partial, place in columns))
        for s in speeds
    ]
    heads = (quantity_latex(Quantity(kind, place), eom.system.inertial) for kind, _, place in columns)
    head = (r"$u_r$", *(f"${latex}_r$" for latex in heads))
    return PageTable(title, head, tuple(rows))


def _matrix(speeds: Sequence[Symbol], shown: Mapping[Quantity, DisplayedFormula], kind: Kind) -> str:
    n = range(len(speeds))
    rows = r" \\[3pt] ".join(
        " & ".join(_right(shown, Quantity(kind, speeds[min(i, j)], speeds[max(i, j)])) for j in n) for i in n
    )
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def _right(shown: Mapping[Quantity, DisplayedFormula], quantity: Quantity) -> str:
    """What is zero has no formula."""
    return shown[quantity].right if quantity in shown else "0"


def _solution(eom: Equations) -> tuple[Block, str]:
    values = zip((*map(rate, eom.speeds), *eom.reactions), (*eom.accelerations, *eom.reaction_values), strict=True)
    between, shown = formulas([(symbol.name, e) for symbol, e in values])
    if len(between) > _MOST:
        return Block(), f"The solution takes {len(between)} intermediates and is left out here."
    return Block(tuple(between), tuple(shown)), ""


# + − × ÷ √ first, then the functions by name
_SIGNS = {"add": "+", "sub": "−", "mul": "×", "div": "÷", "sqrt": "√", "pow": "power"}


@dataclass(frozen=True, slots=True)
class Costs:
    """`lines`: (operation, of parameters alone, with the state, both). `groups`: (results, on their own, added to those above)."""

    lines: tuple[tuple[str, int, int, int], ...]
    total: tuple[int, int, int]
    groups: tuple[tuple[str, int, int], ...]


def costs(eom: Equations) -> Costs:
    """What one evaluation of the right-hand side and the reactions costs."""
    roots = (*eom.right_hand_side, *eom.solved.reactions)
    hoisted = dict(count_operations(_of_parameters(roots)).by_operation)
    counts = dict(eom.operations.by_operation)
    kinds = [(k, hoisted.get(k, 0), counts[k]) for k in dict.fromkeys((*_SIGNS, *counts)) if k in counts]
    lines = tuple((_SIGNS.get(k, k), alone, both - alone, both) for k, alone, both in kinds)
    whole = eom.operations
    return Costs(lines, (whole.parameter, whole.state, whole.total), tuple(_groups(eom, roots)))


def _of_parameters(roots: Iterable[Expr]) -> list[Expr]:
    """The nodes that depend on nothing but parameters."""
    alone: dict[Expr, bool] = {}
    for node in postorder(list(roots)):
        alone[node] = isinstance(node, Parameter) if isinstance(node, Symbol) else all(alone[a] for a in node.args)
    return [node for node, yes in alone.items() if yes]


def _groups(eom: Equations, roots: Iterable[Expr]) -> Iterator[tuple[str, int, int]]:
    """Only nodes that the whole evaluation has count as added, so that the additions sum to its total."""
    whole = set(postorder(list(roots)))
    solved = ((r"$\dot{u}$, solved", eom.solved.accelerations), ("reactions, solved", eom.solved.reactions))
    if eom.operations.total == count_operations(eom.right_hand_side).total:  # u̇ is found by way of the reactions
        solved = solved[::-1]
    parts: tuple[tuple[str, tuple[Expr, ...]], ...] = (
        (r"$\dot{q} = W u + X$", eom.rates),
        ("$M$, the mass matrix", eom.mass_matrix.entries),
        ("$f$, the right side", eom.forcing),
        *solved,
    )
    reached: dict[Expr, None] = {}
    before = 0
    for title, exprs in parts:
        if not exprs:
            continue
        reached.update((node, None) for node in postorder(list(exprs)) if node in whole)
        after = count_operations(list(reached)).total
        yield title, count_operations(list(exprs)).total, after - before
        before = after


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
    shapes: Iterable[BodyShape] = (),
    why: bool | None = None,
    notes: Sequence[Any] = (),
) -> Path:
    """Write the report of a derivation to `path` and return it; a report that has that name is replaced, nothing else.

    One self-contained HTML file: a sketch, what was declared, a chapter for each of the seven steps with its formulas and
    where their terms come from, what other methods would have to solve, the operations that one evaluation costs, checks with their
    figures and, with a solution, checks and plots of the motion.

    Parameters
    ----------
    eom : Equations
    path : where to write; missing folders are made
    solution : a motion of the same equations
    title : heading; by default the bodies' names
    sources : where the system comes from, a line each
    checks : figures to show, each with its limit
    shapes : of bodies, from `kn.figures.shape`, for the sketch
    why : whether there is a chapter on the same system by Lagrange's and by Newton's and Euler's equations; by default where that
        takes no time to speak of
    notes : what else the reader is told, at the end: Markdown as text, with LaTeX between dollar signs; figures of matplotlib;
        Paths of pictures, .svg or .png. HTML in the text is shown as text

    Raises
    ------
    ArgumentError
        if there are no equations, the solution is one of other equations, something else than a report has that name,
        or a note is no text, figure or picture
    """
    target = path_of(path, 'kn.report(eom, "report.html")')
    text = page(
        eom, solution=solution, title=title, sources=sources, checks=checks, shapes=shapes, why=why, notes=notes
    )
    target.parent.mkdir(parents=True, exist_ok=True)
    exchange(target, partial(Path.write_text, data=text, encoding="utf-8"), lambda p: _MARK in p.read_bytes())
    return target


def page(
    eom: Equations,
    *,
    solution: Solution | None,
    title: str | None,
    sources: Sequence[str],
    checks: Iterable[Check],
    shapes: Iterable[BodyShape] = (),
    why: bool | None = None,
    notes: Sequence[Any] = (),
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
        drawn = scene(eom, shapes)
        screen = None if solution is None or not drawn.drawable else screen_of(solution, drawn)
        motion = {"checks": told} if solution is None else _motion(solution, told, screen)
        scripts = ("report", *(("viewer", "engine", "first_screen") if screen else ()))
        head = title or f"Equations of motion: {', '.join(b.name for b in eom.system.bodies)}"
        return _template().render(
            title=head,
            sketches=_sketches(drawn, head),
            screen=screen,
            meanings=[(symbol_latex(q), q.description) for q in eom.coordinates if q.description],
            eom=eom,
            summary=_summary(eom),
            receipt=costs(eom),
            declared=declared_tables(eom, solution.parameters if solution is not None else None),
            chapters=chapters(eom),
            why_kane=why_kane(eom) if (is_small(eom) if why is None else why) else None,
            long=LONG,
            solution=solution,
            **motion,
            notes=written(notes),
            sources=tuple(sources),
            version=version("kane"),
            carried=carried(
                asset("katex.min.css"), asset("katex.min.js"), *(asset(f"{x}.js", "templates") for x in scripts)
            ),
        )


def _sketches(seen: Scene, title: str) -> list[Markup]:
    """The drawing as a desk and as a phone show it; none of a system that has nothing to draw."""
    return [Markup(s.svg) for s in draw_each(seen, (WIDE, NARROW), title=title)] if seen.drawable else []


def _template() -> Template:
    page = environment(trim_blocks=True, lstrip_blocks=True)
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


def _motion(solution: Solution, told: list[Check], screen: FirstScreen | None) -> dict[str, Any]:
    """Start and end, plots of what the first screen does not draw, and the checks of a motion after those `told`."""
    from kane.present.motion_plots import plots

    eom = solution.equations
    drawn = () if screen is None else [q.expr for _, _, lines in screen.plots for _, q in lines]
    symbols = eom.state
    ends = zip(symbols, solution.states[0], solution.states[-1], strict=True)
    rows = tuple((Tex(symbol_latex(s)), f"{a:.6g}", f"{b:.6g}", unit_text(eom.unit(s))) for s, a, b in ends)
    head = ("", f"t = {solution.t[0]:g} s", f"t = {solution.t[-1]:.6g} s", "unit")
    return {
        "checks": [*told, *motion_checks(solution, told)],
        "start": PageTable("Start and end", head, rows, unfolded=False),
        "changes": _changes(solution),
        "plots": [(p, Markup(p.svg)) for p in plots(solution, drawn)],
    }


_SHOWN = 100
"""As many changes of a motion are listed."""
_NO_ENERGY = 1e-9
"""Share of the largest energy below which a change is none."""


def _changes(solution: Solution) -> PageTable | None:
    """When a motion was changed, by which events, what contacts do from then on, and what energy that took; None without changes."""
    begins = solution.begins.tolist()
    if not begins:
        return None
    rows, energies = [], solution.energy
    least = _NO_ENERGY * float(np.abs(energies).max())
    for k in begins[:_SHOWN]:
        by = ", ".join(e.name for e in solution.phases[solution.phase[k]].by)
        pairs = ((name, str(words[k - 1]), str(words[k])) for name, words in solution.modes.items())
        told = ", ".join(f"{name}: {a} → {b}" for name, a, b in pairs if a != b)
        energy = float(energies[k] - energies[k - 1])
        rows.append((f"{solution.t[k]:.9g}", by, told, f"{energy:+.4g}" if abs(energy) > least else "0"))
    if len(begins) > _SHOWN:
        rows.append(("…", f"{len(begins) - _SHOWN} more", "", ""))
    return PageTable("What happens on the way", ("t (s)", "event", "contacts", "energy (J)"), tuple(rows))
