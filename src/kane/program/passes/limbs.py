# SPDX-License-Identifier: BSD-3-Clause
"""Identical limbs side by side: what several parts of a system compute in one way, by other numbers, becomes one vector's lanes.

The legs of a walking machine, the fingers of a hand, the arms of a parallel robot are derived alike, so that their instructions are
the same but for signs and for what they read. Starting from results that are alike, arguments are matched down to the inputs; values
that limbs share stay single, and enter in every lane. Signs are those of lanes: a − b beside a + b is a + (∓b).
"""

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from kane.expr.ops import ADD, COS, DIV, MUL, NEG, REGULAR, SIN, SQRT, SUB
from kane.program.passes.alike import Alike
from kane.program.program import Code, Operand, Pack, Routine

MOST = 8
"""Limbs side by side."""
_LEAST = 400
"""Instructions of a routine from which on limbs are looked for."""
_SHARE = 0.6
"""Of a routine's instructions, how many have to be in lanes."""
_FAR = 100
"""How many values are looked at for the lane of one."""
_OPS = {ADD, SUB, MUL, DIV, SQRT, SIN, COS, REGULAR}


def beside(code: Code) -> Code | None:
    """The code with the packs of its routines; None where no routine has limbs that are alike."""
    routines = tuple(replace(r, packs=_packs(code, r)) for r in code.routines)
    return replace(code, routines=routines) if any(r.packs for r in routines) else None


def _packs(code: Code, routine: Routine) -> tuple[Pack, ...]:
    body = [i for i in code.below(set(routine.results), True) if code.ops[i - code.first] is not NEG]
    if len(body) < _LEAST:
        return ()
    alike = Alike(code)
    own = {alike.plain(i).value for i in routine.results}.intersection(body)
    counts = Counter(n for n in Counter(alike.form[i] for i in own).values() if 2 <= n <= MOST)
    often = Counter(Counter(alike.form[i] for i in body).values())
    # a limb may hold a form several times
    likely = [n for n in counts if sum(m * k for m, k in often.items() if m % n == 0) >= _SHARE * len(body)]
    found = [_from_results(alike, body, routine.results, n) for n in likely]
    best = max(found, key=_laid, default=())
    return best if _laid(best) >= _SHARE * len(body) else ()


def _from_results(alike: Alike, body: Sequence[int], results: Sequence[int], limbs: int) -> tuple[Pack, ...]:
    search = _Search(alike, set(body), limbs)
    search.from_values(results)
    search.from_values(reversed(body))
    for terms in _sums(alike, body):
        search.from_values(terms)
    return tuple(search.packs)


def _sums(alike: Alike, body: Sequence[int]) -> Iterator[list[int]]:
    """The terms of each sum of more than two: where limbs come together, each has one."""
    inside, inner = set(body), set[int]()
    counts = Counter(x.value for i in body for x in alike.reads(i))
    for i in reversed(body):
        if alike.op(i) is not ADD or i in inner:
            continue
        terms, waiting = list[int](), [i]
        while waiting:
            for x in alike.reads(waiting.pop()):
                if x.value in inside and counts[x.value] == 1 and alike.op(x.value) is ADD:
                    inner.add(x.value)
                    waiting.append(x.value)
                elif x.value in inside:
                    terms.append(x.value)
        if len(terms) > 2:
            yield terms


def _laid(packs: Sequence[Pack]) -> int:
    """Values in lanes."""
    return sum(len(p.values) for p in packs)


