# SPDX-License-Identifier: BSD-3-Clause
"""The start of a simulation: complete values, named and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError, ValueMissingError
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.named import finite_number, named_values

_UNIT_SLACK = 1e-8


def start_values(eom: Equations, what: str, symbols: Sequence[Symbol], given: Any) -> list[float]:
    """One finite number for each symbol."""
    values = named_values(what, symbols, given)
    missing = [s.name for s in symbols if s not in values]
    if missing:
        raise ValueMissingError(
            f"Expected a start value for all {what}, got none for {', '.join(missing)}. Give one for each, by symbol or name."
        )
    numbers = []
    for s in symbols:
        numbers.append(finite_number("start value", s.name, values[s]))
    return numbers


def start_state(eom: Equations, q: Any, u: Any) -> Array:
    """The state (q, u) at the start; Euler parameters must be of unit length."""
    state = start_values(eom, "coordinates", eom.coordinates, q) + start_values(eom, "speeds", eom.speeds, u)
    place = {c: i for i, c in enumerate(eom.coordinates)}
    for s in eom.system.euler_parameters:
        length = float(np.sqrt(sum(state[place[e]] ** 2 for e in s.coordinates)))
        if abs(length - 1) > _UNIT_SLACK:
            names = ", ".join(e.name for e in s.coordinates)
            raise SimulationError(
                f"Expected Euler parameters ({names}) with e0² + e1² + e2² + e3² = 1, got length {length:.9g}. Divide them by it."
            )
    return np.array(state)


def check_masses(eom: Equations, constants: Mapping[Expr, float]) -> None:
    """No mass below zero with the parameters' values."""
    for body in eom.system.bodies:
        if all(s in constants for s in free_symbols([body.mass])):
            value = float(evaluate(body.mass, constants))
            if value < 0:
                raise SimulationError(
                    f"Expected a mass ≥ 0 for {body.name}, got {body.mass!s:.60} = {value:g} at the values of the parameters. "
                    "Correct them."
                )


def check_span(span: Any) -> tuple[float, float]:
    """(t0, t1) with t1 > t0."""
    try:
        t0, t1 = (float(x) for x in span)
    except (TypeError, ValueError) as error:
        raise SimulationError(f"Expected a time span (t0, t1), got {span!r:.60}. Give two times in s.") from error
    if not (np.isfinite(t0) and np.isfinite(t1) and t1 > t0):
        raise SimulationError(
            f"Expected a time span (t0, t1) with t1 > t0, got ({t0:g}, {t1:g}). Motions run forwards: "
            "swap the two, or end later."
        )
    return t0, t1


def check_tolerance(name: str, value: float) -> float:
    """A tolerance above zero."""
    number = finite_number("tolerance", name, value)
    if not number > 0:
        raise SimulationError(f"Expected {name} > 0, got {value!r}. Usual tolerances are 1e-6 to 1e-12.")
    return number
