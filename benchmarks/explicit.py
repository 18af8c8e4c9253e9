# SPDX-License-Identifier: BSD-3-Clause
"""Evaluations that explicit methods take to the same error, over those of DOP853: `python -m benchmarks.explicit`.

The error is the largest of a component at a hundred samples, in its range along the motion, from `gauss16` at a tolerance of 1e-14.
Between tolerances in steps of half a power of ten counts are interpolated. Once motions are sampled a hundred times, for which some
steps take the stages of dense output, once only at their ends. Counts are deterministic, up to rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import kane as kn
from benchmarks.rhs_table import table
from kane.gallery import (
    four_bar,
    furuta_pendulum,
    gimbal_gyroscope,
    pendulums,
    rattleback,
    spherical_pendulum,
    spinning_top,
)

METHODS = ("dop853", "tsitpap8", "vern9")
TOLERANCES = 10.0 ** np.arange(-3, -14.01, -0.5)
WANTED = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
SAMPLES = 101
CASES: Mapping[str, tuple[Callable[[], kn.System], float, Mapping[str, Any]]] = {
    "double pendulum": (lambda: pendulums.system(2), 5, {"q": [1.0, 1.5], "u": [0.0, 0.0]}),
    "five rods": (lambda: pendulums.system(5), 3, {"q": [1.0] * 5, "u": [0.0] * 5}),
    "ten rods": (lambda: pendulums.system(10), 3, {"q": [1.0] * 10, "u": [0.0] * 10}),
    "spherical pendulum": (spherical_pendulum.system, 10, {"q": [0.8, 0.3], "u": [0.5, 1.0]}),
    "Furuta's pendulum": (furuta_pendulum.system, 5, {"q": [0.3, 0.8], "u": [1.0, 0.2]}),
    "spinning top": (spinning_top.system, 5, {"q": [0.1, 0.4, 0.0], "u": [0.1, 0.0, 40.0]}),
    "gyroscope in gimbals": (gimbal_gyroscope.system, 5, {"q": [0.1, 0.4, 0.0], "u": [0.3, 0.2, 20.0]}),
    "four-bar": (four_bar.system, 10, four_bar.START),
    "rattleback": (rattleback.system, 2, rattleback.START),
}
"""A system, the seconds of its motion, and its start."""


def counts(eom: Any, end: float, start: Mapping[str, Any]) -> dict[str, tuple[list[float], list[float], list[float]]]:
    """By method: errors at each tolerance, evaluations with samples and without."""

    def run(method: str, tolerance: float, samples: int) -> Any:
        asked: Mapping[str, Any] = {"method": method, "rtol": tolerance, "atol": tolerance, "samples": samples}
        return kn.simulate(eom, (0, end), inputs=dict.fromkeys(eom.inputs, 0), **asked, **start)

    exact = run("gauss16", 1e-14, SAMPLES).states
    size = np.ptp(exact, axis=0) + 1e-3 * np.abs(exact).max()
    found = {}
    for method in METHODS:
        sampled = [run(method, float(t), SAMPLES) for t in TOLERANCES]
        errors = [float((np.abs(s.states - exact) / size).max()) for s in sampled]
        ends = [float(run(method, float(t), 2).evaluations) for t in TOLERANCES]
        found[method] = errors, [float(s.evaluations) for s in sampled], ends
    return found


def at(errors: list[float], evaluations: list[float], wanted: float) -> float:
    """Evaluations at an error: points whose error is no smaller than one at a looser tolerance are left out."""
    kept = [
        (-np.log(e), np.log(n))
        for k, (e, n) in enumerate(zip(errors, evaluations, strict=True))
        if e < min([*errors[:k], 1e9])
    ]
    x, y = zip(*kept, strict=True)
    return float(np.exp(np.interp(-np.log(wanted), x, y, right=np.nan)))


def main() -> None:
    """Two tables: with samples and without."""
    found = {name: counts(kn.derive(system()), end, start) for name, (system, end, start) in CASES.items()}
    for what, title in ((1, f"{SAMPLES} samples"), (2, "no samples")):
        rows, ratios = [], []
        for name, methods in found.items():
            own = [[at(methods[m][0], methods[m][what], w) for w in WANTED] for m in METHODS]
            ratio = np.array(own[1:]) / own[0]
            ratios.append(ratio)
            rows.append([name, *(f"{own[0][k]:.0f}: {a:.2f}, {b:.2f}" for k, (a, b) in enumerate(ratio.T))])
        means = np.exp(np.nanmean(np.log(ratios), axis=0))
        rows.append(["geometric mean", *(f"{a:.2f}, {b:.2f}" for a, b in means.T)])
        print(
            table([f"{title}; {METHODS[0]}: {METHODS[1]}, {METHODS[2]}", *(f"error {w:.0e}" for w in WANTED)], rows),
            "\n",
        )


if __name__ == "__main__":
    main()
