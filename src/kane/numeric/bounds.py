# SPDX-License-Identifier: BSD-3-Clause
"""Values of expressions, and how far rounding may carry them: a value that is no larger than its bound counts as zero.

|Δ(a b)| ≤ |a| |Δb| + |b| |Δa| + |Δa| |Δb| and so on, each result and 2⁻⁵¹ of it (Higham 2002, Accuracy and Stability of Numerical
Algorithms, sec. 3.1); constants that were computed while the expression was built bring their own bounds along. So a sum is judged
beside the terms that cancel in it, in any units, also where they cancel everywhere. The bounds are of the first order of what happens,
not sharp: terms that depend on each other are taken for independent ones. Turned from link to link a vector's bound doubles with each,
so that it says nothing after fifty. So in long expressions a bound is no larger than a thousand times what random changes of all
results by their rounding change the root by (Vignes 2004, Discrete stochastic arithmetic, Numerical Algorithms 37).
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.expr.constants import error_of, number_of
from kane.expr.node import Expr, nodes, postorder
from kane.expr.ops import ADD, CONST, COS, DIV, MUL, NEG, OPS, PI, REGULAR, SIN, SQRT, SUB, SYMBOL, WHERE, Op
from kane.numeric.sampling import SEEDS, draw, unit

ROUNDING = 2.0**-51
_LONG = 1000
"""Nodes from which on values are changed at random: below, a chain is too short for bounds to grow."""
_CHANGES, _AMPLE = 8, 1024.0
"""How often; and how many times as far as these lead rounding may carry a value: errors of many results may all be of one sign."""
Bounded = tuple[Any, Any]
"""A value and its bound, numbers or arrays."""


def bounded(roots: Iterable[Expr], values: Mapping[Any, Any], share: float = ROUNDING) -> list[Bounded]:
    """Value and bound of each root, every symbol off by a `share` of its value at most; infinity or NaN where nothing bounds it."""
    known: dict[Expr, Bounded] = {}
    wanted = list(roots)
    order = postorder(wanted)
    with np.errstate(all="ignore"):
        for node in order:
            op = node.op
            if not node.args:
                known[node] = _leaf(node, values, share)
            elif op is MUL:
                (a, s), (b, t) = known[node.args[0]], known[node.args[1]]
                z = a * b
                known[node] = z, abs(a) * t + abs(b) * s + s * t + abs(z) * ROUNDING
            elif op is ADD or op is SUB:
                (a, s), (b, t) = known[node.args[0]], known[node.args[1]]
                z = a + b if op is ADD else a - b
                known[node] = z, s + t + abs(z) * ROUNDING
            else:
                parts = [known[x] for x in node.args]
                z = op.numpy(*[x for x, _ in parts])
                known[node] = z, _RULES.get(op, _by_differences(op))(z, *parts)
        if len(order) < _LONG:
            return [known[r] for r in wanted]
        changed = _changed(order, values, share)
        return [(x, np.fmin(error, _AMPLE * _furthest(x, changed[r]))) for r in wanted for x, error in (known[r],)]


def _changed(order: Iterable[Expr], values: Mapping[Any, Any], share: float) -> dict[Expr, Any]:
    """Values with each result changed by its rounding, and each leaf within its bound, at random: arrays with one more axis."""
    rng = np.random.default_rng(SEEDS[0])
    found: dict[Expr, Any] = {}
    for node in order:
        by = rng.uniform(-1.0, 1.0, _CHANGES)
        if node.args:
            found[node] = node.op.numpy(*[found[x] for x in node.args]) * (1.0 + ROUNDING * by)
        else:
            x, error = _leaf(node, values, share)
            found[node] = np.asarray(x)[..., None] + np.asarray(error)[..., None] * by
    return found


def _furthest(x: Any, changed: Any) -> Any:
    return np.abs(changed - np.asarray(x)[..., None]).max(axis=-1)


def vanish(
    exprs: Iterable[Expr], groups: Iterable[Sequence[Any]] = (), known: Mapping[Any, float] | None = None
) -> list[bool]:
    """Which of the expressions are zero but for rounding whatever their symbols are: at all of several states drawn at random.

    `groups` are Euler parameters; parameters are drawn, too, but for those that are `known`.
    """
    roots, known = list(exprs), known or {}
    symbols = [node for node in nodes(roots) if node.op is SYMBOL]
    values = unit({s: np.array([known.get(s, draw(seed, s)) for seed in SEEDS]) for s in symbols}, groups)
    return [bool(np.all((abs(x) <= error) & (error < np.inf))) for x, error in bounded(roots, values)]


def _leaf(node: Expr, values: Mapping[Any, Any], share: float) -> Bounded:
    if node.op is CONST:
        return np.float64(number_of(node)), error_of(node)
    if node.op is PI:
        return np.float64(math.pi), math.pi * ROUNDING
    x: Any = values[node]
    if not isinstance(x, np.ndarray):
        x = np.float64(x)
    return x, abs(x) * share


def _by_differences(op: Op) -> Callable[..., Any]:
    """The rule of an operation whose arguments are moved by their bounds, one at a time, both ways."""

    def rule(z: Any, *parts: Bounded) -> Any:
        total = abs(z) * ROUNDING
        for k, (_, s) in enumerate(parts):
            ends = [op.numpy(*[y + d * (i == k) for i, (y, _) in enumerate(parts)]) for d in (-s, s)]
            total = total + np.fmax(abs(ends[0] - z), abs(ends[1] - z))
        return total

    return rule


def _quotient(z: Any, above: Bounded, below: Bounded) -> Any:
    least = abs(below[0]) - below[1]
    return np.where(least > 0, (above[1] + abs(z) * below[1]) / least, np.inf)[()] + abs(z) * ROUNDING


_RULES: dict[Op, Callable[..., Any]] = {
    NEG: lambda z, a: a[1],
    OPS["abs"]: lambda z, a: a[1],
    DIV: _quotient,
    SIN: lambda z, a: np.minimum(abs(np.cos(a[0])) * a[1] + a[1] ** 2 / 2, 2.0) + abs(z) * ROUNDING,
    COS: lambda z, a: np.minimum(abs(np.sin(a[0])) * a[1] + a[1] ** 2 / 2, 2.0) + abs(z) * ROUNDING,
    SQRT: lambda z, a: np.fmin(a[1] / z, np.sqrt(a[1])) + z * ROUNDING,
    OPS["min"]: lambda z, a, b: np.maximum(a[1], b[1]),
    OPS["max"]: lambda z, a, b: np.maximum(a[1], b[1]),
    OPS["less"]: lambda z, a, b: 0.0,
    OPS["sign"]: lambda z, a: 0.0,
    OPS["floor"]: lambda z, a: 0.0,
    REGULAR: lambda z, a, size: a[1],
    WHERE: lambda z, condition, a, b: np.where(condition[0], a[1], b[1])[()],
}
"""The bound of z = op(a, …) from the values and bounds of its arguments; of others by differences."""
