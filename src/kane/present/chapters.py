# SPDX-License-Identifier: BSD-3-Clause
"""Chapters of a report, independent of the format: sections of sentences, formulas, tables, figures; the seven steps, and counts."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kane.dynamics.readings.contributions import Contributions
from kane.dynamics.readings.seven_steps import Kind, Quantity, Result, Step, moving_frames_and_points, shown_speeds
from kane.equations.equations import Equations
from kane.expr.evaluation import count_operations
from kane.expr.node import Expr, postorder
from kane.expr.symbols import Parameter, Symbol, rate
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED
from kane.present.formula_list import DisplayedFormula, formulas, quantity_latex, result_formulas
from kane.present.languages.catalogue import N_, tr
from kane.present.overview import DECLARED, PageTable, Tex, page_table
from kane.present.provenance import Provenance, force_provenance, mass_provenance, noncontributing
from kane.space.frame import Frame, Point
from kane.write.latex import latex_name, symbol_latex

if TYPE_CHECKING:
    from kane.present.motion_plots import Plot

Part = str | Tex | PageTable
"""A sentence with LaTeX between dollar signs, a displayed formula, or a table."""


@dataclass(frozen=True, slots=True)
class Section:
    """A chapter: its anchor name, its title, its parts in reading order, and figures after them."""

    name: str
    title: str
    parts: tuple[Part, ...]
    plots: "tuple[Plot, ...]" = ()


_NEXT = r" \\ "


def number(x: float, digits: int = 5) -> str:
    """LaTeX of a number."""
    mantissa, e, power = f"{x + 0.0:.{digits}g}".partition("e")
    return rf"{mantissa} \cdot 10^{{{int(power)}}}" if e else mantissa


def matrix(a: Array) -> str:
    """LaTeX of a matrix of numbers; entries within rounding of zero beside the largest are written as zero."""
    least = ROUNDED * np.abs(a).max(initial=0.0)
    rows = (" & ".join(number(x if abs(x) > least else 0.0) for x in row) for row in a.tolist())
    return rf"\begin{{bmatrix}} {_NEXT.join(rows)} \end{{bmatrix}}"


def latex_of(eom: Equations, names: Sequence[str]) -> list[str]:
    """LaTeX of states and inputs by name; small angles of Euler parameters are not symbols."""
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs)
    known = {s.name: symbol_latex(s) for s in symbols}
    return [known.get(n, latex_name(n)) for n in names]


LONG = 300
"""Length of a formula, as text, above which it is collapsed."""
_FEW = 12
"""Largest number of intermediates shown without collapsing."""
_WIDE, _HIGH = 9, 16
"""Numbers of speeds, and of speeds with auxiliary ones, above which mass matrix and table of partial velocities are not printed."""
_BRIEF, _SHORT = 7, 60
"""Formulas are set in two columns if they are more than this, each shorter than this as text."""
_MOST = 400
"""Number of lines of the solution above which it is omitted."""


@dataclass(frozen=True, slots=True)
class MatrixEquation:
    """An equation with a matrix by its rows; `entries` are the formulas of its nonzero entries."""

    head: str
    rows: tuple[tuple[str, ...], ...]
    entries: tuple[DisplayedFormula, ...]

    @property
    def latex(self) -> str:
        """The whole equation as LaTeX."""
        rows = r" \\[3pt] ".join(" & ".join(row) for row in self.rows)
        return rf"{self.head}\begin{{bmatrix}} {rows} \end{{bmatrix}}"


@dataclass(frozen=True, slots=True)
class FormulaBlock:
    """Formulas with their shared intermediates, and matrix equations, which precede them."""

    between: tuple[DisplayedFormula, ...] = ()
    formulas: tuple[DisplayedFormula, ...] = ()
    displays: tuple[MatrixEquation, ...] = ()

    @property
    def unfolded(self) -> bool:
        """Whether the intermediates are few and short."""
        return len(self.between) <= _FEW and all(len(z.text) <= LONG for z in self.between)

    @property
    def brief(self) -> bool:
        """Whether the formulas are many and short, for two columns."""
        return len(self.formulas) > _BRIEF and all(len(f.name + f.text) < _SHORT for f in self.formulas)


@dataclass(frozen=True, slots=True)
class Chapter:
    """A step: its formulas, its tables, the origin of its terms; for step 7 the solution.

    With dependent speeds, `by_all_speeds` are the forces and equations of all speeds, after those of the independent ones.
    """

    number: int
    title: str
    text: str
    block: FormulaBlock = FormulaBlock()
    tables: tuple[PageTable, ...] = ()
    solution: FormulaBlock = FormulaBlock()
    by_all_speeds: FormulaBlock = FormulaBlock()
    note: str = ""
    provenance: Provenance | None = None

    @property
    def formulas(self) -> tuple[DisplayedFormula, ...]:
        """All formulas except those of the solution."""
        return (*self.block.formulas, *self.by_all_speeds.formulas)


def chapters_of(eom: Equations) -> list[Chapter]:
    """One chapter for each of `eom.steps`."""
    terms = [eom.contributions(s) for s in shown_speeds(eom.derived)] if _surveyable(eom) else []
    return [_chapter(eom, step, terms) for step in eom.steps]


def _surveyable(eom: Equations) -> bool:
    return len(eom.speeds) <= _WIDE and len(shown_speeds(eom.derived)) <= _HIGH


def _chapter(eom: Equations, step: Step, terms: list[Contributions]) -> Chapter:
    if step.number == 1:
        coordinates = page_table("", DECLARED["coordinates"](eom.system), "coordinate", "unit", "meaning")
        return Chapter(step.number, tr(step.title), _prose(eom, step), tables=(coordinates,))
    of_independent = [(q, value) for q, value in step.results if q.kind in _OF_INDEPENDENT]
    of_all = [(q, value) for q, value in step.results if q.kind not in _OF_INDEPENDENT]
    own, others = (of_independent, of_all) if of_independent else (of_all, [])
    block, shown = _block(eom, step.number, own)
    tables = (_ALL, _INDEPENDENT)[: 1 + bool(eom.embedding)] if step.number == 4 and _surveyable(eom) else ()
    solution, note = _solution(eom) if step.number == 7 else (FormulaBlock(), "")
    note = noncontributing(eom, terms) if step.number == 5 and terms else note
    origins = _PROVENANCE[step.number](eom, terms) if step.number in _PROVENANCE and terms else None
    partials, by_all = tuple(_partials(eom, shown, *parts) for parts in tables), _block(eom, step.number, others)[0]
    prose = _prose(eom, step)
    return Chapter(step.number, tr(step.title), prose, block, partials, solution, by_all, note, origins)


def _block(
    eom: Equations, number: int, results: Sequence[Result]
) -> tuple[FormulaBlock, Mapping[Quantity, DisplayedFormula]]:
    """The block of the results, and the formula of each."""
    between, written = result_formulas(results, eom.system.inertial)
    shown = dict(zip((quantity for quantity, _ in results), written, strict=True))
    displays: list[MatrixEquation] = []
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
        displays = [_matrix(head, speeds, shown, kind) for kind, (head, speeds) in heads.items() if kind in kinds]
    listed = [f for q, f in shown.items() if q.kind not in apart or (number == 7 and q.place not in set(eom.speeds))]
    return FormulaBlock(tuple(between), tuple(listed), tuple(displays)), shown


_PROVENANCE: dict[int, Callable[[Equations, list[Contributions]], Provenance | None]] = {
    5: lambda eom, terms: force_provenance(eom, Kind.ACTIVE_FORCE, terms),
    6: lambda eom, terms: force_provenance(eom, Kind.INERTIA_FORCE, terms),
    7: lambda eom, _: mass_provenance(eom),
}

_PROSE = {
    3: N_(r"$u = Y\dot{q} + z$, chosen so that these velocities become short; solved, $\dot{q} = W u + X$."),
    4: N_("Angular velocities, velocities, their partial velocities, and accelerations."),
    5: N_(r"$F_r = \sum \mathbf{v}_r \cdot \mathbf{F} + \sum \boldsymbol{\omega}_r \cdot \mathbf{T}$ over all loads."),
    6: N_(
        r"$F^{*}_r = \sum \mathbf{v}_r \cdot (-m\,\mathbf{a}) + \sum \boldsymbol{\omega}_r \cdot (-\mathbf{I}\cdot"
        r"\boldsymbol{\alpha} - \boldsymbol{\omega}\times\mathbf{I}\cdot\boldsymbol{\omega})$ over all bodies."
    ),
    7: N_(r"$F_r + F^{*}_r = 0$, ordered as $M\dot{u} = f$."),
}


def _prose(eom: Equations, step: Step) -> str:
    said = [tr(_PROSE.get(step.number, step.text))]
    if eom.embedding and step.number in _EMBEDDED:
        said = [*said, tr(_EMBEDDED[step.number])] if step.number < 7 else [tr(_EMBEDDED[step.number])]
    if eom.reactions and step.number == 7:
        said.append(tr("The auxiliary equations give the reactions."))
    if eom.states and step.number == 7:
        said.append(tr("The further states have their own rates."))
    return " ".join(said)


_EMBEDDED = {
    4: N_(
        r"The constraints $A u + b = 0$ give the dependent speeds, $u_D = A_n u_I + b_n$, and with them the "
        r"nonholonomic partial velocities $\tilde{\mathbf{v}}_r = \mathbf{v}_r + \sum_D \mathbf{v}_D A_{n,Dr}$ of the others."
    ),
    5: N_(r"Of the independent speeds, $\tilde F_r = F_r + \sum_D A_{n,Dr} F_D$ over the dependent ones $D$."),
    7: N_(
        r"$\tilde F_r + \tilde F^{*}_r = 0$, ordered as $\tilde M\dot{u}_I = \tilde f$, "
        r"or $M\dot{u} = f + A^{T} \lambda$ with $A u + b = 0$."
    ),
}
"""Texts for systems with constraints: in addition, or for step 7 instead."""


_ALL = (N_("Partial angular velocities and partial velocities"), Kind.PARTIAL_ANGULAR_VELOCITY, Kind.PARTIAL_VELOCITY)
_OF_INDEPENDENT = (Kind.NONHOLONOMIC_INERTIA_FORCE, Kind.NONHOLONOMIC_MASS, Kind.NONHOLONOMIC_FORCING)
"""Quantities of independent speeds, which precede those of all speeds in a separate block."""
_INDEPENDENT = (
    N_("Nonholonomic partial angular velocities and partial velocities"),
    Kind.NONHOLONOMIC_PARTIAL_ANGULAR_VELOCITY,
    Kind.NONHOLONOMIC_PARTIAL_VELOCITY,
)


def _partials(
    eom: Equations, shown: Mapping[Quantity, DisplayedFormula], title: str, turn: Kind, shift: Kind
) -> PageTable:
    """Kane's table: a row for each speed, a column for each angular velocity and velocity."""
    frames, points = moving_frames_and_points(eom.system)
    columns: list[tuple[Kind, Kind, Frame | Point]] = [(Kind.ANGULAR_VELOCITY, turn, f) for f in frames]
    columns += [(Kind.VELOCITY, shift, p) for p in points]
    speeds = shown_speeds(eom.derived) if turn is Kind.PARTIAL_ANGULAR_VELOCITY else eom.independent_speeds
    rows = [
        (Tex(symbol_latex(s)), *(Tex(_right(shown, Quantity(partial, place, s))) for _, partial, place in columns))
        for s in speeds
    ]
    heads = (quantity_latex(Quantity(kind, place), eom.system.inertial) for kind, _, place in columns)
    head = (r"$u_r$", *(f"${latex}_r$" for latex in heads))
    return PageTable(tr(title), head, tuple(rows))


