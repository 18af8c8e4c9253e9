# SPDX-License-Identifier: BSD-3-Clause
"""A parameter's powers where they cost least: lengths of a disk are counted in its radii.

    (g sin q + R u₂ w)/(5 R/4),  m (g − R x)  →  4 ((g/R) sin q + u₂ w)/5,  m R (g/R − x)

Every expression e is p^k e′, with the power k that its factors bring. It costs nothing to carry k along through products, and through
sums whose terms have the same k. Elsewhere a term is multiplied by p, or the parameters in it are: g is R (g/R), once for all.
"""

import heapq
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence, Set
from functools import reduce

from kane.expr.build import NODE_BUILDERS, div, mul, neg
from kane.expr.evaluation import Together
from kane.expr.node import ONE, Expr
from kane.expr.ops import ADD, DIV, MUL, NEG, SUB
from kane.expr.symbols import Parameter

WHOLE = 9
"""The choice for what is multiplied by its power of p at once: more than any power."""
_ROUNDS = 3
"""How often all choices are gone through at most."""
_ONE = -1
"""The number of the expression 1."""
_REFUSED = 1000
"""The cost of a division by p where nothing divides by p."""


_LEAF, _SCALE, _OTHER, _KEPT, _NEGATIVE, _PRODUCT, _QUOTIENT, _SUM, _ELSE = range(9)
"""Kinds of nodes: what has no power, p, another parameter, what stays as it is, and operations."""


_Asked = tuple[tuple[int, int], ...]
_State = tuple[int, int, int, _Asked]
"""Of e = p^k e′: the number of e′, k, what e′ costs, and which numbers are multiplied by which powers for it."""


class _Graph:
    """What is computed together: nodes in order, and the numbers of their arguments and users; after them one place for each root.

    What is `kept` stays as it is, of power 0.
    """

    def __init__(self, roots: Together, kept: Set[Expr]) -> None:
        self.roots, self.kept, self.order = roots, kept, roots.order
        self.place: dict[Expr, int] = {}
        self.args: list[tuple[int, ...]] = []
        self.kinds = [_kind(node, kept) for node in self.order]
        self.costs = [node.op.cost for node in self.order]
        self.states: list[_State] = []  # without powers
        place, states = self.place, self.states
        for i, node in enumerate(self.order):
            args = tuple([place[a] for a in node.args])
            self.args.append(args)
            states.append((states[args[0]][0] if self.kinds[i] == _NEGATIVE else i, 0, self.costs[i], ()))
            place[node] = i
        self.others = {i for i, kind in enumerate(self.kinds) if kind == _OTHER}
        self.cost = sum(self.costs)
        self.args += [(place[r],) for r in roots]
        self.kinds += [_ELSE] * len(roots)
        self.costs += [0] * len(roots)
        states += [(i, 0, 0, ()) for i in range(len(states), len(self.args))]
        self.users: list[list[int]] = [[] for _ in self.args]
        for i, numbers in enumerate(self.args):
            for a in numbers:
                self.users[a].append(i)

    def above(self, places: Iterable[int]) -> list[int]:
        """These places and those of all that is made of them, in order."""
        found, waiting = set(places), list(places)
        while waiting:
            for user in self.users[waiting.pop()]:
                if user not in found:
                    found.add(user)
                    waiting.append(user)
        return sorted(found)


def _chosen(graph: _Graph, p: Parameter) -> dict[int, int]:
    """The powers of other parameters, and of sums where it is not the least one of their terms, by place."""
    powers = _Powers(graph, p)
    for _ in range(_ROUNDS):
        before = powers.cost
        for i, choice in list(powers.options()):
            powers.attempt(i, choice)
        if powers.cost == before:
            break
    return {i: choice for i, choice in powers.choices.items() if choice is not None}


