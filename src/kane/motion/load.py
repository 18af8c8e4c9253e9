# SPDX-License-Identifier: BSD-3-Clause
"""Reading solutions from files, for given equations, whose system must be the one that was simulated."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from kane.dynamics.constraints.partition import Partition
from kane.equations.equations import Equations, derive, repartition
from kane.equations.mode_equations import equations_in
from kane.errors import ArgumentError, KaneError, SimulationError, SolutionFileError, cut
from kane.expr.node import ZERO, Expr
from kane.model.contacts import ContactMode
from kane.model.declarations import Event
from kane.model.system import System
from kane.motion.inputs.functions import Recorded, a_constant, constant
from kane.motion.simulate import repeating
from kane.motion.solution.files import Contents, Declared, check, declared, difference, names, phase_parameters, read
from kane.motion.solution.phases import Phase
from kane.motion.solution.solution import Solution, SolutionSegment
from kane.whole import path_of

_APART = 1.0
"""Multiple of the tolerances by which the end of the repeated motion may differ from that in the file."""


def load_solution(path: Any, system: Equations | System) -> Solution:
    """Read the solution that `sol.save(path)` wrote, a file .npz or .zarr.

    A file contains numbers alone; give the equations of the simulated system, or the system, which is then derived. Its
    declarations must agree with those at the time of saving: masses, loads, units and defaults of parameters. The parameters of
    the solution are those of the simulation. Inputs are known by their values at the samples.

    Raises
    ------
    SolutionFileError
        if the file is incomplete, damaged, modified, of a different version, or of a different system; the message names the
        difference
    ArgumentError
        if `path` is not a path, or `system` neither Equations nor a System
    """
    path = path_of(path, 'kn.load_solution("run.npz", eom)')
    if not isinstance(system, Equations | System):
        raise ArgumentError(
            f"Expected the Equations or the System of the motion in the file, got {cut(repr(system))}. A file contains only "
            "numbers: call kn.load_solution(path, eom)."
        )
    found = read(path)
    eom = system if isinstance(system, Equations) else derive(system)
    try:
        _check_system(path, found, eom)
        check(found, eom)
        solution = _solution(found, eom)
    except SolutionFileError:
        raise
    except (KaneError, KeyError, IndexError, AttributeError, ValueError, TypeError) as error:
        raise SolutionFileError(
            f"Expected a file with all parts of a solution, got {path}, where some are missing or do not fit together "
            f"({type(error).__name__}: {error}). Simulate again."
        ) from error
    return _repeated(solution)


def _repeated(solution: Solution) -> Solution:
    """The solution with a function that repeats its motion, if its inputs are constants and its phases begin by events alone."""
    first, *others = solution.phases
    known = all(constant(f) is not None for f in first.inputs.values()) and all(phase.by for phase in others)
    if not known:
        return solution
    given = dict.fromkeys(("first_step", "breakpoints", "settings", "max_step"))
    inputs = {s: constant(f) for s, f in first.inputs.items()}
    again = repeating(None, given | {"parameters": first.parameters, "inputs": inputs})
    return replace(solution, _again=partial(_with_stored_options, again))


def _with_stored_options(again: Callable[..., Any], solution: Solution, **more: Any) -> Any:
    """Repeats the motion; a SimulationError if it ends elsewhere, since a file does not store all options."""
    result = again(solution, **more)
    if "samples" not in more:
        return result
    off = np.abs(result.states[-1] - solution.states[-1])
    if result.t[-1] == solution.t[-1] and np.any(
        off > _APART * (solution.atol + solution.rtol * np.abs(solution.states).max(axis=0))
    ):
        worst = [s.name for s in solution.equations.state][int(np.argmax(off))]
        raise SimulationError(
            f"Expected the repeated motion to agree with the file, got one that ends with {worst} off by {off.max():.2g}: the "
            "motion in the file was simulated with max_step=, breakpoints= or settings= that a file does not contain. "
            "Simulate it here, or save more samples."
        )
    return replace(result, work=result.work + solution.work[0])


def _check_system(path: Path, found: Contents, eom: Equations) -> None:
    for kind, own in names(eom).items():
        kept = found.header[kind]
        if kept != own:
            raise SolutionFileError(
                f"Expected a file of these equations, with the {kind} {', '.join(own) or 'none'}, got {path} with "
                f"{', '.join(map(str, kept)) or 'none'}. It belongs to another system: load it with that system."
            )
    differs = difference(Declared(found.header["declared"], found.arrays["declared"]), declared(eom.system))
    if differs:
        raise SolutionFileError(
            f"Expected a file of this system, got {path}, whose system differs in {differs}. Load it with the system that was "
            "simulated, as it was then."
        )


def _solution(found: Contents, eom: Equations) -> Solution:
    header, arrays = found
    partitions = [None if p is None else Partition(*map(tuple, p)) for p in header["partitions"]]
    present = eom.embedding and eom.embedding.partition
    first = eom if partitions[0] in (None, present) else repartition(eom, partitions[0])
    modes = [tuple(map(ContactMode, own)) for own in header["modes"]]
    every = [first, *(equations_in(first, *pair) for pair in zip(modes[1:], partitions[1:], strict=True))]
    met = _met(every)
    starts, places = arrays["segment_starts"].tolist(), arrays["segments"].tolist()
    t = arrays["t"]
    rtol, atol = arrays["tolerances"].tolist()
    events = [
        _event(met, name) if told is None else Event(name, ZERO, terminal=False, message=told)
        for name, told in header["events"]
    ]
    return Solution(
        first,
        t,
        arrays["states"],
        arrays["work"],
        dict(zip(first.parameters, arrays["parameters"].tolist(), strict=True)),
        _inputs(found, first, 0),
        header["status"],
        header["message"],
        None if header["event"] is None else _event(met, header["event"]),
        tuple(zip(events, arrays["event_times"].tolist(), strict=True)),
        header["steps"],
        header["evaluations"],
        tuple(SolutionSegment(start, every[k]) for start, k in zip(starts, places, strict=True)),
        tuple(every[k] for k in arrays["samples"].tolist()),
        rtol=rtol,
        atol=atol,
        method=header["method"],
        phases=_phases(found, first, met),
        phase=arrays["phase"],
    )


def _met(every: Sequence[Equations]) -> dict[str, Event]:
    """The events of the equations by name; with contacts also the events at which rebounds end."""
    met = {e.name: e for one in every for e in one.events}
    if not every[0].system.contacts:
        return met
    from kane.motion.contact_runner import rests  # slow to import

    return {e.name: e for e in map(rests, met.values())} | met


def _phases(found: Contents, eom: Equations, met: Mapping[str, Event]) -> tuple[Phase, ...]:
    rows = zip(found.arrays["phase_parameters"].tolist(), found.header["phases"], strict=True)
    return tuple(
        Phase(
            dict(zip(phase_parameters(eom), values, strict=True)),
            _inputs(found, eom, k),
            tuple(_event(met, name) for name in by),
        )
        for k, (values, by) in enumerate(rows)
    )


def _inputs(found: Contents, eom: Equations, number: int) -> dict[Expr, Any]:
    """The inputs of a phase: constants, and functions by their values at the samples."""
    at = found.arrays["phase"] == number
    t, given = found.arrays["t"][at], found.header["numbers"][number]
    return {
        s: Recorded(s.name, t, values[at]) if value is None else a_constant(float(value))
        for s, values, value in zip(eom.inputs, found.arrays["inputs"], given, strict=True)
    }


def _event(met: Mapping[str, Event], name: str) -> Event:
    if name in met:
        return met[name]
    raise SolutionFileError(
        f"Expected equations with the event {name!r}, which the motion in the file met, got those with "
        f"{', '.join(map(repr, met)) or 'none'}. They belong to another system: load the file with the system that was simulated."
    )
