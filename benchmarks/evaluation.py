# SPDX-License-Identifier: BSD-3-Clause
"""`evaluate` of all accelerations at one state: the first time, and again with other numbers: `python -m benchmarks.evaluation`."""

import statistics
import time

import numpy as np

import kane as kn
from benchmarks.systems import COUNTED

NAMES = ("7R arm, general axes", "Whipple bicycle", "planar pendulum, absolute angles, 10 rods")


def times(eom: kn.Equations, repeats: int = 300) -> tuple[float, float, float]:
    """The first call, the second, which lists the instructions, and the median of later ones, in ms."""
    rng = np.random.default_rng(1)
    found = []
    for _ in range(repeats):
        q, u = rng.uniform(-1, 1, len(eom.coordinates)), rng.uniform(-1, 1, len(eom.independent_speeds))
        speeds = dict(zip(eom.independent_speeds, u, strict=True))
        start = time.perf_counter()
        eom.evaluate(eom.accelerations, q=q, u=speeds, inputs=dict.fromkeys(eom.inputs, 0.5))
        found.append(1e3 * (time.perf_counter() - start))
    return found[0], found[1], statistics.median(found[2:])


def main() -> None:
    """Print the times of each system."""
    for name in NAMES:
        first, second, later = times(kn.derive(COUNTED[name]()))
        print(f"{name:45} first {first:6.2f} ms  second {second:6.2f} ms  later {later:6.3f} ms")


if __name__ == "__main__":
    main()
