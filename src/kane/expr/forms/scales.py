# SPDX-License-Identifier: BSD-3-Clause
"""A parameter's powers where they cost least: lengths of a disk are counted in its radii.

    (g sin q + R u₂ w)/(5 R/4),  m (g − R x)  →  4 ((g/R) sin q + u₂ w)/5,  m R (g/R − x)

Every expression e is p^k e′, with the power k that its factors bring. It costs nothing to carry k along through products, and through
sums whose terms have the same k. Elsewhere a term is multiplied by p, or the parameters in it are: g is R (g/R), once for all.
"""

import heapq
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

from kane.expr.build import NODE_BUILDERS, div, mul, neg
from kane.expr.forms.count import price
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


def chosen(roots: Sequence[Expr], p: Parameter, kept: frozenset[Expr]) -> dict[Expr, int]:
    """The powers of other parameters, and of sums where it is not the least one of their terms.

    Parameters
    ----------
    roots : what is computed together
    p : the parameter
    kept : expressions in them that stay as they are, of power 0
    """
    powers = _Powers(roots, p, kept)
    for _ in range(_ROUNDS):
        before = powers.cost
        for i, choice in list(powers.options()):
            powers.attempt(i, choice)
        if powers.cost == before:
            break
    return {powers.order[i]: choice for i, choice in powers.choices.items()}


class _State(NamedTuple):
    """Of e = p^k e′: the number of e′, k, what e′ costs, and which numbers are multiplied by which powers for it."""

    value: int
    power: int
    cost: int = 0
    asked: tuple[tuple[int, int], ...] = ()


class _Powers:
    """Choices, and what everything costs by them: nodes in order, after them one place for each root."""

    def __init__(self, roots: Sequence[Expr], p: Parameter, kept: frozenset[Expr]) -> None:
        self.p, self.kept = p, kept
        self.order = postorder(roots)
        place = {node: i for i, node in enumerate(self.order)}
        self.args = [tuple(place[a] for a in node.args) for node in self.order] + [(place[r],) for r in roots]
        self.users: list[list[int]] = [[] for _ in self.args]
        for i, args in enumerate(self.args):
            for a in args:
                self.users[a].append(i)
        self.choices: dict[int, int] = {}
        self.taken = 0
        self.refused: dict[tuple[int, int | None], int] = {}
        self.asked: Counter[tuple[int, int]] = Counter()
        self.cost = 0
        self.states: list[_State] = []
        for i in range(len(self.args)):
            self.states.append(self._state(i))
        below = (self.args[i][1] for i, node in enumerate(self.order) if node.op is DIV)
        self.divides = any(self.states[i].power > 0 for i in below)
        for state in self.states:
            self._enter(state, 1)

    def options(self) -> Iterator[tuple[int, int | None]]:
        """Choices to try: of parameters beside p, of sums whose terms have other powers, of what is used more than once."""
        for i, node in enumerate(self.order):
            if isinstance(node, Parameter):
                if node is not self.p:
                    yield from ((i, k) for k in (*self._met(i), None))
                continue
            if (node.op is ADD or node.op is SUB) and self._uneven(i):
                yield from ((i, k) for k in (max(self.states[a].power for a in self.args[i]), None))
            if len(self.users[i]) > 1 and node.args and self.states[i].power:
                yield from ((i, k) for k in (WHOLE, None))

    def _met(self, i: int) -> Iterator[int]:
        """Powers of another parameter to try: −1 as a factor of what has some, 1 as a term, or a factor of one, beside what has."""
        users = [k for k in self.users[i] if k < len(self.order)]
        if any(self.order[k].op is MUL and self.states[k].power for k in users):
            yield -1
        terms = [k for user in users for k in (user, *(self.users[user] if self.order[user].op is MUL else ()))]
        if any(k < len(self.order) and self._uneven(k) for k in terms):
            yield 1

    def _uneven(self, i: int) -> bool:
        """Whether a sum's terms have other powers."""
        node = self.order[i]
        return (node.op is ADD or node.op is SUB) and len({self.states[a].power for a in self.args[i]}) > 1

    def attempt(self, i: int, choice: int | None) -> None:
        """Make a choice, and take it back unless everything costs less then; not again where nothing else has changed since."""
        usual = self.choices.get(i)
        if choice == usual or self.refused.get((i, choice)) == self.taken:
            return
        cost, before = self.cost, {}
        self._set(i, choice)
        waiting = [i]
        while waiting:
            k = heapq.heappop(waiting)
            while waiting and waiting[0] == k:
                heapq.heappop(waiting)
            old, new = self.states[k], self._state(k)
            if new != old:
                before[k] = old
                self._put(k, new)
                if new[:2] != old[:2]:
                    for user in self.users[k]:
                        heapq.heappush(waiting, user)
        if self.cost < cost:
            self.taken += 1
            return
        self.refused[i, choice] = self.taken
        self._set(i, usual)
        for k, old in before.items():
            self._put(k, old)

    def _set(self, i: int, choice: int | None) -> None:
        if choice is None:
            self.choices.pop(i, None)
        else:
            self.choices[i] = choice

    def _put(self, k: int, new: _State) -> None:
        self._enter(self.states[k], -1)
        self._enter(new, 1)
        self.states[k] = new

    def _enter(self, state: _State, sign: int) -> None:
        self.cost += sign * state.cost
        for key in state.asked:
            self.asked[key] += sign
            if self.asked[key] == (sign > 0):
                self.cost += sign * self._cost(*key)

    def _cost(self, value: int, power: int) -> int:
        """Of a number times a power of p."""
        plain = abs(power) - (value == _ONE and power > 0)
        return plain if power > 0 or self.divides else _REFUSED

    def _state(self, i: int) -> _State:
        if i >= len(self.order):
            return _State(i, 0, 0, self._raised(self.args[i], 0))
        node, choice = self.order[i], self.choices.get(i)
        op = node.op
        if node is self.p:
            return _State(_ONE, 1)
        if isinstance(node, Parameter) and choice:
            return _State(-2 - i, choice, 0, ((i, -choice),))
        if not node.args:
            return _State(i, 0)
        if node in self.kept:
            return _State(i, 0, op.cost, self._raised(self.args[i], 0))
        if op is NEG:
            return self.states[self.args[i][0]]._replace(cost=0, asked=())
        if op is MUL or op is DIV:
            state = self._product(i, op is MUL)
        elif op is ADD or op is SUB:
            power = min(self.states[a].power for a in self.args[i]) if choice is None or choice == WHOLE else choice
            state = _State(i, power, op.cost, self._raised(self.args[i], power))
        else:
            return _State(i, 0, op.cost, self._raised(self.args[i], 0))
        if choice == WHOLE and state.power:
            return _State(-2 - i, 0, state.cost, (*state.asked, (state.value, state.power)))
        return state

    def _product(self, i: int, times: bool) -> _State:
        a, b = (self.states[k] for k in self.args[i])
        power = a.power + b.power if times else a.power - b.power
        if b.value == _ONE:
            return _State(a.value, power)
        if times and a.value == _ONE:
            return _State(b.value, power)
        return _State(i, power, 1)

    def _raised(self, args: Sequence[int], power: int) -> tuple[tuple[int, int], ...]:
        states = [self.states[a] for a in args]
        return tuple((s.value, s.power - power) for s in states if s.power != power)


