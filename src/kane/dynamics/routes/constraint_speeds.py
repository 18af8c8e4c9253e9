# SPDX-License-Identifier: BSD-3-Clause
"""The route through the constraints' own rates: regular where W alone has a pole.

In the place of the dependent speeds stand the rates of their constraints, w = A_q q̇ + b_q, which vanish: with (u_I, w) as speeds
the constraints are w = 0, and q̇ follows from [Y_I; A_q]. What is derived so is solved by the classical route. The declared dependent
speeds are u_D = Y_D q̇ + z_D of these rates:

    u_D = A_n u_I + A_na u_a + b_n          with w = −A_a u_a

The state's u_D stand only in loads that were declared with them.
"""

from dataclasses import replace

from kane.dynamics.constraints.embed import Embedding, Solution
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, by_other_speeds
from kane.dynamics.routes.classical import classical
from kane.dynamics.routes.rates import ConstraintRates, constraint_rates
from kane.dynamics.solved import Solved
from kane.expr.build import add
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO
from kane.kinematics.constraints import ConstraintRows


def constraint_speeds(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions, free of the poles that W alone has; without constraints by the classical route."""
    if partition is None:
        return classical(derived, partition)
    w = constraint_rates(dict(zip(partition.dependent, partition.rows, strict=True)))
    twin = classical(_twin(derived, w), partition)
    e = _embedding(derived, partition, twin.derived, w)
    found = twin.mapped(w.held)
    own = [found.accelerations[i] for i in e.independent]
    return replace(
        found,
        route="constraint speeds",
        derived=derived,
        embedding=e,
        accelerations=e.every(own),
        twin=twin,
        vanishing=w.vanishing,
    )


def _twin(derived: Derived, w: ConstraintRates) -> Derived:
    """The same with the rates of the constraints in the places of the dependent speeds."""
    rows = derived.constraints
    m, n = rows.a.shape
    nothing = (ZERO,) * m
    held = ConstraintRows(
        rows.constraints, Matrix([w.row(r, n) for r in range(m)], (m, n)), rows.a_auxiliary, nothing, lambda: nothing
    )
    return by_other_speeds(derived, w.definitions(derived), held)


def _embedding(derived: Derived, partition: Partition, twin: Derived, w: ConstraintRates) -> Embedding:
    """The declared dependent speeds by the independent ones: A_n, b_n from Y_D q̇ + z_D with q̇ of the twin."""
    speeds = derived.speeds
    free = partition.independent(len(speeds))
    definitions = [derived.system.speeds[speeds[d]] for d in partition.dependent]
    forms = twin.kinematical.forms(definitions)
    released = derived.constraints.a_auxiliary.take(partition.rows)  # w = −A_a u_a
    by_w = Matrix([[f.coefficients.get(s, ZERO) for s in w.speeds.values()] for f in forms])
    a_n = Matrix([[f.coefficients.get(speeds[i], ZERO) for i in free] for f in forms], (len(forms), len(free)))
    own = [speeds[i] for i in free]
    b_n = tuple(f.rest for f in forms)
    drift = tuple(w.held(twin.kinematics.drift(add(dot(row, own), b))) for row, b in zip(a_n, b_n, strict=True))
    solution = Solution(a_n, -(by_w @ released), b_n, lambda: drift)
    return Embedding(derived.constraints, partition, free, lambda: solution)
