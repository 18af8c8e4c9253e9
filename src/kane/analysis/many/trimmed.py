# SPDX-License-Identifier: BSD-3-Clause
"""`trim` at many states: continuation of the steady motion of the first state along the arrays.

Which conditions apply is decided at the first state; steady motions have residuals within the tolerance. If the conditions do not
determine all unknowns, or there are switches, each state is solved alone. The followed equations have z = (u̇, λ, R) among
their unknowns, so that no linear system is solved within them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.flow import share
from kane.analysis.local import regular_rows, unknowns, values
from kane.analysis.many.following import SquareEquations, Unknowns, follow
from kane.analysis.many.poses import Poses
from kane.analysis.perturbations import perturbations
from kane.analysis.stacks import Entries, solve_each
from kane.analysis.steady_conditions import Applying, Conditions, SteadyProblem, shares
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import partials, unsolved
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.equations.state import GROUPS, Guess, State
from kane.errors import SingularError
from kane.expr.build import sub
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle
from kane.program.native.compiled_routine import CompiledRoutine

_TOLD = 4


class SteadyEquations(NamedTuple):
    """Conditions to follow from X at the start, with unknowns X[`free`]; `symbols` have the indices `places` in a row of data after t.

    `routine` has these unknowns and then z = (u̇, λ, R), which is `last` at the start. `left` returns the largest relative residual
    at each X (k × …), which must not exceed `tolerance`.
    """

    start: Array
    free: Sequence[int]
    symbols: Sequence[Symbol]
    places: Sequence[int]
    routine: CompiledRoutine
    unknowns: Unknowns
    last: Array
    left: Callable[[Array], Array]
    tolerance: float


def trimmed(poses: Poses, alone: Callable[[int], State], branch: Callable[[int, Array], SteadyEquations | None]) -> Any:
    """The steady motions as a Dataset; `alone` solves state k by itself, `branch` returns what to follow from its X, or None."""
    eom, causes = poses.eom, dict(poses.failed)
    first = poses.first(alone, causes)
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    x = np.full((poses.count, len(symbols)), np.nan)
    if first is not None:
        start, state = first
        x[start] = [state[s] for s in symbols]
        task = branch(start, x[start])
        if task is not None:
            _follow(poses, task, (x, start), causes)
    for k, one in poses.rest(alone, causes, set(np.flatnonzero(~np.isnan(x).any(axis=1)))):
        x[k] = [one[s] for s in symbols]
    x[list(causes)] = np.nan
    return _dataset(poses, symbols, x, causes)


def _follow(poses: Poses, task: SteadyEquations, places: tuple[Array, int], causes: dict[int, str]) -> None:
    """Fill X of all states (k × …) that are reached by continuation from the one at `start`."""
    (x, start), free = places, list(task.free)
    whole = np.tile(task.start, (poses.count, 1))
    for i, s in enumerate(task.symbols):
        for kind in GROUPS:
            if s in poses.instances.columns[kind]:
                whole[:, i] = poses.instances.columns[kind][s]
    order = [k for k in poses.open if k >= start]
    data = np.zeros((len(order), 1 + sum(len(port.symbols) for port in task.routine.program.ports[1:])))
    data[:, 0] = poses.given("t")[time]
    data[:, 1 + np.array(task.places)] = whole[order]
    found = follow(task.routine, data, np.concatenate([x[start, free], task.last]), task.unknowns)
    ended = np.array([row in found.ends for row in range(len(order))])
    for row, k in enumerate(order):
        end = found.ends.get(row)
        whole[k, free] = (found.x[row] if end is None else end.x)[: len(free)]
    there = np.array(order)[~ended]
    steady = dict(zip(there.tolist(), (task.left(whole[there]) <= task.tolerance).tolist(), strict=True))
    for row, k in enumerate(order):
        end = found.ends.get(row)
        if steady.get(k, False):
            x[k] = whole[k]
            continue
        at_end = ", ".join(f"{task.symbols[i].name} = {whole[k, i]:.6g}" for i in free[:_TOLD])
        way = f" on the way from instance {order[end.last]}" if end is not None else ""
        causes[k] = (
            f"Expected a steady motion on the branch of the other instances, got the end of this branch{way}, near {at_end}: there "
            "it meets another branch, or the equations are singular. Trim the states beyond it separately, from guesses."
        )


def _dataset(poses: Poses, symbols: Sequence[Symbol], x: Array, causes: dict[int, str]) -> Any:
    eom = poses.eom
    state = set(eom.state)
    given = {s: v for kind in ("inputs", "parameters") for s, v in poses.given(kind).items()}
    shown = [i for i, s in enumerate(symbols) if s in state or isinstance(given.get(s), Guess)]
    own = poses.variables([symbols[i] for i in shown], x[:, shown].T)
    return poses.dataset(own, causes, {})


_SURELY = 1e-3
"""Fraction of the tolerance below which residuals need not be measured by the sizes at their own state."""


def followed(task: SteadyProblem, first: Array, tolerance: float) -> SteadyEquations | None:
    """The equations to follow from the steady motion X, or None if the conditions do not determine the unknowns."""
    conditions = replace(task.conditions, quick=True)
    free, measured_alone = _linear_last(conditions, task.free)
    numeric, eom, measured = conditions.numeric, conditions.eom, task.measured
    _, j = conditions(first)
    rows = sorted(choose(j[:, free] * measured.columns[free] / measured.rows[:, None]).rows) if free else []
    if len(rows) < len(free):
        return None
    _, z, slopes, _ = conditions.numbers(first)
    keep, terms = regular_rows(eom), conditions.sizes(first).terms
    routine = numeric.routine(steady_rows, conditions.applying, tuple(rows), tuple(free), keep).flat
    # X is ordered (x, r, p), arguments of routines (x, p, r, z)
    x, r, p = (len(s) for s in (eom.state, eom.inputs, eom.parameters))
    places = [*range(x), *range(x + p, x + p + r), *range(x, x + p)]
    pushed = np.abs(slopes.residual[list(keep)] * measured.columns).max(axis=1, initial=0)
    unknowns = Unknowns(
        [*(places[i] for i in free), *(x + p + r + k for k in keep)],
        np.concatenate([measured.columns[free], np.ones(len(keep))]),
        np.concatenate([measured.rows[rows], np.where(pushed > 0, pushed, 1.0)]),
        measured_alone,
    )

    def left(xs: Array) -> Array:
        # sizes at the first state are cheaper, and suffice far below the tolerance
        result = _quick_shares(conditions, xs, terms)
        for k in np.flatnonzero(~(result <= _SURELY * tolerance)).tolist():
            try:
                result[k] = shares(conditions, xs[k]).max(initial=0)
            except SingularError:
                result[k] = np.inf
        return result

    return SteadyEquations(
        task.start, free, conditions.symbols, places, routine, unknowns, z[list(keep)], left, tolerance
    )


def _linear_last(conditions: Conditions, free: Sequence[int]) -> tuple[list[int], int]:
    """The unknowns in X, last the inputs in which K z − k is jointly linear with z, and the number of unknowns before these.

    Those inputs follow from the others as z does: their changes do not show whether a root is on the branch.
    """
    symbols, u = conditions.symbols, unsolved(conditions.eom.derived)
    inputs = set(conditions.eom.inputs)
    asked, together, linear = [i for i in free if symbols[i] in inputs], set(u.unknowns), list[int]()
    slopes = partials([*u.places, *u.residual], [symbols[i] for i in asked])
    for k, i in enumerate(asked):
        if {*together, symbols[i]}.isdisjoint(free_symbols([row[k] for row in slopes.rows])):
            together.add(symbols[i])
            linear.append(i)
    return [*(i for i in free if i not in set(linear)), *linear], len(free) - len(linear)


def steady_rows(
    eom: Equations, applying: Applying, rows: Sequence[int], free: Sequence[int], keep: Sequence[int]
) -> Bundle[SquareEquations]:
    """The bundle of some rows of F, and K z = k in some rows, with derivatives in the unknowns of X and in z."""
    u, perturbed = unsolved(eom.derived), perturbations(eom)
    e = [[eom.coordinates[i] for i in places] for places in perturbed.sets]
    moved = [*(u.rates[i] for i in perturbed.coordinates), *u.spins]
    z = [u.unknowns[i] for i in applying.steady]
    held = [*u.configuration, *(sub(dot(x, x), ONE) for x in e), *u.motion]
    every = [*held, *(moved[i] for i in applying.constant), *z, *(u.states[i] for i in applying.further)]
    f, residual = [every[i] for i in rows], [u.residual[k] for k in keep]
    symbols = (*eom.state, *eom.inputs, *eom.parameters)
    by_x = partials([*f, *residual], [symbols[i] for i in free])
    kept = [u.unknowns[k] for k in keep]
    by_z = [[ONE if f_i is unknown else ZERO for unknown in kept] for f_i in f]
    by_z += [[u.matrix[k][i] for i in keep] for k in keep]
    gradient = [[*one, *two] for one, two in zip(by_x, by_z, strict=True)]
    size = len(f) + len(keep)
    groups = {"f": [*f, *residual], "gradient": Matrix(gradient, (size, size))}
    return Bundle("steady_rows", (*ports(eom.derived), unknowns(eom)), SquareEquations, groups)


def _quick_shares(conditions: Conditions, xs: Array, terms: Array) -> Array:
    """The largest relative residual of F at each X (k × …), for known sizes of terms; NaN where K is singular."""
    numeric, eom = conditions.numeric, conditions.eom
    x, r, p = np.split(xs, np.cumsum([len(eom.state), len(eom.inputs)]), axis=1)
    routine, keep, n = numeric.routine(values), regular_rows(eom), len(eom.speeds)
    rows = routine.flat(conditions.t, x, p, r)
    matrix, right = routine.bundle.places("matrix"), routine.bundle.places("right")
    own, z = routine.bundle.split(rows), np.zeros((len(rows), len(right)))
    a, b = Entries(rows, matrix[np.ix_(keep, keep)]), Entries(rows, right[list(keep), None])
    z[:, keep] = solve_each(a, b, numeric.settings).x[:, :, 0]
    norms = [(x[:, list(places)] ** 2).sum(axis=1)[:, None] - 1.0 for places in conditions.perturbed.sets]
    moved = np.hstack([own.rates[:, list(conditions.perturbed.coordinates)], own.spins])
    applying = conditions.applying
    steady = (
        moved[:, list(applying.constant)],
        z[:, :n][:, list(applying.steady)],
        own.states[:, list(applying.further)],
    )
    f = np.hstack([own.configuration, *norms, own.motion, *steady])
    return np.asarray(share(f, terms).max(axis=1, initial=0))
