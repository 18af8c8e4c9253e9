# SPDX-License-Identifier: BSD-3-Clause
"""Where the numbers of a linearization come from: compiled code, or the graph as it is on one side of its switches."""

from dataclasses import dataclass
from typing import Protocol

from kane.analysis.local import Slopes, Values, slopes_at, values_at
from kane.analysis.outputs import Answers, Outputs, answers
from kane.analysis.state import State
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.numeric.arrays import Array


class Numbers(Protocol):
    """The unsolved equations at a state, their derivatives at given z, and outputs with theirs."""

    def values(self, state: State) -> Values:
        """K, k, and what a state must satisfy."""

    def slopes(self, state: State, z: Array) -> Slopes:
        """Derivatives in q, u and inputs."""

    def answers(self, state: State, z: Array, outputs: Outputs) -> Answers:
        """Outputs, and their derivatives in q, u, inputs and z."""


@dataclass(frozen=True, slots=True, eq=False)
class Coded:
    """Of compiled code."""

    numeric: Numeric[Equations]

    def values(self, state: State) -> Values:
        """See `Numbers`."""
        return values_at(self.numeric, state)

    def slopes(self, state: State, z: Array) -> Slopes:
        """See `Numbers`."""
        return slopes_at(self.numeric, state, z)

    def answers(self, state: State, z: Array, outputs: Outputs) -> Answers:
        """See `Numbers`."""
        return self.numeric.routine(answers, *outputs.roots)(state.t, state.x, state.p, state.r, z)
