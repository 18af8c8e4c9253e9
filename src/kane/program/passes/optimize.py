# SPDX-License-Identifier: BSD-3-Clause
"""Fewer operations: code is read as a graph of sums and products, rewritten there, and written in an order that waits little.

There are two starts: the sums and products as they are, and multiplied out (`rewrite/node_rows.py`). Of short code both are tried,
else the one that promises more, and the other where that gains nothing. Of these and the code itself the shortest is taken.

Results change by rounding errors, so that the pass belongs to compilation with contraction. Taking out a factor never raises the
running error bound; sums in another order may, where terms cancel. So the bounds of both are compared at several points, and a form
is left where the bound of a result would be more than twice as large in the mean of the points, or four times at one.

Divisions by one divisor become one reciprocal and multiplications.

A division costs a processor about ten multiplications. x/d becomes x·(1/d) where 1/d serves at least two divisions of a
routine, or can be hoisted because d depends on parameters alone. Results change by a rounding error each, so that the pass belongs
to compilation with contraction and is left out where results must be those of the expressions bit by bit.

How far rounding may carry the results of code at given values: the running error bound, of first order.

Each operation rounds its result z by |z| ε/2 and passes on the errors of its arguments, times its partial derivatives (Higham,
*Accuracy and Stability of Numerical Algorithms*, 2nd ed., sec. 3.3).
"""

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kane.errors import ExpressionError
from kane.expr.evaluation import FLOAT
from kane.expr.node import as_expr, constant, constant_value
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, OPS, REGULAR, SIN, SQRT, SUB, WHERE, Op
from kane.numeric.sampling import draw, value_of
from kane.program.passes.graphs import joined, read, written
from kane.program.program import Code, Routine, verified
from kane.rewrite.divisors import DIVISORS, DivisorKind, DivisorSearch
from kane.rewrite.graph import Graph, Price, cost
from kane.rewrite.node_rows import ROWS, NodeRow, normal, sweep


def rounding(code: Code, values: Sequence[float]) -> list[tuple[float, float]]:
    """All results at `values` of the inputs, each with the bound on its error in units of ε/2, NaN where none holds."""
    v = [*values, *code.constants]
    e = [0.0] * len(v)
    with np.errstate(all="ignore"):
        for op, reads in zip(code.ops, code.args, strict=True):
            if op is MUL:
                a, b = reads
                x, y = v[a], v[b]
                z = x * y
                error = abs(x) * e[b] + abs(y) * e[a] + abs(z)
            elif op is ADD:
                a, b = reads
                z = v[a] + v[b]
                error = e[a] + e[b] + abs(z)
            elif op is SUB:
                a, b = reads
                z = v[a] - v[b]
                error = e[a] + e[b] + abs(z)
            elif op is NEG:
                z, error = -v[reads[0]], e[reads[0]]
            else:
                args = [v[i] for i in reads]
                z = FLOAT[op](*args)
                error = _passed_on(op, z, args, [e[i] for i in reads])
            v.append(z)
            e.append(error)
    return [(v[i], e[i]) for routine in code.routines for i in routine.results]


def _passed_on(op: Op, z: float, args: list[float], errors: list[float]) -> float:
    """The error of z = op(args)."""
    if not math.isfinite(z):
        return math.nan
    rule = _PASSED_ON.get(op)
    return rule(z, args, errors) if rule else _by_derivative(op, z, args, errors)


def _by_derivative(op: Op, z: float, args: list[float], errors: list[float]) -> float:
    """The error of z = op(args) by the derivatives of the table of operations."""
    if not any(errors) or op.derivative is None:
        return abs(z)
    try:
        slopes = [constant_value(as_expr(s)) for s in op.derivative(constant(z), *map(constant, args))]
    except ExpressionError:
        return math.nan
    return abs(z) + sum(
        abs(float(s)) * d if s is not None else math.nan for s, d in zip(slopes, errors, strict=True) if d
    )


_PASSED_ON: dict[Op, Callable[[float, list[float], list[float]], float]] = {
    DIV: lambda z, args, errors: (errors[0] + abs(z) * errors[1]) / abs(args[1]) + abs(z),
    SQRT: lambda z, args, errors: (errors[0] / (2 * z) if z else math.nan) + z if errors[0] else z,
    SIN: lambda z, args, errors: abs(math.cos(args[0])) * errors[0] + abs(z),
    COS: lambda z, args, errors: abs(math.sin(args[0])) * errors[0] + abs(z),
    REGULAR: lambda z, args, errors: errors[0],
    WHERE: lambda z, args, errors: errors[1 if args[0] else 2],
    OPS["abs"]: lambda z, args, errors: errors[0],
    OPS["min"]: lambda z, args, errors: errors[args.index(z)],
    OPS["max"]: lambda z, args, errors: errors[args.index(z)],
    OPS["less"]: lambda z, args, errors: 0.0,
    OPS["sign"]: lambda z, args, errors: 0.0,
    OPS["floor"]: lambda z, args, errors: 0.0,
}
"""The error of z = op(args) where the table's derivative would take long or round nothing."""


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


