# SPDX-License-Identifier: BSD-3-Clause
"""The accelerations of the dependent speeds, once those of the independent ones are known.

By A_n and c_D, u̇_D = A_n u̇_I + c_D, each speed's share is differentiated by itself. With u̇_I put in first, the whole is at once:

    A_D u̇_D = −(d/dt)(A u + b) at u̇_D = 0

along the tree, from the accelerations of what is held, or of the rates A_q q̇ + b_q as they are written, with q̈ of each coordinate.
"""

from collections.abc import Iterator, Sequence

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.expr.build import neg
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.square_system import square
from kane.expr.symbols import QuasiRate, rate
from kane.expr.visit import substituted
from kane.kinematics.constraints import drift_of
from kane.kinematics.motion import Following
from kane.model.variables import constraint_rate

Exprs = tuple[Expr, ...]


def dependent_accelerations(derived: Derived, e: Embedding, u_dot: Sequence[Expr]) -> Iterator[Exprs]:
    """u̇ of all speeds in two ways, `u_dot` being those of the independent ones."""
    own = dict(zip(e.independent, u_dot, strict=True))
    usual = derived.kinematics
    given = usual.with_following({u: Following({}, ZERO, own.get(i, ZERO)) for i, u in enumerate(derived.speeds)}, {})
    held = [derived.constraints.constraints[r] for r in e.partition.rows]
    solver = square(derived.constraints.a.take(e.partition.rows, e.partition.dependent).rows)

    def solved(right: Sequence[Expr]) -> Exprs:
        values = own | dict(zip(e.partition.dependent, solver.solve(list(map(neg, right))), strict=True))
        return tuple(values[i] for i in range(len(values)))

    yield solved([drift_of(c, given, usual) for c in held])
    rates = [constraint_rate(c) for c in held]
    if not any(isinstance(s, QuasiRate) for s in free_symbols(rates)):
        by_speeds: dict[Expr, Expr] = {
            rate(q): x for q, x in zip(derived.system.coordinates, derived.rates, strict=True)
        }
        memo: dict[Expr, Expr] = {}
        yield solved([given.drift(substituted(x, by_speeds, memo)) for x in rates])
