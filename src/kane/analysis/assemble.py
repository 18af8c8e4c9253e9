# SPDX-License-Identifier: BSD-3-Clause
"""`assemble`: a start that satisfies the constraints, from values that are given, guessed, or left out to be solved for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.state import GIVEN, Entries, entries, misses
from kane.dynamics.constraints.closure import Closure, closure, residual_function
from kane.dynamics.readings.values import parameter_values
from kane.equations.equations import Equations
from kane.errors import SimulationError, ValueMissingError
from kane.expr.evaluate import evaluate
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Speed, time
from kane.numeric.arrays import Array
from kane.numeric.named import named_values
from kane.numeric.newton import CLOSED, Closed, Residual, close, closest, starts
from kane.numeric.projection import least_squares
from kane.numeric.rank import STATE_RANK, singular

_TRIES, _SEED = 24, 20048
_ROUNDING = 1e-7
"""Share of the largest row of A below which a row's misses are compared with the largest instead: near a singular position."""


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """A state on the constraints: `q` and `u` by symbol, ready for `simulate(q=…, u=…)`, and the largest `residual`."""

    q: dict[Coordinate, float]
    u: dict[Speed, float]
    residual: float

    def __repr__(self) -> str:
        values = ", ".join(f"{s} = {v:.6g}" for s, v in (*self.q.items(), *self.u.items()))
        return f"Assembled({values}; residual {self.residual:.1e})"


def assemble(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[float] | None = None,
    u: Mapping[Any, Any] | Sequence[float] | None = None,
    rates: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
) -> Assembled:
    """A state that satisfies all constraints.

    Values that are given are kept, guesses (`kn.guess(value)`) may move, what is left out is solved for: coordinates by
    Gauss–Newton steps from the guesses (from several starts where there is none), speeds by linear least squares.

    Parameters
    ----------
    eom : Equations
    q : coordinates by symbol or name
    u : speeds by symbol or name; left out altogether, the system is at rest as far as the constraints let it
    rates : rates of coordinates by coordinate, in place of `u`
    inputs : values at `t` of the inputs (and of their derivatives) that constraints hold

    Raises
    ------
    ValueMissingError
        if the constraints do not determine what is left out
    SimulationError
        if no state satisfies the constraints with the values that are given; says which constraint resists, and by how much
    """
    constants: dict[Expr, Any] = {**parameter_values(eom.system, parameters), time: float(t)}
    constants.update(named_values("inputs", eom.inputs, inputs))
    configuration = _configuration(eom, entries("coordinates", eom.coordinates, q), constants)
    at: dict[Expr, Any] = {**constants, **dict(zip(eom.coordinates, configuration.x.tolist(), strict=True))}
    if u is not None and rates is not None:
        raise SimulationError("Expected either u= or rates= to assemble with, got both.")
    speeds, left = _motion(eom, _wanted_speeds(eom, u, rates), at, rates is not None)
    return Assembled(
        dict(zip(eom.coordinates, configuration.x.tolist(), strict=True)),
        dict(zip(eom.speeds, speeds.tolist(), strict=True)),
        max(configuration.size, left),
    )


def _configuration(eom: Equations, start: Entries, constants: Mapping[Expr, Any]) -> Closed:
    constraints = closure(eom.system)
    names = [q.name for q in eom.coordinates]
    if not constraints.f:
        if start.missing:
            missing = ", ".join(names[i] for i in start.missing)
            raise ValueMissingError(f"Expected a start value for all coordinates, got none for {missing}.")
        return Closed(start.values, np.zeros(0), 0)
    function = residual_function(eom.system, constraints, constants)
    if not start.free:
        bad = misses(constraints.names, function(start.values)[0])
        if bad:
            raise SimulationError(
                f"Expected start values that satisfy the constraints, got coordinates that miss {bad}. Leave some out, or mark them "
                "with kn.guess(…), to have them solved for."
            )
        return close(function, start.values, range(len(names)))
    spreads = [0.3 + 0.15 * k for k in range(1, _TRIES)] if start.missing else []
    best = closest(function, starts(start.values, start.missing, _SEED, spreads), start.free)
    _check_closed(constraints, function, start, best, names)
    # what is left out must follow from the constraints, what is given and the guesses
    block = function(best.x)[1][:, list(start.free)]
    unknown, count = _undetermined(block, start, names) if start.missing else ([], 0)
    if unknown:
        raise ValueMissingError(
            f"Expected values that determine the configuration, got {count} too few: {', '.join(unknown)} can still move. Give "
            f"{count} of them, or a guess for each: kn.guess(value)."
        )
    return best


