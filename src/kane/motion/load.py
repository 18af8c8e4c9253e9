# SPDX-License-Identifier: BSD-3-Clause
"""Solutions out of files: of the equations given, by names and by the rates that they have along the motion."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from kane.dynamics.constraints.partition import Partition
from kane.equations.derive import derive, repartition
from kane.equations.equations import Equations
from kane.errors import ArgumentError, SimulationError, SolutionFileError, cut
from kane.expr.node import ZERO, Expr
from kane.model.declarations import Event
from kane.model.system import System
from kane.motion.contents import names, some
from kane.motion.drives import a_constant, constant
from kane.motion.files import Contents, read
from kane.motion.phases import Phase
from kane.motion.recorded import Recorded
from kane.motion.run import repeatable
from kane.motion.solution import Segment, Solution
from kane.numeric.arrays import Array

_SAME = 1e-6
"""Share of its largest by which a rate of the same system may differ."""
_APART = 1.0
"""Tolerances by which the end of a motion that is taken once more may differ."""
_MOVED, _TIMES = 1e-13, 100.0
"""By what share states are moved to see what rounding makes of rates, and how many times that is let pass."""


def load_solution(path: Any, system: Equations | System) -> Solution:
    """The solution that `sol.save(path)` wrote, a file .npz or .zarr.

    A file holds numbers; what they are of is said by the equations, or the system, which is derived. It is checked that both fit: by
    the names of coordinates, speeds, parameters and inputs, and by the rates along the motion, at the parameters that it was
    simulated with. Of inputs the values at the samples are kept.

    Raises
    ------
    SolutionFileError
        if the file is cut off or damaged, of another version, or of another system
    """
    if not isinstance(system, Equations | System):
        raise ArgumentError(
            f"Expected the Equations or the System that the file is of, got {cut(repr(system))}. A file holds numbers alone: "
            "kn.load_solution(path, eom)."
        )
    found = read(path)
    eom = system if isinstance(system, Equations) else derive(system)
    _check_names(path, found, eom)
    try:
        solution = _solution(found, eom)
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise SolutionFileError(
            f"Expected a file with all parts of a solution, got {path} without some ({type(error).__name__}: {error})."
        ) from error
    _check_rates(path, found, solution)
    return _repeated(solution)


def _repeated(solution: Solution) -> Solution:
    """It with what takes it once more, where numbers alone and the events of its equations say how it moves."""
    first, *others = solution.phases
    known = all(constant(f) is not None for f in first.inputs.values()) and all(phase.by for phase in others)
    if not known:
        return solution
    given = dict.fromkeys(("first_step", "breakpoints", "settings", "max_step"))
    inputs = {s: constant(f) for s, f in first.inputs.items()}
    again = repeatable(solution, None, given | {"parameters": first.parameters, "inputs": inputs})._again
    return solution if again is None else replace(solution, _again=partial(_as_kept, solution, again))


def _as_kept(solution: Solution, again: Callable[..., Any], **more: Any) -> Any:
    """The motion once more; the one in the file may have had options that are not kept there."""
    found = again(**more)
    if "samples" not in more:
        return found
    off = np.abs(found.states[-1] - solution.states[-1])
    if found.t[-1] == solution.t[-1] and np.any(
        off > _APART * (solution.atol + solution.rtol * np.abs(solution.states).max(axis=0))
    ):
        worst = [s.name for s in solution.equations.state][int(np.argmax(off))]
        raise SimulationError(
            f"Expected the motion of the file once more, got one that ends with {worst} off by {off.max():.2g}: it was simulated with "
            "a longest step, breakpoints or settings that a file does not keep. Simulate it here, or take more samples."
        )
    return replace(found, work=found.work + solution.work[0])


def _check_names(path: Any, found: Contents, eom: Equations) -> None:
    for kind, own in names(eom).items():
        kept = found.header.get(kind, [])
        if kept != own:
            raise SolutionFileError(
                f"Expected a file of these equations, with the {kind} {', '.join(own) or 'none'}, got {path} with "
                f"{', '.join(map(str, kept or ())) or 'none'}. It is of another system: load it with that one."
            )


def _solution(found: Contents, eom: Equations) -> Solution:
    header, arrays = found
    partitions = [None if p is None else Partition(*map(tuple, p)) for p in header["partitions"]]
    present = eom.embedding and eom.embedding.partition
    first = eom if partitions[0] in (None, present) else repartition(eom, partitions[0])
    every = [first, *(repartition(first, p) for p in partitions[1:] if p is not None)]
    starts, places = arrays["segment_starts"].tolist(), arrays["segments"].tolist()
    t = arrays["t"]
    rtol, atol = arrays["tolerances"].tolist()
    events = [
        _event(first, name, told) if told is None else Event(name, ZERO, terminal=False, message=told)
        for name, told in header["events"]
    ]
    return Solution(
        first,
        t,
        arrays["states"].reshape(len(t), len(first.state)),
        arrays["work"],
        dict(zip(first.parameters, arrays["parameters"].tolist(), strict=True)),
        _inputs(found, first, 0),
        header["status"],
        header["message"],
        None if header["event"] is None else _event(first, header["event"], None),
        tuple(zip(events, arrays["event_times"].tolist(), strict=True)),
        header["steps"],
        header["evaluations"],
        tuple(Segment(start, every[k]) for start, k in zip(starts, places, strict=True)),
        tuple(every[k] for k in arrays["samples"].tolist()),
        rtol=rtol,
        atol=atol,
        method=header["method"],
        phases=_phases(found, first),
        phase=arrays["phase"],
    )


def _phases(found: Contents, eom: Equations) -> tuple[Phase, ...]:
    rows = zip(found.arrays["phase_parameters"].tolist(), found.header["phases"], strict=True)
    return tuple(
        Phase(
            dict(zip(eom.parameters, values, strict=True)),
            _inputs(found, eom, k),
            tuple(_event(eom, name, None) for name in by),
        )
        for k, (values, by) in enumerate(rows)
    )


def _inputs(found: Contents, eom: Equations, number: int) -> dict[Expr, Any]:
    """The inputs of a phase: numbers as such, of functions the values at its samples."""
    at = found.arrays["phase"] == number
    t, given = found.arrays["t"][at], found.header["numbers"][number]
    return {
        s: Recorded(s.name, t, values[at]) if value is None else a_constant(float(value))
        for s, values, value in zip(eom.inputs, found.arrays["inputs"], given, strict=True)
    }


def _event(eom: Equations, name: str, told: str | None) -> Event:
    for event in eom.events:
        if event.name == name:
            return event
    raise SolutionFileError(
        f"Expected equations with the event {name!r}, which the motion in the file met, got those with "
        f"{', '.join(repr(e.name) for e in eom.events) or 'none'}. They are of another system: load the file with its own."
    )


def _check_rates(path: Any, found: Contents, solution: Solution) -> None:
    """The rates of the equations given are those that were kept, up to what rounding makes of them."""
    at = found.arrays["compared"]
    few, kept = some(solution, at), found.arrays["rates"]
    here = few.rates()
    limit = _SAME * np.nanmax(np.abs(kept), axis=0, initial=0.0)
    off = _off(here, kept, limit)
    if not off.any():
        return
    signs = np.where(np.arange(few.states.shape[1]) % 2, 1.0, -1.0)
    for moved in (signs, -signs, np.abs(signs)):
        near: Array = replace(few, states=few.states * (1 + _MOVED * moved)).rates()
        limit = np.maximum(limit, _TIMES * np.abs(np.nan_to_num(near - here)))
    off = _off(here, kept, limit)
    if off.any():
        k, i = (int(x) for x in np.argwhere(off)[0])
        eom = solution.equations
        name = [s.name for s in eom.state][i]
        raise SolutionFileError(
            f"Expected a file of these equations, got {path}, along whose motion {name}' is {kept[k, i]:.9g} at t = "
            f"{few.t[k]:.6g}; by these equations it is {here[k, i]:.9g}. It is of another system: load it with that one."
        )


def _off(here: Array, kept: Array, limit: Array) -> Any:
    """Where rates differ by more than the limit; what is infinite or NaN must be so in both."""
    both = np.isfinite(here) & np.isfinite(kept)
    with np.errstate(invalid="ignore"):
        apart = np.abs(here - kept) > limit
    return np.where(both, apart, np.isfinite(here) != np.isfinite(kept))
