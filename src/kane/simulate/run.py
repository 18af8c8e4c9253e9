# SPDX-License-Identifier: BSD-3-Clause
"""`simulate`: integrate the compiled equations of motion with SciPy's solvers."""

from __future__ import annotations

import warnings
import weakref
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.equations import Equations
from kane.dynamics.values import parameter_values, without_unknowns
from kane.errors import KaneWarning, SimulationError
from kane.expr.node import Expr
from kane.expr.symbols import time
from kane.model.events import Event
from kane.program.equations import expressions, rate_names
from kane.program.handle import Handle
from kane.program.machine import Settings
from kane.simulate.crossings import crossings
from kane.simulate.singular import check_regular, nearly_singular
from kane.simulate.solution import Solution
from kane.simulate.start import check_masses, check_span, check_tolerance, input_functions, start_state

Array = npt.NDArray[np.float64]
Rate = Callable[[float, Array], Array]

_SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


def simulate(
    eom: Equations,
    span: tuple[float, float],
    *,
    q: Mapping[Any, float] | Sequence[float] | Array,
    u: Mapping[Any, float] | Sequence[float] | Array | None = None,
    rates: Mapping[Any, float] | Sequence[float] | Array | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    method: str = "DOP853",
    rtol: float = 1e-9,
    atol: float = 1e-9,
    samples: int | Sequence[float] = 501,
    max_steps: int = 1_000_000,
) -> Solution:
    """The motion from `span[0]` to `span[1]` (s).

    The power of the loads without a potential is integrated with the state, so that `sol.energy_check` holds the integration to
    the energy. Terminal events of the system end the motion; where the right-hand side becomes infinite or NaN it stops, and
    the solution holds what there is.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
    q, u : start values by symbol or name, or in the order of `eom.coordinates` and `eom.speeds`
    rates : the rates of the coordinates at the start, by coordinate, in place of `u`
    parameters : values by symbol or name; those left out take their defaults
    inputs : a number or a function of time for each input
    method : one of SciPy's "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"
    rtol, atol : relative and absolute tolerance
    samples : how many evenly spaced times to return, or the times; the start and the end always come too

    Raises
    ------
    ValueMissingError
        if a start value, parameter or input is missing or unknown
    SimulationError
        if the start is not admissible, or the integration fails
    """
    t0, t1 = check_span(span)
    tolerances = {"rtol": check_tolerance("rtol", rtol), "atol": check_tolerance("atol", atol)}
    if method not in _SOLVERS:
        raise SimulationError(f"Expected method to be one of {', '.join(_SOLVERS)}, got {method!r}.")
    constants = parameter_values(eom, parameters)
    check_masses(eom, constants)
    drives = input_functions(eom, inputs)
    fixed = np.array([constants[p] for p in eom.parameters])
    forces = list(drives.values())
    width = len(eom.coordinates) + len(eom.speeds)

    def at(handle: Handle) -> Rate:
        if not forces:
            return lambda t, y: handle(t, y[:width], fixed)
        return lambda t, y: handle(t, y[:width], fixed, np.array([float(f(t)) for f in forces]))

    motion, events = _compiled(eom)
    rate = at(motion)
    if (u is None) == (rates is None):
        raise SimulationError(f"Expected either u= or rates= at the start, got {'neither' if u is None else 'both'}.")
    speeds = u if rates is None else eom.speeds_from_rates(q, rates, parameters=parameters, t=t0)
    start = np.append(start_state(eom, q, speeds), 0.0)
    check_regular(eom, _values(eom, constants, t0, start), t0)
    watch = at(events) if events else None
    watched = watch(t0, start) if watch else np.zeros(0)
    _check_events(eom, watched, t0)
    _check_start(motion, rate, t0, start, lambda: motion.explain(t0, start[:-1], fixed, [float(f(t0)) for f in forces]))
    _warn_of_events(eom, watched)
    return _integrate(eom, rate, watch, (t0, t1), start, method, tolerances, samples, max_steps, constants, drives)


_known: weakref.WeakKeyDictionary[Equations, tuple[Handle, Handle | None]] = weakref.WeakKeyDictionary()


def _compiled(eom: Equations) -> tuple[Handle, Handle | None]:
    """(q̇, u̇, P) and the events' quantities as machine code, made once for these equations."""
    if eom not in _known:
        motion = _routine(eom, "motion", [*eom.right_hand_side, eom.power], [*rate_names(eom), "P"])
        quantities, names = [e.quantity for e in eom.events], [e.name for e in eom.events]
        _known[eom] = motion, _routine(eom, "events", quantities, names) if quantities else None
    return _known[eom]


def _routine(eom: Equations, name: str, roots: Sequence[Expr], labels: Sequence[str]) -> Handle:
    return Handle(expressions(eom, name, without_unknowns(eom, roots), labels), name, Settings(), None, "ignore")


