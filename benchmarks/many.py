# SPDX-License-Identifier: BSD-3-Clause
"""Many double pendulums on one core and two, a second: `python -m benchmarks.many [COUNT [PAIRS]]`, beside heyoka where it is there.

Rods start at rest at random angles and move for 10 s, at the loosest tolerances that keep the energy to 1e-8 in the median: `drift`
is its change over the largest that there is. Both sides run in turn.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial

import numpy as np

import kane as kn
from benchmarks.native import Array
from benchmarks.paired import paired
from benchmarks.rhs_cases import optional
from kane.gallery import pendulums

END, GRAVITY = 10.0, 9.81
TOLERANCE, PEERS = 8e-8, 1e-7  # at 1.2e-7 a Taylor series loses an order, and drifts by 3e-8


def starts(count: int) -> Array:
    """Angles from −π to π, at rest."""
    return np.hstack([np.random.default_rng(0).uniform(-np.pi, np.pi, (count, 2)), np.zeros((count, 2))])


def own(threads: int) -> Callable[[Array], Array]:
    """The motions by `kn.simulate_many`."""
    eom = kn.derive(pendulums.system(2))

    def run(x: Array) -> Array:
        runs = kn.simulate_many(
            eom, (0, END), q=x[:, :2], u=x[:, 2:], samples=2, rtol=TOLERANCE, atol=TOLERANCE, threads=threads
        )
        return np.asarray(runs["end_state"])

    return run


def energy(x: Array) -> Array:
    """K + V of two rods of length 1 and mass 1."""
    q1, q2, u1, u2 = x.T
    kinetic = u1**2 * 2 / 3 + u2**2 / 6 + u1 * u2 * np.cos(q1 - q2) / 2
    return np.asarray(kinetic - GRAVITY * (1.5 * np.cos(q1) + 0.5 * np.cos(q2)))


def main() -> None:
    """Drifts, then pairs: two threads beside one, and the peer."""
    count, pairs = (int(a) for a in (*sys.argv[1:], *("10000", "5")[len(sys.argv) - 1 :]))
    x = starts(count)
    one, two = own(1), own(2)
    peer = optional("heyoka_batch")
    sides = {"two threads": two} | ({"heyoka": peer.motions(2, END, PEERS, GRAVITY)} if peer else {})
    for name, run in {"kane": one, **sides}.items():
        drift = np.abs(energy(run(x)) - energy(x)) / (4 * GRAVITY)
        print(f"{name}: drift {np.median(drift):.1e} in the median, {drift.max():.1e} at most")
    for name, run in sides.items():
        print(f"{count} motions:", paired(partial(one, x), partial(run, x), pairs).line("kane", name))


if __name__ == "__main__":
    main()
