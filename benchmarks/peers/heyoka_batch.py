# SPDX-License-Identifier: BSD-3-Clause
"""Many pendulums of rods by heyoka's batch mode: as many motions side by side as its vectors have lanes."""

from __future__ import annotations

from collections.abc import Callable

import heyoka as hy
import numpy as np

from benchmarks.native import Array
from benchmarks.peers.recursion import accelerations


def motions(n: int, end: float, tolerance: float, gravity: float) -> Callable[[Array], Array]:
    """What leads states (k × 2 n) of n rods of length 1 and mass 1 from rest in time to `end`."""
    lanes = hy.recommended_simd_size()
    q, u = (list(hy.make_vars(*(f"{kind}{i:03}" for i in range(n)))) for kind in "qu")
    found = accelerations(q, u, [1.0] * n, [1.0] * n, gravity, hy.sin, hy.cos)
    rates = list(zip([*q, *u], [*u, *found], strict=True))
    stepper = hy.taylor_adaptive_batch(rates, np.zeros((2 * n, lanes)), tol=tolerance)

    def run(starts: Array) -> Array:
        ends = np.empty_like(starts)
        for k in range(0, len(starts), lanes):
            stepper.set_time(0.0)
            some = starts[k : k + lanes]
            stepper.state[:, : len(some)] = some.T
            stepper.propagate_until(end)
            ends[k : k + lanes] = stepper.state[:, : len(some)].T
        return ends

    return run
