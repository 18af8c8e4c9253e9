# SPDX-License-Identifier: BSD-3-Clause
"""The phases of a motion: parts with values of their own for parameters and inputs, and what jumps where one begins."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.expr.node import Expr
from kane.model.declarations import Event
from kane.motion.drives import constant
from kane.motion.feedback import HeldInput
from kane.motion.formulas import Formula
from kane.numeric.arrays import Array

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """A part of a motion: the values of its parameters, its inputs, and the events whose actions began it."""

    parameters: Mapping[Expr, float]
    inputs: Mapping[Expr, Callable[[Any], Any]]
    by: tuple[Event, ...] = ()

    def same(self, other: "Phase") -> bool:
        """Whether another one, which comes after, has the same parameters and inputs."""
        return self.parameters == other.parameters and all(
            _same(f, other.inputs.get(s)) for s, f in self.inputs.items()
        )


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """Where a phase of a motion begins with other values than the last one ended with.

    Attributes
    ----------
    t : when (s)
    events : those whose actions it is
    changes : coordinates, speeds and parameters that changed, with their values before and after
    energy : what kinetic and potential energy changed by (J)
    """

    t: float
    events: tuple[Event, ...]
    changes: Mapping[Expr, tuple[float, float]]
    energy: float

    def __repr__(self) -> str:
        names = ", ".join(e.name for e in self.events) or "start="
        told = ", ".join(f"{s}: {a:.6g} → {b:.6g}" for s, (a, b) in self.changes.items())
        return f"Jump({names} at t = {self.t:.6g} s: {told or 'nothing'}; energy {self.energy:+.4g} J)"


def _same(f: Any, g: Any) -> bool:
    """Whether one input goes on as another one, which may know more of it by then."""
    if isinstance(f, Formula) and isinstance(g, Formula):
        return f.expr is g.expr and f.values == g.values
    if isinstance(f, HeldInput) and isinstance(g, HeldInput):
        count = len(f.group.times)
        same = f.group.controller is g.group.controller and f.place == g.place
        return same and g.group.times[:count] == f.group.times
    return f is g or (constant(f) is not None and g is not None and constant(f) == constant(g))


def breaks(phase: Indices) -> Indices:
    """The samples with which a phase begins, but for the first."""
    return np.flatnonzero(np.diff(phase)) + 1


def leaps(values: Array, begins: Indices) -> Array:
    """What values (n) have jumped by so far, at the samples with which phases begin."""
    steps = np.zeros_like(values)
    steps[begins] = values[begins] - values[begins - 1]
    return np.cumsum(steps)
