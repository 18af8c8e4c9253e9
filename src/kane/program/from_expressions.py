# SPDX-License-Identifier: BSD-3-Clause
"""From expressions to a Program: common subexpressions are numbered once, and constants folded.

`Bundle` is a record of named groups of expressions that one routine computes; the results are arrays with the groups' shapes.

`Receipt` counts the operations of a Program for each routine, by tier and by kind.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from kane.errors import Attributes, ProgramError, ValueMissingError, none_of
from kane.expr.evaluation import Operations, compile_reference
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr, constant_value, postorder
from kane.expr.numbers import value_of_numbers
from kane.expr.ops import CONST, PI, REGULAR, SYMBOL, Op
from kane.expr.piecewise import lowered
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.program.passes import limbs
from kane.program.passes.optimize import RULES, Rules, optimized, with_reciprocals
from kane.program.program import Code, Note, Port, Program, Routine, assembled, verified
from kane.progress import collecting_seldom


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """The specification of a routine: expressions in row-major order of `shape`, with one label each."""

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
    rules: Rules = RULES,
) -> Program:
    """The Program of the routines in `tasks`; with `reciprocals`, divisions by one divisor share its reciprocal.

    `optimize` reduces operations by `rules`, which change rounding, or, if the code has enough isomorphic subgraphs, leaves it
    unchanged with these as packs. `note` explains the NaN of a guard.

    Raises
    ------
    ValueMissingError
        if an expression contains a symbol that is in no port
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
    side_by_side = limbs.beside(code) if rules.limbs and len(code.ops) >= limbs.LEAST else None
    return assembled(optimized(code, rules) if side_by_side is None else side_by_side)


def _numbered(
    name: str, subject: str, ports: Sequence[Port], tasks: Sequence[Task], note: Callable[[Expr], Note] | None
) -> Code:
    """The code with every expression once, in evaluation order; constant subexpressions are folded."""
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
    """A key that distinguishes 0.0 and −0.0, which compare equal."""
    return value, math.copysign(1.0, value) < 0.0


def _refuse_unknown(order: Iterable[Expr], inputs: Sequence[Symbol], ports: Sequence[Port]) -> None:
    own: set[Expr] = set(inputs)
    unknown = [f"{n} ({type(n).__name__})" for n in order if n.op is SYMBOL and n not in own]
    if unknown:
        listing = "; ".join(f"{p.name}: {', '.join(s.name for s in p.symbols) or 'none'}" for p in ports)
        raise ValueMissingError(f"Expected expressions of the program's inputs ({listing}), got {', '.join(unknown)}.")


def _fold(order: Iterable[Expr]) -> dict[Expr, float]:
    """The value of every constant node; a value that is not finite is not folded, so that it is reported when the code runs."""
    values: dict[Expr, float] = {}
    for node in order:
        if node.op is CONST:
            values[node] = float(constant_value(node) or 0)
        elif node.op is PI:
            values[node] = float(np.pi)
        elif node.args and node.args[0] in values and values.keys() >= {*node.args}:
            value = value_of_numbers(node.op, *(values[a] for a in node.args))
            if np.isfinite(value):
                values[node] = value
    return values


R = TypeVar("R")


@dataclass(frozen=True, slots=True, eq=False)
class Shaped:
    """Expressions in row-major order of a shape."""

    shape: tuple[int, ...]
    roots: tuple[Expr, ...]


def shaped(what: Any) -> Shaped:
    """The expressions and shape of a single expression (shape ()), a sequence (n,) or a Matrix (m, n)."""
    if isinstance(what, Shaped):
        return what
    if isinstance(what, Matrix):
        return Shaped(what.shape, tuple(what.entries))
    if isinstance(what, list | tuple):
        return Shaped((len(what),), tuple(as_expr(x) for x in what))
    return Shaped((), (as_expr(what),))


class Bundle(Generic[R]):
    """Named groups of expressions in the symbols of `ports`; `record(*arrays)` makes the result, with an array for each group."""

    __slots__ = ("_places", "groups", "labels", "name", "ports", "record")

    def __init__(
        self,
        name: str,
        ports: Sequence[Port],
        record: Callable[..., R],
        groups: Mapping[str, Any],
        labels: Sequence[str] | None = None,
    ) -> None:
        names = [f.name for f in fields(record)] if is_dataclass(record) else getattr(record, "_fields", groups)
        if list(names) != list(groups):
            raise ProgramError(f"Expected the groups {', '.join(names)}, got {', '.join(groups)}.")
        self.name, self.ports, self.record = name, tuple(ports), record
        self.groups = {name: shaped(what) for name, what in groups.items()}
        self.labels = [x for n, g in self.groups.items() for x in _labels(n, g)] if labels is None else list(labels)
        self._places: list[tuple[slice, tuple[int, ...]]] = []
        end = 0
        for g in self.groups.values():
            start, end = end, end + math.prod(g.shape)
            self._places.append((slice(start, end), g.shape))

    @property
    def task(self) -> Task:
        """The specification of its routine: all groups, concatenated."""
        roots = tuple(root for g in self.groups.values() for root in g.roots)
        return Task(self.name, roots, (len(roots),), self.labels)

    def split(self, values: Array) -> R:
        """The record of results (…, n); each array is a view with the leading axes, then the shape of its group."""
        lead = values.shape[:-1]
        return self.record(*(values[..., place].reshape(lead + shape) for place, shape in self._places))

    def places(self, name: str) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
        """The indices of a group's results in a row of results, in the shape of the group."""
        place, shape = self._places[list(self.groups).index(name)]
        return np.arange(place.start, place.stop).reshape(shape)

    def reference(self, leaves: Sequence[Expr]) -> Callable[[Sequence[Any]], R]:
        """A function from values of `leaves` to the record, by the reference evaluator, without compilation."""
        run = compile_reference(self.task.roots, leaves)
        return lambda values: self.split(np.array(run(values), dtype=float))


def _labels(name: str, group: Shaped) -> list[str]:
    return [name] if group.shape == () else [f"{name}[{k}]" for k in range(len(group.roots))]


@dataclass(frozen=True, slots=True)
class Receipt(Attributes):
    """Operation counts of each routine, in the order of the program.

    Operations on parameters are those that the routine depends on; a program computes them once for all routines.
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
    """The operation counts of all routines."""
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
