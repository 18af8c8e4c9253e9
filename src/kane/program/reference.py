# SPDX-License-Identifier: BSD-3-Clause
"""A Program run instruction by instruction with NumPy: what its machine code must give, and where it first goes wrong."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.expr.node import Expr, constant, intern_node
from kane.expr.ops import REGULAR, WHERE
from kane.program.program import Note, Program, Routine

_LONGEST = 80


def values(program: Program, block: Iterable[int], inputs: Sequence[Any]) -> dict[int, Any]:
    """Every value after the hoisted instructions and those of `block`; `inputs` are numbers or broadcastable arrays."""
    computed: dict[int, Any] = dict(enumerate(np.float64(v) for v in inputs))
    computed.update(enumerate(map(np.float64, program.constants), len(program.inputs)))
    with np.errstate(all="ignore"):
        for i in (*program.hoisted, *block):
            computed[i] = program.op(i).numpy(*[computed[a] for a in program.arguments(i)])
    return computed


def explain(program: Program, routine: Routine, inputs: Sequence[float]) -> str:
    """Which intermediate is the first that is not finite, and what it is made of; "" where all is finite."""
    computed = values(program, routine.body, inputs)
    bad = [k for k, i in enumerate(routine.results) if not np.isfinite(computed[i])]
    if not bad:
        return ""
    culprit = _origin(program, computed, routine.results[bad[0]])
    names = ", ".join(routine.labels[k] for k in bad[:6]) + (", …" if len(bad) > 6 else "")
    if culprit < program.first:
        return f"{_text(program, culprit)} = {computed[culprit]}; it makes {names} not finite"
    if program.op(culprit) is REGULAR:
        x, size = (float(computed[a]) for a in program.arguments(culprit))
        plain = f"a quotient whose divisor is {_text(program, program.arguments(culprit)[0])}"
        note = dict(program.notes).get(culprit, Note(plain))
        zero = f" = {x:.3g}, which is zero beside its terms of {size:.3g}" if note.zero else ""
        return f"{note.text}{zero}; it makes {names} NaN"
    made_of = {_text(program, a): computed[a] for a in program.arguments(culprit) if a not in _numbers(program)}
    where = ", ".join(f"{text} = {float(value):.6g}" for text, value in made_of.items())
    return f"{_text(program, culprit)} = {float(computed[culprit])} where {where}; it makes {names} not finite"


def _numbers(program: Program) -> range:
    return range(len(program.inputs), program.first)


def _origin(program: Program, computed: Mapping[int, Any], i: int) -> int:
    """From a value that is not finite down to one whose arguments all are."""
    while i >= program.first:
        reads = program.arguments(i)
        if program.op(i) is WHERE and np.isfinite(computed[reads[0]]):
            reads = reads[1:2] if computed[reads[0]] else reads[2:]  # only the branch that was chosen
        bad = [a for a in reads if not np.isfinite(computed[a])]
        if not bad:
            return i
        i = bad[0]
    return i


def _text(program: Program, i: int) -> str:
    text = str(_expression(program, i))
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _expression(program: Program, root: int) -> Expr:
    """The expression that a value stands for, without rewriting."""
    expressions: dict[int, Expr] = {}
    needed = {root}
    for i in range(root, program.first - 1, -1):
        if i in needed:
            needed.update(program.arguments(i))
    for i in sorted(needed):
        if i < len(program.inputs):
            expressions[i] = program.inputs[i]
        elif i < program.first:
            expressions[i] = constant(program.constants[i - len(program.inputs)])
        else:
            expressions[i] = intern_node(program.op(i), *(expressions[a] for a in program.arguments(i)))
    return expressions[root]
