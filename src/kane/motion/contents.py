# SPDX-License-Identifier: BSD-3-Clause
"""What a file keeps of a motion: its numbers, the names of what they are of, and what its system declares."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.expr.node import ZERO
from kane.motion.declared import declared
from kane.motion.drives import constant
from kane.motion.feedback import along
from kane.motion.files import Contents
from kane.numeric.arrays import Array

_KINDS = ("coordinates", "speeds", "states", "parameters", "inputs")
_STATUS = ("finished", "event", "stopped")
_TYPES = {
    **dict.fromkeys(("kane", "status", "message", "method"), str),
    **dict.fromkeys(("steps", "evaluations"), int),
    **dict.fromkeys(("events", "partitions", "numbers", "phases", "declared"), list),
}
"""What a header says, and as what."""


def contents(motion: Any) -> Contents:
    """Of a Solution."""
    eom: Equations = motion.equations
    kept = list(dict.fromkeys([eom, *(s.equations for s in motion.segments), *motion.samples]))
    place = {one: k for k, one in enumerate(kept)}
    known = declared(eom.system)
    header = {
        "kane": version("kane"),
        **names(eom),
        "status": motion.status,
        "message": motion.message,
        "event": None if motion.event is None else motion.event.name,
        "events": [[e.name, None if e.quantity is not ZERO else e.message] for e, _ in motion.events],
        "steps": int(motion.steps),
        "evaluations": int(motion.evaluations),
        "method": motion.method,
        "partitions": [_partition(one) for one in kept],
        "numbers": [[constant(p.inputs[s]) for s in motion.inputs] for p in motion.phases],
        "phases": [[e.name for e in p.by] for p in motion.phases],
        "declared": known.things,
    }
    columns = [_column(motion, s) for s in motion.inputs]
    arrays = {
        "t": motion.t,
        "states": motion.states,
        "work": motion.work,
        "parameters": np.array([float(motion.parameters[p]) for p in eom.parameters]),
        "inputs": np.array(columns, dtype=float).reshape(len(columns), len(motion.t)),
        "tolerances": np.array([motion.rtol, motion.atol]),
        "event_times": np.array([t for _, t in motion.events], dtype=float),
        "segment_starts": np.array([s.start for s in motion.segments], dtype=float),
        "segments": np.array([place[s.equations] for s in motion.segments], dtype=np.int64),
        "samples": np.array([place[one] for one in motion.samples], dtype=np.int64),
        "phase": motion.phase,
        "phase_parameters": np.array(
            [[float(p.parameters[s]) for s in eom.parameters] for p in motion.phases], dtype=float
        ).reshape(len(motion.phases), len(eom.parameters)),
        "declared": known.numbers,
    }
    return Contents(header, arrays)


def check(found: Contents, eom: Equations) -> None:
    """A ValueError names what a file of these equations cannot hold: a wrong type or shape, NaN, times that fall."""
    header, arrays = found
    for name, kind in _TYPES.items():
        if type(header[name]) is not kind:
            raise ValueError(f"{name} should be {kind.__name__}, got {type(header[name]).__name__}")
    if header["status"] not in _STATUS:
        raise ValueError(f"the status should be one of {', '.join(_STATUS)}, got {header['status']!r}")
    n, starts, samples = (arrays[name].size for name in ("t", "segment_starts", "samples"))
    own, phases, kept = len(eom.parameters), len(header["phases"]), len(header["partitions"])
    shapes = {
        "t": (max(n, 1),),
        "states": (n, len(eom.state)),
        "work": (n,),
        "parameters": (own,),
        "inputs": (len(eom.inputs), n),
        "tolerances": (2,),
        "event_times": (len(header["events"]),),
        "segment_starts": (starts,),
        "phase_parameters": (phases, own),
    }
    for name, shape in shapes.items():
        _check_array(name, arrays[name], shape, "f")
        if not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} should be finite numbers, got NaN or infinity")
    for name, length, count in (("segments", starts, kept), ("samples", samples and n, kept), ("phase", n, phases)):
        _check_array(name, arrays[name], (length,), "i")
        if np.any((arrays[name] < 0) | (arrays[name] >= count)):
            raise ValueError(f"{name} should be counted from 0 to {count - 1}, got others")
    steps, leaps = np.diff(arrays["t"]), np.diff(arrays["phase"])
    if np.any((leaps < 0) | (steps < 0) | ((steps == 0) & (leaps == 0))):
        raise ValueError("times should rise, and come twice only where a phase begins, got others")


def _check_array(name: str, array: Any, shape: tuple[int, ...], kind: str) -> None:
    if array.shape != shape or array.dtype.kind != kind:
        raise ValueError(
            f"{name} should be of shape {shape} and kind {kind!r}, got {array.shape} and {array.dtype.kind!r}"
        )


def _column(motion: Any, symbol: Any) -> Array:
    """The values of an input at the samples."""
    found = np.empty(len(motion.t))
    for number, phase in enumerate(motion.phases):
        at = motion.phase == number
        found[at] = along(phase.inputs[symbol], motion.t[at], motion.states[at])
    return found


def names(eom: Equations) -> Mapping[str, Sequence[str]]:
    """The names by which a file knows a system at once."""
    return {kind: [s.name for s in getattr(eom, kind)] for kind in _KINDS}


def _partition(eom: Equations) -> list[list[int]] | None:
    """Rows, dependent speeds and redundant rows."""
    if eom.embedding is None:
        return None
    p = eom.embedding.partition
    return [[int(k) for k in part] for part in (p.rows, p.dependent, p.redundant)]
