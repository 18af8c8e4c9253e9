# SPDX-License-Identifier: BSD-3-Clause
"""The result of importers: a system, its symbols by their names in the source, remarks on the rest; unique names."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from types import MappingProxyType
from typing import Any, Literal

from kane import show
from kane.equations.equations import Equations, derive
from kane.errors import Attributes
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Parameter, Speed
from kane.model.system import System
from kane.program.emit.identifiers import numbered, word

Kind = Literal["read", "inferred", "changed", "ignored", "refused", "checked"]
KINDS: Mapping[str, str] = MappingProxyType(
    {
        "read": "imported unchanged",
        "inferred": "not stated in the source, inferred from the rest",
        "changed": "represented differently than in the source",
        "ignored": "not imported, as it is not mechanics or has no effect",
        "refused": "not imported, as kane has no counterpart",
        "checked": "compared with the source",
    }
)
"""The kinds of remarks, in the order of display."""


@dataclass(frozen=True, slots=True)
class Remark(Attributes):
    """The treatment of an item of the source, and its position there; `kind` is a key of `KINDS`."""

    kind: Kind
    text: str
    where: str = ""

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}{f' ({self.where})' if self.where else ''}"


@dataclass(frozen=True, eq=False, repr=False)
class Imported(Attributes):
    """The model of another tool as a system.

    Attributes
    ----------
    system : the model
    symbols : all symbols, by their names in the source
    q, u, parameters : the coordinates, speeds and parameters among them
    remarks : the items that were read, inferred, changed, ignored, refused and checked
    extras : data that are not part of a system: limits, shapes, files, start values
    """

    system: System
    symbols: Mapping[str, Expr]
    q: Mapping[str, Coordinate]
    u: Mapping[str, Speed]
    parameters: Mapping[str, Parameter]
    remarks: tuple[Remark, ...] = ()
    extras: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @cached_property
    def eom(self) -> Equations:
        """The equations of motion, derived on first access."""
        return derive(self.system)

    def of_kind(self, kind: Kind) -> tuple[str, ...]:
        """The texts of the remarks of one kind."""
        return tuple(r.text for r in self.remarks if r.kind == kind)

    def __repr__(self) -> str:
        return "\n  ".join([f"Imported({size_of(self.system)})", *map(str, self._sorted())])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{r.kind}</td><td>{escape(r.text)}</td><td>{escape(r.where)}</td></tr>" for r in self._sorted()
        )
        return f"<p><b>Imported</b>: {size_of(self.system)}</p><table><tr><th></th><th>remark</th><th>where</th></tr>{rows}</table>"

    def _sorted(self) -> list[Remark]:
        order = list(KINDS)
        return sorted(self.remarks, key=lambda r: order.index(r.kind))


def size_of(system: System) -> str:
    """The numbers of bodies, coordinates, speeds and constraints, in words."""
    counted = ("bodies", "coordinates", "speeds", "constraints")
    return show.counts(**{name: len(getattr(system, name)) for name in counted})


class Remarks:
    """Collects remarks without repetition."""

    def __init__(self) -> None:
        self._said: dict[Remark, None] = {}

    def say(self, kind: Kind, text: str, where: str = "") -> None:
        """Adds a remark."""
        self._said.setdefault(Remark(kind, text, where))

    def all(self) -> tuple[Remark, ...]:
        """The remarks so far."""
        return tuple(self._said)


class FreeNames:
    """The names in use, and new ones derived from wanted names."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def free(self, wanted: str) -> str:
        """`wanted` without spaces, with a number appended if the name is in use."""
        return numbered("".join("_" if c.isspace() else c for c in wanted) or "x", self._taken)

    def identifier(self, wanted: str, kind: str) -> str:
        """`wanted` as an identifier, with `kind` appended if it is in use."""
        plain = word(wanted, kind)
        return numbered(f"{plain}_{kind}" if plain in self._taken else plain, self._taken)
