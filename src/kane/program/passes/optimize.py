# SPDX-License-Identifier: BSD-3-Clause
"""Reduction of operations: code is read as a graph of sums and products, rewritten, and written with a short critical path.

There are two starting points: the sums and products as they are, and expanded (`rewrite/node_rows.py`). For short code both are tried,
else the more promising one, and the other if that gains nothing. The cheapest of these and the original code is taken.

Results change by rounding errors, so that the pass requires contraction. Taking out a factor never raises the running error bound;
reordering a sum may, if terms cancel. So the bounds of both are compared at several points, and a form is rejected if the bound of a
result is more than twice as large in the geometric mean over the points, or four times at one.

`with_reciprocals` replaces divisions by a common divisor with one reciprocal and multiplications.

A division costs a processor about ten multiplications. x/d becomes x·(1/d) if 1/d serves at least two divisions of a routine, or can
be hoisted because d depends only on parameters. Each result changes by a rounding error, so that the pass requires contraction and is
omitted if results must be those of the expressions bit by bit.

`rounding` computes first-order running error bounds of the results of code at given values.

Each operation rounds its result z by at most |z| ε/2 and propagates the errors of its arguments, times its partial derivatives
(Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., sec. 3.3).
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
    """All results at `values` of the inputs, each with its error bound in units of ε/2, NaN if no bound is known."""
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
    """The error bound of z = op(args)."""
    if not math.isfinite(z):
        return math.nan
    rule = _PASSED_ON.get(op)
    return rule(z, args, errors) if rule else _by_derivative(op, z, args, errors)


def _by_derivative(op: Op, z: float, args: list[float], errors: list[float]) -> float:
    """The error bound of z = op(args) by the derivatives in the table of operations."""
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
"""Error bounds of z = op(args) for operations that do not round or whose derivatives are slow to evaluate."""


IN_THE_MEAN, AT_ONE = 2.0, 4.0
"""The maximum growth of a result's error bound: in the geometric mean over the points, and at any point."""
EPS = 2.0**-52
_SHORT, _LONG = 200, 3_000
"""The numbers of operations up to which both starts are tried, and up to which the second is tried if the first gains nothing."""
_LENGTHENED = 1.25
"""The growth of the cost by expansion above which the expanded start is tried first."""
_SELDOM = 3
"""The number of operations on parameters that weigh as much as one on the state."""
_ROUNDS = 4
"""The maximum number of alternations between row rewriting and divisor extraction."""
_WIDE = 2.0
"""The range of the states of both signs drawn for the second and third points."""


class Rules(NamedTuple):
    """The rewriting rules; `benchmarks/ablation.py` measures the effect of omitting each.

    `divisors` are the kinds extracted from graphs and `rows` rewrite sums, from each of the `starts`; with `limbs`, code with
    isomorphic subgraphs is vectorized instead.
    """

    divisors: tuple[type[DivisorKind], ...] = DIVISORS
    rows: tuple[NodeRow, ...] = ROWS
    starts: tuple[str, ...] = ("as read", "multiplied out")
    limbs: bool = True


RULES = Rules()


def optimized(code: Code, rules: Rules = RULES) -> Code:
    """The code with fewer operations, or unchanged if its results would be less accurate."""
    return _each(code, lambda part: next(form for form in _forms(part, rules) if form is part or _as_exact(part, form)))


def rewritten(code: Code, rules: Rules = RULES) -> Code:
    """The code with fewer operations."""
    return _each(code, lambda part: next(_forms(part, rules)))


def _each(code: Code, rewrite: Callable[[Code], Code]) -> Code:
    """Rewrites every routine separately: a call computes one of them, so that sharing between routines gains nothing."""
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
    """Rewritten forms of a routine that cost no more, the cheapest first, then the code itself."""
    own = _counts(code)
    for start in starts(code, own[0], rules):
        form = written(start, code)
        if (new := _counts(form))[0] <= own[0] and _cost(new) <= _cost(own):
            yield form
    yield code


def starts(code: Code, count: int | None = None, rules: Rules = RULES) -> list[Graph]:
    """The rewritten graphs of code with `count` operations, from its starting points, the cheapest first."""
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
    """The graph, rewritten by all rules until none gains."""
    price = Price(graph, _SELDOM, 1)
    search = DivisorSearch(graph, price, rules.divisors)
    search.run()
    for _ in range(_ROUNDS):
        if not sweep(graph, price, rules.rows):
            break
        search.run()
    graph.listener = None  # breaks a reference cycle
    return graph


def _counts(code: Code) -> tuple[int, int, int]:
    """The numbers of operations of a routine: all, those on the state, and the divisions among the latter."""
    (routine,) = code.routines
    body = code.below(set(routine.results), True)
    needed = {a for i in body for a in code.args[i - code.first]}.union(routine.results)
    own, more = (sum(code.ops[i - code.first].cost for i in part) for part in (body, code.below(needed, False)))
    return own + more, own, sum(code.ops[i - code.first] is DIV for i in body)


def _cost(counts: tuple[int, int, int]) -> tuple[int, int]:
    """The cost: operations with divisions counted twice, in total and on the state."""
    total, own, divisions = counts
    return total + divisions, own + divisions


def _as_exact(code: Code, result: Code) -> bool:
    """Whether each result could be compared at some point, agrees within rounding, and has a similar error bound."""
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
    """Three points of values of the inputs; inputs with a default have it."""
    states = {s for port in code.ports if not port.hoisted for s in port.symbols if s.default is None}
    usual = [value_of(s, 0) for s in code.inputs]
    wide = [
        [draw(seed, s, -_WIDE, _WIDE) if s in states else v for s, v in zip(code.inputs, usual, strict=True)]
        for seed in (1, 2)
    ]
    return [usual, *wide]


_WORTH = 2
"""The number of divisions by one divisor from which a reciprocal is computed."""


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
    """The divisors whose reciprocal is computed."""
    divisors: set[int] = set()
    for routine in code.routines:
        below = code.below(set(routine.results), True)
        divided = [code.args[i - code.first][1] for i in below if code.ops[i - code.first] is DIV]
        divisors.update(d for d, n in Counter(divided).items() if n >= _WORTH or not code.varies[d])
    return divisors
