# SPDX-License-Identifier: BSD-3-Clause
"""How exact a motion is: what becomes of it at a tenth of its tolerances, or at half its steps; or by its variational equations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import ArgumentError, Attributes, SimulationError, none_of
from kane.motion.joining import Parts
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED

REPEATED, VARIATIONAL = "repeated", "variational"
"""How errors are estimated."""
_TENTH = 0.1
_SHARES = {"rk4": 16 / 15, "midpoint": 4 / 3}
"""The error, over what half the step changes, of methods of fixed steps."""


@dataclass(frozen=True, slots=True, eq=False)
class Accuracy(Attributes):
    """The errors of coordinates and speeds along a motion, as far as a second motion or variational equations show them.

    Attributes
    ----------
    t : times (n) of samples, of a second motion those that both have
    errors : absolute errors there (n × (coordinates + speeds)), in their units
    largest : the largest of each, by name
    relative : the largest error over the largest size of its own coordinate or speed
    worst : the name of that coordinate or speed
    at : when (s)
    """

    t: Array
    errors: Array
    largest: dict[str, float]
    relative: float
    worst: str
    at: float

    def __repr__(self) -> str:
        return f"Accuracy({self.relative:.1e} of {self.worst} at t = {self.at:.4g} s)"


def accuracy(motion: Any, again: Callable[..., Any] | None, method: str) -> Accuracy:
    """See Solution.accuracy."""
    if method not in (REPEATED, VARIATIONAL):
        raise ArgumentError(f"Expected method to be one of {none_of((REPEATED, VARIATIONAL), method)}")
    if again is None or isinstance(again, Parts):
        raise SimulationError(
            "Expected a motion that this process simulated as a whole, got one that was read from a file or a pickle, of whose inputs "
            "the values at the samples alone are known, or joined. Simulate it here, or ask each part."
        )
    if method == VARIATIONAL:
        return _told(motion, motion.t, np.abs(again(variational=True)))
    share = _SHARES.get(motion.method, 1.0)
    if share != 1.0:
        finer = again()
    elif motion.rtol * _TENTH < ROUNDED:
        raise SimulationError(
            f"Expected a motion with rtol of {ROUNDED / _TENTH:.0e} or more, got {motion.rtol:g}: at a tenth of it rounding is all "
            "that differs. Compare it with a motion by another method."
        )
    else:
        finer = again(rtol=motion.rtol * _TENTH, atol=motion.atol * _TENTH)
    # where a phase begins there are two values, and the other motion has its own such time
    _, _, there = np.intersect1d(np.setdiff1d(motion.t, motion.t[motion.begins]), finer.t, return_indices=True)
    here = np.searchsorted(motion.t, finer.t[there])
    return _told(motion, motion.t[here], share * np.abs(motion.states[here] - finer.states[there]))


def _told(motion: Any, t: Array, errors: Array) -> Accuracy:
    """What the errors at times of samples say."""
    sizes = np.abs(motion.states).max(axis=0)
    ratio = np.divide(errors, sizes, out=np.where(errors > 0, np.inf, 0.0), where=sizes > 0)
    k, i = (int(x) for x in np.unravel_index(int(np.argmax(ratio)), ratio.shape))
    names = [s.name for s in motion.equations.state]
    largest = dict(zip(names, errors.max(axis=0).tolist(), strict=True))
    return Accuracy(t, errors, largest, float(ratio[k, i]), names[i], float(t[k]))
