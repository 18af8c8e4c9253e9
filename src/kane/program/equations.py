# SPDX-License-Identifier: BSD-3-Clause
"""The routines of equations of motion, as Programs over t, x = (q, u), p and r."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from kane.dynamics.equations import Equations
from kane.dynamics.values import without_unknowns
from kane.errors import ArgumentError
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import time
from kane.program.build import Wanted, build_program
from kane.program.program import Port, Program
from kane.program.reciprocal import with_reciprocals
from kane.space.vector import Vector

ROUTINES = ("rhs", "mass_matrix", "forcing", "reactions")
"""What every set of equations has; "outputs" comes with the user's own expressions."""


def ports(eom: Equations) -> tuple[Port, ...]:
    """t, x (coordinates, then speeds), p (parameters), r (inputs)."""
    return (
        Port("t", (time,)),
        Port("x", (*eom.coordinates, *eom.speeds)),
        Port("p", eom.parameters),
        Port("r", eom.inputs),
    )


def program(
    eom: Equations,
    routines: Sequence[str] = ROUTINES,
    outputs: Mapping[str, Any] | None = None,
    *,
    name: str = "model",
    reciprocals: bool = True,
) -> Program:
    """The Program of the named routines, and of "outputs" where there are any.

    "rhs" gives ẋ = (q̇, u̇), "mass_matrix" M, "forcing" f of M u̇ = f with the reactions at their solved values, "reactions" those
    values. `reciprocals` lets divisions by one divisor share its reciprocal, which rounds differently.
    """
    unknown = [r for r in routines if r not in ROUTINES]
    if unknown:
        raise ArgumentError(f"Expected routines among {', '.join(ROUTINES)}, got {', '.join(map(repr, unknown))}.")
    wanted = [_routine(eom, routine) for routine in dict.fromkeys(routines)]
    if outputs:
        wanted.append(_outputs(eom, outputs))
    made = build_program(name, ports(eom), wanted)
    return with_reciprocals(made) if reciprocals else made


def expressions(eom: Equations, name: str, roots: Sequence[Expr], labels: Sequence[str]) -> Program:
    """The Program of one routine with any functions of q, u, t, parameters and inputs."""
    wanted = Wanted(name, roots, (len(roots),), labels)
    return with_reciprocals(build_program("model", ports(eom), [wanted]))


def _routine(eom: Equations, name: str) -> Wanted:
    n = len(eom.speeds)
    speeds = [f"{u.name}'" for u in eom.speeds]
    if name == "rhs":
        labels = [*(f"{q.name}'" for q in eom.coordinates), *speeds]
        return Wanted(name, eom.right_hand_side, (len(labels),), labels)
    if name == "mass_matrix":
        labels = [f"M[{i + 1},{j + 1}]" for i in range(n) for j in range(n)]
        return Wanted(name, without_unknowns(eom, [x for row in eom.mass_matrix.rows for x in row]), (n, n), labels)
    if name == "forcing":
        return Wanted(name, without_unknowns(eom, list(eom.forcing)), (n,), [f"f[{i + 1}]" for i in range(n)])
    return Wanted(name, eom.reaction_values, (len(eom.reactions),), [r.name for r in eom.reactions])


def _outputs(eom: Equations, outputs: Mapping[str, Any]) -> Wanted:
    roots: list[Expr] = []
    labels: list[str] = []
    for name, what in outputs.items():
        parts = scalars(eom, name, what)
        roots += parts
        labels += [name] if shape_of(what) == () else [f"{name}[{k}]" for k in range(len(parts))]
    return Wanted("outputs", without_unknowns(eom, roots), (len(roots),), labels)


def shape_of(what: Any) -> tuple[int, ...]:
    """The shape of an output: () of an expression, (3,) of a vector, that of a Matrix or of a sequence."""
    if isinstance(what, Vector):
        return (3,)
    if isinstance(what, Matrix):
        return what.shape
    return (len(what),) if isinstance(what, list | tuple) else ()


def scalars(eom: Equations, name: str, what: Any) -> list[Expr]:
    """The expressions of an output in row-major order; a vector's along the inertial frame."""
    if isinstance(what, Vector):
        return list(what.components(eom.system.inertial))
    if isinstance(what, Matrix):
        return [x for row in what.rows for x in row]
    try:
        return [as_expr(x) for x in what] if isinstance(what, list | tuple) else [as_expr(what)]
    except TypeError as error:
        raise ArgumentError(
            f"Expected an expression, Vector, Matrix or a sequence of expressions as output {name!r}, got {what!r:.60}."
        ) from error
