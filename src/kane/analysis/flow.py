# SPDX-License-Identifier: BSD-3-Clause
"""The flow on the constraints at a state, and its exact derivative: ẋ = F(x, r) in x = (ξ_I, u_I, a).

δẋ = A δx + B δr,   y = h(q, u, u̇, λ, R, r):   δy = C δx + D δr
"""

from dataclasses import dataclass

import numpy as np

from kane.analysis.local import Slopes, Values, solver
from kane.analysis.magnitudes import Magnitudes, magnitudes
from kane.analysis.numbers import Coded, Numbers
from kane.analysis.outputs import Outputs
from kane.analysis.state import State
from kane.analysis.tangents import Tangents, in_numbers, perturbations, spread, tangents, turning_rates
from kane.dynamics.constraints.partition import quality
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.numeric.arrays import Array
from kane.numeric.projection import mobility, sizes
from kane.numeric.scale import POOR


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """Which perturbations and speeds are to be dependent, as far as the constraints determine them."""

    q: tuple[int, ...] = ()
    u: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """F, A, B at a state. `rest` is F, `mass` the mass matrix of the independent speeds, `moves` δ(q, u, a, r) of δ(ξ_I, u_I, a, r).

    `terms` are the sizes of the terms of F. `scale` says how far equal energies move each x, in the time 1/`pace`: D⁻¹ A D with the
    diagonal D is the same in any units. `answers` is δ(u̇, λ, R) of the same; all is read off `numbers`.
    """

    numeric: Numeric[Equations]
    numbers: Numbers
    state: State
    choice: Choice
    values: Values
    slopes: Slopes
    z: Array
    tangents: Tangents
    rest: Array
    a: Array
    b: Array
    mass: Array
    moves: Array
    answers: Array
    magnitudes: Magnitudes
    terms: Array
    scale: Array

    @property
    def states(self) -> tuple[str, ...]:
        """The names of x."""
        names, speeds = self.numeric.value(perturbations).names, self.numeric.equations.speeds
        own = (*(names[i] for i in self.tangents.free_q), *(speeds[i].name for i in self.tangents.free_u))
        return (*own, *(a.name for a in self.numeric.equations.states))

    @property
    def counts(self) -> tuple[int, int]:
        """How many of x are coordinates, and how many of them and of speeds."""
        count = len(self.tangents.free_q)
        return count, count + len(self.tangents.free_u)


@np.errstate(invalid="ignore")
def flow_at(numeric: Numeric[Equations], state: State, choice: Choice, numbers: Numbers | None = None) -> Flow:
    """F and its derivatives at a state on the constraints, from compiled code unless other `numbers` are given."""
    numbers = numbers or Coded(numeric)
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    nq, n = len(eom.coordinates), len(eom.speeds)
    values = numbers.values(state)
    solve = solver(eom, values, state)
    z = solve(values.right)
    slopes = numbers.slopes(state, z)
    held = values.constraints(n)
    m = values.matrix[:n, :n]
    given_u = choice.u or _own(eom, held, m)
    t, plain = spread(perturbed, state.x[:nq]), list(perturbed.coordinates)

    def by_xi(slope: Array) -> Array:
        return np.hstack([slope[:, :nq] @ t, slope[:, nq:]])

    rates, rate_slopes = np.append(values.rates[plain], values.spins), np.vstack([slopes.rates[plain], slopes.spins])
    width, root = t.shape[1], mobility(m, held)
    tangent = tangents(
        by_xi(slopes.configuration),
        by_xi(slopes.motion),
        width,
        n,
        in_numbers(rate_slopes[:, nq : nq + n] @ root, choice.q),
        in_numbers(root, given_u),
    )
    moves = np.vstack([t @ tangent.moves[:width], tangent.moves[width:]])
    answers = -solve(slopes.residual @ moves)
    own = rate_slopes @ moves - turning_rates(rates, len(plain)) @ tangent.moves[:width]
    # to the constraints a are given, as inputs are: they come before these
    free_q, free_u = list(tangent.free_q), list(tangent.free_u)
    rows = np.vstack([own[free_q], answers[:n][free_u], slopes.states @ moves])
    rest = np.concatenate([rates[free_q], z[:n][free_u], values.states])
    mass = tangent.b.T @ m @ tangent.b
    a, b = rows[:, : len(rows)], rows[:, len(rows) :]
    size = magnitudes(values, slopes, z, state.x[nq : nq + n])
    terms, far = np.append(size.rates[plain], size.spins), np.linalg.norm(rate_slopes[:, nq : nq + n] @ root, axis=1)
    terms = np.concatenate([terms[free_q], size.accelerations[free_u], values.state_terms])
    scale = np.append(far[free_q] / (size.pace or 1.0), np.linalg.norm(root, axis=1)[free_u])
    scale = _with_states(scale, a, size.pace or 1.0)
    return Flow(
        numeric,
        numbers,
        state,
        choice,
        values,
        slopes,
        z,
        tangent,
        rest,
        a,
        b,
        mass,
        moves,
        answers,
        size,
        terms,
        scale,
    )


def _with_states(scale: Array, a: Array, pace: float) -> Array:
    """The scale of q and u, and of the further states behind them: what changes another by its scale in the time 1/pace.

    Those by which nothing else changes have the scale to which they change themselves.
    """
    if len(scale) == len(a):
        return scale
    whole, slopes = np.append(scale, np.zeros(len(a) - len(scale))), np.abs(a)
    for _ in range(len(scale), len(a)):
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (whole * pace / slopes.T)[:, whole > 0].min(axis=1, initial=np.inf)
        whole = np.where(whole > 0, whole, np.where(np.isfinite(reach), reach, 0.0))
    driven = slopes @ whole / pace
    whole = np.where(whole > 0, whole, driven)
    return np.where(whole > 0, whole, 1.0)


def _own(eom: Equations, a: Array, m: Array) -> tuple[int, ...]:
    """The dependent speeds of the equations, where they are well determined."""
    if eom.embedding is None:
        return ()
    partition = eom.embedding.partition
    return partition.dependent if quality(a, partition, sizes(a, mobility(m, a))) > POOR else ()


def output_slopes(flow: Flow, outputs: Outputs) -> tuple[Array, Array]:
    """(h, δh of δ(ξ_I, u_I, a, r)) at the state."""
    if not outputs.roots:
        return np.zeros(0), np.zeros((0, flow.moves.shape[1]))
    found = flow.numbers.answers(flow.state, flow.z, outputs)
    return found.values, found.slopes @ np.vstack([flow.moves, flow.answers])
