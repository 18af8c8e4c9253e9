# SPDX-License-Identifier: BSD-3-Clause
"""The chapters on the operating point, with its values and reactions, and on the linearized equations, in numbers."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kane.analysis.linear import Linear
from kane.equations.equations import Equations
from kane.expr.symbols import rate
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN, SIX_DIGITS
from kane.present.languages.catalogue import tr
from kane.present.linearized.chapter import Part, Section, latex_of, matrix
from kane.present.overview import PageTable, Tex, meaning, page_table, reactions
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
    return Section("linearization", tr("Linearization"), tuple(_parts(eom, linear)))


def _parts(eom: Equations, linear: Linear) -> Iterator[Part]:
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
