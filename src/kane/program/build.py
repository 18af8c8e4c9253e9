# SPDX-License-Identifier: BSD-3-Clause
"""From expressions to a Program: values numbered, constants folded."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kane.collector import collecting_seldom
from kane.errors import ValueMissingError
from kane.expr.constants import value_of_numbers
from kane.expr.node import Expr, constant_value, postorder
from kane.expr.ops import CONST, PI, REGULAR, SYMBOL, Op
from kane.expr.piecewise import lowered
from kane.expr.symbols import Symbol
from kane.program.passes.limbs import beside
from kane.program.passes.optimize import optimized
from kane.program.passes.reciprocal import with_reciprocals
from kane.program.passes.tiers import assembled
from kane.program.passes.verify import verified
from kane.program.program import Code, Note, Port, Program, Routine


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a routine is to compute: expressions in row-major order of `shape`, with a label each."""

    name: str
    roots: Sequence[Expr]
    shape: tuple[int, ...]
    labels: Sequence[str]


@collecting_seldom()
def build_program(
    name: str,
    ports: Sequence[Port],
    tasks: Sequence[Task],
    reciprocals: bool = False,
    subject: str = "expressions",
    note: Callable[[Expr], Note] | None = None,
    optimize: bool = False,
) -> Program:
    """The Program of the routines in `wanted`; `reciprocals` lets divisions by one divisor share its reciprocal.

    `optimize` rewrites to fewer operations, which round in another order, or leaves identical limbs as they are, side by side. `note`
    says of a guard what its NaN means.

    Raises
    ------
    ValueMissingError
        if an expression holds a symbol that no port gives
    """
    memo: dict[Expr, Expr] = {}
    tasks = [replace(task, roots=lowered(task.roots, memo)) for task in tasks]
    if memo and note is not None:
        declared, said = {image: node for node, image in memo.items()}, note

        def note(guard: Expr) -> Note:
            return said(declared.get(guard, guard))

    code = _numbered(name, subject, ports, tasks, note)
    code = with_reciprocals(code) if reciprocals else code
    if not optimize:
        return assembled(code)
    limbs = beside(code)
    return assembled(optimized(code) if limbs is None else limbs)


def _numbered(
    name: str, subject: str, ports: Sequence[Port], tasks: Sequence[Task], note: Callable[[Expr], Note] | None
) -> Code:
    """Every expression once, in the order of evaluation; subexpressions of constants alone are folded."""
    order = postorder(root for w in tasks for root in w.roots)
    inputs = [s for port in ports for s in port.symbols]
    _refuse_unknown(order, inputs, ports)
    folded = _fold(order)
    read = {a for node in order if node not in folded for a in node.args}.union(root for w in tasks for root in w.roots)
    numbers = {_key(v): v for node, v in folded.items() if node in read}
    place: dict[Expr, int] = {s: i for i, s in enumerate(inputs)}
    of_number = {key: len(inputs) + i for i, key in enumerate(numbers)}
    place.update((node, of_number[_key(v)]) for node, v in folded.items() if node in read)

    first = len(inputs) + len(numbers)
    ops: list[Op] = []
    args: list[tuple[int, ...]] = []
    for node in order:
        if node not in place and node not in folded:
            place[node] = first + len(ops)
            ops.append(node.op)
            args.append(tuple([place[a] for a in node.args]))
    routines = tuple(Routine(w.name, tuple(w.shape), tuple(w.labels), tuple(place[r] for r in w.roots)) for w in tasks)
    notes = tuple((place[n], note(n)) for n in order if n.op is REGULAR and n in place) if note else ()
    code = Code(name, subject, tuple(ports), tuple(numbers.values()), tuple(ops), tuple(args), routines, notes=notes)
    return verified(code, "build")


def _key(value: float) -> tuple[float, bool]:
    """0.0 and −0.0 are equal and not the same."""
    return value, bool(np.signbit(value))


def _refuse_unknown(order: Iterable[Expr], inputs: Sequence[Symbol], ports: Sequence[Port]) -> None:
    own: set[Expr] = set(inputs)
    unknown = [f"{n} ({type(n).__name__})" for n in order if n.op is SYMBOL and n not in own]
    if unknown:
        listing = "; ".join(f"{p.name}: {', '.join(s.name for s in p.symbols) or 'none'}" for p in ports)
        raise ValueMissingError(f"Expected expressions of the program's inputs ({listing}), got {', '.join(unknown)}.")


def _fold(order: Iterable[Expr]) -> dict[Expr, float]:
    """The value of every node of constants alone; what is not finite stays an instruction, to be found when it runs."""
    values: dict[Expr, float] = {}
    for node in order:
        if node.op is CONST:
            values[node] = float(constant_value(node) or 0)
        elif node.op is PI:
            values[node] = float(np.pi)
        elif node.args and all(a in values for a in node.args):
            value = value_of_numbers(node.op, *(values[a] for a in node.args))
            if np.isfinite(value):
                values[node] = value
    return values
