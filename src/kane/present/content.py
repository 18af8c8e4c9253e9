# SPDX-License-Identifier: BSD-3-Clause
"""The content of a report in any format: declarations, chapters, checks, and tables of a motion."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane import expect
from kane.analysis.linear import Linear
from kane.analysis.solution_branches import Branch
from kane.equations.equations import Equations, check_equations
from kane.errors import ArgumentError, cut
from kane.expr.symbols import Symbol
from kane.motion.solution.solution import Solution
from kane.numeric.scale import ROUNDED_SUM
from kane.present.chapters import Chapter, Costs, Section, chapters_of, costs
from kane.present.check_figures import Check, energy_text, motion_checks
from kane.present.languages.catalogue import tr, trn
from kane.present.linearized.steady_chapters import check_small_motions, sections
from kane.present.notes import checked
from kane.present.other_methods import WhyKane, is_small, why_kane
from kane.present.overview import Cell, PageTable, Tex, declared_tables
from kane.present.pages import plain
from kane.present.scene.gather import scene
from kane.present.scene.records import Scene
from kane.present.scene.shapes import BodyShape, shapes_of
from kane.units.rules import unit_text
from kane.write.latex import symbol_latex


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """The content that every writer of reports uses; `tables` are those of the solution, if any.

    For a motion with contacts, `eom` are the equations of its first `mode`, and so are the loads in a sketch if no gap may open;
    `moving` has no mode.

    `other_methods` is the chapter on other methods, if any, `sections` are those on small motions, `notes` the argument of
    `report`.
    """

    title: str
    eom: Equations
    seen: Scene
    moving: Scene
    mode: str
    summary: list[tuple[int, str]]
    declared: list[PageTable]
    chapters: list[Chapter]
    other_methods: WhyKane | None
    receipt: Costs
    checks: list[Check]
    sources: tuple[str, ...]
    solution: Solution | None
    tables: tuple[PageTable, ...]
    sections: tuple[Section, ...]
    notes: tuple[Any, ...]

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbols of sketch, sliders and formulas."""
        eom = self.eom
        return (*eom.state, *eom.parameters, *eom.inputs, *eom.reactions)

    @property
    def meanings(self) -> list[tuple[str, str]]:
        """The described coordinates in LaTeX, with their descriptions."""
        return [(symbol_latex(q), q.description) for q in self.eom.coordinates if q.description]


def content_of(
    eom: Equations,
    *,
    solution: Solution | None = None,
    title: str | None = None,
    sources: Sequence[str] = (),
    checks: Iterable[Check] = (),
    shapes: Iterable[BodyShape] = (),
    why: bool | None = None,
    linearization: Linear | None = None,
    root_locus: Branch | None = None,
    notes: Sequence[Any] = (),
) -> Content:
    """The content of a report; arguments as for `report`."""
    check_equations(eom)
    if solution is not None and not isinstance(solution, Solution):
        raise ArgumentError(f"Expected solution= as a motion from kn.simulate, got {cut(repr(solution))}.")
    if solution is not None and solution.equations is not eom:
        raise ArgumentError(
            "Expected a solution of the equations reported, got one of others: pass solution.equations as eom."
        )
    kept = checked(notes)  # fails before expensive work
    check_small_motions(eom, linearization, root_locus)
    given = expect.instances(checks, Check, "checks= as a list of kn.Check", "Write checks=[…].", error=ArgumentError)
    quoted = expect.instances(sources, str, "sources= as a list of texts", 'Write sources=["…"].', error=ArgumentError)
    expect.that(title is None or isinstance(title, str), "title= as a text", title, error=ArgumentError)
    told = [_in_language(check, solution) for check in given]
    shapes, whole = shapes_of(shapes), eom
    if solution is not None and eom.system.modes_change:
        eom = solution.samples[0]
    moving = scene(whole, shapes)
    # draw the loads and reactions of the mode, unless its closed gaps would restrict the pose
    seen = moving if eom is whole or any(c.gap is not None for c in whole.system.contacts) else scene(eom, shapes)
    return Content(
        title=title or tr("Equations of motion: %(bodies)s", bodies=", ".join(b.name for b in eom.system.bodies)),
        eom=eom,
        seen=seen,
        moving=moving,
        mode=_mode(whole, eom) if eom is not whole else "",
        summary=_summary(eom),
        declared=declared_tables(eom, solution.parameters if solution is not None else None),
        chapters=chapters_of(eom),
        other_methods=why_kane(eom) if (is_small(eom) if why is None else why) else None,
        receipt=costs(eom),
        checks=told if solution is None else [*told, *motion_checks(solution, told)],
        sources=quoted,
        solution=solution,
        tables=() if solution is None else (_start(solution), *_reactions(solution), *_changes(solution)),
        sections=tuple(sections(whole, linearization, root_locus)),
        notes=kept,
    )


