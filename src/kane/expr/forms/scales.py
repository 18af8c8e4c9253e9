# SPDX-License-Identifier: BSD-3-Clause
"""A parameter's powers where they cost least: lengths of a disk are counted in its radii.

    (g sin q + R u₂ w)/(5 R/4),  m (g − R x)  →  4 ((g/R) sin q + u₂ w)/5,  m R (g/R − x)

Every expression e is p^k e′, with the power k that its factors bring. It costs nothing to carry k along through products, and through
sums whose terms have the same k. Elsewhere a term is multiplied by p, or the parameters in it are: g is R (g/R), once for all.
"""

import heapq
from collections import Counter
from collections.abc import Iterator, Sequence, Set

from kane.expr.build import NODE_BUILDERS, div, mul, neg
from kane.expr.evaluation import price
from kane.expr.node import ONE, Expr, postorder
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

    def __init__(self, roots: Sequence[Expr], kept: Set[Expr]) -> None:
        self.roots, self.kept, self.order = roots, kept, postorder(roots)
        self.place = {node: i for i, node in enumerate(self.order)}
        self.args = [tuple([self.place[a] for a in node.args]) for node in self.order]
        self.args += [(self.place[r],) for r in roots]
        self.users: list[list[int]] = [[] for _ in self.args]
        for i, args in enumerate(self.args):
            for a in args:
                self.users[a].append(i)
        self.kinds = [_kind(node, kept) for node in self.order] + [_ELSE] * len(roots)
        self.costs = [node.op.cost for node in self.order] + [0] * len(roots)
        self.states: list[_State] = []  # without powers
        for i, kind in enumerate(self.kinds):
            self.states.append((self.states[self.args[i][0]][0] if kind == _NEGATIVE else i, 0, self.costs[i], ()))


def _chosen(graph: _Graph, p: Parameter) -> dict[Expr, int]:
    """The powers of other parameters, and of sums where it is not the least one of their terms."""
    powers = _Powers(graph, p)
    for _ in range(_ROUNDS):
        before = powers.cost
        for i, choice in list(powers.options()):
            powers.attempt(i, choice)
        if powers.cost == before:
            break
    return {graph.order[i]: choice for i, choice in powers.choices.items()}


