# SPDX-License-Identifier: BSD-3-Clause
"""The origin of each generalized force and each entry of M, as tables; `show_versions`, for bug reports."""

import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from kane.dynamics.readings.contributions import Contributions
from kane.dynamics.readings.seven_steps import Kind, Quantity
from kane.equations.equations import Equations
from kane.expr.symbols import Symbol
from kane.model.bodies import Body
from kane.model.loads import Load
from kane.present.formula_list import DisplayedFormula, formulas, quantity_latex
from kane.present.languages.catalogue import N_, tr, trn
from kane.present.overview import Cell, PageTable, Tex
from kane.program.native import machine, store
from kane.space.frame import Point
from kane.write.latex import point_latex, symbol_latex

_PACKAGES = (
    "kane", "numpy", "scipy", "llvmlite", "sympy", "matplotlib", "rich", "typer", "jinja2", "markdown-it-py", "platformdirs",
)  # fmt: skip


def versions() -> dict[str, str]:
    """Versions of kane, of Python and of the packages that kane requires; the processor for which code is compiled; the cache."""
    packages = {name: _version(name) for name in _PACKAGES}
    packages["llvmlite"] = ", ".join(part.removeprefix("llvmlite ") for part in machine.versions())
    here = machine.host()
    place = store.folder()
    return {
        **packages,
        "Python": sys.version.split()[0],
        "system": platform.platform(),
        "processor": f"{here.cpu} ({here.triple}), {here.lanes} lanes of double",
        "cache": "off" if place is None else str(place),
    }


def show_versions() -> None:
    """Print `versions()`, one per line, for bug reports."""
    rows = versions()
    width = max(map(len, rows))
    for name, value in rows.items():
        print(f"{name:{width}}  {value}")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


_MOST = 400
"""Number of terms above which the origin is omitted from a report."""


@dataclass(frozen=True, slots=True)
class Origin:
    """The terms of the quantity `left` (LaTeX), and a sentence on noncontributing loads or bodies."""

    left: str
    count: str
    table: PageTable
    idle: str = ""


@dataclass(frozen=True, slots=True)
class Provenance:
    """The origins of a chapter's quantities, and their shared intermediates."""

    title: str
    origins: tuple[Origin, ...]
    between: tuple[DisplayedFormula, ...]


def mass_provenance(eom: Equations) -> Provenance | None:
    """Contributions of bodies to each entry of M on and above the diagonal."""
    pairs = [(r, s) for i, r in enumerate(eom.speeds) for s in eom.speeds[i:]]
    entries = [(r, s, c) for r, s in pairs for c in eom.mass_contributions(r, s)]
    if len(entries) > _MOST:
        return None
    between, shown = formulas([("", x) for _, _, c in entries for x in (c.translation, c.rotation)])
    shares: Iterator[Cell] = ("–" if f.right == "0" else Tex(f.right) for f in shown)
    rows = tuple((Tex(_left(eom, Kind.MASS, r, s)), c.body.name, next(shares), next(shares)) for r, s, c in entries)
    translation = r"$m\,\mathbf{v}_r\cdot\mathbf{v}_s$"
    rotation = r"$\boldsymbol{\omega}_r\cdot\mathbf{I}\cdot\boldsymbol{\omega}_s$"
    table = PageTable("", (tr("entry"), tr("body"), translation, rotation), rows)
    return Provenance(tr("The mass matrix, body by body"), (Origin("M", _terms(len(rows)), table),), tuple(between))


def noncontributing(eom: Equations, contributions: Sequence[Contributions]) -> str:
    """A sentence that names the loads that contribute to no generalized active force."""
    idle = [set(c.noncontributing_loads) for c in contributions]
    names = [load.name for load in eom.loads if all(load in some for some in idle)]
    if not names:
        return ""
    return trn(
        "%(names)s enters no generalized active force: noncontributing.",
        "%(names)s enter no generalized active force: noncontributing.",
        len(names),
        names=", ".join(names),
    )


def force_provenance(eom: Equations, kind: Kind, contributions: Sequence[Contributions]) -> Provenance | None:
    """The forces and torques in each F_r, or the inertia forces and torques of bodies in each F*_r."""
    if kind is Kind.ACTIVE_FORCE:
        head = tr("load"), tr("on"), tr("force or torque")
        quantities = [(c.speed, c.active, _idle(kind, c.noncontributing_loads)) for c in contributions]
    else:
        head = tr("body"), tr("of"), tr("inertia force or torque")
        quantities = [(c.speed, c.inertia, _idle(kind, c.noncontributing_bodies)) for c in contributions]
    terms = [c for _, some, _ in quantities for c in some]
    if len(terms) > _MOST or not (terms or any(idle for *_, idle in quantities)):
        return None
    between, shown = formulas([("", x) for c in terms for x in (c.vector, c.partial, c.term)])
    right = iter(Tex(f.right) for f in shown)
    origins = []
    for speed, some, idle in quantities:
        rows = []
        for c in some:
            vector, partial, term = next(right), next(right), next(right)
            velocity = Kind.PARTIAL_VELOCITY if isinstance(c.place, Point) else Kind.PARTIAL_ANGULAR_VELOCITY
            met = Tex(f"{_left(eom, velocity, c.place, speed)} = {partial.source}")
            source = Tex(symbol_latex(c.source)) if isinstance(c.source, Symbol) else c.source.name
            rows.append((source, Tex(point_latex(c.place.name)), vector, met, term))
        table = PageTable("", (*head, tr("partial velocity"), tr("term")), tuple(rows))
        origins.append(Origin(_left(eom, kind, speed), _terms(len(some)), table, idle))
    return Provenance(tr("Where the terms come from"), tuple(origins), tuple(between))


def _left(eom: Equations, kind: Kind, place: Any, speed: Any = None) -> str:
    return quantity_latex(Quantity(kind, place, speed), eom.system.inertial)


def _terms(n: int) -> str:
    return tr("no terms") if n == 0 else trn("%(n)s term", "%(n)s terms", n)


_IDLE = {
    Kind.ACTIVE_FORCE: (N_("%(n)s load contributes nothing: %(names)s."), "%(n)s loads contribute nothing: %(names)s."),
    Kind.INERTIA_FORCE: (
        N_("%(n)s body contributes nothing: %(names)s."),
        "%(n)s bodies contribute nothing: %(names)s.",
    ),
}


def _idle(kind: Kind, some: Sequence[Load | Body]) -> str:
    return trn(*_IDLE[kind], len(some), names=", ".join(x.name for x in some)) if some else ""
