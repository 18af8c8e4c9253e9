# SPDX-License-Identifier: BSD-3-Clause
"""The constraints during a motion: residuals, and projection back onto them with the least change in the mass metric.

With the metric ½ δᵀM δ, displacements Δq = W δ and changes of the speeds Δu are

    δ  = −M⁻¹A_cᵀ (A_c M⁻¹ A_cᵀ)⁺ f          f the configuration constraints, A_c their rows of A
    Δu = −M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ (A u + b)

with pseudo-inverses, so that redundant constraints do no harm. Euler parameters are divided by their length.
"""

from dataclasses import dataclass

import numpy as np

from kane.dynamics.constraints.manifold import branch_scalars, branches, turned, turned_closures
from kane.dynamics.readings.programs import mass_matrix
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.equations.routines import ports
from kane.expr.matrix import Matrix
from kane.expr.size import Sizes, size
from kane.model.constraints import Branch
from kane.numeric.arrays import Array
from kane.numeric.newton import improved
from kane.numeric.projection import least_change, of_unit_length, row_sizes
from kane.numeric.rank import Mixed
from kane.numeric.scale import CLOSED_FULLY
from kane.program.bundle import Bundle
from kane.program.native.compiled_routine import BundleRoutine

Mixes = tuple[Mixed | None, Mixed | None]

_ROUNDS = 6


@dataclass(frozen=True, slots=True)
class Numbers:
    """f (configuration) and the sizes of its `terms`, A, b, M and W at a state.

    `speeds` are the speeds themselves where they follow from the independent ones alone, `branch` what tells branches apart.
    """

    f: Array
    terms: Array
    a: Array
    b: Array
    m: Array
    w: Array
    speeds: Array
    branch: Array

    @property
    def finite(self) -> bool:
        """Whether the constraints can be kept there."""
        return all(np.all(np.isfinite(v)) for v in (self.f, self.a, self.b, self.m))


def constraint_numbers(eom: Equations) -> Bundle[Numbers]:
    """What keeps a state on the constraints."""
    solved = eom.solved
    f, d = [c.expr for c in eom.system.holonomic], solved.regular

    def written(m: Matrix) -> Matrix:
        return Matrix([solved.written(row) for row in m], m.shape)

    speeds = solved.speeds_by_independent if solved.twin else ()
    scalars = branch_scalars(branches(eom.system))
    memo = Sizes()
    groups = {
        "f": f,
        "terms": [size(x, memo) for x in f],
        "a": d.A,
        "b": d.b,
        "m": mass_matrix(solved) if solved.twin is None else written(d.mass_matrix),
        "w": written(d.W),
        "speeds": speeds,
        "branch": scalars,
    }
    return Bundle("constraints", ports(eom.derived), Numbers, groups)


@dataclass(frozen=True, slots=True, eq=False)
class Manifold:
    """The constraints of equations of motion: their numbers as one routine, where Euler parameters are, what branches are meant."""

    numbers: BundleRoutine[Numbers]
    coordinates: int
    euler: tuple[tuple[int, ...], ...]
    meant: tuple[Branch, ...] = ()

    def turned(self, numbers: Numbers) -> str:
        """Which closures are turned away from the branch that they mean, in words; "" where none is."""
        return turned_closures(self.meant, turned(self.meant, numbers.branch)) if self.meant else ""

    def project(
        self, t: float, x: Array, p: Array, r: Array, reach: Array | float = 0.0, mixes: Mixes = (None, None)
    ) -> tuple[Array, Numbers]:
        """The state moved onto the constraints, and the numbers there; `reach` holds the sizes that entries of A have had.

        `mixes` are what counts in the places of the rows of the configuration constraints, and in those of all.
        """
        nq = self.coordinates
        x = of_unit_length(x, self.euler)
        now = self.numbers(t, x, p, r)
        if not now.finite:
            return x, now
        reach = np.maximum(reach, np.abs(now.a))
        c, n = len(now.f), len(now.m)
        size = row_sizes(now.m, reach[:c])
        limit = CLOSED_FULLY * (now.terms / size).max(initial=0)

        def closer(at: tuple[Array, Numbers]) -> tuple[Array, Numbers]:
            x, now = at
            shift = now.w[:, :n] @ least_change(now.m, now.a[:c], -now.f, reach[:c], mixes[0])
            x = of_unit_length(np.append(x[:nq] + shift, x[nq:]), self.euler)
            return x, self.numbers(t, x, p, r)

        x, now = improved((x, now), lambda at: np.abs(at[1].f / size).max(initial=0), closer, limit, _ROUNDS)
        if len(now.speeds):
            x = np.concatenate([x[:nq], now.speeds, x[nq + n :]])
        elif len(now.b):
            u = x[nq : nq + n]
            change = least_change(now.m, now.a, -(now.a @ u + now.b), reach, mixes[1])
            x = np.concatenate([x[:nq], u + change, x[nq + n :]])
        return x, now


def is_constrained(eom: Equations) -> bool:
    """Whether there is anything to keep: constraints, or the length of Euler parameters."""
    return bool(eom.constraints.constraints or eom.system.euler_parameters)


def manifold(numeric: Numeric[Equations]) -> Manifold | None:
    """The constraints of the equations, None where there is nothing to keep."""
    eom = numeric.equations
    if not is_constrained(eom):
        return None
    place = {c: i for i, c in enumerate(eom.coordinates)}
    euler = tuple(tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters)
    return Manifold(numeric.routine(constraint_numbers), len(place), euler, branches(eom.system))
