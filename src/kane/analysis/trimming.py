# SPDX-License-Identifier: BSD-3-Clause
"""`trim` and `equilibrium`: steady motions and equilibria, by Newton's method with exact derivatives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.conditions import Conditions, Measured, conditions
from kane.analysis.differentiable import warn_of_jumps
from kane.analysis.linearization import choice_of
from kane.analysis.magnitudes import share
from kane.analysis.point import OperatingPoint, closed, point_of
from kane.analysis.state import check_equations, entries, open_shares
from kane.analysis.tangents import perturbations
from kane.dynamics.constraints.branches import branches, told, turned_function
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.errors import SimulationError, ValueMissingError
from kane.expr.node import Expr
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array
from kane.numeric.named import named_values
from kane.numeric.newton import Closed, closest, starts
from kane.numeric.rank import level, singular
from kane.numeric.scale import ROUNDED_CHAIN, STATE_RANK, TAKES_PART
from kane.program.native.machine import Settings
from kane.progress import working

_TRIES, _SEED = 12, 20049
KINDS = {"q": "coordinates", "u": "speeds", "states": "states", "inputs": "inputs", "parameters": "parameters"}
"""Groups of values by the arguments that give them, in the order of X."""


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Conditions, a start X, and which entries of X may move; `missing` are those that were left out.

    `measured` are the conditions over their sizes at the start.
    """

    conditions: Conditions
    start: Array
    free: tuple[int, ...]
    missing: tuple[int, ...]
    measured: Measured

    @property
    def mattering(self) -> tuple[int, ...]:
        """Entries of X on which something depends."""
        conditions = self.conditions
        perturbed, eom = conditions.perturbed, conditions.eom
        nq, n = len(eom.coordinates), len(eom.speeds)
        plain = len(perturbed.coordinates)
        own = [perturbed.coordinates[i] for i in conditions.constant if i < plain]
        steady = (*conditions.steady, *(n + i for i in conditions.further))
        return (*own, *(nq + i for i in steady), *range(len(eom.state), len(self.start)))


def problem(
    numeric: Numeric[Equations], groups: Mapping[str, Any], t: float, moving: Sequence[Any], independent: Sequence[Any]
) -> Problem:
    """What is to be solved, from what the `groups` of `KINDS` give, guess and leave out."""
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    defaults = {p: p.default for p in eom.parameters if p.default is not None}
    complete = {**groups, "parameters": defaults | named_values("parameters", eom.parameters, groups["parameters"])}
    parts = [entries(what, getattr(eom, what), complete[kind], "value") for kind, what in KINDS.items()]
    for what, part in zip(KINDS.values(), parts, strict=True):
        if part.missing and what in ("inputs", "parameters"):
            raise ValueMissingError(
                f"Expected a value for every one of the {what}, got none for {getattr(eom, what)[part.missing[0]].name}: give a "
                "number to keep, or kn.guess(value) to have it solved for."
            )
    x = np.concatenate([part.values for part in parts])
    first = np.cumsum([0, *(len(part.values) for part in parts)]).tolist()
    for i in parts[2].missing:
        x[first[2] + i] = eom.states[i].default or 0.0
    free = [k + i for k, part in zip(first, parts, strict=False) for i in part.free]
    missing = [k + i for k, part in zip(first, parts, strict=False) for i in part.missing]
    for places in perturbed.sets:
        e = x[list(places)]
        if not e.any():
            x[places[0]] = 1.0
    names = [m.name if isinstance(m, Symbol) else m for m in moving]
    unknown = [n for n in names if n not in perturbed.names and n not in {s.name for s in (*eom.speeds, *eom.states)}]
    if unknown:
        raise ValueMissingError(
            f"Expected moving= to name coordinates, speeds or states, got {', '.join(map(str, unknown))}."
        )
    held = conditions(numeric, float(t), x, choice_of(numeric, independent), names)
    return Problem(held, x, tuple(free), tuple(missing), Measured(held, *held.sizes(x)[1:]))


