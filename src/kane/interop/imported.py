# SPDX-License-Identifier: BSD-3-Clause
"""What an importer returns: the system, what its symbols were called, and what was read, inferred, changed or left out."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import Any, Literal

from kane.equations.equations import Equations, derive
from kane.errors import Attributes
from kane.expr.symbols import Coordinate, Parameter, Speed, Symbol
from kane.model.system import System

Kind = Literal["read", "inferred", "changed", "left out", "checked"]
KINDS: dict[str, str] = {
    "read": "taken over as it stands",
    "inferred": "not said there, concluded from the rest",
    "changed": "expressed in another way than there",
    "left out": "not taken over",
    "checked": "compared with the source",
}
"""The kinds of remarks, and what each means."""


@dataclass(frozen=True, slots=True, eq=False)
class Remark:
    """One thing that an importer says: its kind, a row of `KINDS`, a sentence, and where it stands in the source."""

    kind: Kind
    text: str
    where: str = ""

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}{f' ({self.where})' if self.where else ''}"


@dataclass(frozen=True, eq=False, repr=False)
class Imported(Attributes):
    """A model that came from another tool.

    Attributes
    ----------
    system : the model
    symbols : what each name of the source became
    q, u : start values, of coordinates and speeds for which the source gives one
    parameters : values of parameters that the source gives
    remarks : what was read, inferred, changed, left out and checked, in this order
    source : what it was made from, in words
    """

    system: System
    symbols: Mapping[str, Symbol]
    q: Mapping[Coordinate, float]
    u: Mapping[Speed, float]
    parameters: Mapping[Parameter, float]
    remarks: tuple[Remark, ...]
    source: str

    @cached_property
    def eom(self) -> Equations:
        """The equations of motion, derived when they are first asked for."""
        return derive(self.system)

    def of_kind(self, kind: Kind) -> tuple[str, ...]:
        """What the remarks of one kind say."""
        return tuple(r.text for r in self.remarks if r.kind == kind)

    def __repr__(self) -> str:
        lines = [f"Imported from {self.source}: {self.system!r}"]
        lines += [f"  {kind}: {text}" for kind, text in self._sorted()]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{escape(kind)}</td><td>{escape(text)}</td></tr>" for kind, text in self._sorted())
        head = f"<p><b>Imported</b> from {escape(self.source)}: {escape(repr(self.system))}</p>"
        return f"{head}<table><tr><th>what</th><th>remark</th></tr>{rows}</table>"

    def _sorted(self) -> list[tuple[str, str]]:
        return [(k, f"{r.text}{f' ({r.where})' if r.where else ''}") for k in KINDS for r in self.remarks if r.kind == k]


class Remarks:
    """A list of remarks that is being written."""

    def __init__(self) -> None:
        self._said: dict[tuple[Kind, str], Remark] = {}

    def say(self, kind: Kind, text: str, where: str = "") -> None:
        """One more, once."""
        self._said.setdefault((kind, text), Remark(kind, text, where))

    def all(self) -> tuple[Remark, ...]:
        """Those written so far, by kind."""
        order: dict[Any, int] = {kind: k for k, kind in enumerate(KINDS)}
        return tuple(sorted(self._said.values(), key=lambda r: order[r.kind]))
