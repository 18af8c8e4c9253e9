# SPDX-License-Identifier: BSD-3-Clause
"""What a file keeps of a motion: its numbers, the names of what they are of, and rates by which its equations are known again."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.expr.node import ZERO
from kane.motion.drives import constant
from kane.motion.feedback import along
from kane.motion.files import Contents
from kane.numeric.arrays import Array

_KINDS = ("coordinates", "speeds", "states", "parameters", "inputs")
COMPARED = 25
"""At as many samples, at most, a file keeps the rates."""


def contents(motion: Any, rates: Callable[[Array], Array]) -> Contents:
    """Of a Solution; `rates` gives (q̇, u̇) at some of its samples."""
    eom: Equations = motion.equations
    kept = list(dict.fromkeys([eom, *(s.equations for s in motion.segments), *motion.samples]))
    place = {one: k for k, one in enumerate(kept)}
    at = np.unique(np.linspace(0, len(motion.t) - 1, min(len(motion.t), COMPARED)).astype(int))
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
        "compared": at,
        "rates": rates(at),
    }
    return Contents(header, arrays)


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


def some(motion: Any, at: Array) -> Any:
    """The motion at some of its samples."""
    samples = tuple(motion.samples[k] for k in at) if motion.samples else ()
    return replace(
        motion, t=motion.t[at], states=motion.states[at], work=motion.work[at], samples=samples, phase=motion.phase[at]
    )
