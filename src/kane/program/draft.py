# SPDX-License-Identifier: BSD-3-Clause
"""A program in the making: numbered instructions and what is wanted of them. Passes go from draft to draft."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from kane.program.program import Code


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A routine before its instructions are chosen: the values it is to give."""

    name: str
    shape: tuple[int, ...]
    labels: tuple[str, ...]
    results: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Draft(Code):
    """Numbered values and what is wanted of them."""

    goals: tuple[Goal, ...]

    @cached_property
    def varies(self) -> list[bool]:
        """Of each value, whether it depends on more than parameters."""
        varying = [not port.hoisted for port in self.ports for _ in port.symbols] + [False] * len(self.constants)
        for reads in self.args:
            varying.append(True in [varying[i] for i in reads])
        return varying

    def below(self, values: set[int], varies: bool) -> list[int]:
        """The instructions of one tier that `values` need, in ascending order."""
        first, args, tier = self.first, self.args, self.varies
        needed = {i for i in values if i >= first and tier[i] is varies}
        waiting = list(needed)
        while waiting:
            for a in args[waiting.pop() - first]:
                if a >= first and tier[a] is varies and a not in needed:
                    needed.add(a)
                    waiting.append(a)
        return sorted(needed)
