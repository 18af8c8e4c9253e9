# SPDX-License-Identifier: BSD-3-Clause
"""The conditions of an equilibrium or a steady motion, F(X) = 0, and their exact Jacobian in X = (q, u, inputs, parameters).

f = 0,   eᵀe = 1,   A u + b = 0,   u̇_I = 0,   q̇ = 0 of the coordinates that matter
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from kane.analysis.flow import Choice, Flow, flow_at
from kane.analysis.local import slopes_at, solver, values_at
from kane.analysis.state import State
from kane.analysis.steady import dependence, scaled
from kane.analysis.tangents import Perturbations, perturbations
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array, Mask
from kane.numeric.newton import close
from kane.numeric.sample import draw

_NEAR = (3, 8)
"""Seeds of the states near the start at which it is asked what depends on what."""
_LINK = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Conditions:
    """F and ∂F/∂X; `symbols` names X, `constant` are the perturbations whose rates must vanish, `steady` the speeds.

    Dependent speeds that follow from what matters are among `steady`: at a dead centre the acceleration of the independent ones alone
    may vanish though nothing is at rest.
    """

    numeric: Numeric[Equations]
    t: float
    symbols: tuple[Symbol, ...]
    constant: tuple[int, ...]
    steady: tuple[int, ...]
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
        return (*labels, *((f"{eom.speeds[i].name}'", _unit(eom.speeds[i])) for i in self.steady))

    def state(self, x: Array) -> State:
        """The state at X."""
        eom = self.eom
        at = np.cumsum([len(eom.coordinates) + len(eom.speeds), len(eom.inputs)])
        own, r, p = np.split(x, at)
        return State(self.t, own, p, r)

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """F and ∂F/∂X."""
        eom, perturbed, state = self.eom, self.perturbed, self.state(x)
        nq, n, wide = len(eom.coordinates), len(eom.speeds), len(x)
        values = values_at(self.numeric, state)
        if self.constraints_only:
            z = np.zeros(values.right.shape)
        else:
            solve = solver(eom, values)
            z = solve(values.right)
        first = slopes_at(self.numeric, state, z)
        second = slopes_at(self.numeric, state, z, *eom.parameters) if eom.parameters else None

        def both(name: str) -> Array:
            left: Array = getattr(first, name)
            return np.hstack([left, getattr(second, name)]) if second is not None else left

        norms, norm_slopes = np.zeros(len(perturbed.sets)), np.zeros((len(perturbed.sets), wide))
        for k, places in enumerate(perturbed.sets):
            e = x[list(places)]
            norms[k], norm_slopes[k, list(places)] = e @ e - 1.0, 2 * e
        f = [values.configuration, norms, values.motion]
        j = [both("configuration"), norm_slopes, both("motion")]
        if not self.constraints_only:
            plain = list(perturbed.coordinates)
            rates, moved = (
                np.append(values.rates[plain], values.spins),
                np.vstack([both("rates")[plain], both("spins")]),
            )
            free = list(self.steady)
            f += [rates[list(self.constant)], z[:n][free]]
            j += [moved[list(self.constant)], -solve(both("residual"))[:n][free]]
        assert nq + n + len(eom.inputs) + len(eom.parameters) == wide
        return np.concatenate(f), np.vstack(j)


def _unit(s: Symbol | None) -> str:
    return f"{s.unit}/s" if s is not None and s.unit else ""


def conditions(
    numeric: Numeric[Equations], t: float, start: Array, choice: Choice, moving: Sequence[str]
) -> Conditions:
    """The conditions that apply: coordinates on which no speed depends near the start may move, and so may `moving`."""
    eom = numeric.equations
    symbols: tuple[Symbol, ...] = (*eom.coordinates, *eom.speeds, *eom.inputs, *eom.parameters)
    bare = Conditions(numeric, t, symbols, (), (), constraints_only=True)
    nq, n = len(eom.coordinates), len(eom.speeds)
    constant: set[int] = set()
    steady = set(range(n))
    for seed in _NEAR:
        x = start.copy()
        x[: nq + n] += [draw(seed, s, -0.1, 0.1) for s in symbols[: nq + n]]
        if eom.constraints.constraints or bare.perturbed.sets:
            x = close(bare, x, range(nq + n)).x
        flow = flow_at(numeric, bare.state(x), choice)
        if not choice.u:
            flow = freest(flow)
            choice = flow.choice
        tangent, matters = flow.tangents, _matter(flow)
        constant |= {i for i, m in zip(tangent.free_q, matters, strict=True) if m}
        by_cyclic = np.abs(tangent.e[:, ~matters]).max(axis=1, initial=0)
        steady -= set(np.flatnonzero(by_cyclic > _LINK * np.abs(tangent.e).max(initial=0)).tolist())
    return Conditions(
        numeric,
        t,
        symbols,
        tuple(sorted(i for i in constant if bare.perturbed.names[i] not in moving)),
        tuple(sorted(i for i in steady if eom.speeds[i].name not in moving)),
    )


def freest(flow: Flow) -> Flow:
    """The same with those dependent speeds, exchanged one by one, with which the fewest coordinates matter to the independent ones.

    Along a frame that spins the speeds of a contact change in a steady motion, and where one of them is independent the spin matters.
    """
    count = len(flow.numeric.equations.speeds)
    least = int(_matter(flow).sum())
    again = True
    while again and least:
        again = False
        free = flow.tangents.free_u
        dependent = [i for i in range(count) if i not in free]
        for i, d in product(free, dependent):
            choice = Choice(flow.choice.q, (i, *(k for k in dependent if k != d)))
            other = flow_at(flow.numeric, flow.state, choice)
            fewer = int(_matter(other).sum())
            if fewer < least:
                flow, least, again = other, fewer, True
                break
    return flow


def _matter(flow: Flow) -> Mask:
    """Which of the independent coordinates matter to the speeds."""
    count = len(flow.tangents.free_q)
    return dependence(scaled(flow.a, flow), count)[:count]
