# SPDX-License-Identifier: BSD-3-Clause
"""Whole motions against heyoka's Taylor integrator: chains of rods for 10 s, from nine starts, at equal drift of the energy.

For each start and tool the loosest tolerance is taken at which, and at all tighter ones, the energy stays within the drift at a
hundred samples. Both are then timed in turn, pair by pair, without samples:
the steps alone, the call of a prepared motion, and `kn.simulate`. heyoka has masses, lengths and gravity folded, kane reads
them.
`python -m benchmarks.stepping [rods …]` prints a table.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np

import kane as kn
from benchmarks.machine import processor
from benchmarks.paired import paired
from benchmarks.peers.recursion import accelerations
from kane.gallery import pendulums
from kane.motion.course import Course, Method
from kane.motion.loop import solver_by
from kane.motion.native import KernelSolver
from kane.motion.steps import Stepper

SPAN = 10.0
GRAVITY = 9.81
DRIFTS = {2: (1e-8, 1e-9, 1e-12), 10: (1e-6, 1e-9, 1e-12)}
TOLERANCES = 10.0 ** np.arange(-3, -15.01, -0.5)
REPEATS = 10
SAMPLES = np.linspace(0, SPAN, 101)
Array = Any


def starts(n: int) -> list[Array]:
    """The peers' start, which leaves the rods nearly level, and eight others, all at rest."""
    rng = np.random.default_rng(0)
    first = math.pi / 2 + 0.1 * np.arange(n)
    return [first, *(first * rng.uniform(0.7, 1.2) + rng.uniform(-0.1, 0.1, n) for _ in range(8))]


def drift(n: int, x: Array) -> float:
    """The largest change of the energy over samples (k × 2n), in the range of the potential one."""
    q, u = x[:, :n], x[:, n:]
    vx, vy = np.cumsum(np.cos(q) * u, axis=1), np.cumsum(np.sin(q) * u, axis=1)
    y = -np.cumsum(np.cos(q), axis=1)
    cx, cy = vx - np.cos(q) * u / 2, vy - np.sin(q) * u / 2
    energy = (0.5 * (cx**2 + cy**2) + u**2 / 24 + GRAVITY * (y + np.cos(q) / 2)).sum(axis=1)
    return float(np.abs(energy - energy[0]).max() / (2 * GRAVITY * sum(n - i - 0.5 for i in range(n))))


class Kane:
    """A motion of n rods by one of the integrators."""

    def __init__(self, n: int, method: str) -> None:
        begun = time.perf_counter()
        self.eom, self.method = kn.derive(pendulums.system(n)), method
        p = np.array([s.default for s in self.eom.parameters], dtype=float)
        self.stepper = Stepper(self.eom, p, (), None)
        self.course(math.pi / 2 * np.ones(n), 1e-3, SAMPLES)
        self.seconds = time.perf_counter() - begun

    def course(self, q: Array, tolerance: float, times: Array) -> KernelSolver:
        """Everything but the steps."""
        method = Method(self.method, tolerance, tolerance, 10**9)
        start = np.concatenate([q, np.zeros(len(q) + 1)])
        kernel = Course(self.stepper, method, (0.0, SPAN), start, times, solver_by).solver
        assert isinstance(kernel, KernelSolver)
        return kernel

    def sampled(self, q: Array, tolerance: float) -> Array:
        """The states at the samples."""
        course = self.course(q, tolerance, SAMPLES)
        course.kernel(limit=10**9)
        return np.vstack([np.append(q, 0 * q), course.out[:, :-1]])

    def timed(self, q: Array, tolerance: float) -> Callable[[], object]:
        """The motion alone."""
        course = self.course(q, tolerance, np.zeros(0))
        left = course.given["lag"]
        s, y, lag = course.s.copy(), course.y.copy(), left.copy()

        def run() -> None:
            course.s[:], course.y[:], left[:] = s, y, lag
            course.kernel(limit=10**9)

        return run

    def calls(self, q: Array, tolerance: float) -> dict[str, Callable[[], object]]:
        """The motion alone, by `run = kn.prepare(…)`, and by `kn.simulate`, which has run it before."""
        options: dict[str, Any] = {"method": self.method, "rtol": tolerance, "atol": tolerance, "samples": 2}
        run, u = kn.prepare(self.eom, (0.0, SPAN), **options), np.zeros(len(q))

        def simulate() -> object:
            return kn.simulate(self.eom, (0.0, SPAN), q=q, u=u, **options)

        simulate()
        return {"the steps": self.timed(q, tolerance), "run(…)": lambda: run(q, u), "kn.simulate": simulate}


