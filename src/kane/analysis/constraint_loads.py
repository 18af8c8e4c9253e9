# SPDX-License-Identifier: BSD-3-Clause
"""`constraint_forces`: what holds constraints, by multipliers and by auxiliary speeds (Kane & Levinson 1985, sec. 4.9 and 7.7).

M u̇ = f + Aᵀ λ        and        F_a + F*_a = 0 of a speed u_a that the constraint is released by: its force is λ
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kane.equations.derive import derive
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, state_of
from kane.errors import Attributes, SimulationError
from kane.expr.symbols import Reaction
from kane.model.constraints import Constraint
from kane.model.reactions import constraint_of, reaction


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ConstraintForces(Attributes):
    """The force or torque of each constraint at a state, found in two ways.

    Attributes
    ----------
    by_multipliers : λ by constraint
    by_auxiliary_speeds : the same brought into evidence by a speed of its own
    """

    by_multipliers: Mapping[Constraint, float]
    by_auxiliary_speeds: Mapping[Constraint, float]

    def __repr__(self) -> str:
        rows = (
            f"{c.name}: {x:.9g} by multipliers, {self.by_auxiliary_speeds[c]:.9g} by an auxiliary speed"
            for c, x in self.by_multipliers.items()
        )
        return f"ConstraintForces({'; '.join(rows)})"


def constraint_forces(
    eom: Equations,
    state: State | None = None,
    *,
    q: Any = None,
    u: Any = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, float] | None = None,
    t: float | None = None,
    states: Any = None,
) -> ConstraintForces:
    """The forces of constraints at a state, by multipliers and by auxiliary speeds.

    Parameters
    ----------
    eom : Equations
        with constraints of which it is known where their forces act, such as `kn.distance`, `kn.no_slip`, `kn.coincident`
    state : `kn.State`, in place of the values that follow
    q, u : a state on the constraints; dependent speeds may be left out
    parameters, inputs, t, states : as in `eom.evaluate`

    Raises
    ------
    SimulationError
        if no constraint says where its forces act
    ReactionError
        if reactions at cuts already bring some of these forces into evidence
    """
    check_equations(eom)
    placed = [c for c in eom.system.constraints if c.placed and c not in set(eom.redundant)]
    if not placed:
        raise SimulationError(
            "Expected constraints that say where their forces act, got none: scalars that must vanish do not. Declare them with "
            "kn.distance, kn.no_slip, kn.coincident, …."
        )
    at = state_of(state, q=q, u=u, parameters=parameters, inputs=inputs, t=t, states=states)
    known: dict[Constraint, Reaction] = {c: r for r in eom.reactions if (c := constraint_of(r)) is not None}
    own = {c: known[c] if c in known else reaction(f"lambda_{k}", constraint=c) for k, c in enumerate(placed)}
    added = [r for c, r in own.items() if c not in known]
    others = derive(eom.system.replace(reactions=(*eom.reactions, *added), dependent_speeds=eom.dependent_speeds))
    evident = others.evaluate(list(own.values()), at)
    multipliers = eom.evaluate([eom.multipliers[c] for c in placed], at)
    return ConstraintForces(
        dict(zip(placed, map(float, multipliers), strict=True)), dict(zip(placed, map(float, evident), strict=True))
    )
