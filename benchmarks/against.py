# SPDX-License-Identifier: BSD-3-Clause
"""This checkout against another one, in turn: `python -m benchmarks.against OTHER/src [--pairs 15] [--only TEXT]`.

Each side runs in a process of its own that imports its own `kane`; the processes take the same task in turn, so that a drift of the
machine's speed meets both. A ratio above 1 means that this checkout is slower.
"""

from __future__ import annotations

import argparse
import gc
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.paired import Pairs

ROOT = Path(__file__).resolve().parents[1]
MOTIONS = 20
SETTINGS: dict[str, Any] = {"rtol": 1e-9, "atol": 1e-9, "samples": 101}
ONE_BY_ONE = f"{MOTIONS} motions of four-bars, one by one"


def cranks(count: int) -> list[float]:
    """Lengths of cranks (m), each of which turns."""
    return [0.36 + 0.08 * k / count for k in range(count)]


def tasks() -> dict[str, tuple[Callable[[], object], Callable[[], object]]]:
    """Name → what is done before each run, untimed, and what is timed. Public names alone, so that any version can be asked."""
    import numpy as np

    import kane as kn
    from benchmarks.native import kane_kernel, kane_loop
    from kane.expr.node import sweep
    from kane.gallery import four_bar, pendulums, pure_rolling_disk, rolling_disk, whipple_bicycle

    rods, bar = kn.derive(pendulums.system(10)), kn.derive(four_bar.system())
    two = kn.derive(pendulums.system(2)).compile(cache=False).rhs
    ten = rods.compile(cache=False).rhs
    generator = np.random.default_rng(1)
    x2, x10, rows = (generator.uniform(-1, 1, shape) for shape in (4, 20, (20_000, 20)))

    def calls(rhs: Callable[..., object], x: object) -> Callable[[], object]:
        return lambda: [rhs(0.0, x) for _ in range(20_000)]

    start: dict[str, Any] = dict(four_bar.START)

    def native(make: Callable[[], kn.System]) -> Callable[[], object]:
        """The right-hand side in a native loop, at a state near which none is singular."""
        eom = kn.derive(make())
        state = generator.uniform(0.2, 0.6, len(eom.coordinates) + len(eom.speeds))
        loop = kane_loop(kane_kernel(eom, state, {})).loop
        return lambda: loop(100_000)

    def motion(eom: kn.Equations) -> object:
        return kn.simulate(eom, (0, 10), rtol=1e-9, atol=1e-9, **start)

    def nothing() -> None:
        """Nothing has to be done before."""

    def sweep_of_cranks(count: int) -> object:
        """Motions one by one, as any version has them."""
        return [kn.simulate(bar, (0, 10), parameters={"a": a}, **SETTINGS, **start) for a in cranks(count)]

    motion(bar)
    return {
        "derivation of the bicycle": (sweep, lambda: kn.derive(whipple_bicycle.system())),
        "derivation of ten rods": (sweep, lambda: [kn.derive(pendulums.system(10)) for _ in range(10)]),
        "derivation of the sliding disk": (sweep, lambda: [kn.derive(rolling_disk.system()) for _ in range(10)]),
        "derivation of the four-bar": (sweep, lambda: [kn.derive(four_bar.system()) for _ in range(10)]),
        "compilation of ten rods": (nothing, lambda: rods.compile(cache=False)),
        "calls from Python, two rods": (nothing, calls(two, x2)),
        "calls from Python, ten rods": (nothing, calls(ten, x10)),
        "rows in machine code, ten rods": (nothing, lambda: ten(0.0, rows)),
        "machine code, ten rods": (nothing, native(lambda: pendulums.system(10))),
        "machine code, bicycle": (nothing, native(whipple_bicycle.system)),
        "machine code, rolling disk": (nothing, native(pure_rolling_disk.system)),
        "machine code, four-bar": (nothing, native(four_bar.system)),
        "motion of the four-bar, compiled before": (nothing, lambda: motion(bar)),
        ONE_BY_ONE: (nothing, lambda: sweep_of_cranks(MOTIONS)),
        "motion of the four-bar, derived and compiled anew": (sweep, lambda: motion(kn.derive(four_bar.system()))),
    }


def serve() -> None:
    """Run the tasks that come by name, line by line; answer with seconds."""
    table = tasks()
    print(*table, sep="|", flush=True)
    for line in sys.stdin:
        prepare, run = table[line.strip()]
        prepare()
        gc.collect()
        start = time.perf_counter()
        run()
        print(time.perf_counter() - start, flush=True)


class Side:
    """A process with the `kane` of a source folder."""

    def __init__(self, source: Path) -> None:
        environment = {**os.environ, "PYTHONPATH": str(source), "KANE_CACHE": "off"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.against", "--serve"],
            cwd=ROOT,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.names = self._line().split("|")

    def _line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def seconds(self, name: str) -> float:
        """One run."""
        assert self.process.stdin is not None
        print(name, file=self.process.stdin, flush=True)
        return float(self._line())


def main() -> None:
    """Print a line for each task: medians of both, the median ratio of the pairs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", type=Path)
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--only", default="", help="text in the names of the tasks to run")
    chosen = parser.parse_args()
    old, new = Side(chosen.other.resolve()), Side(ROOT / "src")
    for name in [n for n in new.names if chosen.only in n]:
        old.seconds(name), new.seconds(name)
        times: dict[Side, list[float]] = {old: [], new: []}
        for k in range(chosen.pairs):
            for side in (old, new) if k % 2 else (new, old):
                times[side].append(side.seconds(name))
        pairs = Pairs(tuple(times[old]), tuple(times[new]))
        a, b = (statistics.median(seconds) * 1e3 for seconds in (pairs.a, pairs.b))
        print(
            f"{name:50} other {a:9.2f} ms, this {b:9.2f} ms, ratio {pairs.ratio:.3f} over {chosen.pairs} pairs",
            flush=True,
        )


if __name__ == "__main__":
    serve() if "--serve" in sys.argv[1:] else main()
