# SPDX-License-Identifier: BSD-3-Clause
"""The motions that `plot` draws, with their names, section points, and motions with added samples."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from kane.errors import ArgumentError, SimulationError, cut
from kane.motion.cycles.section import SectionPoints
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array

R = TypeVar("R")

_MOST = 4000
"""Largest number of samples drawn, unless the motion itself has more."""
_BEND = 0.003
"""Largest deviation of a sample from the line through its neighbours, as a fraction of a panel; half of it shows no corner."""
_FEW = 9
"""Number of samples below which the deviation cannot be estimated."""
_ROUNDS = 2
"""Number of refinements, as the first estimate from few samples is inaccurate."""


@dataclass(frozen=True, slots=True)
class PlottedRun:
    """A motion or section points, with its name in the legend ("" if it is the only one)."""

    name: str
    motion: Solution | SectionPoints
    dotted: bool = False

    @property
    def t(self) -> Array:
        """The times of the samples."""
        return self.motion.t

    @property
    def line(self) -> str:
        """The line style in matplotlib; section points have none."""
        return "none" if isinstance(self.motion, SectionPoints) else "-"


def runs_of(solution: Any) -> list[PlottedRun]:
    """The runs for one motion, a list, or a mapping from labels.

    Raises
    ------
    ArgumentError
        if an item is not a motion, or there is none
    """
    if isinstance(solution, Mapping):
        named = [(str(label), motion) for label, motion in solution.items()]
    elif isinstance(solution, Sequence) and not isinstance(solution, str):
        named = [(f"{k}", motion) for k, motion in enumerate(solution, 1)]
    else:
        named = [("", solution)]
    for label, motion in named:
        if not isinstance(motion, Solution | SectionPoints):
            where = f" for {label!r}" if label else ""
            raise ArgumentError(
                f"Expected a motion from kn.simulate to plot, passages from kn.poincare, or a list or mapping of these, got "
                f"{cut(repr(motion))}{where}."
            )
    if not named:
        raise ArgumentError(f"Expected at least one motion to plot, got {cut(repr(solution))}.")
    return [PlottedRun(label, motion, isinstance(motion, SectionPoints)) for label, motion in named]


def smooth(
    run: PlottedRun, read: Callable[[PlottedRun], R], curves: Callable[[R], Sequence[Array]]
) -> tuple[PlottedRun, R]:
    """The run with enough samples that curves show no corners, and the result of `read` for it; `curves` extracts them."""
    fine, found, parts = run, read(run), 1
    for _ in range(_ROUNDS):
        more = _pieces(fine, curves(found))
        if more == 1:
            break
        parts *= more
        fine = _finer(run, parts)
        found = read(fine)
    return fine, found


def _pieces(run: PlottedRun, curves: Sequence[Array]) -> int:
    """Number of pieces into which each step between samples is to be divided so that curves show no corners."""
    if run.dotted or len(run.t) < 2 or not curves:
        return 1
    own = run.motion.phase if isinstance(run.motion, Solution) else np.zeros(len(run.t), dtype=np.int64)
    worst = max((bend(run.t, own, curve) for curve in curves), default=0.0)
    least = 8 if len(run.t) < _FEW else 1
    wanted = max(least, int(np.ceil(np.sqrt(worst / _BEND))))
    return max(1, min(wanted, 64, _MOST // len(run.t)))


def bend(t: Array, phase: Indices, values: Array) -> float:
    """Largest distance of a sample from the line through its neighbours of the same phase, relative to the range of all values."""
    before, after = np.diff(t)[:-1], np.diff(t)[1:]
    inside = (
        (phase[2:] == phase[:-2]) & (before > 0) & (after > 0) & np.isfinite(values[2:] + values[1:-1] + values[:-2])
    )
    size = float(np.ptp(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
    if not size or not inside.any():
        return 0.0
    first, middle, last = (part[inside] for part in (values[:-2], values[1:-1], values[2:]))
    share = before[inside] / (before + after)[inside]
    return float(np.max(np.abs(middle - first - share * (last - first)))) / size


def _finer(run: PlottedRun, parts: int) -> PlottedRun:
    """The motion with `parts` − 1 added samples in each step, from dense output.

    Without dense output, as for a motion from a file, the samples are drawn as visible dots.
    """
    motion = run.motion
    assert isinstance(motion, Solution)
    steps = np.flatnonzero((np.diff(motion.phase) == 0) & (np.diff(motion.t) > 0))
    shares = np.arange(1, parts) / parts
    times = (motion.t[steps, None] + shares * np.diff(motion.t)[steps, None]).ravel()
    try:
        between = motion.at(times)
    except SimulationError:
        return replace(run, dotted=True)
    places = np.repeat(steps + 1, parts - 1)
    whole = np.insert(np.arange(len(motion)), places, len(motion) + np.arange(len(times)))
    equations = [s.samples or (s.equations,) * len(s) for s in (motion, between)]
    every = (*equations[0], *equations[1])

    def both(name: str) -> Array:
        rows: Array = np.concatenate([getattr(motion, name), getattr(between, name)])[whole]
        return rows

    merged = replace(
        motion,
        t=both("t"),
        states=both("states"),
        work=both("work"),
        phase=np.insert(motion.phase, places, motion.phase[places - 1]),
        samples=tuple(every[k] for k in whole),
    )
    return replace(run, motion=merged)
