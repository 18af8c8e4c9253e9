# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion before they are solved, as one linear system for all that is unknown at a state.

    M u̇ − Aᵀ λ − G R       = f                n rows
    A u̇                    = −(Ȧ u + ḃ)       one for each constraint
    M_a u̇ − A_aᵀ λ − G_a R = f_a              one for each reaction

K z = k with z = (u̇, λ, R). Nothing is divided by, so that its derivatives are short, and hold wherever K is regular:

    K δz = −∂(K z − k)/∂x δx,   z held while differentiating.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kane.dynamics.derivation import Derived
from kane.expr.build import add, neg, sub
from kane.expr.differentiation import tangent
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Reaction, Symbol, rate


@dataclass(frozen=True, slots=True, eq=False)
class Unsolved:
    """z = (u̇, λ, R) as `unknowns`, K, k, and what a state must satisfy.

    `configuration` is f(q, t), `motion` A u + b, `rates` q̇ in speeds, `spins` the angular velocity's measure numbers of each set of
    Euler parameters, `states` ȧ of the further states.
    """

    unknowns: tuple[Symbol, ...]
    matrix: tuple[tuple[Expr, ...], ...]
    right: tuple[Expr, ...]
    configuration: tuple[Expr, ...]
    motion: tuple[Expr, ...]
    rates: tuple[Expr, ...]
    spins: tuple[Expr, ...]
    states: tuple[Expr, ...]

    @property
    def residual(self) -> tuple[Expr, ...]:
        """K z − k."""
        return tuple(sub(dot(row, self.unknowns), k) for row, k in zip(self.matrix, self.right, strict=True))

    @property
    def places(self) -> tuple[Expr, ...]:
        """f, A u + b, q̇, spins and ȧ: what is differentiated together with the residual."""
        return (*self.configuration, *self.motion, *self.rates, *self.spins, *self.states)


def unsolved(derived: Derived) -> Unsolved:
    """The unsolved equations of motion."""
    blocks, rows = derived.blocks, derived.constraints
    m, s = len(rows.constraints), len(derived.reactions)
    columns = (*blocks.mass, *blocks.mass_a), (*rows.a.T, *rows.a_auxiliary.T), (*blocks.coupling, *blocks.coupling_a)
    dynamical = [(*mass, *map(neg, a), *map(neg, g)) for mass, a, g in zip(*columns, strict=True)]
    held = [(*row, *[ZERO] * (m + s)) for row in rows.a]
    kinematical, n = derived.kinematical, len(derived.speeds)
    return Unsolved(
        (*map(rate, derived.speeds), *(Reaction.declare(f"λ{k + 1}") for k in range(m)), *derived.reactions),
        (*dynamical[:n], *held, *dynamical[n:]),
        (*blocks.forcing, *map(neg, rows.drift), *blocks.forcing_a),
        tuple(c.expr for c in derived.system.holonomic),
        derived.constraint_rates,
        derived.rates,
        tuple(
            add(dot(list(kinematical.inverse[w].values()), list(kinematical.inverse[w])), kinematical.x[w])
            for e in derived.system.euler_parameters
            for w in e.quasi
        ),
        derived.state_rates,
    )


def partials(roots: Sequence[Expr], symbols: Sequence[Expr]) -> Matrix:
    """∂roots/∂symbols, a row for each root; those of lengths |v| at v = 0 are zero."""
    columns = []
    for s in symbols:
        memo: dict[Expr, Expr] = {}
        columns.append([tangent(r, {s: ONE}, memo, at_rest=True) for r in roots])
    return Matrix(zip(*columns, strict=True), (len(roots), len(symbols)))
