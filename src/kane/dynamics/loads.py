# SPDX-License-Identifier: BSD-3-Clause
"""Loads with their rates written in generalized speeds."""

from __future__ import annotations

from collections.abc import Sequence

from kane.expr.evaluate import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import QuasiRate, Rate
from kane.kinematics.speeds import Row, Speeds
from kane.model.loads import Load


def loads_in_speeds(loads: Sequence[Load], speeds: Speeds) -> tuple[Load, ...]:
    """The loads with every rate written in speeds."""
    memo: dict[Expr, tuple[Row | None, Expr]] = {}

    def convert(e: Expr) -> Expr:
        return speeds.in_speeds(e, memo)

    if not any(_has_rates(x) for load in loads for x in _scalars(load)):
        return tuple(loads)
    return tuple(
        Load(
            load.name,
            tuple((p, v.map(convert)) for p, v in load.forces),
            tuple((f, v.map(convert)) for f, v in load.torques),
            load.potential,
        )
        for load in loads
    )


def _scalars(load: Load) -> list[Expr]:
    return [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]


def _has_rates(e: Expr) -> bool:
    return any(isinstance(s, Rate | QuasiRate) for s in free_symbols([e]))
