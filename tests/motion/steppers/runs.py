# SPDX-License-Identifier: BSD-3-Clause
"""Integrators' kernels called by themselves, on systems whose motion is known."""

import numpy as np

import kane as kn
from kane.motion.routines import rates
from kane.motion.steppers.outline import SIZE, At
from kane.motion.steppers.table import INTEGRATORS
from kane.program.native.entry import hoisted


def spring():
    """q'' = −q with q = cos t."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    p = O.at("P", q * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, -q * N.x)], speeds="rates"))


def arguments(eom, settings, name, y, end, step, tolerance=1.0, samples=()):
    """What a kernel is given, but for its routine, and the compiled rates; no step is longer than `step`."""
    routine = eom.numeric(settings).routine(rates).flat
    y = np.append(y, 0.0)
    p = np.array([s.default for s in eom.parameters], dtype=float)
    told = {At.STEP: step, At.END: end, At.LONGEST: step, At.RTOL: tolerance, At.ATOL: tolerance, At.FRESH: 1.0}
    s = np.zeros(SIZE)
    for place, value in told.items():
        s[place] = value
    n, count = len(y), len(samples)
    arrays = {
        "s": s,
        "y": y,
        "lag": np.zeros(n),
        "work": np.zeros(INTEGRATORS[name].rows * n),
        "p": p,
        "r": np.zeros(1),
    }
    arrays |= {"h": hoisted(routine, 0.0, y[:-1], p, np.zeros(0)), "times": np.append(samples, np.inf)}
    return {"n": n, "limit": 10**6, "samples": count, **arrays, "rows": np.zeros((max(count, 1), n))}, routine
