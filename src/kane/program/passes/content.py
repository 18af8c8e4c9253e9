# SPDX-License-Identifier: BSD-3-Clause
"""Factors that depend on parameters alone leave products and sums, as the content leaves a polynomial.

Every value is c·v with a monomial c of parameters, its content, and v free of them: contents of factors are multiplied, a sum gives
what all of its terms have, a quotient divides. So 1/(l₁ d) and 1/(l₃ d) share 1/d, l₁ (x/l₁) is x, and in a sum of products each term
is multiplied by one number at most, which is hoisted. Results change by rounding errors.
"""

from collections.abc import Iterable
from dataclasses import replace

from kane.expr.ops import ADD, DIV, MUL, Op
from kane.program.passes.nary import Flat, flattened
from kane.program.passes.spell import spelled
from kane.program.passes.verify import verified
from kane.program.program import Code

Content = tuple[tuple[int, int], ...]
"""Nodes that depend on parameters alone, in ascending order, each with its power."""
_MOST = 12
"""Nodes in one content at most: what is longer stays with its value."""


def without_content(code: Code) -> Code:
    """The code with parameters taken out of products and sums and multiplied where they are needed."""
    made = code if 1.0 in code.constants else _with_one(code)
    flat = _Lifted(made, flattened(made)).flat()
    return verified(spelled(made, flat), "content")


def _with_one(code: Code) -> Code:
    """The code with 1 among its constants."""

    def moved(values: Iterable[int]) -> tuple[int, ...]:
        return tuple([v + (v >= code.first) for v in values])

    return replace(
        code,
        constants=(*code.constants, 1.0),
        args=tuple(map(moved, code.args)),
        routines=tuple(replace(g, results=moved(g.results)) for g in code.routines),
        notes=tuple(zip(moved(i for i, _ in code.notes), [note for _, note in code.notes], strict=True)),
    )


class _Lifted:
    """The nodes of `old` as contents times parts of `new`, equal nodes once; what depends on parameters alone is all content."""

    def __init__(self, code: Code, old: Flat) -> None:
        self.code, self.old = code, old
        first = code.first
        self.new = Flat([None] * first, [[] for _ in range(first)], old.varies[:first], [0] * first, [])
        self.known: dict[tuple[Op, tuple[int, ...]], int] = {}
        self.one = 2 * (len(code.inputs) + code.constants.index(1.0))
        found = [self._separated(2 * v, ()) for v in range(first)]
        self.parts, self.contents = [part for part, _ in found], [content for _, content in found]

    def flat(self) -> Flat:
        """All nodes that the routines need."""
        old, new = self.old, self.new
        for v in range(self.code.first, len(old.kinds)):
            part, content = self._node(v)
            if len(content) > _MOST or sum(abs(power) for _, power in content) > 2 * _MOST:
                part, content = self._times(content, part), ()
            part, content = self._separated(part, content)
            self.parts.append(part)
            self.contents.append(content)
        needed = [i for routine in self.code.routines for i in routine.results] + [i for i, _ in self.code.notes]
        places = {i: self._whole(old.place[i]) for i in needed}
        new.place = [places.get(i, -1) for i in range(len(old.place))]
        new.uses = [0] * len(new.kinds)
        for i in needed:
            new.uses[places[i] >> 1] += 1
        for v in range(len(new.kinds) - 1, -1, -1):
            for p in new.parts[v] if new.uses[v] else ():
                new.uses[p >> 1] += 1
        return new

    def _separated(self, part: int, content: Content) -> tuple[int, Content]:
        """A value that depends on parameters alone goes into the content."""
        v = part >> 1
        if self.new.varies[v] or 2 * v == self.one:
            return part, content
        return self.one | (part & 1), _product(content, ((v, 1),))

    def _node(self, v: int) -> tuple[int, Content]:
        """A node of `old` as a part of `new` and its content."""
        kind, parts = self.old.kinds[v], self.old.parts[v]
        if kind is MUL:
            return self._multiplied(parts)
        if kind is DIV:
            return self._divided(*parts)
        if kind is ADD:
            return self._added(parts)
        return self._add(kind, [self._whole(p) for p in parts]), ()

    def _multiplied(self, parts: list[int]) -> tuple[int, Content]:
        reads = [self._read(p) for p in parts]
        sign = sum(q for q, _ in reads) & 1
        left = [q & ~1 for q, _ in reads if q & ~1 != self.one]
        content: Content = ()
        for _, own in reads:
            content = _product(content, own)
        if len(left) > 1:
            return self._add(MUL, left) ^ sign, content
        return (left[0] if left else self.one) ^ sign, content

    def _divided(self, top: int, bottom: int) -> tuple[int, Content]:
        (x, above), (y, below) = self._read(top), self._read(bottom)
        content, sign = _product(above, below, -1), (x ^ y) & 1
        x, y = x & ~1, y & ~1
        if y == self.one:
            return x ^ sign, content
        inverse = self._add(DIV, [self.one, y])
        return (inverse if x == self.one else self._add(MUL, [x, inverse])) ^ sign, content

    def _added(self, parts: list[int]) -> tuple[int, Content]:
        reads = [self._read(p) for p in parts]
        common = dict(reads[0][1])
        for _, content in reads[1:]:
            own = dict(content)
            common = {v: _nearer(n, own[v]) for v, n in common.items() if n * own.get(v, 0) > 0}
        shared = tuple(common.items())
        return self._add(ADD, [self._times(_product(c, shared, -1), q) for q, c in reads]), shared

    def _read(self, part: int) -> tuple[int, Content]:
        """A part of `old` as one of `new` and its content."""
        v = part >> 1
        return self.parts[v] ^ (part & 1), self.contents[v]

    def _whole(self, part: int) -> int:
        """A part of `old` as one of `new`."""
        new, content = self._read(part)
        return self._times(content, new)

    def _times(self, content: Content, part: int) -> int:
        """A part of `new` times a content, which is one number."""
        if not content:
            return part
        top, bottom = ([2 * v for v, n in content for _ in range(sign * n)] for sign in (1, -1))
        factor = self._one_of(top)
        if bottom:
            factor = self._add(DIV, [factor, self._one_of(bottom)])
        return (factor if part & ~1 == self.one else self._add(MUL, [factor, part & ~1])) ^ (part & 1)

    def _one_of(self, factors: list[int]) -> int:
        return self.one if not factors else factors[0] if len(factors) == 1 else self._add(MUL, factors)

    def _add(self, kind: Op | None, parts: list[int]) -> int:
        """The part of a node, which is made unless it is there."""
        assert kind is not None
        key = kind, tuple(sorted(parts) if kind is ADD or kind is MUL else parts)
        found = self.known.get(key)
        if found is None:
            found = self.known[key] = self.new.add(kind, parts, any(self.new.varies[p >> 1] for p in parts), 0)
        return 2 * found


def _product(x: Content, y: Content, power: int = 1) -> Content:
    """x yⁿ."""
    if not y:
        return x
    powers = dict(x)
    for v, n in y:
        powers[v] = powers.get(v, 0) + power * n
    return tuple(sorted((v, n) for v, n in powers.items() if n))


def _nearer(m: int, n: int) -> int:
    """Of two powers of one sign the one nearer to zero."""
    return m if abs(m) < abs(n) else n