def trim(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[Any] | None = None,
    u: Mapping[Any, Any] | Sequence[Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
    moving: Sequence[Any] = (),
    independent: Sequence[Any] = (),
    tolerance: float = 1e-9,
    settings: Settings | None = None,
    states: Mapping[Any, Any] | Sequence[Any] | None = None,
) -> OperatingPoint:
    """A steady motion or an equilibrium: u̇ = 0 of the independent speeds, q̇ = 0 of the coordinates that matter, all constraints.

    Values that are given are kept, guesses (`kn.guess(value)`) may move, coordinates and speeds left out are solved for, from zero,
    further states from their defaults; these rest too, ȧ = 0, where the speeds depend on them.
    Coordinates on which no speed depends may move steadily: a heading, a wheel's angle, a place on the road.

    Parameters
    ----------
    eom : Equations
    q, u, states, parameters, inputs : values and guesses by symbol or name; parameters left out take their defaults
    moving : more coordinates, speeds and states that may change
    independent : speeds to be independent, where those of the equations are not constant in a steady motion
    tolerance : what may remain of rates, accelerations and constraints, as a share of the terms that cancel in them
    settings : how to compile

    Raises
    ------
    SimulationError
        if no such motion is found; says which acceleration remains, and how much of it
    ValueMissingError
        if the conditions do not determine what is left out
    """
    check_equations(eom)
    with working("Trimming"):
        numeric = eom.numeric(settings)
        groups = {"q": q, "u": u, "states": states, "inputs": inputs, "parameters": parameters}
        task = problem(numeric, groups, t, moving, independent)
        x = solve_problem(task, tolerance)
        names = undetermined(task, x, task.missing)
        if names:
            raise ValueMissingError(
                f"Expected values that determine the steady motion, got too few: {', '.join(names)} can still take other values. Give "
                "some of them, or a guess for each: kn.guess(value)."
            )
        state = closed(numeric, task.conditions.state(x))
        warn_of_jumps(numeric, state, tolerance)
        return point_of(eom, state)


def equilibrium(
    eom: Equations,
    *,
    q: Mapping[Any, Any] | Sequence[Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float = 0.0,
    tolerance: float = 1e-9,
    settings: Settings | None = None,
    states: Mapping[Any, Any] | Sequence[Any] | None = None,
) -> OperatingPoint:
    """A state of rest: as `trim` with all speeds zero."""
    check_equations(eom)
    rest = dict.fromkeys(eom.speeds, 0.0)
    return trim(
        eom,
        q=q,
        u=rest,
        parameters=parameters,
        inputs=inputs,
        t=t,
        tolerance=tolerance,
        settings=settings,
        states=states,
    )


def solve_problem(task: Problem, tolerance: float) -> Array:
    """X by Gauss–Newton from the start; where something was left out and that fails, from other starts for it.

    A SimulationError says what remains where there is none.
    """
    measured, turned = task.measured, _astray(task.conditions)
    spreads = [0.2 * k for k in range(1, _TRIES)] if task.missing else []
    tries = starts(task.start / measured.columns, task.missing, _SEED, spreads)

    def astray(y: Array) -> Array:
        x = y * measured.columns
        return np.append(turned(x), _shares(task.conditions, x).max(initial=0) > tolerance)

    best = closest(measured, tries, task.free, np.inf, limit=1e-14, astray=astray)
    x = _plain(task, best) * measured.columns
    left = _shares(task.conditions, x)
    if not left.max(initial=0) <= tolerance:
        raise SimulationError(_failed(task, task.conditions(x)[0], left, best.steps))
    away = told(branches(task.conditions.eom.system), turned(x))
    if away:
        raise SimulationError(
            f"Expected a steady motion on the branch that the closures mean, got {away}. Guess coordinates on that branch: "
            "kn.assemble finds them."
        )
    return x


def _shares(conditions: Conditions, x: Array) -> Array:
    """What is left of each condition, over the size of its terms."""
    f, held = conditions(x)[0], len(conditions.eom.system.holonomic)
    sizes = conditions.sizes(x).terms
    shares = share(f, sizes)
    shares[:held] = open_shares(conditions.eom, f[:held], sizes[:held], conditions.state(x).given(conditions.eom))
    return shares


def _plain(task: Problem, best: Closed) -> Array:
    """Y with what is zero but for rounding made zero: where nothing else has a size, no number is small."""
    free = np.array(task.free, dtype=int)
    tiny = free[np.abs(best.x[free]) <= ROUNDED_CHAIN]
    if not best.x[tiny].any():
        return best.x
    y = best.x.copy()
    y[tiny] = 0.0
    left = np.abs(task.measured(y)[0]).max(initial=0)
    return y if left <= max(best.size, ROUNDED_CHAIN) else best.x


def _astray(conditions: Conditions) -> Callable[[Array], Array]:
    """By what angles closures are turned at X."""
    eom = conditions.eom
    system, nq, width = eom.system, len(eom.coordinates), len(eom.state)
    rest = [*eom.inputs, *eom.parameters, time]

    def angles(x: Array) -> Array:
        values: dict[Expr, Any] = dict(zip(rest, [*x[width:].tolist(), conditions.t], strict=True))
        return turned_function(system, values)(x[:nq])

    return angles


def _failed(task: Problem, residual: Array, shares: Array, steps: int) -> str:
    labels = task.conditions.labels
    order = np.argsort(-shares, kind="stable")
    remains = [
        f"{labels[i][0]} = {residual[i]:.6g}{' ' + labels[i][1] if labels[i][1] else ''}"
        for i in order[:4]
        if shares[i] > 1e-3 * shares.max()
    ]
    solved = [task.conditions.symbols[i].name for i in task.free]
    return (
        f"Expected a steady motion with the values given, got none: after {steps} steps there remains {', '.join(remains)}. Solved "
        f"for were {', '.join(solved) or 'no values'}; guess nearer, or mark more values with kn.guess(…)."
    )


def null_space(task: Problem, x: Array) -> Array:
    """Directions of the free entries in which the conditions stay satisfied, one a row (k × free)."""
    _, j = task.measured(x / task.measured.columns)
    return singular(level(j[:, list(task.free)])).kernel(STATE_RANK)


def undetermined(task: Problem, x: Array, among: Sequence[int]) -> list[str]:
    """Entries of X among those given that matter and are not determined."""
    if not task.free:
        return []
    directions = np.abs(null_space(task, x)).max(axis=0, initial=0)
    matter = set(task.mattering) & set(among)
    return [
        task.conditions.symbols[i].name
        for i, d in zip(task.free, directions, strict=True)
        if d > TAKES_PART and i in matter
    ]
