# SPDX-License-Identifier: BSD-3-Clause
"""The graph of sums of products on which rewriting rules work, in the representation of Brayton & McMullen 1982, and its price.

A node is an input, a positive constant, a function of nodes, or a sum. A sum has terms, each a sign and a cube: a product of powers of
nodes, its literals. A product is a sum of one term. Signs cost nothing; terms, arguments and results have them, nodes do not.

A literal is a number, 2 v for the node v and 2 v + 1 for its reciprocal; a cube is the sorted tuple of its literals, so that x² y⁻¹ is
(2x, 2x, 2y+1). It has at most one constant. All orders are orders of creation, so that the same input gives the same graph everywhere.

The price counts operations of two tiers with different weights: with the state, and of parameters alone, evaluated once per set of
parameters. The parameters in a product are multiplied first and count as one factor. A divisor costs as much as a factor: the
reciprocal of one shared by several products is computed once, and a single product divides.
"""

from collections.abc import Callable, Iterable

from kane.expr.ops import Op

Cube = tuple[int, ...]
Signed = tuple[int, int]
"""A node and a sign."""
ONE: Cube = ()
_NOTHING = 1e-14
"""Share of a coefficient below which what is left of a difference of two is rounding."""


class Graph:
    """Nodes and terms by number; the owner of a removed term is −1.

    Terms of a sum are indexed by their cubes without constants, `rest`, so that like terms are joined; `factor` is a term's constant.
    `changed` are the sums with new or removed terms, `place` their index in the last topological order, `numbers` the literals of
    constants.
    """

    def __init__(self) -> None:
        self.varies: list[bool] = []
        self.number: list[float | None] = []
        self.op: list[Op | None] = []
        self.args: list[tuple[Signed, ...]] = []
        self.terms: list[dict[Cube, int] | None] = []
        self.readers: list[dict[int, None]] = []
        self.calls: list[dict[int, None]] = []
        self.results: list[Signed] = []
        self.owner: list[int] = []
        self.sign: list[int] = []
        self.cube: list[Cube] = []
        self.rest: list[Cube] = []
        self.factor: list[float] = []
        self.changed: dict[int, None] = {}
        self.place: dict[int, int] = {}
        self.listener: Callable[[int], None] | None = None
        self._constants: dict[float, int] = {}
        self.numbers = set[int]()
        self._functions: dict[tuple[Op, tuple[Signed, ...]], int] = {}
        self._sums: dict[tuple[tuple[Cube, int], ...], int] = {}
        self._needed: dict[int, int] = {}
        self._loose: list[int] = []
        self._order: list[int] | None = None

    # Nodes ---------------------------------------------------------------------------------------------------------------------

    def input(self, varies: bool) -> int:
        """A new input."""
        return self._node(varies)

    def constant(self, value: float) -> int:
        """The node of a positive constant."""
        v = self._constants.get(value)
        if v is None:
            v = self._constants[value] = self._node(False)
            self.number[v] = value
            self.numbers |= {2 * v, 2 * v + 1}
        return v

    def function(self, op: Op, args: tuple[Signed, ...]) -> int:
        """The node op(args)."""
        v = self._functions.get((op, args))
        if v is None:
            v = self._functions[op, args] = self._node(any(self.varies[a] for a, _ in args))
            self.op[v], self.args[v] = op, args
            for a, _ in args:
                self.calls[a][v] = None
        return v

    def known(self, op: Op, args: tuple[Signed, ...]) -> int | None:
        """The node op(args), if there is one."""
        return self._functions.get((op, args))

    def sum(self, terms: Iterable[tuple[int, Cube]]) -> Signed:
        """The signed node of the sum of terms: an existing node with these terms or their negatives, or a new one."""
        ordered = sorted([(cube, sign) for sign, cube in terms])
        first = ordered[0][1]
        key = tuple([(cube, sign * first) for cube, sign in ordered])
        v = self._sums.get(key)
        if v is not None and self.is_read(v) and self._key(v) == key:
            return v, first
        varies = self.varies
        v = self._node(any(varies[x >> 1] for cube, _ in key for x in cube))
        self.terms[v] = {}
        self._sums[key] = v
        for cube, sign in key:
            self.add(v, sign, cube)
        return v, first

    def nothing(self) -> int:
        """The sum of no terms."""
        v = self._node(False)
        self.terms[v] = {}
        return v

    def _key(self, v: int) -> tuple[tuple[Cube, int], ...]:
        own = self.terms[v]
        return tuple(sorted([(self.cube[t], self.sign[t]) for t in own.values()])) if own else ()

    def _node(self, varies: bool) -> int:
        self.varies.append(varies)
        self.number.append(None)
        self.op.append(None)
        self.args.append(())
        self.terms.append(None)
        self.readers.append({})
        self.calls.append({})
        return len(self.varies) - 1

    def result(self, v: int, sign: int) -> None:
        """Adds a signed node to the results."""
        self.results.append((v, sign))
        self._order = None
        self._needed[v] = self._needed.get(v, 0) + 1

    def is_read(self, v: int) -> bool:
        """Whether a node has readers or is a result."""
        return bool(self.readers[v] or self.calls[v]) or v in self._needed

    def is_result(self, v: int) -> bool:
        """Whether a node is a result."""
        return v in self._needed

    def is_product(self, v: int) -> bool:
        """Whether a node is a sum of one term."""
        own = self.terms[v]
        return own is not None and len(own) == 1

    def only(self, v: int) -> int:
        """The term of a product."""
        (t,) = (self.terms[v] or {}).values()
        return t

    def of(self, v: int) -> list[int]:
        """The terms of a sum; none of other nodes."""
        own = self.terms[v]
        return list(own.values()) if own else []

    # Terms ---------------------------------------------------------------------------------------------------------------------

    def add(self, v: int, sign: int, cube: Cube) -> None:
        """Adds a term to a sum; like terms are joined."""
        own = self.terms[v]
        assert own is not None
        rest, value = (cube, 1.0) if self.numbers.isdisjoint(cube) else self.parted(cube)
        like = own.get(rest)
        if like is not None:
            total = self.sign[like] * self.factor[like] + sign * value
            self.drop(like)
            if abs(total) > _NOTHING * value:
                self.add(v, 1 if total > 0 else -1, self.scaled(abs(total), rest))
            return
        t, self._order = len(self.owner), None
        self.owner.append(v)
        self.sign.append(sign)
        self.cube.append(cube)
        self.rest.append(rest)
        self.factor.append(value)
        self.changed[v] = None
        own[rest] = t
        readers = self.readers
        for x in cube:
            readers[x >> 1][t] = None
        if self.listener:
            self.listener(t)

    def drop(self, t: int) -> None:
        """Removes a term; nodes without readers are removed by the next `collect`."""
        own = self.terms[self.owner[t]]
        assert own is not None
        del own[self.rest[t]]
        self.changed[self.owner[t]] = None
        self.owner[t], self._order = -1, None
        readers, loose = self.readers, self._loose
        for x in self.cube[t]:
            v = x >> 1
            held = readers[v]
            if t in held:
                del held[t]
                if not held:
                    loose.append(v)

    def collect(self) -> None:
        """Removes nodes without readers."""
        loose = self._loose
        while loose:
            v = loose.pop()
            if self.is_read(v):
                continue
            for t in self.of(v):
                self.drop(t)
            op = self.op[v]
            if op is not None:
                self._functions.pop((op, self.args[v]), None)
                self.op[v] = None
                for a, _ in self.args[v]:
                    if self.calls[a].pop(v, 0) is None and not self.is_read(a):
                        loose.append(a)

    # Cubes ---------------------------------------------------------------------------------------------------------------------

    def parted(self, cube: Cube) -> tuple[Cube, float]:
        """A cube without its constant, and the constant."""
        numbers = self.numbers
        if numbers.isdisjoint(cube):
            return cube, 1.0
        x = next(x for x in cube if x in numbers)
        value = self.number[x >> 1]
        assert value is not None
        return tuple([y for y in cube if y != x]), 1.0 / value if x & 1 else value

    def scaled(self, value: float, cube: Cube) -> Cube:
        """The product of a cube without constant and a positive number."""
        return cube if value == 1.0 else tuple(sorted([*cube, 2 * self.constant(value)]))

    def times(self, a: Cube, b: Cube) -> Cube:
        """The product of two cubes."""
        if not a or not b:
            return a or b
        m = n = 1.0
        if not self.numbers.isdisjoint(a):
            a, m = self.parted(a)
        if not self.numbers.isdisjoint(b):
            b, n = self.parted(b)
        left = [*a, *b]
        if not {*a}.isdisjoint([x ^ 1 for x in b]):
            left = list(a)
            for x in b:
                if x ^ 1 in left:
                    left.remove(x ^ 1)
                else:
                    left.append(x)
        left.sort()
        return self.scaled(m * n, tuple(left))

    # Canonical form ------------------------------------------------------------------------------------------------------------

    def settle(self, waiting: Iterable[int]) -> None:
        """Restores the canonical form: products of one literal are replaced by it, products and sums with one reader are inlined."""
        stack = list(waiting)
        while stack:
            v = stack.pop()
            own = self.terms[v]
            if own is None or not self.is_read(v):
                continue
            if not own:
                stack += self._vanished(v)
            elif len(own) == 1:
                stack += self._product_inlined(v)
            elif len(self.readers[v]) == 1 and not self.calls[v] and v not in self._needed:
                stack += self._sum_inlined(v)
        self.collect()

    def _vanished(self, v: int) -> list[int]:
        """Removes the terms with an empty sum v as a factor; as an argument or a result v remains, written as 0."""
        changed = []
        for t in list(self.readers[v]):
            if 2 * v in self.cube[t]:
                changed.append(self.owner[t])
                self.drop(t)
        return changed

    def _product_inlined(self, v: int) -> list[int]:
        t = self.only(v)
        sign, cube = self.sign[t], self.cube[t]
        if len(cube) == 1 and not cube[0] & 1:
            return self.replace(v, cube[0] >> 1, sign)
        if not cube or self.calls[v] or v in self._needed or len(self.readers[v]) != 1:
            return []
        (r,) = self.readers[v]
        if self.cube[r].count(2 * v) + self.cube[r].count(2 * v + 1) != 1:
            return []
        below = 2 * v + 1 in self.cube[r]
        rest = tuple([x for x in self.cube[r] if x >> 1 != v])
        owner, s = self.owner[r], self.sign[r]
        new = self.times(rest, tuple(sorted([x ^ 1 for x in cube])) if below else cube)
        self.drop(r)
        self.add(owner, s * sign, new)
        return [owner]

    def _sum_inlined(self, v: int) -> list[int]:
        (r,) = self.readers[v]
        owner, s = self.owner[r], self.sign[r]
        if self.cube[r] != (2 * v,) or self.varies[v] is not self.varies[owner]:
            return []
        own = [(self.sign[t], self.cube[t]) for t in self.of(v)]
        self.drop(r)
        for sign, cube in own:
            self.add(owner, s * sign, cube)
        return [owner]

    def replace(self, v: int, new: int, sign: int) -> list[int]:
        """Replaces v by `new`, with a sign, in all its readers; the sums that changed."""
        changed, self._order = [], None
        for t in list(self.readers[v]):
            cube, owner = self.cube[t], self.owner[t]
            powers = [x & 1 for x in cube if x >> 1 == v]
            rest = tuple([x for x in cube if x >> 1 != v])
            s = self.sign[t] * (sign if len(powers) & 1 else 1)
            self.drop(t)
            self.add(owner, s, self.times(rest, tuple([2 * new + p for p in powers])))
            changed.append(owner)
        for f in list(self.calls[v]):
            changed += self._argument_replaced(f, v, new, sign)
        if v in self._needed:
            self.results = [(new, s * sign) if x == v else (x, s) for x, s in self.results]
            self._needed[new] = self._needed.get(new, 0) + self._needed.pop(v)
            self._loose.append(v)
        return changed

    def _argument_replaced(self, f: int, v: int, new: int, sign: int) -> list[int]:
        op = self.op[f]
        assert op is not None
        self._functions.pop((op, self.args[f]), None)
        args = tuple([(new, s * sign) if a == v else (a, s) for a, s in self.args[f]])
        self.args[f] = args
        del self.calls[v][f]
        self.calls[new][f] = None
        self._loose.append(v)
        known = self._functions.setdefault((op, args), f)
        if known == f:
            return []
        self._loose.append(f)
        return self.replace(f, known, 1)

    def order(self) -> list[int]:
        """The nodes needed by the results, in topological order."""
        if self._order is not None:
            return self._order
        found: dict[int, None] = {}
        args, terms, cube = self.args, self.terms, self.cube
        stack = [v for v, _ in reversed(self.results)]
        while stack:
            v = stack.pop()
            if v < 0:
                found[~v] = None
            elif v not in found:
                own = terms[v]
                stack.append(~v)
                if own:
                    stack += [x >> 1 for t in own.values() for x in cube[t] if x >> 1 not in found]
                elif args[v]:
                    stack += [a for a, _ in args[v] if a not in found]
        self._order = list(found)
        return self._order


