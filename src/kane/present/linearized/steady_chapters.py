# SPDX-License-Identifier: BSD-3-Clause
"""The chapters of a report on steady motions: the operating point, the linearized equations in numbers, and eigenvalues."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kane.analysis.linear import Linear, Mode
from kane.analysis.solution_branches import Branch
from kane.equations.equations import Equations
from kane.equations.state import State
from kane.errors import ArgumentError, cut
from kane.expr.symbols import rate
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN, SIX_DIGITS
from kane.present.chapters import Part, Section, latex_of, matrix, number
from kane.present.languages.catalogue import tr, trn
from kane.present.overview import Cell, PageTable, Tex, meaning, page_table, reactions
from kane.units.rules import unit_text
from kane.write.latex import symbol_latex

_MANY = 24
"""Number of rows from which a table is collapsed."""
_WIDE = 10
"""Largest number of states, inputs or outputs for which a matrix is printed."""


def operating_point(eom: Equations, linear: Linear) -> Section:
    """The kind of operating point, the values of the state, of inputs and of changed parameters, and the reactions."""
    parts: list[Part] = [_values(eom, linear), *_outputs(linear)]
    if eom.reactions:
        parts.append(_reactions(eom, linear))
    return Section("point", tr("Operating point"), (_what(eom, linear), *parts))


def _what(eom: Equations, linear: Linear) -> str:
    """Whether the point is an equilibrium, a steady motion, or a state of another motion."""
    count = len(linear.coordinates)
    left = [abs(x) for n, x in zip(linear.states, linear.rates.tolist(), strict=True) if n not in linear.cyclic]
    size = max(1.0, float(np.abs(linear.A).max(initial=0.0)))
    if max(left, default=0.0) > SIX_DIGITS * size:
        rates = zip(latex_of(eom, linear.states), linear.rates.tolist(), strict=True)
        told = r",\; ".join(rf"\dot{{{s}}} = {x:.4g}" for s, x in list(rates)[count:])
        return tr(
            "A state of a motion that is not steady: deviations are those from the motion through it, $%(rates)s$.",
            rates=told,
        )
    q_dot = eom.evaluate([rate(q) for q in eom.coordinates], linear.point)
    moving = [q for q, x in zip(eom.coordinates, q_dot, strict=True) if abs(float(x)) > EQUAL]
    if not moving:
        return tr("An equilibrium: nothing moves.")
    return tr(
        "A steady motion: the speeds are constant, and of the coordinates only $%(moving)s$ change, on which no speed depends.",
        moving=r",\, ".join(map(symbol_latex, moving)),
    )


def _values(eom: Equations, linear: Linear) -> PageTable:
    """The state, inputs, and parameters that differ from their defaults, without empty columns."""
    point = linear.point
    groups: list[Any] = [point.q, point.u, point.states, point.inputs]
    known = {s: float(x) for group in groups for s, x in (group or {}).items()}
    size = max(map(abs, known.values()), default=0.0)
    changed = {s: float(x) for s, x in dict(point.parameters or {}).items() if x != s.default}
    shown = [(s, _figure(known[s], size)) for s in (*eom.state, *eom.inputs)]
    rows = [*shown, *((s, f"{x:.6g}") for s, x in changed.items())]
    cells = [(Tex(symbol_latex(s)), x, unit_text(eom.unit(s)), meaning(s)) for s, x in rows]
    head = ("", tr("value"), tr("unit"), tr("meaning"))
    told = [k for k, column in enumerate(zip(*cells, strict=True)) if any(column)]
    return PageTable(
        tr("Values"),
        tuple(head[k] for k in told),
        tuple(tuple(row[k] for k in told) for row in cells),
        len(cells) <= _MANY,
    )


def _outputs(linear: Linear) -> Iterator[Part]:
    if linear.outputs:
        rows = zip(map(str, linear.outputs), (f"{x:.6g}" for x in linear.values.tolist()), strict=True)
        yield PageTable(tr("Outputs"), (tr("output"), tr("value")), tuple(rows))


def _reactions(eom: Equations, linear: Linear) -> PageTable:
    """The reactions at the operating point, with their points and directions."""
    values: Sequence[float] = list(map(float, eom.evaluate(list(eom.reactions), linear.point)))
    size = max(map(abs, values))
    rows = zip(reactions(eom.system, eom.auxiliary_speeds), values, strict=True)
    told = ({**row, "value": _figure(x, size)} for row, x in rows)
    return page_table("Reactions brought into evidence", told, "reaction", "at", "along", "value", "unit")


def _figure(x: float, size: float) -> str:
    """Six digits; 0 for values within rounding of zero beside the largest."""
    return f"{x:.6g}" if abs(x) > ROUNDED_CHAIN * size else "0"


# The linearized equations -----------------------------------------------------------------------------------------------------


def state_space(eom: Equations, linear: Linear) -> Section:
    """The chapter on ẋ = A x + B r, y = C x + D r."""
    return Section("linearization", tr("Linearization"), tuple(_matrices(eom, linear)))


def _matrices(eom: Equations, linear: Linear) -> Iterator[Part]:
    laws = [r"\dot{x} = A x + B r" if linear.inputs else r"\dot{x} = A x"]
    if linear.outputs:
        laws.append("y = C x + D r" if linear.inputs else "y = C x")
    yield tr(
        "Small deviations $x$ of the states from the operating point obey $%(laws)s$; what depends on them by a constraint is "
        "eliminated.",
        laws=r",\; ".join(laws),
    )
    yield from _vector("x", latex_of(eom, linear.states))
    yield from _vector("r", latex_of(eom, linear.inputs))
    yield from _vector("y", latex_of(eom, linear.outputs))
    if linear.cyclic:
        names = latex_of(eom, linear.cyclic)
        yield tr("No speed depends on $%(names)s$.", names=r",\, ".join(names))
    shown = {"A": linear.A, "B": linear.B, "C": linear.C, "D": linear.D}
    for name, values in shown.items():
        if not values.size:
            continue
        if max(values.shape) > _WIDE:
            size = " × ".join(map(str, values.shape))
            yield tr("$%(name)s$ has %(size)s entries and is left out here.", name=name, size=size)
        else:
            yield Tex(f"{name} = {matrix(values)}")


def _vector(name: str, entries: Sequence[str]) -> Iterator[Part]:
    """The components of a vector of deviations."""
    if 0 < len(entries) <= _WIDE:
        within = " & ".join(rf"\delta {e}" for e in entries)
        yield Tex(rf"{name} = \begin{{bmatrix}} {within} \end{{bmatrix}}^{{T}}")


_SHOWN = 0.05
"""Smallest component of a mode that is listed, relative to the largest."""
_FEW = 3
"""Largest number of components of a mode that are listed."""
_NONE = "–"


def eigenvalues(eom: Equations, linear: Linear) -> Section:
    """A table row for each mode, with one for a conjugate pair, by decreasing real part and increasing frequency."""
    return Section("eigenvalues", tr("Eigenvalues"), tuple(_modes(eom, linear)))


def _modes(eom: Equations, linear: Linear) -> Iterator[Part]:
    size = max((m.frequency for m in linear.modes), default=0.0)
    least = SIX_DIGITS * size  # multiple zero eigenvalues are less accurate
    yield _verdict(linear, least)
    head = (r"$\lambda$ (1/s)", r"$|\lambda|$ (rad/s)", tr("frequency (Hz)"), tr("damping"), tr("mode"))
    ordered = sorted(linear.modes, key=lambda m: (-m.eigenvalue.real * (abs(m.eigenvalue.real) > least), m.frequency))
    yield PageTable("", head, tuple(_row(eom, m, len(linear.coordinates), least) for m in ordered))
    yield tr(
        r"The frequency is $|\mathrm{Im}\,\lambda|/2\pi$, the damping $-\mathrm{Re}\,\lambda/|\lambda|$. Each mode lists the "
        "coordinates that take part most, compared by their numbers, with their phases; speeds, where no coordinate does."
    )


def _verdict(linear: Linear, least: float) -> str:
    growing = sum(m.eigenvalue.real > least for m in linear.modes)
    staying = sum(abs(m.eigenvalue.real) <= least for m in linear.modes)
    if growing:
        return trn("%(n)s mode grows: unstable.", "%(n)s modes grow: unstable.", growing)
    if staying:
        return trn(
            "No mode grows; %(n)s neither grows nor decays.", "No mode grows; %(n)s neither grow nor decay.", staying
        )
    return tr("Every mode decays: stable.")


def _row(eom: Equations, mode: Mode, coordinates: int, least: float) -> tuple[Cell, ...]:
    real, imaginary = mode.eigenvalue.real, mode.eigenvalue.imag
    real = real if abs(real) > least else 0.0
    still = mode.frequency <= least
    swings = imaginary > least
    told = rf"{number(real) if real else ''} \pm {number(imaginary)}\,\mathrm{{i}}" if swings else number(real)
    return (
        Tex(told.strip()), "0" if still else f"{mode.frequency:.5g}", f"{imaginary / (2 * math.pi):.5g}" if swings else _NONE,
        _NONE if still else f"{-real / mode.frequency + 0.0:.4g}", Tex(_shape(eom, mode, coordinates)),
    )  # fmt: skip


def _shape(eom: Equations, mode: Mode, coordinates: int) -> str:
    """The largest components in decreasing size, scaled so that the first is 1."""
    own = mode.vector[:coordinates]
    moves = np.abs(own).max(initial=0.0) > SIX_DIGITS * np.abs(mode.vector).max(initial=0.0)
    vector, names = (own, mode.names[:coordinates]) if moves else (mode.vector, mode.names)
    order = np.argsort(-np.abs(vector), kind="stable")
    relative = vector / vector[order[0]]
    kept = [k for k in order.tolist() if abs(relative[k]) >= _SHOWN]
    latex = latex_of(eom, names)
    told = [rf"{latex[k]}\; {_component(complex(relative[k]))}" for k in kept[:_FEW]]
    return r",\;\; ".join([*told, *([r"\dots"] if len(kept) > _FEW else [])])


def _component(value: complex) -> str:
    """Amplitude and phase; a sign for components in phase or in antiphase."""
    degrees = round(math.degrees(math.atan2(value.imag, value.real)))
    if degrees % 180 == 0:
        return number(abs(value) if degrees == 0 else -abs(value), 3)
    return rf"{number(abs(value), 3)}\angle {degrees}^{{\circ}}"


def check_small_motions(eom: Equations, linearization: Any, root_locus: Any) -> None:
    """Raise ArgumentError for arguments that are not a linearization, or a branch, of these equations."""
    _of(eom, linearization, Linear, "linearization= as kn.linearize(eom, …) returns it", lambda x: [x.point])
    _of(eom, root_locus, Branch, "root_locus= as kn.analysis.continuation(eom, …) returns it", lambda x: x.points)


def _of(eom: Equations, given: Any, kind: type, expected: str, points: Any) -> None:
    if given is None:
        return
    if not isinstance(given, kind):
        raise ArgumentError(f"Expected {expected}, got {cut(repr(given))}.")
    if not all(_belongs(eom, point) for point in points(given)):
        raise ArgumentError(f"Expected {expected} for the equations reported, got one of others.")


def _belongs(eom: Equations, point: State) -> bool:
    groups: tuple[Any, ...] = (point.q, point.u, point.states, point.inputs, point.parameters)
    return {*eom.state, *eom.inputs, *eom.parameters} == {s for group in groups for s in group or ()}


def sections(eom: Equations, linearization: Linear | None, root_locus: Branch | None) -> Iterator[Section]:
    """The chapters, in order."""
    if linearization is not None:
        yield from (made(eom, linearization) for made in (operating_point, state_space, eigenvalues))
    if root_locus is not None:
        from kane.present.linearized.branch_figures import root_loci

        yield root_loci(root_locus)
