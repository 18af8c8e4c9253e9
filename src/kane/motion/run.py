# SPDX-License-Identifier: BSD-3-Clause
"""`simulate`: integrate the compiled equations of motion with SciPy's solvers."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.analysis.assemble import assemble
from kane.analysis.start import check_masses, check_span, check_tolerance, start_state
from kane.dynamics.readings.values import parameter_values
from kane.equations.equations import Equations
from kane.errors import KaneWarning, SimulationError
from kane.motion.drives import check_prescribed, input_functions
from kane.motion.singular import check_regular
from kane.motion.solution import Solution
from kane.motion.stepping import SOLVERS, integrate
from kane.motion.steps import Motion
from kane.numeric.arrays import Array


def simulate(
    eom: Equations,
    span: tuple[float, float],
    *,
    q: Mapping[Any, float] | Sequence[float] | Array,
    u: Mapping[Any, float] | Sequence[float] | Array | None = None,
    rates: Mapping[Any, float] | Sequence[float] | Array | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float | None = None,
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
    t : the time of the start values, if they come with one (`**point.arguments`): the span must begin there
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
    if t is not None and not np.isclose(t, t0, rtol=1e-12, atol=1e-12):
        raise SimulationError(
            f"Expected a span that begins at the time of the start values, t = {t:.9g}, got one from {t0:.9g}. Begin it there, or "
            "take start values that hold at its beginning."
        )
    tolerances = {"rtol": check_tolerance("rtol", rtol), "atol": check_tolerance("atol", atol)}
    if method not in SOLVERS:
        raise SimulationError(f"Expected method to be one of {', '.join(SOLVERS)}, got {method!r}.")
    constants = parameter_values(eom.system, parameters)
    check_masses(eom, constants)
    drives = input_functions(eom, inputs, (t0, t1))
    check_prescribed(eom, constants, (t0, t1))
    fixed = np.array([constants[p] for p in eom.parameters])
    forces = list(drives.values())
    if (u is None) == (rates is None):
        raise SimulationError(f"Expected either u= or rates= at the start, got {'neither' if u is None else 'both'}.")
    motion = Motion(eom, fixed, forces)
    begin = {"parameters": parameters, "inputs": {s: f(t0) for s, f in drives.items()}}
    start = np.append(_start(eom, q, u, rates, begin, t0), 0.0)
    check_regular(eom, motion.values(t0, start), t0)
    start, numbers = motion.keep(t0, start)
    motion.settle(t0, numbers)
    watched = motion.watch(t0, start)
    _check_events(eom, watched, t0)
    _check_start(motion, t0, start)
    _warn_of_events(eom, watched)
    return integrate(
        motion, (t0, t1), start, method, tolerances, _sample_times(samples, t0, t1), max_steps, constants, drives
    )


def _start(eom: Equations, q: Any, u: Any, rates: Any, given: dict[str, Any], t0: float) -> Array:
    """(q, u), what is left out solved for where there are constraints; u = Y q̇ + z of rates."""
    if eom.constraints.constraints or rates is not None:
        found = assemble(eom, q=q, u=u, rates=rates, **given, t=t0)
        q, u = found.q, found.u
    return start_state(eom, q, u)


def _check_start(motion: Motion, t0: float, start: Array) -> None:
    first = motion.rate(t0, start)
    bad = [n for n, v in zip(motion.handle.labels[:-1], first, strict=False) if not np.isfinite(v)]
    if bad:
        raise SimulationError(
            f"Expected finite rates at the start, got none for {', '.join(bad)} at t = {t0:g}: the equations are singular at "
            f"this state ({motion.explain(t0, start)}). Start elsewhere, or choose coordinates and speeds that are regular here."
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