class Rules(NamedTuple):
    """What rewrites code: what an entry brings shows where it is left out (`benchmarks/ablation.py`).

    `divisors` are taken out of graphs and `rows` rewrite sums, from each of the `starts`; `limbs` that are alike stay side by
    side, as they are.
    """

    divisors: tuple[type[DivisorKind], ...] = DIVISORS
    rows: tuple[NodeRow, ...] = ROWS
    starts: tuple[str, ...] = ("as read", "multiplied out")
    limbs: bool = True


RULES = Rules()


def optimized(code: Code, rules: Rules = RULES) -> Code:
    """The code with fewer operations, or as it is where its results would be less exact."""
    return _each(code, lambda part: next(form for form in _forms(part, rules) if form is part or _as_exact(part, form)))


def rewritten(code: Code, rules: Rules = RULES) -> Code:
    """The code with fewer operations."""
    return _each(code, lambda part: next(_forms(part, rules)))


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


def _forms(code: Code, rules: Rules) -> Iterator[Code]:
    """Forms of the code of one routine that are no longer, and the code itself, the cheapest first, what was rewritten before it."""
    own = _counts(code)
    for start in starts(code, own[0], rules):
        form = written(start, code)
        if (new := _counts(form))[0] <= own[0] and _cost(new) <= _cost(own):
            yield form
    yield code


def starts(code: Code, count: int | None = None, rules: Rules = RULES) -> list[Graph]:
    """The graphs of code, of so many operations, from its starts, rewritten, the cheapest first."""
    graph = read(code)
    count = _counts(code)[0] if count is None else count
    if count > _LONG or "multiplied out" not in rules.starts:
        return [_rewritten(graph, rules)]
    if "as read" not in rules.starts:
        return [_rewritten(normal(graph), rules)]
    before, out = cost(graph), normal(graph)
    first, second = (out, graph) if cost(out) > _LENGTHENED * before else (graph, out)
    made = _rewritten(first, rules)
    if count > _SHORT and cost(made) < before:
        return [made]
    other = _rewritten(second, rules)
    return sorted([made, other], key=cost)


def _rewritten(graph: Graph, rules: Rules) -> Graph:
    """The graph by all rules, as long as one gains."""
    price = Price(graph, _SELDOM, 1)
    search = DivisorSearch(graph, price, rules.divisors)
    search.run()
    for _ in range(_ROUNDS):
        if not sweep(graph, price, rules.rows):
            break
        search.run()
    graph.listener = None  # else each holds the other
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


_WORTH = 2
"""Divisions by one divisor from which a reciprocal is computed."""


def with_reciprocals(code: Code) -> Code:
    """The code with shared reciprocals."""
    chosen = _divisors(code)
    if not chosen:
        return code
    count = len(code.inputs)
    one = next((count + k for k, v in enumerate(code.constants) if v == 1.0), code.first)
    constants = code.constants if one < code.first else (*code.constants, 1.0)
    first = count + len(constants)
    place = list(range(code.first))
    reciprocal: dict[int, int] = {}
    ops: list[Op] = []
    args: list[tuple[int, ...]] = []

    def emit(op: Op, reads: tuple[int, ...]) -> int:
        ops.append(op)
        args.append(reads)
        return first + len(ops) - 1

    for op, reads in zip(code.ops, code.args, strict=True):
        now = tuple([place[a] for a in reads])
        if op is not DIV or reads[1] not in chosen:
            place.append(emit(op, now))
            continue
        divisor = reads[1]
        if divisor not in reciprocal:
            reciprocal[divisor] = emit(DIV, (one, now[1]))
        inverse = reciprocal[divisor]
        place.append(inverse if now[0] == one else emit(MUL, (now[0], inverse)))
    routines = tuple(dataclasses.replace(g, results=tuple(place[i] for i in g.results)) for g in code.routines)
    notes = tuple((place[i], text) for i, text in code.notes)
    result = dataclasses.replace(
        code, constants=constants, ops=tuple(ops), args=tuple(args), routines=routines, notes=notes
    )
    return verified(result, "reciprocal")


def _divisors(code: Code) -> set[int]:
    """The divisors whose reciprocal is worth computing."""
    divisors: set[int] = set()
    for routine in code.routines:
        below = code.below(set(routine.results), True)
        divided = [code.args[i - code.first][1] for i in below if code.ops[i - code.first] is DIV]
        divisors.update(d for d, n in Counter(divided).items() if n >= _WORTH or not code.varies[d])
    return divisors
