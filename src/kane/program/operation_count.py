# SPDX-License-Identifier: BSD-3-Clause
"""The operation receipt of a Program: what each routine costs, by tier and by kind."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from kane.errors import ValueMissingError, none_of
from kane.expr.forms.count import Operations
from kane.program.program import Program


@dataclass(frozen=True, slots=True)
class Receipt:
    """Operations of each routine, in the order of the program.

    Those of parameters are what the routine needs of them; they are computed once for all routines.
    """

    routines: tuple[tuple[str, Operations], ...]

    def __iter__(self) -> Iterator[str]:
        return (name for name, _ in self.routines)

    def __getitem__(self, name: str) -> Operations:
        by_name = dict(self.routines)
        if name not in by_name:
            raise ValueMissingError(f"Expected one of {none_of(by_name, name)}")
        return by_name[name]

    def __str__(self) -> str:
        return "\n".join(f"{name}: {operations}" for name, operations in self.routines)


def receipt(program: Program) -> Receipt:
    """Count the instructions that each routine runs."""
    return Receipt(tuple((r.name, _count(program, r.name)) for r in program.routines))


def _count(program: Program, name: str) -> Operations:
    routine = program.routine(name)
    needed = set(routine.results).union(*(program.arguments(i) for i in routine.body))
    fixed = []
    for i in reversed(program.hoisted):
        if i in needed:
            fixed.append(i)
            needed.update(program.arguments(i))
    costs = [sum(program.op(i).cost for i in block) for block in (fixed, routine.body)]
    kinds: Counter[str] = Counter()
    for i in (*fixed, *routine.body):
        if program.op(i).cost:
            kinds[program.op(i).name] += program.op(i).cost
    return Operations(costs[0], costs[1], tuple(sorted(kinds.items())))