class _Powers:
    """Choices, and what everything costs by them."""

    def __init__(self, graph: _Graph, p: Parameter) -> None:
        self.order, self.args, self.users, self.costs = graph.order, graph.args, graph.users, graph.costs
        self.kinds, self.states, self.others = graph.kinds.copy(), graph.states.copy(), graph.others
        self.kinds[graph.place[p]] = _SCALE
        self.choices: dict[int, int | None] = {}
        self.taken = 0
        self.refused: dict[tuple[int, int | None], int] = {}
        self.asked: dict[tuple[int, int], int] = {}
        self.cost = graph.cost
        self.moved = set[int]()  # places whose states have been others than without powers
        above = graph.above([graph.place[p]])
        for i in above:
            old, new = self.states[i], self._state(i)
            if new != old:
                self.cost += new[2] - old[2]
                self.states[i] = new
                self.moved.add(i)
        ratios = [i for i in above if i < len(self.order) and self.order[i].op is DIV]
        self.divides = any(self.states[self.args[i][1]][1] > 0 for i in ratios)
        self.cost += self._asked((), tuple([key for i in self.moved for key in self.states[i][3]]))
        self.later = self._later()

    def _later(self) -> tuple[list[int], list[int]]:
        """Places that ask for powers, in order, and what each and those after it ask for, 0 at the end: no more can be saved there."""
        places = sorted([i for i in self.moved if self.states[i][3]])
        seen, total, found = set[tuple[int, int]](), 0, [0]
        for i in reversed(places):
            asked = self.states[i][3]
            total += sum([self._cost(*key) for key in asked if key not in seen])
            seen.update(asked)
            found.append(total)
        return places, found[::-1]

    def options(self) -> Iterator[tuple[int, int | None]]:
        """Choices to try: of parameters beside p, of sums whose terms have other powers, of what is used more than once.

        Of another parameter −1 as a factor of what has some power, 1 as a term, or a factor of one, beside what has.
        """
        states, kinds, args, users = self.states, self.kinds, self.args, self.users
        powered = {i for i in self.moved if states[i][1]}
        factors = {a for i in powered if kinds[i] == _PRODUCT for a in args[i]}
        uneven = {k for i in powered for k in users[i] if kinds[k] == _SUM and len({states[a][1] for a in args[k]}) > 1}
        terms = {a for k in uneven for a in args[k]}
        terms |= {a for k in terms if self.order[k].op is MUL for a in args[k]}
        for i in sorted(powered | uneven | (self.others & (factors | terms | self.choices.keys()))):
            if kinds[i] == _OTHER:
                yield from [(i, k) for k, found in ((-1, factors), (1, terms)) if i in found]
                yield i, None
            elif kinds[i] != _SCALE:
                if i in uneven:
                    yield i, max([states[a][1] for a in args[i]])
                    yield i, None
                if len(users[i]) > 1 and i in powered:
                    yield i, WHOLE
                    yield i, None

    def attempt(self, i: int, choice: int | None) -> None:
        """Make a choice, and take it back unless everything costs less then; not again where nothing else has changed since."""
        usual = self.choices.get(i)
        if choice == usual or self.refused.get((i, choice)) == self.taken:
            return
        states, users, cost, before = self.states, self.users, self.cost, {}
        self.choices[i] = choice
        waiting, listed = [i], {i}
        places, saved = self.later
        while waiting and (choice is None or self.cost - saved[bisect_left(places, waiting[0])] < cost):
            k = heapq.heappop(waiting)
            old, new = states[k], self._state(k)
            if new != old:
                before[k] = old
                states[k] = new
                self.cost += new[2] - old[2]
                if new[3] != old[3]:
                    self.cost += self._asked(old[3], new[3])
                if new[0] != old[0] or new[1] != old[1]:
                    for user in users[k]:
                        if user not in listed:
                            listed.add(user)
                            heapq.heappush(waiting, user)
        if self.cost < cost:
            self.taken += 1
            self.moved.update(before)
            self.later = self._later()
            return
        self.refused[i, choice] = self.taken
        self.choices[i] = usual
        for k, old in before.items():
            if states[k][3] != old[3]:
                self._asked(states[k][3], old[3])
            states[k] = old
        self.cost = cost

    def _asked(self, old: _Asked, new: _Asked) -> int:
        """What it costs more to ask for other numbers times powers."""
        cost, asked = 0, self.asked
        for key in old:
            asked[key] -= 1
            if not asked[key]:
                cost -= self._cost(*key)
        for key in new:
            count = asked.get(key, 0)
            asked[key] = count + 1
            if not count:
                cost += self._cost(*key)
        return cost

    def _cost(self, value: int, power: int) -> int:
        """Of a number times a power of p."""
        plain = abs(power) - (value == _ONE and power > 0)
        return plain if power > 0 or self.divides else _REFUSED

    def _state(self, i: int) -> _State:
        kind, states = self.kinds[i], self.states
        choice = self.choices.get(i)
        asked: _Asked = ()
        if kind in _FACTORED:
            x, y = self.args[i]
            (a, k, _, _), (b, n, _, _) = states[x], states[y]
            power = k + n if kind == _PRODUCT else k - n
            value, cost = (a, 0) if b == _ONE else (b, 0) if a == _ONE and kind == _PRODUCT else (i, 1)
        elif kind == _SUM:
            x, y = self.args[i]
            k, n = states[x][1], states[y][1]
            power = (k if k < n else n) if choice is None or choice == WHOLE else choice
            value, cost = i, self.costs[i]
            if k != n or k != power:
                asked = _raised((states[x], states[y]), power)
        elif kind == _LEAF:
            return i, 0, 0, ()
        elif kind == _SCALE:
            return _ONE, 1, 0, ()
        elif kind == _OTHER:
            return (-2 - i, choice, 0, ((i, -choice),)) if choice else (i, 0, 0, ())
        elif kind == _NEGATIVE:
            value, power, _, _ = states[self.args[i][0]]
            return value, power, 0, ()
        else:
            return i, 0, self.costs[i], _raised([states[a] for a in self.args[i]], 0)
        if choice == WHOLE and power:
            return -2 - i, 0, cost, (*asked, (value, power))
        return value, power, cost, asked


