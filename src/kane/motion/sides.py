# SPDX-License-Identifier: BSD-3-Clause
"""Which side of its switches, and which regime of friction, a motion is on at each sample."""

from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.events import SLIPS
from kane.equations.equations import Equations
from kane.motion.switches import switches
from kane.numeric.scale import CHANGES_SIDE, ROUNDED_CHAIN

Sides = npt.NDArray[np.int8]


def sides(motion: Any) -> dict[str, Sides]:
    """See Solution.regimes."""
    eom: Equations = motion.equations
    turning = [s for s in switches(eom) if s.jumps]
    slips = [
        (load.name, load.slip)
        for load in eom.solved.regular.declared_loads
        if load.slip and load.slip.speed is not None
    ]
    values = motion[[*(s.quantity for s in turning), *(slip.speed for _, slip in slips)]] if turning or slips else []
    found = {s.text: _sign(v) for s, v in zip(turning, values, strict=False)}
    for (name, slip), speed in zip(slips, values[len(turning) :], strict=True):
        least = SLIPS * np.abs(speed).max(initial=0) if slip.threshold is None else slip.threshold
        found[name] = (speed > (1 + CHANGES_SIDE) * least).astype(np.int8)
    return found


def _sign(values: npt.NDArray[np.float64]) -> Sides:
    near = np.abs(values) <= ROUNDED_CHAIN * np.abs(values).max(initial=0)
    return np.where(near, 0, np.sign(values)).astype(np.int8)
