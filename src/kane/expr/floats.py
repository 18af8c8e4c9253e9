# SPDX-License-Identifier: BSD-3-Clause
"""A graph as a list of instructions in Python's floats: for one state, many times as quick as NumPy's scalars.

Nodes of one kind that do not wait for each other stand in one batch, and a product that only one sum or difference holds is computed
within it; each operation still rounds by itself, so that the numbers are NumPy's bit by bit, infinity and NaN included.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from kane.expr.node import Expr
from kane.expr.ops import ADD, DIV, GONE, LESS, MUL, NEG, OPS, REGULAR, SQRT, SUB, WHERE, Op

Rows = list[tuple[int, ...]]
Batch = Callable[[list[float], Rows], None]


def _rounded(function: Callable[..., Any]) -> Callable[..., float]:
    return lambda *args: float(function(*args))


def _quotient(x: float, y: float) -> float:
    """x / y as IEEE 754 has it."""
    if y:
        return x / y
    return math.copysign(math.inf, x) * math.copysign(1.0, y) if x < 0 or x > 0 else math.nan


FLOAT: dict[Op, Callable[..., float]] = {
    **{op: _rounded(op.numpy) for op in OPS.values() if op.arity},
    **{op: op.numpy for op in (ADD, SUB, MUL, NEG)},
    DIV: _quotient,
    SQRT: lambda x: math.nan if x < 0 else math.sqrt(x),
    LESS: lambda x, y: 1.0 if x < y else 0.0,
    WHERE: lambda condition, x, y: x if condition else y,
    REGULAR: lambda x, size: x if abs(x) > GONE * size else math.nan,
    OPS["abs"]: abs,
}
"""Each operation on floats; those that a processor's library may round in another way are NumPy's own."""


def know(op: Op) -> None:
    """One more operation."""
    FLOAT[op] = _rounded(op.numpy)
    _BATCHES[op, False, False] = _each(FLOAT[op])


def _add(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] + w[b])


def _sub(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] - w[b])


def _mul(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] * w[b])


def _add_product(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] + w[b] * w[c])


def _sub_product(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] - w[b] * w[c])


def _product_sub(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] * w[b] - w[c])


def _add_products(w: list[float], rows: Rows) -> None:
    for a, b, c, d in rows:
        w.append(w[a] * w[b] + w[c] * w[d])


def _sub_products(w: list[float], rows: Rows) -> None:
    for a, b, c, d in rows:
        w.append(w[a] * w[b] - w[c] * w[d])


def _each(function: Callable[..., float]) -> Batch:
    def batch(w: list[float], rows: Rows) -> None:
        for row in rows:
            w.append(function(*[w[i] for i in row]))

    return batch


_BATCHES: dict[tuple[Op, bool, bool], Batch] = {
    **{(op, False, False): _each(function) for op, function in FLOAT.items()},
    (ADD, False, False): _add,
    (SUB, False, False): _sub,
    (MUL, False, False): _mul,
    (ADD, False, True): _add_product,
    (SUB, False, True): _sub_product,
    (SUB, True, False): _product_sub,
    (ADD, True, True): _add_products,
    (SUB, True, True): _sub_products,
}
"""By operation, and whether its two arguments are products computed within."""


def in_batches(
    order: Sequence[Expr], roots: Sequence[Expr], leaves: Mapping[Expr, float | None]
) -> Callable[[Mapping[Expr, float]], list[float]]:
    """A function from numbers for those of `leaves` that have none to the values of `roots`.

    Parameters
    ----------
    order : every node below the roots, arguments before their users
    leaves : the nodes without arguments, and the numbers of constants
    """
    kinds, arguments = _kinds(order, roots)
    place = {leaf: i for i, leaf in enumerate(leaves)}
    program: list[tuple[Batch, Rows]] = []
    for kind, nodes in _batched(kinds, arguments):
        place.update(zip(nodes, range(len(place), len(place) + len(nodes)), strict=True))
        program.append((_BATCHES[kind], [tuple([place[a] for a in arguments[n]]) for n in nodes]))
    start = [0.0 if value is None else value for value in leaves.values()]
    given = [(place[leaf], leaf) for leaf, value in leaves.items() if value is None]
    outputs = [place[r] for r in roots]

    def run(values: Mapping[Expr, float]) -> list[float]:
        w = start.copy()
        for i, leaf in given:
            w[i] = values[leaf]
        for batch, rows in program:
            batch(w, rows)
        return [w[i] for i in outputs]

    return run


Kind = tuple[Op, bool, bool]


def _kinds(order: Sequence[Expr], roots: Sequence[Expr]) -> tuple[dict[Expr, Kind], dict[Expr, tuple[Expr, ...]]]:
    """What each node does, and to which nodes; products that are computed within their only user are left out."""
    users = Counter(a for node in order for a in node.args)
    users.update(roots)
    within = {
        a for node in order if node.op is ADD or node.op is SUB for a in node.args if a.op is MUL and users[a] == 1
    }
    kinds: dict[Expr, Kind] = {}
    arguments: dict[Expr, tuple[Expr, ...]] = {}
    for node in order:
        args, op = node.args, node.op
        if not args or node in within:
            continue
        first, last = args[0] in within, args[-1] in within
        if not (first or last):
            kinds[node], arguments[node] = (op, False, False), args
            continue
        if op is ADD and first and not last:  # a sum is the same either way round
            args, first, last = (args[1], args[0]), False, True
        kinds[node] = op, first, last
        arguments[node] = (*(args[0].args if first else args[:1]), *(args[1].args if last else args[1:]))
    return kinds, arguments


def _batched(kinds: Mapping[Expr, Kind], arguments: Mapping[Expr, tuple[Expr, ...]]) -> list[tuple[Kind, list[Expr]]]:
    """Batches of one kind in an order in which they can be computed.

    The kinds take turns; a node is computed in the first turn of its kind at which its arguments are known, if only by that batch.
    """
    turns = {kind: k for k, kind in enumerate(dict.fromkeys(kinds.values()))}
    turn: dict[Expr, int] = {}
    batches: dict[int, list[Expr]] = {}
    for node, kind in kinds.items():
        known = max([turn.get(a, 0) for a in arguments[node]])
        mine = turn[node] = known + (turns[kind] - known) % len(turns)
        batches.setdefault(mine, []).append(node)
    return [(kinds[batches[k][0]], batches[k]) for k in sorted(batches)]
