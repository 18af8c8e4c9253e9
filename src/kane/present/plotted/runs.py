# SPDX-License-Identifier: BSD-3-Clause
"""What `plot` draws of: one or several motions by their names, and passages of a section; and a motion with more samples between."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from kane.equations.equations import Equations
from kane.errors import ArgumentError, SimulationError, cut
from kane.motion.cycles.section import SectionPoints
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array

R = TypeVar("R")

_MOST = 4000
"""Samples that are drawn of a motion at most, where it has not more of its own."""
_BEND = 0.003
"""Share of a panel by which a sample may lie beside the line through its neighbours: at half the distance a corner is not seen."""
_FEW = 9
"""Samples of which no more can be said than that they are few."""
_ROUNDS = 2
"""Few samples do not tell how much they miss: it is asked once more."""


@dataclass(frozen=True, slots=True)
class PlottedRun:
    """One motion, or passages of a section, with what the legend calls it ("" where it is the only one)."""

    name: str
    motion: Solution | SectionPoints
    dotted: bool = False

    @property
    def equations(self) -> Equations:
        """Those of the motion."""
        return self.motion.equations

    @property
    def t(self) -> Array:
        """Times of what is drawn."""
        return self.motion.t

    @property
    def line(self) -> str:
        """matplotlib's style of its lines: passages have none."""
        return "none" if isinstance(self.motion, SectionPoints) else "-"


def runs_of(solution: Any) -> list[PlottedRun]:
    """Motions one by one: of one, of a list, of a mapping from labels.

    Raises
    ------
    ArgumentError
        if it is none, or there is none in it
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
    """The run with samples enough that none of the curves of what is read has corners to be seen, and what is read of it."""
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
    """Into how many pieces each step between samples is to be cut, so that none of the curves has corners to be seen."""
    if run.dotted or len(run.t) < 2 or not curves:
        return 1
    own = run.motion.phase if isinstance(run.motion, Solution) else np.zeros(len(run.t), dtype=np.int64)
    worst = max((bend(run.t, own, curve) for curve in curves), default=0.0)
    least = 8 if len(run.t) < _FEW else 1
    wanted = max(least, int(np.ceil(np.sqrt(worst / _BEND))))
    return max(1, min(wanted, 64, _MOST // len(run.t)))


def bend(t: Array, phase: Indices, values: Array) -> float:
    """The furthest that a sample lies beside the line through its neighbours of the same phase, as a share of all values' range."""
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
    """The motion with `parts` − 1 more samples in each step, read off the integrator's polynomials.

    Where these are not at hand, as of a motion from a file, its samples are drawn as dots on the line, to be seen as such.
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