_Image = tuple[Expr, int]
"""e′ and k of p^k e′."""


def scaled(roots: Sequence[Expr], kept: Collection[Expr] = ()) -> tuple[Expr, ...]:
    """`roots` with parameters' powers where all of them together take fewer operations; by no other parameter than before is divided.

    Parameters
    ----------
    roots : what is computed together
    kept : expressions in them that stay as they are
    """
    best, least, held = tuple(roots), price(roots), frozenset(kept)
    for p in _frequent(best):
        found = _rewritten(best, p, held, chosen(best, p, held))
        cost = price(found)
        if cost < least:
            best, least = found, cost
    return best


def _frequent(roots: Sequence[Expr]) -> list[Parameter]:
    """Parameters that are factors more than once, the most frequent first."""
    uses: dict[Parameter, int] = {}
    for node in postorder(roots):
        if node.op is MUL or node.op is DIV:
            for a in node.args:
                if isinstance(a, Parameter):
                    uses[a] = uses.get(a, 0) + 1
    return sorted((p for p, n in uses.items() if n > 1), key=lambda p: -uses[p])


def _rewritten(
    roots: tuple[Expr, ...], p: Parameter, kept: frozenset[Expr], choices: dict[Expr, int]
) -> tuple[Expr, ...]:
    images: dict[Expr, _Image] = {}
    for node in postorder(roots):
        if node is p:
            images[node] = ONE, 1
        elif isinstance(node, Parameter):
            k = choices.get(node, 0)
            images[node] = _times(node, p, -k), k
        elif not node.args or node in kept:
            images[node] = node, 0
        else:
            images[node] = _image(node, p, [images[a] for a in node.args], choices)
    return tuple(_times(e, p, k) for e, k in (images[r] for r in roots))


def _image(node: Expr, p: Parameter, args: list[_Image], choices: dict[Expr, int]) -> _Image:
    op, choice = node.op, choices.get(node)
    if op is NEG:
        return neg(args[0][0]), args[0][1]
    if op in (MUL, DIV):
        (x, k), (y, n) = args
        e, power = (mul(x, y), k + n) if op is MUL else (div(x, y), k - n)
    else:
        sum_ = op is ADD or op is SUB
        power = (min(k for _, k in args) if choice is None or choice == WHOLE else choice) if sum_ else 0
        e = NODE_BUILDERS[op.name](*[_times(x, p, k - power) for x, k in args])
    return (_times(e, p, power), 0) if choice == WHOLE else (e, power)


def _times(e: Expr, p: Parameter, k: int) -> Expr:
    """p^k e."""
    factor = ONE
    for _ in range(abs(k)):
        factor = mul(factor, p)
    return mul(e, factor) if k >= 0 else div(e, factor)
