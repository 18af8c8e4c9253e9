# SPDX-License-Identifier: BSD-3-Clause
"""Virtual work and virtual power in generalized coordinates.

Σ (F − m a)·∂r/∂q_s = 0           work: rigid bodies as sets of particles with the same mass, mass centre and inertia,
                                  for an orientation has no r (Yoo 2004, eq. 5)
Σ (F − m a)·∂v/∂q̇_s + Σ (T − I·α − ω × I·ω)·∂ω/∂q̇_s = 0     power (Yoo 2004, eq. 6; Jourdain 1909)
"""

from collections.abc import Callable, Iterator

from kane.dynamics.methods.formulation import Exprs, Formulation
from kane.dynamics.methods.in_rates import InRates
from kane.dynamics.methods.solving import on_constraints, solved, told
from kane.errors import ModelError
from kane.expr.affine import affine_forms
from kane.expr.build import add, mul, neg, sub
from kane.expr.diff import jacobian, time_derivative
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr, as_expr, constant
from kane.model.bodies import Part
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def virtual_power(s: InRates) -> Formulation:
    """By partial velocities and partial angular velocities for q̇."""
    return _formulation(s, "virtual power", "Jourdain 1909; Yoo 2004, eq. 6", (), lambda: _powers(s))


def virtual_work(s: InRates) -> Formulation:
    """By positions of particles."""
    count = sum(1 for part in s.parts for _ in _particles(part))
    gone = (f"rigid bodies, by {count} particles that move as they do",)
    return _formulation(s, "virtual work", "d'Alembert 1743; Yoo 2004, eq. 5", gone, lambda: _works(s))


def _formulation(
    s: InRates, name: str, source: str, gone: tuple[str, ...], inertia: Callable[[], Exprs]
) -> Formulation:
    def solution() -> Exprs:
        forms = affine_forms(inertia(), s.accelerations)
        mass = Matrix([[form.get(x, ZERO) for x in s.accelerations] for form, _ in forms])
        return solved(mass, [sub(q, rest) for q, (_, rest) in zip(s.forces, forms, strict=True)], s.held).x

    return Formulation(
        name,
        source,
        (*s.coordinates, *s.rates),
        s.accelerations,
        (*gone, *told(s.held)),
        lambda: on_constraints([sub(x, q) for x, q in zip(inertia(), s.forces, strict=True)], s.held, s.accelerations),
        lambda: (*s.rates, *solution()),
        lambda: s.speeds_rates(solution()),
    )


def _powers(s: InRates) -> Exprs:
    """Σ m a·∂v/∂q̇ + (I·α + ω × I·ω)·∂ω/∂q̇."""

    def inertial() -> Iterator[tuple[Point | Frame, Vector]]:
        for part in s.parts:
            yield part.mass_center, s.acceleration(part.mass_center) * part.mass
            if part.frame is not None and part.inertia is not None:
                w, alpha = (v.express(part.frame) for v in (s.velocity(part.frame), s.acceleration(part.frame)))
                yield part.frame, part.inertia.dot(alpha) + w.cross(part.inertia.dot(w))

    return s.power_by(inertial())


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
    inertial = s.derived.system.inertial
    total = [ZERO] * len(s.coordinates)
    for part in s.parts:
        root = part.mass_center.root()
        if root.frame is not inertial:
            raise ModelError(
                f"Expected positions from a point of {inertial.name}, got {part.name} placed from {root.name} of {root.frame}."
            )
        center = part.mass_center.position(root)
        for mass, arm in _particles(part):
            r = (center + arm).components(inertial)
            a = [s.own(time_derivative(s.own(time_derivative(x)))) for x in r]
            slopes = jacobian(list(r), s.coordinates)
            for k, column in enumerate(slopes.T):
                total[k] = add(total[k], mul(mass, dot(column, a)))
    return tuple(total)
