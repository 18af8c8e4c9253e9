# SPDX-License-Identifier: BSD-3-Clause
"""What sums and products cost: an operation with the state, or one of parameters, which runs once a set of their values.

The parameters of a product are multiplied first and count as one factor of it. A divisor costs what a factor costs: the reciprocal of
one that several products share is computed once, and one product alone divides.
"""

from __future__ import annotations

from kane.rewrite.graph import Cube, Graph


class Price:
    """Prices of one graph, in operations with the state and of parameters at their weights."""

    def __init__(self, graph: Graph, state: int = 1, parameter: int = 1) -> None:
        self.graph, self.state, self.parameter = graph, state, parameter
        self._products: dict[Cube, tuple[int, int]] = {}
        self._varies = graph.varies

    def operation(self, varies: bool) -> int:
        """One operation of a tier."""
        return self.state if varies else self.parameter

    def product(self, cube: Cube) -> int:
        """A cube alone."""
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
        """A cube times one more factor of a tier."""
        if not base:
            return 0
        cost, own = self._products.get(base) or self._known(base)
        if varies:
            return cost + self.state
        count = len(base) - own
        return cost + (self.parameter if count else self.state)

    def sum(self, cubes: list[Cube]) -> int:
        """A sum of cubes, each read by it alone."""
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
    """Operations of all that the results need; divisions with the state count twice."""
    price = Price(graph)
    total = 0
    divided: dict[int, int] = {}
    for v in graph.order():
        op = graph.op[v]
        if op is not None:
            total += op.cost
        cubes = [graph.cube[t] for t in graph.of(v)]
        total += price.sum(cubes) if cubes else 0
        for x in {x for cube in cubes for x in cube if x & 1}:
            divided[x] = divided.get(x, 0) + 1
    return total + sum([(n > 1) + graph.varies[x >> 1] for x, n in divided.items()])
