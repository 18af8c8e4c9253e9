# SPDX-License-Identifier: BSD-3-Clause
"""How far rounding may carry the results of code at given values: the running error bound, of first order.

Each operation rounds its result z by |z| ε/2 and passes on the errors of its arguments, times its partial derivatives (Higham,
*Accuracy and Stability of Numerical Algorithms*, 2nd ed., sec. 3.3).
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from kane.errors import ExpressionError
from kane.expr.floats import FLOAT
from kane.expr.node import as_expr, constant, constant_value
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, OPS, REGULAR, SIN, SQRT, SUB, WHERE, Op
from kane.program.program import Code


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
