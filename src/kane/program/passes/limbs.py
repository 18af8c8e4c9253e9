# SPDX-License-Identifier: BSD-3-Clause
"""Superword-level parallelism (Larsen & Amarasinghe 2000, *PLDI*): isomorphic subgraphs ("limbs") are computed in vector lanes.

The legs of a walking machine, the fingers of a hand or the arms of a parallel robot have the same instructions except for signs and
inputs. Starting from isomorphic results, arguments are matched down to the inputs; values that limbs share remain scalars and are
broadcast. Signs belong to lanes: a − b in one lane and a + b in another are a + (∓b).

Two values have the same form if they are computed by the same operations, regardless of signs and inputs.

`gathered` places sines and cosines of as many angles as a vector has lanes next to each other in a long block.

In a depth-first order the sines and cosines of each angle would be where the first of them is read, link by link, with few of them in
each piece of the block, although a vector of eight angles takes as much code as one. Angles that are inputs, or one operation on
inputs, are available as soon as the first of eight is needed.
"""

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from kane.expr.ops import ADD, COS, DIV, MUL, NEG, REGULAR, SIN, SQRT, SUB, Op
from kane.program.program import Code, Operand, Pack, Program, Routine

_NEAR = 3
"""The number of levels of readers that distinguish values of the same form."""


class Alike:
    """The form of each value: the operations that compute it, regardless of signs and inputs; 0 for inputs, 1 for constants.

    Values that depend only on parameters count as inputs; their `fine` form, which includes their operations, distinguishes them.
    """

    def __init__(self, code: Code) -> None:
        self.code = code
        known: dict[tuple[Op | int, ...], int] = {}
        inputs = len(code.inputs)
        self.form = [0] * inputs + [1] * (code.first - inputs)
        self.fine = list(self.form)
        for k, (op, reads) in enumerate(zip(code.ops, code.args, strict=True)):
            if not code.varies[code.first + k]:
                fine = sorted(self.fine[a] for a in reads)
                same = op is NEG
                self.fine.append(
                    fine[0] if same else known.setdefault((ADD if op is SUB else op, *fine), len(known) + 2)
                )
                self.form.append(0)
                continue
            self.fine.append(0)
            forms = [self.form[a] for a in reads]
            if op is NEG:
                self.form.append(forms[0])
                continue
            if op is ADD or op is SUB or op is MUL:
                forms.sort()
            self.form.append(known.setdefault((ADD if op is SUB else op, *forms), len(known) + 2))

    @cached_property
    def uses(self) -> list[int]:
        """For each value a number for its form and those of `_NEAR` levels of readers, too few to reach the sums over limbs."""
        code, known = self.code, dict[tuple[int, ...], int]()
        result = self.form
        for _ in range(_NEAR):
            read: list[list[int]] = [[] for _ in result]
            for i in reversed(range(code.first, len(result))):
                op, args = code.ops[i - code.first], code.args[i - code.first]
                if op is NEG:
                    read[args[0]] += read[i]
                else:
                    for a in args:
                        read[a].append(result[i])
            result = [
                known.setdefault((form, *sorted(own)), len(known)) for form, own in zip(self.form, read, strict=True)
            ]
        return result

    def op(self, i: int) -> Op:
        """The operation of an instruction; ADD for differences."""
        op = self.code.ops[i - self.code.first]
        return ADD if op is SUB else op


MOST = 8
"""The maximum number of limbs."""
LEAST = 400
"""The number of instructions of a routine from which on limbs are searched for."""
_SHARE = 0.6
"""The minimum fraction of a routine's instructions in lanes."""
_FAR = 100
"""The maximum number of values visited to find the lane of a value."""
_OPS = {ADD, SUB, MUL, DIV, SQRT, SIN, COS, REGULAR}


def beside(code: Code) -> Code | None:
    """The code with the packs of its routines; None if no routine has isomorphic limbs."""
    routines = tuple(replace(r, packs=_packs(code, r)) for r in code.routines)
    return replace(code, routines=routines) if any(r.packs for r in routines) else None


def _packs(code: Code, routine: Routine) -> tuple[Pack, ...]:
    body = [i for i in code.below(set(routine.results), True) if code.ops[i - code.first] is not NEG]
    if len(body) < LEAST:
        return ()
    alike = Alike(code)
    own = {code.plain(i).value for i in routine.results}.intersection(body)
    counts = Counter(n for n in Counter(alike.form[i] for i in own).values() if 2 <= n <= MOST)
    often = Counter(Counter(alike.form[i] for i in body).values())
    # a form may occur several times in each limb
    likely = [n for n in counts if sum(m * k for m, k in often.items() if m % n == 0) >= _SHARE * len(body)]
    found = [_from_results(alike, body, routine.results, n) for n in likely]
    best = max(found, key=_laid, default=())
    return best if _laid(best) >= _SHARE * len(body) else ()


def _from_results(alike: Alike, body: Sequence[int], results: Sequence[int], limbs: int) -> tuple[Pack, ...]:
    search = _PackSearch(alike, set(body), limbs)
    search.from_values(results)
    search.from_values(reversed(body))
    for terms in _sums(alike, body):
        search.from_values(terms)
    return tuple(search.packs)