def _matrix(
    head: str, speeds: Sequence[Symbol], shown: Mapping[Quantity, DisplayedFormula], kind: Kind
) -> MatrixEquation:
    n = range(len(speeds))
    places = [[Quantity(kind, speeds[min(i, j)], speeds[max(i, j)]) for j in n] for i in n]
    rows = tuple(tuple(_right(shown, place) for place in row) for row in places)
    entries = [shown[row[j]] for i, row in enumerate(places) for j in n[i:] if row[j] in shown]
    return MatrixEquation(head, rows, tuple(entries))


def _right(shown: Mapping[Quantity, DisplayedFormula], quantity: Quantity) -> str:
    """The right side of a quantity's formula; "0" for a quantity without one."""
    return shown[quantity].right if quantity in shown else "0"


def _solution(eom: Equations) -> tuple[FormulaBlock, str]:
    values = zip((*map(rate, eom.speeds), *eom.reactions), (*eom.accelerations, *eom.reaction_values), strict=True)
    between, shown = formulas(list(values), symbol_latex)
    if len(between) > _MOST:
        return FormulaBlock(), tr("The solution takes %(n)s intermediates and is left out here.", n=len(between))
    return FormulaBlock(tuple(between), tuple(shown)), ""


# + − × ÷ √ first, then the functions by name
_SIGNS = {"add": "+", "sub": "−", "mul": "×", "div": "÷", "sqrt": "√", "pow": N_("power")}


