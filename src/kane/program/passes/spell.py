# SPDX-License-Identifier: BSD-3-Clause
"""Sums and products of many parts become operations of two arguments again, in an order that waits little.

Of the parts always the two that are known first are taken together (as Huffman did with weights, 1952, *Proc. IRE* 40(9), p. 1098):
no order of a lone sum is done sooner, and few partial sums round each term. What depends on parameters alone is known before anything
else, so that it is gathered and hoisted. A product that only one sum reads waits for its factors alone: the processor multiplies and
adds at once.
"""

import dataclasses
import heapq
from dataclasses import dataclass

from kane.expr.ops import ADD, DIV, MUL, NEG, OPS, SQRT, SUB, Op
from kane.program.program import Code

_STEPS = {op: 1 for op in OPS.values() if not op.cost} | {ADD: 1, SUB: 1, MUL: 1, NEG: 0, DIV: 4, SQRT: 6}
"""How long an operation takes, in additions."""
_FUNCTION = 12
"""The same of sines and the like."""
_HOISTED = -1
"""When a value of the tier "parameter" is known."""


@dataclass(slots=True, eq=False)
class Flat:
    """Nodes by number, first the inputs and constants of the code: `kinds[v]` is ADD for a sum, MUL for a product, None for an input.

    `parts` are the arguments, each a node with a sign: 2 v for the node v, 2 v + 1 for its negative. `uses` says how often a node is
    read, `varies` whether it depends on more than parameters. `place` gives the parts that are results.
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


def spelled(code: Code, flat: Flat) -> Code:
    """The code of the nodes that the routines need."""
    writer = _Writer(code, flat)
    routines = tuple(
        dataclasses.replace(g, results=tuple([writer.value(flat.place[i]) for i in g.results])) for g in code.routines
    )
    notes = tuple((writer.value(flat.place[i]), note) for i, note in code.notes)
    return dataclasses.replace(code, ops=tuple(writer.ops), args=tuple(writer.args), routines=routines, notes=notes)


class _Writer:
    """The instructions so far, each once; `ready` says of each value when it is known, `part` which value a node is."""

    def __init__(self, code: Code, flat: Flat) -> None:
        self.flat, self.first = flat, code.first
        self.ops: list[Op] = []
        self.args: list[tuple[int, ...]] = []
        self.ready = [0 if varies else _HOISTED for varies in code.varies[: code.first]]
        self.known: dict[tuple[Op, tuple[int, ...]], int] = {}
        self.part = [2 * v if v < code.first else -1 for v in range(len(flat.kinds))]

    def value(self, part: int) -> int:
        """The value of a part; what it needs is written first."""
        made, parts, kinds = self.part, self.flat.parts, self.flat.kinds
        stack = [part >> 1] if made[part >> 1] < 0 else []
        while stack:
            v = stack[-1]
            if made[v] < 0:
                count = len(stack)
                stack += [p >> 1 for p in reversed(parts[v]) if made[p >> 1] < 0]
                if len(stack) > count:
                    continue
                kind = kinds[v]
                made[v] = self._node(kind, v) if kind is not None else 2 * v
            stack.pop()
        return self._plain(made[part >> 1] ^ (part & 1))

    def _node(self, kind: Op, v: int) -> int:
        """A node whose parts are written, as a part."""
        made = self.part
        parts = [made[p >> 1] ^ (p & 1) for p in self.flat.parts[v]]
        if kind is ADD or kind is MUL:
            return self._both(kind, *parts) if len(parts) == 2 else self._all(kind, v, parts)
        if kind is DIV:
            return 2 * self._emit(DIV, (parts[0] >> 1, parts[1] >> 1)) + ((parts[0] ^ parts[1]) & 1)
        return 2 * self._emit(kind, tuple([self._plain(p) for p in parts]))

    def _all(self, kind: Op, v: int, parts: list[int]) -> int:
        """The sum or product of more than two parts, those first that are known first."""
        ready, kinds, uses = self.ready, self.flat.kinds, self.flat.uses
        heap = [(ready[p >> 1], k, p) for k, p in enumerate(parts)]
        if kind is ADD:
            terms = [p >> 1 for p in self.flat.parts[v]]
            heap = [(at - (kinds[t] is MUL and uses[t] == 1), k, p) for (at, k, p), t in zip(heap, terms, strict=True)]
        heapq.heapify(heap)
        while len(heap) > 1:
            _, i, x = heapq.heappop(heap)
            _, j, y = heap[0]
            both = self._both(kind, x, y) if i < j else self._both(kind, y, x)
            heapq.heapreplace(heap, (ready[both >> 1], min(i, j), both))
        return heap[0][2]

    def _both(self, kind: Op, x: int, y: int) -> int:
        """The sum or product of two parts, as a part."""
        sign = x & 1
        if kind is MUL:
            sign ^= y & 1
        elif (x ^ y) & 1:
            kind, sign = SUB, 0
            if x & 1:
                x, y = y, x
        return 2 * self._emit(kind, (x >> 1, y >> 1)) + sign

    def _plain(self, part: int) -> int:
        """The value of a part, negated where its sign is."""
        return self._emit(NEG, (part >> 1,)) if part & 1 else part >> 1

    def _emit(self, op: Op, reads: tuple[int, ...]) -> int:
        """The value of an instruction, written unless it is there."""
        key = (op, reads)
        found = self.known.get(key)
        if found is None:
            found = self.known[key] = self.first + len(self.ops)
            self.ops.append(op)
            self.args.append(reads)
            ready = self.ready
            last = ready[reads[0]]
            for a in reads:
                if ready[a] > last:
                    last = ready[a]
            ready.append(last + _STEPS.get(op, _FUNCTION) if last >= 0 else last)
        return found
