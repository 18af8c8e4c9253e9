# SPDX-License-Identifier: BSD-3-Clause
"""The loop over a solver's steps: project, look for events, sample."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kane.expr.node import Expr
from kane.model.events import Event
from kane.motion.crossings import crossings
from kane.motion.singular import nearly_singular
from kane.motion.solution import Segment, Solution
from kane.motion.steps import Motion
from kane.numeric.arrays import Array

SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
_ONE_STEP = ("RK23", "RK45", "DOP853", "Radau")
"""Solvers that remember nothing but y and f, so that a projected state can take the place of theirs."""
_DRIFT = 10.0
"""Change by projection, in tolerances, at which the other solvers are started anew; what they return is projected all the same."""

_AHEAD = 1e-3
"""Share of the time after which a motion that broke off is asked whether its constraints can be held there."""
_NARROW = 1e-12
"""Share of the time below which a step is not halved any more."""


def integrate(
    motion: Motion,
    span: tuple[float, float],
    start: Array,
    method: str,
    tolerances: Mapping[str, float],
    wanted: Array,
    max_steps: int,
    constants: dict[Expr, float],
    drives: dict[Expr, Callable[[Any], Any]],
) -> Solution:
    """Step from `start` over `span`."""
    t0, t1 = span
    values = motion.watch(t0, start)
    solver = _solver(method, motion, t0, start, t1, tolerances)
    grid, steps, evaluations = [t0], 0, 0
    rows = [motion.sample(t0, start)]
    status, message = "finished", f"reached t = {t1:g}"
    hit: Event | None = None
    met: list[tuple[Event, float]] = []
    beyond = np.inf
    while solver.status == "running":
        if steps >= max_steps:
            status, message = "stopped", f"{max_steps} steps were not enough; at t = {solver.t:.6g}"
            break
        before, last = solver.t, solver.y.copy()
        failure = _advance(solver)
        steps += 1
        if solver.status == "failed" or solver.t <= before or not np.all(np.isfinite(solver.y)):
            status = "stopped"
            locked = motion.held_up(before, last, before + _AHEAD * (t1 - t0))
            message = locked or (
                f"the right-hand side is singular or not finite near t = {before:.6g} ({failure or 'no progress'})"
                f"{nearly_singular(motion.eom, motion.values(before, last))}"
            )
            break
        dense, end = solver.dense_output(), solver.t
        kept, numbers = motion.keep(end, solver.y)
        if motion.jumped(numbers) and end - before > _NARROW * max(abs(end), t1 - t0):
            # the place is closed in on by halves, until a state lies so near to it that `settle` sees it
            evaluations += int(solver.nfev)
            solver, beyond = _solver(method, motion, before, last, t1, tolerances, (end - before) / 2), end
            continue
        # what is met is read off the states that are gone on from: projection cannot hide it, nor make it be met twice
        after = motion.watch(end, kept)
        for event, t in crossings(motion.eom.events, motion.watch, dense, (solver.t_old, end), (values, after)):
            met.append((event, t))
            if event.terminal:
                status, hit, end = "event", event, t
                message = f"{event.name} at t = {end:.6g}: {event.message or 'terminal event'}"
                break
        inside = wanted[(wanted > grid[-1]) & (wanted < end)]
        for t in [*inside, end] if status == "event" or solver.status == "finished" else inside:
            grid.append(float(t))
            rows.append(motion.sample(t, dense(t)))
        if status == "event" or solver.status == "finished":
            break
        values = after
        changed = motion.settle(end, numbers)
        if changed:
            values = motion.watch(end, kept)
        if changed or not np.array_equal(kept, solver.y):
            solver, spent = _continued(solver, kept, changed, method, motion, t1, tolerances)
            evaluations += spent
        beyond = beyond if end < beyond and not changed else np.inf
        if np.isfinite(beyond) and hasattr(solver, "h_abs"):
            solver.h_abs = min(solver.h_abs, (beyond - end) / 2)
    if status == "stopped" and solver.t > grid[-1] and np.all(np.isfinite(solver.y)):
        grid.append(float(solver.t))
        rows.append(motion.sample(solver.t, solver.y))
    states = np.array([y for y, _ in rows])
    return Solution(
        motion.first,
        np.array(grid),
        states[:, :-1],
        states[:, -1],
        constants,
        drives,
        status,
        message,
        hit,
        tuple(sorted([*met, *motion.changes], key=lambda pair: pair[1])),
        steps,
        evaluations + int(solver.nfev),
        tuple(Segment(t, eom) for t, eom in motion.segments),
        tuple(eom for _, eom in rows) if motion.segments else (),
        **tolerances,
    )


def _solver(
    method: str,
    motion: Motion,
    t: float,
    y: Array,
    t1: float,
    tolerances: Mapping[str, float],
    first_step: float | None = None,
) -> Any:
    from scipy import integrate as scipy_integrate

    return getattr(scipy_integrate, method)(motion.rate, t, y, t1, first_step=first_step, **tolerances)


def _advance(solver: Any) -> str | None:
    """One step; what went wrong, if anything."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            warnings.filterwarnings("ignore", message="lsoda", category=UserWarning)
            message: str | None = solver.step()
            return message
    except (ValueError, np.linalg.LinAlgError) as error:  # the implicit methods' linear algebra on NaN
        return str(error)


def _continued(
    solver: Any, y: Array, changed: bool, method: str, motion: Motion, t1: float, tolerances: Mapping[str, float]
) -> tuple[Any, int]:
    """The solver at the projected state, and the evaluations that a solver given up had spent."""
    if method in _ONE_STEP:
        solver.y = y
        solver.f = motion.rate(solver.t, y)
        return solver, 1
    slack = _DRIFT * (tolerances["atol"] + tolerances["rtol"] * np.abs(y))
    if not changed and np.all(np.abs(y - solver.y) <= slack):
        return solver, 0
    return _solver(method, motion, solver.t, y, t1, tolerances), int(solver.nfev)