class _Powers:
    """Choices, and what everything costs by them."""

    def __init__(self, graph: _Graph, p: Parameter) -> None:
        self.order, self.args, self.users, self.costs = graph.order, graph.args, graph.users, graph.costs
        self.kinds, self.states, place = graph.kinds.copy(), graph.states.copy(), graph.place[p]
        self.kinds[place] = _SCALE
        self.choices: dict[int, int] = {}
        self.taken = 0
        self.refused: dict[tuple[int, int | None], int] = {}
        self.asked: dict[tuple[int, int], int] = {}
        powered = set[int]()
        for i in range(place, len(self.args)):
            if (i == place or not powered.isdisjoint(self.args[i])) and (state := self._state(i)) != self.states[i]:
                self.states[i] = state
                powered.add(i)
        below = [self.args[i][1] for i, node in enumerate(self.order) if node.op is DIV]
        self.divides = any(self.states[i][1] > 0 for i in below)
        for state in self.states:
            for key in state[3]:
                self.asked[key] = self.asked.get(key, 0) + 1
        self.cost = sum([state[2] for state in self.states]) + sum([self._cost(*key) for key in self.asked])
        self.later = self._later()

    def _later(self) -> list[int]:
        """What each node and those after it ask for: no more can be saved there."""
        seen, total, found = set[tuple[int, int]](), 0, []
        for state in reversed(self.states):
            total += sum([self._cost(*key) for key in state[3] if key not in seen])
            seen.update(state[3])
            found.append(total)
        return found[::-1]

    def options(self) -> Iterator[tuple[int, int | None]]:
        """Choices to try: of parameters beside p, of sums whose terms have other powers, of what is used more than once."""
        states = self.states
        for i, kind in enumerate(self.kinds[: len(self.order)]):
            if kind in (_LEAF, _SCALE):
                continue
            if kind == _OTHER:
                yield from ((i, k) for k in (*self._met(i), None))
                continue
            if self._uneven(i):
                yield i, max([states[a][1] for a in self.args[i]])
                yield i, None
            if len(self.users[i]) > 1 and states[i][1]:
                yield i, WHOLE
                yield i, None

    def _met(self, i: int) -> Iterator[int]:
        """Powers of another parameter to try: −1 as a factor of what has some, 1 as a term, or a factor of one, beside what has."""
        users = [k for k in self.users[i] if k < len(self.order)]
        if any(self.order[k].op is MUL and self.states[k][1] for k in users):
            yield -1
        terms = [k for user in users for k in (user, *(self.users[user] if self.order[user].op is MUL else ()))]
        if any(k < len(self.order) and self._uneven(k) for k in terms):
            yield 1

    def _uneven(self, i: int) -> bool:
        """Whether a sum's terms have other powers."""
        op = self.order[i].op
        if op is not ADD and op is not SUB:
            return False
        a, b = self.args[i]
        return self.states[a][1] != self.states[b][1]

    def attempt(self, i: int, choice: int | None) -> None:
        """Make a choice, and take it back unless everything costs less then; not again where nothing else has changed since."""
        usual = self.choices.get(i)
        if choice == usual or self.refused.get((i, choice)) == self.taken:
            return
        states, users, cost, before = self.states, self.users, self.cost, {}
        self._set(i, choice)
        waiting, listed = [i], {i}
        while waiting and (choice is None or self.cost - self.later[waiting[0]] < cost):
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
            self.later = self._later()
            return
        self.refused[i, choice] = self.taken
        self._set(i, usual)
        for k, old in before.items():
            if states[k][3] != old[3]:
                self._asked(states[k][3], old[3])
            states[k] = old
        self.cost = cost

    def _set(self, i: int, choice: int | None) -> None:
        if choice is None:
            self.choices.pop(i, None)
        else:
            self.choices[i] = choice

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
    """`roots` with parameters' powers where all of them together take fewer operations; by no other parameter than before is divided.

    Parameters
    ----------
    roots : what is computed together
    kept : expressions in them that stay as they are
    """
    best, least = tuple(roots), price(roots)
    graph = _Graph(best, kept)
    for p in _frequent(graph.order):
        if graph.roots is not best:
            graph = _Graph(best, kept)
        found = _rewritten(graph, p, _chosen(graph, p)) if p in graph.place else best
        cost = price(found)
        if cost < least:
            best, least = found, cost
    return best


def _frequent(order: Sequence[Expr]) -> list[Parameter]:
    """Parameters that are factors more than once, the most frequent first."""
    factors = [a for node in order if node.op is MUL or node.op is DIV for a in node.args]
    uses = Counter(a for a in factors if isinstance(a, Parameter))
    return [p for p, n in uses.most_common() if n > 1]


def _rewritten(graph: _Graph, p: Parameter, choices: dict[Expr, int]) -> tuple[Expr, ...]:
    images: dict[Expr, _Image] = {p: (ONE, 1)}  # of what changes
    for node in graph.order:
        args, choice = node.args, choices.get(node)
        if not args or node in graph.kept:
            if choice:
                images[node] = _times(node, p, -choice), choice
        elif choice is not None or not images.keys().isdisjoint(args):
            image = _image(node, p, [images.get(a) or (a, 0) for a in args], choice)
            if image[1] or image[0] is not node:
                images[node] = image
    return tuple([_times(e, p, k) for e, k in [images.get(r) or (r, 0) for r in graph.roots]])


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
        e = NODE_BUILDERS[op.name](*[_times(x, p, k - power) for x, k in args])
    return (_times(e, p, power), 0) if choice == WHOLE else (e, power)


def _times(e: Expr, p: Parameter, k: int) -> Expr:
    """p^k e."""
    if not k:
        return e
    factor = ONE
    for _ in range(abs(k)):
        factor = mul(factor, p)
    return mul(e, factor) if k > 0 else div(e, factor)
