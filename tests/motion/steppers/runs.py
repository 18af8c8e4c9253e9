# SPDX-License-Identifier: BSD-3-Clause
"""Integrators' kernels called by themselves, on systems whose motion is known."""

import numpy as np

import kane as kn
from kane.motion import INTEGRATORS, SIZE, Slot, by_kind, entries, rates
from kane.program import aligned, entry, hoisted, wide_entry


def spring(events=lambda q: ()):
    """q'' = −q with q = cos t."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    p = O.at("P", q * N.x)
    loads = [kn.Force(p, -q * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=loads, speeds="rates", events=events(q)))


def arguments(eom, settings, name, y, end, step, tolerance=1.0, samples=()):
    """What a kernel is given, and the compiled rates of one state; no step is longer than `step`."""
    integrator, routine = INTEGRATORS[name], eom.numeric(settings).routine(rates).flat
    y = np.append(y, 0.0)
    p = np.array([s.default for s in eom.parameters], dtype=float)
    told = {
        Slot.STEP: step,
        Slot.END: end,
        Slot.LONGEST: step,
        Slot.RTOL: tolerance,
        Slot.ATOL: tolerance,
        Slot.FRESH: 1.0,
    }
    s = np.zeros(SIZE)
    for place, value in told.items():
        s[place] = value
    n, count = len(y), len(samples)
    arrays = {"s": s, "y": y, "lag": np.zeros(n), "work": aligned(integrator.work(n)), "p": p}
    arrays |= {"r": np.zeros(integrator.width), "single_r": np.zeros(1), "hd": np.zeros(1)}
    arrays |= {"h": hoisted(routine, 0.0, y[:-1], p, np.zeros(0))}
    arrays |= {"times": np.append(samples, np.inf), "rows": np.zeros((max(count, 1), n))}
    numbers = {"n": n, "limit": 10**6, "samples": count}
    rhs = entry(routine) if integrator.width == 1 else wide_entry(routine, integrator.width)
    slopes = eom.numeric(settings).routine(entries).flat
    arrays["hj"] = hoisted(slopes, 0.0, y[:-1], p, np.zeros(0))
    return {
        **numbers,
        **arrays,
        **by_kind(eom),
        "driven": 0,
        "breakpoints": 0,
        "pauses": np.zeros(1),
        "control": rhs,
        "rhs": rhs,
        "drive": rhs,
        "single_drive": rhs,
        "long": 0,
        "jac": entry(slopes),
        "slopes": slopes,
        "along": rhs,
    }, routine


def languages(given, routine):
    """The arguments with the routine as NumPy, machine code and C take it."""
    code, n, lanes = given["rhs"], given["n"], len(given["r"])

    def rate(t, x, p, r, h, out):
        out[:n] = routine(float(t), x[: n - 1], p, None)

    def wide(t, x, p, r, h, out):
        states = x[: (n - 1) * lanes].reshape(-1, lanes).T.copy()
        out[: n * lanes] = np.array([routine(float(s), y, p, None) for s, y in zip(t, states, strict=False)]).T.reshape(
            -1
        )

    own = rate if lanes == 1 else wide
    jac = given["jac"]
    slopes = given["slopes"]

    def derivatives(t, x, p, r, h, out):
        out[: n * (n - 1)] = slopes(float(t), x[: n - 1], p, None).reshape(-1)

    routines = {"numpy": own, "llvm": code, "c": code.library.address(code.symbol)}
    of_slopes = {"numpy": derivatives, "llvm": jac, "c": jac.library.address(jac.symbol)}
    return given | dict.fromkeys(("rhs", "drive", "single_drive", "control", "along"), routines) | {"jac": of_slopes}
