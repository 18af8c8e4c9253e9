# SPDX-License-Identifier: BSD-3-Clause
"""Trees beside robotics engines, and how cost grows with the number of bodies; `make bench-trees` writes trees.json and trees.md.

Right-hand sides and their derivatives in native loops, all contenders of a case in turn in one process, two runs; derivation and
compilation cold, each in a process of its own. `--once` prints one run as JSON, `--cold NAME n` one derivation with its compilation.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import kane as kn
from benchmarks import jacobian, native, trees_table
from benchmarks.machine import compiler, processor, versions
from benchmarks.random_trees import random_tree
from benchmarks.rounds import in_turn, summary
from benchmarks.tree_cases import CASES, SEED, TreeCase, kane_loops, peer_loops
from kane.gallery import pendulums

HERE = Path(__file__).parent
ROUNDS, RUNS = 15, 2
FRESH = 3
GROWING: dict[str, Callable[[int], kn.System]] = {
    "planar chain, absolute angles": pendulums.system,
    "spatial chain": lambda n: random_tree(range(-1, n - 1), SEED),
}
COLD = {"planar chain, absolute angles": (10, 40, 50, 100, 200, 400), "spatial chain": (25, 50, 100, 200, 400)}
GROWTH = (50, 100, 200, 400)
_LONG = 20.0


def measured(case: TreeCase) -> dict[str, Any]:
    """Nanoseconds a call of all contenders, and the peers' times over kane's, round by round."""
    times = in_turn({**kane_loops(case), **peer_loops(case)}, ROUNDS)
    own = times["kane"]
    return {
        "route": case.eom.route,
        "operations": {"state": case.eom.operations.state, "parameter": case.eom.operations.parameter},
        "ns": {name: summary(values, 1e-9) for name, values in times.items()},
        "over kane": {
            name: summary([a / b for a, b in zip(values, own, strict=True)])
            for name, values in times.items()
            if not name.startswith("kane")
        },
    }


def cold(name: str, n: int) -> dict[str, float]:
    """The figures of a chain."""
    kn.derive(pendulums.system(2)).compile(cache=False)  # what is imported late, and LLVM
    return figures(GROWING[name](n))


def figures(system: kn.System) -> dict[str, float]:
    """Seconds of processor time to derive, and to compile, and for one evaluation, nothing cached.

    Raises
    ------
    RuntimeError
        if the rates at the state drawn are not finite
    """
    start = time.process_time()
    eom = kn.derive(system)
    derived = time.process_time()
    eom.compile(cache=False)
    done = time.process_time()
    x = np.random.default_rng(7).uniform(-1, 1, len(eom.coordinates) + len(eom.speeds))
    kernel = native.kane_loop(native.kane_kernel(eom, x, {}))
    times = in_turn({"kane": kernel.loop}, 5)["kane"]
    kernel.loop(1)
    if not np.isfinite(kernel.out).all():
        raise RuntimeError(f"Expected finite rates, got {kernel.out}.")
    return {
        "operations": eom.operations.total,
        "derive": derived - start,
        "compile": done - derived,
        "evaluation": float(np.median(times)),
    }


def growth() -> dict[str, Any]:
    """Cold figures by number of bodies, the best of a few processes, and their powers of it."""
    found: dict[str, Any] = {}
    for name, counts in COLD.items():
        rows: dict[str, dict[str, float]] = {}
        for n in counts:
            runs: list[dict[str, float]] = []
            begin = time.perf_counter()
            while len(runs) < FRESH and (not runs or time.perf_counter() - begin < _LONG):
                runs.append(json.loads(_child("--cold", name, str(n))))
            rows[str(n)] = {key: float(np.median([run[key] for run in runs])) for key in runs[0]}
        powers = {
            key: float(np.polyfit(np.log(GROWTH), np.log([rows[str(n)][key] for n in GROWTH]), 1)[0])
            for key in ("operations", "derive", "compile", "evaluation")
        }
        found[name] = {"rows": rows, "powers": powers}
    return found


def once() -> dict[str, Any]:
    """One run."""
    return {
        "native": {case.name: measured(case) for case in CASES},
        "derivatives": {case.name: jacobian.measured(case, ROUNDS) for case in jacobian.cases()},
        "growth": growth(),
    }


def _child(*arguments: str) -> str:
    command = [sys.executable, "-m", "benchmarks.trees", *arguments]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent).stdout


def main() -> None:
    """Measure, print the tables, write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--once", action="store_true", help="one run, as JSON")
    parser.add_argument("--cold", nargs=2, metavar=("NAME", "N"), help="one cold derivation and compilation, as JSON")
    asked = parser.parse_args()
    if asked.cold:
        print(json.dumps(cold(asked.cold[0], int(asked.cold[1]))))
        return
    if asked.once:
        print(json.dumps(once()))
        return
    runs = [json.loads(_child("--once")) for _ in range(RUNS)]
    setting = {
        "processor": processor(),
        "compiler": compiler(native.CC),
        "versions": versions(),
        "rounds": ROUNDS,
    }
    record = {**setting, "targets": trees_table.targets(runs), "runs": runs}
    text = trees_table.document(record)
    print(text)
    (HERE / "trees.json").write_text(json.dumps(record, indent=1) + "\n")
    (HERE / "trees.md").write_text(text)


if __name__ == "__main__":
    main()
