# SPDX-License-Identifier: BSD-3-Clause
"""A program in the making: numbered instructions and what is wanted of them. Passes go from draft to draft."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from kane.expr.ops import Op
from kane.expr.symbols import Parameter, Symbol
from kane.program.program import Port


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A routine before its instructions are chosen: the values it is to give."""

    name: str
    shape: tuple[int, ...]
    labels: tuple[str, ...]
    results: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Draft:
    """Values are numbered as in a `Program`: symbols, constants, instructions."""

    name: str
    ports: tuple[Port, ...]
    constants: tuple[float, ...]
    ops: tuple[Op, ...]
    args: tuple[tuple[int, ...], ...]
    goals: tuple[Goal, ...]

    @cached_property
    def inputs(self) -> tuple[Symbol, ...]:
        """The symbols of all ports."""
        return tuple(s for port in self.ports for s in port.symbols)

    @cached_property
    def first(self) -> int:
        """The number of the first instruction's value."""
        return len(self.inputs) + len(self.constants)

    @cached_property
    def varies(self) -> list[bool]:
        """Of each value, whether it depends on more than parameters."""
        found = [not isinstance(s, Parameter) for s in self.inputs] + [False] * len(self.constants)
        for reads in self.args:
            found.append(True in [found[i] for i in reads])
        return found

    def below(self, values: set[int], varies: bool) -> list[int]:
        """The instructions of one tier that `values` need, in ascending order."""
        first, args, tier = self.first, self.args, self.varies
        wanted = {i for i in values if i >= first and tier[i] is varies}
        waiting = list(wanted)
        while waiting:
            for a in args[waiting.pop() - first]:
                if a >= first and tier[a] is varies and a not in wanted:
                    wanted.add(a)
                    waiting.append(a)
        return sorted(wanted)
