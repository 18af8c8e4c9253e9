# SPDX-License-Identifier: BSD-3-Clause
"""The conditions F of steady motions and their exact derivatives in X = (q, u, a, inputs, p), with scaling of both.

f = 0,  eᵀe = 1,  A u + b = 0,  u̇_I = 0,  q̇ = 0 for coordinates and ȧ = 0 for further states that affect the speeds
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.analysis.flow import Perturbations, magnitudes, perturbations, share
from kane.analysis.local import Slopes, Values, coded, quick_solver, slopes_at, solver, values_at
from kane.analysis.state_checks import StateArrays, open_shares
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.units import parse

_ROUNDS = 3
"""Iterations of the sizes of X and F, which depend on each other."""


class Applying(NamedTuple):
    """Indices of the perturbations, speeds and further states whose rates must vanish."""

    constant: tuple[int, ...]
    steady: tuple[int, ...]
    further: tuple[int, ...]


class Sizes(NamedTuple):
    """The sizes of the terms of F, and the scales `rows` of F and `columns` of X."""

    terms: Array
    rows: Array
    columns: Array


@dataclass(frozen=True, slots=True, eq=False)
class Conditions:
    """F and ∂F/∂X; `symbols` names X; the rates of perturbations `constant`, speeds `steady` and states `further` must vanish.

    `steady` includes dependent speeds that follow from affecting coordinates: at a dead centre the acceleration of independent speeds
    may vanish although the motion is not steady. `quick` omits rank tests, near states where the equations are known to be regular.
    """

    numeric: Numeric[Equations]
    t: float
    symbols: tuple[Symbol, ...]
    constant: tuple[int, ...]
    steady: tuple[int, ...]
    further: tuple[int, ...] = ()
    constraints_only: bool = False
    quick: bool = False

    @property
    def eom(self) -> Equations:
        """The equations of motion."""
        return self.numeric.equations

    @property
    def perturbed(self) -> Perturbations:
        """The perturbations of the coordinates."""
        return self.numeric.value(perturbations)

    @property
    def applying(self) -> Applying:
        """Which rates must vanish."""
        return Applying(self.constant, self.steady, self.further)

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """A name and a unit for each condition."""
        eom, perturbed = self.eom, self.perturbed
        held = [c.name for c in eom.system.holonomic], [c.name for c in eom.constraints.constraints]
        labels = [(n, "") for n in held[0]] + [("unit length of Euler parameters", "")] * len(perturbed.sets)
        labels += [(n, "") for n in held[1]]
        if self.constraints_only:
            return tuple(labels)
        labels += [(f"{perturbed.names[i]}'", _unit(perturbed.symbols[i])) for i in self.constant]
        moved = [*(eom.speeds[i] for i in self.steady), *(eom.states[i] for i in self.further)]
        return (*labels, *((f"{s.name}'", _unit(s)) for s in moved))

    def state(self, x: Array) -> StateArrays:
        """The state at X."""
        eom = self.eom
        at = np.cumsum([len(eom.state), len(eom.inputs)])
        own, r, p = np.split(x, at)
        return StateArrays(self.t, own, p, r)

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """F and ∂F/∂X."""
        values, z, slopes, solve = self.numbers(x)
        places, held = self._residuals(x, values, slopes)
        f, j = list(places), list(held)
        if not self.constraints_only:
            plain, n = list(self.perturbed.coordinates), len(self.eom.speeds)
            rates = np.append(values.rates[plain], values.spins)
            moved = np.vstack([slopes.rates[plain], slopes.spins])
            free = list(self.steady)
            further = list(self.further)
            f += [rates[list(self.constant)], z[:n][free], values.states[further]]
            j += [moved[list(self.constant)], -solve(slopes.residual)[:n][free], slopes.states[further]]
        return np.concatenate(f), np.vstack(j)

    def sizes(self, x: Array, ranges: Mapping[int, float] | None = None) -> Sizes:
        """The sizes of the terms of F at X, and the scales of F and X; `ranges`: by how much entries of X are going to vary."""
        values, z, slopes, solve = self.numbers(x)
        nq, n = len(self.eom.coordinates), len(self.eom.speeds)
        size = magnitudes(self.eom, values, slopes, z, self.state(x))
        plain = list(self.perturbed.coordinates)
        held = [values.configuration_terms, np.ones(len(self.perturbed.sets)), size.motion]
        terms = np.concatenate([*held, size.rates[plain], size.spins, size.accelerations, values.state_terms])
        pushed = np.maximum(np.abs(size.inverse @ slopes.residual[:n]), np.abs(solve(slopes.residual)[:n]))
        moved = self._residuals(x, values, slopes)[1]
        j = np.abs(np.vstack([*moved, slopes.rates[plain], slopes.spins, pushed, slopes.states]))
        start, states = sum(map(len, held)), len(values.states)
        changed = [*(i - n for i in self.steady), *self.further]
        rest = [] if self.constraints_only else [*self.constant, *(len(terms) - states - start + i for i in changed)]
        taken = [*range(start), *(start + i for i in rest)]
        least = np.zeros(len(x))
        least[nq : nq + n] = size.alone
        for i, length in (ranges or {}).items():
            least[i] = max(least[i], length)
        rows, columns = _steps(terms, j, least, self._alike(size.alike))
        return Sizes(np.where(terms > 0, terms, rows)[taken], rows[taken], columns)

    def _alike(self, changes: Array) -> Array:
        """Changes of q and u at one energy as sizes of X, zero for the rest; no angle is larger than 1 or, without any, no entry."""
        angles = [i for i, q in enumerate(self.eom.coordinates) if q.unit and parse(q.unit).is_bare]
        result = np.zeros(len(self.symbols))
        result[: len(changes)] = changes / ((changes[angles] if angles else changes).max(initial=0) or 1.0)
        return result

    def numbers(self, x: Array) -> tuple[Values, Array, Slopes, Callable[[Array], Array]]:
        """The values at X, z (zero for constraints alone), their derivatives, and the function that solves for z."""
        eom, state, run = self.eom, self.state(x), coded(self.numeric)
        values = values_at(run, state)
        solve = np.zeros_like if self.constraints_only else (quick_solver if self.quick else solver)(eom, values, state)
        z = solve(values.right)
        slopes = slopes_at(run, state, z)
        if eom.parameters:
            pairs = zip(slopes, slopes_at(run, state, z, *eom.parameters), strict=True)
            slopes = Slopes(*map(np.hstack, pairs))
        return values, z, slopes, solve

    def _residuals(self, x: Array, values: Values, slopes: Slopes) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """f, eᵀe − 1, A u + b and their derivatives."""
        sets = self.perturbed.sets
        norms, norm_slopes = np.zeros(len(sets)), np.zeros((len(sets), len(x)))
        for k, places in enumerate(sets):
            e = x[list(places)]
            norms[k], norm_slopes[k, list(places)] = e @ e - 1.0, 2 * e
        f = values.configuration, norms, values.motion
        return f, (slopes.configuration, norm_slopes, slopes.motion)


def _steps(terms: Array, j: Array, least: Array, alike: Array) -> tuple[Array, Array]:
    """Scales of f and x from the sizes of `terms` of f (m) and of ∂f/∂x, `j` (m × n); `least` bounds those of x.

    Those of x that nothing tells are `alike`, as at rest without loads, where all terms vanish, or 1 where that is zero.
    """
    rows, columns = _told(terms, j, least)
    untold = columns == 0
    rows, columns[untold] = _told(rows, j[:, untold], alike[untold])
    columns = np.where(columns > 0, columns, 1.0)
    rows = np.where(rows > 0, rows, (j * columns).max(axis=1, initial=0))
    return np.where(rows > 0, rows, 1.0), columns


def _told(terms: Array, j: Array, least: Array) -> tuple[Array, Array]:
    """The scales that follow from the terms, 0 for others.

    The scale of an x is the least change that alters an f by its scale. Such changes also enlarge the scales of other f, which are
    small for straight motions or at rest, and thereby those of other x.
    """
    rows, columns = terms, np.zeros(len(least))
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            reach = np.where((j > 0) & (rows[:, None] > 0), rows[:, None] / j, np.inf).min(axis=0, initial=np.inf)
        columns = np.maximum(np.where(np.isfinite(reach), reach, 0.0), least)
        rows = np.maximum(rows, (j * columns).max(axis=1, initial=0))
    return rows, columns


def _unit(s: Symbol | None) -> str:
    return f"{s.unit}/s" if s is not None and s.unit else ""


@dataclass(frozen=True, slots=True, eq=False)
class ScaledConditions:
    """F divided by the scales `rows`, and ∂F/∂Y, with Y = X[`places`] divided by the scales `columns`; both do not depend on units.

    The other X have their values at the `start`.
    """

    conditions: Conditions
    rows: Array
    columns: Array
    start: Array
    places: Sequence[int]

    def spread(self, y: Array) -> Array:
        """X from Y."""
        x = self.start.copy()
        x[list(self.places)] = y * self.columns
        return x

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """F and ∂F/∂Y."""
        f, j = self.conditions(self.spread(y))
        return f / self.rows, j[:, list(self.places)] * self.columns / self.rows[:, None]

    def last(self, y: Array) -> str:
        """The last entry of Y with its name, as text."""
        return f"{self.conditions.symbols[self.places[-1]].name} = {y[-1] * self.columns[-1]:.6g}"


@dataclass(frozen=True, slots=True, eq=False)
class SteadyProblem:
    """Conditions, a start X, and the indices of the entries of X that may change; `missing` are those without a guess.

    `measured` are the conditions scaled at the start.
    """

    conditions: Conditions
    start: Array
    free: tuple[int, ...]
    missing: tuple[int, ...]
    measured: ScaledConditions

    @property
    def mattering(self) -> tuple[int, ...]:
        """Indices of the entries of X that affect the conditions."""
        conditions = self.conditions
        perturbed, eom = conditions.perturbed, conditions.eom
        nq, n = len(eom.coordinates), len(eom.speeds)
        plain = len(perturbed.coordinates)
        own = [perturbed.coordinates[i] for i in conditions.constant if i < plain]
        steady = (*conditions.steady, *(n + i for i in conditions.further))
        return (*own, *(nq + i for i in steady), *range(len(eom.state), len(self.start)))


def shares(conditions: Conditions, x: Array) -> Array:
    """The residual of each condition as a fraction of the size of its terms."""
    f, held = conditions(x)[0], len(conditions.eom.system.holonomic)
    sizes = conditions.sizes(x).terms
    result = share(f, sizes)
    result[:held] = open_shares(conditions.eom, f[:held], sizes[:held], conditions.state(x).given(conditions.eom))
    return result
