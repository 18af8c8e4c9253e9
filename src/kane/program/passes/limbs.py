# SPDX-License-Identifier: BSD-3-Clause
"""Identical limbs side by side: what several parts of a system compute in one way, by other numbers, becomes one vector's lanes.

The legs of a walking machine, the fingers of a hand, the arms of a parallel robot are derived alike, so that their instructions are
the same but for signs and for what they read. Starting from results that are alike, arguments are matched down to the inputs; values
that limbs share stay single, and enter in every lane. Signs are those of lanes: a − b beside a + b is a + (∓b).
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from kane.expr.ops import ADD, COS, DIV, MUL, NEG, REGULAR, SIN, SQRT, SUB, Op
from kane.program.program import Code, Operand, Pack, Routine

MOST = 8
"""Limbs side by side."""
_LEAST = 400
"""Instructions of a routine from which on limbs are looked for."""
_SHARE = 0.6
"""Of a routine's instructions, how many have to be in lanes."""
_OPS = {ADD, SUB, MUL, DIV, SQRT, SIN, COS, REGULAR}


def beside(code: Code) -> Code | None:
    """The code with the packs of its routines; None where no routine has limbs that are alike."""
    routines = tuple(replace(r, packs=_packs(code, r)) for r in code.routines)
    return replace(code, routines=routines) if any(r.packs for r in routines) else None


def _packs(code: Code, routine: Routine) -> tuple[Pack, ...]:
    body = [i for i in code.below(set(routine.results), True) if code.ops[i - code.first] is not NEG]
    if len(body) < _LEAST:
        return ()
    alike = _Alike(code)
    own = {alike.plain(i).value for i in routine.results}.intersection(body)
    counts = Counter(n for n in Counter(alike.form[i] for i in own).values() if 2 <= n <= MOST)
    often = Counter(Counter(alike.form[i] for i in body).values())
    # a limb may hold a form several times
    likely = [n for n in counts if sum(m * k for m, k in often.items() if m % n == 0) >= _SHARE * len(body)]
    found = [_from_results(alike, body, routine.results, n) for n in likely]
    best = max(found, key=_laid, default=())
    return best if _laid(best) >= _SHARE * len(body) else ()


def _from_results(alike: "_Alike", body: Sequence[int], results: Sequence[int], limbs: int) -> tuple[Pack, ...]:
    search = _Search(alike, set(body))
    search.from_values(results, limbs)
    search.from_values(reversed(body), limbs)
    return tuple(search.packs)


def _laid(packs: Sequence[Pack]) -> int:
    """Values in lanes."""
    return sum(len(p.values) for p in packs)


class _Alike:
    """The form of each value: what it computes, whatever the signs and the inputs; 0 of inputs, 1 of constants."""

    def __init__(self, code: Code) -> None:
        self.code = code
        known: dict[tuple[Op | int, ...], int] = {}
        inputs = len(code.inputs)
        self.form = [0] * inputs + [1] * (code.first - inputs)
        for k, (op, reads) in enumerate(zip(code.ops, code.args, strict=True)):
            if not code.varies[code.first + k]:
                self.form.append(0)
                continue
            forms = [self.form[a] for a in reads]
            if op is NEG:
                self.form.append(forms[0])
                continue
            if op is ADD or op is SUB or op is MUL:
                forms.sort()
            self.form.append(known.setdefault((ADD if op is SUB else op, *forms), len(known) + 2))

    def plain(self, i: int) -> Operand:
        """A value without signs before it, and its sign."""
        sign, code = 1, self.code
        while i >= code.first and code.ops[i - code.first] is NEG:
            i, sign = code.args[i - code.first][0], -sign
        return Operand(i, sign)

    def op(self, i: int) -> Op:
        """The operation of an instruction, sums for differences."""
        op = self.code.ops[i - self.code.first]
        return ADD if op is SUB else op

    def reads(self, i: int) -> list[Operand]:
        """What an instruction reads, the sign of a difference with what is taken away."""
        own = [self.plain(a) for a in self.code.args[i - self.code.first]]
        if self.code.ops[i - self.code.first] is SUB:
            own[1] = own[1]._replace(sign=-own[1].sign)
        return own


@dataclass
class _Search:
    alike: _Alike
    body: set[int]
    packs: list[Pack] = field(default_factory=list)
    placed: set[int] = field(default_factory=set)

    def from_values(self, values: Sequence[int] | Iterator[int], limbs: int) -> None:
        """Packs of those of the values that are alike, as many as there are limbs, and of what they read."""
        kinds: dict[int, dict[int, None]] = {}
        for i in values:
            plain = self.alike.plain(i).value
            if plain in self.body and plain not in self.placed:
                kinds.setdefault(self.alike.form[plain], {})[plain] = None
        for own in kinds.values():
            if len(own) == limbs:
                self._matched(tuple(sorted(own)))

    def _matched(self, seed: tuple[int, ...]) -> None:
        waiting = [seed]
        while waiting:
            values = waiting.pop()
            if not self._suits(values):
                continue
            lanes = [self.alike.reads(i) for i in values]
            if self.alike.op(values[0]) in (ADD, MUL):
                lanes = [lanes[0], *(self._ordered(lanes[0], own) for own in lanes[1:])]
            operands = tuple(zip(*lanes, strict=True))
            self.packs.append(Pack(self.alike.op(values[0]), values, operands))
            self.placed.update(values)
            waiting += [tuple(x.value for x in operand) for operand in operands]

    def _suits(self, values: tuple[int, ...]) -> bool:
        new = set(values)
        return (
            len(new) == len(values)
            and new <= self.body
            and self.placed.isdisjoint(new)
            and len({self.alike.form[i] for i in values}) == 1
            and self.alike.op(values[0]) in _OPS
        )

    def _ordered(self, first: list[Operand], own: list[Operand]) -> list[Operand]:
        """The two arguments of a sum or product in the order in which those of the first limb stand."""
        form = self.alike.form
        (a, b), (x, y) = (o.value for o in first), (o.value for o in own)
        if form[a] != form[b]:
            keep = form[a] == form[x]
        elif a in (x, y) or b in (x, y):
            keep = a == x or b == y
        else:
            keep = (a < b) == (x < y)
        return own if keep else own[::-1]