def _values(eom: Equations, constants: Mapping[Expr, float], t: float, state: Array) -> dict[Expr, float]:
    return {time: t, **constants, **dict(zip((*eom.coordinates, *eom.speeds), state, strict=False))}


def _check_start(motion: Handle, rate: Rate, t0: float, start: Array, why: Callable[[], str]) -> None:
    first = rate(t0, start)
    bad = [n for n, v in zip(motion.labels[:-1], first, strict=False) if not np.isfinite(v)]
    if bad:
        raise SimulationError(
            f"Expected finite rates at the start, got none for {', '.join(bad)} at t = {t0:g}: the equations are singular at "
            f"this state ({why()}). Start elsewhere, or choose coordinates and speeds that are regular here."
        )


def _integrate(
    eom: Equations,
    rate: Rate,
    watch: Rate | None,
    span: tuple[float, float],
    start: Array,
    method: str,
    tolerances: dict[str, float],
    samples: int | Sequence[float],
    max_steps: int,
    constants: dict[Expr, float],
    drives: dict[Expr, Callable[[Any], Any]],
) -> Solution:
    from scipy import integrate

    t0, t1 = span
    wanted = _sample_times(samples, t0, t1)
    values = watch(t0, start) if watch else np.zeros(0)
    solver = getattr(integrate, method)(rate, t0, start, t1, **tolerances)
    grid, rows, steps = [t0], [start], 0
    status, message = "finished", f"reached t = {t1:g}"
    hit: Event | None = None
    met: list[tuple[Event, float]] = []
    while solver.status == "running":
        if steps >= max_steps:
            status, message = "stopped", f"{max_steps} steps were not enough; at t = {solver.t:.6g}"
            break
        before, last, failure = solver.t, solver.y.copy(), None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                warnings.filterwarnings("ignore", message="lsoda", category=UserWarning)
                failure = solver.step()
        except (ValueError, np.linalg.LinAlgError) as error:  # the implicit methods' linear algebra on NaN
            failure = str(error)
        steps += 1
        if solver.status == "failed" or solver.t <= before or not np.all(np.isfinite(solver.y)):
            status = "stopped"
            message = (
                f"the right-hand side is singular or not finite near t = {before:.6g} ({failure or 'no progress'})"
                f"{nearly_singular(eom, _values(eom, constants, before, last))}"
            )
            break
        dense, end = solver.dense_output(), solver.t
        if watch:
            after = watch(end, solver.y)
            for event, t in crossings(eom.events, watch, dense, (solver.t_old, end), (values, after)):
                met.append((event, t))
                if event.terminal:
                    status, hit, end = "event", event, t
                    message = f"{event.name} at t = {end:.6g}: {event.message or 'terminal event'}"
                    break
            values = after
        inside = wanted[(wanted > grid[-1]) & (wanted < end)]
        for t in inside:
            grid.append(float(t))
            rows.append(dense(t))
        if status == "event" or solver.status == "finished":
            grid.append(float(end))
            rows.append(dense(end))
            break
    if status == "stopped" and solver.t > grid[-1] and np.all(np.isfinite(solver.y)):
        grid.append(float(solver.t))
        rows.append(solver.y)
    states = np.array(rows)
    return Solution(
        eom,
        np.array(grid),
        states[:, :-1],
        states[:, -1],
        constants,
        drives,
        status,
        message,
        hit,
        tuple(met),
        steps,
        int(solver.nfev),
    )


def _sample_times(samples: int | Sequence[float], t0: float, t1: float) -> Array:
    if isinstance(samples, int | np.integer):
        if samples < 2:
            raise SimulationError(f"Expected at least 2 samples, got {samples}.")
        return np.linspace(t0, t1, int(samples))
    try:
        times = np.asarray(samples, dtype=float)
    except (TypeError, ValueError) as error:
        raise SimulationError(f"Expected a number of samples or their times, got {samples!r:.60}.") from error
    if times.ndim != 1 or np.any(np.diff(times) <= 0) or (times.size and (times[0] < t0 or times[-1] > t1)):
        raise SimulationError(f"Expected increasing sample times within ({t0:g}, {t1:g}).")
    return times


def _check_events(eom: Equations, values: Array, t0: float) -> None:
    """The model must hold at the start; the user's own events may start on either side of their thresholds."""
    own = {e.name for e in eom.system.events}
    for event, value in zip(eom.events, values, strict=True):
        if event.direction < 0 and value <= event.threshold and event.name not in own:
            raise SimulationError(
                f"Expected a start before the event {event.name!r}, got {value:.6g} at t = {t0:g}, already at or below "
                f"{event.threshold:g}. {event.message}"
            )


def _warn_of_events(eom: Equations, values: Array) -> None:
    for event, value in zip(eom.events, values, strict=True):
        if not np.isfinite(value):
            warnings.warn(f"The event {event.name!r} is not finite at the start.", KaneWarning, stacklevel=3)
