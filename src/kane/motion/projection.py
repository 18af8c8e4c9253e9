# SPDX-License-Identifier: BSD-3-Clause
"""The constraints during a motion: residuals, and projection back onto them with the least change in the mass metric.

With the metric ½ δᵀM δ, displacements Δq = W δ and changes of the speeds Δu are

    δ  = −M⁻¹A_cᵀ (A_c M⁻¹ A_cᵀ)⁺ f          f the configuration constraints, A_c their rows of A
    Δu = −M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ (A u + b)

with pseudo-inverses, so that redundant constraints do no harm. Euler parameters are divided by their length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kane.analysis.routines import routine
from kane.equations.equations import Equations
from kane.equations.handle import Handle
from kane.expr.node import Expr
from kane.numeric.arrays import Array
from kane.numeric.newton import improved
from kane.numeric.projection import least_change, of_unit_length

_ROUNDS = 6
_CLOSED = 1e-13


@dataclass(frozen=True, slots=True)
class Numbers:
    """f (configuration), A, b, M and W at a state."""

    f: Array
    a: Array
    b: Array
    m: Array
    w: Array

    @property
    def finite(self) -> bool:
        """Whether the constraints can be kept there."""
        return all(np.all(np.isfinite(v)) for v in (self.f, self.a, self.b, self.m))


@dataclass(frozen=True, slots=True, eq=False)
class Manifold:
    """The constraints of equations of motion as one compiled routine."""

    handle: Handle
    coordinates: int
    speeds: int
    configuration: int
    rows: int
    euler: tuple[tuple[int, ...], ...]

    def numbers(self, t: float, x: Array, p: Array, r: Array) -> Numbers:
        """Residuals and matrices at a state x = (q, u)."""
        flat = self.handle(t, x, p, r)
        n, nq, m, c = self.speeds, self.coordinates, self.rows, self.configuration
        at = np.cumsum([c, m * n, m, n * n])
        return Numbers(
            flat[: at[0]],
            flat[at[0] : at[1]].reshape(m, n),
            flat[at[1] : at[2]],
            flat[at[2] : at[3]].reshape(n, n),
            flat[at[3] :].reshape(nq, -1)[:, :n],
        )

    def project(self, t: float, x: Array, p: Array, r: Array, reach: Array | float = 0.0) -> tuple[Array, Numbers]:
        """The state moved onto the constraints, and the numbers there; `reach` holds the sizes that entries of A have had."""
        nq, c = self.coordinates, self.configuration
        x = of_unit_length(x, self.euler)
        now = self.numbers(t, x, p, r)
        if not now.finite:
            return x, now
        reach = np.maximum(reach, np.abs(now.a))

        def closer(at: tuple[Array, Numbers]) -> tuple[Array, Numbers]:
            x, now = at
            shift = now.w @ least_change(now.m, now.a[:c], -now.f, reach[:c])
            x = of_unit_length(np.append(x[:nq] + shift, x[nq:]), self.euler)
            return x, self.numbers(t, x, p, r)

        x, now = improved((x, now), lambda at: np.abs(at[1].f).max(initial=0), closer, _CLOSED, _ROUNDS)
        if len(now.b):
            x = np.append(x[:nq], x[nq:] + least_change(now.m, now.a, -(now.a @ x[nq:] + now.b), reach))
        return x, now


def manifold(eom: Equations) -> Manifold | None:
    """The constraints of the equations, None where there is nothing to keep."""
    place = {c: i for i, c in enumerate(eom.coordinates)}
    euler = tuple(tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters)
    if not eom.constraints.constraints and not euler:
        return None
    roots: list[Expr] = [c.expr for c in eom.system.holonomic]
    roots += [x for row in eom.A.rows for x in row]
    roots += list(eom.b)
    roots += [x for row in eom.mass_matrix.rows for x in row]
    roots += [x for row in eom.W.rows for x in row]
    handle = routine(eom, "constraints", roots)
    return Manifold(handle, len(eom.coordinates), len(eom.speeds), len(eom.system.holonomic), len(eom.b), euler)