def _check_closed(constraints: Closure, function: Residual, start: Entries, best: Closed, names: Sequence[str]) -> None:
    if best.size <= CLOSED:
        return
    first = np.abs(function(start.values)[0]).max()
    moved = ", ".join(names[i] for i in start.guessed)
    worst = int(np.argmax(np.abs(best.residual)))
    raise SimulationError(
        f"Expected a configuration that satisfies the constraints, got none: the residual came from {first:.3g} to {best.size:.3g}, "
        f"and {constraints.names[worst]!r} resists most. "
        + (
            f"Only starts near the guesses were tried: guess nearer, or leave {moved} out, so that others are. "
            if moved
            else ""
        )
        + "The parts may not reach each other with the values given and these lengths: free more coordinates, or correct the lengths."
    )


def _undetermined(block: Array, start: Entries, names: Sequence[str]) -> tuple[list[str], int]:
    """What is left out and may still move where `block`, over what is free, holds the rest; and how many values are too few."""
    directions = singular(block).kernel(STATE_RANK)
    open_ = np.abs(directions).max(axis=0, initial=0) > 1e-7
    return [names[i] for i, x in zip(start.free, open_, strict=True) if x and i in start.missing], len(directions)


def _wanted_speeds(eom: Equations, u: Any, rates: Any) -> Entries:
    if rates is not None:
        return entries("rates, by coordinate,", eom.coordinates, rates)
    if u is None:
        n = len(eom.speeds)
        return Entries(np.zeros(n), tuple(range(n)), ())
    return entries("speeds", eom.speeds, u)


def _motion(eom: Equations, start: Entries, at: Mapping[Expr, Any], by_rates: bool) -> tuple[Array, float]:
    """u with A u + b = 0; with rates u = Y q̇ + z."""
    held = eom.solved.held
    n, m = len(eom.speeds), len(held.b)
    y = np.asarray(evaluate(eom.Y, at), dtype=float)[:n] if by_rates else np.eye(n)
    z = np.array(evaluate(list(eom.z), at), dtype=float)[:n] if by_rates else np.zeros(n)
    a = np.asarray(evaluate(held.a, at), dtype=float).reshape(m, n)
    b = np.array(evaluate(list(held.b), at), dtype=float) if m else np.zeros(0)
    names = [s.name for s in (eom.coordinates if by_rates else eom.speeds)]
    rows, rest = a @ y, a @ z + b
    x = start.values.copy()
    size = np.abs(rows).max(axis=1, initial=0)
    # a row that vanishes here but for rounding holds nothing
    scale = np.maximum(size, max(_ROUNDING * size.max(initial=0), np.finfo(float).tiny))
    free = list(start.free)
    if free:
        block = rows[:, free] / scale[:, None]
        unknown, count = _undetermined(block, start, names)
        if unknown:
            raise ValueMissingError(
                f"Expected a start value for all {'rates' if by_rates else 'speeds'} that the constraints do not give, got too few: "
                f"{', '.join(unknown)} are not determined. Give {count} of them."
            )
        if m:
            x[free] += least_squares(block, -(rows @ x + rest) / scale)
    left = np.abs((rows @ x + rest) / scale)
    limit = GIVEN * max(1.0, np.abs(x).max(initial=0))
    bad = misses([c.name for c in held.constraints], rows @ x + rest, left, limit)
    if bad:
        raise SimulationError(
            f"Expected start {'rates' if by_rates else 'speeds'} that satisfy the constraints A u + b = 0, got values that miss "
            f"{bad}. Leave some out, or mark them with kn.guess(…), to have them solved for."
        )
    return y @ x + z, float(left.max(initial=0))
