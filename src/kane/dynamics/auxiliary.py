# SPDX-License-Identifier: BSD-3-Clause
"""Auxiliary speeds: one for each reaction that is brought into evidence."""

from __future__ import annotations

from kane.expr.node import ONE, Expr
from kane.expr.symbols import AuxiliarySpeed
from kane.model.reactions import Cut, constraint_of, cut_of
from kane.model.system import System

Pairs = dict[tuple[Expr, Expr], Expr]


def auxiliary_speeds(system: System) -> tuple[tuple[AuxiliarySpeed, ...], Pairs]:
    """Auxiliary speeds, one a reaction, and what the action–reaction pairs put into their equations: n_a·n_b at one cut."""
    explicit = iter(system.auxiliary_speeds)
    speeds: list[AuxiliarySpeed] = []
    for r in system.reactions:
        place = cut_of(r) or constraint_of(r)
        if place is None:
            speeds.append(next(explicit))
        else:
            speeds.append(AuxiliarySpeed.declare(f"u_{r.name}", None, "", f"auxiliary speed of {r.name}", place))
    pairs: Pairs = {}
    for a in speeds:
        for r in system.reactions:
            here, there = cut_of(a), cut_of(r)
            if constraint_of(a) is not None and constraint_of(a) is constraint_of(r):
                pairs[a, r] = ONE
            if isinstance(here, Cut) and isinstance(there, Cut) and here.at is there.at:
                pairs[a, r] = here.along.dot(there.along)
    return tuple(speeds), pairs
