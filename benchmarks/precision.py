# SPDX-License-Identifier: BSD-3-Clause
"""Work and precision of whole motions: time against the drift of the energy, tolerance by tolerance, for several tools.

Chains of 2 and 10 rods swing for 10 s from the peers' start. The drift is the largest change of the energy at a hundred samples, over
the range of the potential one; times are medians of rounds in which every tool runs once at each tolerance, without samples,
compilation before. `make bench-precision` writes benchmarks/precision.json, precision.md and docs/_static/precision.svg.
"""

from __future__ import annotations

import gc
import json
import math
import statistics
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machine import processor, versions
from benchmarks.motion_tools import TOOLS
from benchmarks.rhs_table import table
from benchmarks.stepping import drift, starts

HERE = Path(__file__).parent
PICTURE = HERE.parent / "docs" / "_static" / "precision.svg"
TOLERANCES = 10.0 ** np.arange(-4, -14.01, -1)
WANTED = (1e-6, 1e-8, 1e-10, 1e-12)
RODS = (2, 10)
ROUNDS = 15
LONGEST = 0.5
"""Seconds from which on a motion is timed once in three rounds."""


def measured(n: int, rounds: int) -> dict[str, list[dict[str, float]]]:
    """By tool: tolerance, drift and the median time of each point."""
    q = starts(n)[0]
    runs: list[tuple[str, float, float, Any, list[float]]] = []
    for name, make in TOOLS.items():
        tool = make(n)
        for tolerance in map(float, TOLERANCES):
            error = drift(n, tool.sampled(q, tolerance))
            run = tool.timed(q, tolerance)
            run()
            runs.append((name, tolerance, error, run, []))
        print(f"{n} rods, {name}: made", file=sys.stderr, flush=True)
    for k in range(rounds):
        for _, _, _, run, times in runs:
            if k % 3 and times and times[0] > LONGEST:
                continue
            gc.collect()
            start = time.perf_counter()
            run()
            times.append(time.perf_counter() - start)
    found: dict[str, list[dict[str, float]]] = {name: [] for name in TOOLS}
    for name, tolerance, error, _, times in runs:
        if math.isfinite(error):
            found[name].append({"tolerance": tolerance, "drift": error, "seconds": statistics.median(times)})
    return found


def at(points: Sequence[Mapping[str, float]], wanted: float) -> float | None:
    """The time at a drift: of the fastest point that holds it."""
    return min((p["seconds"] for p in points if p["drift"] <= wanted), default=None)


def page(result: Mapping[str, Any]) -> str:
    """The figures as Markdown."""
    parts = [
        "# Work and precision of motions",
        "",
        "Chains of 2 and 10 rods, 10 s from nearly level, at rest: the fastest tolerance at which the energy drifts by no more "
        f"than is asked, of {' to '.join(f'{t:.0e}' for t in TOLERANCES[[0, -1]])} in powers of ten. Milliseconds, and in brackets "
        f"the time over that of `kane` by `gauss16`; {_rounds(result['rounds'])} in one process, compilation before, no "
        "samples.",
        "",
        f"{result['processor']}; {', '.join(f'{k} {v}' for k, v in result['versions'].items())}.",
    ]
    for n, tools in result["rods"].items():
        head = [f"{n} rods", *(f"drift {w:.0e}" for w in WANTED)]
        rows = []
        for name, points in tools.items():
            row = [name]
            for wanted in WANTED:
                own, first = at(points, wanted), at(next(iter(tools.values())), wanted)
                row.append("–" if own is None or first is None else f"{own * 1e3:.3g} ({_times(own / first)})")
            rows.append(row)
        parts += ["", table(head, rows)]
    return "\n".join([*parts, ""])


def _rounds(count: int) -> str:
    return "one round" if count == 1 else f"medians of {count} rounds"


def _times(ratio: float) -> str:
    """A ratio in two digits, or whole."""
    return f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}"


def draw(result: Mapping[str, Any]) -> None:
    """Time over drift, a panel for each number of rods."""
    import matplotlib as mpl

    mpl.use("svg")
    import matplotlib.pyplot as plt

    mpl.rcParams.update({"svg.hashsalt": "kane", "svg.fonttype": "path"})
    figure, axes = plt.subplots(1, len(result["rods"]), figsize=(10, 4.6), layout="constrained", sharex=True)
    for ax, (n, tools) in zip(axes, result["rods"].items(), strict=True):
        for k, (name, points) in enumerate(tools.items()):
            own = name.startswith("kane")
            ax.loglog(
                [p["drift"] for p in points],
                [p["seconds"] * 1e3 for p in points],
                "o-",
                color=f"C{k}",
                lw=2.2 if own else 1.2,
                ms=4,
                label=name,
            )
        ax.set_xlabel("drift of the energy")
        ax.set_ylabel("time, ms")
        ax.set_title(f"{n} rods, 10 s", fontsize=10)
        ax.grid(visible=True, which="major", alpha=0.3)
    axes[0].invert_xaxis()  # of both: the more exact, the farther to the right
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=4, fontsize=8, frameon=False)
    figure.savefig(PICTURE, metadata={"Date": None})


def main(rounds: int = ROUNDS) -> None:
    """Measure, write, draw."""
    result = {
        "processor": processor(),
        "versions": versions(),
        "rounds": rounds,
        "rods": {str(n): measured(n, rounds) for n in RODS},
    }
    (HERE / "precision.json").write_text(json.dumps(result, indent=1) + "\n")
    (HERE / "precision.md").write_text(page(result))
    draw(result)
    print(page(result))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
