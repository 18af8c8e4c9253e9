# SPDX-License-Identifier: BSD-3-Clause
"""Chains in space whose end is held, up to 400 links: `python -m benchmarks.rings` prints how their cost grows.

A ring is held at a point, a rod holds a chain of pins about random axes at a distance. Derivation and compilation cold, each in a
process of its own, seconds of processor time; accelerations and the multipliers are computed at a state off the constraints, which
takes as long. `--cold NAME n` prints one of them as JSON.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

import kane as kn
from benchmarks.random_trees import random_tree
from benchmarks.tree_cases import SEED
from benchmarks.trees import figures
from kane.gallery import four_bar

COUNTS, FRESH = (50, 100, 200, 400), 3
COLUMNS = {
    "operations": ("{:.0f}", 1),
    "derive, s": ("{:.2f}", 1),
    "compile, s": ("{:.2f}", 1),
    "evaluation, µs": ("{:.2f}", 1e6),
}
"""How the figures are written, and in what unit."""


def ring(n: int) -> kn.System:
    """Links on pins about x and z in turn; masses and lengths are parameters."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at = O = kn.Point("O", fixed_in=N)
    frame, bodies = N, []
    for i in range(1, n + 1):
        frame = frame.rotate(f"B{i}", kn.coordinate(f"q{i}"), frame.x if i % 2 else frame.z)
        length, mass = kn.parameter(f"l{i}", 1.0 / n), kn.parameter(f"m{i}", 1.0)
        center = at.at(f"C{i}", length / 2 * frame.y)
        inertia = kn.inertia(frame, 0.1, 0.02, 0.11)
        bodies.append(kn.RigidBody(f"b{i}", frame=frame, mass_center=center, mass=mass, inertia=inertia))
        at = at.at(f"P{i}", length * frame.y)
    end = O.at("E", kn.parameter("a", 0.4) * N.x + kn.parameter("b", 0.3) * N.y)
    held = kn.coincident(at, end, along=(N.x, N.y, N.z))
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], holonomic=held)


def rod(n: int) -> kn.System:
    """Links on pins about random axes; the last one is held at a distance from a point of the ground."""
    chain = random_tree(range(-1, n - 1), SEED)
    N, tip = chain.inertial, chain.joints[-1].point
    end = tip.root().at("E", kn.parameter("a", 0.4) * N.x + kn.parameter("b", 0.3) * N.y)
    return chain.replace(holonomic=kn.distance(tip, end, kn.parameter("L", 0.5)))


CHAINS = {"ring": ring, "rod": rod}


def cold(name: str, n: int) -> dict[str, float]:
    """The figures of one."""
    kn.derive(four_bar.system()).compile(cache=False)  # what is imported late, and LLVM
    found = figures(CHAINS[name](n)).values()
    return {key: x * unit for (key, (_, unit)), x in zip(COLUMNS.items(), found, strict=True)}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cold", nargs=2, metavar=("NAME", "N"), help="one cold derivation and compilation, as JSON")
    asked = parser.parse_args()
    if asked.cold:
        print(json.dumps(cold(asked.cold[0], int(asked.cold[1]))))
        return
    for name in CHAINS:
        rows = []
        for n in COUNTS:
            runs = [_fresh(name, n) for _ in range(FRESH)]
            rows.append([float(np.median([run[key] for run in runs])) for key in COLUMNS])
            shown = zip(COLUMNS.items(), rows[-1], strict=True)
            print(f"{name}, {n} links: " + "; ".join(f"{key} {form.format(x)}" for (key, (form, _)), x in shown))
        powers = np.polyfit(np.log(COUNTS), np.log(rows), 1)[0]
        print("power of n: " + "; ".join(f"{key} {x:.2f}" for key, x in zip(COLUMNS, powers, strict=True)))


def _fresh(name: str, n: int) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.rings", "--cold", name, str(n)]
    text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]).stdout
    return dict(json.loads(text))


if __name__ == "__main__":
    main()
