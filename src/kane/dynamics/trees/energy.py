# SPDX-License-Identifier: BSD-3-Clause
"""The kinetic energy of trees from the velocities of their segments, in a number of operations that grows as the tree.

A body with ω, the velocity v of its origin, the mass m, h = m r* and the inertia J about that has ½ (m v·v + 2 v·(ω × h) + ω·J·ω).
"""

from kane.dynamics.derivation import Derived
from kane.dynamics.routes.recursive import carrying
from kane.expr.build import add, mul
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.kinematics.travel import travel, velocities
from kane.space.rotation import cross3, product


def kinetic_energy_along_tree(derived: Derived) -> Expr:
    """½ Σ m v·v + ω·I·ω of a tree; Unsuited, with what is in the way, of another system."""
    carried = carrying(derived)
    on, twice = travel(carried.segments.steps), ZERO
    for body, rates, v in zip(carried.bodies, on.rates, velocities(on), strict=True):
        w = rates.own
        twice = add(twice, add(mul(body.m, dot(v, v)), dot(w, product(body.j, w))))
        twice = add(twice, mul(TWO, dot(v, cross3(w, body.h))))
    return twice / 2
