# SPDX-License-Identifier: BSD-3-Clause
"""Checks of quantities that should be constant along a motion, E − ∫P dt and other integrals; and the work of each load.

The drift D(t) = E(t) − E(0) − ∫P dt is compared with the energies at the same instant: a scale for the whole motion would be set by
one spike, as in a near collision of two bodies, and hide errors that remain after it. The scale is the largest, at t, of K,
|E − E(0)|, |∫P dt|, δE/rtol, and the median of K and of the change of V over a tenth of the motion about t; without the median every
instant of rest would be reported.

Errors of ∫P dt add up over a long motion, while dampers reduce those of the state; and they remain where loads have supplied an
energy and removed it again. Therefore D(t) is divided by a hundredth of the energy that dampers have taken, or of the range of
∫P dt so far, if that is larger than the scale; the change of D between samples is not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived
from kane.dynamics.readings.energy import Integral, depends_on_time
from kane.dynamics.readings.quantities import asked
from kane.errors import ArgumentError, Attributes, cut, warn
from kane.expect import is_list
from kane.expr.node import Expr
from kane.expr.ops import Immutable
from kane.expr.regular import Sizes, size
from kane.model.loads import Load
from kane.motion.solution.phases import Indices, leaps
from kane.numeric.arrays import Array, Mask, distinct, median
from kane.numeric.scale import EPS

_PARTS = 10
"""The median at an instant is taken over this part of the motion on either side of it."""
_WINDOWS = 12
_STEPS, _DIGITS, _MOST = 1e3, 1e-5, 0.1
"""The limit of the relative drift in relative tolerances, and the least and largest value of this limit."""
_SHARP = 0.1
_TAKEN, _SURE = 0.01, 20
"""Share of the work done that D(t) is compared with; least number of samples that distinguish a damper from a spring."""
FEW = 25
"""Largest number of samples at which δE is evaluated."""
_ROUNDING = 64 * EPS
"""Rounding error of the energy relative to K and V."""


@dataclass(frozen=True, slots=True)
class EnergyCheck(Attributes):
    """The energy balance of a motion: how constant E − ∫P dt is.

    `drift` (J) is the largest |D|, D = E − E(0) − ∫P dt. `relative` is the largest of |D| over the scale at its instant, or over a
    hundredth of the energy taken or exchanged, and of the change of D between samples over the scale alone; `at` is its time (s).
    `scale` (J) is the largest, over the motion, of |E − E(0)|, K, |∫P dt| and δE/rtol, where δE is the change of E if coordinates
    and speeds change by `atol`, one at a time.
    """

    drift: float
    scale: float
    relative: float
    at: float

    def exceeds(self, rtol: float) -> bool:
        """Whether the drift exceeds the accumulated errors of steps at a tolerance: the motion is then wrong or poorly resolved."""
        return self.relative > _limit(rtol)

    def surely_within(self, rtol: float, whole: bool = False) -> bool:
        """Whether the drift is within the limit with a margin for instants between samples; with `whole`, without the margin."""
        return self.relative <= (1.0 if whole else _SHARP) * _limit(rtol)

    def __str__(self) -> str:
        return f"energy minus work constant to {self.drift:.2e} J ({self.relative:.1e} of the energy present at t = {self.at:.4g} s)"


def _limit(rtol: float) -> float:
    return min(max(_STEPS * rtol, _DIGITS), _MOST)


def keeps_sharply(kinetic: Array, total: Array, work: Array, rtol: float, whole: bool = False) -> Mask:
    """Whether `energy_check` of K, E and ∫P dt, all (… × n), is certainly within the limit by its terms K and |E − E(0)| alone.

    There is a margin for instants between samples, unless these are the samples of the `whole` motion.
    """
    change = total - total[..., :1]
    drift = np.abs(change - work)
    allowed = ((1.0 if whole else _SHARP) * _limit(rtol) / 2) * np.maximum(
        kinetic, np.abs(change)
    )  # half the limit, as a step of D has two ends
    return np.asarray((drift <= allowed).all(axis=-1) & (drift[..., :-1] <= allowed[..., 1:]).all(axis=-1))


def surely_keeps(t: Array, kinetic: Array, total: Array, work: Array, rtol: float, whole: bool) -> bool:
    """Whether the check of K, E and ∫P dt, all (n), passes without the terms for absolute tolerances and dampers."""
    if keeps_sharply(kinetic, total, work - work[0], rtol, whole):
        return True
    return energy_check(t, kinetic, total, work, np.zeros(len(t))).surely_within(rtol, whole)


@np.errstate(invalid="ignore")  # at a pole of W the energy is NaN, and so is the check
def energy_check(
    t: Array, kinetic: Array, total: Array, work: Array, open_: Array, powers: Sequence[Array] = ()
) -> EnergyCheck:
    """The check of K, E and ∫P dt at times t, all (n); `open_` (n) is δE/rtol, `powers` those of loads without potential, each (n)."""
    change = total - total[0]
    work = work - work[0]
    gone = change - work
    drift = np.abs(gone)
    own = np.max([kinetic, np.abs(change), np.abs(work), open_], axis=0)
    terms = kinetic + np.abs(total - kinetic)
    rounding = _ROUNDING * (terms + terms[0])
    local = np.maximum(own, _usual(kinetic, total - kinetic))
    exchanged = np.maximum.accumulate(work) - np.minimum.accumulate(work)
    ratio = _ratio(drift - rounding, np.maximum(local, _TAKEN * np.maximum(taken(t, powers), exchanged)))
    ratio[1:] = np.maximum(ratio[1:], _ratio(np.abs(np.diff(gone)) - rounding[1:] - rounding[:-1], local[1:]))
    worst = int(np.argmax(ratio))
    return EnergyCheck(float(drift.max()), float(own.max()), float(ratio[worst]), float(t[worst]))


def opened(energies: Array) -> Array:
    """δE (n) from energies at the state, with each component of x increased, and with each decreased ((1 + 2 x) × n)."""
    up, down = np.split(np.abs(energies[1:] - energies[0]), 2)
    return np.asarray(np.maximum(up, down).sum(axis=0))


def taken(t: Array, powers: Sequence[Array]) -> Array:
    """The energy (n) taken up to times t (n) by loads whose powers, each (n), are never positive: dampers, friction, drag."""
    result = np.zeros(len(t))
    for power in powers if len(t) >= _SURE else ():
        size = -np.nan_to_num(power, posinf=0.0, neginf=0.0)
        if size.min() >= -_ROUNDING * size.max():
            result[1:] += np.cumsum(np.diff(t) * (size[1:] + size[:-1]) / 2)
    return result


def _ratio(drift: Array, scale: Array) -> Array:
    counts = np.maximum(drift, 0.0)
    return np.divide(counts, scale, out=np.where(counts > 0, np.inf, 0.0), where=scale > 0)


def _usual(kinetic: Array, potential: Array) -> Array:
    """The median of max(K, |V − median of V|) over a window about each instant (n)."""
    n = len(kinetic)
    centers = distinct(np.linspace(0, n - 1, min(n, _WINDOWS)).astype(int))
    half = max(2, n // _PARTS)
    sizes = np.empty(len(centers))
    for k, i in enumerate(centers):
        about = slice(max(0, i - half), i + half + 1)
        v = potential[about]
        sizes[k] = median(np.maximum(kinetic[about], np.abs(v - median(v))))
    return np.interp(np.arange(n), centers, sizes)


LIMIT = 1000
"""Largest drift in relative tolerances that is attributed to the integration, as for the energy."""


@dataclass(frozen=True, slots=True, eq=False)
class Drift(Immutable):
    """The drift of an integral of the motion, or of another expression that should be constant, from its initial value.

    Attributes
    ----------
    name : name of the integral, or the expression as text
    values : values along the motion (n)
    drift : the largest change, in the unit of the expression
    relative : `drift` over the largest magnitude of the terms of the expression along the motion
    at : the time of the largest change (s)
    """

    name: str
    values: Array
    drift: float
    relative: float
    at: float

    def __repr__(self) -> str:
        return f"Drift({self.name}: {self.drift:.3g}, {self.relative:.1g} of its terms, at t = {self.at:.4g} s)"


Functions = tuple[tuple[str, Expr], ...]


def checking_functions(derived: Derived, functions: Sequence[Any]) -> Functions:
    """The functions, each with its name, checked before a motion runs.

    Raises
    ------
    ArgumentError
        if they are not a list of integrals and expressions
    """
    if isinstance(functions, Integral | Expr) or not is_list(functions):
        raise ArgumentError(
            f"Expected a list of integrals or expressions to check, got {cut(repr(functions))}. Write […]."
        )
    wanted = [(f.name, f.value) if isinstance(f, Integral) else (cut(f), f) for f in functions]
    wrong = [name for name, f in wanted if not isinstance(f, Expr)]
    if wrong:
        raise ArgumentError(
            f"Expected integrals or expressions to check, got {wrong[0]}. Use those of eom.integrals, or write them in the "
            "system's symbols."
        )
    asked(derived, [f for _, f in wanted])
    return tuple(wanted)


def drifts(
    t: Array, functions: Functions, values: Callable[[list[Expr]], list[Array]], begins: Indices
) -> tuple[Drift, ...]:
    """The drift of each function, from the values of expressions along a motion; jumps where phases begin do not count."""
    memo: Sizes = {}
    roots = [f for _, f in functions]
    tables = values([*roots, *(size(e, memo) for e in roots)])
    return tuple(
        _drift(t, name, values_, sizes, begins)
        for (name, _), (values_, sizes) in zip(functions, zip(*np.split(np.array(tables), 2), strict=True), strict=True)
    )


def check_drifts(found: Sequence[Drift], rtol: float) -> None:
    """Warn of a function whose drift errors of the integration do not explain."""
    worst = max(found, key=lambda d: d.relative, default=None)
    if worst is not None and not worst.relative <= LIMIT * rtol:
        warn(
            f"Expected {worst.name} constant along the motion, got a change of {worst.drift:.3g}, {worst.relative:.1g} of its "
            f"terms, at t = {worst.at:.4g} s. Tighten rtol= and atol=, or check that it is an integral of these equations: "
            "eom.integrals lists them."
        )


def _drift(t: Array, name: str, values: Array, sizes: Array, begins: Indices) -> Drift:
    change = np.abs(values - values[0] - leaps(values, begins))
    k = int(np.nanargmax(change)) if np.isfinite(change).any() else 0
    whole = float(np.nanmax(np.abs(sizes), initial=0.0))
    most = float(change[k])
    return Drift(name, values, most, most / whole if whole else most, float(t[k]))


_LEAST = 4
"""Least number of samples for a cubic spline."""


def work_of(
    load: Load, power: Expr, t: Array, values: Callable[[Sequence[Expr]], list[Array]], runs: Sequence[Any]
) -> Array:
    """The work since the start (n), from the values of expressions along a motion; `runs` are the samples of its phases."""
    held = load.potential is not None and not depends_on_time(load.potential)
    (own,) = values([load.potential if held and load.potential is not None else power])
    return by_runs(t, own, runs, (lambda _, v: v[0] - v) if held else integral)


def by_runs(t: Array, values: Array, runs: Sequence[Any], of: Callable[[Array, Array], Array]) -> Array:
    """A function of the times and values of each of `runs`, zero where these begin, continued from one to the next (n)."""
    result, done = np.empty(len(t)), 0.0
    for at in runs:
        result[at] = done + of(t[at], values[at])
        done = result[at[-1]]
    return result


def integral(t: Array, power: Array) -> Array:
    """∫P dt (n) from the values of P, by a cubic spline."""
    from scipy.interpolate import CubicSpline  # slow to import

    if len(t) < _LEAST:
        return np.append(0.0, np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(t)))
    whole = CubicSpline(t, power).antiderivative()
    return np.asarray(whole(t) - whole(t[0]))
