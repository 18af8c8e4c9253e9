# SPDX-License-Identifier: BSD-3-Clause
"""`assemble`: a start that satisfies the constraints, from values that are given, guessed, or left out to be solved for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, overload

import numpy as np

from kane.analysis.held import held_at
from kane.analysis.search import Found, Search
from kane.analysis.state import Entries, check_equations, entries, misses
from kane.dynamics.constraints.closure import closure
from kane.dynamics.readings.values import parameter_values
from kane.equations.equations import Equations
from kane.errors import Attributes, SimulationError, ValueMissingError
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Speed, time
from kane.numeric.arrays import Array
from kane.numeric.named import named_values
from kane.numeric.newton import Closed
from kane.numeric.projection import least_squares
from kane.numeric.rank import singular
from kane.numeric.scale import GIVEN, ROUNDED, ROUNDED_ROOT, STATE_RANK
from kane.progress import working

_BESIDE = "The coordinates, or lengths, are singular there: give other values, or other coordinates (another sequence of angles)."


@dataclass(frozen=True, slots=True, eq=False)
class Assembled(Attributes):
    """A state on the constraints: `q` and `u` by symbol, ready for `simulate(q=…, u=…)`, and the largest `residual`.

    `branch` says which of the branches found it is, and where the next one lies; "" where nothing was sought.
    """

    q: dict[Coordinate, float]
    u: dict[Speed, float]
    residual: float
    branch: str = ""

    def __repr__(self) -> str:
        values = ", ".join(f"{s} = {v:.6g}" for s, v in (*self.q.items(), *self.u.items()))
        return f"Assembled({values}; residual {self.residual:.1e}{self.branch and '; '}{self.branch})"


@overload
def assemble(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[float] | None = None,
    u: Mapping[Any, Any] | Sequence[float] | None = None,
    rates: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
    all_branches: Literal[False] = False,
) -> Assembled: ...


@overload
def assemble(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[float] | None = None,
    u: Mapping[Any, Any] | Sequence[float] | None = None,
    rates: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
    all_branches: Literal[True],
) -> tuple[Assembled, ...]: ...


def assemble(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[float] | None = None,
    u: Mapping[Any, Any] | Sequence[float] | None = None,
    rates: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
    all_branches: bool = False,
) -> Assembled | tuple[Assembled, ...]:
    """A state that satisfies all constraints: of the configurations that many starts lead to, the one nearest to the guesses.

    Values that are given are kept, guesses (`kn.guess(value)`) may move, what is left out is solved for: coordinates by
    Gauss–Newton steps, speeds by linear least squares. Distances are those of the guessed coordinates, or from zero where there
    is no guess: of angles in rad, as they stand, of lengths over how far they reach. Orientations that closures do not mean, where
    their equations hold too, are no configurations.

    Parameters
    ----------
    eom : Equations
    q : coordinates by symbol or name
    u : speeds by symbol or name; left out altogether, the system is at rest as far as the constraints let it
    rates : rates of coordinates by coordinate, in place of `u`
    inputs : values at `t` of the inputs (and of their derivatives) that constraints hold
    all_branches : return all that are found, nearest first; angles that differ by turns are one

    Raises
    ------
    ValueMissingError
        if the constraints do not determine what is left out
    SimulationError
        if no state satisfies the constraints with the values that are given; says which constraint resists, and by how much, or
        which closure is turned
    """
    check_equations(eom)
    constants: dict[Expr, Any] = {**parameter_values(eom.system, parameters), time: float(t)}
    constants.update(named_values("inputs", eom.inputs, inputs))
    if u is not None and rates is not None:
        raise SimulationError("Expected either u= or rates= to assemble with, got both.")
    wanted = _wanted_speeds(eom, u, rates)
    with working("Assembling"):
        found = _configurations(eom, entries("coordinates", eom.coordinates, q), constants, all_branches)
    made = []
    for configuration, branch in found if all_branches else found[:1]:
        at = dict(zip(eom.coordinates, configuration.x.tolist(), strict=True))
        speeds, left = _motion(eom, wanted, constants | dict(at.items()), rates is not None)
        by_speed = dict(zip(eom.speeds, speeds.tolist(), strict=True))
        made.append(Assembled(at, by_speed, max(configuration.size, left), branch))
    return tuple(made) if all_branches else made[0]


def _configurations(
    eom: Equations, start: Entries, constants: Mapping[Expr, Any], every: bool
) -> list[tuple[Closed, str]]:
    """Where the coordinates are, and which branch that is in words: the nearest, or all that are found."""
    constraints = closure(eom.system)
    names = [q.name for q in eom.coordinates]
    if not constraints.f:
        if start.missing:
            missing = ", ".join(names[i] for i in start.missing)
            raise ValueMissingError(f"Expected a start value for all coordinates, got none for {missing}.")
        return [(Closed(start.values, np.zeros(0), 0), "")]
    search = Search(eom.system, constraints, constants, start)
    if not start.free:
        return [(_given(search), "")]
    found = search.found(every)
    if not found.closed:
        raise SimulationError(_not_closed(search, found))
    # what is left out must follow from the constraints, what is given and the guesses
    asked = start.free if every else start.missing
    unknown, count = _undetermined(search.block(found.closed[0].x), start, names, asked)
    if unknown:
        cure = "" if every else ", or a guess for each: kn.guess(value)"
        raise ValueMissingError(
            f"Expected values that determine the configuration, got {count} too few: {', '.join(unknown)} can still move. Give "
            f"{count} of them{cure}."
        )
    return list(zip(found.closed, search.words(found), strict=True))


def _given(search: Search) -> Closed:
    """Coordinates that are given whole, moved by rounding only."""
    names, values = search.conditions.names, search.start.values
    if search.singular_at(values):
        raise SimulationError(
            f"Expected coordinates at which the constraints are finite, got {search.singular_at(values)}. {_BESIDE}"
        )
    whole = Search(
        search.system, search.conditions, search.values, replace(search.start, guessed=tuple(range(len(values))))
    )
    residual = search.one(values)[0]
    bad = misses(names, residual, whole.shares(residual))
    if bad:
        raise SimulationError(
            f"Expected start values that satisfy the constraints, got coordinates that miss {bad}. Leave some out, or mark them "
            "with kn.guess(…), to have them solved for."
        )
    closed = whole.closed(values)
    turned = search.told(closed.x)
    if turned:
        raise SimulationError(
            f"Expected coordinates on the branch that the closures mean, got {turned}, where their equations hold too. "
            f"{search.cure()}"
        )
    return closed


def _not_closed(search: Search, found: Found) -> str:
    """No configuration was found, or none on the branch that is meant."""
    start, names = search.start, [q.name for q in search.system.coordinates]
    if found.turned:
        return (
            f"Expected a configuration on the branch that the closures mean, got only others from {found.starts} starts, the nearest "
            f"{found.turned}. The parts do not reach the orientation that is meant with the values given: free more coordinates, or "
            "correct the frames and axes of the closure."
        )
    first, best = np.abs(search.one(start.values)[0]).max(), found.nearest
    undefined = search.singular_at(best.x)
    if undefined:
        return (
            f"Expected a configuration at which the constraints are finite, got {undefined} in the nearest. {_BESIDE}"
        )
    worst = int(np.argmax(np.abs(best.residual)))
    return (
        f"Expected a configuration that satisfies the constraints, got none from {found.starts} starts: the residual came "
        f"{f'from {first:.3g} ' if np.isfinite(first) else ''}to {best.size:.3g}, and {search.conditions.names[worst]!r} resists "
        f"most{'' if np.isfinite(first) else ', which is not finite at the guesses'}. The parts may not reach each other "
        f"with the values given and these lengths: free more coordinates than {', '.join(names[i] for i in start.free)}, or correct "
        "the lengths."
    )


def _undetermined(block: Array, start: Entries, names: Sequence[str], among: Sequence[int]) -> tuple[list[str], int]:
    """Which `among` what is free may still move where `block` holds the rest; and how many values are too few."""
    directions = singular(block).kernel(STATE_RANK)
    open_ = np.abs(directions).max(axis=0, initial=0) > ROUNDED_ROOT
    return [names[i] for i, x in zip(start.free, open_, strict=True) if x and i in among], len(directions)


def _wanted_speeds(eom: Equations, u: Any, rates: Any) -> Entries:
    if rates is not None:
        return entries("rates, by coordinate,", eom.coordinates, rates)
    if u is None:
        n = len(eom.speeds)
        return Entries(np.zeros(n), tuple(range(n)), ())
    return entries("speeds", eom.speeds, u)


def _motion(eom: Equations, start: Entries, at: Mapping[Expr, Any], by_rates: bool) -> tuple[Array, float]:
    """u with A u + b = 0; with rates u = Y q̇ + z."""
    held = held_at(eom, at, by_rates)
    rows, rest = held.rows, held.rest
    names = [s.name for s in (eom.coordinates if by_rates else eom.speeds)]
    # what a unit of each does: metres and radians per second compare by that
    pace = np.abs(rows).max(axis=0, initial=0)
    pace = np.where(pace > ROUNDED * pace.max(initial=0), pace, 1.0)
    rows, x = rows / pace, start.values * pace
    size = np.abs(rows).max(axis=1, initial=0)
    # a row that vanishes here but for rounding holds nothing
    scale = np.maximum(size, max(ROUNDED_ROOT * size.max(initial=0), np.finfo(float).tiny))
    free = list(start.free)
    if free:
        block = rows[:, free] / scale[:, None]
        unknown, count = _undetermined(block, start, names, start.missing)
        if unknown:
            raise ValueMissingError(
                f"Expected a start value for all {'rates' if by_rates else 'speeds'} that the constraints do not give, got too few: "
                f"{', '.join(unknown)} are not determined. Give {count} of them."
            )
        if len(rows):
            x[free] += least_squares(block, -(rows @ x + rest) / scale)
    left = np.abs((rows @ x + rest) / scale)
    limit = GIVEN * max(np.abs(x).max(initial=0), np.abs(rest / scale).max(initial=0))
    bad = misses(held.names, rows @ x + rest, left, limit)
    if bad:
        raise SimulationError(
            f"Expected start {'rates' if by_rates else 'speeds'} that satisfy the constraints A u + b = 0, got values that miss "
            f"{bad}. Leave some out, or mark them with kn.guess(…), to have them solved for."
        )
    return held.to_speeds @ (x / pace) + held.added, float(left.max(initial=0))
