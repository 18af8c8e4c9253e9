# SPDX-License-Identifier: BSD-3-Clause
"""Conversion of code to a graph of sums and products, and of such a graph to code.

Sums and products of many terms become binary operations in an order with a short critical path.

The two operands that are available first are always combined (Huffman's algorithm, 1952, *Proc. IRE* 40(9), p. 1098): no order of a
single sum finishes earlier, and few partial sums add to the rounding error of each term. Values of parameters are available first, so
that they are combined and hoisted. For a product that only one sum reads, only its factors count, because the processor multiplies and
adds at once.
"""

import dataclasses
import heapq
import math
from dataclasses import dataclass, replace

from kane.expr.ops import ADD, DIV, MUL, NEG, OPS, SQRT, SUB, Op
from kane.program.program import Code
from kane.rewrite.divisors import MOST
from kane.rewrite.graph import ONE, Coefficients, Cube, Graph

_STEPS = {op: 1 for op in OPS.values() if not op.cost} | {ADD: 1, SUB: 1, MUL: 1, NEG: 0, DIV: 4, SQRT: 6}
"""Latencies of operations, in units of an addition."""
_FUNCTION = 12
"""The latency of sines and similar functions."""
_HOISTED = -1
"""The time at which values of the tier "parameter" are available."""


@dataclass(slots=True, eq=False)
class Flat:
    """Nodes by number, first the inputs and constants of the code: `kinds[v]` is ADD for a sum, MUL for a product, None for an input.

    `parts` are the arguments, each a node with a sign: 2 v for the node v, 2 v + 1 for its negative. `uses` is the number of readers
    of a node; `varies` tells whether it depends on anything but parameters. `place` are the parts that are results.
    """

    kinds: list[Op | None]
    parts: list[list[int]]
    varies: list[bool]
    uses: list[int]
    place: list[int]

    def add(self, kind: Op, parts: list[int], varies: bool, uses: int) -> int:
        """Adds a node; returns its number."""
        self.kinds.append(kind)
        self.parts.append(parts)
        self.varies.append(varies)
        self.uses.append(uses)
        return len(self.kinds) - 1


def spelled(code: Code, flat: Flat) -> Code:
    """The code of the nodes on which the routines depend."""
    writer = _Instructions(code, flat)
    routines = tuple(
        dataclasses.replace(g, results=tuple([writer.value(flat.place[i]) for i in g.results])) for g in code.routines
    )
    notes = tuple((writer.value(flat.place[i]), note) for i, note in code.notes)
    return dataclasses.replace(code, ops=tuple(writer.ops), args=tuple(writer.args), routines=routines, notes=notes)


class _Instructions:
    """The instructions so far, without duplicates; `ready` are the times at which values are available, `part` the parts of nodes."""

    def __init__(self, code: Code, flat: Flat) -> None:
        self.flat, self.first = flat, code.first
        self.ops: list[Op] = []
        self.args: list[tuple[int, ...]] = []
        self.ready = [0 if varies else _HOISTED for varies in code.varies[: code.first]]
        self.known: dict[tuple[Op, tuple[int, ...]], int] = {}
        self.part = [2 * v if v < code.first else -1 for v in range(len(flat.kinds))]

    def value(self, part: int) -> int:
        """The value of a part; its dependencies are emitted first."""
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
        """Emits a node whose parts are available; the result as a part."""
        made = self.part
        parts = [made[p >> 1] ^ (p & 1) for p in self.flat.parts[v]]
        if kind is ADD or kind is MUL:
            return self._both(kind, *parts) if len(parts) == 2 else self._all(kind, v, parts)
        if kind is DIV:
            return 2 * self._emit(DIV, (parts[0] >> 1, parts[1] >> 1)) + ((parts[0] ^ parts[1]) & 1)
        return 2 * self._emit(kind, tuple([self._plain(p) for p in parts]))

    def _all(self, kind: Op, v: int, parts: list[int]) -> int:
        """Emits the sum or product of more than two parts, always combining the two that are available first."""
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
        """Emits the sum or product of two parts; the result as a part."""
        sign = x & 1
        if kind is MUL:
            sign ^= y & 1
        elif (x ^ y) & 1:
            kind, sign = SUB, 0
            if x & 1:
                x, y = y, x
        return 2 * self._emit(kind, (x >> 1, y >> 1)) + sign

    def _plain(self, part: int) -> int:
        """The value of a part; a negation is emitted if it has a sign."""
        return self._emit(NEG, (part >> 1,)) if part & 1 else part >> 1

    def _emit(self, op: Op, reads: tuple[int, ...]) -> int:
        """The value of an instruction, emitted unless it exists."""
        key = (op, reads)
        result = self.known.get(key)
        if result is None:
            result = self.known[key] = self.first + len(self.ops)
            self.ops.append(op)
            self.args.append(reads)
            ready = self.ready
            last = ready[reads[0]]
            for a in reads:
                if ready[a] > last:
                    last = ready[a]
            ready.append(last + _STEPS.get(op, _FUNCTION) if last >= 0 else last)
        return result


