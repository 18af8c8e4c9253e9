# SPDX-License-Identifier: BSD-3-Clause
"""A Program: frozen straight-line code over named inputs and outputs.

Values are numbered: first the symbols of the ports, port after port, then the constants, then the instructions. An
instruction is an operation and the numbers of its arguments, all smaller than its own.

Each port belongs to a tier. `hoisted` instructions depend on ports of the tier "parameter" alone and run once a set of their values;
the `body` of a routine holds what one evaluation of it needs besides.

A Program run instruction by instruction with NumPy: what its machine code must give, and where it first goes wrong.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from kane.expr.node import Expr, constant, intern_node
from kane.expr.ops import REGULAR, WHERE, Op
from kane.expr.symbols import Symbol


@dataclass(frozen=True, slots=True, eq=False)
class Port:
    """A named input: a vector of symbols, or where it is `scalar` one symbol that is passed as a number.

    Values of the tier "parameter" change seldom: what depends on them alone is computed once. `noun` and `nouns` say what the values
    are ("state", "states"), by default the name. An `optional` port may be left out of a call.
    """

    name: str
    symbols: tuple[Symbol, ...]
    tier: Literal["state", "parameter"] = "state"
    scalar: bool = False
    noun: str = ""
    nouns: str = ""
    optional: bool = False

    def __post_init__(self) -> None:
        noun = self.noun or self.name
        object.__setattr__(self, "noun", noun)
        object.__setattr__(self, "nouns", self.nouns or noun)

    @property
    def hoisted(self) -> bool:
        """Whether what depends on it alone is computed once a set of values."""
        return self.tier == "parameter"


class Operand(NamedTuple):
    """A value, or its negative."""

    value: int
    sign: int


class Pack(NamedTuple):
    """Values of one operation that may be computed side by side, one a lane; of each argument the operand of each lane.

    The operation of differences is that of sums: their signs are with the operands.
    """

    op: Op
    values: tuple[int, ...]
    operands: tuple[tuple[Operand, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Routine:
    """What one call computes: `results` in row-major order of `shape`, by the instructions of `body` once they are chosen.

    `packs` say which of them may be computed in lanes.
    """

    name: str
    shape: tuple[int, ...]
    labels: tuple[str, ...]
    results: tuple[int, ...]
    body: tuple[int, ...] = ()
    packs: tuple[Pack, ...] = ()


class Note(NamedTuple):
    """What to say where a guard is NaN: what is given divided by the `zero` that it guards, or another reason."""

    text: str
    zero: bool = True


@dataclass(frozen=True, eq=False, repr=False)
class Code:
    """Numbered values, from pass to pass: `ops[k]` and `args[k]` belong to the value `first + k`; `subject` says what they are of.

    `notes` say of guards what their NaN means.
    """

    name: str
    subject: str
    ports: tuple[Port, ...]
    constants: tuple[float, ...]
    ops: tuple[Op, ...]
    args: tuple[tuple[int, ...], ...]
    routines: tuple[Routine, ...]
    notes: tuple[tuple[int, Note], ...] = field(default=(), kw_only=True)

    @cached_property
    def inputs(self) -> tuple[Symbol, ...]:
        """The symbols of all ports: values 0, 1 and so on."""
        return tuple(s for port in self.ports for s in port.symbols)

    @cached_property
    def first(self) -> int:
        """The number of the first instruction's value."""
        return len(self.inputs) + len(self.constants)

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


@dataclass(frozen=True, eq=False, repr=False)
class Program(Code):
    """Straight-line code over ports.

    `hoisted` lists the instructions of parameters alone in their order, `kept` those of them that routines read, and parameters that
    limbs read at a time: the vector h.
    """

    hoisted: tuple[int, ...]
    kept: tuple[int, ...]

    def port(self, name: str) -> Port:
        """The port of that name."""
        return next(port for port in self.ports if port.name == name)

    def routine(self, name: str) -> Routine:
        """The routine of that name."""
        for routine in self.routines:
            if routine.name == name:
                return routine
        raise KeyError(f"Expected one of {', '.join(r.name for r in self.routines)}, got {name!r}.")

    @property
    def hoisted_ports(self) -> tuple[Port, ...]:
        """The ports of the tier "parameter"."""
        return tuple(port for port in self.ports if port.hoisted)

    @property
    def lost(self) -> list[str]:
        """What there is to say of results that are NaN, where divisors are guarded."""
        if REGULAR not in self.ops:
            return []
        found = dict.fromkeys(note for _, note in self.notes)
        rows = [f"  {note.text}" for note in found if note.zero]
        others = [f"A result is NaN where there is {note.text}" for note in found if not note.zero]
        if not rows and others:
            return others
        return [
            "A result is NaN where what it is divided by is zero, but for rounding, beside the terms that it is made of:",
            *rows,
            *others,
        ]

    @property
    def signature(self) -> str:
        """The arguments of its routines, with their sizes: "t, x[4], p[5]"; empty ones are left out."""
        return ", ".join(p.name if p.scalar else f"{p.name}[{len(p.symbols)}]" for p in self.ports if p.symbols)

    def op(self, value: int) -> Op:
        """The operation that computes an instruction's value."""
        return self.ops[value - self.first]

    def arguments(self, value: int) -> tuple[int, ...]:
        """The values that an instruction reads."""
        return self.args[value - self.first]

    def __repr__(self) -> str:
        inputs = ", ".join(f"{p.name}[{len(p.symbols)}]" for p in self.ports)
        routines = ", ".join(f"{r.name}{list(r.shape)}" for r in self.routines)
        return f"Program({self.name!r}: {inputs} -> {routines}; {len(self.ops)} instructions)"


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
