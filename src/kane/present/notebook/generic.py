# SPDX-License-Identifier: BSD-3-Clause
"""HTML of records without their own representation, with a row for each field; of mappings and lists, with a row for each item."""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from kane.dynamics.readings.seven_steps import Quantity
from kane.errors import cut
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.symbols import Symbol, Symbols
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.loads import Load
from kane.present.formula_list import quantity_latex
from kane.present.notebook.declared import acting, declared
from kane.present.notebook.typeset import (
    Typeset,
    dyadic,
    equations,
    escaped,
    expression,
    math,
    matrix,
    paragraph,
    table,
    vector,
)
from kane.show import Named
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector
from kane.units.rules import unit_text
from kane.write.latex import latex_name, point_latex, symbol_latex

_ITEMS = 12
"""Largest number of items of a list within a cell."""
_LETTERS = 120
"""Largest number of letters of a plain text in a cell."""


def cell(value: Any) -> str:
    """HTML of a value within a table; "" for an uninformative value."""
    return next((write(value) for kind, write in _CELLS.items() if isinstance(value, kind)), _text(value))


def _text(value: Any) -> str:
    name = getattr(value, "name", None)
    return escaped(name if isinstance(name, str) else cut(repr(value), _LETTERS))


def _array(values: np.ndarray) -> str:
    if values.size > _ITEMS or values.ndim > 1:
        return f"{' × '.join(map(str, values.shape))} numbers"
    return ", ".join(cell(v) if np.issubdtype(values.dtype, np.number) else escaped(v) for v in values.ravel().tolist())


def _pairs(values: Mapping[Any, Any]) -> str:
    shown = [f"{cell(k)}: {cell(v)}" for k, v in list(values.items())[:_ITEMS]]
    return "<br>".join([*shown, *_rest(values)])


def _several(values: Any) -> str:
    return ", ".join([*map(cell, tuple(values)[:_ITEMS]), *_rest(values)])


def _rest(values: Any) -> list[str]:
    return [f"… and {len(values) - _ITEMS} more"] if len(values) > _ITEMS else []


_CELLS: dict[Any, Callable[[Any], str]] = {
    type(None): lambda _: "",
    bool | np.bool_: lambda yes: "yes" if yes else "no",
    int | np.integer: str,
    str: lambda text: escaped(cut(text, _LETTERS)),
    Symbol: lambda s: math(symbol_latex(s)),
    Expr: lambda e: expression(e).cell,
    Vector: lambda v: vector(v).cell,
    Dyadic: lambda d: dyadic(d).cell,
    Matrix: lambda m: matrix(m).cell,
    Frame | Point: lambda place: math(point_latex(place.name)),
    float | complex | np.number: lambda x: escaped(f"{x:.6g}"),
    np.ndarray: _array,
    Mapping: _pairs,
    tuple | list | set | frozenset: _several,
    Callable: lambda _: "",
}
"""HTML of a value by its type, the first that matches."""


def record_html(record: Any) -> str:
    """A row for each nonempty field; for objects that are not records their printed form."""
    lead = f"<b>{type(record).__name__}</b>"
    own = [f.name for f in fields(record) if not f.name.startswith("_")] if is_dataclass(record) else []
    shown = [(escaped(name.replace("_", " ")), cell(getattr(record, name, None))) for name in own]
    body = table(("", ""), [row for row in shown if row[1]])
    return paragraph(lead) + body if body else paragraph(f"{lead}: {escaped(cut(repr(record), 300))}")


def mapping_html(values: Mapping[Any, Any]) -> str:
    """A row for each key."""
    rows = [(cell(key), cell(value)) for key, value in values.items()]
    return table(("", ""), rows) or paragraph("Nothing.")


def symbols_html(symbols: Symbols[Any]) -> str:
    """Name, unit, default and meaning."""
    rows = [(cell(s), escaped(unit_text(s.unit)), cell(s.default), escaped(s.description or "")) for s in symbols]
    return table(("symbol", "unit", "default", "meaning"), rows) or paragraph("No symbols.")


_GROUPS: dict[Any, str] = {RigidBody | Particle: "bodies", Constraint: "constraints", Event: "events"}
"""The group of a system as which a list is shown, by the type of its items."""


def listing_html(values: tuple[Any, ...]) -> str:
    """A row for each item."""
    for kind, group in _GROUPS.items():
        if values and all(isinstance(v, kind) for v in values):
            return declared(SimpleNamespace(**{group: values}), group)
    heads = getattr(values, "_fields", range(len(values)))
    rows = [(str(k), _item_name(v), _item(v)) for k, v in zip(heads, values, strict=True)]
    return table(("", "", ""), rows) or paragraph("Nothing.")


def _item_name(value: Any) -> str:
    name = getattr(value, "name", "")
    return "" if isinstance(value, Expr | Frame | Point) or not isinstance(name, str) else escaped(name)


def _item(value: Any) -> str:
    if isinstance(value, Load):
        return acting(value)
    return cell(value) if isinstance(value, _PLAIN) else escaped(cut(repr(value), _LETTERS))


_PLAIN = (Expr, Vector, Dyadic, Matrix, Frame, Point, str, int, float, complex, np.ndarray, tuple)


def named_formulas(named: Named[Expr]) -> Typeset:
    """Equations one below the other."""
    pairs = zip(named.labels, named, strict=True)
    return equations([(_label(label), e) for label, e in pairs])


def _label(label: object) -> str:
    if isinstance(label, Quantity):
        return quantity_latex(label)
    return symbol_latex(label) if isinstance(label, Symbol) else latex_name(str(label))