Terms = list[tuple[int, Cube]]


def read(code: Code) -> Graph:
    """The graph of the results and notes of code, in order; a sum or product that only one other reads is merged into it."""
    return _Reader(code).read()


class _Reader:
    """For each value of the code its node and sign, or, if only one value reads it, its terms; a product has one."""

    def __init__(self, code: Code) -> None:
        self.code, self.g = code, Graph()
        self.node: list[tuple[int, int] | None] = []
        self.terms: list[Terms] = []

    def read(self) -> Graph:
        code, g = self.code, self.g
        wanted = [i for routine in code.routines for i in routine.results] + [i for i, _ in code.notes]
        uses = _uses(code, wanted)
        for port in code.ports:
            self.node += [(g.input(not port.hoisted), 1) for _ in port.symbols]
        self.node += [(g.constant(abs(x)), -1 if x < 0 else 1) if x else (g.nothing(), 1) for x in code.constants]
        self.terms = [[] for _ in self.node]
        for i, (op, args) in enumerate(zip(code.ops, code.args, strict=True), code.first):
            self.node.append(None)
            self.terms.append([])
            if not uses[i]:
                continue
            if op is NEG:
                self._negated(i, args[0], uses[i])
            elif op is ADD or op is SUB:
                self.terms[i] = [*self._as_sum(args[0], 1, i), *self._as_sum(args[1], -1 if op is SUB else 1, i)]
                self._shared_value(i, uses[i])
            elif op is MUL or op is DIV:
                s, a = self._as_product(args[0])
                r, b = self._as_product(args[1]) if a or op is MUL else self._as_literal(args[1])
                b = tuple(sorted([x ^ 1 for x in b])) if op is DIV else b
                self.terms[i] = [(s * r, g.times(a, b))]
                self._shared_value(i, uses[i])
            else:
                self.node[i] = g.function(op, tuple([self._as_node(a) for a in args])), 1
        for i in wanted:
            g.result(*self._as_node(i))
        return g

    def _shared_value(self, i: int, uses: int) -> None:
        """Makes a node of a value with several readers, except for a reciprocal, which is a literal."""
        terms = self.terms[i]
        if uses > 1 and not (len(terms) == 1 and len(terms[0][1]) == 1):
            self._as_node(i)

    def _negated(self, i: int, a: int, uses: int) -> None:
        known = self.node[a]
        if known is not None:
            self.node[i] = known[0], -known[1]
        else:
            self.terms[i] = [(-s, c) for s, c in self.terms[a]]
            self._shared_value(i, uses)

    def _as_node(self, i: int) -> tuple[int, int]:
        result = self.node[i]
        if result is None:
            terms = self._joined(self.terms[i])
            if not terms:
                result = self.g.nothing(), 1
            elif len(terms) == 1 and len(terms[0][1]) == 1 and not terms[0][1][0] & 1:
                result = terms[0][1][0] >> 1, terms[0][0]
            elif len(terms) == 1 and not terms[0][1]:
                result = self.g.constant(1.0), terms[0][0]
            else:
                result = self.g.sum(terms)
            self.node[i] = result
        return result

    def _as_product(self, i: int) -> tuple[int, Cube]:
        terms = self.terms[i]
        if self.node[i] is None and len(terms) == 1 and len(terms[0][1]) <= MOST:
            return terms[0]
        return self._as_literal(i)

    def _as_literal(self, i: int) -> tuple[int, Cube]:
        v, s = self._as_node(i)
        return s, ONE if self.g.number[v] == 1.0 else (2 * v,)

    def _as_sum(self, i: int, sign: int, reader: int) -> Terms:
        terms, tier = self.terms[i], self.code.varies
        if self.node[i] is None and (len(terms) == 1 or tier[i] is tier[reader]):
            return terms if sign > 0 else [(-s, c) for s, c in terms]
        s, cube = self._as_product(i)
        return [(s * sign, cube)]

    def _joined(self, terms: Terms) -> Terms:
        """The terms, with like terms combined."""
        g = self.g
        if len({c for _, c in terms}) == len(terms) and g.numbers.isdisjoint([x for _, c in terms for x in c]):
            return terms
        total = Coefficients(g)
        for s, c in terms:
            rest, size = g.parted(c)
            total.add(rest, s * size)
        return total.terms()


