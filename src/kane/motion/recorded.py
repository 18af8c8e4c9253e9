# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of a motion that was saved or pickled: their values at its samples."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import SimulationError
from kane.motion.drives import constant
from kane.motion.feedback import along
from kane.numeric.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """The values of an input at the samples of a motion: what a file or a pickle keeps of its function."""

    name: str
    t: Array
    values: Array

    def __call__(self, t: Any) -> Any:
        """The value at a sample's time."""
        k = np.searchsorted(self.t, t)
        if k < len(self.t) and self.t[k] == t:
            return self.values[k]
        raise SimulationError(
            f"Expected a time among the samples for the input {self.name} of a motion that was saved or pickled, got t = {t:.6g}: of "
            "its function the values there were kept. Simulate again with the function."
        )


def recorded(name: str, function: Callable[[Any], Any], t: Array, states: Array) -> Callable[[Any], Any]:
    """An input as it is kept: a number as such, of a function its values at samples."""
    return function if constant(function) is not None else Recorded(name, t, along(function, t, states))
