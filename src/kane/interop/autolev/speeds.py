# SPDX-License-Identifier: BSD-3-Clause
"""Generalized speeds as functions of rates, from kinematical equations that give rates as functions of speeds.

Of the rows rate = W u + X a maximal set that is independent at random states is solved for the speeds, short rows first. The others
become motion constraints, unless they are identities. A speed that no row determines gets an additional coordinate, its integral.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from kane.errors import KaneError, ModelError
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import solve_linear
from kane.expr.node import ZERO, Expr, constant_value
from kane.expr.symbols import Coordinate, Speed, rate
from kane.interop.autolev.model import LastForm, replacing, undefined
from kane.interop.autolev.space import RateRow, Space
from kane.interop.driven import independent_rows
from kane.numeric.sampling import SEEDS, sample


@dataclass(frozen=True, slots=True, eq=False)
class TurnedRates:
    """Definitions of speeds; speeds that vanish, as constraints; and the rates of coordinates that are further states instead."""

    speeds: dict[Speed, Expr]
    vanishing: dict[Speed, Expr]
    states: dict[Coordinate, Expr]


def kinematics(space: Space, names: LastForm, speeds: Sequence[Speed], moving: Iterable[Expr]) -> TurnedRates:
    """The inverse of the kinematical equations; `moving` are the expressions in positions and orientations of the model."""
    held = set(free_symbols(moving))
    grouped = {e for group in space.groups for e in group}
    named = [q for q in names.coordinates() if q not in grouped and rate(q) in names.kinematic]
    own = [_row(q, names, speeds) for q in named]
    placed = [(q, r) for q, r in zip(named, own, strict=True) if q in held]
    loose = [(q, r) for q, r in zip(named, own, strict=True) if q not in held]
    for q, row in placed:
        if row is None:
            raise ModelError(
                f"Expected the rate of {q} as an affine function of speeds, got {names.kinematic[rate(q)]}."
            )
    rows = [*(r for _, r in placed if r is not None), *space.rows]
    chosen = _independent(rows, speeds, space)
    states: dict[Coordinate, Expr] = {}
    for q, row in loose:
        more = None if row is None or len(chosen) == len(speeds) else _independent([*rows, row], speeds, space)
        if row is not None and more is not None and len(more) > len(chosen):
            rows, chosen = [*rows, row], more
        else:
            states[q] = names.kinematic[rate(q)]
    for u in speeds:
        if len(chosen) == len(speeds):
            break
        q = Coordinate.declare(f"{u.name}_integral", None, "", "")
        more = _independent([*rows, RateRow(rate(q), u)], speeds, space)
        if len(more) > len(chosen):
            rows, chosen = [*rows, RateRow(rate(q), u)], more
            space.sheet.remarks.say("inferred", f"{u.name} is the rate of no coordinate of the file: one is added")
    return _turned(
        [rows[k] for k in chosen], [r for k, r in enumerate(rows) if k not in set(chosen)], speeds, states, space
    )


def _row(q: Coordinate, names: LastForm, speeds: Sequence[Speed]) -> RateRow | None:
    """The kinematical equation of a coordinate, or None if it is not affine in the speeds."""
    value = names.final(names.kinematic[rate(q)])
    try:
        affine_forms([value], speeds)
    except KaneError:
        return None
    return RateRow(rate(q), value)


def _independent(rows: Sequence[RateRow], speeds: Sequence[Speed], space: Space) -> list[int]:
    """The indices of a maximal set of independent rows, with a preference for few and constant coefficients."""
    if not rows or not speeds:
        return []
    forms = [form for form, _ in affine_forms([r.value for r in rows], speeds)]
    weight = [sum(1 if constant_value(c) is not None else 10 for c in form.values()) for form in forms]
    flat = [form.get(u, ZERO) for form in forms for u in speeds]
    matrix = np.array(sample(map(undefined, flat), SEEDS[0], space.groups), dtype=float).reshape(
        len(rows), len(speeds), 1
    )
    order = sorted(range(len(rows)), key=weight.__getitem__)
    return sorted(order[k] for k in independent_rows(matrix[order]))


def _turned(
    rows: Sequence[RateRow],
    rest: Sequence[RateRow],
    speeds: Sequence[Speed],
    states: dict[Coordinate, Expr],
    space: Space,
) -> TurnedRates:
    forms = affine_forms([r.value for r in rows], speeds)
    matrix = [[form.get(u, ZERO) for u in speeds] for form, _ in forms]
    right = [r.rates - x for r, (_, x) in zip(rows, forms, strict=True)]
    definitions = dict(zip(speeds, solve_linear(matrix, right), strict=True))
    replace = replacing(definitions)
    left = {Speed.declare(f"slip_{k}", None, "", ""): r.rates - replace(r.value) for k, r in enumerate(rest, 1)}
    return TurnedRates(definitions, left, states)
