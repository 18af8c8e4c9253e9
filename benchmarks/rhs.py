# SPDX-License-Identifier: BSD-3-Clause
"""Right-hand sides against peers: native, from Python, and compile times; `make bench-rhs` writes rhs.json and rhs.md.

Two runs, each a process of its own; within a run all contenders take turns in one process. `--peers` leaves kane out and
writes nothing; `--once` prints one run as JSON; `--compile n` one compile of n rods in a process of its own.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import kane as kn
from benchmarks import native, rhs_table
from benchmarks.machine import compiler, processor, versions
from benchmarks.native import KaneKernel
from benchmarks.peers import casadi_ad
from benchmarks.rhs_cases import CASES, Case, native_loops, pendulum, python_loops
from benchmarks.rounds import in_turn, summary
from kane.gallery import pendulums

HERE = Path(__file__).parent
ROUNDS, RUNS = 15, 2
PYTHON_CASES = (2, 10)
RODS = (2, 10, 20, 40, 80)
GROWTH = (20, 40, 80)
ENOUGH, REPEATS = 8.0, 5  # compile again until so many seconds, derivation too, or repeats
NS, US = 1e-9, 1e-6


def kane_side(case: Case) -> KaneKernel:
    """kane's compiled right-hand side of a case."""
    return native.kane_kernel(case.eom, case.x, case.values)


def measure_native(case: Case, kane: bool) -> dict[str, Any]:
    """Nanoseconds a call, and kane's share of CasADi's, round by round."""
    times = in_turn(native_loops(case, kane_side(case) if kane else None), ROUNDS)
    ratios = {
        name: summary([a / b for a, b in zip(values, times["CasADi C"], strict=True)])
        for name, values in times.items()
        if name.startswith("kane")
    }
    return {
        "operations": {"state": case.eom.operations.state, "parameter": case.eom.operations.parameter},
        "ns": {name: summary(values, NS) for name, values in times.items()},
        "ratio to CasADi C": ratios,
    }


def measure_python(case: Case, kane: bool) -> dict[str, Any]:
    """Microseconds a call from Python, and what kane's call adds to its native time."""
    times = in_turn(python_loops(case, kane_side(case) if kane else None), ROUNDS)
    native_times = times.pop("kane, native", None)
    found: dict[str, Any] = {"us": {name: summary(values, US) for name, values in times.items()}}
    if native_times is not None:
        found["us over native"] = summary([a - b for a, b in zip(times["kane"], native_times, strict=True)], US)
    return found


def compile_once(n: int) -> dict[str, float]:
    """Operations of n rods and seconds of one compile."""
    eom = kn.derive(pendulums.system(n))
    return {"operations": eom.operations.total, "seconds": native.kane_compile(eom)}


def measure_compile() -> dict[str, Any]:
    """Cold compiles, each in a fresh process."""
    found = {}
    for n in RODS:
        seconds: list[float] = []
        start = time.perf_counter()
        while len(seconds) < REPEATS and time.perf_counter() - start < ENOUGH:
            once = json.loads(_child("--compile", str(n)))
            seconds.append(once["seconds"])
        found[str(n)] = {"operations": once["operations"], "seconds": summary(seconds)}
    return {"rods": found, "exponent": exponent(found)}


def exponent(found: dict[str, Any]) -> float:
    """The power of the operation count that compile times follow, fitted over the large pendulums."""
    points = [(found[str(n)]["operations"], found[str(n)]["seconds"]["median"]) for n in GROWTH]
    operations, seconds = np.log(np.array(points)).T
    return float(np.polyfit(operations, seconds, 1)[0])


def measure_peer_compile() -> dict[str, float]:
    """Seconds from nothing to CasADi's compiled C, by rods: building the function, generating, cc."""
    found = {}
    for n in (2, 10, 20):
        case = pendulum(n)
        x, values = case.x, case.values
        start = time.perf_counter()
        casadi_ad.kernel(casadi_ad.chain(n), x, values)
        found[str(n)] = time.perf_counter() - start
    return found


def once(kane: bool = True) -> dict[str, Any]:
    """One run."""
    found: dict[str, Any] = {"native": {case.name: measure_native(case, kane) for case in CASES}}
    found["python"] = {case.name: measure_python(case, kane) for case in map(pendulum, PYTHON_CASES)}
    found["peer compile"] = measure_peer_compile()
    if kane:
        found["compile"] = measure_compile()
    return found


def _child(*arguments: str) -> str:
    command = [sys.executable, "-m", "benchmarks.rhs", *arguments]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent).stdout


def main() -> None:
    """Measure, print the tables, write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--peers", action="store_true", help="the peers only, written nowhere")
    parser.add_argument("--once", action="store_true", help="one run, as JSON")
    parser.add_argument("--compile", type=int, metavar="N", help="one compile of N rods, as JSON")
    asked = parser.parse_args()
    if asked.compile:
        print(json.dumps(compile_once(asked.compile)))
        return
    if asked.once:
        print(json.dumps(once()))
        return
    runs = [once(kane=False)] if asked.peers else [json.loads(_child("--once")) for _ in range(RUNS)]
    setting = {
        "processor": processor(),
        "compiler": compiler(native.CC),
        "flags": " ".join(native.FLAGS),
        "versions": versions(),
    }
    record = {**setting, "rounds": ROUNDS, "targets": rhs_table.targets(runs), "runs": runs}
    text = rhs_table.document(record)
    print(text)
    if not asked.peers:
        (HERE / "rhs.json").write_text(json.dumps(record, indent=1) + "\n")
        (HERE / "rhs.md").write_text(text)


if __name__ == "__main__":
    main()
