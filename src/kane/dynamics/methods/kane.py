# SPDX-License-Identifier: BSD-3-Clause
"""Kane's equations, F̃_r + F̃*_r = 0, in the form in which other methods are compared with them (Kane & Levinson 1985, sec. 6.1)."""

from kane.dynamics.methods.formulation import Formulation
from kane.dynamics.solved import Solved
from kane.expr.build import add
from kane.expr.symbols import rate


def kane(solved: Solved) -> Formulation:
    """By the declared generalized speeds, the dependent ones from the start by the others."""
    d = solved.derived
    count = len(solved.dependent_speeds)
    gone = (f"{count} dependent speed{'s' * (count > 1)}, by u_D = A_n u_I + b_n",) if count else ()
    own = len(solved.independent_speeds)
    return Formulation(
        "Kane",
        "Kane & Levinson 1985, sec. 6.1",
        d.state,
        tuple(map(rate, solved.independent_speeds)),
        gone,
        lambda: tuple(map(add, solved.Fr_nh[:own], solved.Fr_star_nh[:own])),
        lambda: solved.right_hand_side,
        lambda: solved.accelerations,
    )
