# SPDX-License-Identifier: BSD-3-Clause
"""The Whipple bicycle beside SymPy: derivation and numeric linearization; `make bench-bicycle` writes bicycle.json and bicycle.md.

Two runs, each a process of its own; within a run the derivations take turns. SymPy linearizes once, in a
process of its own. `--once` prints one run as JSON, `--linearize` SymPy's linearization.
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
from sympy.core.cache import clear_cache

import kane as kn
from benchmarks import bicycle_table
from benchmarks.machine import processor, versions
from benchmarks.native import Array
from benchmarks.paired import paired
from benchmarks.peers import sympy_bicycle
from benchmarks.rounds import summary
from kane.expr.node import sweep
from kane.gallery import whipple_bicycle

HERE = Path(__file__).parent
PAIRS, RUNS = 15, 2
POINTS = 100
SPEED = 5.0
INDEPENDENT = ("u1", "u4", "u5")


def ours() -> kn.Equations:
    """Declared and derived by kane."""
    return kn.derive(whipple_bicycle.system())


def theirs() -> object:
    """Declared and derived by SymPy."""
    method = sympy_bicycle.derive()
    return method.mass_matrix, method.forcing


def by_name(eom: kn.Equations, at: kn.analysis.Assembled, inputs: dict[str, float]) -> dict[str, float]:
    """What SymPy's model needs at a state: its angles, their rates, the inputs and the parameters."""
    names = [q.name for q in eom.coordinates]
    rates = eom.evaluate(eom.rates, q=at.q, u=at.u)
    angles = dict(zip(names, eom.evaluate(eom.coordinates, q=at.q, u=at.u), strict=True))
    found = {p.name: p.default for p in eom.parameters} | angles | inputs
    found |= {f"u_{name}": rate for name, rate in zip(names, rates, strict=True)}
    return {name: float(value) for name, value in found.items()}


def difference(seed: int = 0) -> float:
    """Largest relative difference of the angles' second derivatives at a random state on the constraints."""
    generator = np.random.default_rng(seed)
    eom, method = ours(), sympy_bicycle.derive()
    q: dict[str, Any] = {s.name: float(generator.uniform(-0.5, 0.5)) for s in eom.coordinates}
    q["theta"] = kn.guess(0.0)
    u = dict(zip(INDEPENDENT, generator.uniform(-3, 3, 3), strict=True))
    at, inputs = kn.assemble(eom, q=q, u=u), {"T_phi": 3.0, "T_delta": -1.5}
    peer = sympy_bicycle.accelerations(method, by_name(eom, at, inputs))
    own = eom.evaluate([eom.time_derivative(r) for r in eom.rates], q=at.q, u=at.u, inputs=inputs)
    found = {f"u_{s.name}": float(a) for s, a in zip(eom.coordinates, own, strict=True)}
    return max(abs(found[name] - a) for name, a in peer.items()) / max(map(abs, peer.values()))


def straight(eom: kn.Equations, speed: float) -> kn.analysis.Assembled:
    """Upright and straight ahead."""
    q = dict.fromkeys((s.name for s in eom.coordinates), 0.0)
    return kn.assemble(eom, q=q, u={"u1": 0.0, "u4": 0.0, "u5": -speed / 0.3})


def linearizations(lin: kn.analysis.Linearizer, speeds: Array) -> list[float]:
    """Seconds of kane's numeric linearization at each forward speed."""
    points, seconds = [straight(lin.eom, float(v)) for v in speeds], []
    for at in points:
        start = time.perf_counter()
        lin(q=at.q, u=at.u, independent=INDEPENDENT)
        seconds.append(time.perf_counter() - start)
    return seconds


def measure_linearization() -> dict[str, Any]:
    """kane's: the first point with compiling, then many."""
    start = time.perf_counter()
    lin = kn.analysis.linearizer(ours())
    at = straight(lin.eom, SPEED)
    lin(q=at.q, u=at.u, independent=INDEPENDENT)
    ready = time.perf_counter() - start
    return {"kane, s": summary(linearizations(lin, np.linspace(1.0, 10.0, POINTS))), "kane ready, s": ready}


def peer_linearization() -> dict[str, float]:
    """Seconds of SymPy's, derivation left out, and the largest distance of kane's eigenvalues from SymPy's."""
    eom, method = ours(), sympy_bicycle.derive()
    at = straight(eom, SPEED)
    own = kn.linearize(eom, q=at.q, u=at.u, independent=INDEPENDENT).without("cyclic")
    values = by_name(eom, at, dict.fromkeys(sympy_bicycle.INPUTS, 0.0))
    start = time.perf_counter()
    A = sympy_bicycle.linear(method, values)
    seconds = time.perf_counter() - start
    roots = np.linalg.eigvals(A)
    return {"s": seconds, "difference": max(float(np.abs(roots - r).min()) for r in own.eigenvalues)}


def once() -> dict[str, Any]:
    """One run."""
    derivation = paired(ours, theirs, PAIRS, before=(sweep, clear_cache))
    return {
        "difference": difference(),
        "derivation": {
            "kane, s": summary(derivation.a),
            "SymPy, s": summary(derivation.b),
            "ratio": derivation.ratio,
        },
        "linearization": measure_linearization(),
    }


def _child(what: str) -> Any:
    command = [sys.executable, "-m", "benchmarks.bicycle", what]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent).stdout)


def write(runs: list[Any], peer: dict[str, float]) -> None:
    """Print the page; write it and the figures."""
    record = {
        "processor": processor(),
        "versions": {name: v for name, v in versions().items() if name in ("Python", "kane", "numpy", "sympy")},
        "pairs": PAIRS,
        "points": POINTS,
        "SymPy linearization": peer,
        "targets": bicycle_table.targets(runs),
        "runs": runs,
    }
    text = bicycle_table.document(record)
    print(text)
    (HERE / "bicycle.json").write_text(json.dumps(record, indent=1) + "\n")
    (HERE / "bicycle.md").write_text(text)


def main() -> None:
    """Measure, print the tables, write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--once", action="store_true", help="one run, as JSON")
    parser.add_argument("--linearize", action="store_true", help="SymPy's linearization, as JSON")
    asked = parser.parse_args()
    if asked.once or asked.linearize:
        print(json.dumps(once() if asked.once else peer_linearization()))
        return
    write([_child("--once") for _ in range(RUNS)], _child("--linearize"))


if __name__ == "__main__":
    main()
