# SPDX-License-Identifier: BSD-3-Clause
"""Motions with constraints against those of another checkout, run by run in turn: what is measured is all of `simulate`.

A four-bar linkage for 100 s, the rattleback's reversal at 1e-12, the slider-crank with 2,001 samples. What is left of the constraints
at the samples is measured beside. `python -m benchmarks.constrained <folder src of the other checkout>`
prints a table.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

PAIRS = 5
Case = tuple[Any, Callable[[], Any]]
OWN = Path(__file__).parents[1] / "src"


def four_bar(kn: Any, gallery: Any) -> Case:
    """A crank and rocker, turning over and over."""
    eom = kn.derive(gallery.four_bar.system())
    return eom, lambda: kn.simulate(eom, (0, 100), samples=501, **gallery.four_bar.START)


def rattleback(kn: Any, gallery: Any) -> Case:
    """Spun at 5 rad/s the wrong way round it rattles and turns back, within 3 s."""
    eom = kn.derive(gallery.rattleback.system())
    return eom, lambda: kn.simulate(eom, (0, 3), rtol=1e-12, atol=1e-12, samples=301, **gallery.rattleback.START)


def slider_crank(kn: Any, gallery: Any) -> Case:
    """One second, at 2,001 samples."""
    eom = kn.derive(gallery.slider_crank.system())
    return eom, lambda: kn.simulate(eom, (0, 1), samples=2001, **gallery.slider_crank.START)


CASES = {case.__name__: case for case in (four_bar, rattleback, slider_crank)}


def left(eom: Any, sol: Any) -> float:
    """The largest residual at the samples, of closures and of speeds, in their units."""
    rows = [sum(x * u for x, u in zip(row, eom.speeds, strict=True)) + b for row, b in zip(eom.A, eom.b, strict=True)]
    return max(float(np.abs(sol[f]).max()) for f in (*(c.expr for c in eom.system.holonomic), *rows))


def work() -> None:
    """A case by its name, then a run for each line that comes, of which the seconds are told."""
    import kane as kn
    from kane.gallery import four_bar, rattleback, slider_crank

    gallery = type("gallery", (), {m.__name__.split(".")[-1]: m for m in (four_bar, rattleback, slider_crank)})
    eom, run = CASES[sys.stdin.readline().strip()](kn, gallery)
    sol = run()
    print(sol.method if hasattr(sol, "method") else "DOP853", sol.status, f"{left(eom, sol):.1e}", flush=True)
    for _ in sys.stdin:
        begun = time.perf_counter()
        run()
        print(time.perf_counter() - begun, flush=True)


class Worker:
    """A process that runs one case by the sources of a folder."""

    def __init__(self, case: str, source: Path) -> None:
        command = [sys.executable, "-m", "benchmarks.constrained", "--work"]
        environment = {**os.environ, "PYTHONPATH": f"{source}{os.pathsep}{OWN.parent}"}
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=environment, cwd=OWN.parent)
        self.told = self.ask(case)

    def ask(self, line: str) -> str:
        """What it answers."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().strip()

    def end(self) -> None:
        """No more runs."""
        self.process.communicate()


def main(other: Path) -> None:
    """A line for each case: medians, ratio, method, status and residual."""
    for case in CASES:
        own, before = Worker(case, OWN), Worker(case, other)
        times = [(float(own.ask("run")), float(before.ask("run"))) for _ in range(PAIRS)]
        ours, theirs = (statistics.median(t) * 1e3 for t in zip(*times, strict=True))
        ratios = [b / a for a, b in times]
        print(
            f"{case}: {ours:.2f} ms ({own.told}), before {theirs:.0f} ms ({before.told}), "
            f"ratio {statistics.median(ratios):.0f} ({min(ratios):.0f} … {max(ratios):.0f})"
        )
        own.end()
        before.end()


if __name__ == "__main__":
    work() if sys.argv[1:] == ["--work"] else main(Path(sys.argv[1]))