@dataclass(frozen=True, slots=True)
class Costs:
    """Operation counts. `lines`: (operation, parameters only, with the state, sum). `groups`: (results, alone, added to others)."""

    lines: tuple[tuple[str, int, int, int], ...]
    total: tuple[int, int, int]
    groups: tuple[tuple[str, int, int], ...]


def costs(eom: Equations) -> Costs:
    """The operation counts of one evaluation of the right-hand side and the reactions."""
    roots = (*eom.right_hand_side, *eom.solved.reactions)
    hoisted = dict(count_operations(_of_parameters(roots)).by_operation)
    counts = dict(eom.operations.by_operation)
    kinds = [(k, hoisted.get(k, 0), counts[k]) for k in dict.fromkeys((*_SIGNS, *counts)) if k in counts]
    lines = tuple((tr(_SIGNS.get(k, k)), alone, both - alone, both) for k, alone, both in kinds)
    whole = eom.operations
    return Costs(lines, (whole.parameter, whole.state, whole.total), tuple(_groups(eom, roots)))


def _of_parameters(roots: Iterable[Expr]) -> list[Expr]:
    """The nodes that depend on parameters only."""
    alone: dict[Expr, bool] = {}
    for node in postorder(list(roots)):
        alone[node] = isinstance(node, Parameter) if isinstance(node, Symbol) else all(alone[a] for a in node.args)
    return [node for node, yes in alone.items() if yes]


