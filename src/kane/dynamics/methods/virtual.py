# SPDX-License-Identifier: BSD-3-Clause
"""Virtual work and virtual power in generalized coordinates.

Σ (F − m a)·∂r/∂q_s = 0           work: rigid bodies as sets of particles with the same mass, mass centre and inertia,
                                  for an orientation has no r (Yoo 2004, eq. 5)
Σ (F − m a)·∂v/∂q̇_s + Σ (T − I·α − ω × I·ω)·∂ω/∂q̇_s = 0     power (Yoo 2004, eq. 6; Jourdain 1909)
"""

from collections.abc import Callable, Iterator
from functools import cache

from kane.dynamics.methods.base import Exprs, Formulation, on_constraints, solved_for, told
from kane.dynamics.methods.in_rates import InRates
from kane.errors import ModelError
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import jacobian, time_derivative
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr, as_expr, constant
from kane.model.bodies import Part
from kane.space.point import Point
from kane.space.rotation import Triple
from kane.space.vector import Vector


def virtual_power(s: InRates) -> Formulation:
    """By partial velocities and partial angular velocities for q̇."""
    return _formulation(s, "virtual power", "Jourdain 1909; Yoo 2004, eq. 6", (), lambda: s.power_by(s.inertia()))


def virtual_work(s: InRates) -> Formulation:
    """By positions of particles."""
    count = sum(1 for part in s.parts for _ in _particles(part))
    gone = (f"rigid bodies, by {count} particles that move as they do",)
    return _formulation(s, "virtual work", "d'Alembert 1743; Yoo 2004, eq. 5", gone, lambda: _works(s))


def _formulation(
    s: InRates, name: str, source: str, gone: tuple[str, ...], inertia: Callable[[], Exprs]
) -> Formulation:
    left = cache(lambda: tuple(sub(x, q) for x, q in zip(inertia(), s.forces, strict=True)))
    solution = cache(lambda: solved_for(s.accelerations, left(), s.held).x)
    return Formulation(
        name,
        source,
        (*s.coordinates, *s.rates),
        s.accelerations,
        (*gone, *told(s.held)),
        lambda: on_constraints(left(), s.held, s.accelerations),
        lambda: (*s.rates, *solution()),
        lambda: s.speeds_rates(solution()),
    )


def _particles(part: Part) -> Iterator[tuple[Expr, Vector]]:
    """Masses and places from the mass centre of particles a metre off, with the same mass, mass centre and central inertia.

    With E = ½ tr(I) 1 − I: E_ii/2 at ± e_i, E_ij/4 at ±(e_i + e_j), −E_ij/4 at ±(e_i − e_j), the rest of the mass at the centre.
    """
    left = part.mass
    if part.frame is not None and part.inertia is not None:
        axes = (part.frame.x, part.frame.y, part.frame.z)
        rows = [[a.dot(part.inertia.dot(b)) for b in axes] for a in axes]
        half = mul(constant(0.5), add(add(rows[0][0], rows[1][1]), rows[2][2]))
        for i in range(3):
            e = sub(half, rows[i][i])
            left = sub(left, e)
            for sign in (1, -1):
                yield e / 2, axes[i] * as_expr(sign)
            for j in range(i):
                if rows[i][j] is not ZERO:
                    e = neg(rows[i][j])
                    for sign in (1, -1):
                        yield e / 4, (axes[i] + axes[j]) * as_expr(sign)
                        yield neg(e / 4), (axes[i] - axes[j]) * as_expr(sign)
    yield left, Vector()


def _works(s: InRates) -> Exprs:
    """Σ m a·∂r/∂q."""
    total = [ZERO] * len(s.coordinates)
    for part in s.parts:
        for r, carried in _carried(s, part):
            columns = jacobian(list(r), s.coordinates).T
            for mass, x in carried:
                a = [s.own(time_derivative(s.own(time_derivative(c)))) for c in x]
                for k, column in enumerate(columns):
                    total[k] = add(total[k], mul(mass, dot(column, a)))
    return tuple(total)


def _carried(s: InRates, part: Part) -> Iterator[tuple[Triple, list[tuple[Expr, Triple]]]]:
    """Places of particles, each with the masses and places that its m a is a sum of."""
    if part.momenta:
        yield _place(s, part.mass_center), [(mass, _place(s, p)) for p, mass in part.momenta]
        return
    for mass, arm in _particles(part):
        r = _place(s, part.mass_center, arm)
        yield r, [(mass, r)]


def _place(s: InRates, point: Point, arm: Vector = Vector()) -> Triple:  # noqa: B008, vectors are frozen
    inertial, root = s.derived.system.inertial, point.root()
    if root.frame is not inertial:
        raise ModelError(
            f"Expected positions from a point of {inertial.name}, got {point.name} placed from {root.name} of {root.frame}."
        )
    return (point.position(root) + arm).components(inertial)