def _uses(code: Code, wanted: list[int]) -> list[int]:
    """The number of times each value is read or wanted."""
    first = code.first
    uses = [0] * (first + len(code.ops))
    for i in wanted:
        uses[i] += 1
    for i in range(first + len(code.ops) - 1, first - 1, -1):
        if uses[i]:
            more = uses[i] if code.ops[i - first] is NEG else 1
            for a in code.args[i - first]:
                uses[a] += more
    return uses


def written(g: Graph, code: Code) -> Code:
    """The code of a graph: shared values once, parameters multiplied first, the reciprocal of a divisor of several terms."""
    writer = _Flattening(g, len(code.inputs))
    places = [2 * writer.node(v) + (s < 0) for v, s in g.results]
    flat = writer.flat
    flat.place = places
    numbers = iter(range(len(places)))
    routines = tuple([replace(r, results=tuple([next(numbers) for _ in r.results])) for r in code.routines])
    notes = tuple([(next(numbers), note) for _, note in code.notes])
    made = replace(code, constants=tuple(writer.constants), ops=(), args=(), routines=routines, notes=notes)
    return spelled(made, flat)


class _Flattening:
    """The flat nodes so far; `part` maps the nodes of the graph to parts."""

    def __init__(self, g: Graph, inputs: int) -> None:
        self.g = g
        order = g.order()
        used = [v for v in range(inputs, len(g.varies)) if g.number[v] is not None]
        self.constants = [x for v in used if (x := g.number[v]) is not None and x != 1.0]
        self.constants += [1.0, *([0.0] if any(g.terms[v] == {} for v in order) else [])]
        numbers = {x: inputs + k for k, x in enumerate(self.constants)}
        first = inputs + len(self.constants)
        self.one = numbers[1.0]
        varies = [*g.varies[:inputs], *[False] * len(self.constants)]
        self.flat = Flat([None] * first, [[] for _ in range(first)], varies, [0] * first, [])
        self.part = {v: 2 * v for v in range(inputs)} | {
            v: 2 * numbers[x] for v in used if (x := g.number[v]) is not None
        }
        self.divides = _divisors(g, order)
        self.inverse: dict[int, int] = {}
        self.products: dict[tuple[int, ...], int] = {}
        self.zero = 2 * numbers[0.0] if 0.0 in numbers else -1
        for v in order:
            if v not in self.part:
                self.part[v] = self._made(v)

    def node(self, v: int) -> int:
        """The flat node of a node of the graph."""
        return self.part[v] >> 1

    def _made(self, v: int) -> int:
        g, part = self.g, self.part
        op = g.op[v]
        if op is not None:
            return self._add(op, [part[a] ^ (s < 0) for a, s in g.args[v]])
        terms = [(g.sign[t], self._product(g.cube[t])) for t in g.of(v)]
        if not terms:
            return self.zero
        if len(terms) == 1:
            ((s, p),) = terms
            return p ^ (s < 0)
        return self._add(ADD, [p ^ (s < 0) for s, p in terms])

    def _product(self, cube: Cube) -> int:
        """A cube as a part: parameters first, then the rest; it is divided once by the product of the divisors that only it has."""
        g = self.g
        if len({(g.varies[x >> 1], x & 1) for x in cube}) == 1 and not cube[0] & 1:
            return self._one_of([self.part[x >> 1] for x in cube])
        groups: dict[tuple[bool, bool], list[int]] = {}
        for x in cube:
            below = bool(x & 1) and self.divides[x >> 1] == 1
            part = self.part[x >> 1] if not x & 1 or below else self._inverse(x >> 1)
            groups.setdefault((g.varies[x >> 1], below), []).append(part)
        top, bottom = (groups.get((True, below), []) for below in (False, True))
        numbers = self._quotient(groups.get((False, False), []), groups.get((False, True), []))
        whole = self._quotient(top if numbers is None else [numbers, *top], bottom)
        return 2 * self.one if whole is None else whole

    def _quotient(self, top: list[int], bottom: list[int]) -> int | None:
        if not bottom:
            return self._one_of(top) if top else None
        x, y = self._one_of(top) if top else 2 * self.one, self._one_of(bottom)
        return self._add(DIV, [x & ~1, y & ~1]) ^ ((x ^ y) & 1)

    def _one_of(self, factors: list[int]) -> int:
        sign = sum(factors) & 1
        plain = [p & ~1 for p in factors]
        return (plain[0] if len(plain) == 1 else self._powers(plain)) ^ sign

    def _powers(self, parts: list[int]) -> int:
        """A product; powers by repeated squaring."""
        if len(parts) == 2 and parts[0] != parts[1]:
            return self._known(parts)
        counts: dict[int, int] = {}
        for p in parts:
            counts[p] = counts.get(p, 0) + 1
        if len(counts) == 1:
            ((p, n),) = counts.items()
            if n == 1:
                return p
            half = self._powers([p] * (n // 2))
            return self._known([half, half] if not n & 1 else [half, half, p])
        return self._known(
            [q for p, n in counts.items() for q in ([p] if n == 1 else [self._powers([p] * n)] if n > 2 else [p, p])]
        )

    def _known(self, parts: list[int]) -> int:
        key = tuple(sorted(parts))
        result = self.products.get(key)
        if result is None:
            result = self.products[key] = self._add(MUL, parts)
        return result

    def _inverse(self, v: int) -> int:
        result = self.inverse.get(v)
        if result is None:
            p = self.part[v]
            result = self.inverse[v] = self._add(DIV, [2 * self.one, p & ~1]) ^ (p & 1)
        return result

    def _add(self, kind: object, parts: list[int]) -> int:
        flat = self.flat
        for p in parts:
            flat.uses[p >> 1] += 1
        varies = True in [flat.varies[p >> 1] for p in parts]
        return 2 * flat.add(kind, parts, varies, 0)  # type: ignore[arg-type]


def _divisors(g: Graph, order: list[int]) -> dict[int, int]:
    """For each divisor, the number of terms that are divided by it."""
    result: dict[int, int] = {}
    for v in order:
        for t in g.of(v):
            for x in {x for x in g.cube[t] if x & 1}:
                result[x >> 1] = result.get(x >> 1, 0) + 1
    return result


def joined(parts: list[Code]) -> Code:
    """The code of the routines of several codes with the same ports; common instructions are shared."""
    inputs = len(parts[0].inputs)
    constants = list(dict.fromkeys([(x, math.copysign(1.0, x)) for part in parts for x in part.constants]))
    numbers = {key: inputs + k for k, key in enumerate(constants)}
    first = inputs + len(constants)
    known: dict[tuple[Op, tuple[int, ...]], int] = {}
    routines, notes = [], []
    for part in parts:
        place = [*range(inputs), *[numbers[x, math.copysign(1.0, x)] for x in part.constants]]
        for op, args in zip(part.ops, part.args, strict=True):
            place.append(known.setdefault((op, tuple([place[a] for a in args])), first + len(known)))
        routines += [replace(r, results=tuple([place[i] for i in r.results])) for r in part.routines]
        notes += [(place[i], note) for i, note in part.notes]
    ops, reads = [op for op, _ in known], [own for _, own in known]
    made = replace(parts[0], constants=tuple([x for x, _ in constants]), ops=tuple(ops), args=tuple(reads))
    return replace(made, routines=tuple(routines), notes=tuple(dict.fromkeys(notes)))
