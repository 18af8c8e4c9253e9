# SPDX-License-Identifier: BSD-3-Clause
"""The flow on the constraints at a state, and its exact derivative: ẋ = F(x, r) in x = (ξ_I, u_I).

δẋ = A δx + B δr,   y = h(q, u, u̇, λ, R, r):   δy = C δx + D δr
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.local import Slopes, Values, slopes_at, solver, unknowns, values_at
from kane.analysis.magnitudes import Magnitudes, magnitudes
from kane.analysis.state import State
from kane.analysis.tangents import Tangents, in_numbers, perturbations, spread, tangents, turning_rates
from kane.dynamics.constraints.partition import POOR, quality
from kane.dynamics.readings.asked import asked
from kane.dynamics.readings.unsolved import partials
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.equations.routines import ports
from kane.errors import ArgumentError, ValueMissingError, cut
from kane.expr.evaluate import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import time
from kane.expr.visit import substitute
from kane.numeric.arrays import Array
from kane.numeric.projection import mobility, sizes
from kane.program.bundle import Bundle


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """Which perturbations and speeds are to be dependent, as far as the constraints determine them."""

    q: tuple[int, ...] = ()
    u: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """F, A, B at a state. `rest` is F, `mass` the mass matrix of the independent speeds, `moves` δ(q, u, r) of δ(ξ_I, u_I, r).

    `terms` are the sizes of the terms of F. `scale` says how far equal energies move each x, in the time 1/`pace`: D⁻¹ A D with the
    diagonal D is the same in any units.
    """

    numeric: Numeric[Equations]
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
        return (*(names[i] for i in self.tangents.free_q), *(speeds[i].name for i in self.tangents.free_u))


def flow_at(numeric: Numeric[Equations], state: State, choice: Choice) -> Flow:
    """F and its derivatives at a state on the constraints."""
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    nq, n = len(eom.coordinates), len(eom.speeds)
    values = values_at(numeric, state)
    solve = solver(eom, values)
    z = solve(values.right)
    slopes = slopes_at(numeric, state, z)
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
    rows = np.vstack([own[list(tangent.free_q)], answers[:n][list(tangent.free_u)]])
    rest = np.concatenate([rates[list(tangent.free_q)], z[:n][list(tangent.free_u)]])
    mass = tangent.b.T @ m @ tangent.b
    a, b = rows[:, : len(rows)], rows[:, len(rows) :]
    size = magnitudes(values, slopes, z, state.x[nq:])
    terms, far = np.append(size.rates[plain], size.spins), np.linalg.norm(rate_slopes[:, nq : nq + n] @ root, axis=1)
    terms = np.append(terms[list(tangent.free_q)], size.accelerations[list(tangent.free_u)])
    scale = np.append(
        far[list(tangent.free_q)] / (size.pace or 1.0), np.linalg.norm(root, axis=1)[list(tangent.free_u)]
    )
    return Flow(
        numeric, state, choice, values, slopes, z, tangent, rest, a, b, mass, moves, answers, size, terms, scale
    )


def _own(eom: Equations, a: Array, m: Array) -> tuple[int, ...]:
    """The dependent speeds of the equations, where they are well determined."""
    if eom.embedding is None:
        return ()
    partition = eom.embedding.partition
    return partition.dependent if quality(a, partition, sizes(a, mobility(m, a))) > POOR else ()


@dataclass(frozen=True, slots=True, eq=False)
class Outputs:
    """Named expressions of q, u, u̇, λ, R, inputs and t."""

    names: tuple[str, ...]
    roots: tuple[Expr, ...]


def outputs_of(eom: Equations, outputs: Mapping[str, Any] | Sequence[Any] | None) -> Outputs:
    """The outputs with every rate written in speeds; a sequence is named by its expressions."""
    if outputs is None:
        return Outputs((), ())
    pairs = outputs.items() if isinstance(outputs, Mapping) else [(e, e) for e in _listed(outputs)]
    names, roots = [], []
    for key, e in pairs:
        name = str(key)
        try:
            wanted = asked(eom.derived, e)
        except TypeError as error:
            raise ArgumentError(
                f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}."
            ) from error
        if wanted.shape not in ((), (3,)) or wanted.parts is not None:
            raise ArgumentError(f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}.")
        names += [f"{name}.{axis}" for axis in "xyz"] if wanted.shape else [name]
        roots += [substitute(eom.in_speeds(root), dict.fromkeys(eom.auxiliary_speeds, ZERO)) for root in wanted.roots]
    allowed = {time, *eom.coordinates, *eom.speeds, *eom.parameters, *eom.inputs, *unknowns(eom).symbols}
    unknown = [str(s) for s in free_symbols(roots) if s not in allowed]
    if unknown:
        raise ValueMissingError(
            f"Expected outputs in symbols of the system, got {', '.join(unknown)}. A reaction must be listed in System(reactions=…)."
        )
    return Outputs(tuple(names), tuple(roots))


def _listed(outputs: Any) -> Sequence[Any]:
    if isinstance(outputs, str | Expr) or not isinstance(outputs, Sequence):
        raise ArgumentError(f"Expected outputs as a list or a dict {{name: expression}}, got {cut(repr(outputs))}.")
    return outputs


class Answers(NamedTuple):
    """h, and ∂h/∂(q, u, r, z), a row for each output."""

    values: Array
    slopes: Array


def answers(eom: Equations, *roots: Expr) -> Bundle[Answers]:
    """Outputs h and their derivatives; z is an argument."""
    z = unknowns(eom)
    slopes = partials(roots, (*eom.coordinates, *eom.speeds, *eom.inputs, *z.symbols))
    return Bundle("outputs", (*ports(eom.derived), z), Answers, {"values": roots, "slopes": slopes})


def output_slopes(flow: Flow, outputs: Outputs) -> tuple[Array, Array]:
    """(h, δh of δ(ξ_I, u_I, r)) at the state."""
    if not outputs.roots:
        return np.zeros(0), np.zeros((0, flow.moves.shape[1]))
    state = flow.state
    found = flow.numeric.routine(answers, *outputs.roots)(state.t, state.x, state.p, state.r, flow.z)
    return found.values, found.slopes @ np.vstack([flow.moves, flow.answers])