@dataclass
class _Search:
    """The packs so far, and the `lane` of each value in them; `twins` say of each limb which value stands for which of the first one.

    Arguments of a sum or product that are alike may stand in any order: what is known of them decides, and waits until it is known.
    """

    alike: Alike
    body: set[int]
    limbs: int
    packs: list[Pack] = field(default_factory=list)
    lane: dict[int, int] = field(default_factory=dict)
    twins: list[dict[int, int]] = field(init=False)

    def __post_init__(self) -> None:
        self.twins = [{} for _ in range(self.limbs)]

    def from_values(self, values: Sequence[int] | Iterator[int]) -> None:
        """Packs of those of the values that are alike, as many as there are limbs, and of what they read."""
        kinds: dict[int, dict[int, None]] = {}
        for i in values:
            plain = self.alike.plain(i).value
            if plain in self.body and plain not in self.lane:
                kinds.setdefault(self.alike.form[plain], {})[plain] = None
        for own in kinds.values():
            if len(own) == self.limbs:
                self._matched(self._in_lanes(sorted(own)))

    def _in_lanes(self, values: list[int]) -> tuple[int, ...]:
        """Values in the lanes of what they are made of, as far as that is placed."""
        lanes = [self._lane(i) for i in values]
        if None in lanes or len(set(lanes)) < len(lanes):
            return tuple(values)
        return tuple(i for _, i in sorted(zip(lanes, values, strict=True)))

    def _lane(self, value: int) -> int | None:
        """The lane of what it reads first that is placed."""
        waiting = deque([value])
        for _ in range(_FAR):
            if not waiting:
                break
            i = waiting.popleft()
            if i in self.lane:
                return self.lane[i]
            if i in self.body:
                waiting += [x.value for x in self.alike.reads(i)]
        return None

    def _matched(self, seed: tuple[int, ...]) -> None:
        waiting, later = [seed], deque[tuple[int, ...]]()
        idle = 0
        while waiting or later:
            values = waiting.pop() if waiting else later.popleft()
            if not self._suits(values):
                continue
            lanes = self._lanes(values, idle > len(later))
            if lanes is None:
                later.append(values)
                idle += 1
                continue
            idle = 0
            operands = tuple(zip(*lanes, strict=True))
            self.packs.append(Pack(self.alike.op(values[0]), values, operands))
            self.lane.update((i, k) for k, i in enumerate(values))
            below = [tuple(x.value for x in operand) for operand in operands]
            for known in (values, *below):
                for twin, i in zip(self.twins, known, strict=True):
                    twin.setdefault(known[0], i)
            waiting += below

    def _suits(self, values: tuple[int, ...]) -> bool:
        new = set(values)
        return (
            len(new) == len(values)
            and new <= self.body
            and self.lane.keys().isdisjoint(new)
            and len({self.alike.form[i] for i in values}) == 1
            and self.alike.op(values[0]) in _OPS
        )

    def _lanes(self, values: tuple[int, ...], at_last: bool) -> list[list[Operand]] | None:
        """What each lane reads, in the order of the first; None where that is not known yet and need not be decided."""
        lanes = [self.alike.reads(i) for i in values]
        if self.alike.op(values[0]) not in (ADD, MUL):
            return lanes
        kept = [self._in_order(lanes[0], own, twin) for own, twin in zip(lanes, self.twins, strict=True)]
        if None in kept and not at_last:
            return None
        kept = [self._by_place(lanes[0], own) if k is None else k for k, own in zip(kept, lanes, strict=True)]
        return [own if k else own[::-1] for k, own in zip(kept, lanes, strict=True)]

    def _in_order(self, first: list[Operand], own: list[Operand], twin: dict[int, int]) -> bool | None:
        """Whether the two arguments stand as those of the first limb do; None where nothing tells."""
        (a, b), (x, y) = (o.value for o in first), (o.value for o in own)
        if self.alike.form[a] != self.alike.form[b]:
            return self.alike.form[a] == self.alike.form[x]
        p, q = twin.get(a), twin.get(b)
        if p in (x, y) or q in (x, y):
            return p == x or q == y
        if a in (x, y) or b in (x, y):
            return a == x or b == y
        for form in (self.alike.fine, self.alike.uses):
            if form[a] != form[b] and {form[a], form[b]} == {form[x], form[y]}:
                return form[a] == form[x]
        straight = self._shared(a, x, twin) + self._shared(b, y, twin)
        crossed = self._shared(a, y, twin) + self._shared(b, x, twin)
        return None if straight == crossed else straight > crossed

    def _shared(self, a: int, x: int, twin: dict[int, int], deep: int = 2) -> int:
        """How much of what a reads is known to stand for what x reads."""
        first = self.alike.code.first
        if twin.get(a) == x or a == x:
            return 1
        if not deep or a < first or x < first:
            return 0
        others = [o.value for o in self.alike.reads(x)]
        return sum(
            max((self._shared(o.value, y, twin, deep - 1) for y in others), default=0) for o in self.alike.reads(a)
        )

    def _by_place(self, first: list[Operand], own: list[Operand]) -> bool:
        """The same by the order in which they are computed."""
        (a, b), (x, y) = (o.value for o in first), (o.value for o in own)
        return (a < b) == (x < y)
