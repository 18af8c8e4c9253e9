# SPDX-License-Identifier: BSD-3-Clause
"""The reference evaluator: the graph as a list of NumPy calls, the meaning that every emitter must reproduce; its symbols."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.errors import ValueMissingError
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr, constant_value, postorder
from kane.expr.ops import CONST, PI, SYMBOL
from kane.expr.symbols import Parameter, Symbol

Values = Mapping[Any, Any]


def compile_reference(roots: Iterable[Expr], leaves: Sequence[Expr]) -> Callable[[Sequence[Any]], list[Any]]:
    """A function from the values of `leaves` (numbers or broadcastable arrays) to the values of `roots`.

    The function touches no shared state: threads may call it at the same time. Division by zero and the like give
    infinity or NaN as IEEE 754 says, without a warning.
    """
    wanted = [as_expr(r) for r in roots]
    order = postorder(wanted)
    place: dict[Expr, int] = {leaf: i for i, leaf in enumerate(leaves)}
    start: list[Any] = [None] * len(leaves)
    steps: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []
    for node in order:
        if node in place:
            continue
        place[node] = len(start)
        if node.op is CONST:
            start.append(np.float64(float(constant_value(node) or 0)))
        elif node.op is PI:
            start.append(np.float64(math.pi))
        elif node.op is SYMBOL:
            raise ValueMissingError(
                f"Expected a value for every symbol, got none for {node} ({type(node).__name__}). Known here: "
                f"{', '.join(str(s) for s in leaves) or 'none'}."
            )
        else:
            start.append(None)
            steps.append((node.op.numpy, tuple(place[a] for a in node.args), place[node]))
    outputs = [place[r] for r in wanted]
    count = len(leaves)

    def run(values: Sequence[Any]) -> list[Any]:
        work = start.copy()
        work[:count] = values
        with np.errstate(all="ignore"):
            for f, args, out in steps:
                work[out] = f(*[work[i] for i in args])
        return [work[i] for i in outputs]

    return run


def evaluate(exprs: Any, values: Values) -> Any:
    """Values of one expression, or of a sequence or Matrix of them, at numbers or broadcastable arrays.

    Those of a sequence all have the broadcast shape. Parameters without a value take their default; any other symbol
    without one is a `ValueMissingError`.
    """
    if isinstance(exprs, Matrix):
        return stacked(evaluate(exprs.entries, values), exprs.shape)
    if isinstance(exprs, Expr | int | float):
        return evaluate([exprs], values)[0]
    roots = [as_expr(e) for e in exprs]
    arrays: dict[Expr, Any] = {symbol: np.asarray(value, dtype=np.float64)[()] for symbol, value in values.items()}
    for node in postorder(roots):
        if isinstance(node, Parameter) and node not in arrays and node.default is not None:
            arrays[node] = np.float64(node.default)
    run = compile_reference(roots, list(arrays))
    results = [np.asarray(v) for v in run(list(arrays.values()))]
    shape = np.broadcast_shapes(*(v.shape for v in results))
    return [v if v.shape == shape else np.broadcast_to(v, shape).copy() for v in results]


def stacked(entries: Sequence[Any], shape: tuple[int, int]) -> Any:
    """A matrix of numbers, or of arrays as its leading axes, from its entries row by row."""
    leading = entries[0].shape if entries else ()
    flat = np.stack(entries) if entries else np.zeros((0,))
    return np.moveaxis(flat.reshape(*shape, *leading), (0, 1), (-2, -1))


def free_symbols(roots: Iterable[Expr]) -> tuple[Symbol, ...]:
    """The symbols below `roots`, in the order of their first appearance."""
    return tuple(n for n in postorder(roots) if isinstance(n, Symbol))


def is_constant_in_time(exprs: Iterable[Expr]) -> bool:
    """Whether the expressions hold parameters and numbers only."""
    return all(isinstance(s, Parameter) for s in free_symbols(exprs))
