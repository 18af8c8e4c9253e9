# SPDX-License-Identifier: BSD-3-Clause
"""Numbers on the configuration constraints: f(q, t) = 0 and eᵀe = 1, closed by Gauss–Newton steps of least size."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kane.expr.build import sub
from kane.expr.diff import jacobian
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, Expr
from kane.model.system import System
from kane.numeric.newton import Residual
from kane.program.bundle import Bundle

OFF = 1e-6
"""Residual, over the reach of the coordinates, above which no configuration was found."""


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """What a configuration must satisfy: names, f and ∂f/∂q in the order of the coordinates."""

    names: tuple[str, ...]
    f: tuple[Expr, ...]
    gradient: Matrix


def closure(system: System) -> Closure:
    """The configuration constraints of a system, those of its Euler parameters last."""
    f = [c.expr for c in system.holonomic]
    names = [c.name for c in system.holonomic]
    for s in system.euler_parameters:
        f.append(sub(dot(s.coordinates, s.coordinates), ONE))
        names.append(f"unit length of ({', '.join(e.name for e in s.coordinates)})")
    return Closure(
        tuple(names), tuple(f), jacobian(f, system.coordinates) if f else Matrix([], (0, len(system.coordinates)))
    )


def residual_function(system: System, conditions: Closure, values: Mapping[Expr, Any]) -> Residual:
    """f and ∂f/∂q as a function of the coordinates, all other symbols at `values`, on the reference evaluator."""
    bundle = Bundle("closure", (), lambda *parts: parts, {"f": conditions.f, "gradient": conditions.gradient})
    run = bundle.reference([*system.coordinates, *values])
    numbers = list(values.values())
    return lambda q: run([*q, *numbers])
