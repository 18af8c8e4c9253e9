# SPDX-License-Identifier: BSD-3-Clause
"""The conditions of steady motions as equations to follow: z = (u̇, λ, R) is unknown, too, so that none is solved for within."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kane.analysis.flow import share
from kane.analysis.local import coded, regular_rows, unknowns, values
from kane.analysis.many.following import SquareEquations, Unknowns
from kane.analysis.many.trimmed import SteadyEquations
from kane.analysis.perturbations import perturbations
from kane.analysis.steady_conditions import Applying, Conditions, Problem, shares
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import partials, unsolved
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.expr.build import sub
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle

_SURELY = 1e-3
"""Share of the tolerance below which it does not matter at which state sizes are those."""


def followed(task: Problem, first: Array, tolerance: float) -> SteadyEquations | None:
    """What is followed from the steady motion X; None where the conditions do not determine what is free."""
    conditions, free = replace(task.conditions, quick=True), list(task.free)
    numeric, eom, measured = conditions.numeric, conditions.eom, task.measured
    _, j = conditions(first)
    rows = sorted(choose(j[:, free] * measured.columns[free] / measured.rows[:, None]).rows) if free else []
    if len(rows) < len(free):
        return None
    _, z, slopes, _ = conditions.numbers(first)
    keep, terms = regular_rows(eom), conditions.sizes(task.start).terms
    routine = numeric.routine(steady_rows, conditions.applying, tuple(rows), tuple(free), keep).flat
    # X is (x, r, p), what routines take (x, p, r, z)
    x, r, p = (len(s) for s in (eom.state, eom.inputs, eom.parameters))
    places = [*range(x), *range(x + p, x + p + r), *range(x, x + p)]
    pushed = np.abs(slopes.residual[list(keep)] * measured.columns).max(axis=1, initial=0)
    unknowns = Unknowns(
        [*(places[i] for i in free), *(x + p + r + k for k in keep)],
        np.concatenate([measured.columns[free], np.ones(len(keep))]),
        np.concatenate([measured.rows[rows], np.where(pushed > 0, pushed, 1.0)]),
        len(free),
    )

    def left(xs: Array) -> Array:
        # far below the tolerance by the sizes at the first, which cost less than those there
        found = _quick_shares(conditions, xs, terms)
        for k in np.flatnonzero(~(found <= _SURELY * tolerance)).tolist():
            found[k] = shares(conditions, xs[k]).max(initial=0)
        return found

    return SteadyEquations(
        task.start, free, conditions.symbols, places, routine, unknowns, z[list(keep)], left, tolerance
    )


def steady_rows(
    eom: Equations, applying: Applying, rows: Sequence[int], free: Sequence[int], keep: Sequence[int]
) -> Bundle[SquareEquations]:
    """Some of F, and K z = k of the rows that are kept, with the derivatives in what is free of X, and in z."""
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
    """What is left of F at each X (k × …), by sizes of its terms that are known; infinity where K is singular at one of them."""
    eom, run = conditions.eom, coded(conditions.numeric)
    x, r, p = np.split(xs, np.cumsum([len(eom.state), len(eom.inputs)]), axis=1)
    own, keep, n = run(values)(conditions.t, x, p, r), list(regular_rows(eom)), len(eom.speeds)
    z = np.zeros(own.right.shape)
    try:
        z[:, keep] = np.linalg.solve(own.matrix[:, keep][:, :, keep], own.right[:, keep, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return np.full(len(xs), np.inf)
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
