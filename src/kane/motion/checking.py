# SPDX-License-Identifier: BSD-3-Clause
"""Checking functions: what should be constant along a motion, and how far it is (Kane & Levinson 1985, sec. 7.3)."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived
from kane.dynamics.readings.integrals import Integral
from kane.dynamics.readings.values import asked
from kane.errors import ArgumentError, KaneWarning, cut
from kane.expr.immutable import Immutable
from kane.expr.node import Expr
from kane.expr.size import Sizes, size
from kane.motion.phases import Indices, leaps
from kane.numeric.arrays import Array

LIMIT = 1000
"""Relative tolerances up to which a drift is that of the integration, as for the energy."""


@dataclass(frozen=True, slots=True, eq=False)
class Drift(Immutable):
    """How far a checking function went from its value at the start.

    Attributes
    ----------
    name : that of the integral, or the expression
    values : along the motion (n)
    drift : the largest change, in the function's unit
    relative : it over the largest size of the function's terms along the motion
    at : when (s)
    """

    name: str
    values: Array
    drift: float
    relative: float
    at: float

    def __repr__(self) -> str:
        return f"Drift({self.name}: {self.drift:.3g}, {self.relative:.1g} of its terms, at t = {self.at:.4g} s)"


Functions = tuple[tuple[str, Expr], ...]


def checking_functions(derived: Derived, functions: Sequence[Any]) -> Functions:
    """The functions, each with its name, before a motion runs.

    Raises
    ------
    ArgumentError
        if they are no list, or something else than integrals and expressions stands in it
    """
    if isinstance(functions, Integral | Expr | str):
        raise ArgumentError(
            f"Expected a list of integrals or expressions to check, got {cut(repr(functions))}. Write […]."
        )
    wanted = [(f.name, f.value) if isinstance(f, Integral) else (cut(f), f) for f in functions]
    wrong = [name for name, f in wanted if not isinstance(f, Expr)]
    if wrong:
        raise ArgumentError(
            f"Expected integrals or expressions to check, got {wrong[0]}. Take them from eom.integrals, or write them in "
            "the system's symbols."
        )
    asked(derived, [f for _, f in wanted])
    return tuple(wanted)


def drifts(
    t: Array, functions: Functions, values: Callable[[list[Expr]], list[Array]], begins: Indices
) -> tuple[Drift, ...]:
    """The drift of each function, by the values of expressions along a motion; what jumps where phases begin is none."""
    memo: Sizes = {}
    roots = [f for _, f in functions]
    tables = values([*roots, *(size(e, memo) for e in roots)])
    return tuple(
        _drift(t, name, values_, sizes, begins)
        for (name, _), (values_, sizes) in zip(functions, zip(*np.split(np.array(tables), 2), strict=True), strict=True)
    )


def check_drifts(found: Sequence[Drift], rtol: float) -> None:
    """Warn of a function that went further than integration explains."""
    worst = max(found, key=lambda d: d.relative, default=None)
    if worst is not None and not worst.relative <= LIMIT * rtol:
        warnings.warn(
            f"Expected {worst.name} constant along the motion, got a change of {worst.drift:.3g}, {worst.relative:.1g} of its "
            f"terms, at t = {worst.at:.4g} s. Tighten rtol= and atol=, or look whether it is an integral of these equations: "
            "eom.integrals names those.",
            KaneWarning,
            stacklevel=4,
        )


def _drift(t: Array, name: str, values: Array, sizes: Array, begins: Indices) -> Drift:
    change = np.abs(values - values[0] - leaps(values, begins))
    k = int(np.nanargmax(change)) if np.isfinite(change).any() else 0
    whole = float(np.nanmax(np.abs(sizes), initial=0.0))
    most = float(change[k])
    return Drift(name, values, most, most / whole if whole else most, float(t[k]))
