# SPDX-License-Identifier: BSD-3-Clause
"""What importers return: a system, its symbols by the names that they have in the source, and what became of the rest."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from kane.expr.node import Expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Parameter, Speed
from kane.model.system import System


@dataclass(frozen=True, slots=True)
class Remark:
    """What an importer did with a thing of the source, and where it stands there."""

    kind: Literal["read", "inferred", "ignored", "refused"]
    text: str
    where: str = ""

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}{f' ({self.where})' if self.where else ''}"


@dataclass(frozen=True, slots=True, eq=False)
class Imported(Immutable):
    """A model of another tool as a system.

    `symbols` are all symbols by name; `q`, `u` and `parameters` are those that have names in the source, by these names. `remarks`
    say what was read, inferred, ignored and refused; `extras` hold what is no mechanics: limits, shapes, files.
    """

    system: System
    symbols: Mapping[str, Expr]
    q: Mapping[str, Coordinate]
    u: Mapping[str, Speed]
    parameters: Mapping[str, Parameter]
    remarks: tuple[Remark, ...] = ()
    extras: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __repr__(self) -> str:
        s = self.system
        head = f"Imported({len(s.bodies)} bodies, {len(s.coordinates)} coordinates, {len(s.speeds)} speeds"
        return "\n  ".join([f"{head}, {len(s.constraints)} constraints)", *map(str, self.remarks)])
