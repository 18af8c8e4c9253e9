# SPDX-License-Identifier: BSD-3-Clause
"""The tangent space of the constraints at a state: δx = T ξ with independent perturbations ξ, and shifts by time and parameters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kane.analysis.flow import Flow, Preference, flow_at, perturbations, spread
from kane.analysis.local import slopes_at
from kane.analysis.state_checks import StateArrays
from kane.equations.equations import Equations
from kane.expr.symbols import Parameter, time
from kane.motion.derivatives.parameter_slopes import input_changes
from kane.motion.right_hand_side import Routines
from kane.motion.solution.phases import Phase
from kane.numeric.arrays import Array
from kane.numeric.rank import least_squares


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A motion on one side of an instant: the numeric equations, the phase, the time and the state."""

    now: Routines
    phase: Phase
    t: float
    x: Array

    @property
    def rate(self) -> Array:
        """(q̇, u̇, ȧ)."""
        return self.now.rate(self.t, np.append(self.x, 0.0))[:-1]


def kinds(eom: Equations) -> tuple[tuple[type, str], ...]:
    """The kind and the unit of each state, of a speed declared without one that of its definition."""
    return tuple((type(s), s.unit or eom.unit(s)) for s in eom.state)


def sizes_of(eom: Equations, sizes: Array, share: float) -> Array:
    """Sizes of the states, each at least a `share` of the largest of its kind and unit: metres say nothing about radians."""
    every = eom.numeric().value(kinds)
    largest = {kind: max(x for x, k in zip(sizes.tolist(), every, strict=True) if k == kind) for kind in every}
    return np.maximum(sizes, [share * largest[kind] or 1.0 for kind in every])


def flow_of(side: Side) -> Flow:
    """The constrained flow at a state."""
    now = side.now
    p = now.p[: len(now.eom.parameters)]
    return flow_at(
        now.eom.numeric(now.settings), StateArrays(side.t, side.x, p, now.inputs(side.t, side.x)), Preference()
    )


def basis_of(flow: Flow) -> Array:
    """The basis T of the tangent space (x × ξ)."""
    return np.asarray(flow.moves[: len(flow.state.x), : len(flow.rest)])


def allowed(side: Side, by: Sequence[Parameter]) -> tuple[Array, Array, Array]:
    """T, and the changes of the state (x) and (x × k) that satisfy the constraints for unit changes of time and of each of `by`."""
    flow = flow_of(side)
    nq, n = len(side.now.eom.coordinates), len(side.now.eom.speeds)
    zero = np.zeros(flow.values.right.shape)
    t = spread(flow.numeric.value(perturbations), side.x[:nq])
    by_state = slopes_at(flow.run, flow.state, zero)
    driven = input_changes(side.now, side.t, side.x, by)
    shifts = []
    for s, inputs in zip((time, *by), driven.T, strict=True):
        own = slopes_at(flow.run, flow.state, zero, s)
        configuration, motion = (
            getattr(own, kind)[:, 0] + getattr(by_state, kind)[:, len(side.x) :] @ inputs
            for kind in ("configuration", "motion")
        )
        q = -t @ least_squares(by_state.configuration[:, :nq] @ t, configuration)
        rest = motion + by_state.motion[:, :nq] @ q
        u = -least_squares(flow.values.constraints(n), rest)
        shifts.append(np.concatenate([q, u, np.zeros(len(side.x) - nq - n)]))
    return basis_of(flow), shifts[0], np.array(shifts[1:]).reshape(len(by), len(side.x)).T
