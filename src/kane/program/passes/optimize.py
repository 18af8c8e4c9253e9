# SPDX-License-Identifier: BSD-3-Clause
"""Fewer operations: code is read as a graph of sums and products, rewritten there, and written in an order that waits little.

There are two starts: the sums and products as they are, and multiplied out (`rewrite/normal.py`). Of short code both are tried, else
the one that promises more, and the other where that gains nothing. Of these and the code itself the shortest is taken.

Results change by rounding errors, so that the pass belongs to compilation with contraction. Taking out a factor never raises the
running error bound; sums in another order may, where terms cancel. So the bounds of both are compared at several points, and a form
is left where the bound of a result would be more than twice as large in the mean of the points, or four times at one.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from kane.expr.ops import DIV
from kane.numeric.sampling import draw, value_of
from kane.program.passes.graphs import joined, read, written
from kane.program.passes.rounding import rounding
from kane.program.passes.verify import verified
from kane.program.program import Code, Routine
from kane.rewrite.divisors import Search
from kane.rewrite.graph import Graph
from kane.rewrite.node_rows import sweep
from kane.rewrite.normal import normal
from kane.rewrite.price import Price, cost

IN_THE_MEAN, AT_ONE = 2.0, 4.0
"""By what factors the bound on a result's error may grow: in the geometric mean of the points, and at any of them."""
EPS = 2.0**-52
_SHORT, _LONG = 200, 3_000
"""Operations up to which both starts are tried, and up to which the second one is where the first gains nothing."""
_LENGTHENED = 1.25
"""By what factor multiplying out lengthens code with so many brackets that others are likely to serve better."""
_SELDOM = 3
"""Operations of parameters that weigh as much as one with the state."""
_ROUNDS = 4
"""How often the rows at a node and the divisors take turns at the most."""
_WIDE = 2.0
"""States are drawn once as everywhere, then of both signs up to this size."""


def optimized(code: Code) -> Code:
    """The code with fewer operations, or as it is where its results would be less exact."""
    return _each(code, lambda part: next(form for form in _forms(part) if form is part or _as_exact(part, form)))


def rewritten(code: Code) -> Code:
    """The code with fewer operations."""
    return _each(code, lambda part: next(_forms(part)))


def _each(code: Code, rewrite: Callable[[Code], Code]) -> Code:
    """Every routine by itself: one call computes one of them, so that what they share is no gain."""
    parts = [_alone(code, routine) for routine in code.routines]
    found = list(map(rewrite, parts))
    if all(made is part for made, part in zip(found, parts, strict=True)):
        return code
    return verified(found[0] if len(found) == 1 else joined(found), "optimize")


def _alone(code: Code, routine: Routine) -> Code:
    """The code of one routine, with the notes on its guards."""
    if len(code.routines) == 1:
        return code
    needed = set(routine.results)
    body = code.below(needed, True)
    needed.update(body, code.below({*needed, *(a for i in body for a in code.args[i - code.first])}, False))
    return replace(code, routines=(routine,), notes=tuple([(i, note) for i, note in code.notes if i in needed]))


def _forms(code: Code) -> Iterator[Code]:
    """Forms of the code of one routine that are no longer, and the code itself, the cheapest first, what was rewritten before it."""
    own = _counts(code)
    for start in starts(code):
        form = written(start, code)
        if (new := _counts(form))[0] <= own[0] and _cost(new) <= _cost(own):
            yield form
    yield code


def starts(code: Code) -> list[Graph]:
    """The graphs of code from its starts, rewritten, the cheapest first."""
    graph, count = read(code), _counts(code)[0]
    if count > _LONG:
        return [_rewritten(graph)]
    before, out = cost(graph), normal(graph)
    ordered = [out, graph] if cost(out) > _LENGTHENED * before else [graph, out]
    made = [_rewritten(ordered[0])]
    if count <= _SHORT or cost(made[0]) >= before:
        made.append(_rewritten(ordered[1]))
    return sorted(made, key=cost)


def _rewritten(graph: Graph) -> Graph:
    """The graph by all rules, as long as one gains."""
    price = Price(graph, _SELDOM, 1)
    search = Search(graph, price)
    search.run()
    for _ in range(_ROUNDS):
        if not sweep(graph, price):
            break
        search.run()
    return graph


def _counts(code: Code) -> tuple[int, int, int]:
    """Operations of a routine, of parameters included; of these those with the state; and among these divisions."""
    (routine,) = code.routines
    body = code.below(set(routine.results), True)
    needed = {a for i in body for a in code.args[i - code.first]}.union(routine.results)
    own, more = (sum(code.ops[i - code.first].cost for i in part) for part in (body, code.below(needed, False)))
    return own + more, own, sum(code.ops[i - code.first] is DIV for i in body)


def _cost(counts: tuple[int, int, int]) -> tuple[int, int]:
    """Operations, divisions counted twice; and of these those with the state."""
    total, own, divisions = counts
    return total + divisions, own + divisions


def _as_exact(code: Code, result: Code) -> bool:
    """Whether every result is judged at one point at least, is the same but for rounding, and nearly as exact as before."""
    growths: list[list[float]] = [[] for routine in code.routines for _ in routine.results]
    for point in points(code):
        both = zip(growths, rounding(code, point), rounding(result, point), strict=True)
        for found, (value, error), (new, new_error) in both:
            size = error + abs(value)
            if math.isfinite(size):
                growth = (new_error + abs(new)) / size if size else 1.0
                found.append(growth if abs(new - value) <= EPS * (size + new_error) else math.inf)
    return all(found and max(found) <= AT_ONE and _mean(found) <= IN_THE_MEAN for found in growths)


def _mean(growths: list[float]) -> float:
    return math.prod(growths) ** (1.0 / len(growths))


def points(code: Code) -> list[list[float]]:
    """Three points: values of the inputs, those with a default at it."""
    states = {s for port in code.ports if not port.hoisted for s in port.symbols if s.default is None}
    usual = [value_of(s, 0) for s in code.inputs]
    wide = [
        [draw(seed, s, -_WIDE, _WIDE) if s in states else v for s, v in zip(code.inputs, usual, strict=True)]
        for seed in (1, 2)
    ]
    return [usual, *wide]