def _mode(whole: Equations, eom: Equations) -> str:
    """The derived mode of the contacts, in words."""
    pairs = zip(whole.system.contacts, eom.system.modes, strict=True)
    told = ", ".join(f"{c.name} {tr(m.word(c))}" for c, m in pairs)
    return tr(
        "The contacts change the active constraints. Derived here is the mode in which the motion begins: %(modes)s.",
        modes=told,
    )


def _summary(eom: Equations) -> list[tuple[int, str]]:
    free = eom.independent_speeds if eom.embedding else ()
    groups = (eom.system.bodies, eom.coordinates, eom.speeds, free, eom.states, eom.reactions)
    bodies, q, u, freedoms, states, reactions = sizes = [len(some) for some in groups]
    told = (
        trn("body", "bodies", bodies),
        trn("coordinate", "coordinates", q),
        trn("generalized speed", "generalized speeds", u),
        trn("degree of freedom", "degrees of freedom", freedoms),
        trn("further state", "further states", states),
        trn("reaction", "reactions", reactions),
    )
    return [*(row for row in zip(sizes, told, strict=True) if row[0]), (eom.operations.total, tr("operations"))]


def _in_language(check: Check, solution: Solution | None) -> Check:
    """A check with its texts in the language of the report, unless they are the user's."""
    energy = None if solution is None else solution.energy_check
    detail = energy_text(energy) if energy is not None and check.detail == str(energy) else check.detail
    return replace(check, name=tr(check.name), detail=detail)


def _start(solution: Solution) -> PageTable:
    """A table of the state at the start and at the end."""
    eom = solution.equations
    ends = zip(eom.state, solution.states[0], solution.states[-1], strict=True)
    rows = tuple((Tex(symbol_latex(s)), f"{a:.6g}", f"{b:.6g}", unit_text(eom.unit(s))) for s, a, b in ends)
    head = ("", f"t = {solution.t[0]:g} s", f"t = {solution.t[-1]:.6g} s", tr("unit"))
    return PageTable(tr("Start and end"), head, rows, unfolded=False)


def _reactions(solution: Solution) -> Iterator[PageTable]:
    """The minimum and maximum of each reaction, with times; reactions are undefined where constraints lose rank."""
    symbols = solution.equations.reactions
    rows: list[tuple[Cell, ...]] = []
    every = np.array(solution[list(symbols)])
    least = ROUNDED_SUM * np.nanmax(np.abs(every), initial=0.0)
    for s, values in zip(symbols, np.where(np.abs(every) > least, every, every * 0 + 0.0), strict=True):
        if np.isfinite(values).any():
            ends = ((values[k], solution.t[k]) for k in (np.nanargmin(values), np.nanargmax(values)))
            told = (f"{x:.5g}" for pair in ends for x in pair)
            rows.append((Tex(symbol_latex(s)), *told, unit_text(solution.equations.unit(s))))
    if rows:
        head = (tr("reaction"), tr("least"), tr("at t (s)"), tr("greatest"), tr("at t (s)"), tr("unit"))
        yield PageTable(tr("Reactions during the motion"), head, tuple(rows))


_SHOWN = 100
"""Largest number of changes of a motion in a table."""
_NO_ENERGY = 1e-9
"""Fraction of the largest energy below which a change of energy is shown as zero."""


def _changes(solution: Solution) -> Iterator[PageTable]:
    """A table of changes of a motion: times, events, subsequent modes of contacts, and energy lost."""
    begins = solution.begins.tolist()
    if not begins:
        return
    rows, energies = [], solution.energy
    least = _NO_ENERGY * float(np.abs(energies).max())
    for k in begins[:_SHOWN]:
        by = ", ".join(e.name for e in solution.phases[solution.phase[k]].by)
        pairs = ((name, str(words[k - 1]), str(words[k])) for name, words in solution.modes.items())
        told = ", ".join(f"{name}: {tr(a)} → {tr(b)}" for name, a, b in pairs if a != b)
        energy = float(energies[k] - energies[k - 1])
        rows.append((f"{solution.t[k]:.9g}", by, told, f"{energy:+.4g}" if abs(energy) > least else "0"))
    if len(begins) > _SHOWN:
        rows.append(("…", tr("%(n)s more", n=len(begins) - _SHOWN), "", ""))
    head = ("t (s)", tr("event"), tr("contacts"), tr("energy (J)"))
    yield PageTable(tr("Events during the motion"), head, tuple(rows))


def run_text(solution: Solution) -> str:
    """A sentence on the run of a motion: span, steps and evaluations, reason for its end, energy error."""
    run = {
        "begin": f"{solution.t[0]:g}",
        "end": f"{solution.t[-1]:.6g}",
        "steps": solution.steps,
        "evaluations": solution.evaluations,
    }
    message = tr("reached t = %(end)s", end=f"{solution.t[-1]:g}")
    told = message if solution.status == "finished" else solution.message
    return tr(
        "From %(begin)s s to %(end)s s, in %(steps)s steps and %(evaluations)s evaluations: %(message)s; %(energy)s.",
        **run, message=plain(told), energy=plain(energy_text(solution.energy_check)),
    )  # fmt: skip
