# SPDX-License-Identifier: BSD-3-Clause
"""A Program: immutable straight-line code over named inputs and outputs.

Values are numbered: first the symbols of the ports, port after port, then the constants, then the instructions. An instruction is an
operation and the numbers of its arguments, all smaller than its own number.

Each port belongs to a tier. Instructions in `hoisted` depend only on ports of the tier "parameter" and run once per set of parameters;
the `body` of a routine contains the others that one evaluation needs. `values` runs a Program with NumPy, as the reference for machine
code; `explain` finds the first intermediate that is not finite.

Every pass ends in `assembled`, which sorts the instructions into tiers, orders them and verifies the Program. The order keeps live
ranges short, so that values stay in registers. Two depth-first orders, in which a value is computed just before it is used, are
compared: that of the expressions, and the one that first evaluates the argument that needs more registers (Sethi & Ullman 1970, *J.
ACM* 17(4), p. 715, for trees). The one with the smaller sum of live ranges is taken. Greedy orders that free the most operands at each
step have shorter ranges, but ran up to 50 % longer on long programs, because they interleave unrelated subexpressions.

Long blocks are cut into chunks, so that compile time grows linearly with their length. Values that a later chunk reads pass through
slots of a work array; a slot is reused after its last reader.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np

from kane.errors import ProgramError
from kane.expr.node import Expr, constant, intern_node
from kane.expr.ops import ADD, MUL, NEG, REGULAR, SUB, WHERE, Op
from kane.expr.symbols import Symbol


@dataclass(frozen=True, slots=True, eq=False)
class Port:
    """A named input: a vector of symbols, or, if `scalar`, one symbol that is passed as a number.

    Values of the tier "parameter" change seldom: what depends only on them is computed once. `noun` and `nouns` name the values in
    messages ("state", "states"); the default is the name. An `optional` port may be omitted in a call.
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
        """Whether values that depend only on this port are computed once per set of parameters."""
        return self.tier == "parameter"


class Operand(NamedTuple):
    """A value, possibly negated."""

    value: int
    sign: int


