# SPDX-License-Identifier: BSD-3-Clause
"""Numbers on the configuration constraints: f(q, t) = 0 and eᵀe = 1, closed by Gauss–Newton steps of least size."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.expr.build import sub
from kane.expr.differentiation import jacobian
from kane.expr.evaluation import Reference, compile_reference
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, Expr
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.bounds import bounded
from kane.numeric.many import Indices, Rounding, Sizes, sizes
from kane.numeric.newton import Residual
from kane.program.bundle import Bundle

_SEED = 20048
ROWS = 16
"""How many places are looked at one by one."""


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """What a configuration must satisfy: names, f and ∂f/∂q in the order of the coordinates."""

    names: tuple[str, ...]
    f: tuple[Expr, ...]
    gradient: Matrix


def closure(system: System) -> Closure:
    """The configuration constraints of a system, those of its Euler parameters last."""
    f = [c.expr for c in system.holonomic]
    names = [c.name for c in system.holonomic]
    for s in system.euler_parameters:
        f.append(sub(dot(s.coordinates, s.coordinates), ONE))
        names.append(f"unit length of ({', '.join(e.name for e in s.coordinates)})")
    return Closure(
        tuple(names), tuple(f), jacobian(f, system.coordinates) if f else Matrix([], (0, len(system.coordinates)))
    )


def many_function(
    system: System, conditions: Closure, values: Mapping[Expr, Any]
) -> Callable[[Array], tuple[Array, Array]]:
    """f (k × m) and ∂f/∂q (k × m × n) as a function of q (k × n), all other symbols at `values`."""
    run = compile_reference([*conditions.f, *conditions.gradient.entries], [*system.coordinates, *values])
    m, shape, rest = len(conditions.f), conditions.gradient.shape, list(values.values())

    def function(x: Array) -> tuple[Array, Array]:
        numbers = in_rows(run, x, rest)
        return numbers[:, :m], numbers[:, m:].reshape(len(x), *shape)

    return function


def in_rows(run: Reference, x: Array, others: Sequence[Any]) -> Array:
    """What `run` gives at each row of x (k × n) and of the others, which are numbers or arrays (k): k × results.

    A few rows go one by one, in Python's floats, which take a twentieth of the time of arrays of a few.
    """
    if 0 < len(x) <= ROWS:
        columns = [np.broadcast_to(v, len(x)).tolist() if np.ndim(v) else [float(v)] * len(x) for v in others]
        return np.array(run.rows([[*row, *rest] for row, *rest in zip(x.tolist(), *columns, strict=True)]), dtype=float)
    values = run([*x.T, *others])
    numbers = np.empty((len(x), len(values)))
    for k, value in enumerate(values):
        numbers[:, k] = value
    return numbers


def rounding_function(system: System, conditions: Closure, values: Mapping[Any, Any]) -> Rounding:
    """How far rounding may carry f (k × m) at q (k × n) of starts by number: of these other symbols have numbers, or one value."""

    def rounding(x: Array, starts: Indices) -> Array:
        own = {s: v if np.ndim(v) == 0 else np.asarray(v)[starts] for s, v in values.items()}
        own |= zip(system.coordinates, x.T, strict=True)
        return np.stack([np.broadcast_to(e, len(x)) for _, e in bounded(conditions.f, own)], axis=1)

    return rounding


def usual_sizes(system: System, conditions: Closure, values: Mapping[Expr, Any]) -> Sizes:
    """How large coordinates and the terms of f are by their nature, all other symbols at `values`."""
    function, n = many_function(system, conditions, values), len(system.coordinates)
    x = np.vstack([np.zeros(n), np.random.default_rng(_SEED).uniform(-np.pi, np.pi, (11, n))])
    rounding = rounding_function(system, conditions, values)
    return sizes(lambda x, _: function(x), x, unit_places(system, range(n)), rounding)


def unit_places(system: System, among: Sequence[int]) -> list[int]:
    """Where Euler parameters are among the coordinates of these places."""
    unit = {e for s in system.euler_parameters for e in s.coordinates}
    return [k for k, i in enumerate(among) if system.coordinates[i] in unit]


def residual_function(system: System, conditions: Closure, values: Mapping[Expr, Any]) -> Residual:
    """f and ∂f/∂q as a function of the coordinates, all other symbols at `values`, on the reference evaluator."""
    bundle = Bundle("closure", (), lambda *parts: parts, {"f": conditions.f, "gradient": conditions.gradient})
    run = bundle.reference([*system.coordinates, *values])
    numbers = list(values.values())
    return lambda q: run([*q, *numbers])
