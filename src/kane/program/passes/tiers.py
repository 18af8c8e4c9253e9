# SPDX-License-Identifier: BSD-3-Clause
"""The last pass: code becomes a Program, its instructions sorted into tiers and ordered.

The order keeps live ranges short, so that values stay in registers. Both candidates compute depth first, a value just before it is
used: the order in which expressions were met, and the order that takes of two arguments first the one that needs more registers
(Sethi & Ullman 1970, *J. ACM* 17(4), p. 715, for trees). The one with the smaller sum of live ranges is taken. Greedy orders that
free the most operands at each step have shorter ranges and ran up to 50 % longer on long programs: they interleave what would be
local.

Structural verification of a Program: run after each pass that makes or changes one.

Long blocks cut into chunks, so that the time to compile grows with their length and no faster.

Values that a later chunk reads pass through slots of a work array; a slot is free again after its last reader.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from kane.errors import ProgramError
from kane.expr.ops import ADD, MUL, NEG, SUB
from kane.program.program import Code, Operand, Program, Routine

Checked = TypeVar("Checked", Code, Program)


def verified(code: Checked, after: str) -> Checked:
    """`code`, if it is well formed after the pass of that name: its tables, and of a Program its tiers and order.

    Raises
    ------
    ProgramError
        naming the pass, the place and the instruction where it is not
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
    """Each packed value once, computed by the pack's operation from its operands, but for signs."""
    placed = [i for pack in r.packs for i in pack.values]
    if len(set(placed)) < len(placed) or not set(placed) <= set(r.body):
        return f"a value in two packs of {r.name}, or one that it does not compute"
    for pack in r.packs:
        for lane, i in enumerate(pack.values):
            op = program.op(i)
            own = [_plain(program, a) for a in program.arguments(i)]
            if op is SUB:
                own[1] = own[1]._replace(sign=-own[1].sign)
            given = [operand[lane] for operand in pack.operands]
            turned = pack.op in (ADD, MUL) and own[::-1] == given
            if pack.op is not (ADD if op is SUB else op) or not (own == given or turned):
                return f"a pack of {r.name} that does not compute value {i}"
    return ""


def _plain(program: Program, i: int) -> Operand:
    sign = 1
    while i >= program.first and program.op(i) is NEG:
        (i,), sign = program.arguments(i), -sign
    return Operand(i, sign)


def _defined(program: Program, block: Iterable[int], available: set[int], where: str) -> tuple[set[int], str]:
    """`available` and the values of the block; each must read what stands before it, and stand there once."""
    defined = set(available)
    for i in block:
        if i < program.first or i in defined:
            return defined, f"value {i} in {where} twice, or not an instruction"
        if not defined.issuperset(program.arguments(i)):
            return defined, f"value {i} = {program.op(i).name}{program.arguments(i)} in {where} before its arguments"
        defined.add(i)
    return defined, ""


def assembled(code: Code) -> Program:
    """The Program: what depends on parameters alone is hoisted, and each routine gets the rest of what it needs."""
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
    """`kept` with those together that limbs read at a time, which are one vector then, and parameters among them as they are."""
    given = [port.hoisted for port in code.ports for _ in port.symbols]
    own, order = {*kept, *(i for i, hoisted in enumerate(given) if hoisted)}, dict[int, None]()
    for pack in (p for r in routines for p in r.packs):
        for operand in pack.operands:
            values = [x.value for x in operand]
            if own.issuperset(values) and order.keys().isdisjoint(values) and len(set(values)) == len(values):
                order.update(dict.fromkeys(values))
    return tuple(order | dict.fromkeys(kept))


def live_ranges(code: Code, order: Sequence[int]) -> int:
    """The sum over all values of the distance from their instruction to their last reader; results are stored at once."""
    first, args = code.first, code.args
    place = {i: k for k, i in enumerate(order)}
    last = dict(place)
    for k, i in enumerate(order):
        for a in args[i - first]:
            if a in place:
                last[a] = k
    return sum(last.values()) - sum(place.values())


def _larger_first(code: Code, body: Sequence[int], results: Sequence[int]) -> tuple[int, ...]:
    """`body`, given in ascending order, depth first; of the arguments first the one that needs the most registers."""
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
"""A block of at most this many instructions stays whole: one function is what LLVM schedules best."""
CHUNK = 600
"""Instructions in a chunk of a longer block; from about a thousand, LLVM's time grows faster than the length."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Instructions in order; slots to read before and to write after, and places among the results, by value."""

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
    """`block` as it is, or in chunks of nearly equal length, at most `chunk`.

    Results are written where they are computed, in the last chunk where they are not computed at all.
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
        free.extend(released[k])  # not earlier: this chunk reads them and may write others in the meantime
    return Split(tuple(map(Chunk, pieces, loads, stores, writes)), slots)
