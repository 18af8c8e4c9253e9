# SPDX-License-Identifier: BSD-3-Clause
"""Numbers on the configuration constraints: f(q, t) = 0 and eᵀe = 1, closed by Gauss–Newton steps of least size."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.dynamics.constraints.branches import branch_scalars, branches, turned_function
from kane.expr.build import sub
from kane.expr.diff import jacobian
from kane.expr.evaluate import compile_reference, free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, Expr
from kane.expr.symbols import Parameter, Symbol, input_of, time
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.newton import Closed, Residual, closest, starts
from kane.numeric.sample import values_of
from kane.program.bundle import Bundle

OFF = 1e-6
"""Residual, over the reach of the coordinates, above which no configuration was found."""
TRIES = 12
_MORE = 100
"""Starts beyond those, where closures vanish on several branches and one is meant."""
_SEED = 20322
_TIMES = (1.0, 0.01, 0.0)
"""Shares of a random time at which a mechanism that is driven is closed: t = 0, which may be a special position, comes last."""


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


def residual_function(system: System, conditions: Closure, values: Mapping[Expr, Any]) -> Residual:
    """f and ∂f/∂q as a function of the coordinates, all other symbols at `values`, on the reference evaluator."""
    bundle = Bundle("closure", (), lambda *parts: parts, {"f": conditions.f, "gradient": conditions.gradient})
    run = bundle.reference([*system.coordinates, *values])
    numbers = list(values.values())
    return lambda q: run([*q, *numbers])


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """Values of symbols, with the coordinates on the configuration constraints if that was reached, at random otherwise.

    Nearest to constraints f that cannot hold, Gᵀ f = 0: there the rows of G depend on each other, whatever they do elsewhere.
    `missed` are those that resist there, with what is left of them, the worst first; `drawn` names what constraints depend on and is
    no default: parameters without one, and inputs. `times` are those that were tried, if constraints depend on the time.
    """

    values: dict[Symbol, float]
    missed: tuple[tuple[str, float], ...]
    drawn: tuple[str, ...]
    times: tuple[float, ...] = ()


def sampled(system: System, roots: Sequence[Expr], seed: int = _SEED) -> Sampled:
    """Values of every symbol below `roots`, with the coordinates on the configuration constraints if that can be reached.

    Parameters take their defaults; what has none is drawn at random. Used to choose what is solved for, so that a point off the
    constraints (where none was reached) costs nothing but a worse choice.
    """
    conditions = closure(system)
    scalars = branch_scalars(branches(system))
    values = values_of((*free_symbols([*roots, *conditions.f, *scalars]), *system.coordinates), seed)
    if not conditions.f:
        return Sampled(values, (), ())
    moving = set(system.coordinates)
    start = np.array([values[q] for q in system.coordinates])
    times = [values[time] * share for share in _TIMES] if time in set(free_symbols(conditions.f)) else []
    missed: tuple[tuple[str, float], ...] = ()
    for at in [{time: t} for t in times] or [{}]:
        rest: dict[Expr, Any] = {s: v for s, v in (values | at).items() if s not in moving}
        function, turned = residual_function(system, conditions, rest), turned_function(system, rest)
        every = range(len(start))
        spreads = [1.0] * (TRIES - 1) + [2.0] * (_MORE if scalars else 0)
        best = closest(function, starts(start, every, seed, spreads), every, astray=turned)
        left = _missed(conditions, function, best) or tuple(
            (f"{b.name}: its {b.what} turned", float(x))
            for b, x in zip(branches(system), turned(best.x), strict=True)
            if x
        )
        if not left:
            values.update(at)
            values.update(zip(system.coordinates, best.x.tolist(), strict=True))
            return Sampled(values, (), _drawn(conditions))
        missed = missed or left
    return Sampled(values, missed, _drawn(conditions), tuple(times))


def _missed(conditions: Closure, function: Residual, best: Closed) -> tuple[tuple[str, float], ...]:
    """Constraints that are further off than steps that go on closing would leave them."""
    _, gradient = function(best.x)
    reach = np.abs(gradient) @ np.maximum(np.abs(best.x), 1.0)
    left = [
        (name, float(r))
        for name, r, size in zip(conditions.names, best.residual, reach, strict=True)
        if not abs(r) <= OFF * max(size, 1e-3)
    ]
    return tuple(sorted(left, key=lambda pair: -abs(pair[1])))


def _drawn(conditions: Closure) -> tuple[str, ...]:
    return tuple(
        s.name
        for s in free_symbols(conditions.f)
        if (isinstance(s, Parameter) and s.default is None) or input_of(s) is not None
    )


def matrix_at(matrix: Matrix, values: Mapping[Any, float]) -> Array:
    """A matrix at numbers, of its shape."""
    symbols = free_symbols(matrix.entries)
    run = compile_reference(matrix.entries, list(symbols))
    return np.array(run([values[s] for s in symbols]), dtype=float).reshape(matrix.shape)
