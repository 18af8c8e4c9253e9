# SPDX-License-Identifier: BSD-3-Clause
"""Conditions of rest and of steady motion, as equations (Kane & Levinson 1985, sec. 6.5 and 6.6).

at rest  F̃_r = 0 at u = z (q̇ = 0),        in steady motion  F̃_r + F̃*_r = 0 at u̇ = 0
"""

from collections.abc import Mapping, Sequence
from typing import Any

from kane.dynamics.derivation import Exprs
from kane.dynamics.solved import Solved
from kane.errors import ExpressionError, ModelError, ValueMissingError, alike, cut
from kane.expr.build import add
from kane.expr.collect import collected
from kane.expr.count import price
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Symbol, Time, input_of, rate
from kane.expr.visit import substituted


def equilibrium_conditions(solved: Solved) -> Exprs:
    """F̃_r at rest, one for each independent speed: what vanishes in equilibrium.

    Raises
    ------
    ModelError
        if motion is prescribed, so that nothing can be at rest, or a load has no value there
    """
    d = solved.derived
    given = [s for s in free_symbols([*d.z, *d.constraints.b]) if isinstance(s, Time) or input_of(s) is not None]
    if given:
        raise ModelError(
            f"Expected a system that can be at rest, got one whose motion is prescribed by {given[0]}. What holds while it moves "
            "evenly is in eom.steady_conditions({…})."
        )
    at: dict[Expr, Expr] = dict(zip(d.speeds, d.z, strict=False))  # z ends with a zero for each set of Euler parameters
    try:
        return _written(solved.Fr_nh[: len(solved.independent_speeds)], at)
    except ExpressionError as error:
        raise ModelError(
            "Expected loads that have a value at rest, got one that is divided by a speed, as sliding friction is: at rest it may be "
            "any in a range. Leave it out, eom.system.replace(loads=[…])."
        ) from error


def steady_conditions(solved: Solved, values: Mapping[Any, Any]) -> Exprs:
    """F̃_r + F̃*_r at u̇ = 0 with the `values` of some coordinates and speeds, one for each independent speed.

    Raises
    ------
    ValueMissingError
        if a value is given for something else
    """
    d, count = solved.derived, len(solved.independent_speeds)
    known: dict[str, Symbol] = {s.name: s for s in (*d.system.coordinates, *d.speeds)}
    at: dict[Expr, Expr] = {}
    given: object = values
    if not isinstance(given, Mapping):
        raise ValueMissingError(f"Expected values by symbol or name, {{u1: 2.0}}, got {cut(repr(given))}.")
    for key, value in values.items():
        name = key.name if isinstance(key, Symbol) else key
        if name not in known:
            raise ValueMissingError(
                f"Expected values of coordinates and speeds ({', '.join(known)}) in a steady motion, got one of {cut(repr(name))}."
                f"{alike(str(name), known)}"
            )
        at[known[name]] = as_expr(value)
    even: dict[Expr, Expr] = {rate(u): ZERO for u in d.speeds}
    sums = [add(f, g) for f, g in zip(solved.Fr_nh[:count], solved.Fr_star_nh[:count], strict=True)]
    return _written([substituted(e, even) for e in sums], at)


def _written(exprs: Sequence[Expr], at: Mapping[Expr, Expr]) -> Exprs:
    memo: dict[Expr, Expr] = {}
    found = [substituted(e, at, memo) for e in exprs]
    return tuple(min((e, collected(e)), key=lambda form: price([form])) for e in found)
