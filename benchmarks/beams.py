# SPDX-License-Identifier: BSD-3-Clause
"""The spin-up of a flexible beam beside Exudyn: `make bench-beams` writes beams.json and beams.md.

Two runs, each a process of its own. In each the fewest modes and the coarsest mesh are sought whose peak lag of the tip is within
1 % of that of a fine mesh, the mesh with its fastest settings that meet it; then they take turns. `--once` prints one run as JSON.
"""

from __future__ import annotations

import argparse
import gc
import itertools
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import kane as kn
from benchmarks import beams_table
from benchmarks.machine import processor, versions
from benchmarks.peers.exudyn_spin_up import END, Setting, spun
from benchmarks.rounds import summary
from kane.expr.node import sweep
from kane.gallery import rotating_beam

HERE = Path(__file__).parent
ROUNDS, RUNS = 15, 2
MODES = 5
WITHIN = 0.01
"""Share of the peak lag by which it may be wrong."""
SAMPLES = 201
FINEST = Setting(elements=6, steps=3000)
"""With 8 elements and 4000 steps the peak changes by 0.01 %."""
RTOL = 1e-4


def derived(modes: int) -> kn.Equations:
    """The beam of Yoo, Ryan and Scott on its hub, linearized in the deformation."""
    return kn.derive(rotating_beam.system(spin_up=True, modes=modes))


def manoeuvre(modes: int) -> Callable[[], float]:
    """A function that simulates 20 s and gives the largest lag of the tip (m)."""
    eom = derived(modes)
    beam: Any = eom.system.bodies[0]
    tip = beam.point_at(1).position(beam.root).dot(beam.frame.y)
    start: dict[str, Any] = {"q": [0.0] * modes, "u": [0.0] * modes}

    def peak() -> float:
        sol = kn.simulate(eom, (0, END), samples=SAMPLES, rtol=RTOL, atol=RTOL / 100, **start)
        return float(-sol[tip].min())

    return peak


def fewest_modes(reference: float) -> int:
    """How many modes meet the error."""
    return next(n for n in range(1, MODES + 1) if abs(manoeuvre(n)() / reference - 1) <= WITHIN)


def coarsest(reference: float) -> tuple[Setting, float]:
    """Exudyn's coarsest mesh that meets the error at some settings, the fastest of these, and the error."""
    for elements in itertools.count(1):
        found = []
        for steps, radius, modified in itertools.product((400, 600, 800, 1200, 2000), (0.9, 0.6), (True, False)):
            setting = Setting(elements, steps, radius, modified)
            lag, seconds = spun(setting)
            error = abs(-lag.min() / reference - 1)
            if error <= WITHIN:
                found.append((seconds, setting, error))
        if found:
            _, setting, error = min(found)
            return setting, float(error)
    raise AssertionError("no mesh meets the error")


def timed(f: Callable[[], object]) -> float:
    """Seconds of a call."""
    gc.collect()
    start = time.perf_counter()
    f()
    return time.perf_counter() - start


def derivation() -> float:
    """Seconds from nothing to the equations with all modes."""
    sweep()
    return timed(lambda: derived(MODES))


def once() -> dict[str, Any]:
    """One run."""
    reference = float(-spun(FINEST)[0].min())
    fewest = fewest_modes(reference)
    setting, error = coarsest(reference)
    few, all_ = manoeuvre(fewest), manoeuvre(MODES)
    errors = [few() / reference - 1, all_() / reference - 1]
    rows = [(timed(few), timed(all_), spun(setting)[1], derivation()) for _ in range(ROUNDS)]
    names = ("fewest", "all", "Exudyn", "derivation")
    return {
        "reference": reference,
        "modes": fewest,
        "setting": str(setting),
        "errors": {"fewest": errors[0], "all": errors[1], "Exudyn": error},
        "operations": derived(MODES).operations.total,
        **{name: summary(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)},
        "ratios": {
            name: statistics.median(row[2] / row[k] for row in rows) for k, name in enumerate(("fewest", "all"))
        },
    }


def _child() -> Any:
    command = [sys.executable, "-m", "benchmarks.beams", "--once"]
    text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent).stdout
    return json.loads(text.strip().splitlines()[-1])  # what Exudyn prints stands before


def main() -> None:
    """Measure, print the page, write it and the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--once", action="store_true", help="one run, as JSON")
    if parser.parse_args().once:
        print(json.dumps(once()))
        return
    runs = [_child() for _ in range(RUNS)]
    record = {
        "processor": processor(),
        "versions": {k: v for k, v in versions().items() if k in ("Python", "kane", "numpy", "llvmlite", "exudyn")},
        "rounds": ROUNDS,
        "finest": f"{FINEST.elements} elements in {FINEST.steps} steps",
        "targets": beams_table.targets(runs),
        "runs": runs,
    }
    text = beams_table.document(record)
    print(text)
    (HERE / "beams.json").write_text(json.dumps(record, indent=1) + "\n")
    (HERE / "beams.md").write_text(text)


if __name__ == "__main__":
    main()
