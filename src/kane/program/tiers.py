# SPDX-License-Identifier: BSD-3-Clause
"""The last step of every pass: numbered instructions become a Program with its tiers, and are verified."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kane.expr.ops import Op
from kane.expr.symbols import Parameter
from kane.program.program import Port, Program, Routine
from kane.program.schedule import schedule
from kane.program.verify import verified


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A routine before its instructions are chosen: the values it is to give."""

    name: str
    shape: tuple[int, ...]
    labels: tuple[str, ...]
    results: tuple[int, ...]


def assembled(
    after: str,
    name: str,
    ports: tuple[Port, ...],
    constants: tuple[float, ...],
    ops: Sequence[Op],
    args: Sequence[tuple[int, ...]],
    goals: Sequence[Goal],
) -> Program:
    """The Program: what depends on parameters alone is hoisted, and each routine gets the rest of what it needs."""
    inputs = [s for port in ports for s in port.symbols]
    first = len(inputs) + len(constants)
    varies = [not isinstance(s, Parameter) for s in inputs] + [False] * len(constants)
    for reads in args:
        varies.append(any(varies[i] for i in reads))
    routines = []
    read: set[int] = set()
    for goal in goals:
        body = _below(goal.results, first, args, varies, True)
        read.update(goal.results, *(args[i - first] for i in body))
        order = schedule(body, goal.results, first, args)
        routines.append(Routine(goal.name, goal.shape, goal.labels, goal.results, order))
    hoisted = tuple(_below(read, first, args, varies, False))
    kept = tuple(i for i in hoisted if i in read)
    program = Program(name, ports, constants, tuple(ops), tuple(args), hoisted, kept, tuple(routines))
    return verified(program, after)


def _below(
    results: Iterable[int], first: int, args: Sequence[tuple[int, ...]], varies: Sequence[bool], tier: bool
) -> list[int]:
    """The instructions of one tier that the results need, in ascending order."""
    wanted = {i for i in results if i >= first and varies[i] is tier}
    waiting = list(wanted)
    while waiting:
        for a in args[waiting.pop() - first]:
            if a >= first and varies[a] is tier and a not in wanted:
                wanted.add(a)
                waiting.append(a)
    return sorted(wanted)
