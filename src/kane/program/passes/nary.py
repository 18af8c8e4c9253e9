# SPDX-License-Identifier: BSD-3-Clause
"""Code as sums of many terms and products of many factors, which say nothing of the order of their operations.

A part is a value with a sign: 2·value for the value, 2·value + 1 for its negative. Signs cost nothing, so that NEG disappears: it goes
into the parts of sums and out of products.
"""

from dataclasses import dataclass

from kane.expr.ops import ADD, DIV, MUL, NEG, SUB, Op
from kane.program.program import Code

MOST = 32
"""Parts of one sum or product at most: what looks at pairs of parts then takes a time that grows with the length of the code alone."""
_KIND = {ADD: ADD, SUB: ADD, MUL: MUL}


@dataclass(slots=True, eq=False)
class Flat:
    """Nodes by number, first the inputs and constants of the code: `kinds[v]` is ADD for a sum, MUL for a product, None for an input.

    `parts` are the arguments, `uses` how often a value is read or a result, `varies` whether it depends on more than parameters.
    `place` gives for a value of the code the part that it is, −1 where it went into another one.
    """

    kinds: list[Op | None]
    parts: list[list[int]]
    varies: list[bool]
    uses: list[int]
    place: list[int]

    def add(self, kind: Op, parts: list[int], varies: bool, uses: int) -> int:
        """The number of a new node."""
        self.kinds.append(kind)
        self.parts.append(parts)
        self.varies.append(varies)
        self.uses.append(uses)
        return len(self.kinds) - 1


def flattened(code: Code) -> Flat:
    """Sums of sums and products of products that nothing else reads become one, as long as they belong to one tier."""
    first, varies = code.first, code.varies
    uses = _uses(code)
    absorbed = _absorbed(code, uses)
    flat = Flat([None] * first, [[] for _ in range(first)], varies[:first], uses[:first], [2 * v for v in range(first)])
    place = flat.place
    for i, (op, reads) in enumerate(zip(code.ops, code.args, strict=True), first):
        if op is NEG:
            place.append(place[reads[0]] ^ 1 if place[reads[0]] >= 0 else -1)
            continue
        if absorbed[i] or not uses[i]:
            place.append(-1)
            continue
        kind = _KIND.get(op, op)
        parts = [place[a] for a in reads]
        sign = 0
        if kind is ADD or kind is MUL:
            if -1 in parts:
                parts = _parts(code, place, i)
            elif op is SUB:
                parts[1] ^= 1
        if kind is MUL or kind is DIV:
            for k, p in enumerate(parts):
                if p & 1:
                    sign ^= 1
                    parts[k] = p ^ 1
        place.append(2 * flat.add(kind, parts, varies[i], uses[i]) + sign)
    return flat


def _uses(code: Code) -> list[int]:
    """How often each value is read or a result; what reads a negative reads the value itself."""
    first, args, ops = code.first, code.args, code.ops
    uses = [0] * (first + len(ops))
    for routine in code.routines:
        for i in routine.results:
            uses[i] += 1
    for i in range(first + len(ops) - 1, first - 1, -1):
        if uses[i]:
            more = uses[i] if ops[i - first] is NEG else 1
            for a in args[i - first]:
                uses[a] += more
    return uses


def _absorbed(code: Code, uses: list[int]) -> list[bool]:
    """Of each value, whether it is a part of the only sum or product that reads it."""
    first, varies = code.first, code.varies
    kinds: list[Op | None] = [None] * first
    base = list(range(first))
    size = [1] * first
    absorbed = [False] * (first + len(code.ops))
    for i, (op, reads) in enumerate(zip(code.ops, code.args, strict=True), first):
        kind = _KIND.get(op)
        kinds.append(kind)
        base.append(base[reads[0]] if op is NEG else i)
        total = 1
        if kind is not None and uses[i]:
            total, tier = 2, varies[i]
            a, b = base[reads[0]], base[reads[1]]
            for v in (b, a) if size[a] > size[b] else (a, b):
                if kinds[v] is kind and uses[v] == 1 and varies[v] is tier and total + size[v] - 1 <= MOST:
                    absorbed[v] = True
                    total += size[v] - 1
        size.append(total)
    return absorbed


def _parts(code: Code, place: list[int], root: int) -> list[int]:
    """The parts of a sum or product from left to right."""
    first, ops, args = code.first, code.ops, code.args
    parts: list[int] = []
    stack = [2 * root]
    while stack:
        part = stack.pop()
        i, sign = part >> 1, part & 1
        if i < len(place) and place[i] >= 0:
            parts.append(place[i] ^ sign)
            continue
        op, reads = ops[i - first], args[i - first]
        if op is NEG:
            stack.append(2 * reads[0] + (sign ^ 1))
        else:
            stack.append(2 * reads[1] + (0 if op is MUL else sign ^ (op is SUB)))
            stack.append(2 * reads[0] + sign)
    return parts
