# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives at a state at which a switch stands at zero: they are those of both sides, or there are none."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kane.dynamics.readings.values import evaluate_along
from kane.dynamics.solved import Solved
from kane.errors import CornerError, cut
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, constant
from kane.expr.ops import GONE
from kane.expr.size import Sizes, size
from kane.expr.switching import Switch, on_sides, switches
from kane.expr.symbols import Parameter
from kane.expr.visit import substituted
from kane.numeric.arrays import Array
from kane.numeric.places import first_place
from kane.numeric.scale import EQUAL

State = tuple[Any, Any, Any, Any, Any, Any]
"""q, u, parameters, inputs, t, further states."""


def at_state(solved: Solved, matrix: Matrix, state: State) -> Array:
    """Numbers of derivatives of the right-hand side; a CornerError where two sides of a switch have others."""
    found = np.asarray(evaluate_along(solved, matrix, *state))
    for switch, here, sides in _standing(solved, matrix, state):
        one, other = (np.asarray(evaluate_along(solved, side, *state)) for side in sides)
        scale = np.abs(np.nan_to_num(one)).max(axis=(-2, -1), keepdims=True, initial=0)
        with np.errstate(invalid="ignore"):
            apart = (~(np.abs(one - other) <= EQUAL * scale) & ~(np.isnan(one) & np.isnan(other))).any(axis=(-2, -1))
        if (apart & here).any():
            place = f" at {first_place(apart & here)}" if apart.ndim else ""
            raise CornerError(
                f"Expected a state at which the equations have one derivative, got a corner{place}: "
                f"{cut(str(switch.nodes[0]), 80)} turns at {cut(str(switch.quantity))} = 0. Take a state beside it; "
                "kn.linearize(eom, …, side=…) takes the derivative of one side."
            )
    return found


def _standing(solved: Solved, matrix: Matrix, state: State) -> Iterator[tuple[Switch, Any, tuple[Matrix, Matrix]]]:
    """The switches that stand at zero, where they do, and the derivatives on both sides, those of the others on one and the other."""
    every = switches(solved.right_hand_side)
    if not every:
        return
    memo: Sizes = {}
    found = evaluate_along(solved, [x for s in every for x in (s.quantity, size(s.quantity, memo))], *state)
    zero = [np.abs(c) <= GONE * bound for c, bound in zip(found[::2], found[1::2], strict=True)]
    at = [(s, here) for s, here in zip(every, zero, strict=True) if np.any(here)]
    for k, (switch, here) in enumerate(at):
        for others in (1, -1):
            signs = [[sign if j == k else others for j in range(len(at))] for sign in (1, -1)]
            one, other = (_on_side(matrix, [s for s, _ in at], own) for own in signs)
            yield switch, here, (one, other)


def _on_side(matrix: Matrix, standing: Sequence[Switch], signs: Sequence[int]) -> Matrix:
    sides = {s.quantity: Parameter.declare(f"side{k}", description="of a switch") for k, s in enumerate(standing)}
    values: dict[Expr, Expr] = {x: constant(sign) for x, sign in zip(sides.values(), signs, strict=True)}
    turned: dict[Expr, Expr] = {}
    memo: dict[Expr, Expr] = {}
    return matrix.map(lambda e: substituted(on_sides(e, sides, turned), values, memo))
