# SPDX-License-Identifier: BSD-3-Clause
"""Functions of time that jump where no breakpoint is named: a step leads across, and its estimate need not see it."""

import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from kane.errors import KaneWarning
from kane.motion.drives import Asked
from kane.numeric.scale import NEAR_TIME

_PLACES = 1025
"""At so many times of a span a function is asked: what is shorter between two of them is not seen."""
_MOST = 4
_TORN = 1e-3
"""Share of its range by which a function changes within rounding of a time where it jumps."""


def warn_of_jumps(drives: Iterable[Any], span: tuple[float, float], breakpoints: Sequence[float]) -> None:
    """Warn of jumps of the user's functions of time, each function's first ones."""
    for f in drives:
        if isinstance(f, Asked):
            near = NEAR_TIME * (span[1] - span[0])
            told = [t for t in jumps(f, span) if not any(abs(t - b) <= near for b in breakpoints)]
            if told:
                listed = ", ".join(f"{t:.9g}" for t in told)
                warnings.warn(
                    f"Expected a function of time without jumps for the input {f.name}, got one that jumps at t = {listed}, where no "
                    f"step ends. Name the times, breakpoints=[{listed}], or give the input as a table, kn.table(t, y, 'steps').",
                    KaneWarning,
                    stacklevel=4,
                )


def jumps(f: Asked, span: tuple[float, float]) -> list[float]:
    """The times of the largest jumps, in order."""
    times = np.linspace(*span, _PLACES)
    values = np.array([f(float(t)) for t in times])
    reach = float(np.ptp(values)) if np.isfinite(values).all() else 0.0
    changes = np.diff(values)
    beside = np.pad(changes, 1, mode="edge")
    sudden = np.abs(changes - (beside[:-2] + beside[2:]) / 2)  # a slope changes as much beside
    found = []
    for k in np.argsort(sudden)[::-1][:_MOST] if reach else ():
        (a, b), (p, q) = times[k : k + 2].tolist(), values[k : k + 2].tolist()
        while True:
            middle = a + (b - a) / 2
            if not a < middle < b:
                break
            between = f(middle)
            if not abs(p - q) > _TORN * reach:
                break
            a, b, p, q = (a, middle, p, between) if abs(between - p) >= abs(q - between) else (middle, b, between, q)
        if abs(p - q) > _TORN * reach:
            found.append(b)
    return sorted(found)
