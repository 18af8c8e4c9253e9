# SPDX-License-Identifier: BSD-3-Clause
"""One degree of freedom: the power of the forces is the rate of the kinetic energy.

Where velocities are homogeneous in the speeds, u = B u_I, the kinetic energy is K = ½ uᵀ M u, and with u̇ = B u̇_I + c

    Bᵀ M B u̇_I = Bᵀ F − (M B)ᵀ c − ½ Bᵀ Ṁ u,

F those of the active forces alone: no acceleration of any body is needed, and of M only what changes is differentiated. As B_r u_s is
B_s u_r, each pair of entries of Ṁ counts once.
"""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics import assembly
from kane.dynamics.assembly import blocks
from kane.dynamics.bodies import Moving
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.routes.embedded import evident
from kane.dynamics.solved import Solved
from kane.expr.build import add, mul, sub
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.space.vector import Vector

_HALF = constant(0.5)


def homogeneous(derived: Derived, e: Embedding) -> bool:
    """Whether velocities are u_I times what depends on the configuration and time, with one u_I, and momenta are m v."""
    if any(m.shared for m in derived.bodies):
        return False
    moving = [m.center for m in derived.bodies] + [m.rotation.motion for m in derived.bodies if m.rotation]
    return len(e.independent) == 1 and all(m.rest.is_zero for m in moving) and all(x is ZERO for x in e.b_n)


def power(derived: Derived, e: Embedding) -> Solved:
    """u̇ from the power, without the reactions; what is divided by is not watched yet."""
    every: list[Expr] = [ONE] * len(derived.speeds)
    for i, (x,) in zip(e.partition.dependent, e.a_n.rows, strict=True):
        every[i] = x
    spread = derived.mass_matrix @ every
    resting = [still(m) for m in derived.bodies]
    left = derived.left_by(derived.kinematics, resting)
    active = [assembly.generalized_by_motion(left, s) for s in derived.speeds]
    held = [spread[d] for d in e.partition.dependent]
    right = sub(sub(dot(every, active), dot(held, e.c)), _gained(derived, e, every))
    inner = block_solution(blocks([[dot(every, spread)]], [right], (), (), {}))
    matrix = evident(derived)
    return Solved("power", derived, e, e.every(inner.accelerations), (), inner.pivots, matrix, matrix)


def still(m: Moving) -> Moving:
    """The same body as if it had no acceleration at u̇ = 0."""
    turning = m.rotation and m.rotation._replace(bias=Vector())
    shared = tuple((replace(motion, bias=Vector()), mass) for motion, mass in m.shared)
    return m._replace(center=replace(m.center, bias=Vector()), rotation=turning, shared=shared)


def _gained(derived: Derived, e: Embedding, every: Sequence[Expr]) -> Expr:
    """½ Bᵀ Ṁ u, the shares of the independent speed first, whose B is 1."""
    total, m = ZERO, derived.mass_matrix
    order = (*e.independent, *sorted(e.partition.dependent))
    for k, s in enumerate(order):
        column = mul(every[s], mul(_HALF, derived.kinematics.drift(m[s, s])))
        for r in order[:k]:
            column = add(column, mul(every[r], derived.kinematics.drift(m[r, s])))
        total = add(total, mul(derived.speeds[s], column))
    return total
