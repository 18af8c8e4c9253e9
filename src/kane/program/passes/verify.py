# SPDX-License-Identifier: BSD-3-Clause
"""Structural verification of a Program: run after each pass that makes or changes one."""

import math
from collections.abc import Iterable
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