class Coefficients:
    """Terms summed by their cubes without constants; coefficients that cancel up to rounding are dropped."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.total: dict[Cube, float] = {}
        self._size: dict[Cube, float] = {}

    def add(self, cube: Cube, value: float) -> None:
        """Add a multiple of a cube without a constant."""
        self.total[cube] = self.total.get(cube, 0.0) + value
        self._size[cube] = self._size.get(cube, 0.0) + abs(value)

    def terms(self) -> list[tuple[int, Cube]]:
        """The remaining terms, with signs."""
        scaled, size = self.graph.scaled, self._size
        return [(1 if k > 0 else -1, scaled(abs(k), c)) for c, k in self.total.items() if abs(k) > _NOTHING * size[c]]


def common(cubes: list[Cube]) -> Cube:
    """The common literals of all cubes."""
    shared = list(cubes[0])
    for cube in cubes[1:]:
        left = list(cube)
        kept = []
        for x in shared:
            if x in left:
                left.remove(x)
                kept.append(x)
        if not kept:
            return ONE
        shared = kept
    return tuple(shared)


def over(cube: Cube, base: Cube) -> Cube:
    """The quotient of a cube and a cube that divides it."""
    if not base:
        return cube
    left = list(cube)
    for x in base:
        left.remove(x)
    return tuple(left)


class Price:
    """Prices in one graph: weighted operations with the state and of parameters."""

    def __init__(self, graph: Graph, state: int, parameter: int) -> None:
        self.graph, self.state, self.parameter = graph, state, parameter
        self._products: dict[Cube, tuple[int, int]] = {}
        self._varies = graph.varies

    def operation(self, varies: bool) -> int:
        """The price of one operation of a tier."""
        return self.state if varies else self.parameter

    def product(self, cube: Cube) -> int:
        """The price of a cube by itself."""
        return (self._products.get(cube) or self._known(cube))[0]

    def varies(self, cube: Cube) -> bool:
        """Whether a cube depends on more than parameters."""
        return bool((self._products.get(cube) or self._known(cube))[1])

    def _known(self, cube: Cube) -> tuple[int, int]:
        known = self._products[cube] = self._product(cube)
        return known

    def _product(self, cube: Cube) -> tuple[int, int]:
        varies = self._varies
        own = sum([varies[x >> 1] for x in cube])
        count = len(cube) - own
        total = self.parameter * (count - 1) if count > 1 else 0
        return (total + self.state * (own - 1 + (count > 0)) if own else total), own

    def with_factor(self, base: Cube, varies: bool) -> int:
        """The price of a cube with one more factor of a tier."""
        if not base:
            return 0
        cost, own = self._products.get(base) or self._known(base)
        if varies:
            return cost + self.state
        count = len(base) - own
        return cost + (self.parameter if count else self.state)

    def sum(self, cubes: list[Cube]) -> int:
        """The price of a sum of cubes that have no other readers."""
        own = total = 0
        products = self._products
        for cube in cubes:
            price, varying = products.get(cube) or self._known(cube)
            total += price
            if varying:
                own += 1
        count = len(cubes) - own
        total += self.parameter * (count - 1) if count > 1 else 0
        return total + self.state * (own - 1 + (count > 0)) if own else total


def cost(graph: Graph) -> int:
    """The operations of all nodes needed by the results; divisions with the state count twice."""
    total = 0
    divided: dict[int, int] = {}
    for v in graph.order():
        op, own = graph.op[v], graph.terms[v]
        if op is not None:
            total += op.cost
        elif own:
            cubes = [graph.cube[t] for t in own.values()]
            total += sum(map(len, cubes)) + cubes.count(ONE) - 1
            for x in {x for cube in cubes for x in cube if x & 1}:
                divided[x] = divided.get(x, 0) + 1
    return total + sum([(n > 1) + graph.varies[x >> 1] for x, n in divided.items()])
