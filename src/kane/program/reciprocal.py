# SPDX-License-Identifier: BSD-3-Clause
"""Divisions by one divisor become one reciprocal and multiplications.

A division costs a processor about ten multiplications. x/d becomes x·(1/d) where 1/d serves at least two divisions of a
routine, or can be hoisted because d depends on parameters alone. Results change by a rounding error each, so that the pass belongs
to compilation with contraction and is left out where results must be those of the expressions bit by bit.
"""

from __future__ import annotations

from collections import Counter

from kane.expr.ops import DIV, MUL, Op
from kane.expr.symbols import Parameter
from kane.program.program import Program
from kane.program.tiers import Goal, assembled

_WORTH = 2
"""Divisions by one divisor from which a reciprocal is computed."""


def with_reciprocals(program: Program) -> Program:
    """The program with shared reciprocals."""
    chosen = _divisors(program)
    if not chosen:
        return program
    count = len(program.inputs)
    one = next((count + k for k, v in enumerate(program.constants) if v == 1.0), program.first)
    constants = program.constants if one < program.first else (*program.constants, 1.0)
    first = count + len(constants)
    place = list(range(program.first))
    reciprocal: dict[int, int] = {}
    ops: list[Op] = []
    args: list[tuple[int, ...]] = []

    def emit(op: Op, reads: tuple[int, ...]) -> int:
        ops.append(op)
        args.append(reads)
        return first + len(ops) - 1

    for op, reads in zip(program.ops, program.args, strict=True):
        now = tuple([place[a] for a in reads])
        if op is DIV and reads[1] in chosen and now[0] != one:
            if reads[1] not in reciprocal:
                reciprocal[reads[1]] = emit(DIV, (one, now[1]))
            place.append(emit(MUL, (now[0], reciprocal[reads[1]])))
        elif op is DIV and reads[1] in reciprocal:
            place.append(reciprocal[reads[1]])
        else:
            place.append(emit(op, now))
            if op is DIV and reads[1] in chosen:
                reciprocal[reads[1]] = place[-1]
    goals = [Goal(r.name, r.shape, r.labels, tuple(place[i] for i in r.results)) for r in program.routines]
    return assembled("reciprocal", program.name, program.ports, constants, ops, args, goals)


def _divisors(program: Program) -> set[int]:
    """The divisors whose reciprocal is worth computing."""
    fixed = {i for i, s in enumerate(program.inputs) if isinstance(s, Parameter)}
    fixed.update(range(len(program.inputs), program.first), program.hoisted)
    found: set[int] = set()
    for routine in program.routines:
        uses = Counter(program.arguments(i)[1] for i in routine.body if program.op(i) is DIV)
        found.update(d for d, n in uses.items() if n >= _WORTH or d in fixed)
    return found
