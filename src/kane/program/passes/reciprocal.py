# SPDX-License-Identifier: BSD-3-Clause
"""Divisions by one divisor become one reciprocal and multiplications.

A division costs a processor about ten multiplications. x/d becomes x·(1/d) where 1/d serves at least two divisions of a
routine, or can be hoisted because d depends on parameters alone. Results change by a rounding error each, so that the pass belongs
to compilation with contraction and is left out where results must be those of the expressions bit by bit.
"""

import dataclasses
from collections import Counter

from kane.expr.ops import DIV, MUL, Op
from kane.program.passes.verify import verified
from kane.program.program import Code

_WORTH = 2
"""Divisions by one divisor from which a reciprocal is computed."""


def with_reciprocals(code: Code) -> Code:
    """The code with shared reciprocals."""
    chosen = _divisors(code)
    if not chosen:
        return code
    count = len(code.inputs)
    one = next((count + k for k, v in enumerate(code.constants) if v == 1.0), code.first)
    constants = code.constants if one < code.first else (*code.constants, 1.0)
    first = count + len(constants)
    place = list(range(code.first))
    reciprocal: dict[int, int] = {}
    ops: list[Op] = []
    args: list[tuple[int, ...]] = []

    def emit(op: Op, reads: tuple[int, ...]) -> int:
        ops.append(op)
        args.append(reads)
        return first + len(ops) - 1

    for op, reads in zip(code.ops, code.args, strict=True):
        now = tuple([place[a] for a in reads])
        if op is not DIV or reads[1] not in chosen:
            place.append(emit(op, now))
            continue
        divisor = reads[1]
        if divisor not in reciprocal:
            reciprocal[divisor] = emit(DIV, (one, now[1]))
        inverse = reciprocal[divisor]
        place.append(inverse if now[0] == one else emit(MUL, (now[0], inverse)))
    routines = tuple(dataclasses.replace(g, results=tuple(place[i] for i in g.results)) for g in code.routines)
    notes = tuple((place[i], text) for i, text in code.notes)
    result = dataclasses.replace(
        code, constants=constants, ops=tuple(ops), args=tuple(args), routines=routines, notes=notes
    )
    return verified(result, "reciprocal")


def _divisors(code: Code) -> set[int]:
    """The divisors whose reciprocal is worth computing."""
    divisors: set[int] = set()
    for routine in code.routines:
        below = code.below(set(routine.results), True)
        divided = [code.args[i - code.first][1] for i in below if code.ops[i - code.first] is DIV]
        divisors.update(d for d, n in Counter(divided).items() if n >= _WORTH or not code.varies[d])
    return divisors