def _sums(alike: Alike, body: Sequence[int]) -> Iterator[list[int]]:
    """The terms of each sum of more than two terms: a sum over limbs has one from each."""
    inside, inner = set(body), set[int]()
    counts = Counter(x.value for i in body for x in alike.code.signed(i))
    for i in reversed(body):
        if alike.op(i) is not ADD or i in inner:
            continue
        terms, waiting = list[int](), [i]
        while waiting:
            for x in alike.code.signed(waiting.pop()):
                if x.value in inside and counts[x.value] == 1 and alike.op(x.value) is ADD:
                    inner.add(x.value)
                    waiting.append(x.value)
                elif x.value in inside:
                    terms.append(x.value)
        if len(terms) > 2:
            yield terms


def _laid(packs: Sequence[Pack]) -> int:
    """The number of values in lanes."""
    return sum(len(p.values) for p in packs)


@dataclass
class _PackSearch:
    """The packs so far, and the `lane` of each value in them; `twins` map, for each limb, values of the first limb to its values.

    Arguments of a sum or product with the same form may be in either order: known twins decide, and the decision waits for them.
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
        """Adds packs of those values that have the same form and are as many as there are limbs, and of their arguments."""
        kinds: dict[int, dict[int, None]] = {}
        for i in values:
            plain = self.alike.code.plain(i).value
            if plain in self.body and plain not in self.lane:
                kinds.setdefault(self.alike.form[plain], {})[plain] = None
        for own in kinds.values():
            if len(own) == self.limbs:
                self._matched(self._in_lanes(sorted(own)))

    def _in_lanes(self, values: list[int]) -> tuple[int, ...]:
        """Values ordered by the lanes of their dependencies, if these are all in distinct lanes."""
        lanes = [self._lane(i) for i in values]
        if None in lanes or len(set(lanes)) < len(lanes):
            return tuple(values)
        return tuple(i for _, i in sorted(zip(lanes, values, strict=True)))

    def _lane(self, value: int) -> int | None:
        """The lane of the nearest dependency that is in a pack."""
        waiting = deque([value])
        for _ in range(_FAR):
            if not waiting:
                break
            i = waiting.popleft()
            if i in self.lane:
                return self.lane[i]
            if i in self.body:
                waiting += [x.value for x in self.alike.code.signed(i)]
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
        """The operands of each lane, in the order of the first lane; None if the order is undecided and not `at_last`."""
        lanes = [self.alike.code.signed(i) for i in values]
        if self.alike.op(values[0]) not in (ADD, MUL):
            return lanes
        kept = [self._in_order(lanes[0], own, twin) for own, twin in zip(lanes, self.twins, strict=True)]
        if None in kept and not at_last:
            return None
        kept = [self._by_order(lanes[0], own) if k is None else k for k, own in zip(kept, lanes, strict=True)]
        return [own if k else own[::-1] for k, own in zip(kept, lanes, strict=True)]

    def _in_order(self, first: list[Operand], own: list[Operand], twin: dict[int, int]) -> bool | None:
        """Whether two arguments are in the order of those of the first limb; None if undecided."""
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
        """The number of dependencies of a with a known twin among those of x."""
        first = self.alike.code.first
        if twin.get(a) == x or a == x:
            return 1
        if not deep or a < first or x < first:
            return 0
        others = [o.value for o in self.alike.code.signed(x)]
        return sum(
            max((self._shared(o.value, y, twin, deep - 1) for y in others), default=0)
            for o in self.alike.code.signed(a)
        )

    def _by_order(self, first: list[Operand], own: list[Operand]) -> bool:
        """The same, decided by the order of computation."""
        (a, b), (x, y) = (o.value for o in first), (o.value for o in own)
        return (a < b) == (x < y)


def gathered(program: Program, block: Sequence[int], lanes: int) -> tuple[int, ...]:
    """`block` with the sines and cosines of available angles in groups of `lanes`, each at the position of its first."""
    within = set(block)
    own: dict[int, list[int]] = {}  # by angle
    for i in block:
        if program.op(i) in (SIN, COS):
            angle = program.arguments(i)[0]
            if angle not in within or _near(program, angle, within):
                own.setdefault(angle, []).append(i)
    angles = list(own)
    packs: dict[int, list[int]] = {}  # by their first instruction in the block
    for k in range(0, len(angles), lanes):
        pack = angles[k : k + lanes]
        packs[own[pack[0]][0]] = [*(a for a in pack if a in within), *(i for a in pack for i in own[a])]
    placed: dict[int, None] = {}
    for i in block:
        # an angle with an earlier reader stays where it is
        placed.update(dict.fromkeys(packs.get(i, (i,))))
    return tuple(placed)


def _near(program: Program, angle: int, within: set[int]) -> bool:
    """Whether an angle is one operation, not itself a sine or cosine, on values from outside the block."""
    return program.op(angle) not in (SIN, COS) and within.isdisjoint(program.arguments(angle))