def _kind(node: Expr, kept: Set[Expr]) -> int:
    if not node.args:
        return _OTHER if isinstance(node, Parameter) else _LEAF
    return _KEPT if node in kept else _KINDS.get(node.op, _ELSE)


_FACTORED = (_PRODUCT, _QUOTIENT)
_KINDS = {NEG: _NEGATIVE, MUL: _PRODUCT, DIV: _QUOTIENT, ADD: _SUM, SUB: _SUM}


def _raised(states: Sequence[_State], power: int) -> _Asked:
    return tuple([(s[0], s[1] - power) for s in states if s[1] != power])


_Image = tuple[Expr, int]
"""e′ and k of p^k e′."""


def scaled(roots: Sequence[Expr], kept: Set[Expr] = frozenset()) -> tuple[Expr, ...]:
    """`roots` with parameters' powers, `kept` ones apart, where all take fewer operations; by no other parameter is divided."""
    best = Together.of(roots)
    graph = _Graph(best, kept)
    order = graph.order
    uses = Counter(a for x in order if x.op is MUL or x.op is DIV for a in x.args if isinstance(a, Parameter))
    for p in [p for p, n in uses.most_common() if n > 1]:
        if graph.roots is not best:
            graph = _Graph(best, kept)
        if p in graph.place:
            best = best.or_shorter(_rewritten(graph, p, _chosen(graph, p)))
    return best


def _rewritten(graph: _Graph, p: Parameter, choices: dict[int, int]) -> tuple[Expr, ...]:
    images: dict[Expr, _Image] = {p: (ONE, 1)}  # of what changes
    for i in graph.above((graph.place[p], *choices)):
        if i < len(graph.order):
            node, choice = graph.order[i], choices.get(i)
            args = node.args
            if not args or node in graph.kept:
                if choice:
                    images[node] = _times(node, p, -choice), choice
            elif choice is not None or not images.keys().isdisjoint(args):
                image = _image(node, p, [images.get(a) or (a, 0) for a in args], choice)
                if image[1] or image[0] is not node:
                    images[node] = image
    return tuple([_times(e, p, k) if k else e for e, k in [images.get(r) or (r, 0) for r in graph.roots]])


def _image(node: Expr, p: Parameter, args: list[_Image], choice: int | None) -> _Image:
    op = node.op
    if op is NEG:
        return neg(args[0][0]), args[0][1]
    if op is MUL or op is DIV:
        (x, k), (y, n) = args
        e, power = (mul(x, y), k + n) if op is MUL else (div(x, y), k - n)
    else:
        sum_ = op is ADD or op is SUB
        power = (min([k for _, k in args]) if choice is None or choice == WHOLE else choice) if sum_ else 0
        e = NODE_BUILDERS[op.name](*[_times(x, p, k - power) if k != power else x for x, k in args])
    return (_times(e, p, power), 0) if choice == WHOLE and power else (e, power)


def _times(e: Expr, p: Parameter, k: int) -> Expr:
    """p^k e."""
    factor = reduce(mul, [p] * abs(k), ONE)
    return mul(e, factor) if k > 0 else div(e, factor)
