# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion before they are solved, and conditions of rest and of steady motion.

    M u̇ − Aᵀ λ − G R       = f                n rows
    A u̇                    = −(Ȧ u + ḃ)       one for each constraint
    M_a u̇ − A_aᵀ λ − G_a R = f_a              one for each reaction

K z = k with z = (u̇, λ, R). Nothing is divided by, so that its derivatives are short, and hold wherever K is regular:

    K δz = −∂(K z − k)/∂x δx,   z held while differentiating.

At rest F̃_r = 0 at u = z (q̇ = 0), in steady motion F̃_r + F̃*_r = 0 at u̇ = 0 (Kane & Levinson 1985, sec. 6.5 and 6.6).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.solved import Solved
from kane.errors import ExpressionError, ModelError, ValueMissingError, alike, cut
from kane.expr.build import add, neg, sub
from kane.expr.collect import collected
from kane.expr.count import price
from kane.expr.differentiation import tangent
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import Reaction, Symbol, Time, input_of, rate
from kane.expr.visit import substituted


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


def equilibrium_conditions(solved: Solved) -> Exprs:
    """F̃_r at rest, one for each independent speed: what vanishes in equilibrium.

    Raises
    ------
    ModelError
        if motion is prescribed, so that nothing can be at rest, or a load has no value there
    """
    d = solved.derived
    given = [s for s in free_symbols([*d.z, *d.constraints.b]) if isinstance(s, Time) or input_of(s) is not None]
    if given:
        raise ModelError(
            f"Expected a system that can be at rest, got one whose motion is prescribed by {given[0]}. What holds while it moves "
            "evenly is in eom.steady_conditions({…})."
        )
    at: dict[Expr, Expr] = dict(zip(d.speeds, d.z, strict=False))  # z ends with a zero for each set of Euler parameters
    try:
        return _written(solved.Fr_nh[: len(solved.independent_speeds)], at)
    except ExpressionError as error:
        raise ModelError(
            "Expected loads that have a value at rest, got one that is divided by a speed, as sliding friction is: at rest it may be "
            "any in a range. Leave it out, eom.system.replace(loads=[…])."
        ) from error


def steady_conditions(solved: Solved, values: Mapping[Any, Any]) -> Exprs:
    """F̃_r + F̃*_r at u̇ = 0 with the `values` of some coordinates and speeds, one for each independent speed.

    Raises
    ------
    ValueMissingError
        if a value is given for something else
    """
    d, count = solved.derived, len(solved.independent_speeds)
    known: dict[str, Symbol] = {s.name: s for s in (*d.system.coordinates, *d.speeds)}
    at: dict[Expr, Expr] = {}
    given: object = values
    if not isinstance(given, Mapping):
        raise ValueMissingError(f"Expected values by symbol or name, {{u1: 2.0}}, got {cut(repr(given))}.")
    for key, value in values.items():
        name = key.name if isinstance(key, Symbol) else key
        if name not in known:
            raise ValueMissingError(
                f"Expected values of coordinates and speeds ({', '.join(known)}) in a steady motion, got one of {cut(repr(name))}."
                f"{alike(str(name), known)}"
            )
        at[known[name]] = as_expr(value)
    even: dict[Expr, Expr] = {rate(u): ZERO for u in d.speeds}
    sums = [add(f, g) for f, g in zip(solved.Fr_nh[:count], solved.Fr_star_nh[:count], strict=True)]
    return _written([substituted(e, even) for e in sums], at)


def _written(exprs: Sequence[Expr], at: Mapping[Expr, Expr]) -> Exprs:
    memo: dict[Expr, Expr] = {}
    found = [substituted(e, at, memo) for e in exprs]
    return tuple(min((e, collected(e)), key=lambda form: price([form])) for e in found)
