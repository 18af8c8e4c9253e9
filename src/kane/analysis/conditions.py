# SPDX-License-Identifier: BSD-3-Clause
"""The conditions of an equilibrium or a steady motion, F(X) = 0, and their exact Jacobian in X = (q, u, a, inputs, parameters).

f = 0,   eᵀe = 1,   A u + b = 0,   u̇_I = 0,   q̇ = 0 of the coordinates that matter,   ȧ = 0 of the further states that do
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from kane.analysis.flow import Choice, Flow, flow_at
from kane.analysis.local import Slopes, Values, slopes_at, solver, values_at
from kane.analysis.magnitudes import magnitudes
from kane.analysis.state import State
from kane.analysis.steady import dependence, scaled
from kane.analysis.tangents import Perturbations, perturbations
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array, Mask
from kane.numeric.newton import close
from kane.numeric.sampling import draw
from kane.numeric.scale import UNRELATED

_NEAR = (3, 8)
"""Seeds of the states near the start at which it is asked what depends on what."""
_ROUNDS = 3
"""Times that sizes of what moves and of what must vanish follow from each other."""


class Sizes(NamedTuple):
    """The sizes of the terms of F; of F and X where both move as far as they do together, `rows` and `columns`."""

    terms: Array
    rows: Array
    columns: Array


@dataclass(frozen=True, slots=True, eq=False)
class Conditions:
    """F and ∂F/∂X; `symbols` names X; rates must vanish of the perturbations `constant`, the speeds `steady`, the states `further`.

    Dependent speeds that follow from what matters are among `steady`: at a dead centre the acceleration of the independent ones alone
    may vanish though nothing is at rest.
    """

    numeric: Numeric[Equations]
    t: float
    symbols: tuple[Symbol, ...]
    constant: tuple[int, ...]
    steady: tuple[int, ...]
    further: tuple[int, ...] = ()
    constraints_only: bool = False

    @property
    def eom(self) -> Equations:
        """The equations."""
        return self.numeric.equations

    @property
    def perturbed(self) -> Perturbations:
        """The perturbations of the coordinates."""
        return self.numeric.value(perturbations)

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

    def state(self, x: Array) -> State:
        """The state at X."""
        eom = self.eom
        at = np.cumsum([len(eom.state), len(eom.inputs)])
        own, r, p = np.split(x, at)
        return State(self.t, own, p, r)

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """F and ∂F/∂X."""
        values, z, first, second, solve = self._numbers(x)
        places, slopes = self._places(x, values, first, second)
        f, j = list(places), list(slopes)
        if not self.constraints_only:
            plain, n = list(self.perturbed.coordinates), len(self.eom.speeds)
            rates = np.append(values.rates[plain], values.spins)
            moved = np.vstack([_both("rates", first, second)[plain], _both("spins", first, second)])
            free = list(self.steady)
            further = list(self.further)
            f += [rates[list(self.constant)], z[:n][free], values.states[further]]
            j += [moved[list(self.constant)], -solve(_both("residual", first, second))[:n][free]]
            j.append(_both("states", first, second)[further])
        return np.concatenate(f), np.vstack(j)

    def sizes(self, x: Array) -> Sizes:
        """How large the terms of F are at X, and what steps from there are measured by."""
        values, z, first, second, solve = self._numbers(x)
        nq, n = len(self.eom.coordinates), len(self.eom.speeds)
        size = magnitudes(values, first, z, x[nq : nq + n])
        plain = list(self.perturbed.coordinates)
        held = [values.configuration_terms, np.ones(len(self.perturbed.sets)), size.motion]
        _, slopes = self._places(x, values, first, second)
        terms = np.concatenate([*held, size.rates[plain], size.spins, size.accelerations, values.state_terms])
        own = [_both("rates", first, second)[plain], _both("spins", first, second)]
        residual = _both("residual", first, second)
        pushed = np.maximum(np.abs(size.inverse @ residual[:n]), np.abs(solve(residual)[:n]))
        j = np.abs(np.vstack([*slopes, *own, pushed, _both("states", first, second)]))
        start, states = sum(map(len, held)), len(values.states)
        moved = [*(i - n for i in self.steady), *self.further]
        rest = [] if self.constraints_only else [*self.constant, *(len(terms) - states - start + i for i in moved)]
        taken = [*range(start), *(start + i for i in rest)]
        least = np.zeros(len(x))
        least[nq : nq + n] = size.alone
        rows, columns = _steps(terms, j, least)
        return Sizes(np.where(terms > 0, terms, rows)[taken], rows[taken], columns)

    def _numbers(self, x: Array) -> tuple[Values, Array, Slopes, Slopes | None, Callable[[Array], Array]]:
        """What stands in the equations at X, z (zero for constraints alone), the derivatives, and what solves for z."""
        eom, state = self.eom, self.state(x)
        values = values_at(self.numeric, state)
        solve = np.zeros_like if self.constraints_only else solver(eom, values, state)
        z = solve(values.right)
        first = slopes_at(self.numeric, state, z)
        return values, z, first, slopes_at(self.numeric, state, z, *eom.parameters) if eom.parameters else None, solve

    def _places(
        self, x: Array, values: Values, first: Slopes, second: Slopes | None
    ) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """f, eᵀe − 1, A u + b and their derivatives."""
        sets = self.perturbed.sets
        norms, norm_slopes = np.zeros(len(sets)), np.zeros((len(sets), len(x)))
        for k, places in enumerate(sets):
            e = x[list(places)]
            norms[k], norm_slopes[k, list(places)] = e @ e - 1.0, 2 * e
        f = values.configuration, norms, values.motion
        return f, (_both("configuration", first, second), norm_slopes, _both("motion", first, second))


def _steps(terms: Array, j: Array, least: Array) -> tuple[Array, Array]:
    """Sizes of f with `terms` (m) and slopes of the size `j` (m × n), and of x, no smaller than the `least`; 1 where nothing tells.

    An x has the size that changes some terms by theirs. Such changes make terms in other f, which are small where the motion is
    straight or at rest, and let others move further.
    """
    rows, columns = terms, np.zeros(len(least))
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where((j > 0) & (rows[:, None] > 0), rows[:, None] / j, np.inf).min(axis=0, initial=np.inf)
        columns = np.maximum(np.where(np.isfinite(reach), reach, 0.0), least)
        columns = np.where(columns > 0, columns, 1.0)
        rows = np.maximum(rows, (j * columns).max(axis=1, initial=0))
    return np.where(rows > 0, rows, 1.0), columns


def _both(name: str, first: Slopes, second: Slopes | None) -> Array:
    """Derivatives in q, u, a and inputs, then those in parameters."""
    left: Array = getattr(first, name)
    return np.hstack([left, getattr(second, name)]) if second is not None else left


def _unit(s: Symbol | None) -> str:
    return f"{s.unit}/s" if s is not None and s.unit else ""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """F over the sizes of its `rows` and ∂F/∂Y, of Y = X over the sizes of its `columns`: the same in any units."""

    conditions: Conditions
    rows: Array
    columns: Array

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """F and ∂F/∂Y."""
        f, j = self.conditions(y * self.columns)
        return f / self.rows, j * self.columns / self.rows[:, None]


def conditions(
    numeric: Numeric[Equations], t: float, start: Array, choice: Choice, moving: Sequence[str]
) -> Conditions:
    """The conditions that apply: coordinates on which no speed depends near the start may move, and so may `moving`."""
    eom = numeric.equations
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    bare = Conditions(numeric, t, symbols, (), (), constraints_only=True)
    placed, width = len(eom.coordinates) + len(eom.speeds), len(eom.state)
    constant: set[int] = set()
    further: set[int] = set()
    steady = set(range(len(eom.speeds)))
    _, rows, columns = bare.sizes(start)
    measured = Measured(bare, rows, columns)
    for seed in _NEAR:
        y = start / columns
        y[:width] += [draw(seed, s, -0.1, 0.1) for s in symbols[:width]]
        if eom.constraints.constraints or bare.perturbed.sets:
            y = close(measured, y, range(placed)).x
        flow = flow_at(numeric, bare.state(y * columns), choice)
        if not choice.u:
            flow = freest(flow)
            choice = flow.choice
        tangent, every = flow.tangents, _matter(flow)
        matters = every[: flow.counts[0]]
        further |= set(np.flatnonzero(every[flow.counts[1] :]).tolist())
        constant |= {i for i, m in zip(tangent.free_q, matters, strict=True) if m}
        by_cyclic = np.abs(tangent.e[:, ~matters]).max(axis=1, initial=0)
        steady -= set(np.flatnonzero(by_cyclic > UNRELATED * np.abs(tangent.e).max(initial=0)).tolist())
    return Conditions(
        numeric,
        t,
        symbols,
        tuple(sorted(i for i in constant if bare.perturbed.names[i] not in moving)),
        tuple(sorted(i for i in steady if eom.speeds[i].name not in moving)),
        tuple(sorted(i for i in further if eom.states[i].name not in moving)),
    )


def freest(flow: Flow) -> Flow:
    """The same with those dependent speeds, exchanged one by one, with which the fewest coordinates matter to the independent ones.

    Along a frame that spins the speeds of a contact change in a steady motion, and where one of them is independent the spin matters.
    """
    count = len(flow.numeric.equations.speeds)
    least = int(_matter(flow)[: flow.counts[0]].sum())
    again = True
    while again and least:
        again = False
        free = flow.tangents.free_u
        dependent = [i for i in range(count) if i not in free]
        for i, d in product(free, dependent):
            choice = Choice(flow.choice.q, (i, *(k for k in dependent if k != d)))
            other = flow_at(flow.numeric, flow.state, choice)
            fewer = int(_matter(other)[: other.counts[0]].sum())
            if fewer < least:
                flow, least, again = other, fewer, True
                break
    return flow


def _matter(flow: Flow) -> Mask:
    """Which of the independent coordinates, speeds and further states matter to the speeds."""
    return dependence(scaled(flow.a, flow), *flow.counts)
