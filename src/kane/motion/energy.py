# SPDX-License-Identifier: BSD-3-Clause
"""How well E − ∫P dt stayed constant, measured at every instant by what there is then.

A scale over the whole motion would hide behind one spike, as where two bodies all but collide, what is left wrong after it. So the
drift D(t) = E(t) − E(0) − ∫P dt is divided by the largest, at t, of K, |E − E(0)|, |∫P dt|, δE/rtol and the median of K
and of the change of V over a tenth of the motion about t, without which every rest on the way would count.
"""

from dataclasses import dataclass

import numpy as np

from kane.numeric.arrays import Array

_PARTS = 10
"""The scale of an instant is read off a window of this part of the motion on either side of it."""
_WINDOWS = 12
_STEPS, _DIGITS, _MOST = 1e3, 1e-5, 0.1
"""How many relative tolerances may be missed, and the shares of the scale below and above which none is asked for."""
_SHARP = 0.1
_ROUNDING = 64 * np.finfo(float).eps
"""Share of K and V that is left of their sum by rounding."""


@dataclass(frozen=True, slots=True)
class EnergyCheck:
    """How well E − ∫P dt stayed constant.

    `drift` is the largest |D| with D = E − E(0) − ∫P dt, `relative` the largest of |D| over the scale of its instant, and `at` that
    instant (s). `scale` is the largest, over the motion, of |E − E(0)|, K, |∫P dt| and δE/rtol. δE is what the absolute tolerance
    leaves open: the change of E with coordinates and speeds off by `atol`, one at a time.
    """

    drift: float
    scale: float
    relative: float
    at: float

    def exceeds(self, rtol: float) -> bool:
        """Whether it is more than steps of a tolerance leave, even many of them; the motion is wrong then, or was barely resolved."""
        return self.relative > min(max(_STEPS * rtol, _DIGITS), _MOST)

    def sharply(self, rtol: float) -> bool:
        """Whether it is so far within the limit that no other samples would change that."""
        return self.relative <= _SHARP * min(max(_STEPS * rtol, _DIGITS), _MOST)

    def __str__(self) -> str:
        return f"energy minus work constant to {self.drift:.2e} J ({self.relative:.1e} of what there is at t = {self.at:.4g} s)"


def energy_check(t: Array, kinetic: Array, total: Array, work: Array, open_: Array) -> EnergyCheck:
    """The check of K, E and ∫P dt at times t, all (n); `open_` (n) is δE/rtol."""
    with np.errstate(invalid="ignore"):  # at a pole of W there is no energy, and the check is NaN
        return _checked(t, kinetic, total, work, open_)


def _checked(t: Array, kinetic: Array, total: Array, work: Array, open_: Array) -> EnergyCheck:
    change = total - total[0]
    work = work - work[0]
    drift = np.abs(change - work)
    own = np.max([kinetic, np.abs(change), np.abs(work), open_], axis=0)
    terms = kinetic + np.abs(total - kinetic)
    counts = np.maximum(drift - _ROUNDING * (terms + terms[0]), 0.0)
    local = np.maximum(own, _usual(kinetic, total - kinetic))
    ratio = np.divide(counts, local, out=np.where(counts > 0, np.inf, 0.0), where=local > 0)
    worst = int(np.argmax(ratio))
    return EnergyCheck(float(drift.max()), float(own.max()), float(ratio[worst]), float(t[worst]))


def _usual(kinetic: Array, potential: Array) -> Array:
    """The median of the largest of K and |V − its median| about each instant (n)."""
    n = len(kinetic)
    centers = np.unique(np.linspace(0, n - 1, min(n, _WINDOWS)).astype(int))
    half = max(2, n // _PARTS)
    sizes = np.empty(len(centers))
    for k, i in enumerate(centers):
        about = slice(max(0, i - half), i + half + 1)
        v = potential[about]
        sizes[k] = np.median(np.maximum(kinetic[about], np.abs(v - np.median(v))))
    return np.interp(np.arange(n), centers, sizes)
