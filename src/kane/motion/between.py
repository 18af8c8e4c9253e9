# SPDX-License-Identifier: BSD-3-Clause
"""A motion at other times than its samples: taken once more, and sampled there by the integrator's own polynomials.

A motion takes milliseconds, and its steps do not depend on the samples: so nothing is kept of the polynomials, which would be many
times the samples, and what is read between two of these is as exact as they are, on the constraints and phase by phase.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from kane.errors import SimulationError, cut
from kane.numeric.scale import NEAR_TIME


def between(motion: Any, again: Callable[..., Any] | None, times: Any) -> Any:
    """See Solution.at."""
    if again is None:
        raise SimulationError(
            "Expected a motion that this process simulated as a whole, got one that was read from a file or a pickle, of whose inputs "
            "the values at the samples alone are known, or joined. Simulate it here, or ask each part; or take more samples."
        )
    try:
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
    except (TypeError, ValueError) as error:
        raise SimulationError(f"Expected a time or times of the motion, got {cut(repr(times))}.") from error
    begin, end = float(motion.t[0]), float(motion.t[-1])
    if wanted.ndim != 1 or not wanted.size or np.any(np.diff(wanted) <= 0):
        raise SimulationError(
            f"Expected a time, or increasing times, of the motion, got {cut(repr(times))}. Sort them."
        )
    if not (begin <= wanted[0] and wanted[-1] <= end):
        raise SimulationError(
            f"Expected times of the motion, from t = {begin:.9g} to {end:.9g}, got {wanted[0]:.9g} to {wanted[-1]:.9g}. What comes "
            "after its end another motion tells: kn.simulate(eom, end, start=sol)."
        )
    whole = again(samples=wanted)
    # where a phase begins there are two values: the one after it
    places = np.searchsorted(whole.t, wanted, side="right") - 1
    off = wanted - whole.t[np.clip(places, 0, len(whole.t) - 1)]
    if np.any(np.abs(off) > NEAR_TIME * max(abs(begin), abs(end), end - begin)):
        raise SimulationError(
            f"Expected the motion to lead to t = {end:.9g} once more, got one that ends at {whole.t[-1]:.9g}: {whole.message}. "
            "Functions that are inputs must give the same at each call."
        )
    return replace(
        whole,
        t=whole.t[places],
        states=whole.states[places],
        work=whole.work[places],
        phase=whole.phase[places],
        samples=tuple(whole.samples[k] for k in places) if whole.samples else (),
        _again=again,
    )