class Pack(NamedTuple):
    """Values of one operation that may be computed in the lanes of a vector; for each argument the operand in each lane.

    The operation of differences is ADD: the signs are in the operands.
    """

    op: Op
    values: tuple[int, ...]
    operands: tuple[tuple[Operand, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Routine:
    """The computation of one call: `results` in row-major order of `shape`, by the instructions of `body`, which `assembled` sets.

    `packs` are the groups of instructions that may be computed in vector lanes.
    """

    name: str
    shape: tuple[int, ...]
    labels: tuple[str, ...]
    results: tuple[int, ...]
    body: tuple[int, ...] = ()
    packs: tuple[Pack, ...] = ()


class Note(NamedTuple):
    """The explanation of a guard that is NaN: `text` describes the zero divisor if `zero`, else another reason."""

    text: str
    zero: bool = True


@dataclass(frozen=True, eq=False, repr=False)
class Code:
    """Straight-line code as passes exchange it: `ops[k]` and `args[k]` compute the value `first + k`; `notes` explain NaN guards.

    `subject` says in messages what the values describe.
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
        """The symbols of all ports, which are the values 0, 1, …."""
        return tuple(s for port in self.ports for s in port.symbols)

    @cached_property
    def first(self) -> int:
        """The number of the first instruction's value."""
        return len(self.inputs) + len(self.constants)

    @cached_property
    def varies(self) -> list[bool]:
        """For each value, whether it depends on anything but parameters."""
        varying = [not port.hoisted for port in self.ports for _ in port.symbols] + [False] * len(self.constants)
        for reads in self.args:
            varying.append(True in [varying[i] for i in reads])
        return varying

    def plain(self, i: int) -> Operand:
        """A value without its negations, and the sign."""
        sign = 1
        while i >= self.first and self.ops[i - self.first] is NEG:
            (i,), sign = self.args[i - self.first], -sign
        return Operand(i, sign)

    def signed(self, i: int) -> list[Operand]:
        """The operands of an instruction; those of a difference with the sign of the subtrahend changed."""
        own = [self.plain(a) for a in self.args[i - self.first]]
        if self.ops[i - self.first] is SUB:
            own[1] = own[1]._replace(sign=-own[1].sign)
        return own

    def below(self, values: set[int], varies: bool) -> list[int]:
        """The instructions of one tier on which `values` depend, in ascending order."""
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
    """Straight-line code over ports, sorted into tiers.

    `hoisted` lists the instructions that depend only on parameters, in order; `kept` is the vector h: those that routines read, and
    parameters that packs read as vectors.
    """

    hoisted: tuple[int, ...]
    kept: tuple[int, ...]

    def port(self, name: str) -> Port:
        """The port with a name."""
        return next(port for port in self.ports if port.name == name)

    def routine(self, name: str) -> Routine:
        """The routine with a name."""
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
        """Explanations of the results that are NaN when divisors are guarded."""
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
        """The arguments of its routines, with their sizes: "t, x[4], p[5]"; empty ports are omitted."""
        return ", ".join(p.name if p.scalar else f"{p.name}[{len(p.symbols)}]" for p in self.ports if p.symbols)

    def op(self, value: int) -> Op:
        """The operation of an instruction."""
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
    """All values after the hoisted instructions and those of `block`; `inputs` are numbers or broadcastable arrays."""
    computed: dict[int, Any] = dict(enumerate(np.float64(v) for v in inputs))
    computed.update(enumerate(map(np.float64, program.constants), len(program.inputs)))
    with np.errstate(all="ignore"):
        for i in (*program.hoisted, *block):
            computed[i] = program.op(i).numpy(*[computed[a] for a in program.arguments(i)])
    return computed


def explain(program: Program, routine: Routine, inputs: Sequence[float]) -> str:
    """A message that names the first intermediate that is not finite, and its operands; "" if all values are finite."""
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
    """A value that is not finite and whose arguments all are, reached from value i."""
    while i >= program.first:
        reads = program.arguments(i)
        if program.op(i) is WHERE and np.isfinite(computed[reads[0]]):
            reads = reads[1:2] if computed[reads[0]] else reads[2:]  # only the selected branch
        bad = [a for a in reads if not np.isfinite(computed[a])]
        if not bad:
            return i
        i = bad[0]
    return i


def _text(program: Program, i: int) -> str:
    text = str(_expression(program, i))
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _expression(program: Program, root: int) -> Expr:
    """The expression that a value represents, without simplification."""
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


Checked = TypeVar("Checked", Code, Program)


def verified(code: Checked, after: str) -> Checked:
    """`code`, if it is well formed after the pass with the given name: its tables and, for a Program, its tiers and order.

    Raises
    ------
    ProgramError
        if it is not; the message names the pass and the instruction
    """
    fault = _tables(code) or _results(code)
    if isinstance(code, Program):
        fault = fault or _hoisted(code) or _routines(code)
    if fault:
        raise ProgramError(f"Expected a well-formed program {code.name!r} after the pass {after!r}, got {fault}.")
    return code


def _results(code: Code) -> str:
    count = code.first + len(code.ops)
    for r in code.routines:
        if not len(r.results) == len(r.labels) == math.prod(r.shape):
            return f"{len(r.results)} results and {len(r.labels)} labels of shape {r.shape} in {r.name}"
        if not all(0 <= i < count for i in r.results):
            return f"a result in {r.name} that no instruction computes"
    return ""


def _tables(program: Code) -> str:
    first = program.first
    if len(program.ops) != len(program.args):
        return f"{len(program.ops)} operations and {len(program.args)} lists of arguments"
    if not all(map(math.isfinite, program.constants)):
        return "a constant that is not finite"
    if len({port.name for port in program.ports}) != len(program.ports):
        return "two ports of one name"
    for port in program.ports:
        if not (port.name.isascii() and port.name.isidentifier()):
            return f"a port whose name {port.name!r} is no identifier"
        if port.scalar and len(port.symbols) != 1:
            return f"{len(port.symbols)} symbols in the port {port.name}, which is a number"
        if len({s.name for s in port.symbols}) != len(port.symbols):
            return f"two symbols of one name in the port {port.name}"
    for i, (op, reads) in enumerate(zip(program.ops, program.args, strict=True), first):
        if len(reads) == op.arity == 2 and 0 <= reads[0] < i and 0 <= reads[1] < i:
            continue
        if not op.arity or len(reads) != op.arity or not 0 <= min(reads) <= max(reads) < i:
            return f"value {i} = {op.name}{reads}"
    return ""


def _hoisted(program: Program) -> str:
    hoisted = [port.hoisted for port in program.ports for _ in port.symbols]
    fixed = {i for i, own in enumerate(hoisted) if own} | set(range(len(hoisted), program.first))
    defined, fault = _defined(program, program.hoisted, fixed, "hoisted")
    if not fault and not defined.issuperset(program.kept):
        return "a kept value that is not hoisted"
    return fault


def _routines(program: Program) -> str:
    available = {*range(program.first), *program.kept}
    for r in program.routines:
        defined, fault = _defined(program, r.body, available, r.name)
        if fault:
            return fault
        if not defined.issuperset(r.results):
            return f"a result in {r.name} that is not computed"
        if not set(r.results).union(*map(program.arguments, r.body)).issuperset(r.body):
            return f"an instruction in {r.name} whose value is not used"
        if fault := _packs(program, r):
            return fault
    return ""


def _packs(program: Program, r: Routine) -> str:
    """Checks that each packed value occurs once and is the pack's operation on its operands up to signs; the error, or ""."""
    placed = [i for pack in r.packs for i in pack.values]
    if len(set(placed)) < len(placed) or not set(placed) <= set(r.body):
        return f"a value in two packs of {r.name}, or one that it does not compute"
    for pack in r.packs:
        for lane, i in enumerate(pack.values):
            op = program.op(i)
            own = program.signed(i)
            given = [operand[lane] for operand in pack.operands]
            turned = pack.op in (ADD, MUL) and own[::-1] == given
            if pack.op is not (ADD if op is SUB else op) or not (own == given or turned):
                return f"a pack of {r.name} that does not compute value {i}"
    return ""


def _defined(program: Program, block: Iterable[int], available: set[int], where: str) -> tuple[set[int], str]:
    """Adds the values of the block to `available`; checks that each is computed once, after its arguments."""
    defined = set(available)
    for i in block:
        if i < program.first or i in defined:
            return defined, f"value {i} in {where} twice, or not an instruction"
        if not defined.issuperset(program.arguments(i)):
            return defined, f"value {i} = {program.op(i).name}{program.arguments(i)} in {where} before its arguments"
        defined.add(i)
    return defined, ""


def assembled(code: Code) -> Program:
    """The Program: instructions that depend only on parameters are hoisted, and each routine gets the others that it needs."""
    first, args = code.first, code.args
    routines = []
    read: set[int] = set()
    for routine in code.routines:
        body = code.below(set(routine.results), True)
        read.update(routine.results, *(args[i - first] for i in body))
        orders = (tuple(body), _larger_first(code, body, routine.results))
        routines.append(replace(routine, body=min(orders, key=lambda order: live_ranges(code, order))))
    hoisted = tuple(code.below(read, False))
    kept = _side_by_side(code, routines, [i for i in hoisted if i in read])
    parts = (code.name, code.subject, code.ports, code.constants, code.ops, args)
    return verified(Program(*parts, tuple(routines), hoisted, kept, notes=code.notes), "tiers")


def _side_by_side(code: Code, routines: Sequence[Routine], kept: Sequence[int]) -> tuple[int, ...]:
    """`kept`, with values that packs read as a vector contiguous, parameters among them included."""
    given = [port.hoisted for port in code.ports for _ in port.symbols]
    own, order = {*kept, *(i for i, hoisted in enumerate(given) if hoisted)}, dict[int, None]()
    for pack in (p for r in routines for p in r.packs):
        for operand in pack.operands:
            values = [x.value for x in operand]
            if own.issuperset(values) and order.keys().isdisjoint(values) and len(set(values)) == len(values):
                order.update(dict.fromkeys(values))
    return tuple(order | dict.fromkeys(kept))


def live_ranges(code: Code, order: Sequence[int]) -> int:
    """The sum over all values of the distance from their instruction to their last reader; results are stored immediately."""
    first, args = code.first, code.args
    place = {i: k for k, i in enumerate(order)}
    last = dict(place)
    for k, i in enumerate(order):
        for a in args[i - first]:
            if a in place:
                last[a] = k
    return sum(last.values()) - sum(place.values())


def _larger_first(code: Code, body: Sequence[int], results: Sequence[int]) -> tuple[int, ...]:
    """`body`, given in ascending order, in depth-first order; the argument that needs the most registers comes first."""
    first, args = code.first, code.args
    need: dict[int, int] = {}
    for i in body:
        reads = args[i - first]
        if len(reads) == 2 and reads[0] != reads[1]:
            a, b = need.get(reads[0], 0), need.get(reads[1], 0)
            need[i] = max(a, b, 1) + (a == b > 0)
        else:
            below = sorted([need[a] for a in set(reads) if a in need], reverse=True)
            need[i] = max(1, *(n + k for k, n in enumerate(below))) if below else 1
    order: dict[int, None] = {}
    for result in results:
        stack = [result] if result in need else []
        while stack:
            i = stack[-1]
            waiting = [a for a in args[i - first] if a in need and a not in order] if i not in order else ()
            if not waiting:
                order[stack.pop()] = None
            elif len(waiting) == 1:
                stack.append(waiting[0])
            else:
                stack += sorted(set(waiting), key=lambda a: (need[a], -a))
    return tuple(order)


WHOLE = 1500
"""Blocks of at most this many instructions are not split: LLVM schedules a single function best."""
CHUNK = 600
"""Instructions in a chunk of a longer block; beyond about a thousand, LLVM's time grows faster than linearly."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Instructions in order; the slots to read first and to write last, and the positions among the results, by value."""

    instructions: tuple[int, ...]
    loads: dict[int, int]
    stores: dict[int, int]
    writes: dict[int, list[int]]


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """The chunks of a block and the length of the work array."""

    chunks: tuple[Chunk, ...]
    slots: int


def split(
    program: Program, block: Sequence[int], whole: float = WHOLE, chunk: int = CHUNK, results: Sequence[int] = ()
) -> Split:
    """`block` as one chunk, or in chunks of nearly equal length, at most `chunk`.

    Results are written where they are computed, or in the last chunk if they are not computed in the block.
    """
    count = 1 if len(block) <= whole else -(-len(block) // chunk)
    size = max(1, -(-len(block) // count))
    pieces = [tuple(block[k : k + size]) for k in range(0, len(block), size)] or [()]
    home = {i: k for k, piece in enumerate(pieces) for i in piece}
    writes: list[dict[int, list[int]]] = [{} for _ in pieces]
    for place, i in enumerate(results):
        writes[home.get(i, len(pieces) - 1)].setdefault(i, []).append(place)
    if len(pieces) == 1:
        return Split((Chunk(pieces[0], {}, {}, writes[0]),), 0)

    readers: dict[int, list[int]] = {}
    for k, piece in enumerate(pieces):
        for i in piece:
            for a in program.arguments(i):
                if home.get(a, k) != k:
                    chunks = readers.setdefault(a, [])
                    if not chunks or chunks[-1] != k:
                        chunks.append(k)

    loads: list[dict[int, int]] = [{} for _ in pieces]
    stores: list[dict[int, int]] = [{} for _ in pieces]
    released: list[list[int]] = [[] for _ in pieces]
    free: list[int] = []
    slots = 0
    for k, piece in enumerate(pieces):
        for i in piece:
            if i not in readers:
                continue
            if free:
                slot = free.pop()
            else:
                slot, slots = slots, slots + 1
            stores[k][i] = slot
            for reader in readers[i]:
                loads[reader][i] = slot
            released[readers[i][-1]].append(slot)
        free.extend(released[k])  # not earlier: this chunk reads these slots, and may write others before that
    return Split(tuple(map(Chunk, pieces, loads, stores, writes)), slots)
