# SPDX-License-Identifier: BSD-3-Clause
"""The methods by name; Kane's equations, F̃_r + F̃*_r = 0, in the form in which the others are compared with them.

(Kane & Levinson 1985, sec. 6.1.)
"""

from collections.abc import Callable, Mapping

from kane.dynamics.formulation.classical import holds_reactions
from kane.dynamics.in_rates import InRates
from kane.dynamics.methods import lagrange, newton_euler
from kane.dynamics.methods.base import Formulation
from kane.dynamics.solved import Solved
from kane.errors import ModelError, cut, none_of
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


OTHERS: Mapping[str, Callable[[InRates], Formulation]] = {
    "lagrange": lagrange.second_kind,
    "lagrange first kind": lagrange.first_kind,
    "hamilton": lagrange.canonical,
    "boltzmann-hamel": lagrange.boltzmann_hamel,
    "newton-euler": newton_euler.newton_euler,
    "virtual work": newton_euler.virtual_work,
    "virtual power": newton_euler.virtual_power,
}
"""Formulations in coordinates, by name."""

METHODS = ("kane", *OTHERS)
"""The names."""


def formulation(solved: Solved, method: str) -> Formulation:
    """The equations of what is solved by Kane's method, by the method of this name."""
    given: object = method
    if not isinstance(given, str) or given not in METHODS:
        raise ModelError(f"Expected a method, one of {none_of(METHODS, method)}")
    if method == "kane":
        return kane(solved)
    if solved.derived.states:
        raise ModelError(
            f"Expected a system without further states for {cut(method)!r}, got "
            f"{', '.join(map(str, solved.derived.states))}, which are not part of the equations of motion. Declare them as inputs, "
            "kn.input, to compare methods."
        )
    if holds_reactions(solved.derived):
        raise ModelError(
            "Expected loads that contain no reaction, got friction or another one that does: methods that eliminate constraint forces "
            "from the start do not determine it. Kane's, with the reaction in evidence, solves for both: use eom itself."
        )
    partition = None if solved.embedding is None else solved.embedding.partition
    return OTHERS[method](InRates(solved.derived, partition))
