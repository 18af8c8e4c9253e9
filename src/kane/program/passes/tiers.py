# SPDX-License-Identifier: BSD-3-Clause
"""The last pass: code becomes a Program, its instructions sorted into tiers and ordered.

The order keeps live ranges short, so that values stay in registers. Both candidates compute depth first, a value just before it is
used: the order in which expressions were met, and the order that takes of two arguments first the one that needs more registers
(Sethi & Ullman 1970, *J. ACM* 17(4), p. 715, for trees). The one with the smaller sum of live ranges is taken. Greedy orders that
free the most operands at each step have shorter ranges and ran up to 50 % longer on long programs: they interleave what would be
local.
"""

from collections.abc import Sequence
from dataclasses import replace

from kane.program.passes.verify import verified
from kane.program.program import Code, Program, Routine


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
