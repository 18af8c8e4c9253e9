# SPDX-License-Identifier: BSD-3-Clause
"""Numbers at a state: rates, accelerations and reactions replaced by what the equations say of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kane.dynamics.constraints.singular import check_pivots
from kane.errors import ValueMissingError
from kane.expr.evaluate import evaluate, free_symbols, stacked
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.substitute import substitute
from kane.expr.symbols import AuxiliarySpeed, Coordinate, QuasiRate, Rate, Reaction, Speed, input_of, rate, time
from kane.numeric.named import finite_number, named_values

if TYPE_CHECKING:
    from kane.equations.equations import Equations


def without_rates(eom: Equations, root: Expr) -> Expr:
    """`root` with q̇ written in speeds and q̈ in u̇."""
    second: dict[Expr, Expr] = {
        s: eom.time_derivative(s.place)
        for s in free_symbols([root])
        if isinstance(s, Rate)
        and (
            isinstance(s.place, QuasiRate)
            or (isinstance(s.place, Rate) and not isinstance(s.place.place, Speed) and input_of(s) is None)
        )
    }
    if second:
        root = substitute(root, second)
    return eom.kinematical.in_speeds(root, {})


def without_unknowns(eom: Equations, roots: Sequence[Expr]) -> list[Expr]:
    """Functions of q, u, t, parameters and inputs: u̇ and reactions replaced by their solved values, auxiliary speeds by 0."""
    plain = [without_rates(eom, e) for e in roots]
    solved: dict[Expr, Expr] = {rate(u): a for u, a in zip(eom.speeds, eom.accelerations, strict=True)}
    solved.update(zip(eom.reactions, eom.reaction_values, strict=True))
    solved.update(dict.fromkeys(eom.auxiliary_speeds, ZERO))
    if not any(isinstance(s, Rate | Reaction | AuxiliarySpeed) for s in free_symbols(plain)):
        return plain
    memo: dict[Expr, Expr] = {}
    return [substitute(e, solved, memo) for e in plain]


def speeds_from_rates(
    eom: Equations, q: Any, rates: Any, parameters: Mapping[Any, Any] | None, t: Any
) -> dict[Speed, Any]:
    """See Equations.speeds_from_rates."""
    given = named_values("rates, by coordinate,", eom.coordinates, rates)
    missing = [c.name for c in eom.coordinates if c not in given]
    if missing:
        raise ValueMissingError(f"Expected a rate for every coordinate, got none for {', '.join(missing)}.")
    values: dict[Expr, Any] = {time: t}
    values.update({rate(c): v for c, v in given.items() if isinstance(c, Coordinate)})
    values.update(named_values("coordinates", eom.coordinates, q))
    values.update(named_values("parameters", eom.parameters, parameters))
    q_dot = [rate(c) for c in eom.coordinates]
    rows = zip(eom.speeds, eom.Y.rows, eom.z, strict=False)
    found = evaluate([dot(row, q_dot) + z for _, row, z in rows], values)
    return dict(zip(eom.speeds, found, strict=True))


def evaluate_along(
    eom: Equations,
    exprs: Any,
    q: Any,
    u: Any,
    parameters: Mapping[Any, Any] | None,
    inputs: Mapping[Any, Any] | None,
    t: Any,
) -> Any:
    """See Equations.evaluate."""
    shape = exprs.shape if isinstance(exprs, Matrix) else None
    single = isinstance(exprs, Expr | int | float)
    given = [x for row in exprs.rows for x in row] if shape is not None else [exprs] if single else exprs
    wanted = without_unknowns(eom, [as_expr(e) for e in given])
    values: dict[Expr, Any] = {time: t}
    values.update(named_values("coordinates", eom.coordinates, q))
    values.update(named_values("speeds", eom.speeds, u))
    values.update(named_values("parameters", eom.parameters, parameters))
    values.update(named_values("inputs", eom.inputs, inputs))
    found = check_pivots(eom, wanted, values, evaluate(wanted, values))
    if shape is not None:
        return stacked(found, shape)
    return found[0] if single else found


def parameter_values(eom: Equations, parameters: Mapping[Any, Any] | None) -> dict[Expr, float]:
    """A number for every parameter of the system; a missing one is named."""
    values = named_values("parameters", eom.parameters, parameters)
    for p in eom.parameters:
        if p not in values and p.default is not None:
            values[p] = p.default
    missing = [p.name for p in eom.parameters if p not in values]
    if missing:
        raise ValueMissingError(
            f"Expected a value for every parameter, got none for {', '.join(missing)}: pass parameters={{…}} or declare a "
            "default, kn.parameter(name, default)."
        )
    return {p: finite_number("value", str(p), v) for p, v in values.items()}