def _groups(eom: Equations, roots: Iterable[Expr]) -> Iterator[tuple[str, int, int]]:
    """Counts by group; only nodes of the whole evaluation count as added, so that these add up to its total."""
    whole = set(postorder(list(roots)))
    solved = ((tr(r"$\dot{u}$, solved"), eom.solved.accelerations), (tr("reactions, solved"), eom.solved.reactions))
    if eom.operations.total == count_operations(eom.right_hand_side).total:  # u̇ is computed from the reactions
        solved = solved[::-1]
    parts: tuple[tuple[str, tuple[Expr, ...]], ...] = (
        (r"$\dot{q} = W u + X$", eom.rates),
        (tr("$M$, the mass matrix"), eom.mass_matrix.entries),
        (tr("$f$, the right side"), eom.forcing),
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


# Sentences common to all formats ----------------------------------------------------------------------------------------


def solved_text(reactions: bool) -> str:
    """The heading of the solution."""
    return tr(r"Solved for $\dot{u}$ and the reactions") if reactions else tr(r"Solved for $\dot{u}$")


def by_all_text(number: int) -> str:
    """The heading of forces and equations of all speeds, if some are dependent."""
    return tr("By all speeds, with the forces of the constraints") if number == 7 else tr("By all speeds")


def operations_text(reactions: bool) -> str:
    """A description of the counted operations."""
    head = (
        tr(r"Operations of one evaluation of $\dot{q}$, $\dot{u}$ and the reactions, including the solution.")
        if reactions
        else tr(r"Operations of one evaluation of $\dot{q}$, $\dot{u}$, including the solution.")
    )
    return f"{head} " + tr(
        "An operation is one +, −, ×, ÷, √, power or transcendental function; a change of sign is none, and "
        "subexpressions that several formulas share count once. Operations on parameters alone are executed once, before a motion "
        "begins; those with the state in every evaluation."
    )
