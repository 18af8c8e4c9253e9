# SPDX-License-Identifier: BSD-3-Clause
"""Checks that need the derivation: speeds that move no mass, reactions along free directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kane.errors import ModelError, ReactionError
from kane.expr.diff import time_derivative
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Parameter
from kane.kinematics.motion import Kinematics
from kane.model.reactions import Cut, cut_of
from kane.model.system import System
from kane.space.frame import Frame
from kane.space.vector import Vector


def check_mass(system: System, speeds: Sequence[Expr], mass: list[list[Expr]]) -> None:
    """Every speed must move some mass."""
    still = [str(u) for u, row in zip(speeds, mass, strict=True) if all(x is ZERO for x in row)]
    if still:
        raise ModelError(
            f"Expected every generalized speed to move some mass, got a zero row of the mass matrix for {', '.join(still)}. Give the "
            "massless part a mass or inertia, or leave out its coordinate."
        )


def check_reaction_places(system: System, kinematics: Kinematics) -> None:
    """A reaction's direction must not be one in which the far side moves freely already."""
    for symbol in (*system.reactions, *system.auxiliary_speeds):
        cut = cut_of(symbol)
        if cut is None:
            continue
        free = _free_rate(cut)
        if free is not ZERO and _vanishes_nowhere(free):
            raise ReactionError(
                f"Expected the reaction {symbol} along a direction in which the far side is held, got {cut.along} at "
                f"{cut.at.name}, along which it moves freely with {free}. Choose a direction across the motion."
            )


def _free_rate(cut: Cut) -> Expr:
    """Rate of the far side relative to the near side along the reaction."""
    if isinstance(cut.at, Frame):
        o, frame = cut.at.orientation, cut.at
        assert o is not None
        relative = frame.angular_velocity(frame.parent) if frame.parent is not None else Vector()
        return relative.dot(cut.along)
    slide = Vector()
    for f, (x, y, z) in cut.at.offset.parts:
        slide = slide + Vector(((f, (time_derivative(x), time_derivative(y), time_derivative(z))),))
    return slide.dot(cut.along)


def _vanishes_nowhere(e: Expr) -> bool:
    """Whether `e` differs from zero at a random point."""
    generator = np.random.default_rng(20042)
    numbers = {
        s: generator.uniform(0.3, 1.2)
        for s in free_symbols([e])
        if not (isinstance(s, Parameter) and s.default is not None)
    }
    return bool(abs(float(evaluate(e, numbers))) > 1e-12)
