# SPDX-License-Identifier: BSD-3-Clause
"""Physical consistency of estimated inertial parameters: positive mass, and moments of inertia of some distribution of mass.

The distance of each body from the initial one (`numeric.pseudo_inertia`) is a weighted barrier, added to half the sum of squared
residuals: negligible for consistent bodies, unbounded where consistency is lost.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.differentiation import gradient
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Parameter
from kane.model.bodies import Particle, RigidBody
from kane.numeric import pseudo_inertia
from kane.numeric.arrays import Array
from kane.numeric.pseudo_inertia import distance, root_of, step_rows
from kane.numeric.scale import DECLARED

_MOMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


class Here(NamedTuple):
    """The distance from the initial body, and C and c of its gradient Cᵀ c and Hessian Cᵀ C by the unknowns."""

    distance: float
    slopes: Array
    rest: Array


@dataclass(frozen=True, slots=True, eq=False)
class Possible:
    """One body: mass and central moments, their derivatives by the unknowns, and the initial J₀ in directions of nonzero extent."""

    values: tuple[Expr, ...]
    slopes: tuple[tuple[Expr, ...], ...]
    units: Array
    first: Array

    def at(self, values: Mapping[Expr, Any]) -> Here | None:
        """The distance with C and c; None if the body is inconsistent."""
        pi = np.array(evaluate(list(self.values), values), dtype=float)
        lower = root_of(np.tensordot(pi, self.units, 1))
        if lower is None:
            return None
        by = np.array([evaluate(list(row), values) for row in self.slopes], dtype=float)
        return Here(distance(lower, self.first), *step_rows(lower, np.tensordot(by.T, self.units, 1), self.first))


def possible_bodies(eom: Equations, unknown: Sequence[Parameter], values: Mapping[Expr, Any]) -> tuple[Possible, ...]:
    """The bodies whose mass or moments of inertia depend on unknowns.

    A rod has no extent across it, and a body in a planar model no moments about axes within the plane: directions without extent in
    the initial body are exempt from the condition.

    Raises
    ------
    SimulationError
        if an initial body is inconsistent
    """
    found = list[Possible]()
    for body in eom.system.bodies:
        if not isinstance(body, RigidBody | Particle):
            continue
        own = _parameters(body)
        if not {*free_symbols(own)} & {*unknown}:
            continue
        pi = np.array(evaluate(own, values), dtype=float)
        j, plane = pseudo_inertia.of(pi), sum(e is not ZERO for e in own[4:7]) == 1
        size = np.array([*[max(abs(float(j[i, i])) for i in range(3)) or 1.0] * 3, pi[0] if pi[0] > 0 else 1.0]) ** 0.5
        sizes, axes = np.linalg.eigh(j / np.outer(size, size))
        extent = sizes > DECLARED
        if not pi[0] > 0 or (sizes[0] < -DECLARED and not plane):
            raise SimulationError(
                f"Expected first values for which {body.name!r} is physically possible, got mass {pi[0]:g} and moments of inertia "
                f"{', '.join(f'{x:g}' for x in pi[4:7])}: all must be above zero, and no moment above the sum of the other two. "
                "Give other first values in parameters=."
            )
        across = size[:, None] ** -1 * axes[:, extent]
        units = np.einsum("ia,kij,jb->kab", across, pseudo_inertia.UNITS, across)
        slopes = tuple(gradient(e, unknown) for e in own)
        found.append(Possible(tuple(own), slopes, units, np.tensordot(pi, units, 1)))
    return tuple(found)


def _parameters(body: RigidBody | Particle) -> list[Expr]:
    moments = [ZERO] * 6
    if isinstance(body, RigidBody):
        table = body.inertia.components(body.frame)
        moments = [table[i, j] for i, j in _MOMENTS]
    return [body.mass, ZERO, ZERO, ZERO, *moments]
