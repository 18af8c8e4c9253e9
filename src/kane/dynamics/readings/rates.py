# SPDX-License-Identifier: BSD-3-Clause
"""Rates along a motion: q̇ written in speeds, q̈ in u̇, and de/dt."""

from __future__ import annotations

from kane.dynamics.derived import Derived
from kane.errors import ExpressionError
from kane.expr.diff import tangent
from kane.expr.evaluate import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.substitute import substitute
from kane.expr.symbols import QuasiRate, Rate, Reaction, Speed, Time, input_of, rate


def without_rates(derived: Derived, root: Expr) -> Expr:
    """`root` with q̇ written in speeds and q̈ in u̇."""
    second: dict[Expr, Expr] = {
        s: time_derivative(derived, s.place)
        for s in free_symbols([root])
        if isinstance(s, Rate)
        and (
            isinstance(s.place, QuasiRate)
            or (isinstance(s.place, Rate) and not isinstance(s.place.place, Speed) and input_of(s) is None)
        )
    }
    if second:
        root = substitute(root, second)
    return derived.kinematical.in_speeds(root, {})


def time_derivative(derived: Derived, e: Expr) -> Expr:
    """de/dt along the motion: q̇ = W u + X, u̇ as the leaves u'.

    Raises
    ------
    ExpressionError
        if it would hold the rate of u̇ or of a reaction
    """
    rates: dict[Expr, Expr] = dict(zip(derived.system.coordinates, derived.rates, strict=True))

    def leaf_rate(leaf: Expr) -> Expr:
        if isinstance(leaf, Time):
            return ONE
        if isinstance(leaf, Speed) or input_of(leaf) is not None:
            return rate(leaf)  # type: ignore[arg-type]  # a Speed, an Input or its rate
        if isinstance(leaf, Rate | Reaction):
            raise ExpressionError(
                f"Expected an expression of coordinates, rates and speeds to differentiate along the motion, got {leaf} in it. "
                "Differentiate a trajectory's values instead."
            )
        return rates.get(leaf, ZERO)

    return tangent(without_rates(derived, e), leaf_rate)
