# SPDX-License-Identifier: BSD-3-Clause
"""The methods by name."""

from collections.abc import Callable, Mapping

from kane.dynamics.methods import boltzmann_hamel, hamilton, kane, lagrange, newton_euler, virtual
from kane.dynamics.methods.formulation import Formulation
from kane.dynamics.methods.in_rates import InRates
from kane.dynamics.solved import Solved
from kane.errors import ModelError, cut, none_of

OTHERS: Mapping[str, Callable[[InRates], Formulation]] = {
    "lagrange": lagrange.second_kind,
    "lagrange first kind": lagrange.first_kind,
    "hamilton": hamilton.canonical,
    "boltzmann-hamel": boltzmann_hamel.boltzmann_hamel,
    "newton-euler": newton_euler.newton_euler,
    "virtual work": virtual.virtual_work,
    "virtual power": virtual.virtual_power,
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
        return kane.kane(solved)
    if solved.derived.states:
        raise ModelError(
            f"Expected a system of coordinates and speeds alone for {cut(method)!r}, got the further states "
            f"{', '.join(map(str, solved.derived.states))}, which stand beside the equations of motion. Give their values as inputs, "
            "kn.input, to compare methods."
        )
    partition = None if solved.embedding is None else solved.embedding.partition
    return OTHERS[method](InRates(solved.derived, partition))