class Heyoka:
    """The same motion by heyoka."""

    def __init__(self, n: int) -> None:
        begun = time.perf_counter()
        q, u = (list(hy.make_vars(*(f"{kind}{i:03}" for i in range(n)))) for kind in "qu")
        found = accelerations(q, u, [1.0] * n, [1.0] * n, GRAVITY, hy.sin, hy.cos)
        self.rates = [*zip(q, u, strict=True), *zip(u, found, strict=True)]
        self.made: dict[float, Any] = {}
        self.integrator(n, 1e-9)
        self.seconds = time.perf_counter() - begun

    def integrator(self, n: int, tolerance: float) -> Any:
        """heyoka's, one a tolerance."""
        if tolerance not in self.made:
            self.made[tolerance] = hy.taylor_adaptive(self.rates, [0.0] * 2 * n, tol=tolerance)
        return self.made[tolerance]

    def begin(self, q: Array, tolerance: float) -> Any:
        """At the start."""
        integrator = self.integrator(len(q), tolerance)
        integrator.time = 0.0
        integrator.state[:] = np.append(q, 0 * q)
        return integrator

    def sampled(self, q: Array, tolerance: float) -> Array:
        """The states at the samples."""
        return self.begin(q, tolerance).propagate_grid(SAMPLES)[-1]

    def timed(self, q: Array, tolerance: float) -> Callable[[], object]:
        """The motion alone."""
        return lambda: self.begin(q, tolerance).propagate_until(SPAN)


def loosest(tool: Any, n: int, q: Array, wanted: float) -> float | None:
    """The loosest tolerance that holds the drift, as do all tighter ones."""
    held = None
    for tolerance in TOLERANCES[::-1]:
        if drift(n, tool.sampled(q, float(tolerance))) > wanted:
            break
        held = float(tolerance)
    return held


def again(run: Callable[[], object]) -> Callable[[], object]:
    """`REPEATS` times: after a collection of garbage the first one finds nothing in the processor's caches."""

    def runs() -> None:
        for _ in range(REPEATS):
            run()

    return runs


def main(rods: list[int], method: str = "gauss16") -> None:
    """A line for each number of rods, drift and call."""
    print(processor())
    for n in rods:
        kane, heyoka = Kane(n, method), Heyoka(n)
        print(
            f"{n} rods: until the first motion {kane.seconds:.2f} s (derivation and compilation), heyoka {heyoka.seconds:.2f} s"
        )
        for wanted in DRIFTS.get(n, (1e-9,)):
            print(f"  drift {wanted:.0e}")
            found: dict[str, list[Any]] = {}
            for q in starts(n):
                a, b = loosest(kane, n, q, wanted), loosest(heyoka, n, q, wanted)
                if a is None or b is None:
                    continue
                for call, run in kane.calls(q, a).items():
                    found.setdefault(call, []).append(paired(again(run), again(heyoka.timed(q, b))))
            for call, times in found.items():
                shares = [1 / t.ratio for t in times]
                ours, theirs = (
                    statistics.median(statistics.median(x) for x in one)
                    for one in ([t.a for t in times], [t.b for t in times])
                )
                print(
                    f"    {call}: {ours * 1e3 / REPEATS:.3f} ms, heyoka {theirs * 1e3 / REPEATS:.3f} ms, share "
                    f"{statistics.geometric_mean(shares):.2f} ({min(shares):.2f} … {max(shares):.2f}; first start {shares[0]:.2f}) "
                    f"over {len(shares)} starts"
                )


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [2, 10])
